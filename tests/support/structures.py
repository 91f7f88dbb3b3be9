"""Assemblies that several tests analyse."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import shapely

from assessment.benchmark.measure import block_on_base, in_frame, running_bond
from assessment.project.catalogue.geometry import rectangle
from mechanics import Assembly, Block, Material, Tie

__all__ = [
    "arch_on_piers", "block_on_base", "built", "column", "in_bond", "in_frame", "on_base", "outlines", "rectangle",
    "running_bond", "semicircular_arch", "springing_arch", "tied_arch",
]  # fmt: skip


def built(stone: Material, *shapes: Any, tolerance: float | None = None, **supports: Any) -> Assembly:
    """Supports by name, then blocks, of one stone, 1 m deep: boxes (left, bottom, right, top) or corners (n, 2)."""
    under = [Block(_corners(shape), 1.0, stone, support=name) for name, shape in supports.items()]
    return Assembly([*under, *(Block(_corners(shape), 1.0, stone) for shape in shapes)], tolerance=tolerance)


def _corners(shape: Any) -> Any:
    return rectangle(*shape) if np.ndim(shape) == 1 else shape


def on_base(stone: Material, base: tuple[float, float, float], *shapes: Any) -> Assembly:
    """Blocks, as `built`, and a support `base` (left, bottom, right) that ends at z = 0."""
    return built(stone, *shapes, base=(*base, 0.0))


def in_bond(rows: Sequence[Sequence[float]], height: float) -> list[tuple[float, float, float, float]]:
    """Bricks of courses from z = 0 on, each by the ends of its bricks."""
    return [
        (left, height * k, right, height * (k + 1))
        for k, row in enumerate(rows)
        for left, right in pairwise(row)
    ]


def arch_on_piers(
    radius: float = 0.6,
    thickness: float = 0.1,
    voussoirs: int = 23,
    pier_height: float = 0.8,
    pier_width: float = 0.3,
    courses: int = 10,
    friction: float = 0.6,
    stiffness: float = 1.2e5,
    segments: int | None = None,
    depth: float = 0.1,
    unit_weight: float = 11.5,
) -> Assembly:
    """A semicircular arch on two piers of single blocks; the piers stand on supports left and right."""
    # eleven arguments: the dimensions of a structure, by keyword
    stone = Material(unit_weight, friction, stiffness)
    inner, outer = radius - 0.5 * thickness, radius + 0.5 * thickness
    angles = np.linspace(0.0, np.pi, voussoirs + 1)

    def at(r: float, angle: float) -> list[float]:
        return [r * np.cos(angle), pier_height + r * np.sin(angle)]

    blocks = [
        Block([at(inner, a), at(outer, a), at(outer, b), at(inner, b)], depth, stone)
        for a, b in pairwise(angles)
    ]
    step = pier_height / courses
    for side, name in ((1, "right"), (-1, "left")):
        x0, x1 = sorted((side * inner, side * (inner + pier_width)))
        blocks += [Block(rectangle(x0, i * step, x1, (i + 1) * step), depth, stone) for i in range(courses)]
        blocks.append(Block(rectangle(x0 - 0.1, -0.1, x1 + 0.1, 0.0), depth, stone, support=name))
    return Assembly(blocks, segments)


def semicircular_arch(
    voussoirs: int,
    thickness: float,
    friction: float = 1e3,
    stiffness: float = 1e5,
    segments: int | None = None,
    strength: float = float("inf"),
) -> Assembly:
    """A semicircle of centre-line radius 1 m on two supports, joints radial."""
    stone = Material(20.0, friction, stiffness, compressive_strength=strength)
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


def tied_arch(yield_force: float = np.inf, **tie: float) -> Assembly:
    """A small arch on piers, its springings tied to each other, and one pier to its support."""
    arch = arch_on_piers(voussoirs=7, courses=3)
    return arch.tied(
        [
            Tie("springing", (-0.7, 0.78), (0.7, 0.78), yield_force, **tie),
            Tie("foot", (0.7, 0.3), (0.95, -0.05), yield_force, **tie),
        ]
    )


def column(
    width: float,
    height: float,
    blocks: int,
    stiffness: float | None = None,
    friction: float = 0.6,
    unit_weight: float = 20.0,
    strength: float = np.inf,
    segments: int | None = None,
) -> Assembly:
    """Equal blocks 1 m deep, one on the other, on a wide support."""
    stone = Material(unit_weight, friction, stiffness, compressive_strength=strength)
    levels = np.linspace(0.0, height, blocks + 1)
    base = Block(rectangle(-width, -0.2, 2.0 * width, 0.0), 1.0, stone, support="base")
    stacked = [Block(rectangle(0.0, low, width, high), 1.0, stone) for low, high in pairwise(levels)]
    return Assembly([base, *stacked], segments)


def springing_arch(
    lip: float = 0.0,
    ledge: float = 0.0,
    strength: float = np.inf,
    stiffness: float | None = None,
    friction: float = 0.7,
    collisions: bool = True,
) -> Assembly:
    """A segmental arch of nine voussoirs between skewbacks on two piers, span 2.4 m, as they are drawn.

    `lip` (m): of the skewbacks, upright below the springing; `ledge` (m): by which it is set back on them, or on the
    piers. Without a lip the foot of the intrados lies on a pier, at its corner where there is no ledge.
    """
    stone = Material(20.0, friction, stiffness, compressive_strength=strength)
    half, thick, pier, top = np.radians(55.0), 0.4, 0.8, 2.0
    radius = (1.2 + ledge) / np.sin(half)
    centre = np.array([0.0, top + lip - radius * np.cos(half)])
    turns = np.linspace(-half, half, 10)
    inner = centre + radius * np.column_stack([np.sin(turns), np.cos(turns)])
    outer = centre + (radius + thick) * np.column_stack([np.sin(turns), np.cos(turns)])
    blocks = []
    for side in (-1.0, 1.0):
        low, high = sorted((1.2 * side, (1.2 + pier) * side))
        blocks.append(Block(rectangle(low, -0.4, high, 0.0), 1.0, stone, support=f"{side:+g}"))
        blocks += [Block(rectangle(low, 0.5 * k, high, 0.5 * k + 0.5), 1.0, stone) for k in range(4)]
        foot, head = (inner[0], outer[0]) if side < 0.0 else (inner[-1], outer[-1])
        skewback = [((1.2 + pier) * side, top), ((1.2 + pier) * side, head[1]), head, foot]
        skewback += [(1.2 * side, foot[1])] if lip and ledge else []
        skewback += [(1.2 * side, top)] if lip or not ledge else []
        blocks.append(Block(skewback, 1.0, stone))
    pairs = zip(inner, outer, inner[1:], outer[1:], strict=False)
    blocks += [Block([a, b, d, c], 1.0, stone) for a, b, c, d in pairs]
    return Assembly(blocks, collisions=collisions)


def outlines(model: Assembly, positions: np.ndarray) -> list[shapely.Polygon]:
    """The shapes of the blocks at positions (b, 3)."""
    found = []
    for block, at in zip(model.blocks, positions, strict=True):
        c, s = np.cos(at[2]), np.sin(at[2])
        found.append(shapely.Polygon(at[:2] + (block.polygon - block.centroid) @ np.array([[c, s], [-s, c]])))
    return found
