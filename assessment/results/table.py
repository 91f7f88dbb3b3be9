"""What every table of results is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from assessment.ntc.limit_states import CHECKS, INDEXED, QUOTED, ROCK, SURFACE

Results = Mapping[str, Any]
Row = dict[str, Any]


@dataclass(frozen=True)
class Table:
    """Rows as dictionaries. A missing key was not asked for; None was asked for and not reached."""

    name: str
    rows: list[Row]
    columns: tuple[str, ...]


def sense(direction: str) -> float:
    """Return +1 for a push towards +x, −1 towards −x: displacements along the push times it are those along x."""
    return -1.0 if direction == "-x" else 1.0


def reduction(original: float | None, settled: float | None) -> float | None:
    """Return 1 − settled/original: positive where the movement costs capacity; None where one is not known."""
    return None if not original or settled is None else 1.0 - settled / original


def quoted_limit_state(capacity: Mapping[str, Any] | None) -> str | None:
    """Return the farthest limit state that was checked in a direction; None where none was."""
    return next((limit_state for limit_state in QUOTED if (capacity or {}).get(limit_state)), None)


def static_pga(capacity: Mapping[str, Any] | None) -> float | None:
    """Return the a_g borne (g) at the farthest limit state that was checked in a direction."""
    limit_state = quoted_limit_state(capacity)
    value: float | None = capacity[limit_state]["a_g_g"] if capacity and limit_state else None
    return value


def nominal_pga(capacity: Mapping[str, Any] | None) -> float | None:
    """Return the static capacity of a direction on the reference of a dynamic one: PGA at the surface, F_C = 1, g."""
    value: float | None = ((capacity or {}).get("nominal") or {}).get("pga_g")
    return value


def brought_together(capacity: Mapping[str, Any] | None, dynamic: float | None) -> Row:
    """Return the static capacity at the surface with F_C = 1 (g), and the dynamic one over it."""
    static = nominal_pga(capacity)
    ratio = dynamic / static if static and dynamic is not None else None
    return {"static_surface_pga_g": static, "dynamic_to_static": ratio}


def reference_of(results: Results) -> str:
    """Return where the a_g of the checks is: on "rock", or at the "surface" where the spectrum is a record's."""
    kinds = {spectrum.get("kind") for spectrum in (results.get("spectra") or {}).values()}
    return SURFACE if kinds == {"record"} else ROCK


def ratios(capacity: Mapping[str, Any]) -> dict[str, float]:
    """Return the ratio of a_g borne to a_g demanded of every check of a direction that has one, by its name."""
    known = {name: (capacity.get(name) or {}).get("zeta_E") for name in CHECKS}
    return {name: float(ratio) for name, ratio in known.items() if ratio is not None}


def indices(capacity: Mapping[str, Any]) -> dict[str, float]:
    """Return the ratios of a direction that are an index ζ_E (NTC 2018, §8.3): those at SLV and SLC.

    The linear check at SLV is an alternative to the nonlinear one, and stands for it where that one has no number.
    """
    found = {name: ratio for name, ratio in ratios(capacity).items() if name.partition(" ")[0] in INDEXED}
    if "SLV" in found:
        found.pop("SLV linear", None)
    return found


def taken_to_collapse(results: Results) -> set[str]:
    """Return the settlements whose ultimate movement was sought."""
    return {each["name"] for each in results["echo"].get("settlements") or () if each.get("to_collapse")}
