"""The work of `assesto check` grows no faster than n log n in blocks and in vertices: counted, not timed.

What is counted: calls of functions, and memory at its peak. Loops over pairs would show in the first, arrays over pairs
in the second; both are the same on a busy machine.
"""

import math
import sys
import tracemalloc
from pathlib import Path
from types import FrameType

import numpy as np
import pytest

from assessment.project.catalogue.new_project import new_project, write_drawing
from assessment.project.model import build_model
from assessment.project.project import load_project
from tests.support.block_project import block
from tests.support.structures import rectangle

SLACK = 1.15
FIXED = 2**20  # bytes: what one run allocates more than another, whatever its size


def calls_and_memory(folder: Path) -> tuple[int, int]:
    """Return how many functions a check of the project calls, and the most bytes that it holds."""
    build_model(load_project(folder))  # everything is imported and compiled
    calls = 0

    def count(_: FrameType, event: str, __: object) -> None:
        nonlocal calls
        calls += event in {"call", "c_call"}

    sys.setprofile(count)
    try:
        build_model(load_project(folder))
    finally:
        sys.setprofile(None)
    tracemalloc.start()
    try:
        build_model(load_project(folder))
        memory = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    return calls, memory


def wall(folder: Path, count: int) -> Path:
    """A wall of count × count blocks."""
    new_project(folder, "wall", {"blocks": count, "courses": count})
    return folder


def comb(folder: Path, teeth: int) -> Path:
    """One block on a base, its top a comb of 2 teeth + 3 vertices."""
    folder.mkdir()
    x = np.linspace(0.3, -0.3, 2 * teeth + 1)
    top = np.column_stack([x, 4.2 - 0.2 * (np.arange(len(x)) % 2)])
    outline = np.vstack([[[-0.3, 0.0], [0.3, 0.0]], top])
    base = np.array(rectangle(-0.5, -0.2, 0.5, 0.0))
    write_drawing(folder / "geometry.dxf", {"BASE": [base], "BLOCK": [outline]})
    text = block().replace("point_m = [0.3, 4.2]", "point_m = [0.3, 2.0]")
    text = text.replace("point_m = [-0.3, 4.2]", "point_m = [-0.3, 2.0]")
    (folder / "project.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.mark.parametrize(
    ("draw", "small", "large", "n"),
    [(wall, 6, 12, lambda count: count**2), (comb, 100, 800, lambda teeth: 2 * teeth + 3)],
    ids=["blocks", "vertices"],
)
def test_work_grows_no_faster_than_n_log_n(tmp_path, draw, small, large, n):
    (calls, memory), (more, peak) = (calls_and_memory(draw(tmp_path / str(k), k)) for k in (small, large))
    allowed = SLACK * n(large) * math.log(n(large)) / (n(small) * math.log(n(small)))
    assert more / calls <= allowed
    assert (peak - FIXED) / memory <= allowed
