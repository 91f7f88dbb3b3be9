"""The arch with a chain (projects/chained_arch): the multipliers of its README, and the tension that they need.

The tension where α0 is reached is compared with limit analysis of a chain that yields: with a yield force a little
above it α0 is that of an unbreakable chain, a tenth below it α0 is less.
"""

from dataclasses import replace

import pytest

from assessment.project.model import build_model
from assessment.project.project import load_project
from mechanics import limit_analysis
from tests import ROOT
from tests.support.block_project import outcome_of


@pytest.fixture(scope="module")
def project():
    whole = load_project(ROOT / "projects" / "chained_arch")
    assert whole.pushover is not None
    rigid = whole.pushover.model_copy(update={"contacts": ("rigid",), "increment_m": 0.05})
    alone = {"scatter": 1, "accuracy": "fast"}
    return whole.model_copy(update={"pushover": rigid, "assessment": None, **alone})


@pytest.fixture(scope="module")
def results(project):
    return outcome_of(project).results


README = {  # α0 towards +x and −x
    "original": (0.127, 0.127),
    "appoggio destro 80 mm": (0.121, 0.117),
    "con catena": (0.212, 0.212),
}


@pytest.mark.parametrize("state", README)
def test_the_multipliers_of_the_readme(results, state):
    for direction, expected in zip(("+x", "-x"), README[state], strict=True):
        found = results.states[state].pushover[direction].rigid
        assert found.alpha_0 == pytest.approx(expected, abs=1e-3)
        assert abs(found.second_solver.relative_difference) < 1e-6


def test_the_tension_is_that_which_the_mechanism_needs(project):
    """As drawn, rigid: α0 is that of an unbreakable chain from the tension on, and less below it."""
    model = build_model(project).states["con catena"].assembly
    [chain] = model.ties

    def alpha(yield_force: float) -> float:
        return limit_analysis(model.tied([replace(chain, yield_force=yield_force)]), "+x").alpha

    limit = limit_analysis(model, "+x")
    tension = float(limit.forces[len(model.joints.a), 0])
    assert 10.0 < tension < 30.0
    assert alpha(1.001 * tension) == pytest.approx(limit.alpha, rel=1e-6)
    assert alpha(0.9 * tension) < 0.999 * limit.alpha
