"""What the project files of the templates have in common: stone, control points, movements, pushover, site."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from assessment.project.catalogue.geometry import Layout

Made = tuple[Layout, dict[str, Any]]
"""What a template makes of its dimensions: polygons by layer, and the content of the project file."""

DRAWING = "geometry.dxf"
ASSESSMENT = {
    "limit_states": ["SLD", "SLV", "SLC"],
    "confidence_factor": 1.35,
    "behaviour_factor": 2.0,
    "model": "trilinear",
    "spectrum": "ntc",
    "site": {  # L'Aquila
        "latitude": 42.35,
        "longitude": 13.40,
        "soil": "B",
        "topography": "T1",
        "nominal_life_years": 50,
        "use_class": "II",
    },
}
TWO_SUPPORTS = {"BASE_SINISTRA": {"support": "sinistro"}, "BASE_DESTRA": {"support": "destro"}}


def project(title: str, depth: float, material: Mapping[str, float], **tables: Any) -> dict[str, Any]:
    """Return the content of a project file: `depth` in m, `tables` beside those that all templates have.

    Those of [assessment] are added to what all have, or take its place.
    """
    return {
        "title": title,
        "geometry": {"drawing": DRAWING, "unit": "m", "depth_m": depth},
        "material": material,
        **tables,
        "assessment": ASSESSMENT | tables.get("assessment", {}),
        "report": {"language": "it", "client": "", "engineer": "", "location": ""},
    }


def stone(unit_weight: float, friction: float, stiffness: float) -> dict[str, float]:
    """Return [material]: kN/m³, –, kN/m³."""
    return {"unit_weight_kN_m3": unit_weight, "friction": friction, "normal_stiffness_kN_m3": stiffness}


def pushover(increment: float, control: str | tuple[str, str] | None = None) -> dict[str, Any]:
    """Return [pushover] with steps of `increment`, m; `control`: the point, or those of +x and -x."""
    table: dict[str, Any] = {
        "contacts": ["rigid", "elastic"],
        "directions": ["+x", "-x"],
        "increment_m": increment,
    }
    if isinstance(control, tuple):
        return table | {"control": dict(zip(("+x", "-x"), control, strict=True))}
    return table if control is None else table | {"control": control}


def point(name: str, x: float, z: float) -> dict[str, Any]:
    """Return a [[control]] at (x, z), m."""
    return {"name": name, "point_m": [round(x, 9), round(z, 9)]}


def outward(movement: float, increment: float) -> dict[str, Any]:
    """Return the paper's [[settlements]]: the right support goes outward and down by a `movement` (m) each."""
    return sinking(movement) | {
        "displacement_m": [movement, -movement],
        "increment_m": increment,
        "to_collapse": True,
    }


def sinking(movement: float) -> dict[str, Any]:
    """Return [[settlements]] of the right support by a `movement` (m), downward."""
    return {
        "name": f"appoggio destro {1e3 * movement:.4g} mm",
        "support": "destro",
        "displacement_m": [0.0, -movement],
        "increment_m": round(movement / 10.0, 7),
    }
