"""Blocks, ties between them, and dry joints: pairs of edges that touch, divided at partial overlaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from mechanics.errors import array_of, is_between, is_number, is_whole, point_of, require, require_positive
from mechanics.types import GRAVITY, Array, Index

Polygons = NDArray[np.object_]


@dataclass(frozen=True, slots=True)
class Material:
    """Stone and its dry joints.

    unit_weight: kN/m³; friction: tangent of the friction angle, infinite: no sliding; normal_stiffness and
    tangential_stiffness: of a joint per unit area, kN/m³. Without normal_stiffness only rigid analyses are possible; an
    infinite tangential_stiffness is the paper's choice (§4). compressive_strength: of a joint, kN/m². Raises
    ArgumentError naming the argument.
    """

    unit_weight: float
    friction: float = 0.6
    normal_stiffness: float | None = None
    tangential_stiffness: float = float("inf")
    compressive_strength: float = float("inf")

    def __post_init__(self) -> None:
        require_positive(
            self, unit_weight="positive, in kN/m³", normal_stiffness="positive, in kN/m³, or None"
        )
        require_positive(self, "[]", friction="zero or positive")
        require_positive(
            self, "(]", tangential_stiffness="positive, in kN/m³ (inf: rigid in shear)",
            compressive_strength="positive, in kN/m² (inf: no limit)",
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Block:
    """A rigid block: simple polygon `vertices` (n, 2) in m, kept anticlockwise, `depth` in m out of plane.

    `support`: name of the support that the block belongs to (None: movable). `vertical_load` (kN) acts downward at the
    centroid and counts as seismic mass if `load_has_mass`. `segments`: instead of the assembly's segments per joint.
    `layer`, `handle`: origin of the block in the drawing; `region`: of the project. Raises ArgumentError for fewer than
    three distinct vertices, zero area, an outline that crosses itself, an upward load with mass, or numbers that are
    not finite.
    """

    vertices: ArrayLike
    depth: float
    material: Material
    support: str | None = None
    vertical_load: float = 0.0
    load_has_mass: bool = True
    segments: int | None = None
    layer: str = ""
    handle: str = ""
    region: str = ""

    def __post_init__(self) -> None:
        must_be = "three or more finite (x, z) pairs"
        v = array_of("vertices", self.vertices, must_be)
        pairs = v.ndim == 2 and v.shape[1] == 2 and len(v) >= 3 and bool(np.isfinite(v).all())
        require(pairs, "vertices", v.shape, must_be)
        require_positive(self, depth="positive, in m")
        load, segments, name = self.vertical_load, self.segments, self.support
        require(is_number(load) and abs(load) < np.inf, "vertical_load", load, "finite, in kN")
        # an upward force is no mass: it made the mass of a block negative
        require(load >= 0.0 or not self.load_has_mass, "vertical_load", load,
                "zero or positive where load_has_mass, in kN")  # fmt: skip
        whole = segments is None or (is_whole(segments) and segments >= 1)
        require(whole, "segments", segments, "a whole number ≥ 1")
        require(isinstance(self.material, Material), "material", self.material, "a Material")
        require(name is None or (isinstance(name, str) and name != ""), "support", name, "a name, or None")
        size = float(np.ptp(v, axis=0).max())
        v = v[np.hypot(*(v - np.roll(v, 1, axis=0)).T) > 1e-12 * size]  # repeated vertices are dropped
        require(len(v) >= 3, "vertices", len(v), "three or more distinct points")
        area = _signed_area(v)
        require(abs(area) > 1e-12 * size**2, "vertices", area, "a polygon with an area")
        require(bool(shapely.is_valid(shapely.polygons(v))), "vertices", "an outline that crosses or touches itself",
                "a simple polygon")  # fmt: skip
        if area < 0.0:
            v = v[::-1].copy()
        v.flags.writeable = False
        object.__setattr__(self, "vertices", v)

    @property
    def polygon(self) -> Array:
        """Vertices (n, 2), m, anticlockwise."""
        return self.vertices  # type: ignore[return-value]

    @cached_property
    def area(self) -> float:
        """Area of the polygon, m²."""
        return _signed_area(self.polygon)

    @cached_property
    def centroid(self) -> Array:
        """Centroid (2,), m."""
        origin = self.polygon[0]
        p, q, cross = _edges_from(self.polygon, origin)
        return origin + ((p + q) * cross[:, None]).sum(axis=0) / (6.0 * self.area)

    @cached_property
    def mass(self) -> float:
        """Seismic mass, Mg: that of the stone, and of the load if it has mass."""
        load = self.vertical_load if self.load_has_mass else 0.0
        return (self.material.unit_weight * self.area * self.depth + load) / GRAVITY

    @cached_property
    def inertia(self) -> float:
        """Polar moment of inertia of the stone about the centroid, Mg·m² (a load is a point mass there)."""
        p, q, cross = _edges_from(self.polygon, self.centroid)
        second_moment = float((cross * ((p * p).sum(1) + (p * q).sum(1) + (q * q).sum(1))).sum()) / 12.0
        return self.material.unit_weight / GRAVITY * self.depth * second_moment

    @property
    def weight(self) -> float:
        """Vertical force, kN: own weight and load."""
        return self.material.unit_weight * self.area * self.depth + self.vertical_load


def _signed_area(v: Array) -> float:
    return 0.5 * float(_edges_from(v, v[0])[2].sum())


def _edges_from(v: Array, origin: Array) -> tuple[Array, Array, Array]:
    """Return start and end (n, 2) of the edges of a polygon as seen from a point, and their cross products (n,)."""
    p = v - origin
    q = np.roll(p, -1, axis=0)
    return p, q, p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]


@dataclass(frozen=True, eq=False)
class Tie:
    """A straight tie between two points (x, z) m as drawn, each in or on a block: it pulls, and never pushes.

    `yield_force` (kN): it lengthens under that without bearing more, until it breaks at a share `ultimate_elongation`
    of its length: a motion has collapsed then; `stiffness` (kN/m) of the whole tie, None: rigid; `pretension` (kN): its
    tension at its `length` (m), None: that as drawn. Stiffness and pretension count in analyses
    with elastic joints; with rigid joints the tie is inextensible up to its yield force: a self-stress does not change
    what a rigid structure bears. Raises ArgumentError naming the argument.
    """

    name: str
    start: ArrayLike
    end: ArrayLike
    yield_force: float = float("inf")
    stiffness: float | None = None
    pretension: float = 0.0
    length: float | None = None
    ultimate_elongation: float = float("inf")

    def __post_init__(self) -> None:
        require(isinstance(self.name, str) and bool(self.name), "name", self.name, "the name of the tie")
        for key in ("start", "end"):
            object.__setattr__(self, key, point_of(key, getattr(self, key)))
        require_positive(self, "(]", yield_force="positive, in kN (inf: it does not yield)")
        require_positive(
            self, "(]", ultimate_elongation="positive, a share of the length (inf: it does not break)"
        )
        require_positive(self, stiffness="positive, in kN/m, or None")
        fits = is_between(self.pretension, 0.0, self.yield_force, "[)")
        require(fits, "pretension", self.pretension, "from zero to less than yield_force, in kN")
        drawn = float(np.hypot(*(self.points[1] - self.points[0])))
        require(drawn > 0.0, "end", self.end, "another point than start")
        if self.length is None:
            object.__setattr__(self, "length", drawn)
        require_positive(self, length="positive, in m")

    @property
    def points(self) -> Array:
        """Both ends (2, 2) m as drawn."""
        return np.stack([self.start, self.end])

    @property
    def taut_length(self) -> float:
        """The length (m) at which it has its pretension: the one given, or that as drawn."""
        assert self.length is not None
        return self.length

    @property
    def longest(self) -> float:
        """The length (m) by which it has yielded as it breaks."""
        return self.ultimate_elongation * self.taut_length


@dataclass(frozen=True, eq=False)
class Joints:
    """Joints between blocks `a` and `b` (j,), as drawn.

    `ends` (j, 2, 2) m: the two ends of the overlap, midway between the two edges; the tangent runs from the first
    to the second and the normal, a quarter turn anticlockwise from it, points from b into a.
    `room_a`, `room_b` (j, 2) m: first and last coordinate of the edge of a (of b) along the tangent, from the first
    end. `edges` (j, 2): indices of the two edges among those of all blocks (see block_edges). `gap` (j, 2) m: how far
    the two edges are apart at the two ends, negative where they overlap.
    """

    a: Index
    b: Index
    ends: Array
    room_a: Array
    room_b: Array
    edges: Index
    gap: Array

    @property
    def blocks(self) -> Index:
        """The blocks (j, 2) of each."""
        return np.stack([self.a, self.b], axis=1)

    @property
    def length(self) -> Array:
        """Overlap (j,), m."""
        return np.hypot(*(self.ends[:, 1] - self.ends[:, 0]).T)

    @property
    def tangent(self) -> Array:
        """Unit vectors (j, 2) from the first to the second end."""
        return (self.ends[:, 1] - self.ends[:, 0]) / self.length[:, None]


def polygons_of(blocks: Sequence[Block]) -> Polygons:
    """Return the outlines (b,) of blocks."""
    return shapely.polygons([shapely.linearrings(b.polygon) for b in blocks])


def default_tolerance(outlines: Sequence[Block | Array]) -> float:
    """Return a thousandth of the median edge (m) of blocks, or corners (n, 2): less than a gap, more than rounding."""
    start, end, _ = ring_edges([each.polygon if isinstance(each, Block) else each for each in outlines])
    return 1e-3 * float(np.median(np.hypot(*(end - start).T)))


def find_joints(blocks: Sequence[Block], tolerance: float) -> Joints:
    """Return the joints of an assembly.

    Two edges of different blocks form a joint if they run in opposite directions, overlap by more than `tolerance` (m),
    and at no place along the overlap farther apart than `tolerance`. Running bond and L- or T-contacts are partial
    overlaps and need no extra vertices; vertices in the middle of a straight edge are ignored. Two supports have no
    joint.
    """
    start, end, owner = block_edges(blocks)
    lines = shapely.linestrings(np.stack([start, end], axis=1))
    first, second = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=1.01 * tolerance)
    fixed = np.array([b.support is not None for b in blocks])
    keep = (owner[first] < owner[second]) & ~(fixed[owner[first]] & fixed[owner[second]])
    first, second = first[keep], second[keep]

    unit = (end - start) / np.hypot(*(end - start).T)[:, None]
    t = unit[first] - unit[second]
    size = np.hypot(*t.T)
    keep = size > 1.9  # opposite directions to about 35°: the distance at the overlap's ends decides
    first, second, t = first[keep], second[keep], t[keep] / size[keep, None]
    n = np.stack([-t[:, 1], t[:, 0]], axis=1)

    # along the common tangent, from the start of the first edge; the first edge runs forward, the second back
    points = np.stack([start[first], end[first], end[second], start[second]]) - start[first]
    along, across = (points * t).sum(axis=2), (points * n).sum(axis=2)
    low, high = bounds = np.stack([np.maximum(along[0], along[2]), np.minimum(along[1], along[3])])
    one, other = (
        across[k] + (across[k + 1] - across[k]) * (bounds - along[k]) / (along[k + 1] - along[k])
        for k in (0, 2)
    )
    gap = (one - other).T
    keep = (high - low > tolerance) & (abs(gap) <= tolerance).all(axis=1)
    ends = start[first] + bounds[..., None] * t + 0.5 * (one + other)[..., None] * n
    ends = ends.transpose(1, 0, 2)
    room_a, room_b = (np.stack([along[k] - low, along[k + 1] - low], axis=1) for k in (0, 2))
    a, b, edges = owner[first], owner[second], np.stack([first, second], axis=1)
    order = np.flatnonzero(keep)[np.lexsort((b[keep], a[keep]))]
    return Joints(a[order], b[order], ends[order], room_a[order], room_b[order], edges[order], gap[order])


def connected(pairs: Index, count: int) -> Index:
    """Return the part (count,) to which each of so many things belongs that are linked by pairs (p, 2)."""
    graph = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.intp)


def ring_edges(rings: Sequence[Array]) -> tuple[Array, Array, Index]:
    """Return the edges of rings, each (n, 2) m: start (e, 2) m, end (e, 2) m, ring (e,)."""
    start = np.concatenate(rings)
    owner = np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])
    return start, start[following(owner)], owner


def block_edges(blocks: Sequence[Block]) -> tuple[Array, Array, Index]:
    """Return the straight edges of all blocks: start (e, 2) m, end (e, 2) m, block (e,)."""
    vertex, then, owner = ring_edges([b.polygon for b in blocks])
    after = then - vertex
    before = after[preceding(owner)]
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    one, other = np.hypot(*before.T), np.hypot(*after.T)
    # vertices at which the outline changes direction by more than rounding
    corner = abs(turn) > 1e-9 * one * other + 2.0 * np.spacing(abs(vertex).max()) * (one + other)
    start, owner = vertex[corner], owner[corner]
    return start, start[following(owner)], owner


def following(owner: Index) -> Index:
    """Return the number of the next vertex around the ring of each (v,); those of a ring follow one another."""
    last = np.append(owner[1:] != owner[:-1], True)
    return np.where(last, np.searchsorted(owner, owner), np.arange(1, len(owner) + 1))


def preceding(owner: Index) -> Index:
    """Return the number of the vertex before each (v,): see `following`."""
    return np.argsort(following(owner))
