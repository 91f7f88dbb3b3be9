"""What blocks see and feel of a joint: relative motion, resultants, and the stiffness in the matrix of the program.

Rows are in the order of elimination: `row` (j, 2) is the first of the three rows of block a and of block b, −1 for a
support; `pattern` says where the matrix is stored (see elimination).
"""

from __future__ import annotations

from typing import Any

from mechanics.kernels.jit import inlined, looped
from mechanics.kernels.joint import LX, LZ, MPHI, MU, MV, NX, NZ
from mechanics.types import Array


@looped
def motion(p: Array, i: int, j: int, x: Array) -> tuple[float, float, float]:
    """Changes of u, φ and v of a joint at a place p (PLACE,) that displacements x (m,) of its blocks cause."""
    ax, az, ta = _of_block(i, x)
    bx, bz, tb = _of_block(j, x)
    return moved_by(p, ax, az, ta, bx, bz, tb)


@inlined
def _of_block(i: int, x: Array) -> tuple[float, float, float]:
    """x, z and ω of a block whose first row is i, zero of a support."""
    if i < 0:
        return 0.0, 0.0, 0.0
    return x[i], x[i + 1], x[i + 2]


@looped
def moved_by(
    p: Array, ax: float, az: float, ta: float, bx: float, bz: float, tb: float
) -> tuple[float, float, float]:
    """A₀ᵀΔx of a joint at a place p (PLACE,): changes of u, φ and v as block a moves by x, z and ω, and b likewise."""
    dx, dz, turn = ax - (bx - p[LZ] * tb), az - (bz + p[LX] * tb), ta - tb
    u, v = p[NX] * dx + p[NZ] * dz + p[MU] * turn, p[NZ] * dx - p[NX] * dz + p[MV] * turn
    return u, p[MPHI] * turn, v


@looped
def push(p: Array, i: int, j: int, n: float, m: float, t: float, total: Array) -> None:
    """Add the forces of N, P and T (n, m, t) on the blocks of a joint to `total` (m,)."""
    fx, fz = n * p[NX] + t * p[NZ], n * p[NZ] - t * p[NX]
    moment = n * p[MU] + m * p[MPHI] + t * p[MV]
    if i >= 0:
        total[i] += fx
        total[i + 1] += fz
        total[i + 2] += moment
    if j >= 0:
        total[j] -= fx
        total[j + 1] -= fz
        total[j + 2] -= moment + p[LX] * fz - p[LZ] * fx


