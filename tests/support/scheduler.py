"""A Dask scheduler and its worker, processes of their own as one starts them."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tests import ROOT

LONG = 600  # s: what hangs fails, a busy machine does not
PAUSE = 0.01  # s


def wait_for(happened: Callable[[], bool], *alive: subprocess.Popen[Any]) -> None:
    """Wait until something has happened that no process needs more than LONG for, and that needs all of these."""
    for _ in range(round(LONG / PAUSE)):
        ended = [process.args for process in alive if process.poll() is not None]
        if happened():
            return
        assert not ended
        time.sleep(PAUSE)
    raise AssertionError(f"not within {LONG} s")


@contextmanager
def dask(*command: str) -> Iterator[subprocess.Popen[bytes]]:
    """Start a command of Dask; end it."""
    started = subprocess.Popen([sys.executable, "-m", "dask", *command], cwd=ROOT, stderr=subprocess.DEVNULL)
    try:
        yield started
    finally:
        started.kill()
        started.wait(timeout=LONG)


@contextmanager
def scheduler(folder: Path) -> Iterator[tuple[str, subprocess.Popen[bytes], subprocess.Popen[bytes]]]:
    """Start a scheduler and a worker, as one does; yield the address, the scheduler and the worker."""
    file = folder / "scheduler.json"
    options = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
    with dask("scheduler", *options) as started:
        wait_for(lambda: file.exists() and bool(file.read_text()), started)
        address = json.loads(file.read_text())["address"]
        ending = ("--no-nanny", "--death-timeout", "60")
        with dask("worker", address, "--nthreads", "1", "--no-dashboard", *ending) as worker:
            yield address, started, worker
