"""Sphinx configuration: `make docs` builds these pages into build/docs, with warnings as errors."""

from __future__ import annotations

import re
import sys
from importlib.metadata import version as installed
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

project = "Assesto"
version = release = installed("assesto")
extensions = ["myst_parser", "sphinx.ext.autodoc"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = f"Assesto {version}"
default_role = "code"
autodoc_typehints = "none"  # the signature has them
autodoc_member_order = "bysource"

_QUOTED = re.compile(r"(`[^`]*`)")
_MARKUP = re.compile(r"[*|]|(?<=\w)_(?!\w)")


def _plain(_app: Any, _what: str, _name: str, _obj: Any, _options: Any, lines: list[str]) -> None:
    """Docstrings are plain text: what would be markup in them (d*, |P|, T_) is not meant as such."""
    for number, line in enumerate(lines):
        parts = _QUOTED.split(line)
        parts[::2] = [_MARKUP.sub(lambda sign: "\\" + sign[0], part) for part in parts[::2]]
        lines[number] = "".join(parts)


def setup(app: Any) -> None:
    """Register the hook."""
    app.connect("autodoc-process-docstring", _plain)
