"""One time step of blocks in contact.

Balance, loads and springs are taken at a share θ of the step (θ = 1: implicit Euler, the paper's; θ = ½: the middle).

Elastic joints: M(v₁ − v₀)/h = f + BᵀF and Δx/h = v₀ + θ(v₁ − v₀), hence the mass M/(θh²). The forces F: gaps.

Rigid joints, at velocity level: M(v₁ − v₀)/h = f + BᵀF and the gap g₀ + h Bv₁ ≥ 0 (Moreau and Jean, without bounce),
with x₁ = x₀ + h((1 − θ)v₀ + θv₁). What a joint that closes takes of the energy is an impact's, but for what a block
that falls for the time of the step alone would have brought: that is a loss of the time stepping.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.kernels.dynamics.motion import (  # isort: skip
    ELASTIC, ENERGIES, FRICTION_WORK, GAPS, IMPACT, INPUT, LONGER, MIDDLE, N1, SPRING, STANDARD_GRAVITY,
    STEPPING, SUNK, TURNED, VISCOUS, bed_under, elastic_beds, placed, posed, relative, sunk,
)  # fmt: skip
from mechanics.kernels.dynamics.program import COLD, solve
from mechanics.kernels.jit import compiled
from mechanics.kernels.joint import LENGTH, PHI, PLACE, TIED, H, U, V, friction_between
from mechanics.kernels.law import CRUSHED, FRICTION, SHEAR, SLID, STRENGTH, lift, most_shear
from mechanics.kernels.matrix import motion
from mechanics.types import Array

PRESSED = 1e-6  # of the weight of a block: a force that is one
CLOSING = 2.0  # times the way of a step: gaps that are wider stay open, as a rule
SLIDING = 0.999  # of the bound of friction: the force of an elastic joint that slides
STILL = 1e-3  # of its speed before: a slide that has come to rest


@compiled
def attempt(
    a: Any, b: Any, faces: Array, basic: Array, row: Any, first: Any, mass: Array, load: Array,
    blocks: Array, joints: Array, energy: Array, h: float, theta: float, beta: float, restitution: float, scale: Any,
    resultants: Array, stored_matrix: Array, pattern: Any, begins: int,
) -> tuple[bool, int, float, float, float, float, float, float]:  # fmt: skip
    """A step of length h from the state of blocks (4, b, 3), joints (j, JOINT) and energy, changed in place if solved.

    `load` (b, 3) kN at the share θ; `restitution` of velocities at which rigid ends meet; `scale`: weight, size and
    span of the step, the accepted residual of forces and products, and the energy (kNm) that errors of velocities may
    have; `resultants` (j, 3): N, P and T found; `begins`: where the program does (program.NEAR).
    Returns whether a solution was found, the number of iterations, the energy that the step took, that which its length
    leaves uncertain of slides that turn back, that of elastic contacts under way, the residual of force, the energy
    (kNm) that errors of velocities may have, and the greatest lift of what slides by Coulomb's law, per span.

    Joints that stay open bear nothing: those too far apart to close in the step are left out of its program, and it is
    solved again with those that its motion has closed all the same.
    """
    weight, size, span, accepted, errors = scale
    c, n, m = len(a), blocks.shape[1], 0
    x, v, past = blocks[0], blocks[1], blocks[2]
    for i in range(n):
        m += 3 * (first[i] >= 0)
    elastic = elastic_beds(basic)
    places, start, law = np.empty((c, PLACE)), np.empty((c, PLACE)), basic.copy()
    placed(a, b, faces, x, joints, start)
    ahead = 0.5 * h if elastic else (1.0 - theta) * h
    placed(a, b, faces, x + ahead * (v + 0.5 * ahead * past), joints, places)
    touching = posed(a, b, start, v, joints, basic, h, theta, beta, restitution, size, places, law)
    inside = np.empty(len(touching), np.bool_)
    for q in range(len(touching)):
        k = touching[q]
        du, dphi, _ = relative(places[k], a[k], b[k], v)
        near = CLOSING * (span + h * (abs(du) + places[k, H] * abs(dphi)))
        inside[q] = places[k, U] - places[k, H] * abs(places[k, PHI]) < near
    share = theta if elastic else 1.0
    scaled, pushed, begun, central = np.empty(m), np.empty(m), np.empty(m), np.empty(m)
    for i in range(n):
        j = first[i]
        if j >= 0:
            for e in range(3):
                scaled[j + e] = mass[i, e] / (share * h * h)
                begun[j + e], central[j + e] = h * v[i, e], blocks[3, i, e]
                pushed[j + e] = load[i, e] + scaled[j + e] * begun[j + e]
    done, lifts = 0, 0.0
    while True:
        chosen = touching[inside]
        at, laws, dx = places[chosen], law[chosen], begun.copy()
        friction_between(at, laws)
        f, y = joints[chosen][:, N1:GAPS].copy(), joints[chosen][:, GAPS:MIDDLE].copy()
        near = joints[chosen][:, MIDDLE:SPRING].copy()
        # the error of velocities has at most the energy of all products, for the program is strongly convex: where
        # forces balance and gaps are met, Δxᵀ M̄ Δx ≤ Σ products, M̄ = M/(θh²), Δx = θhΔv (rigid: θ = 1 in both)
        products = 4.0 * max(len(chosen), 1) * weight * span
        closed = max(accepted, errors / products)
        solved, more, force, product, lifts = solve(
            row[chosen], at, laws, pushed, scaled, dx, f, y, (weight, size, span, accepted, closed),
            begins, elastic,
            COLD * weight * span / (STANDARD_GRAVITY * h * h), stored_matrix, pattern, chosen, near, central, h,
            errors > 0.0,
        )  # fmt: skip
        done += more
        joints[:, MIDDLE:SPRING] = 0.0
        for q in range(len(chosen)):
            joints[chosen[q], MIDDLE:SPRING] = near[q]
        if not solved:
            return False, done, 0.0, 0.0, 0.0, force, 0.0, 0.0
        if not _closed_all_the_same(touching, row, places, law, joints, dx, inside):
            break
    for i in range(n):
        for e in range(3):
            blocks[3, i, e] = central[first[i] + e] if first[i] >= 0 else 0.0
    moved, speed, jerked, work = np.zeros((n, 3)), np.zeros((n, 3)), 0.0, 0.0
    for i in range(n):
        j = first[i]
        if j < 0:
            continue
        for e in range(3):
            if elastic:
                moved[i, e] = dx[j + e]
                speed[i, e] = v[i, e] + (dx[j + e] / h - v[i, e]) / theta
            else:
                speed[i, e] = dx[j + e] / h
                moved[i, e] = h * ((1.0 - theta) * v[i, e] + theta * speed[i, e])
            jerked += mass[i, e] * (speed[i, e] - v[i, e]) ** 2
            work += load[i, e] * moved[i, e]
    spent, held = np.zeros(ENERGIES), 0.0
    contact, turned = _worked(
        a, b, chosen, start, at, laws, basic, f, y, v, moved, speed, h, theta, beta, weight, joints,
        resultants, spent,
    )  # fmt: skip
    if elastic:
        closest, done_on = np.zeros(c), np.zeros(c)
        for q in range(len(chosen)):
            k = chosen[q]
            normal = resultants[k, 0]
            du, dphi, _ = relative(at[q], a[k], b[k], moved)
            u = start[k, U] - joints[k, SUNK] + du - lift(laws[q], y[q, 2] + y[q, 3])
            closest[k] = u - at[q, H] * abs(start[k, PHI] + dphi)
            done_on[k] = -(normal * du + resultants[k, 1] * dphi)
            if normal > PRESSED * weight:  # the blocks meet, or part, where the joint presses, at this speed
                lightness = (first[a[k]] >= 0) / mass[a[k], 0] + (first[b[k]] >= 0) / mass[b[k], 0]
                held += 0.5 * (done_on[k] / (normal * h)) ** 2 / lightness
        end = np.empty((c, PLACE))
        placed(a, b, faces, x + moved, joints, end)
        more, plastic = sunk(start, end, basic, closest, done_on, joints, size)
        spent[ELASTIC] += more
        spent[FRICTION_WORK] += plastic
    else:
        _yield(a, b, faces, x + moved, basic, resultants, joints)
    # computed from the forces, not as what is missing: the balance is a check
    taken = (theta - 0.5) * jerked - contact - spent[FRICTION_WORK] - spent[VISCOUS] - spent[ELASTIC]
    if not elastic and theta < 1.0:
        spent[IMPACT] = taken - spent[STEPPING]
    else:
        spent[STEPPING] = taken
    spent[INPUT], spent[TURNED] = work, turned
    energy += spent
    x += moved
    past[:] = (speed - v) / h
    v[:] = speed
    return True, done, taken, turned, held, force, product * products, lifts


@compiled
def _closed_all_the_same(
    touching: Any, row: Any, places: Array, law: Array, joints: Array, dx: Array, inside: Any
) -> bool:
    """Whether displacements dx (m,) close joints that are not `inside` the program; they are then.

    Of the others the gaps (j, JOINT) become those at which the blocks arrive.
    """
    closes = False
    for q in range(len(touching)):
        if inside[q]:
            continue
        k = touching[q]
        p = places[k]
        du, dphi, dv = motion(p, row[k, 0], row[k, 1], dx)
        slip = p[V] + dv - law[k, SLID]
        u, tilt = p[U] + du - lift(law[k], abs(slip)), p[H] * (p[PHI] + dphi)
        joints[k, GAPS], joints[k, GAPS + 1] = u - tilt, u + tilt
        joints[k, GAPS + 2], joints[k, GAPS + 3] = max(slip, 0.0), max(-slip, 0.0)
        if u < abs(tilt):
            joints[k, N1:SPRING] = 0.0
            inside[q], closes = True, True
    return closes


@compiled
def _yield(a: Any, b: Any, faces: Array, x: Array, basic: Array, resultants: Array, joints: Array) -> None:
    """Rigid ties that bear their yield force (resultants, j × 3) are as long as the way at positions x (b, 3)."""
    for k in range(len(a)):
        if faces[k, LENGTH] > 0.0 and resultants[k, 0] > CRUSHED * basic[k, STRENGTH]:
            end = np.empty((1, PLACE))
            placed(a[k : k + 1], b[k : k + 1], faces[k : k + 1], x, joints[k : k + 1], end)
            joints[k, LONGER] += max(-end[0, U], 0.0)


@compiled
def _worked(
    a: Any, b: Any, chosen: Any, start: Array, at: Array, laws: Array, basic: Array, f: Array, y: Array, v: Array,
    moved: Array, speed: Array, h: float, theta: float, beta: float, weight: float, joints: Array,
    resultants: Array, spent: Array,
) -> tuple[float, float]:  # fmt: skip
    """Return the work of all joints on the blocks in a step, and the part that slides which turn back leave uncertain.

    `spent` (ENERGIES,) gets the energies of friction, dashpots, springs in shear and slow impacts, `resultants` (j, 3)
    and `joints` (j, JOINT) the forces.
    """
    elastic = elastic_beds(basic)
    stretch = theta + beta / h if elastic else 1.0
    contact, turned = 0.0, 0.0
    shear = joints[:, SPRING].copy()
    joints[:, N1:GAPS], joints[:, SPRING:SUNK], resultants[:] = 0.0, 0.0, 0.0
    for k in range(len(joints)):
        spent[ELASTIC] -= 0.5 * basic[k, SHEAR] * shear[k] ** 2
    for q in range(len(chosen)):
        k = chosen[q]
        joints[k, N1:GAPS], joints[k, GAPS:MIDDLE] = f[q], y[q]
        du, dphi, dv = relative(at[q], a[k], b[k], moved)
        normal, moment, t = f[q, 0] + f[q, 1], at[q, H] * (f[q, 1] - f[q, 0]), f[q, 2]
        resultants[k, 0], resultants[k, 1], resultants[k, 2] = normal, moment, t
        contact += normal * du + moment * dphi + t * dv
        limit = most_shear(laws[q, FRICTION], normal)
        if elastic:
            joints[k, SPRING] = min(max(shear[k] + (t - shear[k]) / stretch, -limit), limit)
            give = basic[k, SHEAR] * (joints[k, SPRING] - shear[k])  # way of the spring: no slide
            spent[FRICTION_WORK] -= t * (dv + give)
            spent[ELASTIC] += 0.5 * basic[k, SHEAR] * joints[k, SPRING] ** 2
            if beta > 0.0:
                # dashpots along the contact of the middle of the step, and that of the spring in shear
                u, phi = start[k, U] - joints[k, SUNK] + 0.5 * du, start[k, PHI] + 0.5 * dphi
                _, _, c0, c1, c2 = bed_under(at[q], u, phi, basic[k], joints[k])
                spent[VISCOUS] += beta / h * (c0 * du * du + 2.0 * c1 * du * dphi + c2 * dphi * dphi)
                spent[VISCOUS] += beta / h * give * (joints[k, SPRING] - shear[k])
        elif at[q, TIED] > 0.0 and normal > CRUSHED * laws[q, STRENGTH]:
            spent[FRICTION_WORK] -= normal * du
            continue
        else:
            spent[FRICTION_WORK] -= t * dv
            # faces that meet no faster than a step makes a block that falls may not have met at all
            met = -(normal * du + moment * dphi)
            unsure = 0.5 * STANDARD_GRAVITY * h * h * normal
            spent[STEPPING] += min(max(met, -unsure), unsure)
        # of a slide that turns back, or comes to rest and may turn, the friction is not that of the whole step
        _, _, v0 = relative(start[k], a[k], b[k], v)
        _, _, v1 = relative(at[q], a[k], b[k], speed)
        if v0 * v1 < 0.0 and (not elastic or max(abs(t), abs(shear[k])) >= SLIDING * limit):
            turned += abs(t * h * v0 * v1 / (v0 - v1))
        elif not elastic and limit < np.inf and abs(v1) < STILL * abs(v0):
            turned += h * abs(v0) * (limit - abs(t))
    return contact, turned
