"""The structures that are measured: some built here, the others from the built-in templates."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from mechanics import Assembly, Block, Material

if TYPE_CHECKING:
    from assessment.project.project import Project


def rectangle(x0: float, z0: float, x1: float, z1: float) -> list[list[float]]:
    """Corners (4, 2) of a rectangle between two of them, m."""
    return [[x0, z0], [x1, z0], [x1, z1], [x0, z1]]


def block_on_base(
    width: float = 0.2,
    height: float = 1.0,
    friction: float = 0.7,
    stiffness: float = 5e5,
    segments: int | None = None,
) -> Assembly:
    """A block 1 m deep, its lower left corner at the origin, on a wide support; `segments` of its bed, None: exact."""
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
    """Courses of whole bricks alternating with courses that begin and end with a half brick.

    The default is wall 1 of Ferris and Tin-Loi.
    """
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


def in_frame(model: Assembly, length: float, origin: tuple[float, float], weight: float) -> Assembly:
    """Return the model with lengths and unit weights multiplied, and then moved to an origin (m)."""
    return Assembly(
        [
            replace(
                block,
                vertices=length * block.polygon + np.array(origin),
                material=replace(block.material, unit_weight=weight * block.material.unit_weight),
            )
            for block in model.blocks
        ]
    )


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


@cache
def template(name: str) -> Project:
    """A new project from a built-in template, in a folder that lasts as long as the process."""
    from assessment.project.catalogue.new_project import new_project
    from assessment.project.project import load_project

    folder = Path(_scratch().name) / name
    new_project(folder, name, {})
    return load_project(folder)


@cache
def assembly(name: str, segments: int | None = None) -> Assembly:
    """The assembly of a template, its elastic joints of `segments`; None: exact."""
    from assessment.project.structure.model import build_model

    project = template(name)
    geometry = project.geometry.model_copy(update={"segments_per_joint": segments})
    return build_model(project.model_copy(update={"geometry": geometry})).assembly


@cache
def _scratch() -> TemporaryDirectory[str]:
    return TemporaryDirectory(prefix="assesto-benchmark-")
