"""Receivers of the progress of a run: the terminal, a journal, or none."""

from __future__ import annotations

from collections.abc import Sequence


class Show:
    """Receives the progress of the analyses; this one ignores it.

    `interval` (s): between two reports of how far an analysis at work is.
    """

    interval = 0.25

    def begin(self, stage: str, total: int, taken: int, work: float) -> None:
        """A stage begins: of `total` analyses all but `taken` are to be computed, `work` in all."""

    def under_way(self, title: str) -> None:
        """An analysis is being computed; of several the one that has been for longest."""

    def reached(self, done: float) -> None:
        """So much of the work is done, analyses at work included."""

    def advance(self, done: float) -> None:
        """One more analysis of the stage is finished; so much of the work is done."""

    def fault(self, title: str, reasons: Sequence[str]) -> None:
        """An analysis, computed or taken over, could not be completed, for these reasons."""

    def end(self) -> None:
        """The stage is finished."""


SILENCE = Show()
