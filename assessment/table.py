"""What every table of results is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

Results = Mapping[str, Any]
Row = dict[str, Any]
# limit states, and beside the nonlinear check at SLV the linear one
CHECKS = ("SLO", "SLD", "SLV linear", "SLV", "SLC")
QUOTED = ("SLC", "SLV", "SLD", "SLO")  # limit states, the farthest first


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


def static_pga(capacity: Mapping[str, Any] | None) -> float | None:
    """Return the a_g borne (g) at the farthest limit state that was checked in a direction."""
    checks = [(capacity or {}).get(limit_state) for limit_state in QUOTED]
    value: float | None = next((check["a_g_g"] for check in checks if check), None)
    return value


def decisive(capacity: Mapping[str, Any]) -> dict[str, float]:
    """Return ζ_E of the checks of a direction that have one and decide.

    The linear check at SLV is an alternative to the nonlinear one, and counts only where that one has no number.
    """
    known = {name: (capacity.get(name) or {}).get("zeta_E") for name in CHECKS}
    found = {name: float(zeta) for name, zeta in known.items() if zeta is not None}
    if "SLV" in found:
        found.pop("SLV linear", None)
    return found


def taken_to_collapse(results: Results) -> set[str]:
    """Return the settlements whose ultimate movement was sought."""
    return {each["name"] for each in results["echo"].get("settlements") or () if each.get("to_collapse")}
