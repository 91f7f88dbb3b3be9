"""The outlines of the blocks of a set of results."""

from __future__ import annotations

from assessment.results.schema import Results
from mechanics.pictures import Shape


def outlines(results: Results) -> Shape:
    """Return the outlines of the blocks in the drawing position."""
    blocks = results.geometry.blocks
    return Shape.of(
        [block.vertices_m for block in blocks],
        [block.centroid_m for block in blocks],
        [block.support is not None for block in blocks],
    )
