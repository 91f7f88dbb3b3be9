"""One time step of blocks in contact, and steps halved where impacts take energy: compiled.

Balance, loads and springs are taken at a share θ of the step (θ = 1: implicit Euler, the paper's; θ = ½: the middle).

Elastic joints: M(v₁ − v₀)/h = f + BᵀF and Δx/h = v₀ + θ(v₁ − v₀), hence the mass M/(θh²). Of a fibre of the bed that is
closed at the start, w₀ < 0, the force is −k(w₀ + θΔw), of one that closes −kθ(w₀ + Δw); dashpots add −kβΔw/h. In one:
−k(θ + β/h)(Δw + g), g = w₀ where open and w₀/(θ + β/h) where closed: two beds where a face is partly open.

Rigid joints, at velocity level: M(v₁ − v₀)/h = f + BᵀF and the gap g₀ + h Bv₁ ≥ 0 (Moreau and Jean, without bounce),
with x₁ = x₀ + h((1 − θ)v₀ + θv₁). What a joint that closes takes of the energy is an impact.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.kernels.bed import crushed, stored
from mechanics.kernels.interior_iteration import iterate
from mechanics.kernels.jit import compiler
from mechanics.kernels.joint import MPHI, MU, MV, NX, NZ, PHI, PLACE, H, U, V, place
from mechanics.kernels.law import ABOVE, BED, BELOW, FRICTION, KINK, PHI0, SHEAR, SLID, U0
from mechanics.kernels.newton_iteration import newton
from mechanics.types import Array

compiled = compiler("contract", "reassoc")

# where the energy of a motion is (energy, 6): stored in springs; taken by friction, impacts, dashpots and the stepping;
# put in
ELASTIC, RUBBED, IMPACT, VISCOUS, STEPPING, INPUT = range(6)
ENERGIES = 6
STANDARD_GRAVITY = 9.80665  # m/s²
ROUGHLY = 1e-4  # missed per weight and span: the joints that slide are known
COLD = 1.0  # per force that stops the blocks, and span: forces and gaps of a cold start
MOST_ITERATIONS = np.int64(60)  # of no literal type, for which the iteration would be compiled once more
PRESSED = 1e-6  # of the weight of a block: a force that is one
STILL = 1e-3  # of its speed before: a slide that has come to rest
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
def _begin_inside(
    at: Array, laws: Array, weight: float, span: float, pressed: float, cold: bool, f: Array, y: Array
) -> None:
    """Bring forces and gaps within their bounds, where the interior point begins.

    `cold`: nothing is known of them but the gaps that are there, and the force `pressed` that stops blocks.
    """
    for k in range(len(f)):
        if cold:
            for e in range(2):
                gap = at[k, U] + (2 * e - 1) * at[k, H] * at[k, PHI]
                y[k, e] = COLD * span + max(gap, 0.0)
                f[k, e] = pressed * COLD * span / y[k, e]
            f[k, 2], y[k, 2], y[k, 3] = 0.0, COLD * span, COLD * span
        f[k, 0], f[k, 1] = max(f[k, 0], 1e-2 * weight), max(f[k, 1], 1e-2 * weight)
        bound = 0.98 * laws[k, FRICTION] * (f[k, 0] + f[k, 1])
        f[k, 2] = min(max(f[k, 2], -bound), bound)
        for e in range(4):
            least = 1e-2 * span / (max(laws[k, FRICTION], 1.0) if e > 1 else 1.0)
            y[k, e] = max(y[k, e], least)


@compiled
def _solve(
    rows: Any, at: Array, laws: Array, load: Array, mass: Array, dx: Array, f: Array, y: Array, scale: Any, cold: bool,
    elastic: bool, pressed: float, stored_matrix: Array, packed: Any, chosen: Any,
) -> tuple[int, float, float, float]:  # fmt: skip
    """Displacements dx (m,), forces f (j, 3) and gaps y (j, 4) of a step: iterations and residuals as of `iterate`.

    Elastic joints: by Newton's method from the start of the step; where many joints slide, from what the interior point
    has found ROUGHLY; else, as with rigid joints, by the interior point, near the dx, f and y given.
    """
    weight, size, span, accepted = scale
    done, none = 0, np.empty(0)
    if elastic and not cold:
        moved = np.zeros(len(dx))
        more, force, gap = newton(
            rows, at, laws, load, mass, moved, f, y, scale, stored_matrix, packed, chosen
        )
        done += more
        if force <= accepted:
            dx[:] = moved
            return done, force, gap, 0.0
    _begin_inside(at, laws, weight, span, pressed, cold, f, y)
    if elastic:
        more, _, force, gap, product = iterate(
            rows, at, laws, load, none, 0.0, mass, np.empty((0, 7)), dx, 0.0, f, y,
            (weight, size, span, ROUGHLY), MOST_ITERATIONS, stored_matrix, packed, chosen,
        )  # fmt: skip
        done += abs(more)
        if not max(force, product) <= ROUGHLY:
            return done, force, gap, product
        moved = dx.copy()
        more, force, gap = newton(
            rows, at, laws, load, mass, moved, f, y, scale, stored_matrix, packed, chosen
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
def attempt(
    a: Any, b: Any, faces: Array, basic: Array, tolerance: float, row: Any, first: Any, mass: Array, load: Array,
    x: Array, v: Array, past: Array, forces: Array, gaps: Array, shear: Array, slides: Array, energy: Array, h: float,
    theta: float, beta: float,
    restitution: float, lifted: Array, scale: Any, resultants: Array, stored_matrix: Array, packed: Any, attempts: int,
) -> tuple[int, float, float, float, float]:  # fmt: skip
    """A step of length h from positions x and velocities v (b, 3), changed in place like all that moves.

    `load` (b, 3) kN at the share θ; `forces` (j, 3): N₁, N₂, T and `gaps` (j, 4), near which the solution is sought;
    `shear` (j,) of springs; `energy` (ENERGIES,); `restitution` of velocities at which rigid ends meet; `lifted` (j,):
    gaps that count as none; `resultants` (j, 3): N, P and T found; `attempts` so far: after one, nothing is known of
    forces and gaps but the gaps that are there, and that impacts stop the blocks within the step. Returns the
    iterations, negative where nothing was found, the energy of which impacts, the stepping and slides that turn back
    leave unsure, and the residuals: force, gap, product.
    """
    weight, size, span, accepted = scale
    c, n, m = len(a), len(x), 0
    for i in range(n):
        m += 3 * (first[i] >= 0)
    elastic = basic[0, BED] < np.inf
    places, start = np.empty((c, PLACE)), np.empty((c, PLACE))
    place(a, b, faces, x, tolerance, start)
    half_way = np.empty((n, 3))
    for i in range(n):
        for e in range(3):
            half_way[i, e] = x[i, e] + (1.0 - theta) * h * (v[i, e] + (1.0 - theta) * 0.5 * h * past[i, e])
    place(a, b, faces, half_way, tolerance, places)
    law = basic.copy()
    stretch = theta + beta / h if elastic else 1.0
    active, count = np.empty(c, np.intp), 0
    for k in range(c):
        p, s = places[k], start[k]
        # gaps of the start, rows of the middle
        p[U], p[PHI], p[V] = s[U] - lifted[k], s[PHI], s[V]
        p[H] = min(p[H], s[H])
        law[k, SLID] = s[V]
        if not elastic:
            # the velocity at the end is along the rows of the end, which differ from those of the middle as these do
            # from those of the start
            u0, phi0, _ = relative(s, a[k], b[k], v)
            u1, phi1, _ = relative(p, a[k], b[k], v)
            du, dphi = h * (u1 - u0), h * (phi1 - phi0)
            low = (
                _apart(p[U] - s[H] * p[PHI], h * (u0 - s[H] * phi0), CLOSED * size, restitution)
                + du
                - s[H] * dphi
            )
            high = (
                _apart(p[U] + s[H] * p[PHI], h * (u0 + s[H] * phi0), CLOSED * size, restitution)
                + du
                + s[H] * dphi
            )
            p[U], p[PHI] = 0.5 * (low + high), 0.5 * (high - low) / max(p[H], GONE * size)
        if p[H] <= GONE * size:
            forces[k] = 0.0
            continue
        active[count] = k
        count += 1
        if elastic:
            law[k, BED] *= stretch
            law[k, SHEAR] /= stretch
            law[k, SLID] += law[k, SHEAR] * shear[k]
            low, high = p[U] - p[H] * p[PHI], p[U] + p[H] * p[PHI]
            closed = 1.0 / stretch
            if stretch != 1.0 and low * high < 0.0 and attempts < 2:
                law[k, KINK], law[k, U0], law[k, PHI0] = -p[U] / p[PHI], p[U], p[PHI]
                law[k, BELOW], law[k, ABOVE] = (closed, 1.0) if low < 0.0 else (1.0, closed)
                p[U], p[PHI] = 0.0, 0.0
            elif max(low, high) <= 0.0:
                p[U], p[PHI] = p[U] * closed, p[PHI] * closed
        # Coulomb: the lift of a slide that goes on as it did is taken back, which leaves that by which it has changed;
        # where a slower slide has let rigid faces into each other, it is left until they are out again
        lift = law[k, FRICTION] * h * max(slides[k, 0] + h * slides[k, 1], 0.0)
        p[U] += lift if elastic else max(lift + min(s[U] - lifted[k] - s[H] * abs(s[PHI]), 0.0), 0.0)
    share = theta if elastic else 1.0
    chosen = active[:count]
    rows, at, laws = row[chosen], places[chosen], law[chosen]
    f, y = forces[chosen], gaps[chosen]
    scaled, pushed, dx = np.empty(m), np.empty(m), np.empty(m)
    for i in range(n):
        j = first[i]
        if j >= 0:
            for e in range(3):
                scaled[j + e] = mass[i, e] / (share * h * h)
                dx[j + e] = h * v[i, e]
                pushed[j + e] = load[i, e] + scaled[j + e] * dx[j + e]
    done, force, gap, product = _solve(
        rows, at, laws, pushed, scaled, dx, f, y, (weight, size, span, accepted), attempts > 0, elastic,
        COLD * weight * span / (STANDARD_GRAVITY * h * h), stored_matrix, packed, chosen,
    )  # fmt: skip
    if max(force, product) > accepted:
        return -done, 0.0, force, gap, product
    moved, speed = np.zeros((n, 3)), np.zeros((n, 3))
    jerked, work = 0.0, 0.0
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
    contact, rubbed, viscous, turned = 0.0, 0.0, 0.0, 0.0
    forces[:], resultants[:] = 0.0, 0.0
    slid, slides[:] = slides.copy(), 0.0
    before, after = 0.0, 0.0
    new_shear = np.zeros(c)
    for q in range(count):
        k = chosen[q]
        forces[k], gaps[k] = f[q], y[q]
        du, dphi, dv = relative(at[q], a[k], b[k], moved)
        normal, moment, t = f[q, 0] + f[q, 1], at[q, H] * (f[q, 1] - f[q, 0]), f[q, 2]
        resultants[k, 0], resultants[k, 1], resultants[k, 2] = normal, moment, t
        if normal > PRESSED * weight:
            slides[k, 0] = abs(y[q, 2] - y[q, 3]) / h
            slides[k, 1] = (slides[k, 0] - slid[k, 0]) / h if slid[k, 0] > 0.0 else 0.0
        contact += normal * du + moment * dphi + t * dv
        if elastic:
            soft = laws[q, SHEAR]
            slip = dv + soft * (t - shear[k])
            rubbed -= t * slip
            s, limit = start[k], 0.0
            stiff = basic[k, BED]
            w0, w1 = s[U] - lifted[k], s[U] - lifted[k] + du
            before += stored(w0, s[PHI], at[q, H], stiff) + 0.5 * basic[k, SHEAR] * shear[k] ** 2
            limit = laws[q, FRICTION] * normal
            new_shear[k] = min(max(shear[k] + (t - shear[k]) / stretch, -limit), limit)
            after += stored(w1, s[PHI] + dphi, at[q, H], stiff) + 0.5 * basic[k, SHEAR] * new_shear[k] ** 2
            if beta > 0.0:
                # dashpots along the contact of the middle of the step, and that of the spring in shear
                _, _, c0, c1, c2 = crushed(w0 + 0.5 * du, s[PHI] + 0.5 * dphi, at[q, H], stiff, np.inf)
                viscous += beta / h * (c0 * du * du + 2.0 * c1 * du * dphi + c2 * dphi * dphi)
                viscous += beta / h * basic[k, SHEAR] * ((t - shear[k]) / stretch) ** 2
        else:
            rubbed -= t * dv
            # of a slide that turns back, or comes to rest and may turn, the friction is not that of the whole step
            _, _, v0 = relative(start[k], a[k], b[k], v)
            _, _, v1 = relative(at[q], a[k], b[k], speed)
            if v0 * v1 < 0.0:
                turned += abs(t * h * v0 * v1 / (v0 - v1))
            elif abs(v1) < STILL * abs(v0):
                turned += h * abs(v0) * (laws[q, FRICTION] * normal - abs(t))
    shear[:] = new_shear
    # computed from the forces, not as what is missing: the balance is a check
    taken = (theta - 0.5) * jerked - contact - rubbed - viscous - (after - before)
    if elastic:
        energy[VISCOUS] += viscous
        energy[STEPPING] += taken
    else:
        # what a fixed rule takes of a smooth motion is of the third order; what is more are impacts
        energy[IMPACT] += taken if theta < 1.0 else 0.0
        energy[STEPPING] += 0.0 if theta < 1.0 else taken
    energy[RUBBED] += rubbed
    energy[INPUT] += work
    for i in range(n):
        for e in range(3):
            x[i, e] += moved[i, e]
            past[i, e] = (speed[i, e] - v[i, e]) / h
            v[i, e] = speed[i, e]
    return done, abs(taken) + turned, force, gap, product


@compiled
def march(
    a: Any, b: Any, faces: Array, basic: Array, tolerance: float, row: Any, first: Any, mass: Array, dead: Array,
    base: Array, x: Array, v: Array, past: Array, forces: Array, gaps: Array, shear: Array, slides: Array, energy:
    Array, h: float,
    theta: float, beta: float, restitution: float, lifted: Array, sizes: Any, halving: Any, margin: float, radius:
    Array,
    begun: Array, xs: Array, vs: Array, fs: Array, es: Array, counts: Any, stored_matrix: Array, packed: Any,
) -> tuple[int, int]:  # fmt: skip
    """Steps of length h under base accelerations (k + 1, 3), m/s², linear in between, recorded in xs, vs, fs and es.

    `sizes`: weight, size of a block and what is accepted of a solution; `halving`: levels down to which a step is
    halved and the share of the kinetic energy that impacts and the stepping may take before it is; `margin` (m): how
    far a corner may go from where it has `begun` (b, 3) before contacts are looked for anew, `radius` (b,) of blocks;
    `counts` (6,): programs, iterations, halvings, cold starts, and the worst residuals. Returns the steps done and why
    no more: 0 all are, 1 a corner has gone that far, 2 a program is not solved (the motion is as before that step).
    """
    weight, size, accepted = sizes
    levels, share = halving
    n, c, steps = len(x), len(a), len(base) - 1
    load, now, resultants = np.empty((n, 3)), np.empty((c, PLACE)), np.empty((c, 3))
    duration, level = np.empty(levels + 2), np.empty(levels + 2, np.intp)
    kept_x, kept_v, kept_past, kept_f, kept_y, kept_s, kept_e = (
        np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3)), np.empty((c, 3)), np.empty((c, 4)), np.empty(c),
        np.empty(ENERGIES),
    )  # fmt: skip
    whole_x, whole_v, whole_past, whole_f, whole_y, whole_s, whole_e = (
        np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3)), np.empty((c, 3)), np.empty((c, 4)), np.empty(c),
        np.empty(ENERGIES),
    )  # fmt: skip
    kept_slides, whole_slides = np.empty((c, 2)), np.empty((c, 2))
    for k in range(steps):
        whole_x[:], whole_v[:], whole_past[:], whole_f[:] = x, v, past, forces
        whole_y[:], whole_s[:], whole_e[:], whole_slides[:] = gaps, shear, energy, slides
        time, top = 0.0, 0
        duration[0], level[0] = h, 0
        while top >= 0:
            step, deep = duration[top], level[top]
            top -= 1
            kinetic, fastest = 0.0, 0.0
            at = (time + theta * step) / h
            for i in range(n):
                fastest = max(fastest, abs(v[i, 0]), abs(v[i, 1]))
                for e in range(3):
                    kinetic += 0.5 * mass[i, e] * v[i, e] ** 2
                    load[i, e] = dead[i, e] - mass[i, e] * ((1.0 - at) * base[k, e] + at * base[k + 1, e])
            kept_x[:], kept_v[:], kept_past[:], kept_f[:] = x, v, past, forces
            kept_y[:], kept_s[:], kept_e[:], kept_slides[:] = gaps, shear, energy, slides
            span = max(STANDARD_GRAVITY * step * step, fastest * step)
            solved, taken = False, 0.0
            for start in range(3 if deep == levels else 2):
                counts[3] += start > 0
                done, taken, force, _gap, product = attempt(
                    a, b, faces, basic, tolerance, row, first, mass, load, x, v, past, forces, gaps, shear, slides,
                    energy, step,
                    theta, beta, restitution, lifted, (weight, size, span, accepted), resultants, stored_matrix, packed,
                    start,
                )  # fmt: skip
                counts[0] += 1
                counts[1] += abs(done)
                solved = max(force, product) <= accepted
                if solved:
                    counts[4], counts[5] = max(counts[4], force), max(counts[5], product)
                    break
            small = share * (kinetic + 0.5 * weight / STANDARD_GRAVITY * (STANDARD_GRAVITY * step) ** 2)
            if deep < levels and (not solved or taken > small):
                x[:], v[:], past[:], forces[:] = kept_x, kept_v, kept_past, kept_f
                gaps[:], shear[:], energy[:], slides[:] = kept_y, kept_s, kept_e, kept_slides
                counts[2] += 1
                duration[top + 1], level[top + 1] = 0.5 * step, deep + 1
                duration[top + 2], level[top + 2] = 0.5 * step, deep + 1
                top += 2
                continue
            if not solved:
                x[:], v[:], past[:], forces[:] = whole_x, whole_v, whole_past, whole_f
                gaps[:], shear[:], energy[:], slides[:] = whole_y, whole_s, whole_e, whole_slides
                return k, 2
            if taken > small:
                past[:] = 0.0  # an impact is no acceleration
            time += step
        if basic[0, BED] < np.inf:
            place(a, b, faces, x, tolerance, now)
            energy[ELASTIC] = strain_energy(now, basic, shear, size)
        xs[k + 1], vs[k + 1], es[k + 1] = x, v, energy
        fs[k + 1] = resultants
        far = 0.0
        for i in range(n):
            way = np.hypot(x[i, 0] - begun[i, 0], x[i, 1] - begun[i, 1]) + radius[i] * abs(
                x[i, 2] - begun[i, 2]
            )
            far = max(far, way)
        if far > margin:
            return k + 1, 1
    return steps, 0
