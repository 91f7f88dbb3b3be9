"""The built-in templates by name: each a function of its dimensions, which annotations describe."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import NamedTuple

from assessment.project.catalogue import arches, walls
from assessment.project.catalogue.content import Made
from assessment.runtime.errors import ProjectError, nearest

NUMBER = "number"  # unit of a dimension that counts: a whole number
UNITS = {"_kN_m3": "kN/m³", "_kN": "kN", "_deg": "°", "_m": "m"}  # by the end of a name
LARGEST = {NUMBER: 100, "m": 1e3, "kN": 1e6, "kN/m³": 1e3, "°": 89.0}
LEAST = 1e-3  # m, of a dimension that is not 0 by default
TEMPLATES: dict[str, Callable[..., Made]] = {
    "block": walls.block,
    "wall": walls.wall,
    "wall-with-openings": walls.wall_with_openings,
    "facade": walls.facade,
    "tympanum": walls.tympanum,
    "bell-gable": walls.bell_gable,
    "arch": arches.arch,
    "pointed-arch": arches.pointed_arch,
    "buttressed-arch": arches.buttressed_arch,
    "arcade": arches.arcade,
    "barrel-vault": arches.barrel_vault,
    "triumphal-arch": arches.triumphal_arch,
}


class Option(NamedTuple):
    """A dimension of a template."""

    default: float
    unit: str
    description: str


def template_options(template: str) -> dict[str, Option]:
    """Return the dimensions of a template by name. Raises ProjectError if it is unknown."""
    if template not in TEMPLATES:
        raise ProjectError(f"--template: {template}: no such template; {nearest(template, TEMPLATES)}")
    given = inspect.signature(TEMPLATES[template], eval_str=True).parameters
    return {
        name: Option(each.default, _unit(name, each.default), each.annotation.__metadata__[0])
        for name, each in given.items()
    }


def made(template: str, options: Mapping[str, float]) -> Made:
    """Return polygons by layer, m, and the content of the project file of a template with some dimensions of its own.

    Raises ProjectError where the template or a dimension is unknown or does not fit.
    """
    values = _values(template, options)
    try:
        return TEMPLATES[template](**values)
    except ValueError as error:
        raise ProjectError(f"{template}: {error}") from None


def _unit(name: str, default: float) -> str:
    if isinstance(default, int):
        return NUMBER
    return next(unit for end, unit in UNITS.items() if name.endswith(end))


def _values(template: str, options: Mapping[str, float]) -> dict[str, float]:
    """Return the dimensions given, counts as int, each within its bounds."""
    known, values = template_options(template), {}
    for name, value in options.items():
        if name not in known:
            raise ProjectError(f"{template}: {name}: no such option; {nearest(name, known)}")
        default, unit, _ = known[name]
        low = 1.0 if unit == NUMBER else LEAST if unit == "m" and default else 0.0
        high = LARGEST[unit]
        if not low <= value <= high or (unit == NUMBER and value != int(value)):
            what = "a whole number" if unit == NUMBER else f"a number, in {unit},"
            raise ProjectError(f"{template}: {name}: is {value:g}; must be {what} from {low:g} to {high:g}")
        values[name] = int(value) if unit == NUMBER else float(value)
    return values
