"""Which figures a set of results has, in the order of the report, and writing them; deformed shapes as DXF."""

from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any, TypeVar

from ezdxf import units
from ezdxf.filemanagement import new
from matplotlib.figure import Figure

from assessment.report.figures import curves, deformed, motions
from assessment.report.figures.curves import draw_scenarios, draw_tornado, varied
from assessment.report.figures.drawing import draw_model, save_png, save_svg
from assessment.report.language import slug, words_of
from assessment.report.tables import capacities
from assessment.report.tables.dynamic import shaken
from assessment.report.tables.structure import cracks_of, printed, surveyed
from assessment.results.frames import tie_ends
from assessment.results.hand_check import governing_view, mechanisms
from assessment.results.joint_states import joint_states, outlines, situations, thrust_lines
from assessment.results.schema import Configuration, Results, StateResults, known
from assessment.results.summary import worst_settled
from assessment.runtime.files import write_atomically
from assessment.runtime.pool import Pool, result_of
from mechanics.model import dxf_bytes, reproducible
from mechanics.pictures import Shape

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
    return [result_of(path) for path in _drawn(pool, folder, save_svg, "svg")]


def write_images(pool: Pool, folder: Path) -> list[Future[Any]]:
    """Begin to write every figure as PNG into the folder, and deformed.dxf; the same bytes for the same results."""
    return [*_drawn(pool, folder, save_png, "png"), pool.apply(write_deformed, folder / "deformed.dxf")]


def _drawn(pool: Pool, folder: Path, save: Callable[..., None], kind: str) -> list[Future[Path]]:
    return [pool.apply(_draw, folder, number, save, kind) for number in range(len(pictures(pool.held)))]


def _draw(results: Results, folder: Path, number: int, save: Callable[..., None], kind: str) -> Path:
    picture = pictures(results)[number]
    save(picture.draw, path := folder / f"{picture.name}.{kind}")
    return path


def pictures(results: Results) -> list[Picture]:
    """List the figures that the results allow: nothing is drawn of what was not computed."""
    made: list[Picture] = []

    def show(
        name: str, section: str, draw: Callable[..., Figure], /, *what: Any, caption: str = "", full: bool = False,
        **fields: object,
    ) -> None:  # fmt: skip
        """Add the picture of what a function draws of the results; its caption is named as the picture by default."""
        drawing = partial(draw, results, words_of(results), *what)
        made.append(Picture(name, section, drawing, caption or name, fields, full))

    # the structure and its movements
    worst, governing = worst_settled(results), governing_view(results)
    if worst or governing:
        show("synthesis", "synthesis", deformed.draw_synthesis, worst, governing, caption="synthesis_drawing")
    show("model", "structure", draw_model)
    if results.identification and results.identification.best is not None:
        show("identification", "movement", deformed.draw_identification)
    for name, state in results.states.items():
        stem = slug(results, name)
        told = partial(show, state=name)
        if state.settlement:
            told(f"settlement_{stem}", "movement", deformed.draw_settlement, name, caption="settlement")
        if state.pushdown:
            told(f"pushdown_{stem}", "movement", curves.draw_pushdown, name, caption="pushdown")
        if state.settlement and (cracks_of(results, name) or surveyed(results, name)):
            drawn = name, printed(results)
            told(f"cracks_{stem}", "cracks", deformed.draw_cracks, *drawn, caption="cracks_drawing")
    # pushes, mechanisms, checks
    there = list(situations(results))
    resting = [each for each in there if each.direction is None]
    activated = [each for each in there if each.direction is not None]
    for name, shown in _portions("thrust_at_rest", resting):
        show(name, "cracks", deformed.draw_thrust, shown, caption="thrust_at_rest")
    for name, shown in _portions("thrust", activated):
        show(name, "joints", deformed.draw_thrust, shown, caption="thrust", full=True)
    if results.spectra:
        show("spectrum", "action", curves.draw_demand, full=True)
    pushes = [(name, way) for name, state in results.states.items() for way in sorted(state.pushover)]
    if pushes:
        show("pushover", "curves", curves.draw_pushover, sorted({way for _, way in pushes}))
    rigid = [(view, push) for view in pushes if (push := results.states[view[0]].pushover[view[1]].rigid)]
    for name, views in _portions("mechanism", [view for view, _ in rigid]):
        show(name, "mechanisms", deformed.draw_mechanisms, views, caption="mechanism")
    for name, views in _portions("overturned", [view for view, push in rigid if push.d_0_m is not None]):
        show(name, "joints", deformed.draw_overturned, views, caption="overturned", full=True)
    for number, given in enumerate(results.mechanisms or [], 1):
        if not given.refused:
            told = partial(show, caption="chosen_mechanism", state=given.state, name=given.name)
            told(f"chosen_mechanism_{number}", "mechanisms", deformed.draw_mechanisms, [given])
    for limit in ("SLV", "SLC"):
        found = {(name, way): each for name, way, each in capacities(results)}
        able = [view for view, each in found.items() if each.curve.d_star_m and limit in each.checks]
        for name, views in _portions(f"spectra_{limit}", able):
            told = partial(show, caption="spectra", full=limit == "SLC", limit=limit)
            told(name, "checks", curves.draw_spectra, views, limit)
    # studies
    if results.scenarios:
        show("scenarios", "scenarios", draw_scenarios, caption="scenarios_curves")
    for name, states in _portions("tornado", varied(results)):
        told = partial(show, limit=known(results.sensitivity).limit_state)
        told(name, "sensitivity", draw_tornado, states, caption="tornado_bars")
    # motions
    for number, motion in enumerate(results.motions or []):
        told = partial(show, record=motion.name, pga=motion.pga_g)
        told(f"record_{number + 1}", "history", motions.draw_motion, number, caption="motion")
        if moving := motions.moving(results, motion.name):
            told(f"history_{number + 1}", "history", motions.draw_history, number, caption="control_history")
        for name in moving:
            stem = f"shapes_{number + 1}_{slug(results, name)}"
            told(stem, "history", motions.draw_shapes, name, number, caption="shapes", full=True, state=name)
    scanned = shaken(results, "incremental")
    drawn_ones = [each for each in scanned if any(row.points for row in each.rows)]
    for name, of in _portions("incremental", drawn_ones):
        show(name, "incremental", motions.draw_ida, of, caption="incremental_curves")
    if fragile := [each for each in scanned if each.fit.beta is not None]:
        show("fragility", "incremental", motions.draw_fragility, fragile)
    if results.campaign:
        show("campaign_loss", "campaign", motions.draw_campaign_loss, caption="campaign_losses")
    moved = groupby(shaken(results, "campaign"), key=lambda each: each.state)
    for number, (name, after) in enumerate(moved):
        told, of = partial(show, settlement=name), [*after]
        if fragile := [each for each in of if each.fit.beta is not None]:
            stem = _numbered("campaign_fragility", number)
            told(stem, "campaign", motions.draw_fragility, fragile, caption="campaign_fragility_curves")
        stem = _numbered("campaign_curves", number)
        told(stem, "campaign", motions.draw_ida, of, caption="campaign_curves", full=True)
    return made


