"""Frames of paths and what is derived from them: joint forces, conditions, reactions, thrust."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assessment.report.tables.mechanisms import balance, joint_table, reactions
from assessment.report.tables.structure import edge_pressures, pushover_curves
from assessment.results.frames import MOST, chosen, path_frames, snapshots
from assessment.results.joint_states import (
    Situation,
    described,
    faces_of,
    joint_states,
    outlines,
    pressed,
    situations,
    thrust_lines,
)
from assessment.results.table import sense
from mechanics import Material, pushdown, pushover, time_history
from mechanics.pictures import place
from mechanics.steps.equilibrium import reaction
from tests.support.analysed import SETTLED, analysed
from tests.support.structures import block_on_base, on_base, semicircular_arch
from tests.support.typed import typed


def plain_results(model):
    """What the kinematics of joints need of the results."""
    geometry = {
        "blocks": [
            {"vertices_m": b.polygon.tolist(), "centroid_m": b.centroid.tolist(), "support": b.support}
            for b in model.blocks
        ],
        "joints": described(model, model.contacts),
        "joint_tolerance_m": model.joint_tolerance,
    }
    return typed({"geometry": geometry, "model": {"weight_kN": model.weight}})


def asked_of(path):
    """The point of a movement of 0.02 m."""
    return int(np.argmin(abs(path.movement - 0.02)))


def situation(frames, number):
    """The situation of a frame."""
    force, centre = (np.array(values[number], dtype=float) for values in (frames.force_kN, frames.centre))
    return Situation("", "+x", "", 0.0, np.array(frames.configuration[number]), force, centre, frames.met)


def forces_on(model, states):
    """The sum (b, 2) of the joint forces on each block, kN."""
    total = np.zeros((len(model.blocks), 2))
    for (a, b), force in zip(states.blocks, states.force, strict=True):
        total[a] += force
        total[b] -= force
    return total


@given(st.integers(1, 2000), st.integers(2, 200), st.data())
def test_chosen_points_hold_the_ends_and_what_was_wanted(count, most, data):
    wanted = data.draw(st.lists(st.integers(0, count - 1), max_size=3))
    kept = chosen(count, most, wanted)
    assert kept == sorted(set(kept))
    assert {0, count - 1, *wanted} <= set(kept)
    assert len(kept) <= min(count, most) + len(wanted)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_reactions_of_the_frames_are_those_of_the_path(contacts):
    model = semicircular_arch(15, 0.3, friction=0.7)
    path = pushdown(model, "right", (0.02, -0.01), increment=0.004, contacts=contacts)
    right = model.support("right")
    frames = path_frames(path, asked_of(path))
    for number, index in enumerate(frames.index):
        states = joint_states(plain_results(model), situation(frames, number))
        on_structure = -forces_on(model, states)[right].sum(axis=0)
        expected = reaction(path.steps[index], right)[:2]
        np.testing.assert_allclose(on_structure, expected, atol=1e-4 * model.weight)


def test_frames_hold_onset_peak_end_and_the_movement_asked_for():
    model = block_on_base(0.6, 4.2)
    path = pushover(model, (0.6, 4.2), increment=0.05)
    found = path_frames(path, path.peak, path.formed)
    assert {0, path.peak, path.formed, len(path.states) - 1} <= set(found.index)
    assert len(found.index) <= MOST + 4
    assert np.shape(found.configuration) == (len(found.index), 2, 3)
    arch = semicircular_arch(11, 0.2)
    moved = pushdown(arch, "right", (0.02, 0.0), increment=0.004, to_collapse=True)
    kept = path_frames(moved, asked_of(moved)).index
    assert any(moved.movement[index] == pytest.approx(0.02) for index in kept)


def test_at_its_onset_a_block_stands_on_its_toe_and_at_low_friction_it_slides():
    for friction, condition in ((0.7, "edge"), (0.1, "sliding")):
        model = block_on_base(0.6, 4.2, friction=friction)
        path = pushover(model, (0.6, 4.2), increment=0.05)
        frames = path_frames(path, path.peak, path.formed)
        found = joint_states(plain_results(model), situation(frames, 0))
        assert found.condition == [condition]
        assert found.normal[0] == pytest.approx(model.weight)
        assert abs(found.shear[0]) == pytest.approx(path.multiplier[0] * model.weight)
        assert found.force[0] * (1 if model.joints.a[0] == 1 else -1) == pytest.approx(
            [-path.multiplier[0] * model.weight, model.weight], rel=1e-5
        )
        if condition == "edge":
            assert found.point[0] == pytest.approx([0.6, 0.0], abs=1e-6)
            assert abs(found.eccentricity[0]) == pytest.approx(0.3, abs=1e-6)
            assert found.contact[0] == pytest.approx(0.0, abs=1e-5)


def test_a_block_slides_off_its_base_and_its_joint_shortens_with_it():
    """Overlap, slip and the middle from which eccentricity counts are those of the configuration."""
    model = block_on_base(0.6, 4.2, friction=0.05)
    base = next(b for b in model.blocks if b.support)
    room = float(base.polygon[:, 0].max()) - 0.6  # until its corner leaves the base
    moved = np.zeros((2, 3))
    moved[next(i for i, b in enumerate(model.blocks) if not b.support), 0] = room + 0.2
    found = joint_states(
        plain_results(model),
        Situation("", None, "rigid", 0.0, moved, np.array([[model.weight, 0.0]]), np.array([0.5]), []),
    )
    assert abs(found.slip[0]) == pytest.approx(room + 0.2)
    assert np.hypot(*(found.ends[0, 1] - found.ends[0, 0])) == pytest.approx(0.4)
    assert found.contact[0] == pytest.approx(0.4)
    assert found.opening[0] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert found.pressure[0] == pytest.approx(model.weight / 0.4)


@pytest.mark.parametrize(
    ("share", "condition"),
    [
        (0.34, "whole"),
        (0.66, "whole"),
        (0.33, "partial"),
        (0.67, "partial"),
        (0.979, "partial"),
        (0.019, "edge"),
    ],
)
def test_a_joint_presses_as_a_whole_while_the_resultant_is_in_its_middle_third(share, condition):
    model = block_on_base(0.6, 4.2)
    force, still = np.array([[model.weight, 0.0]]), np.zeros((2, 3))
    at = Situation("", None, "rigid", 0.0, still, force, np.array([share]), [])
    found = joint_states(plain_results(model), at)
    assert found.condition == [condition]
    near = min(share, 1.0 - share)
    assert found.contact[0] == pytest.approx(0.6 if condition == "whole" else 3.0 * near * 0.6)


def test_opening_at_both_ends_of_a_block_turned_about_its_toe():
    model = block_on_base(0.6, 4.2)
    tilted = model.rotated(1 if model.blocks[0].support else 0, (0.6, 0.0), -0.05)
    moved = tilted.positions - model.initial.positions
    found = joint_states(
        plain_results(model),
        Situation("", None, "rigid", 0.0, moved, np.zeros((1, 2)), np.full(1, np.nan), []),
    )
    assert sorted(found.opening[0]) == pytest.approx([0.0, 0.6 * np.sin(0.05)], abs=1e-9)


@given(
    st.floats(0.01, 5.0), st.floats(0.05, 3.0), st.floats(0.0, 1.0), st.floats(0.0, 0.98), st.floats(1.0, 1e4)
)
def test_the_length_that_presses_and_its_edge_pressure_balance_what_acts(
    length, share, full, spare, strength
):
    """Against stress blocks integrated by hand: the strength over c, then linearly down to zero over t."""
    c, t = full * share * length / 3.0, (1.0 - full) * share * length / 3.0
    if not 1e-6 < c + t <= length:
        return
    normal = strength * (c + 0.5 * t)
    near = strength * (0.5 * c**2 + 0.5 * t * (c + t / 3.0)) / normal
    one = [np.array([each]) for each in (normal, near, length, strength)]
    contact, pressure = pressed(*one)
    assert contact[0] == pytest.approx(c + t, rel=1e-6, abs=1e-6)
    assert pressure[0] == pytest.approx(strength, rel=1e-6)
    # a bed that does not crush: linear over the joint, from the lesser pressure at the farther end
    greater, less = strength * 0.999, spare * strength * 0.999
    normal = 0.5 * (greater + less) * length
    near = 0.5 * length - (greater - less) * length**2 / 12.0 / normal
    contact, pressure = pressed(*(np.array([each]) for each in (normal, near, length, strength)))
    assert contact[0] == pytest.approx(length, rel=1e-6)
    assert pressure[0] == pytest.approx(greater, rel=1e-6)


def test_a_wall_leans_on_its_neighbour_and_the_pair_that_met_is_told():
    """Two blocks 50 mm apart: the slender one comes to lean on the stout one, and both balance."""
    stone = Material(20.0, 0.6)
    model = on_base(stone, (-1.0, -0.3, 3.0), (0.0, 0.0, 0.3, 3.0), (0.35, 0.0, 1.55, 2.0))
    path = pushover(model, (0.0, 3.0), "+x", increment=0.01)
    frames = path_frames(path, path.peak, path.formed)
    assert frames.met
    assert [sorted(each.blocks) for each in frames.met] == [[1, 2]] * len(frames.met)
    lateral = model.lateral_load("+x")[:, :2]
    leaning = 0
    for number, index in enumerate(frames.index):
        if frames.force_kN[number] is None:
            continue
        states = joint_states(plain_results(model), situation(frames, number))
        load = model.dead_load[:, :2] + path.steps[index - 1].alpha * lateral
        assert forces_on(model, states)[1:] == pytest.approx(-load[1:], abs=1e-4 * model.weight)
        assert np.isnan(states.slip[len(model.joints.a) :]).all()
        leaning += states.normal[len(model.joints.a) :].max() > 0.01
    assert leaning > 2


def test_joints_of_results_are_those_of_the_model_in_every_column():
    model = block_on_base()
    np.testing.assert_allclose(
        faces_of(plain_results(model)).contacts.faces, model.contacts.faces, atol=1e-12
    )


def test_rest_and_onset_of_every_state_are_there_and_balanced():
    results = analysed()
    found = [(each.state, each.direction, each.contacts) for each in situations(typed(results))]
    assert found == [
        (state, *how)
        for state in ("original", SETTLED)
        for how in ((None, "elastic"), ("+x", "rigid"), ("-x", "rigid"))
    ]
    assert max(row["unbalanced"] for row in balance(typed(results)).rows) < 1e-4
    upward = sum(
        row["reaction_z_kN"]
        for row in reactions(typed(results)).rows
        if (row["state"], row["direction"]) == ("original", "+x")
    )
    assert upward == pytest.approx(results["model"]["weight_kN"], rel=1e-5)


def test_a_frame_that_is_out_of_balance_is_seen():
    results = analysed()
    frames = results["states"]["original"]["pushover"]["+x"]["elastic"]["frames"]
    frames["force_kN"][0][0][0] *= 1.1
    assert max(row["unbalanced"] for row in balance(typed(results)).rows) > 1e-3


def test_the_line_of_thrust_of_an_arch_passes_each_voussoir_within_its_joints():
    results = analysed()
    for each in situations(typed(results)):
        lines = thrust_lines(joint_states(typed(results), each))
        assert len(lines) == 11
        shape = outlines(typed(results)).moved(each.configuration)
        for (x0, z0), (x1, z1) in lines:
            low, high = shape.points.min(axis=0), shape.points.max(axis=0)
            assert low[0] <= min(x0, x1)
            assert max(z0, z1) <= high[1] + 1e-9


def test_four_hinges_at_the_onset_of_an_arch_and_open_joints_there():
    results = analysed()
    onset = next(each for each in situations(typed(results)) if each.direction == "+x")
    assert joint_states(typed(results), onset).condition.count("edge") >= 4
    settled = [row for row in joint_table(typed(results)).rows if row["state"] == SETTLED]
    rigid = [row for row in settled if row["contacts"] == "rigid"]
    gaping = [row for row in rigid if max(row["opening_1_m"], row["opening_2_m"]) > 1e-3]
    assert gaping
    assert {row["condition"] for row in gaping if row["direction"] == "+x"} <= {"edge", "sliding"}


def test_edge_pressures_are_the_greatest_of_the_elastic_joints_and_crushing_bounds_them():
    results = analysed()
    found = edge_pressures(typed(results))
    joints = [row for row in joint_table(typed(results)).rows if row["contacts"] == "elastic"]
    for each in found:
        own = [row["edge_pressure_kN_m2"] for row in joints if row["joint"] == each.joint]
        assert each.edge_pressure_kN_m2 == each.uncrushed_pressure_kN_m2 == max(own)
        assert np.isfinite(each.edge_pressure_kN_m2)
    greatest = found[0].edge_pressure_kN_m2
    for joint in results["geometry"]["joints"]:
        joint["compressive_strength_kN_m2"] = 0.5 * greatest
    crushed = edge_pressures(typed(results))
    assert crushed[0].edge_pressure_kN_m2 == pytest.approx(0.5 * greatest)
    assert crushed[0].uncrushed_pressure_kN_m2 == greatest


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_frames_of_a_motion_hold_what_the_joints_carry(contacts):
    """The weight at mid-joint at rest; under a steady push below the threshold both of them, off the middle."""
    model = block_on_base()
    for push in (0.0, 0.1):  # g; the block of 0.2 × 1 m rocks at 0.2 g
        motion = time_history(
            model, np.full(400, push), 0.01, contacts, damping_ratio=0.5 * (contacts == "elastic")
        )
        seen = snapshots(model, motion.time, np.zeros(len(motion.time)), motion.positions, motion.forces, 3)
        assert seen.force_kN[0] is None  # no step has led there
        [centre] = seen.centre[-1]
        states = joint_states(plain_results(model), situation(seen, -1))
        sign = 1.0 if model.joints.a[0] == 1 else -1.0
        assert sign * states.force[0] == pytest.approx(
            [push * model.weight, model.weight], rel=0.02, abs=1e-3
        )
        assert abs(centre - 0.5) == pytest.approx(0.5 * push / 0.2, abs=0.02)
        assert len(seen.force_kN) == len(seen.centre) == len(seen.time_s)


PUSHED = [(state, direction) for state in ("original", SETTLED) for direction in ("+x", "-x")]


@pytest.mark.parametrize(("state", "direction"), PUSHED)
@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_curves_are_in_the_axes_of_the_model(state, direction, contacts):
    """Displacements of −x were those of a mirror image: the control point goes where the frames show it."""
    results = analysed()
    stage = results["states"][state]["pushover"][direction][contacts]
    d = np.array(stage["curve"]["displacement_m"])
    assert d[0] == 0.0 and "-0.0" not in json.dumps(stage["curve"]["displacement_m"][:1])
    [control] = results["geometry"]["controls"]
    owner, drawn = np.array([control["block"]]), np.array([control["point_m"]])
    centroids = outlines(typed(results)).centroids
    at = [place(drawn, owner, centroids, np.array(each))[0, 0] for each in stage["frames"]["configuration"]]
    np.testing.assert_allclose(d[stage["frames"]["index"]], np.array(at) - at[0], atol=2e-6)
    assert sense(direction) * d[-1] > 0.0
    listed = [
        row["displacement_m"]
        for row in pushover_curves(typed(results)).rows
        if (row["state"], row["direction"], row["contacts"]) == (state, direction, contacts)
    ]
    assert listed == d.tolist()
