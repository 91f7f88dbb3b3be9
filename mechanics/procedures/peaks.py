"""The peak of a capacity curve behind a joint that closes.

α of rigid joints jumps up where an open joint closes, and falls behind that. The step in which a joint closes ends
anywhere behind the jump, with less than the curve reaches: less by what α falls within a step. The peak is therefore
looked for in that step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import ConvergenceError, NoEquilibriumError
from mechanics.kernels.joint import H
from mechanics.model.assembly import State
from mechanics.model.contacts import end_gaps
from mechanics.procedures.step_control import reach
from mechanics.program import end_forces
from mechanics.steps.static_step import Equilibrium, StepProblem
from mechanics.steps.tolerances import STEP
from mechanics.types import Array


def may_peak(multiplier: ArrayLike, displacement: ArrayLike, least: float) -> list[tuple[float, int]]:
    """Return the steps in which α may exceed all points: the most that it may reach, and the point at the step's end.

    `multiplier` (k,) and `displacement` (k,) m of the points; the highest first. The most is the fall behind the point,
    carried back over the step; differences below `least` do not count.
    """
    alpha, forward, rise = np.asarray(multiplier), np.diff(displacement), np.diff(multiplier)
    highest = alpha.max()
    found = []
    for point in range(1, len(alpha)):
        behind = -rise[point] / forward[point] if point < len(rise) and forward[point] > 0.0 else 0.0
        most = alpha[point] + max(behind * forward[point - 1], 0.0)
        if most >= highest + least or (most >= highest and rise[point - 1] >= least):
            found.append((float(most), point))
    return sorted(found, reverse=True)


def closes(start: State, end: Equilibrium) -> bool:
    """Whether the end of a joint carries at the end of a step that is open at its start: without that α has no jump."""
    system = end.system
    begun = end.contacts.places(start.positions)
    apart = (end_gaps(begun) > STEP.inside * system.model.size) | (begun[:, [H]] <= 0.0)
    carries = end_forces(end.forces, abs(end.places[:, H])) > system.least_force
    return bool((apart & carries).any())


def behind_closing(lateral: Array, before: Equilibrium, end: Equilibrium, part: float) -> Equilibrium | None:
    """Return the equilibrium just behind the joint that closes in a step; None if none has a larger α than its end.

    `lateral` (b, 3) kN and kNm: the loads that α multiplies; `before`, `end`: the points of the step. The jump of α is
    located to a `part` of the step, and the equilibrium is one or two such parts behind it: nearer, joints are open by
    less than the program resolves.
    """
    start, system = before.state, end.system
    moved = end.state.positions - start.positions
    work, size = float((lateral * moved).sum()), float(abs(moved[:, :2]).max())

    def reached(share: float) -> Equilibrium | None:
        step = StepProblem(system, start, system.model.dead_load, share * size, lateral, share * work)
        try:
            return reach(step, start.positions + share * moved, before, shortest=False).step
        except (NoEquilibriumError, ConvergenceError):
            return None

    apart, behind, highest = 0.0, 1.0, end.alpha  # shares of the step between which α jumps
    while behind - apart > part:
        share = 0.5 * (apart + behind)
        step = reached(share)
        if step is None:
            break
        if step.alpha > highest:
            behind, highest = share, step.alpha
        else:
            apart = share
    return reached(2.0 * behind - apart) if behind < 1.0 else None
