"""The kinds of values in a project file, each with its bounds, and the table that holds them."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, StringConstraints

from assessment.runtime.errors import shortened

if TYPE_CHECKING:
    from assessment.project.schema import ProjectContent

KeyPath = tuple[str | int, ...]
"""Where a value stands in the project's content, list entries counted from 0."""


def key_of(path: KeyPath) -> str:
    """Return how a message names the value at a path: history[1].contacts."""
    key = "" if path else "project"
    for part in path:
        if isinstance(part, int):
            key += f"[{part + 1}]"
        else:
            quoted = shortened(json.dumps(part, ensure_ascii=False), SHOWN)
            key += "." * bool(key) + (part if re.fullmatch(r"[\w+-]+", part) else quoted)
    return key


class Problem(NamedTuple):
    """What is wrong with the value at `path`, and the remedy."""

    path: KeyPath
    text: str


Contradiction = tuple[str | KeyPath, str] | Problem
"""A key of a table, or a path below it, () for the table itself, and what is wrong there; a Problem where elsewhere."""


@dataclass(frozen=True)
class NameOf:
    """Marks a key whose names are those of something else in the project."""

    what: Literal["control point", "support", "settlement", "state"]


@dataclass(frozen=True)
class FileName:
    """Marks a key whose names are those of files in the project's folder; `records`: patterns, or a number to make."""

    kind: Literal["file", "pattern", "records", "picture"] = "file"


SHOWN = 40  # characters of a value, or of a key in quotes, that a message shows
DISTINCT = "distinct"
"""Marks a list of tables whose names are different, or tables of different layers."""

ORIGINAL = "original"  # name of the state before any settlement

Entry = TypeVar("Entry", str, float, int)
Table = TypeVar("Table", bound="ProjectTable")

# Nothing invisible: what cannot be seen in an editor or held by a spreadsheet cell is a typing slip.
_UNSEEN = r"\x00-\x08\x0b-\x1f\x7f-\x9f\u200b\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ufffe\uffff"

_MOST_STIFFNESS = 1e11  # kN/m³

MOST_ENTRIES = 1000  # a list of tables or of names has no more
MOST_LAYERS = 10_000  # tables [layers.NAME], at most


def unique(items: tuple[Entry, ...]) -> tuple[Entry, ...]:
    """Return the items. Raises ValueError where one appears twice."""
    if len(set(items)) < len(items):
        raise ValueError("an entry appears twice; write each entry once")
    return items


def _stiff_or_rigid(stiffness: float) -> float:
    if _MOST_STIFFNESS < stiffness < math.inf:
        text = f"{stiffness:g} is more than {_MOST_STIFFNESS:g}"
        raise ValueError(f"{text}; write inf for a joint that is rigid in shear")
    return stiffness


