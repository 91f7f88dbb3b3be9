"""The program in a child of this process: what is imported here, a second's work, and put into it, is there too."""

import os
import signal
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress

from assessment.cli.main import main

UNCAUGHT = 70  # exit code of a child in which an exception was raised


class Forked:
    """A child at work, with a session and pipes of its own; `out` and `err`, what it prints, to read."""

    def __init__(self, arguments: Sequence[str]) -> None:
        pipes = os.pipe(), os.pipe()
        self.pid = os.fork()
        if self.pid == 0:
            _carry_out(arguments, *(writing for _, writing in pipes))
        for _, writing in pipes:
            os.close(writing)
        self.out, self.err = (os.fdopen(reading, encoding="utf-8") for reading, _ in pipes)
        self._code: int | None = None

    def send(self, number: int) -> None:
        """Send a signal to the child alone."""
        os.kill(self.pid, number)

    @property
    def at_work(self) -> bool:
        """Whether the child has not ended."""
        if self._code is None and (ended := os.waitpid(self.pid, os.WNOHANG)) != (0, 0):
            self._code = os.waitstatus_to_exitcode(ended[1])
        return self._code is None

    def end(self) -> tuple[int, str, str]:
        """Wait until nobody holds the pipes; return exit code, minus the number of a signal, and what was printed."""
        out, err = self.out.read(), self.err.read()
        self._code = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])
        return self._code, out, err

    def kill(self) -> None:
        """End the child, and what it has begun."""
        with suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        if self._code is None:
            os.waitpid(self.pid, 0)
        self.out.close()
        self.err.close()


def _carry_out(arguments: Sequence[str], out: int, err: int) -> None:
    """Be the program as a new process would, and end."""
    code = UNCAUGHT
    try:
        os.setsid()
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
        for number, pipe in ((1, out), (2, err)):
            os.dup2(pipe, number)
        sys.stdout, sys.stderr = (os.fdopen(number, "w", encoding="utf-8") for number in (1, 2))
        sys.argv = ["assesto", *arguments]
        code = main()
    except BaseException:  # nothing of the tests may go on in the child
        traceback.print_exc()
    finally:
        with suppress(OSError, ValueError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)


@contextmanager
def forked(*arguments: str) -> Iterator[Forked]:
    """Begin the program with these arguments; nothing of it is left at the end."""
    child = Forked(arguments)
    try:
        yield child
    finally:
        child.kill()
