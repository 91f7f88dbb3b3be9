"""How far dynamic results are from converged: peaks in the segments of joints, collapses in segments and time step.

Elastic histories are run again with twice and with four times the segments, at the time step given. A PGA at collapse
is looked for again about where it was found, with half the time step and, where contacts are elastic, four times the
segments: a few runs beside those of the search. Results stay as they are; only their error is told.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from assessment.campaign import Campaign, starts_of
from assessment.convergence import Levels, accuracy_of
from assessment.dynamics import StageResult, history
from assessment.histories import history_tasks, peak
from assessment.incremental import Bracket, search_again, search_title
from assessment.increments import finest_settlements
from assessment.segments import TIMES, Estimates, finer, too_few
from assessment.states import Request, analyse_states

if TYPE_CHECKING:
    from assessment.base_motion import BaseMotion
    from assessment.project_schema import MotionTable

AGAIN = 6  # motions that a bracket looked for again costs, about, at two to eight runs


def in_more_segments(campaign: Campaign, halvings: Mapping[str, int]) -> list[Campaign]:
    """Return the campaign with more segments in every joint, as many times over as the errors asked for need.

    `halvings`: of each state's increments. None for rigid contacts, which do not depend on segments.
    """
    project = campaign.project
    if accuracy_of(project).tolerance is None:
        return []
    incremental = _elastic([project.incremental] if project.incremental else [])
    if shaken := _elastic(project.history):
        return [_with_segments(campaign, [*shaken, *incremental], halvings, times) for times in TIMES]
    return [_with_segments(campaign, incremental, halvings, TIMES[-1])] if incremental else []


def peaks_in_more_segments(
    campaign: Campaign, refined: Sequence[Campaign], motions: list[BaseMotion], given: Sequence[StageResult]
) -> Estimates:
    """Estimate what segments without end would change of peak displacements; `given`: the histories in their order.

    Where one number of segments collapses and another does not, the error is not known.
    """
    found, tolerance = Estimates(), accuracy_of(campaign.project).tolerance
    kept = [
        (n, stage.convergence)
        for n, stage in enumerate(given)
        if stage.numbers["contacts"] == "elastic" and stage.convergence is not None
    ]
    if tolerance is None or not kept:
        return found
    runs = []
    for each in refined:
        tasks = history_tasks(each, motions)
        runs.append(each.each("segments: history", history, [tasks[n] for n, _ in kept], 1))
    found.seconds = sum(stage.seconds for stages in runs for stage in stages)
    for (_, row), *stages in zip(kept, *runs, strict=True):
        at_step_given = {key: values[0] for key, values in row["levels"].items()}
        levels = Levels(campaign.model.size, (at_step_given, *map(peak, stages)), result=0)
        same = {"state": row["state"], "record": row["record"]}
        found.rows.append(same | levels.numbers(tolerance))
        title = f"{row['state']}, history of {row['record']}"
        found.warnings += _peak_warnings(title, levels, stages, tolerance)
    return found


def collapses_again(
    campaign: Campaign, refined: Sequence[Campaign], motions: list[BaseMotion], given: Sequence[StageResult]
) -> Estimates:
    """Estimate the error of the PGA at collapse; `given`: the searches in their order.

    It is the width of the bracket and twice the distance to the PGA that the finer analysis gives: by a method of first
    order, half the step leaves half of the error.
    """
    found, project = Estimates(), campaign.project
    table, tolerance = project.incremental, accuracy_of(project).tolerance
    if table is None or tolerance is None:
        return found
    close = refined[-1] if table.contacts == "elastic" else campaign
    tasks = [
        (model, motion.at_half_step(), setting, state, start, Bracket(safe, stage.numbers["pga_collapse_g"], ()))
        for (model, motion, setting, state, start), stage in zip(close.tasks(table, motions), given, strict=True)
        for safe in [stage.numbers["pga_safe_g"]]
        if safe is not None
    ]  # fmt: skip
    again = close.each("finer: incremental", search_again, tasks, AGAIN, table.max_scale, table.tolerance_g)
    found.seconds = sum(stage.seconds for stage in again)
    for (_, motion, _, state, _, near), stage in zip(tasks, again, strict=True):
        measured = ({"pga_collapse_g": each} for each in (near.collapse, stage.numbers["pga_collapse_g"]))
        levels = Levels(campaign.model.size, tuple(measured), result=0, resolution=near.width)
        found.rows.append({"state": state, "record": motion.name, **levels.numbers(tolerance)})
        found.warnings += _collapse_warnings(search_title(state, motion), levels, stage, tolerance)
    return found


def _peak_warnings(title: str, levels: Levels, stages: Sequence[StageResult], tolerance: float) -> list[str]:
    """Return what is wrong with a peak in more segments; `stages`: the histories in more of them."""
    why = next((stage.numbers["reason"] for stage in stages if stage.numbers["collapsed"] is None), "")
    if why:
        return [f"{title}: more segments_per_joint fail: {why}"]
    first, *others = (None in level.values() for level in levels.measured)
    if any(others) and not first:
        return [
            f"{title}: collapses with more segments_per_joint than those given, the error of its peak is not known; "
            "take more of them"
        ]
    if first and not all(others):
        return [
            f"{title}: does not collapse with more segments_per_joint than those given; take more of them"
        ]
    return too_few(title, levels, tolerance)


def _collapse_warnings(title: str, levels: Levels, stage: StageResult, tolerance: float) -> list[str]:
    """Return what is wrong with a PGA at collapse; `stage`: the finer search."""
    if stage.numbers["pga_safe_g"] is None:
        why = stage.numbers["reason"]
        return [f"{title}: a finer time step or more segments_per_joint fail: {why}"]
    if levels.within(tolerance):
        return []
    said = "; ".join(levels.missed(tolerance))
    return [
        f"{title}: estimated error of {said} with the tolerance_g, time_step_s and segments_per_joint given, "
        f"tolerance {100.0 * tolerance:.2g} %; refine them"
    ]


def _elastic(tables: Iterable[MotionTable]) -> list[MotionTable]:
    return [table for table in tables if table.contacts == "elastic"]


def _with_segments(
    campaign: Campaign, tables: Sequence[MotionTable], halvings: Mapping[str, int], times: int
) -> Campaign:
    """Return the campaign with so many times the segments, the settled states those that the tables begin from."""
    project, model = campaign.project, finer(campaign.model, times)
    settled = analyse_states(
        [
            Request(project.model_copy(update={"pushover": None}), model, settlement, "elastic")
            for settlement in finest_settlements(project, halvings)
            if any(table.states is None or settlement.name in table.states for table in tables)
        ],
        campaign.workers,
        "segments",
    )
    return replace(
        campaign, model=model, starts={**campaign.starts, **starts_of(["elastic"], model, settled)}
    )
