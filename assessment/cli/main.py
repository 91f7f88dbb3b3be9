"""The command line: assesto run, check, status, new, convert, schema, report, app, benchmark."""

from __future__ import annotations

import logging
import os
import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

from assessment.cli import commands
from assessment.cli.arguments import options_of
from assessment.cli.commands import INCOMPLETE, WRONG_INPUT, incomplete, tell_error
from assessment.runtime.console import collect_rarely, interrupted, leave, prepare, tell, watch
from assessment.runtime.errors import is_input_error
from assessment.runtime.journal import BusyError, record_exit
from mechanics.progress import before_compiling

if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code: 0 done, 2 wrong input, 3 an analysis could not be completed."""
    whole = arguments is None  # the process is this command
    if whole:
        prepare()
    try:
        options = options_of(sys.argv[1:] if arguments is None else arguments)
    except ValueError as error:
        tell(f"error: {error}")  # a name that has lines is no message of several
        return WRONG_INPUT
    except OSError as error:
        return tell_error(error)
    running = options.command is commands.run
    kept = "; finished analyses are kept: run again to go on" if running else ""
    unchanged = f"nothing of an earlier result was changed{kept}"

    def record(code: int) -> None:
        """Leave the exit code of a run in the journal of its folder, where `assesto status` finds it."""
        if running:
            record_exit(options.out or options.project / "output", code)

    if whole:
        watch(f"interrupted: {unchanged}", INCOMPLETE, lambda: record(INCOMPLETE))
        collect_rarely()
        before_compiling(lambda: tell("compiling, once for this version: about a minute"))
        # what libraries warn of and log, with the user's names in it, stays off the terminal, of other processes too
        logging.getLogger().addHandler(logging.NullHandler())
        if not sys.warnoptions:
            warnings.simplefilter("ignore")
            os.environ.setdefault("PYTHONWARNINGS", "ignore")
    try:
        code = _carry_out(options)
    except BusyError as error:
        return tell_error(error)  # the journal is that of the other run
    except (ValueError, OSError) as error:
        if not is_input_error(error):
            raise
        code = tell_error(error)
        if running and getattr(error, "outlines", None):
            tell("assesto check draws model.svg with the faults marked")
    except (RuntimeError, MemoryError) as error:
        if (cause := incomplete(error, unchanged)) is None:
            raise
        tell(f"error: {cause}")
        code = INCOMPLETE
    except KeyboardInterrupt:
        record(INCOMPLETE)
        if whole:
            leave(f"interrupted: {unchanged}", INCOMPLETE)
        tell(f"interrupted: {unchanged}")
        return INCOMPLETE
    record(code)
    return code


def _carry_out(options: argparse.Namespace) -> int:
    """Return the exit code of a command. Raises KeyboardInterrupt where a library made an error of an interruption.

    Raises ValueError where the folder that the command is given in is gone: relative paths mean nothing.
    """
    try:
        Path.cwd()
    except OSError:
        text = "the folder that the command is given in is gone; change to another one (cd)"
        raise ValueError(text) from None
    try:
        code: int = options.command(options)
    except Exception as error:  # a library may make any error of an interruption
        if interrupted():
            raise KeyboardInterrupt from error
        raise
    return code
