"""Solvers of the program, one module each; nothing else imports a solver library."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mechanics.errors import ConvergenceError, NoEquilibriumError
from mechanics.kernels.joint import PHI, H, U, V
from mechanics.kernels.law import BED, DILATION, FRICTION, SHEAR, SLID, STEEPEST, STRENGTH
from mechanics.messages import message
from mechanics.model.contacts import end_gaps
from mechanics.program import Program, Solution, certify
from mechanics.solvers import interior
from mechanics.solvers.elimination import Elimination
from mechanics.solvers.interior import Iterate
from mechanics.types import GRAVITY, Array

ACCEPTED = 1e-10  # residual of an interior-point solution, per weight and step
GOOD = 1e-8  # a certificate that needs no second opinion
# the worst certificate that is accepted after all solvers have been tried or where a motion rests
USABLE = 1e-6
BALANCED = USABLE  # of gravity: acceleration up to which loads count as balanced
DOUBTFUL = 1e-3  # of gravity: a smaller acceleration may be none
OPEN = 100.0  # steps: gap of a joint that stays open; half of it is open too


def iterated(program: Program, layout: Elimination) -> tuple[Solution, Iterate] | None:
    """Return the first certified solution of the interior point and its iterate, else the best; None if it has none."""
    best: tuple[Solution, Iterate] | None = None
    for start in interior.starts(program, layout):
        iterate, outcome = interior.run(program, layout, start, ACCEPTED)
        if not np.isfinite(outcome.force):
            continue
        found = interior.solution(program, iterate)
        if best is None or found.certificate.worst(program.step) < best[0].certificate.worst(program.step):
            best = found, iterate
        if found.certificate.worst(program.step) <= GOOD:
            break
    return best


def solve(program: Program, layout: Elimination) -> tuple[Solution, Iterate | None]:
    """Return the first certified solution, and its iterate as the start of a next one (None for one of another solver).

    The package's interior-point method is tried first; then PIQP, if the program is quadratic, and HiGHS, if it is
    linear. A solver's status is never relied on: the certificate decides. Raises NoEquilibriumError if the loads cannot
    be balanced (see least_acceleration), ConvergenceError if they can but no solver finds forces, or it is not decided.
    """
    own = iterated(program, layout)
    if own is not None and own[0].certificate.worst(program.step) <= GOOD:
        return own
    best = own[0] if own else None
    acceleration, undecided = 0.0, None
    if program.mass is None:
        try:
            acceleration, _ = least_acceleration(program, layout)
        except ConvergenceError as error:  # ignored if an attempt finds a certified solution
            undecided = error
    if acceleration <= BALANCED:
        for answer in _second_opinions(program):
            if answer is not None:
                found = Solution(*answer, certify(program, *answer))
                best = min(found, best or found, key=lambda each: each.certificate.worst(program.step))
                if best.certificate.worst(program.step) <= GOOD:
                    return best, None
        if best is not None and best.certificate.worst(program.step) <= USABLE:
            return best, None
    if undecided is not None:
        raise undecided
    if acceleration > GOOD:
        raise NoEquilibriumError(
            message(
                "no equilibrium: some block would start to move with {acceleration:.2g} g",
                acceleration=acceleration,
            )
        )
    raise ConvergenceError(message("equilibrium exists, but no solver found it to the required accuracy"))


def least_acceleration(program: Program, layout: Elimination) -> tuple[float, Array]:
    """Return the least acceleration, per gravity, with which blocks start to move, and its forces (j, 3), kN and kNm.

    It is that of blocks of mean mass (Gauss's principle); the forces are N, P and T. Joints count as rigid, and as
    closed if they may close within the program's step. This auxiliary program always has a solution. It is zero if the
    loads can be balanced, with a lateral load for some multiplier. Its objective is the square of the acceleration, so
    a small acceleration may be none: a linear program decides that. Raises ConvergenceError if it is not solved.
    """
    places, law = program.places.copy(), program.law.copy()
    closed = end_gaps(places) <= 0.5 * OPEN * program.step
    low, high = np.where(closed, 0.0, OPEN * GRAVITY).T
    places[:, U], places[:, PHI] = 0.5 * (low + high), 0.5 * (high - low) / np.maximum(places[:, H], 1e-300)
    places[:, V] = 0.0
    law[:, BED], law[:, SHEAR], law[:, SLID], law[:, DILATION] = np.inf, 0.0, 0.0, 1.0
    # T is nothing where N is: no closed cone says that
    law[:, FRICTION] = np.minimum(law[:, FRICTION], STEEPEST)
    mass = np.full(len(program.load), program.weight / GRAVITY)
    mass[2::3] *= program.size**2
    gauss = replace(program, places=places, law=law, work=0.0, mass=mass, step=GRAVITY, curved=None)
    found, forces = _least_acceleration(gauss, layout)
    if BALANCED < found < DOUBTFUL and np.isinf(law[:, STRENGTH]).all():
        from mechanics.solvers import lp_highs

        if lp_highs.least_residual(replace(gauss, mass=None), closed) <= BALANCED:
            return 0.0, forces
    return found, forces


def _least_acceleration(gauss: Program, layout: Elimination) -> tuple[float, Array]:
    """Return the largest acceleration, per gravity, in the solution of the auxiliary program, and its forces (j, 3).

    Raises ConvergenceError if it is not solved.
    """

    def least(acceleration: np.ndarray) -> float:
        return float(abs(acceleration.reshape(-1, 3) * (1.0, 1.0, gauss.size)).max()) / GRAVITY

    iterate, outcome = interior.run(gauss, layout, interior.cold(gauss), 1e-11)
    # the objective, the square of the acceleration, is known up to the residual products
    if outcome.force <= BALANCED and outcome.product <= 1e-9:
        found = least(iterate.displacement)
        if outcome.accepted or found > 10.0 * np.sqrt(outcome.product):
            return found, interior.resultants(gauss, iterate)
    from mechanics.solvers import qp_piqp

    smallest, forces = np.inf, np.zeros((len(gauss.places), 3))
    for tolerance in (1e-9, 1e-11, 1e-13):
        answer = qp_piqp.solve(gauss, tolerance, most_iterations=100)
        if answer is None or certify(gauss, *answer).equilibrium > BALANCED:
            continue
        if least(answer[2]) < smallest:
            smallest, forces = least(answer[2]), answer[0]
        if smallest <= BALANCED or smallest > 10.0 * np.sqrt(tolerance):
            return smallest, forces
    if np.isfinite(smallest):
        return smallest, forces
    raise ConvergenceError(message("the auxiliary program of least acceleration was not solved"))


def _second_opinions(program: Program) -> Iterator[tuple[Array, float, Array] | None]:
    """Yield forces, multiplier and displacements by PIQP, and by HiGHS where the program is linear."""
    from mechanics.solvers import lp_highs, qp_piqp

    # quadratic: no joint crushes, and what slides lifts in full
    if np.isinf(program.law[:, STRENGTH]).all() and (program.law[:, DILATION] == 1.0).all():
        yield qp_piqp.solve(program, 1e-9)
        yield qp_piqp.solve(program, 1e-11, most_iterations=400)
        if program.mass is None and not np.isfinite(program.law[:, BED]).any():
            yield lp_highs.solve(program)
            yield lp_highs.solve(program, "highs-ipm")
