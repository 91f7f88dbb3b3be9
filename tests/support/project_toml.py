"""A project's content as plain TOML text, without the comments of a new project file."""

from collections.abc import Mapping
from typing import Any

from assessment.project.toml import plain_values, toml_header, toml_line, toml_tables


def to_toml(content: Mapping[str, Any]) -> str:
    """Return the TOML text of a project's content: plain values, lists, tables and lists of tables."""
    lines: list[str] = []
    for path, table in toml_tables(content):
        lines += [*toml_header(path), *(toml_line(key, value) for key, value in plain_values(table).items())]
    return "\n".join(lines).strip() + "\n"
