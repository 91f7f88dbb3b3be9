"""Steps of a motion: impacts shorter than one, rest that is not computed."""

from dataclasses import replace

import numpy as np
import pytest

from assessment.benchmark.motions import shaking
from mechanics import Assembly, TimeHistory, time_history
from mechanics.kernels.joint import H
from mechanics.model.contacts import forces_on_blocks
from mechanics.procedures.motion_start import HISTORY, HistoryTolerances, Integrator
from mechanics.steps.dynamic_system import Halving
from mechanics.types import GRAVITY
from tests.support.drawn_projects import drawn
from tests.support.structures import arch_on_piers, block_on_base, column, running_bond, semicircular_arch

STEP = 0.005
SPRINGING = (0.42, 0.55)


def shaken(amplitude: float, step: float, duration: float) -> np.ndarray:
    """The benchmark's motion."""
    return shaking(amplitude)(step * np.arange(round(duration / step) + 1))


def buttressed_arch(stiffness: float) -> Assembly:
    blocks = drawn("buttressed_arch").blocks
    return Assembly([replace(b, material=replace(b.material, normal_stiffness=stiffness)) for b in blocks])


def sound(motion: TimeHistory) -> None:
    """The balance closes, and what steps have given stays small against what was turned over.

    No invariant: 0.1 to 1.7 % was measured, in part the dilation of slides, in part beds that give back more than they
    stored, for which no cause is known. Where gaps wrong by microns were blows it was nine times the turnover and more.
    """
    energy = motion.energy
    assert energy.imbalance <= 1e-4
    assert np.diff(energy.integrator).clip(max=0.0).sum() >= -0.03 * energy.turnover
    assert not any("energy balance" in note for note in motion.notes)


def small_arch(stiffness: float) -> Assembly:
    return arch_on_piers(voussoirs=5, courses=1, stiffness=stiffness)


def test_collapse_on_stiff_joints_is_seen_at_the_usual_step() -> None:
    """0.3 g at 5 ms, k = 1e8 kN/m³: in steps of 0.3 ms members within 1 % fall at 1.01 to 1.04 s, unhalved at 1.25."""
    motion = time_history(small_arch(1e8), shaken(0.3, STEP, 2.0), STEP, "elastic")
    sound(motion)
    assert motion.collapsed and motion.time_of_collapse == pytest.approx(1.04, abs=0.06)
    assert motion.halvings > 100


def test_stiff_joints_move_as_rigid_ones_in_the_limit() -> None:
    """The first uplift at 0.25 g in steps of 2.5 ms: 23, 10 to 13, 5.2 mrad on 1e7, 1e8 kN/m³ and rigid joints."""
    wave = shaken(0.25, 0.5 * STEP, 0.55)
    turned = []
    for stiffness, contacts in ((1e7, "elastic"), (1e8, "elastic"), (1e8, "rigid")):
        motion = time_history(small_arch(stiffness), wave, 0.5 * STEP, contacts)
        turned.append(float(abs(motion.positions[-1] - motion.positions[0])[:, 2].max()))
    *elastic, rigid = turned
    beyond = [value / rigid - 1.0 for value in elastic]
    assert beyond[0] > 3.0 and 0.0 < beyond[1] < 0.5 * beyond[0]


def test_a_bed_that_is_stiff_for_its_step_gives_no_energy() -> None:
    """Even where nothing is halved, and slides stop: gaps wrong by microns are no blows."""
    whole = HistoryTolerances(closing=Halving(0, np.inf))
    model = buttressed_arch(1e8)
    for integrator in ("second-order", "implicit-euler"):
        sound(
            time_history(
                model, shaken(0.12, STEP, 1.5), STEP, "elastic", integrator=integrator, tolerances=whole
            )
        )


def test_an_ensemble_at_the_usual_step_has_the_resolved_median() -> None:
    """Five members; 45 at 0.3 ms have 5.9 to 15.0 mm, median 13.7 mm (95 % confidence: 13.3 to 13.9 mm)."""
    found = []
    for factor in np.linspace(0.99, 1.01, 5):
        motion = time_history(
            drawn("buttressed_arch"), factor * shaken(0.12, STEP, 2.2), STEP, control=SPRINGING
        )
        assert motion.integrator == "moreau-jean" and motion.energy.imbalance <= 1e-4
        found.append(float(abs(motion.displacement).max()))
    assert np.median(found) == pytest.approx(0.0137, rel=0.2)
    assert min(found) < 0.0137 < max(found)


@pytest.mark.parametrize("integrator", ["moreau-jean", "second-order"])
def test_an_arch_without_many_impacts_falls_at_one_level_by_every_integrator(integrator: Integrator) -> None:
    """25 voussoirs, thickness 0.15 of the radius, a half sine of 0.5 s: at 0.193 g at 5 ms, as at 1.25 ms."""
    times = STEP * np.arange(251)
    pulse = np.sin(2.0 * np.pi * times) * (times < 0.5)
    fallen = [
        time_history(semicircular_arch(25, 0.15, 0.7), level * pulse, STEP, integrator=integrator).collapsed
        for level in (0.191, 0.195)
    ]
    assert fallen == [False, True]


