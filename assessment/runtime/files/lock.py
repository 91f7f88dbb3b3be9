"""One run at a time writes into an output folder; the system lifts the lock of a process that was killed."""

from __future__ import annotations

import json
import os
import platform
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from assessment.runtime.errors import ProjectError

NAME = ".assesto.lock"  # in the output folder, while a run writes there
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
    """Keep other runs out of a folder; it is created if missing, and removed again if it stays empty.

    Raises BusyError if another run writes into it, OSError if it cannot be written.
    """
    from filelock import FileLock, Timeout  # late: most commands need none

    made, path = not folder.exists(), folder / NAME
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
    path = folder / NAME
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
    """Return who holds a lock, as far as its file tells."""
    with suppress(OSError, ValueError, TypeError, KeyError, RecursionError):
        text, _, facts = path.read_text(encoding="utf-8").partition("\n")
        return Holder(text, int(json.loads(facts)["pid"]))
    return Holder("a process which has just begun", None)
