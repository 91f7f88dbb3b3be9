"""Elastic pushover under a growing multiplier, up to the last equilibrium (paper, §4, eq. 4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mechanics.assembly import Assembly, Direction, State
from mechanics.equilibrium import rest_size
from mechanics.errors import ConvergenceError, NoEquilibriumError, require
from mechanics.onset import settled
from mechanics.static_step import Step, find_step
from mechanics.types import Array

HALVINGS = 6


@dataclass(frozen=True, eq=False)
class LoadPath:
    """The rising branch: `displacement` (k,) m of the control point, `multiplier` (k,), `steps`, and why it ends.

    Equilibrium exists at the last multiplier and none was found `bracket` above it.
    """

    displacement: Array
    multiplier: Array
    steps: tuple[Step, ...]
    bracket: float
    end: str


def load_control(
    model: Assembly,
    control: ArrayLike,
    direction: Direction = "+x",
    increment: float = 0.005,
    state: State | None = None,
) -> LoadPath:
    """Raise the multiplier by `increment` from elastic rest until no equilibrium is found, then by halves of it.

    The peak that `pushover` passes through under work control lies within the bracket of the last multiplier: the
    same curve found in another way. Raises UnstableError, and ValueError for a control point outside every block.
    """
    require(0.0 < increment < np.inf, "increment", increment, "positive")
    block = model.block_at(control)
    lateral = model.lateral_load(direction)
    steps, multiplier = [settled(model, state)], [0.0]
    rate = np.zeros_like(steps[0].state.positions)
    size, by, end = rest_size(model, "elastic"), increment, ""
    while by >= increment / 2.0**HALVINGS:
        now, alpha = steps[-1].state, multiplier[-1] + by
        expected = max(float(abs(rate[:, :2]).max()) * by, size)
        try:
            step = find_step(
                model,
                "elastic",
                now,
                now.positions + by * rate,
                model.dead_load + alpha * lateral,
                expected,
                last=steps[-1],
            )
        except (NoEquilibriumError, ConvergenceError) as stop:
            end = str(stop)
            by /= 2.0
            continue
        rate = (step.state.positions - now.positions) / by
        steps.append(step)
        multiplier.append(alpha)
    origin = model.point_displacement(control, block, steps[0].state.positions)
    sign = 1.0 if direction == "+x" else -1.0
    path = [sign * (model.point_displacement(control, block, s.state.positions) - origin)[0] for s in steps]
    return LoadPath(np.array(path), np.array(multiplier), tuple(steps), 2.0 * by, end)
