"""Which figures a set of results has, in the order of the report, and writing them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
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
from assessment.report.figures.curves import draw_pushdown, draw_pushover
from assessment.report.figures.drawings.deformed import (
    draw_chosen,
    draw_cracks,
    draw_identification,
    draw_mechanisms,
    draw_overturned,
    draw_settlement,
    draw_synthesis,
)
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
from assessment.report.tables.structure.cracks import cracks_of, printed
from assessment.report.tables.synthesis import governing_view, worst_settled
from assessment.report.text.language import Words, slug, words_of
from assessment.results.configurations.joint_states import situations
from assessment.results.schema import Results
from assessment.results.schema.part import known
from assessment.runtime.processes.pool import Pool, result_of

T = TypeVar("T")
PANELS = 4  # in one figure


@dataclass(frozen=True)
class Picture:
    """A figure of the report: file stem, section, how to draw it, key and fields of its caption.

    `full`: printed in full annexes only; its files are there in any case.
    """

    name: str
    section: str
    draw: Callable[[], Figure]
    caption: str
    fields: dict[str, object] = field(default_factory=dict)
    full: bool = False


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
        write_deformed,
    )  # late: ezdxf is for nothing else here

    write_deformed(results, path)


def pictures(results: Results) -> list[Picture]:
    """List the figures that the results allow: nothing is drawn of what was not computed."""
    words = words_of(results)
    return [
        *_structure(results, words),
        *_static(results, words),
        *_studies(results, words),
        *_dynamic(results, words),
        *_campaign(results, words),
    ]


def _structure(results: Results, words: Words) -> Iterable[Picture]:
    worst, governing = worst_settled(results), governing_view(results)
    if worst or governing:
        yield Picture(
            "synthesis",
            "synthesis",
            partial(draw_synthesis, results, words, worst, governing),
            "synthesis_drawing",
        )
    yield Picture("model", "structure", partial(draw_model, results, words), "model")
    if results.identification and results.identification.best is not None:
        yield Picture(
            "identification", "movement", partial(draw_identification, results, words), "identification"
        )
    for name, state in results.states.items():
        fields: dict[str, object] = {"state": words.state(name)}
        stem = slug(results, name)
        if state.settlement:
            draw = partial(draw_settlement, results, words, name)
            yield Picture(f"settlement_{stem}", "movement", draw, "settlement", fields)
        if state.pushdown:
            draw = partial(draw_pushdown, results, words, name)
            yield Picture(f"pushdown_{stem}", "movement", draw, "pushdown", fields)
        if state.settlement and cracks_of(results, name):
            draw = partial(draw_cracks, results, words, name, printed(results))
            yield Picture(f"cracks_{stem}", "cracks", draw, "cracks_drawing", fields)


def _static(results: Results, words: Words) -> Iterable[Picture]:
    there = list(situations(results))
    resting = [each for each in there if each.direction is None]
    activated = [each for each in there if each.direction is not None]
    for stem, found, full in (("thrust_at_rest", resting, False), ("thrust", activated, True)):
        for number, shown in enumerate(_portions(found)):
            draw: Callable[[], Figure] = partial(draw_thrust, results, words, shown)
            yield Picture(_numbered(stem, number), "joints" if full else "cracks", draw, stem, full=full)
    if results.spectra:
        yield Picture("spectrum", "action", partial(draw_demand, results, words), "spectrum", full=True)
    pushes = [(name, way) for name, state in results.states.items() for way in sorted(state.pushover)]
    if pushes:
        draw = partial(draw_pushover, results, words, sorted({way for _, way in pushes}))
        yield Picture("pushover", "curves", draw, "pushover")
    rigid = [(view, push) for view in pushes if (push := results.states[view[0]].pushover[view[1]].rigid)]
    for number, views in enumerate(_portions([view for view, _ in rigid])):
        draw = partial(draw_mechanisms, results, words, views)
        yield Picture(_numbered("mechanism", number), "mechanisms", draw, "mechanism")
    for number, views in enumerate(_portions([view for view, push in rigid if push.d_0_m is not None])):
        draw = partial(draw_overturned, results, words, views)
        yield Picture(_numbered("overturned", number), "joints", draw, "overturned", full=True)
    for number, given in enumerate(results.mechanisms or [], 1):
        if not given.refused:
            fields: dict[str, object] = {"name": given.name, "state": words.state(given.state)}
            draw = partial(draw_chosen, results, words, given)
            yield Picture(f"chosen_mechanism_{number}", "mechanisms", draw, "chosen_mechanism", fields)
    for limit in ("SLV", "SLC"):
        able = [
            (name, way)
            for name, state in results.states.items()
            for way, capacity in sorted(state.capacity.items())
            if capacity.curve.d_star_m and limit in capacity.checks
        ]
        for number, views in enumerate(_portions(able)):
            draw = partial(draw_spectra, results, words, views, limit)
            caption = "spectra" if one_scale(results, views, limit) else "spectra_own"
            stem = _numbered(f"spectra_{limit}", number)
            yield Picture(stem, "checks", draw, caption, {"limit": limit}, full=limit == "SLC")


def _studies(results: Results, words: Words) -> Iterable[Picture]:
    if results.scenarios:
        yield Picture("scenarios", "scenarios", partial(draw_scenarios, results, words), "scenarios_curves")
    for number, names in enumerate(_portions(varied(results))):
        fields: dict[str, object] = {"limit": known(results.sensitivity).limit_state}
        draw = partial(draw_tornado, results, words, names)
        yield Picture(_numbered("tornado", number), "sensitivity", draw, "tornado_bars", fields)


def _dynamic(results: Results, words: Words) -> Iterable[Picture]:
    for index, motion in enumerate(results.motions or []):
        fields: dict[str, object] = {"record": motion.name, "pga": motion.pga_g}
        draw = partial(draw_motion, results, words, index)
        yield Picture(f"record_{index + 1}", "history", draw, "motion", fields)
        if states := shaken(results, motion.name):
            draw = partial(draw_history, results, words, index)
            yield Picture(f"history_{index + 1}", "history", draw, "control_history", fields)
        for name in states:
            draw = partial(draw_shapes, results, words, name, index)
            stem = f"shapes_{index + 1}_{slug(results, name)}"
            yield Picture(stem, "history", draw, "shapes", fields | {"state": words.state(name)}, full=True)
    searched = [
        name
        for name, state in results.states.items()
        if any(record.points for record in state.incremental.records or [])
    ]
    for number, names in enumerate(_portions(searched)):
        draw = partial(draw_incremental, results, words, names)
        yield Picture(_numbered("incremental", number), "incremental", draw, "incremental_curves")
    if fragile(results):
        yield Picture("fragility", "incremental", partial(draw_fragility, results, words), "fragility")


def _campaign(results: Results, words: Words) -> Iterable[Picture]:
    if not results.campaign:
        return
    yield Picture("campaign_loss", "campaign", partial(draw_campaign_loss, results, words), "campaign_losses")
    for number, name in enumerate(moved(results)):
        fields: dict[str, object] = {"settlement": name}
        if fragile_shares(results, name):
            draw = partial(draw_campaign_fragility, results, words, name)
            stem = _numbered("campaign_fragility", number)
            yield Picture(stem, "campaign", draw, "campaign_fragility_curves", fields)
        draw = partial(draw_campaign_curves, results, words, name)
        yield Picture(
            _numbered("campaign_curves", number), "campaign", draw, "campaign_curves", fields, full=True
        )


def _portions(names: Sequence[T]) -> list[Sequence[T]]:
    return [names[start : start + PANELS] for start in range(0, len(names), PANELS)]


def _numbered(stem: str, number: int) -> str:
    return stem if number == 0 else f"{stem}_{number + 1}"
