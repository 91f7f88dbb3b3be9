"""The verdict on an input: refused in the words of the person who wrote it, or completed; anything else is a fault."""

import contextlib
import io
import re
from collections.abc import Callable
from pathlib import Path

from assessment.cli.main import main
from assessment.runtime.errors import is_input_error

REFUSED, COMPLETED = "refused", "completed"

# What Python and its libraries say of their own troubles: no user can mend that.
INTERNAL = re.compile(
    r"cannot convert|object is not|has no attribute|unsupported operand|invalid literal|index out of|out of range"
    r"|NoneType|division by zero|Expecting |ndarray|dtype|broadcast|positional argument|recursion depth"
    r"|codec can't|could not convert|truth value|Traceback|\bKeyError|\bTypeError|int too large"
)
WITHOUT_REMEDY = re.compile(
    r"and \d+ more of this kind|gaps of up to|gaps, and blocks that touch nothing|drawing with the faults marked"
    r"|small faults can be repaired"
)
LONGEST = 3000  # characters of a line of a message


def judged(call: Callable[[], object]) -> str:
    """Return the verdict on what a function of the program does with an input."""
    try:
        call()
    except (ValueError, OSError) as error:
        if not is_input_error(error):
            raise
        check(str(error))
        return REFUSED
    return COMPLETED


def commanded(*arguments: str | Path) -> str:
    """Return the verdict on a command: exit code 2 with messages alone, or 0 or 3."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([str(argument) for argument in arguments])
    assert not _unseen(out.getvalue() + err.getvalue()), "an escape reached the terminal"
    if code in {0, 3}:
        return COMPLETED
    assert code == 2
    assert out.getvalue() == ""
    lines = err.getvalue().splitlines()
    for line in lines:
        assert line.startswith(
            ("error: ", "drawing with the faults marked: ", "small faults can be repaired")
        )
    check("\n".join(line.removeprefix("error: ") for line in lines))
    return REFUSED


def check(message: str) -> None:
    """Assert that a message says file, what is wrong and what to do, in lines that one can read."""
    assert message
    assert not INTERNAL.search(message), message
    for line in message.split("\n"):
        assert len(line) <= LONGEST, f"{len(line)} characters"
        if not WITHOUT_REMEDY.search(line):
            file, _, what = line.partition(": ")
            assert file and what, line
            assert ";" in what or "?" in what or "must " in what, line


def _unseen(text: str) -> bool:
    return any(not (c.isprintable() or c == "\n") for c in text)
