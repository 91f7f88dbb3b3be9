"""The error of a PGA at collapse due to the time step.

The search is repeated near its result with a half and a quarter of the time step, which takes a few runs. The results
remain unchanged; their estimated error is added.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from assessment.analyses.accuracy import NOISE, accuracy_of
from assessment.analyses.dynamic.bracket import Bracket
from assessment.analyses.dynamic.ensemble import scatter_of
from assessment.analyses.dynamic.incremental import AGAIN, search_again, search_title
from assessment.analyses.dynamic.refinement import Refinement
from assessment.results.schema.part import known
from mechanics.messages import Message, headed, message

if TYPE_CHECKING:
    from assessment.analyses.dynamic.inputs import Campaign
    from assessment.analyses.dynamic.time_history import DynamicResult
    from assessment.project.motions import BaseMotion
    from assessment.results.schema.dynamic import Search
    from assessment.results.schema.studies import ConvergenceRow

PGA = "pga_collapse_g"


@dataclass
class Estimates:
    """`rows` of results.json; `warnings`: where the tolerance was not met; `seconds`: what the analyses took."""

    rows: list[ConvergenceRow] = field(default_factory=list)
    warnings: list[Message] = field(default_factory=list)
    seconds: float = 0.0


def collapses_again(
    campaign: Campaign, motions: list[BaseMotion], given: Sequence[DynamicResult[Search]]
) -> Estimates:
    """Estimate the error of the PGA at collapse; `given`: the searches in the order of their tasks.

    The error is the sum of the width of the bracket, the distance to the PGA of the finest time step, and the error of
    that PGA.
    """
    found, project = Estimates(), campaign.project
    table, tolerance = project.incremental, accuracy_of(project).tolerance
    if table is None or tolerance is None:
        return found
    searched = [
        (task, stage)
        for task, stage in zip(campaign.tasks(table, motions), given, strict=True)
        if stage.numbers.pga_safe_g is not None
    ]
    tasks = [
        (replace(task, motion=finer), _bracket(stage))
        for task, stage in searched
        for finer in (task.motion.at_half_step(), task.motion.at_half_step().at_half_step())
    ]
    again = campaign.each(
        "finer: incremental",
        search_again,
        tasks,
        AGAIN,
        scatter_of(project),
        table.max_scale,
        table.tolerance_g,
    )
    found.seconds = sum(stage.seconds for stage in again)
    for (task, stage), half, quarter in zip(searched, again[::2], again[1::2], strict=True):
        title, near = search_title(task), _bracket(stage)
        values = tuple(each.numbers.pga_collapse_g for each in (stage, half, quarter))
        apart = 0.0 if near.certain is None or near.collapse is None else near.certain - near.collapse
        levels = Refinement(PGA, values, (apart, 0.0, 0.0), NOISE, near.width, 0)
        failed = [each.numbers.reason for each in (half, quarter) if each.numbers.pga_safe_g is None]
        row = levels.row(task.state, task.motion.name, tolerance)
        found.rows.append(row.replace(met=False) if failed else row)
        found.warnings += [
            headed(title, message("a finer time step fails: {reason}", reason=reason or ""))
            for reason in failed[:1]
        ]
        found.warnings += [] if failed else levels.missed(title, tolerance, "tolerance_g or time_step_s")
    return found


def _bracket(search: DynamicResult[Search]) -> Bracket:
    """Return the bracket of a search."""
    numbers = search.numbers
    _, certain = numbers.pga_collapse_g_range or (None, None)
    return Bracket(known(numbers.pga_safe_g), numbers.pga_collapse_g, certain, ())
