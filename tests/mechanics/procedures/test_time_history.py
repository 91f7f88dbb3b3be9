"""Time histories: invariants, energy, collapse, messages."""

import numpy as np
import pytest

from assessment.benchmark.motions import shaking
from mechanics import Assembly, Block, ConvergenceError, Material, State, TimeHistory, pushdown, time_history
from mechanics.procedures.collapse import ControlPoint, collapse
from mechanics.procedures.energy import Energy
from mechanics.procedures.motion_start import Integrator
from mechanics.steps import dynamic_system
from tests.support.structures import arch_on_piers, block_on_base, on_base, rectangle, semicircular_arch

SCHEMES = [(c, i) for c in ("rigid", "elastic") for i in ("implicit-euler", "second-order", "moreau-jean")]
STEP = 0.005


def burst(amplitude: float, n: int = 100, frequency: float = 2.0) -> np.ndarray:
    return amplitude * np.sin(2.0 * np.pi * frequency * STEP * np.arange(n))


def two_blocks(scale: float = 1.0, shift: tuple[float, float] = (0.0, 0.0), turned: bool = False) -> Assembly:
    """A block on a block on a base, not symmetrical; `turned`: listed from the top."""
    stone = Material(18.0, 0.6, 1e6)
    shapes = [((-1.0, -0.2, 1.0, 0.0), "base"), ((-0.1, 0.0, 0.1, 0.6), None), ((-0.12, 0.6, 0.1, 1.1), None)]
    blocks = [
        Block(scale * np.array(rectangle(*corners)) + shift, scale, stone, support=support)
        for corners, support in shapes
    ]
    return Assembly(blocks[::-1] if turned else blocks)


@pytest.mark.parametrize(
    ("blocks", "contacts", "integrator", "why"),
    [
        (3, "rigid", "second-order", "3 movable blocks: every impact is located"),
        (4, "rigid", "moreau-jean", "4 movable blocks: many impacts, resolved where they take energy"),
        (4, "elastic", "second-order", "elastic joints: steps are halved where closing joints take energy"),
    ],
)
def test_the_integrator_that_is_chosen_and_why(blocks: int, contacts: str, integrator: str, why: str) -> None:
    stone = Material(18.0, 0.6, 1e6)
    row = ((0.2 * k, 0.0, 0.2 * k + 0.1, 0.2) for k in range(blocks))
    motion = time_history(on_base(stone, (-0.1, -0.2, 0.8), *row), np.zeros(3), STEP, contacts)
    assert motion.integrator == integrator and motion.chosen.startswith(why)


@pytest.mark.parametrize(("contacts", "integrator"), SCHEMES)
def test_no_motion_without_a_record(contacts: str, integrator: str) -> None:
    for model in (arch_on_piers(voussoirs=9, courses=3), two_blocks()):
        motion = time_history(model, np.zeros(30), STEP, contacts, integrator=integrator)
        moved = abs(motion.positions - motion.start.positions)
        settlement = abs(motion.start.positions - model.initial.positions).max()
        # the statics' tolerance of a thousandth is swung through, undamped, to either side
        assert moved.max() < 1e-6 * model.size + 4e-3 * settlement
        assert not motion.collapsed and motion.notes == ()


@pytest.mark.parametrize(("contacts", "integrator"), SCHEMES)
def test_mirrored_record_gives_the_mirrored_motion(contacts: str, integrator: str) -> None:
    model = block_on_base(0.6, 4.2)
    a, b = (
        time_history(model, sign * burst(0.25), STEP, contacts, integrator=integrator).positions[:, 1]
        for sign in (1, -1)
    )
    a, b = a - a[0], b - b[0]
    assert abs(a[:, 2]).max() > 1e-3, "it rocks"
    assert a[:, [0, 2]] == pytest.approx(-b[:, [0, 2]], abs=1e-4 * abs(a).max())


@pytest.mark.parametrize(("contacts", "integrator"), SCHEMES)
def test_place_and_order_of_the_blocks_do_not_matter(contacts: str, integrator: str) -> None:
    def moved(model: Assembly) -> np.ndarray:
        motion = time_history(model, burst(0.3, 60), STEP, contacts, integrator=integrator)
        return motion.positions - motion.positions[0]

    reference = moved(two_blocks())
    assert abs(reference).max() > 1e-3
    near = 1e-3 * abs(reference).max()
    assert moved(two_blocks(shift=(3.0, -2.0))) == pytest.approx(reference, abs=near)
    assert moved(two_blocks(turned=True))[:, ::-1] == pytest.approx(reference, abs=near)