@pytest.fixture
def levels() -> dict[int, TimeHistory]:
    """The arch with rigid joints, its steps halved so many times."""
    found = {}
    for count in (0, 6):
        halved = replace(HISTORY, resolved=replace(HISTORY.resolved, levels=count))
        found[count] = time_history(
            drawn("buttressed_arch"), shaken(0.12, STEP, 3.0), STEP, control=SPRINGING, tolerances=halved
        )
    return found


def test_what_coarse_steps_take_is_no_impact(levels: dict[int, TimeHistory]) -> None:
    """A fixed step of 5 ms stops small rocking dead: 3.2 mm where it is 13.5. The share of the integrator says so."""
    coarse, resolved = levels[0], levels[6]
    peaks = [float(abs(motion.displacement).max()) for motion in (coarse, resolved)]
    assert peaks[0] < 0.004 < 0.005 < peaks[1]
    for motion in (coarse, resolved):
        assert motion.integrator == "moreau-jean"
        assert motion.energy.imbalance <= 1e-4
    assert coarse.energy.integrator_share > 0.4
    assert resolved.energy.integrator_share < 0.2
    # Moreau and Jean's programs end where errors of velocities have at most 1e-4 of the kinetic energy
    assert max(coarse.unsure, resolved.unsure) <= 1e-4


def test_a_resolved_impact_is_no_loss_of_the_integrator() -> None:
    """A block dropped from 0.2 m, by either rule: its impact at 2 m/s takes what it brings."""
    model = block_on_base(0.5, 0.5)
    lifted = model.initial.positions.copy()
    lifted[1, 1] += 0.2
    state = replace(model.initial, positions=lifted)
    motion = time_history(model, np.zeros(61), STEP, "rigid", state, "moreau-jean")
    assert motion.energy.impact[-1] == pytest.approx(0.2 * model.weight, rel=1e-2)
    assert motion.energy.integrator_share < 1e-2


@pytest.mark.parametrize("integrator", ["moreau-jean", "second-order"])
def test_friction_is_not_booked_as_an_impact(integrator: Integrator) -> None:
    energy = time_history(running_bond(3, 3), shaken(0.8, STEP, 0.8), STEP, integrator=integrator).energy
    assert energy.friction[-1] > 0.8 * energy.dissipated[-1]
    assert energy.imbalance <= 1e-4


def two_pulses(step: float) -> np.ndarray:
    """Weak shaking of 12 s with two strong stretches, g."""
    time = np.arange(0.0, 12.0, step)
    strong = np.exp(-(((time - 2.0) / 0.5) ** 2)) + 0.8 * np.exp(-(((time - 8.0) / 0.4) ** 2)) + 0.05
    return np.asarray(0.3 * strong * np.sin(2.0 * np.pi * 1.5 * time) * np.sin(9.0 * time + 1.0))


@pytest.mark.parametrize("model", [block_on_base(0.6, 3.0), column(0.4, 1.6, 3)], ids=["block", "column"])
def test_a_motion_whose_rest_is_skipped_is_the_whole_motion(model: Assembly) -> None:
    """A third of the steps and more are not computed; the peak is that of the whole motion, to 1e-5.

    Programs are solved to 1e-9: the usual 1e-7 leave more open, 1e-4 of the block's peak and 4e-3 of the column's.
    """
    base = two_pulses(STEP)
    skipped, whole = (
        time_history(model, base, STEP, tolerances=HistoryTolerances(skips=skips, accepted=1e-9))
        for skips in (True, False)
    )
    moved = [abs(motion.positions - motion.positions[0]) for motion in (skipped, whole)]
    assert skipped.skipped > 0.3 * skipped.steps and whole.skipped == 0
    assert moved[1].max() > 1e-3
    assert moved[0].max() == pytest.approx(moved[1].max(), rel=1e-5)
    assert skipped.energy.imbalance <= 1e-4


def test_a_record_below_activation_costs_ten_steps_and_a_try_how_far_rest_goes() -> None:
    """Of 2400 steps tens are computed; blocks stay exactly where they are, and joints carry what balances."""
    model = running_bond(3, 3)
    base = 0.2 * two_pulses(STEP)
    motion = time_history(model, base, STEP)
    assert motion.steps - motion.skipped < 30 and motion.programs < 40
    resting = np.flatnonzero(~motion.velocities.any(axis=(1, 2)))[1:]
    assert abs(motion.positions[resting] - motion.positions[0]).max() < 1e-7
    contacts, places = model.contacts, model.contacts.places(motion.positions[-1])
    for k in resting[:: len(resting) // 20]:
        forces = motion.forces[k]
        assert (abs(forces[:, 1]) <= places[:, H] * forces[:, 0] + 1e-6).all()
        assert (abs(forces[:, 2]) <= contacts.friction * forces[:, 0] + 1e-6).all()
        total = np.zeros((len(model.blocks), 3))
        np.add.at(total, contacts.a, forces_on_blocks(places, forces)[:, :3])
        np.add.at(total, contacts.b, forces_on_blocks(places, forces)[:, 3:])
        total += model.dead_load
        total[:, 0] -= model.mass[:, 0] * GRAVITY * base[k]
        assert abs(total[model.movable]).max() < 1e-2 * model.weight * abs(base).max() + 1e-6


def test_elastic_joints_and_vertical_shaking_skip_nothing() -> None:
    base = 0.1 * two_pulses(0.02)
    assert time_history(block_on_base(), base, 0.02, "elastic").skipped == 0
    assert time_history(block_on_base(), base, 0.02, vertical_acceleration=0.1 * base).skipped == 0
