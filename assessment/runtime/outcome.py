"""What a run came to."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from assessment.results.schema import Results


@dataclass(frozen=True)
class Outcome:
    """What a run came to: its results, whether every analysis asked for was completed, and how they were come by.

    `results`: in plain numbers, as results.json has them; `computed`: analyses of this run; `taken`: those of earlier
    ones whose inputs have not changed.
    """

    results: dict[str, Any]
    complete: bool
    computed: int
    taken: int

    @cached_property
    def typed(self) -> Results:
        """The results by type, held against their schema when they are first asked for: they change no more."""
        from assessment.results.file import typed  # late: see workflow/run.py

        return typed(self.results)
