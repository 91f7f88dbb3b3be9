"""The chapter of a campaign, its tables and figures: from hand-made results, in both languages."""

import copy
import math
from xml.etree import ElementTree

import numpy as np
import pytest

from assessment.report.chapters.judgement import draft_judgement
from assessment.report.chapters.synthesis import lead
from assessment.report.document import render_html
from assessment.report.figures.motions import draw_ida
from assessment.report.language import plain_text, words_of
from assessment.report.tables.dynamic import fragility_model, shaken, static_dynamic
from tests.support.judgement.claims import hold
from tests.support.pictured import draw_sections
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed

SHARES = (0.0, 0.5, 1.0)
LEVELS = {"a": 0.30, "b": 0.36, "c": 0.45}  # g: at which each record collapses the structure as drawn


def combination(record: str, share: float, sign: int) -> dict:
    collapse = LEVELS[record] * (1.0 - 0.3 * share) * (1.0 if sign > 0 else 1.1)
    stood = [
        {"pga_g": part * collapse, "peak_displacement_m": 0.02 * part, "members": 1,
         "residual_displacement_m": 0.0, "peak_displacement_m_range": [0.02 * part, 0.02 * part]}
        for part in (0.5, 0.95)
    ]  # fmt: skip
    fell = {
        "pga_g": collapse,
        "collapsed": True,
        "members": 1,
        "members_collapsed": 1,
        "time_of_collapse_s": 3.0,
    }
    return {
        "record": record, "settlement": SETTLED, "share": share, "sign": sign, "runs": 3, "points": [*stood, fell],
        "pga_collapse_g": collapse, "pga_collapse_range": [collapse, 1.1 * collapse], "pga_safe_g": 0.95 * collapse,
        "lowest_collapse_g": collapse, "level_16_g": collapse, "level_50_g": collapse, "level_84_g": collapse,
        "beta": 0.0, "widest_gap_g": [0.95 * collapse, collapse], "time_step_s": 0.01, "resurrections_g": [],
    }  # fmt: skip


def fit(share: float, own: list[dict]) -> dict:
    """A fragility of hand-made levels: mean and root mean square of their logarithms."""
    logs = np.log([row["pga_collapse_g"] for row in own])
    median, beta = float(np.exp(logs.mean())), float(logs.std())
    return {
        "settlement": SETTLED, "share": share, "movement_m": 0.02 * share, "combinations": len(own),
        "median_g": median, "median_range": [0.9 * median, 1.1 * median], "beta": beta,
        "beta_range": [0.5 * beta, 1.5 * beta], "beta_record": beta, "beta_ensemble": 0.0, "rule": "lowest",
        "level_16_g": median * math.exp(-beta), "level_84_g": median * math.exp(beta),
        "pga_collapse_g": min(row["pga_collapse_g"] for row in own),
    }  # fmt: skip


def lost(share: float) -> dict:
    """The loss of hand-made levels, 30 % of each at the whole movement."""
    dynamic = 0.3 * share
    return {
        "settlement": SETTLED, "share": share, "movement_m": 0.02 * share, "dynamic": dynamic,
        "dynamic_range": [dynamic, dynamic], "distinguishable": True if share else None,
        "static": 0.2 * share, "static_capacity": 0.5 - 0.1 * share,
    }  # fmt: skip


def results_with_campaign(language: str = "it") -> dict:
    """Results with a campaign of three records, both signs, three shares; each β is that of its levels."""
    rows = [combination(record, share, sign) for share in SHARES for record in LEVELS for sign in (1, -1)]
    return results_example(language) | {
        "campaign": {
            "measure": "PGA", "method": "incremental", "tolerance": 0.05, "contacts": "rigid", "members": 5,
            "static_quantity": "a_g_g", "combinations": rows, "computed": len(rows),
            "fragility": [fit(share, [row for row in rows if row["share"] == share]) for share in SHARES],
            "loss": [lost(share) for share in SHARES],
            "records": [{"record": name, "record_pga_g": 0.3, "scale": 1.0, "duration_s": 25.0, "time_step_s": 0.01}
                        for name in LEVELS],
        }
    }  # fmt: skip


def said(results, sentences=lead):
    """What the first page says of a campaign, or the judgement, as plain text."""
    found = typed(results)
    return " ".join(map(plain_text, sentences(found, words_of(found)))).replace("\u00a0", " ")


