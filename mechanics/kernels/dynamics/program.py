"""The program of a step: from where, and by which method, it is solved."""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.kernels.dynamics.newton import newton
from mechanics.kernels.interior.iteration import iterate
from mechanics.kernels.interior.joints import keep_within_strength
from mechanics.kernels.jit import compiled, looped
from mechanics.kernels.joint import CURVED, PHI, H, U

from mechanics.kernels.law import (  # isort: skip
    DASHPOTS, DILATION, FRICTION, LEFT, STEEP, STRENGTH, bed_forces, gaps_under, lift,
)  # fmt: skip
from mechanics.kernels.matrix import motion
from mechanics.types import Array

ROUGHLY = 1e-4  # missed per weight and span: the joints that slide are known
# per weight and span: products of forces and gaps near an earlier solution, of rigid and of elastic joints, with which
# the interior point is asked only where many have changed
CENTRAL_RIGID, CENTRAL_ELASTIC = 0.1, 1.0
# of rigid joints the program begins at the central iterate of the last one, the first with products and with forces
# missed by no more than these, and with no product of an end below LIFTED: they would drift to the bounds otherwise
CENTRAL, CENTRAL_FORCE, LIFTED = 0.1, 1e-2, 0.01
# the program of a step begins near the forces and gaps that joints had; where that leads nowhere from the gaps alone
NEAR, FROM_GAPS = range(2)
# by Coulomb's law the products may stop falling on the central path, of forces, per weight, and gaps that are right:
# they are accepted up to this, of blocks that move
STALLED_FORCE, STALLED = 1e-5, 1e-4
# what is not solved even so is solved with lift: that of the slips before is taken from the gaps, until they differ by
# less than this share of a span, in so many programs
RIGHT, ROUNDS = 0.1, 5
LINEAR = 3  # programs with beds without the lines of dashpots, each of which bears what the bed does where the last led
PRESSED = 1e-3  # of the weight: a joint whose lift counts
WITHIN = 0.98  # of the bound of friction: the most of a force there
COLD = 1.0  # per force that stops the blocks, and span: forces and gaps of a cold start
# iterations, and those without progress: of no literal type, for which the iteration would be compiled once more
LIMITS = (np.int64(60), np.int64(10))
LIMITS_COULOMB = (np.int64(60), np.int64(5))


@looped
def _begin_cold(at: Array, span: float, stops: float, f: Array, y: Array) -> None:
    """Forces and gaps where nothing is known of them but the gaps that are there, and a force that stops blocks."""
    for k in range(len(f)):
        for e in range(2):
            gap = at[k, U] + (2 * e - 1) * at[k, H] * at[k, PHI]
            y[k, e] = COLD * span + max(gap, 0.0)
            f[k, e] = stops * COLD * span / y[k, e]
        f[k, 2], y[k, 2], y[k, 3] = 0.0, COLD * span, COLD * span


@looped
def _part_evenly(weight: float, span: float, product: float, e: int, f: Array, y: Array) -> None:
    """Give force and gap of an end this product, per weight and span, at the same difference, both scaled."""
    carries = 0.5 * (f[e] / weight - y[e] / span)
    large = abs(carries) + np.sqrt(carries * carries + product)
    small = product / large
    f[e], y[e] = weight * small, span * large
    if carries > 0.0:
        f[e], y[e] = weight * large, span * small


@looped
def _within_friction(law: Array, weight: float, span: float, product: float, f: Array, y: Array) -> None:
    """Bring the force of friction within its bounds, and enlarge slips, up to the span, to the least product."""
    bound = min(law[FRICTION], STEEP) * (f[0] + f[1])
    f[2] = min(max(f[2], -WITHIN * bound), WITHIN * bound)
    for e in range(2):
        least = product * weight * span / (bound + (1 - 2 * e) * f[2])
        y[2 + e] = max(y[2 + e], min(least, span))


@looped
def _begin_near(laws: Array, weight: float, span: float, central: float, f: Array, y: Array) -> None:
    """Bring forces and gaps of an earlier solution within their bounds.

    The products of the ends become `central`, per weight and span: of an end that carries the gap becomes small, of one
    that is open the force; their difference, scaled, remains. Slips are enlarged, up to the span, to the same product;
    larger products stay.
    """
    for k in range(len(f)):
        for e in range(2):
            _part_evenly(weight, span, central, e, f[k], y[k])
        _within_friction(laws[k], weight, span, central, f[k], y[k])


