"""One time step of blocks in contact.

Balance, loads and springs are taken at a share θ of the step (θ = 1: implicit Euler, the paper's; θ = ½: the middle).

Elastic joints: M(v₁ − v₀)/h = f + BᵀF and Δx/h = v₀ + θ(v₁ − v₀), hence the mass M/(θh²). The forces F: gaps.

Rigid joints, at velocity level: M(v₁ − v₀)/h = f + BᵀF and the gap g₀ + h Bv₁ ≥ 0 (Moreau and Jean, without bounce),
with x₁ = x₀ + h((1 − θ)v₀ + θv₁). What a joint that closes takes of the energy is an impact's, but for what a block
that falls for the time of the step alone would have brought: that is a loss of the time stepping.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np

from mechanics.kernels.dynamics.motion import (  # isort: skip
    ELASTIC, ENERGIES, FRICTION_WORK, GAPS, IMPACT, INPUT, LONGER, MIDDLE, N1, SPRING, STANDARD_GRAVITY,
    STEPPING, SUNK, TURNED, VISCOUS, Moving, Scheme, Structure, bed_under, elastic_beds, placed, posed, relative, sunk,
)  # fmt: skip
from mechanics.kernels.dynamics.program import Start, solve_elastic, solve_rigid
from mechanics.kernels.interior.iteration import OrderedProgram
from mechanics.kernels.interior.joints import ProgramJoints
from mechanics.kernels.jit import compiled
from mechanics.kernels.joint import CURVED, LENGTH, PHI, PLACE, TIED, H, U, V, friction_between, place
from mechanics.kernels.law import CRUSHED, FRICTION, SHEAR, SLID, STRENGTH, lift, most_shear
from mechanics.kernels.matrix import motion
from mechanics.types import Array

PRESSED = 1e-6  # of the weight of a block: a force that is one
CLOSING = 2.0  # times the way of a step: gaps that are wider stay open, as a rule
SLIDING = 0.999  # of the bound of friction: the force of an elastic joint that slides
STILL = 1e-3  # of its speed before: a slide that has come to rest
# what a step has found: whether it is `solved`, in how many `iterations`, to which residual of `force`; the energy
# `taken` by it, that which its length leaves uncertain of slides that have `turned` back, that `held` by elastic
# contacts, that which `errors` of velocities may have (kNm); the greatest `lift` of what slides by Coulomb's law, per
# span
Tried = namedtuple("Tried", "solved iterations force taken turned held errors lift")
# all joints as a step begins, `start` (j, PLACE); those of its program: `which` (i,), forces f (i, 3), gaps y (i, 4)
Met = namedtuple("Met", "start which places laws f y")


@compiled
def attempt(
    structure: Structure, scheme: Scheme, moving: Moving, h: float, load: Array, wanted: Any, resultants: Array,
    begins: int,
) -> Tried:  # fmt: skip
    """A step of length h from the state of `moving`, which is changed in place if it is solved.

    `load` (b, 3) kN at the share θ; `wanted`: span of the step, the accepted residual of forces and products, and the
    energy (kNm) that errors of velocities may have; `resultants` (j, 3): N, P and T found; `begins`: where the program
    does (program.NEAR).

    Joints that stay open bear nothing: those too far apart to close in the step are left out of its program, and it is
    solved again with those that its motion has closed all the same.
    """
    span, accepted, errors = wanted
    a, b, basic, first, mass = structure.a, structure.b, structure.basic, structure.first, structure.mass
    weight, size, theta, joints = structure.weight, structure.size, scheme.theta, moving.joints
    n, m = len(mass), 3 * int((first >= 0).sum())
    x, v, past = moving.blocks[0], moving.blocks[1], moving.blocks[2]
    elastic, law = elastic_beds(basic), basic.copy()
    start = placed(structure, x, joints)
    ahead = 0.5 * h if elastic else (1.0 - theta) * h
    places = placed(structure, x + ahead * (v + 0.5 * ahead * past), joints)
    touching = posed(structure, scheme, moving, h, start, places, law)
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
                begun[j + e], central[j + e] = h * v[i, e], moving.blocks[3, i, e]
                pushed[j + e] = load[i, e] + scaled[j + e] * begun[j + e]
    done = 0
    while True:
        chosen = touching[inside]
        at, laws, dx = places[chosen], law[chosen], begun.copy()
        friction_between(at, laws)
        f, y = joints[chosen][:, N1:GAPS].copy(), joints[chosen][:, GAPS:MIDDLE].copy()
        near = joints[chosen][:, MIDDLE:SPRING].copy()
        program = OrderedProgram(
            ProgramJoints(structure.row[chosen], at, laws, np.empty((0, CURVED)), chosen), pushed, np.empty(0), 0.0,
            scaled, weight, size, span, structure.stored, structure.pattern,
        )  # fmt: skip
        begin = Start(begins, h, near, central)
        # the error of velocities has at most the energy of all products, for the program is strongly convex: where
        # forces balance and gaps are met, Δxᵀ M̄ Δx ≤ Σ products, M̄ = M/(θh²), Δx = θhΔv (rigid: θ = 1 in both)
        products = 4.0 * max(len(chosen), 1) * weight * span
        closed = max(accepted, errors / products)
        if elastic:
            solved, more, force, product, lifts = solve_elastic(program, dx, f, y, begin, accepted, closed)
        else:
            solved, more, force, product, lifts = solve_rigid(
                program, dx, f, y, begin, accepted, closed, errors > 0.0
            )
        done += more
        joints[:, MIDDLE:SPRING] = 0.0
        for q in range(len(chosen)):
            joints[chosen[q], MIDDLE:SPRING] = near[q]
        if not solved:
            return Tried(False, done, force, 0.0, 0.0, 0.0, 0.0, 0.0)
        if not _closed_all_the_same(touching, structure.row, places, law, joints, dx, inside):
            break
    moved, speed, jerked, work = np.zeros((n, 3)), np.zeros((n, 3)), 0.0, 0.0
    for i in range(n):
        j = first[i]
        for e in range(3):
            moving.blocks[3, i, e] = central[j + e] if j >= 0 else 0.0
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
    spent, held, met = np.zeros(ENERGIES), 0.0, Met(start, chosen, at, laws, f, y)
    contact, turned = _worked(structure, scheme, moving, h, met, moved, speed, resultants, spent)
    if elastic:
        held = _borne_by_beds(structure, moving, h, met, moved, resultants, spent)
    else:
        _yield(structure, x + moved, resultants, joints)
    # computed from the forces, not as what is missing: the balance is a check
    taken = (theta - 0.5) * jerked - contact - spent[FRICTION_WORK] - spent[VISCOUS] - spent[ELASTIC]
    if not elastic and theta < 1.0:
        spent[IMPACT] = taken - spent[STEPPING]
    else:
        spent[STEPPING] = taken
    spent[INPUT], spent[TURNED] = work, turned
    moving.energy[:] += spent
    x += moved
    past[:] = (speed - v) / h
    v[:] = speed
    return Tried(True, done, force, taken, turned, held, product * products, lifts)


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
def _yield(structure: Structure, x: Array, resultants: Array, joints: Array) -> None:
    """Rigid ties that bear their yield force (resultants, j × 3) are as long as the way at positions x (b, 3)."""
    a, b, faces, basic = structure.a, structure.b, structure.faces, structure.basic
    for k in range(len(a)):
        if faces[k, LENGTH] > 0.0 and resultants[k, 0] > CRUSHED * basic[k, STRENGTH]:
            end = np.empty((1, PLACE))
            place(a[k : k + 1], b[k : k + 1], faces[k : k + 1], x, end)
            joints[k, LONGER] += max(-(end[0, U] + joints[k, LONGER]), 0.0)


@compiled
def _borne_by_beds(
    structure: Structure, moving: Moving, h: float, met: Met, moved: Array, resultants: Array, spent: Array
) -> float:
    """Let beds end a step as they were pressed, see `sunk`; return the kinetic energy that they hold.

    Blocks meet, or part, where a joint presses, at the speed of the way on which its forces do their work.
    """
    a, b, first, mass, joints = structure.a, structure.b, structure.first, structure.mass, moving.joints
    closest, done_on, held = np.zeros(len(a)), np.zeros(len(a)), 0.0
    for q in range(len(met.which)):
        k, at = met.which[q], met.places[q]
        normal = resultants[k, 0]
        du, dphi, _ = relative(at, a[k], b[k], moved)
        u = met.start[k, U] - joints[k, SUNK] + du - lift(met.laws[q], met.y[q, 2] + met.y[q, 3])
        closest[k] = u - at[H] * abs(met.start[k, PHI] + dphi)
        done_on[k] = -(normal * du + resultants[k, 1] * dphi)
        if normal > PRESSED * structure.weight:
            lightness = (first[a[k]] >= 0) / mass[a[k], 0] + (first[b[k]] >= 0) / mass[b[k], 0]
            held += 0.5 * (done_on[k] / (normal * h)) ** 2 / lightness
    end = placed(structure, moving.blocks[0] + moved, joints)
    more, plastic = sunk(met.start, end, structure.basic, closest, done_on, joints, structure.size)
    spent[ELASTIC] += more
    spent[FRICTION_WORK] += plastic
    return held


@compiled
def _worked(
    structure: Structure, scheme: Scheme, moving: Moving, h: float, met: Met, moved: Array, speed: Array,
    resultants: Array, spent: Array,
) -> tuple[float, float]:  # fmt: skip
    """Return the work of all joints on the blocks in a step, and the part that slides which turn back leave uncertain.

    `spent` (ENERGIES,) gets the energies of friction, dashpots, springs in shear and slow impacts, `resultants` (j, 3)
    and the joints the forces. Nine arguments: the last two are results.
    """
    start, chosen, at, laws, f, y = met
    a, b, basic, v, joints, beta = (
        structure.a, structure.b, structure.basic, moving.blocks[1], moving.joints, scheme.beta
    )  # fmt: skip
    elastic = elastic_beds(basic)
    stretch = scheme.theta + beta / h if elastic else 1.0
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
