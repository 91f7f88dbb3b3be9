"""Processes that compute side by side, here, or on the workers of a running Dask cluster; they end with the run."""

import multiprocessing
import os
import platform
import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from typing import Any, Self, TypeVar, TypeVarTuple

from assessment.runtime.cache import program
from assessment.runtime.errors import ProjectError

Arguments = TypeVarTuple("Arguments")
Result = TypeVar("Result")
Key = TypeVar("Key")
MOST = 61  # processes that Windows lets one wait for
LOOK = 0.25  # s between two looks at what the processes are at
CELLS = 1024  # more than there are processes
NOTHING = -1.0  # in a cell: no task is at work
_held: list[Any] = []  # in a process of a pool: what all of them were given
_board: list[Any] = []  # in a process of a pool: its cells, see Pool.shares
KILLED = "a process of the run was ended from outside, as where memory runs out (--jobs 1 takes least)"
LOST = "the Dask scheduler or its workers were lost; start them and run again"
ANSWER = 10.0  # s: until a scheduler has taken us on
CLOSING = 2.0  # s that the library has for leaving the cluster in good order


class KilledError(RuntimeError):
    """A process was ended from outside, as systems do where memory runs out."""


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def processes(jobs: int) -> int:
    """Return the number of processes for `jobs`, 0: one per core; more than two per core are of no use."""
    return min(jobs or cores(), 2 * cores(), MOST)


class Pool:
    """Computes functions in processes that start when needed, each given `held` once; none: at once in this one."""

    def __init__(self, processes: int, held: Any = None) -> None:
        self.held = held
        self._board: list[Any] = []  # memory shared with the processes to come, where the system gives any
        self._executor = None
        if processes:
            with suppress(OSError):
                self._board = [multiprocessing.RawArray("d", [NOTHING] * CELLS)]
            self._executor = ProcessPoolExecutor(processes, initializer=_begin, initargs=(held, self._board))

    def submit(self, function: Callable[[*Arguments], Result], *arguments: *Arguments) -> Future[Result]:
        """Start function(*arguments), at once without processes. Raises KilledError where a process was killed."""
        if self._executor is None:
            done: Future[Result] = Future()
            done.set_result(function(*arguments))
            return done
        try:
            return self._executor.submit(function, *arguments)
        except BrokenProcessPool as error:
            raise _ended(error) from error.__cause__

    def apply(self, function: Callable[..., Result], *arguments: Any) -> Future[Result]:
        """Start function(held, *arguments) and return its future."""
        if self._executor is None:
            return self.submit(function, self.held, *arguments)
        return self.submit(_apply, function, arguments)

    def shares(self) -> Mapping[int, float]:
        """Return the share that is done of the tasks at work, by the numbers under which they `tell` it."""
        return {int(value): value % 1.0 for board in self._board for value in board if value >= 0.0}

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


def tell(number: int, share: float | None) -> None:
    """Report, in a process of a pool, the share that is done of a task, in one cell with its number; None: ended."""
    for board in _board:
        board[number % CELLS] = NOTHING if share is None else number + min(share, 0.999)


def finished(
    futures: Mapping[Future[Result], Key], meanwhile: Callable[[], object] = lambda: None
) -> Iterator[tuple[Key, Result]]:
    """Yield key and result of every future as it is finished; `meanwhile`: done every LOOK in which none is.

    `futures` may grow. Of those finished together failed ones come last. Raises what they raised, or KilledError.
    """
    heard: set[Future[Result]] = set()
    while left := futures.keys() - heard:
        done, _ = wait(left, timeout=LOOK, return_when=FIRST_COMPLETED)
        heard |= done
        if not done:
            meanwhile()
        for future in sorted(done, key=lambda each: each.cancelled() or each.exception() is not None):
            yield futures[future], result_of(future)


def result_of(future: Future[Result]) -> Result:
    """Return the result of a future. Raises what its function raised, or KilledError."""
    try:
        return future.result()
    except BrokenProcessPool as error:
        raise _ended(error) from error.__cause__
    except (Exception, CancelledError) as error:
        raise _lost(error) from error.__cause__


def _ended(error: BrokenProcessPool) -> Exception:
    if error.__cause__ is not None:  # a result that cannot be sent: a bug
        return error
    return KilledError(KILLED)


def _apply(function: Callable[..., Result], arguments: tuple[Any, ...]) -> Result:
    return function(_held[0], *arguments)


def _begin(held: Any, board: list[Any]) -> None:
    """Prepare a process: interruptions are left to the parent, with which it ends however that ends."""
    _held[:], _board[:] = [held], board
    signal.set_wakeup_fd(-1)  # the parent's own
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if hasattr(signal, "SIGHUP"):
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def follow() -> None:
        assert parent is not None
        parent.join()
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


class Cluster(Pool):
    """Computes functions on the workers of the scheduler at an address such as tcp://host:8786.

    Raises ProjectError without dask.distributed or a scheduler, KilledError where a peer says nothing.
    """

    def __init__(self, address: str) -> None:
        try:
            from distributed import Client
            from distributed.comm.addressing import resolve_address
        except ImportError:
            text = 'dask.distributed is not installed; install it: pip install "assesto[cluster]"'
            raise ProjectError(f"--scheduler: {text}") from None
        found: list[Any] = []  # in a thread, as the library waits for ever for a peer that says nothing

        def connect() -> None:
            with suppress(Exception):  # what an address of another kind raises is up to its library
                at = resolve_address(address)  # a client of none would end with a traceback of its own
                found.append(Client(at, timeout=ANSWER, set_as_default=False))  # type: ignore[no-untyped-call]

        thread = threading.Thread(target=connect, daemon=True)
        thread.start()
        thread.join(2.0 * ANSWER)
        if not found:  # a peer that accepts and says nothing is no wrong address
            text = f"--scheduler: {address}: no Dask scheduler answers; start it and workers, or correct the address"
            raise (KilledError if thread.is_alive() else ProjectError)(text)
        self._client = found[0]
        self._workers, self._board = self._client.get_executor(pure=False), []

    def submit(self, function: Callable[[*Arguments], Result], *arguments: *Arguments) -> Future[Result]:
        """Begin function(*arguments) where a worker is free; the error of the function is that of the future."""
        try:
            return self._workers.submit(_of_this_version, program(), function, arguments)
        except Exception as error:
            raise _lost(error) from error

    def close(self, at_once: bool) -> None:
        """Leave the cluster; its work for this process is given up."""
        self._client.close(timeout=CLOSING)


def _of_this_version(expected: str, function: Callable[..., Result], arguments: tuple[Any, ...]) -> Result:
    """Compute in a worker, where it runs the same program."""
    if program() != expected:
        raise ProjectError(
            f"--scheduler: the worker on {platform.node()} has another version of the program, its libraries or "
            "Python; install the same ones there"
        )
    return function(*arguments)


def _lost(error: BaseException) -> BaseException:
    """Return the error of a function as it is, and that of a cluster that is gone as KilledError."""
    of_cluster = type(error).__module__.startswith(("distributed", "concurrent", "asyncio"))
    return KilledError(LOST) if of_cluster else error
