"""Motions by the laws of joints: sliding, apart, on contact points, crushed."""

from dataclasses import replace

import numpy as np
import pytest

from assessment.analyses.time_history import Setting, Shaking, respond
from assessment.benchmark.measure import assembly
from assessment.project.model import build_model
from assessment.project.motions import history_motions
from assessment.project.project import load_project
from mechanics import ArgumentError, Assembly, Block, Material, State, TimeHistory, pushdown, time_history
from mechanics.procedures import settled
from mechanics.procedures.motion_start import HISTORY, HistoryTolerances, Integrator, first_frequency
from mechanics.procedures.time_history import _notes
from mechanics.steps.dynamic_system import Halving
from mechanics.types import GRAVITY, Array
from tests.support.analysed import arch
from tests.support.structures import (
    block_on_base,
    built,
    column,
    on_base,
    rectangle,
    running_bond,
    semicircular_arch,
)

G = 9.80665


def between_walls(friction: float, stiffness: float) -> Assembly:
    """A beam of 1.8 m, 0.8 m high, that fits between two walls."""
    walls = {"left": (-0.5, 0.0, 0.0, 2.0), "right": (1.8, 0.0, 2.3, 2.0)}
    return built(Material(20.0, friction, stiffness), (0.0, 1.0, 1.8, 1.8), **walls)


@pytest.mark.parametrize(("friction", "stiffness"), [(0.84, 1e5), (0.84, 1e7), (np.inf, 1e6)])
def test_a_beam_that_nothing_presses_between_walls_falls_freely(friction, stiffness):
    """½gt² in 0.3 s, whatever friction, stiffness and step; it was held by the lift of its slides."""
    model = between_walls(friction, stiffness)
    motion = time_history(model, np.zeros(round(0.3 / 0.005) + 1), 0.005, "elastic")
    fallen = motion.positions[0, 2, 1] - motion.positions[-1, 2, 1]
    assert fallen == pytest.approx(0.5 * G * 0.3**2, rel=1e-6)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_block_that_slides_does_not_lift(contacts):
    """A slide of millimetres; by the associative law with its lift it would rise by μ times as much."""
    model = block_on_base(1.0, 0.5, friction=0.3, stiffness=1e6)
    shaken = 0.6 * np.sin(3.0 * np.pi * np.arange(0.0, 1.0, 0.002))
    motion = time_history(model, shaken, 0.002, contacts)
    slid = float(abs(motion.positions[:, 1, 0] - motion.positions[0, 1, 0]).max())
    lifted = float((motion.positions[:, 1, 1] - motion.positions[0, 1, 1]).max())
    assert slid > 0.02
    assert lifted < 1e-3 * 0.3 * slid
    assert motion.lifting == 0


def test_peaks_of_a_sliding_wall_do_not_hang_on_the_step():
    """Peaks at half the step within 3 %; few steps need the associative law."""
    model = running_bond(4, 6, friction=0.6, stiffness=1e6)
    rng = np.random.default_rng(1)
    frequency, phase = rng.uniform(0.5, 5.0, 12), rng.uniform(0.0, 2.0 * np.pi, 12)
    peaks = []
    for step in (0.005, 0.0025):
        time = np.arange(0.0, 2.0, step)[:, None]
        motion = time_history(model, 0.2 * np.sin(2.0 * np.pi * frequency * time + phase).sum(axis=1), step)
        peaks.append(float(abs(motion.positions[:, :, 0] - motion.positions[0, :, 0]).max()))
        assert motion.lifting == 0
    assert peaks[1] == pytest.approx(peaks[0], rel=0.03)


def test_steps_that_lift_are_told():
    """From a thousandth of the programs on."""
    model = block_on_base(1.0, 0.5, friction=0.3, stiffness=1e6)
    moved = time_history(model, 0.6 * np.sin(np.arange(0.0, 3.0, 0.03)), 0.002)
    still = moved.energy
    told = _notes(model, moved.positions[-1], still, 0.002, 0.0, HISTORY)
    assert any("Coulomb's law was not solved in 0.2%" in note for note in told)
    assert not any(
        "Coulomb" in note for note in _notes(model, moved.positions[-1], still, 0.0005, 0.0, HISTORY)
    )


