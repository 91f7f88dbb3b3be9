"""Support movements found again from measurements of movements that are known.

The measurements are made by a pushdown with other increments; the arch has no friction path here, its joints only
open, so that a path predicts what any other path to the same movement does.
"""

import numpy as np
import pytest

from assessment.project.model import Gauge, readings
from assessment.results.schema.studies import Explanation
from assessment.runtime.cache import Store
from assessment.runtime.tasks import Workers
from assessment.studies import identification as search_module
from assessment.studies.fit import Fit, Unknowns, over_kinks, refined, sureness
from assessment.studies.identification import follow, probability
from mechanics import CollapseError, ConvergenceError
from mechanics.messages import message
from mechanics.procedures import SupportMovement, pushdown_together
from tests.support.surveyed_arch import (
    CROWN,
    LEFT,
    PIER,
    SPRINGING,
    entry,
    identified,
    measured,
    surveyed,
    write_surveyed,
)
from tests.support.wording import in_italian

TRUTH = (0.012, -0.008, 0.004)
PLACES = [
    ("crown", "crack", CROWN), ("left haunch", "crack", LEFT), ("right pier", "lean", PIER),
    ("span", "span", SPRINGING), ("foot", "foot", (0.27, 0.10)),
]  # fmt: skip
RIGHT_MOVES = '[{ destro = ["x", "z", "rotation"] }]'
UPRIGHT, DOES_NOT_TURN = (0.012, -0.008, 0.0), '[{ destro = ["x", "z"] }]'


@pytest.fixture(autouse=True)
def short(monkeypatch):
    """Few and short paths: what they lead to does not depend on their increments here."""
    for name, value in {"FARTHEST": 2.0, "COARSE": 5, "FINE": 2, "STARTS": 1}.items():
        monkeypatch.setattr(search_module, name, value)


@pytest.fixture
def fine(monkeypatch, short):
    """As by default, where the way to a movement tells which joints open."""
    monkeypatch.setattr(search_module, "FINE", 5)


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    folder = write_surveyed(tmp_path_factory.mktemp("arch"), RIGHT_MOVES, *synthetic_zero())
    return surveyed(folder)[1]


@pytest.fixture(scope="module")
def identify(tmp_path_factory):
    """The identification of a project folder; one other process follows the paths, those that are equal once."""
    with Workers(jobs=1, store=Store(tmp_path_factory.mktemp("paths"))) as workers:
        yield lambda folder: identified(folder, workers)


def synthetic_zero():
    return [entry(name, kind, point, 0.0) for name, kind, point in PLACES]


def synthetic(model, places, movement=TRUTH, sigma=0.2, noise=None, support="destro"):
    noise = np.zeros(len(places)) if noise is None else noise
    return [
        entry(name, kind, point, measured(model, kind, point, movement, support) + error, sigma)
        for (name, kind, point), error in zip(places, noise, strict=True)
    ]


def movement_of(explained):
    [moved] = explained.movement
    return np.array([moved.x_m, moved.z_m, moved.rotation_rad])


def test_a_movement_is_found_again_from_exact_measurements(identify, model, tmp_path):
    # tolerance: rounding of the paths, 1e-9 m, over the derivatives of the readings (about 0.1)
    found, study = identify(write_surveyed(tmp_path, RIGHT_MOVES, *synthetic(model, PLACES)))
    [explained] = found.hypotheses
    assert movement_of(explained) == pytest.approx(TRUTH, abs=1e-6)
    assert explained.chi_squared < 1e-6 and explained.probability > 0.999
    assert explained.degrees_of_freedom == 2
    assert explained.aic == pytest.approx(explained.chi_squared + 6.0)
    assert not study.findings and not study.failures and study.quality
    [ready] = found.settlements
    assert ready.support == "destro" and ready.displacement_m == pytest.approx(TRUTH[:2], abs=1e-6)


