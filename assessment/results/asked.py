"""What the project file asked for, and what of it has no capacity."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from assessment.ntc.tables import CHECKS
from assessment.results.schema import Block, Direction, Echo, Indices, Results, present
from mechanics.messages import layer_key


def material(echo: Echo, block: Block) -> dict[str, Any]:
    """Return what a block is made of and loaded by: keys of its region before those of its layer and of [material]."""
    own = {layer_key(name): table for name, table in (echo.layers or {}).items()}
    regions = {each["name"]: each for each in echo.region or ()}
    layer, region = own.get(layer_key(block.layer)), regions.get(block.region or "")
    return echo.material | present(layer or {}) | present(region or {})


def segments(echo: Echo) -> list[int]:
    """Return the numbers of segments that joints are divided into, each once; of exact joints none."""
    tables = [echo.geometry, *(echo.layers or {}).values(), *(echo.region or ())]
    return sorted({table["segments_per_joint"] for table in tables if table.get("segments_per_joint")})


def coulomb(echo: Echo) -> bool:
    """Return whether what slides does not lift."""
    return (echo.contacts or {}).get("sliding") == "coulomb"


def collisions(echo: Echo) -> bool:
    """Return whether blocks that were apart may come to touch."""
    return bool((echo.contacts or {}).get("collisions", True))


def damped(echo: Echo) -> bool:
    """Return whether joints of a motion have dashpots."""
    shaking = (*(echo.history or ()), echo.incremental or {}, echo.campaign or {})
    return any(each.get("damping_ratio") for each in shaking)


def taken_to_collapse(echo: Echo) -> set[str]:
    """Return the settlements whose ultimate movement is to be found."""
    return {each["name"] for each in echo.settlements or () if each.get("to_collapse")}


def turns(echo: Echo) -> set[str]:
    """Return the settlements that are a rotation alone."""
    rotated = (each for each in echo.settlements or () if each["rotation_rad"])
    return {each["name"] for each in rotated if not any(each["displacement_m"])}


def limit_states(echo: Echo) -> list[str]:
    """Return the limit states of the project."""
    return list((echo.assessment or {}).get("limit_states", []))


def printed(echo: Echo) -> dict[str, Any]:
    """Return the input to be printed: nominal life and use class only where the hazard is known to follow from them."""
    content = echo.model_dump(exclude_unset=True)
    assessment = echo.assessment or {}
    site = assessment.get("site") or {}
    typed = [site[limit] for limit in ("SLD", "SLV", "SLC") if site.get(limit)]
    if not typed or all(hazard.get("return_period_years") for hazard in typed):
        return content
    kept = {key: value for key, value in site.items() if key not in {"nominal_life_years", "use_class"}}
    return {**content, "assessment": {**assessment, "site": kept}}


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
    capacities = [each for state in results.states.values() for each in state.capacity.values()]
    if made := {name for capacity in capacities for name in capacity.checks}:
        return [name for name in CHECKS if name in made]
    asked = set(limit_states(results.echo))
    return [name for name in CHECKS if name.removesuffix(" linear") in asked]


def determined_indices(results: Results) -> dict[str, Indices]:
    """Return the indices of the states that have a capacity in every direction asked for."""
    found = present({name: state.indices for name, state in results.states.items()})
    return {name: each for name, each in found.items() if name not in undetermined(results)}
