"""Processes that compute side by side, here, or on the workers of a running Dask cluster; they end with the run."""

import multiprocessing
import os
import platform
import queue
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, InvalidStateError, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
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
GONE = ("closing", "closed")  # status of a client without its scheduler
LOST = "the Dask scheduler or its workers were lost; start them and run again"
NONE_LEFT = (
    "the Dask scheduler has not answered, or had no worker, for {seconds:g} s; start it, or one (dask worker)"
)
MUTE = (
    "--scheduler: {address}: accepts connections and has not answered as a Dask scheduler for {seconds:g} s; "
    "start one (dask scheduler) with its workers (dask worker), or correct the address, and run again"
)
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
    """Computes functions in a number of processes, started when first needed; 0: at once in this one.

    `held`: what each process is given once; `ended`: is given each function applied to it as it ends, in any thread.
    """

    def __init__(
        self, processes: int, held: Any = None, ended: Callable[[Callable[..., Any]], object] | None = None
    ) -> None:
        self.held, self._ended = held, ended
        self._board: list[Any] = []  # memory shared with the processes to come, where the system gives any
        self._executor = None
        if processes:
            with suppress(OSError):
                self._board = [multiprocessing.RawArray("d", [NOTHING] * CELLS)]
            own = (held, self._board)
            self._executor = ProcessPoolExecutor(processes, initializer=_begin, initargs=own)

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
        future: Future[Result]
        if self._executor is None:
            future = self.submit(function, self.held, *arguments)
        else:
            future = self.submit(_apply, function, arguments)
        if (ended := self._ended) is not None:
            future.add_done_callback(lambda _: ended(function))
        return future

    def teller(self, number: int) -> Callable[[float | None], None]:
        """Return what reports, in a process, the share that is done of the task of that number; None: it has ended."""
        return partial(_tell, number)

    def shares(self) -> Mapping[int, float]:
        """Return the share that is done of the tasks at work, by the numbers under which they report it."""
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


def _tell(number: int, share: float | None) -> None:
    """Report, in a process of a pool, the share that is done of a task, in one cell with its number; None: ended."""
    for board in _board:
        board[number % CELLS] = NOTHING if share is None else number + min(share, 0.999)


def finished(
    futures: Mapping[Future[Result], Key], meanwhile: Callable[[], object] = lambda: None
) -> Iterator[tuple[Key, Result]]:
    """Yield key and result of every future as it is finished; `meanwhile`: done every LOOK in which none is.

    `futures` may grow. Of those finished together failed ones come last. Raises what they raised, or KilledError.
    """
    ended: queue.SimpleQueue[Future[Result]] = queue.SimpleQueue()
    heard: set[Future[Result]] = set()
    left = 0
    while True:
        for future in futures.keys() - heard:
            heard.add(future)
            left += 1
            future.add_done_callback(ended.put)
        if not left:
            return
        try:
            done = [ended.get(timeout=LOOK)]
        except queue.Empty:
            meanwhile()
            continue
        while not ended.empty():
            done.append(ended.get())
        left -= len(done)
        for future in sorted(done, key=lambda each: each.exception() is not None):
            yield futures[future], result_of(future)


def result_of(future: Future[Result]) -> Result:
    """Return the result of a future. Raises what its function raised, or KilledError."""
    try:
        return future.result()
    except BrokenProcessPool as error:
        raise _ended(error) from error.__cause__


def _ended(error: BrokenProcessPool) -> Exception:
    if error.__cause__ is not None:  # a result that cannot be sent: a bug
        return error
    return KilledError(
        "a process of the run was ended from outside, as happens where memory runs out (--jobs 1 takes least)"
    )


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
    assert parent is not None

    def follow() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


@dataclass(frozen=True, slots=True)
class Patience:
    """Times, s: deadlines of our own, as the library waits for ever where a peer accepts and says nothing.

    `answer`: until a scheduler has taken us on; `workerless`: in which work waits, and no scheduler has told of a
    worker; `look`: between two looks at the workers.
    """

    answer: float = 10.0
    workerless: float = 300.0
    look: float = 2.0


PATIENCE = Patience()


