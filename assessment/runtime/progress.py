"""How far a run is: the events that tell of it, the stages that follow from them, and bars on the terminal."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, get_args

if TYPE_CHECKING:
    from rich.console import Console

LATE = "longer than expected"  # what is left once the time that was expected is over
OVER = 1.0  # s: since when
Event = Literal["begin", "under_way", "reached", "done", "fault", "end"]


class Show:
    """Receives the progress of the analyses as events, each with its fields; this one ignores them.

    `begin` (stage, total, taken, work): of `total` analyses all but `taken` are to be computed, `work` in all;
    `under_way` (title): one is being computed, of several the one that has been for longest; `reached` (work): so much
    is done, analyses at work included; `done` (work): the same, and one more is finished; `fault` (title, reasons):
    one, computed or taken over, could not be completed; `end`: of the stage. `interval` (s): between two of `reached`.
    """

    interval = 0.25

    def tell(self, event: Event, **fields: Any) -> None:
        """Receive an event."""


SILENCE = Show()


@dataclass
class Stage:
    """A stage as its events tell; times in s of one clock.

    `work`: of all its analyses, `reached` until `latest`, those at work with their share, in a unit of its own;
    `under_way`: the analysis that it is at `since` then; `faults`: title and reasons of those not completed.
    """

    name: str
    total: int
    taken: int
    work: float
    began: float
    done: int = 0
    reached: float = 0.0
    latest: float = 0.0
    ended: bool = False
    under_way: str | None = None
    since: float = 0.0
    faults: list[tuple[str, list[str]]] = field(default_factory=list)

    @property
    def open(self) -> int:
        """Analyses that are not finished."""
        return self.total - self.taken - self.done

    def doing(self, now: float) -> str:
        """Return the stage and the analysis that it is at, as a text."""
        return f"{self.name}: {clock(now - self.since)} on {self.under_way}" if self.under_way else self.name

    def left(self, now: float) -> float | None:
        """Return the time that the stage still takes, negative where it is late; None where nothing is done yet."""
        if self.reached <= 0.0:
            return None
        rest = (self.latest - self.began) / self.reached * max(self.work - self.reached, 0.0)
        return self.latest + rest - now if math.isfinite(rest) else None

    def time_left(self, now: float, unknown: str) -> str:
        """Return the same as a text, that it is late, or that this is `unknown`."""
        left = self.left(now)
        return unknown if left is None else LATE if left < -OVER else clock(left)


def heard(stages: list[Stage], now: float, event: str, /, **fields: Any) -> Stage:
    """Add an event to the last of the stages and return that. One that is no event raises and changes nothing."""
    work = float(fields["work"]) if event in {"begin", "reached", "done"} else 0.0
    if not math.isfinite(now) or not math.isfinite(work) or event not in get_args(Event):
        raise ValueError(f"{event}: time: {now}, work: {work}")
    if event == "begin":
        stages.append(Stage(str(fields["stage"]), int(fields["total"]), int(fields["taken"]), work, now))
    stage = stages[-1]
    if event in {"reached", "done"}:
        stage.reached, stage.latest = work, now
        stage.done += event == "done"
    elif event == "under_way":
        stage.under_way, stage.since = str(fields["title"]), now
    elif event == "fault":
        stage.faults.append((str(fields["title"]), [str(reason) for reason in fields["reasons"]]))
    elif event == "end":
        stage.ended, stage.under_way = True, None
    return stage


def clock(seconds: float) -> str:
    """Return a time as h:mm:ss."""
    whole = max(0, round(seconds))
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}"


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
            TextColumn("{task.description}", markup=False, table_column=rest), BarColumn(bar_width=10),
            TextColumn("{task.fields[count]}", markup=False), TimeElapsedColumn(),
            TextColumn("left {task.fields[left]}", markup=False),
        )  # fmt: skip
        self.progress = Progress(*columns, console=console, transient=True, expand=True)
        self.stages: list[Stage] = []

    def tell(self, event: Event, **fields: Any) -> None:
        """Draw an event."""
        stage, lines = heard(self.stages, time.perf_counter(), event, **fields), list[str]()
        count = f"{stage.taken + stage.done}/{stage.total}"
        if event == "begin":
            left = _Now(lambda: stage.time_left(time.perf_counter(), "-:--:--"))
            doing: Any = _Now(lambda: stage.doing(time.perf_counter()))
            self.task = self.progress.add_task(doing, total=stage.work, count=count, left=left)
        elif event == "fault":
            lines = [f"✗ {fields['title']}: {reason}" for reason in fields["reasons"]]
        elif event == "end":
            self.progress.remove_task(self.task)
            kept = f", {stage.taken} taken over, inputs unchanged" if stage.taken else ""
            lines = [f"· {stage.name}: {stage.total}{kept}, {time.perf_counter() - stage.began:.1f} s"]
        elif event in {"reached", "done"}:
            self.progress.update(self.task, completed=stage.reached, count=count)
        for line in lines:
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
