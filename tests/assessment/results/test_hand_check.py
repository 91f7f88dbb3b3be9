"""The hand check: groups of blocks that move as one, and virtual work from the figures that are printed."""

import numpy as np
import pytest
import shapely

from assessment.report.chapters.grids import macro_block_grids
from assessment.report.chapters.remarks import too_many
from assessment.report.document import render_html
from assessment.report.figures.deformed import found_mechanism
from assessment.report.language import words_of
from assessment.report.tables.mechanisms import hand_check
from assessment.results.hand_check import (
    governing_view,
    hand_checks,
    macro_blocks,
    multiplier,
    rotation,
    virtual_work_table,
    weights,
)
from tests.support.analysed import SETTLED, analysed
from tests.support.results_example import results_example
from tests.support.typed import typed


def test_the_four_hinges_of_an_arch_leave_three_macro_blocks():
    results = analysed()
    rigid = results["states"]["original"]["pushover"]["+x"]["rigid"]
    assert rigid["mechanism"]["hinges"] == 4
    whole = macro_blocks(typed(results), "original", "+x")
    assert len(whole) == 3
    assert sum(each.weight_kN for each in whole) == pytest.approx(
        rigid["mechanism"]["moving_weight_kN"], rel=1e-3
    )
    members = [block for each in whole for block in each.members]
    assert len(members) == len(set(members))


def test_the_mechanism_that_governs_is_that_of_the_least_index_else_of_the_least_multiplier():
    results = typed(analysed())
    [least, *_] = sorted(results.summary.rows, key=lambda row: row.alpha_0)
    none = results.summary.replace(governing=None)
    assert governing_view(results.replace(summary=none)) == (least.state, least.direction)
    [other, *_] = (row for row in results.summary.rows if row.state != least.state)
    governing = results.summary.governing.replace(state=other.state, direction=other.direction)
    chosen = results.replace(summary=results.summary.replace(governing=governing))
    assert governing_view(chosen) == (other.state, other.direction)


def test_macro_blocks_turn_about_their_centres_and_about_the_hinges_between_them():
    """A hinge joined to still ground is a centre; two macro-blocks have one velocity at the hinge they share."""
    results = analysed()
    whole = macro_blocks(typed(results), "original", "+x")
    hinges = np.array(results["states"]["original"]["pushover"]["+x"]["rigid"]["mechanism"]["hinge_points_m"])
    centres = np.array([(each.x_C_m, each.z_C_m) for each in whole])
    grounded = [float(np.hypot(*(hinges - centre).T).min()) for centre in centres]
    assert sorted(grounded)[1] < 1e-3  # two of the three stand on the ground

    def velocity(each, point):
        return each.omega * np.array([each.z_C_m - point[1], point[0] - each.x_C_m])

    inner = [h for h in hinges if min(np.hypot(*(centres - h).T)) > 1e-3]
    for hinge in inner:
        rates = [velocity(each, hinge) for each in whole]
        gaps = [np.hypot(*(a - b)) for i, a in enumerate(rates) for b in rates[:i]]
        assert min(gaps) < 0.02


@pytest.mark.parametrize(("turn", "centre"), [(2.3e-9, None), (0.0, None), (1e-3, (5.0, 12.0))])
def test_what_the_solver_leaves_of_no_rotation_is_a_translation(turn, centre):
    """A block slid down a joint: ω = 2.3e-9 put its centre at 5000 km. (5, 2) + (0, 0.01)/0.001 = (5, 12) m."""
    motion = np.array([0.01, 0.0, turn])
    omega, x, z = rotation(np.array([5.0, 2.0]), motion)
    assert omega == (turn if centre else 0.0)
    assert (x, z) == (None, None) if centre is None else (x, z) == pytest.approx(centre)


def test_the_multiplier_of_the_printed_figures_is_the_programs():
    results = analysed()
    checks = list(hand_checks(typed(results)))
    assert len(checks) == 4
    for check in checks:
        assert abs(check.hand_deviation) < 2e-3
        by_hand = macro_blocks(typed(results), check.state, check.direction)
        assert multiplier(by_hand) == check.hand_alpha
        # as a reader would: every figure has four significant digits, and the last row the sums
        for figure in by_hand:
            for number in (figure.weight_kN, figure.x_G_m, figure.delta_x, figure.delta_z):
                assert float(f"{number:.3e}") == number
        total = virtual_work_table(by_hand).rows[-1]
        assert total["work_weight"] / total["work_load"] == check.hand_alpha


def test_weights_come_from_the_input_alone():
    results = analysed()
    for block in results["geometry"]["blocks"]:
        del block["weight_kN"]
    dead, seismic = weights(typed(results))
    movable = [block["support"] is None for block in results["geometry"]["blocks"]]
    assert dead[movable].sum() == pytest.approx(results["model"]["weight_kN"])
    results["geometry"]["blocks"][4]["depth_m"] *= 0.5
    assert weights(typed(results))[0][4] == pytest.approx(0.5 * dead[4])
    results["geometry"]["blocks"][3]["vertical_load_kN"] = 2.0
    layer = results["geometry"]["blocks"][3]["layer"]
    results["echo"]["layers"].setdefault(layer, {})["load_has_mass"] = False
    loaded, still = weights(typed(results))
    assert loaded[3] == pytest.approx(dead[3] + 2.0)
    assert still[3] == pytest.approx(seismic[3])


def test_a_wrong_multiplier_is_found_out():
    results = analysed()
    rigid = results["states"]["original"]["pushover"]["+x"]["rigid"]
    rigid["mechanism"]["alpha"] *= 1.05
    assert abs(hand_check(typed(results)).rows[0]["hand_deviation"]) > 0.04


def test_a_mechanism_goes_where_the_loads_push_it_and_its_joints_open():
    """Drawn the other way round its blocks would run into one another."""
    results = analysed()
    for direction, along in (("+x", 1.0), ("-x", -1.0)):
        for state in ("original", SETTLED):
            assert sum(each.work_load for each in macro_blocks(typed(results), state, direction)) > 0.0
            drawing = found_mechanism(typed(results), state, direction)
            crown = drawing.start.nearest([0.0, 1.65])
            assert along * (drawing.swept.centroids - drawing.start.centroids)[crown, 0] > 0.0
            forth, back = (
                overlap(drawing.start.swept(sign * drawing.velocity, 0.01 * drawing.amount))
                for sign in (1.0, -1.0)
            )
            # m²: below it is rounding, of joints that only slide or turn
            assert forth <= max(0.1 * back, 1e-9)
            assert back > 0.0 or state == SETTLED  # a settled arch stands with its joints open


def overlap(shape):
    """Area in which neighbouring blocks lie one over the other, m²."""
    rings = [shapely.Polygon(ring) for ring in shape.rings(range(13))]
    return sum(a.intersection(b).area for i, a in enumerate(rings) for b in rings[:i])


def test_a_mechanism_of_many_macro_blocks_is_left_to_the_table(tmp_path, monkeypatch):
    results = typed(results_example("en"))
    words = words_of(results)
    monkeypatch.setattr("assessment.report.document.pictures", lambda _: [])
    printed = render_html(results, tmp_path, words)
    assert "Macro-blocks of the mechanism" in printed and "too many" not in printed
    assert list(macro_block_grids(results, words)) and not list(too_many(results, words))
    assert not list(macro_block_grids(results, words, most=0))
    assert "too many for a check by hand" in " ".join(too_many(results, words, most=0))
