"""The compiled loops of a joint against their definitions: resultants, stiffness, and the elimination of its laws."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.kernels.interior import joint_law, joints
from mechanics.kernels.interior.joint_law import KNOWN, LANES
from mechanics.kernels.joint import CURVED, H, curvature
from mechanics.kernels.law import BED, DILATION, FRICTION, LAW, SEGMENTS, SHEAR, STRENGTH
from mechanics.kernels.matrix import bend, diagonal, motion, push, stiffen, turn
from mechanics.model.contacts import rows
from mechanics.steps.static_system import static_system
from mechanics.types import Array
from tests.mechanics.solvers.test_dissection import dense
from tests.support.reference_loops import joint_newton
from tests.support.steps import shaken
from tests.support.structures import arch_on_piers, running_bond, tied_arch

MODELS = {"wall": running_bond(4, 5), "arch": arch_on_piers(voussoirs=7, courses=3), "tied": tied_arch()}
COLUMNS = {
    name: getattr(joint_law, name)
    for name in (
        "N1", "N2", "T", "Y1", "Y2", "LP", "LM", "G1", "G2", "BETA", "E1", "E2", "SLIP", "ZP", "ZM", "S11", "S12",
        "S22",
    )
}  # fmt: skip
seeds = st.integers(0, 2**32 - 1)


def full_rows(model, places: Array, columns: int, row: Array) -> Array:
    """B (j, 3, m), columns in the order of elimination."""
    local, found = rows(places), np.zeros((len(places), 3, columns))
    for k, (i, j) in enumerate(row):
        for at, part in ((i, local[k, :, :3]), (j, local[k, :, 3:])):
            if at >= 0:
                found[k, :, at : at + 3] += part
    return found


@pytest.mark.parametrize("name", sorted(MODELS))
def test_what_blocks_see_and_feel_of_joints_is_that_of_their_rows(name):
    model = MODELS[name]
    layout = static_system(model, "elastic").layout
    places = model.contacts.places(shaken(model, 1).positions)
    m, rng = len(layout.order), np.random.default_rng(3)
    b = full_rows(model, places, m, layout.row)
    x, forces, total = rng.standard_normal(m), rng.standard_normal((len(places), 3)), np.zeros(m)
    for k, (i, j) in enumerate(layout.row):
        assert motion(places[k], i, j, x) == pytest.approx(b[k] @ x, abs=1e-12)
        push(places[k], i, j, *forces[k], total)
    assert total == pytest.approx(np.einsum("jrm,jr->m", b, forces), abs=1e-11)


@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
@pytest.mark.parametrize("name", sorted(MODELS))
def test_the_matrix_is_the_sum_of_the_joints_stiffness_and_mass(name, behaviour):
    """M̄ + BᵀDB less the curvature, whichever block of a joint is eliminated first."""
    model = MODELS[name]
    layout = static_system(model, behaviour).layout
    places = model.contacts.places(shaken(model, 2).positions)
    m, rng = len(layout.order), np.random.default_rng(4)
    b, mass = full_rows(model, places, m, layout.row), rng.uniform(1.0, 2.0, m)
    lower, upper = layout.triangle(), layout.triangle()
    diagonal(mass, lower, layout.pattern)
    diagonal(mass, upper, layout.pattern)
    expected, x, change = np.diag(mass), rng.standard_normal(m), np.zeros(m)
    for k, (i, j) in enumerate(layout.row):
        d, c = rng.standard_normal((3, 3)), np.empty(CURVED)
        stiffen(k, places[k], i, j, d.ravel(), lower, layout.pattern)
        stiffen(k, places[k], i, j, d.T.ravel(), upper, layout.pattern)
        expected += b[k].T @ d @ b[k]
        curvature(places[k], *rng.standard_normal(3), c)
        turn(c, i, j, x, change)
        bend(k, i, j, c, lower, layout.pattern)
        bend(k, i, j, c, upper, layout.pattern)
    found = dense(lower, upper, layout.row, layout.pattern)
    assert found @ x + change == pytest.approx(expected @ x, rel=1e-10, abs=1e-9)


LANE = 3  # of a row of joints, any of them
ENTRIES = [
    (joint_law.DUU, joint_law.DUP, joint_law.DUV),
    (joint_law.DUP, joint_law.DPP, joint_law.DPV),
    (joint_law.DVU, joint_law.DVP, joint_law.DVV),
]
LAWS = ["rigid", "elastic", "crushing", "points"]


def any_joint(seed: int, kind: str) -> tuple[Array, Array, Array, Array, Array]:
    """A joint's place and law, and forces (3,), gaps (4,) and motion (3,) strictly within its bounds."""
    rng = np.random.default_rng(seed)
    model = MODELS["arch"]
    place = model.contacts.places(shaken(model, seed % 100).positions)[seed % len(model.contacts)]
    law = np.zeros(LAW)
    law[FRICTION], law[DILATION] = rng.uniform(0.1, 1.5), rng.choice([0.0, 0.4, 1.0])
    law[BED], law[STRENGTH] = np.inf, np.inf
    forces = np.r_[rng.uniform(0.1, 2.0, 2), 0.0]
    if kind != "rigid":
        law[BED], law[SHEAR] = 10.0 ** rng.uniform(3.0, 6.0), 10.0 ** rng.uniform(-6.0, -4.0)
    if kind == "points":
        law[SEGMENTS] = 5
    if kind == "crushing":
        law[STRENGTH] = 3.0 * forces.sum() ** 2 / (4.0 * place[H] * forces[:2].min())
    forces[2] = rng.uniform(-0.9, 0.9) * law[FRICTION] * forces.sum()
    return place, law, forces, 10.0 ** rng.uniform(-6.0, -3.0, 4), 1e-4 * rng.standard_normal(3)