@pytest.mark.usefixtures("fine")
def test_standard_errors_do_not_divide_a_jump_by_a_step(identify, model, tmp_path):
    """The crown opens at one edge or the other as the support rises or goes down: a jump of its crack at z = 0.

    A level with σ 0.5 mm tells z: its standard error is that of z = −2 mm, 0.481 mm, far from the jump; a difference
    across the jump made 0.014 mm of it.
    """
    seen = [
        *synthetic(model, [PLACES[0], PLACES[1], PLACES[3]], (0.012, 0.0, 0.0)),
        entry("level", "foot", (0.27, 0.10), 0.0, 0.5),
    ]
    found, study = identify(write_surveyed(tmp_path, DOES_NOT_TURN + "\ndownward_only = false", *seen))
    [explained] = found.hypotheses
    assert movement_of(explained)[:2] == pytest.approx([0.012, 0.0], abs=1e-6)
    assert explained.movement[0].z_standard_error_m == pytest.approx(4.81e-4, rel=0.01)
    [told] = study.findings
    assert "kink within a standard error of the movement along z" in told and "towards higher values" in told
    assert "scarto tipo" in in_italian(told)


def test_noise_moves_it_within_its_standard_errors(identify, model, tmp_path):
    # four standard errors: the chance of one of two normal deviates beyond is 1e-4, and the seed is fixed
    noise = 0.2 * np.random.default_rng(1).standard_normal(len(PLACES))
    seen = synthetic(model, PLACES, UPRIGHT, noise=noise)
    found, _ = identify(write_surveyed(tmp_path, DOES_NOT_TURN, *seen))
    [explained] = found.hypotheses
    [moved] = explained.movement
    errors = np.array([moved.x_standard_error_m, moved.z_standard_error_m])
    assert (abs(movement_of(explained) - UPRIGHT)[:2] < 4.0 * errors).all()
    assert (abs(movement_of(explained) - UPRIGHT)[:2] > 1e-6).any()
    assert 1e-5 < errors[0] < 5e-3
    assert 0.01 < explained.probability < 0.999


@pytest.mark.usefixtures("fine")
def test_a_crack_that_is_not_there_tells_two_hypotheses_apart(identify, tmp_path):
    """Span and the crack of a haunch fit either support; that the crown is whole to its left, the left one alone."""
    both = '[{ destro = ["x"] }, { sinistro = ["x"] }]'
    seen = [entry("span", "span", SPRINGING, 8.0), entry("left haunch", "crack", LEFT, 1.2)]
    unclear, study = identify(write_surveyed(tmp_path / "unclear", both, *seen))
    assert not any(each.distinguished for each in unclear.hypotheses)
    assert any("do not tell one hypothesis" in text for text in study.findings)
    whole = entry("crown", "crack", CROWN, 0.0)
    clear, _ = identify(write_surveyed(tmp_path / "clear", both, *seen, whole))
    right, left = clear.hypotheses
    assert clear.best == 1 and left.chi_squared < 2.0 and not left.distinguished
    assert right.distinguished and right.aic > left.aic + 2.0


def test_hypotheses_are_told_apart_by_more_than_two_of_aic(monkeypatch, tmp_path):
    """Burnham and Anderson (2002)."""
    told = iter((10.0, 11.9, 12.1))

    def explained(_, search, unknowns):
        return Explanation(
            hypothesis=unknowns.title, unknowns=1, movement=[], chi_squared=1.0, degrees_of_freedom=1, probability=0.5,
            aic=next(told), distinguished=False, undetermined=[], kinked=[], contradicting=[], at_collapse=False,
            fit=[], configuration=None,
        )  # fmt: skip

    monkeypatch.setattr(search_module, "_explained", explained)
    asked = '[{ destro = ["x"] }, { sinistro = ["x"] }, { destro = ["z"] }]'
    with Workers(jobs=1) as workers:
        found, _ = identified(write_surveyed(tmp_path, asked, *synthetic_zero()), workers)
    assert [each.distinguished for each in found.hypotheses] == [False, False, True]


def test_a_movement_that_no_measurement_shows_is_named(identify, model, tmp_path):
    """Above the springing nothing tells a rotation of the pier from a movement of its support."""
    places = [("crown", "crack", CROWN), ("left", "crack", LEFT), ("crown again", "crack", CROWN)]
    found, study = identify(write_surveyed(tmp_path, RIGHT_MOVES, *synthetic(model, places)))
    [explained] = found.hypotheses
    assert any("the rotation of the support destro" in text for text in explained.undetermined)
    assert explained.movement[0].rotation_standard_error_rad is None
    assert any("the measurements do not determine" in text for text in study.findings)


