"""Exit codes, and the exceptions that lead to them."""

from __future__ import annotations

from opcode import opmap

from assessment.runtime.terminal.console import tell, unwritten

DONE, WRONG_INPUT, INCOMPLETE = 0, 2, 3
EXIT_CODES = f"""exit codes:
  {DONE}  done
  {WRONG_INPUT}  the input is wrong: nothing was overwritten
  {INCOMPLETE}  an analysis or the output was not completed, or the run was interrupted: what is finished is kept"""
RAISE = opmap["RAISE_VARARGS"]  # the instruction of a raise statement


def incomplete(error: RuntimeError | MemoryError, unchanged: str) -> str | None:
    """Return what kept an analysis from being completed, and what is left; None where the error is a bug."""
    from assessment.runtime.processes.pool import KilledError
    from mechanics import ConvergenceError

    if isinstance(error, ConvergenceError):
        return f"{error}; nothing was written"
    if isinstance(error, KilledError | MemoryError):
        return f"{'memory ran out' if isinstance(error, MemoryError) else error}; {unchanged}"
    return None


def is_input_error(error: ValueError | OSError) -> bool:
    """Whether an exception is the user's to mend: those that name what is wrong; any other one is a bug.

    A plain ValueError names it where a `raise` of our own code made it; one out of a library, or out of Python itself
    (int of a NaN), is a bug of ours.
    """
    if isinstance(error, OSError):
        return True
    from assessment.runtime.errors import ProjectError
    from mechanics import ArgumentError, DrawingError, RecordError

    if isinstance(error, ProjectError | DrawingError | RecordError | ArgumentError):
        return True
    last = error.__traceback__
    while last and last.tb_next:
        last = last.tb_next
    if type(error) is not ValueError or last is None:
        return False
    package = last.tb_frame.f_globals["__name__"].partition(".")[0]
    ours = package in {"assessment", "mechanics", "__main__"}
    return ours and last.tb_frame.f_code.co_code[last.tb_lasti] == RAISE


def tell_error(error: ValueError | OSError) -> int:
    """Print the message of an error, each of its lines as one; return its exit code."""
    for line in _message(error).split("\n"):
        tell(f"error: {line}")
    return INCOMPLETE if unwritten(error) else WRONG_INPUT


def _message(error: ValueError | OSError) -> str:
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}; change it or choose another place"
    return str(error)
