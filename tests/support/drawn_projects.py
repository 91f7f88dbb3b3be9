"""The assemblies of the example projects, read without the assessment."""

import tomllib
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from mechanics import Assembly, Material, read_drawing
from mechanics.model.drawing import Layer
from tests import ROOT

FOLDER = ROOT / "projects"


@cache
def tables(name: str | Path) -> dict[str, Any]:
    """What the project file of an example, or of any folder, says."""
    return tomllib.loads((FOLDER / name / "project.toml").read_text(encoding="utf-8"))


@cache
def drawn(name: str | Path, stiffness: float = 1.0, strength: float = float("inf")) -> Assembly:
    """An example project's blocks, their stiffness times a factor, with exact beds."""
    project = tables(name)
    geometry, common = project["geometry"], project["material"]

    def layer(own: dict[str, Any]) -> Layer:
        told = {**common, **own}
        normal = told.get("normal_stiffness_kN_m3")
        stone = Material(
            told["unit_weight_kN_m3"],
            told["friction"],
            normal and stiffness * normal,
            compressive_strength=strength,
        )
        return Layer(
            stone, own.get("depth_m", geometry["depth_m"]), own.get("support"),
            own.get("vertical_load_kN", 0.0), own.get("load_has_mass", True),
        )  # fmt: skip

    layers = {key: layer(own) for key, own in project.get("layers", {}).items()}
    drawing = read_drawing(FOLDER / name / geometry["drawing"], geometry["unit"], layer({}), layers)
    return Assembly([replace(block, segments=None) for block in drawing.blocks])