def test_the_measurement_that_contradicts_the_rest_is_named(identify, model, tmp_path):
    wrong = entry("foot again", "foot", (0.27, 0.10), -2.0)
    lean = measured(model, "lean", PIER, UPRIGHT)
    leans = [entry(f"{off} σ", "lean", PIER, lean + 0.2 * off) for off in (2.9, 3.1)]
    found, study = identify(
        write_surveyed(tmp_path, DOES_NOT_TURN, *synthetic(model, PLACES, UPRIGHT), wrong, *leans)
    )
    [explained] = found.hypotheses
    assert {"foot again", "3.1 σ"} <= {*explained.contradicting}
    assert not {"crown", "2.9 σ"} & {*explained.contradicting}
    assert any("foot again contradicts the rest" in text for text in study.findings)
    assert any("does not explain the measurements" in text for text in study.findings)


def test_supports_do_not_rise_unless_they_may(identify, model, tmp_path):
    up = synthetic(model, [PLACES[3], PLACES[4]], (0.004, 0.006, 0.0))
    hypotheses = '[{ destro = ["x", "z"] }]'
    held, _ = identify(write_surveyed(tmp_path / "held", hypotheses, *up))
    assert held.hypotheses[0].movement[0].z_m == 0.0
    free, _ = identify(write_surveyed(tmp_path / "free", hypotheses + "\ndownward_only = false", *up))
    assert movement_of(free.hypotheses[0])[:2] == pytest.approx([0.004, 0.006], abs=1e-5)


def test_a_movement_that_the_structure_does_not_survive_is_no_answer(monkeypatch, tmp_path):
    """Of 20 mm that were measured a structure survives 8."""

    def falls(model, movements, increment, sliding):
        [asked] = movements
        if asked.displacement[0] <= 0.008:
            return pushdown_together(model, movements, increment, sliding)
        path = pushdown_together(model, [SupportMovement("destro", (0.008, 0.0))], increment, sliding)
        raise CollapseError(message("it falls"), path)

    monkeypatch.setattr(search_module, "pushdown_together", falls)
    wide = entry("span", "span", SPRINGING, 20.0, 1.0)
    with Workers(jobs=1) as workers:
        found, study = identified(write_surveyed(tmp_path, '[{ destro = ["x"] }]', wide), workers)
    [explained] = found.hypotheses
    assert explained.at_collapse and explained.movement[0].x_m == pytest.approx(0.008, rel=0.02)
    assert any("beyond what the structure survives" in text for text in study.findings)


def _stopped(monkeypatch, path):
    """Let every movement be stopped by an error that is no collapse, and carries the path so far, or none."""

    def stop(*_):
        error = ConvergenceError(message("a step of the path was not solved to the required accuracy"))
        error.path = path
        raise error

    monkeypatch.setattr(search_module, "pushdown_together", stop)


def test_what_was_followed_of_a_path_counts_and_why_it_was_stopped_is_kept(model, monkeypatch):
    """Stopped after 3 of 12 mm: four of sixteen increments, and the readings of a pushdown by these 3 mm."""
    gauge = Gauge("relative", SPRINGING, model.block_at(SPRINGING), axis=0)
    quarter = pushdown_together(model, [SupportMovement("destro", (0.003, 0.0))], 0.00075)
    _stopped(monkeypatch, quarter)
    whole = SupportMovement("destro", (0.012, 0.0))
    found = follow(model, [whole], 16, "associative", [gauge])
    assert found.share == pytest.approx([0.0, 0.0625, 0.125, 0.1875, 0.25])
    assert found.shown[-1] == pytest.approx(readings(model, [gauge], quarter.states[-1].positions))
    assert found.configuration is None and "not solved" in found.stopped and len(found.quality) == 1
    _stopped(monkeypatch, None)
    nothing = follow(model, [whole], 16, "associative", [gauge])
    assert not nothing.share.size and "not solved" in nothing.stopped