def test_each_record_and_sign_has_its_curve_to_the_highest_level_withstood_and_an_arrow_at_collapse():
    results = results_with_campaign()
    results["campaign"]["combinations"][0]["points"].insert(3, results["campaign"]["combinations"][0]["points"][1] | {
        "pga_g": 0.35})  # fmt: skip
    results["campaign"]["combinations"][0]["resurrections_g"] = [0.35]
    results["campaign"]["fragility"][2]["d_0_m"] = 0.0418
    figure = draw_ida(typed(results), words_of(typed(results)), shaken(typed(results)))
    panels = [axes for axes in figure.axes if axes.axison and axes.get_title()]
    assert len(panels) == len(SHARES)
    for axes, share, fit in zip(panels, SHARES, results["campaign"]["fragility"], strict=True):
        assert axes.get_title() == (f"{100.0 * share:g}\u00a0% del cedimento" if share else "originale")
        own = [row for row in results["campaign"]["combinations"] if row["share"] == share]
        curves = [line for line in axes.lines if line.get_xdata()[0] == 0.0 and line.get_ydata()[0] == 0.0]
        assert [line.get_ydata()[-1] for line in curves] == pytest.approx([row["pga_safe_g"] for row in own])
        assert [line.get_xdata()[-1] for line in curves] == pytest.approx([19.0] * len(own))  # mm
        looks = [(line.get_color(), line.get_marker(), line.get_linestyle()) for line in curves]
        assert len(set(looks)) == len(own) and len({look[:2] for look in looks}) == len(LEVELS)
        arrows = sorted(text.xy for text in axes.texts if text.arrow_patch)
        assert [y for _, y in arrows] == pytest.approx(sorted(row["lowest_collapse_g"] for row in own))
        assert {x for x, _ in arrows} == {axes.get_xlim()[1]}
        flat = [line.get_ydata()[0] for line in axes.lines if list(line.get_xdata()) == [0.0, 1.0]]
        probable = [fit[key] for key in ("level_16_g", "median_g", "level_84_g")]
        assert flat == pytest.approx([fit["pga_collapse_g"], *probable])
        again = [line for line in axes.lines if line.get_markerfacecolor() == "1.0"]
        assert [list(line.get_ydata()) for line in again] == ([[0.35]] if share == 0.0 else [])
    [beside] = [axes for axes in figure.axes if axes.axison and not axes.get_title()]
    assert beside.get_xlim()[1] == pytest.approx(1e-3 * panels[2].get_xlim()[1] / 0.0418)


@pytest.mark.parametrize("method", ["incremental", "stripes"])
def test_the_chapter_shows_tables_figures_and_what_was_not_completed(method, tmp_path):
    results = copy.deepcopy(results_with_campaign("it"))
    campaign = results["campaign"]
    campaign |= {"failures": ["a reason"]}
    if method == "stripes":
        campaign |= {"method": method, "levels_g": [0.2, 0.4]}
        for row in campaign["combinations"]:
            fallen = [row["pga_collapse_g"] <= level for level in (0.2, 0.4)]
            row |= {"collapsed": fallen}
        for row in campaign["fragility"]:
            row |= {"rule": None, "pga_collapse_g": None}
    words = words_of(typed(results))
    draw_sections(typed(results), tmp_path, "campaign")
    html = render_html(typed(results), tmp_path, words)
    start = html.index(f"<h3>{words('section.campaign')}")
    text = html[start : html.index("<h2", start + 4)]
    assert text.count("<figure ") == 2 and text.count("<caption>") == 4
    assert words("section.campaign") in text and words("text.campaign_failures", count=1) in text
    assert words(f"text.campaign_loss_{method}") in text.replace("\xa0", " ")
    assert ("§7.3.5" in text) == (method == "incremental")
    assert words("text.campaign_static_a_g_g", limit="SLC") in text and words("text.campaign_pga") in text


@pytest.mark.parametrize(("static", "key"), [(None, "alone"), (0.1, "beside"), (-0.1, "opposed")])
def test_the_judgement_sets_the_loss_beside_the_static_one_and_remarks_opposite_signs(static, key):
    """Neither a collapse under a record nor what a campaign gave was told in the judgement."""
    results = results_with_campaign("en")
    for row in results["campaign"]["loss"]:
        row["static"] = static
    assert f"campaign_{key}" in hold(results)
    # one sign of the records gains too; medians are of both, and a loss without a word on it contradicts them
    for row in results["campaign"]["loss"]:
        row["directions"] = {"+x": row["dynamic"], "-x": -0.1}
    held = hold(results)
    assert "campaign_opposed" not in held and "one_sign" in held
    assert "that of one sign of the records, +x" in said(results)


