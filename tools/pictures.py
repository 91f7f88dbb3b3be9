"""Pictures of the documentation: the same bytes each time they are written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

FOLDER = Path(__file__).parents[1] / "docs" / "pictures"


def write_picture(
    name: str, size: tuple[float, float], draw: Callable[[Figure], None], font_size: float
) -> None:
    """Draw a picture of a size (inches) into docs/pictures."""
    style = {"svg.hashsalt": "assesto", "svg.fonttype": "none", "font.family": "DejaVu Sans"}
    with mpl.rc_context(style | {"font.size": font_size}):
        figure = Figure(figsize=size, layout="constrained")
        draw(figure)
        figure.savefig(FOLDER / name, metadata={"Date": None}, facecolor="white")
