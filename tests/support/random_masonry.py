"""Random walls of bricks, some of them missing, and random arches between two supports."""

from itertools import pairwise

import numpy as np

from mechanics import Assembly, Block, Material
from tests.support.structures import rectangle


def random_masonry(seed: int) -> Assembly:
    """An arch for every third seed, else a wall."""
    rng = np.random.default_rng(seed)
    return _wall(rng) if seed % 3 else _arch(rng)


def small_wall(seed: int) -> Assembly:
    """A wall of 1 to 4 bricks and 2 to 6 courses, whose joints slide."""
    rng = np.random.default_rng(1000 + seed)
    friction, length, slender = rng.uniform(0.35, 0.6), rng.uniform(0.3, 0.6), rng.uniform(0.35, 0.9)
    columns, courses = rng.integers(1, 5), rng.integers(2, 7)
    return _bond(rng, friction, length, slender * length, columns, courses, 0.08)


def _wall(rng: np.random.Generator) -> Assembly:
    friction, length, height = rng.uniform(0.4, 0.8), rng.uniform(0.3, 0.6), rng.uniform(0.12, 0.3)
    columns, courses = rng.integers(2, 7), rng.integers(2, 8)
    return _bond(rng, friction, length, height, columns, courses, 0.06)


def _bond(
    rng: np.random.Generator,
    friction: float,
    length: float,
    height: float,
    columns: int,
    courses: int,
    missing: float,
) -> Assembly:
    """Courses of bricks on a base, every other one shifted by a part of a brick; a share of the bricks is missing."""
    stone, width = Material(18.0, friction, 1e6), columns * length
    blocks = [Block(rectangle(-length, -height, width + length, 0.0), 0.3, stone, support="base")]
    for course in range(courses):
        shift = rng.uniform(0.25, 0.75) * length if course % 2 else 0.0
        ends = np.unique(np.round(np.r_[0.0, np.arange(columns) * length + shift, width], 9))
        for left, right in pairwise(ends):
            gone = rng.uniform() < missing
            if not (gone and course < courses - 1 and left > 0.0 and right < width):
                blocks.append(
                    Block(rectangle(left, course * height, right, (course + 1) * height), 0.3, stone)
                )
    return Assembly(blocks)


def _arch(rng: np.random.Generator) -> Assembly:
    """A segmental to semicircular arch between two abutments."""
    voussoirs, radius = int(rng.integers(7, 25)), rng.uniform(1.0, 3.0)
    thick, stone = radius * rng.uniform(0.13, 0.3), Material(18.0, rng.uniform(0.4, 0.9), 5e5)
    open_ = rng.uniform(0.55, 1.0) * np.pi / 2.0
    angles = np.linspace(np.pi / 2.0 + open_, np.pi / 2.0 - open_, voussoirs + 1)

    def at(r: float, angle: float) -> np.ndarray:
        return r * np.array([np.cos(angle), np.sin(angle)])

    inner, outer = radius - 0.5 * thick, radius + 0.5 * thick
    blocks = [
        Block([at(inner, a), at(outer, a), at(outer, b), at(inner, b)], 1.0, stone)
        for a, b in pairwise(angles)
    ]
    for side, angle, sign in (("left", angles[0], -1.0), ("right", angles[-1], 1.0)):
        out = sign * thick * np.array([np.sin(angle), -np.cos(angle)])
        near, far = at(radius - 0.6 * thick, angle), at(radius + 0.6 * thick, angle)
        blocks.append(Block([near, far, far + out, near + out], 1.0, stone, support=side))
    return Assembly(blocks)
