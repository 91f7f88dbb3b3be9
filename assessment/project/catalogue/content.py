"""What the project files of the templates have in common: stone, control points, movements, pushover, site."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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


def project(
    title: str,
    depth: float,
    stone: tuple[float, float, float],
    layers: Mapping[str, Any],
    control: Mapping[str, tuple[float, float]],
    increment: float,
    settlements: Sequence[Mapping[str, Any]] = (),
    **tables: Any,
) -> dict[str, Any]:
    """Return the content of a project file; `depth` (m), `stone`: kN/m³, tangent of friction, kN/m³ of the joints.

    `control`: points (m) by name, of two each followed where it goes ahead; `increment` (m) of the pushover. What
    [assessment] has of its own in `tables` is added to what all templates have.
    """
    ahead = sorted(control, key=lambda name: -control[name][0])
    pushover: dict[str, Any] = {"contacts": ["rigid", "elastic"], "directions": ["+x", "-x"]}
    pushover["increment_m"] = increment
    pushover["control"] = dict(zip(("+x", "-x"), ahead, strict=True)) if ahead[1:] else ahead[0]
    own, keys = tables.pop("assessment", {}), ("unit_weight_kN_m3", "friction", "normal_stiffness_kN_m3")
    return {
        "title": title,
        "geometry": {"drawing": DRAWING, "unit": "m", "depth_m": depth},
        "material": dict(zip(keys, stone, strict=True)),
        "layers": layers,
        **tables,
        "control": [
            {"name": name, "point_m": [round(x, 9), round(z, 9)]} for name, (x, z) in control.items()
        ],
        **({"settlements": [*settlements]} if settlements else {}),
        "pushover": pushover,
        "assessment": ASSESSMENT | own,
        "report": {"language": "it", "client": "", "engineer": "", "location": ""},
    }


def outward(movement: float, increment: float = 0.0) -> dict[str, Any]:
    """Return the paper's [[settlements]]: the right support goes outward and down by a `movement` (m) each.

    `increment` (m): 0: a twentieth.
    """
    step = increment or round(0.05 * movement, 7)
    way = {"displacement_m": [movement, -movement], "increment_m": step, "to_collapse": True}
    return sinking(movement) | way


def sinking(movement: float) -> dict[str, Any]:
    """Return [[settlements]] of the right support by a `movement` (m), downward."""
    return {
        "name": f"appoggio destro {1e3 * movement:.4g} mm",
        "support": "destro",
        "displacement_m": [0.0, -movement],
        "increment_m": round(movement / 10.0, 7),
    }