def test_a_loss_of_fewer_than_three_records_has_no_bounds_of_95_per_cent():
    results = results_with_campaign("en")
    assert "with 95 % between" in said(results)
    for row in results["campaign"]["loss"]:
        row |= {"records": 2, "distinguishable": None, "static": -0.1}
    assert "of fewer than three records" in said(results) and "95 %" not in said(results)
    assert "campaign_beside" in hold(results)


def test_the_judgement_tells_which_states_a_record_makes_collapse():
    results = results_example("en")
    common = {"record": "wave", "pga_g": 0.3, "reason": None}
    stands = common | {"collapsed": False, "peak_displacement_m": 0.058}
    falls = common | {"collapsed": True, "peak_displacement_m": 0.2, "time_of_collapse_s": 5.32}
    results["states"]["original"]["history"] = [falls]
    results["states"][SETTLED]["history"] = [stands]
    assert {"history_collapse", "history_stands"} <= set(hold(results))
    results["states"]["original"]["history"] = [stands]
    assert "history_peak" in hold(results)


def test_a_loss_that_is_not_distinguishable_from_none_is_said_to_be_so():
    results = results_with_campaign("en")
    assert "not distinguishable" not in said(results, draft_judgement)
    for row in results["campaign"]["loss"]:
        row |= {"distinguishable": False, "dynamic_range": [-0.02, 0.05]}
    assert "campaign_indistinct" in hold(results)


def test_static_check_incremental_analysis_and_campaign_stand_on_one_reference():
    """A reader found a gain of 2 % beside a loss of 17 %: each loss has its bounds, and says if it is one."""
    results = results_with_campaign()
    loss = next(row for row in results["campaign"]["loss"] if row["share"] == 1.0)
    loss |= {"dynamic": 0.02, "dynamic_range": [-0.05, 0.1], "distinguishable": False}
    rows = static_dynamic(typed(results)).rows
    settled = {row["analysis"]: row for row in rows if row["state"] == SETTLED}
    told = settled["campaign"]
    assert (told["capacity_loss"], told["dynamic_loss_low"], told["distinguishable"]) == (0.02, -0.05, False)
    assert told["level_50_g"] == pytest.approx(results["campaign"]["fragility"][-1]["median_g"])
    assert {row["analysis"] for row in rows if row["state"] == "original"} >= {"campaign"}
    assert all("capacity_loss" not in row for row in rows if row["state"] == "original")
    assert "non è distinguibile" in said(results)


def test_fragilities_are_a_fragility_model_of_mean_and_standard_deviation():
    """OpenQuake takes those of the measure: they give median and β back."""
    results = typed(results_with_campaign("en"))
    found = ElementTree.fromstring(fragility_model(results)).findall(".//{*}fragilityFunction")
    rows = [row for row in results.campaign.fragility if row.median_g and row.beta]
    assert len(found) >= len(rows) > 0
    for function, row in zip(found[-len(rows) :], rows, strict=True):
        params = function.find("{*}params")
        mean, deviation = float(params.get("mean")), float(params.get("stddev"))
        beta = math.sqrt(math.log1p((deviation / mean) ** 2))
        assert beta == pytest.approx(row.beta, rel=1e-4)
        assert mean * math.exp(-0.5 * beta**2) == pytest.approx(row.median_g, rel=1e-4)
        assert function.find("{*}imls").get("imt") == "PGA"


def test_identifiers_of_fragilities_are_ascii_and_differ_and_wide_ones_are_left_out():
    """OpenQuake refuses other letters and equal identifiers; at β = 49 the mean is beyond all floats."""
    content = results_with_campaign("en")
    rows = content["campaign"]["fragility"]
    names = ["metà", "met_", "met ", "wide " * 20]
    content["campaign"]["fragility"] = [rows[-1] | {"settlement": name} for name in names]
    content["campaign"]["fragility"].append(rows[-1] | {"settlement": "wide", "beta": 49.0})
    content["campaign"]["loss"] = content["campaign"]["loss"][-1:] * 5
    found = ElementTree.fromstring(fragility_model(typed(content))).findall(".//{*}fragilityFunction")
    ids = [each.get("id") for each in found]
    assert not any(each.endswith("_wide_1") for each in ids) and len(set(ids)) == len(ids) >= len(names)
    assert all(each.isascii() and len(each) <= 60 for each in ids)


def test_without_fragilities_there_is_no_fragility_model():
    assert fragility_model(typed(results_example())) is None
