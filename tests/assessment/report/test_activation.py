"""Every place that shows the activation of a mechanism shows the same one, in settled states and ensembles too.

α0 is the largest multiplier, of an ensemble the least of its runs. Mechanism, e*, Γ*, reactions, thrust and hand check
are of one point of the curve that is reported, which is printed with its α where that is not α0.
"""

import numpy as np
import pytest

from assessment.report.chapters.remarks import onsets
from assessment.report.document import tables
from assessment.report.figures.curves import draw_pushover
from assessment.report.figures.deformed import draw_thrust
from assessment.report.language import direction_name, words_of
from assessment.report.viewer import viewer
from assessment.results.hand_check import hand_checks
from assessment.results.joint_states import situations
from assessment.results.table import sense
from tests.support.analysed import SETTLED, analysed
from tests.support.typed import typed

CORNERS = 1e-6  # what moving corners by 1e-7 of a block, as runs of an ensemble do, may change
CASES = [(state, direction) for state in ("original", SETTLED) for direction in ("+x", "-x")]
each_case = pytest.mark.parametrize(("state", "direction"), CASES)


@pytest.fixture(scope="module")
def results():
    return typed(analysed())


@pytest.fixture(scope="module")
def rows(results):
    return {table.name: table.rows for table in tables(results)}


def push(results, state, direction):
    return results.states[state].pushover[direction].rigid


def of(rows, state, direction):
    return [row for row in rows if (row["state"], row["direction"]) == (state, direction)]


def test_the_example_has_runs_whose_multipliers_differ(results):
    """Without one the tests below would show nothing of ensembles."""
    found = [push(results, *case) for case in CASES]
    assert any(each.members for each in found)
    assert any(each.alpha_0_range and each.alpha_0_range[0] < each.alpha_0_range[1] for each in found)
    assert any(each.onset and each.onset.e_star != each.mechanism.e_star for each in found)
    assert any(each.alpha_onset < 0.9 * each.alpha_0 for each in found), "a hinge of the settlement closes"


@each_case
def test_tables_and_summaries_have_one_multiplier(results, rows, state, direction):
    """Of a run with an ensemble the linear checks and the list of mechanisms had that of another run."""
    rigid = push(results, state, direction)
    shown = {
        "results": rigid.alpha_0,
        "curve": max(rigid.curve.multiplier),
        "mechanism": rigid.mechanism.alpha,
    }
    for name in ("mechanisms", "all_mechanisms"):
        shown |= {
            f"{name} {number}": row["alpha_0"] for number, row in enumerate(of(rows[name], state, direction))
        }
    found = [row for row in results.summary.rows if (row.state, row.direction) == (state, direction)]
    [shown["results' summary"]] = [row.alpha_0 for row in found]
    [shown["summary"]] = [row["alpha_0"] for row in of(rows["summary"], state, direction)]
    for row in of(rows["static_ranges"], state, direction):
        if row["quantity"] == "alpha_0":
            shown["ranges"] = row["value"]
    assert shown == pytest.approx(dict.fromkeys(shown, rigid.alpha_0), rel=1e-12)


@each_case
def test_linear_checks_are_of_what_is_activated_first(results, rows, state, direction):
    """C8.7.1.2: they were of α0, which is reached only once hinges of the settlement have closed, above the onset.

    The sentence on the curve says the number of the table.
    """
    rigid = push(results, state, direction)
    shown = {
        f"{name} {number}": row["alpha_onset"]
        for name in ("linear_checks", "all_mechanisms")
        for number, row in enumerate(of(rows[name], state, direction))
    }
    [vertical] = of(rows["vertical"], state, direction)
    [factor] = [
        line.inputs["lambda_v"]
        for line in results.states[state].capacity[direction].vertical.trace
        if line.symbol == "alpha_0_v"
    ]
    shown |= {"vertical component": vertical["alpha_0"] / factor, "curve": rigid.curve.multiplier[0]}
    assert shown == pytest.approx(dict.fromkeys(shown, rigid.alpha_onset), rel=1e-12)
    e_star = rigid.onset.e_star if rigid.onset else rigid.mechanism.e_star
    for row in of(rows["linear_checks"], state, direction):
        assert row["e_star"] == pytest.approx(e_star, rel=CORNERS)
    words = words_of(results)
    for sentence in onsets(results, words):
        if f"“{words.state(state)}”, direction {direction_name(direction)}" in sentence:
            assert f"first motion at α = {words.show(rigid.alpha_onset)};" in sentence


@each_case
def test_all_that_is_of_the_mechanism_is_of_the_point_that_is_printed(results, rows, state, direction):
    rigid, words = push(results, state, direction), words_of(results)
    [row] = of(rows["mechanisms"], state, direction)
    printed = row.get("mechanism_alpha", row["alpha_0"])
    shown = {
        "mechanism": rigid.mechanism.alpha,
        "curve": rigid.curve.multiplier[rigid.mechanism.point],
        "peak": max(rigid.curve.multiplier),
    }
    for name in ("reactions", "balance"):
        for number, each in enumerate(of(rows[name], state, direction)):
            if each["contacts"] == "rigid":
                shown[f"{name} {number}"] = each["alpha"]
    [check] = [each for each in hand_checks(results) if (each.state, each.direction) == (state, direction)]
    shown["hand check"] = check.alpha_mechanism
    [at] = [each for each in situations(results) if (each.state, each.direction) == (state, direction)]
    shown["joints"] = at.alpha
    assert shown == pytest.approx(dict.fromkeys(shown, printed), rel=1e-12)
    assert check.virtual_work_alpha == pytest.approx(printed, rel=1e-6)
    assert check.hand_alpha == pytest.approx(printed, rel=2e-3), "figures as printed"
    assert np.array(rigid.mechanism_configuration) == pytest.approx(at.configuration, abs=6e-7), "rounded"
    [axes, *_] = draw_thrust(results, words, [at]).axes
    assert axes.get_title().endswith(f"α = {words.show(printed)}")


def test_figures_mark_the_multiplier_of_the_tables(results):
    """The mark stood at the peak of the run that is reported, beside the number of another one."""
    words = words_of(results)
    figure = draw_pushover(results, words, ["-x"])
    marks = [line.get_xydata()[0] for line in figure.axes[0].lines if line.get_marker() == "o"]
    states = [state for state, way in CASES if way == "-x"]
    assert len(marks) == len(states)
    for state, (_, alpha) in zip(states, marks, strict=True):
        expected = push(results, state, "-x").alpha_0
        assert alpha == pytest.approx(expected, rel=1e-12)


def test_the_page_to_step_through_has_the_curves_of_the_tables(results):
    text = viewer(results, words_of(results))
    for state, direction in CASES:
        rigid = push(results, state, direction)
        along = 1000.0 * sense(direction) * abs(rigid.curve.displacement_m[rigid.mechanism.point])
        assert f"{along:.6g}" in text and f"{rigid.mechanism.alpha:.6g}" in text
