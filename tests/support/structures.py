"""Assemblies that several tests analyse."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from assessment.benchmark.cases.structures import (
    arch_on_piers,
    block_on_base,
    in_frame,
    rectangle,
    running_bond,
)
from mechanics import Assembly, Block, Material, Tie

__all__ = [
    "arch_on_piers",
    "block_on_base",
    "column",
    "in_frame",
    "rectangle",
    "running_bond",
    "semicircular_arch",
    "tied_arch",
]


def semicircular_arch(
    voussoirs: int,
    thickness: float,
    friction: float = 1e3,
    stiffness: float = 1e5,
    segments: int | None = None,
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
