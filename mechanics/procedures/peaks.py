"""The peaks of a capacity curve: one behind a joint that closes, and one that held leads to a fall.

α of rigid joints jumps up where an open joint closes, and falls behind that. The step in which a joint closes ends
anywhere behind the jump, with less than the curve reaches: less by what α falls within a step. The peak is therefore
looked for in that step.

The load of a peak, held, drives the structure through the trough behind it. What it does not survive is no capacity.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import ConvergenceError, NoEquilibriumError
from mechanics.kernels.joint import H
from mechanics.model.assembly import Assembly, State
from mechanics.model.contacts import end_gaps
from mechanics.procedures.step_control import reach
from mechanics.program import end_forces
from mechanics.steps.static_step import Equilibrium, StepProblem
from mechanics.steps.tolerances import STEP
from mechanics.types import Array, Mask


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
            return reach(step, start.positions + share * moved, before, shortest=False)[0]
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


def stands_until(
    model: Assembly, lateral: Array, alpha: Array, moves: Array, jumps: Mask, flat: float, zero: float
) -> tuple[int, float]:
    """Return the last point of a curve that counts, and the multiplier held there; the last of all where none falls.

    `alpha` (k,) of the points; `moves` (k − 1, b, 3) of the blocks between them, and whether these are `jumps`;
    `lateral` (b, 3) kN and kNm. The work of all loads, held at a peak, must be taken up before α exceeds the peak by a
    share `flat`, and before it is `zero` of the largest; else the structure falls. Where the direction of its motion
    changes from Δ to Δ', as in an impact, it keeps (ΔᵀMΔ')² / (ΔᵀMΔ Δ'ᵀMΔ') of its energy, and none if it turns back.
    """
    inertia = np.einsum("kbi,bi,kbi->k", moves, model.mass, moves)
    turning = np.einsum("kbi,bi,kbi->k", moves[:-1], model.mass, moves[1:])
    kept = np.r_[0.0, np.maximum(turning, 0.0) ** 2 / np.maximum(inertia[:-1] * inertia[1:], 1e-300)]
    work, gravity = (np.einsum("kbi,bi->k", moves, load) for load in (lateral, model.dead_load))
    # index of the peak; energy (kNm) gained since; index of the first point that exceeds the peak
    held, gained, above = 0, 0.0, 0
    for k in range(1, len(alpha)):
        if not gained and alpha[k] >= alpha[held]:
            held = k
            continue
        # where joints close α rises at once
        along = max(0.5 * (alpha[k - 1] + alpha[k]), alpha[k]) * work[k - 1]
        against = -gravity[k - 1] if jumps[k - 1] else along
        gained = kept[k - 1] * gained + alpha[held] * work[k - 1] - against
        if gained <= 0.0:
            held, gained, above = k, 0.0, 0
        elif alpha[k] > (1.0 + flat) * alpha[held] and not above:
            above = k
    spent = [k for k in range(held + 1, above or len(alpha)) if alpha[k] <= zero * alpha.max()]
    return (spent[0] if spent else (above or len(alpha)) - 1), float(alpha[held])
