"""The output folder: each set of files appears whole or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assessment.report.formats.pdf import printable
from assessment.runtime.files.atomic_files import write_atomically
from assessment.runtime.files.swap import SCRATCH, put_in_place
from assessment.runtime.processes.pool import KilledError, Pool, processes, result_of
from assessment.workflow.earlier import (
    EVERYTHING,
    FIGURES,
    JUDGEMENT,
    REPORT,
    RESULTS,
    TABLES,
    files_of,
)

if TYPE_CHECKING:
    from assessment.results.schema import Results

PRINTED = 4  # figures that the PDF takes as long as, per figure of the results: 3 to 6
SHEETS = 3  # page, DOCX, tables: each takes about as long as a figure


def prepare(report: bool) -> None:
    """Import what `write` needs; it takes nearly two seconds, which other processes use to compute."""
    import pandas  # noqa: F401

    import assessment.report.figures.animation
    import assessment.report.figures.index

    if report:
        import assessment.report.document  # noqa: F401

        printable()


def write(
    results: Results,
    folder: Path,
    parts: Collection[str] = EVERYTHING,
    kept: Collection[str] = (),
    jobs: int = 1,
    attachments: Sequence[Path] = (),
    tell: Callable[[float], object] = lambda _: None,
) -> list[str]:
    """Write parts of what is made of results into `folder`, all at once; each set appears whole or not at all.

    Parts `kept` stay unchanged; all other files of earlier results are removed. A judgement.md that was edited
    is kept and printed. Return warnings (a PDF that could not be made). `jobs`: processes, 0: one per core;
    `attachments`: pictures that end the report; `tell`: is given the share that is made, about. Raises
    KilledError if one of them was ended from outside, OSError that names a file; the folder is then unchanged.
    """
    folder.mkdir(parents=True, exist_ok=True)
    ours = (folder / "results.json").exists()
    with tempfile.TemporaryDirectory(prefix=SCRATCH, dir=folder, ignore_cleanup_errors=True) as scratch:
        new = Path(scratch)
        try:
            for name in files_of(folder, kept):  # the report is made with them
                _linked(folder / name, new / name)
            warnings = _make(results, folder, new, parts, jobs, attachments, tell)
            gone = files_of(folder, EVERYTHING - {*kept}) if ours else []
            put_in_place(new, folder, files_of(new, parts), gone)
        except KilledError as error:
            raise KilledError(f"{', '.join(sorted(parts))}: {error}") from None
        except OSError as error:
            raise OSError(error.errno, error.strerror, _at_home(error.filename, new, folder)) from error
    return warnings


def _make(
    results: Results,
    folder: Path,
    new: Path,
    parts: Collection[str],
    jobs: int,
    attachments: Sequence[Path],
    tell: Callable[[float], object],
) -> list[str]:
    """Make the parts in the folder `new`; return warnings."""
    from assessment.report.chapters.judgement_file import NAME, judgement
    from assessment.report.document import write_docx, write_page, write_pdf
    from assessment.report.figures.animation import write_animations
    from assessment.report.figures.index import pictures, write_figures, write_images
    from assessment.report.formats.attachments import write_attachments
    from assessment.report.tables.index import write_tables
    from assessment.report.text.language import words_of
    from assessment.results.file import as_bytes

    opinion = judgement(results, words_of(results), folder)
    if JUDGEMENT in parts:
        write_atomically(new / NAME, opinion.content)
    number, figures = processes(jobs), len(pictures(results))
    whole = SHEETS + 2 * figures * (FIGURES in parts) + PRINTED * figures * (REPORT in parts)
    made = 0

    def ended(function: Callable[..., Any]) -> None:
        nonlocal made
        made += PRINTED * figures if function is write_pdf else 1
        tell(min(made / whole, 1.0))

    with Pool(number if number > 1 else 0, results, ended) as pool:
        begun: list[Future[Any]] = []
        images: list[Future[None]] = []
        printed: Future[list[str]] | None = None
        if FIGURES in parts:
            write_figures(pool, new / "figures")
        if REPORT in parts:
            write_attachments(attachments, new)
            printed = pool.apply(write_pdf, new, opinion.edited)  # first: it takes longest
            begun.append(pool.apply(write_page, new, opinion.edited))
        if FIGURES in parts:
            images = write_images(pool, new / "figures")
            begun += write_animations(pool, new / "figures")
        if TABLES in parts:
            begun.append(pool.apply(write_tables, new / "tables"))
        for work in images:
            result_of(work)
        if REPORT in parts:  # its figures are the images
            begun.append(pool.apply(write_docx, new, opinion.edited))
        if RESULTS in parts:
            write_atomically(new / "results.json", as_bytes(results))
        for work in begun:
            result_of(work)
        return [*opinion.warnings, *(result_of(printed) if printed else [])]


def _linked(old: Path, new: Path) -> None:
    """Link a file to a second path, or copy it where the file system has no links."""
    new.parent.mkdir(exist_ok=True)
    try:
        os.link(old, new)
    except OSError:
        shutil.copy2(old, new)


def _at_home(name: Any, new: Path, folder: Path) -> Any:
    """Return the final path of a file that was written in the scratch folder."""
    return str(folder / Path(name).relative_to(new)) if name and Path(name).is_relative_to(new) else name
