"""The outcome of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from assessment.results.schema import Results


@dataclass(frozen=True)
class Outcome:
    """The outcome of a run: its results, whether every requested analysis was completed, and how many were computed.

    `computed`: number of analyses of this run; `taken`: number of stored results of earlier runs that were used, as
    their inputs have not changed.
    """

    results: Results
    complete: bool
    computed: int
    taken: int