def test_supports_that_move_together(identify, tmp_path):
    """Both go out by the same: the span shows the sum, each foot its own; there is no settlement to paste."""
    places = [("span", "span", SPRINGING, 16.0), ("foot", "foot", (0.27, 0.10), -3.0)]
    entries = [entry(*each) for each in places]
    entries.append(entry("left foot", "foot", (-0.27, 0.10), 0.0))
    found, _ = identify(write_surveyed(tmp_path, '[{ destro = ["x", "z"], sinistro = ["z"] }]', *entries))
    right, left = found.hypotheses[0].movement
    assert [right.x_m, right.z_m, left.z_m] == pytest.approx([0.016, -0.003, 0.0], abs=1e-4)
    assert (
        right.rotation_standard_error_rad is None
        and "rotation_standard_error_rad" not in right.model_fields_set
    )


# parts of it, by hand


def test_readings_of_a_block_that_turns(model):
    """A pier turned by θ about its lower corner: opening b·θ at the other end, lean θ, top moved by h·θ."""
    block, turn = model.block_at(PIER), 1e-4
    pivot = np.array([0.42, 0.0])
    joints = [j for j in range(len(model.joints.a)) if block in (model.joints.a[j], model.joints.b[j])]
    joint = min(joints, key=lambda j: model.joints.ends[j, :, 1].mean())
    ends = model.joints.ends[joint]
    pivot = ends[np.argmax(ends[:, 0])]
    positions = model.rotated(block, pivot, -turn).positions
    far = int(np.argmin(ends[:, 0]))
    gauges = [
        Gauge("crack", tuple(ends[far]), block, joint, far),
        Gauge("crack", tuple(ends[1 - far]), block, joint, 1 - far),
        Gauge("slip", tuple(ends[far]), block, joint, far),
        Gauge("lean", PIER, block),
        Gauge("relative", PIER, block, axis=0),
        Gauge("relative", SPRINGING, model.block_at(SPRINGING), origin=PIER, origin_block=block, axis=1),
    ]
    width = abs(ends[0, 0] - ends[1, 0])
    arm = np.array(PIER) - pivot
    shown = readings(model, gauges, positions)
    expected = 1e3 * turn * np.array([width, 0.0, 0.0, -1.0, arm[1], arm[0]])
    # second order in the rotation
    assert shown == pytest.approx(expected, abs=1e-4 * 1e3 * turn * width + 1e-9)


LINEAR = np.array([[2.0, 0.0], [0.0, 1.0], [1.0, 1.0]])


def linear(offset):
    def predict(values):
        return [LINEAR @ u - offset for u in values]

    return predict


def two(downward=False):
    return Unknowns((("a", "x"), ("a", "z")), 1.0, downward)


def test_what_is_flat_beyond_a_kink_within_its_error_is_not_determined():
    """r = (10 x, z up to 0.3, constant beyond): the standard error of z by the slope at the fit alone is 1."""

    def flat(values):
        return [np.array([10.0 * u[0], min(u[1], 0.3)]) for u in values]

    fit = refined(two(), np.zeros(2), np.zeros(2), flat, 10.0)
    assert sureness(fit, 10.0).error == pytest.approx([0.1, 1.0])
    kinked, around = over_kinks(two(), fit, sureness(fit, 10.0).error, flat)
    assert kinked.tolist() == [[False, False], [False, True]]
    sure = sureness(around, 10.0)
    assert sure.error == pytest.approx([0.1, np.inf]) and abs(sure.open) == pytest.approx(
        np.array([[0.0, 1.0]])
    )


def test_standard_errors_are_the_largest_of_all_pairs_of_slopes():
    """Beyond their kinks x and z show apart; at the fit together, J⁻¹ = [[−0.9, 1], [1, −1]]."""
    slopes = tuple(
        tuple(map(np.array, each)) for each in (([5.0, 0.0], [10.0, 10.0]), ([0.0, 5.0], [10.0, 9.0]))
    )
    fit = Fit(np.ones(2), np.zeros(2), slopes, False)
    assert sureness(fit, 10.0).error == pytest.approx(np.sqrt([1.81, 2.0]))


def test_a_linear_problem_is_solved_with_its_standard_errors():
    offset = np.array([1.0, 2.0, 4.0])
    predict, start = linear(offset), np.array([0.1, -0.1])
    fit = refined(two(), start, LINEAR @ start - offset, predict, 10.0)
    assert fit.u == pytest.approx(np.linalg.lstsq(LINEAR, offset, rcond=None)[0], abs=1e-9)
    errors = np.sqrt(np.diag(np.linalg.inv(LINEAR.T @ LINEAR)))
    assert sureness(fit, 1.0).error == pytest.approx(errors, abs=1e-9)
    assert not len(sureness(fit, 1.0).open)


