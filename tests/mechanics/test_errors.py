"""What the mechanics says where it cannot answer: which argument is wrong, or what the structure does."""

import re

import numpy as np
import pytest

from mechanics import (
    ArgumentError,
    Assembly,
    Block,
    CollapseError,
    ControlError,
    Material,
    UnstableError,
    limit_analysis,
    pushdown,
    pushover,
    time_history,
)
from mechanics.model.assembly import State
from tests.support.structures import (
    arch_on_piers,
    block_on_base,
    on_base,
    rectangle,
    running_bond,
    semicircular_arch,
)

STONE = Material(18.0, 0.7, 1e6)
TOP = (0.2, 1.0)


@pytest.fixture(scope="module")
def model():
    return block_on_base()


def leaning(shift: float) -> Assembly:
    """A block whose centroid stands `shift` (m) beyond the edge of its base."""
    return on_base(STONE, (-1, -1, 0), (shift - 0.5, 0, shift + 0.5, 1))


ANALYSES = {
    "limit analysis": limit_analysis,
    "rigid pushover": lambda m: pushover(m, (0.0, 1.0)),
    "elastic pushover": lambda m: pushover(m, (0.0, 1.0), contacts="elastic"),
    "rigid pushdown": lambda m: pushdown(m, "base", (0.01, 0.0)),
    "elastic pushdown": lambda m: pushdown(m, "base", (0.01, 0.0), contacts="elastic"),
}


@pytest.mark.parametrize("analysis", ANALYSES.values(), ids=ANALYSES)
def test_a_block_that_overhangs_cannot_stand(analysis):
    with pytest.raises(UnstableError, match="cannot stand under its own weight"):
        analysis(leaning(0.01))


@pytest.mark.parametrize("sliding", ["associative", "coulomb"])
def test_every_result_says_which_law_of_sliding_it_has(model, sliding):
    found = [
        limit_analysis(model, sliding=sliding),
        pushover(model, TOP, increment=0.05, sliding=sliding),
        pushdown(model, "base", (0.01, 0.0), increment=0.01, sliding=sliding),
    ]
    assert [each.sliding for each in found] == 3 * [sliding]
    with pytest.raises(ArgumentError, match=r"sliding = 'colomb': must be \"coulomb\" or \"associative\""):
        limit_analysis(model, sliding="colomb")


@pytest.mark.parametrize("analysis", ANALYSES.values(), ids=ANALYSES)
def test_a_block_without_support_cannot_stand(analysis):
    apart = Assembly([*leaning(-0.2).blocks, Block(rectangle(5, 5, 6, 6), 1.0, STONE)])
    with pytest.raises(UnstableError, match="own weight"):
        analysis(apart)


def test_an_arch_that_is_too_thin_cannot_stand():
    limit_analysis(semicircular_arch(27, 0.110))
    with pytest.raises(UnstableError, match=r"start to move with .* g"):
        limit_analysis(semicircular_arch(27, 0.104))


def test_a_state_in_which_nothing_stands_is_refused(model):
    fallen = model.rotated(1, (0.2, 0.0), -0.3)  # beyond its corner: arctan(0.2) = 0.197
    for analysis in (limit_analysis, lambda m, state: pushover(m, TOP, state=state)):
        with pytest.raises(UnstableError, match="own weight"):
            analysis(model, state=fallen)


@pytest.mark.parametrize("lean", [-0.19, -0.01])
def test_a_block_that_leans_on_its_corner_falls_back(model, lean):
    """Gravity alone is not carried, though it would be by the end of the joint that is open."""
    with pytest.raises(UnstableError, match="start to move"):
        limit_analysis(model, state=model.rotated(1, (0.2, 0.0), lean))


def test_elastic_analyses_need_a_stiffness():
    model = Assembly([Block(b.polygon, 1.0, Material(18.0, 0.7), b.support) for b in block_on_base().blocks])
    for call in (
        lambda: pushover(model, TOP, contacts="elastic"),
        lambda: pushdown(model, "base", (0.01, 0.0), contacts="elastic"),
    ):
        with pytest.raises(ValueError, match="normal_stiffness"):
            call()
    assert limit_analysis(model).alpha == pytest.approx(0.2)


def test_a_control_point_outside_every_block_is_told_how_far(model):
    with pytest.raises(ValueError, match=r"0\.25 m away"):
        pushover(model, (0.1, 1.25))


def test_a_control_point_on_an_edge_belongs_to_the_movable_block(model):
    assert model.block_at((0.1, 0.0)) == 1
    assert model.block_at((0.5, 0.0)) == 0


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_control_point_of_a_support_takes_no_part(model, contacts):
    with pytest.raises(ControlError, match=re.escape("control = (0.9, -0.05) takes no part")):
        pushover(model, (0.9, -0.05), contacts=contacts, increment=0.01)


def test_a_control_point_on_a_part_that_stays_takes_no_part():
    low = Block(rectangle(0.5, 0.0, 0.9, 0.1), 1.0, STONE)  # squat: stays while the tall block tips
    model = Assembly([*block_on_base().blocks, low])
    with pytest.raises(ControlError, match=r"takes no part in the mechanism along \+x"):
        pushover(model, (0.7, 0.1), increment=0.01)


def test_an_unknown_support_is_told_the_known_ones():
    with pytest.raises(ValueError, match=r"support = 'middle': must be one of left, right"):
        pushdown(arch_on_piers(), "middle", (0.01, 0.0))


