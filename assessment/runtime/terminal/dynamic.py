"""Lines of the terminal summary on what moves: time histories, incremental analysis, campaign."""

from __future__ import annotations

from collections.abc import Iterator

from assessment.results.schema import Results
from assessment.results.schema.campaign import Campaign, CampaignFragility, CampaignLoss
from assessment.results.schema.dynamic import History


def dynamic_lines(results: Results) -> Iterator[str]:
    """Yield a line for each history and incremental analysis of a state, and for each movement of the campaign."""
    for name, state in results.states.items():
        yield from (f"history {entry.record}, {name}: {_came_to(entry)}" for entry in state.history)
    for name, state in results.states.items():
        if state.incremental.records is not None:
            rule = state.incremental.rule or "lowest; NTC 2018 §7.3.5 needs three records"
            borne = _value(state.incremental.pga_collapse_g, "{:.3g} g")
            yield f"incremental analysis, {name}: PGA at collapse {borne} ({rule})"
    if found := results.campaign:
        for fit, loss in zip(found.fragility, found.loss, strict=True):
            yield _of_movement(fit, loss, found)


def _came_to(entry: History) -> str:
    if entry.collapsed is None:
        return "not computed"
    if entry.collapsed:
        return f"collapse at {_value(entry.time_of_collapse_s, '{:.3g} s')}"
    peak = None if entry.peak_displacement_m is None else 1000.0 * entry.peak_displacement_m
    return f"peak {_value(peak, '{:.3g} mm')}"


def _of_movement(fit: CampaignFragility, loss: CampaignLoss, found: Campaign) -> str:
    parts = [f"median {found.measure} at collapse {_value(fit.median_g, '{:.3g} g')}"]
    if fit.share:
        static = "" if loss.static is None else f" (static {100.0 * loss.static:+.1f} %)"
        dynamic = None if loss.dynamic is None else 100.0 * loss.dynamic
        parts.append(f"loss {_value(dynamic, '{:+.1f} %')}{static}")
    if fit.rule:
        parts.append(f"PGA of NTC 2018 §7.3.5 {_value(fit.pga_collapse_g, '{:.3g} g')} ({fit.rule})")
    elif found.method == "incremental":
        parts.append("no PGA of NTC 2018 §7.3.5, which needs three records")
    return f"campaign, {fit.settlement} × {fit.share:g}: {', '.join(parts)}"


def _value(value: float | None, form: str) -> str:
    return "not determined" if value is None else form.format(value)
