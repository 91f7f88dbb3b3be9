"""The two iterations of the Newton solver (see newton) in plain NumPy: from contact states, and from the inside.

`compiled_iterations` has the same ones for numba. Arguments as in kernels, rows in the order of elimination; `runs`:
the contact points between the same two blocks (see runs.Runs); `stored` is work space for a matrix of that `pattern`
(see elimination); `scale`: weight, size and step of the program, and the certificate that is accepted. Both write the
displacements x (m,) and contact forces (c, 2) that they find, and return the number of factorisations and the
residuals (as kernels.residuals), infinite where nothing is found.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import lapack

from mechanics.block import Array
from mechanics.joints import Index
from mechanics.solvers import kernels
from mechanics.solvers.elimination import Elimination, Pattern
from mechanics.solvers.kernels import OPEN, SLIDING_BACK, SLIDING_ON, STICKING, Residuals
from mechanics.solvers.runs import Runs

CORRECTIONS = 7  # of the contact states
MOST_ITERATIONS = 40  # from the inside
TO_THE_BOUND = 0.995  # share of the way to the cone that a step goes
PROXIMAL = 1e6  # stiffness that stands for a rigid contact, per scaled mass: one or two rounds make it exact
STATES = np.array([[OPEN, SLIDING_BACK], [SLIDING_ON, STICKING]])  # by which of its rays bear
LIKELY = 2e2  # accepted complementarities: products s z beyond them are not worth the look

NONE = (np.inf, np.inf, np.inf, np.inf)


def handed(layout: Elimination) -> Pattern:
    """What the functions here take for the pattern of a matrix."""
    return layout.pattern


def worst(residuals: Residuals, weight: float, step: float) -> float:
    """The largest residual, as Certificate.worst."""
    unbalanced, cone, power, penetration = residuals
    if not power < np.inf:  # a maximum passes over what is no number, a sum does not
        return np.inf
    return max(
        unbalanced / weight, cone / weight, power / (weight * step) / 100.0, penetration / step / 100.0
    )


def factorise(stored: Array, pattern: Pattern) -> bool:
    """The factor L of LLᵀ in place of a positive definite matrix; False where it is none."""
    _, failed = lapack.dpbtrf(stored.reshape(-1, pattern.places).T, lower=1, overwrite_ab=1)
    return not failed


def substitute(stored: Array, pattern: Pattern, x: Array) -> None:
    """The solution of LLᵀx = b in place of b (m,)."""
    x[:] = lapack.dpbtrs(stored.reshape(-1, pattern.places).T, x, lower=1)[0]


def semismooth(
    row: Index, normal: Array, tangent: Array, gap: Array, friction: Array, compliance: Array, mass: Array,
    load: Array, x: Array, forces: Array, state: Index, stored: Array, pattern: Pattern,
    scale: tuple[float, float, float, float], many: int,
) -> tuple[int, Residuals]:  # fmt: skip
    """From known contact states (c,), corrected in place; nothing where a step changes more than `many` of them."""
    weight, size, step, accepted = scale
    rows = (row, normal, tangent)
    mobility = np.where(row >= 0, 1.0 / mass[row], 0.0).sum(axis=1)
    extra = np.where(compliance > 0.0, 0.0, mobility[:, None] / PROXIMAL)
    soft, centred = compliance + extra, gap - extra * forces
    found, total, kept, at = np.empty_like(forces), np.empty_like(load), state.copy(), x.copy()
    kernels.contact_law(*rows, centred, friction, soft, at, kept, found, total)
    # where joints are elastic the last states tell more than a guess of the slip; rigid ones need the forces
    state[:] = np.where(compliance[:, 0] > 0.0, state, kept)
    kernels.repeat_forces(*rows, centred, friction, soft, at, state, found, total)
    changes, factorisations, good = 1, 0, NONE
    for correction in range(CORRECTIONS):
        if changes:
            kernels.repeat_matrix(*rows, friction, soft, mass, state, stored, pattern)
            factorisations += 1
            if not factorise(stored, pattern):
                return factorisations, NONE
        dx = load + total - mass * at
        substitute(stored, pattern, dx)
        if changes and correction:
            dx *= kernels.line_search(*rows, centred, friction, soft, mass, load, at, dx)
        at += dx
        changes = kernels.contact_law(*rows, centred, friction, soft, at, state, found, total)
        here = kernels.residuals(*rows, gap, friction, compliance, mass, load, at, found, size)
        if worst(here, weight, step) <= accepted:
            again = good[0] < np.inf
            x[:], forces[:], kept[:], good = at, found, state, here
            if again or changes:
                return factorisations, good
        if changes > many:
            return factorisations, NONE
        if not changes:
            # right but for the compliance that stands for none: with its centre in the forces found, exact
            centred = gap - extra * found
            changes = kernels.contact_law(*rows, centred, friction, soft, at, state, found, total)
            if good[0] < np.inf and changes:
                break
    state[:] = kept
    return factorisations, good


def interior(
    row: Index, normal: Array, tangent: Array, gap: Array, friction: Array, compliance: Array, mass: Array,
    load: Array, x: Array, forces: Array, s: Array, z: Array, state: Index, runs: Runs, stored: Array, pattern: Pattern,
    scale: tuple[float, float, float, float],
) -> tuple[int, Residuals]:  # fmt: skip
    """From forces s and gaps z (c, 2) along the rays of the friction cones, all positive, left at those found.

    The contact states (c,) are told by the rays that bear more than they are apart, per weight and step.

    A primal-dual interior point method (Mehrotra): the best certificate met is returned, at the first that is accepted.
    """
    weight, size, step, accepted = scale
    c, rows = len(row), (row, normal, tangent)
    n = 1.0 / np.hypot(1.0, friction)
    ray = np.stack([n, friction * n], axis=1)
    law = (ray, compliance)
    u, du, ds, dz, found = (np.empty((c, 2)) for _ in range(5))
    inverse, dx, product, at = np.empty((c, 3)), np.empty_like(load), s * z, x.copy()
    kernels.opening(*rows, gap, at, u)
    best, iteration = NONE, 0
    while iteration < MOST_ITERATIONS:
        iteration += 1
        kernels.interior_matrix(*rows, *law, mass, s, z, inverse, stored, pattern)
        if not factorise(stored, pattern):
            break
        point = (u, s, z, product, inverse)
        for corrects in (False, True):
            kernels.interior_rhs(*rows, *law, mass, load, at, *point, dx)
            substitute(stored, pattern, dx)
            reach = kernels.interior_step(*rows, *law, *point, dx, du, ds, dz)
            if not corrects:
                kernels.interior_centre(s, z, ds, dz, *reach, product)
        share = min(1.0, TO_THE_BOUND * min(reach))
        at += share * dx
        kernels.interior_advance(share, ray, u, s, z, du, ds, dz, product, found)
        if product.sum() <= LIKELY * accepted * weight * step or iteration == MOST_ITERATIONS:
            here = kernels.residuals(*rows, gap, friction, compliance, mass, load, at, found, size)
            if worst(here, weight, step) < worst(best, weight, step):
                x[:], forces[:], best = at, found, here
            if worst(best, weight, step) <= accepted:
                break
    state[:] = STATES[tuple((s * step > z * weight).T.astype(np.intp))]
    return iteration, best
