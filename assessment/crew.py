"""Processes that all hold the results of a run: what is made of them is made side by side."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ProcessPoolExecutor
from typing import Any, Self, TypeVar, TypeVarTuple

from assessment.processes import belong_to_parent, dismiss

Results = Mapping[str, Any]
Arguments = TypeVarTuple("Arguments")
Product = TypeVar("Product")
_held: list[Results] = []  # in a process of the crew: the results


class Crew:
    """Does work on the results, in `jobs` processes (0: one per core) or, with 1, at once in this one."""

    def __init__(self, results: Results, jobs: int = 1) -> None:
        self.results = results
        self.jobs = jobs or os.cpu_count() or 1
        self.pool: ProcessPoolExecutor | None = None

    def do(
        self, function: Callable[[Results, *Arguments], Product], *arguments: *Arguments
    ) -> Future[Product]:
        """Begin function(results, *arguments); what it returns, or raises, is the future's."""
        if self.jobs == 1:
            done: Future[Product] = Future()
            done.set_result(function(self.results, *arguments))
            return done
        if self.pool is None:
            self.pool = ProcessPoolExecutor(self.jobs, initializer=_take_up, initargs=(self.results,))
        return self.pool.submit(_work, function, arguments)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self.pool is not None:
            dismiss(self.pool, at_once=kind is not None)


def _take_up(results: Results) -> None:
    belong_to_parent()
    _held[:] = [results]


def _work(function: Callable[..., Product], arguments: tuple[Any, ...]) -> Product:
    return function(_held[0], *arguments)
