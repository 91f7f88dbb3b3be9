"""The built-in templates: their options, what they draw, and the content of their project files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from assessment.project.catalogue import geometry as parametric
from assessment.project.catalogue.geometry import Layout
from assessment.project.catalogue.triumphal_arch import triumphal_arch

Option = tuple[float, str, str]
Values = Mapping[str, Any]

NUMBER = "number"  # unit of an option that counts: a whole number, one or more
DRAWING = "geometry.dxf"


@dataclass(frozen=True)
class Template:
    """What makes a template.

    `options`: name to (default, unit, description); `layout` draws the polygons and `content` fills the
    project file, both from the values of all options.
    """

    options: dict[str, Option]
    layout: Callable[..., Layout]
    content: Callable[[Values], dict[str, Any]]


# The hazard is L'Aquila's (42.35 N, 13.40 E), class II, 50 years of nominal life.
ASSESSMENT = {
    "limit_states": ["SLD", "SLV", "SLC"],
    "confidence_factor": 1.35,
    "behaviour_factor": 2.0,
    "model": "trilinear",
    "spectrum": "ntc",
    "site": {
        "soil": "B",
        "topography": "T1",
        "nominal_life_years": 50,
        "use_class": "II",
        "SLD": {"ag_g": 0.104, "F0": 2.33, "Tc_star_s": 0.28, "return_period_years": 50},
        "SLV": {"ag_g": 0.261, "F0": 2.36, "Tc_star_s": 0.35, "return_period_years": 475},
        "SLC": {"ag_g": 0.334, "F0": 2.40, "Tc_star_s": 0.36, "return_period_years": 975},
    },
}


def _content(title: str, depth: float, material: Values, **tables: Any) -> dict[str, Any]:
    return {
        "title": title,
        "geometry": {"drawing": DRAWING, "unit": "m", "depth_m": depth},
        "material": material,
        **tables,
        "assessment": ASSESSMENT,
        "report": {"language": "it", "client": "", "engineer": "", "location": ""},
    }


def _stone(unit_weight: float, friction: float, stiffness: float) -> dict[str, float]:
    return {
        "unit_weight_kN_m3": unit_weight,
        "friction": friction,
        "normal_stiffness_kN_m3": stiffness,
    }


def _pushover(increment: float, **control: Any) -> dict[str, Any]:
    return {
        "contacts": ["rigid", "elastic"],
        "directions": ["+x", "-x"],
        "increment_m": increment,
        "control": control["both"] if "both" in control else {"+x": control["right"], "-x": control["left"]},
    }


def _point(name: str, x: float, z: float) -> dict[str, Any]:
    return {"name": name, "point_m": [round(x, 9), round(z, 9)]}


def _outward(movement: float, increment: float) -> dict[str, Any]:
    """Return the paper's movement: the right support goes outward and down by equal parts."""
    return {
        "name": f"appoggio destro {1e3 * movement:.4g} mm",
        "support": "destro",
        "displacement_m": [movement, -movement],
        "increment_m": increment,
        "to_collapse": True,
    }


def _block(values: Values) -> dict[str, Any]:
    half, height = 0.5 * values["width_m"], values["height_m"]
    return _content(
        "Blocco oscillante",
        depth=1.0,
        material=_stone(18.0, 0.7, 5e8),
        layers={"BASE": {"support": "base"}},
        control=[_point("in alto a destra", half, height), _point("in alto a sinistra", -half, height)],
        settlements=[
            {
                "name": "base ruotata 20 mrad",
                "support": "base",
                "rotation_rad": -0.02,
                "increment_rad": 0.001,
                "to_collapse": True,
            }
        ],
        pushover=_pushover(
            round(0.01 * values["width_m"], 6), right="in alto a destra", left="in alto a sinistra"
        ),
    )


def _wall(values: Values) -> dict[str, Any]:
    length = values["blocks"] * values["block_length_m"]
    height = values["courses"] * values["block_height_m"]
    settlement = round(0.1 * values["block_height_m"], 6)
    return _content(
        "Parete a corsi sfalsati",
        depth=0.3,
        material=_stone(18.0, 0.65, 1e6),
        layers={"BASE_SINISTRA": {"support": "sinistro"}, "BASE_DESTRA": {"support": "destro"}},
        control=[_point("in alto a destra", length, height), _point("in alto a sinistra", 0.0, height)],
        settlements=[
            {
                "name": f"appoggio destro {1e3 * settlement:.4g} mm",
                "support": "destro",
                "displacement_m": [0.0, -settlement],
                "increment_m": round(settlement / 10.0, 7),
            }
        ],
        pushover=_pushover(
            round(0.02 * values["block_length_m"], 6), right="in alto a destra", left="in alto a sinistra"
        ),
    )


def _arch(values: Values) -> dict[str, Any]:
    layout = parametric.arch(**values)
    crown = max(float(polygon[:, 1].max()) for polygons in layout.values() for polygon in polygons)
    movement = round(0.01 * values["span_m"], 6)
    return _content(
        "Arco",
        depth=1.0,
        material=_stone(20.0, 0.6, 1e6),
        layers={"BASE_SINISTRA": {"support": "sinistro"}, "BASE_DESTRA": {"support": "destro"}},
        control=[_point("chiave", 0.0, crown)],
        settlements=[_outward(movement, round(0.05 * movement, 7))],
        pushover=_pushover(round(0.001 * values["span_m"], 6), both="chiave"),
    )