def test_a_model_without_supports_says_so():
    free = Assembly([Block(rectangle(0, 0, 1, 1), 1.0, STONE)])
    with pytest.raises(ValueError, match="has no support"):
        pushdown(free, "base", (0.01, 0.0))
    with pytest.raises(UnstableError):
        limit_analysis(free)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_collapse_carries_the_path_so_far(contacts):
    model = block_on_base(stiffness=1e8)  # falls when the base has turned by arctan(0.2)
    with pytest.raises(CollapseError, match="before the whole of") as caught:
        pushdown(model, "base", rotation=-0.3, increment=0.02, contacts=contacts)
    path = caught.value.path
    assert len(path.movement) == len(path.states) == len(path.reaction) > 3
    assert path.final is path.states[-1]
    assert path.ultimate == path.movement[-1]
    assert -path.final.positions[0, 2] == pytest.approx(np.arctan(0.2), abs=0.01)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_state_of_another_model_is_refused(model, contacts):
    with pytest.raises(ValueError, match=r"^state = \(34, 3\): must be of this assembly: \(2, 3\)"):
        pushover(model, TOP, contacts=contacts, state=running_bond().initial)


def test_a_state_that_is_not_finite_is_refused(model):
    positions = np.full_like(model.initial.positions, np.nan)
    with pytest.raises(ValueError, match=r"^state = .* must be finite"):
        limit_analysis(model, state=State(positions, np.zeros_like(positions)))


def test_a_pushdown_is_no_state(model):
    moved = pushdown(model, "base", (0.01, 0.0), increment=0.01)
    with pytest.raises(ValueError, match=r"^state = 'Pushdown': must be a State"):
        limit_analysis(model, state=moved)


FOOT = [[-1, -0.3], [1, -0.3], [1, 0], [-1, 0]]
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
REST = np.zeros(5)


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("direction", lambda m: limit_analysis(m, "x")),
        ("contacts", lambda m: pushover(m, TOP, contacts="soft")),
        ("contacts", lambda m: pushover(m, TOP, contacts=["rigid"])),
        ("increment", lambda m: pushover(m, TOP, increment=0.0)),
        ("increment", lambda m: pushdown(m, "base", (0.01, 0.0), increment=0.0)),
        ("displacement", lambda m: pushdown(m, "base")), ("control", lambda m: pushover(m, (0.1, 2.0))),
        ("block", lambda m: m.rotated(2, TOP, 0.1)), ("about", lambda m: m.rotated(1, (0.0,), 0.1)),
        ("segments_per_joint", lambda m: Assembly(m.blocks, segments_per_joint=0)),
        ("tolerance", lambda m: Assembly(m.blocks, tolerance=0.0)), ("blocks", lambda m: Assembly([])),
        ("blocks", lambda m: Assembly(m.blocks[:1])), ("unit_weight", lambda m: Material(0.0)),
        ("friction", lambda m: Material(18.0, -0.1)),
        ("normal_stiffness", lambda m: Material(18.0, 0.5, 0.0)),
        ("tangential_stiffness", lambda m: Material(18.0, 0.5, 1e6, 0.0)),
        ("depth", lambda m: Block(rectangle(0, 0, 1, 1), 0.0, STONE)),
        ("vertices", lambda m: Block([[0, 0], [1, 0], [2, 0]], 1.0, STONE)),
        ("segments", lambda m: Block(rectangle(0, 0, 1, 1), 1.0, STONE, segments=0)),
        # not of its type, or no number
        ("friction", lambda _: Material(18.0, None)), ("material", lambda _: Block(FOOT, 1.0, "stone")),
        ("support", lambda _: Block(FOOT, 1.0, STONE, support=3)),
        ("segments", lambda _: Block(FOOT, 1.0, STONE, segments=1.5)),
        ("blocks", lambda m: Assembly([*m.blocks, "wall"])), ("blocks", lambda m: Assembly([*m.blocks, None])),
        ("block", lambda m: m.rotated(1.0, (0.0, 0.0), 0.1)),
        ("about", lambda m: m.rotated(1, "corner", 0.1)), ("model", lambda m: limit_analysis(list(m.blocks))),
        ("control", lambda m: pushover(m, "C1")), ("until", lambda m: pushover(m, TOP, until="0")),
        ("displacement", lambda m: pushdown(m, "base", "down")),
        ("acceleration", lambda m: time_history(m, "record", 0.005)),
        ("time_step", lambda m: time_history(m, REST, "0.005")),
        ("restitution", lambda m: time_history(m, REST, 0.005, restitution="0")),
        ("vertices", lambda _: Block([[0, 0], [2, 2], [2, 0], [0, 1]], 1.0, STONE)),  # a bow tie
        ("support", lambda _: Block(FOOT, 1.0, STONE, support="")),
        # lighter than nothing
        ("vertical_load", lambda _: Block(FOOT, 1.0, STONE, vertical_load=-50.0)),
        # as heavy as nothing
        ("blocks", lambda _: Assembly([Block(SQUARE, 1.0, STONE, vertical_load=-18.0, load_has_mass=False)])),
        ("sliding", lambda m: pushover(m, TOP, sliding="colomb")),
        ("sliding", lambda m: pushdown(m, "base", (0.01, 0.0), sliding="colomb")),
    ],
)  # fmt: skip
def test_a_bad_argument_is_named(model, name, call):
    with pytest.raises(ArgumentError, match=rf"^{name} = .*must be "):
        call(model)


@pytest.mark.parametrize("procedure", [limit_analysis, pushdown, pushover, time_history])
def test_every_analysis_names_a_model_that_is_none(procedure):
    with pytest.raises(ArgumentError, match="model = 'list': must be an Assembly"):
        procedure([], *([] if procedure is limit_analysis else [TOP, 0.005]))
