"""How paths end, and what the contacts as drawn cannot show."""

from dataclasses import replace
from importlib import import_module
from itertools import pairwise

import numpy as np
import pytest

from assessment.project.catalogue.new_project import new_project
from mechanics import Assembly, Block, Material, UnstableError, pushdown, pushover, time_history
from mechanics.errors import CollapseError, RunawayError
from mechanics.procedures.push_path import PUSHOVER, PushInput, PushPath, PushPoint
from mechanics.steps.static_system import static_system
from tests.support.contact_dynamics import motion
from tests.support.drawn_projects import drawn, tables
from tests.support.random_masonry import random_masonry
from tests.support.structures import arch_on_piers, block_on_base, built, on_base, rectangle
from tests.support.template_assembly import template_assembly

STONE = Material(20.0, 0.6, 1e6)
MODULE = {name: import_module(f"mechanics.procedures.{name}") for name in ("support_movement", "push_path")}


def test_a_structure_that_rides_with_its_support_has_no_ultimate_movement():
    path = pushdown(block_on_base(), "base", (0.02, -0.02), increment=0.01, to_collapse=True)
    assert path.ultimate is None
    assert path.end == "the structure moves with its support as a whole"
    assert len(path.movement) < 20


def test_a_lintel_that_rides_with_one_seat_slides_off_the_other():
    """Its bearings are 0.05 and 0.10 m: friction takes it along with the longer one, on which its weight is larger."""
    seats = {"left": (-1.0, -1.0, 0.05, 0.0), "right": (1.9, -1.0, 3.0, 0.0)}
    model = built(STONE, (0.0, 0.0, 2.0, 0.3), **seats)
    path = pushdown(model, "right", (0.002, 0.0), increment=0.001, to_collapse=True)
    assert path.ultimate == pytest.approx(0.05, abs=1e-5)


def test_run_arch_tie():
    """Which springing slides alternates from program to program; the short steps, in turn, refused every step.

    Each point was then found by blocks released at 1/32 of an increment: 600 points, and 20 s, to the same end.
    """
    stone, angles = Material(20.0, 0.3, 1e6), np.linspace(0.5 * np.pi + 1.5, 0.5 * np.pi - 1.5, 8)
    edges = [np.outer((0.875, 1.125), (np.cos(angle), np.sin(angle))) for angle in angles]
    names = ["left", *5 * [None], "right"]
    ring = Assembly(
        [
            Block([*one, *other[::-1]], 1.0, stone, support=name)
            for one, other, name in zip(edges, edges[1:], names, strict=False)
        ]
    )
    path = pushdown(ring, "right", rotation=0.01, increment=0.01, to_collapse=True)
    assert path.ultimate == pytest.approx(0.6097, rel=1e-3)
    assert len(path.movement) < 100
    assert not path.crossed.size


def test_the_arc_of_a_turn_does_not_depend_on_vertices_in_the_middle_of_an_edge():
    plain = [[-1.0, -0.2], [1.0, -0.2], [1.0, 0.0], [-1.0, 0.0]]
    dotted = [*plain[:1], *([x, -0.2] for x in (-0.9, -0.8, -0.7)), *plain[1:]]
    models = [built(STONE, (-0.1, 0.0, 0.1, 1.0), base=base) for base in (plain, dotted)]
    one, other = (pushdown(model, "base", rotation=0.01).movement[-1] for model in models)
    assert one == pytest.approx(other, rel=1e-12)


@pytest.mark.parametrize("increment", [0.001, 0.01])
def test_an_arch_that_falls_does_so_at_the_same_displacement(increment):
    """At 13.24 mm α jumps from 0.143 below zero: no point at zero belongs to the curve, at whatever increment."""
    model = arch_on_piers(voussoirs=9, courses=3, stiffness=1e7)
    curve = pushover(model, (0.85, 0.8), increment=increment)
    assert curve.lost and not curve.reached_zero
    assert curve.displacement[-1] == pytest.approx(0.01324, rel=0.02)
    assert curve.multiplier[-1] == pytest.approx(0.1426, rel=0.02)


