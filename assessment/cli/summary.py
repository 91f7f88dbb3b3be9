"""The summary of a run on the terminal: the answer, a table by state and direction, warnings; or all of it as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assessment.ntc.tables import INDEXED
from assessment.report.chapters.lead import lead
from assessment.report.language import Words, plain_text
from assessment.results.schema import Campaign, Results, plain
from assessment.results.summary import best_of, fits, movement_text, settlement_lines, turns, undetermined
from assessment.results.table import among_known, gains_by, quoted_limit_state

if TYPE_CHECKING:
    from assessment.runtime.tasks import Outcome


def model_summary(results: Results) -> str:
    """Return a summary of the model, a few lines."""
    model = results.model
    ties = f", ties {len(model.ties)}" if model.ties else ""
    stands = "yes" if model.self_weight_stable else "NO"
    return (
        f"{results.title}\n"
        f"  blocks {model.blocks} ({model.movable_blocks} movable), joints {model.joints}, "
        f"unknowns {model.unknowns}{ties}\n"
        f"  weight {model.weight_kN:.4g} kN; stands under its own weight: {stands}"
    )


def warning_lines(warnings: Iterable[str]) -> list[str]:
    """Return the warnings as lines, each once."""
    return [f"warning: {text}" for text in dict.fromkeys(warnings)]


def summary(outcome: Outcome, folder: Path, warnings: Iterable[str]) -> str:
    """Return a summary of the run: a table by state and direction, then the warnings."""
    results = outcome.results
    lines = [*(plain_text(said) for said in lead(results, Words.of("en"))), "", model_summary(results)]
    lines += [*_table(capacities(results)), *_statics(results), *_studies(results)]
    lines += dynamic_lines(results)
    if outcome.taken:
        lines.append(
            f"taken over from earlier runs: {outcome.taken} of {outcome.taken + outcome.computed} analyses, "
            "inputs unchanged (--fresh computes them again)"
        )
    lines.append(f"results: {folder}")
    return "\n".join([*lines, *warning_lines(_warnings(results, warnings))])


def as_json(outcome: Outcome, folder: Path, warnings: Iterable[str]) -> str:
    """Return the summary as one JSON object; null for what was not asked for or not reached."""
    results = outcome.results
    best = best_of(results.identification) if results.identification else None
    content = {
        "assesto": results.assesto, "title": results.title, "output": str(folder),
        "complete": outcome.complete, "analyses": {"computed": outcome.computed, "taken_over": outcome.taken},
        "model": {key: value for key, value in plain(results.model).items() if key != "warnings"},
        "summary": plain(results.summary), "undetermined": undetermined(results),
        "capacities": capacities(results), "ultimate_movements": _ultimates(results),
        "worst_scenario": plain(results.scenarios.worst) if results.scenarios else None,
        "comparison": plain(results.comparison), "strengthening": plain(results.strengthening),
        "best_movement": plain(best.movement) if best else None, "warnings": _warnings(results, warnings),
        "timing_s": results.timing_s,
    }  # fmt: skip
    return json.dumps(content, allow_nan=False, indent=2)


def capacities(results: Results) -> list[dict[str, Any]]:
    """Return α0, d_0 (m), a_g (g) and ζ_E of the farthest limit state, and every check, by state and direction."""
    rows = []
    for name, state in results.states.items():
        for direction, curves in state.pushover.items():
            capacity = state.capacity.get(direction)
            found = capacity.checks if capacity else {}
            checks = {name: {"a_g_g": check.a_g_g, "zeta_E": check.zeta_E} for name, check in found.items()}
            limit = quoted_limit_state(found)
            rows.append(
                {
                    "state": name, "direction": direction,
                    "alpha_0": curves.rigid.alpha_0 if curves.rigid else None,
                    "d_0_m": curves.rigid.d_0_m if curves.rigid else None, "limit_state": limit,
                    **(checks[limit] if limit else {"a_g_g": None, "zeta_E": None}), "checks": checks,
                }
            )  # fmt: skip
    return rows


def _table(rows: list[dict[str, Any]]) -> list[str]:
    """The capacities as lines: SLV beside SLC, the farthest limit state where neither was checked."""
    if not rows:
        return []
    width = max(len("state"), *(len(row["state"]) for row in rows))
    asked = {check for row in rows for check in row["checks"]}
    limits = [limit for limit in INDEXED if limit in asked]
    limits = limits or [row["limit_state"] for row in rows[:1] if row["limit_state"]]
    above, head = " " * (width + 24), f"{'state':{width}}  dir   α0      d_0 [m] "
    for limit in limits:
        above += f" {limit:16}"
        head += f" a_g [g]  {'ζ_E' if limit == limits[0] and limit in INDEXED else 'ratio':6} "
    lines = [above.rstrip(), head.rstrip()] if limits else [head.rstrip()]
    for row in rows:
        numbers = f"{_number(row['alpha_0'], 4):7} {_number(row['d_0_m'], 4):8}"
        for limit in limits:
            check = row["checks"].get(limit, {"a_g_g": None, "zeta_E": None})
            ratio = "–" if check["zeta_E"] is None else Words.of("en").ratio(check["zeta_E"])
            numbers += f" {_number(check['a_g_g'], 3):8} {ratio:7}"
        lines.append(f"{row['state']:{width}}  {row['direction']}  {numbers.rstrip()}")
    return lines


def _number(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def _statics(results: Results) -> Iterator[str]:
    """Yield lines on ultimate movements, and on what each strengthened state gains."""
    turned = turns(results.echo)
    for each in _ultimates(results):
        if (movement := each["ultimate_movement_m"]) is not None:
            arc = " (arc at the support's farthest corner)" if each["state"] in turned else ""
            yield f"{each['state']}: ultimate movement, {each['contacts']}: {movement:.4g} m{arc}"
    for row in results.strengthening or ():
        if row.gain is None:
            continue
        pushed = results.states[row.state].pushover.get(row.direction) if row.direction else None
        ties = [each for push in (pushed.by_contacts.values() if pushed else ()) for each in push.ties or ()]
        tension = {
            each.tie: f"{each.tie} {each.greatest_kN:.4g} kN" + (", yields" if each.yields else "")
            for each in sorted(ties, key=lambda each: each.greatest_kN or 0.0)
            if each.greatest_kN is not None
        }
        names = {"a_g_g": f"a_g at {row.limit_state}", "alpha_0": "α0", "alpha_u": "α_u"}
        gained = names.get(gains_by(row) or "", "PGA at collapse")
        where = f" {row.direction}" if row.direction else ""
        pulled = f"; greatest tension: {'; '.join(tension.values())}" if tension else ""
        yield f"{row.state}{where}: {gained} {100.0 * row.gain:+.0f} % over {row.of}{pulled}"


def _ultimates(results: Results) -> list[dict[str, Any]]:
    """Return the ultimate movement (m) of every state and behaviour of its joints; None: not sought, or not reached."""
    return [
        {"state": name, "contacts": behaviour, "ultimate_movement_m": path.ultimate_movement_m}
        for name, state in results.states.items()
        for behaviour, path in state.pushdown.items()
    ]


def _studies(results: Results) -> Iterator[str]:
    """Yield lines on the best movement, as the project file has it too, and on the worst scenario."""
    identified = results.identification
    if identified and (best := best_of(identified)):
        moved = "; ".join(map(movement_text, best.movement))
        freedom = best.degrees_of_freedom
        yield f"best movement: {moved} (χ² {best.chi_squared:.3g}, {freedom} degrees of freedom)"
        if identified.settlements and not fits(best):
            yield "  # does not fit the measurements: not to be used"
        for ready in identified.settlements:
            yield from (f"  {line}" for line in settlement_lines(ready))
    scenarios = results.scenarios
    if scenarios and (worst := scenarios.worst):
        counts = None if worst.collapses else among_known(scenarios)
        among = " among the {} of {} that have a capacity".format(*counts) if counts else ""
        fallen = ": the structure collapses before" if worst.collapses else ""
        movement = f"{1000.0 * worst.movement_m:.4g} mm, {worst.direction}"
        yield f"worst scenario{among}: {worst.state} at {movement}{fallen}"


def dynamic_lines(results: Results) -> Iterator[str]:
    """Yield a line for each history and incremental analysis of a state, and for each movement of the campaign."""
    for name, state in results.states.items():
        for entry in state.history:
            came_to = f"peak {Words.of('en').told('peak_displacement_m', entry.peak_displacement_m)}"
            if entry.collapsed is None:
                came_to = "not computed"
            elif entry.collapsed:
                came_to = f"collapse at {_value(entry.time_of_collapse_s, '{:.3g} s')}"
            yield f"history {entry.record}, {name}: {came_to}".replace("\u00a0", " ")
    for name, state in results.states.items():
        if state.incremental.records is not None:
            rule = state.incremental.rule or "lowest; NTC 2018 §7.3.5 needs three records"
            borne = _value(state.incremental.pga_collapse_g, "{:.3g} g")
            yield f"incremental analysis, {name}: PGA at collapse {borne} ({rule})"
    if results.campaign:
        yield from _campaign_lines(results.campaign)


def _campaign_lines(found: Campaign) -> Iterator[str]:
    for fit, loss in zip(found.fragility, found.loss, strict=True):
        parts = [f"median {found.measure} at collapse {_value(fit.median_g, '{:.3g} g')}"]
        if fit.share:
            static = "" if loss.static is None else f" (static {100.0 * loss.static:+.1f} %)"
            dynamic = None if loss.dynamic is None else 100.0 * loss.dynamic
            parts.append(f"loss {_value(dynamic, '{:+.1f} %')}{static}")
        if fit.rule:
            parts.append(f"PGA of NTC 2018 §7.3.5 {_value(fit.pga_collapse_g, '{:.3g} g')} ({fit.rule})")
        elif found.method == "incremental":
            parts.append("no PGA of NTC 2018 §7.3.5, which needs three records")
        yield f"campaign, {fit.settlement} × {fit.share:g}: {', '.join(parts)}"


def _value(value: float | None, form: str) -> str:
    return "not determined" if value is None else form.format(value)


def _warnings(results: Results, others: Iterable[str]) -> list[str]:
    return [*results.model.warnings, *results.quality.warnings, *others]
