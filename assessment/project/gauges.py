"""Measurements of a project as gauges on its model, and what they show where the blocks have moved."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import shapely

from assessment.project.masonry import block_at
from assessment.project.project import Project
from assessment.runtime.errors import ProjectError
from mechanics import Assembly
from mechanics.model import V, end_gaps
from mechanics.types import Array

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
        block = block_at(model, f"{key}.point_m", each.point_m)
        gauge = Gauge(each.kind, each.point_m, block, axis=int(each.component == "z"))
        if isinstance(each.from_m, tuple):
            other = block_at(model, f"{key}.from_m", each.from_m)
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
