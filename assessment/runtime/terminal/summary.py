"""The summary of a run on the terminal: the model, a table by state and direction, warnings; or all of it as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from assessment.ntc.limit_states import INDEXED
from assessment.results.echo import turns
from assessment.results.identified import best_of, fits, movement_text, settlement_lines
from assessment.results.plain import plain, ratio_decimals
from assessment.results.schema import Results
from assessment.results.schema.checks import Direction, StrengtheningRow
from assessment.results.schema.identification import SupportMovement
from assessment.results.schema.static import Contacts
from assessment.results.table import among_known, gains_by, quoted_limit_state
from assessment.results.undetermined import undetermined
from assessment.runtime.terminal.dynamic import dynamic_lines

if TYPE_CHECKING:
    from assessment.runtime.tasks import Outcome


def model_summary(results: Results) -> str:
    """Return a summary of the model, a few lines."""
    model = results.model
    ties = f", ties {len(model.ties)}" if model.ties else ""
    return "\n".join(
        [
            results.title,
            f"  blocks {model.blocks} ({model.movable_blocks} movable), joints {model.joints}, "
            f"unknowns {model.unknowns}{ties}",
            f"  weight {model.weight_kN:.4g} kN; stands under its own weight: "
            f"{'yes' if model.self_weight_stable else 'NO'}",
        ]
    )


def warning_lines(warnings: Iterable[str]) -> list[str]:
    """Return the warnings as lines, each once."""
    return [f"warning: {text}" for text in dict.fromkeys(warnings)]


def summary(outcome: Outcome, folder: Path, warnings: Iterable[str]) -> str:
    """Return a summary of the run: a table by state and direction, then the warnings."""
    results = outcome.results
    lines = [model_summary(results), *_table(capacities(results))]
    lines += [
        f"{name}: ζ_E not determined: towards {', '.join(directions)} no capacity was found"
        for name, directions in undetermined(results).items()
    ]
    turned = turns(results.echo)
    lines += [
        f"{each.state}: ultimate movement, {each.contacts}: {each.ultimate_movement_m:.4g} m"
        + (" (arc at the support's farthest corner)" if each.state in turned else "")
        for each in _ultimates(results)
        if each.ultimate_movement_m is not None
    ]
    lines += _strengthened(results)
    lines += _identified(results)
    lines += _worst(results)
    lines += dynamic_lines(results)
    if outcome.taken:
        lines.append(
            f"taken over from earlier runs: {outcome.taken} of {outcome.taken + outcome.computed} analyses, "
            "inputs unchanged (--fresh computes them again)"
        )
    lines.append(f"results: {folder}")
    return "\n".join([*lines, *warning_lines(_warnings(results, warnings))])


def _worst(results: Results) -> list[str]:
    """Return a line for the worst scenario, which says among how many of them it is where some have no capacity."""
    found = results.scenarios
    if found is None or (worst := found.worst) is None:
        return []
    among = ""
    if not worst.collapses and (counts := among_known(found)):
        among = " among the {} of {} that have a capacity".format(*counts)
    return [
        f"worst scenario{among}: {worst.state} at {1000.0 * worst.movement_m:.4g} mm, {worst.direction}"
        + (": the structure collapses before" if worst.collapses else "")
    ]


def _best_movement(results: Results) -> list[SupportMovement] | None:
    found = results.identification
    best = best_of(found) if found else None
    return best.movement if best else None


def _identified(results: Results) -> list[str]:
    """Return a line for the best movement, and those of it for the project file."""
    found = results.identification
    best = best_of(found) if found else None
    if found is None or best is None:
        return []
    moved = "; ".join(map(movement_text, best.movement))
    lines = [
        f"best movement: {moved} (χ² {best.chi_squared:.3g}, {best.degrees_of_freedom} degrees of freedom)"
    ]
    if found.settlements and not fits(best):
        lines.append("  # does not fit the measurements: not to be used")
    for ready in found.settlements:
        lines += [f"  {line}" for line in settlement_lines(ready)]
    return lines


def _strengthened(results: Results) -> list[str]:
    """Return a line for each strengthened state and direction: what it gains, and the tension of its ties."""
    lines = []
    for row in results.strengthening or ():
        if row.gain is None:
            continue
        pushed = results.states[row.state].pushover.get(row.direction) if row.direction else None
        ties = [each for push in (pushed.by_contacts.values() if pushed else ()) for each in push.ties or ()]
        told = {
            each.tie: f"{each.tie} {each.greatest_kN:.4g} kN" + (", yields" if each.yields else "")
            for each in sorted(ties, key=lambda each: each.greatest_kN or 0.0)
            if each.greatest_kN is not None
        }
        where = f" {row.direction}" if row.direction else ""
        pulled = f"; greatest tension: {'; '.join(told.values())}" if told else ""
        lines.append(f"{row.state}{where}: {_gained(row)} {100.0 * row.gain:+.0f} % over {row.of}{pulled}")
    return lines


def _gained(row: StrengtheningRow) -> str:
    """Return what the gain of a strengthened state is of."""
    named = {"a_g_g": f"a_g at {row.limit_state}", "alpha_0": "α0", "alpha_u": "α_u"}
    return named.get(gains_by(row) or "", "PGA at collapse")


def as_json(outcome: Outcome, folder: Path, warnings: Iterable[str]) -> str:
    """Return the summary as one JSON object; null for what was not asked for or not reached."""
    results = outcome.results
    content = {
        "assesto": results.assesto,
        "title": results.title,
        "output": str(folder),
        "complete": outcome.complete,
        "analyses": {"computed": outcome.computed, "taken_over": outcome.taken},
        "model": {key: value for key, value in plain(results.model).items() if key != "warnings"},
        "undetermined": undetermined(results),
        "capacities": [asdict(each) for each in capacities(results)],
        "ultimate_movements": [asdict(each) for each in _ultimates(results)],
        "worst_scenario": plain(results.scenarios.worst) if results.scenarios else None,
        "comparison": plain(results.comparison),
        "strengthening": plain(results.strengthening),
        "best_movement": plain(_best_movement(results)),
        "warnings": _warnings(results, warnings),
        "timing_s": results.timing_s,
    }
    return json.dumps(content, allow_nan=False, indent=2)


@dataclass(frozen=True)
class CheckSummary:
    """A check in a summary: a_g borne (g), and its ratio to that demanded; None: not defined."""

    a_g_g: float | None
    zeta_E: float | None


@dataclass(frozen=True)
class CapacitySummary:
    """A state in one direction: α0, d_0 (m), a_g (g) and ζ_E of the farthest limit state, and every check by name."""

    state: str
    direction: Direction
    alpha_0: float | None
    d_0_m: float | None
    limit_state: str | None
    a_g_g: float | None
    zeta_E: float | None
    checks: dict[str, CheckSummary]


def capacities(results: Results) -> list[CapacitySummary]:
    """Return the capacities of every state and direction."""
    rows = []
    for name, state in results.states.items():
        for direction, curves in state.pushover.items():
            rigid, capacity = curves.rigid, state.capacity.get(direction)
            checks = capacity.checks if capacity else {}
            limit = quoted_limit_state(checks)
            quoted = checks[limit] if limit else None
            rows.append(
                CapacitySummary(
                    state=name,
                    direction=direction,
                    alpha_0=rigid.alpha_0 if rigid else None,
                    d_0_m=rigid.d_0_m if rigid else None,
                    limit_state=limit,
                    a_g_g=quoted.a_g_g if quoted else None,
                    zeta_E=quoted.zeta_E if quoted else None,
                    checks={name: CheckSummary(check.a_g_g, check.zeta_E) for name, check in checks.items()},
                )
            )
    return rows


def _table(rows: list[CapacitySummary]) -> list[str]:
    """The capacities as lines: SLV beside SLC, the farthest limit state where neither was checked."""
    if not rows:
        return []
    width = max(len("state"), *(len(row.state) for row in rows))
    asked = dict.fromkeys(check for row in rows for check in row.checks)
    limits = [limit for limit in INDEXED if limit in asked]
    limits = limits or [row.limit_state for row in rows[:1] if row.limit_state]
    above, head = " " * (width + 24), f"{'state':{width}}  dir   α0      d_0 [m] "
    for limit in limits:
        above += f" {limit:16}"
        head += f" a_g [g]  {'ζ_E' if limit == limits[0] and limit in INDEXED else 'ratio':6} "
    lines = [above.rstrip(), head.rstrip()] if limits else [head.rstrip()]
    for row in rows:
        numbers = f"{_number(row.alpha_0, 4):7} {_number(row.d_0_m, 4):8}"
        for limit in limits:
            check = row.checks.get(limit) or CheckSummary(None, None)
            numbers += f" {_number(check.a_g_g, 3):8} {_ratio(check.zeta_E):7}"
        lines.append(f"{row.state:{width}}  {row.direction}  {numbers.rstrip()}")
    return lines


@dataclass(frozen=True)
class _Ultimate:
    """The ultimate movement (m) of a state under one behaviour of its joints; None: not sought, or not reached."""

    state: str
    contacts: Contacts
    ultimate_movement_m: float | None


def _ultimates(results: Results) -> list[_Ultimate]:
    return [
        _Ultimate(name, behaviour, path.ultimate_movement_m)
        for name, state in results.states.items()
        for behaviour, path in state.pushdown.items()
    ]


def _warnings(results: Results, others: Iterable[str]) -> list[str]:
    return [*results.model.warnings, *results.quality.warnings, *others]


def _ratio(value: float | None) -> str:
    return _number(value, 2 if value is None else ratio_decimals(value))


def _number(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"
