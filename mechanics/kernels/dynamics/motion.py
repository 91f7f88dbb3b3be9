"""The state of a motion as the compiled loops keep it: the gaps and slips that a step counts from, and those it leaves.

Elastic joints: of a fibre of the bed that is closed the force is −k(w₀ + θΔw), of one that closes within the step
−kθ(w₀ + Δw). Dashpots act in contact: they add −kβ/h times what the closed part of the way is, Δw or w₀ + Δw. In one:
−k(θ + β/h)(Δw + g), where g = c w₀, c = 1/(θ + β/h), of a fibre that is closed and g = w₀ of one that closes. Where
c < 1 that is g = c w₀ + ⟨(1 − c)w₀⟩: of a joint that is open at one end the bed begins above the line (1 − c)w₀, as one
that has been crushed above those that crushing left. Where c ≥ 1 a fibre that is pressed closes within the step anyway,
and g is linear between the ends.

A bed that has been crushed begins where that has left it (bed): what counts as closed is the gap to there.

No step leaves a bed deeper than its forces pressed it, nor with more stored than was done on it (it may give more):
where the blocks come closer than that, by the geometry of the step or a slide that stops, the bed has `sunk` until they
part. Otherwise a stiff bed would turn an error of microns in a gap into an impact.

Ties that yield stay `LONGER`.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np

from mechanics.kernels.bed import LINES, highest, leave
from mechanics.kernels.jit import compiled
from mechanics.kernels.joint import PHI, PLACE, TIED, H, U, V, place
from mechanics.kernels.law import BED, DASHPOTS, LEFT, SEGMENTS, SHEAR, SLID, STRENGTH, bed_forces, bed_work
from mechanics.kernels.matrix import moved_by
from mechanics.types import Array

# where the energy of a motion is (energy, 8): stored in springs; taken by friction, impacts, dashpots and the
# stepping; put in; the largest kinetic energy so far, by which what steps take is measured; and that of friction which
# slides that turn back within steps leave uncertain
ELASTIC, FRICTION_WORK, IMPACT, VISCOUS, STEPPING, INPUT, LARGEST, TURNED = range(8)
ENERGIES = 8
# columns of the state of a joint (joints, j × 25): N₁, N₂, T and y₁, y₂, λ₊, λ₋ of the last program; of rigid ones
# the same of its central iterate, gaps over the length of the step (program); spring in shear, kN; gap of the blocks
# less that of the bed, m; by how much a tie is longer than as it was made, m; what a bed remembers of having been
# crushed (law)
N1, GAPS, MIDDLE, SPRING, SUNK, LONGER, REMAINS = 0, 3, 7, 14, 15, 16, 17
JOINT = 25
STANDARD_GRAVITY = 9.80665  # m/s²
GONE = 1e-9  # of the block size: an overlap that is none
NEWTON = 30  # iterations for the gap at which a bed stores what was done on it
CLOSED = 1e-6  # of the block size: a gap that is none
# what does not change in a motion: joints (j,) between blocks `a` and `b`, `faces` (j, FACE), `basic` (j, LAW), `row`
# (j, 2) and `first` (b,) row of blocks, −1 of a support; `mass` (b, 3), `dead` load (b, 3) kN, `radius` (b,) m;
# `weight` and `size` of a mean block; the matrix
Structure = namedtuple("Structure", "a b faces basic row first mass dead radius weight size stored pattern")
# how it is computed: in steps of `h` (s), at whose share `theta` the equations hold; `beta` (s): viscous contact force
# over the stiffness and the rate of the gap; `restitution` of velocities at which rigid ends meet; `accepted` residual
# of a program, per weight and span. A step is halved down to `levels` where it takes, or leaves unsure, more than a
# `share` of the largest kinetic energy so far, or of that `of_moment`, down to `most` where it is not solved. `unsure`:
# share of the kinetic energy by which velocities may be wrong, 0: as little as at rest. `margin` (m): how far a corner
# may go before contacts are looked for anew
Scheme = namedtuple("Scheme", "h theta beta restitution accepted levels share most unsure of_moment margin")
# `blocks` (4, b, 3): positions, velocities, mean accelerations of the last step, velocities at which the next program
# begins; `joints` (j, JOINT); `energy` (ENERGIES,)
Moving = namedtuple("Moving", "blocks joints energy")


@compiled
def relative(p: Array, a: int, b: int, moved: Array) -> tuple[float, float, float]:
    """Changes of u, φ and v of a joint at p (PLACE,) under displacements (b, 3), with the lever of its place.

    As matrix.motion, whose displacements are in the order of elimination; a view of these by rows took 13 % of a step.
    """
    return moved_by(p, moved[a, 0], moved[a, 1], moved[a, 2], moved[b, 0], moved[b, 1], moved[b, 2])


@compiled
def crushable(p: Array, law: Array) -> bool:
    """Whether a joint at a place p (PLACE,) is a bed that can be crushed; ties yield: they stay `LONGER`."""
    return bool(law[STRENGTH] < np.inf and p[TIED] == 0.0)


@compiled
def work_on_bed(p: Array, u: float, law: Array, joint: Array) -> float:
    """The work (kNm) that presses the bed of a joint at a place p (PLACE,) to the gap u at its middle."""
    strength = law[STRENGTH] if crushable(p, law) else np.inf
    return bed_work(law, strength, joint[REMAINS:], p[H], u, p[PHI])


@compiled
def bed_under(
    p: Array, u: float, phi: float, law: Array, joint: Array
) -> tuple[float, float, float, float, float]:
    """N, P and −∂N/∂u, −∂N/∂φ, −∂P/∂φ of the bed of a joint at a place p (PLACE,) under the gap u + φs."""
    strength = law[STRENGTH] if crushable(p, law) else np.inf
    return bed_forces(law, strength, joint[REMAINS:], p[H], u, phi)


@compiled
def remember(places: Array, law: Array, joints: Array, size: float) -> None:
    """Let the beds of `joints` at places (j, PLACE) remember as what they are there of having been crushed."""
    for k in range(len(places)):
        if places[k, H] > GONE * size and crushable(places[k], law[k]):
            u = places[k, U] - joints[k, SUNK]
            leave(u, places[k, PHI], places[k, H], law[k, BED], law[k, STRENGTH], joints[k, REMAINS:])


@compiled
def strain_energy(places: Array, law: Array, joints: Array, size: float) -> float:
    """Energy (kNm) stored in the beds at places (j, PLACE), and in springs in shear with the forces of `joints`."""
    total = 0.0
    for k in range(len(places)):
        if places[k, H] > GONE * size:
            total += work_on_bed(places[k], places[k, U], law[k], joints[k])
        total += 0.5 * law[k, SHEAR] * joints[k, SPRING] ** 2
    return total


@compiled
def elastic_beds(law: Array) -> bool:
    """Whether joints of the `law` (j, LAW) are elastic; none are not."""
    return len(law) > 0 and law[0, BED] < np.inf


@compiled
def placed(structure: Structure, x: Array, joints: Array) -> Array:
    """Where the joints are (j, PLACE) at positions x (b, 3); ties as long as they have become."""
    places = np.empty((len(joints), PLACE))
    place(structure.a, structure.b, structure.faces, x, places)
    places[:, U] += joints[:, LONGER]
    return places


@compiled
def _apart(gap: float, rate: float, closed: float, bounce: float) -> float:
    """The gap of an end that its velocity has to respect: blocks that lie in each other are not thrown apart.

    An end that would meet at its `rate` leaves at the share `bounce` of it: at once, not where it touches.
    """
    if bounce > 0.0 and gap + rate <= 0.0:
        return bounce * min(rate, 0.0)
    return gap if gap > closed else 0.0


@compiled
def _storing(p: Array, u: float, law: Array, joint: Array, most: float) -> float:
    """The gap, u or more, at the middle of a bed at a place p (PLACE,) that so much work leads to (Newton)."""
    if most <= 0.0:
        return max(u, p[H] * abs(p[PHI]))
    for _ in range(NEWTON):
        over = work_on_bed(p, u, law, joint) - most
        if over <= 1e-12 * most:
            break
        u += over / bed_under(p, u, p[PHI], law, joint)[0]
    return u


@compiled
def _begins(
    p: Array, s: Array, rate: tuple[float, float], h: float, closed: float, law: Array, joint: Array
) -> None:
    """Set u and φ of an elastic joint at a place p so that its ends have the gaps g, see above.

    `s` (PLACE,): at the start, where its gap changes at the `rate` (u, φ); `closed`: 1/(θ + β/h). The `law` (LAW,) of
    the step gets what crushing has left in it, scaled like the gaps, and the line of its dashpots.
    """
    low, high = p[U] - p[H] * p[PHI], p[U] + p[H] * p[PHI]
    first, second = 1.0, 1.0  # factors of the gaps of the ends
    left = joint[REMAINS:]
    bare_low = low + max(left[0], left[2], left[4], 0.0)
    bare_high = high + max(left[1], left[3], left[5], 0.0)
    narrow, wide = min(bare_low, bare_high), max(bare_low, bare_high)
    if narrow < 0.0:
        first, second = closed, closed
        side = 1.0 if bare_high > bare_low else -1.0
        if wide > 0.0 and closed < 1.0 and law[SEGMENTS] == 0.0:
            line = highest(-side * p[H] * (wide + narrow) / (wide - narrow), p[H], left)
            q_low, q_high = (left[2 * line], left[2 * line + 1]) if line < LINES else (0.0, 0.0)
            law[DASHPOTS] = (1.0 - closed) * low + q_low
            law[DASHPOTS + 1] = (1.0 - closed) * high + q_high
        elif wide > 0.0 and wide + h * (rate[0] + side * s[H] * rate[1]) <= 0.0:
            first, second = (1.0, closed) if bare_high < bare_low else (closed, 1.0)
        low, high = first * low, second * high
        p[U], p[PHI] = 0.5 * (low + high), 0.5 * (high - low) / p[H]
    for line in range(0, DASHPOTS - LEFT, 2):
        law[LEFT + line], law[LEFT + line + 1] = first * left[line], second * left[line + 1]


@compiled
def _rigid_gaps(
    p: Array, s: Array, a: int, b: int, v: Array, h: float, size: float, restitution: float
) -> None:
    """Set u and φ of a rigid joint at a place p to those that its velocity has to respect.

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
    structure: Structure, scheme: Scheme, moving: Moving, h: float, start: Array, places: Array, law: Array
) -> Any:
    """Return which joints (i,) overlap in a step; `places` get the gaps of the start with the rows of the middle.

    `law` (j, LAW) becomes that of the step.
    """
    a, b, basic, size = structure.a, structure.b, structure.basic, structure.size
    v, joints = moving.blocks[1], moving.joints
    elastic, count = elastic_beds(basic), 0
    stretch = scheme.theta + scheme.beta / h if elastic else 1.0
    active = np.empty(len(a), np.intp)
    for k in range(len(a)):
        p, s = places[k], start[k]
        p[U], p[PHI], p[V] = s[U] - joints[k, SUNK], s[PHI], s[V]
        p[H] = min(p[H], s[H])
        law[k, SLID] = s[V]
        if not elastic:
            _rigid_gaps(p, s, a[k], b[k], v, h, size, scheme.restitution)
        if p[H] <= GONE * size:
            joints[k, :GAPS] = 0.0
            continue
        active[count] = k
        count += 1
        if elastic:
            law[k, BED] *= stretch
            law[k, SHEAR] /= stretch
            law[k, SLID] += law[k, SHEAR] * joints[k, SPRING]
            u0, phi0, _ = relative(s, a[k], b[k], v)
            _begins(p, s, (u0, phi0), h, 1.0 / stretch, law[k], joints[k])
    return active[:count]


