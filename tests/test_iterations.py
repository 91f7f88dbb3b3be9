"""The loops of a time step: factors against those of LAPACK, springs, runs, and what ends an iteration."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy
from scipy.linalg import lapack

from mechanics.block import Array
from mechanics.joints import Index
from mechanics.solvers import cholesky, compiled, kernels
from mechanics.solvers.band import envelope
from mechanics.solvers.compiled_iterations import semismooth
from mechanics.solvers.dissection import NO_FRONTS
from mechanics.solvers.elimination import PADDING, Elimination, Pattern
from mechanics.solvers.kernels import worst
from mechanics.solvers.runs import runs
from mechanics.solvers.threads import _libraries, one_thread
from tests.steps import euler_step
from tests.structures import arch_on_piers, running_bond
from tests.test_newton import newton_for, shaken

MODELS = {"wall": running_bond(4, 5, stiffness=1e6), "arch": arch_on_piers(voussoirs=7, courses=3)}


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
    return Elimination(order, order, row, places, NO_FRONTS).pattern


@pytest.mark.parametrize("share", [1.0, 0.3])
@pytest.mark.parametrize(("blocks", "reach"), [(1, 0), (2, 1), (3, 2), (5, 3), (22, 1), (40, 9), (61, 20)])
def test_factorisation_is_that_of_lapack(blocks: int, reach: int, share: float) -> None:
    """Bands narrower and wider than a tile and than the matrix, full and ragged; factor and solution to rounding."""
    row, width = linked(blocks, reach, share), 3 * reach + 3
    band, pattern = banded(row, blocks, width + PADDING), pattern_of(row, blocks, width + PADDING)
    factor, failed = lapack.dpbtrf(band[:, :width].T.copy(), lower=1)
    assert not failed
    b = np.random.default_rng(1).uniform(-1.0, 1.0, len(band))
    x = b.copy()
    assert cholesky.factorise(band.ravel(), pattern)
    cholesky.substitute(band.ravel(), pattern, x)
    assert x == pytest.approx(lapack.dpbtrs(factor, b, lower=1)[0], rel=1e-12, abs=1e-14)
    band[:, 0] = 1.0 / band[:, 0]  # which is stored inverted
    for k in range(len(band)):
        inside = min(width, len(band) - k)
        assert band[k, :inside] == pytest.approx(factor.T[k, :inside], rel=1e-12, abs=1e-13)
        assert not band[k, inside:].any(), "what is beyond the band stays zero"
        assert not band[k, pattern.last[k] + 1 - k :].any()


@pytest.mark.parametrize("row", [0, 4, 11])
def test_a_matrix_that_is_not_positive_definite_is_told(row: int) -> None:
    pairs = linked(4, 1, 1.0)
    for value in (0.0, -1.0, np.nan):
        band = banded(pairs, 4, 6 + PADDING)
        band[row, 0] = value
        assert not cholesky.factorise(band.ravel(), pattern_of(pairs, 4, 6 + PADDING))


def test_envelope_of_a_few_links() -> None:
    """Five blocks, the first linked with the third, the second with the fourth; the last stands alone."""
    first, last = envelope(np.array([[0, 6], [9, 3], [-1, 12]]), 15)
    assert first.tolist() == [0] * 3 + [3] * 3 + [0] * 3 + [3] * 3 + [12] * 3
    assert last.tolist() == [8] * 3 + [11] * 9 + [14] * 3


def test_an_empty_right_hand_side_is_left_alone(capfd: pytest.CaptureFixture[str]) -> None:
    """LAPACK, which once took it, printed a line of complaint for each."""
    pairs = linked(4, 1, 1.0)
    band, pattern, b = banded(pairs, 4, 6 + PADDING).ravel(), pattern_of(pairs, 4, 6 + PADDING), np.empty(0)
    assert cholesky.factorise(band, pattern)
    cholesky.substitute(band, pattern, b)
    assert not len(b) and capfd.readouterr() == ("", "")


def springs(behaviour: str) -> tuple[tuple[float, float, float], Array, Array]:
    """Energies of a step, and the shear of the springs before and after it."""
    model = MODELS["arch"]
    contacts = model.contacts(behaviour)
    rows = model.kinematics(behaviour, shaken(model, 1).positions)
    rng, c = np.random.default_rng(2), len(contacts)
    moved, forces = rng.standard_normal((len(model.blocks), 3)), rng.standard_normal((c, 2))
    stiffness = np.full(c, np.inf) if behaviour == "rigid" else contacts.stiffness[:, 0].copy()
    compliance = np.zeros((c, 2)) if behaviour == "rigid" else rng.uniform(0.0, 1.0, (c, 2))
    start, before, shear = rng.standard_normal(c), rng.standard_normal(c), np.empty(c)
    energies = compiled.springs(
        contacts.a, contacts.b, rows.normal, rows.tangent, moved, forces, start,
        rows.slide, compliance, stiffness, contacts.friction, before, shear, 0.7, 0.2,
    )  # fmt: skip
    opening, slide = (
        (row * np.concatenate([moved[contacts.a], moved[contacts.b]], axis=1)).sum(axis=1)
        for row in (rows.normal, rows.tangent)
    )
    slip = compliance[:, 1] * forces[:, 1] + rows.slide + slide
    assert energies[0] == pytest.approx(-forces[:, 1] @ slip), "friction works on the slip"
    work = -forces[:, 0] @ opening - forces[:, 1] @ (slide - slip)
    flexible, ends = 0.7 * compliance[:, 1], (start, start + opening)
    pressed, after = (np.maximum(-gap, 0.0) * np.where(np.isinf(stiffness), 0.0, stiffness) for gap in ends)
    stored = 0.5 * ((after**2 - pressed**2) / stiffness + flexible * (shear**2 - before**2)).sum()
    assert energies[2] == pytest.approx(work - energies[1] - stored), "the rest is the time stepping's"
    return energies, before, shear


def test_springs_of_rigid_contacts_hold_nothing() -> None:
    energies, before, shear = springs("rigid")
    assert energies[1] == 0.0
    assert (shear == before).all()


def test_springs_of_elastic_contacts_lose_energy_to_dashpots() -> None:
    energies, before, shear = springs("elastic")
    assert energies[1] > 0.0
    assert (shear != before).any()


def test_what_springs_hold_at_the_start_of_a_step() -> None:
    """Gaps and slides of a step, compliances and energy; an open gap stays what it is, a closed one is stretched."""
    rng = np.random.default_rng(3)
    start, compliance = rng.standard_normal((9, 2)), rng.uniform(0.0, 1.0, (9, 2))
    shear, stiffness = rng.standard_normal(9), rng.uniform(0.5, 1.0, 9)
    gap, soft = np.empty((9, 2)), np.empty((9, 2))
    compiled.at_start(start, shear, compliance, 0.7, gap, soft)
    closed = start[:, 0] < 0.0
    assert 0 < closed.sum() < 9
    assert gap[:, 0] == pytest.approx(np.where(closed, start[:, 0] / 0.7, start[:, 0]))
    assert gap[:, 1] == pytest.approx(-soft[:, 1] * shear)
    assert soft == pytest.approx(compliance / 0.7)
    energy = 0.5 * (stiffness[closed] @ start[closed, 0] ** 2 + compliance[:, 1] @ shear**2)
    assert compiled.strain_energy(start, stiffness, compliance, shear) == pytest.approx(energy)


def test_contacts_of_two_blocks_form_one_run() -> None:
    """Points seen from either block belong together; a run ends where another pair of blocks begins."""
    row = np.array([[0, 3], [3, 0], [0, 3], [-1, 3], [3, -1], [6, 0], [6, 3]])
    found = runs(row)
    assert found.start.tolist() == [5, 6, 3, 0]
    assert found.ends.tolist() == [[6, 0], [6, 3], [3, -1], [0, 3]]
    # of one length side by side: the first points of two runs are all that they have, the others come one by one
    assert found.parts.tolist() == [[0, 2, 1, 0], [2, 3, 2, 2], [3, 4, 3, 4]]
    assert found.column.tolist() == [4, 5, 6, 2, 3, 0, 1]
    none = runs(row[:0])
    assert not len(none.start) and none.parts.shape == (0, 4)


def test_points_of_runs_alike_alternate_in_parts_of_some_hundred(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mechanics.solvers.runs.PART", 6)
    found = runs(np.repeat([[0, 3], [3, 6], [6, 9], [9, -1]], 2, axis=0))
    assert found.parts.tolist() == [[0, 3, 2, 0], [3, 4, 2, 6]]
    assert found.column.tolist() == [0, 3, 1, 4, 2, 5, 6, 7]


def test_what_is_no_number_is_no_solution() -> None:
    """A maximum passes over nan: the sum of the complementarities does not."""
    assert worst((0.0, 0.0, np.nan, 0.0), 1.0, 1.0) == np.inf
    assert worst((1e-9, 2e-9, 1e-9, 1e-9), 1.0, 1.0) == 2e-9
    model = MODELS["arch"]
    program = euler_step(model, "elastic", shaken(model, 1), 0.3)
    program.load[4] = np.nan
    newton = newton_for(model, program)
    for _ in range(2):
        assert newton.solve(program, np.zeros(len(program.load)), np.zeros_like(program.gap)) is None
    program.load[4] = 0.0
    found = newton.solve(program, np.zeros(len(program.load)), np.zeros_like(program.gap))
    assert found is not None, "what went wrong is not begun from again"


def test_one_thread_within_and_as_many_as_before_afterwards() -> None:
    """Of the BLAS that each of the two wheels brings."""
    wheels = [path.parent for path in (Path(np.__file__).parent, Path(scipy.__file__).parent)]
    names = ("numpy", "scipy")
    assert len(_libraries()) == sum(
        any(wheel.glob(f"{name}.libs/*openblas*")) for wheel, name in zip(wheels, names, strict=True)
    )
    before = [ask() for ask, _ in _libraries()]
    with one_thread():
        assert all(ask() == 1 for ask, _ in _libraries())
    assert [ask() for ask, _ in _libraries()] == before


def test_corrections_end_where_they_are_many() -> None:
    """States far from those of the solution are given up after one factorisation."""
    model = MODELS["wall"]
    program = euler_step(model, "elastic", shaken(model, 2), 0.5)
    newton = newton_for(model, program)
    assert program.mass is not None
    x, forces = np.zeros(len(program.load)), np.zeros_like(program.gap)
    state = np.full(len(forces), kernels.STICKING)
    scale = (program.weight, program.size, program.step, 1e-6)
    posed = newton._posed(program, program.mass[newton.order], program.load[newton.order])
    count, residuals = semismooth(*posed, x, forces, state, newton.stored, newton.packed, scale, 3)
    assert count == 1
    assert worst(residuals, program.weight, program.step) == np.inf
    assert not x.any() and not forces.any()
