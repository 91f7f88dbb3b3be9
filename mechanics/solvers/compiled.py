"""The loops of `kernels`, compiled by numba: same names, arguments and results."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from mechanics.block import Array
from mechanics.solvers.kernels import OPEN, SLIDING_BACK, SLIDING_ON, STICKING

NAME = "numba"
compiled: Any = numba.njit(cache=True, fastmath=False, error_model="numpy")


@compiled
def geometry(
    a: Any, b: Any, p: Array, q: Array, n: Array, positions: Array, gap: Array, normal: Array, tangent: Array
) -> None:
    """See kernels.geometry."""
    blocks = len(positions)
    cos, sin = np.empty(blocks), np.empty(blocks)
    for j in range(blocks):
        cos[j], sin[j] = np.cos(positions[j, 2]), np.sin(positions[j, 2])
    for k in range(len(a)):
        i, j = a[k], b[k]
        px = cos[i] * p[k, 0] - sin[i] * p[k, 1]
        pz = sin[i] * p[k, 0] + cos[i] * p[k, 1]
        nx = cos[j] * n[k, 0] - sin[j] * n[k, 1]
        nz = sin[j] * n[k, 0] + cos[j] * n[k, 1]
        bx = positions[i, 0] + px - positions[j, 0]
        bz = positions[i, 1] + pz - positions[j, 1]
        ox = bx - (cos[j] * q[k, 0] - sin[j] * q[k, 1])
        oz = bz - (sin[j] * q[k, 0] + cos[j] * q[k, 1])
        gap[k, 0] = nx * ox + nz * oz
        gap[k, 1] = nz * ox - nx * oz
        normal[k, 0], normal[k, 1], normal[k, 2] = nx, nz, px * nz - pz * nx
        normal[k, 3], normal[k, 4], normal[k, 5] = -nx, -nz, -(bx * nz - bz * nx)
        tangent[k, 0], tangent[k, 1], tangent[k, 2] = nz, -nx, -px * nx - pz * nz
        tangent[k, 3], tangent[k, 4], tangent[k, 5] = -nz, nx, bx * nx + bz * nz


@compiled
def _opening(row: Any, k: int, x: Array, normal: Array, tangent: Array, gap: Array) -> tuple[float, float]:
    un, ut = gap[k, 0], gap[k, 1]
    for side in range(2):
        first = row[k, side]
        if first >= 0:
            for e in range(3):
                un += normal[k, 3 * side + e] * x[first + e]
                ut += tangent[k, 3 * side + e] * x[first + e]
    return un, ut


@compiled
def _law(un: float, ut: float, mu: float, cn: float, ct: float) -> tuple[int, float, float]:
    if un >= mu * abs(ut):
        return OPEN, 0.0, 0.0
    if un <= 0.0 and abs(ut) * cn <= -mu * un * ct:
        return STICKING, -un / cn, -ut / ct
    force = -(un - mu * abs(ut)) / (cn + mu * mu * ct)
    if ut < 0.0:
        return SLIDING_ON, force, mu * force
    return SLIDING_BACK, force, -mu * force


@compiled
def evaluate(
    row: Any,
    normal: Array,
    tangent: Array,
    gap: Array,
    friction: Array,
    compliance: Array,
    mass: Array,
    load: Array,
    x: Array,
    forced: bool,
    state: Any,
    forces: Array,
    gradient: Array,
    band: Array,
) -> tuple[float, int]:
    """See kernels.evaluate."""
    value = 0.0
    changes = 0
    band[:] = 0.0
    for i in range(len(x)):
        gradient[i] = mass[i] * x[i] - load[i]
        value += (0.5 * mass[i] * x[i] - load[i]) * x[i]
        band[i, 0] = mass[i]
    s = np.empty(6)
    r = np.empty(6)
    for k in range(len(row)):
        un, ut = _opening(row, k, x, normal, tangent, gap)
        mu, cn, ct = friction[k], compliance[k, 0], compliance[k, 1]
        if forced:
            new = state[k]
            if new == OPEN:
                fn, ft = 0.0, 0.0
            elif new == STICKING:
                fn, ft = -un / cn, -ut / ct
            else:
                side = mu if new == SLIDING_ON else -mu
                fn = -(un + side * ut) / (cn + mu * mu * ct)
                ft = side * fn
        else:
            new, fn, ft = _law(un, ut, mu, cn, ct)
            if new != state[k]:
                changes += 1
                state[k] = new
        forces[k, 0], forces[k, 1] = fn, ft
        if new == OPEN:
            continue
        value += 0.5 * (cn * fn * fn + ct * ft * ft)
        i, j = row[k, 0], row[k, 1]
        for side in range(2):
            first = row[k, side]
            if first >= 0:
                for e in range(3):
                    gradient[first + e] -= fn * normal[k, 3 * side + e] + ft * tangent[k, 3 * side + e]
        # rank-one parts of the stiffness: s sᵀ, and r rᵀ where the contact sticks
        if new == STICKING:
            wn, wt = 1.0 / np.sqrt(cn), 1.0 / np.sqrt(ct)
            for e in range(6):
                s[e] = wn * normal[k, e]
                r[e] = wt * tangent[k, e]
        else:
            w = 1.0 / np.sqrt(cn + mu * mu * ct)
            slope = mu if new == SLIDING_ON else -mu
            for e in range(6):
                s[e] = w * (normal[k, e] + slope * tangent[k, e])
                r[e] = 0.0
        for side in range(2):
            first = row[k, side]
            if first >= 0:
                for e in range(3):
                    for h in range(e + 1):
                        u, v = 3 * side + e, 3 * side + h
                        band[first + h, e - h] += s[u] * s[v] + r[u] * r[v]
        if i >= 0 and j >= 0:
            high, low, low_row, high_row = (0, 3, j, i) if i > j else (3, 0, i, j)
            for h in range(3):
                for e in range(3):
                    band[low_row + h, high_row + e - low_row - h] += (
                        s[high + e] * s[low + h] + r[high + e] * r[low + h]
                    )
    return value, changes


@compiled
def slope(
    row: Any,
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
    """See kernels.slope."""
    total = 0.0
    for i in range(len(x)):
        total += (mass[i] * x[i] - load[i]) * direction[i]
    for k in range(len(row)):
        un, ut = _opening(row, k, x, normal, tangent, gap)
        new, fn, ft = _law(un, ut, friction[k], compliance[k, 0], compliance[k, 1])
        if new != OPEN:
            for side in range(2):
                first = row[k, side]
                if first >= 0:
                    for e in range(3):
                        total -= direction[first + e] * (
                            fn * normal[k, 3 * side + e] + ft * tangent[k, 3 * side + e]
                        )
    return total


@compiled
def residuals(
    row: Any,
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
    """See kernels.residuals."""
    residual = load - mass * x
    cone, power, penetration = 0.0, 0.0, 0.0
    for k in range(len(row)):
        un, ut = _opening(row, k, x, normal, tangent, gap)
        fn, ft = forces[k, 0], forces[k, 1]
        wn, wt = un + compliance[k, 0] * fn, ut + compliance[k, 1] * ft
        cone = max(cone, abs(ft) - friction[k] * fn, -fn)
        power += abs(fn * wn + ft * wt)
        penetration = max(penetration, friction[k] * abs(wt) - wn)
        for side in range(2):
            first = row[k, side]
            if first >= 0:
                for e in range(3):
                    residual[first + e] += fn * normal[k, 3 * side + e] + ft * tangent[k, 3 * side + e]
    unbalanced = 0.0
    for i in range(len(x)):
        unbalanced = max(unbalanced, abs(residual[i]) / (size if i % 3 == 2 else 1.0))
    return unbalanced, cone, power, penetration
