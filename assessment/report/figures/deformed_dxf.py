"""The deformed shapes as a DXF drawing, each on a layer of its own."""

import io
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

from ezdxf import units
from ezdxf._options import options
from ezdxf.filemanagement import new

from assessment.report.figures.deformed import found_mechanism
from assessment.report.language import slug
from assessment.results.frames import tie_ends
from assessment.results.hand_check import mechanisms
from assessment.results.joint_states import joint_states, outlines, situations, thrust_lines
from assessment.results.schema import Configuration, Results, StateResults
from assessment.runtime.files import write_atomically
from mechanics.pictures import Shape

SIDES = {"+x": "PLUS_X", "-x": "MINUS_X"}
COLOURS = (7, 1, 5, 3, 6, 30, 140, 94)  # AutoCAD's colour indices, one layer after the other
HINGE_RADIUS = 0.008  # of the model's size


def write_deformed(results: Results, path: Path) -> None:
    """Write a DXF in metres: the drawing and, for every state, each deformed shape, hinges, lines of thrust.

    Layers are DRAWN and NUMBER_STATE_WHAT, the state numbered and named as in the names of the figures. True scale, but
    for mechanisms, whose virtual displacements have none. The same bytes for the same results.
    """
    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True  # no times and no random identifiers
    try:
        drawing, text = new("R2010"), io.StringIO()
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
                layer = (
                    f"{_layer(results, at.state)}_THRUST_{SIDES[at.direction] if at.direction else 'REST'}"
                )
                drawing.layers.add(layer, color=5)
                for start, end in lines:
                    space.add_line(start, end, dxfattribs={"layer": layer})
        for kind in sorted(drawing.entitydb.dxf_types_in_use()):  # ezdxf leaves their order to chance
            drawing.classes.add_class(kind)
        drawing.write(text)
    finally:
        options.write_fixed_meta_data_for_testing = before
    write_atomically(path, text.getvalue().encode(drawing.output_encoding))


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
                mechanism = found_mechanism(results, name, direction)
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