@pytest.mark.parametrize("effect", [1e-8, 1e-2])
def test_unknowns_share_what_their_difference_does_not_show(effect):
    """Their difference, of an effect within σ, would become 10⁴ m, or 1 m; supports were told to sink by 13 m."""

    def alike(values):
        return [np.array([10.0 * (u[0] + u[1] - 1.0), effect * (u[0] - u[1] - 1.0)]) for u in values]

    fit = refined(two(), np.zeros(2), alike([np.zeros(2)])[0], alike, 1.0)
    assert fit.u == pytest.approx([0.5, 0.5], abs=0.02)


@pytest.mark.parametrize("length", [0.0, 1e-5])
def test_a_start_much_shorter_than_the_movement_is_left(length):
    """The pattern is a share of the start; steps of Gauss and Newton go on where it is too small to lead anywhere."""

    def curved(values):
        return [LINEAR @ (u + u**3 - [0.3, 0.2]) for u in values]

    start = np.array([length, 0.0])
    fit = refined(two(), start, curved([start])[0], curved, 10.0)
    assert fit.u + fit.u**3 == pytest.approx([0.3, 0.2], abs=1e-4)


def test_a_jump_beside_the_fit_and_a_kink_in_it():
    """r = (10 x, z ± 5 beyond a jump): at z = 0 the slope is 1 wherever the jump is. At a kink it has two."""
    start = np.zeros(2)

    def jump(at):
        return lambda values: [
            np.array([10.0 * u[0], u[1] + 5.0 * (u[1] > at) - 5.0 * (at < 0.0)]) for u in values
        ]

    for at, side in ((1e-9, 1), (-1e-9, 0), (1.5e-6, 1)):
        fit = refined(two(), start, jump(at)([start])[0], jump(at), 10.0)
        error = sureness(fit, 10.0).error
        assert error == pytest.approx([0.1, 1.0])
        assert over_kinks(two(), fit, error, jump(at))[0].tolist() == [[False, False], [side == 0, side == 1]]

    def kink(values):
        return [np.array([10.0 * u[0], max(u[1], 2.0 * u[1])]) for u in values]

    fit = refined(two(), start, np.zeros(2), kink, 10.0)
    assert sureness(fit, 10.0).error == pytest.approx([0.1, 1.0])
    assert [len(slopes) for slopes in fit.slopes] == [1, 2]


def test_a_bound_holds_and_the_others_go_on():
    offset, start = np.array([1.0, 2.0, 4.0]), np.array([0.1, -0.1])
    fit = refined(two(True), start, LINEAR @ start - offset, linear(offset), 10.0)
    assert fit.u[1] == 0.0
    assert fit.u[0] == pytest.approx(LINEAR[:, 0] @ offset / (LINEAR[:, 0] @ LINEAR[:, 0]), abs=1e-9)


def test_slopes_are_those_between_one_and_two_hundredths_of_the_movement():
    """z + z² held at its bound z = 0, of a movement of 1 m: downwards (z₂ − z₁)/0.01 = 0.97."""

    def curved(values):
        return [np.array([10.0 * (u[0] - 1.0), u[1] + u[1] ** 2 - 1.0]) for u in values]

    start = np.array([1.0, 0.0])
    fit = refined(two(True), start, curved([start])[0], curved, 10.0)
    assert fit.u == pytest.approx([1.0, 0.0], abs=1e-9)
    assert [slope[1] for slope in fit.slopes[1]] == pytest.approx([0.97])


def test_a_direction_without_effect_is_open():
    fit = Fit(np.array([1.0, 1.0]), np.zeros(2), ((np.full(2, 10.0),), (np.full(2, 10.0),)), False)
    found = sureness(fit, 1.0)
    assert np.isinf(found.error).all()
    assert abs(found.open[0]) == pytest.approx([0.5**0.5] * 2)


def test_probability_of_chi_squared():
    # Abramowitz and Stegun, table 26.8: 5 % at 3.841 with one degree of freedom and 7.815 with three
    assert probability(3.84146, 1) == pytest.approx(0.05, abs=1e-5)
    assert probability(7.81473, 3) == pytest.approx(0.05, abs=1e-5)
