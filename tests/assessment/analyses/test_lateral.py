"""Pushes of a state: control points, the other law of friction, the multiplier by a second program."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from assessment.analyses import lateral
from assessment.analyses import lateral as module
from assessment.analyses.capacity import activation_of, rigid_branch, way_of_blocks
from assessment.analyses.lateral import (
    PushSetting,
    _rigid_notes,
    push,
    rests_or_moves,
    rigid_push,
    second_solver,
)
from assessment.cli.main import main
from assessment.project.catalogue.new_project import write_drawing
from assessment.project.schema import ControlTable
from assessment.results.schema.static import RigidPush
from mechanics import Assembly, Block, Material, Pushover, limit_analysis, pushdown, pushover
from mechanics.errors import ConvergenceError, NoEquilibriumError
from mechanics.messages import Message, message
from mechanics.procedures import limit_in
from tests.support.analysed import SETTLED, analysed
from tests.support.block_project import (
    ASSESSMENT,
    PUSHED,
    TURNED,
    block,
    read_results,
    run,
)
from tests.support.random_masonry import small_wall
from tests.support.structures import block_on_base, column, on_base, rectangle
from tests.support.wording import in_italian

CONTROLS = re.compile(r"\[\[control\]\]\nname = .*\npoint_m = .*\n")
BARE = CONTROLS.sub("", block())
PUSH = '[pushover]\ncontacts = ["rigid", "elastic"]\nincrement_m = 0.05\n'


def plinth(folder, text: str):
    """A wall 0.6 × 4.2 m on a plinth 1 × 1 m that does not move in its mechanism."""
    folder.mkdir(exist_ok=True)
    layers = {
        "BASE": [rectangle(-1.0, -0.3, 1.0, 0.0)],
        "WALL": [rectangle(-0.5, 0.0, 0.5, 1.0), rectangle(-0.3, 1.0, 0.3, 5.2)],
    }
    write_drawing(folder / "geometry.dxf", layers)
    (folder / "project.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.mark.usefixtures("no_figures")
def test_a_project_without_control_point_follows_one_and_says_which(tmp_path, capsys):
    """Every stage that needs one has it, in every state; `check` says the same."""
    project = plinth(tmp_path / "wall", BARE + TURNED + PUSH)
    assert main(["check", str(project)]) == 0
    said = "no control point given: towards +x that of block 2 at (0.3, 5.2) m is followed"
    assert said in capsys.readouterr().out
    assert run(project) == 0
    results = read_results(project / "output")
    assert any(said in warning for warning in results["quality"]["warnings"])
    controls = {each["name"]: (each["point_m"], each["block"]) for each in results["geometry"]["controls"]}
    assert controls == {"scelto +x": ([0.3, 5.2], 2), "scelto -x": ([-0.3, 5.2], 2)}
    for state in results["states"].values():
        for direction, pushed in state["pushover"].items():
            assert (
                pushed["control"] == f"scelto {direction}"
                and pushed["control_m"] == controls[pushed["control"]][0]
            )
    rigid = results["states"]["original"]["pushover"]["+x"]["rigid"]
    assert rigid["alpha_0"] == pytest.approx(1.0 / 7.0, rel=1e-6)


@pytest.mark.usefixtures("no_figures")
def test_a_curve_is_not_thrown_away_for_its_control_point(tmp_path):
    """It had no curve, with the advice to add a point; with elastic joints the plinth moved, and had its own."""
    given = BARE + '[[control]]\nname = "plinth"\npoint_m = [0.45, 0.9]\n'
    found = {}
    for name, text in (("plinth", given), ("none", BARE)):
        alone = 'scatter = 1\naccuracy = "fast"\n'
        project = plinth(tmp_path / name, alone + text + PUSH + ASSESSMENT.replace('"none"', '"trilinear"'))
        assert run(project) == 0
        results = read_results(project / "output")
        found[name] = results["states"]["original"]
        warned = [each for each in results["quality"]["warnings"] if "takes no part" in each]
        assert len(warned) == (2 if name == "plinth" else 0), warned
    for direction, pushed in found["plinth"]["pushover"].items():
        other = found["none"]["pushover"][direction]
        assert pushed["control_m"] == other["control_m"]
        for contacts in ("rigid", "elastic"):
            for key, values in pushed[contacts]["curve"].items():
                assert values == pytest.approx(other[contacts]["curve"][key], rel=1e-6, abs=1e-9)
        ratios = [found[name]["capacity"][direction]["SLV"]["zeta_E"] for name in ("plinth", "none")]
        assert ratios[0] == pytest.approx(ratios[1], rel=1e-6)


def test_a_curve_whose_first_motion_is_not_found_is_told_and_the_others_go_on(monkeypatch):
    """Checks are of the first motion: without it there is no capacity, and none that is too large."""
    model, made = block_on_base(), lateral.rigid_push

    def lost(control, path):
        if path.direction == "-x":
            raise NoEquilibriumError(message("no equilibrium: some block would start to move"))
        return made(control, path)

    monkeypatch.setattr(lateral, "rigid_push", lost)
    setting = lateral.PushSetting("rigid", "coulomb", 0.02)
    control = ControlTable(name="C", point_m=(0.0, 1.0))
    there, none = lateral.push(model, "original", None, setting, ("+x", "-x"), (control, control))
    assert there.value is not None
    assert none.value is None
    assert "pushover -x, rigid contacts: the mechanism of the first motion is not found" in none.failures[0]


LAYERS = {
    "BASE": [rectangle(-1.0, -0.3, 1.0, 0.0)],
    "SIDE": [rectangle(-1.0, 0.0, -0.25, 3.0)],
    "WALL": [rectangle(-0.25, 0.0, 0.25, 3.0)],
}


def rubbing(folder, sliding: str) -> dict:
    """A wall 0.5 × 3 m that is pushed away from a fixed one, with which it has a joint."""
    folder.mkdir()
    write_drawing(folder / "geometry.dxf", LAYERS)
    text = "scatter = 1\n" + block().replace("point_m = [0.3, 4.2]", "point_m = [0.25, 3.0]")
    text = (
        text.replace('[[control]]\nname = "left"\npoint_m = [-0.3, 4.2]\n', "")
        + '[layers.SIDE]\nsupport = "side"\n'
    )
    text += sliding + PUSHED + ASSESSMENT
    (folder / "project.toml").write_text(text, encoding="utf-8")
    assert main(["run", str(folder), "--no-report"]) == 0
    return read_results(folder / "output")


@pytest.mark.usefixtures("no_figures")
def test_coulombs_law_counts_where_none_is_asked_for_and_both_indices_are_told(tmp_path):
    """What turns away leaves the other wall: by Coulomb's law nothing rubs, α0 = t/h = 1/6.

    By the associative law its foot, which rises faster than it leaves, rubs on, and α0 is more: the wall is safer the
    rougher a joint that opens.
    """
    found = {name: rubbing(tmp_path / name, text) for name, text in (
        ("none", ""),
        ("associative", '[contacts]\nsliding = "associative"\n'),
    )}  # fmt: skip
    rigid = {name: each["states"]["original"]["pushover"]["+x"]["rigid"] for name, each in found.items()}
    capacity = {name: each["states"]["original"]["capacity"]["+x"] for name, each in found.items()}
    told = {
        name: [w for w in each["quality"]["warnings"] if "has the ratio" in w] for name, each in found.items()
    }

    assert rigid["associative"]["sliding"] == "associative" and rigid["associative"]["alpha_0"] > 1.01 / 6.0
    other = rigid["associative"]["other_law"]
    assert (other["sliding"], other["alpha_0"]) == ("coulomb", pytest.approx(1.0 / 6.0, rel=1e-5))
    by_name = capacity["associative"]
    assert (by_name["sliding"], by_name["alpha_0"]) == ("associative", rigid["associative"]["alpha_0"])
    assert by_name["other_law"]["zeta_E"]["SLV linear"] < by_name["SLV linear"]["zeta_E"]
    assert told["associative"]

    assert capacity["none"]["sliding"] == "coulomb"
    linear = by_name["other_law"]["zeta_E"]["SLV linear"]
    assert capacity["none"]["SLV linear"]["zeta_E"] == pytest.approx(linear, rel=1e-4)
    assert capacity["none"]["SLV"]["zeta_E"] < by_name["SLV"]["zeta_E"]
    assert capacity["none"]["alpha_0"] == pytest.approx(1.0 / 6.0, rel=1e-5)
    assert capacity["none"]["other_law"]["sliding"] == "associative"
    assert told["none"]
    for row in found["none"]["summary"]["rows"]:
        assert row["alpha_0"] == capacity["none"]["alpha_0"]
        assert row.get("other_law") == capacity["none"].get("other_law")


def leaning(seed: int, direction: str) -> Pushover:
    """The curve of a random wall whose base has turned by 0.02 rad."""
    wall = small_wall(seed)
    settled = pushdown(wall, "base", rotation=0.02, increment=0.01).final
    return pushover(wall, direction=direction, increment=0.02, state=settled)


def told(path: Pushover, begins: str = "by {law}") -> tuple[RigidPush, list[Message]]:
    curve = rigid_push(ControlTable(name="C", point_m=tuple(path.control.tolist())), path)
    return curve, [note for note in _rigid_notes(curve, path) if note.template.startswith(begins)]


@pytest.mark.parametrize(("dropped", "fields"), [([], []), ([(0.01, 0.6), (0.02, 0.5)], [(2, 0.6)])])
def test_points_left_out_of_a_curve_are_told(dropped, fields):
    path = replace(leaning(2, "-x"), dropped=np.array(dropped).reshape(-1, 2))
    _, notes = told(path, "points left out")
    assert [(note.fields["count"], note.fields["multiplier"]) for note in notes] == fields
    assert all("punti esclusi" in in_italian(note) for note in notes)


def test_the_other_law_is_compared_at_alpha_0_where_the_mechanism_is_another():
    """The control point takes no part at α0: both multipliers were those of the point from which it does."""
    path = leaning(2, "-x")
    path = replace(path, formed=path.peak + 1)
    at_peak = limit_analysis(path.model, "-x", path.states[path.peak], "associative").alpha
    curve, [note] = told(path)
    assert note.fields["multiplier"] == curve.alpha_0 == path.alpha_0
    assert note.fields["other"] == curve.other_law.alpha_0 == pytest.approx(at_peak, rel=1e-8)
    assert curve.other_law.mechanism.alpha != pytest.approx(at_peak, rel=1e-4)


@pytest.mark.parametrize(("friction", "rests"), [(1, 1.0), (0.4, None)])
def test_rigid_joints_that_may_rest_where_they_may_move_are_told(friction, rests):
    """Three courses of two bricks, friction 1: it may move from 4/7 on, and may rest up to μ.

    With 0.4 the wall slides, and both laws have one multiplier.
    """
    stone, rows = Material(18.0, friction), [(0.0, 0.4, 0.8), (0.0, 0.2, 0.6, 0.8), (0.0, 0.4, 0.8)]
    bricks = [
        (left, 0.25 * course, right, 0.25 * (course + 1))
        for course, ends in enumerate(rows)
        for left, right in pairwise(ends)
    ]
    model = on_base(stone, (-0.5, -0.3, 1.3), *bricks)
    found = rests_or_moves(model, "original", model.initial)
    if rests is None:
        assert found.value == pytest.approx(1.0, abs=1e-6)
        assert not found.warnings
        return
    assert found.value == pytest.approx(rests / (4.0 / 7.0), rel=1e-6)
    assert [warning.fields["text"].fields["direction"] for warning in found.warnings] == ["+x", "-x"]


@pytest.mark.parametrize("state", ["original", SETTLED])
@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_every_state_and_direction_of_a_run_has_it(state, direction):
    rigid = analysed()["states"][state]["pushover"][direction]["rigid"]
    found = rigid["second_solver"]
    low, high = rigid.get("alpha_0_range", [rigid["alpha_0"]] * 2)
    # of an ensemble the least counts; this is that of the own run
    assert low <= found["alpha_0"] <= (high or 1.0)
    assert found["alpha_program"] == pytest.approx(found["alpha_0"], rel=1e-4)
    assert found["alpha_linear_program"] == pytest.approx(found["alpha_program"], rel=1e-6)
    difference = found["alpha_linear_program"] / found["alpha_program"] - 1.0
    assert found["relative_difference"] == pytest.approx(difference, abs=1e-15)


@pytest.mark.parametrize(("share", "warned"), [(5e-7, False), (-2e-6, True)])
def test_a_difference_above_one_in_a_million_is_warned_of(monkeypatch, share, warned):
    def wrong(model, direction, state, sliding):
        limit = limit_in(model, direction, state, sliding)
        return replace(limit, alpha=limit.alpha / (1.0 + share))

    monkeypatch.setattr(module.procedures, "limit_in", wrong)
    model = block_on_base()
    part = second_solver(model, "moved", "-x", model.initial, 0.2)
    assert part.value.relative_difference == pytest.approx(share, rel=1e-3)
    assert bool(part.warnings) == warned
    for warning in part.warnings:
        italian = in_italian(warning)
        assert "moved" in italian and "scarto relativo" in italian and "written apart" not in italian


def test_a_multiplier_of_zero_by_both_is_no_difference():
    """Without friction: α = 0 by one, 1e-9 by the other."""
    model = block_on_base(friction=0.0)
    part = second_solver(model, "original", "+x", model.initial, 0.0)
    assert part.value.alpha_linear_program == pytest.approx(0.0, abs=1e-8)
    assert not part.warnings


def test_an_optimum_that_highs_does_not_find_is_warned_of(monkeypatch):
    monkeypatch.setattr(module.procedures, "static_theorem", lambda *_: None)
    model = block_on_base()
    part = second_solver(model, "original", "+x", model.initial, 0.2)
    assert part.value.alpha_linear_program is None and part.value.relative_difference is None
    assert part.value.alpha_program == pytest.approx(0.2)
    [warning] = part.warnings
    assert "ottimo" in in_italian(warning)


def test_a_state_that_may_not_stand_is_warned_of(monkeypatch):
    def undecided(*_):
        raise ConvergenceError(message("does not settle"))

    monkeypatch.setattr(module.procedures, "static_theorem", undecided)
    part = second_solver(block_on_base(), "original", "+x", block_on_base().initial, 0.2)
    assert part.value.alpha_program is None and part.value.alpha_linear_program is None
    assert ["does not settle" in str(each) for each in part.warnings] == [True]


def test_joints_that_crush_have_no_comparison():
    model = column(0.5, 1.0, 2, strength=1000.0)
    part = second_solver(model, "original", "+x", model.initial, 0.2)
    assert part.value is None and not part.warnings


def test_what_rises_behind_a_trough_counts_no_more_than_the_first_peak():
    """The curve was cut in the trough; whole, its later rise would be the capacity."""
    path = pushover(block_on_base(), (0.0, 1.0), increment=0.05)
    multiplier = path.multiplier.copy()
    multiplier[1:4] = np.array([0.5, 1.3, 1.2]) * path.alpha_0
    risen, found = replace(path, multiplier=multiplier), module.Found[module.Pushed]()
    setting, control = (
        module.PushSetting("rigid", "coulomb", 0.05),
        ControlTable(name="C", point_m=(0.0, 1.0)),
    )
    module.add_curve("t", setting, control, risen, found)
    assert any("what the curve has beyond, up to" in text for text in found.warnings)
    rigid = found.value.curves.rigid
    assert (rigid.peak, rigid.alpha_0) == (0, path.alpha_0)
    _, alpha = rigid_branch(rigid, way_of_blocks(rigid, rigid.mechanism.gamma_star, "+x"))
    assert alpha[2] == alpha[3] == alpha.max() == path.alpha_0
    # a trough in which the control point stays, as hinges of a settlement close, is no part of its capacity
    forms = rigid.replace(mechanism=rigid.mechanism.replace(point=2))
    assert (rigid_branch(forms, way_of_blocks(rigid, rigid.mechanism.gamma_star, "+x"))[1][0]) == path.alpha_0
    told = module.Found[module.Pushed]()
    module.add_curve("t", setting, control, path, told)
    assert not any("what the curve has beyond" in text for text in told.warnings)


def test_a_curve_whose_joints_slide_and_crush_says_what_it_is_not_held_against():
    stone = Material(20.0, 0.1, compressive_strength=1e4)
    path = pushover(on_base(stone, (-1.0, -1.0, 3.0), (0.0, 0.0, 1.0, 1.0)), increment=0.05, until=0.9)
    curve = rigid_push(ControlTable(name="C", point_m=(0.0, 1.0)), path)
    assert any("joints slide and can be crushed" in text for text in _rigid_notes(curve, path))


def test_a_wall_as_drawn_that_meets_another_is_told_what_activates_it():
    """A panel of 4.2 × 0.6 m turns at α = t/h = 1/7, and after the 20 mm to its neighbour both have to turn."""
    stone = Material(18.0, 0.7)
    base, wall, neighbour = (
        Block(rectangle(x0, z0, x1, z1), 1.0, stone, support=support)
        for x0, z0, x1, z1, support in (
            (-1.0, -0.3, 4.0, 0.0, "base"), (0.0, 0.0, 0.6, 4.2, None), (0.62, 0.0, 2.02, 4.2, None),
        )
    )  # fmt: skip
    model, control = Assembly([base, wall, neighbour]), ControlTable(name="top", point_m=(0.6, 4.2))
    setting = PushSetting("rigid", "associative", increment=0.005)
    [pushed] = push(model, "original", None, setting, ("+x",), (control,))
    curve = pushed.value.curves.rigid
    assert curve.alpha_onset == pytest.approx(1.0 / 7.0, rel=1e-6) and curve.alpha_0 > 1.5 / 7.0
    [warning] = [each for each in pushed.warnings if "met others" in each]
    assert "blocks move from α = 0.1429 on; by d = 0.0203 m they have met others" in warning
    assert "da α = 0,1429 in poi" in in_italian(warning)
    first = activation_of(model, curve.alpha_onset, curve.onset)
    assert (first.alpha, first.e_star) == pytest.approx((1.0 / 7.0, 1.0), rel=1e-6), "one block, e* = 1"
    assert curve.onset.moving_weight_kN == pytest.approx(18.0 * 0.6 * 4.2)
    assert curve.mechanism.moving_weight_kN > 2.0 * curve.onset.moving_weight_kN
    [alone] = push(Assembly([base, wall]), "original", None, setting, ("+x",), (control,))
    assert not any("meet others" in each for each in alone.warnings)
    assert alone.value.curves.rigid.onset is None
