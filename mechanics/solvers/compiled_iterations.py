"""The two iterations of the Newton solver (see newton), compiled by numba: from contact states, and from the inside.

Arguments as in `compiled`, rows in the order of elimination; `runs`: the contact points between the same two blocks
(see runs.Runs); `stored`: work space for a matrix whose pattern is `packed` (see elimination); `scale`: weight, size
and step of the program, and the certificate that is accepted. Both write the displacements x (m,) and contact forces
(c, 2) that they find, and return the number of factorisations and the residuals (as compiled.residuals), infinite where
nothing is found.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.block import Array
from mechanics.solvers.cholesky import solve, substitute
from mechanics.solvers.compiled import (
    compiled,
    contact_law,
    line_search,
    repeat_forces,
    repeat_matrix,
    residuals,
)
from mechanics.solvers.compiled_columns import (
    advance,
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
from mechanics.solvers.kernels import OPEN, SLIDING_BACK, SLIDING_ON, STICKING, Residuals, worst

CORRECTIONS = 7  # of the contact states
MOST_ITERATIONS = 40  # from the inside
TO_THE_BOUND = 0.995  # share of the way to the cone that a step goes
PROXIMAL = 1e6  # stiffness that stands for a rigid contact, per scaled mass: one or two rounds make it exact
STATES = np.array([[OPEN, SLIDING_BACK], [SLIDING_ON, STICKING]])  # by which of its rays carry
LIKELY = 2e2  # accepted complementarities: while the sum of s z is larger, the residuals are not computed
NONE = (np.inf, np.inf, np.inf, np.inf)  # residuals where nothing is found

_worst: Any = compiled(worst)


@compiled
def semismooth(
    row: Any, normal: Array, tangent: Array, gap: Array, friction: Array, compliance: Array, mass: Array,
    load: Array, x: Array, forces: Array, state: Any, stored: Array, packed: Any, scale: Any, many: int,
) -> tuple[int, Residuals]:  # fmt: skip
    """From known contact states (c,), corrected in place; given up where a step changes more than `many` of them.

    A semismooth Newton method: the stiffness of the contact states, an exact line search. Rigid contacts get a small
    compliance whose centre is the force found; with the centre moved there, the solution is exact.
    """
    pattern = unpacked(packed)
    weight, size, step, accepted = scale
    soft, centred, extra = np.empty_like(gap), np.empty_like(gap), np.zeros_like(gap)
    for k in range(len(row)):
        mobility = 0.0
        for side in range(2):
            if row[k, side] >= 0:
                mobility += 1.0 / mass[row[k, side]]
        for e in range(2):
            if compliance[k, e] == 0.0:
                extra[k, e] = mobility / PROXIMAL
            soft[k, e] = compliance[k, e] + extra[k, e]
            centred[k, e] = gap[k, e] - extra[k, e] * forces[k, e]
    found, total, kept, at = np.empty_like(forces), np.empty_like(load), state.copy(), x.copy()
    contact_law(row, normal, tangent, centred, friction, soft, at, kept, found, total)
    # where joints are elastic the last states tell more than a guess of the slip; rigid ones need the forces
    for k in range(len(row)):
        if compliance[k, 0] == 0.0:
            state[k] = kept[k]
    repeat_forces(row, normal, tangent, centred, friction, soft, at, state, found, total)
    changes, factorisations, good = 1, 0, NONE
    dx = np.empty_like(load)
    for correction in range(CORRECTIONS):
        for i in range(len(x)):
            dx[i] = load[i] + total[i] - mass[i] * at[i]
        if changes:
            repeat_matrix(row, normal, tangent, friction, soft, mass, state, stored, pattern)
            factorisations += 1
            if not solve(stored, pattern, dx):
                return factorisations, NONE
        else:
            substitute(stored, pattern, dx)
        if changes and correction:
            dx *= line_search(row, normal, tangent, centred, friction, soft, mass, load, at, dx)
        at += dx
        changes = contact_law(row, normal, tangent, centred, friction, soft, at, state, found, total)
        here = residuals(row, normal, tangent, gap, friction, compliance, mass, load, at, found, size)
        if _worst(here, weight, step) <= accepted:
            again = good[0] < np.inf
            x[:], forces[:], kept[:], good = at, found, state, here
            if again or changes:
                return factorisations, good
        if changes > many:
            return factorisations, NONE
        if not changes:
            # right but for the compliance that stands for none: with its centre in the forces found, exact
            centred = gap - extra * found
            changes = contact_law(row, normal, tangent, centred, friction, soft, at, state, found, total)
            if good[0] < np.inf and changes:
                break
    state[:] = kept
    return factorisations, good


@compiled
def interior(
    row: Any, normal: Array, tangent: Array, gap: Array, friction: Array, compliance: Array, mass: Array,
    load: Array, x: Array, forces: Array, s: Array, z: Array, state: Any, runs: Any, stored: Array, packed: Any,
    scale: Any,
) -> tuple[int, Residuals]:  # fmt: skip
    """From forces s and gaps z (c, 2) along the rays of the friction cones, all positive, left at those found.

    The contact states (c,) follow from the rays whose force, per weight, exceeds their gap, per step. A primal-dual
    interior point method (Mehrotra): it returns at the first certificate that is accepted, otherwise the best one met.
    In exact arithmetic a share of a step leaves the rest of the linear residuals, `short` of equilibrium and `r` of z:
    they are not computed again.
    """
    pattern = unpacked(packed)
    weight, size, step, accepted = scale
    c = len(row)
    lever, arm, law = pack(row, normal, tangent, friction, compliance, runs)
    along, apart, work = columns(s, runs), columns(z, runs), work_space(runs)
    r, short = np.empty((2, c)), load - mass * x
    lacking(runs, lever, arm, law, columns(gap, runs), x, along, apart, r, work, short)
    p, ds, dz = along * apart, np.empty_like(r), np.empty_like(r)
    inverse, dx = np.empty((5, c)), np.empty_like(x)
    rays, product = 2.0 * c, p.sum()
    at, found, best, iteration = x.copy(), np.empty_like(forces), NONE, 0
    while iteration < MOST_ITERATIONS:
        iteration += 1
        matrix(runs, lever, arm, law, mass, along, apart, inverse, work, stored, pattern)
        right_hand_side(runs, lever, arm, law, r, p, inverse, short, work, dx)
        if not solve(stored, pattern, dx):
            break
        to_force, to_gap, zds, sdz, both = changes_with(
            runs, lever, arm, law, along, apart, r, p, inverse, dx, ds, dz, work
        )
        ahead = product + to_force * zds + to_gap * sdz + to_force * to_gap * both
        corrected(p.ravel(), ds.ravel(), dz.ravel(), (ahead / product) ** 3 * product / rays)
        right_hand_side(runs, lever, arm, law, r, p, inverse, short, work, dx)
        substitute(stored, pattern, dx)
        reach = changes_with(runs, lever, arm, law, along, apart, r, p, inverse, dx, ds, dz, work)
        share = min(1.0, TO_THE_BOUND * min(reach[0], reach[1]))
        product = advance(share, along.ravel(), apart.ravel(), ds.ravel(), dz.ravel(), r.ravel(), p.ravel())
        at += share * dx
        short *= 1.0 - share
        if product <= LIKELY * accepted * weight * step or iteration == MOST_ITERATIONS:
            for k in range(c):
                i = runs.column[k]
                found[k, 0] = law[0, i] * (along[0, i] + along[1, i])
                found[k, 1] = law[1, i] * (along[0, i] - along[1, i])
            here = residuals(row, normal, tangent, gap, friction, compliance, mass, load, at, found, size)
            if _worst(here, weight, step) < _worst(best, weight, step):
                x[:], forces[:], best = at, found, here
            if _worst(best, weight, step) <= accepted:
                break
    points_of(along, runs, s)
    points_of(apart, runs, z)
    for k in range(c):
        state[k] = STATES[int(s[k, 0] * step > z[k, 0] * weight), int(s[k, 1] * step > z[k, 1] * weight)]
    return iteration, best
