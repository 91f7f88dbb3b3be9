"""The outcome of an identification: hypotheses worth telling, the best movement on a line and for the project file."""

from __future__ import annotations

import json

from assessment.results.schema.studies import (
    Explanation,
    Identification,
    ReadySettlement,
    SupportMovement,
)

UNLIKELY = 0.05  # probability of a χ² as large, below which a movement explains nothing
UNMET = 9.0  # χ² of a measurement that is off by three standard deviations


def best_of(found: Identification) -> Explanation | None:
    """Return the hypothesis with the least AIC; None where none could be followed."""
    return None if found.best is None else found.hypotheses[found.best]


def told_of(found: Identification) -> list[Explanation]:
    """Return the hypotheses that are not told from the best one, it first."""
    best = best_of(found)
    others = [each for each in found.hypotheses if each is not best and not each.distinguished]
    return [] if best is None else [best, *others]


def fits(best: Explanation) -> bool:
    """Return whether a movement explains the measurements.

    It does not where its χ² is improbable, where a measurement contradicts it, and where as many unknowns as
    measurements leave a χ² above that of one measurement off by three standard deviations.
    """
    unlikely = best.probability is not None and best.probability < UNLIKELY
    unmet = not best.degrees_of_freedom and (best.chi_squared or 0.0) > UNMET
    return not (unlikely or unmet or best.contradicting)


def settlement_lines(ready: ReadySettlement) -> list[str]:
    """Return the lines of a movement in a project file."""
    x, z = ready.displacement_m
    lines = [
        "[[settlements]]",
        f"name = {json.dumps(ready.name, ensure_ascii=False)}",
        f"support = {json.dumps(ready.support, ensure_ascii=False)}",
        f"displacement_m = [{_number(x)}, {_number(z)}]",
    ]
    return [*lines, f"rotation_rad = {_number(ready.rotation_rad)}"] if ready.rotation_rad else lines


def movement_text(each: SupportMovement) -> str:
    """Return a movement on one line, in mm and mrad, with the standard errors that are known."""
    told = []
    for name, unit in (("x", "m"), ("z", "m"), ("rotation", "rad")):
        key = f"{name}_standard_error_{unit}"
        if key in each.model_fields_set:
            value, error = getattr(each, f"{name}_{unit}"), getattr(each, key)
            known = f" m{unit} (not determined)" if error is None else f" ± {1e3 * error:.2g} m{unit}"
            told.append(f"{name} {1e3 * value:.3g}{known}")
    return f"{each.support}: {', '.join(told)}"


def _number(value: float) -> str:
    """Return a number as TOML has it: with a point, and without a power."""
    text = f"{value:.7f}".rstrip("0")
    return f"{text}0" if text.endswith(".") else text
