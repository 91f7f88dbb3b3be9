"""A run from the project to the output folder, and the report of stored results; unchanged parts are not made again.

Imports are late: a run in which nothing has changed needs neither the analyses nor the figures.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assessment.runtime.files.journal import journal
from assessment.runtime.files.lock import locked
from assessment.runtime.files.swap import clear
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
    from assessment.runtime.tasks import Show

Results = dict[str, Any]
EDITED = (
    "results.json was changed after the run that wrote it: numbers printed from it may not be computed ones"
)


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
    with locked(folder):
        clear(folder)
        last = None if fresh else recall(folder)
        if last and last.results == keys.results and last.intact(folder, RESULTS):
            outcome = last.outcome(folder)
            _retitle(outcome.results, project)
            outcome.results["inputs"][project.source] = project.digests()[project.source]
        else:
            with journal(folder, show) as told:
                outcome = _analysed(project, folder, jobs, fresh, report, told, scheduler)
        standing = last.standing(folder, keys) if last else frozenset()
        show.begin("report" if report else "figures and tables", 1, 0)
        from assessment.workflow.output import write

        warnings = write(
            outcome.typed, outcome.results, folder, parts - standing, standing, jobs, project.attachments()
        )
        if last and REPORT in standing:
            warnings = [*last.warnings, *warnings]
        remember(folder, outcome, keys, parts | standing, warnings)
        show.end()
    return outcome, warnings


def _analysed(
    project: Project, folder: Path, jobs: int, fresh: bool, report: bool, show: Show, scheduler: str | None
) -> Outcome:
    from assessment.project.model import build_model
    from assessment.report.judgement_file import NAME, read_judgement
    from assessment.runtime.cache import FOLDER, Store
    from assessment.workflow.output import prepare
    from assessment.workflow.stages import run

    if (folder / NAME).is_file():
        read_judgement(folder / NAME)  # a file that cannot be read is refused before any analysis
    model = build_model(project)
    return run(project, model, jobs, Store(folder / FOLDER), fresh, show, partial(prepare, report), scheduler)


def print_again(project: Project, folder: Path) -> list[str]:
    """Render the report, figures and tables again from the results in `folder`, without any analysis.

    Title page and language are those of the project. Return warnings. Raises ValueError for results that are missing
    or cannot be printed (damaged, edited, of another version), BusyError as `carry_out`.
    """
    from assessment.results.file import read_content, typed
    from assessment.workflow.output import write

    stored = folder / "results.json"
    if not stored.is_file():
        raise ValueError(f"{stored}: no stored results; run the project first (assesto run {project.folder})")
    with locked(folder):
        clear(folder)
        results, last = read_content(stored), recall(folder)
        edited = last is not None and not last.intact(folder, RESULTS)
        warnings = [EDITED] if edited else []
        try:
            told = results["quality"]["warnings"]
            told += [text for text in warnings if text not in told]
            _retitle(results, project)
            warnings += write(typed(results), results, folder, jobs=0, attachments=project.attachments())
        except (OSError, KilledError):
            raise
        except Exception as error:
            if last is not None and not edited and last.results == keys_of(project).results:
                raise  # a fault of the program: the results are unchanged
            raise ValueError(
                f"{stored}: damaged or edited, cannot be printed; run the project again"
            ) from error
        if (
            last is not None and not edited
        ):  # else the record stays: the results are not those of the run it is of
            keys = keys_with(last.results, project, results["inputs"].get(project.source))
            outcome = Outcome(results, last.complete, 0, last.analyses)
            remember(folder, outcome, keys, EVERYTHING, warnings)
    return warnings


def _retitle(results: Results, project: Project) -> None:
    """Put the project's title page and language into results."""
    page = project.content()
    results["title"] = results["echo"]["title"] = page["title"]
    results["echo"]["report"] = page["report"]
