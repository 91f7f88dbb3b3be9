"""A run, from project to output folder, and the report again; imports are late: what has not changed needs few."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assessment.report.printing import printable
from assessment.runtime import cache
from assessment.runtime import files as disk
from assessment.runtime.cache import FOLDER, Store, unpacked
from assessment.runtime.errors import ProjectError, nearest
from assessment.runtime.pool import KilledError, Pool, processes, result_of
from assessment.runtime.progress import Stage, locked
from assessment.runtime.tasks import Outcome
from assessment.workflow import STAGES

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.results.schema import Results
    from assessment.runtime.progress import Show

PLACES = """results.json figures/*.svg figures/*.png figures/*.dxf tables/*.csv tables/fragility.xml judgement.md
report.html report.pdf report.docx attachments/*.png attachments/*.jpg"""  # of a run's files; all else is the user's
ENTRY = "last"  # of the record, in the store


def key_of(project: Project) -> str:
    """Return a digest of what a run of the project writes depends on: the program, and every file that it reads."""
    attached = [disk.file_digest(path) for path in project.attachments()]
    return cache.digest([cache.program(), cache.printing(), project.content(), project.digests(), attached])


@dataclass(frozen=True)
class LastRun:
    """What a run left: its key, the digests of its files, warnings, what the terminal tells, whether it is complete."""

    key: str
    files: Mapping[str, str]
    complete: bool
    analyses: int
    warnings: list[str]
    told: str

    def outcome(self, folder: Path) -> Outcome:
        """Return the outcome stored in the folder; none of its analyses is computed again."""
        from assessment.results.schema import read_results  # late: see above

        return Outcome(read_results(folder / "results.json"), self.complete, 0, self.analyses, self.told)

    def stands(self, folder: Path, key: str, report: bool) -> bool:
        """Return whether a run with this key, with its `report` or without, would leave the folder as it is."""
        if self.key != key or self.files != _digests(folder):
            return False
        if not report:
            return True
        return "report.html" in self.files and ("report.pdf" in self.files or not printable())


def recall(folder: Path) -> LastRun | None:
    """Return the record of the last run in an output folder; None if there is none that can be read."""
    text = Store(folder / FOLDER).read(ENTRY)
    with suppress(Exception):  # of another version, or none at all
        return unpacked(text, LastRun) if text else None
    return None


def remember(folder: Path, outcome: Outcome, key: str, warnings: list[str]) -> None:
    """Store the record of a run in its output folder, for the next run."""
    number = outcome.computed + outcome.taken
    left = LastRun(key, _digests(folder), outcome.complete, number, warnings, outcome.told)
    Store(folder / FOLDER).keep(ENTRY, json.dumps(asdict(left)))


def _digests(folder: Path) -> dict[str, str]:
    return {name: disk.file_digest(folder / name) for name in _files(folder)}


def _files(folder: Path) -> list[str]:
    """Return the names of the files of a run, relative to its folder, with slashes."""
    found = (path for place in PLACES.split() for path in folder.glob(place))
    return sorted(path.relative_to(folder).as_posix() for path in found if path.is_file())


def write(
    results: Results, folder: Path, report: bool = True, jobs: int = 1, attachments: Sequence[Path] = ()
) -> list[str]:  # fmt: skip
    """Write all that is made of results into `folder`, for that of earlier ones; a judgement that was edited is kept.

    `jobs`: processes, 0: one per core. Raises KilledError, or OSError that names a file; all is then unchanged.
    """
    from assessment.report.chapters.judgement import NAME
    from mechanics.messages import message

    folder.mkdir(parents=True, exist_ok=True)
    before = _version(opinion := folder / NAME)
    gone = _files(folder) if (folder / "results.json").exists() else []
    with tempfile.TemporaryDirectory(prefix=disk.SCRATCH, dir=folder, ignore_cleanup_errors=True) as scratch:
        new = Path(scratch)
        try:
            warnings = _make(results, folder, new, report, jobs, attachments)
            if _version(opinion) not in (None, before):
                disk.write_atomically(new / NAME, opinion.read_bytes())
                warnings.append(message("judgement.md was changed while the report was made: print it again"))
            disk.put_in_place(new, folder, _files(new), gone)
        except KilledError as error:
            raise KilledError(f"{'report' if report else 'figures and tables'}: {error}") from None
        except OSError as error:
            name = error.filename
            if name and Path(name).is_relative_to(new):  # named where the user will look for it
                name = str(folder / Path(name).relative_to(new))
            raise OSError(error.errno, error.strerror, name) from error
    return warnings


def _make(
    results: Results, folder: Path, new: Path, report: bool, jobs: int, attachments: Sequence[Path]
) -> list[str]:  # fmt: skip
    """Make everything in the folder `new`; return warnings."""
    from assessment.report.chapters.judgement import NAME, judgement
    from assessment.report.document import write_attachments, write_docx, write_page, write_pdf, write_tables
    from assessment.report.figures.index import write_figures, write_images
    from assessment.report.language import words_of
    from assessment.results.schema import as_bytes

    opinion = judgement(results, words_of(results), folder)
    disk.write_atomically(new / NAME, opinion.content)
    number = processes(jobs)
    with Pool(number if number > 1 else 0, results) as pool:
        write_figures(pool, new / "figures")
        begun: list[Future[Any]] = []
        if report:
            write_attachments(attachments, new)
            begun.append(pool.apply(write_pdf, new, opinion.edited))  # first: it takes longest
            begun.append(pool.apply(write_page, new, opinion.edited))
        images = write_images(pool, new / "figures")
        begun.append(pool.apply(write_tables, new / "tables"))
        for work in images:
            result_of(work)
        if report:  # its figures are the images
            begun.append(pool.apply(write_docx, new, opinion.edited))
        disk.write_atomically(new / "results.json", as_bytes(results))
        done = [result_of(work) for work in begun]
    return [*opinion.warnings, *(done[0] if report else [])]


def _version(path: Path) -> tuple[int, int] | None:
    """Return time (ns) and size of a file, which change with it; None where there is none."""
    if not path.is_file():
        return None
    now = path.stat()
    return now.st_mtime_ns, now.st_size


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
        missing = f"--only: {wanted[0]}: the project has no [{STAGES[wanted[0]]}]"
        raise ProjectError(f"{missing}; add it, or name a stage that it has")
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
    project: Project, folder: Path, jobs: int, fresh: bool, report: bool, show: Show,
    scheduler: str | None = None,
) -> tuple[Outcome, list[str]]:  # fmt: skip
    """Carry out what the project asks for and write `folder`, unless an earlier run left the same; return warnings too.

    `jobs`: processes, 0: as many as help; `scheduler`: address of a Dask cluster instead; `fresh`: nothing stored is
    used. Raises BusyError while another run writes into the folder.
    """
    key = key_of(project)
    last = None if fresh else recall(folder)
    if last and last.stands(folder, key, report):
        return last.outcome(folder), last.warnings
    with locked(folder):
        disk.clear(folder)
        show.keep_in(folder)
        from assessment.project.model import build_model
        from assessment.report.chapters.judgement import refuse_unreadable
        from assessment.workflow.stages import run

        refuse_unreadable(folder)
        model, store = build_model(project), Store(folder / FOLDER)
        outcome = run(project, model, jobs, store, fresh, show, scheduler)
        show.begin(stage := Stage("report" if report else "figures and tables", 1, 0, 1.0))
        warnings = write(outcome.results, folder, report, jobs, project.attachments())
        remember(folder, outcome, key, warnings)
        stage.reach(1.0, 1)
        show.end(stage)
    return outcome, warnings


def print_again(project: Project, folder: Path) -> list[str]:
    """Render everything again from the results in `folder`, with the title page of the project; return warnings.

    Raises ValueError for results that are missing or cannot be printed (damaged, of another version), BusyError.
    """
    from assessment.report.chapters.judgement import told
    from assessment.results.schema import read_results
    from mechanics.messages import message

    stored = folder / "results.json"
    if not stored.is_file():
        raise ValueError(f"{stored}: no stored results; run the project first (assesto run {project.folder})")
    with locked(folder):
        disk.clear(folder)
        results, last = read_results(stored), recall(folder)
        edited = last is not None and last.files.get(stored.name) != disk.file_digest(stored)
        doubt = message(
            "results.json was changed after the run that wrote it: numbers printed from it may not be computed ones"
        )
        warnings: list[str] = [doubt] if edited else []
        try:
            page, known = project.content(), results.quality.warnings
            results = results.replace(
                title=page["title"],
                echo=results.echo.replace(title=page["title"], report=page["report"]),
                quality=results.quality.replace(warnings=[*known, *(x for x in warnings if x not in known)]),
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
            # that of no run where the page would be printed again
            key = last.key if last.key == key_of(project) else ""
            remember(folder, Outcome(results, last.complete, 0, last.analyses, told(results)), key, warnings)
    return warnings
