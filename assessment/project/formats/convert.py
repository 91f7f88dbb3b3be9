"""The two forms of a project file, TOML and spreadsheet: written with explanations, one turned into the other."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assessment.project.formats.comments import commented_toml
from assessment.project.formats.xlsx import to_xlsx
from assessment.runtime.atomic_files import write_atomically
from assessment.runtime.errors import ProjectError

if TYPE_CHECKING:
    from assessment.project.project import Project

TOML, XLSX = SOURCES = ("project.toml", "project.xlsx")


def source_bytes(source: str, content: Mapping[str, Any]) -> bytes:
    """Return the project file called `source` that says `content` and explains its keys."""
    return to_xlsx(content) if source == XLSX else commented_toml(content).encode()


def convert(project: Project) -> tuple[Path, Path]:
    """Write a project's file in the other form; return it, and where the earlier one is kept.

    Only what the earlier file says is written; its own comments stay behind in it. Raises ProjectError where an
    earlier one is kept already, OSError where the folder cannot be written.
    """
    old = project.path(project.source)
    new = old.with_name(XLSX if project.source == TOML else TOML)
    kept = old.with_name(f"{old.name}.old")
    if kept.exists():
        raise ProjectError(f"{kept}: file: exists, and {old.name} would take its place; move it away")
    write_atomically(new, source_bytes(new.name, project.content(defaults=False)))
    old.replace(kept)
    return new, kept