def test_a_jammed_arch_hardly_lifts():
    """0.2 s of an arch of 362 blocks: at most one program in 500 lifts, and hardly any begins from nothing."""
    shaken = 0.6 * np.sin(10.0 * np.pi * np.arange(0.0, 0.2, 0.005))
    motion = time_history(assembly("triumphal-arch"), shaken, 0.005)
    assert motion.programs > 80
    assert motion.lifting <= 0.002 * motion.programs
    assert motion.cold <= 0.02 * motion.programs


def shaken_block(
    stiffness: float, step: float, integrator: Integrator = "auto", tolerances: HistoryTolerances = HISTORY
) -> TimeHistory:
    """A low block that slides forth and back on elastic joints, 5 % of damping; the base motion is that of 10 ms."""
    given = np.arange(0.0, 1.0, 0.01)
    time = np.arange(0.0, given[-1] + 1e-9, step)
    shaken = np.interp(time, given, 0.6 * np.sin(3.0 * np.pi * given))
    model = block_on_base(1.0, 0.5, friction=0.3, stiffness=stiffness)
    return time_history(
        model, shaken, step, "elastic", integrator=integrator, damping_ratio=0.05, tolerances=tolerances
    )


def slid(motion: TimeHistory) -> Array:
    """Way (k,) m of the block every 10 ms."""
    moved = motion.positions[:: round(0.01 / motion.time[1]), 1, 0]
    return moved - moved[0]


def test_elastic_joints_turn_back_where_they_do_at_shorter_steps():
    """Without steps halved where a slide turns it is 11 % off at 10 ms, 4 % at 5 ms."""
    fine = slid(shaken_block(1e6, 0.0003125))
    for step in (0.01, 0.005):
        motion = shaken_block(1e6, step)
        assert abs(slid(motion) - fine).max() < 0.01 * abs(fine).max()
        assert motion.sliding_error < 0.01
        assert motion.energy.imbalance < 1e-4
        assert not [note for note in motion.notes if "steps are long" in note]


@pytest.mark.parametrize(
    ("integrator", "least", "most"), [("implicit-euler", 0.5, 1.5), ("second-order", 0.1, 1.0)]
)
def test_steps_too_long_for_slides_are_told_with_the_error(integrator: Integrator, least: float, most: float):
    """No step is halved. By implicit Euler about that of the motion, else the root of what is unsure: the least."""
    fine = slid(shaken_block(1e7, 0.0003125))
    coarse = shaken_block(1e7, 0.01, integrator, HistoryTolerances(closing=Halving(0, np.inf)))
    assert [note for note in coarse.notes if "steps are long" in note]
    error = abs(slid(coarse) - fine).max() / abs(fine).max()
    assert least < coarse.sliding_error / error < most


def test_springs_of_joints_that_slide_leave_nothing_to_the_integrator():
    """What a slide takes is friction's, also where a spring reaches the bound of friction within a step."""
    energy = shaken_block(1e6, 0.005).energy
    assert energy.friction[-1] > 0.9 * energy.dissipated[-1]
    assert energy.integrator_share < 1e-3


STONE = Material(18.0, 0.6, 1e6)
STACK = [
    Block(rectangle(0.0, 0.0, 0.2, 0.6), 1.0, STONE),
    Block(rectangle(-0.02, 0.6, 0.2, 1.1), 1.0, STONE),
    Block(rectangle(-0.3, -0.2, 0.3, 0.0), 1.0, STONE, support="base"),
]
BESIDE = Block(rectangle(-0.2, 0.0, 0.0, 0.4), 1.0, STONE)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_block_carried_away_leaves_the_stack_as_it_would_move_alone(contacts):
    """Its joint comes first in the model; the matrix has a place for it, and nothing there."""
    shaking = 0.5 * np.sin(8.0 * np.pi * 0.005 * np.arange(40))
    alone = Assembly(STACK)
    both = Assembly([BESIDE, *STACK])
    assert (both.joints.a[0], both.joints.b[0]) == (0, 1)
    positions = both.initial.positions.copy()
    positions[0, 0] -= 0.7
    # moving, so that neither settles on its springs first
    states = [State(p, np.full_like(p, 1e-9)) for p in (alone.initial.positions, positions)]
    one, other = (
        time_history(model, shaking, 0.005, contacts, state, "implicit-euler")
        for model, state in zip((alone, both), states, strict=True)
    )
    assert abs(one.positions - one.positions[0]).max() > 1e-3
    assert other.positions[:, 1:] == pytest.approx(one.positions, abs=1e-5)


