"""Capacities that are refused, and what is said of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from assessment.analyses import capacity
from assessment.analyses.capacity import CONTRADICTION, assess, told
from assessment.analyses.demand import Demands
from assessment.project.model import build_model
from assessment.project.project import load_project
from tests.support.analysed import analysed, arch
from tests.support.block_project import ASSESSMENT, PUSHED, block, read_results, run, write_block
from tests.support.typed import typed
from tests.support.wording import in_italian

pytestmark = pytest.mark.usefixtures("no_figures")


@pytest.fixture(scope="module")
def capacities(tmp_path_factory):
    """What the assessment makes of the small arch pushed towards +x, its curves changed by a function."""
    folder: Path = arch(tmp_path_factory.mktemp("refused") / "arch")
    project = load_project(folder)
    model, demands = build_model(project).assembly, Demands()

    def of(change):
        pushovers = dict(typed(analysed()).states["original"].pushover)
        pushovers["+x"] = change(pushovers["+x"])
        found = assess(project, model, pushovers, demands)
        return capacity.capacities(found), told(found)

    return of


@pytest.mark.parametrize(("share", "refused"), [(0.9, False), (1.1, True)])
def test_a_mechanism_that_virtual_work_contradicts_has_no_capacity(capacities, share, refused):
    def contradict(curves):
        alpha = (1.0 + share * CONTRADICTION) * curves.rigid.mechanism.alpha
        return curves.replace(rigid=curves.rigid.replace(virtual_work_alpha=alpha))

    found, warnings = capacities(contradict)
    assert ("+x" in found) is not refused
    assert "-x" in found
    assert (
        any("+x: no capacity: virtual work on the mechanism gives α" in text for text in warnings) is refused
    )


def test_a_mechanism_on_which_the_horizontal_load_does_no_work_has_no_capacity(capacities):
    """Virtual work is then infinite, or 0/0: null in the results, and it contradicts every curve."""
    found, warnings = capacities(
        lambda curves: curves.replace(rigid=curves.rigid.replace(virtual_work_alpha=None))
    )
    assert "+x" not in found and "-x" in found
    assert any("+x: no capacity: virtual work on the mechanism gives α = inf" in text for text in warnings)


def test_an_elastic_pushover_that_failed_is_not_asked_for_again(capacities):
    found, warnings = capacities(lambda curves: curves.replace(elastic=None))
    assert "+x" not in found and "-x" in found
    [said] = [text for text in warnings if text.startswith("+x: no capacity")]
    assert "was asked for and gave no curve" in said and "ask for contacts" not in said
    assert "è stato richiesto" in in_italian(said)


@pytest.mark.parametrize("height", [4.2, 0.02])
def test_the_capacity_is_that_of_the_blocks_whatever_point_is_followed(height, tmp_path):
    """A panel turns about its toe: d* = ΣPδu/ΣPδ = 2.1 sin θ + 0.3 (1 − cos θ), which its centroid goes.

    A point at its other face, z high, goes by z sin θ + 0.6 (1 − cos θ), and Γ* = 2.1/z times that told up to forty
    times the way: from 0.02 m the panel bore several times the acceleration, or was refused, by a threshold of 80 %.
    """
    text = block().replace("point_m = [0.3, 4.2]", f"point_m = [-0.3, {height}]")
    folder = write_block(tmp_path, text + PUSHED.replace("0.2\n", "0.01\n") + ASSESSMENT)
    run(folder)
    state = read_results(folder / "output")["states"]["original"]
    rigid, capacity = state["pushover"]["+x"]["rigid"], state["capacity"]["+x"]
    lean = np.arctan(0.6 / 4.2)
    own = 2.1 * np.sin(lean) + 0.3 * (1.0 - np.cos(lean))
    assert rigid["d_0_m"] == pytest.approx(height * np.sin(lean) + 0.6 * (1.0 - np.cos(lean)), rel=1e-4)
    assert rigid["d_star_m"][-1] == pytest.approx(own, rel=1e-4)
    assert capacity["d_0_star_m"] == pytest.approx(own, rel=1e-4)
    assert capacity["gamma_star"] == pytest.approx(2.1 / height, rel=1e-4)
    assert capacity["SLV"]["d_star_m"] == pytest.approx(0.4 * own, rel=1e-4)


def test_the_elastic_curve_is_over_the_way_of_the_blocks_too(tmp_path):
    """Followed at the foot of the other face or at the top: the same capacity, T_0 and end of the elastic branch."""
    found = []
    for height in (4.2, 0.3):
        text = block().replace("point_m = [0.3, 4.2]", f"point_m = [-0.3, {height}]")
        pushed = PUSHED.replace('"rigid"', '"rigid", "elastic"').replace("0.2\n", f"{0.004 * height}\n")
        folder = write_block(
            tmp_path / str(height), text + pushed + ASSESSMENT.replace('"none"', '"trilinear"')
        )
        run(folder)
        found.append(read_results(folder / "output")["states"]["original"]["capacity"]["+x"])
    top, foot = found
    assert foot["SLV"]["a_g_g"] == pytest.approx(top["SLV"]["a_g_g"], rel=1e-3)
    assert foot["d_0_star_m"] == pytest.approx(top["d_0_star_m"], rel=1e-4)
