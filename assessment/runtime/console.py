"""Standard output and error: a text that cannot be printed does not end a run."""

from __future__ import annotations

import atexit
import codecs
import errno
import os
import sys
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

OUTPUT = "standard output"  # as a message names it
SPELT = dict.fromkeys("−–—·", "-") | dict.fromkeys("“”", '"') | {"…": "...", "×": "x", "’": "'", "→": "->"}


def prepare() -> None:
    """Have both streams open, and letters that their encoding lacks spelt out.

    Of a closed one the number would fall to the next file that is opened, and what libraries print would go there.
    """
    while (spare := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(spare, True)
    os.close(spare)
    sys.stdout = sys.stdout or _nowhere()
    sys.stderr = sys.stderr or _nowhere()
    atexit.register(_finish)
    codecs.register_error("spelt", _spell)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="spelt")  # type: ignore[union-attr]


def say(text: str = "", end: str = "\n") -> None:
    """Print a text, its lines as they are shown; a reader that has gone away, `head` for one, has seen enough.

    Raises OSError that names standard output where it cannot be written for another reason.
    """
    with _written():
        print("\n".join(map(visible, text.split("\n"))), end=end, flush=True)


def unwritten(error: BaseException) -> bool:
    """Return whether an error is that standard output could not be written."""
    return isinstance(error, OSError) and error.filename == OUTPUT


def tell(line: str) -> None:
    """Print a line to standard error, if anybody listens."""
    try:
        print(visible(line), file=sys.stderr, flush=True)
    except OSError:  # what is left in its buffer would fail once more at the end, with a code of its own
        sys.stderr = _nowhere()


def visible(line: str) -> str:
    """Return a line of unknown origin as a terminal shows it, and does nothing else: control characters as escapes.

    `mechanics.faults` has the same for messages; to import it takes longer than a run in which nothing has changed.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in line)


@contextmanager
def _written() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        sys.stdout = _nowhere()
        if not isinstance(error, BrokenPipeError) and error.errno != errno.EINVAL:  # as Windows calls it
            raise OSError(error.errno, error.strerror, OUTPUT) from None


def _finish() -> None:
    """Print what libraries have left, whose reader may also have seen enough."""
    try:
        with _written():
            sys.stdout.flush()
    except OSError as error:
        tell(f"error: {error.filename}: {error.strerror}")


def _nowhere() -> TextIO:
    return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123 - for as long as the process lives


def _spell(error: UnicodeError) -> tuple[str, int]:
    """Return what to write for letters that an encoding lacks: α is alpha, é is e, ? where there is nothing like it."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_spelt, error.object[error.start : error.end])), error.end


def _spelt(letter: str) -> str:
    base = unicodedata.normalize("NFKD", letter)
    name = unicodedata.name(base[0], "").split()
    if name[:1] == ["GREEK"]:
        return name[-1].lower() if "SMALL" in name else name[-1].capitalize()
    return SPELT.get(letter) or base.encode("ascii", "ignore").decode() or "?"
