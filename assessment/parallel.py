"""Independent tasks of an analysis, one after another or on several processes, their results in order."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TypeVar, TypeVarTuple

SMALL = 2000  # contact points times static analyses: below it a second process costs more than it saves
Arguments = TypeVarTuple("Arguments")
Result = TypeVar("Result")


def spread(
    function: Callable[[*Arguments], Result],
    tasks: Sequence[tuple[*Arguments]],
    jobs: int,
    worthwhile: bool,
    announce: Callable[[int], None],
) -> Iterator[Result]:
    """Yield function(*task) for every task, in their order.

    `jobs`: processes, 0: one per core if the work is `worthwhile` enough to start them. `announce` is called with the
    number of each task before it is begun or waited for.
    """
    processes = jobs or ((os.cpu_count() or 1) if worthwhile else 1)
    if min(processes, len(tasks)) <= 1:
        for number, task in enumerate(tasks):
            announce(number)
            yield function(*task)
        return
    with ProcessPoolExecutor(min(processes, len(tasks))) as pool:
        futures = [pool.submit(function, *task) for task in tasks]
        for number, future in enumerate(futures):
            announce(number)
            yield future.result()
