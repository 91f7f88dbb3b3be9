"""Scenarios side by side and the sensitivity of the capacity: against closed forms, invariants, and by themselves."""

import math
from pathlib import Path

import numpy as np
import pytest

from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.report.figures.curves import draw_scenarios
from assessment.report.language import words_of
from assessment.results.schema.part import plain
from assessment.results.schema.studies import SensitivityRun
from assessment.studies.variants import scatter, with_factor, without_effect
from assessment.workflow.stages import run
from mechanics import limit_analysis
from tests.support import block_project
from tests.support.block_project import block, outcome_of, write_block
from tests.support.typed import made

WIDTH, HEIGHT = 0.6, 4.2
SLENDERNESS = math.atan(WIDTH / HEIGHT)
FAST = 'scatter = 1\naccuracy = "fast"\n'
BLOCK = block(stiffness="2e4")
TURNS = """
[[settlements]]
name = "turned"
support = "base"
rotation_rad = -0.04
increment_rad = 0.01
steps = 4
[[settlements]]
name = "turned back"
support = "base"
rotation_rad = 0.02
increment_rad = 0.01
"""
PUSHOVER = """
[pushover]
contacts = ["rigid"]
increment_m = 0.1
control = {"+x" = "right", "-x" = "left"}
"""
ASSESSMENT = block_project.ASSESSMENT.replace('"SLV"', '"SLV", "SLC"')
# SLD looks at the elastic branch: S_e(T_0) = a_y*.
ELASTIC = PUSHOVER.replace('"rigid"', '"rigid", "elastic"').replace("0.1", "0.02")
ELASTIC += block_project.ASSESSMENT.replace(
    'limit_states = ["SLV"]\nmodel = "none"', 'limit_states = ["SLD"]'
)


@pytest.fixture
def project(tmp_path: Path):
    """Write a project of one block on a base and load it; one folder for all its variants."""
    return lambda text: load_project(write_block(tmp_path, FAST + text))


def results_of(project, jobs: int = 1) -> dict:
    outcome = run(project, build_model(project), jobs)
    return plain(outcome.results) | {"complete": outcome.complete}


def test_a_sweep_follows_the_closed_form(project):
    """A base turned by θ leaves tan(arctan(B/H) ∓ θ): the block leans the way it turns."""
    found = results_of(project(BLOCK + TURNS + PUSHOVER))["scenarios"]
    assert found["quantity"] == "alpha_0" and found["limit_state"] is None
    points = found["points"]
    assert [p["share"] for p in points if p["state"] == "turned" and p["direction"] == "+x"] == [
        0.25, 0.5, 0.75, 1,
    ]  # fmt: skip
    for point in points:
        turn = {"original": 0.0, "turned": 0.04, "turned back": -0.02}[point["state"]] * point["share"]
        lean = turn if point["direction"] == "+x" else -turn
        assert point["alpha_0"] == pytest.approx(math.tan(SLENDERNESS - lean), rel=1e-6)
        assert point["reduction"] == pytest.approx(1 - point["alpha_0"] / math.tan(SLENDERNESS), abs=1e-6)
        assert point["movement_m"] == pytest.approx(abs(turn) * math.hypot(0.6, 0.15), abs=1e-12)
    assert (found["worst"]["state"], found["worst"]["direction"], found["worst"]["share"]) == (
        "turned",
        "+x",
        1,
    )


def test_a_movement_that_follows_another_is_drawn_from_where_that_ends(project):
    """It was drawn from the capacity as drawn: of a movement there and back the figure showed no loss."""
    asked = project(BLOCK + TURNS.replace('"turned back"', '"turned back"\nafter = "turned"') + PUSHOVER)
    found = outcome_of(asked).results
    lines = draw_scenarios(found, words_of(found)).axes[0].get_lines()
    way = 1000.0 * math.hypot(0.6, 0.15)
    ends = [line.get_xdata()[[0, -1]] for line in lines if str(line.get_label()).startswith("turned back, ")]
    assert np.array(ends) == pytest.approx(way * np.array([[0.04, 0.06]] * 2))


