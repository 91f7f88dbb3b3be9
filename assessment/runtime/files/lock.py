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

try:
    import fcntl
except ImportError:  # Windows
    import msvcrt

    fcntl = None  # type: ignore[assignment]

NAME = ".assesto.lock"  # in the output folder, while a run writes there
BEYOND = 1 << 20  # byte that Windows locks and nobody can read then: behind the text
PATIENCE = 0.2  # s: `holder` takes the lock for an instant, to see whether it is free


@dataclass(frozen=True)
class Holder:
    """The process that writes into a folder: as a sentence names it, and its number; None where it is not known yet."""

    text: str
    pid: int | None


class BusyError(ProjectError):
    """Another run writes into the folder; the message names its lock and its process."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Keep other runs out of a folder; it is created if missing, and removed again if it stays empty.

    Raises BusyError if another run writes into it, OSError if it cannot be written.
    """
    made = not folder.exists()
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / NAME
    descriptor = _claimed(path)
    try:
        os.ftruncate(descriptor, 0)
        host = platform.node()
        text = f"process {os.getpid()} on {host} since {time.strftime('%H:%M')}"
        facts = json.dumps({"pid": os.getpid(), "host": host, "since": time.time()})
        os.write(descriptor, f"{text}\n{facts}\n".encode())
        yield
    finally:
        # before the lock is released: a process that holds the removed file opens a new one
        with suppress(OSError):
            path.unlink()
        os.close(descriptor)
        with suppress(OSError):  # Windows does not remove an open file
            path.unlink()
        if made:
            with suppress(OSError):  # not empty
                folder.rmdir()


def holder(folder: Path) -> Holder | None:
    """Return the process that writes into a folder; None if there is none."""
    try:
        descriptor = os.open(folder / NAME, os.O_RDWR)
    except OSError:
        return None
    try:
        return None if _lock(descriptor) else _read(descriptor)
    finally:
        os.close(descriptor)


def _read(descriptor: int) -> Holder:
    """Return who holds the lock of an open file; its text may not be written yet."""
    text, _, facts = os.read(descriptor, 1000).decode(errors="replace").partition("\n")
    try:
        pid = int(json.loads(facts)["pid"])
    except (ValueError, TypeError, KeyError, RecursionError):
        pid = None
    return Holder(text or "a process which has just begun", pid)


def _claimed(path: Path) -> int:
    """Return the descriptor of a lock that no other process holds."""
    began = time.monotonic()
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        if not _lock(descriptor):
            other = _read(descriptor)
            os.close(descriptor)
            if time.monotonic() - began < PATIENCE:
                time.sleep(0.02)
                continue
            raise BusyError(
                f"{path}: another run is writing into this folder ({other.text}); wait until it has ended, stop it, "
                "or give another folder with --out DIR"
            )
        with suppress(FileNotFoundError):
            if path.stat().st_ino == os.fstat(descriptor).st_ino:
                return descriptor
        os.close(descriptor)  # the file was just removed by the previous run


def _lock(descriptor: int) -> bool:
    """Lock an open file; return whether that succeeded. On a file system without locks it always does."""
    try:
        if fcntl is not None:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        else:
            os.lseek(descriptor, BEYOND, os.SEEK_SET)
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:  # some network drives
        return True
    finally:
        os.lseek(descriptor, 0, os.SEEK_SET)
    return True