def test_a_small_arch_that_breaks_apart_is_solved_to_its_collapse(tmp_path):
    """An impact in a step of 10 µs: forces that stop the blocks are thousands of weights, gaps thousands of steps."""
    project = load_project(arch(tmp_path / "arch"))
    [motion] = history_motions(project)
    setting = Setting(project.history[0], project.control_point(None))
    model = build_model(project).assembly
    found = respond(Shaking(model, motion, setting, model.initial))
    assert found.collapsed and found.worst <= 1e-7


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_blocks_without_any_joint_fall(contacts):
    """Free fall from 0.5 m above the base for 0.2 s: g t²/2, as trapezes have it exactly."""
    apart = on_base(STONE, (-0.3, -0.2, 0.3), (0.0, 0.5, 0.2, 1.0))
    assert len(apart.contacts) == 0
    motion = time_history(apart, np.zeros(41), 0.005, contacts)
    fallen = motion.positions[0] - motion.positions[-1]
    assert fallen[1] == pytest.approx([0.0, 0.5 * 9.80665 * 0.2**2, 0.0], abs=1e-9)


SIDE, STIFFNESS, SPIN, STEP = 0.8, 2e5, 0.002, 1e-4  # m, kN/m³, rad/s, s
SEGMENTS = [None, 1, 2, 4, 7]


def swing(segments: int | None, duration: float, damping: float = 0.0) -> tuple[TimeHistory, float, float]:
    """A cube that is turned about the middle of its base so slowly that all of its bed remains pressed.

    The motion; its stiffness, kNm, and its inertia, t m², about there: the bed's kL³/12 (1 + 2/n²) less what the weight
    takes of it.
    """
    model = column(SIDE, SIDE, 1, stiffness=STIFFNESS, segments=segments)
    start = settled(model, None).state
    velocities = np.zeros_like(start.velocities)
    velocities[1] = -0.5 * SIDE * SPIN, 0.0, SPIN
    motion = time_history(
        model, np.zeros(round(duration / STEP) + 1), STEP, "elastic",
        replace(start, velocities=velocities, carrying=None), control=(0.5 * SIDE, SIDE), damping_ratio=damping,
    )  # fmt: skip
    n, m = (motion.forces[1:, 0, i] for i in range(2))
    assert (abs(m) < n * SIDE / 6.0).all()  # within the core
    mass, _, inertia = model.mass[1]
    turns = STIFFNESS * SIDE**3 / 12.0 * (1.0 if segments is None else 1.0 + 2.0 / segments**2)
    return motion, turns - mass * GRAVITY * 0.5 * SIDE, inertia + mass * (0.5 * SIDE) ** 2


@pytest.mark.parametrize("segments", SEGMENTS)
def test_a_block_that_rocks_on_its_closed_bed_swings_for_ever(segments: int | None) -> None:
    motion, stiffness, inertia = swing(segments, 0.1)
    energy, rate = motion.energy, np.sqrt(stiffness / inertia)
    assert abs(energy.integrator).max() < 1e-7 * energy.kinetic[0]
    assert energy.mechanical == pytest.approx(energy.mechanical[0], abs=2e-5 * energy.kinetic[0])
    assert motion.notes == () and motion.halvings < 0.5 * motion.steps
    expected = -SIDE * SPIN / rate * np.sin(rate * motion.time)
    assert motion.displacement == pytest.approx(expected, abs=5e-3 * abs(expected).max())


