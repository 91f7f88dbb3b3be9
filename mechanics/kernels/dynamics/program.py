"""The program of a step: from where, and by which method, it is solved."""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from mechanics.kernels.dynamics.motion import STANDARD_GRAVITY
from mechanics.kernels.dynamics.newton import newton
from mechanics.kernels.interior.iteration import OrderedProgram, iterate
from mechanics.kernels.interior.joints import ProgramJoints, keep_within_strength
from mechanics.kernels.jit import compiled, looped
from mechanics.kernels.joint import PHI, H, U

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
# where the program of a step of length h begins: NEAR what joints had, or FROM_GAPS; the central iterate of the program
# before, which rigid joints leave there: `near` (j, 7), forces, and gaps over h, 0: none; `speed` (m,): displacements
# over h
Start = namedtuple("Start", "begins h near speed")


@looped
def _begin_cold(program: OrderedProgram, h: float, f: Array, y: Array) -> None:
    """Forces and gaps where nothing is known of them but the gaps that are there, and a force that stops blocks."""
    at, span = program.joints.places, program.step
    stops = COLD * program.weight * span / (STANDARD_GRAVITY * h * h)
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
def _begin_central(program: OrderedProgram, h: float, near: Array, f: Array, y: Array) -> None:
    """Begin at the central iterate `near` of the program before (Start); joints that it has not near f and y.

    Ends whose product is below LIFTED are lifted to it at the same difference of force and gap, both scaled.
    """
    laws, weight, span = program.joints.law, program.weight, program.step
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
    program: OrderedProgram, x: Array, f: Array, y: Array, accepted: float, closed: float
) -> tuple[int, float, float, float]:
    """`iterate`; returns iterations and residuals of forces, gaps and products."""
    laws = program.joints.law
    skew = len(laws) > 0 and laws[0, DILATION] < 1.0
    done, _, force, gap, product = iterate(
        program, x, 0.0, f, y, accepted, closed, LIMITS_COULOMB if skew else LIMITS
    )
    return abs(done), force, gap, product


@compiled
def _of_joints(program: OrderedProgram, at: Array, laws: Array) -> OrderedProgram:
    """The program with its joints at other places (j, PLACE) and by other laws (j, LAW)."""
    row, _, _, curved, which = program.joints
    _, load, lateral, work, mass, weight, size, step, stored, pattern = program
    joints = ProgramJoints(row, at, laws, curved, which)
    return OrderedProgram(joints, load, lateral, work, mass, weight, size, step, stored, pattern)


@compiled
def _take_lift_back(
    program: OrderedProgram, x: Array, f: Array, y: Array, accepted: float, closed: float, known: bool
) -> tuple[bool, int, float, float, float]:
    """Solve a program of Coulomb's law by convex ones: slips lift, and the lift of the slips before is no gap.

    A fixed point, u + μ|v| − μ|v|ₙ ≥ 0 (De Saxcé), is by Coulomb's law. Begins near x, f and y, whose slips are those
    of the first lift if they are `known`. Returns as `solve` does.
    """
    weight, span, at = program.weight, program.step, program.joints.places
    taken, done, lifts = np.zeros(len(f)), 0, np.inf
    force, product, solved = np.inf, np.inf, False
    convex = program.joints.law.copy()
    convex[:, DILATION] = 1.0
    places = at.copy()
    lifted = _of_joints(program, places, convex)
    for n in range(ROUNDS):
        if n > 0 or known:
            for q in range(len(f)):
                taken[q] = lift(convex[q], y[q, 2] + y[q, 3])
        places[:, U] = at[:, U] + taken
        _begin_near(convex, weight, span, CENTRAL_RIGID, f, y)
        more, force, _, product = _interior_point(lifted, x, f, y, accepted, closed)
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
def _without_dashpots(program: OrderedProgram, x: Array) -> OrderedProgram:
    """The program of beds without the lines of dashpots that bear the same at displacements x (m,)."""
    rows, at, laws, _, _ = program.joints
    places, linear = at.copy(), laws.copy()
    linear[:, DASHPOTS:] = 0.0
    for q in range(len(laws)):
        if not (laws[q, DASHPOTS:] > 0.0).any():
            continue
        du, dphi, _ = motion(at[q], rows[q, 0], rows[q, 1], x)
        h = at[q, H]
        n, m, _, _, _ = bed_forces(
            laws[q], laws[q, STRENGTH], laws[q, LEFT:], h, at[q, U] + du, at[q, PHI] + dphi
        )
        if n > 0.0 and abs(m) < h * n:
            w1, w2, _, _, _ = gaps_under(linear[q], h, 0.5 * (n - m / h), 0.5 * (n + m / h))
            places[q, U], places[q, PHI] = 0.5 * (w1 + w2) - du, 0.5 * (w2 - w1) / h - dphi
    return _of_joints(program, places, linear)


