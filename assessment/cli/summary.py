"""The summary of a run on the terminal: the answer, a table by state and direction, warnings; or all of it as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assessment.ntc.tables import farthest
from assessment.report.terminal import told
from assessment.results.schema import Results, plain
from assessment.results.summary import best_of, undetermined

if TYPE_CHECKING:
    from assessment.runtime.tasks import Outcome


def warning_lines(warnings: Iterable[str]) -> list[str]:
    """Return the warnings as lines, each once."""
    return [f"warning: {text}" for text in dict.fromkeys(warnings)]


def summary(outcome: Outcome, folder: Path, warnings: Iterable[str]) -> str:
    """Return a summary of the run: what was found, a table by state and direction, then the warnings."""
    lines = [outcome.told or told(outcome.results)]
    if outcome.taken:
        lines.append(
            f"taken over from earlier runs: {outcome.taken} of {outcome.taken + outcome.computed} analyses, "
            "inputs unchanged (--fresh computes them again)"
        )
    lines.append(f"results: {folder}")
    return "\n".join([*lines, *warning_lines(_warnings(outcome.results, warnings))])


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
            limit = farthest(found)
            rows.append(
                {
                    "state": name, "direction": direction,
                    "alpha_0": curves.rigid.alpha_0 if curves.rigid else None,
                    "d_0_m": curves.rigid.d_0_m if curves.rigid else None, "limit_state": limit,
                    **(checks[limit] if limit else {"a_g_g": None, "zeta_E": None}), "checks": checks,
                }
            )  # fmt: skip
    return rows


def _ultimates(results: Results) -> list[dict[str, Any]]:
    """Return the ultimate movement (m) of every state and behaviour of its joints; None: not sought, or not reached."""
    return [
        {"state": name, "contacts": behaviour, "ultimate_movement_m": path.ultimate_movement_m}
        for name, state in results.states.items()
        for behaviour, path in state.pushdown.items()
    ]


def _warnings(results: Results, others: Iterable[str]) -> list[str]:
    return [*results.model.warnings, *results.quality.warnings, *others]
