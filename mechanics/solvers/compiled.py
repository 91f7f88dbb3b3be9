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
def _push(row: Any, k: int, fn: float, ft: float, normal: Array, tangent: Array, total: Array) -> None:
    for side in range(2):
        first = row[k, side]
        if first >= 0:
            for e in range(3):
                total[first + e] += fn * normal[k, 3 * side + e] + ft * tangent[k, 3 * side + e]


@compiled
def _stiffen(
    row: Any, k: int, knn: float, knt: float, ktt: float, normal: Array, tangent: Array, band: Array
) -> None:
    i, j = row[k, 0], row[k, 1]
    for side in range(2):
        first = row[k, side]
        if first >= 0:
            for h in range(3):
                n, t = normal[k, 3 * side + h], tangent[k, 3 * side + h]
                pn, pt = knn * n + knt * t, knt * n + ktt * t
                for e in range(h, 3):
                    band[first + h, e - h] += pn * normal[k, 3 * side + e] + pt * tangent[k, 3 * side + e]
    if i >= 0 and j >= 0:
        high, low, below, above = (0, 3, j, i) if i > j else (3, 0, i, j)
        for h in range(3):
            n, t = normal[k, low + h], tangent[k, low + h]
            pn, pt = knn * n + knt * t, knt * n + ktt * t
            for e in range(3):
                band[below + h, above + e - below - h] += pn * normal[k, high + e] + pt * tangent[k, high + e]


@compiled
def repeat_matrix(
    row: Any,
    normal: Array,
    tangent: Array,
    friction: Array,
    compliance: Array,
    mass: Array,
    state: Any,
    band: Array,
) -> None:
    """See kernels.repeat_matrix."""
    band[:] = 0.0
    for i in range(len(mass)):
        band[i, 0] = mass[i]
    for k in range(len(row)):
        if state[k] == OPEN:
            continue
        cn, ct = compliance[k, 0], compliance[k, 1]
        if state[k] == STICKING:
            _stiffen(row, k, 1.0 / cn, 0.0, 1.0 / ct, normal, tangent, band)
        else:
            mu = friction[k] if state[k] == SLIDING_ON else -friction[k]
            w = 1.0 / (cn + mu * mu * ct)
            _stiffen(row, k, w, mu * w, mu * mu * w, normal, tangent, band)


@compiled
def repeat_forces(
    row: Any,
    normal: Array,
    tangent: Array,
    gap: Array,
    friction: Array,
    compliance: Array,
    x: Array,
    state: Any,
    forces: Array,
    total: Array,
) -> None:
    """See kernels.repeat_forces."""
    total[:] = 0.0
    for k in range(len(row)):
        fn, ft = 0.0, 0.0
        if state[k] != OPEN:
            un, ut = _opening(row, k, x, normal, tangent, gap)
            cn, ct = compliance[k, 0], compliance[k, 1]
            if state[k] == STICKING:
                fn, ft = -un / cn, -ut / ct
            else:
                mu = friction[k] if state[k] == SLIDING_ON else -friction[k]
                fn = -(un + mu * ut) / (cn + mu * mu * ct)
                ft = mu * fn
            _push(row, k, fn, ft, normal, tangent, total)
        forces[k, 0], forces[k, 1] = fn, ft


@compiled
def find_states(
    row: Any,
    normal: Array,
    tangent: Array,
    gap: Array,
    friction: Array,
    compliance: Array,
    x: Array,
    state: Any,
) -> int:
    """See kernels.find_states."""
    changes = 0
    for k in range(len(row)):
        un, ut = _opening(row, k, x, normal, tangent, gap)
        mu = friction[k]
        if un >= mu * abs(ut):
            new = OPEN
        elif un <= 0.0 and abs(ut) * compliance[k, 0] <= -mu * un * compliance[k, 1]:
            new = STICKING
        else:
            new = SLIDING_ON if ut < 0.0 else SLIDING_BACK
        changes += new != state[k]
        state[k] = new
    return changes


