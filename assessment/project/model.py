"""From a project's tables and drawing to the assembly of every state, its gauges, and a repaired drawing."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np
import shapely

from assessment.project import masonry
from assessment.project.plausibility import implausible
from assessment.project.project import Project
from assessment.project.schema import StrengtheningTable, TieTable
from assessment.runtime.errors import ProjectError, nearest
from assessment.runtime.files import write_atomically
from mechanics import Assembly, DrawingError, Layer, State, Tie
from mechanics.errors import Fault, FaultyDrawingError
from mechanics.messages import Message, headed, layer_key, message
from mechanics.model import V, default_tolerance, end_gaps, repair_drawing, survey_drawing, survey_layout
from mechanics.types import Array


@dataclass(frozen=True, eq=False)
class StateModel:
    """The assembly of a state: `settling` as its support moves, or as drawn; `strengthened`, None: by nothing."""

    name: str
    settling: Assembly
    strengthened: Assembly | None = None
    later: int = 0  # how many of its last ties are set after the movement, there as long as drawn

    @property
    def assembly(self) -> Assembly:
        """What is pushed and shaken; ties that are set after the movement are as long as drawn."""
        return self.strengthened or self.settling

    def tied_at(self, reached: State | None) -> Assembly:
        """Return what is pushed and shaken from a state (None: as drawn), where the last ties are set without slack."""
        if self.strengthened is None or reached is None or not self.later:
            return self.assembly
        ties = self.strengthened.ties
        first, ends = len(ties) - self.later, self.strengthened.tie_ends(reached)
        later = zip(ties[first:], ends[first:], strict=True)
        taut = [replace(tie, length=math.dist(*at)) for tie, at in later]
        return self.strengthened.tied((*ties[:first], *taut))

    def taken_over(self, reached: State) -> State:
        """Return the settled state as one of the strengthened assembly: ties that are set there remember nothing."""
        if self.strengthened is None or not self.later:
            return reached
        longer: dict[str, Any] = {}
        for key in ("shear", "carrying", "lengthened"):  # of contacts and ties (n,): zeros at their end
            if (values := getattr(reached, key)) is not None:
                longer[key] = np.pad(values, (0, self.later))
        return replace(reached, **longer)

    def varied(self, settling: Assembly) -> Self:
        """Return the model of another assembly that settles: `settling` with corners elsewhere."""
        if self.strengthened is None:
            return replace(self, settling=settling)
        blocks = [
            replace(block, vertices=other.vertices)
            for block, other in zip(self.strengthened.blocks, settling.blocks, strict=True)
        ]
        return replace(self, settling=settling, strengthened=replace(self.strengthened, blocks=blocks))


def state_models(project: Project, drawn: Assembly) -> dict[str, StateModel]:
    """Return the assembly of every state by name; `drawn`: without ties. Raises ProjectError for a wrong one."""
    bars = {table.name: _bar(project, drawn, table) for table in project.tie}
    known: dict[tuple[str, ...], Assembly] = {(): drawn}
    found = {}
    for name in project.states:
        there, later = (tuple(tie.name for tie in ties) for ties in project.ties_of(name))
        if there not in known:  # one assembly for all states of the same ties
            known[there] = drawn.tied([bars[tie] for tie in there])
        found[name] = StateModel(name, known[there])
        if made := project.strengthening_of(name):
            changed = _with_changed_layers(project, known[there], made)
            strengthened = changed.tied([bars[tie] for tie in (*there, *later)])
            found[name] = StateModel(name, known[there], strengthened, len(later))
    return found


def _bar(project: Project, model: Assembly, table: TieTable) -> Tie:
    """Return a tie between two blocks of a model. Raises ProjectError for one that does not join two of them."""
    key = f"{project.source}: tie.{table.name}"
    blocks = [masonry.block_at(model, f"{key}.{end}", getattr(table, end)) for end in ("from_m", "to_m")]
    if blocks[0] == blocks[1]:
        raise ProjectError(f"{key}.to_m: both ends are in block {blocks[0]}; write a point of another")
    if not model.movable[blocks].any():
        why = "both ends are in supports, between which a tie bears nothing; write a point of a movable block"
        raise ProjectError(f"{key}.to_m: {why}")
    bar = (table.yield_force_kN, table.stiffness_kN_m, table.pretension_kN)
    return Tie(table.name, table.from_m, table.to_m, *bar, ultimate_elongation=table.ultimate_elongation)


def _with_changed_layers(project: Project, model: Assembly, made: StrengtheningTable) -> Assembly:
    changes: dict[str, dict[str, float]] = {}
    layers = {layer_key(block.layer): block.layer for block in model.blocks}
    for layer, table in made.layers.items():
        if layer_key(layer) not in layers:
            key = f"{project.source}: strengthening[{project.strengthening.index(made) + 1}].layers.{layer}"
            raise ProjectError(f"{key}: no block on that layer; {nearest(layer, sorted(layers.values()))}")
        changes[layer_key(layer)] = {key: x for key, x in table if x is not None}
    if not changes:
        return model
    own, changed = {each.name: each.model_fields_set for each in project.region}, []
    for block in model.blocks:
        given = changes.get(layer_key(block.layer), {}).items()
        new = {masonry.MATERIAL[key]: x for key, x in given if key not in own.get(block.region, ())}
        changed.append(replace(block, material=replace(block.material, **new)))
    return replace(model, blocks=changed)


UNSEEN = "gaps, and blocks that touch nothing, are looked for once these are mended"


@dataclass(frozen=True, eq=False)
class ProjectModel:
    """The blocks and joints of a project as drawn, the assembly of every state by name, warnings about the drawing.

    `cracks`: lines (n, 2), m, that the drawing has of a survey.
    """

    assembly: Assembly
    states: Mapping[str, StateModel]
    warnings: tuple[Message, ...]
    cracks: tuple[Array, ...] = ()


def build_model(project: Project) -> ProjectModel:
    """Read the drawing, check it, and place control points and ties.

    Raises DrawingError, FaultyDrawingError with all faults, and ProjectError for what does not go with its blocks.
    """
    geometry = project.geometry
    drawing = masonry.as_built(project, survey_drawing(*how_to_read(project), geometry.tolerance_m))
    name, blocks, faults = geometry.drawing, drawing.blocks, drawing.faults
    if not blocks:
        raise FaultyDrawingError(name, faults, drawing.outlines)
    if not faults and all(block.support is not None for block in blocks):
        noticed = "".join(f" ({warning})" for warning in drawing.warnings)
        text = f"every block is a support; put the movable ones on other layers{noticed}"
        raise FaultyDrawingError(name, [Fault("layer", text)], drawing.outlines)
    tolerance = geometry.tolerance_m or default_tolerance(blocks)
    layout = survey_layout(blocks, tolerance, whole=not faults)
    if faults or layout.faults:
        remedy = layout.hint if not faults else UNSEEN
        raise FaultyDrawingError(name, (*faults, *layout.faults), drawing.outlines, remedy)
    warnings = drawing.warnings + layout.warnings
    unset = sorted({block.layer for block in blocks if block.material.normal_stiffness is None})
    if unset and project.elastic:
        raise ProjectError(
            f"{project.source}: layers.{unset[0]}.normal_stiffness_kN_m3: missing ({', '.join(unset)}), "
            "and elastic analyses need it for every block; give it there or in [material]"
        )
    collisions = project.contacts.collisions
    try:
        assembly = Assembly(blocks, geometry.segments_per_joint, tolerance, collisions)
    except ValueError as error:  # a block too light beside the others
        raise DrawingError(f"{name}: {error}") from None
    unit = "".join(f" ({warning})" for warning in drawing.warnings if "$INSUNITS" in warning)
    for point in project.control:
        key = f"{project.source}: control.{point.name}.point_m"
        block = assembly.blocks[masonry.block_at(assembly, key, point.point_m, unit)]
        if block.support is not None:
            text = f'{list(point.point_m)} is in the support "{block.support}", which no push moves'
            raise ProjectError(f"{key}: {text}; move it into another block")
    masonry.chosen_mechanisms(project, assembly)  # raises for wrong mechanisms before any analysis
    gauges(project, assembly)  # likewise
    states = state_models(project, assembly)
    far = assembly.as_drawn([0.0, 0.0])
    if far.any():
        warnings += (headed(name, message(
            "drawn far from (0, 0): in hand checks and in the steps of given mechanisms x and z count from ({x:.0f}, "
            "{z:.0f}) m", x=far[0], z=far[1],
        )),)  # fmt: skip
    return ProjectModel(assembly, states, (*warnings, *implausible(project, assembly)), drawing.cracks)


def how_to_read(project: Project) -> tuple[Path, str, Layer, dict[str, Layer], float | None]:
    """Return a project's drawing, its unit, the layers and the sagitta: what `read_drawing` is called with."""
    geometry = project.geometry
    return (
        project.path(geometry.drawing), geometry.unit, masonry.layer_of(project, None),
        {name: masonry.layer_of(project, table) for name, table in project.layers.items()}, geometry.sagitta_m,
    )  # fmt: skip


