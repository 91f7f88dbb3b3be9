"""Exit codes, and the exceptions that lead to them."""

from __future__ import annotations

from assessment.runtime.terminal.console import tell, unwritten

DONE, WRONG_INPUT, INCOMPLETE = 0, 2, 3
EXIT_CODES = f"""exit codes:
  {DONE}  done
  {WRONG_INPUT}  the input is wrong: nothing was overwritten
  {INCOMPLETE}  an analysis or the output was not completed, or the run was interrupted: what is finished is kept"""


def incomplete(error: RuntimeError | MemoryError, unchanged: str) -> str | None:
    """Return what kept an analysis from being completed, and what is left; None where the error is a bug."""
    from assessment.runtime.processes.pool import KilledError
    from mechanics import ConvergenceError

    if isinstance(error, ConvergenceError):
        return f"{error}; nothing was written"
    if isinstance(error, KilledError | MemoryError):
        return f"{'memory ran out' if isinstance(error, MemoryError) else error}; {unchanged}"
    return None


def tell_error(error: ValueError | OSError) -> int:
    """Print the message of an error, each of its lines as one; return its exit code."""
    from assessment.runtime.errors import error_text  # late: it takes as long to import as all of --help

    for line in error_text(error).split("\n"):
        tell(f"error: {line}")
    return INCOMPLETE if unwritten(error) else WRONG_INPUT
