"""Where what a project names is on the assembly: the block at a point, macro-blocks of mechanisms, gauges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
import shapely
from numpy.typing import NDArray

from assessment.runtime.errors import ProjectError, nearest
from mechanics import ArgumentError, Assembly
from mechanics.messages import layer_key
from mechanics.model import V, end_gaps
from mechanics.types import Array

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.schema import MechanismTable


def block_at(model: Assembly, key: str, point: tuple[float, float], note: str = "") -> int:
    """Return the block that contains a point (m). Raises ProjectError naming its key, with a note, where none does."""
    try:
        return model.block_at(point)
    except ArgumentError as error:
        reason = str(error).partition("must be ")[2] + note
        raise ProjectError(f"{key}: {list(point)} must be {reason}; move it there") from None


@dataclass(frozen=True, eq=False)
class RotatingBlocks:
    """Blocks (n,) that rotate as one by `rotation`, anticlockwise, about the point `about` (2,) m, from the origin."""

    about: NDArray[np.float64]
    rotation: float
    blocks: NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Chosen:
    """A mechanism chosen by the user, in the configuration of a state."""

    name: str
    state: str
    parts: tuple[RotatingBlocks, ...]


def chosen_mechanisms(project: Project, model: Assembly) -> list[Chosen]:
    """Return the mechanisms of [[mechanism]], entries of one name joined.

    Raises ProjectError naming the entry: an unknown layer, no such block, a support, a block chosen twice, none at all.
    """
    found: dict[str, Chosen] = {}
    for index, entry in enumerate(project.mechanism):
        key = f"{project.source}: mechanism[{index + 1}]"
        blocks = _blocks(entry, model, key)
        before = found.get(entry.name, Chosen(entry.name, entry.state, ()))
        for part in before.parts:
            if (twice := np.intersect1d(part.blocks, blocks)).size:
                text = f'block {twice[0]} is in another macro-block of "{entry.name}"'
                raise ProjectError(f"{key}: {text}; a block has one rotation")
        part = RotatingBlocks(model.from_origin(entry.about_m), entry.rotation, blocks)
        found[entry.name] = replace(before, parts=(*before.parts, part))
    return [*found.values()]


def _blocks(entry: MechanismTable, model: Assembly, key: str) -> NDArray[np.intp]:
    """Return the blocks of the layers within the region, and those named by number; sorted."""
    of_layer = {layer_key(block.layer): block.layer for block in model.blocks}
    for layer in entry.layers or ():
        if layer_key(layer) not in of_layer:
            names = sorted(set(of_layer.values()))
            raise ProjectError(f'{key}.layers: no block on layer "{layer}"; {nearest(layer, names)}')
    for number in entry.blocks or ():
        if not 0 <= number < len(model.blocks):
            raise ProjectError(f"{key}.blocks: no block {number}; write 0 to {len(model.blocks) - 1}")
        if not model.movable[number]:
            raise ProjectError(
                f"{key}.blocks: block {number} is a support, which a mechanism leaves where it is; leave it out"
            )
    chosen = np.zeros(len(model.blocks), dtype=bool)
    if entry.layers or entry.region_m:
        chosen |= model.movable
    if entry.layers:
        chosen &= np.isin([layer_key(block.layer) for block in model.blocks], [*map(layer_key, entry.layers)])
    if entry.region_m:
        corners = np.reshape(entry.region_m, (-1, 2))
        if len(corners) == 2:
            region = shapely.box(*corners.min(axis=0), *corners.max(axis=0))
        elif not (region := shapely.Polygon(corners)).is_valid:
            raise ProjectError(f"{key}.region_m: the outline crosses itself; write its corners in order")
        chosen &= shapely.intersects(region, shapely.points([block.centroid for block in model.blocks]))
    chosen[list(entry.blocks or ())] = True
    if not chosen.any():
        raise ProjectError(f"{key}: no movable block is chosen; correct layers, region_m or blocks")
    return np.flatnonzero(chosen)


FAR = 0.5  # of a block's size: a joint farther from the point of a crack is not the one that was measured


@dataclass(frozen=True)
class Gauge:
    """Where something is measured: the value that it shows depends on the positions of the blocks alone.

    Of a crack or slip: `joint`, and `end` (0, 1) of it that is nearest to the point. Of a lean: `block`. Of a relative
    displacement: `point` (m, as drawn) of `block`, against `origin` of `origin_block` (None: the benchmark), along
    `axis` (0: x, 1: z). `block` is in every case one that the point moves with.
    """

    kind: Literal["crack", "slip", "lean", "relative"]
    point: tuple[float, float]
    block: int
    joint: int = -1
    end: int = 0
    origin: tuple[float, float] | None = None
    origin_block: int | None = None
    axis: int = 0


def gauges(project: Project, model: Assembly) -> tuple[Gauge, ...]:
    """Return the gauges of all measurements.

    Raises ProjectError for a point far from any joint, in no block, twice in one.
    """
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
        gauge = Gauge(each.kind, each.point_m, block_at(model, f"{key}.point_m", each.point_m))
        if each.kind == "relative":
            gauge = replace(gauge, axis=0 if each.component == "x" else 1)
        if isinstance(each.from_m, tuple):
            other = block_at(model, f"{key}.from_m", each.from_m)
            if other == gauge.block:
                text = "in the same block as point_m; write a point of another one"
                raise ProjectError(f"{key}.from_m: {text}")
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
