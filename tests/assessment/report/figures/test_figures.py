"""Figures are drawn from results alone, the same bytes each time, at the scale and places they claim."""

import math
import re
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.patches import Rectangle

from assessment.project.project import load_project
from assessment.project.structure.model import build_model
from assessment.report.figures.curves import draw_pushdown, draw_pushover
from assessment.report.figures.drawings import deformed
from assessment.report.figures.drawings.deformed import (
    draw_mechanisms,
    draw_settlement,
    found_mechanism,
    round_force,
)
from assessment.report.figures.index import pictures, write_figures
from assessment.report.figures.style import (
    BAND_MM,
    MM,
    SCALES,
    SYMBOL,
    WIDTH_MM,
    EvenDecimals,
    chart,
    save_svg,
    sheet,
    typeset,
)
from assessment.report.text.language import slug, words_of
from assessment.results.configurations.faces import outlines
from assessment.results.configurations.hand_check import macro_blocks
from assessment.runtime.pool import Pool
from assessment.workflow.stages import run
from mechanics.pictures import STYLE, Shape, magnification, nice
from tests.support.analysed import analysed
from tests.support.block_project import TURNED, write_block
from tests.support.block_project import block as tables_of_block
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    folder = tmp_path_factory.mktemp("figures")
    return write_figures(Pool(0, typed(results_example())), folder)


def test_every_figure_of_the_results_is_written(drawn):
    names = {path.stem for path in drawn}
    stem = slug(typed(results_example()), SETTLED)
    assert {"model", f"settlement_{stem}", f"pushdown_{stem}"} <= names
    assert {"synthesis", "mechanism", "pushover", "spectra_SLV", "spectra_SLC"} <= names
    for path in drawn:
        assert ElementTree.parse(path).getroot().tag.endswith("svg")


def test_bytes_depend_on_the_results_only(drawn, tmp_path):
    write_figures(Pool(0, typed(results_example())), tmp_path)
    for first in drawn[0].parent.iterdir():
        assert first.read_bytes() == (tmp_path / first.name).read_bytes()


def test_no_temporary_file_is_left(drawn):
    assert {path.name for path in drawn[0].parent.iterdir()} == {path.name for path in drawn}


def test_figures_speak_the_language_of_the_report(drawn, tmp_path):
    for picture in pictures(typed(results_example("en"))):
        if picture.name == "pushover":
            save_svg(picture.draw, tmp_path / "pushover.svg")
    english = {path.name: path.read_text() for path in tmp_path.iterdir()}
    italian = {path.name: path.read_text() for path in drawn}
    assert "Spostamento del punto di controllo [mm]" in italian["pushover.svg"]
    assert "Displacement of the control point [mm]" in english["pushover.svg"]
    glyphs = {
        name: re.sub(r"<[^>]+>|\s", "", text) for name, text in italian.items()
    }  # of symbols one by one
    assert "curvacompleta" in glyphs["pushover.svg"]
    assert not SYMBOL.search(italian["pushover.svg"]), "symbols are set as symbols"
    assert "1:20" in italian["model.svg"]


def test_symbols_are_set_as_symbols_and_names_stay_as_they_are():
    with mpl.rc_context(STYLE):
        figure, (axes,) = chart(words_of(typed(results_example("en"))), 1)
        axes.set_title("cost $5 of a_g and pier a_g1: α₀, S_De")
        axes.set_xlabel("pier_y $\\frac$")
        typeset(figure)
    assert axes.get_title() == (
        "cost \\$5 of $a_{\\mathrm{g}}$ and pier a_g1: $α_{\\mathrm{0}}$, $S_{\\mathrm{De}}$"
    )
    assert axes.get_xlabel() == "pier_y $\\frac$"


def test_only_what_was_computed_is_drawn():
    results = results_example()
    del results["spectra"]
    for content in results["states"].values():
        del content["capacity"], content["pushover"]
        content.pop("pushdown", None)
    assert [p.name for p in pictures(typed(results))] == [
        f"{stem}{slug(typed(results), SETTLED)}" if stem.endswith("_") else stem
        for stem in ("synthesis", "model", "settlement_", "cracks_")
    ]


