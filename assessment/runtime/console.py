"""The process of a command: what it prints never ends it, Ctrl-C does within a second, garbage is collected rarely."""

import atexit
import errno
import gc
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import NoReturn, TextIO

from mechanics.messages import visible

OUTPUT = "standard output"  # as a message names it


def prepare() -> None:
    """Have both streams open: files and pipes get UTF-8, a terminal a question mark for each letter that it lacks.

    Of a closed one the number would fall to the next file that is opened, and what libraries print would go there.
    """
    while (spare := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(spare, True)
    os.close(spare)
    sys.stdout = sys.stdout or _nowhere()
    sys.stderr = sys.stderr or _nowhere()
    atexit.register(_finish)
    for stream in (sys.stdout, sys.stderr):
        encoding = stream.encoding if stream.isatty() else "utf-8"
        stream.reconfigure(encoding=encoding, errors="replace")  # type: ignore[union-attr]


def say(text: str = "", end: str = "\n") -> None:
    """Print a text as it is; that its reader has gone away is no error. Raises OSError that names standard output."""
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


GRACE = 0.4  # s that the run has for ending in good order
SHOW_CURSOR = "\r\x1b[2K\x1b[?25h"  # a bar hides it
# Ctrl-C and what means the same, where the system has them
ASKED = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
_came = threading.Event()


def watch(message: str, code: int, last: Callable[[], object] = lambda: None) -> None:
    """From now on an interruption ends the process, after GRACE if KeyboardInterrupt has not; `last` is called first.

    A callback from C swallows that exception, and a library in C does not see it: the signal handler wakes a thread.
    """
    for name in ASKED:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) != signal.SIG_IGN:  # nohup wants SIGHUP ignored
            signal.signal(number, _interrupt)
    woken, wake = socket.socketpair()  # a pipe that does not block is none on Windows
    wake.setblocking(False)
    signal.set_wakeup_fd(wake.fileno(), warn_on_full_buffer=False)

    def follow() -> None:
        with wake:
            woken.recv(1)
            time.sleep(GRACE)
            last()
            leave(message, code)

    threading.Thread(target=follow, daemon=True).start()


def interrupted() -> bool:
    """Return whether an interruption came: a library may have made another exception of it."""
    return _came.is_set()


def _interrupt(*_: object) -> NoReturn:
    _came.set()
    raise KeyboardInterrupt


def leave(message: str, code: int) -> NoReturn:
    """End the process now: taking its libraries down in order would take a second and more."""
    with suppress(OSError):  # the terminal may be gone
        print((SHOW_CURSOR if sys.stderr.isatty() else "") + message, file=sys.stderr, flush=True)
    os._exit(code)


def collect_rarely() -> None:
    """Let the garbage collector run less often; processes that are started afterwards inherit the setting."""
    gc.set_threshold(50_000)  # allocations between collections: with Python's 700 the PDF takes a third more