@compiled
def _begin_central(
    laws: Array, weight: float, span: float, h: float, near: Array, f: Array, y: Array
) -> None:  # fmt: skip
    """Begin at the central iterate `near` of the program before (solve); joints that it has not near f and y.

    Ends whose product is below LIFTED are lifted to it at the same difference of force and gap, both scaled.
    """
    for q in range(len(f)):
        if near[q, 0] == 0.0:
            _begin_near(laws[q : q + 1], weight, span, CENTRAL_RIGID, f[q : q + 1], y[q : q + 1])
            continue
        f[q], y[q] = near[q, :3], h * near[q, 3:]
        for e in range(2):
            if f[q, e] * y[q, e] < LIFTED * weight * span:
                _part_evenly(weight, span, LIFTED, e, f[q], y[q])
        _within_friction(laws[q], weight, span, LIFTED, f[q], y[q])


@compiled
def _interior_point(
    rows: Any, at: Array, laws: Array, load: Array, mass: Array, dx: Array, f: Array, y: Array, scale: Any,
    stored_matrix: Array, pattern: Any, chosen: Any,
) -> tuple[int, float, float, float]:  # fmt: skip
    """`iterate` without lateral load and curvature; returns iterations and residuals of forces, gaps and products."""
    skew = len(laws) > 0 and laws[0, DILATION] < 1.0
    done, _, force, gap, product = iterate(
        rows, at, laws, load, np.empty(0), 0.0, mass, np.empty((0, CURVED)), dx, 0.0, f, y, scale,
        LIMITS_COULOMB if skew else LIMITS, stored_matrix, pattern, chosen,
    )  # fmt: skip
    return abs(done), force, gap, product


@compiled
def _take_lift_back(
    rows: Any, at: Array, laws: Array, load: Array, mass: Array, dx: Array, f: Array, y: Array, scale: Any,
    stored_matrix: Array, pattern: Any, chosen: Any, known: bool,
) -> tuple[bool, int, float, float, float]:  # fmt: skip
    """Solve a program of Coulomb's law by convex ones: slips lift, and the lift of the slips before is no gap.

    A fixed point, u + μ|v| − μ|v|ₙ ≥ 0 (De Saxcé), is by Coulomb's law. Begins near dx, f and y, whose slips are those
    of the first lift if they are `known`. Returns as `solve` does.
    """
    weight, _, span, accepted, closed = scale
    taken, done, lifts = np.zeros(len(f)), 0, np.inf
    force, product, solved = np.inf, np.inf, False
    convex = laws.copy()
    convex[:, DILATION] = 1.0
    places = at.copy()
    for n in range(ROUNDS):
        if n > 0 or known:
            for q in range(len(f)):
                taken[q] = lift(convex[q], y[q, 2] + y[q, 3])
        places[:, U] = at[:, U] + taken
        _begin_near(laws, weight, span, CENTRAL_RIGID, f, y)
        more, force, _, product = _interior_point(
            rows, places, convex, load, mass, dx, f, y, scale, stored_matrix, pattern, chosen
        )
        done += more
        solved = force <= accepted and product <= closed
        if not solved:
            break
        lifts = 0.0
        for q in range(len(f)):
            if f[q, 0] + f[q, 1] > PRESSED * weight:
                lifts = max(lifts, abs(lift(convex[q], y[q, 2] + y[q, 3]) - taken[q]) / span)
        if lifts <= RIGHT:
            break
    return solved, done, force, product, lifts


@compiled
def _without_dashpots(rows: Any, at: Array, laws: Array, dx: Array) -> tuple[Array, Array]:
    """Places (j, PLACE) and laws (j, LAW) of beds without the lines of dashpots that bear the same at dx (m,)."""
    places, linear = at.copy(), laws.copy()
    linear[:, DASHPOTS:] = 0.0
    for q in range(len(laws)):
        if not (laws[q, DASHPOTS:] > 0.0).any():
            continue
        du, dphi, _ = motion(at[q], rows[q, 0], rows[q, 1], dx)
        h = at[q, H]
        n, m, _, _, _ = bed_forces(
            laws[q], laws[q, STRENGTH], laws[q, LEFT:], h, at[q, U] + du, at[q, PHI] + dphi
        )
        if n > 0.0 and abs(m) < h * n:
            w1, w2, _, _, _ = gaps_under(linear[q], h, 0.5 * (n - m / h), 0.5 * (n + m / h))
            places[q, U], places[q, PHI] = 0.5 * (w1 + w2) - du, 0.5 * (w2 - w1) / h - dphi
    return places, linear


