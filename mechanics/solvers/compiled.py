"""The loops over contact points, compiled by numba: geometry, contact law with its stiffness, springs, residuals.

Arguments that several loops take, of c contact points and a matrix of m rows, three a block:

- `a`, `b` (c,): the two blocks of each point; `row` (c, 2): the first of the three rows of either in the order of
  elimination, −1 for a support;
- `normal`, `tangent` (c, 6): the rows of A₀ᵀ, the change of gap and of slide per unit x, z, ω of block a, then of
  block b; `gap` (c, 2) m: gap and slide at x = 0;
- `friction` (c,); `compliance` (c, 2) m/kN, normal and tangential; `forces` (c, 2) kN, normal and tangential;
- `mass` (m,), `load` (m,), `x` (m,): diagonal of M̄, loads and displacements of the program;
- `state` (c,): OPEN, STICKING, SLIDING_ON or SLIDING_BACK (see kernels);
- `stored`: the numbers of a symmetric matrix whose lower triangle stands as its `pattern` tells (see elimination).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.block import Array
from mechanics.solvers.compiler import compiler
from mechanics.solvers.kernels import OPEN, SLIDING_BACK, SLIDING_ON, STICKING

SEARCHES = 12  # slopes that a line search computes, at most
FLAT = 0.1  # of the slope at the start: a slope that counts as zero
compiled = compiler()


@compiled
def geometry(
    a: Any, b: Any, p: Array, q: Array, n: Array, positions: Array, gap: Array, normal: Array, tangent: Array
) -> None:
    """Gap and slide (c, 2) and the rows of A₀ᵀ for block positions (b, 3), into the last three arguments.

    Points `p`, their feet `q` and the outward normals `n` (c, 2) are in the blocks' own axes, see contacts.Contacts;
    the result is that of contacts.kinematics.
    """
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
def relative(a: Any, b: Any, rows: Array, moved: Array, change: Array) -> None:
    """Change (c,) of gaps or slides caused by displacements (b, 3), into `change`; `rows` (c, 6): those of A₀ᵀ."""
    for k in range(len(a)):
        total = 0.0
        for e in range(3):
            total += rows[k, e] * moved[a[k], e] + rows[k, 3 + e] * moved[b[k], e]
        change[k] = total


@compiled
def at_start(start: Array, shear: Array, compliance: Array, stretch: float, gap: Array, soft: Array) -> None:
    """The gaps and slides (c, 2) of a step with elastic joints, and its compliances (c, 2), into the last arguments.

    From the gaps (c, 2) at the start and the `shear` (c,) of the springs there; `stretch` as in integrators.
    """
    share = 1.0 / stretch
    for k in range(len(start)):
        soft[k, 0], soft[k, 1] = compliance[k, 0] * share, compliance[k, 1] * share
        gap[k, 0] = max(start[k, 0], 0.0) + min(start[k, 0], 0.0) * share
        gap[k, 1] = -soft[k, 1] * shear[k]


@compiled
def strain_energy(gap: Array, stiffness: Array, compliance: Array, shear: Array) -> float:
    """Energy (kNm) of springs of normal `stiffness` (c,), tangential `compliance` (c, 2), `shear` (c,), gaps (c, 2)."""
    energy = 0.0
    for k in range(len(gap)):
        energy += stiffness[k] * min(gap[k, 0], 0.0) ** 2 + compliance[k, 1] * shear[k] ** 2
    return 0.5 * energy


@compiled
def springs(
    a: Any,
    b: Any,
    normal: Array,
    tangent: Array,
    moved: Array,
    forces: Array,
    start: Array,
    gap: Array,
    compliance: Array,
    stiffness: Array,
    friction: Array,
    before: Array,
    shear: Array,
    stretch: float,
    dashpot: float,
) -> tuple[float, float, float]:
    """Energy taken by friction, by dashpots and by the time stepping (kNm); shear of the springs at the end, written.

    For a step with displacements `moved` (b, 3): from contact forces (c, 2), the normal gaps at its start, `start`
    (c,), the slides of the program, `gap` (c,), compliances (c, 2) and stiffness (c,), infinite for rigid contacts, and
    the shear `before` (c,); `stretch` and `dashpot` as in integrators. What the time stepping takes is the work of the
    contact forces, less that of friction and dashpots, less the change of the energy in the springs. Where sliding
    dilates, this work comes back when the gap closes.
    """
    rubbed, work, viscous, stored, share = 0.0, 0.0, 0.0, 0.0, 1.0 / stretch
    for k in range(len(a)):
        own, other, along, across = moved[a[k]], moved[b[k]], normal[k], tangent[k]
        opening, slide = 0.0, 0.0
        for e in range(3):
            opening += along[e] * own[e] + along[3 + e] * other[e]
            slide += across[e] * own[e] + across[3 + e] * other[e]
        n, t = forces[k, 0], forces[k, 1]
        slip = compliance[k, 1] * t + gap[k] + slide
        rubbed -= t * slip
        work -= n * opening + t * (slide - slip)
        stiff = stiffness[k]
        if np.isinf(stiff):
            shear[k] = before[k]
            continue
        flexible = compliance[k, 1] * stretch
        pressed, after = stiff * max(-start[k], 0.0), stiff * max(-start[k] - opening, 0.0)
        limit = friction[k] * max(n, after) if n > 0.0 else 0.0
        shear[k] = min(max(before[k] + (t - before[k]) * share, -limit), limit)
        grown, soft = n - pressed if n > 0.0 else 0.0, 1.0 / stiff
        viscous += grown**2 * soft + flexible * (t - before[k]) ** 2
        stored += (after**2 - pressed**2) * soft + flexible * (shear[k] ** 2 - before[k] ** 2)
    viscous *= dashpot * share
    return rubbed, viscous, work - viscous - 0.5 * stored


@compiled
def _opening(row: Any, k: int, x: Array, normal: Array, tangent: Array, gap: Array) -> tuple[float, float]:
    un, ut = _change(row, k, x, normal, tangent)
    return gap[k, 0] + un, gap[k, 1] + ut


@compiled
def _change(row: Any, k: int, x: Array, normal: Array, tangent: Array) -> tuple[float, float]:
    un, ut = 0.0, 0.0
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
    row: Any, k: int, knn: float, knt: float, ktt: float, normal: Array, tangent: Array, stored: Array, pattern: Any
) -> None:  # fmt: skip
    for side in range(2):
        if row[k, side] >= 0:
            at, step = pattern.own[row[k, side] // 3], pattern.step[row[k, side] // 3]
            for h in range(3):
                n, t = normal[k, 3 * side + h], tangent[k, 3 * side + h]
                pn, pt = knn * n + knt * t, knt * n + ktt * t
                for e in range(h, 3):
                    stored[at + h * step + e] += pn * normal[k, 3 * side + e] + pt * tangent[k, 3 * side + e]
    at, step = pattern.between[k], pattern.stride[k]
    if at >= 0:
        high, low = (0, 3) if row[k, 0] > row[k, 1] else (3, 0)
        for h in range(3):
            n, t = normal[k, low + h], tangent[k, low + h]
            pn, pt = knn * n + knt * t, knt * n + ktt * t
            for e in range(3):
                stored[at + h * step + e] += pn * normal[k, high + e] + pt * tangent[k, high + e]


@compiled
def diagonal(mass: Array, stored: Array, pattern: Any) -> None:
    """The matrix is that of the masses (m,)."""
    stored[:] = 0.0
    for j in range(len(pattern.own)):
        for e in range(3):
            stored[pattern.own[j] + e * (pattern.step[j] + 1)] = mass[3 * j + e]


@compiled
def repeat_matrix(
    row: Any,
    normal: Array,
    tangent: Array,
    friction: Array,
    compliance: Array,
    mass: Array,
    state: Any,
    stored: Array,
    pattern: Any,
) -> None:
    """M̄ + A₀KA₀ᵀ into `stored`, K the stiffness of contacts that keep their `state`."""
    diagonal(mass, stored, pattern)
    for k in range(len(row)):
        if state[k] == OPEN:
            continue
        cn, ct = compliance[k, 0], compliance[k, 1]
        if state[k] == STICKING:
            _stiffen(row, k, 1.0 / cn, 0.0, 1.0 / ct, normal, tangent, stored, pattern)
        else:
            mu = friction[k] if state[k] == SLIDING_ON else -friction[k]
            w = 1.0 / (cn + mu * mu * ct)
            _stiffen(row, k, w, mu * w, mu * mu * w, normal, tangent, stored, pattern)


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
    """Forces c = −K(A₀ᵀx + g) of contacts that keep their `state`, into `forces`; A₀c into `total` (m,)."""
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
def _law(un: float, ut: float, cn: float, ct: float, mu: float) -> tuple[float, float, int]:
    if un >= mu * abs(ut):
        return 0.0, 0.0, OPEN
    if un <= 0.0 and abs(ut) * cn <= -mu * un * ct:
        return -un / cn, -ut / ct, STICKING
    slope = mu if ut < 0.0 else -mu
    fn = -(un + slope * ut) / (cn + mu * mu * ct)
    return fn, slope * fn, SLIDING_ON if ut < 0.0 else SLIDING_BACK


@compiled
def contact_law(
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
) -> int:
    """Forces that minimise ½cᵀCc + cᵀ(A₀ᵀx + g) in the friction cone, their states and A₀c (m,), all written.

    Returns how many states changed.
    """
    total[:] = 0.0
    changes = 0
    for k in range(len(row)):
        un, ut = _opening(row, k, x, normal, tangent, gap)
        fn, ft, new = _law(un, ut, compliance[k, 0], compliance[k, 1], friction[k])
        changes += new != state[k]
        state[k], forces[k, 0], forces[k, 1] = new, fn, ft
        if new != OPEN:
            _push(row, k, fn, ft, normal, tangent, total)
    return changes


@compiled
def line_search(
    row: Any,
    normal: Array,
    tangent: Array,
    gap: Array,
    friction: Array,
    compliance: Array,
    mass: Array,
    load: Array,
    x: Array,
    dx: Array,
) -> float:
    """The share of the step `dx` (m,) to go: where ½xᵀM̄x − f̄ᵀx + Σφ(A₀ᵀx + g) is least along it, −∇φ the contact law.

    The slope is exact and never falls, so its root is found by regula falsi (Illinois). The full step is taken where
    the slope is still negative at its end.
    """
    c = len(row)
    u, du = np.empty((c, 2)), np.empty((c, 2))
    constant, linear = 0.0, 0.0
    for i in range(len(x)):
        constant += dx[i] * (mass[i] * x[i] - load[i])
        linear += dx[i] * mass[i] * dx[i]
    for k in range(c):
        u[k, 0], u[k, 1] = _opening(row, k, x, normal, tangent, gap)
        du[k, 0], du[k, 1] = _change(row, k, dx, normal, tangent)
    low, high, at_low, at_high, steep = 0.0, 1.0, 0.0, 0.0, 0.0
    share = 0.0
    for trial in range(SEARCHES):
        slope = constant + share * linear
        for k in range(c):
            fn, ft, _ = _law(
                u[k, 0] + share * du[k, 0],
                u[k, 1] + share * du[k, 1],
                compliance[k, 0],
                compliance[k, 1],
                friction[k],
            )
            slope -= fn * du[k, 0] + ft * du[k, 1]
        if trial == 0:
            at_low, steep, share = slope, abs(slope), 1.0
            continue
        if abs(slope) <= FLAT * steep or (trial == 1 and slope < 0.0):
            break
        if slope > 0.0:
            if trial > 1 and high < 1.0:
                at_low *= 0.5
            high, at_high = share, slope
        else:
            low, at_low = share, slope
            at_high *= 0.5
        share = low - at_low * (high - low) / (at_high - at_low)
    return share


@compiled
def changed(
    s: Array, z: Array, before: Array, apart: Array, weight: float, step: float
) -> tuple[float, float, float]:
    """How much forces and gaps (c, 2) along the rays changed, from `before` and `apart` to s and z.

    The share of the rays that carried and do so no longer, or the other way round; and the root mean squares of the
    changes of forces, per weight, and of gaps, per step.
    """
    sides, forces, gaps = 0, 0.0, 0.0
    for k in range(len(s)):
        for e in range(2):
            sides += (s[k, e] * step > z[k, e] * weight) != (before[k, e] * step > apart[k, e] * weight)
            forces += (s[k, e] - before[k, e]) ** 2
            gaps += (z[k, e] - apart[k, e]) ** 2
    rays = 2.0 * len(s)
    return sides / rays, np.sqrt(forces / rays) / weight, np.sqrt(gaps / rays) / step


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
    """The definitions of program.Certificate, with their units: unbalanced force, cone, |cᵀw|, penetration."""
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
