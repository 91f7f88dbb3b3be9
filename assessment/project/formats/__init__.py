"""The two forms of a project file, TOML and spreadsheet: written with explanations, one turned into the other."""

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from assessment.project.formats.toml import commented_toml
from assessment.project.formats.xlsx import to_xlsx
from assessment.project.schema import KeyPath
from assessment.runtime.errors import ProjectError
from assessment.runtime.files import file_digest, write_atomically

TOML, XLSX = SOURCES = ("project.toml", "project.xlsx")


def source_bytes(source: str, content: Mapping[str, Any], marked: Collection[KeyPath] = ()) -> bytes:
    """Return the project file called `source` that explains every key, and which are to be filled in (`marked`)."""
    return to_xlsx(content, marked) if source == XLSX else commented_toml(content, marked).encode()


def convert(old: Path, content: Mapping[str, Any]) -> tuple[Path, Path]:
    """Write the `old` project file in the other form; return that, and where `old` is kept. Raises ProjectError."""
    new = old.with_name(XLSX if old.name == TOML else TOML)
    kept = old.with_name(f"{old.name}.old")
    if kept.exists() and not is_converted(old):
        raise ProjectError(f"{kept}: file: exists, and {old.name} would take its place; move it away")
    write_atomically(kept, old.read_bytes())
    # from here on `old` is_converted: a kill leaves nothing to be mended
    write_atomically(new, source_bytes(new.name, content))
    old.unlink()
    return new, kept


def is_converted(file: Path) -> bool:
    """Return whether a project file has been turned into its other form: what is kept of it is the file itself."""
    kept = file.with_name(f"{file.name}.old")
    return kept.is_file() and file_digest(kept) == file_digest(file)
