"""Progress in the terminal: a bar for the current stage with the time left."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from assessment.runtime.pace import Pace
from assessment.runtime.show import Show

if TYPE_CHECKING:
    from rich.console import Console


LATE = "longer than expected"  # what is left once the time that was expected is over
OVER = 1.0  # s: since when


@dataclass(frozen=True)
class TimeLeft:
    """Time left until a moment (s, of the performance counter), written as h:mm:ss of now; None: not known.

    After that moment the text is LATE instead of a time of zero.
    """

    until: float | None = None

    def __str__(self) -> str:
        if self.until is None:
            return "-:--:--"
        left = self.until - time.perf_counter()
        return LATE if left < -OVER else clock(left)


@dataclass(frozen=True)
class AtWork:
    """What a stage is at and since when (s, of the performance counter), written with the time gone since."""

    stage: str
    title: str
    since: float

    def __str__(self) -> str:
        return f"{self.stage}: {clock(time.perf_counter() - self.since)} on {self.title}"


def clock(seconds: float) -> str:
    """Return a time as h:mm:ss."""
    whole = max(0, round(seconds))
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}"


class Bars(Show):
    """A progress bar for the work of the current stage with the time left, and a line for each finished stage."""

    def __init__(self, console: Console) -> None:
        from rich.progress import (
            BarColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
        )
        from rich.table import Column

        # on a narrow terminal titles are cut, not times
        rest = Column(ratio=1, no_wrap=True, overflow="ellipsis")
        columns = (
            TextColumn("{task.description}", markup=False, table_column=rest),
            BarColumn(bar_width=10),
            TextColumn("{task.fields[count]}", markup=False),
            TimeElapsedColumn(),
            TextColumn("left"),
            TextColumn("{task.fields[left]}", markup=False),
        )
        self.progress = Progress(*columns, console=console, transient=True, expand=True)

    def begin(self, stage: str, total: int, taken: int, work: float) -> None:
        """See Show."""
        self.stage, self.total, self.taken, self.finished = stage, total, taken, taken
        self.pace = Pace(work, time.perf_counter())
        self.task = self.progress.add_task(stage, total=work, count=f"{taken}/{total}", left=TimeLeft())

    def under_way(self, title: str) -> None:
        """See Show."""
        at_work: Any = AtWork(self.stage, title, time.perf_counter())  # written anew whenever the bar is
        self.progress.update(self.task, description=at_work)

    def reached(self, done: float) -> None:
        """See Show."""
        self.pace.reached(done, time.perf_counter())
        count = f"{self.finished}/{self.total}"
        self.progress.update(self.task, completed=done, count=count, left=TimeLeft(self.pace.ends))

    def advance(self, done: float) -> None:
        """See Show."""
        self.finished += 1
        self.reached(done)

    def fault(self, title: str, reasons: Sequence[str]) -> None:
        """See Show."""
        for reason in reasons:
            self.progress.console.print(f"✗ {title}: {reason}", highlight=False, markup=False)

    def end(self) -> None:
        """See Show."""
        self.progress.remove_task(self.task)
        kept = f", {self.taken} taken over, inputs unchanged" if self.taken else ""
        seconds = time.perf_counter() - self.pace.began
        self.progress.console.print(
            f"· {self.stage}: {self.total}{kept}, {seconds:.1f} s", highlight=False, markup=False
        )


@contextmanager
def progress() -> Iterator[Show]:
    """Yield a Show that prints progress to standard error; silent if that is not a terminal."""
    if not sys.stderr.isatty():
        from assessment.runtime.show import SILENCE

        yield SILENCE
        return
    from rich.console import Console

    bars = Bars(Console(stderr=True))
    with bars.progress:
        yield bars
