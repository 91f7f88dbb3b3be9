"""An assembly of blocks and the states it can be in."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
import shapely
from numpy.typing import ArrayLike

from mechanics.errors import ArgumentError, is_number, is_whole, point_of, require, require_positive
from mechanics.kernels.bed import MOST_SEGMENTS
from mechanics.kernels.joint import H
from mechanics.model.block import Block, Joints, Tie, default_tolerance, find_joints, polygons_of
from mechanics.model.contacts import Contacts, Outlines, drawn_contacts, tie_contacts
from mechanics.pictures import Shape, draw_state, place
from mechanics.types import GRAVITY, Array, Index, Mask, turned

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


# of the mean block's weight times size: equilibrium to 1e-8 of it would not see less overturn
LIGHTEST = 1e-6
PART = 0.01  # of the largest displacement of a block: one that takes part in a mechanism
FAR = 10.0  # of the drawing's size: beyond it coordinates lose more than one digit to their distance from the origin

Behaviour = Literal["rigid", "elastic"]
Direction = Literal["+x", "-x"]


@dataclass(frozen=True, eq=False)
class MotionMemory:
    """What a motion of `rigid` or elastic joints goes on from, beside positions and velocities.

    `blocks` (2, b, 3): mean accelerations of the last step, m/s² and rad/s², and velocities at which the next program
    begins; `joints` (k, 2 + JOINT): both edges of each contact and what is known of it (kernels.dynamics.motion);
    `largest` kinetic energy so far, kNm; `halved`: how often the last step was; `begun` (b, 3): first positions.
    """

    rigid: bool
    blocks: Array
    joints: Array
    largest: float
    halved: int
    begun: Array


@dataclass(frozen=True, eq=False, repr=False)
class State:
    """Positions and velocities of the blocks, and the forces that their joints remember.

    `positions` (b, 3): x, z (m) of each centroid, from the assembly's origin, and rotation (rad) from the drawing;
    `velocities` (b, 3): m/s and rad/s. `shear` (j,): tangential forces (kN) in the springs of the drawn joints; `met`
    (k, 3): the same for faces that came into contact, by their two edges. `carrying` (j,): which drawn joints carry in
    the equilibrium of this state; rigid ones count as closed whatever gap dilatant sliding has left. None: the state is
    not from an equilibrium. `lengthened` (t,): by how much each tie has yielded, m; None: not at all. `motion`: of the
    state at the end of a motion, None: the next one begins anew.
    """

    positions: Array
    velocities: Array
    shear: Array | None = None
    met: Array | None = None
    carrying: Mask | None = None
    lengthened: Array | None = None
    motion: MotionMemory | None = None

    def __repr__(self) -> str:
        fastest = float(abs(self.velocities[:, :2]).max())
        return f"State({len(self.positions)} blocks, {f'up to {fastest:.3g} m/s' if fastest else 'at rest'})"


@dataclass(frozen=True, eq=False, repr=False)
class Assembly:
    """Blocks and the dry joints between them; blocks with the name of a support are fixed.

    `segments_per_joint`: contact points of the paper in elastic analyses; by default the bed is exact. `tolerance`
    (m): edges closer than this touch (default: a thousandth of the median edge). `collisions`: blocks that are apart as
    drawn may come to touch. `ties` between them. Raises ArgumentError for blocks that cannot be analysed, and for a tie
    that does not join two of them.

    `origin` (2,) m: where the positions of states count from; by default (0, 0), or, for the sake of their digits,
    whole metres near the corner of what is drawn far away beside its size. Blocks, joints and points that are given are
    those of the drawing.
    """

    blocks: Sequence[Block]
    segments_per_joint: int | None = None
    tolerance: float | None = None
    collisions: bool = True
    ties: Sequence[Tie] = ()
    origin: ArrayLike | None = None

    def __post_init__(self) -> None:
        for name, kind in (("blocks", Block), ("ties", Tie)):
            given, must_be = getattr(self, name), f"a sequence of {kind.__name__}"
            require(isinstance(given, Iterable), name, given, must_be)
            object.__setattr__(self, name, tuple(given))
            odd = [each for each in getattr(self, name) if not isinstance(each, kind)]
            require(not odd, name, odd[:1], must_be)
        require(len(self.blocks) > 0, "blocks", 0, "at least one block")
        object.__setattr__(self, "origin", _origin(self.blocks) if self.origin is None else self.origin)
        n = self.segments_per_joint
        whole = n is None or (is_whole(n) and 1 <= n <= MOST_SEGMENTS)
        require(whole, "segments_per_joint", n, f"from 1 to {MOST_SEGMENTS}, or None")
        if self.tolerance is None:
            object.__setattr__(self, "tolerance", default_tolerance(self.blocks))
        require_positive(self, tolerance="positive, in m")
        require(bool(self.movable.any()), "blocks", "all supports", "an assembly with a movable block")
        weights = np.array([abs(b.weight) for b in self.blocks])
        moments = np.where(self.movable, weights * self.block_size, np.inf)
        lightest, mean = int(np.argmin(moments)), float(weights[self.movable].mean()) * self.size
        share = float(moments[lightest]) / max(mean, 1e-300)  # of blocks without any weight 0
        told = f"weight times size of block {lightest} is {share:.2g} of the mean block's"
        least = f"at least {LIGHTEST:g} (less is lost in the accuracy of equilibrium): leave the block out"
        require(share >= LIGHTEST, "blocks", told, least)
        for tie, (one, other) in zip(self.ties, self.tie_blocks.tolist(), strict=True):
            told = f"both ends in block {one}" if one == other else "both ends in supports"
            joins = one != other and bool(self.movable[[one, other]].any())
            require(joins, f'tie "{tie.name}"', told, "between two blocks that can move against each other")

    def __repr__(self) -> str:
        tied = f", {len(self.ties)} ties" if self.ties else ""
        return f"Assembly({len(self.blocks)} blocks, {(~self.movable).sum()} of them supports{tied})"

    @cached_property
    def shape(self) -> Shape:
        """The outlines of the blocks as drawn, for pictures."""
        b = self.blocks
        return Shape.of([e.polygon for e in b], [e.centroid for e in b], (~self.movable).tolist())

    def displaced(self, state: State) -> Array:
        """Return displacements x, z (m) and rotations (rad) of the blocks (b, 3) in a state, from the drawing."""
        return state.positions - self.initial.positions

    def plot(self, state: State | None = None, magnified: float = 1.0, axes: Axes | None = None) -> Axes:
        """Draw blocks and ties, `magnified`, over the outlines as drawn; return the axes (default: a new figure's)."""
        moved, ties = self.displaced(self.starting(state)), self.tie_ends(self.starting(state), magnified)
        title = "" if magnified == 1.0 else f"displacements × {magnified:g}"
        return draw_state(self.shape.moved(moved, magnified), self.shape, ties, title, axes)

    def tie_ends(self, state: State, magnified: float = 1.0) -> list[Array]:
        """Return the ends (2, 2), m, of every tie in a state, its displacements magnified, for pictures."""
        moved, middles = self.displaced(state), self.shape.centroids
        found = zip([np.asarray(tie.points) for tie in self.ties], self.tie_blocks, strict=True)
        return [ends + magnified * (place(ends, pair, middles, moved) - ends) for ends, pair in found]

    def to_frame(self) -> pd.DataFrame:
        """Return a table of the blocks: support, centroid (m), area (m²), depth (m), weight with loads (kN)."""
        import pandas as pd  # late: only tables need it

        rows = [(b.support, *b.centroid, b.area, b.depth, b.weight) for b in self.blocks]
        return pd.DataFrame(rows, columns=["support", "x_m", "z_m", "area_m2", "depth_m", "weight_kN"])

    def tied(self, ties: Iterable[Tie]) -> Assembly:
        """Return the assembly with these ties in the place of its own."""
        return replace(self, ties=tuple(ties))

    def from_origin(self, points: ArrayLike) -> Array:
        """Return points (…, 2) m of the drawing as they count from the origin."""
        return np.asarray(points, dtype=float) - np.asarray(self.origin, dtype=float)

    def as_drawn(self, points: ArrayLike) -> Array:
        """Return points (…, 2) m that count from the origin as those of the drawing."""
        return np.asarray(points, dtype=float) + np.asarray(self.origin, dtype=float)

    @cached_property
    def tie_blocks(self) -> Index:
        """The two blocks (t, 2) of each tie. Raises ArgumentError for an end that is in no block."""
        found = [
            self.block_at(point, f'{key} of tie "{tie.name}"')
            for tie in self.ties
            for key, point in zip(("start", "end"), tie.points, strict=True)
        ]
        return np.array(found, dtype=np.intp).reshape(len(self.ties), 2)

    @property
    def joint_tolerance(self) -> float:
        """Tolerance in use (m): the one given, or the default."""
        assert self.tolerance is not None
        return self.tolerance

    @cached_property
    def joints(self) -> Joints:
        """Joints between the blocks, as drawn."""
        return replace(self._joints, ends=self.as_drawn(self._joints.ends))

    @cached_property
    def _moved(self) -> Sequence[Block]:
        """The blocks as they count from the origin: far from it corners and centroids would lose digits."""
        if not np.any(self.origin):
            return self.blocks
        return [replace(block, vertices=self.from_origin(block.polygon)) for block in self.blocks]

    @cached_property
    def _joints(self) -> Joints:
        """The joints as they count from the origin."""
        return find_joints(self._moved, self.joint_tolerance)

    @cached_property
    def contacts(self) -> Contacts:
        """The contacts of the joints as drawn, then the ties."""
        drawn = drawn_contacts(self._moved, self._joints, self.segments_per_joint or 0, self.joint_tolerance)
        if not self.ties:
            return drawn
        ends, centroid = self.from_origin([tie.points for tie in self.ties]), self.initial.positions[:, :2]
        return drawn.joined(tie_contacts(self.ties, ends, self.tie_blocks, centroid, drawn))

    @cached_property
    def outlines(self) -> Outlines:
        """Edges and corners of the blocks."""
        return Outlines.of(self._moved)

    @cached_property
    def radius(self) -> Array:
        """Distance (b,) of each block's farthest corner from its centroid, m."""
        return np.array([np.hypot(*(b.polygon - b.centroid).T).max() for b in self.blocks])

    @cached_property
    def block_size(self) -> Array:
        """Root of the area of each block (b,), m."""
        return np.array([np.sqrt(b.area) for b in self.blocks])

    def farthest(self, one: Array, other: Array) -> float:
        """Return an upper bound (m) of the way of any corner from positions (b, 3) to others."""
        moved = abs(other - one)
        return float((np.hypot(moved[:, 0], moved[:, 1]) + self.radius * moved[:, 2]).max())

    @staticmethod
    def check(model: object) -> None:
        """Raise ArgumentError if the argument `model` of an analysis is no assembly."""
        require(isinstance(model, Assembly), "model", type(model).__name__, "an Assembly")

    def check_behaviour(self, behaviour: Behaviour) -> None:
        """Raise ArgumentError for an unknown behaviour, and for elastic joints without stiffness."""
        require(behaviour in ("rigid", "elastic"), "contacts", behaviour, '"rigid" or "elastic"')
        if behaviour == "elastic" and np.isnan(self.contacts.bed).any():
            raise ArgumentError("normal_stiffness: elastic contacts need it for the material of every block")

    @cached_property
    def rounding(self) -> float:
        """The last digit of a position over the compression of the median joint under the structure's weight."""
        positions, contacts = self.initial.positions, self.contacts.take(np.flatnonzero(~self.contacts.ties))
        if len(contacts) == 0:
            return 0.0
        stiffness = contacts.bed * 2.0 * contacts.places(positions)[:, H]
        return float(np.spacing(abs(positions[:, :2]).max()) * np.median(stiffness) / self.weight)

    @property
    def crushes(self) -> bool:
        """Whether joints of some block have a finite compressive strength."""
        return any(block.material.compressive_strength < np.inf for block in self.blocks)

    @cached_property
    def uncrushed(self) -> Assembly:
        """The same blocks with joints that cannot be crushed."""
        stones = [replace(block.material, compressive_strength=np.inf) for block in self.blocks]
        whole = [replace(block, material=stone) for block, stone in zip(self.blocks, stones, strict=True)]
        return replace(self, blocks=whole) if self.crushes else self

    @cached_property
    def joints_in_a_row(self) -> int:
        """Largest number of joints from a block to the support nearest to it."""
        near, count = ~self.movable, 0
        while True:
            touched = near.copy()
            touched[self.joints.a[near[self.joints.b]]] = True
            touched[self.joints.b[near[self.joints.a]]] = True
            if (touched == near).all():
                return count
            near, count = touched, count + 1

    @cached_property
    def movable(self) -> Mask:
        """Mask (b,) of the blocks that are no supports."""
        return np.array([b.support is None for b in self.blocks])

    @cached_property
    def dof(self) -> Index:
        """Degree of freedom (b, 3) of x, z, ω of each block; −1 for supports."""
        index = np.full((len(self.blocks), 3), -1, dtype=np.intp)
        index[self.movable] = np.arange(3 * self.movable.sum()).reshape(-1, 3)
        return index

    @cached_property
    def initial(self) -> State:
        """The state as drawn, at rest."""
        centroid = np.array([b.centroid for b in self._moved])
        return State(np.column_stack([centroid, np.zeros(len(centroid))]), np.zeros((len(centroid), 3)))

    @cached_property
    def mass(self) -> Array:
        """Mass (b, 3): Mg, Mg, Mg·m² of each block."""
        return np.array([(b.mass, b.mass, b.inertia) for b in self.blocks])

    @cached_property
    def dead_load(self) -> Array:
        """f_D (b, 3): weights and vertical loads, kN."""
        load = np.zeros((len(self.blocks), 3))
        load[:, 1] = [-b.weight for b in self.blocks]
        return load

    def taking_part(self, mechanism: Array) -> Mask:
        """Return which blocks (b,) move noticeably in virtual displacements (b, 3): others would make e* too small."""
        moves = abs(mechanism[:, :2]).max(axis=1)
        return (moves > PART * moves.max()) & self.movable

    def lateral_load(self, direction: Direction) -> Array:
        """Return f_L (b, 3), kN: the weight of every seismic mass as a horizontal force in the direction."""
        require(direction in {"+x", "-x"}, "direction", direction, '"+x" or "-x"')
        load = np.zeros((len(self.blocks), 3))
        load[:, 0] = (1.0 if direction == "+x" else -1.0) * GRAVITY * self.mass[:, 0]
        return load

    @cached_property
    def weight(self) -> float:
        """Weight of the movable blocks with their loads, kN."""
        return -float(self.dead_load[self.movable, 1].sum())

    @cached_property
    def size(self) -> float:
        """A block's size, m: the root of the mean area of the movable blocks (the program's unit of length)."""
        return float(np.sqrt(np.mean([b.area for b in self.blocks if b.support is None])))

    def support(self, name: str) -> Index:
        """Return the blocks of a support. Raises ArgumentError, with the known names, for another name."""
        index = np.flatnonzero([b.support is not None and b.support == name for b in self.blocks])
        known = sorted({b.support for b in self.blocks if b.support})
        require(len(index) > 0, "support", name, f"one of {', '.join(known) or '(the model has no support)'}")
        return index

    def support_centre(self, name: str) -> Array:
        """Return the centroid (2,) of a support's blocks as drawn, m, from the origin."""
        index = self.support(name)
        area = np.array([self.blocks[i].area for i in index])
        return area @ self.initial.positions[index, :2] / area.sum()

    def moved_support(self, positions: Array, name: str, displacement: Array, rotation: float) -> Array:
        """Return positions (b, 3) after a displacement (2,) m and rotation (rad), about its centroid, of a support."""
        index, centre = self.support(name), self.support_centre(name)
        arm = self.initial.positions[index, :2] - centre
        moved = positions.copy()
        moved[index, :2] = centre + displacement + turned(arm, rotation)
        moved[index, 2] = rotation
        return moved

    def support_movement(self, positions: Array, name: str) -> tuple[Array, float]:
        """Return displacement (2,) m and rotation (rad), about its drawn centroid, of a support at positions (b, 3)."""
        first, centre = self.support(name)[0], self.support_centre(name)
        turn, arm = float(positions[first, 2]), self.initial.positions[first, :2] - centre
        return positions[first, :2] - centre - turned(arm, turn), turn

    def rotated(self, block: int, about: ArrayLike, rotation: float) -> State:
        """Return the drawn state with one block rotated by `rotation` (rad) about a point (2,) m."""
        last = len(self.blocks) - 1
        require(is_whole(block) and 0 <= block <= last, "block", block, f"from 0 to {last}")
        pivot = point_of("about", about)
        require(is_number(rotation) and abs(rotation) < np.inf, "rotation", rotation, "finite, in rad")
        pivot = self.from_origin(pivot)
        positions = self.initial.positions.copy()
        positions[block] = *(pivot + turned(positions[block, :2] - pivot, rotation)), rotation
        return State(positions, np.zeros_like(positions))

    def starting(self, state: State | None) -> State:
        """Return the state in which an analysis starts, None: as drawn. Raises ArgumentError if it has other blocks."""
        if state is None:
            return self.initial
        require(isinstance(state, State), "state", type(state).__name__, "a State, as .final of a pushdown")
        shape = self.initial.positions.shape
        require(state.positions.shape == shape, "state", state.positions.shape, f"of this assembly: {shape}")
        require(bool(np.isfinite(state.positions).all()), "state", "positions", "finite")
        return state

    def block_at(self, point: ArrayLike, name: str = "control") -> int:
        """Return the first of `blocks_at` of a drawn point (2,) m called `name`; raises ArgumentError likewise."""
        return int(self.blocks_at(point, name)[0])

    def blocks_at(self, point: ArrayLike, name: str = "control") -> Index:
        """Return the blocks (n,) that contain or touch a drawn point (2,) m called `name`; ArgumentError if none."""
        distance = shapely.distance(polygons_of(self.blocks), shapely.Point(at := point_of(name, point)))
        distance += np.where(self.movable, 0.0, 0.5 * self.joint_tolerance)  # a support comes last
        order = np.argsort(distance, kind="stable")
        must_be = f"in or on a block (the nearest one is {distance.min():.4g} m away)"
        require(distance.min() <= self.joint_tolerance, name, tuple(at.tolist()), must_be)
        return order[distance[order] <= self.joint_tolerance]

    def point_displacement(self, point: ArrayLike, block: int, positions: Array) -> Array:
        """Return the displacement (…, 2), m, of a drawn point (2,) m of a block at positions (…, b, 3)."""
        at = self.from_origin(point)
        arm = at - self.initial.positions[block, :2]
        return positions[..., block, :2] + turned(arm, positions[..., block, 2]) - at


def _origin(blocks: Sequence[Block]) -> Array:
    """Return the origin (2,) m of blocks: (0, 0), or whole metres where they are FAR times their extent away."""
    points = np.concatenate([block.polygon for block in blocks])
    low = points.min(axis=0)
    near = np.abs(points).max() <= FAR * np.ptp(points, axis=0).max()
    return np.zeros(2) if near else np.floor(low)
