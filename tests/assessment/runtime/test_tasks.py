"""Analyses on several processes."""

from __future__ import annotations

import operator
import os
import time
from pathlib import Path

from assessment.runtime.cache import Store, fingerprint
from assessment.runtime.tasks import From, Workers


def test_as_many_processes_as_asked_for(tmp_path):
    """The first analysis waits for another process to have begun one: the second process, however late it starts."""
    with Workers(jobs=2) as workers:
        tasks = [(str(tmp_path), 2)] * 6
        pids = workers.each("wait", _pid, tasks, [""] * 6, worthwhile=False)
    assert len({*pids} - {os.getpid()}) == 2
    with Workers(jobs=1) as workers:
        tasks = [(str(tmp_path), 1)] * 2
        assert workers.each("wait", _pid, tasks, ["", ""], worthwhile=False) == [os.getpid()] * 2


def _pid(folder: str, processes: int) -> int:
    Path(folder, str(os.getpid())).touch()
    while len(list(Path(folder).iterdir())) < processes:
        time.sleep(0.01)
    return os.getpid()


def test_an_argument_from_an_earlier_result(tmp_path):
    """Each begins when the one that it follows from is known; what was kept of them is not computed again.

    Taken over is what an earlier run kept: a first run told that it took over what it had computed itself.
    """
    tasks = [(1.0, 3.0), (From(0, _doubled), 4.0), (5.0, 5.0), (From(1, _doubled), 2.0)]
    sums = [4.0, 12.0, 10.0, 26.0]
    with Workers(jobs=2, store=Store(tmp_path)) as workers:
        assert workers.each("add", operator.add, tasks[:2], [""] * 2, False) == sums[:2]
        assert workers.each("add", operator.add, tasks, [""] * 4, False) == sums
        assert workers.each("add", operator.add, tasks, [""] * 4, False) == sums
        assert (workers.computed, workers.taken) == (4, 0)
    with Workers(jobs=2, store=Store(tmp_path)) as again:
        assert again.each("add", operator.add, tasks, [""] * 4, False) == sums
        assert (again.computed, again.taken) == (0, 4)
    first = Store(tmp_path)
    (first.folder / fingerprint(operator.add, tasks[0])).unlink()
    with Workers(
        jobs=2, store=first
    ) as again:  # what follows from it is as it was, and is not computed again
        assert again.each("add", operator.add, tasks, [""] * 4, False) == sums
        assert (again.computed, again.taken) == (1, 3)


def _doubled(result: float) -> float:
    return 2.0 * result
