"""What the progress of a run is told to: the terminal, a journal, or nobody."""

from __future__ import annotations

from collections.abc import Sequence


class Show:
    """Receives the progress of the analyses; this one ignores it."""

    def begin(self, stage: str, total: int, taken: int, work: float) -> None:
        """Tell that of `total` analyses of a stage all but `taken` are to be computed, `work` in all."""

    def under_way(self, title: str) -> None:
        """Tell which analysis is being computed."""

    def reached(self, done: float) -> None:
        """Tell how much of the work is done, of analyses at work too."""

    def advance(self, done: float) -> None:
        """Tell that one more analysis of the stage is finished, and how much of the work is done."""

    def fault(self, title: str, reasons: Sequence[str]) -> None:
        """Tell why an analysis, computed or taken over, could not be completed."""

    def end(self) -> None:
        """Tell that the stage is finished."""


SILENCE = Show()