@compiled
def solve(
    rows: Any, at: Array, laws: Array, load: Array, mass: Array, dx: Array, f: Array, y: Array, scale: Any, begins: int,
    elastic: bool, stops: float, stored_matrix: Array, pattern: Any, chosen: Any, near: Array, speed: Array, h: float,
    moves: bool,
) -> tuple[bool, int, float, float, float]:  # fmt: skip
    """Solve for displacements dx (m,), forces f (j, 3) and gaps y (j, 4) of a step of length h.

    With elastic joints Newton's method is tried from the start of the step; if it fails since many joints slide, from
    a rough solution (ROUGHLY) of the interior point. Otherwise the interior point begins near the dx, f and y given;
    with rigid joints at the central iterate of the program before, if there is one, and leaves its own there: forces,
    and gaps over h, `near` (j, 7), 0: none, and displacements over h, `speed` (m,). By Coulomb's law rigid joints of
    blocks that move are solved as far as STALLED, or with lift. Returns whether it is solved, the number of
    iterations, the residuals of forces and products, and the greatest lift, per span.
    """
    weight, size, span, accepted, closed = scale
    done, central, gap = 0, True, 0.0
    if elastic and begins == NEAR:
        done, force, gap = newton(
            rows, at, laws, load, mass, np.zeros(len(dx)), dx, f, y, scale[:4], stored_matrix, pattern, chosen
        )
        if force <= accepted:
            return True, done, force, 0.0, 0.0
    if begins != NEAR:
        _begin_cold(at, span, stops, f, y)
    elif not elastic and near.any():
        dx[:] = h * speed
        _begin_central(laws, weight, span, h, near, f, y)
    else:
        _begin_near(laws, weight, span, CENTRAL_ELASTIC if elastic else CENTRAL_RIGID, f, y)
    keep_within_strength(at, laws, f)
    if elastic:
        dashpots = (laws[:, DASHPOTS:] > 0.0).any()
        for n in range(LINEAR if dashpots else 1):
            wanted = (weight, size, span, ROUGHLY, ROUGHLY) if n == 0 else scale
            places, linear = _without_dashpots(rows, at, laws, dx) if dashpots else (at, laws)
            more, force, gap, product = _interior_point(
                rows, places, linear, load, mass, dx, f, y, wanted, stored_matrix, pattern, chosen
            )
            done += more
            if not max(force, product) <= ROUGHLY:
                return False, done, force, product, 0.0
            more, force, gap = newton(
                rows, at, laws, load, mass, dx, dx, f, y, scale[:4], stored_matrix, pattern, chosen
            )
            done += more
            if force <= accepted:
                return True, done, force, 0.0, 0.0
    skew = not elastic and len(laws) > 0 and laws[0, DILATION] < 1.0
    if not elastic and begins == NEAR:
        more, force, gap, product = _interior_point(
            rows, at, laws, load, mass, dx, f, y, (weight, size, span, CENTRAL_FORCE, CENTRAL), stored_matrix, pattern,
            chosen,
        )  # fmt: skip
        done += more
        near[:] = 0.0
        central = force <= CENTRAL_FORCE and product <= CENTRAL
        if central:
            near[:, :3], near[:, 3:], speed[:] = f, y / h, dx / h
    if central or not skew:
        more, force, gap, product = _interior_point(
            rows, at, laws, load, mass, dx, f, y, scale, stored_matrix, pattern, chosen
        )
        done += more
        stalled = skew and moves and force <= STALLED_FORCE and product <= STALLED
        if stalled or not skew or (force <= accepted and product <= closed):
            return stalled or (force <= accepted and product <= closed), done, force, product, 0.0
    solved, more, force, product, lifts = _take_lift_back(
        rows, at, laws, load, mass, dx, f, y, scale, stored_matrix, pattern, chosen, central and gap <= RIGHT
    )
    return solved, done + more, force, product, lifts