@pytest.mark.parametrize(("contacts", "integrator"), SCHEMES)
def test_similitude(contacts: str, integrator: str) -> None:
    """At 1:100 with time ten times as fast the same accelerations give a hundredth of the displacements."""
    big = time_history(two_blocks(), burst(0.3, 60), STEP, contacts, integrator=integrator)
    small = time_history(two_blocks(0.01), burst(0.3, 60), 0.1 * STEP, contacts, integrator=integrator)
    moved = [m.positions - m.positions[0] for m in (big, small)]
    scale = np.array([0.01, 0.01, 1.0])
    assert moved[1] == pytest.approx(scale * moved[0], abs=1e-3 * abs(moved[1]).max())


@pytest.mark.parametrize(
    ("contacts", "integrator", "open_share"),
    [
        ("rigid", "implicit-euler", 1e-6),
        ("rigid", "second-order", 1e-3),
        ("elastic", "implicit-euler", 0.03),  # its geometry is that of the beginning of the step
        ("elastic", "second-order", 1e-3),
    ],
)
def test_energy_balance(contacts: str, integrator: str, open_share: float) -> None:
    """Every term is computed on its own; what they leave open is small, and no term is negative that cannot be."""
    motion = time_history(block_on_base(0.6, 4.2), burst(0.25), STEP, contacts, integrator=integrator)
    energy = motion.energy
    assert energy.input.max() > 0.0
    assert energy.imbalance < open_share
    assert energy.imbalance == pytest.approx(abs(energy.residual).max() / energy.turnover)
    spent = np.stack([energy.friction, energy.impact, energy.viscous, energy.integrator])
    assert np.diff(spent, axis=1).min() > -1e-3 * energy.turnover


def test_energy_of_springs_and_dashpots_is_in_the_balance() -> None:
    """A block that falls on its elastic joint, whose shear yields too."""
    stone = Material(18.0, 0.6, 1e5, tangential_stiffness=5e4)
    model = on_base(stone, (-1.0, -0.2, 1.0), (-0.25, 0.0, 0.25, 0.5))
    positions, velocities = model.initial.positions.copy(), np.zeros((2, 3))
    positions[1, 1] += 0.01
    velocities[1, 0] = 0.05
    motion = time_history(model, np.zeros(600), 2e-4, "elastic", State(positions, velocities), "second-order",
                          damping_ratio=0.02)  # fmt: skip
    energy = motion.energy
    assert energy.elastic.max() > 0.5 * energy.turnover
    assert energy.viscous[-1] > 0.05 * energy.turnover
    assert energy.imbalance < 1e-3
    assert np.diff(energy.viscous).min() >= 0.0


def test_midpoint_rule_with_elastic_contacts_gives_next_to_no_energy() -> None:
    """Rocking on joints so stiff that impacts are shorter than a step: they take energy, and nothing else does."""
    model = block_on_base(0.6, 4.2, friction=2.0, stiffness=5e8)
    state = model.rotated(1, (0.6, 0.0), -0.07)
    for step in (0.01, 0.0025):
        motion = time_history(model, np.zeros(round(3.0 / step)), step, "elastic", state, "second-order")
        energy = motion.energy
        assert np.diff(energy.integrator).min() > -5e-4 * energy.turnover
        assert np.diff(energy.mechanical).max() < 1e-4 * energy.turnover
        assert energy.imbalance < 1e-3


def test_implicit_euler_dissipates_what_its_formula_says() -> None:
    """Where no contact works (free flight), ½ΔvᵀMΔv a step: v grows by gΔt."""
    model = block_on_base(0.5, 0.5)
    positions = model.initial.positions.copy()
    positions[1, 1] += 1.0
    start = State(positions, np.zeros_like(positions))
    motion = time_history(model, np.zeros(20), STEP, "rigid", start, "implicit-euler")
    lost = 0.5 * model.weight * 9.80665 * STEP**2
    assert np.diff(motion.energy.integrator) == pytest.approx(lost, rel=1e-6)


def overturning(**kwargs: object) -> TimeHistory:
    return time_history(
        block_on_base(0.2, 1.0), np.full(400, 0.4), STEP, "rigid", control=(0.2, 1.0), **kwargs
    )


def test_overturning_block_collapses_and_the_run_stops() -> None:
    motion = overturning()
    assert motion.collapsed and "turned" in motion.collapse_reason
    assert motion.time_of_collapse == motion.time[-1] < 2.0
    assert len(motion.time) == len(motion.positions) == len(motion.velocities) == len(motion.displacement)
    assert motion.displacement[-1] < -0.3


