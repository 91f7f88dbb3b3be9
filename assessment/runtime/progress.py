"""How far a run is: its events, as bars on the terminal and in the journal of its output folder, which it locks.

`assesto status` and the app read the journal.
"""

from __future__ import annotations

import json
import math
import os
import platform
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from assessment.runtime.errors import WRONG_INPUT, ProjectError

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


LOCK = ".assesto.lock"  # in the output folder, while a run writes there
PATIENCE = 0.2  # s: `holder` takes the lock for an instant, to see whether it is free


@dataclass(frozen=True)
class Holder:
    """The process that writes into a folder: as a sentence names it, and its number; None where it is not known."""

    text: str
    pid: int | None


class BusyError(ProjectError):
    """Another run writes into the folder; the message names its lock and its process."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Keep other runs out of a folder, which is made, and removed if it stays empty. Raises BusyError, OSError."""
    from filelock import FileLock, Timeout  # late: most commands need none

    made, path = not folder.exists(), folder / LOCK
    folder.mkdir(parents=True, exist_ok=True)
    lock = FileLock(path, timeout=PATIENCE)
    try:
        lock.acquire()
    except Timeout:
        raise BusyError(
            f"{path}: another run is writing into this folder ({_read(path).text}); wait until it has ended, stop it, "
            "or give another folder with --out DIR"
        ) from None
    try:
        host, now = platform.node(), time.strftime("%H:%M")
        facts = json.dumps({"pid": os.getpid(), "host": host, "since": time.time()})
        with suppress(OSError):  # Windows keeps a locked file to itself, also from this
            path.write_text(f"process {os.getpid()} on {host} since {now}\n{facts}\n", encoding="utf-8")
        yield
    finally:
        with suppress(OSError):  # before it is released: who waits for the removed file opens a new one
            path.unlink()
        lock.release()
        with suppress(OSError):  # Windows does not remove an open file
            path.unlink()
        if made:
            with suppress(OSError):  # not empty
                folder.rmdir()


def holder(folder: Path) -> Holder | None:
    """Return the process that writes into a folder; None if there is none."""
    path = folder / LOCK
    if not path.is_file():
        return None
    from filelock import FileLock, Timeout  # late: as above

    try:
        with FileLock(path, timeout=0):
            return None
    except Timeout:
        return _read(path)
    except OSError:
        return None


def _read(path: Path) -> Holder:
    """Return who holds a lock, as far as its file says."""
    with suppress(OSError, ValueError, TypeError, KeyError, RecursionError):
        text, _, facts = path.read_text(encoding="utf-8").partition("\n")
        return Holder(text, int(json.loads(facts)["pid"]))
    return Holder("a process which has just begun", None)


MOST_BYTES = 100_000_000  # that are read: half a million analyses
SELDOM = 0.01  # of the time of a stage: how often it is written what is reached, 1 s at least
NOTHING = "nothing has been run in"
NAME = ".assesto.journal"  # in the output folder: of the last run that computed or wrote something there


def record_exit(folder: Path, code: int) -> None:
    """Append the exit code of a run to the journal of its folder, where that does not end with it already."""
    if folder.is_dir() and read_journal(folder).exit_code != code:
        _append(folder / NAME, event="result", code=code)


class Journal(Show):
    """Writes events as lines of JSON, titles once a second and work reached at SELDOM, and passes them to `show`.

    It takes the place of the journal of an earlier run in the folder.
    """

    def __init__(self, folder: Path, show: Show) -> None:
        self.path, self.show = folder / NAME, show
        self.began = self.latest = self.named = 0.0  # times of the stage, the last line, the last title
        self.title: str | None = None  # of the analysis under way, not written yet
        self.path.unlink(missing_ok=True)

    def tell(self, event: Event, **fields: Any) -> None:
        """Write an event, and pass it on."""
        now = time.time()
        if event == "begin":
            self.began, self.named, self.title = now, 0.0, None
        elif event == "under_way":
            self.title = fields["title"]
        if event not in {"under_way", "reached"}:
            self.latest = _append(self.path, event=event, **fields)
        elif self.title is not None and now - self.named >= 1.0:
            self.latest = self.named = _append(self.path, event="under_way", title=self.title)
            self.title = None
        if event == "reached" and now - self.latest >= max(1.0, SELDOM * (now - self.began)):
            self.latest = _append(self.path, event=event, **fields)
        self.show.tell(event, **fields)


