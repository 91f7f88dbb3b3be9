"""The dynamic program over elastic joints by Newton's method on the displacements, with a guess which joints slide.

The bed's forces N and P are functions of the motion, T is that of the slide or, in a joint that sticks, an unknown:

    equilibrium    f + Bᵀ(N, P, T) − M̄x = 0            N, P: of the bed under u − ψμ|λ| and φ
    sticks         λ = v − v₀ + T/k_t = 0              as long as |T| ≤ μN
    slides         λ = v − v₀ + T/k_t, T = ∓μN         as long as λ has the sign that it had

Where nothing slides (μ infinite) a joint sticks as long as it presses, and is free where it is open.

A joint that finds itself beyond its bound changes from one to the other (a primal-dual active set). Near a solution
this takes two to four iterations. Nothing guarantees that it converges: where it does not, or where many joints change,
the interior point solves it. That has no forces of faces that are crushed all over: where faces can be, Newton goes on.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.kernels.interior.iteration import OrderedProgram
from mechanics.kernels.interior.joints import unbalanced
from mechanics.kernels.jit import compiled, looped
from mechanics.kernels.joint import PHI, TIED, H, U, V

from mechanics.kernels.law import (  # isort: skip
    DILATION, FRICTION, LEFT, SHEAR, SLID, STRENGTH, bed_forces, lift, most_shear,
)  # fmt: skip
from mechanics.kernels.linalg.factors import cholesky, lu, substitute
from mechanics.kernels.matrix import diagonal, motion, push, stiffen
from mechanics.types import Array

STICKING = 1e-8  # compliance, per step and weight, that bounds the stiffness of joints that stick
STUCK = 1e-6  # of the step: a slip of a joint that sticks that is none
BEYOND = 1e-9  # of the weight: a force beyond the bound of friction that is not
PRESSES = 1e-8  # of the weight: a force of faces that do more than touch
NEWTON = 30  # iterations for the force of a joint that slides on a spring
MOST = 12  # iterations
# joints, and share of all, that may change after the first iteration; more do not settle soon
FEW, MANY = 3, 0.1

# columns of what an iteration knows of a joint (j, KNOWN): N, P, T; the slip λ, with its sign where the joint slides;
# −1, 0 or 1: how it slides; D's entries; what a joint that sticks misses, and its compliance
N, P, T, SLIP, SLIDES, DUU, DUP, DUV, DPP, DPV, DVV, DVU, DVP, MISS, SOFT = range(15)
KNOWN = 15


@looped
def _slide(law: Array, h: float, u: float, phi: float, v: float, sign: float, s: Array) -> None:
    """Forces and stiffness of a joint that slides by |λ| = ±v − μN/k_t, into `s`; u − ψμ|λ| is the bed's."""
    mu, shear = law[FRICTION], law[SHEAR]
    steep = law[DILATION] * mu
    w, give = u - steep * sign * v, steep * mu * shear
    force = max(s[N], 0.0)
    n, m, c0, c1, c2 = bed_forces(law, law[STRENGTH], law[LEFT:], h, w + give * force, phi)
    if give > 0.0:
        for _ in range(NEWTON):
            change = (n - force) / (1.0 + give * c0)
            force += change
            n, m, c0, c1, c2 = bed_forces(law, law[STRENGTH], law[LEFT:], h, w + give * force, phi)
            if abs(change) <= 1e-14 * force:
                break
    share = 1.0 / (1.0 + give * c0)
    s[N], s[P], s[T], s[SLIP], s[SLIDES] = n, m, -sign * mu * n, v - sign * shear * mu * n, sign
    uu, up = share * c0, share * c1
    s[DUU], s[DUP], s[DPP], s[DVV] = uu, up, c2 - c1 * c1 * give * share, steep * mu * uu
    s[DUV], s[DPV], s[DVU], s[DVP] = -steep * sign * uu, -steep * sign * up, -mu * sign * uu, -mu * sign * up
    s[MISS], s[SOFT] = 0.0, 0.0


@looped
def _stick(law: Array, h: float, u: float, phi: float, v: float, least: float, s: Array) -> None:
    """Forces and stiffness of a joint that sticks with the force T, into `s`."""
    s[N], s[P], s[DUU], s[DUP], s[DPP] = bed_forces(law, law[STRENGTH], law[LEFT:], h, u, phi)
    s[SLIP], s[SLIDES], s[DUV], s[DPV], s[DVU], s[DVP] = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    s[MISS], s[SOFT] = v + law[SHEAR] * s[T], max(law[SHEAR], least)
    s[DVV] = 1.0 / s[SOFT]


@looped
def _evaluate(
    joints: Any, x: Array, weight: float, least: float, known: Array, residual: Array
) -> tuple[int, float]:
    """Forces of all joints at x onto `residual`; how many change to sliding or sticking; the largest slip left."""
    row, places, law = joints.row, joints.places, joints.law
    changed, missed = 0, 0.0
    for k in range(len(row)):
        p, s, mu = places[k], known[k], law[k, FRICTION]
        du, dphi, dv = motion(p, row[k, 0], row[k, 1], x)
        u, phi, v = p[U] + du, p[PHI] + dphi, p[V] + dv - law[k, SLID]
        if mu == np.inf:
            apart = s[SLIDES] != 0.0
            _stick(law[k], p[H], u, phi, v, least, s)
            s[SLIDES] = 0.0 if s[N] > PRESSES * weight else 1.0
            changed += apart != (s[SLIDES] != 0.0)
            if s[SLIDES] != 0.0:
                s[T], s[SLIP], s[MISS], s[DVV] = 0.0, v, 0.0, 0.0
        elif s[SLIDES] == 0.0:
            _stick(law[k], p[H], u, phi, v, least, s)
            if abs(s[T]) > mu * s[N] + BEYOND * weight:
                changed += 1
                _slide(law[k], p[H], u, phi, v, -1.0 if s[T] > 0.0 else 1.0, s)
        else:
            sign = s[SLIDES]
            _slide(law[k], p[H], u, phi, v, sign, s)
            if sign * s[SLIP] < 0.0:
                changed += 1
                _stick(law[k], p[H], u, phi, v, least, s)
        missed = max(missed, abs(s[MISS]))
        push(p, row[k, 0], row[k, 1], s[N], s[P], s[T], residual)
    return changed, missed


