"""The array loops of the Newton solver: geometry, contact law with its stiffness, certificate.

Rows of blocks: `row` (c, 2) is the first of the three rows of block a and of block b of each contact point, −1 for a
support. Matrices are banded: entry (i, j), i ≥ j, of a symmetric matrix stands at [j, i − j].
These are the plain NumPy loops; `compiled` has the same ones for numba, used where it is installed.
"""

from __future__ import annotations

from types import ModuleType

import numpy as np

from mechanics.block import Array
from mechanics.contacts import Contacts, kinematics
from mechanics.joints import Index

NAME = "numpy"
OPEN, STICKING, SLIDING_ON, SLIDING_BACK = 0, 1, 2, 3  # the slip of a sliding contact: w_t < 0, w_t > 0


def fastest() -> ModuleType:
    """The compiled loops where numba is installed, else these."""
    try:
        from mechanics.solvers import compiled
    except ImportError:
        from mechanics.solvers import kernels

        return kernels
    return compiled


def geometry(
    a: Index, b: Index, p: Array, q: Array, n: Array, positions: Array, gap: Array, normal: Array, tangent: Array
) -> None:
    """Gap and slide (c, 2) and the rows of A₀ᵀ in a configuration, into the last three arguments (see contacts)."""
    nothing = np.zeros(0)
    rows = kinematics(Contacts(a, b, p, q, n, nothing, nothing, b, nothing), positions)
    gap[:, 0], gap[:, 1], normal[:], tangent[:] = rows.gap, rows.slide, rows.normal, rows.tangent


def evaluate(
    row: Index,
    normal: Array,
    tangent: Array,
    gap: Array,
    friction: Array,
    compliance: Array,
    mass: Array,
    load: Array,
    x: Array,
    forced: bool,
    state: Index,
    forces: Array,
    gradient: Array,
    band: Array,
) -> tuple[float, int]:
    """The dual function Ψ = ½xᵀM̄x − f̄ᵀx + Σφ_k(A_kᵀx + g_k), its gradient and its (generalised) Hessian.

    The contact forces are those that minimise ½cᵀCc + cᵀ(A_kᵀx + g_k) in the friction cone: a projection in the
    metric of C. With `forced` each contact keeps the linear law of its `state`; else the states are found and written.
    Returns Ψ and the number of states that changed; writes `forces`, `gradient` and `band`.
    """
    u = _opening(row, x, normal, tangent, gap)
    changes = 0
    if not forced:
        found = _state(u, friction, compliance)
        changes = int((found != state).sum())
        state[:] = found
    sliding = np.where(state == SLIDING_ON, friction, np.where(state == SLIDING_BACK, -friction, 0.0))
    ray = np.where(state >= SLIDING_ON, 1.0 / (compliance[:, 0] + friction**2 * compliance[:, 1]), 0.0)
    stick = np.where((state == STICKING)[:, None], 1.0 / compliance, 0.0)
    along = ray * (u[:, 0] + sliding * u[:, 1])
    forces[:, 0] = -stick[:, 0] * u[:, 0] - along
    forces[:, 1] = -stick[:, 1] * u[:, 1] - sliding * along
    gradient[:] = mass * x - load - _resultant(row, normal, tangent, forces, len(x))
    value = float((0.5 * mass * x - load) @ x + 0.5 * (compliance * forces**2).sum())

    oblique = normal + sliding[:, None] * tangent
    stiffness = (
        np.einsum("ki,kj,k->kij", normal, normal, stick[:, 0])
        + np.einsum("ki,kj,k->kij", tangent, tangent, stick[:, 1])
        + np.einsum("ki,kj,k->kij", oblique, oblique, ray)
    )
    rows = _rows(row)
    i = np.broadcast_to(rows[:, :, None], stiffness.shape)
    j = np.broadcast_to(rows[:, None, :], stiffness.shape)
    lower = (i >= j) & (j >= 0)
    width = band.shape[1]
    flat = np.bincount(j[lower] * width + i[lower] - j[lower], stiffness[lower], minlength=band.size)
    band[:] = flat.reshape(band.shape)
    band[:, 0] += mass
    return value, changes


def slope(
    row: Index,
    normal: Array,
    tangent: Array,
    gap: Array,
    friction: Array,
    compliance: Array,
    mass: Array,
    load: Array,
    x: Array,
    direction: Array,
) -> float:
    """Derivative of Ψ at `x` along a direction (m,)."""
    u = _opening(row, x, normal, tangent, gap)
    state = _state(u, friction, compliance)
    sliding = np.where(state == SLIDING_ON, friction, -friction)
    along = np.where(
        state >= SLIDING_ON, (u[:, 0] + sliding * u[:, 1]) / (compliance[:, 0] + friction**2 * compliance[:, 1]), 0.0
    )
    stick = (state == STICKING)[:, None] * u / compliance
    forces = -stick - along[:, None] * np.stack([np.ones_like(sliding), sliding], axis=1)
    return float((mass * x - load - _resultant(row, normal, tangent, forces, len(x))) @ direction)


def residuals(
    row: Index,
    normal: Array,
    tangent: Array,
    gap: Array,
    friction: Array,
    compliance: Array,
    mass: Array,
    load: Array,
    x: Array,
    forces: Array,
    size: float,
) -> tuple[float, float, float, float]:
    """The definitions of program.Certificate, with their units: unbalanced force, cone, |cᵀw|, penetration."""
    w = compliance * forces + _opening(row, x, normal, tangent, gap)
    residual = load - mass * x + _resultant(row, normal, tangent, forces, len(x))
    residual[2::3] /= size
    n, t = forces.T
    return (
        float(abs(residual).max(initial=0.0)),
        float(max((abs(t) - friction * n).max(initial=0.0), (-n).max(initial=0.0))),
        float(abs((forces * w).sum(axis=1)).sum()),
        float((friction * abs(w[:, 1]) - w[:, 0]).max(initial=0.0)),
    )


def _rows(row: Index) -> Index:
    rows: Index = np.where(row[:, :, None] >= 0, row[:, :, None] + np.arange(3), -1).reshape(-1, 6)
    return rows


def _opening(row: Index, x: Array, normal: Array, tangent: Array, gap: Array) -> Array:
    rows = _rows(row)
    local = np.where(rows >= 0, x[rows], 0.0)
    opening: Array = gap + np.stack([(normal * local).sum(axis=1), (tangent * local).sum(axis=1)], axis=1)
    return opening


def _state(u: Array, friction: Array, compliance: Array) -> Index:
    n, t = u.T
    slip = friction * abs(t)
    sticks = (n <= 0.0) & (abs(t) * compliance[:, 0] <= -friction * n * compliance[:, 1])
    state: Index = np.where(
        n >= slip, OPEN, np.where(sticks, STICKING, np.where(t < 0.0, SLIDING_ON, SLIDING_BACK))
    )
    return state


def _resultant(row: Index, normal: Array, tangent: Array, forces: Array, size: int) -> Array:
    rows = _rows(row)
    entries = forces[:, :1] * normal + forces[:, 1:] * tangent
    moving = rows >= 0
    total: Array = np.bincount(rows[moving], entries[moving], minlength=size)
    return total