def _buttressed_arch(values: Values) -> dict[str, Any]:
    outer, top = 0.5 * values["span_m"] + values["pier_width_m"], values["pier_height_m"]
    drawn = {name: default for name, (default, _, _) in _BUTTRESSED_OPTIONS.items()}
    sized = any(values[name] != default for name, default in drawn.items() if name.endswith("_m"))
    scale = values["span_m"] / drawn["span_m"]
    movement = round(0.02 * scale, 3)
    return _content(
        "Arco su piedritti" if sized else "Arco su piedritti, modello 1:10",
        depth=round(0.1 * scale, 2),
        material=_stone(11.5, 0.6, 1.2e5),
        layers={
            "BASE_SINISTRA": {"support": "sinistro"},
            "BASE_DESTRA": {"support": "destro"},
        },
        control=[_point("C1", -outer, top), _point("C2", outer, top)],
        settlements=[_outward(movement, round(0.05 * movement, 7))],
        pushover=_pushover(round(0.0005 * scale, 7), right="C2", left="C1"),
    )


def _triumphal_arch(values: Values) -> dict[str, Any]:
    outer, top = 0.5 * values["span_m"] + values["wall_thickness_m"], values["height_m"]
    return _content(
        "Arco trionfale",
        depth=0.6,
        material=_stone(16.0, 0.65, 5.33e6),
        layers={
            "BASE_SINISTRA": {"depth_m": 5.5, "support": "sinistro"},
            "BASE_DESTRA": {"depth_m": 5.5, "support": "destro"},
            "NAVATA": {"depth_m": 5.5},
            "COPERTURA": {"vertical_load_kN": 9.1},
        },
        control=[_point("C1", outer, top), _point("C2", -outer, top)],
        settlements=[_outward(0.15, 0.01)],
        pushover=_pushover(0.01, right="C1", left="C2"),
    )


_ARCH_OPTIONS: dict[str, Option] = {
    "span_m": (3.0, "m", "clear span"),
    "rise_m": (1.5, "m", "rise of the intrados, at most half the span"),
    "thickness_m": (0.3, "m", "thickness of the ring"),
    "voussoirs": (21, NUMBER, "voussoirs of the ring"),
}

_BUTTRESSED_OPTIONS: dict[str, Option] = {
    **_ARCH_OPTIONS,
    "span_m": (0.54, "m", "clear span"),
    "rise_m": (0.24, "m", "rise of the intrados, at most half the span"),
    "thickness_m": (0.055, "m", "thickness of the ring"),
    "pier_width_m": (0.15, "m", "width of a pier"),
    "pier_height_m": (0.55, "m", "height of a pier up to the springing"),
    "blocks_per_pier": (5, NUMBER, "blocks of a pier"),
}

TEMPLATES: dict[str, Template] = {
    "block": Template(
        {
            "width_m": (0.6, "m", "width of the block"),
            "height_m": (4.2, "m", "height of the block"),
        },
        parametric.block,
        _block,
    ),
    "wall": Template(
        {
            "block_length_m": (0.5, "m", "length of a block"),
            "block_height_m": (0.3, "m", "height of a course"),
            "blocks": (6, NUMBER, "blocks along the wall"),
            "courses": (8, NUMBER, "courses"),
            "moving_blocks": (2, NUMBER, "blocks at the right end that stand on the support 'destro'"),
        },
        parametric.wall,
        _wall,
    ),
    "arch": Template(_ARCH_OPTIONS, parametric.arch, _arch),
    "buttressed-arch": Template(
        _BUTTRESSED_OPTIONS,
        parametric.buttressed_arch,
        _buttressed_arch,
    ),
    # Dimensions found by search, so that α0 and d_0 as drawn are near the paper's §7.
    "triumphal-arch": Template(
        {
            "span_m": (9.2, "m", "clear span"),
            "rise_m": (3.48, "m", "rise of the intrados, at most half the span"),
            "thickness_m": (0.2, "m", "thickness of the ring"),
            "voussoirs": (27, NUMBER, "voussoirs of the ring"),
            "springing_m": (5.4, "m", "height of the springing above the bases"),
            "height_m": (9.3, "m", "height of the nave walls"),
            "wall_thickness_m": (1.215, "m", "thickness of the nave walls below the springing"),
            "course_height_m": (0.3, "m", "height of the courses, adapted to whole numbers of them"),
            "wall_blocks": (3, NUMBER, "blocks across a nave wall"),
            "spandrel_blocks": (24, NUMBER, "blocks along a course of the arch wall between the nave walls"),
            "beams": (8, NUMBER, "roof beams on the top course"),
            "beam_side_m": (0.2, "m", "side of a roof beam"),
        },
        triumphal_arch,
        _triumphal_arch,
    ),
}
