"""Collapse is decided from the motion of the blocks, never from a solver that fails."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from mechanics.kernels.dynamics.motion import GONE
from mechanics.kernels.joint import H, U
from mechanics.kernels.law import BED, STRENGTH
from mechanics.messages import Message, message
from mechanics.model.assembly import Assembly
from mechanics.model.contacts import Contacts
from mechanics.steps.static_system import StaticSystem
from mechanics.types import Array, Mask

TURNED = 1.0  # rad from the drawing, half of it in the motion: so far turned, a block does not come back
THROUGH = 0.01  # of a block's area: an overlap that is none


@dataclass(frozen=True, eq=False)
class ControlPoint:
    """A drawn `point` (2,) m of a `block`, whose horizontal displacement is followed, up to its `ultimate` one (m)."""

    point: Array
    block: int
    ultimate: float | None = None

    def displacement(self, model: Assembly, begun: Array, x: Array) -> Array:
        """Horizontal displacements (…) m from positions (b, 3) in which a motion has begun to others (…, b, 3)."""
        now, then = (model.point_displacement(self.point, self.block, positions) for positions in (x, begun))
        moved: Array = now[..., 0] - then[0]
        return moved

    def velocity(self, model: Assembly, x: Array, v: Array) -> float:
        """Return the horizontal velocity, m/s, at positions x (b, 3) and velocities v (b, 3)."""
        moved = model.point_displacement(self.point, self.block, x) + model.from_origin(self.point)
        return float(v[self.block, 0] - v[self.block, 2] * (moved[1] - x[self.block, 1]))


def _turned(model: Assembly, begun: Array, x: Array) -> Array:
    """Return how far (…, b) rad blocks have turned from the drawing, at most twice as far as since `begun` (b, 3)."""
    drawn = model.initial.positions[:, 2]
    least: Array = np.minimum(abs(x[..., 2] - drawn), 2.0 * abs(x[..., 2] - begun[:, 2]))
    return least


def far(model: Assembly, begun: Array, x: Array, control: ControlPoint | None) -> Mask:
    """Return which positions (…, b, 3) are far enough from where a motion has `begun` (b, 3) to be a collapse."""
    turned = _turned(model, begun, x).max(axis=-1) > TURNED
    found: Mask = turned | (abs(x - begun).max(axis=(-2, -1)) > model.block_size.min())
    if control is not None and control.ultimate is not None:
        found |= abs(control.displacement(model, begun, x)) > control.ultimate
    return found


def collapse(
    model: Assembly, contacts: Contacts, begun: Array, x: Array, v: Array, control: ControlPoint | None
) -> Message | None:
    """Return why a motion at positions x (b, 3) and velocities v (b, 3) cannot come back; None where it can.

    The control point is past its ultimate displacement and moves outward; or a block has turned by more than 1 rad from
    the drawing and half of it in the motion, or fallen by more than its size and still falls, or is out of reach of all
    its contacts. Displacements are from where the motion has `begun` (b, 3).
    """
    if control is not None and control.ultimate is not None:
        displacement = float(control.displacement(model, begun, x))
        if abs(displacement) > control.ultimate and displacement * control.velocity(model, x, v) > 0.0:
            return message(
                "the control point is {displacement:.3g} m away, past its ultimate displacement, and moving outward",
                displacement=displacement,
            )
    if not far(model, begun, x, None):
        return None
    moved, size = x - begun, model.block_size
    turned = _turned(model, begun, x)
    if turned.max() > TURNED:
        block = int(turned.argmax())
        angle = float(abs(x[block, 2] - model.initial.positions[block, 2]))
        return message("block {block} has turned by {angle:.2f} rad", block=block, angle=angle)
    fallen = (-moved[:, 1] > size) & (v[:, 1] < 0.0)
    if fallen.any():
        block = int(np.argmax(np.where(fallen, -moved[:, 1], -np.inf)))
        return message("block {block} has fallen by {drop:.3g} m", block=block, drop=float(-moved[block, 1]))
    alone = np.flatnonzero(model.movable & ~_in_reach(size, contacts, x))
    if not alone.size:
        return None
    return message("block {block} is out of reach of all its contacts", block=int(alone[0]))


def broken_tie(system: StaticSystem, x: Array) -> tuple[int, Message] | None:
    """Return the first of positions x (k, b, 3) at which a tie has yielded by more than it can, and which one."""
    ties = system.model.ties
    yields = np.array([tie.yield_force < np.inf for tie in ties])
    longest = np.where(yields, [tie.longest for tie in ties], np.inf)
    if not np.isfinite(longest).any():
        return None
    own, law = system.contacts.take(np.arange(len(system.contacts))[system.ties]), system.law[system.ties]
    elastic = np.where(yields, law[:, STRENGTH], 0.0) / law[:, BED] - system.stretched
    for k, at in enumerate(x):
        broken = np.flatnonzero(-own.places(at)[:, U] - elastic > longest)
        if broken.size:
            tie = ties[broken[0]]
            return k, message(
                "the tie {tie} breaks: it has yielded by more than {longest:.3g} m", tie=tie.name, longest=tie.longest,
            )  # fmt: skip
    return None


def _in_reach(size: Array, contacts: Contacts, x: Array) -> Mask:
    """Return which blocks (b,) still have a contact: neither its gap nor its slide exceeds the smaller block's size."""
    places = contacts.places(x)
    near = np.maximum(places[:, U], -2.0 * places[:, H]) <= np.minimum(size[contacts.a], size[contacts.b])
    has = np.zeros(len(size), dtype=bool)
    has[contacts.a[near]] = has[contacts.b[near]] = True
    return has


def passing_through(model: Assembly, x: Array) -> tuple[Message, ...]:
    """Return a note on the two blocks that overlap most at positions (b, 3); empty where none overlap.

    It can be needed only where contacts are not looked for again as blocks move.
    """
    cos, sin = np.cos(x[:, 2]), np.sin(x[:, 2])
    turned = [
        at[:2] - x[0, :2] + (block.polygon - block.centroid) @ np.array([[c, s], [-s, c]])
        for block, at, c, s in zip(model.blocks, x, cos, sin, strict=True)
    ]
    shapes = np.array([shapely.Polygon(polygon) for polygon in turned])
    first, second = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    first, second = first[first < second], second[first < second]
    # on a grid: in plain numbers the overlay of blocks that only touch may be a whole block
    common = shapely.area(shapely.intersection(shapes[first], shapes[second], grid_size=GONE * model.size))
    share = common / np.minimum(shapely.area(shapes[first]), shapely.area(shapes[second]))
    if share.max(initial=0.0) <= THROUGH:
        return ()
    k = int(np.argmax(share))
    return (
        message(
            "block {block} passes through block {other}: they did not touch as drawn, or slid off each other",
            block=int(first[k]),
            other=int(second[k]),
        ),
    )
