"""The iterations of `iterations`, compiled by numba: same names, arguments and results."""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.block import Array
from mechanics.solvers.cholesky import factorise, solve, substitute
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
from mechanics.solvers.compiled_pattern import handed, unpacked
from mechanics.solvers.compiled_runs import pack
from mechanics.solvers.iterations import (
    CORRECTIONS,
    LIKELY,
    MOST_ITERATIONS,
    NONE,
    PROXIMAL,
    STATES,
    TO_THE_BOUND,
    worst,
)
from mechanics.solvers.kernels import Residuals
from mechanics.solvers.meeting import share_of, together

__all__ = ["factorise", "handed", "interior", "semismooth", "substitute"]

_worst: Any = compiled(worst)


@compiled
def semismooth(
    row: Any, normal: Array, tangent: Array, gap: Array, friction: Array, compliance: Array, mass: Array,
    load: Array, x: Array, forces: Array, state: Any, stored: Array, packed: Any, scale: Any, many: int,
    shared: Any = None,
) -> tuple[int, Residuals]:  # fmt: skip
    """See iterations.semismooth; of a half of the model where `shared` is told (see meeting)."""
    pattern = unpacked(packed)
    weight, size, step, accepted = scale
    soft, centred, extra = np.empty_like(gap), np.empty_like(gap), np.zeros_like(gap)
    for k in range(len(row)):
        mobility = 0.0
        for side in range(2):
            if row[k, side] >= 0:
                mobility += share_of(shared, row[k, side], len(mass)) / mass[row[k, side]]
        for e in range(2):
            if compliance[k, e] == 0.0:
                extra[k, e] = mobility / PROXIMAL
            soft[k, e] = compliance[k, e] + extra[k, e]
            centred[k, e] = gap[k, e] - extra[k, e] * forces[k, e]
    found, total, kept, at = np.empty_like(forces), np.empty_like(load), state.copy(), x.copy()
    contact_law(row, normal, tangent, centred, friction, soft, at, kept, found, total)
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
            if not solve(stored, pattern, dx, shared):
                return factorisations, NONE
        else:
            substitute(stored, pattern, dx, shared)
        if changes and correction:
            dx *= line_search(row, normal, tangent, centred, friction, soft, mass, load, at, dx, shared)
        at += dx
        changes = _all(
            shared, contact_law(row, normal, tangent, centred, friction, soft, at, state, found, total)
        )
        here = residuals(row, normal, tangent, gap, friction, compliance, mass, load, at, found, size, shared)
        if _worst(here, weight, step) <= accepted:
            again = good[0] < np.inf
            x[:], forces[:], kept[:], good = at, found, state, here
            if again or changes:
                return factorisations, good
        if changes > many:
            return factorisations, NONE
        if not changes:
            centred = gap - extra * found
            changes = _all(
                shared, contact_law(row, normal, tangent, centred, friction, soft, at, state, found, total)
            )
            if good[0] < np.inf and changes:
                break
    state[:] = kept
    return factorisations, good


@compiled
def _all(shared: Any, count: int) -> int:
    """Of both halves."""
    (counted,) = together(shared, (float(count),))
    return int(counted)


@compiled
def interior(
    row: Any, normal: Array, tangent: Array, gap: Array, friction: Array, compliance: Array, mass: Array,
    load: Array, x: Array, forces: Array, s: Array, z: Array, state: Any, runs: Any, stored: Array, packed: Any,
    scale: Any, shared: Any = None,
) -> tuple[int, Residuals]:  # fmt: skip
    """See iterations.interior; of a half of the model where `shared` is told (see meeting).

    In exact arithmetic a step of a share of the way leaves the rest of the linear residuals: `short` of equilibrium and
    `r` of z, which are therefore not computed again.
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
    rays, product = together(shared, (2.0 * c, p.sum()))
    at, found, best, iteration = x.copy(), np.empty_like(forces), NONE, 0
    while iteration < MOST_ITERATIONS:
        iteration += 1
        matrix(runs, lever, arm, law, mass, along, apart, inverse, work, stored, pattern)
        right_hand_side(runs, lever, arm, law, r, p, inverse, short, work, dx)
        if not solve(stored, pattern, dx, shared):
            break
        to_force, to_gap, zds, sdz, both = changes_with(
            runs, lever, arm, law, along, apart, r, p, inverse, dx, ds, dz, work, shared
        )
        ahead = product + to_force * zds + to_gap * sdz + to_force * to_gap * both
        corrected(p.ravel(), ds.ravel(), dz.ravel(), (ahead / product) ** 3 * product / rays)
        right_hand_side(runs, lever, arm, law, r, p, inverse, short, work, dx)
        substitute(stored, pattern, dx, shared)
        reach = changes_with(runs, lever, arm, law, along, apart, r, p, inverse, dx, ds, dz, work, shared)
        share = min(1.0, TO_THE_BOUND * min(reach[0], reach[1]))
        left = advance(share, along.ravel(), apart.ravel(), ds.ravel(), dz.ravel(), r.ravel(), p.ravel())
        (product,) = together(shared, (left,))
        at += share * dx
        short *= 1.0 - share
        if product <= LIKELY * accepted * weight * step or iteration == MOST_ITERATIONS:
            for k in range(c):
                i = runs.column[k]
                found[k, 0] = law[0, i] * (along[0, i] + along[1, i])
                found[k, 1] = law[1, i] * (along[0, i] - along[1, i])
            here = residuals(
                row, normal, tangent, gap, friction, compliance, mass, load, at, found, size, shared
            )
            if _worst(here, weight, step) < _worst(best, weight, step):
                x[:], forces[:], best = at, found, here
            if _worst(best, weight, step) <= accepted:
                break
    points_of(along, runs, s)
    points_of(apart, runs, z)
    for k in range(c):
        state[k] = STATES[int(s[k, 0] * step > z[k, 0] * weight), int(s[k, 1] * step > z[k, 1] * weight)]
    return iteration, best
