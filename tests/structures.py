"""Assemblies that several tests analyse."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from mechanics import Assembly, Block, Material


def rectangle(x0: float, z0: float, x1: float, z1: float) -> list[list[float]]:
    return [[x0, z0], [x1, z0], [x1, z1], [x0, z1]]


def block_on_base(
    width: float = 0.2, height: float = 1.0, friction: float = 0.7, stiffness: float = 5e5, segments: int = 1
) -> Assembly:
    stone = Material(18.0, friction, stiffness)
    base = Block(rectangle(-5 * width, -0.1 * height, 5 * width, 0.0), 1.0, stone, support="base")
    return Assembly([base, Block(rectangle(0.0, 0.0, width, height), 1.0, stone)], segments)


def running_bond(
    columns: int = 5,
    courses: int = 6,
    length: float = 0.4,
    height: float = 0.175,
    friction: float = 0.65,
    stiffness: float = 1e6,
    full_on_top: bool = True,
) -> Assembly:
    """Courses of whole bricks alternating with courses that begin and end with a half brick."""
    stone = Material(18.0, friction, stiffness)
    width = columns * length
    blocks = [Block(rectangle(-length, -height, width + length, 0.0), 0.1, stone, support="base")]
    for j in range(courses):
        whole = ((courses - 1 - j) % 2 == 0) == full_on_top
        edges = (
            np.arange(columns + 1) * length
            if whole
            else np.r_[0.0, (np.arange(columns) + 0.5) * length, width]
        )
        blocks += [
            Block(rectangle(a, j * height, b, (j + 1) * height), 0.1, stone) for a, b in pairwise(edges)
        ]
    return Assembly(blocks)


def semicircular_arch(
    voussoirs: int, thickness: float, friction: float = 1e3, stiffness: float = 1e5, segments: int = 1
) -> Assembly:
    """A semicircle of centre-line radius 1 m on two supports, joints radial."""
    stone = Material(20.0, friction, stiffness)
    radii = np.array([1.0 - 0.5 * thickness, 1.0 + 0.5 * thickness])
    angles = np.linspace(0.0, np.pi, voussoirs + 1)
    corner = np.stack([np.outer(np.cos(angles), radii), np.outer(np.sin(angles), radii)], axis=2)
    ring = [
        Block([corner[i, 0], corner[i, 1], corner[i + 1, 1], corner[i + 1, 0]], 1.0, stone)
        for i in range(voussoirs)
    ]
    supports = [
        Block(rectangle(side * 1.0 - thickness, -0.2, side * 1.0 + thickness, 0.0), 1.0, stone, support=name)
        for side, name in ((1, "right"), (-1, "left"))
    ]
    return Assembly([*ring, *supports], segments)


def arch_on_piers(
    radius: float = 0.6,
    thickness: float = 0.1,
    voussoirs: int = 23,
    pier_height: float = 0.8,
    pier_width: float = 0.3,
    courses: int = 10,
    friction: float = 0.6,
    stiffness: float = 1.2e5,
    segments: int = 2,
) -> Assembly:
    """A semicircular arch on two piers of single blocks, 0.1 m deep; the piers stand on supports left and right."""
    stone = Material(11.5, friction, stiffness)
    inner, outer = radius - 0.5 * thickness, radius + 0.5 * thickness
    angles = np.linspace(0.0, np.pi, voussoirs + 1)

    def at(r: float, angle: float) -> list[float]:
        return [r * np.cos(angle), pier_height + r * np.sin(angle)]

    blocks = [
        Block([at(inner, a), at(outer, a), at(outer, b), at(inner, b)], 0.1, stone)
        for a, b in pairwise(angles)
    ]
    step = pier_height / courses
    for side, name in ((1, "right"), (-1, "left")):
        x0, x1 = sorted((side * inner, side * (inner + pier_width)))
        blocks += [Block(rectangle(x0, i * step, x1, (i + 1) * step), 0.1, stone) for i in range(courses)]
        blocks.append(Block(rectangle(x0 - 0.1, -0.1, x1 + 0.1, 0.0), 0.1, stone, support=name))
    return Assembly(blocks, segments)
