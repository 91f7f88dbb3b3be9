"""A running Dask cluster that computes, of workers of the same program: what `Pool` is on this machine."""

from __future__ import annotations

import platform
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeVar, TypeVarTuple

from assessment.runtime.cache import program
from assessment.runtime.errors import ProjectError
from assessment.runtime.pool import KilledError, Pool

Arguments = TypeVarTuple("Arguments")
Result = TypeVar("Result")
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
            if self._client.status not in GONE and not _is_of_cluster(error):
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


def _is_of_cluster(error: BaseException) -> bool:
    return type(error).__module__.startswith(("distributed", "asyncio", "concurrent"))
