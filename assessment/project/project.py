"""The project file, TOML or spreadsheet: wrong keys, types, ranges told at once, else all that does not fit."""

import math
import os
import re
from collections.abc import Collection, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError

from assessment.project.problems import content_problems, matches, project_error, schema_problems
from assessment.project.schema import Behaviour, ControlTable, Direction, KeyPath, ProjectContent
from assessment.project.schema.motions import GENERATED, SetTable
from assessment.project.toml import commented_toml, read_toml
from assessment.project.xlsx import read_xlsx, to_xlsx
from assessment.runtime.errors import ProjectError
from assessment.runtime.files import file_digest, write_atomically
from mechanics.messages import visible

TOML, XLSX = SOURCES = ("project.toml", "project.xlsx")
CONTROL = re.compile(r"[\x00-\x1f\x7f]")  # a line of a message would end in the middle


class Project(ProjectContent):
    """A checked project: the tables of its file, the folder it lives in and the file's name."""

    folder: Path = Field(description="absolute folder of the project")
    source: str = Field(description="name of the project file in the folder")
    moved_contacts: tuple[Behaviour, ...] = Field(
        default=(), description="contacts under which supports move, beside those of the stages that are left"
    )

    def path(self, name: str) -> Path:
        """Return the file that the project calls `name`, relative to its folder."""
        return self.folder / name

    @property
    def pushed_contacts(self) -> tuple[Behaviour, ...]:
        """Contacts of the pushover."""
        return self.pushover.contacts if self.pushover else ()

    @property
    def dynamic_contacts(self) -> tuple[Behaviour, ...]:
        """Contacts of the dynamic stages; each needs its own settled state."""
        tables = [*self.history, self.incremental, self.campaign]
        return tuple(dict.fromkeys(table.contacts for table in tables if table))

    @property
    def elastic(self) -> bool:
        """Whether any analysis asks for elastic contacts."""
        return "elastic" in (*self.pushed_contacts, *self.dynamic_contacts, *self.moved_contacts)

    def control_point(self, name: str | None = None) -> ControlTable:
        """Return the control point of that name, or the first; stages that need one have one."""
        return next(point for point in self.control if name in (None, point.name))

    def pushover_control(self, direction: Direction) -> ControlTable:
        """Return the control point of the pushover in a direction."""
        control = self.pushover.control if self.pushover else None
        return self.control_point(control.get(direction) if isinstance(control, dict) else control)

    def record_files(self, table: SetTable | None, *keys: str) -> tuple[Path, ...]:
        """Return the files of those keys of a table (all), patterns expanded, as often as named; none of generated."""
        names = [getattr(table, key, None) or () for key in keys or ("records", "vertical_records")]
        patterns = [each for own in names for each in own if not each.startswith(GENERATED)]
        return tuple(file for each in patterns for file in matches(self.folder, each))

    def attachments(self) -> tuple[Path, ...]:
        """Pictures that end the report."""
        return tuple(map(self.path, self.report.attachments))

    def digests(self) -> dict[str, str]:
        """Return the SHA-256 of every file that a run reads, the project file first, by names with slashes."""
        names = [self.source, self.geometry.drawing]
        if self.assessment and self.assessment.site and self.assessment.site.grid:
            names.append(self.assessment.site.grid)
        for history in self.history:
            names += [name for name in (history.record, history.vertical_record) if name]
        for path in (*self.record_files(self.incremental), *self.record_files(self.campaign)):
            names.append(path.as_posix())
            with suppress(ValueError):  # on another drive
                names[-1] = Path(os.path.relpath(path, self.folder)).as_posix()
        return {name: file_digest(self.path(name)) for name in names}

    def content(self, defaults: bool = True) -> dict[str, Any]:
        """Return the content of the file as plain values, without absent tables; by default with all defaults."""
        own = {"folder", "source", "moved_contacts"}
        return self.model_dump(mode="json", exclude=own, exclude_none=True, exclude_unset=not defaults)

    def echoed(self) -> dict[str, Any]:
        """Return the content with all defaults but those of [[region]], which are no keys over those of a layer."""
        given = self.content(defaults=False)
        return self.content() | {key: given[key] for key in given.keys() & {"region"}}


def load_project(folder: Path | str) -> Project:
    """Read and check the project in `folder` (or its file). Raises ProjectError with a line per problem."""
    project, contradictions = survey_project(folder)
    if contradictions is not None:
        raise contradictions
    return project


def survey_project(folder: Path | str) -> tuple[Project, ProjectError | None]:
    """Return a project and what does not fit together in it (None: nothing). Raises ProjectError for wrong keys."""
    try:
        file = project_file(folder)
        content, places, faults = read_xlsx(file) if file.suffix == ".xlsx" else (read_toml(file), {}, [])
    except OSError as error:
        raise ProjectError(f"{error.filename}: project: {error.strerror}; make it readable") from None
    try:
        tables = ProjectContent.model_validate(content)
    except ValidationError as error:
        wrong = str(project_error(file.name, schema_problems(error, content), places))
        raise ProjectError("\n".join([*faults, wrong])) from None
    if faults:
        raise ProjectError("\n".join(faults))
    problems = list(content_problems(tables, file.parent))
    given = {name: getattr(tables, name) for name in tables.model_fields_set}
    project = Project(**given, folder=file.parent, source=file.name)
    return project, project_error(file.name, problems, places) if problems else None


def json_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of the project file, for editors."""
    schema = ProjectContent.model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | schema | {"title": "Assesto project"}


def spelt(value: Any) -> Any:
    """Return the content of the project file with infinity as the text "inf": JSON has no infinity."""
    if isinstance(value, dict):
        return {key: spelt(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [spelt(each) for each in value]
    return "inf" if value == math.inf else value


def project_file(folder: Path | str) -> Path:
    """Return the project file in `folder`, or the file itself. Raises ProjectError where there is none."""
    path = Path(folder).absolute()
    if CONTROL.search(str(path)):
        raise ProjectError(f"{visible(str(path))}: project: control characters in the name; rename it")
    if path.name in SOURCES and path.is_file():
        return path
    if path.is_file():
        raise ProjectError(f"{path}: project: a file; give the folder that holds {' or '.join(SOURCES)}")
    if not path.is_dir():
        raise ProjectError(f"{path}: project: no such folder; give the folder that holds {SOURCES[0]}")
    found = [path / name for name in SOURCES if (path / name).is_file()]
    if len(found) > 1:
        raise ProjectError(f"{path}: project: holds {' and '.join(SOURCES)}; keep one of them")
    if not found:
        raise ProjectError(f"{path}: project: holds no {' or '.join(SOURCES)}; write one (assesto new)")
    return found[0]


def source_bytes(source: str, content: Mapping[str, Any], marked: Collection[KeyPath] = ()) -> bytes:
    """Return the project file called `source` that explains every key, and which are to be filled in (`marked`)."""
    return to_xlsx(content, marked) if source == XLSX else commented_toml(content, marked).encode()


def convert(old: Path, content: Mapping[str, Any]) -> tuple[Path, Path]:
    """Write the `old` project file in the other form; return that, and where `old` is kept. Raises ProjectError."""
    new = old.with_name(XLSX if old.name == TOML else TOML)
    kept = old.with_name(f"{old.name}.old")
    if kept.exists() and kept.read_bytes() != old.read_bytes():
        raise ProjectError(f"{kept}: file: exists, and {old.name} would take its place; move it away")
    write_atomically(new, source_bytes(new.name, content))
    old.replace(kept)
    return new, kept
