"""What an analysis found, and what is to be told of it: one way for every static analysis, check and study."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Generic, TypeVar

from assessment.results.schema.model import QualityRow
from mechanics.messages import Message

if TYPE_CHECKING:
    from collections.abc import Iterable
    from typing import Any

Value = TypeVar("Value")


@dataclass
class Found(Generic[Value]):
    """The `value` that an analysis found; None: nothing, and the `failures` say why.

    `warnings`: what to know about the value; `quality`: certificates of the programs that were solved; `seconds`:
    computing time; `scatters`: whether the value turns on the last digits of the input, so that runs have a range.
    """

    value: Value | None = None
    warnings: list[Message] = field(default_factory=list)
    failures: list[Message] = field(default_factory=list)
    quality: list[QualityRow] = field(default_factory=list)
    seconds: float = 0.0
    scatters: bool = False

    def take(self, others: Iterable[Found[Any]]) -> None:
        """Add what is to be told of other analyses, with their certificates and times."""
        for each in others:
            self.warnings += each.warnings
            self.failures += each.failures
            self.quality += each.quality
            self.seconds += each.seconds
            self.scatters |= each.scatters
