"""Figures and printed reports that take no time, for tests of all else."""

import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from assessment.report.figures import index as figures


def draw_nothing(patch: pytest.MonkeyPatch) -> None:
    """Write one figure that is as good as empty."""

    def blank(_: object, folder: Path) -> None:
        folder.mkdir()
        (folder / "model.svg").write_text("<?xml?>", encoding="utf-8")

    patch.setattr(figures, "write_figures", blank)
    patch.setattr(figures, "write_images", lambda *_: [])


def print_nothing(patch: pytest.MonkeyPatch) -> None:
    """Make PDF files that only look like one."""
    empty = SimpleNamespace(pages=[])  # heights of blocks cannot be told: figures stay where they are
    printed = SimpleNamespace(write_pdf=lambda: b"%PDF-", render=lambda: empty)
    patch.setitem(sys.modules, "weasyprint", SimpleNamespace(HTML=lambda string: printed))
