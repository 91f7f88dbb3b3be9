"""Walls that slide: the range of an ensemble tells the same in other units, elsewhere, and in another order."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from assessment.analyses.governing import ENSEMBLE, shaken_corners
from mechanics import Assembly, ControlError, pushover
from mechanics.steps.static_system import Sliding
from tests.stress.harness import Case
from tests.support.structures import in_frame, running_bond

COUNT = 50  # walls
SHORT = (42,)  # those of which the short tests ask: all their paths end, and soon
INCREMENT = 0.1  # of the block size
FRAMES = {  # length, origin (m), weight
    "as drawn": (1.0, (0.0, 0.0), 1.0),
    "units": (1000.0, (0.0, 0.0), 1.0),
    "origin": (1.0, (137.3, -41.9), 1.0),
    "weight": (1.0, (0.0, 0.0), 37.0),
}

Range = tuple[float, float]


def member(model: Assembly, top: np.ndarray, increment: float, sliding: Sliding) -> Range:
    """α0 and d_0 (m) of one member; a path without end has an infinite d_0."""
    try:
        curve = pushover(model, top, "+x", "rigid", increment, sliding=sliding)
    except ControlError:  # the mechanism lies below the control point
        return np.nan, np.nan
    ended = curve.lost or curve.reached_zero
    return float(curve.multiplier.max()), float(curve.displacement[-1]) if ended else np.inf


def ensemble(model: Assembly, top: np.ndarray, seed: int, sliding: Sliding) -> tuple[Range, Range]:
    """The least and the largest α0 and d_0 (m) of five members."""
    factors = np.geomspace(*ENSEMBLE.increments, 4)
    found = [member(model, top, INCREMENT * model.size, sliding)]
    for k, factor in enumerate(factors):
        varied = shaken_corners(model, 100 * seed + k)
        found.append(member(varied, top, INCREMENT * model.size * float(factor), sliding))
    alpha, displacement = np.array(found).T
    return (alpha.min(), alpha.max()), (displacement.min(), displacement.max())


def overlap(ranges: list[Range]) -> bool:
    """Whether all ranges have a value in common, to 0.1 %; no value is common to none."""
    low, high = np.array(ranges).T
    return bool(np.isnan(low).all() or low.max() <= high.min() * 1.001)


def same_ranges(number: int, wall: Assembly, order: np.ndarray, sliding: Sliding) -> None:
    top, found = wall.blocks[-1].centroid, []
    for length, origin, weight in FRAMES.values():
        model = in_frame(wall, length, origin, weight)
        alpha, d = ensemble(model, model.blocks[-1].centroid, number, sliding)
        found.append((alpha, (d[0] / length, d[1] / length)))
    found.append(ensemble(Assembly([wall.blocks[i] for i in order]), top, number, sliding))
    for ranges in zip(*found, strict=True):
        assert overlap(list(ranges)), f"ranges lie apart: {ranges}"


def cases() -> Iterator[Case]:
    rng = np.random.default_rng(5)
    for number in range(COUNT):
        columns, courses = int(rng.integers(2, 5)), int(rng.integers(2, 6))
        brick = float(rng.uniform(0.25, 0.6)), float(rng.uniform(0.12, 0.25))
        wall = running_bond(columns, courses, *brick, float(rng.uniform(0.3, 1.2)))
        order = rng.permutation(len(wall.blocks))
        for sliding in ("associative", "coulomb"):
            yield Case(
                "ranges",
                f"wall {number}, {columns} × {courses}, {sliding}",
                partial(same_ranges, number, wall, order, sliding),
                long=number not in SHORT,
            )
