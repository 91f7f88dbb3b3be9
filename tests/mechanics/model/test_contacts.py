"""Kinematics of joints: measures, rows and second derivatives against finite differences, overlap, stones that meet."""

from typing import NamedTuple

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mechanics import Assembly, Block, Material
from mechanics.kernels.bed import pressed, stored
from mechanics.kernels.joint import (
    ALONG,
    ARM,
    BETA,
    CURVED,
    LEVERS,
    MU,
    MV,
    PHI,
    SHIFTS,
    SLIDE,
    H,
    U,
    V,
    curvature,
    lay_shear,
)
from mechanics.model.contacts import Contacts, rows
from mechanics.types import Array
from tests.support.reference_loops import Pair, derivative, scattered, turned
from tests.support.structures import arch_on_piers, outlines, rectangle, running_bond

MODELS = {"arch": arch_on_piers(voussoirs=7, courses=2), "wall": running_bond(columns=3, courses=3)}
seeds = st.integers(0, 2**32 - 1)
names = st.sampled_from(sorted(MODELS))
STONE = Material(18.0)


def pair_of(contacts: Contacts, k: int, positions: Array) -> Pair:
    return Pair(contacts.faces[k], positions[contacts.a[k]], positions[contacts.b[k]])


@settings(max_examples=15)
@given(name=names, seed=seeds, amount=st.sampled_from([1e-3, 0.05, 0.3]))
def test_places_are_those_of_their_definition(name, seed, amount):
    model = MODELS[name]
    positions, contacts = scattered(model, seed, amount), model.contacts
    places = contacts.places(positions)
    for k, p in enumerate(places):
        pair = pair_of(contacts, k, positions)
        low, high = pair.overlap
        assert p[BETA] == pytest.approx(pair.beta(), abs=1e-9)
        assert abs(p[H]) == pytest.approx(abs(0.5 * (high - low)), abs=1e-12)
        measures = pair.measures(p[BETA], pair.arm(), pair.upper)
        assert p[[U, PHI, V]] == pytest.approx(measures, abs=1e-12)
        closed = p[U] - p[ARM] * p[PHI]
        assert (p[H] > 0.0) == (high - low > max(0.0, -closed))


@settings(max_examples=15)
@given(name=names, seed=seeds, turn=st.floats(-4.0, 4.0), dx=st.floats(-3.0, 3.0), dz=st.floats(-3.0, 3.0))
def test_measures_do_not_feel_a_rigid_motion_of_everything(name, seed, turn, dx, dz):
    model = MODELS[name]
    positions = scattered(model, seed, 0.2)
    moved = np.column_stack([turned(positions[:, :2], turn) + np.array([dx, dz]), positions[:, 2] + turn])
    before, after = model.contacts.places(positions), model.contacts.places(moved)
    assert after[:, [U, PHI, V]] == pytest.approx(before[:, [U, PHI, V]], abs=1e-11)
    assert after[:, H] == pytest.approx(before[:, H], abs=1e-11)


class Joint(NamedTuple):
    """One joint of a scattered model: its place, and u, φ, v with the share β and the arm held as they are there."""

    place: Array
    start: Array  # (6,): positions of blocks a and b
    pair: Pair

    def measures(self, moved: Array) -> Array:
        at = self.start + moved
        p = self.place
        return Pair(self.pair.face, at[:3], at[3:]).measures(p[BETA], p[ARM], self.pair.upper)

    @property
    def rows(self) -> Array:
        return rows(self.place[None])[0]


def any_joint(model: Assembly, seed: int, amount: float) -> Joint:
    """A joint in a random configuration, of both touched faces and of corners that meet."""
    positions = scattered(model, seed, amount)
    k = seed % len(model.contacts)
    c = model.contacts
    return Joint(
        c.places(positions)[k], np.r_[positions[c.a[k]], positions[c.b[k]]], pair_of(c, k, positions)
    )


