"""What a measurement would show on the structure in other positions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
import shapely

from assessment.project.structure.state_models import block_at
from assessment.runtime.errors import ProjectError
from mechanics import Assembly
from mechanics.model import V, end_gaps
from mechanics.types import Array

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.schema import MeasurementTable

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
    """Return the gauge of every measurement.

    Raises ProjectError for a crack or slip where no joint is, a point in no block.
    """
    return tuple(_gauge(project, model, each) for each in project.measurement)


def readings(model: Assembly, found: Sequence[Gauge], positions: Array) -> Array:
    """Return what the gauges show (m,) at positions (b, 3): mm, of a lean mrad."""
    drawn = len(model.joints.a)
    places = model.contacts.places(positions)[:drawn]
    gaps, slips = end_gaps(places), places[:, V]
    return np.array([_reading(model, each, positions, gaps, slips) for each in found])


def _reading(model: Assembly, gauge: Gauge, positions: Array, gaps: Array, slips: Array) -> float:
    if gauge.kind == "crack":
        return 1000.0 * float(gaps[gauge.joint, gauge.end])
    if gauge.kind == "slip":
        return 1000.0 * abs(float(slips[gauge.joint]))
    if gauge.kind == "lean":
        return 1000.0 * float(positions[gauge.block, 2])
    moved = model.point_displacement(gauge.point, gauge.block, positions)
    if gauge.origin is not None and gauge.origin_block is not None:
        moved = moved - model.point_displacement(gauge.origin, gauge.origin_block, positions)
    return 1000.0 * float(moved[gauge.axis])


def _gauge(project: Project, model: Assembly, each: MeasurementTable) -> Gauge:
    key = f"{project.source}: measurement.{each.name}"
    if each.kind in ("crack", "slip"):
        joint, end = _joint_at(model, f"{key}.point_m", each.point_m)
        block = int(model.joints.a[joint])
        return Gauge(each.kind, each.point_m, block, joint, end)
    block = block_at(model, f"{key}.point_m", each.point_m)
    if each.kind == "lean" or each.from_m is None:
        return Gauge(each.kind, each.point_m, block)
    axis = 0 if each.component == "x" else 1
    if each.from_m == "benchmark":
        return Gauge("relative", each.point_m, block, axis=axis)
    other = block_at(model, f"{key}.from_m", each.from_m)
    if other == block:
        raise ProjectError(f"{key}.from_m: in the same block as point_m; write a point of another one")
    return Gauge("relative", each.point_m, block, origin=each.from_m, origin_block=other, axis=axis)


def _joint_at(model: Assembly, key: str, point: tuple[float, float]) -> tuple[int, int]:
    """Return the joint nearest to a point (m) and its nearer end. Raises ProjectError where it is far away."""
    ends = model.joints.ends
    distance = shapely.distance(shapely.linestrings(ends), shapely.Point(point))
    joint = int(np.argmin(distance))
    if distance[joint] > FAR * model.size:
        raise ProjectError(
            f"{key}: {list(point)} is at no joint (the nearest one is {distance[joint]:.4g} m away); move it there"
        )
    return joint, int(np.argmin(np.hypot(*(ends[joint] - np.array(point)).T)))
