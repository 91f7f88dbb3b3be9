"""What the terminal shows: a line per stage, and the run in one table."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

Results = Mapping[str, Any]


@contextmanager
def progress() -> Iterator[Callable[[str], None]]:
    """Yield a function that shows the stage under way; silent where standard error is no terminal."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console

    console = Console(stderr=True)
    with console.status("reading") as status:

        def show(stage: str) -> None:
            console.print(f"· {stage}", highlight=False)
            status.update(stage)

        yield show


def model_summary(results: Results) -> str:
    """The model in a few lines, warnings last."""
    model = results["model"]
    lines = [
        f"{results['title']}",
        f"  blocks {model['blocks']} ({model['movable_blocks']} movable), joints {model['joints']}, "
        f"contact points {model['contact_points']}",
        f"  weight {model['weight_kN']:.4g} kN; stands under its own weight: "
        f"{'yes' if model['self_weight_stable'] else 'NO'}",
    ]
    return "\n".join([*lines, *(f"warning: {text}" for text in model["warnings"])])


def summary(results: Results, folder: Path, warnings: Iterable[str]) -> str:
    """The run in one table, state by direction; warnings last."""
    lines = [model_summary(results)]
    rows = [
        (name, direction, rigid.get("alpha_0"), rigid.get("d_0_m"), *_capacity(state, direction))
        for name, state in results["states"].items()
        for direction, curves in state["pushover"].items()
        for rigid in [curves.get("rigid") or {}]
    ]
    if rows:
        width = max(len(row[0]) for row in rows)
        lines.append(f"{'state':{width}}  dir   α0      d0 [m]   a_g [g]  ζ_E")
        lines += [
            f"{name:{width}}  {direction}  {_number(a, 4):7} {_number(d, 4):8} {_number(ag, 3):8} {_number(zeta, 2)}"
            for name, direction, a, d, ag, zeta in rows
        ]
    for name, state in results["states"].items():
        for behaviour, path in state["pushdown"].items():
            if path["ultimate_movement_m"] is not None:
                lines.append(f"{name}: ultimate movement, {behaviour}: {path['ultimate_movement_m']:.4g} m")
    worst = (results.get("scenarios") or {}).get("worst")
    if worst:
        lines.append(
            f"worst scenario: {worst['state']} at {1000.0 * worst['movement_m']:.4g} mm, {worst['direction']}"
            + (": the structure collapses before" if worst["collapses"] else "")
        )
    lines += [f"warning: {text}" for text in (*results["quality"]["warnings"], *warnings)]
    lines.append(f"results: {folder}")
    return "\n".join(lines)


def _capacity(state: Mapping[str, Any], direction: str) -> tuple[float | None, float | None]:
    checks = state["capacity"].get(direction, {})
    for limit_state in ("SLC", "SLV", "SLD"):
        if limit_state in checks:
            return checks[limit_state]["a_g_g"], checks[limit_state]["zeta_E"]
    return None, None


def _number(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"