def test_slugs_are_file_names_and_differ():
    results = {"states": {"à / b": {}, "a b": {}, "«»": {}}}
    assert [slug(typed(results), name) for name in results["states"]] == ["0_a_b", "1_a_b", "2"]


def test_sheet_is_to_scale():
    for count in (1, 2, 4):
        page = sheet((0.0, 0.0, 2.7, 1.6), count, border_mm=14.0)
        assert page.scale in SCALES
        for axes in page.panels:
            paper_mm = axes.get_position().size * page.figure.get_size_inches() / MM
            model_mm = 1000.0 * np.ptp([axes.get_xlim(), axes.get_ylim()], axis=1)
            assert paper_mm == pytest.approx(model_mm / page.scale)
            assert paper_mm[1] == pytest.approx(1.6e3 / page.scale + 18.0)


def test_panels_of_slender_models_leave_room_for_their_titles():
    page = sheet((0.0, 0.0, 0.5, 8.0), 2)
    assert [axes.get_position().width for axes in page.panels] == pytest.approx([0.5, 0.5])


def test_a_constant_reaction_is_a_level_line():
    results = results_example()
    stage = results["states"][SETTLED]["pushdown"]["rigid"]
    count = len(stage["movement_m"])
    stage["reaction_x_kN"] = [1e-9 * (-1) ** k for k in range(count)]
    stage["reaction_z_kN"] = [45.0 + k for k in range(count)]
    results["states"][SETTLED]["pushdown"] = {"rigid": stage}
    level, rising = draw_pushdown(typed(results), words_of(typed(results)), SETTLED).axes
    assert np.ptp(level.get_ylim()) > 1.0
    assert np.ptp(rising.get_ylim()) < 1.2 * count


def turned(folder, rotation):
    """Results of a block whose base turns about its centre, without a displacement."""
    text = tables_of_block() + TURNED.replace("-0.02", str(rotation)).replace("0.01", "0.004")
    project = load_project(write_block(folder / "block", text))
    return run(project, build_model(project), jobs=1).results


def base_of(results):
    return next(each for each in results.geometry.blocks if each.support == "base")


@pytest.mark.parametrize("rotation", [-0.02, 0.02])
def test_a_pure_rotation_has_its_movement_line_at_the_end_of_the_path(tmp_path, rotation):
    """The arc at the base's farthest corner; as the largest displacement, 0, the line was left out."""
    results = turned(tmp_path, rotation)
    corners = np.array(base_of(results).vertices_m)
    radius = np.hypot(*(corners - corners.mean(axis=0)).T).max()  # a rectangle
    figure = draw_pushdown(results, words_of(results), "base turned")
    for axes in figure.axes:
        [line] = [each for each in axes.lines if "cedimento assegnato" in each.get_label()]
        [curve] = [each for each in axes.lines if each.get_label() == "giunti rigidi"]
        asked = 1000.0 * abs(rotation) * radius
        assert line.get_xdata() == pytest.approx([asked, asked])
        assert curve.get_xdata()[[0, -1]] == pytest.approx([0.0, asked])
        assert axes.get_xlim()[1] > asked


@pytest.mark.parametrize("rotation", [-0.02, 0.02])
def test_a_pure_rotation_has_an_arc_over_its_support_in_its_sense(tmp_path, rotation):
    results = turned(tmp_path, rotation)
    figure = draw_settlement(results, words_of(results), "base turned")
    [arrow] = figure.axes[0].texts
    centre, tail, head = base_of(results).centroid_m, arrow.xyann, arrow.xy
    assert (np.array(tail) + head) / 2.0 == pytest.approx(centre)
    assert math.copysign(1.0, tail[0] - head[0]) == math.copysign(
        1.0, rotation
    )  # anticlockwise: from the right
    figure.draw_without_rendering()
    begun, over, *_ = arrow.arrow_patch.get_path().vertices
    assert over[1] > begun[1]


def test_panels_stay_on_the_page():
    for bounds in ((0, 0, 1, 1), (0, 0, 12, 2), (0, 0, 1, 9)):
        for count in (1, 2, 3, 4):
            width, height = sheet(bounds, count).figure.get_size_inches() / MM
            assert width <= 170.0 + 1e-6
            assert height <= 216.0