@settings(max_examples=30)
@given(name=names, seed=seeds, amount=st.sampled_from([1e-3, 0.05, 0.3]))
def test_rows_are_the_derivatives_of_gap_turn_and_slip(name, seed, amount):
    joint = any_joint(MODELS[name], seed, amount)
    assert pytest.approx(joint.rows, abs=1e-8) == derivative(joint.measures).T


def geometric(joint: Joint, n: float, m: float, t: float) -> Array:
    """The full matrix (6, 6) of what forces change as their joint moves."""
    out = np.empty(CURVED)
    curvature(joint.place, n, m, t, out)
    assert not out[7:SHIFTS].any()
    full = np.zeros((6, 6))
    full[2, :2] = full[:2, 2] = out[:2]
    full[5, :2] = full[:2, 5] = out[2:4]
    full[2, 3:5] = full[3:5, 2] = -out[:2]
    full[5, 3:5] = full[3:5, 5] = -out[2:4]
    full[2, 2], full[2, 5], full[5, 2], full[5, 5] = out[4], out[5], out[5], out[6]
    return full


@settings(max_examples=30)
@given(name=names, seed=seeds, amount=st.sampled_from([1e-3, 0.05, 0.3]))
def test_curvature_is_the_second_derivative_along_the_forces(name, seed, amount):
    joint = any_joint(MODELS[name], seed, amount)
    forces = np.random.default_rng(seed).standard_normal(3)
    gradient = lambda at: derivative(lambda step: forces @ joint.measures(at + step))  # noqa: E731
    assert derivative(gradient, 1e-4) == pytest.approx(geometric(joint, *forces), abs=1e-5)


@settings(max_examples=60)
@given(name=names, seed=seeds, amount=st.sampled_from([1e-3, 0.03]))
def test_forces_at_the_ends_of_an_overlap_move_with_it_as_faces_slide(name, seed, amount):
    """Of N₁ and N₂ at the ends and T midway between the faces: all that changes, overlap, frame and levers too."""
    model, (n1, n2, t) = MODELS[name], np.random.default_rng(seed).uniform(0.5, 1.5, 3)
    positions, k = scattered(model, seed, amount), seed % len(model.contacts)
    a, b = model.contacts.a[k], model.contacts.b[k]

    def laid(moved: Array) -> tuple[Array, Array]:
        at = positions.copy()
        at[a], at[b] = at[a] + moved[:3], at[b] + moved[3:]
        place = model.contacts.places(at)[k : k + 1]
        forces = np.array([[n1 + n2, place[0, H] * (n2 - n1), t]])
        lay_shear(place, forces, np.zeros(1))
        return place, forces[0]

    def on_blocks(moved: Array) -> Array:
        place, forces = laid(moved)
        return forces @ rows(place)[0]

    place, forces = laid(np.zeros(6))
    assume(place[0, H] > 0.02)
    out = np.empty(CURVED)
    curvature(place[0], *forces, out)
    row = rows(place)[0]
    expected = geometric(Joint(place[0], np.zeros(6), None), *forces)
    expected += np.outer(out[SHIFTS:SLIDE] @ row, out[SLIDE:LEVERS] @ row) + np.outer(
        row[1], out[LEVERS:] @ row[:2]
    )
    found = derivative(on_blocks, 1e-7).T
    # another corner may end the overlap within the difference: there is no derivative
    assume(found == pytest.approx(derivative(on_blocks, 1e-8).T, abs=1e-5))
    # to the first order in the turn, and in the gap beside the size of blocks
    small = abs(place[0, PHI]) * abs(expected).max() + abs(place[0, U]) * (n1 + n2 + t)
    assert found == pytest.approx(expected, abs=small + 1e-5)


def two(
    upper: list[list[float]] | Array, lower: list[list[float]] | Array, tolerance: float = 1e-6
) -> Assembly:
    return Assembly([Block(lower, 1.0, STONE, support="base"), Block(upper, 1.0, STONE)], tolerance=tolerance)