@pytest.mark.parametrize("sliding", ["associative", "coulomb"])
def test_a_control_point_that_stands_still_is_no_collapse(sliding):
    """Of a wall, until a smooth block has slid to it: as little as it goes back is rounding, not a part that falls."""
    smooth = replace(STONE, friction=0.1)
    base = Block(rectangle(-3.0, -0.3, 5.0, 0.0), 1.0, STONE, support="base")
    wall = Block(rectangle(0.0, 0.0, 0.3, 1.0), 1.0, STONE)
    loose = Block(rectangle(-0.55, 0.0, -0.05, 0.3), 1.0, smooth)
    curve = pushover(Assembly([base, wall, loose]), (0.3, 1.0), increment=0.002, sliding=sliding)
    still = curve.displacement < 1e-6
    assert still.sum() > 10 and curve.multiplier[still].max() == pytest.approx(0.1, rel=1e-6)
    assert not curve.lost and curve.reached_zero
    assert curve.displacement[-1] > 0.25


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_an_increment_wider_than_the_settlement_is_no_reason_to_give_up(contacts):
    """A base turned by θ leaves d_0 = H sin(arctan(B/H) − θ), found whatever the increment."""
    model = block_on_base(stiffness=1e8)
    moved = pushdown(model, "base", rotation=-0.002, increment=0.01).final
    for increment in (0.01, 0.05, 0.1):
        path = pushover(model, (0.2, 1.0), "+x", contacts, increment, moved)
        assert path.reached_zero
        expected = np.hypot(0.2, 1.0) * np.sin(np.arctan(0.2) - 0.002)
        assert path.displacement[-1] == pytest.approx(expected, rel=5e-2)


LOOSE = ((0.0, 0.0, 0.6, 2.0), [(2.0, 0.0, 2.1, 1.0), (2.3, 0.0, 3.5, 1.0)], 0.0, 0.01, 1e-2)
NEIGHBOUR = ((0.0, 0.0, 0.3, 2.0), [(1.0, 0.0, 2.2, 1.5)], 0.3, 0.02, 1e-3)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
@pytest.mark.parametrize(("wall", "others", "at", "increment", "near"), [LOOSE, NEIGHBOUR])
def test_a_wall_ends_by_itself_whatever_falls_beside_it_or_it_falls_on(
    wall, others, at, increment, near, contacts
):
    """On soft joints it leant until a loose block fell against a stop, and took part in that: α0 was 0.077, not 0.27.

    The other fell by half a metre and rested on its neighbour: the push that moves both, 0.7, was taken for its α0.
    """
    stone = Material(20.0, 0.7, 1e6)
    models = (on_base(stone, (-2.0, -0.3, 5.0), *boxes) for boxes in ([wall], [wall, *others]))
    expected, found = (pushover(model, (at, 2.0), "+x", contacts, increment) for model in models)
    assert found.multiplier.max() == pytest.approx(expected.multiplier.max(), rel=near)
    assert found.displacement[-1] == pytest.approx(expected.displacement[-1], rel=near)
    if len(others) == 1:
        assert found.reached_zero and not len(found.crossed)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_block_that_only_slides_is_not_followed_for_ever(contacts):
    model = block_on_base(friction=0.1, stiffness=1e6)
    path = pushover(model, (0.2, 1.0), "+x", contacts, 0.02)
    assert "slides: α stays 0.1 over" in path.end
    assert not path.reached_zero and not path.lost
    assert path.displacement[-1] == pytest.approx(model.size, abs=0.05)


def test_a_bed_is_followed_however_soft_it_is():
    """Gravity presses the block in by 18 mm, 1/17 of its height: a warning of the project file, no end of the path.

    For a lean θ the bed's force W acts at k b³θ/(12 W) from its middle, where it is open at b/2 − √(2W/(kθ))/3.
    """
    width, height, stiffness = 0.2, 0.3, 300.0
    weight, lean = 18.0 * width * height, np.linspace(1e-4, 0.4, 4001)
    closed = stiffness * width**3 * lean / (12.0 * weight)
    opened = 0.5 * width - np.sqrt(2.0 * weight / (stiffness * lean)) / 3.0
    arm = np.where(closed <= width / 6.0, closed, opened)
    expected = (arm / (0.5 * height) - np.tan(lean)).max()
    path = pushover(block_on_base(width, height, stiffness=stiffness), (width, height), contacts="elastic")
    assert path.multiplier.max() == pytest.approx(expected, rel=0.02)


def test_a_bed_too_soft_to_keep_its_block_upright_leads_nowhere():
    """It stands where k d l³/12 exceeds W h/2: for 3 m above 2.4e4 kN/m³."""
    with pytest.raises(UnstableError, match=r"cannot stand under its own weight.*too soft"):
        pushover(block_on_base(height=3.0, stiffness=1.5e4), (0.2, 3.0), contacts="elastic")


CORNER = (0.2, 1.0)


def test_where_nothing_stands_beyond_the_last_equilibrium_is_located(monkeypatch):
    found = MODULE["push_path"].reach

    def reach(problem, guess, last, shortest):
        reached = found(problem, guess, last, shortest)
        if problem.system.model.point_displacement(CORNER, 1, reached.step.state.positions)[0] > 0.055:
            raise RunawayError("a part falls")
        return reached

    monkeypatch.setattr(MODULE["push_path"], "reach", reach)
    curve = pushover(block_on_base(), CORNER, increment=0.01)
    assert curve.lost and curve.end == "a part falls"
    assert 0.055 - 0.01 / 32 <= curve.displacement[-1] <= 0.055