@given(st.floats(1e-6, 1e6))
def test_nice_numbers_are_just_below(value):
    found = nice(value)
    assert found <= value * (1 + 1e-6) < 2.5 * found * (1 + 1e-6)


@given(st.floats(-3.0, 3.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_a_rigid_motion_keeps_lengths_and_turns_by_the_angle(angle, dx, dz):
    shape = outlines(typed(results_example()))
    moved = shape.moved(np.tile([dx, dz, angle], (7, 1)))
    for block in range(7):
        before, after = (each.points[each.owner == block] for each in (shape, moved))
        side = after[1] - after[0]
        assert np.linalg.norm(side) == pytest.approx(np.linalg.norm(before[1] - before[0]))
        turn = math.atan2(*side[::-1]) - math.atan2(*(before[1] - before[0])[::-1])
        assert math.cos(turn - angle) == pytest.approx(1.0)
    assert moved.centroids == pytest.approx(shape.centroids + np.array([dx, dz]))


def test_the_nearest_block_of_a_hinge():
    points = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [2, 0], [3, 0], [3, 1], [2, 1]], dtype=float)
    shape = Shape(points, np.repeat([0, 1], 4), np.array([[0.5, 0.5], [2.5, 0.5]]), np.zeros(2, bool))
    assert shape.nearest([0.0, 0.6]) == 0  # on the closing edge of the ring
    assert shape.nearest([1.4, 0.5]) == 0
    assert shape.nearest([1.6, 0.5]) == 1


def test_mechanism_and_finite_motion_agree_to_first_order():
    shape = outlines(typed(results_example()))
    rate = np.random.default_rng(1).normal(size=(7, 3))
    difference = shape.swept(rate, 1e-4).points - shape.moved(1e-4 * rate).points
    assert np.abs(difference).max() < 1e-7


@pytest.mark.parametrize("language", ["it", "en"])
def test_the_points_of_curves_are_named_in_the_legend_where_no_curve_runs(language):
    """Their names stood beside their marks: on another curve, or on the name of a point near by."""
    results = typed(results_example(language))
    figure = draw_pushover(results, words_of(results), ["+x"])
    assert not [text for axes in figure.axes for text in axes.texts]
    [legend] = figure.legends
    named = [text.get_text() for text in legend.get_texts()]
    assert [named.count(name) for name in ("α_0", "d_0", "d_y, α_y")] == [1, 1, 1]


def test_a_legend_of_many_states_stays_below_the_axes():
    """Six states: a foot for four lines had six, over the names of the axes."""
    results = results_example()
    for number in range(4):
        results["states"][f"settled {number}"] = results["states"][SETTLED]
    with mpl.rc_context(STYLE):
        figure = draw_pushover(typed(results), words_of(typed(results)), ["+x"])
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        top = figure.legends[0].get_window_extent(canvas.get_renderer()).y1
        assert top < min(axes.get_tightbbox(canvas.get_renderer()).y0 for axes in figure.axes)


def test_sheets_are_saved_without_empty_bands(tmp_path):
    """A square of 40 mm with 30 mm above it and 20 mm below: the picture is as high as the square."""

    def draw():
        page = sheet((0.0, 0.0, 0.4, 0.4), border_mm=30.0, below_mm=20.0, most_mm=90.0)
        page.panels[0].add_patch(Rectangle((0.0, 0.0), 0.4, 0.4))
        assert page.scale == 10.0
        return page.figure

    save_svg(draw, tmp_path / "square.svg")
    box = re.search(r'viewBox="([^"]*)"', (tmp_path / "square.svg").read_text())[1].split()
    width, height = (float(each) * 25.4 / 72.0 for each in box[2:])
    assert width == pytest.approx(WIDTH_MM)
    assert height == pytest.approx(40.0 + 2.0 * BAND_MM, abs=0.5)


