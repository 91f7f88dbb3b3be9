"""The deepest overlap of two blocks in the certificates: what it is, and when it matters."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from markupsafe import Markup

from assessment.report.text.language import Words
from assessment.results.configurations.hand_check import outline_area
from assessment.results.schema import Results

NOTICED = 0.01  # of the size of a block, the root of its area


def overlap_sentences(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what a penetration is, and the analyses in which the largest is more than a hundredth of a block."""
    size = float(np.median([outline_area(block.vertices_m) ** 0.5 for block in results.geometry.blocks]))
    deep = [row for row in results.quality.by_stage if (row.worst_penetration_m or 0.0) > NOTICED * size]
    if not deep:
        return
    listed = []
    for row in deep:
        stage = ", ".join(words.name("value", part) for part in row.stage.split(", "))
        named = f"{words.state(row.state)}, {stage}" if row.state else stage
        listed.append(f"{named}: {words.millimetres(row.worst_penetration_m)}")
    yield words("text.overlap", where="; ".join(listed))
