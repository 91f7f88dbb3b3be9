"""A run from the project to the output folder, and the report of stored results; unchanged parts are not made again.

Imports are late: a run in which nothing has changed needs neither the analyses nor the figures.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from assessment.runtime.errors import ProjectError
from assessment.runtime.files.atomic_files import clear_left_over
from assessment.runtime.files.lock import locked
from assessment.runtime.files.swap import clear
from assessment.runtime.journal import Journal
from assessment.runtime.outcome import Outcome
from assessment.runtime.processes.pool import KilledError
from assessment.workflow.earlier import (
    EVERYTHING,
    NO_REPORT,
    REPORT,
    RESULTS,
    keys_of,
    keys_with,
    recall,
    remember,
)

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.results.schema import Results
    from assessment.runtime.show import Show


def carry_out(
    project: Project,
    folder: Path,
    jobs: int,
    fresh: bool,
    report: bool,
    show: Show,
    scheduler: str | None = None,
) -> tuple[Outcome, list[str]]:
    """Carry out every stage that the project asks for and write what is made of the results into `folder`.

    If an earlier run wrote the same, nothing is computed or written; if only the title page or the language has
    changed, nothing is computed. `jobs`: processes, 0: as many as help; `scheduler`: address of a Dask cluster in their
    place; `fresh`: stored results are not used. Return
    the outcome of the run, and warnings of the writing. Raises BusyError while another run writes into the folder.
    """
    parts, keys = EVERYTHING if report else NO_REPORT, keys_of(project)
    last = None if fresh else recall(folder)
    if last and parts <= last.standing(folder, keys):
        return last.outcome(folder), last.warnings
    clear_left_over(project.folder)
    with locked(folder):
        clear(folder)
        show = Journal(folder, show)
        last = None if fresh else recall(folder)
        if last and last.results == keys.results and last.intact(folder, RESULTS):
            outcome = _retitled(last.outcome(folder), project)
        else:
            outcome = _analysed(project, folder, jobs, fresh, report, show, scheduler)
        standing = last.standing(folder, keys) if last else frozenset()
        show.begin("report" if report else "figures and tables", 1, 0, 1.0)
        from assessment.workflow.output import write

        warnings = write(
            outcome.results, folder, parts - standing, standing, jobs, project.attachments(), show.reached
        )
        if last and REPORT in standing:
            warnings = [*last.warnings, *warnings]
        remember(folder, outcome, keys, parts | standing, warnings)
        show.advance(1.0)
        show.end()
    return outcome, warnings


def _analysed(
    project: Project, folder: Path, jobs: int, fresh: bool, report: bool, show: Show, scheduler: str | None
) -> Outcome:
    from assessment.project.structure.model import build_model
    from assessment.report.chapters.judgement_file import refuse_unreadable
    from assessment.runtime.cache import FOLDER, Store
    from assessment.workflow.output import prepare
    from assessment.workflow.stages import run

    refuse_unreadable(folder)
    model = build_model(project)
    return run(project, model, jobs, Store(folder / FOLDER), fresh, show, partial(prepare, report), scheduler)


def print_again(project: Project, folder: Path) -> list[str]:
    """Render the report, figures and tables again from the results in `folder`, without any analysis.

    Title page and language are those of the project. Return warnings. Raises ValueError for results that are missing
    or cannot be printed (damaged, edited, of another version), BusyError as `carry_out`.
    """
    from assessment.results.file import read_results
    from assessment.workflow.output import write
    from mechanics.messages import message

    stored = folder / "results.json"
    if not stored.is_file():
        raise ValueError(f"{stored}: no stored results; run the project first (assesto run {project.folder})")
    with locked(folder):
        clear(folder)
        results, last = read_results(stored), recall(folder)
        edited = last is not None and not last.intact(folder, RESULTS)
        doubt = message(
            "results.json was changed after the run that wrote it: numbers printed from it may not be computed ones"
        )
        warnings: list[str] = [doubt] if edited else []
        try:
            known = results.quality.warnings
            quality = results.quality.replace(
                warnings=[*known, *(text for text in warnings if text not in known)]
            )
            results = _titled(results, project).replace(quality=quality)
            warnings += write(results, folder, jobs=0, attachments=project.attachments())
        except (OSError, KilledError, ProjectError):  # that name another file
            raise
        except Exception as error:
            if last is not None and not edited and last.results == keys_of(project).results:
                raise  # a fault of the program: the results are unchanged
            raise ValueError(
                f"{stored}: damaged or edited, cannot be printed; run the project again"
            ) from error
        # else the record stays: the results are not those of the run it is of
        if last is not None and not edited:
            keys = keys_with(last.results, project, results.inputs.get(project.source))
            outcome = Outcome(results, last.complete, 0, last.analyses)
            remember(folder, outcome, keys, EVERYTHING, warnings)
    return warnings


def _titled(results: Results, project: Project) -> Results:
    """Return results with the project's title page and language."""
    page = project.content()
    echo = results.echo.replace(title=page["title"], report=page["report"])
    return results.replace(title=page["title"], echo=echo)


def _retitled(outcome: Outcome, project: Project) -> Outcome:
    """Return an earlier outcome with the project's title page and language, and the digest of its file."""
    results, source = _titled(outcome.results, project), project.source
    digests = results.inputs | {source: project.digests()[source]}
    return replace(outcome, results=results.replace(inputs=digests))
