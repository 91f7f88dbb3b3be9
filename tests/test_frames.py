"""Frames of paths and what is derived from them: joint forces, conditions, reactions, thrust."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assessment.frames import MOST, chosen, joint_forces, pushdown_frames, pushover_frames, snapshots
from assessment.joint_states import Situation, joint_states, situations, thrust_lines
from assessment.outlines import outlines
from assessment.reactions import balance, joint_table, reactions
from mechanics import pushdown, pushover, time_history
from mechanics.equilibrium import reaction
from tests.analysed import SETTLED, analysed
from tests.structures import block_on_base, semicircular_arch


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
    for state, step in zip(path.states, path.steps, strict=True):
        force, _ = joint_forces(model, contacts, state.positions, step.forces)
        on_structure = force[np.isin(model.joints.b, right)].sum(axis=0) - force[
            np.isin(model.joints.a, right)
        ].sum(axis=0)
        expected = reaction(model, contacts, step, right)[:2]
        np.testing.assert_allclose(on_structure, expected, atol=1e-4 * model.weight)


def test_frames_hold_onset_peak_end_and_the_movement_asked_for():
    model = block_on_base(0.6, 4.2)
    path = pushover(model, (0.6, 4.2), increment=0.05)
    found = pushover_frames(model, "rigid", path)
    assert {0, path.peak, path.formed, len(path.states) - 1} <= set(found["index"])
    assert len(found["index"]) <= MOST + 4
    assert np.shape(found["configuration"]) == (len(found["index"]), 2, 3)
    arch = semicircular_arch(11, 0.2)
    moved = pushdown(arch, "right", (0.02, 0.0), increment=0.004, to_collapse=True)
    kept = pushdown_frames(arch, "rigid", moved, 0.02)["index"]
    assert any(moved.movement[index] == pytest.approx(0.02) for index in kept)


def test_at_its_onset_a_block_stands_on_its_toe_and_at_low_friction_it_slides():
    for friction, condition in ((0.7, "edge"), (0.1, "sliding")):
        model = block_on_base(0.6, 4.2, friction=friction)
        path = pushover(model, (0.6, 4.2), increment=0.05)
        force, centre = joint_forces(model, "rigid", model.initial.positions, path.forces)
        results = {
            "geometry": {
                "blocks": [
                    {"vertices_m": b.polygon.tolist(), "centroid_m": b.centroid.tolist()}
                    for b in model.blocks
                ],
                "joints": [
                    {"blocks": [int(a), int(b)], "ends_m": ends.tolist(), "friction": friction}
                    for a, b, ends in zip(model.joints.a, model.joints.b, model.joints.ends, strict=True)
                ],
            },
            "model": {"weight_kN": model.weight},
        }
        situation = Situation("", "+x", "rigid", path.multiplier[0], np.zeros((2, 3)), force, centre)
        found = joint_states(results, situation)
        assert found.condition == [condition]
        assert found.normal[0] == pytest.approx(model.weight)
        assert abs(found.shear[0]) == pytest.approx(path.multiplier[0] * model.weight)
        if condition == "edge":
            assert found.point[0] == pytest.approx([0.6, 0.0], abs=1e-6)


def test_rest_and_onset_of_every_state_are_there_and_balanced():
    results = analysed()
    found = [(each.state, each.direction, each.contacts) for each in situations(results)]
    assert found == [
        (state, *how)
        for state in ("original", SETTLED)
        for how in ((None, "elastic"), ("+x", "rigid"), ("-x", "rigid"))
    ]
    assert max(row["unbalanced"] for row in balance(results).rows) < 1e-4
    upward = sum(
        row["reaction_z_kN"]
        for row in reactions(results).rows
        if (row["state"], row["direction"]) == ("original", "+x")
    )
    assert upward == pytest.approx(results["model"]["weight_kN"], rel=1e-5)


def test_a_frame_that_is_out_of_balance_is_seen():
    results = analysed()
    frames = results["states"]["original"]["pushover"]["+x"]["elastic"]["frames"]
    frames["force_kN"][0][0][1] *= 1.1
    assert max(row["unbalanced"] for row in balance(results).rows) > 1e-3


def test_the_line_of_thrust_of_an_arch_passes_each_voussoir_within_its_joints():
    results = analysed()
    for situation in situations(results):
        states = joint_states(results, situation)
        lines = thrust_lines(results, states)
        assert len(lines) == 11
        shape = outlines(results).moved(situation.configuration)
        for (x0, z0), (x1, z1) in lines:
            low, high = shape.points.min(axis=0), shape.points.max(axis=0)
            assert low[0] <= min(x0, x1)
            assert max(z0, z1) <= high[1] + 1e-9


def test_nothing_slides_where_friction_is_infinite():
    """Null in results.json, which has no infinity; idle joints included."""
    results = analysed()
    for joint in results["geometry"]["joints"]:
        joint["friction"] = None
    conditions = {c for each in situations(results) for c in joint_states(results, each).condition}
    assert "sliding" not in conditions and "edge" in conditions


def test_four_hinges_at_the_onset_of_an_arch_and_open_joints_there():
    results = analysed()
    onset = next(each for each in situations(results) if each.direction == "+x")
    assert joint_states(results, onset).condition.count("edge") >= 4
    settled = [row for row in joint_table(results).rows if row["state"] == SETTLED]
    gaping = [row for row in settled if max(row["opening_1_m"], row["opening_2_m"]) > 1e-3]
    assert gaping
    assert {row["condition"] for row in gaping if row["direction"] == "+x"} <= {"edge", "sliding"}


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_frames_of_a_motion_hold_what_the_joints_carry(contacts):
    """The weight at mid-joint at rest; under a steady push below the threshold both of them, off the middle."""
    model = block_on_base()
    for push in (0.0, 0.1):  # g; the block of 0.2 × 1 m rocks at 0.2 g
        motion = time_history(
            model, np.full(400, push), 0.01, contacts, damping_ratio=0.5 * (contacts == "elastic")
        )
        seen = snapshots(
            model, contacts, motion.time, np.zeros(len(motion.time)), motion.positions, motion.forces, 3
        )
        first = seen["force_kN"][0]
        assert (first is None) == (contacts == "rigid")
        [force], [centre] = seen["force_kN"][-1], seen["centre"][-1]
        sign = 1.0 if model.joints.a[0] == 1 else -1.0
        assert sign * np.array(force) == pytest.approx(
            [push * model.weight, model.weight], rel=0.02, abs=1e-3
        )
        assert abs(centre - 0.5) == pytest.approx(0.5 * push / 0.2, abs=0.02)
        assert len(seen["force_kN"]) == len(seen["centre"]) == len(seen["time_s"])
