"""Output in the terminal: a progress bar during the analyses, and a summary of the run as a table or JSON."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assessment.ntc.limit_states import INDEXED
from assessment.results.echo import turns
from assessment.results.plain import plain
from assessment.results.schema import Results
from assessment.results.table import quoted_limit_state
from assessment.runtime.pace import Pace
from assessment.runtime.show import Show

if TYPE_CHECKING:
    from rich.console import Console

    from assessment.runtime.outcome import Outcome


@dataclass(frozen=True)
class TimeLeft:
    """Time left until a moment (s, of the performance counter), written as h:mm:ss of now; None: not known."""

    until: float | None = None

    def __str__(self) -> str:
        if self.until is None:
            return "-:--:--"
        seconds = max(0, round(self.until - time.perf_counter()))
        return f"{seconds // 3600}:{seconds // 60 % 60:02}:{seconds % 60:02}"


class Bars(Show):
    """A progress bar for the work of the current stage with the time left, and a line for each finished stage."""

    def __init__(self, console: Console) -> None:
        from rich.progress import (
            BarColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
        )

        columns = (
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            TextColumn("{task.fields[count]}", markup=False),
            TimeElapsedColumn(),
            TextColumn("left"),
            TextColumn("{task.fields[left]}", markup=False),
        )
        self.progress = Progress(*columns, console=console, transient=True)

    def begin(self, stage: str, total: int, taken: int, work: float) -> None:
        """See Show."""
        self.stage, self.total, self.taken, self.finished = stage, total, taken, taken
        self.pace = Pace(work, time.perf_counter())
        self.task = self.progress.add_task(stage, total=work, count=f"{taken}/{total}", left=TimeLeft())

    def under_way(self, title: str) -> None:
        """See Show."""
        self.progress.update(self.task, description=f"{self.stage}: {title}")

    def reached(self, done: float) -> None:
        """See Show."""
        self.pace.reached(done, time.perf_counter())
        count = f"{self.finished}/{self.total}"
        self.progress.update(self.task, completed=done, count=count, left=TimeLeft(self.pace.ends))

    def advance(self, done: float) -> None:
        """See Show."""
        self.finished += 1
        self.reached(done)

    def fault(self, title: str, reasons: Sequence[str]) -> None:
        """See Show."""
        for reason in reasons:
            self.progress.console.print(f"✗ {title}: {reason}", highlight=False, markup=False)

    def end(self) -> None:
        """See Show."""
        self.progress.remove_task(self.task)
        kept = f", {self.taken} taken over, inputs unchanged" if self.taken else ""
        seconds = time.perf_counter() - self.pace.began
        self.progress.console.print(
            f"· {self.stage}: {self.total}{kept}, {seconds:.1f} s", highlight=False, markup=False
        )


@contextmanager
def progress() -> Iterator[Show]:
    """Yield a Show that prints progress to standard error; silent if that is not a terminal."""
    if not sys.stderr.isatty():
        from assessment.runtime.show import SILENCE

        yield SILENCE
        return
    from rich.console import Console

    bars = Bars(Console(stderr=True))
    with bars.progress:
        yield bars


def model_summary(results: Results) -> str:
    """Return a summary of the model, a few lines."""
    model = results.model
    return "\n".join(
        [
            results.title,
            f"  blocks {model.blocks} ({model.movable_blocks} movable), joints {model.joints}, "
            f"unknowns {model.unknowns}",
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
    turned = turns(results.echo)
    lines += [
        f"{row['state']}: ultimate movement, {row['contacts']}: {row['ultimate_movement_m']:.4g} m"
        + (" (arc at the support's farthest corner)" if row["state"] in turned else "")
        for row in _ultimates(results)
        if row["ultimate_movement_m"] is not None
    ]
    worst = results.scenarios.worst if results.scenarios else None
    if worst:
        lines.append(
            f"worst scenario: {worst.state} at {1000.0 * worst.movement_m:.4g} mm, {worst.direction}"
            + (": the structure collapses before" if worst.collapses else "")
        )
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
    content = {
        "assesto": results.assesto,
        "title": results.title,
        "output": str(folder),
        "complete": outcome.complete,
        "analyses": {"computed": outcome.computed, "taken_over": outcome.taken},
        "model": {key: value for key, value in plain(results.model).items() if key != "warnings"},
        "capacities": capacities(results),
        "ultimate_movements": _ultimates(results),
        "worst_scenario": plain(results.scenarios.worst) if results.scenarios else None,
        "comparison": plain(results.comparison),
        "warnings": _warnings(results, warnings),
        "timing_s": results.timing_s,
    }
    return json.dumps(content, allow_nan=False, indent=2)


def capacities(results: Results) -> list[dict[str, Any]]:
    """Return a row per state and direction: α0, d_0, a_g and ζ_E of the farthest limit state, and of every check."""
    rows = []
    for name, state in results.states.items():
        for direction, curves in state.pushover.items():
            rigid, capacity = curves.rigid, state.capacity.get(direction)
            checks = capacity.checks if capacity else {}
            limit = quoted_limit_state(checks)
            quoted = checks[limit] if limit else None
            rows.append(
                {
                    "state": name,
                    "direction": direction,
                    "alpha_0": rigid.alpha_0 if rigid else None,
                    "d_0_m": rigid.d_0_m if rigid else None,
                    "limit_state": limit,
                    "a_g_g": quoted.a_g_g if quoted else None,
                    "zeta_E": quoted.zeta_E if quoted else None,
                    "checks": {
                        called: {"a_g_g": check.a_g_g, "zeta_E": check.zeta_E}
                        for called, check in checks.items()
                    },
                }
            )
    return rows


def _table(rows: list[dict[str, Any]]) -> list[str]:
    """The capacities as lines: SLV beside SLC, the farthest limit state where neither was checked."""
    if not rows:
        return []
    width = max(len("state"), *(len(row["state"]) for row in rows))
    asked = dict.fromkeys(check for row in rows for check in row["checks"])
    shown = [limit for limit in INDEXED if limit in asked] or [row["limit_state"] for row in rows[:1]]
    limits = [limit for limit in shown if limit]
    above, head = " " * (width + 24), f"{'state':{width}}  dir   α0      d_0 [m] "
    for limit in limits:
        above += f" {limit:16}"
        head += f" a_g [g]  {'ζ_E' if limit == shown[0] and limit in INDEXED else 'ratio':6} "
    lines = [above.rstrip(), head.rstrip()] if limits else [head.rstrip()]
    for row in rows:
        numbers = f"{_number(row['alpha_0'], 4):7} {_number(row['d_0_m'], 4):8}"
        for limit in limits:
            check = row["checks"].get(limit) or {}
            numbers += f" {_number(check.get('a_g_g'), 3):8} {_number(check.get('zeta_E'), 2):7}"
        lines.append(f"{row['state']:{width}}  {row['direction']}  {numbers.rstrip()}")
    return lines


def _ultimates(results: Results) -> list[dict[str, Any]]:
    return [
        {"state": name, "contacts": behaviour, "ultimate_movement_m": path.ultimate_movement_m}
        for name, state in results.states.items()
        for behaviour, path in state.pushdown.items()
    ]


def _warnings(results: Results, others: Iterable[str]) -> list[str]:
    return [*results.model.warnings, *results.quality.warnings, *others]


def _number(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"
