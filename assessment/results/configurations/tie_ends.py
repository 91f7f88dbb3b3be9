"""Ties in the results: which are in a state, and where their ends are in a configuration."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from assessment.results.configurations.outlines import outlines
from assessment.results.schema import Results
from assessment.results.schema.model import Tie
from mechanics.pictures import field, place
from mechanics.types import Array


def ties_of(results: Results, state: str) -> list[Tie]:
    """Return the ties of a state, in the order of its tensions: those that a strengthening sets come last."""
    there = [tie for tie in results.model.ties or () if state in tie.states]
    return sorted(there, key=lambda tie: state in tie.set_in)


def tie_ends(results: Results, tie: Tie, configuration: ArrayLike) -> Array:
    """Return both ends (2, 2) m of a tie where the blocks are displaced by a configuration (b, 3)."""
    at = np.asarray(configuration, dtype=float)
    return place(np.array([tie.start_m, tie.end_m]), np.array(tie.blocks), outlines(results).centroids, at)


def lengthening(results: Results, tie: Tie, configuration: ArrayLike, rate: ArrayLike) -> float:
    """Return the virtual lengthening of a tie under virtual displacements (b, 3) at a configuration (b, 3)."""
    drawn = outlines(results)
    shape = drawn.moved(configuration)
    ends, owner = tie_ends(results, tie, configuration), np.array(tie.blocks)
    moved = field(ends, owner, shape.centroids, np.asarray(rate, dtype=float))
    along = ends[1] - ends[0]
    return float((moved[1] - moved[0]) @ along / np.hypot(*along))
