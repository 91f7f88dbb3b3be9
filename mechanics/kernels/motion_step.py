"""One time step of blocks in contact, and steps halved where impacts take energy: compiled.

Balance, loads and springs are taken at a share θ of the step (θ = 1: implicit Euler, the paper's; θ = ½: the middle).

Elastic joints: M(v₁ − v₀)/h = f + BᵀF and Δx/h = v₀ + θ(v₁ − v₀), hence the mass M/(θh²). Of a fibre of the bed that is
closed the force is −k(w₀ + θΔw), of one that closes within the step −kθ(w₀ + Δw); dashpots add −kβΔw/h. In one:
−k(θ + β/h)(Δw + g), where g is w₀/(θ + β/h) at an end that is closed and w₀ at one that closes.

No step leaves a bed deeper than its forces pressed it, nor with more stored than was done on it (it may give more):
where the blocks come closer than that, by the geometry of the step or a slide that stops, the bed has `sunk` until they
part. Otherwise a stiff bed would turn a gap wrong by microns into a blow.

Rigid joints, at velocity level: M(v₁ − v₀)/h = f + BᵀF and the gap g₀ + h Bv₁ ≥ 0 (Moreau and Jean, without bounce),
with x₁ = x₀ + h((1 − θ)v₀ + θv₁). What a joint that closes takes of the energy is an impact's, but for what a block
that falls for the time of the step alone would have brought: that is the stepping's.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.kernels.bed import crushed, pressed, stored
from mechanics.kernels.interior_iteration import iterate
from mechanics.kernels.jit import compiler
from mechanics.kernels.joint import MPHI, MU, MV, NX, NZ, PHI, PLACE, H, U, V, place
from mechanics.kernels.law import BED, FRICTION, SHEAR, SLID
from mechanics.kernels.newton_iteration import newton
from mechanics.types import Array

compiled = compiler("contract", "reassoc")

# where the energy of a motion is (energy, 6): stored in springs; taken by friction, impacts, dashpots and the
# stepping; put in; and the largest kinetic energy so far, by which what steps take is measured
ELASTIC, RUBBED, IMPACT, VISCOUS, STEPPING, INPUT, LARGEST = range(7)
ENERGIES = 7
# columns of the state of a joint (joints, j × 11): N₁, N₂, T and y₁, y₂, λ₊, λ₋ of the last program; force of the
# spring in shear, kN; speed of the slide, m/s, and its acceleration; gap of the blocks less that of the bed, m
N1, GAPS, SPRING, SPEED, RATE, SUNK = 0, 3, 7, 8, 9, 10
JOINT = 11
STANDARD_GRAVITY = 9.80665  # m/s²
ROUGHLY = 1e-4  # missed per weight and span: the joints that slide are known
# per weight and span: products of forces and gaps near an earlier solution, of rigid and of elastic joints, with which
# the interior point is asked only where many have changed
CENTRAL_RIGID, CENTRAL_ELASTIC = 0.1, 1.0
WITHIN = 0.98  # of the bound of friction: the most of a force there
COLD = 1.0  # per force that stops the blocks, and span: forces and gaps of a cold start
MOST_ITERATIONS = np.int64(60)  # of no literal type, for which the iteration would be compiled once more
PRESSED = 1e-6  # of the weight of a block: a force that is one
STILL = 1e-3  # of its speed before: a slide that has come to rest
NEWTON = 30  # iterations for the gap at which a bed stores what was done on it
CLOSED = 1e-6  # of the block size: a gap that is none
GONE = 1e-9  # of the block size: an overlap that is none


@compiled
def relative(p: Array, a: int, b: int, moved: Array) -> tuple[float, float, float]:
    """Changes of u, φ and v of a joint at p (PLACE,) under displacements (b, 3), with the lever of its place."""
    lx, lz = p[5], p[6]
    dx = moved[a, 0] - (moved[b, 0] - lz * moved[b, 2])
    dz = moved[a, 1] - (moved[b, 1] + lx * moved[b, 2])
    turn = moved[a, 2] - moved[b, 2]
    return (
        p[NX] * dx + p[NZ] * dz + p[MU] * turn,
        p[MPHI] * turn,
        p[NZ] * dx - p[NX] * dz + p[MV] * turn,
    )


@compiled
def strain_energy(places: Array, law: Array, shear: Array, size: float) -> float:
    """Energy (kNm) of the beds at places (j, PLACE) and of springs in shear with forces (j,)."""
    total = 0.0
    for k in range(len(places)):
        if places[k, H] > GONE * size:
            total += stored(places[k, U], places[k, PHI], places[k, H], law[k, BED])
        total += 0.5 * law[k, SHEAR] * shear[k] ** 2
    return total


@compiled
def _apart(gap: float, rate: float, closed: float, bounce: float) -> float:
    """The gap of an end that its velocity has to respect: blocks that lie in each other are not thrown apart.

    An end that would meet at its `rate` leaves at the share `bounce` of it: at once, not where it touches.
    """
    if bounce > 0.0 and gap + rate <= 0.0:
        return bounce * min(rate, 0.0)
    return gap if gap > closed else 0.0


@compiled
def _storing(u: float, phi: float, half: float, stiffness: float, most: float) -> float:
    """The gap at the middle, u or more, at which a bed turned by φ stores at most that energy (Newton)."""
    if most <= 0.0:
        return max(u, half * abs(phi))
    for _ in range(NEWTON):
        over = stored(u, phi, half, stiffness) - most
        if over <= 1e-12 * most:
            break
        u += over / pressed(u, phi, half, stiffness)[0]
    return u


@compiled
def _begins(p: Array, s: Array, rate: tuple[float, float], h: float, closed: float) -> None:
    """Let u and φ of an elastic joint at a place p be what its forces count from: g of the ends, see above.

    `s` (PLACE,): at the start, where its gap changes at the `rate` (u, φ); `closed`: 1/(θ + β/h).
    """
    low, high = p[U] - p[H] * p[PHI], p[U] + p[H] * p[PHI]
    if min(low, high) >= 0.0:
        return
    side = 1.0 if high > low else -1.0
    if max(low, high) > 0.0 and max(low, high) + h * (rate[0] + side * s[H] * rate[1]) <= 0.0:
        low, high = (low, closed * high) if high < low else (closed * low, high)
        p[U], p[PHI] = 0.5 * (low + high), 0.5 * (high - low) / p[H]
    else:
        p[U], p[PHI] = p[U] * closed, p[PHI] * closed


@compiled
def _rigid_gaps(
    p: Array, s: Array, a: int, b: int, v: Array, h: float, size: float, restitution: float
) -> None:
    """Let u and φ of a rigid joint at a place p be those that its velocity has to respect.

    The velocity at the end is along the rows of the end, which differ from those of the middle as these do from those
    of the start, s (PLACE,).
    """
    u0, phi0, _ = relative(s, a, b, v)
    u1, phi1, _ = relative(p, a, b, v)
    du, dphi, ends = h * (u1 - u0), h * (phi1 - phi0), np.empty(2)
    for e in range(2):
        arm = (2 * e - 1) * s[H]
        ends[e] = _apart(p[U] + arm * p[PHI], h * (u0 + arm * phi0), CLOSED * size, restitution)
        ends[e] += du + arm * dphi
    p[U], p[PHI] = 0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]) / max(p[H], GONE * size)


@compiled
def posed(
    a: Any, b: Any, start: Array, v: Array, joints: Array, basic: Array, h: float, theta: float, beta: float,
    restitution: float, size: float, places: Array, law: Array, back: Array,
) -> Any:  # fmt: skip
    """Return which joints (i,) overlap in a step; `places` get the gaps of the start with the rows of the middle.

    `law` (j, LAW) becomes that of the step; `back` (j,) m: the lift of slides that is subtracted.
    """
    # many arguments: arrays one by one, see mechanics.kernels
    elastic, count = basic[0, BED] < np.inf, 0
    stretch = theta + beta / h if elastic else 1.0
    active = np.empty(len(a), np.intp)
    for k in range(len(a)):
        p, s = places[k], start[k]
        p[U], p[PHI], p[V] = s[U] - joints[k, SUNK], s[PHI], s[V]
        gap = p[U] - s[H] * abs(s[PHI])
        p[H] = min(p[H], s[H])
        law[k, SLID] = s[V]
        if not elastic:
            _rigid_gaps(p, s, a[k], b[k], v, h, size, restitution)
        if p[H] <= GONE * size:
            joints[k, :GAPS] = 0.0
            continue
        active[count] = k
        count += 1
        # Coulomb: the lift of a slide that goes on as it did is taken back, which leaves that by which it has changed
        back[k] = law[k, FRICTION] * h * max(joints[k, SPEED] + h * joints[k, RATE], 0.0)
        if elastic:
            law[k, BED] *= stretch
            law[k, SHEAR] /= stretch
            law[k, SLID] += law[k, SHEAR] * joints[k, SPRING]
            u0, phi0, _ = relative(s, a[k], b[k], v)
            _begins(p, s, (u0, phi0), h, 1.0 / stretch)
        else:  # where a slower slide has let rigid faces into each other, it is left until they are out again
            back[k] = max(back[k] + min(gap, 0.0), 0.0)
        p[U] += back[k]
    return active[:count]


@compiled
def _begin_cold(at: Array, span: float, stops: float, f: Array, y: Array) -> None:
    """Forces and gaps where nothing is known of them but the gaps that are there, and a force that stops blocks."""
    for k in range(len(f)):
        for e in range(2):
            gap = at[k, U] + (2 * e - 1) * at[k, H] * at[k, PHI]
            y[k, e] = COLD * span + max(gap, 0.0)
            f[k, e] = stops * COLD * span / y[k, e]
        f[k, 2], y[k, 2], y[k, 3] = 0.0, COLD * span, COLD * span


@compiled
def _begin_near(laws: Array, weight: float, span: float, central: float, f: Array, y: Array) -> None:
    """Bring forces and gaps of an earlier solution within their bounds, all products `central`, per weight and span.

    Of an end that carries the gap becomes small, of one that is open the force: their difference, scaled, remains.
    """
    for k in range(len(f)):
        for e in range(2):
            carries = 0.5 * (f[k, e] / weight - y[k, e] / span)
            large = abs(carries) + np.sqrt(carries * carries + central)
            small = central / large
            f[k, e], y[k, e] = weight * small, span * large
            if carries > 0.0:
                f[k, e], y[k, e] = weight * large, span * small
        bound = laws[k, FRICTION] * (f[k, 0] + f[k, 1])
        f[k, 2] = min(max(f[k, 2], -WITHIN * bound), WITHIN * bound)
        for e in range(2):
            least = central * weight * span / (bound + (1 - 2 * e) * f[k, 2])
            y[k, 2 + e] = max(y[k, 2 + e], min(least, span))


@compiled
def _solve(
    rows: Any, at: Array, laws: Array, load: Array, mass: Array, dx: Array, f: Array, y: Array, scale: Any, cold: bool,
    elastic: bool, stops: float, stored_matrix: Array, packed: Any, chosen: Any,
) -> tuple[int, float, float, float]:  # fmt: skip
    """Solve for displacements dx (m,), forces f (j, 3) and gaps y (j, 4) of a step; return as `iterate` does, but no α.

    With elastic joints Newton's method is tried from the start of the step; if it fails since many joints slide, from
    a rough solution (ROUGHLY) of the interior point. Otherwise, and with rigid joints, the interior point begins near
    the dx, f and y given.
    """
    # many arguments: arrays one by one, see mechanics.kernels
    weight, size, span, accepted, _ = scale
    done, none = 0, np.empty(0)
    if elastic and not cold:
        moved = np.zeros(len(dx))
        more, force, gap = newton(
            rows, at, laws, load, mass, moved, f, y, scale[:4], stored_matrix, packed, chosen
        )
        done += more
        if force <= accepted:
            dx[:] = moved
            return done, force, gap, 0.0
    if cold:
        _begin_cold(at, span, stops, f, y)
    else:
        _begin_near(laws, weight, span, CENTRAL_ELASTIC if elastic else CENTRAL_RIGID, f, y)
    if elastic:
        more, _, force, gap, product = iterate(
            rows, at, laws, load, none, 0.0, mass, np.empty((0, 7)), dx, 0.0, f, y,
            (weight, size, span, ROUGHLY, ROUGHLY), MOST_ITERATIONS, stored_matrix, packed, chosen,
        )  # fmt: skip
        done += abs(more)
        if not max(force, product) <= ROUGHLY:
            return done, force, gap, product
        moved = dx.copy()
        more, force, gap = newton(
            rows, at, laws, load, mass, moved, f, y, scale[:4], stored_matrix, packed, chosen
        )
        done += more
        if force <= accepted:
            dx[:] = moved
            return done, force, gap, 0.0
    more, _, force, gap, product = iterate(
        rows, at, laws, load, none, 0.0, mass, np.empty((0, 7)), dx, 0.0, f, y, scale, MOST_ITERATIONS, stored_matrix,
        packed, chosen,
    )  # fmt: skip
    return done + abs(more), force, gap, product


@compiled
def sunk(
    start: Array, end: Array, basic: Array, closest: Array, done: Array, joints: Array, size: float
) -> float:
    """What beds store more at the end of a step than at its start (kNm); SUNK of the `joints` becomes that of the end.

    `start`, `end` (j, PLACE); `closest` (j,) m: the least gap that the forces of the step led to; `done` (j,) kNm: the
    work that was done on each bed.
    """
    more = 0.0
    for k in range(len(start)):
        s, e, stiffness, before = start[k], end[k], basic[k, BED], 0.0
        if s[H] > GONE * size:
            before = stored(s[U] - joints[k, SUNK], s[PHI], s[H], stiffness)
        more -= before
        joints[k, SUNK] = 0.0
        if e[H] > GONE * size:
            u = e[U] + max(min(closest[k], 0.0) - e[U] + e[H] * abs(e[PHI]), 0.0)
            if stored(u, e[PHI], e[H], stiffness) > before + done[k]:
                u = _storing(u, e[PHI], e[H], stiffness, before + done[k])
            joints[k, SUNK] = e[U] - u
            more += stored(u, e[PHI], e[H], stiffness)
    return more


@compiled
def attempt(
    a: Any, b: Any, faces: Array, basic: Array, row: Any, first: Any, mass: Array, load: Array,
    blocks: Array, joints: Array, energy: Array, h: float, theta: float, beta: float, restitution: float, scale: Any,
    resultants: Array, stored_matrix: Array, packed: Any, cold: bool,
) -> tuple[int, float, float, float, float]:  # fmt: skip
    """A step of length h from the state of blocks (3, b, 3), joints (j, JOINT) and energy, changed in place if solved.

    `load` (b, 3) kN at the share θ; `restitution` of velocities at which rigid ends meet; `scale`: weight, size and
    span of the step, and the accepted residuals of force and product; `resultants` (j, 3): N, P and T found; `cold`:
    the program begins from the gaps alone. Returns the number of iterations, negative if no solution was found, the
    energy that the step took, the part of it that slides which turn back leave uncertain, and the residuals of force
    and product.
    """
    # many arguments and lines: arrays one by one, shared by the stages of a step, see mechanics.kernels
    weight, size, span, accepted, closed = scale
    c, n, m = len(a), blocks.shape[1], 0
    x, v, past = blocks[0], blocks[1], blocks[2]
    for i in range(n):
        m += 3 * (first[i] >= 0)
    elastic = basic[0, BED] < np.inf
    places, start, law, back = np.empty((c, PLACE)), np.empty((c, PLACE)), basic.copy(), np.zeros(c)
    place(a, b, faces, x, start)
    ahead = 0.5 * h if elastic else (1.0 - theta) * h
    place(a, b, faces, x + ahead * (v + 0.5 * ahead * past), places)
    chosen = posed(a, b, start, v, joints, basic, h, theta, beta, restitution, size, places, law, back)
    at, laws = places[chosen], law[chosen]
    f, y = joints[chosen][:, N1:GAPS].copy(), joints[chosen][:, GAPS:SPRING].copy()
    share = theta if elastic else 1.0
    scaled, pushed, dx = np.empty(m), np.empty(m), np.empty(m)
    for i in range(n):
        j = first[i]
        if j >= 0:
            for e in range(3):
                scaled[j + e] = mass[i, e] / (share * h * h)
                dx[j + e] = h * v[i, e]
                pushed[j + e] = load[i, e] + scaled[j + e] * dx[j + e]
    done, force, _, product = _solve(
        row[chosen], at, laws, pushed, scaled, dx, f, y, scale, cold, elastic,
        COLD * weight * span / (STANDARD_GRAVITY * h * h), stored_matrix, packed, chosen,
    )  # fmt: skip
    if force > accepted or product > closed:
        return -done, 0.0, 0.0, force, product
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
    spent = np.zeros(ENERGIES)
    contact, turned = _worked(
        a, b, chosen, start, at, laws, basic, f, y, back, v, moved, speed, h, theta, beta, weight, joints,
        resultants, spent,
    )  # fmt: skip
    if elastic:
        closest, done_on = np.zeros(c), np.zeros(c)
        for q in range(len(chosen)):
            k = chosen[q]
            du, dphi, _ = relative(at[q], a[k], b[k], moved)
            # by the law of the step: the lift that was taken back, less that of the slide
            u = start[k, U] - joints[k, SUNK] + du + back[k] - laws[q, FRICTION] * (y[q, 2] + y[q, 3])
            closest[k] = u - at[q, H] * abs(start[k, PHI] + dphi)
            done_on[k] = -(resultants[k, 0] * du + resultants[k, 1] * dphi)
        end = np.empty((c, PLACE))
        place(a, b, faces, x + moved, end)
        spent[ELASTIC] += sunk(start, end, basic, closest, done_on, joints, size)
    # computed from the forces, not as what is missing: the balance is a check
    taken = (theta - 0.5) * jerked - contact - spent[RUBBED] - spent[VISCOUS] - spent[ELASTIC]
    if not elastic and theta < 1.0:
        spent[IMPACT] = taken - spent[STEPPING]
    else:
        spent[STEPPING] = taken
    spent[INPUT] = work
    energy += spent
    x += moved
    past[:] = (speed - v) / h
    v[:] = speed
    return done, taken, turned, force, product


@compiled
def _worked(
    a: Any, b: Any, chosen: Any, start: Array, at: Array, laws: Array, basic: Array, f: Array, y: Array, back: Array,
    v: Array, moved: Array, speed: Array, h: float, theta: float, beta: float, weight: float, joints: Array,
    resultants: Array, spent: Array,
) -> tuple[float, float]:  # fmt: skip
    """Return the work of all joints on the blocks in a step, and the part that slides which turn back leave uncertain.

    `spent` (ENERGIES,) gets the energies of friction, dashpots, springs in shear and slow impacts, `resultants` (j, 3)
    and `joints` (j, JOINT) the forces.
    """
    # many arguments: arrays one by one, see mechanics.kernels
    elastic = basic[0, BED] < np.inf
    stretch = theta + beta / h if elastic else 1.0
    contact, turned = 0.0, 0.0
    slid, shear = joints[:, SPEED].copy(), joints[:, SPRING].copy()
    joints[:, N1:GAPS], joints[:, SPRING:SUNK], resultants[:] = 0.0, 0.0, 0.0
    for k in range(len(joints)):
        spent[ELASTIC] -= 0.5 * basic[k, SHEAR] * shear[k] ** 2
    for q in range(len(chosen)):
        k = chosen[q]
        joints[k, N1:GAPS], joints[k, GAPS:SPRING] = f[q], y[q]
        du, dphi, dv = relative(at[q], a[k], b[k], moved)
        normal, moment, t = f[q, 0] + f[q, 1], at[q, H] * (f[q, 1] - f[q, 0]), f[q, 2]
        resultants[k, 0], resultants[k, 1], resultants[k, 2] = normal, moment, t
        if normal > PRESSED * weight:
            joints[k, SPEED] = abs(y[q, 2] - y[q, 3]) / h
            joints[k, RATE] = (joints[k, SPEED] - slid[k]) / h if slid[k] > 0.0 else 0.0
        contact += normal * du + moment * dphi + t * dv
        limit = laws[q, FRICTION] * normal
        if elastic:
            spent[RUBBED] -= t * (dv + laws[q, SHEAR] * (t - shear[k]))
            joints[k, SPRING] = min(max(shear[k] + (t - shear[k]) / stretch, -limit), limit)
            spent[ELASTIC] += 0.5 * basic[k, SHEAR] * joints[k, SPRING] ** 2
            if beta > 0.0:
                # dashpots along the contact of the middle of the step, and that of the spring in shear
                u, phi = start[k, U] - joints[k, SUNK] + 0.5 * du, start[k, PHI] + 0.5 * dphi
                _, _, c0, c1, c2 = crushed(u, phi, at[q, H], basic[k, BED], np.inf)
                spent[VISCOUS] += beta / h * (c0 * du * du + 2.0 * c1 * du * dphi + c2 * dphi * dphi)
                spent[VISCOUS] += beta / h * basic[k, SHEAR] * ((t - shear[k]) / stretch) ** 2
        else:
            spent[RUBBED] -= t * dv
            # faces that meet no faster than a step makes a block that falls may not have met at all
            met = -(normal * du + moment * dphi)
            unsure = 0.5 * STANDARD_GRAVITY * h * h * normal
            spent[STEPPING] += min(max(met, -unsure), unsure)
            # of a slide that turns back, or comes to rest and may turn, the friction is not that of the whole step
            _, _, v0 = relative(start[k], a[k], b[k], v)
            _, _, v1 = relative(at[q], a[k], b[k], speed)
            if v0 * v1 < 0.0:
                turned += abs(t * h * v0 * v1 / (v0 - v1))
            elif abs(v1) < STILL * abs(v0):
                turned += h * abs(v0) * (limit - abs(t))
    return contact, turned


@compiled
def march(
    a: Any, b: Any, faces: Array, basic: Array, row: Any, first: Any, mass: Array, dead: Array,
    base: Array, blocks: Array, joints: Array, energy: Array, h: float, theta: float, beta: float, restitution: float,
    sizes: Any, halving: Any, margin: float, radius: Array, begun: Array, xs: Array, vs: Array, fs: Array, es: Array,
    counts: Any, stored_matrix: Array, packed: Any,
) -> tuple[int, int]:  # fmt: skip
    """Steps of length h under base accelerations (k + 1, 3), m/s², linear in between, recorded in xs, vs, fs and es.

    `sizes`: weight, size of a block and what is accepted of a solution; `halving`: levels down to which a step is
    halved where it takes, or leaves unsure, more than a share of the largest kinetic energy so far, that share, levels
    where it is not solved, and the share of its kinetic energy by which its velocities may be wrong, 0: as little as at
    rest; a part is as long as the one before unless that took little; `margin` (m): how far a corner may go from
    where it has `begun` (b, 3) before contacts are looked for anew, `radius` (b,) of blocks; `counts` (6,): programs,
    iterations, halvings, cold starts, the worst residual of force, per weight, and the largest energy (kNm) that errors
    of velocities may have. Returns the number of steps done and why the march ends:
    0: all steps are done, 1: a corner has moved by the margin, 2: a program is not solved (the motion is as before it).
    """
    # many arguments and lines: arrays one by one, in one loop over steps, see mechanics.kernels
    weight, size, accepted = sizes
    levels, share, most, unsure = halving
    n, c, steps = blocks.shape[1], len(a), len(base) - 1
    rigid = basic[0, BED] == np.inf
    load, resultants = np.empty((n, 3)), np.empty((c, 3))
    whole, deep = 1 << most, 0  # so many of the shortest steps are one; how often the next one is halved
    for k in range(steps):
        first_blocks, first_joints, first_energy = blocks.copy(), joints.copy(), energy.copy()
        gone, once, deep = 0, True, max(deep - 1, 0)
        while gone < whole:
            while gone % (whole >> deep) > 0:
                deep += 1
            step, at = h / (1 << deep), gone / whole + theta / (1 << deep)
            kinetic, fastest = 0.0, 0.0
            for i in range(n):
                fastest = max(fastest, abs(blocks[1, i, 0]), abs(blocks[1, i, 1]))
                for e in range(3):
                    kinetic += 0.5 * mass[i, e] * blocks[1, i, e] ** 2
                    load[i, e] = dead[i, e] - mass[i, e] * ((1.0 - at) * base[k, e] + at * base[k + 1, e])
            energy[LARGEST] = max(energy[LARGEST], kinetic)
            kept_blocks, kept_joints, kept_energy = blocks.copy(), joints.copy(), energy.copy()
            # what is accepted of a program is a share of the way, and of a long step's of the block
            span = min(max(STANDARD_GRAVITY * step * step, fastest * step), size)
            found, taken, turned = False, np.inf, 0.0
            small = share * (energy[LARGEST] + 0.5 * weight * STANDARD_GRAVITY * step**2)
            # the error of velocities has at most the energy of all products: the program is strongly convex
            products = 4.0 * max(c, 1) * weight * span
            most_product = max(accepted, unsure * kinetic / products)
            for start in range(2):
                counts[3] += start
                done, taken, turned, force, product = attempt(
                    a, b, faces, basic, row, first, mass, load, blocks, joints, energy, step, theta, beta,
                    restitution, (weight, size, span, accepted, most_product), resultants, stored_matrix, packed,
                    start > 0,
                )  # fmt: skip
                counts[0] += 1
                counts[1] += abs(done)
                found = force <= accepted and product <= most_product
                if found:
                    counts[4] = max(counts[4], force)
                    counts[5] = max(counts[5], product * products)
                    break
            over = (abs(taken) + turned) / small
            if (deep < most and not found) or (deep < levels and over > 1.0 and once):
                # but the forces and gaps found: the parts begin near them
                blocks[:], energy[:] = kept_blocks, kept_energy
                joints[:, SPRING:] = kept_joints[:, SPRING:]
                counts[2] += 1
                deep += 1
                continue
            if not found:
                blocks[:], joints[:], energy[:] = first_blocks, first_joints, first_energy
                if not once:
                    return k, 2
                # once more, halved only where it is not solved
                gone, once, deep = 0, False, 0
                continue
            if over > 1.0 and rigid:
                blocks[2] = 0.0  # an impact is no acceleration
            gone += whole >> deep
            # longer again as far as that is expected to take no more than the share; at the latest in the next step
            while deep > 0 and over <= 0.5:
                deep, over = deep - 1, 2.0 * over
        xs[k + 1], vs[k + 1], es[k + 1] = blocks[0], blocks[1], energy
        fs[k + 1] = resultants
        far = 0.0
        for i in range(n):
            way = np.hypot(blocks[0, i, 0] - begun[i, 0], blocks[0, i, 1] - begun[i, 1])
            far = max(far, way + radius[i] * abs(blocks[0, i, 2] - begun[i, 2]))
        if far > margin:
            return k + 1, 1
    return steps, 0
