"""What every part of results.json is made of: exact types, finite numbers, no key that is not described."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Self, TypeVar, get_args, get_origin

import pydantic

Name = TypeVar("Name")
Value = TypeVar("Value")

Point = list[float]
Configuration = list[list[float]]
"""Of each block: displacement x, z (m) and rotation (rad) from the drawing."""


# of a message, a kind of string, pydantic by itself would make a plain one
Sentence = Annotated[str, pydantic.WrapValidator(lambda x, checked: x if isinstance(x, str) else checked(x))]
"""A sentence for people; a message keeps what it is made of."""


ENDS = ["kN_m3", "kN_m2", "kN_m", "m_s2", "m_s", "kNm", "kN", "mm", "m", "m2", "g", "s", "rad", "mrad"]
ENDS += ["years", "MPa"]
UNITS = {f"_{end}": end.replace("_", "/").translate(str.maketrans("23", "²³")) for end in ENDS}
"""Of a quantity by the end of its name."""
FACTORS = {("m", "mm"): 1000.0, ("–", "%"): 100.0, ("kN/m²", "MPa"): 0.001, ("rad", "mrad"): 1000.0}
"""From the unit of results.json to that of a report."""


@dataclass(frozen=True)
class Quantity:
    """How a quantity is called and written, wherever it is: in tables, headings, figures, page, and documents."""

    name: str
    unit: str
    label: Mapping[str, str]  # by language
    words: bool  # whether its values are words
    shown: str = ""  # unit in reports, where it is another one
    digits: int | None = None  # significant ones at most
    decimals: int | None = None  # of what has an accuracy of its own, in place of digits
    null: str = ""  # what null means, as in `value.<null>` of the strings
    ground: str = ""  # of an acceleration: "surface", or "rock" (with a spectrum of a record the surface)
    ratio: bool = False  # to be compared with 1, with digits enough to tell
    change: bool = False  # a loss or a gain, in per cent

    @property
    def factor(self) -> float:
        """From the unit of results.json to that of reports."""
        return FACTORS[self.unit, self.shown] if self.shown else 1.0

    @property
    def printed_unit(self) -> str:
        """Unit in reports; empty where there is none."""
        return "" if self.unit == "–" and not self.shown else self.shown or self.unit


QUANTITIES: dict[str, Quantity] = {}
"""Every quantity that a table of results, or a table that follows from them, describes."""


def _kinds(annotation: Any) -> set[Any]:
    """Return the plain types within an annotation."""
    inner = get_args(annotation)
    return set().union(*map(_kinds, inner)) if inner else {annotation}


def enter(name: str, annotation: Any, told: dict[str, Any]) -> None:
    """Register a quantity with its unit. Raises ValueError for a name that is registered already."""
    if unit := told.pop("unit", _unit(name, annotation)):
        told["unit"] = unit
    if "label" in told:
        if name in QUANTITIES:
            raise ValueError(f"{name}: described in another table too")
        words = not {float, int} & _kinds(annotation)
        shown: Any = {"name": name, "unit": "", "words": words} | told
        QUANTITIES[name] = Quantity(**shown)


def plain_value(annotation: Any) -> bool:
    """Return whether values are single ones: text, number or truth, or null."""
    return not any(
        get_origin(each) in (list, dict) or (isinstance(each, type) and issubclass(each, pydantic.BaseModel))
        for each in (annotation, *get_args(annotation))
    )


class Part(pydantic.BaseModel):
    """A table of results.json. Keys are missing where not asked for, null where not reached: None as attributes."""

    model_config = pydantic.ConfigDict(
        strict=True, extra="forbid", frozen=True, allow_inf_nan=False, populate_by_name=True
    )

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Enter the quantities that the fields describe. Raises ValueError for one that is described twice."""
        for name, field in cls.model_fields.items():
            if isinstance(extra := field.json_schema_extra, dict) and name in cls.__annotations__:
                enter(name, field.annotation, extra)

    def replace(self, **values: Any) -> Self:
        """Return the part with other values of some keys, or with keys that it did not have.

        Raises pydantic's ValidationError for a key that is not described, or a value of another type.
        """
        return type(self)(**{name: getattr(self, name) for name in self.model_fields_set} | values)


