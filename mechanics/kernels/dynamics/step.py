"""Time steps of blocks in contact, one after another, halved where impacts take energy.

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
    ELASTIC, ENERGIES, FRICTION_WORK, GAPS, IMPACT, INPUT, LARGEST, LONGER, MIDDLE, N1, SPRING, STANDARD_GRAVITY,
    STEPPING, SUNK, TURNED, VISCOUS, Moving, Scheme, Structure, bed_under, elastic_beds, placed, posed, relative, sunk,
)  # fmt: skip
from mechanics.kernels.dynamics.program import FROM_GAPS, NEAR, RIGHT, Start, solve_elastic, solve_rigid
from mechanics.kernels.interior.iteration import OrderedProgram
from mechanics.kernels.interior.joints import ProgramJoints
from mechanics.kernels.jit import compiled
from mechanics.kernels.joint import CURVED, LENGTH, PHI, PLACE, TIED, H, U, V, friction_between, place
from mechanics.kernels.law import CRUSHED, FRICTION, SHEAR, SLID, STRENGTH, lift, most_shear
from mechanics.kernels.matrix import motion
from mechanics.types import Array

FAR, UNSOLVED, RESTS = 1, 2, 3  # why a march ends before all steps are done
MEETING = 0.1  # of the largest kinetic energy so far: elastic contacts that hold more are resolved
# kinetic energy, over W g h² of a mean block: less is rest. From rest programs are solved to so much more, of what is
# accepted, that the error of velocities is less
REST, SHARPLY = 1e-10, 1e-2
PRESSED = 1e-6  # of the weight of a block: a force that is one
CLOSING = 2.0  # times the way of a step: gaps that are wider stay open, as a rule
SLIDING = 0.999  # of the bound of friction: the force of an elastic joint that slides
STILL = 1e-3  # of its speed before: a slide that has come to rest
# what a step finds: whether it is `solved`, `iterations`, residual of `force`; energies (kNm): `taken` by the step,
# left uncertain of slides that `turned` back, `held` by elastic contacts, that which `errors` of velocities may
# have; the greatest `lift` of what slides by Coulomb's law, per span
Tried = namedtuple("Tried", "solved iterations force taken turned held errors lift")
# all joints as a step begins, `start` (j, PLACE); those of its program: `which` (i,), forces f (i, 3), gaps y (i, 4)
Met = namedtuple("Met", "start which places laws f y")


@compiled
def attempt(
    structure: Structure, scheme: Scheme, moving: Moving, h: float, load: Array, wanted: Any, resultants: Array,
    begins: int,
) -> Tried:  # fmt: skip
    """A step of length h from the state of `moving`, which is changed in place if it is solved.

    `load` (b, 3) kN at the share θ; `wanted`: span, accepted residual of forces and products, energy (kNm) that errors
    of velocities may have; `resultants` (j, 3): N, P and T found; `begins`: where the program does (Start).

    Joints that stay open bear nothing: those too far apart to close in the step are left out of its program, and it is
    solved again with those that its motion has closed all the same.
    """
    span, accepted, errors = wanted
    first, mass, weight, size = structure.first, structure.mass, structure.weight, structure.size
    x, v, joints, theta = moving.blocks[0], moving.blocks[1], moving.joints, scheme.theta
    n, m, elastic = len(mass), 3 * int((first >= 0).sum()), elastic_beds(structure.basic)
    start, places, law, touching, inside = _reached(structure, scheme, moving, h, span)
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
    moved, speed, jerked, work = _gone(structure, scheme, moving, h, load, dx, central)
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
    moving.blocks[2] = (speed - v) / h
    v[:] = speed
    return Tried(True, done, force, taken, turned, held, product * products, lifts)


@compiled
def _reached(
    structure: Structure, scheme: Scheme, moving: Moving, h: float, span: float
) -> tuple[Array, Array, Array, Any, Any]:
    """Places (j, PLACE) as a step begins, and as it feels them with laws (j, LAW); which joints overlap, may close."""
    a, b, v, law = structure.a, structure.b, moving.blocks[1], structure.basic.copy()
    start = placed(structure, moving.blocks[0], moving.joints)
    ahead = 0.5 * h if elastic_beds(law) else (1.0 - scheme.theta) * h
    places = placed(structure, moving.blocks[0] + ahead * (v + 0.5 * ahead * moving.blocks[2]), moving.joints)
    touching = posed(structure, scheme, moving, h, start, places, law)
    inside = np.empty(len(touching), np.bool_)
    for q in range(len(touching)):
        k = touching[q]
        du, dphi, _ = relative(places[k], a[k], b[k], v)
        near = CLOSING * (span + h * (abs(du) + places[k, H] * abs(dphi)))
        inside[q] = places[k, U] - places[k, H] * abs(places[k, PHI]) < near
    return start, places, law, touching, inside


@compiled
def _gone(
    structure: Structure, scheme: Scheme, moving: Moving, h: float, load: Array, dx: Array, central: Array
) -> tuple[Array, Array, float, float]:
    """Way and velocity (b, 3) after a step, of a solution dx (m,), Σ m Δv² and the work of the `load` (b, 3).

    Blocks remember the velocities of the `central` iterate (m,).
    """
    first, mass, v, theta = structure.first, structure.mass, moving.blocks[1], scheme.theta
    moved, speed, jerked, work = np.zeros(v.shape), np.zeros(v.shape), 0.0, 0.0
    elastic, moving.blocks[3] = elastic_beds(structure.basic), 0.0
    for i in range(len(first)):
        j = first[i]
        if j < 0:
            continue
        for e in range(3):
            moving.blocks[3, i, e] = central[j + e]
            if elastic:
                moved[i, e] = dx[j + e]
                speed[i, e] = v[i, e] + (dx[j + e] / h - v[i, e]) / theta
            else:
                speed[i, e] = dx[j + e] / h
                moved[i, e] = h * ((1.0 - theta) * v[i, e] + theta * speed[i, e])
            jerked += mass[i, e] * (speed[i, e] - v[i, e]) ** 2
            work += load[i, e] * moved[i, e]
    return moved, speed, jerked, work


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
            taken = -(normal * du + moment * dphi)
            unsure = 0.5 * STANDARD_GRAVITY * h * h * normal
            spent[STEPPING] += min(max(taken, -unsure), unsure)
        # of a slide that turns back, or comes to rest and may turn, the friction is not that of the whole step
        _, _, v0 = relative(start[k], a[k], b[k], v)
        _, _, v1 = relative(at[q], a[k], b[k], speed)
        if v0 * v1 < 0.0 and (not elastic or max(abs(t), abs(shear[k])) >= SLIDING * limit):
            turned += abs(t * h * v0 * v1 / (v0 - v1))
        elif not elastic and limit < np.inf and abs(v1) < STILL * abs(v0):
            turned += h * abs(v0) * (limit - abs(t))
    return contact, turned


@compiled
def _kinetic(mass: Array, v: Array) -> float:
    """Kinetic energy (kNm) of blocks with velocities v (b, 3)."""
    found = 0.0
    for i in range(len(v)):
        for e in range(3):
            found += 0.5 * mass[i, e] * v[i, e] ** 2
    return found


@compiled
def _tried(
    structure: Structure, scheme: Scheme, moving: Moving, step: float, load: Array, kinetic: float, resultants: Array,
    counts: Array,
) -> Tried:  # fmt: skip
    """A part of a step, from one start of its program after the other; residuals: by its way, at most a block."""
    fastest, rigid = 0.0, not elastic_beds(structure.basic)
    for i in range(len(load)):
        fastest = max(fastest, abs(moving.blocks[1, i, 0]), abs(moving.blocks[1, i, 1]))
    span = min(max(STANDARD_GRAVITY * step * step, fastest * step), structure.size)
    exactly = scheme.accepted if kinetic > 0.0 or not rigid else SHARPLY * scheme.accepted
    wanted = (span, exactly, scheme.unsure * kinetic)
    for start in range(NEAR, FROM_GAPS + 1):
        counts[3] += start > NEAR
        tried = attempt(structure, scheme, moving, step, load, wanted, resultants, start)
        counts[0] += 1
        counts[1] += tried.iterations
        if tried.solved:
            counts[6] += tried.lift > RIGHT
            counts[4], counts[5] = max(counts[4], tried.force), max(counts[5], tried.errors)
            break
    return tried


@compiled
def march(
    structure: Structure, scheme: Scheme, moving: Moving, base: Array, halved: int, begun: Array, found: Any,
    counts: Array,
) -> tuple[int, int, int]:  # fmt: skip
    """Steps under base accelerations (k + 1, 3), m/s², linear in between, into `found` (dynamic_system.Recorded).

    A part of a step is as long as the one before unless that took little; `halved`: how often the last step before was;
    `begun` (b, 3): positions from where contacts were looked for; `counts` (7,): programs, iterations, halvings, cold
    starts, the worst residual of force, per weight, the largest energy (kNm) that errors of velocities may have, and
    steps in which joints lift by Coulomb's law (program.RIGHT). Returns the number of steps done; why the march ends,
    0: all steps are done, FAR: a corner has moved by the margin, UNSOLVED: a program is not solved (the motion is as
    before it), RESTS: rigid joints rested before the last step and do after it (REST); how often it was halved.
    """
    mass, weight, h, theta = structure.mass, structure.weight, scheme.h, scheme.theta
    blocks, joints, energy = moving
    n, c, steps, rigid = len(mass), len(joints), len(base) - 1, not elastic_beds(structure.basic)
    load, resultants = np.empty((n, 3)), np.empty((c, 3))
    # so many of the shortest steps are one; how often the next one is halved
    whole, deep = 1 << scheme.most, halved
    for k in range(steps):
        first_blocks, first_joints, first_energy = blocks.copy(), joints.copy(), energy.copy()
        gone, once, deep, halved_here = 0, True, max(deep - 1, 0), counts[2]
        rested = rigid and _kinetic(mass, blocks[1]) <= REST * weight * STANDARD_GRAVITY * h**2
        while gone < whole:
            while gone % (whole >> deep) > 0:
                deep += 1
            step, at, kinetic = h / (1 << deep), gone / whole + theta / (1 << deep), _kinetic(mass, blocks[1])
            load[:] = structure.dead - mass * ((1.0 - at) * base[k] + at * base[k + 1])
            energy[LARGEST] = max(energy[LARGEST], kinetic)
            kept_blocks, kept_joints, kept_energy = blocks.copy(), joints.copy(), energy.copy()
            counted = kinetic if scheme.of_moment else energy[LARGEST]
            tried = _tried(structure, scheme, moving, step, load, kinetic, resultants, counts)
            # blocks that meet no faster than one falls within a whole step may not have met at all
            small = scheme.share * (counted + 0.5 * weight * STANDARD_GRAVITY * step**2)
            meeting = MEETING * (counted + 0.5 * weight * STANDARD_GRAVITY * h**2)
            over = abs(tried.taken) / small + tried.held / meeting
            # of many elastic joints slides turn with every tremor: told, not located
            over += tried.turned / small if rigid or scheme.of_moment else 0.0
            if (deep < scheme.most and not tried.solved) or (deep < scheme.levels and over > 1.0 and once):
                # but the forces and gaps found: the parts begin near them
                blocks[:3], energy[:] = kept_blocks[:3], kept_energy
                joints[:, SPRING:] = kept_joints[:, SPRING:]
                counts[2] += 1
                deep += 1
                continue
            if not tried.solved:
                blocks[:], joints[:], energy[:] = first_blocks, first_joints, first_energy
                if not once:
                    return k, UNSOLVED, deep
                # once more, halved only where it is not solved
                gone, once, deep = 0, False, 0
                continue
            if over > 1.0 and rigid:
                blocks[2] = 0.0  # an impact is no acceleration
            for q in range(c):  # of elastic joints the greatest force of its parts, of rigid ones no impulse
                if gone == 0 or rigid or resultants[q, 0] >= found.forces[k + 1, q, 0]:
                    found.forces[k + 1, q] = resultants[q]
            gone += whole >> deep
            # longer again as far as that is expected to take no more than the share; at the latest in the next step
            while deep > 0 and over <= 0.5:
                deep, over = deep - 1, 2.0 * over
        still = _kinetic(mass, blocks[1]) <= REST * weight * STANDARD_GRAVITY * h**2
        found.x[k + 1], found.v[k + 1], found.energy[k + 1] = blocks[0], blocks[1], energy
        far = 0.0
        for i in range(n):
            way = np.hypot(blocks[0, i, 0] - begun[i, 0], blocks[0, i, 1] - begun[i, 1])
            far = max(far, way + structure.radius[i] * abs(blocks[0, i, 2] - begun[i, 2]))
        if far > scheme.margin:
            return k + 1, FAR, deep
        if rested and still and deep == 0 and halved_here == counts[2]:
            return k + 1, RESTS, deep
    return steps, 0, deep
