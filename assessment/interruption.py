"""Ctrl-C ends the process within a second, whatever it is at."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from typing import NoReturn

GRACE = 0.4  # s that the run has for ending in good order
SHOW_CURSOR = "\r\x1b[2K\x1b[?25h"  # a bar hides it


def watch(said: str, code: int) -> None:
    """From now on an interruption ends the process, soon after it came if KeyboardInterrupt has not yet.

    A callback from C swallows that exception, and a library at work in C does not see it before it comes back: the
    interpreter's own signal handler, which is in C too, wakes a thread.
    """
    woken, wake = os.pipe()
    os.set_blocking(wake, False)
    signal.set_wakeup_fd(wake, warn_on_full_buffer=False)

    def follow() -> None:
        os.read(woken, 1)
        time.sleep(GRACE)
        leave(said, code)

    threading.Thread(target=follow, daemon=True).start()


def leave(said: str, code: int) -> NoReturn:
    """End the process now: taking its libraries down in order would take a second and more."""
    print((SHOW_CURSOR if sys.stderr.isatty() else "") + said, file=sys.stderr, flush=True)
    os._exit(code)
