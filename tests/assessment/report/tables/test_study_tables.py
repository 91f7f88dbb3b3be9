"""Tables, figures and chapters of scenarios and sensitivity: from hand-made results, in both languages."""

import pytest
from markupsafe import Markup

from assessment.report.chapters.judgement import draft_judgement
from assessment.report.document import render_html
from assessment.report.language import joined, words_of
from assessment.report.tables.studies import scenarios, tornado
from tests.support.pictured import draw_sections
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed

CAPACITY = {"original": (1.0, 1.1), SETTLED: (0.8, 0.6)}  # a_g at SLC towards +x and −x, g
FACTORS = {  # property: factor: what becomes of both capacities
    "friction": {0.8: 0.95, 1.2: 1.0},
    "stiffness": {0.5: 0.7, 2.0: 1.2},
    "depth": {0.9: 1.0, 1.1: 1.0},
    "unit_weight": {0.9: None, 1.1: 0.9},
}


def point(state: str, share: float, direction: str, capacity: float | None) -> dict:
    return {
        "state": state, "share": share, "movement_m": 0.02 * share, "direction": direction,
        "collapses": False, "alpha_0": 0.1, "d_0_m": 0.2, "a_g_g": capacity,
        "zeta_E": None if capacity is None else capacity / 0.334,
        "reduction": None if capacity is None else 0.25,
    }  # fmt: skip


def results_with_studies(language: str = "it") -> dict:
    """Results with a sweep in two steps and a sensitivity of every property."""
    results = results_example(language)
    sides = ("+x", "-x")
    for state, values in CAPACITY.items():
        for direction, value in zip(sides, values, strict=True):
            results["states"][state]["capacity"][direction]["SLC"]["a_g_g"] = value
    points = [point("original", 0.0, d, a) for d, a in zip(sides, CAPACITY["original"], strict=True)]
    points += [point(SETTLED, 0.5, "+x", 0.9), point(SETTLED, 0.5, "-x", 0.7)]
    points += [point(SETTLED, 1.0, d, a) for d, a in zip(sides, CAPACITY[SETTLED], strict=True)]
    results["scenarios"] = {"quantity": "a_g_g", "limit_state": "SLC", "points": points, "worst": points[-1]}
    runs = [
        {"state": state, "property": name, "factor": factor, "direction": direction, "collapses": False}
        | {"alpha_0": 0.1, "d_0_m": 0.2, "a_g_g": share and share * value, "zeta_E": 1.0}
        for state, values in CAPACITY.items()
        for name, shares in FACTORS.items()
        for factor, share in shares.items()
        for direction, value in zip(sides, values, strict=True)
    ]
    results["sensitivity"] = {"limit_state": "SLC", "runs": runs}
    return results


def test_the_tornado_takes_the_weaker_direction_and_the_widest_swing_first():
    rows = {(row["state"], row["property"]): row for row in tornado(typed(results_with_studies())).rows}
    assert [name for state, name in rows if state == SETTLED] == [
        "unit_weight", "stiffness", "friction", "depth",
    ]  # fmt: skip
    row = rows[SETTLED, "stiffness"]
    assert (row["low_factor"], row["high_factor"]) == (0.5, 2.0)
    assert row["a_g_low_g"] == pytest.approx(0.42) and row["a_g_high_g"] == pytest.approx(0.72)
    assert row["a_g_base_g"] == 0.6 and row["swing_g"] == pytest.approx(0.30)
    assert rows["original", "stiffness"]["a_g_base_g"] == 1.0
    # low and as given, the high one being equal
    assert rows[SETTLED, "friction"]["swing_g"] == pytest.approx(0.03)


def test_what_was_not_reached_has_no_swing():
    results = results_with_studies()
    row = next(row for row in tornado(typed(results)).rows if row["property"] == "unit_weight")
    assert row["a_g_low_g"] is None and row["swing_g"] is None and row["a_g_high_g"] == pytest.approx(0.9)
    results["sensitivity"]["runs"][0]["a_g_g"] = None  # one direction of two: the weaker one is not known
    row = next(row for row in tornado(typed(results)).rows if row["property"] == "friction")
    assert row["a_g_low_g"] is None


def test_scenarios_have_the_worst_marked_and_the_ultimate_movement_where_it_was_sought():
    results = results_with_studies()
    rows = scenarios(typed(results)).rows
    assert [row["worst"] for row in rows] == [False] * 5 + [True]
    ultimate = results["states"][SETTLED]["pushdown"]["rigid"]["ultimate_movement_m"]
    assert [row.get("ultimate_rigid_m") for row in rows] == [None] * 4 + [ultimate] * 2
    assert "ultimate_rigid_m" not in rows[0] and rows[0]["limit_state"] == "SLC"
    results["echo"]["settlements"][0]["to_collapse"] = False
    assert not any("ultimate_rigid_m" in row for row in scenarios(typed(results)).rows)


@pytest.mark.parametrize("fallen", [False, True])
def test_chapters_name_the_worst_case_and_show_tables_and_figures(fallen, tmp_path):
    results = results_with_studies("it")
    if fallen:
        last = results["scenarios"]["points"][-1]
        last |= {"collapses": True, "alpha_0": None, "a_g_g": None, "zeta_E": None, "reduction": None}
    words = words_of(typed(results))
    draw_sections(typed(results), tmp_path, "scenarios", "sensitivity")
    html = render_html(typed(results), tmp_path, words)
    for chapter in ("scenarios", "sensitivity"):
        start = html.index(f"<h3>{words(f'section.{chapter}')}</h3>")
        text = html[start : html.index("<h", start + 4)]
        assert text.count("<figure") == 1 and text.count("<caption>") == 1
        assert words(f"section.{chapter}") in text
    key, rock = "collapses" if fallen else "a_g_g", words.plain("value.stated_on_rock")
    sentence = words(f"judgement.worst_{key}", state=SETTLED, movement=0.02, direction="−x",
                     capacity=0.6, limit="SLC", reference=rock, among="")  # fmt: skip
    if not fallen:
        sentence += Markup(" ") + words("judgement.worst_reduction", reduction=0.25)
    assert joined(sentence) in html and sentence in draft_judgement(typed(results), words)
    widest = words("judgement.sensitive", property=words.plain("value.stiffness"), state=words.state("original"),
                   low=0.5, high=2.0, least=0.7, most=1.2, limit="SLC", reference=rock)  # fmt: skip
    assert widest in draft_judgement(typed(results), words)
