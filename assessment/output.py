"""The output folder: each file and each set of files appears whole or not at all."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Mapping
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from typing import Any

from assessment.files import write_atomically

SCRATCH = ".assesto-"  # where files are made before they take their place


def prepare(report: bool) -> None:
    """Import what `write` needs: nearly a second's work, which may be done while others compute."""
    import pandas  # noqa: F401

    import assessment.animation
    import assessment.figures

    if report:
        import assessment.report  # noqa: F401

        with suppress(OSError):  # said where the PDF is written
            import weasyprint  # noqa: F401


def write(results: Mapping[str, Any], folder: Path, report: bool = True, jobs: int = 1) -> list[str]:
    """Write results.json, tables, figures and report into `folder`; each appears whole or not at all.

    A judgement.md that was edited is kept and printed. Returns warnings (a PDF that could not be made). results.json
    comes last: where it is new, all is. `jobs`: processes, 0: one per core.
    """
    from assessment.animation import write_animations
    from assessment.crew import Crew
    from assessment.figures import write_figures, write_images
    from assessment.judgement_file import NAME, judgement
    from assessment.report import write_page, write_pdf
    from assessment.tables import write_tables
    from assessment.words import words_of

    folder.mkdir(parents=True, exist_ok=True)
    for left in folder.glob(f"{SCRATCH}*"):  # of a run that was killed
        shutil.rmtree(left)
    warnings: list[str] = []
    with (
        tempfile.TemporaryDirectory(prefix=SCRATCH, dir=folder) as scratch,
        Crew(results, jobs) as crew,
    ):
        new = Path(scratch)
        opinion = judgement(results, words_of(results), folder)
        write_atomically(new / NAME, opinion.text.encode())
        warnings += opinion.warnings
        write_figures(crew, new / "figures")
        printed = crew.do(write_pdf, new, opinion.edited) if report else None  # first: it takes longest
        begun: list[Future[Any]] = [*write_animations(crew, new / "figures")]
        begun += write_images(crew, new / "figures")
        begun.append(crew.do(write_tables, new / "tables"))
        if report:
            begun.append(crew.do(write_page, new, opinion.edited))
        for work in begun:
            work.result()
        if printed:
            warnings += printed.result()
        text = json.dumps(results, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
        write_atomically(new / "results.json", text.encode())
        ours, made_now = (folder / "results.json").exists(), {item.name for item in new.iterdir()}
        for item in sorted(new.iterdir(), key=lambda path: path.name == "results.json"):
            _replace(item, folder / item.name, ours)
        for name in ("report.pdf", "report.html"):  # one of earlier results would stand beside the new ones
            if ours and name not in made_now:
                (folder / name).unlink(missing_ok=True)
    return warnings


def _replace(new: Path, old: Path, ours: bool) -> None:
    """Put a finished file, or each file of a finished folder, in the place of an earlier one.

    `ours`: an earlier run filled the folder, so that what it made and this one did not is removed.
    """
    if not new.is_dir():
        new.replace(old)
        return
    old.mkdir(exist_ok=True)
    names = {item.name for item in new.iterdir()}
    for name in sorted(names):
        (new / name).replace(old / name)
    if ours:
        for stale in {
            item
            for item in old.iterdir()
            if item.suffix in {".csv", ".svg", ".png", ".dxf", ".gif"} and item.name not in names
        }:
            stale.unlink()
