"""How far a run is: events, as bars and in the journal of its output folder, which it locks; status and app read it."""

from __future__ import annotations

import json
import math
import os
import platform
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assessment.runtime.errors import WRONG_INPUT, ProjectError
from assessment.runtime.files import write_atomically

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress

LATE = "longer than expected"  # what is left once the time that was expected is over
OVER = 1.0  # s: since when


@dataclass
class Stage:
    """How far a stage is, of whose `total` analyses all but `taken` are to be computed; times in s, of time.time()."""

    name: str
    total: int
    taken: int
    work: float  # of these analyses, in a unit of its own
    began: float = field(default_factory=time.time)
    done: int = 0
    reached: float = 0.0  # until `latest`, analyses at work with their share
    latest: float = 0.0
    ended: bool = False
    under_way: str | None = None  # the analysis that it is at `since` then, of several for longest
    since: float = 0.0
    # title and reasons of analyses, computed or taken over, that could not be completed
    faults: list[tuple[str, list[str]]] = field(default_factory=list)

    def reach(self, work: float, finished: int = 0) -> None:
        """Have so much work done, and so many more analyses."""
        self.done += finished
        if work > self.reached:
            self.reached, self.latest = work, time.time()

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


MOST_BYTES = 100_000_000  # that are read
NOTHING = "nothing has been run in"
NAME = ".assesto.journal"  # in the output folder: of the last run that computed or wrote something there


@dataclass
class RunRecord:
    """The stages of the last run that began any, and the exit code of the last that ended."""

    stages: list[Stage] = field(default_factory=list)
    exit_code: int | None = None


class Show:
    """Shows how far the stages of a run are: as bars on a console, and in the journal of a folder, where it has them.

    `every` (s): between two writes to the journal, beside those where a stage begins or ends.
    """

    def __init__(self, console: Console | None = None, every: float = 1.0) -> None:
        self.bars = _bars(console) if console else None
        self.folder: Path | None = None
        self.record, self.every, self.latest = RunRecord(), every, 0.0

    def keep_in(self, folder: Path) -> None:
        """Write the journal of a folder from now on, in the place of that of an earlier run."""
        self.folder = folder
        (folder / NAME).unlink(missing_ok=True)

    def begin(self, stage: Stage) -> None:
        """Show a stage that begins: its texts are made anew whenever the bar is drawn."""
        self.record.stages.append(stage)
        if self.bars:
            count = _Now(lambda: f"{stage.taken + stage.done}/{stage.total}")
            left = _Now(lambda: stage.time_left(time.time(), "-:--:--"))
            doing: Any = _Now(lambda: stage.doing(time.time()))
            self.task = self.bars.add_task(doing, total=stage.work, count=count, left=left)
        self._keep(0.0)

    def changed(self, stage: Stage, title: str | None = None) -> None:
        """Show that more of it is done, or that an analysis of another title is under way."""
        if title is not None:
            stage.under_way, stage.since = title, time.time()
        if self.bars:
            self.bars.update(self.task, completed=stage.reached)
        self._keep(self.every)

    def failed(self, stage: Stage, title: str, reasons: Iterable[str]) -> None:
        """Add an analysis that could not be completed, and tell why."""
        stage.faults.append((title, [*map(str, reasons)]))
        for reason in stage.faults[-1][1]:
            self._print(f"✗ {title}: {reason}")

    def end(self, stage: Stage) -> None:
        """Tell of a stage that has ended, in a line in the place of its bar."""
        stage.ended, stage.under_way = True, None
        if self.bars:
            self.bars.remove_task(self.task)
        kept = f", {stage.taken} taken over, inputs unchanged" if stage.taken else ""
        self._print(f"· {stage.name}: {stage.total}{kept}, {time.time() - stage.began:.1f} s")
        self._keep(0.0)

    def _print(self, line: str) -> None:
        if self.bars:
            self.bars.console.print(line, highlight=False, markup=False)

    def _keep(self, every: float) -> None:
        if self.folder is not None and (now := time.time()) - self.latest >= every:
            self.latest = now
            _write(self.folder, self.record)


def _bars(console: Console) -> Progress:
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
    from rich.table import Column

    # on a narrow terminal titles are cut, not times
    rest = Column(ratio=1, no_wrap=True, overflow="ellipsis")
    columns = (
        TextColumn("{task.description}", markup=False, table_column=rest), BarColumn(bar_width=10),
        TextColumn("{task.fields[count]}", markup=False), TimeElapsedColumn(),
        TextColumn("left {task.fields[left]}", markup=False),
    )  # fmt: skip
    return Progress(*columns, console=console, transient=True, expand=True)


@contextmanager
def progress() -> Iterator[Show]:
    """Yield a Show that prints progress to standard error; silent if that is not a terminal."""
    if not sys.stderr.isatty():
        yield Show()
        return
    from rich.console import Console

    show = Show(Console(stderr=True))
    assert show.bars
    with show.bars:
        yield show


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
        text = f"process {os.getpid()} on {platform.node()} since {time.strftime('%H:%M')}"
        with suppress(OSError):  # Windows keeps a locked file to itself, also from this
            path.write_text(json.dumps(asdict(Holder(text, os.getpid()))), encoding="utf-8")
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
    with suppress(OSError, ValueError, TypeError, RecursionError):
        return Holder(**json.loads(path.read_text(encoding="utf-8")))
    return Holder("a process which has just begun", None)


def _write(folder: Path, record: RunRecord) -> None:
    with suppress(OSError):  # the run goes on without it
        write_atomically(folder / NAME, json.dumps(asdict(record)).encode())


def record_exit(folder: Path, code: int) -> None:
    """Put the exit code of a run into the journal of its folder."""
    if folder.is_dir() and (record := read_journal(folder)).exit_code != code:
        record.exit_code = code
        _write(folder, record)


def read_journal(folder: Path) -> RunRecord:
    """Return what the journal in a folder holds; nothing where there is none, or none that a run wrote."""
    from pydantic import ConfigDict, TypeAdapter, ValidationError  # late: as above

    try:
        reader = TypeAdapter(list[RunRecord], config=ConfigDict(allow_inf_nan=False))
        with (folder / NAME).open("rb") as file:
            return reader.validate_json(b"[" + file.read(MOST_BYTES) + b"]")[0]
    except (OSError, ValidationError):
        return RunRecord()


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