@compiled
def _diagonal(
    k: int, friction: Array, compliance: Array, s: Array, z: Array
) -> tuple[float, float, float, float, float]:
    """Components of the ray (1, μ), and the inverse of RᵀCR + Z/S."""
    mu = friction[k]
    n = 1.0 / np.sqrt(1.0 + mu * mu)
    t = mu * n
    cn, ct = n * n * compliance[k, 0], t * t * compliance[k, 1]
    p, q, c = cn + ct + z[k, 0] / s[k, 0], cn + ct + z[k, 1] / s[k, 1], cn - ct
    # p q − c², without cancellation
    det = (
        4.0 * cn * ct
        + (cn + ct) * (z[k, 0] / s[k, 0] + z[k, 1] / s[k, 1])
        + (z[k, 0] / s[k, 0]) * (z[k, 1] / s[k, 1])
    )
    return n, t, q / det, p / det, -c / det


@compiled
def interior_matrix(
    row: Any,
    normal: Array,
    tangent: Array,
    friction: Array,
    compliance: Array,
    mass: Array,
    s: Array,
    z: Array,
    band: Array,
) -> None:
    """See kernels.interior_matrix."""
    band[:] = 0.0
    for i in range(len(mass)):
        band[i, 0] = mass[i]
    for k in range(len(row)):
        n, t, a, b, c = _diagonal(k, friction, compliance, s, z)
        _stiffen(
            row,
            k,
            n * n * (a + b + 2.0 * c),
            n * t * (a - b),
            t * t * (a + b - 2.0 * c),
            normal,
            tangent,
            band,
        )


@compiled
def interior_rhs(
    row: Any,
    normal: Array,
    tangent: Array,
    gap: Array,
    friction: Array,
    compliance: Array,
    mass: Array,
    load: Array,
    x: Array,
    s: Array,
    z: Array,
    product: Array,
    rhs: Array,
) -> None:
    """See kernels.interior_rhs."""
    for i in range(len(x)):
        rhs[i] = load[i] - mass[i] * x[i]
    for k in range(len(row)):
        n, t, a, b, c = _diagonal(k, friction, compliance, s, z)
        un, ut = _opening(row, k, x, normal, tangent, gap)
        fn, ft = n * (s[k, 0] + s[k, 1]), t * (s[k, 0] - s[k, 1])
        wn, wt = n * (un + compliance[k, 0] * fn), t * (ut + compliance[k, 1] * ft)
        u = z[k, 0] - (wn + wt) - product[k, 0] / s[k, 0]
        v = z[k, 1] - (wn - wt) - product[k, 1] / s[k, 1]
        p, q = a * u + c * v, c * u + b * v
        _push(row, k, fn + n * (p + q), ft + t * (p - q), normal, tangent, rhs)


@compiled
def interior_step(
    row: Any,
    normal: Array,
    tangent: Array,
    gap: Array,
    friction: Array,
    compliance: Array,
    x: Array,
    dx: Array,
    s: Array,
    z: Array,
    product: Array,
    ds: Array,
    dz: Array,
) -> tuple[float, float]:
    """See kernels.interior_step."""
    force, gapping = 1.0, 1.0
    moved = x + dx
    for k in range(len(row)):
        n, t, a, b, c = _diagonal(k, friction, compliance, s, z)
        un, ut = _opening(row, k, moved, normal, tangent, gap)
        fn, ft = n * (s[k, 0] + s[k, 1]), t * (s[k, 0] - s[k, 1])
        wn, wt = n * (un + compliance[k, 0] * fn), t * (ut + compliance[k, 1] * ft)
        u = z[k, 0] - (wn + wt) - product[k, 0] / s[k, 0]
        v = z[k, 1] - (wn - wt) - product[k, 1] / s[k, 1]
        ds[k, 0], ds[k, 1] = a * u + c * v, c * u + b * v
        for e in range(2):
            dz[k, e] = -(product[k, e] + z[k, e] * ds[k, e]) / s[k, e]
            if ds[k, e] < 0.0:
                force = min(force, -s[k, e] / ds[k, e])
            if dz[k, e] < 0.0:
                gapping = min(gapping, -z[k, e] / dz[k, e])
    return force, gapping


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
