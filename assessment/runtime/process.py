"""The process of a command: Ctrl-C and its kin end it within a second; garbage is collected rarely."""

from __future__ import annotations

import gc
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import NoReturn

GRACE = 0.4  # s that the run has for ending in good order
SHOW_CURSOR = "\r\x1b[2K\x1b[?25h"  # a bar hides it
# Ctrl-C and what means the same, where the system has them
ASKED = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
_came = threading.Event()


def watch(message: str, code: int, last: Callable[[], object] = lambda: None) -> None:
    """From now on an interruption ends the process, soon after it came if KeyboardInterrupt has not yet.

    `last`: is called before the process ends.

    A callback from C swallows that exception, and a library at work in C does not see it before it comes back: the
    interpreter's own signal handler, which is in C too, wakes a thread.
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


_NEW_OBJECTS = 50_000  # allocations between two collections: with Python's 700 the PDF takes a third longer


def collect_rarely() -> None:
    """Let the garbage collector run less often; processes that are started afterwards inherit the setting."""
    gc.set_threshold(_NEW_OBJECTS)