@pytest.mark.parametrize("segments", SEGMENTS)
def test_dashpots_let_it_decay_as_the_damping_ratio_says(segments: int | None) -> None:
    """Of the first frequency, which knows no weight and very stiff shear: nearly that of this swing."""
    ratio = 0.05
    motion, stiffness, inertia = swing(segments, 0.1, ratio)
    model = column(SIDE, SIDE, 1, stiffness=STIFFNESS, segments=segments)
    rate = np.sqrt(stiffness / inertia)
    assert first_frequency(model) == pytest.approx(rate, rel=2e-3)
    decay, damped = ratio * rate, rate * np.sqrt(1.0 - ratio**2)
    expected = -SIDE * SPIN / damped * np.exp(-decay * motion.time) * np.sin(damped * motion.time)
    assert motion.displacement == pytest.approx(expected, abs=5e-3 * abs(expected).max())
    energy = motion.energy
    assert energy.viscous[-1] == pytest.approx(energy.mechanical[0] - energy.mechanical[-1], rel=1e-4)
    assert abs(energy.integrator).max() < 1e-6 * energy.viscous[-1]


@pytest.mark.parametrize("segments", [1, 4])
def test_a_column_that_rocks_on_its_points_is_warned_of_nothing(segments: int) -> None:
    """With lift-off, damped: closing points take little, and few steps are halved."""
    record = 0.15 * np.sin(6.0 * np.pi * np.arange(0.0, 1.0, 0.005))
    model = column(0.4, 1.6, 3, stiffness=2e5, segments=segments)
    motion = time_history(model, record, 0.005, "elastic", damping_ratio=0.05)
    assert all("may fall after it" in note for note in motion.notes)
    assert motion.halvings < 0.6 * motion.steps
    assert motion.energy.integrator_share < 0.1


WEIGHT, TIMES = 20.0, 3.0  # kN; the bed bears three times the weight
SOFT, STIFF = 1e6, 1e7  # kN/m³


def block(strength: float, height: float = 1.0, stiffness: float = SOFT) -> Assembly:
    stone = Material(WEIGHT, 0.7, stiffness, compressive_strength=strength)
    return on_base(stone, (-2, -0.5, 2), (-0.5, 0, 0.5, height))


@pytest.fixture(scope="module")
def thrown_up():
    """A base thrown upward with 4 g for 50 ms, then 0.6 s of rest."""
    pulse, step = 0.05, 0.0005
    time = np.arange(0.0, 0.65, step)
    upward = np.where(time < pulse, 4.0, 0.0)
    return time_history(
        block(TIMES * WEIGHT, stiffness=STIFF), 0.0 * time, step, "elastic", vertical_acceleration=upward
    )


def test_a_bed_is_crushed_by_what_it_cannot_bear(thrown_up):
    """N = 3 W: relative to the base 1 + 4 − 3 = 2 g down for t, then 2 g up: twice 2 g t²/2 deep."""
    deep = 2.0 * GRAVITY * 0.05**2
    down = -(thrown_up.positions[:, 1, 1] - thrown_up.positions[0, 1, 1])
    assert down.max() == pytest.approx(deep, rel=0.01)


def test_what_is_crushed_stays_so(thrown_up):
    """The block rests where it was pressed to, less the springs: a bed without memory lifted it to where it began."""
    down = -(thrown_up.positions[:, 1, 1] - thrown_up.positions[0, 1, 1])
    assert down[-200:].min() == pytest.approx(down.max(), abs=2.0 * TIMES * WEIGHT / STIFF)
    assert thrown_up.energy.friction[-1] == pytest.approx(TIMES * WEIGHT * down.max(), rel=0.01)
    assert thrown_up.energy.imbalance < 1e-5


@pytest.mark.parametrize("integrator", ["second-order", "moreau-jean", "implicit-euler"])
def test_rocking_on_edges_that_crush_loses_energy_to_them(integrator):
    """4 m high under a pulse that rocks it: the balance is closed, and the strong bed has no loss of yielding."""
    time = np.arange(0.0, 3.0, 0.005)
    record = 0.25 * np.sin(2.4 * np.pi * time) * np.exp(-((time - 1.5) ** 2))
    weak, strong = (
        time_history(block(strength, 4.0), record, 0.005, "elastic", integrator=integrator)
        for strength in (20.0 * WEIGHT, 1e3 * WEIGHT)
    )
    assert max(weak.energy.imbalance, strong.energy.imbalance) < 1e-4
    assert strong.energy.friction[-1] < 1e-6 * strong.energy.turnover
    assert weak.energy.friction[-1] > 0.1 * weak.energy.turnover
    assert weak.positions[-1, 1, 1] < strong.positions[-1, 1, 1]


