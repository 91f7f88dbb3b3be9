"""Standard output and error: whatever they cannot take, a finished run is not lost for it."""

from __future__ import annotations

import atexit
import codecs
import errno
import os
import sys
import unicodedata
from contextlib import suppress
from typing import TextIO

SPELT = {
    "−": "-",
    "–": "-",
    "—": "-",
    "·": "-",
    "…": "...",
    "×": "x",
    "“": '"',
    "”": '"',
    "’": "'",
    "→": "->",
}


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
    """Print a text; a reader that has gone away, `head` for one, has seen enough.

    Raises OSError that names standard output where it cannot be written for another reason.
    """
    try:
        print(text, end=end, flush=True)
    except OSError as error:
        sys.stdout = _nowhere()
        if not isinstance(error, BrokenPipeError) and error.errno != errno.EINVAL:  # as Windows calls it
            raise OSError(error.errno, error.strerror, "standard output") from None


def tell(text: str) -> None:
    """Print a text to standard error, if anybody listens."""
    with suppress(OSError):
        print(text, file=sys.stderr, flush=True)


def _finish() -> None:
    """Print what is left, of --help too, whose reader may also have seen enough."""
    try:
        say(end="")
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
