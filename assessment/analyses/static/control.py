"""The control point of a project that gives none: the program chooses one for each direction, and says which."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from assessment.project.schema import ControlTable
from mechanics import ConvergenceError, NoEquilibriumError, UnstableError, limit_analysis
from mechanics.messages import Message, message
from mechanics.procedures import farthest_corner

if TYPE_CHECKING:
    from assessment.project.project import Project
    from mechanics import Assembly
    from mechanics.model import Direction

CHOSEN = {"it": "scelto {direction}", "en": "chosen {direction}"}


def with_control(project: Project, model: Assembly) -> tuple[Project, list[Message]]:
    """Return the project with a control point for each direction where it needs one and has none, and which these are.

    It is the corner that goes farthest along the push in the first mechanism of the structure as drawn, `model`: the
    same in every state, so that their displacements can be compared.
    """
    needed = project.pushover or project.history or project.incremental or project.campaign
    if project.control or not needed:
        return project, []
    directions: tuple[Direction, ...] = project.pushover.directions if project.pushover else ("+x",)
    found = [_chosen(project, model, direction) for direction in directions]
    notes = [
        message(
            "no control point given: towards {direction} that of block {block} at ({x:.4g}, {z:.4g}) m is followed, "
            "which goes farthest along the push",
            direction=direction,
            block=block,
            x=point.point_m[0],
            z=point.point_m[1],
        )
        for direction, (point, block) in zip(directions, found, strict=True)
    ]
    points = tuple(point for point, _ in found)
    changed: dict[str, object] = {"control": points}
    if project.pushover:
        by_direction = {way: point.name for way, point in zip(directions, points, strict=True)}
        changed["pushover"] = project.pushover.model_copy(update={"control": by_direction})
    return project.model_copy(update=changed), notes


def _chosen(project: Project, model: Assembly, direction: Direction) -> tuple[ControlTable, int]:
    """Return the control point of a direction and its block; that of the highest corner where nothing moves."""
    begun = model.initial.positions
    moved = begun + model.movable[:, None] * [1.0, 0.0, 0.0]
    with suppress(UnstableError, NoEquilibriumError, ConvergenceError):
        limit = limit_analysis(model, direction, sliding=project.contacts.sliding)
        moved = begun + 1e-6 * model.size * limit.mechanism
    (x, z), block = farthest_corner(model, begun, moved, direction)
    name = CHOSEN[project.report.language].format(direction=direction)
    return ControlTable(name=name, point_m=(float(x), float(z))), block
