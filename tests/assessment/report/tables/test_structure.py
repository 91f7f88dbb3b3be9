"""Cracks against the geometry of one rotation, and the drawing whose numbers they are read with; layers."""

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.text import Text

from assessment.report.chapters.remarks import cracks as crack_sentences
from assessment.report.chapters.remarks import survey as survey_sentences
from assessment.report.figures import deformed
from assessment.report.figures.deformed import draw_cracks
from assessment.report.language import words_of
from assessment.report.tables.structure import PRINTED, SEEN, cracks, layers, survey_table
from mechanics.pictures import STYLE
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed


def with_motion(block, motion):
    results = results_example("en")
    configuration = np.zeros((len(results["geometry"]["blocks"]), 3))
    configuration[block] = motion
    results["states"][SETTLED]["configuration"] = configuration.tolist()
    return results


def about(results, joint, end, turn):
    """The motion of a joint's second block that turns about one end of the joint."""
    known = results["geometry"]["joints"][joint]
    block = known["blocks"][1]
    arm = np.array(results["geometry"]["blocks"][block]["centroid_m"]) - known["ends_m"][end]
    spin = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    return block, [*(spin @ arm - arm), turn]


@pytest.mark.parametrize("end", [0, 1])
def test_a_joint_opens_by_its_length_times_the_rotation(end):
    """2 sin(θ/2) L at the far end, nothing at the hinge; the point is that of the far end."""
    known = results_example()["geometry"]["joints"][0]
    length = float(np.hypot(*np.subtract(*known["ends_m"])))
    tried = [with_motion(*about(results_example(), 0, end, turn)) for turn in (0.01, -0.01)]
    rows = [
        next((r for r in cracks(typed(each)).rows if r["joint"] == 0 and r["opening_m"] > 0), None)
        for each in tried
    ]
    [row] = [row for row in rows if row and row["opening_m"] > 0.005 * length]  # the other sense penetrates
    assert row["opening_m"] == pytest.approx(0.01 * length, rel=0.02)
    assert row["other_opening_m"] == pytest.approx(0.0, abs=1e-4 * length)
    assert row["slip_m"] == pytest.approx(0.0, abs=0.006 * length)
    assert [row["x_m"], row["z_m"]] == pytest.approx(known["ends_m"][1 - end], abs=0.02 * length)


def test_what_is_too_small_to_be_seen_is_left_out():
    block, motion = about(results_example(), 0, 0, 1e-9)
    assert cracks(typed(with_motion(block, motion))).rows == []
    along = np.subtract(*results_example()["geometry"]["joints"][0]["ends_m"])
    slip = 2.0 * SEEN * along / np.hypot(*along)
    rows = [row for row in cracks(typed(with_motion(block, [*slip, 0.0]))).rows if row["joint"] == 0]
    assert rows[0]["slip_m"] == pytest.approx(2.0 * SEEN, rel=1e-6)


def test_every_joint_of_the_table_is_numbered_in_the_drawing():
    results = with_motion(*about(results_example(), 0, 0, 0.05))
    with mpl.rc_context(STYLE):
        [axes] = draw_cracks(typed(results), words_of(typed(results)), SETTLED, 40).axes
    said = {text.get_text() for text in axes.texts}
    assert said >= {f"G{row['joint']}" for row in cracks(typed(results)).rows}


def test_no_number_of_a_joint_covers_another(monkeypatch):
    results = typed(with_motion(*about(results_example(), 0, 0, 0.05)))
    [crack, *_] = deformed.cracks_of(results, SETTLED)
    monkeypatch.setattr(deformed, "cracks_of", lambda *_: [crack] * 4)
    with mpl.rc_context(STYLE):
        [axes] = draw_cracks(results, words_of(results), SETTLED, 10).axes
    assert len({text.xy for text in axes.texts if text.get_text().startswith("G")}) == 4


def test_of_cracks_that_is_told_which_there_is(monkeypatch):
    """ "The 40 widest joints are printed" stood over a table of three; "not reached" without such a row."""
    block, _ = about(results_example(), 0, 0, 0.05)
    results = typed(with_motion(block, [0.003, 0.01, 0.0]))
    words = words_of(results)
    assert len(cracks(results).rows) > 1 and len(list(crack_sentences(results, words))) == 1
    with monkeypatch.context() as patch:
        patch.setitem(PRINTED, "short", 1)
        assert "are printed and numbered" in " ".join(crack_sentences(results, words))
    along = np.subtract(*results_example()["geometry"]["joints"][0]["ends_m"])
    apart = typed(with_motion(block, [*(2.0 * along), 0.0]))
    assert any(row["opening_m"] is None for row in cracks(apart).rows)
    assert "slid off" in " ".join(crack_sentences(apart, words))


def test_surveyed_cracks_stand_beside_those_of_the_nearest_joint():
    """Along the joint that opens, through a block, and a width that was measured; each drawn with its mark."""
    block, motion = about(results_example(), 0, 0, 0.01)
    back = about(results_example(), 0, 0, -0.01)[1]
    opening = [with_motion(block, each) for each in (motion, back)]
    found = next(each for each in opening if any(row["joint"] == 0 for row in cracks(typed(each)).rows))
    [row] = [row for row in cracks(typed(found)).rows if row["joint"] == 0]
    joint = found["geometry"]["joints"][0]["ends_m"]
    stone = found["geometry"]["blocks"][3]["centroid_m"]
    found["geometry"]["cracks_m"] = [joint, [stone, [stone[0], stone[1] + 0.01]]]
    measured = {"name": "impost", "kind": "crack", "point_m": joint[1], "opening_mm": 3.0}
    found["echo"]["measurement"] = [measured]
    rows = {row["mark"]: row for row in survey_table(typed(found)).rows}
    assert rows["F1"]["joint"] == rows["M1"]["joint"] == 0 and "joint" not in rows["F2"]
    assert rows["F1"]["calculated_mm"] == pytest.approx(500.0 * row["opening_m"], rel=0.01)  # at its middle
    assert rows["M1"]["measured_mm"] == 3.0 and rows["F1"]["measured_mm"] is None
    [told] = survey_sentences(typed(found), words_of(typed(found)))
    assert "2 of 3" in told and "F2" in told
    with mpl.rc_context(STYLE):
        figure = draw_cracks(typed(found), words_of(typed(found)), SETTLED, 10)
    written = {text.get_text() for text in figure.findobj(Text)}
    assert {"F1", "F2", "M1"} <= written


def test_layers_add_up_to_the_model():
    results = results_example()
    rows = layers(typed(results)).rows
    assert sum(row["blocks"] for row in rows) == results["model"]["blocks"]
    weight = sum(
        row["area_m2"] * row["depth_m"] * row["unit_weight_kN_m3"] + row["vertical_load_kN"]
        for row in rows
        if row["support"] is None
    )
    assert weight == pytest.approx(results["model"]["weight_kN"])


def test_a_layer_overrides_the_default_material():
    results = results_example()
    results["echo"]["layers"]["PIERS"] = {"friction": 0.4}
    found = {row["layer"]: row["friction"] for row in layers(typed(results)).rows}
    assert (found["PIERS"], found["ARCH"]) == (0.4, 0.6)
