"""The beds that a joint may have: forces, work and gaps of each are of one bed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.kernels.bed import stiffened, stored
from mechanics.kernels.bed_law import bed_forces, ends_under, gaps_under
from mechanics.kernels.dynamics.motion import JOINT, REMAINS, bed_under, work_on_bed
from mechanics.kernels.joint import PHI, PLACE, TIED, H
from mechanics.kernels.law import BED, LAW, LEFT, SEGMENTS, STRENGTH
from mechanics.types import Array
from tests.mechanics.kernels.test_bed import displacements, ends_of, halves, stiffnesses, turns

kinds = st.one_of(
    st.just({}), st.integers(1, 20).map(lambda n: {SEGMENTS: float(n)}), st.just({STRENGTH: 1.0})
)
lines = st.lists(st.floats(-2.0, 2.0), min_size=8, max_size=8)  # above which it begins, in σ/k


def law_of(kind: dict[int, float], k: float, left: list[float]) -> Array:
    law = np.zeros(LAW)
    law[BED], law[STRENGTH], law[LEFT:] = k, np.inf, np.array(left) / k
    for column, value in kind.items():
        law[column] = value
    return law


def in_motion(law: Array, half: float, phi: float) -> tuple[Array, Array]:
    """Place and state of a joint that is turned by φ, with what its law has left."""
    p, joint = np.zeros(PLACE), np.zeros(JOINT)
    p[H], p[PHI], joint[REMAINS:] = half, phi, law[LEFT:]
    return p, joint


@settings(max_examples=40)
@given(kind=kinds, half=halves, k=stiffnesses, turn=turns, over=st.floats(0.05, 3.0), left=lines)
def test_work_on_the_bed_of_a_motion_is_the_integral_of_the_forces_of_its_steps(
    kind, half, k, turn, over, left
):
    """Pressed and turned from where nothing touches, along a straight way; many turns lift an end off."""
    law, end = law_of(kind, k, left), np.array([-over, turn * over / half]) / k
    begin, share = np.array([over / k, 0.0]), np.linspace(0.0, 1.0, 4001)
    way = begin + share[:, None] * (end - begin)
    forces = np.array([bed_forces(law, law[STRENGTH], law[LEFT:], half, *at)[:2] for at in way])
    done = -np.trapezoid(forces @ (end - begin), share)
    p, joint = in_motion(law, half, end[1])
    assert work_on_bed(p, end[0], law, joint) == pytest.approx(done, rel=1e-5, abs=1e-6 * half * over**2 / k)


@settings(max_examples=40)
@given(kind=kinds, half=halves, k=stiffnesses, turn=turns, over=st.floats(0.05, 3.0), left=lines)
def test_dashpots_are_along_the_bed_that_bears(kind, half, k, turn, over, left):
    law, (u, phi) = law_of(kind, k, left), np.array([-over, turn * over / half]) / k
    expected = bed_forces(law, law[STRENGTH], law[LEFT:], half, u, phi)
    p, joint = in_motion(law, half, phi)
    scale = np.array([1.0, half, k, k * half, k * half**2]) * half * max(over, 1.0)
    np.testing.assert_allclose(bed_under(p, u, phi, law, joint) / scale, expected / scale, rtol=0, atol=1e-11)


@settings(max_examples=40)
@given(kind=kinds, half=halves, k=stiffnesses, eccentricity=st.floats(-0.95, 0.95), left=lines)
def test_gaps_and_compliance_under_forces_are_those_of_the_bed_that_has_them(
    kind, half, k, eccentricity, left
):
    law = law_of(kind, k, left)
    n1, n2 = ends_of(eccentricity, 0.9 * 2.0 * half * (1.0 - abs(eccentricity)))  # within the strength
    w1, w2, c11, c12, c22 = gaps_under(law, half, n1, n2)
    n, m, c0, c1, c2 = bed_forces(law, law[STRENGTH], law[LEFT:], half, *displacements(half, (w1, w2)))
    assert (n, m) == pytest.approx((n1 + n2, half * (n2 - n1)), rel=1e-9, abs=1e-9 * half * (n1 + n2))
    # N₁, N₂ = (N ∓ P/h)/2 against u ∓ hφ
    to_ends = 0.5 * np.array([[1.0, -1.0 / half], [1.0, 1.0 / half]])
    stiffness = to_ends @ np.array([[c0, c1], [c1, c2]]) @ to_ends.T
    if SEGMENTS not in kind:  # whose stiffness jumps where a point opens: here two may bear alone
        product = stiffness @ np.array([[c11, -c12], [-c12, c22]])
        assert product == pytest.approx(np.eye(2), abs=1e-6 * abs(stiffness).max() * max(c11, c22))
    gaps = np.empty((1, 2))
    ends_under(np.array([[n1, n2]]), np.array([half]), law[None], gaps)
    assert gaps[0] == pytest.approx([w1, w2], rel=1e-12, abs=1e-12 / k)


@settings(max_examples=25)
@given(half=halves, k=stiffnesses, over=st.floats(0.05, 3.0))
def test_a_tie_in_motion_yields_as_a_whole_and_is_elastic_below(half, k, over):
    law = law_of({STRENGTH: 1.0}, k, [0.0] * 8)
    p, joint = in_motion(law, half, 0.0)
    p[TIED] = 1.0
    assert work_on_bed(p, -over / k, law, joint) == pytest.approx(stored(-over / k, 0.0, half, k), rel=1e-12)
    assert bed_under(p, -over / k, 0.0, law, joint) == pytest.approx(
        stiffened(-over / k, 0.0, half, k), rel=1e-12
    )
