"""Files that appear whole or not at all."""

from __future__ import annotations

import hashlib
import os
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

LONGEST = 3600.0  # s that writing a file takes: older temporary files are of processes that were killed
MOST_BYTES = 250_000_000  # of a file whose content is digested: more than of any input that is not refused


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Raise every OSError of the block with the name of the file; for a full disk the system gives none."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error


def write_atomically(path: Path, content: bytes) -> None:
    """Write to a temporary file in the same folder (made if missing), then rename it over `path`.

    Raises OSError that names `path`.
    """
    temporary = temporary_of(path)
    try:
        with naming(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            _clear_once(path.parent)
            temporary.write_bytes(content)
            temporary.replace(path)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def temporary_of(path: Path) -> Path:
    """Return where this process writes what is then renamed to `path`."""
    return path.with_name(f".{path.name}.{os.getpid()}.tmp")


def left_over(folder: Path, name: str = "*") -> list[Path]:
    """Return the temporary files and folders of killed processes in a folder: of the file `name`, or of all."""
    return [path for path in folder.glob(f".{name}.*.tmp") if _is_left_over(path)]


def clear_left_over(folder: Path) -> None:
    """Remove the temporary files of killed processes from a folder."""
    with suppress(OSError):
        for path in left_over(folder):
            with suppress(OSError):
                path.unlink()


_clear_once = cache(
    clear_left_over
)  # in a process: a folder may hold thousands of files, and is written as often


def _is_left_over(path: Path) -> bool:
    """Whether the process that a temporary file is named after is gone, or has had more than enough time."""
    number = re.fullmatch(r".+\.(\d+)\.tmp", path.name)
    if number is None:
        return False
    with suppress(OSError):
        if time.time() - path.stat().st_mtime > LONGEST:
            return True
    if os.name == "nt":  # where to ask for a process may end it
        return False
    try:
        os.kill(int(number[1]), 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        return False
    return False


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file (hexadecimal); of one larger than MOST_BYTES that of its size and date."""
    with path.open("rb") as file:
        status = os.fstat(file.fileno())
        if status.st_size > MOST_BYTES:
            return hashlib.sha256(f"{status.st_size} {status.st_mtime_ns}".encode()).hexdigest()
        return hashlib.file_digest(file, "sha256").hexdigest()
