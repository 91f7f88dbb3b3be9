"""What the terminal shows: the analyses under way, and the run in one table or as JSON."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assessment.table import QUOTED

if TYPE_CHECKING:
    from rich.console import Console

    from assessment.outcome import Outcome
    from assessment.parallel import Show

Results = Mapping[str, Any]
LONGEST = 3600.0  # s: an analysis that takes longer than this leaves the time left unknown


class Bars:
    """A bar for the stage under way, with the time left, and a line for each that is finished."""

    def __init__(self, console: Console) -> None:
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        columns = (
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
        )
        self.progress = Progress(*columns, console=console, transient=True, speed_estimate_period=LONGEST)
        self.stage, self.total, self.taken, self.began = "", 0, 0, 0.0

    def begin(self, stage: str, total: int, taken: int) -> None:
        """See Show."""
        self.stage, self.total, self.taken, self.began = stage, total, taken, time.perf_counter()
        self.task = self.progress.add_task(stage, total=total, completed=taken)

    def under_way(self, title: str) -> None:
        """See Show."""
        self.progress.update(self.task, description=f"{self.stage}: {title}")

    def advance(self) -> None:
        """See Show."""
        self.progress.advance(self.task)

    def end(self) -> None:
        """See Show."""
        self.progress.remove_task(self.task)
        kept = f", {self.taken} taken over, inputs unchanged" if self.taken else ""
        seconds = time.perf_counter() - self.began
        self.progress.console.print(
            f"· {self.stage}: {self.total}{kept}, {seconds:.1f} s", highlight=False, markup=False
        )


@contextmanager
def progress() -> Iterator[Show]:
    """Yield what shows the analyses under way on standard error; silent where that is no terminal."""
    if not sys.stderr.isatty():
        from assessment.parallel import SILENCE

        yield SILENCE
        return
    from rich.console import Console

    bars = Bars(Console(stderr=True))
    with bars.progress:
        yield bars


def model_summary(results: Results) -> str:
    """The model in a few lines."""
    model = results["model"]
    return "\n".join(
        [
            f"{results['title']}",
            f"  blocks {model['blocks']} ({model['movable_blocks']} movable), joints {model['joints']}, "
            f"contact points {model['contact_points']}",
            f"  weight {model['weight_kN']:.4g} kN; stands under its own weight: "
            f"{'yes' if model['self_weight_stable'] else 'NO'}",
        ]
    )


def told(warnings: Iterable[str]) -> list[str]:
    """Warnings as lines of their own, each once."""
    return [f"warning: {text}" for text in dict.fromkeys(warnings)]


def summary(outcome: Outcome, folder: Path, warnings: Iterable[str]) -> str:
    """The run in one table, state by direction; warnings last."""
    results = outcome.results
    lines = [model_summary(results), *_table(capacities(results))]
    turns = {
        each["name"]
        for each in results["echo"].get("settlements") or ()
        if each["rotation_rad"] and not any(each["displacement_m"])
    }
    lines += [
        f"{row['state']}: ultimate movement, {row['contacts']}: {row['ultimate_movement_m']:.4g} m"
        + (" (arc at the support's farthest corner)" if row["state"] in turns else "")
        for row in _ultimates(results)
        if row["ultimate_movement_m"] is not None
    ]
    worst = (results.get("scenarios") or {}).get("worst")
    if worst:
        lines.append(
            f"worst scenario: {worst['state']} at {1000.0 * worst['movement_m']:.4g} mm, {worst['direction']}"
            + (": the structure collapses before" if worst["collapses"] else "")
        )
    if outcome.taken:
        lines.append(
            f"taken over from earlier runs: {outcome.taken} of {outcome.taken + outcome.computed} analyses, "
            "inputs unchanged (--fresh computes them again)"
        )
    lines.append(f"results: {folder}")
    return "\n".join([*lines, *told(_warnings(results, warnings))])


def as_json(outcome: Outcome, folder: Path, warnings: Iterable[str]) -> str:
    """The same for programs: one JSON object; what was not asked for or not reached is null."""
    results = outcome.results
    content = {
        "assesto": results["assesto"],
        "title": results["title"],
        "output": str(folder),
        "complete": outcome.complete,
        "analyses": {"computed": outcome.computed, "taken_over": outcome.taken},
        "model": {key: value for key, value in results["model"].items() if key != "warnings"},
        "capacities": capacities(results),
        "ultimate_movements": _ultimates(results),
        "worst_scenario": (results.get("scenarios") or {}).get("worst"),
        "comparison": results["comparison"],
        "warnings": _warnings(results, warnings),
        "timing_s": results["timing_s"],
    }
    return json.dumps(content, allow_nan=False, indent=2)


def capacities(results: Results) -> list[dict[str, Any]]:
    """Return a row per state and direction: α0, d_0, and a_g and ζ_E of the farthest limit state."""
    rows = []
    for name, state in results["states"].items():
        for direction, curves in state["pushover"].items():
            rigid, checks = curves.get("rigid") or {}, state["capacity"].get(direction) or {}
            limit = next((limit for limit in QUOTED if limit in checks), None)
            check = checks[limit] if limit else {}
            rows.append(
                {
                    "state": name,
                    "direction": direction,
                    "alpha_0": rigid.get("alpha_0"),
                    "d_0_m": rigid.get("d_0_m"),
                    "limit_state": limit,
                    "a_g_g": check.get("a_g_g"),
                    "zeta_E": check.get("zeta_E"),
                }
            )
    return rows


def _table(rows: list[dict[str, Any]]) -> list[str]:
    if not rows:
        return []
    width = max(len("state"), *(len(row["state"]) for row in rows))
    limits = ", ".join(dict.fromkeys(row["limit_state"] for row in rows if row["limit_state"]))
    lines = [f"{'state':{width}}  dir   α0      d_0 [m]  a_g [g]  ζ_E" + (f" ({limits})" if limits else "")]
    for row in rows:
        numbers = (
            f"{_number(row['alpha_0'], 4):7} {_number(row['d_0_m'], 4):8} "
            f"{_number(row['a_g_g'], 3):8} {_number(row['zeta_E'], 2)}"
        )
        lines.append(f"{row['state']:{width}}  {row['direction']}  {numbers}")
    return lines


def _ultimates(results: Results) -> list[dict[str, Any]]:
    return [
        {"state": name, "contacts": behaviour, "ultimate_movement_m": path["ultimate_movement_m"]}
        for name, state in results["states"].items()
        for behaviour, path in state["pushdown"].items()
    ]


def _warnings(results: Results, others: Iterable[str]) -> list[str]:
    return [*results["model"]["warnings"], *results["quality"]["warnings"], *others]


def _number(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"