def test_a_movement_ends_where_nothing_stands_beyond(monkeypatch):
    model, found = arch_on_piers(), MODULE["support_movement"].reach
    increment, index, drawn = model.size / 50.0, model.support("right"), model.initial.positions

    def reach(problem, guess, last, shortest):
        if float((guess - drawn)[index, 0].max()) > 5.2 * increment:
            raise RunawayError("a part falls")
        return found(problem, guess, last, shortest)

    monkeypatch.setattr(MODULE["support_movement"], "reach", reach)
    with pytest.raises(CollapseError, match="a part falls") as collapse:
        pushdown(model, "right", (9.0 * increment, 0.0), increment=increment, to_collapse=True)
    path = collapse.value.path
    assert 5.2 - 1.0 / 32 <= path.movement[-1] / increment <= 5.2
    assert path.ultimate == path.movement[-1]


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_a_hinge_of_the_settlement_that_snaps_shut_is_no_end_of_the_capacity(direction, tmp_path):
    """The multiplier comes down to zero within 3 mm, and up to ten times the onset's as the hinge has closed."""
    new_project(tmp_path / "arch", "arch", {})
    model, project = drawn(tmp_path / "arch"), tables(tmp_path / "arch")
    [table] = project["settlements"]
    settled = pushdown(model, table["support"], table["displacement_m"], 0.0, table["increment_m"]).final
    points = {point["name"]: point["point_m"] for point in project["control"]}
    named, increment = project["pushover"]["control"], project["pushover"]["increment_m"]
    control = points[named if isinstance(named, str) else named[direction]]
    curve = pushover(model, control, direction, "rigid", increment, settled)
    assert curve.multiplier[0] < 0.04
    assert curve.multiplier.max() > 3.0 * curve.multiplier[0]
    assert curve.displacement[-1] > 0.04


SLENDER = 0.5 / 3.0  # width over height


def beside(height: float, friction: float = 0.6) -> Assembly:
    """A wall 0.5 m wide and 3 m high, 0.10 m from a support of some height."""
    stone = Material(20.0, friction, 1e6)
    return Assembly(
        [
            Block(rectangle(-2.0, -0.3, 2.0, 0.0), 1.0, stone, support="ground"),
            Block(rectangle(0.0, 0.0, 0.5, 3.0), 1.0, stone),
            Block(rectangle(0.6, 0.0, 1.0, height), 1.0, stone, support="neighbour"),
        ]
    )


def test_a_curve_that_ends_at_zero_is_at_zero():
    """Where it says α = 0 the last multiplier is, to 1e-6 of the peak, whatever the increment."""
    model = random_masonry(9)
    for increment in (0.012, 0.005):
        curve = pushover(model, increment=increment)
        last = curve.multiplier[-1]
        assert curve.reached_zero == (abs(last) <= 1e-6 * curve.multiplier.max()), str(curve.end)


@pytest.mark.parametrize("friction", [0.6, np.inf])
def test_wall_beside_support(friction):
    """They can touch at θ = 1/3 only: α0 = b/h, and the wall is spent when its centre stands above its edge."""
    curve = pushover(beside(0.3, friction), increment=0.01)
    assert curve.multiplier[0] == pytest.approx(SLENDER, rel=1e-9)
    assert curve.displacement[-1] == pytest.approx(3.0 * np.sin(np.arctan(SLENDER)), rel=1e-6)
    assert curve.reached_zero


def test_a_motion_passes_a_low_neighbour_that_it_does_not_meet():
    """Until they can touch, at tan θ = 1/3, it is that of the wall alone; friction of an open joint held it before."""
    motions = []
    for blocks in (beside(0.3, np.inf).blocks, beside(0.3, np.inf).blocks[:2]):
        model = Assembly(blocks)
        tilted = model.rotated(1, (0.5, 0.0), -0.9 * np.arctan(SLENDER))
        motions.append(time_history(model, np.full(401, -0.1), 0.0025, "rigid", tilted, control=(0.5, 3.0)))
    met, alone = motions
    turned = -met.positions[:, 1, 2]
    free = turned < np.arctan(0.1 / 0.3) - 0.005
    assert turned[free].max() > np.arctan(SLENDER) and not free.all()
    assert met.displacement[free] == pytest.approx(alone.displacement[free], abs=1e-6)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
@pytest.mark.parametrize("sliding", ["coulomb", "associative"])
def test_a_wall_that_leans_on_a_neighbour_rests(contacts, sliding):
    """What the push presses on a support has no largest multiplier: the curve ends by that name, before it rises."""
    curve = pushover(beside(2.0), increment=0.01, contacts=contacts, sliding=sliding)
    assert "leans" in str(curve.end)
    assert not curve.lost
    assert not curve.reached_zero
    assert curve.multiplier.max() <= SLENDER * (1.0 + 1e-9)
    # touched at 0.10 m of the height of 2 m: 0.15 m at the top
    assert curve.displacement[-1] == pytest.approx(0.15, abs=0.0101)


