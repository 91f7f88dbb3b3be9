"""A running Dask cluster that computes: what `Pool` is on this machine.

Workers need the same program as this process; every task checks it. A worker that is lost costs what it was at: the
scheduler gives it to another one.
"""

from __future__ import annotations

import math
import platform
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeVar, TypeVarTuple

from assessment.runtime.errors import ProjectError
from assessment.runtime.fingerprint import program
from assessment.runtime.processes.pool import LOOK, KilledError

Arguments = TypeVarTuple("Arguments")
Result = TypeVar("Result")
TOPIC = "assesto: share that is done"  # one for all runs: a scheduler keeps a log of each
GONE = ("closing", "closed")  # status of a client without its scheduler
LOST = "the Dask scheduler or its workers were lost; start them and run again: finished analyses are kept"
NONE_LEFT = (
    "the Dask scheduler has had no worker for {seconds:g} s; start one (dask worker) and run again: "
    "finished analyses are kept"
)


@dataclass(frozen=True, slots=True)
class Patience:
    """Times, s. `answer`: that a scheduler has to answer; `look`: between two looks at the workers.

    `workerless`: in which work waits and no worker is there: a scheduler would wait for ever.
    """

    answer: float = 10.0
    workerless: float = 300.0
    look: float = 2.0


PATIENCE = Patience()


class Cluster:
    """Computes functions on the workers of the scheduler at an address such as tcp://host:8786.

    Functions are found by their names and arguments are pickled, as by Pool. Raises ProjectError where dask.distributed
    is not installed or no scheduler answers.
    """

    def __init__(self, address: str, patience: Patience = PATIENCE) -> None:
        self._patience = patience
        try:
            from distributed import Client
        except ImportError:
            raise ProjectError(
                '--scheduler: dask.distributed is not installed; install it: pip install "assesto[cluster]"'
            ) from None
        # `close` closes it; one that could not begin waits 20 s for that when it is deleted, and prints a traceback
        connect: Any = type("Client", (Client,), {"__del__": lambda _: None})
        try:
            self._client = connect(address, timeout=patience.answer, set_as_default=False)
        except Exception as error:  # what an address of another kind raises is up to its library
            raise ProjectError(
                f"--scheduler: {address}: no Dask scheduler answers there ({type(error).__name__}); start one "
                "(dask scheduler) with its workers (dask worker), or correct the address"
            ) from None
        self._open: set[Future[Any]] = set()
        self._shares: dict[int, float] = {}
        self._client.subscribe_topic(TOPIC, self._hear)
        self._closed = threading.Event()
        threading.Thread(target=self._watch, daemon=True).start()

    def submit(self, function: Callable[[*Arguments], Result], *arguments: *Arguments) -> Future[Result]:
        """Begin function(*arguments); result or error are the future's, KilledError where the cluster is lost."""
        done: Future[Result] = Future()
        self._open.add(done)
        done.add_done_callback(self._open.discard)
        try:
            remote = self._client.submit(_checked, program(), function, arguments, pure=False)
        except Exception as error:
            if not _is_loss(error, self._client):
                raise
            done.set_exception(KilledError(LOST))
            return done
        remote.add_done_callback(lambda ended: _hand_over(ended, self._client, done))
        done.remote = remote  # type: ignore[attr-defined]  # released, it would be cancelled
        return done

    def teller(self, number: int) -> Callable[[float | None], None]:
        """Return what reports, in a worker, the share that is done of the task of that number; None: it has ended."""
        return _Teller(self._client.id, number)

    def shares(self) -> Mapping[int, float]:
        """Return the share that is done of the tasks at work, by the numbers under which they report it."""
        return dict(self._shares)

    def _hear(self, event: tuple[float, Any]) -> None:
        """Take over what a worker reports; others have tasks for this scheduler too."""
        _, (client, number, share) = event
        if client != self._client.id:
            return
        if share is None:
            self._shares.pop(number, None)
        else:
            self._shares[number] = share

    def close(self, at_once: bool) -> None:
        """Leave the cluster; its work for this process is given up."""
        self._closed.set()
        self._client.close()

    def _watch(self) -> None:
        """Fail all open tasks once there has been no worker for too long."""
        seen = time.monotonic()
        while not self._closed.wait(self._patience.look):
            try:
                workers = self._client.nthreads()
            except Exception:  # the scheduler is lost: the client fails every future itself
                continue
            if workers or not self._open:  # one that adapts has none while there is nothing to do
                seen = time.monotonic()
            elif time.monotonic() - seen > self._patience.workerless:
                for done in tuple(self._open):
                    _fail(done, KilledError(NONE_LEFT.format(seconds=self._patience.workerless)))


@dataclass
class _Teller:
    """Sends the share that is done of a task of a client from a worker, every LOOK s at most; None: it has ended."""

    client: str
    number: int
    latest: float = -math.inf

    def __call__(self, share: float | None) -> None:
        from distributed import get_worker

        if share is None or time.monotonic() - self.latest >= LOOK:
            self.latest = time.monotonic()
            get_worker().log_event(TOPIC, (self.client, self.number, share))


def _checked(expected: str, function: Callable[..., Result], arguments: tuple[Any, ...]) -> Result:
    """Compute in a worker, where it runs the same program."""
    if program() != expected:
        raise ProjectError(
            f"--scheduler: the worker on {platform.node()} has another version of the program, its libraries or "
            "Python; install the same ones there"
        )
    return function(*arguments)


def _hand_over(ended: Any, client: Any, done: Future[Any]) -> None:
    """Pass the result or the error of a task on the cluster to its future in this process."""
    try:
        result = ended.result()
    except BaseException as error:
        own = ended.status == "error" and not _is_of_cluster(error)
        _fail(done, error if own or not _is_loss(error, client) else KilledError(LOST))
    else:
        with suppress(InvalidStateError):  # it had failed, for want of a worker
            done.set_result(result)


def _fail(done: Future[Any], error: BaseException) -> None:
    with suppress(InvalidStateError):  # it had failed before
        done.set_exception(error)


def _is_loss(error: BaseException, client: Any) -> bool:
    """Whether the cluster was lost.

    A client without its scheduler raises errors of several kinds, plain RuntimeErrors too: its status shows the loss.
    """
    return client.status in GONE or _is_of_cluster(error)


def _is_of_cluster(error: BaseException) -> bool:
    return type(error).__module__.startswith(("distributed", "asyncio", "concurrent"))
