"""Factors of banded matrices against those of LAPACK and of NumPy."""

import numpy as np
import pytest
from scipy.linalg import lapack

from mechanics.kernels.linalg import factors
from mechanics.kernels.linalg.factors import NO_FRONTS, Pattern
from mechanics.solvers.elimination import PADDING, Elimination
from mechanics.types import Array, Index


def linked(blocks: int, reach: int, share: float) -> Index:
    """Rows of pairs of blocks, some `share` of all those that lie not further apart than `reach`."""
    rng = np.random.default_rng(blocks)
    pairs = [(i, i + k) for i in range(blocks) for k in range(1, reach + 1) if i + k < blocks]
    chosen = [pair for pair in pairs if rng.uniform() < share]
    return 3 * np.array(chosen, dtype=np.intp).reshape(-1, 2)


def banded(row: Index, blocks: int, places: int) -> Array:
    """A positive definite matrix of blocks of three rows, linked as told."""
    rng = np.random.default_rng(blocks)
    band = np.zeros((3 * blocks, places))
    for i, j in [*row.tolist(), *((i, i) for i in range(0, 3 * blocks, 3))]:
        for c in range(3):
            for r in range(c if i == j else 0, 3):
                band[i + c, j + r - i - c] = rng.uniform(-1.0, 1.0)
    band[:, 0] = 2.0 * places
    return band


def pattern_of(row: Index, blocks: int, places: int) -> Pattern:
    """Of a band."""
    order = np.arange(3 * blocks)
    return Elimination(order, order, row, places, NO_FRONTS, np.zeros(0)).pattern


BANDS = [(1, 0), (2, 1), (3, 2), (5, 3), (22, 1), (40, 9), (61, 20)]


@pytest.mark.parametrize("share", [1.0, 0.3])
@pytest.mark.parametrize(("blocks", "reach"), BANDS)
def test_factorisation_is_that_of_lapack(blocks: int, reach: int, share: float) -> None:
    """Bands narrower and wider than a tile and than the matrix, full and ragged; factor and solution to rounding."""
    row, width = linked(blocks, reach, share), 3 * reach + 3
    band, pattern = banded(row, blocks, width + PADDING), pattern_of(row, blocks, width + PADDING)
    factor, failed = lapack.dpbtrf(band[:, :width].T.copy(), lower=1)
    assert not failed
    b = np.random.default_rng(1).uniform(-1.0, 1.0, len(band))
    x = b.copy()
    assert factors.cholesky(band.ravel(), pattern)
    factors.substitute(band.ravel(), band.ravel(), pattern, x)
    assert x == pytest.approx(lapack.dpbtrs(factor, b, lower=1)[0], rel=1e-12, abs=1e-14)
    band[:, 0] = 1.0 / band[:, 0]  # which is stored inverted
    for k in range(len(band)):
        inside = min(width, len(band) - k)
        assert band[k, :inside] == pytest.approx(factor.T[k, :inside], rel=1e-12, abs=1e-13)
        assert not band[k, inside:].any(), "what is beyond the band stays zero"
        assert not band[k, pattern.last[k] + 1 - k :].any()


@pytest.mark.parametrize("row", [0, 11])
def test_a_matrix_that_is_not_positive_definite_is_told(row: int) -> None:
    pairs = linked(4, 1, 1.0)
    for value in (0.0, -1.0, np.nan):
        band = banded(pairs, 4, 6 + PADDING)
        band[row, 0] = value
        assert not factors.cholesky(band.ravel(), pattern_of(pairs, 4, 6 + PADDING))


def full_of(lower: Array, upper: Array) -> Array:
    """The matrix of two triangles in a band, the upper one by rows."""
    n, places = lower.shape
    whole = np.zeros((n + places, n + places))
    for j in range(n):
        whole[j, j : j + places] = upper[j]
        whole[j : j + places, j] = lower[j]
    return whole[:n, :n]


def solves(lower: Array, upper: Array, pattern: Pattern, full: Array) -> None:
    b = np.random.default_rng(1).uniform(-1.0, 1.0, len(full))
    x = b.copy()
    factors.substitute(lower, upper, pattern, x)
    assert x == pytest.approx(np.linalg.solve(full, b), rel=1e-10, abs=1e-12)


@pytest.mark.parametrize(("blocks", "reach"), BANDS)
@pytest.mark.parametrize("negative", [0, 1, 2])
def test_lu_counts_negative_eigenvalues_of_a_symmetric_matrix_and_solves(
    blocks: int, reach: int, negative: int
) -> None:
    row, places = linked(blocks, reach, 0.6), 3 * reach + 3 + PADDING
    band, pattern = banded(row, blocks, places), pattern_of(row, blocks, places)
    band[np.random.default_rng(2).permutation(len(band))[:negative], 0] *= -1.0
    full = full_of(band, band)
    lower, upper = band.ravel().copy(), band.ravel().copy()
    assert factors.lu(lower, upper, pattern) == (np.linalg.eigvalsh(full) < 0.0).sum()
    solves(lower, upper, pattern, full)


@pytest.mark.parametrize(("blocks", "reach"), BANDS)
def test_lu_of_an_unsymmetric_band_solves_the_dense_system(blocks: int, reach: int) -> None:
    row, places = linked(blocks, reach, 0.6), 3 * reach + 3 + PADDING
    band, pattern = banded(row, blocks, places), pattern_of(row, blocks, places)
    rng = np.random.default_rng(5)
    other = np.where(band != 0.0, band + rng.uniform(-0.5, 0.5, band.shape), 0.0)
    other[:, 0] = band[:, 0]
    full = full_of(band, other)
    lower, upper = band.ravel().copy(), other.ravel().copy()
    assert factors.lu(lower, upper, pattern) == 0
    solves(lower, upper, pattern, full)


def test_lu_tells_a_pivot_that_vanishes() -> None:
    pairs = linked(4, 1, 1.0)
    for value in (0.0, np.nan):
        band, pattern = banded(pairs, 4, 6 + PADDING), pattern_of(pairs, 4, 6 + PADDING)
        band[0, 0] = value
        assert factors.lu(band.ravel(), band.ravel().copy(), pattern) == -1
