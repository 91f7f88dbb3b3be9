"""The analyses of a run: stored results are used if nothing they depend on has changed, others are computed.

Several processes are used where that is faster. An analysis is a function of its arguments alone; its result is stored
as soon as it is finished, even if others fail.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol, Self, TypeVar, TypeVarTuple

from assessment.runtime.cache import Store, packed, returned, unpacked
from assessment.runtime.fingerprint import fingerprint
from assessment.runtime.processes.pool import KilledError, Pool, finished, processes
from assessment.runtime.progress import SILENCE, Show

if TYPE_CHECKING:
    from assessment.results.schema import Results
    from mechanics import Assembly

SMALL = 100  # joints times static analyses: below it a second process costs more than it saves
Arguments = TypeVarTuple("Arguments")
Result = TypeVar("Result")


@dataclass(frozen=True)
class From:
    """An argument of a task that follows from the result of an earlier one, by its number: `read(result)`."""

    number: int
    read: Callable[[Any], Any]


class Engine(Protocol):
    """Computes outside this process: in processes of this machine, or on a cluster."""

    def submit(self, function: Callable[[*Arguments], Result], *arguments: *Arguments) -> Future[Result]:
        """Start function(*arguments); its future raises KilledError if the process was ended from outside."""

    def teller(self, number: int) -> Callable[[float | None], None]:
        """Return what reports the share that is done of the analysis of that number where it is computed.

        None: it has ended.
        """

    def shares(self) -> Mapping[int, float]:
        """Return the share that is done of the analyses at work, by their numbers."""

    def close(self, at_once: bool) -> None:
        """End it; `at_once`: without finishing its work, after an error."""


@dataclass
class _Work:
    """What is to be computed in a stage: the weight of each analysis by its number; how much is done, for `show`.

    `titles`: what the analyses are called; `at_work`: numbers of those that other processes are at, as begun.
    """

    weights: dict[int, float]
    titles: Sequence[str]
    show: Show
    done: float = 0.0
    at_work: list[int] = field(default_factory=list)
    shares: dict[int, float] = field(default_factory=dict)
    looked: float = field(default_factory=time.monotonic)

    def __post_init__(self) -> None:
        self.total = sum(self.weights.values())

    def finish(self, number: int) -> None:
        """Count an analysis as finished, and report the work done."""
        self.done += self.weights.pop(number)
        self.show.advance(self._reached())

    def hear(self, number: int, share: float | None) -> None:
        """Take over the share that is done of an analysis in this process; reported at the `interval` of `show`."""
        if share and time.monotonic() - self.looked >= self.show.interval:
            self.looked = time.monotonic()
            self.look({number: share})

    def look_elsewhere(self, shares: Mapping[int, float]) -> None:
        """Report the shares that other processes tell; of what they are at, that which they have been at for longest.

        One large program may take a minute in which no share changes: what it is shows that the run is alive.
        """
        before = self.at_work[:1]
        went_on = [number for number in self.at_work if number in shares]
        self.at_work = went_on + [
            number for number in shares if number not in went_on and number in self.weights
        ]
        if self.at_work and self.at_work[:1] != before:
            self.show.under_way(self.titles[self.at_work[0]])
        self.look(shares)

    def look(self, shares: Mapping[int, float]) -> None:
        """Report the shares that are done of the analyses at work."""
        self.shares = dict(shares)
        if (reached := self._reached()) > 0.0:
            self.show.reached(reached)

    def _reached(self) -> float:
        """Work that is done; an analysis that has just ended counts as a whole, and once."""
        at_work = (self.weights.get(number, 0.0) * share for number, share in self.shares.items())
        return self.done + sum(at_work)


@dataclass(frozen=True, eq=False)
class _Plan:
    """The tasks of a stage, each an application of `function`, and the results that are `known` of them so far.

    `keys`: their fingerprints, as far as they were asked for.
    """

    function: Callable[..., Any]
    tasks: Sequence[tuple[Any, ...]]
    known: Mapping[int, Any]
    keys: dict[int, str] = field(default_factory=dict)

    def ready(self, number: int) -> bool:
        """Whether all results are known that the arguments of a task follow from."""
        return all(each.number in self.known for each in self.tasks[number] if isinstance(each, From))

    def task(self, number: int) -> tuple[Any, ...]:
        """Return the arguments of a task that is ready."""
        return tuple(
            each.read(self.known[each.number]) if isinstance(each, From) else each
            for each in self.tasks[number]
        )

    def key(self, number: int) -> str:
        """Return the fingerprint of a task that is ready."""
        if number not in self.keys:
            self.keys[number] = fingerprint(self.function, self.task(number))
        return self.keys[number]


@dataclass(frozen=True)
class Outcome:
    """The outcome of a run: its results, whether every requested analysis was completed, and how many were computed.

    `computed`: number of analyses of this run; `taken`: number of stored results of earlier runs that were used, as
    their inputs have not changed.
    """

    results: Results
    complete: bool
    computed: int
    taken: int


@dataclass
class Workers:
    """How analyses are computed, and how many were.

    `jobs`: processes, 0: one per core if the work is worth starting them; `scheduler`: address of a Dask cluster that
    computes in their place. `store`: where finished analyses are kept and
    looked for, None: nowhere; `fresh`: they are kept, but not looked for. `meanwhile`: what this process does, once,
    while others compute. `computed`, and `taken` over from what earlier runs `kept`: what this one computed and needs
    again is neither.
    """

    jobs: int = 0
    store: Store | None = None
    fresh: bool = False
    show: Show = SILENCE
    computed: int = 0
    taken: int = 0
    kept: set[str] = field(default_factory=set)
    meanwhile: Callable[[], object] | None = None
    scheduler: str | None = None
    engine: Engine | None = None

    def each(
        self,
        stage: str,
        function: Callable[[*Arguments], Result],
        tasks: Sequence[tuple[*Arguments]],
        titles: Sequence[str],
        worthwhile: bool,
        weights: Sequence[float] = (),
    ) -> list[Result]:
        """Return function(*task) for every task, in their order; `weights`: about how long each takes, in any unit.

        An argument that is `From` an earlier task is what its result gives: the task begins when that is known.
        Computed results pass through JSON as stored ones do, so that both are equal to the last bit.
        Raises KilledError where a process was ended from outside.
        """
        known: dict[int, Result] = {}
        plan, kind = _Plan(function, tasks, known), returned(function)
        if self.store and not self.fresh:
            for number in range(len(tasks)):
                if plan.ready(number) and (text := self.store.find(key := plan.key(number))):
                    with suppress(Exception):  # whatever another text than a result makes of it: it is absent
                        known[number] = unpacked(text, kind)
                        self.taken += key not in self.kept
        unknown = [number for number in range(len(tasks)) if number not in known]
        if not tasks:
            return []
        known_weights = {number: weights[number] if weights else 1.0 for number in unknown}
        work = _Work(known_weights, titles, self.show)
        self.show.begin(stage, len(tasks), len(known), work.total)
        for number, result in known.items():
            self._tell(titles[number], result)
        try:
            for number, text in self._compute(plan, titles, unknown, worthwhile, work):
                if self.store:
                    self.store.keep(key := plan.key(number), text)
                    self.kept.add(key)
                known[number] = unpacked(text, kind)  # now, while other processes compute
                self.computed += 1
                work.finish(number)
                self._tell(titles[number], known[number])
        except KilledError as error:
            raise KilledError(f"{stage}: {error}") from None
        self.show.end()
        return [known[number] for number in range(len(tasks))]

    def _tell(self, title: str, result: Any) -> None:
        parts = result if isinstance(result, list) else [result]
        if reasons := [text for part in parts for text in getattr(part, "failures", ())]:
            self.show.fault(title, reasons)

    def _compute(
        self,
        plan: _Plan,
        titles: Sequence[str],
        numbers: Sequence[int],
        worthwhile: bool,
        work: _Work,
    ) -> Iterator[tuple[int, str]]:
        """Yield the number of each task and its packed result, as they are finished.

        Long work runs in another process even if there is one task: a solver in C does not react to an interruption.
        """
        several = len(numbers) > 1 and (self.jobs > 1 or self.scheduler is not None)
        if not numbers or not (worthwhile or several):
            for number in numbers:
                self.show.under_way(titles[number])
                yield number, _packed(plan.function, plan.task(number), partial(work.hear, number))
            return
        engine, waiting = self._engine(), list(numbers)
        futures: dict[Future[str], int] = {}

        def begin() -> None:
            for number in filter(plan.ready, tuple(waiting)):
                waiting.remove(number)
                task = engine.submit(_packed, plan.function, plan.task(number), engine.teller(number))
                futures[task] = number

        begin()
        if self.meanwhile is not None:
            self.meanwhile()
            self.meanwhile = None
        for number, text in finished(futures, lambda: work.look_elsewhere(engine.shares())):
            yield number, text
            begin()  # what waited for this result, which is known now

    def _engine(self) -> Engine:
        """Return the processes, or the cluster; started at first use and kept for later stages."""
        if self.engine is None:
            # existing objects are left out of later garbage collections: 0.1 s less each, here and in the processes
            gc.freeze()
            self.engine = _cluster(self.scheduler) if self.scheduler else Pool(processes(self.jobs))
        return self.engine

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self.engine is not None:
            self.engine.close(at_once=kind is not None)
            gc.unfreeze()
            self.engine = None


def _cluster(address: str) -> Engine:
    from assessment.runtime.processes.cluster import Cluster  # late: few runs have one

    return Cluster(address)


def large(*models: Assembly) -> bool:
    """Return whether a static analysis of each model is work enough for a process of its own."""
    return sum(len(model.contacts) for model in models) > SMALL


def _packed(
    function: Callable[..., Any], task: tuple[Any, ...], report: Callable[[float | None], None]
) -> str:
    """Compute a task; `report` receives the share that is done, at first 0, in the end None."""
    from mechanics.progress import listening  # late: a run in which nothing has changed needs no mechanics

    try:
        report(0.0)
        with listening(report):
            return packed(function(*task))
    finally:
        report(None)
