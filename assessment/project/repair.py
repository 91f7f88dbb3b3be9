"""A repaired drawing beside a project's own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from assessment.project.structure.model import how_to_read
from assessment.runtime.files.atomic_files import write_atomically
from mechanics.model import repair_drawing

if TYPE_CHECKING:
    from assessment.project.project import Project


def with_repaired_drawing(project: Project) -> tuple[Project, tuple[str, ...]]:
    """Write the repaired drawing beside the original; return the project with it, and a line for each change.

    Where nothing is to be repaired nothing is written; an earlier one is kept, and this gets the next number. Raises
    DrawingError where the drawing cannot be read, OSError where none can be written.
    """
    path = project.path(project.geometry.drawing)
    repair = repair_drawing(*how_to_read(project), project.geometry.tolerance_m)
    if not repair.changes:
        return project, ()
    numbered = (
        path.with_name(f"{path.stem}-repaired{end}.dxf") for end in ["", *(f"-{n}" for n in range(2, 1000))]
    )
    beside = next(each for each in numbered if not each.exists() or each.read_bytes() == repair.file)
    write_atomically(beside, repair.file)
    name = (
        path.relative_to(project.folder).with_name(beside.name)
        if path.is_relative_to(project.folder)
        else beside
    )
    geometry = project.geometry.model_copy(update={"drawing": name.as_posix()})
    return project.model_copy(update={"geometry": geometry}), repair.changes
