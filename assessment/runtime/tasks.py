"""The analyses of a run, functions of their arguments alone: stored results are used, others computed and stored."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from itertools import repeat
from typing import TYPE_CHECKING, Any, Self, TypeVar, TypeVarTuple

from assessment.runtime.cache import Store, fingerprint, packed, returned, unpacked
from assessment.runtime.pool import Cluster, KilledError, Pool, finished, processes, tell
from assessment.runtime.progress import Show, Stage

if TYPE_CHECKING:
    from assessment.results.schema import Results

SMALL = 100  # joints times static analyses: below it a second process costs more than it saves
Arguments = TypeVarTuple("Arguments")
Result = TypeVar("Result")
Report = Callable[[float | None], None]


@dataclass(frozen=True)
class From:
    """An argument of a task that follows from the result of an earlier one, by its number: `read(result)`."""

    number: int
    read: Callable[[Any], Any]


@dataclass
class _Stage:
    """The tasks of a stage, each an application of `function`; the results `known` of them; how far it is, to `show`.

    `weights`: about how long each analysis that is not finished takes, by its number; `worked`: of those finished.
    """

    function: Callable[..., Any]
    tasks: Sequence[tuple[Any, ...]]
    titles: Sequence[str]
    show: Show
    weights: dict[int, float]
    stage: Stage
    known: dict[int, Any] = field(default_factory=dict)
    keys: dict[int, str] = field(default_factory=dict)
    worked: float = 0.0

    def ready(self, number: int) -> bool:
        return all(each.number in self.known for each in self.tasks[number] if isinstance(each, From))

    def task(self, number: int) -> tuple[Any, ...]:
        given = self.tasks[number]
        return tuple(each.read(self.known[each.number]) if isinstance(each, From) else each for each in given)

    def key(self, number: int) -> str:
        if number not in self.keys:
            self.keys[number] = fingerprint(self.function, self.task(number))
        return self.keys[number]

    def finish(self, number: int, result: Any) -> None:
        """Take over the result of an analysis, and tell that it is done, or why it could not be completed."""
        self.known[number] = result
        self.worked += self.weights.pop(number)
        self.stage.done += 1
        self.tell(number)
        self.look({})

    def tell(self, number: int) -> None:
        """Tell why an analysis could not be completed, if so."""
        result = self.known[number]
        parts = result if isinstance(result, list) else [result]
        if reasons := [text for part in parts for text in getattr(part, "failures", ())]:
            self.show.failed(self.stage, self.titles[number], reasons)

    def hear(self, number: int, share: float | None) -> None:
        self.look({number: share})

    def look(self, shares: Mapping[int, float | None]) -> None:
        """Tell the shares that are done of analyses at work; one that has just ended counts as a whole, and once."""
        at_work = sum(self.weights.get(number, 0.0) * (share or 0.0) for number, share in shares.items())
        self.stage.reach(self.worked + at_work)
        self.show.changed(self.stage)

    def name(self, begun: Iterable[int]) -> None:
        """Tell what has been `begun` first and is not finished: one large program reports no share for a minute."""
        number = next((each for each in begun if each in self.weights), None)
        if number is not None and self.titles[number] != self.stage.under_way:
            self.show.changed(self.stage, self.titles[number])


@dataclass(frozen=True)
class Outcome:
    """Results of a run, whether complete, counts of analyses computed and taken over, and what the terminal tells."""

    results: Results
    complete: bool
    computed: int
    taken: int
    told: str


@dataclass
class Workers:
    """How analyses are computed, and how many were."""

    jobs: int = 0  # processes, 0: one per core if worth it
    store: Store | None = None  # where results are kept and, unless `fresh`, looked for
    fresh: bool = False
    show: Show = field(default_factory=Show)
    computed: int = 0
    taken: int = 0  # from earlier runs; what this one `kept` itself and needs again does not count
    kept: set[str] = field(default_factory=set)
    scheduler: str | None = None  # address of a Dask cluster instead
    engine: Pool | None = None

    def each(
        self, stage: str, function: Callable[[*Arguments], Result], tasks: Sequence[tuple[*Arguments]],
        titles: Sequence[str], worthwhile: bool | None = None, weights: Sequence[float] = (),
    ) -> list[Result]:  # fmt: skip
        """Return function(*task) for every task, in their order; `weights`: about how long each takes, in any unit.

        `worthwhile`: whether they are work enough for processes of their own; None: as static analyses of their models.
        A task with an argument `From` an earlier one begins when that is known. Results pass through JSON, computed and
        stored ones: both are equal to the last bit. Raises KilledError where a process was ended from outside.
        """
        every = range(len(tasks))
        shares = dict(zip(every, weights or repeat(1.0), strict=False))
        at_hand = _Stage(function, tasks, titles, self.show, shares, Stage(stage, len(tasks), 0, 0.0))
        for number in filter(at_hand.ready, every):
            if self._took(at_hand, number):
                del at_hand.weights[number]
        if not tasks:
            return []
        at_hand.stage.taken, at_hand.stage.work = len(at_hand.known), sum(at_hand.weights.values())
        self.show.begin(at_hand.stage)
        for number in at_hand.known:
            at_hand.tell(number)
        try:
            kind = returned(function)
            for number, text in self._compute(at_hand, worthwhile):
                if self.store:
                    self.store.keep(key := at_hand.key(number), text)
                    self.kept.add(key)
                result = unpacked(text, kind)  # now, while other processes compute
                self.computed += 1
                at_hand.finish(number, result)
        except KilledError as error:
            raise KilledError(f"{stage}: {error}") from None
        self.show.end(at_hand.stage)
        return [at_hand.known[number] for number in every]

    def _took(self, stage: _Stage, number: int) -> bool:
        """Take over the stored result of a task that is ready; return whether there is one. It is looked for once."""
        if self.store is None or self.fresh or number in stage.keys:
            return False
        if text := self.store.find(key := stage.key(number)):
            with suppress(Exception):  # whatever another text than a result makes of it: it is absent
                found = unpacked(text, returned(stage.function))
                if packed(found) == text:  # else what is missing was filled in
                    stage.known[number] = found
                    self.taken += key not in self.kept
                    return True
        return False

    def _compute(self, stage: _Stage, worthwhile: bool | None) -> Iterator[tuple[int, str]]:
        """Yield number and packed result of each task that is left, long ones of another process: it can be stopped."""
        waiting = list(stage.weights)
        several = self.scheduler is not None or (len(waiting) > 1 and self.jobs > 1)
        if not waiting or not (several or (_large(stage.tasks) if worthwhile is None else worthwhile)):
            for number in waiting:
                if self._took(stage, number):
                    stage.finish(number, stage.known[number])
                    continue
                stage.name([number])
                yield (
                    number,
                    _packed(stage.function, stage.task(number), partial(stage.hear, number)),
                )
            return
        if self.engine is None:
            # existing objects are left out of later garbage collections: 0.1 s less each, here and in the processes
            gc.freeze()
            self.engine = Cluster(self.scheduler) if self.scheduler else Pool(processes(self.jobs))
        engine = self.engine
        futures: dict[Future[str], int] = {}

        def begin() -> None:
            while ready := [number for number in waiting if stage.ready(number)]:
                for number in ready:
                    waiting.remove(number)
                    if self._took(stage, number):
                        stage.finish(number, stage.known[number])
                        continue
                    task = engine.submit(_packed, stage.function, stage.task(number), partial(tell, number))
                    futures[task] = number

        def look() -> None:
            stage.name(futures.values())
            stage.look(engine.shares())

        begin()
        for number, text in finished(futures, look):
            yield number, text
            begin()  # what waited for this result, which is known now

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self.engine is not None:
            self.engine.close(at_once=kind is not None)
            gc.unfreeze()
            self.engine = None


def _large(tasks: Iterable[tuple[Any, ...]]) -> bool:
    """Return whether a static analysis of each model among the arguments is work enough for a process of its own."""
    from mechanics import Assembly  # late: a run in which nothing has changed needs no mechanics

    return sum(len(each.contacts) for task in tasks for each in task if isinstance(each, Assembly)) > SMALL


def _packed(function: Callable[..., Any], task: tuple[Any, ...], report: Report) -> str:
    """Compute a task; `report` receives the share that is done, at first 0, in the end None."""
    from mechanics.progress import listening  # late: as above

    try:
        report(0.0)
        with listening(report):
            return packed(function(*task))
    finally:
        report(None)
