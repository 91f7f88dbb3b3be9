"""A run from the project to the output folder, some of its stages, and the report of stored results.

Imports are late: a run in which nothing has changed needs neither the analyses nor the figures.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assessment.runtime.errors import ProjectError, nearest
from assessment.runtime.files import clear, clear_left_over, file_digest
from assessment.runtime.journal import Journal, locked
from assessment.runtime.pool import KilledError
from assessment.runtime.tasks import Outcome
from assessment.workflow.output import key_of, prepare, recall, remember, write

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.runtime.progress import Show


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
    """Return the project with only some of its stages, and what these need.

    Raises ProjectError for a stage that does not exist, or where the project has none of them.
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
    contacts = (*project.pushed_contacts, *project.dynamic_contacts)
    dropped: dict[str, Any] = {
        table: () if table == "history" else None
        for stage, table in STAGES.items()
        if stage not in wanted and table != "settlements"
    }
    dropped["moved_contacts"] = tuple(dict.fromkeys(contacts)) if "pushdown" in wanted else ()
    if not {"pushover", "history", "incremental"} & {*wanted} and not project.mechanism:
        dropped["strengthening"] = ()  # nothing is left that pushes or shakes it
    if "scenarios" not in wanted:
        whole = (each.model_copy(update={"steps": None}) for each in project.settlements)
        dropped["settlements"] = tuple(whole)
    if {*wanted} == {"identification"} and not project.mechanism:
        dropped["settlements"] = ()  # it moves supports by itself
    return project.model_copy(update=dropped)


def carry_out(
    project: Project,
    folder: Path,
    jobs: int,
    fresh: bool,
    report: bool,
    show: Show,
    scheduler: str | None = None,
) -> tuple[Outcome, list[str]]:
    """Carry out what the project asks for and write `folder`, unless an earlier run left the same; return warnings too.

    `jobs`: processes, 0: as many as help; `scheduler`: address of a Dask cluster instead; `fresh`: nothing stored is
    used. Raises BusyError while another run writes into the folder.
    """
    key = key_of(project)
    last = None if fresh else recall(folder)
    if last and last.stands(folder, key, report):
        return last.outcome(folder), last.warnings
    clear_left_over(project.folder)
    with locked(folder):
        clear(folder)
        show = Journal(folder, show)
        from assessment.project.structure.model import build_model
        from assessment.report.chapters.judgement import refuse_unreadable
        from assessment.runtime.cache import FOLDER, Store
        from assessment.workflow.stages import run

        refuse_unreadable(folder)
        model, store = build_model(project), Store(folder / FOLDER)
        outcome = run(project, model, jobs, store, fresh, show, partial(prepare, report), scheduler)
        show.begin("report" if report else "figures and tables", 1, 0, 1.0)
        warnings = write(outcome.results, folder, report, jobs, project.attachments(), show.reached)
        remember(folder, outcome, key, warnings)
        show.advance(1.0)
        show.end()
    return outcome, warnings


def print_again(project: Project, folder: Path) -> list[str]:
    """Render everything again from the results in `folder`, with the title page of the project; return warnings.

    Raises ValueError for results that are missing or cannot be printed (damaged, of another version), BusyError.
    """
    from assessment.results.file import read_results
    from mechanics.messages import message

    stored = folder / "results.json"
    if not stored.is_file():
        raise ValueError(f"{stored}: no stored results; run the project first (assesto run {project.folder})")
    with locked(folder):
        clear(folder)
        results, last = read_results(stored), recall(folder)
        edited = last is not None and last.files.get(stored.name) != file_digest(stored)
        doubt = message(
            "results.json was changed after the run that wrote it: numbers printed from it may not be computed ones"
        )
        warnings: list[str] = [doubt] if edited else []
        try:
            page, known = project.content(), results.quality.warnings
            results = results.replace(
                title=page["title"],
                echo=results.echo.replace(title=page["title"], report=page["report"]),
                quality=results.quality.replace(
                    warnings=[*known, *(text for text in warnings if text not in known)]
                ),
            )
            warnings += write(results, folder, jobs=0, attachments=project.attachments())
        except (OSError, KilledError, ProjectError):  # that name another file
            raise
        except Exception as error:  # edited numbers may break any table or figure
            if last is not None and not edited and last.key == key_of(project):
                raise  # a fault of the program: the results are unchanged
            text = f"{stored}: damaged or edited, cannot be printed; run the project again"
            raise ValueError(text) from error
        # else the record stays: the results are not those of the run it is of
        if last is not None and not edited:
            key = (
                last.key if last.key == key_of(project) else ""
            )  # that of no run, which would print the page again
            remember(folder, Outcome(results, last.complete, 0, last.analyses), key, warnings)
    return warnings
