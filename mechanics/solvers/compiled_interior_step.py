"""An iteration of the static interior-point method, compiled by numba: the residuals of an iterate, the step from it.

The unknowns are Δx, α, the forces s ≥ 0 along the rays of the friction cones and their gaps z ≥ 0, both (c, 2); s and z
are eliminated, which leaves three rows a block in a sparse matrix, bordered by α. Proximal terms, whose centre is the
iterate itself, bound the stiffness of closed contacts and hold blocks that nothing holds, without a trace in the
solution. `posed`: row, normal, tangent, gap, friction and compliance of the contact points, as in `compiled`, and their
runs (see runs); `scale`: weight, size and step of the program; `stored`: work space for a matrix whose pattern is
`packed` (see elimination); `lateral` (m,): the load that α multiplies, empty where there is none.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.block import Array
from mechanics.joints import Index
from mechanics.solvers.cholesky import factorise, substitute
from mechanics.solvers.compiled import compiled
from mechanics.solvers.compiled_columns import (
    changes_with,
    columns,
    corrected,
    lacking,
    matrix,
    points_of,
    right_hand_side,
    work_space,
)
from mechanics.solvers.compiled_pattern import unpacked
from mechanics.solvers.compiled_runs import pack
from mechanics.solvers.kernels import Residuals
from mechanics.solvers.runs import Runs

STIFFEST = 1e12  # of closed contacts, per weight and step
HOLDING = 1e-9  # stiffness that holds blocks, per weight and step
FIRMER, FIRM = 10.0, 1.0  # its growth where the matrix is not definite, and its most
LOW, HIGH = 0.1, 10.0  # products s z outside this range about their target are corrected once
TO_THE_BOUND = 0.995  # share of the way to the bounds that an iteration goes
TO_AND_FRO = -0.3  # of a step: its return that asks for a shorter one
TINY = 1e-300
RESTORATIONS = 2
LEAST = 0.5  # share of a force that a restoration leaves

Posed = tuple[Index, Array, Array, Array, Array, Array, Runs]


@compiled
def measured(posed: Any, load: Array, x: Array, s: Array, z: Array, size: float) -> tuple[Residuals, Any]:
    """The residuals of an iterate: unbalanced force, |cᵀw|, penetration and the mean of s z; and what `advance` needs.

    The latter: the contact points packed into runs and columns, the residuals of the gaps along the rays, z − Rᵀw, and
    of equilibrium.
    """
    row, normal, tangent, gap, friction, compliance, runs = posed
    lever, arm, law = pack(row, normal, tangent, friction, compliance, runs)
    along, apart, work = columns(s, runs), columns(z, runs), work_space(runs)
    r, short = np.empty_like(along), load.copy()
    lacking(runs, lever, arm, law, columns(gap, runs), x, along, apart, r, work, short)
    unbalanced, power, penetration, product = 0.0, 0.0, 0.0, 0.0
    for i in range(len(short)):
        unbalanced = max(unbalanced, abs(short[i]) / (size if i % 3 == 2 else 1.0))
    for k in range(len(s)):
        first, second = apart[0, k] - r[0, k], apart[1, k] - r[1, k]
        power += abs(along[0, k] * first + along[1, k] * second)
        penetration = max(penetration, -min(first, second) / law[0, k])
        product += along[0, k] * apart[0, k] + along[1, k] * apart[1, k]
    lack = (lever, arm, law, r, short, along, apart)
    return (unbalanced, power, penetration, product / max(2 * len(s), 1)), lack


@compiled
def advance(
    posed: Any, lack: Any, lateral: Array, work: float, scale: Any, holding: float, x: Array, alpha: float, s: Array,
    z: Array, last: Array, stored: Array, packed: Any,
) -> tuple[bool, float, float]:  # fmt: skip
    """One step of the iterate, x, s, z and `last`, the step in x (m,), in place; whether there is one, α and `holding`.

    `lack`: what `measured` returned; `work`: that of the lateral load in x after the step. Predictor and corrector
    (Mehrotra), and one more corrector for products that would leave their range (Gondzio). There is no step where
    rounding makes the matrix indefinite even with the firmest hold.
    """
    pattern = unpacked(packed)
    lever, arm, law, r, short, along, apart = lack
    runs, c = posed[6], len(s)
    weight, size, step = scale
    unit = step / weight
    elastic = law[2:].max() > 0.0 if c else False
    law[2:] += law[:2] ** 2 * (unit / STIFFEST)
    inverse, room, held = np.empty((5, c)), work_space(runs), np.empty_like(x)
    while True:
        held[:] = holding / unit
        held[2::3] *= size**2
        matrix(runs, lever, arm, law, held, along, apart, inverse, room, stored, pattern)
        if factorise(stored, pattern):
            break
        if holding >= FIRM:
            return False, alpha, holding
        holding *= FIRMER
    swayed = lateral.copy()
    substitute(stored, pattern, swayed)
    gives = _dot(lateral, swayed)
    p = along * apart
    dx, ds, dz = np.empty_like(x), np.empty_like(r), np.empty_like(r)
    dx2, ds2, dz2 = np.empty_like(x), np.empty_like(r), np.empty_like(r)
    system = (runs, lever, arm, law, r, p, inverse, short, along, apart, room)
    border = (lateral, swayed, gives, work, x)
    _, force, gap, left = _change(system, border, elastic, stored, pattern, dx, ds, dz)
    now = p.sum()
    target = (left / now) ** 3 * now / (2 * c)
    corrected(p.ravel(), ds.ravel(), dz.ravel(), target)
    dalpha, force, gap, _ = _change(system, border, elastic, stored, pattern, dx, ds, dz)
    if min(force, gap) < 1.0:
        to_force, to_gap = min(1.0, 1.5 * force + 0.1), min(1.0, 1.5 * gap + 0.1)
        for e in range(2):
            for k in range(c):
                strayed = (along[e, k] + to_force * ds[e, k]) * (apart[e, k] + to_gap * dz[e, k])
                wanted = min(max(strayed, LOW * target), HIGH * target)
                p[e, k] -= max(wanted - strayed, -HIGH * target)
        dalpha2, force2, gap2, _ = _change(system, border, elastic, stored, pattern, dx2, ds2, dz2)
        if min(force2, gap2) > min(force, gap):
            dalpha, force, gap = dalpha2, force2, gap2
            dx, ds, dz = dx2, ds2, dz2
    force, gap = min(1.0, TO_THE_BOUND * force), min(1.0, TO_THE_BOUND * gap)
    # where the geometry of one iteration and the next send the blocks to and fro, they meet in between
    returns = _dot(dx, last) / max(_dot(last, last), TINY)
    if returns < TO_AND_FRO:
        gap /= 1.0 - max(returns, -1.0)
    for i in range(len(x)):
        last[i] = gap * dx[i]
        x[i] += last[i]
    along += force * ds
    apart += gap * dz
    points_of(along, runs, s)
    points_of(apart, runs, z)
    return True, alpha + force * dalpha, holding


@compiled
def _dot(a: Array, b: Array) -> float:
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@compiled
def _change(
    system: Any, border: Any, elastic: bool, stored: Array, pattern: Any, dx: Array, ds: Array, dz: Array
) -> tuple[float, float, float, float]:
    """The step that takes the products s z to s z − p: that of α, how far it leads, and the sum of s z there."""
    runs, lever, arm, law, r, p, inverse, short, s, z, room = system
    lateral, swayed, gives, work, x = border
    right_hand_side(runs, lever, arm, law, r, p, inverse, short, room, dx)
    substitute(stored, pattern, dx)
    dalpha = 0.0
    if len(lateral):
        dalpha = (work - _dot(lateral, x) - _dot(lateral, dx)) / gives
        dx += dalpha * swayed
    force, gap, zds, sdz, both = changes_with(runs, lever, arm, law, s, z, r, p, inverse, dx, ds, dz, room)
    if elastic:  # compliance ties gaps to forces
        force = gap = min(force, gap)
    return dalpha, force, gap, _dot(s.ravel(), z.ravel()) + force * zds + gap * sdz + force * gap * both


@compiled
def restore(
    posed: Any, load: Array, lateral: Array, scale: Any, s: Array, alpha: float, stored: Array, packed: Any
) -> float:
    """Change forces s in place, and the α returned, by the least shares of themselves that restore equilibrium."""
    pattern = unpacked(packed)
    row, normal, tangent, _, friction, compliance, runs = posed
    lever, arm, law = pack(row, normal, tangent, friction, np.zeros_like(compliance), runs)
    weight, size, _ = scale
    inverse, room, along = np.empty((5, len(s))), work_space(runs), columns(s, runs)
    held = np.full(len(load), HOLDING * weight)
    held[2::3] *= size**2
    matrix(runs, lever, arm, law, held, along, weight / along, inverse, room, stored, pattern)
    if not factorise(stored, pattern):
        return alpha
    swayed = lateral.copy()
    substitute(stored, pattern, swayed)
    gives, still, nothing = _dot(lateral, swayed), np.zeros_like(along), np.zeros_like(load)
    share, y = np.empty_like(along), np.empty_like(load)
    for _ in range(RESTORATIONS):
        y[:] = load
        if len(lateral):
            y += alpha * lateral
        lacking(runs, lever, arm, law, still, nothing, along, still, share, room, y)
        substitute(stored, pattern, y)
        if len(lateral):
            more = -_dot(lateral, y) / gives
            alpha += more
            y += more * swayed
        lacking(runs, lever, arm, law, still, y, still, still, share, room, nothing)
        for e in range(2):
            for k in range(len(s)):
                along[e, k] *= max(1.0 + along[e, k] / weight * share[e, k], LEAST)
    points_of(along, runs, s)
    return alpha
