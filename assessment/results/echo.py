"""What is read of the project file in the results: its tables are plain, their keys those of `assesto schema`."""

from __future__ import annotations

from typing import Any

from assessment.results.schema.model import Block, Echo
from assessment.results.schema.part import present
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


def taken_to_collapse(echo: Echo) -> set[str]:
    """Return the settlements whose ultimate movement is to be found."""
    return {each["name"] for each in echo.settlements or () if each.get("to_collapse")}


def turns(echo: Echo) -> set[str]:
    """Return the settlements that are a rotation alone."""
    return {
        each["name"]
        for each in echo.settlements or ()
        if each["rotation_rad"] and not any(each["displacement_m"])
    }


def limit_states(echo: Echo) -> list[str]:
    """Return the limit states of the project."""
    return list((echo.assessment or {}).get("limit_states", []))


def local_limit(echo: Echo) -> tuple[float | None, str]:
    """Return the displacement limit that was given (m; None: none was) and its reason."""
    assessment = echo.assessment or {}
    return assessment.get("local_displacement_limit_m"), assessment.get("local_displacement_reason") or ""


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