def test_a_label_longer_than_its_axis_takes_two_lines():
    """It was cut at the edge of the picture."""
    with mpl.rc_context(STYLE):
        figure, [low, high] = chart(words_of(typed(results_example())), rows=2, height_mm=60.0)
        low.set_ylabel("spostamento del punto di controllo lungo x [mm]")
        high.set_ylabel("moltiplicatore α [–]")
        typeset(figure)
        assert low.get_ylabel() == "spostamento del punto di\ncontrollo lungo x [mm]"
        assert high.get_ylabel() == "moltiplicatore α [–]"
        box = low.yaxis.label.get_window_extent()
        assert box.y1 <= figure.bbox.y1 and box.y0 >= figure.bbox.y0 and box.x0 >= figure.bbox.x0


def test_the_labels_of_an_axis_have_the_same_decimals():
    """0,025; 0,05; 0,075; 0,1 stood on one axis."""
    labels = EvenDecimals(words_of(typed(results_example("it"))))
    assert labels.format_ticks([-0.025, 0.0, 0.05, 0.1]) == ["−0,025", "0", "0,050", "0,100"]
    assert labels.format_ticks([0.0, 20.0]) == ["0", "20"] and labels(0.5) == "0,5"


@pytest.mark.parametrize(
    ("largest", "unit"), [(0.124, 0.1), (0.131, 0.2), (999.0, 1000.0), (6.6, 10.0), (1.3, 1.0)]
)
def test_resultants_are_drawn_to_a_round_scale(largest, unit):
    """The legend said "12 mm: 0.124 kN", which no scale reads; the largest is at most 13 mm long."""
    assert round_force(largest) == pytest.approx(unit)


def numbers_of(figure):
    """The numbers of the macro-blocks on the first panel, with their boxes in pixels."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    texts = [text for text in figure.axes[0].texts if text.get_text().isdigit()]
    return {text.get_text(): text.get_window_extent(canvas.get_renderer()) for text in texts}


def test_macro_blocks_of_less_than_a_hundredth_of_the_moving_weight_have_no_number(monkeypatch):
    """The bound is put above the second of three here: of those that move, one weighs more than four tenths."""
    results = typed(analysed())
    weights = [each.weight for each in macro_blocks(results, "original", "+x")]
    figure = draw_mechanisms(results, words_of(results), [("original", "+x")])
    assert deformed.LIGHT == 0.01 and set(numbers_of(figure)) == {"1", "2", "3"}
    monkeypatch.setattr(deformed, "LIGHT", 0.5 * (weights[0] + weights[1]) / sum(weights))
    figure = draw_mechanisms(results, words_of(results), [("original", "+x")])
    assert set(numbers_of(figure)) == {"1"}


def test_numbers_of_macro_blocks_are_off_hinges_and_off_one_another(monkeypatch):
    """A hinge where each of the numbers would stand: it was written over."""
    results = typed(analysed())
    parts = macro_blocks(results, "original", "+x")
    view = found_mechanism(results, "original", "+x")
    for each in parts:
        near = min(each.members, key=lambda block: np.hypot(*(view.start.centroids[block] - each.centroid)))
        view.hinges = [*view.hinges, tuple(view.start.centroids[near])]
    monkeypatch.setattr(deformed, "found_mechanism", lambda *_: view)
    figure = draw_mechanisms(results, words_of(results), [("original", "+x")])
    boxes = list(numbers_of(figure).values())
    axes = figure.axes[0]
    marks = next(line for line in axes.lines if line.get_marker() == "o").get_xydata()
    assert len(boxes) == len(parts) == 3 and len(marks) == len(view.hinges)
    for box in boxes:
        assert not any(box.contains(*axes.transData.transform(mark)) for mark in marks)
        assert not any(box.overlaps(other) for other in boxes if other is not box)


def test_what_is_not_moved_is_not_magnified():
    """A facade at rest was drawn with its last digits, magnified by 1e16."""
    corners = np.array([[-4.5e-4, 1.9e-3], [0.61, 1.7e-3], [0.61, 0.42], [1e-3, 0.421]])
    at_rest = Shape.of(
        [corners, corners + np.array([7.3, 3.1])], [[0.30523, 0.21111], [7.60523, 3.31111]], [False, False]
    )
    assert magnification(at_rest, np.zeros((2, 3))) == 1.0
    assert magnification(at_rest, np.full((2, 3), 1e-3)) > 1.0
