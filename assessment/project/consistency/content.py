"""All contradictions in a project, table by table."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from assessment.project.consistency.checks import (
    assessment_problems,
    floor_problems,
    knowledge_problems,
    mechanism_problems,
    sensitivity_problems,
    site_problems,
)
from assessment.project.consistency.files import attachment_problems, missing_file
from assessment.project.consistency.identification import identification_problems
from assessment.project.consistency.motions import motion_problems
from assessment.project.consistency.names import repeated_names
from assessment.project.consistency.strengthening import strengthening_problems, tie_problems
from assessment.project.consistency.structure import (
    control_problems,
    crushing_problems,
    load_problems,
    settlement_problems,
    stiffness_problems,
)
from assessment.project.errors import Problem
from assessment.project.schema import ProjectContent


def content_problems(project: ProjectContent, folder: Path) -> Iterator[Problem]:
    """Yield every problem between tables, and of the files that they name, in the order of the tables.

    `folder`: of the project. Files that cannot be read are problems too, no errors.
    """
    yield from missing_file(folder, ("geometry", "drawing"), project.geometry.drawing)
    yield from stiffness_problems(project)
    yield from crushing_problems(project)
    for name, layer in project.layers.items():
        yield from load_problems(("layers", name), layer)
    yield from repeated_names("control", [point.name for point in project.control])
    yield from control_problems(project)
    yield from repeated_names("settlements", list(project.unstrengthened[1:]))
    for index, settlement in enumerate(project.settlements):
        yield from settlement_problems(project, ("settlements", index), settlement)
    yield from tie_problems(project)
    yield from strengthening_problems(project)
    yield from motion_problems(project, folder)
    for index, name in enumerate(project.report.attachments):
        yield from attachment_problems(folder, ("report", "attachments", index), name)
    yield from mechanism_problems(project)
    if project.assessment:
        yield from assessment_problems(project, project.assessment)
        if project.assessment.knowledge:
            yield from knowledge_problems(project.assessment.knowledge, project.assessment.confidence_factor)
        if project.assessment.floor:
            yield from floor_problems(project.assessment.floor, project.assessment)
        if project.assessment.site:
            yield from site_problems(project.assessment.site, project.assessment.limit_states, folder)
    yield from identification_problems(project)
    if project.sensitivity:
        yield from sensitivity_problems(project, project.sensitivity)
