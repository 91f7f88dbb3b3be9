"""The compiled loops of a time step against the plain ones and against LAPACK."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import scipy
from scipy.linalg import lapack

from mechanics.block import Array
from mechanics.joints import Index
from mechanics.solvers import iterations, kernels
from mechanics.solvers.band import envelope
from mechanics.solvers.dissection import NO_FRONTS
from mechanics.solvers.elimination import PADDING, Elimination, Pattern
from mechanics.solvers.iterations import worst
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
def test_compiled_factorisation_is_that_of_lapack(blocks: int, reach: int, share: float) -> None:
    """Bands narrower and wider than a tile and than the matrix, full and ragged; factor and solution to rounding."""
    cholesky = pytest.importorskip("mechanics.solvers.cholesky")
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
    cholesky = pytest.importorskip("mechanics.solvers.cholesky")
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


@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
@pytest.mark.parametrize("name", sorted(MODELS))
def test_both_sets_of_iterations_do_the_same(name: str, behaviour: str) -> None:
    """As many factorisations, the same contact states and forces, from the inside and from states."""
    compiled = pytest.importorskip("mechanics.solvers.compiled")
    model = MODELS[name]
    for seed in range(4):
        program = euler_step(model, behaviour, shaken(model, seed), 0.3)
        next_one = euler_step(model, behaviour, shaken(model, seed), 0.32)
        solvers = [newton_for(model, program, loops) for loops in (kernels, compiled)]
        still, none = np.zeros(len(program.load)), np.zeros_like(program.gap)
        for step in (program, next_one):
            plain, quick = (solver.solve(step, still, none) for solver in solvers)
            assert plain is not None and quick is not None
            assert plain.forces == pytest.approx(quick.forces, abs=1e-6 * step.weight)
            assert solvers[0].factorisations == solvers[1].factorisations
            assert solvers[0].repeated == solvers[1].repeated
            assert (solvers[0].state == solvers[1].state).all()


@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
def test_springs_of_a_step_are_the_same_in_both_loops(behaviour: str) -> None:
    compiled = pytest.importorskip("mechanics.solvers.compiled")
    model = MODELS["arch"]
    contacts = model.contacts(behaviour)
    rows = model.kinematics(behaviour, shaken(model, 1).positions)
    rng, c = np.random.default_rng(2), len(contacts)
    moved, forces = rng.standard_normal((len(model.blocks), 3)), rng.standard_normal((c, 2))
    stiffness = np.full(c, np.inf) if behaviour == "rigid" else contacts.stiffness[:, 0].copy()
    compliance, before = rng.uniform(0.0, 1.0, (c, 2)), rng.standard_normal(c)
    if behaviour == "rigid":
        compliance[:] = 0.0
    start, results = rng.standard_normal(c), []
    for loops in (kernels, compiled):
        shear = np.empty(c)
        sums = loops.springs(
            contacts.a, contacts.b, rows.normal, rows.tangent, moved, forces, start,
            rows.slide, compliance, stiffness, contacts.friction, before, shear, 0.7, 0.2,
        )  # fmt: skip
        results.append((sums, shear))
    assert results[0][0] == pytest.approx(results[1][0], rel=1e-12)
    assert results[0][1] == pytest.approx(results[1][1], rel=1e-12)
    if behaviour == "rigid":
        assert (results[0][1] == before).all() and results[0][0][1] == 0.0


def test_what_springs_hold_at_the_start_is_the_same_in_both_loops() -> None:
    """Gaps and slides of a step, compliances and energy; an open gap stays what it is, a closed one is stretched."""
    compiled = pytest.importorskip("mechanics.solvers.compiled")
    rng = np.random.default_rng(3)
    start, compliance = rng.standard_normal((9, 2)), rng.uniform(0.0, 1.0, (9, 2))
    shear, stiffness = rng.standard_normal(9), rng.uniform(0.5, 1.0, 9)
    results = []
    for loops in (kernels, compiled):
        gap, soft = np.empty((9, 2)), np.empty((9, 2))
        loops.at_start(start, shear, compliance, 0.7, gap, soft)
        results.append((gap, soft, loops.strain_energy(start, stiffness, compliance, shear)))
    for plain, quick in zip(*results, strict=True):
        assert quick == pytest.approx(plain, rel=1e-14)
    gap, closed = results[0][0], start[:, 0] < 0.0
    assert 0 < closed.sum() < 9
    assert gap[:, 0] == pytest.approx(np.where(closed, start[:, 0] / 0.7, start[:, 0]))


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
    for loops in _every_loop():
        program = euler_step(model, "elastic", shaken(model, 1), 0.3)
        program.load[4] = np.nan
        newton = newton_for(model, program, loops)
        for _ in range(2):
            assert newton.solve(program, np.zeros(len(program.load)), np.zeros_like(program.gap)) is None
        program.load[4] = 0.0
        found = newton.solve(program, np.zeros(len(program.load)), np.zeros_like(program.gap))
        assert found is not None, "what went wrong is not begun from again"


def _every_loop() -> list[ModuleType]:
    try:
        from mechanics.solvers import compiled
    except ImportError:
        return [kernels]
    return [kernels, compiled]


def test_compiled_code_goes_by_the_sources_of_all_that_it_uses(tmp_path: Path) -> None:
    """A cache by the file of each function alone would keep the code of what has changed in another file."""
    compiler = pytest.importorskip("mechanics.solvers.compiler")
    from mechanics.solvers import cholesky, compiled, compiled_iterations

    name = compiler.digest(Path(compiler.__file__).with_name(f"{source}.py") for source in compiler.SOURCES)
    for module in (cholesky, compiled, compiled_iterations):
        assert Path(module.__file__).stem in compiler.SOURCES
        for value in vars(module).values():
            if hasattr(value, "py_func"):
                assert value.py_func.__qualname__.endswith(name)
    files = tmp_path / "a.py", tmp_path / "b.py"
    for file in files:
        file.write_text("x = 1\n")
    before = compiler.digest(files)
    files[1].write_text("x = 2\n")
    assert compiler.digest(files) != before


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
    count, residuals = iterations.semismooth(
        *posed, x, forces, state, newton.stored, newton.pattern, scale, 3
    )
    assert count == 1
    assert worst(residuals, program.weight, program.step) == np.inf
    assert not x.any() and not forces.any()
