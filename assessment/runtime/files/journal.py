"""The progress of a run in a file that remains if the run is killed: written line by line, read by `assesto status`."""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from assessment.runtime.pace import Pace
from assessment.runtime.show import Show

MOST_BYTES = 100_000_000  # that are read: half a million analyses
SELDOM = 0.01  # of the time of a stage: how often it is written what is reached, 1 s at least
NAME = ".assesto.journal"  # in the output folder, while a run is at work there and after one that was killed


@contextmanager
def journal(folder: Path, show: Show) -> Iterator[Show]:
    """Yield a Show that reports to `show` and writes the journal of a folder.

    The journal is removed when the run ends, and stays if it is killed or fails.
    """
    path = folder / NAME
    path.unlink(missing_ok=True)
    yield Journal(path, show)
    path.unlink(missing_ok=True)


@dataclass
class Journal(Show):
    """Writes each event as a line of JSON, so that a kill leaves all lines before it; passes it on to `show`."""

    path: Path
    show: Show
    began: float = 0.0
    latest: float = 0.0

    def begin(self, stage: str, total: int, taken: int, work: float) -> None:
        """See Show."""
        self._write(event="begin", stage=stage, total=total, taken=taken, work=work)
        self.began = self.latest
        self.show.begin(stage, total, taken, work)

    def under_way(self, title: str) -> None:
        """See Show."""
        self.show.under_way(title)

    def reached(self, done: float) -> None:
        """See Show."""
        if time.time() - self.latest >= max(1.0, SELDOM * (time.time() - self.began)):
            self._write(event="reached", work=done)
        self.show.reached(done)

    def advance(self, done: float) -> None:
        """See Show."""
        self._write(event="done", work=done)
        self.show.advance(done)

    def fault(self, title: str, reasons: Sequence[str]) -> None:
        """See Show."""
        self._write(event="fault", title=title, reasons=list(reasons))
        self.show.fault(title, reasons)

    def end(self) -> None:
        """See Show."""
        self._write(event="end")
        self.show.end()

    def _write(self, **event: Any) -> None:
        """Append a line; if it cannot be written, the run goes on without it."""
        self.latest = time.time()
        with suppress(OSError):
            descriptor = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
            try:
                os.write(descriptor, (json.dumps({"time": self.latest} | event) + "\n").encode())
            finally:
                os.close(descriptor)


@dataclass
class Stage:
    """A stage as read from its journal; times in s since the epoch."""

    name: str
    total: int
    taken: int
    pace: Pace
    done: int = 0
    ended: bool = False
    faults: list[tuple[str, list[str]]] = field(default_factory=list)

    @property
    def open(self) -> int:
        """Analyses that are not finished."""
        return self.total - self.taken - self.done


def read_journal(folder: Path) -> list[Stage]:
    """Return the stages of the journal in a folder; none where there is none.

    An incomplete line is left out, and so is one that is no event: the file is what a kill or a full disk left.
    """
    try:
        with (folder / NAME).open("rb") as file:
            lines = file.read(MOST_BYTES).decode(errors="replace").splitlines()
    except OSError:
        return []
    stages: list[Stage] = []
    for line in lines:
        with suppress(ValueError, TypeError, KeyError, IndexError, OverflowError, RecursionError):
            _add(stages, json.loads(line))
    return stages


def _add(stages: list[Stage], event: Mapping[str, Any]) -> None:
    """Add an event to the stage that it is of, the last one; an event that is none raises and changes nothing."""
    kind, moment = event["event"], float(event["time"])
    work = float(event["work"]) if kind in {"begin", "reached", "done"} else 0.0
    if not math.isfinite(moment) or not math.isfinite(work):
        raise ValueError(f"time: {moment}, work: {work}")
    if kind == "begin":
        pace = Pace(work, moment)
        stages.append(Stage(str(event["stage"]), int(event["total"]), int(event["taken"]), pace))
    stage = stages[-1]
    if kind in {"reached", "done"}:
        stage.pace.reached(work, moment)
        stage.done += kind == "done"
    elif kind == "fault":
        stage.faults.append((str(event["title"]), [str(reason) for reason in event["reasons"]]))
    elif kind == "end":
        stage.ended = True
