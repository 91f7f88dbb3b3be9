"""How far a run is: what receives its progress, the pace of a stage, and bars on the terminal."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

LATE = "longer than expected"  # what is left once the time that was expected is over
OVER = 1.0  # s: since when


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


@dataclass
class Pace:
    """Work `done` until the time `latest`, of all the `work` of a stage that began at `began`; times in s of one clock.

    The unit of work is that of the stage: analyses, or samples of records; analyses at work count with their share.
    """

    work: float
    began: float
    done: float = 0.0
    latest: float = 0.0

    def reached(self, done: float, now: float) -> None:
        """Record the work done until `now`."""
        self.done, self.latest = done, now

    def left(self, now: float) -> float | None:
        """Return the time that the stage still takes, negative where it is late; None where nothing is done yet."""
        if self.done <= 0.0:
            return None
        rest = (self.latest - self.began) / self.done * max(self.work - self.done, 0.0)
        return self.latest + rest - now if math.isfinite(rest) else None


def clock(seconds: float) -> str:
    """Return a time as h:mm:ss."""
    whole = max(0, round(seconds))
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}"


def time_left(pace: Pace, now: float, unknown: str) -> str:
    """Return the time that a stage still takes as a text, that it is late, or that this is `unknown`."""
    left = pace.left(now)
    return unknown if left is None else LATE if left < -OVER else clock(left)


@dataclass(frozen=True)
class _Now:
    """A text that is made anew whenever the bar is drawn."""

    text: Callable[[], str]

    def __str__(self) -> str:
        return self.text()


class Bars(Show):
    """A progress bar for the work of the current stage with the time left, and a line for each finished stage."""

    def __init__(self, console: Console) -> None:
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
        from rich.table import Column

        # on a narrow terminal titles are cut, not times
        rest = Column(ratio=1, no_wrap=True, overflow="ellipsis")
        columns = (
            TextColumn("{task.description}", markup=False, table_column=rest),
            BarColumn(bar_width=10),
            TextColumn("{task.fields[count]}", markup=False),
            TimeElapsedColumn(),
            TextColumn("left {task.fields[left]}", markup=False),
        )
        self.progress = Progress(*columns, console=console, transient=True, expand=True)

    def begin(self, stage: str, total: int, taken: int, work: float) -> None:
        """See Show."""
        now = time.perf_counter()
        self.stage, self.total, self.taken, self.finished = stage, total, taken, taken
        self.pace, self.title, self.since = Pace(work, now), "", now
        doing, left = _Now(self._doing), _Now(lambda: time_left(self.pace, time.perf_counter(), "-:--:--"))
        count = f"{taken}/{total}"
        self.task = self.progress.add_task(doing, total=work, count=count, left=left)  # type: ignore[arg-type]

    def _doing(self) -> str:
        elapsed = clock(time.perf_counter() - self.since)
        return f"{self.stage}: {elapsed} on {self.title}" if self.title else self.stage

    def under_way(self, title: str) -> None:
        """See Show."""
        self.title, self.since = title, time.perf_counter()

    def reached(self, done: float) -> None:
        """See Show."""
        self.pace.reached(done, time.perf_counter())
        self.progress.update(self.task, completed=done, count=f"{self.finished}/{self.total}")

    def advance(self, done: float) -> None:
        """See Show."""
        self.finished += 1
        self.reached(done)

    def fault(self, title: str, reasons: Sequence[str]) -> None:
        """See Show."""
        for reason in reasons:
            self._print(f"✗ {title}: {reason}")

    def end(self) -> None:
        """See Show."""
        self.progress.remove_task(self.task)
        kept = f", {self.taken} taken over, inputs unchanged" if self.taken else ""
        seconds = time.perf_counter() - self.pace.began
        self._print(f"· {self.stage}: {self.total}{kept}, {seconds:.1f} s")

    def _print(self, line: str) -> None:
        self.progress.console.print(line, highlight=False, markup=False)


@contextmanager
def progress() -> Iterator[Show]:
    """Yield a Show that prints progress to standard error; silent if that is not a terminal."""
    if not sys.stderr.isatty():
        yield SILENCE
        return
    from rich.console import Console

    bars = Bars(Console(stderr=True))
    with bars.progress:
        yield bars
