"""The gaps and slips that the joints of a step count from, and what its end leaves of them.

Elastic joints: of a fibre of the bed that is closed the force is −k(w₀ + θΔw), of one that closes within the step
−kθ(w₀ + Δw); dashpots add −kβΔw/h. In one: −k(θ + β/h)(Δw + g), where g is w₀/(θ + β/h) at an end that is closed and w₀
at one that closes.

No step leaves a bed deeper than its forces pressed it, nor with more stored than was done on it (it may give more):
where the blocks come closer than that, by the geometry of the step or a slide that stops, the bed has `sunk` until they
part. Otherwise a stiff bed would turn an error of microns in a gap into an impact.

Ties that yield stay `LONGER`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.kernels.bed import pressed, stored
from mechanics.kernels.dynamics.motion import (
    GAPS,
    GONE,
    LONGER,
    RATE,
    SPEED,
    SPRING,
    SUNK,
    elastic_beds,
    relative,
)
from mechanics.kernels.jit import compiler
from mechanics.kernels.joint import PHI, TIED, H, U, V, place
from mechanics.kernels.law import BED, FRICTION, SHEAR, SLID, STRENGTH
from mechanics.types import Array

compiled = compiler("contract", "reassoc")

NEWTON = 30  # iterations for the gap at which a bed stores what was done on it
CLOSED = 1e-6  # of the block size: a gap that is none


@compiled
def placed(a: Any, b: Any, faces: Array, x: Array, joints: Array, places: Array) -> None:
    """Where the joints are at positions x (b, 3), into `places` (j, PLACE); ties as long as they have become."""
    place(a, b, faces, x, places)
    places[:, U] += joints[:, LONGER]


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
    """Set u and φ of an elastic joint at a place p so that its ends have the gaps g, see above.

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
    a: Any, b: Any, start: Array, v: Array, joints: Array, basic: Array, h: float, theta: float, beta: float,
    restitution: float, size: float, places: Array, law: Array, back: Array,
) -> Any:  # fmt: skip
    """Return which joints (i,) overlap in a step; `places` get the gaps of the start with the rows of the middle.

    `law` (j, LAW) becomes that of the step; `back` (j,) m: the lift of slides that is subtracted.
    """
    # many arguments: arrays one by one, see mechanics.kernels
    elastic, count = elastic_beds(basic), 0
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
def sunk(
    start: Array, end: Array, basic: Array, closest: Array, done: Array, joints: Array, size: float
) -> tuple[float, float]:
    """What beds store more at the end of a step than at its start, and what ties took that yielded (kNm).

    SUNK and LONGER of the `joints` become those of the end. `start`, `end` (j, PLACE); `closest` (j,) m: the least gap
    that the forces of the step led to; `done` (j,) kNm: the work that was done on each bed, less what yielding took.
    """
    more, plastic = 0.0, 0.0
    for k in range(len(start)):
        s, e, stiffness, before = start[k], end[k], basic[k, BED], 0.0
        if s[H] > GONE * size:
            before = stored(s[U] - joints[k, SUNK], s[PHI], s[H], stiffness)
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
            if stored(u, e[PHI], e[H], stiffness) > before + done[k]:
                u = _storing(u, e[PHI], e[H], stiffness, before + done[k])
            joints[k, SUNK] = e[U] - u
            more += stored(u, e[PHI], e[H], stiffness)
    return more, plastic
