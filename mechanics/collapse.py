"""Collapse, read from the motion and never from a solver; and what blocks do that their contacts do not know."""

from __future__ import annotations

import numpy as np
import shapely

from mechanics.assembly import Assembly, State
from mechanics.scene import Motion, Scene
from mechanics.types import Array

TURNED = 1.0  # rad from the beginning: a block that has turned so far does not come back
THROUGH = 0.01  # of a block's area: an overlap that is none


def control_displacement(model: Assembly, point: tuple[Array, int], start: State, x: Array) -> float:
    """Horizontal displacement (m) since the start of a drawn point (2,) of a block, for positions (b, 3)."""
    now, then = (model.point_displacement(*point, positions) for positions in (x, start.positions))
    return float(now[0] - then[0])


def collapse(
    scene: Scene, start: State, motion: Motion, point: tuple[Array, int] | None, ultimate: float | None
) -> str:
    """Why the motion cannot come back; empty where it can.

    The control point is past its ultimate displacement (m) and moves outward; or a block has turned by more than
    1 rad, or fallen by more than its size and still falls, or is out of reach of all its contacts.
    """
    if point is not None and ultimate is not None:
        displacement = control_displacement(scene.model, point, start, motion.x)
        if (
            abs(displacement) > ultimate
            and displacement * _control_velocity(scene.model, point, motion) > 0.0
        ):
            return f"the control point is {displacement:.3g} m away, past its ultimate displacement, and moving outward"
    moved = motion.x - start.positions
    if abs(moved).max() <= min(TURNED, scene.smallest):
        return ""  # nothing of what follows
    turned = abs(moved[:, 2])
    if turned.max() > TURNED:
        return f"block {int(turned.argmax())} has turned by {turned.max():.2f} rad"
    fallen = (-moved[:, 1] > scene.block_size) & (motion.v[:, 1] < 0.0)
    if fallen.any():
        block = int(np.argmax(np.where(fallen, -moved[:, 1], -np.inf)))
        return f"block {block} has fallen by {-moved[block, 1]:.3g} m"
    if abs(moved[:, :2]).max() > scene.smallest:
        alone = np.flatnonzero(scene.model.movable & ~_in_reach(scene, motion))
        if alone.size:
            return f"block {int(alone[0])} is out of reach of all its contacts"
    return ""


def passing_through(model: Assembly, x: Array) -> tuple[str, ...]:
    """The two blocks that lie in each other most, for positions (b, 3): their contacts as drawn do not know it."""
    cos, sin = np.cos(x[:, 2]), np.sin(x[:, 2])
    turned = [
        at[:2] + (block.polygon - block.centroid) @ np.array([[c, s], [-s, c]])
        for block, at, c, s in zip(model.blocks, x, cos, sin, strict=True)
    ]
    shapes = np.array([shapely.Polygon(polygon) for polygon in turned])
    first, second = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    first, second = first[first < second], second[first < second]
    share = shapely.area(shapely.intersection(shapes[first], shapes[second])) / np.minimum(
        shapely.area(shapes[first]), shapely.area(shapes[second])
    )
    if share.max(initial=0.0) <= THROUGH:
        return ()
    k = int(np.argmax(share))
    return (
        f"block {first[k]} passes through block {second[k]}: they did not touch as drawn, or slid off each other",
    )


def _control_velocity(model: Assembly, point: tuple[Array, int], motion: Motion) -> float:
    where, block = point
    height = (model.point_displacement(where, block, motion.x) + where - motion.x[block, :2])[1]
    return float(motion.v[block, 0] - motion.v[block, 2] * height)


def _in_reach(scene: Scene, motion: Motion) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Which blocks (b,) have a contact left: neither open nor slid off by more than the smaller block's size."""
    contacts, gap = scene.contacts, scene.geometry(motion.x)[0]
    least = np.minimum(scene.block_size[contacts.a], scene.block_size[contacts.b])
    off = np.maximum(contacts.room[:, 0] - gap[:, 1], gap[:, 1] - contacts.room[:, 1])
    near = np.maximum(gap[:, 0], off) <= least
    has = np.zeros(len(scene.block_size), dtype=bool)
    has[contacts.a[near]] = has[contacts.b[near]] = True
    return has
