"""Processes that compute side by side: a functions and their arguments are sent, results returned as they are finished.

They end with the process that started them, however it ends; if one of them is killed, the others are ended too.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any, Self, TypeVar, TypeVarTuple

Arguments = TypeVarTuple("Arguments")
Result = TypeVar("Result")
Key = TypeVar("Key")
MOST = 61  # processes that Windows lets one wait for
_held: list[Any] = []  # in a process of a pool: what all of them were given


class KilledError(RuntimeError):
    """A process was ended from outside, as systems do where memory runs out."""


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def processes(jobs: int) -> int:
    """Return how many processes `jobs` stands for, 0: one per core; more than two per core are of no use."""
    return min(jobs or cores(), 2 * cores(), MOST)


class Pool:
    """Computes functions in so many processes, begun when first needed; 0: at once in this one.

    `held`: what each process is given once, however many functions are applied to it. Functions are found by their
    names and arguments are pickled: nothing of this process is assumed to be there in another.
    """

    def __init__(self, processes: int, held: Any = None) -> None:
        self.held = held
        self._executor = (
            ProcessPoolExecutor(processes, initializer=_begin, initargs=(held,)) if processes else None
        )

    def submit(self, function: Callable[[*Arguments], Result], *arguments: *Arguments) -> Future[Result]:
        """Start function(*arguments) and return its future; without processes it is computed at once.

        Raises KilledError if a process was ended from outside.
        """
        if self._executor is None:
            done: Future[Result] = Future()
            done.set_result(function(*arguments))
            return done
        try:
            return self._executor.submit(function, *arguments)
        except BrokenProcessPool as error:
            raise _told(error) from error.__cause__

    def apply(self, function: Callable[..., Result], *arguments: Any) -> Future[Result]:
        """Start function(held, *arguments) and return its future."""
        if self._executor is None:
            return self.submit(function, self.held, *arguments)
        return self.submit(_apply, function, arguments)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.close(at_once=kind is not None)

    def close(self, at_once: bool) -> None:
        """End the processes; `at_once`: without finishing their work, after an error."""
        if self._executor is None:
            return
        if at_once:
            for worker in multiprocessing.active_children():
                worker.terminate()
        self._executor.shutdown(cancel_futures=True)


def finished(begun: Mapping[Future[Result], Key]) -> Iterator[tuple[Key, Result]]:
    """Yield key and result of every future as it is finished.

    Of those that are finished at one time the failed ones come last: nothing that was computed is lost. Raises what
    they raised, KilledError where a process was ended from outside.
    """
    pending = dict(begun)
    while pending:
        done = wait(pending, return_when=FIRST_COMPLETED).done
        for future in sorted(done, key=lambda each: each.exception() is not None):
            yield pending.pop(future), result_of(future)


def result_of(future: Future[Result]) -> Result:
    """Wait for a future and return its result.

    Raises what its function raised, KilledError if a process was ended from outside.
    """
    try:
        return future.result()
    except BrokenProcessPool as error:
        raise _told(error) from error.__cause__


def _told(error: BrokenProcessPool) -> Exception:
    if error.__cause__ is not None:  # a result that cannot be sent: a bug
        return error
    return KilledError(
        "a process of the run was ended from outside, as happens where memory runs out (--jobs 1 takes least)"
    )


def _apply(function: Callable[..., Result], arguments: tuple[Any, ...]) -> Result:
    return function(_held[0], *arguments)


def _begin(held: Any) -> None:
    """Leave interruptions to the parent; end when it says so, and with it however it ends."""
    _held[:] = [held]
    signal.set_wakeup_fd(-1)  # the parent's own
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if hasattr(signal, "SIGHUP"):
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def follow() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()