def eliminated(seed: int, kind: str, least: float) -> tuple[Array, Array, Array]:
    """What is known of a joint that is eliminated, as (KNOWN / LANES,); its stiffness (3, 3); its law."""
    place, law, forces, gaps, _ = any_joint(seed, kind)
    row = np.zeros(KNOWN)
    joint_law.read(place, law, -1, -1, np.zeros(3), forces, gaps, row, LANE)
    joint_law.missing(row, LANE, least)
    joint_law.stiffness(row, LANE)
    return row, row[LANE + np.array(ENTRIES)], law


@settings(max_examples=40)
@given(seed=seeds, kind=st.sampled_from(LAWS), target=st.floats(0.0, 1e-4))
def test_a_joint_eliminated_is_its_linear_system_solved(seed, kind, target):
    """Sums of positive terms, of 3 × 3, against the seven equations: forces, gaps and slips that go with a motion."""
    place, _, _, _, moved = any_joint(seed, kind)
    row, full, law = eliminated(seed, kind, 0.0)
    half, know = place[H], row[LANE:]
    rest, per_motion = joint_newton(half, law, know, COLUMNS, target)
    to_resultants = np.array([[1.0, 1.0, 0.0], [-half, half, 0.0], [0.0, 0.0, 1.0]])
    expected = -to_resultants @ per_motion[:3]
    assert full == pytest.approx(expected, rel=1e-7, abs=1e-7 * abs(expected).max())
    forces = [joint_law.FN, joint_law.FP, joint_law.FT]
    joint_law.aim(row, LANE, target)
    at_rest = to_resultants @ rest[:3]
    assert know[forces] == pytest.approx(at_rest, rel=1e-7, abs=1e-7 * abs(at_rest).max())
    know[[joint_law.MU, joint_law.MPHI, joint_law.MV]] = moved
    joint_law.follow(row, LANE)
    solved = rest + per_motion @ moved
    resultants = to_resultants @ solved[:3]
    assert know[forces] == pytest.approx(resultants, rel=1e-7, abs=1e-7 * abs(full).max() * 1e-4)
    between = np.sqrt(know[joint_law.ZP] * know[joint_law.ZM] / (know[joint_law.LP] * know[joint_law.LM]))
    joint_law.agree(row, LANE, target, between)  # one way of sliding is wide, the other narrow
    assert know[forces] == pytest.approx(resultants, rel=1e-6, abs=1e-6 * abs(full).max() * 1e-4)
    for stiff in (1e-300, 1e12):  # gaps from the products, or from the motions
        know[forces] = resultants
        joint_law.change(row, LANE, target, stiff)
        change = know[joint_law.CHANGES][::LANES]
        assert change[:3] == pytest.approx(solved[:3], rel=1e-6, abs=1e-9 * abs(solved[:3]).max())
        assert change[3:7] == pytest.approx(solved[3:], rel=1e-6, abs=1e-6 * abs(solved[3:]).max())


@settings(max_examples=25)
@given(seed=seeds, kind=st.sampled_from(LAWS))
def test_stiffness_of_a_joint_is_positive_and_symmetric_where_sliding_lifts_in_full(seed, kind):
    _, full, law = eliminated(seed, kind, 1e-12)
    if law[DILATION] < 1.0:
        assert abs(full - full.T)[:2, :2].max() <= 1e-12 * abs(full).max() and np.linalg.det(full) > 0.0
        return
    scale = np.sqrt(np.diag(full))
    assert np.linalg.eigvalsh(full / np.outer(scale, scale)).min() > 0.0


def test_a_joint_at_its_strength_ends_the_shortening_of_an_iteration():
    """Rounding may leave nothing between force and strength: however short, no iteration keeps a share of that."""
    row, kappa = np.zeros(KNOWN), 0.25
    for column, value in (("KAPPA", kappa), ("N1", 1.0), ("N2", 1.0), ("CN1", 0.1), ("CN2", 0.1)):
        row[getattr(joint_law, column) + LANE] = value
    assert joints._within(row, LANE, 1.0) == 0.0
    row[joint_law.N1 + LANE] = row[joint_law.N2 + LANE] = 0.5
    row[joint_law.G1 + LANE] = row[joint_law.G2 + LANE] = 0.5 - kappa
    assert joints._within(row, LANE, 1.0) == 1.0
