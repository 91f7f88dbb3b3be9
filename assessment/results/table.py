"""What every table of results is made of."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, get_type_hints

from assessment.ntc.tables import INDEXED, QUOTED, ROCK, SURFACE
from assessment.results.schema import Results
from assessment.results.schema.checks import Capacity, Check, StrengtheningRow
from assessment.results.schema.part import QUANTITIES, Part, enter, plain_value
from assessment.results.schema.studies import Capacities, Scenarios

Row = dict[str, Any]


@dataclass(frozen=True)
class Table:
    """Rows as dictionaries. A missing key was not requested; None was requested and not reached."""

    name: str
    rows: list[Row]
    columns: tuple[str, ...]


def sense(direction: str) -> float:
    """Return +1 for a push towards +x, −1 towards −x: displacements along the push times it are those along x."""
    return -1.0 if direction == "-x" else 1.0


def reduction(original: float | None, settled: float | None) -> float | None:
    """Return 1 − settled/original: positive where the movement costs capacity; None where one is not known."""
    return None if not original or settled is None else 1.0 - settled / original


@cache
def columns_of(row: type) -> tuple[str, ...]:
    """Return the columns of a table whose rows are of a class: fields of a dataclass, of a part those with a label.

    The quantities that a dataclass describes are entered.
    """
    if issubclass(row, Part):
        described = row.model_fields.items()
        return tuple(
            name for name, field in described if name in QUANTITIES and plain_value(field.annotation)
        )
    hints = get_type_hints(row, include_extras=True)
    for name, hint in hints.items():
        for told in getattr(hint, "__metadata__", ()):
            enter(name, hint.__origin__, dict(told))
    return tuple(hints)


def cells(part: Part, columns: Iterable[str]) -> Row:
    """Return the columns that a part has: here alone is a missing key another thing than null."""
    return {column: getattr(part, column) for column in columns if column in part.model_fields_set}


def quoted_limit_state(checks: Mapping[str, object]) -> str | None:
    """Return the farthest limit state that was checked, of checks by name; None where none was."""
    return next((limit_state for limit_state in QUOTED if checks.get(limit_state)), None)


def quoted_check(capacity: Capacity | None) -> Check | None:
    """Return the check of the farthest limit state that was checked in a direction."""
    checks = capacity.checks if capacity else {}
    limit_state = quoted_limit_state(checks)
    return checks[limit_state] if limit_state else None


def static_pga(capacity: Capacity | None) -> float | None:
    """Return the PGA borne at the surface (g), S a_g, at the farthest limit state that was checked in a direction."""
    check = quoted_check(capacity)
    return check.pga_g if check else None


def brought_together(static: float | None, dynamic: float | None) -> Row:
    """Return the static capacity at the surface with F_C = 1 (g), and the dynamic one over it."""
    ratio = dynamic / static if static and dynamic is not None else None
    return {"static_surface_pga_g": static, "dynamic_to_static": ratio}


def compared(found: Capacities, quantity: str) -> float | None:
    """Return the quantity that capacities are compared by: a_g (g), α_0 or α_u."""
    value: float | None = getattr(found, quantity)
    return value


def among_known(found: Scenarios) -> tuple[int, int] | None:
    """Return how many of the settled points have the quantity that is compared, and of how many; None where all do."""
    settled = [point for point in found.points if point.state != "original"]
    known = sum(compared(point, found.quantity) is not None for point in settled)
    return (known, len(settled)) if known < len(settled) else None


def gains_by(row: StrengtheningRow) -> str | None:
    """Return the quantity that the gain of a strengthened state is of: the first that is known before."""
    quantities = ("a_g_g", "alpha_0", "alpha_u", "dynamic_pga_g")
    before = (row.a_g_before_g, row.alpha_0_before, row.alpha_u_before, row.dynamic_pga_before_g)
    return next((name for name, value in zip(quantities, before, strict=True) if value is not None), None)


def reference_of(results: Results) -> str:
    """Return where the a_g of the checks is: on "rock", or at the "surface" where the spectrum is a record's."""
    kinds = {spectrum.kind for spectrum in (results.spectra or {}).values()}
    return SURFACE if kinds == {"record"} else ROCK


def indices(ratios: Mapping[str, float]) -> dict[str, float]:
    """Return those of the ratios of a direction, by check, that are an index ζ_E (NTC 2018, §8.3): at SLV and SLC.

    The linear check at SLV is an alternative to the nonlinear one, and replaces it where that one has no number.
    """
    found = {name: ratio for name, ratio in ratios.items() if name.partition(" ")[0] in INDEXED}
    if "SLV" in found:
        found.pop("SLV linear", None)
    return found
