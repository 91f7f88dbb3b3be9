"""How far a PGA at collapse is from converged in the time step.

It is looked for again about where it was found, with half the time step: a few runs beside those of the search. Results
stay as they are; only their error is told.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from assessment.convergence import Levels, accuracy_of
from assessment.incremental import Bracket, search_again, search_title

if TYPE_CHECKING:
    from assessment.base_motion import BaseMotion
    from assessment.campaign import Campaign
    from assessment.dynamics import StageResult

AGAIN = 6  # motions that a bracket looked for again costs, about, at two to eight runs


@dataclass
class Estimates:
    """`rows` of results.json; `warnings`: where the tolerance was not met; `seconds`: what the analyses took."""

    rows: list[dict[str, Any]] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    seconds: float = 0.0


def collapses_again(campaign: Campaign, motions: list[BaseMotion], given: Sequence[StageResult]) -> Estimates:
    """Estimate the error of the PGA at collapse; `given`: the searches in their order.

    It is the width of the bracket and twice the distance to the PGA that the finer analysis gives: by a method of first
    order, half the step leaves half of the error.
    """
    found, project = Estimates(), campaign.project
    table, tolerance = project.incremental, accuracy_of(project).tolerance
    if table is None or tolerance is None:
        return found
    tasks = [
        (model, motion.at_half_step(), setting, state, start, Bracket(safe, stage.numbers["pga_collapse_g"], ()))
        for (model, motion, setting, state, start), stage in zip(campaign.tasks(table, motions), given, strict=True)
        for safe in [stage.numbers["pga_safe_g"]]
        if safe is not None
    ]  # fmt: skip
    again = campaign.each(
        "finer: incremental", search_again, tasks, AGAIN, table.max_scale, table.tolerance_g
    )
    found.seconds = sum(stage.seconds for stage in again)
    for (_, motion, _, state, _, near), stage in zip(tasks, again, strict=True):
        measured = ({"pga_collapse_g": each} for each in (near.collapse, stage.numbers["pga_collapse_g"]))
        levels = Levels(campaign.model.size, tuple(measured), result=0, resolution=near.width)
        found.rows.append({"state": state, "record": motion.name, **levels.numbers(tolerance)})
        found.warnings += _collapse_warnings(search_title(state, motion), levels, stage, tolerance)
    return found


def _collapse_warnings(title: str, levels: Levels, stage: StageResult, tolerance: float) -> list[str]:
    """Return what is wrong with a PGA at collapse; `stage`: the finer search."""
    if stage.numbers["pga_safe_g"] is None:
        why = stage.numbers["reason"]
        return [f"{title}: a finer time step fails: {why}"]
    if levels.within(tolerance):
        return []
    said = "; ".join(levels.missed(tolerance))
    return [
        f"{title}: estimated error of {said} with the tolerance_g and time_step_s given, "
        f"tolerance {100.0 * tolerance:.2g} %; refine them"
    ]