def test_blocks_fall_back_where_they_jump_from_or_to_where_they_have_jumped_from_before():
    """Parts that moved by themselves took the control point back by 0.03 and 0.5 mm: curves of an arch ended there."""
    model = block_on_base()
    push = PushInput(np.array([0.0, 1.0]), "+x", 0.01, 0.0, PUSHOVER)
    path = PushPath(push, static_system(model, "rigid", "coulomb"), None)

    def moved(way):
        positions = model.initial.positions.copy()
        positions[1, 0] += way
        return positions

    start = path.points[0].step
    behind = replace(start, state=replace(start.state, positions=moved(0.01)))
    path.points = [PushPoint(start, 0.0), PushPoint(behind, -0.001, jumped=True)]
    assert path._falls_back(moved(0.004)) and path._falls_back(moved(-0.004))  # back to where it began
    assert not path._falls_back(moved(0.009)) and not path._falls_back(moved(0.011))  # from where it had led
    climbed = replace(start, state=replace(start.state, positions=moved(0.001)))
    path.points.append(PushPoint(climbed, 0.0))
    assert path._falls_back(moved(0.009))  # the same jump again
    assert not path._falls_back(moved(0.011))


def test_a_brick_that_slides_to_the_edge_and_tips_there_does_not_jump():
    """The last brick of the upper course slides, then turns about the edge below: α falls from μ to 0 above that."""
    model = random_masonry(11)
    curve = pushover(model, direction="-x", increment=0.02 * model.size)
    assert len(curve.crossed) == 0 and curve.reached_zero
    assert np.diff(curve.multiplier).max() < 2e-3 * curve.alpha_0
    moved = curve.states[-1].positions[curve.block] - model.initial.positions[curve.block]
    half = 0.5 * np.ptp(model.blocks[curve.block].polygon[:, 0])
    assert abs(moved[0]) == pytest.approx(half, rel=5e-3)


def test_a_step_does_not_pass_over_a_snap():
    """The arch was told 0.196 m by increments of 2 % of a block; contact dynamics falls where it does."""
    model = random_masonry(0)
    way, told = (0.3 * model.size, 0.0), []
    for part in (0.03, 0.01):
        path = pushdown(model, "right", way, increment=part * model.size, to_collapse=True)
        told.append(path.ultimate)
    assert told == pytest.approx([0.1776, 0.1776], rel=3e-3)
    moved = motion(model, np.zeros(3000), 1e-3, path.states[-1])[-1] - path.states[-1].positions
    assert abs(moved[:, :2]).max() > model.size


def test_what_falls_by_coulombs_law_as_a_support_moves_is_not_held_by_dilation():
    """Of a wall in bond a brick loses its seat of 0.462 m; by steps that lift what slides it hung for 2.3 m more."""
    courses = {
        0.0: (0.533, [0.0, 0.536, 0.99, 1.569, 2.0]),
        0.533: (1.062, [0.0, 0.725, 1.452, 2.0]),
        1.062: (1.52, [0.0, 0.497, 1.118, 1.465, 2.0]),
    }
    stone = Material(20.0, 0.8)
    bases = [("left", -0.4, 1.0), ("right", 1.0, 2.4)]
    blocks = [Block(rectangle(a, -0.3, b, 0.0), 0.5, stone, support=name) for name, a, b in bases]
    for low, (high, ends) in courses.items():
        blocks += [Block(rectangle(a, low, b, high), 0.5, stone) for a, b in pairwise(ends)]
    path = pushdown(Assembly(blocks), "right", (0.5, 0.0), increment=0.0105)
    assert path.lifting == 0
    assert path.crossed[0, 0] == pytest.approx(0.462, abs=1.5e-3)


def test_a_wall_with_openings_settles_by_coulombs_law_alone():
    """It rests wherever it slides: contact dynamics written apart comes to rest after 30 mm too."""
    wall = template_assembly("wall-with-openings", storeys=1)
    settled = pushdown(wall, "destro", (0.0, -0.03), increment=0.0021)
    assert settled.movement[-1] == pytest.approx(0.03) and settled.lifting == 0


def test_a_part_that_slips_by_a_quarter_of_a_block_rests_there():
    """With steps of a tenth of the length too; longer ones led beyond, and the curve ended at 0.218 m."""
    masonry = random_masonry(14)
    curve = pushover(masonry, None, "+x", increment=0.03 * masonry.size, until=0.5)
    assert len(curve.crossed) == 1 and curve.displacement[-1] > 0.28
