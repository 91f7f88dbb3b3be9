"""Which figures a set of results has, in the order of the report, and writing them."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from assessment.canvas import save_svg
from assessment.drawings import draw_chosen, draw_mechanisms, draw_model, draw_settlement
from assessment.dynamic_plots import (
    draw_fragility,
    draw_history,
    draw_incremental,
    draw_motion,
    draw_shapes,
    fragile,
    shaken,
)
from assessment.plots import draw_pushdown, draw_pushover, pushed
from assessment.spectral_plots import draw_demand, draw_spectra
from assessment.study_plots import draw_scenarios, draw_tornado, varied
from assessment.words import Words, direction_name, words_of

PANELS = 4  # states side by side in one figure


@dataclass(frozen=True)
class Picture:
    """A figure of the report: file stem, its chapter, how to draw it, key and fields of its caption."""

    name: str
    section: str
    draw: Callable[[], Figure]
    caption: str
    fields: dict[str, object] = field(default_factory=dict)


def write_figures(results: Mapping[str, Any], folder: Path) -> list[Path]:
    """Write every figure of the results as SVG into the folder, the same bytes for the same results."""
    paths = []
    for picture in pictures(results):
        path = folder / f"{picture.name}.svg"
        save_svg(picture.draw, path)
        paths.append(path)
    return paths


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """List the figures that the results allow: nothing is drawn of what was not computed."""
    words = words_of(results)
    found = [Picture("model", "model", partial(draw_model, results, words), "model")]
    for name, content in results["states"].items():
        fields: dict[str, object] = {"state": words.state(name)}
        if content.get("settlement") and content.get("configuration"):
            draw = partial(draw_settlement, results, words, name)
            found.append(
                Picture(f"settlement_{slug(results, name)}", "settlements", draw, "settlement", fields)
            )
        if content.get("pushdown"):
            draw = partial(draw_pushdown, results, words, name)
            found.append(Picture(f"pushdown_{slug(results, name)}", "pushdown", draw, "pushdown", fields))
    for number, given in enumerate(results.get("mechanisms") or [], 1):
        if "refused" not in given:
            fields = {"name": given["name"], "state": words.state(given["state"])}
            draw = partial(draw_chosen, results, words, given)
            found.append(
                Picture(f"chosen_mechanism_{number}", "mechanisms", draw, "chosen_mechanism", fields)
            )
    if results.get("spectra"):
        found.append(Picture("spectrum", "action", partial(draw_demand, results, words), "spectrum"))
    for direction in ("+x", "-x"):
        found += _of_direction(results, words, direction)
    return found + _studies(results, words) + _dynamic(results, words)


def _studies(results: Mapping[str, Any], words: Words) -> list[Picture]:
    found = []
    if results.get("scenarios"):
        draw: Callable[[], Figure] = partial(draw_scenarios, results, words)
        found.append(Picture("scenarios", "scenarios", draw, "scenarios_curves"))
    for number, names in enumerate(_portions(varied(results))):
        draw = partial(draw_tornado, results, words, names)
        fields: dict[str, object] = {"limit": results["sensitivity"]["limit_state"]}
        found.append(Picture(_numbered("tornado", number), "sensitivity", draw, "tornado_bars", fields))
    return found


def _dynamic(results: Mapping[str, Any], words: Words) -> list[Picture]:
    found = []
    for index, motion in enumerate(results.get("motions") or []):
        fields: dict[str, object] = {"record": motion["name"], "pga": motion["pga_g"]}
        draw = partial(draw_motion, results, words, index)
        found.append(Picture(f"record_{index + 1}", "history", draw, "motion", fields))
        states = shaken(results, motion["name"])
        if states:
            draw = partial(draw_history, results, words, index)
            found.append(Picture(f"history_{index + 1}", "history", draw, "control_history", fields))
        for name in states:
            draw = partial(draw_shapes, results, words, name, index)
            stem = f"shapes_{index + 1}_{slug(results, name)}"
            found.append(Picture(stem, "history", draw, "shapes", fields | {"state": words.state(name)}))
    searched = [
        name
        for name, content in results["states"].items()
        if any(record["points"] for record in (content.get("incremental") or {}).get("records") or [])
    ]
    for number, names in enumerate(_portions(searched)):
        draw = partial(draw_incremental, results, words, names)
        found.append(Picture(_numbered("incremental", number), "incremental", draw, "incremental_curves"))
    if fragile(results):
        draw = partial(draw_fragility, results, words)
        found.append(Picture("fragility", "incremental", draw, "fragility"))
    return found


def _of_direction(results: Mapping[str, Any], words: Words, direction: str) -> list[Picture]:
    states = pushed(results, direction)
    side = "plus_x" if direction == "+x" else "minus_x"
    fields: dict[str, object] = {"direction": direction_name(direction)}
    found = []
    failing = [n for n, s in states.items() if s["pushover"][direction].get("rigid", {}).get("mechanism")]
    for number, names in enumerate(_portions(failing)):
        draw = partial(draw_mechanisms, results, words, names, direction)
        found.append(Picture(_numbered(f"mechanism_{side}", number), "mechanisms", draw, "mechanism", fields))
    if states:
        draw = partial(draw_pushover, results, words, direction)
        found.append(Picture(f"pushover_{side}", "pushover", draw, "pushover", fields))
    for limit in ("SLV", "SLC"):
        able = [n for n, s in results["states"].items() if _has_curve(s, direction, limit)]
        for number, names in enumerate(_portions(able)):
            draw = partial(draw_spectra, results, words, names, direction, limit)
            stem = _numbered(f"spectra_{side}_{limit}", number)
            found.append(Picture(stem, "capacity", draw, "spectra", fields | {"limit": limit}))
    return found


def slug(results: Mapping[str, Any], state: str) -> str:
    """Return a file name for a state: its number among the states and its plain letters."""
    number = list(results["states"]).index(state)
    ascii_name = unicodedata.normalize("NFKD", state).encode("ascii", "ignore").decode().lower()
    return f"{number}_{re.sub(r'[^a-z0-9]+', '_', ascii_name).strip('_')[:40]}".rstrip("_")


def _has_curve(content: Mapping[str, Any], direction: str, limit: str) -> bool:
    capacity = (content.get("capacity") or {}).get(direction) or {}
    return bool(capacity.get("curve") and capacity["curve"]["d_star_m"] and capacity.get(limit))


def _portions(names: list[str]) -> list[list[str]]:
    return [names[start : start + PANELS] for start in range(0, len(names), PANELS)]


def _numbered(stem: str, number: int) -> str:
    return stem if number == 0 else f"{stem}_{number + 1}"