def test_a_point_of_a_sweep_is_a_scenario_of_its_own(project):
    swept = results_of(project(BLOCK + TURNS + PUSHOVER + ASSESSMENT))["scenarios"]["points"]
    half = TURNS.replace("-0.04", "-0.02").replace("steps = 4", "")
    alone = results_of(project(BLOCK + half + PUSHOVER + ASSESSMENT))
    halves = [point for point in swept if point["state"] == "turned" and point["share"] == 0.5]
    assert len(halves) == 2
    for point in halves:
        state = alone["states"]["turned"]
        rigid, check = (
            state["pushover"][point["direction"]]["rigid"],
            state["capacity"][point["direction"]]["SLC"],
        )
        assert point["alpha_0"] == rigid["alpha_0"] and point["d_0_m"] == rigid["d_0_m"]
        assert point["a_g_g"] == check["a_g_g"] and point["zeta_E"] == check["zeta_E"]
        assert not point["collapses"]


def test_a_sweep_past_the_collapse_names_where_it_falls(project):
    """The block overturns at θ = arctan(B/H) = 0.142 rad: of 0.05, 0.10, 0.15 and 0.20 rad it stands the first two."""
    turned = TURNS.replace("-0.04", "-0.20").replace('"turned back"', '"turned on"')
    results = results_of(project(BLOCK + turned + PUSHOVER))
    right = [p for p in results["scenarios"]["points"] if p["state"] == "turned" and p["direction"] == "+x"]
    assert [point["collapses"] for point in right] == [False, False, True, True]
    assert [point["alpha_0"] is None for point in right] == [False, False, True, True]
    found = results["scenarios"]["worst"]
    assert found["collapses"] and found["share"] == 0.75
    assert not results["complete"]
    assert any(text.startswith("part 3 of 4: turned, rigid") for text in results["quality"]["warnings"])


def test_a_property_that_lets_the_structure_fall_is_a_result_that_is_missing(project):
    """On a base turned by 0.04 rad, μ = 0.035 does not hold the block, with 0.7 it stands."""
    text = BLOCK + TURNS.replace("steps = 4", "") + PUSHOVER + ASSESSMENT
    results = results_of(project(text + '[sensitivity]\nfriction = [0.05, 1.0]\nstates = ["turned"]\n'))
    runs = {(run["factor"], run["direction"]): run for run in results["sensitivity"]["runs"]}
    for direction in ("+x", "-x"):
        assert runs[0.05, direction]["collapses"] and runs[0.05, direction]["a_g_g"] is None
        base = results["states"]["turned"]["capacity"][direction]["SLC"]["a_g_g"]
        assert runs[1.0, direction]["a_g_g"] == base and not runs[1.0, direction]["collapses"]
    assert not results["complete"]
    assert any(text.startswith("friction × 0.05: turned, rigid") for text in results["quality"]["warnings"])


SENSITIVITY = """
[sensitivity]
friction = [0.5, 1.5]
stiffness = [0.5, 2.0]
unit_weight = [0.5, 2.0]
depth = [0.5, 2.0]
states = ["original"]
"""


@pytest.fixture(scope="module")
def varied(tmp_path_factory):
    """Runs of the sensitivity of one elastic block by property, factor and direction; and all results."""
    folder = write_block(tmp_path_factory.mktemp("varied"), FAST + BLOCK + ELASTIC + SENSITIVITY)
    results = results_of(load_project(folder))
    runs = {(r["property"], r["factor"], r["direction"]): r for r in results["sensitivity"]["runs"]}
    assert len(runs) == len(results["sensitivity"]["runs"]) == 16
    return results, runs


