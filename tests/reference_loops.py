"""Compiled loops once more in plain NumPy, from the definitions: what the tests compare them with.

Arguments and results are those of mechanics.solvers.compiled, except that results are returned, not written.
"""

from __future__ import annotations

import numpy as np

from mechanics.block import Array
from mechanics.joints import Index
from mechanics.solvers.kernels import OPEN, SLIDING_BACK, SLIDING_ON, STICKING, Residuals


def geometry(
    a: Index, b: Index, p: Array, q: Array, n: Array, positions: Array
) -> tuple[Array, Array, Array]:
    """Gap and slide (c, 2), and the normal and tangential rows of A₀ᵀ, (c, 6) each."""
    normal = _turned(n, positions[b, 2])
    tangent = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    arm_a = _turned(p, positions[a, 2])
    point = positions[a, :2] + arm_a
    arm_b = point - positions[b, :2]
    offset = arm_b - _turned(q, positions[b, 2])
    gap = np.stack([(normal * offset).sum(axis=1), (tangent * offset).sum(axis=1)], axis=1)

    def rows(u: Array) -> Array:
        turning = [(arm[:, 0] * u[:, 1] - arm[:, 1] * u[:, 0])[:, None] for arm in (arm_a, arm_b)]
        return np.concatenate([u, turning[0], -u, -turning[1]], axis=1)

    return gap, rows(normal), rows(tangent)


def contact_law(
    row: Index, normal: Array, tangent: Array, gap: Array, friction: Array, compliance: Array, x: Array
) -> tuple[Array, Index, Array]:
    """Forces (c, 2) that minimise ½cᵀCc + cᵀ(A₀ᵀx + g) in the friction cone, their states (c,), and A₀c (m,).

    The minimum is −C⁻¹u where that lies in the cone, the apex where u lies in the polar cone, else on one of the rays.
    """
    n, t = (gap + displacements(row, normal, tangent, x)).T
    cn, ct = compliance.T
    rays = []
    for slope in (friction, -friction):
        along = -(n + slope * t) / (cn + slope**2 * ct)
        rays.append(np.stack([along, slope * along], axis=1))
    inside = np.stack([-n / cn, -t / ct], axis=1)
    state = np.select(
        [n >= friction * abs(t), abs(inside[:, 1]) <= friction * inside[:, 0], t < 0.0],
        [OPEN, STICKING, SLIDING_ON],
        SLIDING_BACK,
    )
    forces = np.stack([np.zeros_like(inside), inside, *rays])[state, np.arange(len(state))]
    return forces, state, resultant(row, normal, tangent, forces, len(x))


def residuals(
    row: Index, normal: Array, tangent: Array, gap: Array, friction: Array, compliance: Array, mass: Array,
    load: Array, x: Array, forces: Array, size: float,
) -> Residuals:  # fmt: skip
    """The definitions of program.Certificate, with their units: unbalanced force, cone, |cᵀw|, penetration."""
    w = compliance * forces + gap + displacements(row, normal, tangent, x)
    unbalanced = load - mass * x + resultant(row, normal, tangent, forces, len(x))
    unbalanced[2::3] /= size
    n, t = forces.T
    return (
        float(abs(unbalanced).max(initial=0.0)),
        float(np.maximum(abs(t) - friction * n, -n).max(initial=0.0)),
        float(abs((forces * w).sum(axis=1)).sum()),
        float((friction * abs(w[:, 1]) - w[:, 0]).max(initial=0.0)),
    )


def displacements(row: Index, normal: Array, tangent: Array, x: Array) -> Array:
    """A₀ᵀx (c, 2)."""
    here = np.concatenate([x, np.zeros(3)])[_columns(row)]  # row −1 is a support: the zeros at the end
    return np.stack([(normal * here).sum(axis=1), (tangent * here).sum(axis=1)], axis=1)


def resultant(row: Index, normal: Array, tangent: Array, forces: Array, size: int) -> Array:
    """A₀c (m,)."""
    total = np.zeros(size + 3)
    np.add.at(total, _columns(row), forces[:, :1] * normal + forces[:, 1:] * tangent)
    return total[:size]


def _columns(row: Index) -> Index:
    columns: Index = np.where(row[:, :, None] < 0, -3, row[:, :, None]) + np.arange(3)
    return columns.reshape(-1, 6)


def _turned(v: Array, angle: Array) -> Array:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([cos * v[:, 0] - sin * v[:, 1], sin * v[:, 0] + cos * v[:, 1]], axis=1)
