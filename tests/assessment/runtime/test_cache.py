"""How analyses are kept: every bit of them, under a name that tells what they depend on."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import pytest

from assessment.analyses.found import Found
from assessment.analyses.paths import Settled, settle
from assessment.results.schema.model import QualityRow
from assessment.runtime.cache import Store, packed, unpacked
from assessment.runtime.cache import fingerprint as digest
from assessment.workflow.stages import run
from mechanics import State
from mechanics.messages import message
from tests.support.structures import block_on_base
from tests.support.typed import made


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
        np.array([[0.1, 1 / 3, 1e-300]]),
        np.zeros((1, 3)),
        np.zeros(0),
        np.array([[3.0, 7.0, 0.1]]),
        np.array([True, False]),
    )
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
    assert len({digest(settle, (value,)) for value in values}) == len(values)
    assert digest(settle, (model, 1)) == digest(settle, (block_on_base(0.6, 4.2), 1))
    assert digest(settle, (model,)) != digest(run, (model,))
    _ = model.contacts  # what is derived from the content changes nothing
    assert digest(settle, (model,)) == digest(settle, (block_on_base(0.6, 4.2),))
    with pytest.raises(TypeError, match="no fingerprint"):
        digest(settle, (object(),))