def test_friction_governs_where_it_is_low(project, varied):
    """μ = 0.07 < B/H: the block slides, α0 = μ; from 0.35 up it turns, α0 = B/H."""
    low = build_model(with_factor(project(BLOCK), "friction", 0.1)).assembly
    _, runs = varied
    for direction in ("+x", "-x"):
        assert limit_analysis(low, direction).alpha == pytest.approx(0.07, rel=1e-7)
        for factor in (0.5, 1.5):
            assert runs["friction", factor, direction]["alpha_0"] == pytest.approx(WIDTH / HEIGHT, rel=1e-6)


def test_depth_alone_changes_nothing(varied):
    results, runs = varied
    for direction in ("+x", "-x"):
        base = results["states"]["original"]["capacity"][direction]["SLD"]["a_g_g"]
        for factor in (0.5, 2.0):
            assert runs["depth", factor, direction]["a_g_g"] == pytest.approx(base, rel=1e-6)


def test_weight_counts_as_the_inverse_of_stiffness(varied):
    """All forces by λ, weights and elastic, leave accelerations as they are: only weight/stiffness matters."""
    _, runs = varied
    for direction in ("+x", "-x"):
        for factor in (0.5, 2.0):
            light, stiff = runs["unit_weight", factor, direction], runs["stiffness", 1 / factor, direction]
            for key in ("a_g_g", "alpha_u"):
                assert light[key] == pytest.approx(stiff[key], rel=1e-6)
    soft, hard = (runs["stiffness", factor, "+x"]["alpha_u"] for factor in (0.5, 2.0))
    assert soft < 0.999 * hard


def test_what_has_no_effect(project):
    loaded = BLOCK.replace("[layers.BASE]", "[layers.BLOCK]\nvertical_load_kN = 5.0\n[layers.BASE]")
    assert without_effect(project(BLOCK + PUSHOVER)) == {"depth", "unit_weight"}
    assert without_effect(project(BLOCK + ELASTIC)) == {"depth"}
    assert without_effect(project(loaded + PUSHOVER)) == set()


def test_scatter_is_told_where_a_capacity_depends_on_what_it_cannot(varied):
    def at(name, capacity):
        found = {"state": "settled", "direction": "+x", "property": name, "a_g_g": capacity}
        return made(SensitivityRun, found)

    assert scatter([at("depth", 0.2), at("depth", 0.2009), at("friction", 0.1)], {"depth"}) == []
    (found,) = scatter([at("depth", 0.2), at("unit_weight", 0.25)], {"depth", "unit_weight"})
    assert found.startswith("sensitivity, settled, +x: a_g scatters by 20 % with unit weight and depth")
    (found,) = scatter([at("depth", 0.2), at("depth", None)], {"depth", "unit_weight"})
    assert "by 100 % with depth," in found
    assert scatter([at("depth", None), at("depth", None)], {"depth"}) == []
    results, _ = varied
    assert not any("scatters" in text for text in results["quality"]["warnings"])


def test_a_factor_reaches_every_place_where_a_property_is_given(project):
    layers = '[layers.TOP]\nfriction = 0.5\ndepth_m = 2.0\nvertical_load_kN = 3.0\n[layers.BASE]\nsupport = "base"\n'
    base = project(BLOCK.replace('[layers.BASE]\nsupport = "base"\n', layers))
    double = {key: with_factor(base, key, 2.0) for key in ("friction", "stiffness", "unit_weight", "depth")}
    assert double["friction"].material.friction == 1.4 and double["friction"].layers["TOP"].friction == 1.0
    assert (
        double["friction"].layers["BASE"] == base.layers["BASE"]
        and double["friction"].geometry == base.geometry
    )
    assert double["depth"].geometry.depth_m == 2.0 and double["depth"].layers["TOP"].depth_m == 4.0
    assert double["depth"].layers["TOP"].vertical_load_kN == 3.0
    assert double["unit_weight"].material.unit_weight_kN_m3 == 36.0
    stiff = double["stiffness"].material
    assert stiff.normal_stiffness_kN_m3 == 4e4 and stiff.tangential_stiffness_kN_m3 == math.inf
