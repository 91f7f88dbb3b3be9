"""Limit analysis of a reported mechanism by a second program, beside that of the program itself."""

from __future__ import annotations

import time

from assessment.analyses.static.lateral import pushover_title
from assessment.analyses.static.paths import PathResult
from assessment.results.schema.static import SecondSolver
from mechanics import ArgumentError, Assembly, ConvergenceError, NoEquilibriumError, State
from mechanics.messages import headed, message
from mechanics.model import Direction
from mechanics.procedures import limit_in, static_theorem

AGREE = 1e-6  # relative difference of the two multipliers from which there is a warning
LEAST = 1e-2  # a multiplier below which differences are relative to this: solvers know α to 1e-9, not its digits at 0


def second_solver(
    model: Assembly, name: str, direction: Direction, activated: State, alpha_0: float
) -> PathResult[SecondSolver]:
    """Compare the associative multipliers of two programs in the state `activated` of the state of that name.

    `alpha_0`: multiplier of the curve that has its peak there, a third number beside them.
    The law is associative whatever that of the curve: with Coulomb's the multiplier is not unique, and no linear
    program has it. Nothing is `found` where joints crush.
    """
    began = time.perf_counter()
    result = PathResult[SecondSolver]()
    title = pushover_title(name, direction, "rigid")
    try:
        linear = static_theorem(model, direction, activated)
    except ArgumentError:
        return result
    own: float | None = None
    try:
        own = limit_in(model, direction, activated, "associative").alpha
    except (NoEquilibriumError, ConvergenceError) as error:
        note = message("limit analysis where α0 is reached: {reason}", reason=error.message)
        result.warnings.append(headed(title, note))
    if linear is None:
        note = message("the linear program of limit analysis has no optimum by HiGHS")
        result.warnings.append(headed(title, note))
    difference = None
    if own is not None and linear is not None:
        difference = (linear - own) / max(abs(own), LEAST)
        if abs(difference) > AGREE:
            note = message(
                "limit analysis where α0 is reached gives α = {own:.8g}, a linear program written apart (HiGHS) "
                "{linear:.8g}: relative difference {difference:.2g}",
                own=own,
                linear=linear,
                difference=difference,
            )
            result.warnings.append(headed(title, note))
    result.found = SecondSolver(
        alpha_0=alpha_0,
        alpha_program=own,
        alpha_linear_program=linear,
        relative_difference=difference,
    )
    result.seconds = time.perf_counter() - began
    return result
