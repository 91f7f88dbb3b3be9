"""[[tie]] and [[strengthening]] in the project file: what is refused, what is warned of, what each state has."""

import math

import numpy as np
import pytest

from assessment.analyses.states import Request, _beginnings
from assessment.project.model import build_model
from assessment.project.project import ProjectError, load_project
from assessment.results.frames import determined
from assessment.runtime.tasks import Workers
from assessment.workflow.run import select
from tests import ROOT
from tests.support.block_project import PROJECT, TURNED, block, write_block
from tests.support.tied_project import STRENGTHENED, TIE, strengthening, tie

LAYER = "[strengthening.layers.BASE]\n"


def refused(tmp_path, text: str) -> str:
    folder = write_block(tmp_path / "block", text)
    with pytest.raises(ProjectError) as error:
        build_model(load_project(folder))
    return str(error.value)


WRONG = {  # what is added to the project of the block, and what is said
    "of no state": (TIE + 'states = ["turned"]', 'tie[1].states[1]: no state "turned"; did you mean "base turned"?'),
    "twice": (TIE + TIE, 'tie[2].name: "chain" is the name of an earlier entry; write another'),
    "unknown key": (TIE + "force = 1.0", 'tie[1].force: unknown key; '),
    "no length": (tie(to_m="[-0.29, -0.1]"), "tie[1].to_m: the same point as from_m; write the point of another"),
    "pretension": (
        tie(pretension_kN="5.0"), "tie[1].pretension_kN: 5 kN is not below yield_force_kN = 5, and the tie would yield",
    ),
    "outside": (
        tie(to_m="[-0.4, 4.0]"),
        "tie.chain.to_m: [-0.4, 4.0] must be in or on a block (the nearest one is 0.1 m away); move it there",
    ),
    "one block": (tie(from_m="[-0.29, 0.5]"), "tie.chain.to_m: both ends are in block 1; write a point of another"),
    "supports": (
        tie(to_m="[0.5, -0.1]", from_m="[-0.5, -0.1]"), "tie.chain.to_m: both ends are in block 0; write a point of",
    ),
    "strengthening of no state": (
        STRENGTHENED.replace("base turned", "base turnt"),
        'strengthening[1].of: no state to strengthen "base turnt"; did you mean "base turned"?',
    ),
    "strengthening of a strengthening": (
        STRENGTHENED + strengthening("strengthened", "again") + LAYER + "friction = 0.8\n",
        'strengthening[2].of: "strengthened" is a strengthening itself; write the state that it is of, and name its',
    ),
    "name of a state": (
        TIE + strengthening(name="base turned"),
        'strengthening[1].name: "base turned" is the name of another state; write another',
    ),
    "nothing": (
        TIE + strengthening(),
        'strengthening[1]: changes nothing; add a [[tie]] with states = ["strengthened"], or [strengthening.layers',
    ),
    "nothing of a layer": (STRENGTHENED + LAYER, "strengthening[1].layers.BASE: changes nothing; write what it makes"),
    "unit weight": (
        STRENGTHENED + LAYER + "unit_weight_kN_m3 = 20.0\n",
        'strengthening[1].layers.BASE.unit_weight_kN_m3: unknown key; ',
    ),
    "no layer": (
        STRENGTHENED + "[strengthening.layers.BASS]\nfriction = 0.8\n",
        'strengthening[1].layers.BASS: no block on that layer; did you mean "BASE"?',
    ),
    "there already": (
        tie(states='["base turned", "strengthened"]') + strengthening() + LAYER + "friction = 0.8\n",
        'tie[1].states[2]: the tie is in "base turned" already, which "strengthened" strengthens; name one of the two',
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_a_tie_that_is_none_is_refused(tmp_path, case):
    added, said = WRONG[case]
    assert said in refused(tmp_path, PROJECT + added)


def test_a_tie_of_a_state_that_is_not_run_is_refused_too(tmp_path):
    """`--only pushdown` leaves the strengthened state out: the point was told as that of a control, without file."""
    write_block(tmp_path, PROJECT + STRENGTHENED.replace("4.0]", "9.0]"))
    with pytest.raises(ProjectError, match=r"project.toml: tie.chain.\w+: \["):
        build_model(select(load_project(tmp_path), ["pushdown"]))


def test_a_strengthened_state_that_nothing_pushes_is_refused(tmp_path):
    said = refused(tmp_path, block() + TURNED + STRENGTHENED)
    assert said.startswith(
        "project.toml: strengthening: nothing pushes or shakes the strengthened state; add [push"
    )


ODD = {  # keys of the tie, and the warning
    "newtons": ({"yield_force_kN": "5000.0"}, "tie[1].yield_force_kN: 5000 kN is more than anchorages in masonry bear; "
                "write 5 if N were meant"),
    "newtons per metre": ({"stiffness_kN_m": "1e6"}, "tie[1].stiffness_kN_m: 1e+06 kN/m is not E A/L of a steel bar of "
                          "4.1 m that yields at 5 kN, 1.7e+02 to 2.6e+03; write 1000 if N/m were meant"),
    "soft": ({"stiffness_kN_m": "1.0"}, "; write that of bar and anchorages"),
    "of no yield force": ({"yield_force_kN": "", "stiffness_kN_m": "5e6"}, "of a steel bar of 4.1 m, 1e+03 to 1e+06"),
}  # fmt: skip


@pytest.mark.parametrize("case", ODD)
def test_what_no_bar_has_is_warned_of(tmp_path, case):
    keys, said = ODD[case]
    folder = write_block(tmp_path / "block", PROJECT + tie(**keys))
    assert [said in warning for warning in build_model(load_project(folder)).warnings] == [True]


def ties_by_state(tmp_path, text: str) -> dict[str, list[str]]:
    states = build_model(load_project(write_block(tmp_path / "block", text))).states
    return {name: [each.name for each in state.assembly.ties] for name, state in states.items()}


def test_each_state_has_its_ties(tmp_path):
    always = TIE.replace("chain", "old")
    settled = tie(states='["base turned"]').replace("chain", "settled")
    found = ties_by_state(tmp_path, PROJECT + always + settled + STRENGTHENED + strengthening("original", "first"
        ) + "[strengthening.layers.BASE]\nfriction = 0.8\n")  # fmt: skip
    assert found == {
        "original": ["old"],
        "base turned": ["old", "settled"],
        "strengthened": ["old", "settled", "chain"],
        "first": ["old"],
    }


def test_a_tie_without_an_elongation_of_its_own_breaks_at_that_of_b450a(tmp_path):
    """(A_gt)k = 7.5 % of B450C, 2.5 % of B450A: the least of NTC 2018, §11.3.2."""
    model = (
        build_model(load_project(write_block(tmp_path / "block", PROJECT + TIE))).states["original"].assembly
    )
    [chain] = model.ties
    assert chain.longest == pytest.approx(0.025 * math.dist(chain.start, chain.end))


def test_ties_are_set_without_slack_where_the_structure_has_come_to(tmp_path):
    """The block turned by 0.3 rad about its right toe, (0.3, 0); the other tie is as long as drawn."""
    text = PROJECT + TIE.replace("chain", "old") + STRENGTHENED
    state = build_model(load_project(write_block(tmp_path / "block", text))).states["strengthened"]
    moved = state.settling.rotated(1, (0.3, 0.0), -0.3)
    old, new = state.tied_at(moved).ties
    c, s = math.cos(0.3), math.sin(0.3)
    end = np.array([0.3 + c * -0.59 + s * 4.0, s * 0.59 + c * 4.0])
    assert new.taut_length == pytest.approx(math.dist((-0.29, -0.1), end), rel=1e-12)
    assert old.taut_length == pytest.approx(4.1, rel=1e-12)


def test_a_changed_layer_is_another_material_of_the_same_weight(tmp_path):
    text = PROJECT + strengthening() + LAYER + "friction = 0.9\ncompressive_strength_kN_m2 = 3000.0\n"
    state = build_model(load_project(write_block(tmp_path / "block", text))).states["strengthened"]
    before, after = (model.blocks[0].material for model in (state.settling, state.assembly))
    assert (after.friction, after.compressive_strength) == (0.9, 3000.0) != (before.friction, math.inf)
    assert after.unit_weight == before.unit_weight and after.normal_stiffness == before.normal_stiffness


def test_what_a_region_has_of_its_own_stays(tmp_path):
    """Its keys count before those of its layer: a part of friction 0.3 was given the 0.7 of the layer around it."""
    region = '[[region]]\nname = "poor"\noutline_m = [[-2, -1], [2, -1], [2, 0], [-2, 0]]\nfriction = 0.3\n'
    text = (
        PROJECT + region + strengthening() + LAYER + "friction = 0.9\ncompressive_strength_kN_m2 = 3000.0\n"
    )
    model = build_model(load_project(write_block(tmp_path / "block", text))).states["strengthened"].assembly
    assert (model.blocks[0].material.friction, model.blocks[0].material.compressive_strength) == (0.3, 3000.0)


def test_tension_is_determined_where_the_blocks_of_a_tie_move_against_each_other(tmp_path):
    model = (
        build_model(load_project(write_block(tmp_path / "block", PROJECT + TIE))).states["original"].assembly
    )
    still, together, over = np.zeros((2, 3)), np.full((2, 3), [0.1, 0.0, 0.0]), np.zeros((2, 3))
    over[1] = (2.1, -0.3, -1.0)
    x, z = model.from_origin(model.ties[0].points[0]) - model.initial.positions[1, :2]
    about = np.array([[0.0, 0.0, 0.0], [z, -x, 1.0]])  # the end of the tie that the other block holds
    found = determined(model, [still, together, over, about])
    assert found.tolist() == [[False], [False], [True], [True]]


def test_what_strengthens_the_structure_as_drawn_finds_it_at_rest_on_elastic_joints(tmp_path):
    """Its arch spreads as it comes to rest: a chain that is set then is longer than as drawn."""
    project = load_project(ROOT / "projects" / "chained_arch")
    made = project.strengthening[0].model_copy(update={"of": "original"})
    project = project.model_copy(update={"strengthening": (made,)})
    model = build_model(project).states["con catena"]
    elastic, rigid = (Request(project, model, None, behaviour) for behaviour in ("elastic", "rigid"))
    with Workers(1) as workers:
        found, restless = _beginnings([elastic, rigid], {}, workers, "")
    begun = found[elastic]
    assert not restless
    assert (
        begun.state is not None
        and begun.state.positions[2:, 1].min() < model.assembly.initial.positions[2:, 1].min()
    )
    [chain] = begun.model.ties
    assert chain.taut_length == pytest.approx(math.dist(*model.assembly.tie_ends(begun.state)[0]), rel=1e-12)
    assert chain.taut_length > 8.4 + 1e-5
    assert found[rigid].state is None and found[rigid].model is model.assembly
