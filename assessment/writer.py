"""A process that gets ready to write while others compute: what it imports takes as long as a good part of a run."""

from __future__ import annotations

import os
import signal
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, NoReturn, Self

from assessment.processes import belong_to_parent, dismiss


class Writer:
    """Writes results as `output.write` does; with more than one of `jobs` (0: one per core) in a process begun at once.

    `report`: whether HTML and PDF are asked for.
    """

    def __init__(self, report: bool, jobs: int = 0) -> None:
        self.report = report
        self.jobs = jobs or os.cpu_count() or 1
        self.pool = ProcessPoolExecutor(1, initializer=belong_to_parent) if self.jobs > 1 else None
        if self.pool is not None:
            self.pool.submit(_prepare, report)

    def write(self, results: Mapping[str, Any], folder: Path) -> list[str]:
        """Write the results and what is made of them; return warnings."""
        if self.pool is None:
            return _write(results, folder, self.report, self.jobs)
        return self.pool.submit(_write_until_told, results, folder, self.report, self.jobs).result()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self.pool is not None:
            dismiss(self.pool, at_once=kind is not None)


def _prepare(report: bool) -> None:
    from assessment.output import prepare

    prepare(report)


def _write(results: Mapping[str, Any], folder: Path, report: bool, jobs: int) -> list[str]:
    from assessment.output import write

    return write(results, folder, report, jobs)


def _write_until_told(results: Mapping[str, Any], folder: Path, report: bool, jobs: int) -> list[str]:
    """Write, and where the run is given up meanwhile leave nothing half made behind."""
    signal.signal(signal.SIGTERM, _stop)
    return _write(results, folder, report, jobs)


def _stop(*_: object) -> NoReturn:
    raise SystemExit
