"""The structures that are measured: some built here, the others from the built-in templates."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from mechanics import Assembly, Block, Material, Pushdown, Pushover, State, pushdown, pushover
from mechanics.model.assembly import Behaviour, Direction

if TYPE_CHECKING:
    from assessment.project.project import Project


def rectangle(x0: float, z0: float, x1: float, z1: float) -> list[list[float]]:
    """Corners (4, 2) of a rectangle between two of them, m."""
    return [[x0, z0], [x1, z0], [x1, z1], [x0, z1]]


def block_on_base(
    width: float = 0.2, height: float = 1.0, friction: float = 0.7, stiffness: float = 5e5, segments: int | None = None
) -> Assembly:  # fmt: skip
    """A block 1 m deep, its lower left corner at the origin, on a wide support; `segments` of its bed, None: exact."""
    stone = Material(18.0, friction, stiffness)
    base = Block(rectangle(-5 * width, -0.1 * height, 5 * width, 0.0), 1.0, stone, support="base")
    return Assembly([base, Block(rectangle(0.0, 0.0, width, height), 1.0, stone)], segments)


def running_bond(
    columns: int = 5, courses: int = 6, length: float = 0.4, height: float = 0.175, friction: float = 0.65,
    stiffness: float = 1e6, full_on_top: bool = True,
) -> Assembly:  # fmt: skip
    """Courses of whole bricks alternating with half-brick-ended ones; by default wall 1 of Ferris and Tin-Loi."""
    stone = Material(18.0, friction, stiffness)
    width = columns * length
    blocks = [Block(rectangle(-length, -height, width + length, 0.0), 0.1, stone, support="base")]
    for j in range(courses):
        edges, low, high = np.arange(columns + 1) * length, j * height, (j + 1) * height
        if ((courses - 1 - j) % 2 == 0) != full_on_top:
            edges = np.r_[0.0, (np.arange(columns) + 0.5) * length, width]
        blocks += [Block(rectangle(a, low, b, high), 0.1, stone) for a, b in pairwise(edges)]
    return Assembly(blocks)


def in_frame(model: Assembly, length: float, origin: tuple[float, float], weight: float) -> Assembly:
    """Return the model with lengths and unit weights multiplied, and then moved to an origin (m)."""
    blocks = []
    for block in model.blocks:
        material = replace(block.material, unit_weight=weight * block.material.unit_weight)
        blocks.append(replace(block, vertices=length * block.polygon + np.array(origin), material=material))
    return Assembly(blocks)


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
    from assessment.project.model import build_model

    project = template(name)
    geometry = project.geometry.model_copy(update={"segments_per_joint": segments})
    return build_model(project.model_copy(update={"geometry": geometry})).assembly


def settled(
    name: str, contacts: Behaviour, times: float = 1.0, segments: int | None = None, to_collapse: bool = False
) -> Pushdown:
    """A template's movement, in `times` its increment."""
    (table,) = template(name).settlements
    assert table.increment_m is not None
    return pushdown(
        assembly(name, segments), table.support, table.displacement_m, 0.0, times * table.increment_m, contacts,
        to_collapse=to_collapse,
    )  # fmt: skip


def pushed(
    name: str, way: Direction = "+x", contacts: Behaviour = "rigid", times: float = 1.0,
    state: State | None = None, segments: int | None = None, until: float = 0.0,
) -> Pushover:  # fmt: skip
    """A template's capacity curve, in `times` its increment."""
    point, increment = control(name, way)
    return pushover(assembly(name, segments), point, way, contacts, times * increment, state, until)


def control(name: str, way: Direction = "+x") -> tuple[tuple[float, float], float]:
    """The control point (m) of a template, and its increment (m)."""
    project = template(name)
    assert project.pushover is not None
    return project.pushover_control(way).point_m, project.pushover.increment_m


@cache
def _scratch() -> TemporaryDirectory[str]:
    return TemporaryDirectory(prefix="assesto-benchmark-")