# Bounds so wide that only a slip lies outside, so narrow that no arithmetic overflows.
Length = Annotated[float, Field(ge=1e-6, le=1e5)]  # m
Step = Annotated[float, Field(ge=1e-7, le=1e3)]  # m, of a movement
Drawn = Annotated[float, Field(ge=1e-7, le=1e2)]  # m, a tolerance of the drawing
Coordinate = Annotated[float, Field(ge=-1e7, le=1e7)]  # m
Shift = Annotated[float, Field(ge=-1e5, le=1e5)]  # m
Angle = Annotated[float, Field(ge=-6.3, le=6.3)]  # rad
AngleStep = Annotated[float, Field(ge=1e-7, le=1)]  # rad
UnitWeight = Annotated[float, Field(ge=1e-3, le=1e6)]  # kN/m³
Stiffness = Annotated[float, Field(ge=1e-3, le=_MOST_STIFFNESS)]  # kN/m³
Rigidity = Annotated[float, Field(ge=1e-3, allow_inf_nan=True), AfterValidator(_stiff_or_rigid)]  # kN/m³
Friction = Annotated[float, Field(ge=0, allow_inf_nan=True)]  # inf: no sliding
Load = Annotated[float, Field(ge=-1e9, le=1e9)]  # kN
Seconds = Annotated[float, Field(ge=1e-6, le=1e3)]
Instant = Annotated[float, Field(ge=-1e6, le=1e6)]  # s
Acceleration = Annotated[float, Field(ge=1e-6, le=1e3)]  # g
Factor = Annotated[float, Field(ge=1e-4, le=1e4)]
Ratio = Annotated[float, Field(ge=-1e4, le=1e4)]
Damping = Annotated[float, Field(ge=0, le=0.3)]
Period = Annotated[float, Field(ge=1e-6, le=10)]  # s, of a structure
BlockNumber = Annotated[int, Field(ge=0, le=10**9)]
Strength = Annotated[float, Field(ge=1, allow_inf_nan=True)]  # kN/m²; inf: no limit
Yield = Annotated[float, Field(ge=1e-3, allow_inf_nan=True)]  # kN; inf: no limit
Elongation = Annotated[float, Field(ge=1e-6, allow_inf_nan=True)]  # of a length; inf: no limit
Tension = Annotated[float, Field(ge=0, le=1e6)]  # kN
BarStiffness = Annotated[float, Field(ge=1e-3, le=1e9)]  # kN/m
Segments = Annotated[int, Field(ge=1, le=64)]
Members = Annotated[int, Field(ge=1, le=100)]
Pair = Annotated[tuple[Coordinate, Coordinate], Field(strict=False)]
Movement = Annotated[tuple[Shift, Shift], Field(strict=False)]
Window = Annotated[tuple[Instant, Instant], Field(strict=False)]
Varied = Annotated[float, Field(ge=1e-2, le=1e2)]
Factors = Annotated[tuple[Varied, Varied], Field(strict=False)]
Tolerance = Annotated[float, Field(ge=1e-6, lt=1)]
Share = Annotated[float, Field(ge=0, le=1)]
Name = Annotated[str, Field(max_length=200, pattern=rf"^[^\s{_UNSEEN}]([^\t\n{_UNSEEN}]*[^\s{_UNSEEN}])?$")]
Text = Annotated[str, StringConstraints(strip_whitespace=True, max_length=2000, pattern=rf"^[^{_UNSEEN}]*$")]
ENTRIES = Field(strict=False, min_length=1, max_length=MOST_ENTRIES, json_schema_extra={"uniqueItems": True})
TABLES = Field(strict=False, max_length=MOST_ENTRIES)
Named = Annotated[tuple[Table, ...], TABLES, DISTINCT]
Names = Annotated[tuple[Name, ...], ENTRIES, AfterValidator(unique)]
Series = Annotated[tuple[Name, ...], Field(strict=False, min_length=1, max_length=MOST_ENTRIES)]
Behaviour = Literal["rigid", "elastic"]
Direction = Literal["+x", "-x"]
LimitState = Literal["SLD", "SLV", "SLC"]
UseCategory = Literal["A", "B", "C", "D", "E", "F", "G", "H", "I", "K", "snow", "snow above 1000 m", "wind"]
ContactsList = Annotated[tuple[Behaviour, ...], ENTRIES, AfterValidator(unique)]
Directions = Annotated[tuple[Direction, ...], ENTRIES, AfterValidator(unique)]
LimitStates = Annotated[tuple[LimitState, ...], ENTRIES, AfterValidator(unique)]

RecordSet = Annotated[
    tuple[Name, ...], ENTRIES, AfterValidator(unique),
    BeforeValidator(lambda given: (given,) if isinstance(given, str) else given),
]  # fmt: skip
Shares = Annotated[tuple[Share, ...], ENTRIES, AfterValidator(unique)]
Signs = Annotated[tuple[Literal[1, -1], ...], ENTRIES, AfterValidator(unique)]
MemberNumbers = Annotated[tuple[Members, ...], ENTRIES, AfterValidator(unique)]
Levels = Annotated[tuple[Acceleration, ...], ENTRIES, AfterValidator(unique)]
Periods = Annotated[tuple[Period, Period], Field(strict=False)]


def entry(meaning: str, default: Any = ...) -> Any:
    """A key of a table with what it means, for the user: required, or with a default."""
    # JSON has no infinity: its schema leaves such a default out
    hidden: dict[str, Any] = {"json_schema_extra": lambda schema: schema.pop("default")}
    return Field(default, description=meaning, **(hidden if default == math.inf else {}))


def absent(meaning: str, **more: Any) -> Any:
    """A key of a table that may be left out; `meaning` says what holds then."""
    return Field(None, description=meaning, **more)


class ProjectTable(BaseModel):
    """A table of the project file: exact types, finite numbers, no other keys, not to be changed."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield what does not go together in this table, or with others of the `project`; names and files apart."""
        yield from ()
