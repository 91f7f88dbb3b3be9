"""Rest: of settled structures as a motion begins there, of elastic ones however stiff, and never an unstable one."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from mechanics import (
    Assembly,
    Block,
    ConvergenceError,
    NoEquilibriumError,
    State,
    TimeHistory,
    pushdown,
    pushover,
    time_history,
)
from mechanics.errors import RunawayError
from mechanics.kernels.joint import H
from mechanics.steps import geometry_iteration
from mechanics.steps import rest as module
from mechanics.steps.equilibrium import rest, rest_size
from mechanics.steps.rest import come_down, lifted, motion_to_rest, way
from mechanics.steps.static_step import StepProblem
from mechanics.steps.static_system import static_system
from mechanics.steps.tolerances import REST, STEP
from mechanics.types import GRAVITY
from tests.support.structures import arch_on_piers, block_on_base, column, rectangle, running_bond

SETTLED = {"support": "base", "rotation": 0.03, "increment": 0.01}


def wall() -> Assembly:
    return running_bond(3, 4, stiffness=1e6)


def unshaken(model: Assembly, state: State, contacts: str) -> TimeHistory:
    return time_history(model, np.zeros(60), 0.005, contacts, state)


def farthest(positions: np.ndarray, others: np.ndarray) -> float:
    """The longest way (m) of a block."""
    return float(abs(positions - others)[:, :2].max())


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_settlement_ends_where_a_motion_without_shaking_stays(contacts):
    path = pushdown(wall(), **SETTLED, contacts=contacts)
    motion = unshaken(wall(), path.final, contacts)
    assert farthest(motion.positions[-1], path.final.positions) < 2e-5


def test_a_rigid_settlement_comes_to_rest_on_elastic_joints_before_it_is_shaken():
    state = pushdown(wall(), **SETTLED).final
    motion = unshaken(wall(), state, "elastic")
    assert farthest(motion.positions[-1], motion.start.positions) < 2e-5


def test_a_joint_that_carries_is_closed_in_a_rigid_motion_whatever_gap_was_left():
    """A block a hundredth of a millimetre above its base, which bears it or does not."""
    model = block_on_base(0.6, 4.2)
    above = model.initial.positions.copy()
    above[model.movable, 1] += 1e-5
    still = np.zeros_like(above)
    closed = unshaken(model, State(above, still, carrying=np.array([True])), "rigid")
    falls = unshaken(model, State(above, still), "rigid")
    assert farthest(closed.positions[-1], above) < 1e-8
    # a gap that is none
    assert farthest(falls.positions[-1], above) == pytest.approx(1e-5, abs=1e-6 * model.size)


def raised(model: Assembly, height: float) -> StepProblem:
    """Gravity on a block at a height (m) above its rest."""
    system = static_system(model, "elastic")
    over = rest(system, model.initial).state.positions.copy()
    over[model.movable, 1] += height
    start = State(over, np.zeros_like(over))
    return StepProblem(system, start, model.dead_load, rest_size(model, "elastic"))


def test_what_hangs_above_its_joint_comes_to_rest_on_it():
    model = block_on_base(0.6, 4.2, stiffness=1e6)
    problem = raised(model, 0.1)
    rested = motion_to_rest(problem, problem.start.positions)
    expected = rest(static_system(model, "elastic"), model.initial)
    assert farthest(rested.state.positions, expected.state.positions) < 1e-4
    assert lifted(rested) <= REST.lifted * model.size


def test_what_falls_does_not_come_to_rest():
    """A block far above its base, and one turned beyond its edge."""
    model = block_on_base(0.6, 4.2, stiffness=1e6)
    high = raised(model, 2.0)
    with pytest.raises(NoEquilibriumError, match="falls: left to itself"):
        motion_to_rest(high, high.start.positions)
    turned = model.rotated(1, (0.6, 0.0), -0.2)
    with pytest.raises(NoEquilibriumError, match="falls: left to itself"):
        motion_to_rest(replace(high, start=turned), turned.positions)


def test_what_comes_to_no_rest_is_refused():
    model = block_on_base(0.6, 4.2, stiffness=1e6)
    problem = raised(model, 0.1)
    with pytest.raises(ConvergenceError, match="does not come to rest"):
        motion_to_rest(problem, problem.start.positions, replace(REST, steps=1))


def test_what_falls_all_the_time_has_fallen_though_its_step_half_way_is_taken_again(monkeypatch):
    high, calls, step = raised(block_on_base(0.6, 4.2, stiffness=1e6), 2.0), [], module._step_from_rest

    def too_long_half_way(*given):
        calls.append(1)
        return None if len(calls) == 4 else step(*given)

    monkeypatch.setattr(module, "_step_from_rest", too_long_half_way)
    with pytest.raises(RunawayError, match="does not come to rest"):
        motion_to_rest(high, high.start.positions, replace(REST, steps=6, farthest=10.0))


@pytest.mark.parametrize(("share", "error"), [(0.97, RunawayError), (0.93, ConvergenceError)])
def test_what_slows_down_as_it_moves_has_not_fallen(monkeypatch, share, error):
    """Of six steps the forces of the fourth and the sixth are compared: a fall keeps nine tenths of it."""
    high, step, steps = raised(block_on_base(0.6, 4.2, stiffness=1e6), 2.0), module._step_from_rest, []

    def slower(now, at, *more):
        found = step(now, at, *more)
        steps.append(found)
        return replace(found, at=at + share ** len(steps) * (found.at - at))

    monkeypatch.setattr(module, "_step_from_rest", slower)
    with pytest.raises(error, match="does not come to rest"):
        motion_to_rest(high, high.start.positions, replace(REST, steps=6, farthest=10.0))


def test_a_motion_without_inertia_left_is_not_repeated(monkeypatch):
    """Blocks that rest, to rounding, where no static program is certified: the rest is undecided, and told at once."""
    problem = raised(block_on_base(0.6, 4.2, stiffness=1e6), 0.0)
    steps = []

    def undecided(*_):
        steps.append(1)
        raise ConvergenceError("undecided")

    monkeypatch.setattr(module, "find_equilibrium", undecided)
    monkeypatch.setattr(
        module, "certified", lambda *_: replace(rested, certificate=replace(good, equilibrium=1.0))
    )
    rested = rest(static_system(problem.system.model, "elastic"), problem.system.model.initial)
    good = rested.certificate
    with pytest.raises(ConvergenceError, match="does not come to rest"):
        motion_to_rest(problem, problem.start.positions)
    assert len(steps) < 60


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
@pytest.mark.parametrize(("share", "rests"), [(0.9, True), (1.1, False)])
def test_what_does_not_move_at_all_is_at_rest(monkeypatch, contacts, share, rests):
    """Where forces and geometry do not agree to the last digit, but the blocks stay where they are released."""
    model = block_on_base(0.6, 4.2, stiffness=1e6)
    rested = rest(static_system(model, contacts), model.initial)
    problem = StepProblem(rested.system, rested.state, model.dead_load, rest_size(model, contacts))
    step, close = module._step_from_rest, replace(rested.certificate, equilibrium=share * STEP.slow)

    def undecided(*_):
        raise ConvergenceError("undecided")

    def stays(now, at, *more):
        found = step(now, at, *more)
        return found and replace(found, at=at.copy())

    monkeypatch.setattr(module, "_step_from_rest", stays)
    monkeypatch.setattr(module, "find_equilibrium", undecided)
    monkeypatch.setattr(module, "certified", lambda *_: replace(rested, certificate=close))
    if rests:
        assert motion_to_rest(problem, problem.start.positions).certificate == close
    else:
        with pytest.raises(ConvergenceError, match="does not come to rest"):
            motion_to_rest(problem, problem.start.positions)


@pytest.mark.parametrize(("share", "found"), [(0.9, True), (1.1, False)])
def test_rigid_joints_whose_forces_and_geometry_nearly_agree_are_at_rest(monkeypatch, share, found):
    model = block_on_base(0.6, 4.2)
    rested = rest(static_system(model, "rigid"), model.initial)
    close = replace(rested, certificate=replace(rested.certificate, equilibrium=share * STEP.slow))
    problem = StepProblem(rested.system, rested.state, model.dead_load, rest_size(model, "rigid"))
    monkeypatch.setattr(geometry_iteration, "certified", lambda *_: close)
    if found:
        assert geometry_iteration.find_equilibrium(problem, rested.state.positions) is close
    else:
        with pytest.raises(NoEquilibriumError, match="does not settle"):
            geometry_iteration.find_equilibrium(problem, rested.state.positions)


def test_a_lift_counts_from_the_compression_that_forces_ask_for():
    model = block_on_base(0.6, 4.2, stiffness=1e4)
    step = rest(static_system(model, "elastic"), model.initial)
    assert lifted(step) <= 1e-9
    above = replace(step, places=step.places + np.where(np.arange(step.places.shape[1]) == 8, 0.01, 0.0))
    assert above.places[0, H] == step.places[0, H]
    assert lifted(above) == pytest.approx(0.01, rel=1e-6)


@pytest.mark.parametrize(("share", "stays"), [(0.9, True), (1.1, False)])
def test_what_sliding_has_lifted_comes_down_where_it_counts(share, stays):
    """From 5 · 10⁻⁵ of a block on."""
    model = block_on_base(0.6, 4.2)
    step = rest(static_system(model, "rigid"), model.initial)
    above = step.state.positions + model.movable[:, None] * [0.0, share * 5e-5 * model.size, 0.0]
    places = step.system.places(above, step.state)
    up = replace(step, state=replace(step.state, positions=above), places=places)
    down = come_down(up, 1e-4 * model.size)
    assert (down is up) is stays
    if not stays:
        assert down.state.positions == pytest.approx(step.state.positions, abs=1e-8)


def test_a_turn_is_a_way_too():
    positions = np.zeros((2, 3))
    turned = positions + np.array([[0.0, 0.0, 0.0], [1e-3, -2e-3, -0.01]])
    assert way(positions, turned, 0.7) == pytest.approx(0.007)


def test_shears_of_springs_go_on_to_rest():
    """Joints that are elastic in shear, too: what they carry in rest they carry as a motion begins there."""
    blocks = [replace(b, material=replace(b.material, tangential_stiffness=4e5)) for b in wall().blocks]
    path = pushdown(Assembly(blocks), **SETTLED, contacts="elastic")
    motion = unshaken(Assembly(blocks), path.final, "elastic")
    assert path.final.shear is not None and abs(path.final.shear).max() > 0.01
    assert farthest(motion.positions[-1], path.final.positions) < 2e-5


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_block_pulled_aside_is_released_where_it_was_pulled_to(contacts):
    """What carried a block aside is no equilibrium under gravity alone, however near on soft joints one is."""
    model = block_on_base(0.6, 4.2, stiffness=1e4)
    pulled = pushover(model, (0.3, 4.2), "+x", contacts, 0.02, until=0.3).states[-1]
    for state in (pulled, model.rotated(1, (0.6, 0.0), -0.05)):
        motion = unshaken(model, state, "elastic")
        assert np.array_equal(motion.start.positions, state.positions)
        assert farthest(motion.positions[-1], state.positions) > 1e-3


def leaning(blocks, stiffness, lean):
    """The problem of a column 0.3 m wide and 3 m high on elastic joints, and positions that lean upwards (rad)."""
    model = column(0.3, 3.0, blocks, stiffness=stiffness)
    at = model.initial.positions.copy()
    at[model.movable, 2] += lean * np.arange(1, blocks + 1)
    start = State(at, np.zeros_like(at))
    return StepProblem(static_system(model, "elastic"), start, model.dead_load, 1e-3), at


@pytest.mark.parametrize(
    ("blocks", "stiffness", "lean"), [(3, 4800.0, 1e-5), (1, 1200.0, 1e-8), (3, 1200.0, 1e-8)]
)
def test_what_is_unstable_does_not_rest_however_little_is_unbalanced(blocks, stiffness, lean):
    """A block on a bed of k b³/12 per rad (1 m deep) topples where that is less than W H/2: k < 12 000 kN/m³."""
    problem, at = leaning(blocks, stiffness, lean)
    with pytest.raises(RunawayError):
        motion_to_rest(problem, at)


def test_a_step_that_can_be_shorter_leads_at_most_three_times_as_far_as_the_last_imbalance(monkeypatch):
    """Farther away is another solution; what moves freely goes by force · time²."""
    (problem, at), step, told = leaning(1, 20_000.0, 1e-3), module._step_from_rest, []

    def kept(now, at, last, near, shorter):
        found, model = step(now, at, last, near, shorter), now.system.model
        moved = way(at, found.at, model.size)
        assert not shorter or step(now, at, last, 0.9 * moved, shorter) is None
        time = np.sqrt(model.mass[1, 0] * GRAVITY / (now.mass[1, 0] * model.size))
        told.append((time, near, shorter, moved))
        return found

    monkeypatch.setattr(module, "_step_from_rest", kept)
    motion_to_rest(problem, at)
    assert [shorter for *_, shorter, _ in told] == [False] + [True] * 7
    for (time, *_, moved), (longer, near, *_) in pairwise(told[1:]):
        assert near == pytest.approx(3.0 * moved * (longer / time) ** 2)


def test_a_slender_arch_sinks_by_a_hundred_times_what_its_joints_are_compressed():
    """Stiff joints: twice as stiff, half as far."""
    shape = {
        "radius": 2.0, "thickness": 0.3, "voussoirs": 27, "pier_height": 2.0, "pier_width": 0.8,
        "courses": 19,
    }  # fmt: skip
    sunk = []
    for stiffness in (1e8, 2e8):
        model = arch_on_piers(**shape, stiffness=stiffness)
        step = rest(static_system(model, "elastic"), model.initial)
        sunk.append(abs(step.state.positions - model.initial.positions)[:, 1].max())
        assert step.certificate.worst(rest_size(model, "elastic")) < 1e-6
        assert sunk[-1] > 50.0 * rest_size(model, "elastic")
    assert sunk[0] / sunk[1] == pytest.approx(2.0, rel=1e-3)
    assert np.isfinite(sunk).all()


def on_two_supports(wall: Assembly) -> Assembly:
    """A wall whose base is cut in two, left and right."""
    base = wall.blocks[0]
    (x0, z0), (x1, z1) = base.polygon.min(axis=0), base.polygon.max(axis=0)
    middle = 0.5 * (x0 + x1) + 0.13 * wall.size
    halves = [
        Block(rectangle(a, z0, b, z1), base.depth, base.material, support=name)
        for a, b, name in ((x0, middle, "left"), (middle, x1, "right"))
    ]
    return Assembly([*halves, *wall.blocks[1:]])


@pytest.mark.parametrize("integrator", ["implicit-euler", "auto"])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_settled_elastic_wall_left_alone_for_a_second_stays_where_it_is(seed, integrator):
    """Within 0.1 mm: supports moved by up to a seventh of a block, bricks slide, lift and come down."""
    rng = np.random.default_rng(seed)
    columns, courses = (int(n) for n in rng.integers(3, 6, 2))
    size = rng.uniform(0.2, 0.6), rng.uniform(0.1, 0.3)
    wall = on_two_supports(
        running_bond(columns, courses, *size, rng.uniform(0.3, 0.9), 10.0 ** rng.uniform(5.0, 7.0))
    )
    angle = rng.uniform(0.0, 0.5 * np.pi)
    movement = wall.size * rng.uniform(0.02, 0.15) * np.array([np.cos(angle), -np.sin(angle)])
    final = pushdown(wall, "right", movement, 0.0, abs(movement).max() / 5.0, "elastic").final
    motion = time_history(wall, np.zeros(200), 0.005, "elastic", final, integrator)
    assert abs(motion.positions - final.positions)[:, :, :2].max() < 1e-4


WIDTH, HEIGHT, UNIT_WEIGHT = 0.5, 3.0, 20.0  # m, m, kN/m³


def critical_stiffness(blocks: int) -> float:
    """Stiffness (kN/m³) at which an upright column buckles: K = k b³/12 of each joint against the blocks' weight.

    With θ_i the rotations of the joints and Θ = Lθ those of the blocks, the weight does the work ½ ΘᵀDΘ, where block i
    of weight w and height a lowers its centre by ½ aΘ_i²/2 and those above by ½ aΘ_i². Compression is neglected.
    """
    height = HEIGHT / blocks
    weight = UNIT_WEIGHT * WIDTH * height
    above = np.arange(blocks - 1, -1, -1)
    sums = np.tril(np.ones((blocks, blocks)))
    work = sums.T @ np.diag(weight * height * (0.5 + above)) @ sums
    return float(np.linalg.eigvalsh(work).max() / (WIDTH**3 / 12.0))


def settled(stiffness: float, blocks: int):
    model = column(WIDTH, HEIGHT, blocks, stiffness)
    return rest(static_system(model, "elastic", "associative"), model.initial)


@pytest.mark.parametrize("blocks", [1, 2, 6])
def test_an_upright_column_stands_above_its_critical_stiffness(blocks):
    assert settled(1.001 * critical_stiffness(blocks), blocks).stable


@pytest.mark.parametrize("blocks", [1, 2, 6])
@pytest.mark.parametrize("share", [0.98, 0.5])  # the joints' compression, neglected, is 1 % of a block here
def test_an_upright_column_on_softer_joints_is_refused(blocks, share):
    """Its symmetry leaves no direction in which to fall: forces balance, and only the stiffness tells."""
    with pytest.raises(RunawayError, match="balances on an unstable equilibrium"):
        settled(share * critical_stiffness(blocks), blocks)


def test_beyond_the_peak_one_direction_is_held_by_the_push(monkeypatch):
    """K − G has one negative direction there; the work of the push holds it, and under dead load it is refused."""
    found = []
    certified = geometry_iteration.certified

    def kept(problem, now):
        reached = certified(problem, now)
        if problem.lateral is not None:
            dead = problem.load + now.alpha * problem.lateral
            free = certified(replace(problem, lateral=None, load=dead), now)
            found.append((reached.alpha, reached.stable, free.stable))
        return reached

    monkeypatch.setattr(geometry_iteration, "certified", kept)
    curve = pushover(column(0.5, 3.0, 1, 2e5), (0.25, 2.9), contacts="elastic", increment=0.01)
    peak = int(np.argmax([alpha for alpha, _, _ in found]))
    assert len(found) > peak + 20
    assert all(pushed for _, pushed, _ in found)
    assert all(free for *_, free in found[: peak - 1])
    assert not any(free for *_, free in found[peak + 2 :])
    assert curve.steps
