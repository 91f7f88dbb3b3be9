"""The stages of a project that a run carries out."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from assessment.runtime.errors import ProjectError, nearest

if TYPE_CHECKING:
    from assessment.project.project import Project

STAGES = {  # stage: table
    "pushdown": "settlements",
    "pushover": "pushover",
    "history": "history",
    "incremental": "incremental",
    "campaign": "campaign",
    "assessment": "assessment",
    "scenarios": "settlements",
    "sensitivity": "sensitivity",
    "identification": "identification",
}
HAVE_IT = "add it, or name a stage that it has"


def select(project: Project, only: Iterable[str] | None) -> Project:
    """Return the project with only some of its stages.

    Raises ProjectError for a stage that does not exist, and where the project has none of them.

    Settlements stay if a stage other than the assessment needs the settled states; the stage pushdown moves supports
    under all contacts that the project asks for.
    """
    if only is None:
        return project
    wanted = list(only)
    for name in wanted:
        if name not in STAGES:
            raise ProjectError(f"--only: {name}: no such stage; {nearest(name, STAGES)}")
    if not any(getattr(project, STAGES[name]) for name in wanted):
        raise ProjectError(f"--only: {wanted[0]}: the project has no [{STAGES[wanted[0]]}]; {HAVE_IT}")
    if "sensitivity" in wanted and "assessment" not in wanted:
        wanted.append("assessment")
    if "campaign" in wanted and project.campaign:  # which sets the static check beside
        wanted += ["assessment"] if project.assessment else ["pushover"]
    if {"assessment", "scenarios"} & {*wanted} and "pushover" not in wanted:
        wanted.append("pushover")
    by_record = project.assessment is not None and project.assessment.spectrum == "record"
    if "assessment" in wanted and "history" not in wanted and by_record:
        raise ProjectError('--only: assessment: spectrum = "record" needs the history stage; add history')
    moved = (
        dict.fromkeys((*project.pushed_contacts, *project.dynamic_contacts)) if "pushdown" in wanted else ()
    )
    dropped: dict[str, Any] = {
        table: () if table == "history" else None
        for stage, table in STAGES.items()
        if stage not in wanted and table != "settlements"
    }
    dropped["moved_contacts"] = tuple(moved)
    if not {"pushover", "history", "incremental"} & {*wanted} and not project.mechanism:
        dropped["strengthening"] = ()  # nothing is left that pushes or shakes it
    if "scenarios" not in wanted:
        whole = (each.model_copy(update={"steps": None}) for each in project.settlements)
        dropped["settlements"] = tuple(whole)
    if {*wanted} == {"identification"} and not project.mechanism:
        dropped["settlements"] = ()  # it moves supports by itself
    return project.model_copy(update=dropped)