def _append(path: Path, **event: Any) -> float:
    """Append a line and return its time; if it cannot be written, the run goes on without it."""
    now = time.time()
    with suppress(OSError):
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
        try:
            os.write(descriptor, (json.dumps({"time": now} | event) + "\n").encode())
        finally:
            os.close(descriptor)
    return now


@dataclass
class RunRecord:
    """What a journal holds: the stages of the last run that began any, and the exit code of the last that ended."""

    stages: list[Stage] = field(default_factory=list)
    exit_code: int | None = None


def read_journal(folder: Path) -> RunRecord:
    """Return what the journal in a folder holds; a line that a kill cut short, or that is no event, is left out."""
    recorded = RunRecord()
    try:
        with (folder / NAME).open("rb") as file:
            lines = file.read(MOST_BYTES).decode(errors="replace").splitlines()
    except OSError:
        return recorded
    for line in lines:
        with suppress(ValueError, TypeError, KeyError, IndexError, OverflowError, RecursionError):
            event = json.loads(line)
            if event["event"] == "result":
                recorded.exit_code = int(event["code"])
            else:
                heard(recorded.stages, float(event["time"]), event["event"], **event)
    return recorded


def status(folder: Path) -> str:
    """Return the stages of the last run in a folder: done, failed with reasons, in flight, time left."""
    recorded, running = read_journal(folder), holder(folder)
    if not running and not recorded.stages and recorded.exit_code is None:
        stored = folder / "results.json"
        return f"results of an earlier run: {stored}" if stored.is_file() else f"{NOTHING} {folder}"
    if running:
        lines = [f"at work: {running.text}"]
    elif recorded.exit_code is None or any(not stage.ended for stage in recorded.stages):
        lines = ["not at work: the run was interrupted or killed"]
    else:
        code = f", exit code {recorded.exit_code}" if recorded.exit_code else ""
        lines = [f"finished: {folder}{code}"]
    for stage in recorded.stages:
        lines.append(_line(stage, running is not None))
        lines += [f"  failed: {title}: {reason}" for title, reasons in stage.faults for reason in reasons]
    if not running and recorded.exit_code == WRONG_INPUT:
        lines.append("the run was refused: correct the input that it names, and run again")
    elif not running and recorded.exit_code != 0:
        lines.append("finished analyses are kept: run again to go on")
    return "\n".join(lines)


def status_json(folder: Path) -> str:
    """Return the same as one JSON object, the keys as docs/howto/run.md has them."""
    return json.dumps(progress_of(read_journal(folder), holder(folder)), indent=2)


def progress_of(recorded: RunRecord, running: Holder | None) -> dict[str, Any]:
    """Return where a run is as plain values: its last stage, the faults of all, and every stage by itself."""
    stage = recorded.stages[-1] if recorded.stages else None
    at_work = running is not None and stage is not None and not stage.ended
    left = stage.left(time.time()) if stage and at_work else None
    return {
        "running": running is not None,
        "pid": running.pid if running else None,
        "exit_code": None if running else recorded.exit_code,
        "stage": stage.name if stage else None,
        "done": stage.taken + stage.done if stage else 0,
        "total": stage.total if stage else 0,
        "failed": sum(len(each.faults) for each in recorded.stages),
        "under_way": stage.under_way if stage and at_work else None,
        "seconds_left": None if left is None else max(0.0, left),
        "stages": [
            {
                "stage": each.name, "done": each.taken + each.done, "taken_over": each.taken,
                "total": each.total, "ended": each.ended,
                "failures": [{"title": title, "reasons": reasons} for title, reasons in each.faults],
            }
            for each in recorded.stages
        ],
    }  # fmt: skip


def _line(stage: Stage, running: bool) -> str:
    text = f"{stage.name}: {stage.taken + stage.done} of {stage.total} done"
    if stage.taken:
        text += f" ({stage.taken} taken over)"
    if stage.faults:
        text += f", {len(stage.faults)} failed"
    if stage.ended or not running:
        return text
    now = time.time()
    gone, left = clock(now - stage.began), stage.time_left(now, "not known yet")
    text += f", {stage.open} in flight or waiting; {gone} gone, left: {left}"
    return f"{text}; at {stage.under_way}" if stage.under_way else text
