"""Which figures a set of results has, in the order of the report, and writing them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TypeVar

from matplotlib.figure import Figure

from assessment.report.figures.campaign import (
    draw_campaign_curves,
    draw_campaign_fragility,
    draw_campaign_loss,
    fragile_shares,
    moved,
)
from assessment.report.figures.curves import draw_pushdown, draw_pushover, pushed
from assessment.report.figures.drawings.cracks import draw_cracks
from assessment.report.figures.drawings.deformed import (
    draw_chosen,
    draw_mechanisms,
    draw_overturned,
    draw_settlement,
)
from assessment.report.figures.drawings.identification import draw_identification
from assessment.report.figures.drawings.model import draw_model
from assessment.report.figures.drawings.thrust import draw_thrust
from assessment.report.figures.dynamic import (
    draw_fragility,
    draw_history,
    draw_incremental,
    draw_motion,
    draw_shapes,
    fragile,
    shaken,
)
from assessment.report.figures.spectra import draw_demand, draw_spectra, one_scale
from assessment.report.figures.studies import draw_scenarios, draw_tornado, varied
from assessment.report.figures.style import save_png, save_svg
from assessment.report.tables.structure.cracks import cracks_of
from assessment.report.text.language import Words, direction_name, slug, words_of
from assessment.results.configurations.joint_states import situations
from assessment.results.schema import Results, State
from assessment.results.schema.checks import Direction
from assessment.results.schema.part import known
from assessment.runtime.processes.pool import Pool, result_of

T = TypeVar("T")
PANELS = 4  # states side by side in one figure
SIDES: dict[Direction, str] = {"+x": "plus_x", "-x": "minus_x"}  # directions in file names


@dataclass(frozen=True)
class Picture:
    """A figure of the report: file stem, its chapter or part of one, how to draw it, key and fields of its caption."""

    name: str
    section: str
    draw: Callable[[], Figure]
    caption: str
    fields: dict[str, object] = field(default_factory=dict)


def write_figures(pool: Pool, folder: Path) -> list[Path]:
    """Write every figure of the results that the pool holds as SVG into the folder; return paths in their order.

    The same bytes for the same results.
    """
    drawn = [pool.apply(_write_vector, folder, number) for number in range(len(pictures(pool.held)))]
    return [result_of(path) for path in drawn]


def write_images(pool: Pool, folder: Path) -> list[Future[None]]:
    """Begin to write every figure as PNG into the folder, and deformed.dxf; the same bytes for the same results."""
    futures = [pool.apply(_write_raster, folder, number) for number in range(len(pictures(pool.held)))]
    return [*futures, pool.apply(_write_drawing, folder / "deformed.dxf")]


def _write_vector(results: Results, folder: Path, number: int) -> Path:
    picture = pictures(results)[number]
    path = folder / f"{picture.name}.svg"
    save_svg(picture.draw, path)
    return path


def _write_raster(results: Results, folder: Path, number: int) -> None:
    picture = pictures(results)[number]
    save_png(picture.draw, folder / f"{picture.name}.png")


def _write_drawing(results: Results, path: Path) -> None:
    from assessment.report.figures.drawings.deformed_dxf import (
        write_deformed,  # late: ezdxf is needed for nothing else here
    )

    write_deformed(results, path)


def pictures(results: Results) -> list[Picture]:
    """List the figures that the results allow: nothing is drawn of what was not computed."""
    words = words_of(results)
    found = [Picture("model", "model", partial(draw_model, results, words), "model")]
    if results.identification and results.identification.best is not None:
        identified = partial(draw_identification, results, words)
        found.append(Picture("identification", "identification", identified, "identification"))
    for name, state in results.states.items():
        fields: dict[str, object] = {"state": words.state(name)}
        if state.settlement:
            draw = partial(draw_settlement, results, words, name)
            found.append(
                Picture(f"settlement_{slug(results, name)}", "settlements", draw, "settlement", fields)
            )
            if cracks_of(results, name):
                draw = partial(draw_cracks, results, words, name)
                found.append(
                    Picture(f"cracks_{slug(results, name)}", "cracks", draw, "cracks_drawing", fields)
                )
        if state.pushdown:
            draw = partial(draw_pushdown, results, words, name)
            found.append(Picture(f"pushdown_{slug(results, name)}", "pushdown", draw, "pushdown", fields))
    found += _thrusts(results, words, None)
    if results.spectra:
        found.append(Picture("spectrum", "action", partial(draw_demand, results, words), "spectrum"))
    for direction in SIDES:
        found += _of_direction(results, words, direction)
    for number, given in enumerate(results.mechanisms or [], 1):
        if not given.refused:
            fields = {"name": given.name, "state": words.state(given.state)}
            draw = partial(draw_chosen, results, words, given)
            found.append(
                Picture(f"chosen_mechanism_{number}", "mechanisms", draw, "chosen_mechanism", fields)
            )
    return found + _studies(results, words) + _dynamic(results, words) + _campaign(results, words)


def _studies(results: Results, words: Words) -> list[Picture]:
    found = []
    if results.scenarios:
        draw: Callable[[], Figure] = partial(draw_scenarios, results, words)
        found.append(Picture("scenarios", "scenarios", draw, "scenarios_curves"))
    for number, names in enumerate(_portions(varied(results))):
        draw = partial(draw_tornado, results, words, names)
        fields: dict[str, object] = {"limit": known(results.sensitivity).limit_state}
        found.append(Picture(_numbered("tornado", number), "sensitivity", draw, "tornado_bars", fields))
    return found


def _dynamic(results: Results, words: Words) -> list[Picture]:
    found = []
    for index, motion in enumerate(results.motions or []):
        fields: dict[str, object] = {"record": motion.name, "pga": motion.pga_g}
        draw = partial(draw_motion, results, words, index)
        found.append(Picture(f"record_{index + 1}", "history", draw, "motion", fields))
        states = shaken(results, motion.name)
        if states:
            draw = partial(draw_history, results, words, index)
            found.append(Picture(f"history_{index + 1}", "history", draw, "control_history", fields))
        for name in states:
            draw = partial(draw_shapes, results, words, name, index)
            stem = f"shapes_{index + 1}_{slug(results, name)}"
            found.append(Picture(stem, "history", draw, "shapes", fields | {"state": words.state(name)}))
    searched = [
        name
        for name, state in results.states.items()
        if any(record.points for record in state.incremental.records or [])
    ]
    for number, names in enumerate(_portions(searched)):
        draw = partial(draw_incremental, results, words, names)
        found.append(Picture(_numbered("incremental", number), "incremental", draw, "incremental_curves"))
    if fragile(results):
        draw = partial(draw_fragility, results, words)
        found.append(Picture("fragility", "incremental", draw, "fragility"))
    return found


def _campaign(results: Results, words: Words) -> list[Picture]:
    if not results.campaign:
        return []
    loss: Callable[[], Figure] = partial(draw_campaign_loss, results, words)
    found = [Picture("campaign_loss", "campaign", loss, "campaign_losses")]
    for number, name in enumerate(moved(results)):
        fields: dict[str, object] = {"settlement": name}
        if fragile_shares(results, name):
            draw = partial(draw_campaign_fragility, results, words, name)
            stem = _numbered("campaign_fragility", number)
            found.append(Picture(stem, "campaign", draw, "campaign_fragility_curves", fields))
        draw = partial(draw_campaign_curves, results, words, name)
        stem = _numbered("campaign_curves", number)
        found.append(Picture(stem, "campaign", draw, "campaign_curves", fields))
    return found


def _thrusts(results: Results, words: Words, direction: Direction | None) -> list[Picture]:
    there = [each for each in situations(results) if each.direction == direction]
    stem = "thrust_at_rest" if direction is None else f"thrust_{SIDES[direction]}"
    caption = "thrust_at_rest" if direction is None else "thrust"
    fields: dict[str, object] = {} if direction is None else {"direction": direction_name(direction)}
    section = "model" if direction is None else "mechanisms"
    return [
        Picture(
            _numbered(stem, number), section, partial(draw_thrust, results, words, shown), caption, fields
        )
        for number, shown in enumerate(_portions(there))
    ]


def _of_direction(results: Results, words: Words, direction: Direction) -> list[Picture]:
    states = pushed(results, direction)
    side = SIDES[direction]
    fields: dict[str, object] = {"direction": direction_name(direction)}
    found = []
    rigid = {name: pushover.rigid for name, pushover in states.items() if pushover.rigid}
    failing = list(rigid)
    for number, names in enumerate(_portions(failing)):
        draw = partial(draw_mechanisms, results, words, names, direction)
        found.append(Picture(_numbered(f"mechanism_{side}", number), "mechanisms", draw, "mechanism", fields))
    found += _thrusts(results, words, direction)
    overturned = [name for name, push in rigid.items() if push.d_0_m is not None]
    if states:
        draw = partial(draw_pushover, results, words, direction)
        found.append(Picture(f"pushover_{side}", "pushover", draw, "pushover", fields))
    for number, names in enumerate(_portions(overturned)):
        draw = partial(draw_overturned, results, words, names, direction)
        stem = _numbered(f"overturned_{side}", number)
        found.append(Picture(stem, "pushover", draw, "overturned", fields))
    for limit in ("SLV", "SLC"):
        able = [name for name, state in results.states.items() if _has_curve(state, direction, limit)]
        for number, names in enumerate(_portions(able)):
            draw = partial(draw_spectra, results, words, names, direction, limit)
            stem = _numbered(f"spectra_{side}_{limit}", number)
            caption = "spectra" if one_scale(results, names, direction, limit) else "spectra_own"
            found.append(Picture(stem, "capacity", draw, caption, fields | {"limit": limit}))
    return found


def _has_curve(state: State, direction: Direction, limit: str) -> bool:
    capacity = state.capacity.get(direction)
    return capacity is not None and bool(capacity.curve.d_star_m) and limit in capacity.checks


def _portions(names: Sequence[T]) -> list[Sequence[T]]:
    return [names[start : start + PANELS] for start in range(0, len(names), PANELS)]


def _numbered(stem: str, number: int) -> str:
    return stem if number == 0 else f"{stem}_{number + 1}"
