"""The bed of finite strength, and what it keeps: closed forms against integrals over fibres that yield."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.kernels.crushing import crushed, leave, softness, under, worked
from tests.mechanics.kernels.test_bed import displacements, ends_of, halves, stiffnesses, turns

STRENGTH, FIBRES = 1.0, 20_000
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
        force = np.minimum(STRENGTH, self.k * np.maximum(closure, 0.0))
        self.residual += np.maximum(closure - STRENGTH / self.k, 0.0)
        return force.sum() * self.each, (force * self.s).sum() * self.each

    def worked(self, u: float, phi: float) -> float:
        """∫ f dp from the residual on."""
        closure = np.maximum(-(u + phi * self.s) - self.residual, 0.0)
        elastic = np.minimum(closure, STRENGTH / self.k)
        return float((0.5 * self.k * elastic**2 + STRENGTH * (closure - elastic)).sum() * self.each)


def pressed_to(half: float, k: float, over: float, turn: float) -> tuple[float, float]:
    """u and φ of a mean closure of `over` times σ/k, turned by `turn` of it."""
    closed = over * STRENGTH / k
    return -closed, turn * closed / half


@settings(max_examples=30)
@given(half=halves, k=stiffnesses, turn=turns, over=st.floats(0.05, 5.0), before=pressings)
def test_forces_are_those_of_fibres_that_yield(half, k, turn, over, before):
    """Of a bed pressed once before its fibres' residuals are known exactly: the deepest pressing of either end."""
    fibres, left = Fibres(half, k), NONE.copy()
    for one in before[:1]:
        fibres.press(*pressed_to(half, k, *one))
        leave(*pressed_to(half, k, *one), half, k, STRENGTH, left)
    u, phi = pressed_to(half, k, over, turn)
    work, (n, p) = fibres.worked(u, phi), fibres.press(u, phi)
    found = crushed(u, phi, half, k, STRENGTH, left)
    assert found[0] == pytest.approx(n, rel=1e-5, abs=1e-5 * half)
    assert found[1] == pytest.approx(p, abs=1e-5 * half**2 + 1e-5 * n * half)
    assert worked(u, phi, half, k, STRENGTH, left) == pytest.approx(work, rel=1e-5, abs=1e-6 * half / k)


@settings(max_examples=30)
@given(
    half=halves,
    k=stiffnesses,
    turn=turns,
    over=st.floats(0.05, 5.0),
    lines=st.lists(st.floats(-4.0, 4.0), min_size=6, max_size=6),
)
def test_forces_beside_any_three_lines(half, k, turn, over, lines):
    fibres, left = Fibres(half, k), np.array([*lines, 0.0, 0.0]) * STRENGTH / k
    for first, second in left.reshape(4, 2):
        line = 0.5 * (first + second) + 0.5 * (second - first) * fibres.s / half
        fibres.residual = np.maximum(fibres.residual, line)
    u, phi = pressed_to(half, k, over, turn)
    n, p = fibres.press(u, phi)
    found = crushed(u, phi, half, k, STRENGTH, left)
    assert found[:2] == (pytest.approx(n, abs=1e-5 * half), pytest.approx(p, abs=1e-5 * half**2))


@settings(max_examples=30)
@given(half=halves, k=stiffnesses, turn=turns, over=st.floats(0.05, 5.0), before=pressings)
def test_forces_are_minus_the_gradient_of_the_work(half, k, turn, over, before):
    left = NONE.copy()
    for one in before:
        leave(*pressed_to(half, k, *one), half, k, STRENGTH, left)
    u, phi = pressed_to(half, k, over, turn)
    du, dphi = 1e-5 * abs(u), 1e-5 * abs(u) / half

    def work(u: float, phi: float) -> float:
        return worked(u, phi, half, k, STRENGTH, left)

    n, p = crushed(u, phi, half, k, STRENGTH, left)[:2]
    assert (work(u - du, phi) - work(u + du, phi)) / (2.0 * du) == pytest.approx(n, abs=1e-4 * half)
    assert (work(u, phi - dphi) - work(u, phi + dphi)) / (2.0 * dphi) == pytest.approx(p, abs=1e-4 * half**2)


@settings(max_examples=30)
@given(half=halves, k=stiffnesses, turn=turns, over=st.floats(1.01, 5.0))
def test_a_bed_stays_as_it_has_been_pressed(half, k, turn, over):
    """The same displacements have the same forces again; let go by σ/k everywhere the bed carries nothing."""
    left, (u, phi) = NONE.copy(), pressed_to(half, k, over, turn)
    first = np.array(crushed(u, phi, half, k, STRENGTH, left)[:2])
    leave(u, phi, half, k, STRENGTH, left)
    assert left.any()
    assert crushed(u, phi, half, k, STRENGTH, left)[:2] == pytest.approx(first, rel=1e-9, abs=1e-9 * half)
    assert crushed(u + STRENGTH / k, phi, half, k, STRENGTH, left)[0] == pytest.approx(0.0, abs=1e-9 * half)


def test_ends_and_middle_keep_the_lines_of_their_deepest_pressings():
    """Pressed at one end, then at the other, then flat, and less at the first: all three stay."""
    half, k, left = 0.5, 1e3, NONE.copy()
    for u, phi in ((-2e-3, -8e-3), (-2e-3, 8e-3), (-4e-3, 0.0), (-3.5e-3, -3e-3)):
        leave(u, phi, half, k, STRENGTH, left)
    assert left[:6] == pytest.approx([5e-3, -3e-3, -3e-3, 5e-3, 3e-3, 3e-3])


@settings(max_examples=30)
@given(
    half=halves,
    k=stiffnesses,
    eccentricity=st.floats(-0.9, 0.9),
    used=st.floats(0.05, 0.97),
    before=pressings,
)
def test_gaps_are_those_that_the_forces_need(half, k, eccentricity, used, before):
    """At a share of the force that the strength allows at this eccentricity, N(1 − |e|/h) ≤ …"""
    left = NONE.copy()
    for one in before:
        leave(*pressed_to(half, k, *one), half, k, STRENGTH, left)
    most = 2.0 * half * STRENGTH * (1.0 - abs(eccentricity))  # |P| ≤ N(L − N/σ)/2
    n1, n2 = ends_of(eccentricity, used * most)
    ends = under(n1, n2, half, k, STRENGTH, left)
    u, phi = displacements(half, ends)
    n, p, c0, c1, c2 = crushed(u, phi, half, k, STRENGTH, left)
    assert n == pytest.approx(n1 + n2, rel=1e-9)
    assert p == pytest.approx(half * (n2 - n1), abs=1e-9 * n * half)
    c11, c12, c22 = softness(*ends, half, k, STRENGTH, left)
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
    yields = STRENGTH / k
    left = yields * np.array([10.0, 2.0, -320.0, 503.0, 0.0, 0.0, 0.0, 0.0])
    if eccentricity < 0.0:
        left[:4] = left[3::-1].copy()
    n1, n2 = ends_of(eccentricity, used * 2.0 * half * STRENGTH * (1.0 - abs(eccentricity)))
    n, p = crushed(*displacements(half, under(n1, n2, half, k, STRENGTH, left)), half, k, STRENGTH, left)[:2]
    assert n == pytest.approx(n1 + n2, rel=1e-9)
    assert p == pytest.approx(half * (n2 - n1), abs=1e-9 * n * half)