def test_peaks_of_crushed_edges_converge_and_integrators_agree():
    """Measured: 0.0602, 0.0609, 0.0615 rad by the second order, 0.0562, 0.0589, 0.0602 by implicit Euler."""
    peaks = {}
    for step in (0.005, 0.0025, 0.00125):
        time = np.arange(0.0, 3.0, step)
        record = 0.25 * np.sin(2.4 * np.pi * time) * np.exp(-((time - 1.5) ** 2))
        for integrator in ("second-order", "implicit-euler"):
            motion = time_history(block(20.0 * WEIGHT, 4.0), record, step, "elastic", integrator=integrator)
            peaks[integrator, step] = abs(motion.positions[:, 1, 2]).max()
    finest = peaks["second-order", 0.00125]
    assert peaks["second-order", 0.0025] == pytest.approx(finest, rel=1.5e-2)
    assert peaks["implicit-euler", 0.00125] == pytest.approx(finest, rel=3e-2)


def test_a_crushed_state_at_rest_stays_at_rest():
    """Half the strength's load on a tilted bed: the state of a pushdown, shaken by nothing."""
    model = block(4.0 * WEIGHT, 2.0)
    moved = pushdown(model, "base", rotation=0.1, increment=0.01, contacts="elastic")
    motion = time_history(model, np.zeros(200), 0.005, "elastic", state=moved.final)
    assert abs(motion.positions[:, 1] - moved.final.positions[1]).max() < 1e-5
    assert motion.energy.friction[-1] < 1e-6


def test_rigid_joints_that_can_be_crushed_are_refused():
    """They forgot it at every step: a block that should rock sank into its base and stayed there."""
    with pytest.raises(ArgumentError, match=r"contacts = 'rigid'.*compressive_strength"):
        time_history(block(TIMES * WEIGHT), np.zeros(10), 0.01, "rigid")


def test_a_bed_of_finite_strength_is_exact_whatever_segments_are_asked_for():
    """Newton's method let its points bear any pressure, and the interior point crushed the exact bed."""
    record = 0.3 * np.sin(2.4 * np.pi * np.arange(0.0, 1.5, 0.005))
    exact = block(20.0 * WEIGHT, 4.0)
    motions = [
        time_history(Assembly(exact.blocks, segments_per_joint=number), record, 0.005, "elastic").positions
        for number in (None, 2)
    ]
    assert motions[1] == pytest.approx(motions[0], abs=1e-9)


def test_a_bed_crushed_flat_stays_so_where_the_block_rocks_on_edges_that_crush_deeper():
    """Two lines kept nothing of the flat pressing: the middle was whole again, and a tenth of the work came back."""
    step = 0.001
    time = np.arange(0.0, 2.6, step)
    upward = np.where(time < 0.08, 3.5, 0.0)
    record = np.where(time > 0.6, 0.5 * np.sin(4.0 * np.pi * (time - 0.6)), 0.0)
    motion = time_history(block(8.0 * WEIGHT, 3.0), record, step, "elastic", vertical_acceleration=upward)
    crushed = motion.energy.friction
    assert abs(motion.positions[:, 1, 2]).max() > 0.02
    assert -np.diff(crushed).clip(max=0.0).sum() < 5e-3 * crushed[-1]


@pytest.mark.parametrize(("seed", "level"), [(3, 0.3), (4, 0.4)])
def test_motions_in_which_faces_are_crushed_all_over_are_solved(seed, level):
    """An arch whose joints crush as it falls: steps were given up, however short, where many joints changed."""
    model, rng = semicircular_arch(13, 0.23, 0.7, 1e6, strength=250.0), np.random.default_rng(seed)
    time = np.arange(0.0, 4.0, 0.005)[:, None]
    frequency, phase = rng.uniform(0.5, 4.0, 12), rng.uniform(0.0, 6.28, 12)
    shaken = np.sin(2.0 * np.pi * frequency * time + phase).sum(axis=1)
    shaken *= level * np.minimum(time[:, 0], 1.0) / abs(shaken).max()
    assert time_history(model, shaken, 0.005, "elastic", damping_ratio=0.05).collapsed