@pytest.mark.parametrize("tilted", [0.55, 0.95])
def test_a_block_released_beyond_its_balance_collapses(tilted: float) -> None:
    """It lies flat at π/2, which is less than 1 rad from where it began."""
    model = block_on_base(0.3, 1.5, friction=5.0)
    start = model.rotated(block=1, about=tuple(model.blocks[1].vertices[1]), rotation=-tilted)
    motion = time_history(model, np.zeros(400), 0.005, state=start)
    assert motion.collapsed and "turned" in motion.collapse_reason


def test_a_block_that_lies_on_its_side_before_a_motion_is_not_toppled_by_it() -> None:
    """It slides there and back, as it would have from its base."""
    model = block_on_base(0.4, 0.6, friction=0.7)
    x = model.initial.positions.copy()
    x[1] += (0.0, -0.1, -0.5 * np.pi)
    motion = time_history(model, burst(0.9), STEP, state=State(x, np.zeros_like(x)))
    assert not motion.collapsed and abs(motion.positions - x).max() > 0.01


def test_a_fall_that_goes_on_after_the_record_is_a_collapse() -> None:
    """However far the block has turned where the record ends: 0.55 to 0.9 rad."""
    model, whole = block_on_base(0.2, 1.0), overturning()
    for turned in (0.55, 0.75, 0.9):
        at = int(np.argmax(abs(whole.positions[:, 1, 2]) > turned))
        first = time_history(model, np.full(at, 0.4), STEP)
        assert not first.collapsed
        assert time_history(model, np.zeros(400), STEP, state=first.final).collapsed


def test_ultimate_displacement_ends_the_run_earlier() -> None:
    motion = overturning(ultimate=0.25)
    assert motion.collapsed and "ultimate" in motion.collapse_reason
    assert motion.time_of_collapse < overturning().time_of_collapse
    assert abs(motion.displacement[-1]) == pytest.approx(0.25, abs=0.05)


def test_control_point_past_its_ultimate_and_coming_back_is_no_collapse() -> None:
    model = block_on_base(0.2, 1.0)
    x, point = model.rotated(1, (0.2, 0.0), -0.15).positions, ControlPoint(np.array([0.2, 1.0]), 1, 0.1)
    for outward in (True, False):
        v = np.zeros((2, 3))
        v[1, 2] = -0.1 if outward else 0.1
        assert bool(collapse(model, model.contacts, model.initial.positions, x, v, point)) is outward


@pytest.mark.parametrize(("beyond", "lost"), [(0.9, False), (1.1, True)])
def test_a_block_is_out_of_reach_farther_from_its_face_than_its_size(beyond: float, lost: bool) -> None:
    model = on_base(Material(18.0, 0.6), (-1.0, -0.2, 1.0), (0.0, 0.0, 0.2, 0.2))
    x = model.initial.positions + np.array([[0.0, 0.0, 0.0], [1.0 + beyond * model.block_size[1], 0.0, 0.0]])
    reason = collapse(model, model.contacts, model.initial.positions, x, np.zeros((2, 3)), None)
    assert ("out of reach" in (reason or "")) is lost


def test_the_balance_of_a_motion_by_hand() -> None:
    """Of 9 kNm put in 3 and 1 are kinetic and elastic, 2, 1, 0.5 and 1 taken; 0.5 is missing. The turnover is 9."""
    ends = (3.0, 0.0, 1.0, 9.0, 2.0, 1.0, 0.5, 1.0)
    energy = Energy(*(np.array([0.0, end]) for end in ends))
    assert energy.residual.tolist() == [0.0, 0.5] and energy.turnover == 9.0
    assert (energy.imbalance, energy.integrator_share) == pytest.approx((0.5 / 9.0, 1.0 / 9.0))


@pytest.mark.parametrize(("speed", "falls"), [(-0.1, True), (0.1, False)])
def test_a_block_that_has_fallen_by_more_than_its_size_and_still_falls_has_collapsed(
    speed: float, falls: bool
) -> None:
    """One thrown up again from as far below may come back."""
    model = block_on_base(0.2, 1.0)
    x, v = model.initial.positions.copy(), np.zeros((2, 3))
    x[1, 1] -= 1.1 * model.block_size[1]
    v[1, 1] = speed
    reason = collapse(model, model.contacts, model.initial.positions, x, v, None)
    assert ("has fallen" in (reason or "")) is falls


def test_a_step_that_cannot_be_solved_is_no_collapse(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dynamic_system, "march", lambda *_: (3, 2, 0))
    with pytest.raises(ConvergenceError, match="not solved, 3 steps on"):
        time_history(block_on_base(), burst(0.5, 20), STEP, "rigid", integrator="implicit-euler")


