"""What was asked for and has no capacity: a state of which one direction is not known has no index."""

from __future__ import annotations

from collections.abc import Iterable

from assessment.ntc.limit_states import CHECKS
from assessment.results.echo import limit_states
from assessment.results.schema import Results
from assessment.results.schema.checks import Direction
from assessment.results.schema.indices import Indices


def undetermined(results: Results) -> dict[str, list[Direction]]:
    """Return by state the directions in which a capacity was asked for and none found; nothing of complete states."""
    if not results.echo.assessment:
        return {}
    asked = directions_asked(results)
    missing = {name: without(state.capacity, asked) for name, state in results.states.items()}
    return {name: directions for name, directions in missing.items() if directions}


def without(capacities: Iterable[Direction], asked: Iterable[Direction]) -> list[Direction]:
    """Return the directions asked for that are not among those with a capacity."""
    known = set(capacities)
    return [direction for direction in asked if direction not in known]


def directions_asked(results: Results) -> list[Direction]:
    """Return the directions of the pushover: those of the project file, then any other that a state was pushed in."""
    pushed = [direction for state in results.states.values() for direction in sorted(state.pushover)]
    return list(dict.fromkeys([*((results.echo.pushover or {}).get("directions") or ()), *pushed]))


def checks_asked(results: Results) -> list[str]:
    """Return the checks of each direction: those that any has; where none has, those of the limit states."""
    made = {
        name
        for state in results.states.values()
        for capacity in state.capacity.values()
        for name in capacity.checks
    }
    if made:
        return [name for name in CHECKS if name in made]
    asked = set(limit_states(results.echo))
    return [name for name in CHECKS if name.removesuffix(" linear") in asked]


def determined_indices(results: Results) -> dict[str, Indices]:
    """Return the indices of the states that have a capacity in every direction asked for."""
    missing = undetermined(results)
    return {
        name: state.indices for name, state in results.states.items() if state.indices and name not in missing
    }
