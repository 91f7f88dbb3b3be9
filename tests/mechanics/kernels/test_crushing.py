"""The bed of finite strength, and what it keeps, against fibres that yield; forces, work and gaps of every bed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.kernels.bed import crushed, leave, softness, stiffened, stored, under, worked
from mechanics.kernels.dynamics.motion import JOINT, REMAINS, bed_under, work_on_bed
from mechanics.kernels.joint import PHI, PLACE, TIED, H
from mechanics.kernels.law import BED, LAW, LEFT, SEGMENTS, STRENGTH, bed_forces, ends_under, gaps_under
from mechanics.types import Array
from tests.mechanics.kernels.test_bed import displacements, ends_of, halves, stiffnesses, turns

YIELDS, FIBRES = 1.0, 20_000
NONE = np.zeros(8)
pressings = st.lists(st.tuples(st.floats(0.1, 4.0), turns), max_size=3)


class Fibres:
    """The bed as many fibres, each of which keeps what it has been pressed in beyond σ/k."""

    def __init__(self, half: float, k: float):
        self.k, self.each = k, 2.0 * half / FIBRES
        self.s = half * (2.0 * (np.arange(FIBRES) + 0.5) / FIBRES - 1.0)
        self.residual = np.zeros(FIBRES)

    def press(self, u: float, phi: float) -> tuple[float, float]:
        """N and P; fibres that yield keep their residual."""
        closure = -(u + phi * self.s) - self.residual
        force = np.minimum(YIELDS, self.k * np.maximum(closure, 0.0))
        self.residual += np.maximum(closure - YIELDS / self.k, 0.0)
        return force.sum() * self.each, (force * self.s).sum() * self.each

    def worked(self, u: float, phi: float) -> float:
        """∫ f dp from the residual on."""
        closure = np.maximum(-(u + phi * self.s) - self.residual, 0.0)
        elastic = np.minimum(closure, YIELDS / self.k)
        return float((0.5 * self.k * elastic**2 + YIELDS * (closure - elastic)).sum() * self.each)


def pressed_to(half: float, k: float, over: float, turn: float) -> tuple[float, float]:
    """u and φ of a mean closure of `over` times σ/k, turned by `turn` of it."""
    closed = over * YIELDS / k
    return -closed, turn * closed / half


@settings(max_examples=30)
@given(half=halves, k=stiffnesses, turn=turns, over=st.floats(0.05, 5.0), before=pressings)
def test_forces_are_those_of_fibres_that_yield(half, k, turn, over, before):
    """Of a bed pressed once before its fibres' residuals are known exactly: the deepest pressing of either end."""
    fibres, left = Fibres(half, k), NONE.copy()
    for one in before[:1]:
        fibres.press(*pressed_to(half, k, *one))
        leave(*pressed_to(half, k, *one), half, k, YIELDS, left)
    u, phi = pressed_to(half, k, over, turn)
    work, (n, p) = fibres.worked(u, phi), fibres.press(u, phi)
    found = crushed(u, phi, half, k, YIELDS, left)
    assert found[0] == pytest.approx(n, rel=1e-5, abs=1e-5 * half)
    assert found[1] == pytest.approx(p, abs=1e-5 * half**2 + 1e-5 * n * half)
    assert worked(u, phi, half, k, YIELDS, left) == pytest.approx(work, rel=1e-5, abs=1e-6 * half / k)


@settings(max_examples=30)
@given(
    half=halves, k=stiffnesses, turn=turns, over=st.floats(0.05, 5.0),
    lines=st.lists(st.floats(-4.0, 4.0), min_size=6, max_size=6),
)  # fmt: skip
def test_forces_beside_any_three_lines(half, k, turn, over, lines):
    fibres, left = Fibres(half, k), np.array([*lines, 0.0, 0.0]) * YIELDS / k
    for first, second in left.reshape(4, 2):
        line = 0.5 * (first + second) + 0.5 * (second - first) * fibres.s / half
        fibres.residual = np.maximum(fibres.residual, line)
    u, phi = pressed_to(half, k, over, turn)
    n, p = fibres.press(u, phi)
    found = crushed(u, phi, half, k, YIELDS, left)
    assert found[:2] == (pytest.approx(n, abs=1e-5 * half), pytest.approx(p, abs=1e-5 * half**2))


