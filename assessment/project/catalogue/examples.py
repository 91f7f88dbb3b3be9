"""The example projects: in `projects` of a checkout, within the package where the program is installed."""

from __future__ import annotations

import shutil
from pathlib import Path

from assessment.project.catalogue.new_project import new_folder
from assessment.project.formats.convert import TOML, convert
from assessment.project.project import load_project
from assessment.runtime.errors import ProjectError, nearest

_PACKAGE = Path(__file__).parents[2]


def examples() -> dict[str, Path]:
    """Return the folder of every example by its name."""
    installed = _PACKAGE / "examples"
    folder = installed if installed.is_dir() else _PACKAGE.parent / "projects"
    return {path.name: path for path in sorted(folder.iterdir()) if (path / TOML).is_file()}


def example_title(folder: Path) -> str:
    """Return the first heading of an example's README."""
    first, *_ = (folder / "README.md").read_text(encoding="utf-8").split("\n", 1)
    return first.removeprefix("# ")


def new_example(folder: Path, name: str, source: str = TOML) -> None:
    """Copy an example into a new folder, whole or not at all; `source`: name of the project file, which tells its form.

    Raises ProjectError where there is no such example, or the folder holds something already; OSError where it cannot
    be written.
    """
    known = examples()
    name = name.lower().replace("-", "_")
    if name not in known:
        raise ProjectError(f"--example: {name}: no such example; {nearest(name, known)}")
    with new_folder(folder) as made:
        for path in sorted(known[name].rglob("*")):
            within = path.relative_to(known[name])
            if path.is_file() and within.parts[0] != "output":
                (made / within).parent.mkdir(exist_ok=True)
                shutil.copyfile(path, made / within)
        if source != TOML:
            _, kept = convert(made / TOML, load_project(made).content(defaults=False))
            kept.unlink()
