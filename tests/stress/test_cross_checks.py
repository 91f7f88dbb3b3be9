"""Solvers of different kinds against each other on random assemblies, and random paths (paper, eqs 2–5).

Of each 200 with ASSESTO_STRESS=long.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from mechanics.errors import ControlError, NoEquilibriumError, UnstableError
from tests.mechanics.procedures.test_statics_properties import random_path
from tests.mechanics.solvers.test_program import same_elastic_step, same_multiplier, same_time_step
from tests.stress.beds import counted, same_peak
from tests.stress.corpus import assemblies
from tests.stress.test_stress import LONG

COUNT = 200 if LONG else 24


def test_multipliers():
    """Rigid, by PIQP, HiGHS and the method of our own."""
    for number, model in assemblies(COUNT):
        same_multiplier(model, number)


def test_elastic_steps():
    """By PIQP and the method of our own."""
    for number, model in assemblies(COUNT, segments=5):
        same_elastic_step(model, number)


@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
def test_time_steps(behaviour):
    rng = np.random.default_rng(12)
    for number, model in assemblies(COUNT, segments=4):
        same_time_step(model, behaviour, number, rng.uniform(-1.0, 1.0))


@pytest.mark.parametrize("seed", range(COUNT))
def test_random_paths_keep_within_friction(seed):
    random_path(seed, ("rigid", "elastic")[seed % 2])


def test_exact_beds_need_no_points():
    """A path in a hundred at most is not solved, and a step in a hundred has to be tried again in shorter ones."""
    found = Counter[str]()
    for _, model in assemblies(12):
        found += counted(model)
    assert found["paths"] == 36
    assert found["not solved"] <= 0.01 * found["paths"]
    assert found["attempts failed"] <= 0.01 * found["steps"]


def test_peaks_of_points_lie_above_those_of_the_exact_bed():
    """By little, and where joints do not slide: 32 segments are stiffer by 2/32² in rotation."""
    over = []
    for _, model in assemblies(12):
        try:
            over.append(same_peak(model))
        except (ControlError, NoEquilibriumError, UnstableError):
            continue
    assert np.median(over) < 0.02 and min(over) > -0.01