def with_repaired_drawing(project: Project) -> tuple[Project, tuple[str, ...]]:
    """Write the repaired drawing, numbered, beside the original; return the project with it, a line for each change.

    Where there is none nothing is written. Raises DrawingError or OSError.
    """
    path = project.path(project.geometry.drawing)
    repair = repair_drawing(*how_to_read(project), project.geometry.tolerance_m)
    if not repair.changes:
        return project, ()
    ends = ["", *(f"-{n}" for n in range(2, 1000))]
    numbered = (path.with_name(f"{path.stem}-repaired{end}.dxf") for end in ends)
    beside = next(each for each in numbered if not each.exists() or each.read_bytes() == repair.file)
    write_atomically(beside, repair.file)
    name = beside.relative_to(project.folder) if beside.is_relative_to(project.folder) else beside
    geometry = project.geometry.model_copy(update={"drawing": name.as_posix()})
    return project.model_copy(update={"geometry": geometry}), repair.changes


FAR = 0.5  # of a block's size: a joint farther from the point of a crack is not the one that was measured


@dataclass(frozen=True)
class Gauge:
    """Where something is measured: the value that it shows depends on the positions of the blocks alone."""

    kind: Literal["crack", "slip", "lean", "relative"]
    point: tuple[float, float]  # m, as drawn
    block: int  # one that the point moves with
    joint: int = -1  # of a crack or slip, and the end (0, 1) of it that is nearest to the point
    end: int = 0
    # of a relative displacement: against it, of `origin_block` (None: the benchmark), along `axis` (0: x, 1: z)
    origin: tuple[float, float] | None = None
    origin_block: int | None = None
    axis: int = 0


