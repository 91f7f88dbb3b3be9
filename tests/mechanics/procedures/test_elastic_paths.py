"""Elastic paths: where they jump, whether they fall, snap through or leave an axis of symmetry."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from assessment import arch as arch_of_voussoirs
from assessment.project.model import build_model
from assessment.project.project import load_project
from mechanics import Assembly, Material, UnstableError, pushdown, pushover
from mechanics.errors import NoEquilibriumError, RunawayError
from mechanics.kernels.interior.iteration import inertia
from mechanics.solvers.interior import ordered
from mechanics.steps.geometry_iteration import find_equilibrium
from mechanics.steps.rest import motion_to_rest, way
from mechanics.steps.static_system import taken
from mechanics.steps.tolerances import REST
from tests.support.analysed import arch
from tests.support.drawn_projects import drawn, tables
from tests.support.random_masonry import random_masonry
from tests.support.structures import arch_on_piers


def test_an_elastic_path_that_only_bends_is_followed_without_letting_blocks_go():
    """Forces of the last point in the geometry of the next one may be unstable where the structure is not."""
    movement = np.array([0.03, -0.03])
    path = pushdown(drawn("triumphal_arch"), "destro", movement, increment=0.01, contacts="elastic")
    assert path.movement[-1] == pytest.approx(0.03)
    assert not len(path.crossed)
    assert not path.lifting


@pytest.mark.parametrize(
    ("sliding", "increment", "close"), [("associative", 1e-4, 0.002), ("coulomb", 1e-3, 0.04)]
)
def test_an_elastic_path_never_jumps_back_to_where_it_has_jumped_before(sliding, increment, close):
    """At its limit point a released arch came to rest behind, climbed again and was released again, eleven times."""
    curve = pushover(arch_on_piers(), (0.85, 0.8), "+x", "elastic", increment, sliding=sliding)
    lateral, positions = arch_on_piers().lateral_load("+x"), [state.positions for state in curve.states]
    work = (lateral * np.diff(positions, axis=0)).sum(axis=(1, 2))
    assert (work > 0.0).all()
    assert curve.lost
    # 2.758 mm at 0.03 to 0.3 mm by either law, where the control point turns back
    assert curve.displacement.max() == pytest.approx(0.002758, rel=close)


def test_a_slow_fall_is_followed_at_its_own_speed(monkeypatch):
    """Steps with the geometry held followed it at a twentieth of its speed, and it seemed to go on by 0.14 µm a step.

    Released beyond the last equilibrium it falls exponentially, which takes some fifty steps.
    """
    module, released = import_module("mechanics.procedures.step_control"), []
    motion = module.motion_to_rest

    def told(problem, begun):
        released.append((problem, begun))
        return motion(problem, begun)

    monkeypatch.setattr(module, "motion_to_rest", told)
    model, project = drawn("buttressed_arch"), tables("buttressed_arch")
    (table,) = project["settlements"]
    state = pushdown(
        model, table["support"], table["displacement_m"], increment=1e-3, contacts="elastic"
    ).final
    curve = pushover(model, (-0.42, 0.55), "-x", "elastic", 0.0005, state, until=0.5)
    assert curve.lost and curve.end.startswith("the structure falls")
    with pytest.raises(RunawayError, match="the structure falls"):
        motion(*released[-1], replace(REST, steps=80))


def test_a_motion_does_not_jump_out_of_the_rest_that_it_comes_to():
    """An arch that snaps through: a little stiffness moves the end of its curve by no more than 2 %.

    A step from less than a thousandth of a block before its rest led a twentieth away, to another solution of its
    program: one of these curves at the least ended at 10 to 11 mm.
    """
    for stiffness in (1.56e6, 1.6e6):
        model = arch_on_piers(voussoirs=5, courses=3, stiffness=stiffness, friction=1.1)
        movement = (0.0009, -0.0018)
        settled = pushdown(model, "right", movement, 0.0, 0.004, "elastic", sliding="coulomb").final
        curve = pushover(model, (0.0, 1.372), "-x", "elastic", 0.005, settled, sliding="coulomb")
        assert curve.displacement[-1] == pytest.approx(0.0247, rel=0.02)


def test_a_motion_knows_the_gaps_of_beds_better_than_its_way():
    """It turned back, crept to a saddle, and the curve ended there: it went on by 1e-6 m a step."""
    model = random_masonry(21)
    assert pushover(model, None, "-x", "elastic", 0.01 * model.size).reached_zero


def test_a_step_ends_where_two_programs_in_a_row_find_the_structure_unstable(monkeypatch):
    """With its geometry held the sequence cannot come to such an equilibrium: it went on for sixteen programs."""
    module, counts = import_module("mechanics.steps.geometry_iteration"), [0]
    control, solve_round = import_module("mechanics.procedures.step_control"), module._solve_round
    find, given_up = control.find_equilibrium, []

    def counted(*arguments, **options):
        counts[-1] += 1
        return solve_round(*arguments, **options)

    def found(*arguments):
        counts.append(0)
        try:
            return find(*arguments)
        except NoEquilibriumError as error:
            if "stability" in str(error):
                given_up.append(counts[-1])
            raise

    monkeypatch.setattr(module, "_solve_round", counted)
    monkeypatch.setattr(control, "find_equilibrium", found)
    curve = pushover(arch_on_piers(stiffness=3e5), (0.85, 0.8), contacts="elastic", increment=0.003)
    assert curve.reached_zero
    assert given_up and max(given_up) <= 12


@pytest.mark.parametrize(("increment", "until"), [(0.01, 0.5), (0.002, 0.5)])
def test_an_elastic_arch_that_snaps_through_has_not_spent_its_capacity(increment, until, tmp_path):
    """It yields to 0.012 of its weight, rests in the mirror image of its configuration, and bears ten times as much."""
    model = build_model(load_project(arch(tmp_path / "arch"))).assembly
    state = pushdown(model, "right", (0.06, -0.02), increment=0.01, contacts="elastic").final
    curve = pushover(model, (0.0, 1.65), "-x", "elastic", increment, state, until)
    before, after = curve.crossed[0, 0], curve.crossed[-1, 1]  # it may rest on the way
    assert before < 0.012 and after == pytest.approx(0.0161, abs=2e-4)
    assert curve.multiplier.max() == pytest.approx(0.157, rel=0.04)


def arch_of(stone: Material, voussoirs: int) -> Assembly:
    return arch_of_voussoirs(
        span_m=3.0, rise_m=1.5, thickness_m=0.45, voussoirs=voussoirs, material=stone, depth_m=1.0
    )


def test_a_symmetric_arch_that_is_spread_leaves_its_axis_of_symmetry():
    """Elastic joints: the equilibrium on the axis turns unstable, softly; it was told to collapse at 14 to 32 mm.

    Spread with 0.3 mm upwards or downwards the arch comes to the same rest, or its mirror image, without such a point.
    """
    model = arch_of(Material(22.0, 0.6, 1e7, 4e6), 5)
    movements = (0.06, 0.0), (0.06, 3e-4), (0.06, -3e-4)
    turned = [
        pushdown(model, "destro", each, increment=1e-3, contacts="elastic").final.positions[2:, 2]
        for each in movements
    ]
    nearest = min(abs(turned[0] - each).max() for each in turned[1:])
    assert nearest < 5e-4 < 0.01 < abs(turned[0] + turned[0][::-1]).max()


def test_a_settled_elastic_state_is_pushed_without_a_control_point():
    """As rigid blocks it would not stand there; its elastic joints hold it."""
    model = arch_of(Material(22.0, 0.6, 1e6, 4e5), 5)
    moved = pushdown(model, support="destro", displacement=(0.02, -0.02), increment=1e-3, contacts="elastic")
    with pytest.raises(UnstableError):
        pushover(model, state=moved.final)
    curve = pushover(model, state=moved.final, increment=1e-3, until=0.9, contacts="elastic")
    assert 0.28 < curve.alpha_0 < 0.3076  # as drawn 0.3076


def test_a_symmetric_arch_that_is_spread_does_not_come_to_rest_on_an_unstable_equilibrium():
    """It did at 19 mm, as the time of a step grew; with 0.5 % of vertical movement it falls at 0.649 m."""
    model = arch_of(Material(20.0, 0.6, 1e7), 7)
    found = pushdown(model, "destro", (0.01, 0.0), increment=4e-3, contacts="elastic", to_collapse=True)
    assert found.ultimate == pytest.approx(0.649, rel=0.02)


def test_blocks_that_slide_are_held_by_friction_that_follows_the_normal_force(monkeypatch):
    """Under the friction that they have at the moment they would not stay; kicked they come back to where they were."""
    module, held = import_module("mechanics.procedures.step_control"), []

    def followed(problem, guess, last):
        found = find_equilibrium(problem, guess, last)
        program, index = problem.pose(found.state.positions, found.forces)
        near, layout = taken(found.iterate, index), found.system.layout.take(index)
        spring = np.full(len(program.load), 1e-8 * program.weight / program.step)
        negative, work = inertia(ordered(program, layout), near.forces, near.gaps, spring, False)
        if not (negative == 0 or (negative == 1 and work < 0.0)):
            held.append((problem, found))
        return found

    monkeypatch.setattr(module, "find_equilibrium", followed)
    model, random = random_masonry(8), np.random.default_rng(8)
    pushover(model, None, "+x", "elastic", 0.01 * model.size)
    problem, found = held[0]
    still = replace(problem, start=found.state, work=0.0)
    free, scale = model.movable[:, None], (1.0, 1.0, 1.0 / model.size)
    for _ in range(4):
        kick = np.where(free, random.uniform(-1e-4, 1e-4, (len(model.blocks), 3)), 0.0) * model.size * scale
        rested = motion_to_rest(still, found.state.positions + kick)
        assert way(rested.state.positions, found.state.positions, model.size) < 5e-4 * model.size
