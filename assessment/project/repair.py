"""A repaired drawing beside a project's own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from assessment.project.structure.model import how_to_read
from assessment.runtime.errors import ProjectError
from assessment.runtime.files.atomic_files import write_atomically
from mechanics.errors import DrawingError
from mechanics.model import repair_drawing

if TYPE_CHECKING:
    from assessment.project.project import Project


def repairable(project: Project) -> bool:
    """Return whether a repair would change anything in the project's drawing."""
    try:
        return bool(repair_drawing(*how_to_read(project), project.geometry.tolerance_m).changes)
    except (DrawingError, OSError):
        return False


def with_repaired_drawing(project: Project) -> tuple[Project, tuple[str, ...]]:
    """Write the repaired drawing beside the original; return the project with it, and a line for each change.

    Where nothing is to be repaired nothing is written. Raises ProjectError where a file of its name is there already,
    DrawingError where the drawing cannot be read, OSError where none can be written.
    """
    path = project.path(project.geometry.drawing)
    beside = path.with_name(f"{path.stem}-repaired.dxf")
    repair = repair_drawing(*how_to_read(project), project.geometry.tolerance_m)
    if not repair.changes:
        return project, ()
    if beside.exists():
        raise ProjectError(f"{beside}: there is such a file already; delete it, or give it another name")
    write_atomically(beside, repair.file)
    name = (
        path.relative_to(project.folder).with_name(beside.name)
        if path.is_relative_to(project.folder)
        else beside
    )
    geometry = project.geometry.model_copy(update={"drawing": name.as_posix()})
    return project.model_copy(update={"geometry": geometry}), repair.changes