@compiled
def solve_elastic(
    program: OrderedProgram, x: Array, f: Array, y: Array, start: Start, accepted: float, closed: float
) -> tuple[bool, int, float, float, float]:
    """Solve for displacements x (m,), forces f (j, 3) and gaps y (j, 4) of a step over elastic joints.

    Newton's method is tried from the start of the step; if it fails since many joints slide, from a rough solution
    (ROUGHLY) of the interior point. Returns as `solve_rigid` does, no lift.
    """
    laws, done, force, product = program.joints.law, 0, np.inf, np.inf
    if start.begins == NEAR:
        done, force, _ = newton(program, np.zeros(len(x)), x, f, y, accepted)
        if force <= accepted:
            return True, done, force, 0.0, 0.0
        _begin_near(laws, program.weight, program.step, CENTRAL_ELASTIC, f, y)
    else:
        _begin_cold(program, start.h, f, y)
    keep_within_strength(program.joints.places, laws, f)
    dashpots = (laws[:, DASHPOTS:] > 0.0).any()
    for n in range(LINEAR if dashpots else 1):
        linear = _without_dashpots(program, x) if dashpots else program
        balanced, complementary = (ROUGHLY, ROUGHLY) if n == 0 else (accepted, closed)
        more, force, _, product = _interior_point(linear, x, f, y, balanced, complementary)
        done += more
        if not max(force, product) <= ROUGHLY:
            return False, done, force, product, 0.0
        more, force, _ = newton(program, x, x, f, y, accepted)
        done += more
        if force <= accepted:
            return True, done, force, 0.0, 0.0
    more, force, _, product = _interior_point(program, x, f, y, accepted, closed)
    return force <= accepted and product <= closed, done + more, force, product, 0.0


@compiled
def solve_rigid(
    program: OrderedProgram, x: Array, f: Array, y: Array, start: Start, accepted: float, closed: float, moves: bool,
) -> tuple[bool, int, float, float, float]:  # fmt: skip
    """Solve for displacements x (m,), forces f (j, 3) and gaps y (j, 4) of a step over rigid joints.

    The interior point begins at the central iterate of the program before, if there is one, otherwise near x, f and y.
    By Coulomb's law joints of blocks that move (`moves`) are solved as far as STALLED, or with lift. Returns whether it
    is solved, the number of iterations, the residuals of forces and products, and the greatest lift, per span.
    """
    laws, weight, span, h = program.joints.law, program.weight, program.step, start.h
    done, central, gap = 0, True, 0.0
    if start.begins != NEAR:
        _begin_cold(program, h, f, y)
    elif start.near.any():
        x[:] = h * start.speed
        _begin_central(program, h, start.near, f, y)
    else:
        _begin_near(laws, weight, span, CENTRAL_RIGID, f, y)
    keep_within_strength(program.joints.places, laws, f)
    skew = len(laws) > 0 and laws[0, DILATION] < 1.0
    if start.begins == NEAR:
        done, force, gap, product = _interior_point(program, x, f, y, CENTRAL_FORCE, CENTRAL)
        start.near[:] = 0.0
        central = force <= CENTRAL_FORCE and product <= CENTRAL
        if central:
            start.near[:, :3], start.near[:, 3:], start.speed[:] = f, y / h, x / h
    if central or not skew:
        more, force, gap, product = _interior_point(program, x, f, y, accepted, closed)
        done += more
        found = force <= accepted and product <= closed
        stalled = skew and moves and force <= STALLED_FORCE and product <= STALLED
        if found or stalled or not skew:
            return found or stalled, done, force, product, 0.0
    known = central and gap <= RIGHT
    solved, more, force, product, lifts = _take_lift_back(program, x, f, y, accepted, closed, known)
    return solved, done + more, force, product, lifts
