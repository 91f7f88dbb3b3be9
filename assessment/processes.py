"""Processes that a run starts: they end with it, however it ends."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from concurrent.futures import ProcessPoolExecutor


def belong_to_parent() -> None:
    """Leave interruption to the parent; end when it says so, and with it however it ends."""
    signal.set_wakeup_fd(-1)  # the parent's own
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def follow() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


def dismiss(pool: ProcessPoolExecutor, at_once: bool) -> None:
    """End the processes: `at_once`, with what they are at, where something went wrong."""
    if at_once:
        for worker in multiprocessing.active_children():
            worker.terminate()
    pool.shutdown(cancel_futures=True)
