"""The bed of a joint: its closed forms against integrals, its dual, points."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mechanics.kernels.bed import closures, compliance, linearised, points_under, pressed, stiffened, stored
from tests.support.reference_loops import bed_of_points, bed_resultants

halves = st.floats(0.05, 2.0)
stiffnesses = st.floats(2.0, 8.0).map(lambda x: 10.0**x)
eccentricities = st.floats(-0.98, 0.98)  # of half the joint
turns = st.floats(-3.0, 3.0)  # half the joint's length times φ, per mean closure
STEP = 1e-6


def displacements(half: float, ends: tuple[float, float]) -> tuple[float, float]:
    """u and φ of gaps at the two ends."""
    return 0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]) / half


def ends_of(eccentricity: float, force: float = 1.0) -> tuple[float, float]:
    return 0.5 * force * (1.0 - eccentricity), 0.5 * force * (1.0 + eccentricity)


@settings(max_examples=30)
@given(half=halves, k=stiffnesses, turn=turns, closed=st.floats(1e-6, 1e-2))
def test_force_and_couple_are_integrals_of_the_pressure(half, k, turn, closed):
    u, phi = -closed, turn * closed / half
    energy, n, p = bed_resultants(u, phi, half, k)
    found = pressed(u, phi, half, k)
    assert found[0] == pytest.approx(n, rel=1e-6)
    assert found[1] == pytest.approx(p, abs=1e-6 * n * half)
    assert stored(u, phi, half, k) == pytest.approx(energy, rel=1e-6)


@settings(max_examples=30)
@given(half=halves, k=stiffnesses, turn=turns, closed=st.floats(1e-6, 1e-2))
def test_forces_are_minus_the_gradient_of_the_energy_and_stiffness_its_derivative(half, k, turn, closed):
    u, phi = -closed, turn * closed / half
    assume(abs(abs(turn) - 1.0) > 1e-3)  # the stiffness has a kink where an end begins to open
    du, dphi = STEP * closed, STEP * closed / half
    n, p, c0, c1, c2 = stiffened(u, phi, half, k)
    slope = (stored(u + du, phi, half, k) - stored(u - du, phi, half, k)) / (2.0 * du)
    tilt = (stored(u, phi + dphi, half, k) - stored(u, phi - dphi, half, k)) / (2.0 * dphi)
    assert -slope == pytest.approx(n, rel=1e-6)
    assert -tilt == pytest.approx(p, abs=1e-6 * n * half)
    along_u = [np.array(stiffened(u + sign * du, phi, half, k)[:2]) for sign in (1, -1)]
    along_phi = [np.array(stiffened(u, phi + sign * dphi, half, k)[:2]) for sign in (1, -1)]
    assert -(along_u[0] - along_u[1]) / (2.0 * du) == pytest.approx([c0, c1], abs=1e-5 * c0 * max(half, 1.0))
    assert -(along_phi[0] - along_phi[1]) / (2.0 * dphi) == pytest.approx(
        [c1, c2], abs=1e-5 * c0 * max(half, half**2)
    )


def dual(n1: float, n2: float, half: float, k: float) -> float:
    """W* of an elastic bed: quadratic while the whole bed is pressed, else 2N²/(9k(L/2 − |e|))."""
    n, length = n1 + n2, 2.0 * half
    e = abs(half * (n2 - n1)) / n
    if e <= length / 6.0:
        return n**2 / (2.0 * k * length) * (1.0 + 12.0 * e**2 / length**2)
    return 2.0 * n**2 / (9.0 * k * (half - e))


@settings(max_examples=40)
@given(half=halves, k=stiffnesses, eccentricity=eccentricities)
def test_bed_and_dual_fulfil_fenchels_equality(half, k, eccentricity):
    """W(u, φ) + W*(N, P) = −(Nu + Pφ) on the law, and it is more anywhere else."""
    n1, n2 = ends_of(eccentricity)
    soft = 1.0 / (2.0 * half * k)
    u, phi = displacements(half, closures(n1, n2, soft))
    found = pressed(u, phi, half, k)
    assert found[:2] == pytest.approx((1.0, half * eccentricity), abs=1e-12 * max(1.0, half))
    product = -(u + half * eccentricity * phi)
    assert stored(u, phi, half, k) + dual(n1, n2, half, k) == pytest.approx(product, rel=1e-11)
    for off in (0.9, 1.1):
        other = stored(off * u, phi, half, k) + dual(n1, n2, half, k)
        assert other > -(off * u + half * eccentricity * phi)


@settings(max_examples=30)
@given(half=halves, k=stiffnesses, eccentricity=eccentricities)
def test_compliance_is_the_derivative_of_the_closures(half, k, eccentricity):
    n1, n2 = ends_of(eccentricity)
    soft, d = 1.0 / (2.0 * half * k), STEP * min(n1, n2)
    assume(min(abs(2.0 * n1 - n2), abs(2.0 * n2 - n1)) > 10.0 * d)
    c11, c12, c22 = compliance(n1, n2, soft)
    first = (np.array(closures(n1 + d, n2, soft)) - closures(n1 - d, n2, soft)) / (2.0 * d)
    other = (np.array(closures(n1, n2 + d, soft)) - closures(n1, n2 - d, soft)) / (2.0 * d)
    close = 1e-6 * max(c11, c22)
    assert first == pytest.approx([-c11, c12], abs=close)
    assert other == pytest.approx([c12, -c22], abs=close)
    assert min(c11, c22) > 0.0 < c11 * c22 - c12**2


@settings(max_examples=30)
@given(half=halves, k=stiffnesses, eccentricity=eccentricities)
def test_the_stiffer_tangent_is_that_of_the_law_where_forces_and_turn_agree(half, k, eccentricity):
    n1, n2 = ends_of(eccentricity)
    soft = 1.0 / (2.0 * half * k)
    g = closures(n1, n2, soft)
    found = linearised(n1, n2, g[0] - g[1], soft)
    expected = (*g, *compliance(n1, n2, soft))
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-9 * soft)


@settings(max_examples=30)
@given(half=halves, k=stiffnesses, eccentricity=eccentricities, n=st.integers(2, 64))
def test_gaps_of_a_bed_of_points_are_those_whose_springs_bear_the_forces(half, k, eccentricity, n):
    n1, n2 = ends_of(0.9 * eccentricity)
    g1, g2, c11, c12, c22 = points_under(n1, n2, n, 1.0 / (2.0 * half * k))
    u, phi = displacements(half, (g1, g2))
    _, force, couple = bed_of_points(u, phi, half, k, n)
    assert (force, couple) == pytest.approx((1.0, half * (n2 - n1)), abs=1e-9 * max(1.0, half))
    # between two kinks the law is linear: the gaps are the compliance times the forces
    assert (-c11 * n1 + c12 * n2, c12 * n1 - c22 * n2) == pytest.approx((g1, g2), rel=1e-9)
