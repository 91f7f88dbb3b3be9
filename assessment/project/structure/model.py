"""From a project's tables and drawing to an assembly of blocks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from assessment.project.plausibility import implausible
from assessment.project.structure.gauges import gauges
from assessment.project.structure.masonry import as_built, layer_of
from assessment.project.structure.mechanisms import chosen_mechanisms
from assessment.project.structure.state_models import StateModel, block_at, state_models
from assessment.runtime.errors import ProjectError
from mechanics import Assembly, DrawingError
from mechanics.faults import Fault, FaultyDrawingError
from mechanics.messages import Message, headed, message
from mechanics.model import Drawing, Layer, default_tolerance, survey_drawing, survey_layout
from mechanics.types import Array

if TYPE_CHECKING:
    from assessment.project.project import Project

UNSEEN = "gaps, and blocks that touch nothing, are looked for once these are mended"


@dataclass(frozen=True, eq=False)
class ProjectModel:
    """The blocks and joints of a project as drawn, the assembly of every state by name, warnings about the drawing.

    `cracks`: lines (n, 2), m, that the drawing has of a survey.
    """

    assembly: Assembly
    states: Mapping[str, StateModel]
    warnings: tuple[Message, ...]
    cracks: tuple[Array, ...] = ()


def build_model(project: Project) -> ProjectModel:
    """Read the drawing, check it, and place control points and ties.

    Raises DrawingError for a drawing that cannot be read, FaultyDrawingError, one of them, with all the faults of one
    that is no assembly, and ProjectError for a control point in a support, one, the end of a tie or a measurement
    outside every block, a crack or slip at no joint, or a mechanism whose blocks are not there.
    """
    geometry = project.geometry
    drawing = as_built(project, survey_drawing(*how_to_read(project), geometry.tolerance_m))
    tolerance, warnings = _laid_out(project, drawing)
    unset = sorted({block.layer for block in drawing.blocks if block.material.normal_stiffness is None})
    if unset and project.elastic:
        raise ProjectError(
            f"{project.source}: layers.{unset[0]}.normal_stiffness_kN_m3: missing ({', '.join(unset)}), "
            "and elastic analyses need it for every block; give it there or in [material]"
        )
    try:
        assembly = Assembly(
            drawing.blocks, geometry.segments_per_joint, tolerance, project.contacts.collisions
        )
    except ValueError as error:  # a block too light beside the others
        raise DrawingError(f"{geometry.drawing}: {error}") from None
    unit = "".join(f" ({warning})" for warning in drawing.warnings if "$INSUNITS" in warning)
    for point in project.control:
        key = f"{project.source}: control.{point.name}.point_m"
        block = assembly.blocks[block_at(assembly, key, point.point_m, unit)]
        if block.support is not None:
            text = f'{list(point.point_m)} is in the support "{block.support}", which no push moves'
            raise ProjectError(f"{key}: {text}; move it into another block")
    chosen_mechanisms(project, assembly)  # raises for wrong mechanisms before any analysis
    gauges(project, assembly)  # likewise
    states = state_models(project, assembly)
    far = assembly.as_drawn([0.0, 0.0])
    if far.any():
        told = message(
            "drawn far from (0, 0): in hand checks and in the steps of given mechanisms x and z count from ({x:.0f}, "
            "{z:.0f}) m",
            x=far[0],
            z=far[1],
        )
        warnings += (headed(geometry.drawing, told),)
    return ProjectModel(assembly, states, (*warnings, *implausible(project, assembly)), drawing.cracks)


def how_to_read(project: Project) -> tuple[Path, str, Layer, dict[str, Layer], float | None]:
    """Return a project's drawing, its unit, the layers and the sagitta: what `read_drawing` is called with."""
    geometry = project.geometry
    return (
        project.path(geometry.drawing),
        geometry.unit,
        layer_of(project, None),
        {name: layer_of(project, table) for name, table in project.layers.items()},
        geometry.sagitta_m,
    )


def _laid_out(project: Project, drawing: Drawing) -> tuple[float, tuple[Message, ...]]:
    """Return the tolerance (m) of the joints and all warnings; raise FaultyDrawingError with all faults."""
    name, blocks, faults = project.geometry.drawing, drawing.blocks, drawing.faults
    if not blocks:
        raise FaultyDrawingError(name, faults, drawing.outlines)
    if not faults and all(block.support is not None for block in blocks):
        noticed = "".join(f" ({warning})" for warning in drawing.warnings)
        text = f"every block is a support; put the movable ones on other layers{noticed}"
        raise FaultyDrawingError(name, [Fault("layer", text)], drawing.outlines)
    tolerance = project.geometry.tolerance_m or default_tolerance(blocks)
    layout = survey_layout(blocks, tolerance, whole=not faults)
    if faults or layout.faults:
        remedy = layout.hint if not faults else UNSEEN
        raise FaultyDrawingError(name, (*faults, *layout.faults), drawing.outlines, remedy)
    return tolerance, drawing.warnings + layout.warnings
