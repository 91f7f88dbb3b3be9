"""Runs the scripts of docs/gallery.md; as a program it writes their pictures into docs/pictures."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path
from typing import Any
from unittest.mock import patch

import matplotlib as mpl
import matplotlib.pyplot as plt

ROOT = Path(__file__).resolve().parents[1]
SCRIPT = re.compile(r"^## ([^\n]+)\n.*?^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


def scripts() -> dict[str, str]:
    """Return the scripts by their headings."""
    return dict(SCRIPT.findall((ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")))


def carried_out(script: str, folder: Path) -> tuple[dict[str, Any], str]:
    """Run a script in a folder; return its names and what it printed. Its pictures are the same at every run."""
    names: dict[str, Any] = {}
    same = {"svg.hashsalt": "assesto", "backend": "agg", "svg.fonttype": "none"}
    with (
        contextlib.redirect_stdout(io.StringIO()) as said,
        contextlib.chdir(folder),
        mpl.rc_context(same),
        patch.dict("os.environ", SOURCE_DATE_EPOCH="0"),
    ):
        exec(compile(script, "docs/gallery.md", "exec"), names)
    plt.close("all")
    return names, said.getvalue()


if __name__ == "__main__":
    for script in scripts().values():
        carried_out(script, ROOT / "docs" / "pictures")
