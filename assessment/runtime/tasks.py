"""The analyses of a run: taken over where nothing they depend on has changed, otherwise computed.

On several processes where that pays. An analysis is a function of its arguments alone; each is kept as soon as it is
finished, whatever becomes of the others.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, Self, TypeVar, TypeVarTuple

from assessment.runtime.cache import Store, packed, unpacked
from assessment.runtime.fingerprint import fingerprint
from assessment.runtime.pool import KilledError, Pool, finished, processes

if TYPE_CHECKING:
    from mechanics import Assembly

SMALL = 100  # joints times static analyses: below it a second process costs more than it saves
Arguments = TypeVarTuple("Arguments")
Result = TypeVar("Result")


class Show(Protocol):
    """What is told of the analyses under way."""

    def begin(self, stage: str, total: int, taken: int) -> None:
        """Tell that of `total` analyses of a stage all but `taken` are to be computed."""

    def under_way(self, title: str) -> None:
        """Tell which analysis is being computed."""

    def advance(self) -> None:
        """Tell that one more analysis of the stage is finished."""

    def end(self) -> None:
        """Tell that the stage is finished."""


class Silence:
    """Tells nothing."""

    def begin(self, stage: str, total: int, taken: int) -> None:
        """See Show."""

    def under_way(self, title: str) -> None:
        """See Show."""

    def advance(self) -> None:
        """See Show."""

    def end(self) -> None:
        """See Show."""


SILENCE = Silence()


@dataclass
class Workers:
    """How analyses are computed, and how many were.

    `jobs`: processes, 0: one per core if the work is worth starting them. `store`: where finished analyses are kept and
    looked for, None: nowhere; `fresh`: they are kept, but not looked for. `meanwhile`: what this process does, once,
    while others compute.
    """

    jobs: int = 0
    store: Store | None = None
    fresh: bool = False
    show: Show = SILENCE
    computed: int = 0
    taken: int = 0
    meanwhile: Callable[[], object] | None = None
    pool: Pool | None = None

    def each(
        self,
        stage: str,
        function: Callable[[*Arguments], Result],
        tasks: Sequence[tuple[*Arguments]],
        titles: Sequence[str],
        worthwhile: bool,
    ) -> list[Result]:
        """Return function(*task) for every task, in their order.

        What was computed goes the same way through JSON as what is taken over: both are equal to the last bit.
        Raises KilledError where a process was ended from outside.
        """
        keys = [fingerprint(function, task) for task in tasks] if self.store else []
        sought = () if self.fresh else enumerate(keys)
        known = {number: unpacked(text) for number, key in sought if (text := self._find(key))}
        unknown = [number for number in range(len(tasks)) if number not in known]
        self.taken += len(known)
        if not tasks:
            return []
        self.show.begin(stage, len(tasks), len(known))
        try:
            for number, text in self._compute(function, tasks, titles, unknown, worthwhile):
                if self.store:
                    self.store.keep(keys[number], text)
                known[number] = unpacked(text)  # now, while other processes are at work
                self.computed += 1
                self.show.advance()
        except KilledError as error:
            raise KilledError(f"{stage}: {error}") from None
        self.show.end()
        return [known[number] for number in range(len(tasks))]

    def _find(self, key: str) -> str | None:
        return self.store.find(key) if self.store else None

    def _compute(
        self,
        function: Callable[[*Arguments], Result],
        tasks: Sequence[tuple[*Arguments]],
        titles: Sequence[str],
        numbers: Sequence[int],
        worthwhile: bool,
    ) -> Iterator[tuple[int, str]]:
        """Yield the number of each task and its packed result, as they are finished.

        Long work is left to another process even where there is one task: a solver in C hears no interruption.
        """
        if not numbers or not (worthwhile or (self.jobs > 1 and len(numbers) > 1)):
            for number in numbers:
                self.show.under_way(titles[number])
                yield number, _packed(function, tasks[number])
            return
        pool = self._pool()
        begun = {pool.submit(_packed, function, tasks[number]): number for number in numbers}
        if self.meanwhile is not None:
            self.meanwhile()
            self.meanwhile = None
        yield from finished(begun)

    def _pool(self) -> Pool:
        """Return the processes, started when first needed and kept for the stages to come."""
        if self.pool is None:
            gc.freeze()  # nor need it be looked through for garbage, here or there: a tenth of a second each time
            self.pool = Pool(processes(self.jobs))
        return self.pool

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self.pool is not None:
            self.pool.close(at_once=kind is not None)
            gc.unfreeze()
            self.pool = None


def large(*models: Assembly) -> bool:
    """Return whether a static analysis of each model is work enough for a process of its own."""
    return sum(len(model.contacts) for model in models) > SMALL


def _packed(function: Callable[..., Any], task: tuple[Any, ...]) -> str:
    return packed(function(*task))