def key(meaning: str, label: str = "", *, alias: str | None = None, **look: Any) -> Any:
    """Describe a key that is always there; its unit is that of its name, – of other numbers, or `unit`.

    `label`: in headings, "Italian|English", or alike in both; of a shared quantity in one table. `look`: see Quantity.
    """
    return pydantic.Field(description=meaning, alias=alias, json_schema_extra=named(label, **look))


def optional(meaning: str, label: str = "", *, alias: str | None = None, **look: Any) -> Any:
    """Describe a key that is there only where it was asked for, or where it has a meaning; as `key`."""
    told = named(label, **look)
    return pydantic.Field(default=None, description=meaning, alias=alias, json_schema_extra=told)


def present(found: Mapping[Name, Value | None]) -> dict[Name, Value]:
    """Return what there is of some tables that may be missing, by name."""
    return {name: value for name, value in found.items() if value is not None}


def known(value: Value | None) -> Value:
    """Return what is always there beside something else, as the configurations of a history that has a curve."""
    assert value is not None
    return value


def first_error(error: pydantic.ValidationError) -> str:
    """Return the key of the first error, what is wrong there, and how many more there are."""
    errors = error.errors(include_url=False, include_input=False)
    place = ""
    for part in errors[0]["loc"]:
        place += f"[{part}]" if isinstance(part, int) else f"{'.' * bool(place)}{part}"
    wrong = {"missing": "missing", "extra_forbidden": "unknown key"}.get(errors[0]["type"], errors[0]["msg"])
    more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    return f"{place or 'the whole'}: {wrong}{more}"


def unit_of(name: str) -> str:
    """Return the unit that a name tells by its end, empty where it tells none."""
    ends = [end for end in UNITS if name.removesuffix("_range").endswith(end)]
    return UNITS[max(ends, key=len)] if ends else ""


def _unit(name: str, annotation: Any) -> str:
    """Return the unit that a name tells; of configurations, and of other numbers."""
    if unit := unit_of(name):
        return unit
    if annotation in (Configuration, Configuration | None, list[Configuration]):
        return "m, rad"
    tables = dict in {get_origin(each) for each in (annotation, *get_args(annotation))}
    return "–" if float in _kinds(annotation) and not tables else ""


def named(label: str, **look: Any) -> dict[str, Any]:
    """Return the description of a quantity, for `Annotated` fields of rows that are not in the file."""
    italian, _, english = label.partition("|")
    told: dict[str, Any] = {"label": {"it": italian, "en": english or italian}} if label else {}
    if look.get("ground") == "rock" or look.get("ratio") or look.get("change"):
        told["null"] = "not_determined"
    told |= {"shown": "%"} if look.get("change") else {}
    return told | look


class Worded(Part):
    """`messages.SENTENCE`: the template of a sentence, with what fills it; a report words it in its own language."""

    template: str = key("the English sentence with named fields, {name:format}")
    fields: dict[str, str | int | float | Worded | list[str | int | float | Worded]] = key(
        "text, number or sentence of each field, or a list of them"
    )


def finite(value: float | None) -> float | None:
    """Return a number that is finite; None for NaN, infinity and None."""
    return value if value is not None and math.isfinite(value) else None


def ratio_decimals(value: float, decimals: int = 2) -> int:
    """Return the decimals of a ratio that is compared with 1: those, or more where they tell the wrong side of it."""
    while (float(f"{value:.{decimals}f}") >= 1.0) != (value >= 1.0) and decimals < 15:
        decimals += 1
    return decimals


def plain(value: Any) -> Any:
    """Return parts of the results, alone, in lists or tables, as the keys that were set, named as in the file."""
    if isinstance(value, list):
        return [plain(item) for item in value]
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    return value.model_dump(by_alias=True, exclude_unset=True) if isinstance(value, Part) else value
