"""States, and the programs of steps, that several tests solve."""

from dataclasses import replace
from typing import Literal

import numpy as np

from mechanics import Assembly, State
from mechanics.model.assembly import Behaviour
from mechanics.program import Program
from mechanics.solvers import lp_highs
from mechanics.solvers.elimination import Elimination
from mechanics.steps.equilibrium import closed_program
from mechanics.steps.static_step import StepProblem
from mechanics.steps.static_system import static_system
from mechanics.types import GRAVITY


def shaken(model: Assembly, seed: int) -> State:
    """Blocks a little out of place, joints open and closed, and moving."""
    rng = np.random.default_rng(seed)
    size = model.movable[:, None] * model.size * np.array([1.0, 1.0, 1.0 / model.size])
    move = rng.standard_normal((2, len(model.blocks), 3)) * size
    return State(model.initial.positions + 1e-5 * move[0], 1e-2 * move[1])


def posed(problem: StepProblem) -> tuple[Program, Elimination]:
    """The program of a step in the geometry of its start, and the layout of its matrices."""
    program, index = problem.pose(problem.start.positions, None)
    return program, problem.system.layout.take(index)


def static_step(model: Assembly, behaviour: Behaviour) -> tuple[Program, Elimination]:
    """Equilibrium from the drawn state under a free multiplier whose loads do the work γ (paper, eq. 5)."""
    size = 1e-3 * model.size
    work = 0.3 * size * model.weight
    return posed(
        StepProblem(
            static_system(model, behaviour), model.initial, model.dead_load, size, model.lateral_load("+x"),
            work,
        )
    )  # fmt: skip


def euler_step(
    model: Assembly, behaviour: Behaviour, state: State, acceleration: float
) -> tuple[Program, Elimination]:
    """An implicit Euler step of 5 ms from a moving state, under a base acceleration in g (paper, eq. 3)."""
    step, system = 0.005, static_system(model, behaviour)
    load = model.dead_load - acceleration * GRAVITY * model.mass * (1.0, 0.0, 0.0)
    size = max(GRAVITY * step**2, step * float(abs(state.velocities[:, :2]).max()))
    problem = StepProblem(
        system, replace(state, shear=None), load + model.mass / step * state.velocities, size,
        mass=model.mass / step**2,
    )  # fmt: skip
    return posed(problem)


def by_highs(
    model: Assembly, state: State | None = None, method: Literal["highs-ds", "highs-ipm"] = "highs-ds"
) -> float:
    """The associative multiplier towards +x over the joints that are closed in a state, by a solver of another kind."""
    closed = closed_program(model, state or model.initial).pushed(model, model.lateral_load("+x"))
    found = lp_highs.solve(closed.program, method)
    assert found is not None
    return found[1]
