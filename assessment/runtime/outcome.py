"""The outcome of a run."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from assessment.results.schema import Results


@dataclass(frozen=True)
class Outcome:
    """The outcome of a run: its results, whether every analysis asked for was completed, and how many were computed.

    `results`: in plain numbers, as results.json has them; `computed`: number of analyses of this run; `taken`:
    number of stored results of earlier runs that were used, as their inputs have not changed.
    """

    results: dict[str, Any]
    complete: bool
    computed: int
    taken: int

    @cached_property
    def typed(self) -> Results:
        """The typed results, validated against their schema at first use; `results` must not change afterwards."""
        from assessment.results.file import typed  # late: see workflow/run.py

        return typed(self.results)