@settings(max_examples=30)
@given(half=halves, k=stiffnesses, turn=turns, over=st.floats(0.05, 5.0), before=pressings)
def test_forces_are_minus_the_gradient_of_the_work(half, k, turn, over, before):
    left = NONE.copy()
    for one in before:
        leave(*pressed_to(half, k, *one), half, k, YIELDS, left)
    u, phi = pressed_to(half, k, over, turn)
    du, dphi = 1e-5 * abs(u), 1e-5 * abs(u) / half

    def work(u: float, phi: float) -> float:
        return worked(u, phi, half, k, YIELDS, left)

    n, p = crushed(u, phi, half, k, YIELDS, left)[:2]
    assert (work(u - du, phi) - work(u + du, phi)) / (2.0 * du) == pytest.approx(n, abs=1e-4 * half)
    assert (work(u, phi - dphi) - work(u, phi + dphi)) / (2.0 * dphi) == pytest.approx(p, abs=1e-4 * half**2)


def test_ends_and_middle_keep_the_lines_of_their_deepest_pressings():
    """Pressed at one end, then at the other, then flat, and less at the first: all three stay."""
    half, k, left = 0.5, 1e3, NONE.copy()
    for u, phi in ((-2e-3, -8e-3), (-2e-3, 8e-3), (-4e-3, 0.0), (-3.5e-3, -3e-3)):
        leave(u, phi, half, k, YIELDS, left)
    assert left[:6] == pytest.approx([5e-3, -3e-3, -3e-3, 5e-3, 3e-3, 3e-3])


@settings(max_examples=30)
@given(
    half=halves, k=stiffnesses, eccentricity=st.floats(-0.9, 0.9), used=st.floats(0.05, 0.97),
    before=pressings,
)  # fmt: skip
def test_gaps_are_those_that_the_forces_need(half, k, eccentricity, used, before):
    """At a share of the force that the strength allows at this eccentricity, N(1 − |e|/h) ≤ …"""
    left = NONE.copy()
    for one in before:
        leave(*pressed_to(half, k, *one), half, k, YIELDS, left)
    most = 2.0 * half * YIELDS * (1.0 - abs(eccentricity))  # |P| ≤ N(L − N/σ)/2
    n1, n2 = ends_of(eccentricity, used * most)
    ends = under(n1, n2, half, k, YIELDS, left)
    u, phi = displacements(half, ends)
    n, p, c0, c1, c2 = crushed(u, phi, half, k, YIELDS, left)
    assert n == pytest.approx(n1 + n2, rel=1e-9)
    assert p == pytest.approx(half * (n2 - n1), abs=1e-9 * n * half)
    c11, c12, c22 = softness(*ends, half, k, YIELDS, left)
    stiff = np.array([[c0, c1], [c1, c2]])
    to_ends = np.array([[1.0, -half], [1.0, half]])
    expected = to_ends @ np.linalg.inv(stiff) @ to_ends.T
    assert [c11, -c12, c22] == pytest.approx(
        [expected[0, 0], expected[0, 1], expected[1, 1]], rel=1e-5, abs=1e-6 * abs(expected).max()
    )


@pytest.mark.parametrize(("eccentricity", "used"), [(0.994, 0.985), (-0.995, 0.83), (-0.97, 0.97)])
def test_gaps_are_found_beside_what_is_crushed_deep(eccentricity, used):
    """By lines of hundreds of σ/k, near the bound: a search that began on both ends' lines ended in their middle."""
    half, k = 1.5, 1e6
    yields = YIELDS / k
    left = yields * np.array([10.0, 2.0, -320.0, 503.0, 0.0, 0.0, 0.0, 0.0])
    if eccentricity < 0.0:
        left[:4] = left[3::-1].copy()
    n1, n2 = ends_of(eccentricity, used * 2.0 * half * YIELDS * (1.0 - abs(eccentricity)))
    n, p = crushed(*displacements(half, under(n1, n2, half, k, YIELDS, left)), half, k, YIELDS, left)[:2]
    assert n == pytest.approx(n1 + n2, rel=1e-9)
    assert p == pytest.approx(half * (n2 - n1), abs=1e-9 * n * half)


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