def gauges(project: Project, model: Assembly) -> tuple[Gauge, ...]:
    """Return the gauges of all measurements. Raises ProjectError for a point at no joint, in no block, twice in one."""
    found = []
    for each in project.measurement:
        key = f"{project.source}: measurement.{each.name}"
        if each.kind in ("crack", "slip"):
            ends, point = model.joints.ends, np.array(each.point_m)
            distance = shapely.distance(shapely.linestrings(ends), shapely.Point(point))
            joint = int(np.argmin(distance))
            if (away := distance[joint]) > FAR * model.size:
                text = f"{list(each.point_m)} is at no joint (the nearest one is {away:.4g} m away); move it there"
                raise ProjectError(f"{key}.point_m: {text}")
            end, block = int(np.argmin(np.hypot(*(ends[joint] - point).T))), int(model.joints.a[joint])
            found.append(Gauge(each.kind, each.point_m, block, joint, end))
            continue
        block = masonry.block_at(model, f"{key}.point_m", each.point_m)
        gauge = Gauge(each.kind, each.point_m, block, axis=int(each.component == "z"))
        if isinstance(each.from_m, tuple):
            other = masonry.block_at(model, f"{key}.from_m", each.from_m)
            if other == gauge.block:
                raise ProjectError(f"{key}.from_m: in the same block as point_m; write a point of another")
            gauge = replace(gauge, origin=each.from_m, origin_block=other)
        found.append(gauge)
    return tuple(found)


def readings(model: Assembly, found: Sequence[Gauge], positions: Array) -> Array:
    """Return what the gauges show (m,) at positions (b, 3): mm, of a lean mrad."""
    places = model.contacts.places(positions)[: len(model.joints.a)]
    gaps, shown = end_gaps(places), []
    for each in found:
        if each.kind == "crack":
            shown.append(gaps[each.joint, each.end])
        elif each.kind == "slip":
            shown.append(abs(places[each.joint, V]))
        elif each.kind == "lean":
            shown.append(positions[each.block, 2])
        else:
            moved = model.point_displacement(each.point, each.block, positions)
            if each.origin is not None and each.origin_block is not None:
                moved = moved - model.point_displacement(each.origin, each.origin_block, positions)
            shown.append(moved[each.axis])
    return 1000.0 * np.array(shown, dtype=float)