def _portions(stem: str, shown: Sequence[T]) -> Iterator[tuple[str, Sequence[T]]]:
    """Yield names and parts of what is shown, PANELS to a figure."""
    for number, start in enumerate(range(0, len(shown), PANELS)):
        yield _numbered(stem, number), shown[start : start + PANELS]


def _numbered(stem: str, number: int) -> str:
    return stem if number == 0 else f"{stem}_{number + 1}"


SIDES = {"+x": "PLUS_X", "-x": "MINUS_X"}
COLOURS = (7, 1, 5, 3, 6, 30, 140, 94)  # AutoCAD's colour indices, one layer after the other
HINGE_RADIUS = 0.008  # of the model's size


def write_deformed(results: Results, path: Path) -> None:
    """Write a DXF in metres, reproducibly: the drawing and, for every state, deformed shapes, hinges, lines of thrust.

    Layers are DRAWN and NUMBER_STATE_WHAT, as in the names of figures. True scale, but for mechanisms.
    """
    with reproducible():
        drawing = new("R2010")
        drawing.units = units.M
        space, size = drawing.modelspace(), outlines(results).size
        for number, (layer, shape, ties) in enumerate(shapes(results)):
            drawing.layers.add(layer, color=COLOURS[number % len(COLOURS)])
            for ring in shape.rings(shape.every):
                space.add_lwpolyline(ring.tolist(), close=True, dxfattribs={"layer": layer})
            if len(ties):
                drawing.layers.add(f"{layer}_TIES", color=2)
            for start, end in ties:
                space.add_line(start, end, dxfattribs={"layer": f"{layer}_TIES"})
        for name, direction, rigid in mechanisms(results):
            if points := rigid.mechanism.hinge_points_m:
                layer = f"{_layer(results, name)}_HINGES_{SIDES[direction]}"
                drawing.layers.add(layer, color=1)
                for point in points:
                    space.add_circle(point, HINGE_RADIUS * size, dxfattribs={"layer": layer})
        for at in situations(results):
            if lines := thrust_lines(joint_states(results, at)):
                way = SIDES[at.direction] if at.direction else "REST"
                layer = f"{_layer(results, at.state)}_THRUST_{way}"
                drawing.layers.add(layer, color=5)
                for start, end in lines:
                    space.add_line(start, end, dxfattribs={"layer": layer})
        for kind in sorted(drawing.entitydb.dxf_types_in_use()):  # ezdxf leaves their order to chance
            drawing.classes.add_class(kind)
        written = dxf_bytes(drawing)
    write_atomically(path, written)


def shapes(results: Results) -> Iterator[tuple[str, Shape, Collection[Any]]]:
    """Yield layer and outlines of every deformed shape, and the ends of its ties, m."""
    drawn = outlines(results)
    yield "DRAWN", drawn, [(tie.start_m, tie.end_m) for tie in results.model.ties or ()]
    for name, state in results.states.items():
        for what, configuration in _configurations(state):
            if configuration is not None:
                ends = tie_ends(results, name, configuration)
                yield f"{_layer(results, name)}_{what}", drawn.moved(configuration), ends
        for direction, pushover in state.pushover.items():
            if pushover.rigid:
                mechanism = deformed.found_mechanism(results, name, direction)
                yield f"{_layer(results, name)}_MECHANISM_{SIDES[direction]}", mechanism.swept, ()


def _configurations(state: StateResults) -> Iterator[tuple[str, Configuration | None]]:
    if state.settlement:
        yield "SETTLED", state.configuration
    for contacts, path in state.pushdown.items():
        yield f"ULTIMATE_{contacts.upper()}", path.ultimate_configuration
    for direction, pushover in state.pushover.items():
        if pushover.elastic:
            yield f"PEAK_{SIDES[direction]}", pushover.elastic.peak_configuration
        if pushover.rigid:
            yield f"END_{SIDES[direction]}", pushover.rigid.final_configuration
    for number, entry in enumerate(state.history, 1):
        yield f"RECORD_{number}_PEAK", entry.peak_configuration
        yield f"RECORD_{number}_FINAL", entry.final_configuration


def _layer(results: Results, state: str) -> str:
    return slug(results, state).upper()