@looped
def _assemble(
    joints: Any, known: Array, mass: Array, dx: Array, lower: Array, upper: Array, two: bool, pattern: Any
) -> None:  # fmt: skip
    """The matrix, of `two` triangles or one; onto `dx` (m,) the forces that cancel the slips of joints that stick."""
    row, places = joints.row, joints.places
    diagonal(mass, lower, pattern)
    if two:
        diagonal(mass, upper, pattern)
    for k in range(len(row)):
        s = known[k]
        uu, up, uv, pp, pv, vv, vu, vp = s[DUU], s[DUP], s[DUV], s[DPP], s[DPV], s[DVV], s[DVU], s[DVP]
        at, a, b = places[k], row[k, 0], row[k, 1]
        stiffen(joints.which[k], at, a, b, (uu, up, uv, up, pp, pv, vu, vp, vv), lower, pattern)
        if two:
            stiffen(joints.which[k], at, a, b, (uu, up, vu, up, pp, vp, uv, pv, vv), upper, pattern)
        if s[MISS] != 0.0:
            push(places[k], row[k, 0], row[k, 1], 0.0, 0.0, -s[MISS] / s[SOFT], dx)


@looped
def _follow(joints: Any, known: Array, dx: Array) -> None:
    """Let the forces of joints that stick follow displacements dx (m,)."""
    for k in range(len(known)):
        s = known[k]
        if s[SLIDES] == 0.0:
            _, _, v = motion(joints.places[k], joints.row[k, 0], joints.row[k, 1], dx)
            s[T] -= (s[MISS] + v) / s[SOFT]


@looped
def _begin(law: Array, f: Array, y: Array, unit: float, known: Array) -> None:
    """Let joints slide whose slip in the solution f, y, per step, was larger than the distance of T from its bound."""
    for k in range(len(f)):
        s, n = known[k], f[k, 0] + f[k, 1]
        bound, slid = most_shear(law[k, FRICTION], n), y[k, 2] - y[k, 3]
        s[N], s[T] = n, min(max(f[k, 2], -bound), bound)
        s[SLIDES] = 0.0
        if abs(slid) > unit * (bound - abs(s[T])):
            s[SLIDES] = 1.0 if slid > 0.0 else -1.0


@looped
def _end(joints: Any, x: Array, known: Array, f: Array, y: Array) -> None:
    """Forces, gaps and slips as those of the interior point."""
    row, places = joints.row, joints.places
    for k in range(len(row)):
        p, s = places[k], known[k]
        couple = s[P] / p[H]
        f[k, 0], f[k, 1], f[k, 2] = 0.5 * (s[N] - couple), 0.5 * (s[N] + couple), s[T]
        du, dphi, _ = motion(p, row[k, 0], row[k, 1], x)
        u, tilt = p[U] + du - lift(joints.law[k], abs(s[SLIP])), p[H] * (p[PHI] + dphi)
        y[k, 0], y[k, 1] = max(u - tilt, 0.0), max(u + tilt, 0.0)
        y[k, 2], y[k, 3] = max(s[SLIP], 0.0), max(-s[SLIP], 0.0)


@compiled
def newton(
    program: OrderedProgram, begun: Array, x: Array, f: Array, y: Array, accepted: float
) -> tuple[int, float, float]:
    """Iterate from displacements `begun` (m,); x (m,), f (j, 3) and y (j, 4), as in `iterate`, change if it converges.

    `accepted` of unbalanced forces per weight. Returns the number of iterations, the unbalanced force per weight,
    infinite where it has not converged, and the gaps missed, per step.
    """
    joints, weight, step = program.joints, program.weight, program.step
    law, stored, pattern = joints.law, program.stored, program.pattern
    known = np.empty((len(law), KNOWN))
    moved, residual, least = begun.copy(), np.empty(len(x)), STICKING * step / weight
    skew, half = len(law) > 0 and (law[:, DILATION] < 1.0).any(), len(stored) // 2
    lower, upper = stored[:half], stored[half:]
    crushes = ((law[:, STRENGTH] < np.inf) & (joints.places[:, TIED] == 0.0)).any()
    _begin(law, f, y, step / weight, known)
    for iteration in range(MOST + 1):
        residual[:] = program.load - program.mass * moved
        changed, missed = _evaluate(joints, moved, weight, least, known, residual)
        force, gap = unbalanced(residual, program.size) / weight, missed / step
        if force <= accepted and gap <= STUCK and changed == 0:
            _end(joints, moved, known, f, y)
            x[:] = moved
            return iteration, force, gap
        unsettled = iteration > 0 and changed > FEW + MANY * len(law) and not crushes
        if iteration == MOST or unsettled or not force < np.inf:
            break
        _assemble(joints, known, program.mass, residual, lower, upper, skew, pattern)
        found = lu(lower, upper, pattern) >= 0 if skew else cholesky(lower, pattern)
        if not found:
            break
        substitute(lower, upper if skew else lower, pattern, residual)
        _follow(joints, known, residual)
        moved += residual
    return iteration, np.inf, gap
