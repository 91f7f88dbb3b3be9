"""Analyses on several processes, and how they are kept: every bit, under a name that tells what they depend on."""

import operator
import os
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from assessment.analyses.found import Found
from assessment.analyses.paths import Settled, settle
from assessment.results.schema.model import QualityRow
from assessment.runtime.cache import Store, fingerprint, packed, unpacked
from assessment.runtime.tasks import From, Workers
from assessment.workflow.stages import run
from mechanics import State
from mechanics.messages import message
from tests.support.structures import block_on_base
from tests.support.typed import made


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


def test_what_was_not_used_for_longest_goes_first(tmp_path):
    store = Store(tmp_path)
    for key in ("a", "b", "c"):
        store.keep(key, key * 1000)
        os.utime(tmp_path / key, (1.0, 1.0 + ord(key)))
    (tmp_path / ".d.123.tmp").write_text("half-written", encoding="utf-8")
    assert store.find("a") == "a" * 1000  # used now
    store.prune(2500)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "c"]


def test_results_keep_every_bit():
    state = State(
        np.array([[0.1, 1 / 3, 1e-300]]), np.zeros((1, 3)), np.zeros(0), np.array([[3.0, 7.0, 0.1]]),
        np.array([True, False]),
    )  # fmt: skip
    odd = message("{text}", text="w «é»\r\n")
    row = made(QualityRow, {"solves": 3, "worst_complementarity": 1 / 7})
    part = Found(
        Settled({"a": (0.1, None, np.float64(1 / 7), np.int64(3))}, state),
        quality=[row],
        warnings=[odd],
        seconds=0.3,
    )
    found = unpacked(packed(part), Found[Any])
    assert found.value["path"] == {"a": [0.1, None, 1 / 7, 3]}
    reached = unpacked(packed(state), State)
    assert reached.positions.tobytes() == state.positions.tobytes()
    assert (reached.velocities.shape, reached.shear.shape) == ((1, 3), (0,))
    assert reached.met.tobytes() == state.met.tobytes()
    assert reached.carrying.tolist() == [True, False]
    assert (found.quality, found.warnings, found.failures, found.seconds) == ([row], [odd], [], 0.3)
    assert packed(found) == packed(part)


def test_fingerprints_tell_every_content_and_type_apart():
    model, other = block_on_base(0.6, 4.2), block_on_base(0.6, 4.3)
    values = [1, 1.0, True, "1", None, [1], [[1]], {"1": 1}, [], {}, 0.0, -0.0, float("inf"), float("nan")]
    values += [np.zeros(2), np.ones(2), np.zeros((2, 1)), np.zeros(2, dtype=int), model, other, model.initial]
    assert len({fingerprint(settle, (value,)) for value in values}) == len(values)
    assert fingerprint(settle, (model, 1)) == fingerprint(settle, (block_on_base(0.6, 4.2), 1))
    assert fingerprint(settle, (model,)) != fingerprint(run, (model,))
    _ = model.contacts  # what is derived from the content changes nothing
    assert fingerprint(settle, (model,)) == fingerprint(settle, (block_on_base(0.6, 4.2),))
    with pytest.raises(TypeError, match="no fingerprint"):
        fingerprint(settle, (object(),))