@looped
def stiffen(k: int, p: Array, i: int, j: int, d: Any, stored: Array, pattern: Any) -> None:
    """Add the lower triangle of BᵀDB of joint k to the matrix; d (9,): D row by row, over u, φ and v.

    Of the transpose of D it is the upper triangle, by rows.
    """
    nx, nz, mu, mp, mv = p[NX], p[NZ], p[MU], p[MPHI], p[MV]
    # rows of D B_a
    ux, uz, ut = d[0] * nx + d[2] * nz, d[0] * nz - d[2] * nx, d[0] * mu + d[1] * mp + d[2] * mv
    px, pz, pt = d[3] * nx + d[5] * nz, d[3] * nz - d[5] * nx, d[3] * mu + d[4] * mp + d[5] * mv
    vx, vz, vt = d[6] * nx + d[8] * nz, d[6] * nz - d[8] * nx, d[6] * mu + d[7] * mp + d[8] * mv
    # M = B_aᵀ D B_a, rows by the first letter
    xx, xz, xt = nx * ux + nz * vx, nx * uz + nz * vz, nx * ut + nz * vt
    zx, zz, zt = nz * ux - nx * vx, nz * uz - nx * vz, nz * ut - nx * vt
    tx, tz, tt = mu * ux + mp * px + mv * vx, mu * uz + mp * pz + mv * vz, mu * ut + mp * pt + mv * vt
    if i >= 0:
        _own(stored[pattern.own[i // 3] :], pattern.step[i // 3], xx, zx, tx, zz, tz, tt)
    if j < 0:
        return
    lx, lz = p[LX], p[LZ]  # B_b = −B_a E, E: turns of block b about its own centre
    xe, ze, te = xt + lx * xz - lz * xx, zt + lx * zz - lz * zx, tt + lx * tz - lz * tx  # last column of ME
    ex, ez, et = tx + lx * zx - lz * xx, tz + lx * zz - lz * xz, tt + lx * zt - lz * xt  # last row of EᵀM
    _own(stored[pattern.own[j // 3] :], pattern.step[j // 3], xx, zx, ex, zz, ez, et + lx * ez - lz * ex)
    if i < 0:
        return
    between, step = stored[pattern.between[k] :], pattern.stride[k]
    between[0], between[1] = between[0] - xx, between[1] - zx
    between[step], between[step + 1] = between[step] - xz, between[step + 1] - zz
    # the columns are those of the block that is eliminated first: −EᵀM where it is a, −ME where it is b
    rx, rz, cx, cz, last = (ex, ez, xt, zt, et) if i < j else (tx, tz, xe, ze, te)
    between[2] -= rx
    between[step + 2] -= rz
    between[2 * step] -= cx
    between[2 * step + 1] -= cz
    between[2 * step + 2] -= last


@inlined
def _own(own: Array, step: int, xx: float, zx: float, tx: float, zz: float, tz: float, tt: float) -> None:
    """Add to the lower triangle of the rows of one block, by columns."""
    own[0], own[1], own[2] = own[0] + xx, own[1] + zx, own[2] + tx
    own[step + 1], own[step + 2] = own[step + 1] + zz, own[step + 2] + tz
    own[2 * step + 2] += tt


@looped
def bend(k: int, i: int, j: int, c: Array, stored: Array, pattern: Any) -> None:
    """Take the geometric stiffness of joint k off the matrix; c (CURVED,) as in joint.curvature."""
    if i >= 0:
        _own(stored[pattern.own[i // 3] :], pattern.step[i // 3], -c[7], -c[8], -c[0], -c[9], -c[1], -c[4])
    if j >= 0:
        _own(stored[pattern.own[j // 3] :], pattern.step[j // 3], -c[7], -c[8], c[2], -c[9], c[3], -c[6])
    if i >= 0 and j >= 0:
        at, step = pattern.between[k], pattern.stride[k]
        stored[at] += c[7]
        stored[at + 1] += c[8]
        stored[at + step] += c[8]
        stored[at + step + 1] += c[9]
        if i < j:  # rows: those of b; columns: of a
            stored[at + 2] -= c[2]
            stored[at + step + 2] -= c[3]
            stored[at + 2 * step] += c[0]
            stored[at + 2 * step + 1] += c[1]
        else:
            stored[at + 2] += c[0]
            stored[at + step + 2] += c[1]
            stored[at + 2 * step] -= c[2]
            stored[at + 2 * step + 1] -= c[3]
        stored[at + 2 * step + 2] -= c[5]


@looped
def turn(c: Array, i: int, j: int, x: Array, total: Array) -> None:
    """Add to `total` (m,) what the forces of a joint change as its blocks move by x (m,); c (CURVED,): curvature."""
    ax, az, ta = _of_block(i, x)
    bx, bz, tb = _of_block(j, x)
    dx, dz = ax - bx, az - bz
    fx, fz = c[0] * ta + c[2] * tb + c[7] * dx + c[8] * dz, c[1] * ta + c[3] * tb + c[8] * dx + c[9] * dz
    if i >= 0:
        total[i] += fx
        total[i + 1] += fz
        total[i + 2] += c[0] * dx + c[1] * dz + c[4] * ta + c[5] * tb
    if j >= 0:
        total[j] -= fx
        total[j + 1] -= fz
        total[j + 2] += c[2] * dx + c[3] * dz + c[5] * ta + c[6] * tb


@looped
def diagonal(mass: Array, stored: Array, pattern: Any) -> None:
    """The matrix is that of the masses (m,)."""
    stored[:] = 0.0
    for j in range(len(pattern.own)):
        for e in range(3):
            stored[pattern.own[j] + e * (pattern.step[j] + 1)] = mass[3 * j + e]
