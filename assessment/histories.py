"""Every time history that a project asks for, its time step halved until the peak is as accurate as asked."""

from __future__ import annotations

from typing import TYPE_CHECKING

from assessment.campaign import Campaign, Task
from assessment.convergence import Accuracy, Levels, accuracy_of, not_met
from assessment.dynamics import Setting, StageResult, Start, history

if TYPE_CHECKING:
    from assessment.base_motion import BaseMotion
    from mechanics import Assembly


def histories(campaign: Campaign, motions: list[BaseMotion]) -> list[StageResult]:
    """Every time history that the project asks for, in the order of their tasks."""
    tasks = history_tasks(campaign, motions)
    return campaign.each("history", converged_history, tasks, 1, accuracy_of(campaign.project))


def history_tasks(campaign: Campaign, motions: list[BaseMotion]) -> list[Task]:
    """What every time history is made of, state by state."""
    by_table = [
        campaign.tasks(table, [motion])
        for table, motion in zip(campaign.project.history, motions, strict=True)
    ]
    states = campaign.project.states
    return sorted((task for tasks in by_table for task in tasks), key=lambda task: states.index(task[3]))


def converged_history(
    model: Assembly, motion: BaseMotion, setting: Setting, state: str, start: Start, accuracy: Accuracy
) -> StageResult:
    """One time history, its time step halved until the peak displacement is within the tolerance.

    A collapse has no peak: it counts when a second step has seen it too; where one step says collapse and the next does
    not, the error is not known. A finer run that fails leaves the coarser one.
    """
    result = history(model, motion, setting, state, start)
    if accuracy.tolerance is None or result.failures or isinstance(start, str):
        return result
    levels = Levels(model.size, (peak(result),))
    title = f"{state}, history of {motion.name}"
    for _ in range(accuracy.halvings):
        motion = motion.at_half_step()
        finer = history(model, motion, setting, state, start)
        if finer.failures:
            result.warnings.append(f"{title}: a finer time step fails: {'; '.join(finer.failures)}")
            break
        finer.seconds += result.seconds
        result, levels = finer, levels.joined(peak(finer))
        if levels.within(accuracy.tolerance):
            break
    result.convergence = {"state": state, "record": motion.name, "halvings": len(levels.measured) - 1}
    result.convergence |= levels.numbers(accuracy.tolerance)
    result.warnings += not_met(title, levels, accuracy.tolerance, "time steps")
    return result


def peak(result: StageResult) -> dict[str, float | None]:
    """Return what is to converge of a history: its peak displacement, none at a collapse."""
    numbers = result.numbers
    return {"peak_displacement_m": None if numbers["collapsed"] else numbers["peak_displacement_m"]}