@settings(max_examples=30)
@given(
    low=st.floats(-1.5, 1.5), width=st.floats(0.2, 2.0), slide=st.floats(-3.0, 3.0), turn=st.floats(-3.0, 3.0)
)
def test_overlap_is_that_of_the_outlines(low, width, slide, turn):
    """Of two rectangles in touch, after a slide along the joint, at any angle: where their outlines meet."""
    assume(min(low + width, 1.0) - max(low, -1.0) > 1e-3)
    model = two(
        turned(rectangle(low, 0.0, low + width, 0.5), turn), turned(rectangle(-1.0, -0.5, 1.0, 0.0), turn)
    )
    positions = model.initial.positions.copy()
    positions[1, :2] += turned([slide, 0.0], turn)
    outlines = [
        shapely.LineString(turned(line, turn))
        for line in ([[-1.0, 0.0], [1.0, 0.0]], [[low + slide, 0.0], [low + width + slide, 0.0]])
    ]
    near = outlines[0].buffer(1e-9, cap_style="flat")
    expected = near.intersection(outlines[1]).length
    [place] = model.contacts.places(positions)
    assert max(2.0 * place[H], 0.0) == pytest.approx(expected, abs=1e-7)


@settings(max_examples=30)
@given(
    slide=st.floats(-1.5, 1.5),
    lift=st.floats(-5e-3, 5e-3),
    lean=st.floats(-5e-3, 5e-3),
    turn=st.floats(-3.0, 3.0),
)
def test_gaps_and_overlap_tell_the_area_in_which_blocks_lie_in_each_other(slide, lift, lean, turn):
    """A block slid, lifted and leant against its base: ∫⟨−w⟩ over the overlap, to the second order in the lean."""
    model = two(turned(rectangle(-0.6, 0.0, 0.6, 0.5), turn), turned(rectangle(-1.0, -0.5, 1.0, 0.0), turn))
    positions = model.initial.positions.copy()
    positions[1, :2] += turned([slide, lift], turn)
    positions[1, 2] += lean
    shapes = outlines(model, positions)
    [place] = model.contacts.places(positions)
    found = stored(1.0, 0.0, 1.0, 1.0) if place[H] <= 0.0 else pressed(place[U], place[PHI], place[H], 1.0)[0]
    assert found == pytest.approx(shapes[0].intersection(shapes[1]).area, abs=5e-5)


@pytest.mark.parametrize("lean", [-0.3, -0.02, 0.02, 0.3])
def test_the_normal_is_that_of_the_face_that_a_corner_touches(lean):
    """A block on its corner on a wide base: the base's normal; upside down, a wide block on a narrow one: its own."""
    narrow, wide = rectangle(-0.1, 0.0, 0.1, 1.0), rectangle(-1.0, -1.0, 1.0, 0.0)
    for upper, expected in ((narrow, 0.0), ([[-x, -z] for x, z in wide], lean)):
        lower = wide if upper is narrow else [[-x, -z] for x, z in narrow]
        model = two(upper, lower, tolerance=1e-4)
        positions = model.rotated(1, (np.sign(-lean) * 0.1, 0.0), lean).positions
        [place] = model.contacts.places(positions)
        assert np.arctan2(*(place[:2] * (-1.0, 1.0))) == pytest.approx(expected, abs=1e-9) or np.arctan2(
            *(-place[:2] * (-1.0, 1.0))
        ) == pytest.approx(expected, abs=1e-9)
        assert place[BETA] in (0.0, 1.0)


