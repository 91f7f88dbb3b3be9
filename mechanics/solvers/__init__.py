"""Solvers of the program, one module each; nothing else imports a solver library."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from mechanics.block import GRAVITY, Array
from mechanics.errors import ConvergenceError, NoEquilibriumError
from mechanics.program import Neighbour, Program, Solution, certify
from mechanics.solvers import interior_point
from mechanics.solvers.elimination import Elimination

Answer = tuple[Array, float, Array]

GOOD = 1e-8  # a certificate that needs no second opinion
USABLE = 1e-6  # the worst that is accepted when every solver has been asked
BALANCED = 1e-6  # of gravity: an acceleration that is none
WORTH_WHILE = 40  # contact points from which central_path is quicker than PIQP
MARGINAL = 1e-8  # of gravity: one that decides where no solver finds an answer


def suits_central_path(contacts: int) -> bool:
    """Whether central_path is quicker than PIQP for a static program of so many contact points."""
    return contacts >= WORTH_WHILE


def solve(program: Program, near: Neighbour | None = None, layout: Elimination | None = None) -> Solution:
    """The first certified solution.

    A static program of some size goes to central_path, which begins `near` the solution of another
    where one is given, on matrices of that `layout`; a small one, or one that it does not solve, to PIQP. A poor
    certificate is met by a tighter and sturdier run, then by another solver; no status is ever trusted. Raises
    NoEquilibriumError where the loads cannot be balanced (decided by a program of its own, see imbalance) and
    ConvergenceError where they can but no solver shows how, or where not even that program is solved.
    """
    static = program.mass is None
    by_central_path = static and (near is not None or suits_central_path(len(program.gap)))
    if by_central_path:
        found = _by_central_path(program, near, layout)
        if found is not None:
            return found
    best: Solution | None = None
    acceleration, undecided = 0.0, None
    for count, attempt in enumerate(_attempts(program), start=int(by_central_path)):
        if count == 1 and static:
            try:
                acceleration = imbalance(program, layout)
            except ConvergenceError as error:  # of no account where an attempt finds a certified solution
                undecided = error
        if acceleration > BALANCED:
            break
        answer = attempt()
        if answer is not None:
            solution = Solution(*answer, certify(program, *answer))
            if best is None or _worst(program, solution) < _worst(program, best):
                best = solution
            if _worst(program, best) <= GOOD:
                return best
    if best is not None and acceleration <= BALANCED:
        if static and _worst(program, best) > USABLE:
            best = _by_central_path(program, best.neighbour(program), layout, best.displacement) or best
        if _worst(program, best) <= USABLE:
            return best
    if undecided is not None:
        raise undecided
    if acceleration > MARGINAL:
        raise NoEquilibriumError(f"no equilibrium: some block would start to move with {acceleration:.2g} g")
    raise ConvergenceError("equilibrium exists, but no solver found it to the required accuracy")


def _by_central_path(
    program: Program, near: Neighbour | None, layout: Elimination | None, start: Array | None = None
) -> Solution | None:
    """A static program's solution by central_path."""
    from mechanics.solvers import central_path

    return central_path.solve(program, layout or Elimination.of(program.dof), near, start)


def _worst(program: Program, solution: Solution) -> float:
    return solution.certificate.worst(program.step)


def imbalance(program: Program, layout: Elimination | None = None) -> float:
    """The least acceleration, per gravity, with which blocks of mean mass would start to move (Gauss's principle).

    Every contact point of a static program counts as closed and rigid. This auxiliary program always has a solution:
    zero where the loads (for some multiplier, where there is one) can be balanced, of which forces that do are the
    quicker proof.
    """
    still, stiff = np.zeros_like(program.gap), np.zeros_like(program.compliance)
    closed = replace(program, gap=still, compliance=stiff, work=0.0)
    if suits_central_path(len(program.gap)):
        standing = _by_central_path(closed, None, layout)
        if standing is not None and standing.certificate.equilibrium <= GOOD:
            return 0.0
    mass = np.full(len(program.load), program.weight / GRAVITY)
    mass[2::3] *= program.size**2
    gauss = replace(closed, mass=mass, step=GRAVITY)
    least = np.inf
    for tolerance in (1e-9, 1e-11, 1e-13):
        answer = interior_point.solve(gauss, tolerance, most_iterations=100)
        if answer is None or certify(gauss, *answer).equilibrium > BALANCED:
            continue
        least = min(least, float(abs(answer[2].reshape(-1, 3) * (1.0, 1.0, program.size)).max()) / GRAVITY)
        if least <= BALANCED or least > 10.0 * np.sqrt(tolerance):  # the objective is known to the tolerance
            return least
    if np.isfinite(least):
        return least
    raise ConvergenceError("the auxiliary program of least acceleration was not solved")


def _attempts(program: Program) -> Iterator[Callable[[], Answer | None]]:
    yield lambda: interior_point.solve(program, 1e-9)
    yield lambda: interior_point.solve(program, 1e-11, most_iterations=400)
    if program.mass is None and not program.compliance.any():
        from mechanics.solvers import linear

        yield lambda: linear.solve(program)
        yield lambda: linear.solve(program, "highs-ipm")
