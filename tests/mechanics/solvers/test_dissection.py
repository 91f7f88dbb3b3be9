"""Nested dissection: its fronts hold what a band holds, and lead to the same solutions with fewer numbers."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from mechanics import time_history
from mechanics.kernels.joint import PLACE
from mechanics.kernels.linalg import factors
from mechanics.kernels.linalg.factors import Pattern
from mechanics.kernels.matrix import diagonal, stiffen
from mechanics.solvers.elimination import BANDED, CHEAPER, SMALLEST, Elimination, Storage, dissected, fronts
from mechanics.steps.static_system import static_system
from mechanics.types import Array, Index
from tests.support.structures import arch_on_piers, running_bond


def neighbours(centres: Array, share: float) -> Index:
    """Pairs (l, 2) of points that touch, some of them left out: holes, and parts that do not hang together."""
    triangles = Delaunay(centres).simplices
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    return pairs[np.random.default_rng(len(centres)).uniform(size=len(pairs)) < share]


def scattered(blocks: int, share: float) -> tuple[Array, Index]:
    """Points (b, 2) at random, and which of them touch."""
    centres = np.random.default_rng(blocks).uniform(size=(blocks, 2)) * (3.0, 1.0)
    return centres, neighbours(centres, share)


IN_FRONTS = Storage(0.0, 0.0)


def store_in(storage: Storage, monkeypatch: pytest.MonkeyPatch) -> None:
    """From now on all matrices but those of signed factors, which are banded."""
    monkeypatch.setattr(
        Elimination,
        "of",
        lambda dof, centres, given=CHEAPER: LAID_OUT(dof, centres, BANDED if given is BANDED else storage),
    )


LAID_OUT = Elimination.of


CASES = [(5, 1.0), (SMALLEST + 1, 1.0), (60, 1.0), (60, 0.3), (400, 1.0), (400, 0.1)]


@pytest.mark.parametrize(("blocks", "share"), CASES)
def test_every_block_is_eliminated_once_and_no_front_is_empty(blocks: int, share: float) -> None:
    centres, linked = scattered(blocks, share)
    order, bounds = dissected(linked, centres)
    assert sorted(order) == list(range(blocks))
    assert bounds[0] == 0 and bounds[-1] == blocks and (np.diff(bounds) > 0).all()


@pytest.mark.parametrize(("blocks", "share"), CASES)
def test_what_a_front_reaches_is_later_and_held_by_the_first_front_reached(blocks: int, share: float) -> None:
    """The rule by which fill is inherited: what a front reaches beyond its first target, that one reaches too."""
    centres, linked = scattered(blocks, share)
    order, bounds = dissected(linked, centres)
    found = fronts(np.argsort(order)[linked], bounds)
    reached = [set(found.below[found.start[k] : found.start[k + 1]] // 3) for k in range(len(found.base))]
    owner = np.repeat(np.arange(len(found.base)), np.diff(bounds))
    for k, rows in enumerate(reached):
        assert all(owner[row] > k for row in rows)
        if rows:
            parent = owner[min(rows)]
            assert {row for row in rows if owner[row] > parent} <= reached[parent]


def dense(lower: Array, upper: Array, row: Index, pattern: Pattern) -> Array:
    """The matrix of two triangles, rows in the order of elimination; `row` (c, 2) as in Elimination."""
    size = 3 * len(pattern.own)
    whole = np.zeros((size, size))
    places = [
        *zip(range(0, size, 3), range(0, size, 3), pattern.own, pattern.step, strict=True),
        *(
            (pair.max(), pair.min(), at, step)
            for pair, at, step in zip(row, pattern.between, pattern.stride, strict=True)
            if at >= 0
        ),
    ]
    for i, j, at, step in places:
        for c in range(3):
            for r in range(c if i == j else 0, 3):
                whole[j + c, i + r] = upper[at + c * step + r]
                whole[i + r, j + c] = lower[at + c * step + r]
    return whole


D = (1.0, 0.2, 0.1, 0.2, 1.0, 0.3, 0.1, 0.3, 1.0)
SKEW, TURNED = (1.0, 0.2, 0.0, 0.2, 1.0, 0.0, -0.5, 0.3, 1.0), (1.0, 0.2, -0.5, 0.2, 1.0, 0.3, 0.0, 0.0, 1.0)


def filled(layout: Elimination, mass: float, d: tuple[float, ...] = D) -> Array:
    """A triangle of a matrix of joints in random places; definite where the `mass` is."""
    c, rng = len(layout.row), np.random.default_rng(len(layout.row))
    places, stored = rng.standard_normal((c, PLACE)), layout.triangle()
    diagonal(np.full(len(layout.order), mass), stored, layout.pattern)
    for k in range(c):
        stiffen(k, places[k], *layout.row[k], d, stored, layout.pattern)
    return stored


def laid_out(blocks: int, share: float) -> Elimination:
    """In fronts: one joint for each pair, and one of every fifth block with a support."""
    centres, linked = scattered(blocks, share)
    dof = np.concatenate([3 * linked[:, [1, 0]], [(3 * i, -3) for i in range(0, blocks, 5)]])
    return Elimination.of((dof[:, :, None] + np.arange(3)).reshape(-1, 6).clip(-1), centres, IN_FRONTS)


def solves(lower: Array, upper: Array, layout: Elimination, matrix: Array, close: float) -> None:
    b = np.random.default_rng(1).standard_normal(len(matrix))
    x = b.copy()
    factors.substitute(lower, upper, layout.pattern, x)
    assert len(layout.fronts.base)
    assert x == pytest.approx(np.linalg.solve(matrix, b), rel=close, abs=0.01 * close)


@pytest.mark.parametrize(("blocks", "share"), CASES)
def test_factors_in_fronts_solve_the_dense_system(blocks: int, share: float) -> None:
    layout = laid_out(blocks, share)
    stored = filled(layout, 1.0)
    matrix = dense(stored, stored, layout.row, layout.pattern)
    assert factors.cholesky(stored, layout.pattern)
    solves(stored, stored, layout, matrix, 1e-9)


@pytest.mark.parametrize(("blocks", "share"), CASES)
def test_lu_in_fronts_solves_the_dense_unsymmetric_system(blocks: int, share: float) -> None:
    layout = laid_out(blocks, share)
    lower, upper = filled(layout, 1.0, SKEW), filled(layout, 1.0, TURNED)
    matrix = dense(lower, upper, layout.row, layout.pattern)
    assert abs(matrix - matrix.T).max() > 0.1
    assert factors.lu(lower, upper, layout.pattern) >= 0
    solves(lower, upper, layout, matrix, 1e-8)


def test_fronts_tell_a_matrix_that_is_not_positive_definite() -> None:
    layout = laid_out(60, 1.0)
    for block in (0, 31, 59):
        for value in (-1e3, np.nan):
            stored = filled(layout, 1.0)
            stored[layout.pattern.own[block]] = value
            assert not factors.cholesky(stored, layout.pattern)


def test_walls_are_dissected_from_some_size_on_and_arches_are_not() -> None:
    """Products of a factorisation: fewer than half of the band's in a wall of a thousand blocks."""

    def layout(model):
        return static_system(model, "rigid").layout

    wall, small, arch = layout(running_bond(31, 32)), layout(running_bond(9, 10)), layout(arch_on_piers())
    assert not len(small.fronts.base) and not len(arch.fronts.base)
    assert not len(layout(running_bond(60, 20)).fronts.base), "too flat for fronts to pay"
    assert len(wall.fronts.base) and wall.fronts.size < 0.8 * len(wall.order) * wall.places
    assert wall.fronts.products() < 0.5 * (0.5 * len(wall.order) * wall.places**2)


@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
def test_a_motion_is_the_same_in_fronts_and_in_a_band(
    behaviour: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To the accuracy of a step, with as many factorisations."""
    model = running_bond(6, 8, stiffness=1e6)
    shaking = 0.4 * np.sin(np.arange(30))
    motions = []
    for storage in (BANDED, IN_FRONTS):
        store_in(storage, monkeypatch)
        motions.append(time_history(model, shaking, 0.005, behaviour, integrator="implicit-euler"))
    band, found = motions
    assert found.worst <= 1e-6
    assert found.positions == pytest.approx(band.positions, abs=1e-7)