@pytest.mark.parametrize("slide", [2e-3, 4e-3, 8e-3])
def test_level_faces_push_at_one_place_whichever_end_measures_them(slide):
    """Faces of corners that nearly meet: a turn through zero changes the end that is the more closed, not the lever."""
    model = two(rectangle(0, 0, 1, 1), rectangle(0, -1, 1, 0))
    levers = []
    for turn in (-1e-9, 1e-9):
        positions = model.initial.positions + np.array([[0.0, 0.0, 0.0], [slide, 0.0, turn]])
        levers.append(model.contacts.places(positions)[0, MU])
    assert levers[0] == pytest.approx(levers[1], abs=1e-8)


def test_shear_acts_midway_between_the_faces_where_the_pressure_does():
    """Both faces lie in each other by w there: the height of T is half of it from either one."""
    model = two(rectangle(-0.3, 0, 0.3, 1), rectangle(-1, -1, 1, 0), tolerance=1e-4)
    positions = model.initial.positions + np.array([[0.0, 0.0, 0.0], [0.0, -1e-3, 2e-3]])
    place = model.contacts.places(positions)
    before = place.copy()
    force = np.array([[1.0, 0.1 * place[0, H], 0.2]])
    lay_shear(place, force, np.array([0.0]))
    n, e = 1.0, 0.1 * place[0, H]
    at_pressure = place[0, U] + e * place[0, PHI]
    at_corner = place[0, U] - place[0, ARM] * place[0, PHI]
    sign = 0.5 - place[0, BETA]
    assert n > 0.0 > at_pressure > at_corner
    assert before[0, MV] - place[0, MV] == pytest.approx(sign * (at_pressure - 2.0 * at_corner), rel=1e-12)
    assert place[0, V] == before[0, V] and np.array_equal(place[0, ALONG], before[0, ALONG])


def stacked(lower: Material, upper: Material, depths=(1.0, 1.0)):
    return Assembly(
        [
            Block(rectangle(0, 0, 2, 1), depths[0], lower, support="base"),
            Block(rectangle(0, 1, 2, 2), depths[1], upper),
        ]
    )


def test_the_smaller_friction_governs_whichever_block_has_it():
    for materials in ((Material(18.0, 0.3), Material(18.0, 0.7)), (Material(18.0, 0.7), Material(18.0, 0.3))):
        assert stacked(*materials).contacts.friction == pytest.approx(0.3)


def test_half_joints_of_unlike_stones_act_in_series():
    soft, hard = Material(18.0, 0.6, 1e6, 4e5), Material(18.0, 0.6, 3e6)
    contacts = stacked(soft, hard).contacts
    assert contacts.bed == pytest.approx([1.5e6])
    assert contacts.shear == pytest.approx([2.0 * 8e5])


def test_the_smaller_depth_and_strength_carry():
    weak, strong = Material(18.0, 0.6, 1e6, compressive_strength=2e3), Material(18.0, 0.6, 1e6)
    contacts = stacked(weak, strong, (1.0, 0.25)).contacts
    assert contacts.bed == pytest.approx([1e6 * 0.25])
    assert contacts.strength == pytest.approx([2e3 * 0.25])


def test_one_stone_without_stiffness_refuses_elastic_contacts():
    with pytest.raises(ValueError, match="normal_stiffness"):
        stacked(Material(18.0, 0.6, 1e6), Material(18.0)).check_behaviour("elastic")


def test_beds_are_exact_by_default():
    """Python's default of one segment was 2.3 times too strong on a soft column."""
    assert (running_bond().contacts.segments == 0).all()
    assert Assembly(running_bond().blocks).segments_per_joint is None


def test_a_block_may_ask_for_its_own_segments():
    blocks = [Block(b.polygon, 0.1, STONE, b.support, segments=8 if k > 5 else None)
              for k, b in enumerate(running_bond().blocks)]  # fmt: skip
    model = Assembly(blocks, segments_per_joint=2)
    own = np.array([b.segments or 2 for b in blocks])
    c = model.contacts
    assert c.segments.tolist() == np.maximum(own[c.a], own[c.b]).tolist()
    assert set(c.segments) == {2, 8}