def test_moreau_jean_never_gains_energy() -> None:
    """An arch on piers whose joints open and close together, in steps of down to 1/64."""
    motion = time_history(arch_on_piers(), burst(0.2, 200, 1.5), STEP, "rigid", integrator="moreau-jean")
    energy = motion.energy
    assert motion.halvings > 0
    assert energy.imbalance < 1e-5
    assert np.diff(energy.impact).min() > -1e-3 * energy.turnover
    assert np.diff(energy.friction).min() > -1e-4 * energy.turnover


def test_energy_of_many_rigid_joints_is_kept_between_impacts() -> None:
    """An arch on piers that opens its hinges and closes none yet: nothing but the geometry of a step takes energy."""
    spent = []
    for step in (0.02, 0.0025):
        wave = shaking(0.16)(step * np.arange(round(0.88 / step) + 1))
        motion = time_history(arch_on_piers(), wave, step, "rigid", integrator="second-order")
        energy = motion.energy
        assert energy.kinetic.max() > 0.05 * energy.turnover, "it moves"
        assert energy.imbalance < 1e-5
        spent.append(abs(energy.dissipated).max() / energy.turnover)
    assert spent[0] < 1e-3
    assert spent[1] < 0.2 * spent[0]


def test_energy_balance_of_impacts_by_the_dozen() -> None:
    """An arch that rocks until it falls: every term is there, and what the scheme itself takes is little."""
    arch = semicircular_arch(15, 0.2, friction=0.8)
    wave = shaking(0.35)(0.01 * np.arange(171))
    motion = time_history(arch, wave, 0.01, "rigid", integrator="second-order")
    energy = motion.energy
    assert motion.halvings > 5
    assert energy.imbalance < 1e-5
    assert np.diff(energy.impact).min() > -1e-4 * energy.turnover
    assert energy.impact[-1] > 10.0 * abs(energy.integrator[-1])


def test_bounces_shorter_than_a_step_are_rest() -> None:
    model = block_on_base(0.5, 0.5)
    positions = model.initial.positions.copy()
    positions[1, 1] += 0.01
    start = State(positions, np.zeros_like(positions))
    motion = time_history(model, np.zeros(100), 0.02, "rigid", start, "second-order", restitution=0.8)
    assert abs(motion.velocities[-1]).max() < 1e-3


@pytest.mark.parametrize(
    ("contacts", "integrator"),
    [("rigid", "moreau-jean"), ("elastic", "implicit-euler"), ("elastic", "second-order")],
)
def test_a_motion_in_two_parts_is_the_motion_in_one(contacts: str, integrator: Integrator) -> None:
    """What is measured by the past goes on: how far beds were pressed, gaps that count as closed, halved steps.

    Elastic beds had forgotten how far faces had come closer than they were pressed, and threw the blocks: the arch went
    on with 400 times the energy that its joints had stored. Rigid ones forgot the gaps that a settlement leaves.
    """
    model = arch_on_piers(stiffness=1e6)
    state = pushdown(model, "right", (0.01, -0.01), increment=0.005, contacts=contacts).final
    record, cut = 0.15 * np.sin(4.0 * np.pi * STEP * np.arange(161)), 83
    whole, first = (
        time_history(model, part, STEP, contacts, state, integrator) for part in (record, record[: cut + 1])
    )
    after = time_history(model, record[cut:], STEP, contacts, first.final, integrator)
    assert not whole.collapsed and abs(first.final.velocities).max() > 0.01
    assert after.energy.elastic[0] == pytest.approx(first.energy.elastic[-1], rel=1e-9)
    assert (first.programs + after.programs, first.halvings + after.halvings) == (
        whole.programs,
        whole.halvings,
    )
    assert abs(after.positions - whole.positions[cut:]).max() < 1e-9


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"acceleration": np.zeros(1)}, "acceleration"), ({"acceleration": np.zeros((3, 2))}, "acceleration"),
        ({"acceleration": np.array([0.0, np.nan])}, "acceleration"), ({"time_step": 0.0}, "time_step"),
        ({"time_step": np.nan}, "time_step"), ({"integrator": "explicit"}, "integrator"),
        ({"contacts": "soft"}, "contacts"),
        ({"damping_ratio": 0.05}, "damping_ratio"),
        ({"restitution": 0.5, "integrator": "implicit-euler"}, "restitution"),
        ({"ultimate": 0.1}, "ultimate"), ({"vertical_acceleration": np.zeros(3)}, "vertical_acceleration"),
        ({"control": (50.0, 50.0)}, "control"),
    ],
)  # fmt: skip
def test_bad_arguments_are_named(change: dict[str, object], message: str) -> None:
    arguments = {"acceleration": np.zeros(10), "time_step": STEP} | change
    with pytest.raises(ValueError, match=message):
        time_history(block_on_base(), **arguments)
