"""A thousand histories of a campaign: what is held while they run, and what is left of them.

Motions are made up, everything around them is the program's.
"""

import math
import tracemalloc
import weakref
from types import SimpleNamespace

import numpy as np
import pytest

from assessment.analyses import scan
from assessment.analyses.time_history import ENERGIES, Response
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.results.schema import as_bytes
from assessment.results.schema.part import plain
from assessment.runtime import tasks
from assessment.runtime.cache import FOLDER, Store
from assessment.workflow.stages import run
from tests.support.block_project import ASSESSMENT, PROJECT, write_block

RECORDS, SAMPLES = 10, 2000
TABLE = """[campaign]
records = ["made*.csv"]
shares = [0.0, 0.25, 0.5, 0.75, 1.0]
contacts = "rigid"
tolerance = 0.05
"""
MEGABYTE = 1e6


@pytest.fixture
def project(tmp_path):
    folder = write_block(tmp_path / "block", "scatter = 5\n" + PROJECT + TABLE + ASSESSMENT)
    random, time = np.random.default_rng(1), 0.01 * np.arange(SAMPLES)
    for number in range(RECORDS):
        noise = 0.3 * np.sin(math.pi * time / time[-1]) * random.uniform(-1.0, 1.0, SAMPLES)
        np.savetxt(folder / f"made{number:02}.csv", np.column_stack([time, noise]), "%.6f", ",")
    return load_project(folder)


class MadeUp:
    """In the place of `respond`: collapses above a level that the record and the state tell, as large as a real one."""

    def __init__(self):
        self.count, self.most, self.alive = 0, 0, weakref.WeakSet()

    def __call__(self, shaking, factor, **__):
        model, motion, start = shaking.model, shaking.motion, shaking.start
        own = int(motion.name[4:])
        tilt = abs(start.positions[:, 2]).max()
        record = motion.record
        sign = np.sign(record.acceleration[round(0.07 / record.time_step)])  # the same at any time step
        capacity = (0.4 - 5.0 * tilt) * math.exp(0.3 * math.sin(own + sign))
        strength = factor * motion.pga / capacity
        found = Response(
            0.01 * np.arange(SAMPLES),
            strength**8 * np.sin(np.arange(SAMPLES) * (1.0 + 10.0 * strength)),  # as what rocks, near collapse alone
            np.ones((SAMPLES, len(model.blocks), 3)),
            np.ones((SAMPLES, len(model.contacts), 3)),
            (
                SimpleNamespace(
                    collapsed=strength > 1.0, collapse_reason="it fell", worst=1e-12, notes=(), steps=SAMPLES,
                    skipped=0, lifting=0, programs=SAMPLES, iterations=SAMPLES, halvings=0,
                    model=model,
                    energy=SimpleNamespace(**dict.fromkeys((*ENERGIES, "dissipated"), np.zeros(2))),
                ),
            ),
        )  # fmt: skip
        self.count += 1
        if not tracemalloc.is_tracing():
            tracemalloc.start()
        self.alive.add(found)
        self.most = max(self.most, len(self.alive))
        return found


def test_of_a_thousand_histories_numbers_are_left_and_no_curves(project, tmp_path, monkeypatch):
    """One column of their curves alone would be 20 MB. Measured: results of 0.66 MB."""
    made, store = MadeUp(), Store(tmp_path / FOLDER)
    monkeypatch.setattr(scan, "respond", made)
    monkeypatch.setattr(tasks, "processes", lambda _: 0)  # all in this process
    try:
        outcome = run(project, build_model(project), jobs=1, store=store)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    campaign = plain(outcome.results)["campaign"]
    counted = sum(row["runs"] for row in campaign["combinations"])
    # three scans are run with half the step too
    assert 1_200 <= counted <= made.count <= 1.05 * counted
    assert len(campaign["combinations"]) == campaign["computed"] == 10 * RECORDS
    assert all(row["pga_collapse_g"] for row in campaign["combinations"])
    assert made.most == 1  # whole motion at a time
    assert peak < 30 * MEGABYTE
    assert len(as_bytes(outcome.results)) < 0.8 * MEGABYTE
    assert sum(entry.stat().st_size for entry in store.folder.iterdir()) < 0.8 * MEGABYTE