class Cluster(Pool):
    """Computes functions on the workers of the scheduler at an address such as tcp://host:8786.

    Raises ProjectError without dask.distributed or a scheduler, KilledError where what is there says nothing.
    """

    def __init__(self, address: str, patience: Patience = PATIENCE) -> None:
        self._patience = patience
        self._client = _connected(address, patience.answer)
        self._workers = self._client.get_executor(pure=False)
        self._open: set[Future[Any]] = set()
        self._board = []
        self._closed = threading.Event()
        threading.Thread(target=self._watch, daemon=True).start()

    def submit(self, function: Callable[[*Arguments], Result], *arguments: *Arguments) -> Future[Result]:
        """Begin function(*arguments); result or error are the future's, KilledError where the cluster is lost."""
        done: Future[Result] = Future()
        self._open.add(done)
        done.add_done_callback(self._open.discard)
        try:
            remote = self._workers.submit(_outcome, program(), function, arguments)
        except Exception as error:  # a lost cluster shows as whatever its library meets
            of_cluster = type(error).__module__.startswith(("distributed", "asyncio", "concurrent"))
            if self._client.status not in GONE and not of_cluster:
                raise
            _fail(done, KilledError(LOST))
            return done
        remote.add_done_callback(lambda ended: _hand_over(ended, done))
        return done

    def close(self, at_once: bool) -> None:
        """Leave the cluster; its work for this process is given up."""
        self._closed.set()
        _within(CLOSING, self._client.close)
        self._give_up(LOST)

    def _watch(self) -> None:
        """Fail all open tasks once no worker has answered for too long."""
        patience, staffed = self._patience, time.monotonic()
        while not self._closed.wait(patience.look):
            workers, now = _within(patience.workerless, self._client.nthreads), time.monotonic()
            # one that adapts has none while there is nothing to do
            if not isinstance(workers, Exception) and (workers or not self._open):
                staffed = now
            elif now - staffed > patience.workerless:
                self._give_up(NONE_LEFT.format(seconds=patience.workerless))

    def _give_up(self, reason: str) -> None:
        for done in tuple(self._open):
            _fail(done, KilledError(reason))


def _connected(address: str, seconds: float) -> Any:
    """Return a client of the scheduler at an address. Raises as Cluster."""
    try:
        from distributed import Client
    except ImportError:
        text = 'dask.distributed is not installed; install it: pip install "assesto[cluster]"'
        raise ProjectError(f"--scheduler: {text}") from None
    # `close` closes it; one that could not begin waits 20 s for that when it is deleted, and prints a traceback
    connect: Any = type("Client", (Client,), {"__del__": lambda _: None})
    found = _within(2.0 * seconds, lambda: connect(address, timeout=seconds, set_as_default=False))
    if isinstance(found, LateError):
        raise KilledError(MUTE.format(address=address, seconds=2.0 * seconds))
    if isinstance(found, Exception):  # what an address of another kind raises is up to its library
        raise ProjectError(
            f"--scheduler: {address}: no Dask scheduler answers there ({type(found).__name__}); start one "
            "(dask scheduler) with its workers (dask worker), or correct the address"
        )
    return found


class LateError(TimeoutError):
    """A call did not come back in time."""


def _within(seconds: float, call: Callable[[], Any]) -> Any:
    """Return what a call returns, or the exception that it raises; LateError where it does not come back in time."""
    found: list[Any] = []

    def carry_out() -> None:
        try:
            found.append(call())
        except Exception as error:  # raised again by the thread that waits
            found.append(error)

    thread = threading.Thread(target=carry_out, daemon=True)
    thread.start()
    thread.join(seconds)
    return found[0] if found else LateError()


@dataclass(frozen=True)
class _Failed:
    """The error of an analysis: what a future of the cluster itself raises is always a loss of the cluster."""

    error: Exception


def _outcome(expected: str, function: Callable[..., Result], arguments: tuple[Any, ...]) -> Result | _Failed:
    """Compute in a worker, where it runs the same program."""
    if program() != expected:
        return _Failed(
            ProjectError(
                f"--scheduler: the worker on {platform.node()} has another version of the program, its libraries or "
                "Python; install the same ones there"
            )
        )
    try:
        return function(*arguments)
    except Exception as error:  # travels to the run, which raises it
        return _Failed(error)


def _hand_over(ended: Future[Any], done: Future[Any]) -> None:
    """Pass the outcome of a task on the cluster to its future in this process."""
    try:
        outcome = ended.result()
    except MemoryError as error:  # of the result, here
        outcome = _Failed(error)
    except BaseException:  # cancelled, or of a scheduler that is gone
        outcome = _Failed(KilledError(LOST))
    if isinstance(outcome, _Failed):
        _fail(done, outcome.error)
        return
    with suppress(InvalidStateError):  # it had failed, for want of a worker
        done.set_result(outcome)


def _fail(done: Future[Any], error: BaseException) -> None:
    with suppress(InvalidStateError):  # it had failed before
        done.set_exception(error)
