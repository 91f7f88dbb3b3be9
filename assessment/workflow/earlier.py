"""The output of an earlier run, and which parts of it this run would write unchanged."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from assessment.report.formats.pdf import printable
from assessment.runtime import fingerprint
from assessment.runtime.cache import FOLDER, Store, unpacked
from assessment.runtime.files.atomic_files import file_digest
from assessment.runtime.outcome import Outcome

if TYPE_CHECKING:
    from assessment.project.project import Project

RESULTS, FIGURES, TABLES, JUDGEMENT, REPORT = PARTS = ("results", "figures", "tables", "judgement", "report")
EVERYTHING = frozenset(PARTS)
NO_REPORT = EVERYTHING - {REPORT}
PLACES = {  # of the files of each part; other files in the folder are the user's
    RESULTS: ("results.json",),
    FIGURES: tuple(f"figures/*.{kind}" for kind in ("svg", "png", "dxf", "gif")),
    TABLES: ("tables/*.csv",),
    JUDGEMENT: ("judgement.md",),
    REPORT: ("report.html", "report.pdf", "report.docx", "attachments/*.png", "attachments/*.jpg"),
}
ENTRY = "last"  # its name in the store


def files_of(folder: Path, parts: Iterable[str]) -> list[str]:
    """Return the names of the files of some parts, relative to the output folder, with slashes."""
    found = (path for part in parts for place in PLACES[part] for path in folder.glob(place))
    return sorted(path.relative_to(folder).as_posix() for path in found if path.is_file())


@dataclass(frozen=True)
class Keys:
    """Digests of what a run depends on: its `results`, and its title `page` beside them; the `language` of both."""

    results: str
    page: str
    language: str

    def of(self, part: str) -> str:
        """Return what a part of the products depends on; of the program, all do."""
        beside = {TABLES: "", FIGURES: self.language, JUDGEMENT: self.language}.get(part, self.page)
        return f"{self.results} {beside}"


def keys_of(project: Project) -> Keys:
    """Return the keys of a run of the project; a change of comments in its file changes the page alone."""
    content, inputs = project.content(), project.digests()
    source = inputs.pop(project.source)
    software = [fingerprint.program(), fingerprint.printing()]
    settings = {key: value for key, value in content.items() if key not in {"title", "report"}}
    results = fingerprint.digest([software, project.source, settings, inputs])
    return keys_with(results, project, source)


def keys_with(results: str, project: Project, source: str | None) -> Keys:
    """Return the keys of results with the project's title page; `source`: digest of the project file they are of."""
    content = project.content()
    attached = [file_digest(path) for path in project.attachments()]
    page = fingerprint.digest([content["title"], content["report"], attached, source])
    return Keys(results, page, project.report.language)


@dataclass(frozen=True)
class Earlier:
    """The output of a run: keys and file digests of each part, warnings, and whether its analyses were completed."""

    results: str
    keys: Mapping[str, str]
    files: Mapping[str, Mapping[str, str]]
    complete: bool
    analyses: int
    warnings: list[str]

    def outcome(self, folder: Path) -> Outcome:
        """Return the outcome stored in the folder; none of its analyses is computed again."""
        from assessment.results.file import read_results  # late: see run.py

        return Outcome(read_results(folder / "results.json"), self.complete, 0, self.analyses)

    def intact(self, folder: Path, part: str) -> bool:
        """Return whether the files of a part are unchanged since they were written, none missing and none added."""
        return part in self.files and _digests(folder, part) == self.files[part]

    def standing(self, folder: Path, keys: Keys) -> frozenset[str]:
        """Return the parts that a run with these keys would write unchanged."""
        found = {part for part in PARTS if self.keys.get(part) == keys.of(part) and self.intact(folder, part)}
        if REPORT in found and (
            JUDGEMENT not in found  # which is printed in it
            or ("report.pdf" not in self.files[REPORT] and printable())
        ):
            found.remove(REPORT)
        return frozenset(found)


def recall(folder: Path) -> Earlier | None:
    """Return the record of the last run in an output folder; None if there is none that can be read."""
    text = Store(folder / FOLDER).read(ENTRY)
    with suppress(Exception):  # of another version, or none at all
        found: Earlier | None = unpacked(text, Earlier) if text else None
        return found
    return None


def remember(folder: Path, outcome: Outcome, keys: Keys, parts: Collection[str], warnings: list[str]) -> None:
    """Store the record of a run in its output folder, for the next run."""
    left = Earlier(
        keys.results,
        {part: keys.of(part) for part in parts},
        {part: _digests(folder, part) for part in parts},
        outcome.complete,
        outcome.computed + outcome.taken,
        warnings,
    )
    Store(folder / FOLDER).keep(ENTRY, json.dumps(asdict(left)))


def _digests(folder: Path, part: str) -> dict[str, str]:
    return {name: file_digest(folder / name) for name in files_of(folder, [part])}