@compiled
def sunk(
    start: Array, end: Array, basic: Array, closest: Array, done: Array, joints: Array, size: float
) -> tuple[float, float]:
    """What beds store more at the end of a step than at its start, and what yielding took, of ties and of beds (kNm).

    SUNK, LONGER and REMAINS of the `joints` become those of the end. `start`, `end` (j, PLACE); `closest` (j,) m: the
    least gap that the forces of the step led to; `done` (j,) kNm: the work that was done on each bed, less what ties
    took.
    """
    more, plastic = 0.0, 0.0
    for k in range(len(start)):
        s, e, stiffness, before = start[k], end[k], basic[k, BED], 0.0
        if s[H] > GONE * size:
            before = work_on_bed(s, s[U] - joints[k, SUNK], basic[k], joints[k])
        more -= before
        if e[TIED] > 0.0:
            yielded = joints[k, SUNK] - e[U] - basic[k, STRENGTH] / stiffness
            if yielded > 0.0:
                e[U] += yielded
                joints[k, LONGER] += yielded
                done[k] -= yielded * basic[k, STRENGTH]
                plastic += yielded * basic[k, STRENGTH]
        joints[k, SUNK] = 0.0
        if e[H] > GONE * size:
            u = e[U] + max(min(closest[k], 0.0) - e[U] + e[H] * abs(e[PHI]), 0.0)
            work = work_on_bed(e, u, basic[k], joints[k])
            if work > before + done[k]:
                u = _storing(e, u, basic[k], joints[k], before + done[k])
                work = work_on_bed(e, u, basic[k], joints[k])
            joints[k, SUNK] = e[U] - u
            if crushable(e, basic[k]):
                leave(u, e[PHI], e[H], stiffness, basic[k, STRENGTH], joints[k, REMAINS:])
                stays = work_on_bed(e, u, basic[k], joints[k])
                plastic, work = plastic + work - stays, stays
            more += work
    return more, plastic
