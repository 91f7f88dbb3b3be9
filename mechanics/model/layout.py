"""Check of the blocks of a drawing: duplicates, overlaps, floating blocks and gaps."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import shapely

from mechanics.errors import Fault, FaultyDrawingError, listed
from mechanics.messages import Message, message
from mechanics.model.block import Block, Joints, Polygons, connected, find_joints, polygons_of, ring_edges
from mechanics.model.dxf import can_change
from mechanics.model.polylines import SAGITTA
from mechanics.types import Array, Index, Mask

NEAR = 20.0  # edges that face each other within this many tolerances were likely meant to touch
MOST_OVERLAPS = (1000, 4)  # pairs of blocks, and so many for each block: more teach nothing
MANY = 3  # a block that overlaps at least this many others is reported once, not with each of them
GRID = 1e-9  # of a block's width: step of the grid on which outlines are laid over each other
CHUNK = 64  # blocks whose neighbours are looked for at a time
MOST_NEIGHBOURS = 2e7  # pairs of edges within NEAR tolerances of each other, as many as memory holds
ROOM = 1.5  # least ratio of a proposed tolerance to the widest gap


@dataclass(frozen=True, eq=False)
class Layout:
    """What is wrong (`faults`) or odd (`warnings`) with blocks; `hint`: the tolerance that would close every gap."""

    faults: tuple[Fault, ...]
    warnings: tuple[Message, ...] = ()
    hint: str = ""


class Gap(NamedTuple):
    """A pair of blocks that face each other across `least` to `most` m, with nothing between.

    `place` (2,): the middle of the widest stretch; `stretches`: the ends (s, 2, 2) of all of them.
    """

    pair: tuple[int, int]
    least: float
    most: float
    place: Array
    stretches: Array


def _pairs(gaps: Sequence[Gap]) -> Index:
    return np.array([gap.pair for gap in gaps], dtype=np.intp).reshape(-1, 2)


def survey_layout(blocks: Sequence[Block], tolerance: float, whole: bool = True) -> Layout:
    """Find what keeps blocks from being an assembly, with the `tolerance` (m) with which its joints are found.

    Faults: blocks thinner than the tolerance, drawn twice, or overlapping by more than it (a circle of that diameter
    fits into the common area, or a vertex lies that deep); movable blocks without a chain of joints to a support.
    Warnings: gaps narrower than NEAR tolerances, and supports that touch nothing. A duplicate or a frame is reported
    once, and left out of the other checks. `whole`: whether the blocks are all there are; otherwise gaps and floating
    blocks are not reported.
    """
    polygons = polygons_of(blocks)
    short = _too_short(blocks, tolerance)
    overlaps = find_overlaps(blocks, polygons, tolerance)
    faults = (*_too_thin(blocks, polygons, tolerance), *short, *overlaps.faults)
    if overlaps.cut_short or short or not whole:
        return Layout(faults)
    kept = np.flatnonzero(~overlaps.surplus)
    gaps = find_gaps(blocks, polygons, kept, tolerance, NEAR * tolerance)
    joints = _joints(blocks, kept, tolerance)
    held = np.concatenate([joints.blocks, overlaps.pairs])
    held = held[~overlaps.surplus[held].any(axis=1)]
    fixed = np.array([block.support is not None for block in blocks])
    body, floating = _bodies(held, fixed)
    if floating[body[kept]].all():
        text = "no block is a support; name one in the table of a layer: support = …"
        return Layout((*faults, Fault("floating", text)))
    parting = [gap for gap in gaps if floating[body[list(gap.pair)]].any()]
    others = [gap for gap in gaps if not floating[body[list(gap.pair)]].any()]
    apart, adrift = _bodies(np.concatenate([held, _pairs(parting)]), fixed)
    floats = _floating(blocks, kept[adrift[apart[kept]]], apart)
    falls = [_gap_fault(blocks, gap, body, floating, tolerance) for gap in parting]
    texts = [_gap_text(blocks, gap, tolerance) for gap in others]
    warnings = listed([message("{text}; if they should touch, draw them so", text=text) for text in texts])
    noticed = (
        *warnings,
        *_hint(blocks, polygons, kept, others),
        *_idle_supports(blocks, polygons, tolerance),
    )
    return Layout((*faults, *floats, *falls), noticed, "".join(_hint(blocks, polygons, kept, parting)))


def misfits(blocks: Sequence[Block], tolerance: float, reach: float) -> tuple[Index, Array]:
    """Return the pairs (p, 2) that overlap or face each other across at most `reach` (m), and by how much (p,), m.

    Less than the `tolerance` (m) is none, and what is drawn twice or is a frame is in none. Raises FaultyDrawingError
    where edges are too short beside the tolerance, or more blocks overlap than are looked for.
    """
    polygons = polygons_of(blocks)
    overlaps = find_overlaps(blocks, polygons, tolerance)
    if short := _too_short(blocks, reach / NEAR) or (overlaps.faults if overlaps.cut_short else []):
        raise FaultyDrawingError("", short)
    overlapping = overlaps.pairs[~overlaps.surplus[overlaps.pairs].any(axis=1)]
    depths = np.array([depth_of(polygons[i], polygons[j]) for i, j in overlapping.tolist()])
    gaps = find_gaps(blocks, polygons, np.flatnonzero(~overlaps.surplus), tolerance, reach)
    pairs = np.concatenate([overlapping, np.sort(_pairs(gaps), axis=1)])
    width = np.concatenate([depths, [gap.most for gap in gaps]])
    order = np.argsort(-width, kind="stable")  # of a pair that does both the larger one
    pairs, first = np.unique(pairs[order], axis=0, return_index=True)
    width = width[order][first]
    return pairs[width <= reach], width[width <= reach]


def touching(blocks: Sequence[Block], tolerance: float) -> set[tuple[int, int]]:
    """Return the pairs of blocks that have a joint."""
    return set(map(tuple, find_joints(blocks, tolerance).blocks.tolist()))


def _too_thin(blocks: Sequence[Block], polygons: Polygons, tolerance: float) -> list[Fault]:
    return [
        Fault(
            "thin",
            f"{name_of(blocks, i)} at {place_of(blocks[i].centroid)} is nowhere wider than the joint tolerance of "
            f"{tolerance:.3g} m; remove it, or lower the tolerance",
            blocks[i].centroid[None],
            (blocks[i].polygon,),
        )
        for i in np.flatnonzero(shapely.is_empty(eroded(polygons, tolerance))).tolist()
    ]


def _too_short(blocks: Sequence[Block], tolerance: float) -> list[Fault]:
    """Refuse edges so short beside the tolerance that most pairs of them would be within it."""
    start, end, _ = ring_edges([b.polygon for b in blocks])
    edges = np.hypot(*(end - start).T)
    near = float((2.0 * NEAR * tolerance / edges).sum())
    if near <= MOST_NEIGHBOURS:
        return []
    text = (
        f"with a joint tolerance of {tolerance:.3g} m some {near:.2g} pairs of edges are near each other, at most "
        f"{MOST_NEIGHBOURS:.2g}: it is too large for edges of {np.median(edges):.3g} m; write a smaller "
        "geometry.tolerance_m, or draw curves with fewer vertices"
    )
    return [Fault("short", text)]


def _joints(blocks: Sequence[Block], kept: Index, tolerance: float) -> Joints:
    """Return the joints between the blocks `kept` (k,), with their numbers among all blocks."""
    joints = find_joints([blocks[i] for i in kept], tolerance)
    return replace(joints, a=kept[joints.a], b=kept[joints.b])


def _bodies(pairs: Index, fixed: Mask) -> tuple[Index, Mask]:
    """Return the body (b,) of connected blocks each block belongs to, and which bodies have no support."""
    body = connected(pairs, len(fixed))
    floating = np.ones(body.max() + 1, dtype=bool)
    floating[body[fixed]] = False
    return body, floating


def _floating(blocks: Sequence[Block], adrift: Index, body: Index) -> list[Fault]:
    """Return a fault for each body of the blocks `adrift`."""
    faults = []
    order = adrift[np.argsort(body[adrift], kind="stable")]
    for members in np.split(order, np.flatnonzero(np.diff(body[order])) + 1):
        if not len(members):
            continue
        first = blocks[members[0]]
        block = f"{name_of(blocks, members[0])} at {place_of(first.centroid)}"
        text = (
            f"{block} touches nothing; move it to the block it should rest on, or delete it"
            if len(members) == 1
            else f"{block} and {len(members) - 1} more touch one another but nothing that leads to a support; "
            "move them to what they should rest on"
        )
        rings = tuple(blocks[i].polygon for i in members)
        faults.append(Fault("floating", text, first.centroid[None], rings))
    return faults


def find_gaps(
    blocks: Sequence[Block], polygons: Polygons, kept: Index, tolerance: float, reach: float
) -> list[Gap]:
    """Return the gaps of at most `reach` (m) with nothing between, those between the same blocks as one."""
    facing = _joints(blocks, kept, reach)
    pair, apart = facing.blocks, np.maximum(facing.gap, 0.0)
    middle = facing.ends.mean(axis=1)
    midway = shapely.STRtree(shapely.points(middle))
    k, at = midway.query(polygons[kept], predicate="dwithin", distance=tolerance)
    between = at[(kept[k] != pair[at, 0]) & (kept[k] != pair[at, 1])]
    open_ = apart.max(axis=1, initial=0.0) > tolerance
    open_[between] = False
    stretches = np.flatnonzero(open_)
    stretches = stretches[np.lexsort((-apart[stretches].max(axis=1, initial=0.0), *pair[stretches].T[::-1]))]
    pairs, first = np.unique(pair[stretches], axis=0, return_index=True)
    groups = np.split(stretches, first[1:]) if len(first) else []
    found = []
    for (a, b), group in zip(pairs.tolist(), groups, strict=True):
        least, most = float(apart[group].min()), float(apart[group].max())
        found.append(Gap((a, b), least, most, middle[group[0]], facing.ends[group]))
    return found


def _gap_fault(blocks: Sequence[Block], gap: Gap, body: Index, floating: Mask, tolerance: float) -> Fault:
    """Return a gap that separates blocks from every support."""
    pair = np.array(gap.pair)
    hanging = pair[floating[body[pair]]][0]
    more = np.bincount(body)[body[hanging]] - 1
    hangs = f"block {hanging} and {more} more hang" if more else f"block {hanging} hangs"
    text = f"{_gap_text(blocks, gap, tolerance)}, and {hangs} in the air; draw them so that they touch"
    fits = can_fit(blocks, gap.pair, gap.most, tolerance)
    return Fault("gap", text, gap.place[None], tuple(gap.stretches), "fit" if fits else "")


def _gap_text(blocks: Sequence[Block], gap: Gap, tolerance: float) -> Message:
    width: Message | float = gap.most
    if gap.most - gap.least >= 0.01 * gap.most:
        width = message("{low:.3g} to {high:.3g}", low=gap.least, high=gap.most)
    return message(
        "{block} and {other} face each other at {where} across {width:.3g} m, more than the joint tolerance of "
        "{tolerance:.3g} m: no joint", block=name_of(blocks, gap.pair[0]), other=name_of(blocks, gap.pair[1]),
        where=place_of(gap.place), width=width, tolerance=tolerance,
    )  # fmt: skip


def _hint(blocks: Sequence[Block], polygons: Polygons, kept: Index, gaps: Sequence[Gap]) -> list[Message]:
    """Return the tolerance with which every gap is a joint and no block too thin, if there is one, and a gap."""
    if not gaps:
        return []
    widest = max(gap.most for gap in gaps)
    wider = _wider(widest)
    joints = _joints(blocks, kept, wider)
    joined = {*map(tuple, np.sort(joints.blocks).tolist())}
    asked = {tuple(sorted(gap.pair)) for gap in gaps}
    if shapely.is_empty(eroded(polygons[kept], wider)).any() or not asked <= joined:
        return []
    closes = message(
        "gaps of up to {width:.3g} mm: geometry.tolerance_m = {wider} closes all of them",
        width=1e3 * widest, wider=f"{wider:g}",
    )  # fmt: skip
    return [closes]


def _wider(width: float) -> float:
    """Return the tolerance (m) to propose where blocks overlap by so much, or leave such a gap, m: one digit of it."""
    unit = 10.0 ** math.floor(math.log10(ROOM * width))
    return math.ceil(ROOM * width / unit - 1e-9) * unit


def _idle_supports(blocks: Sequence[Block], polygons: Polygons, tolerance: float) -> list[Message]:
    i, j = shapely.STRtree(polygons).query(polygons, predicate="dwithin", distance=tolerance)
    alone = np.setdiff1d(np.flatnonzero([b.support is not None for b in blocks]), i[i != j]).tolist()
    told = (
        message("{block} at {where} is a support and touches nothing", block=name_of(blocks, k),
                where=place_of(blocks[k].centroid)) for k in alone
    )  # fmt: skip
    return listed(list(told))


@dataclass(frozen=True, eq=False)
class Overlaps:
    """Pairs (p, 2) of blocks that overlap; `surplus` (b,): copies, and frames around others.

    `cut_short`: there are more pairs than are looked for.
    """

    faults: list[Fault]
    pairs: Index
    surplus: Mask
    cut_short: bool


def find_overlaps(blocks: Sequence[Block], polygons: Polygons, tolerance: float) -> Overlaps:
    """Find the blocks that overlap by more than the tolerance (m), no more than MOST_OVERLAPS pairs of them."""
    most = MOST_OVERLAPS[0] + MOST_OVERLAPS[1] * len(blocks)
    pairs, cut_short = _overlapping(blocks, polygons, tolerance, most)
    surplus = np.zeros(len(blocks), dtype=bool)
    faults = [*_copies(blocks, polygons, pairs, tolerance, surplus)]
    faults += _overlap_faults(blocks, polygons, pairs[~surplus[pairs].any(axis=1)], tolerance, surplus)
    if cut_short:
        text = f"more than {most} pairs of blocks overlap, and no more were looked for; mend these first"
        faults.append(Fault("overlap", text))
    return Overlaps(faults, pairs, surplus, cut_short)


def _overlapping(
    blocks: Sequence[Block], polygons: Polygons, tolerance: float, most: int
) -> tuple[Index, bool]:
    """Return the pairs (p, 2) of blocks that overlap, in order, and whether there are more than the `most`."""
    corners, _, owner = ring_edges([b.polygon for b in blocks])
    vertices = shapely.points(corners)
    rims = shapely.boundary(polygons)
    for prepared in (polygons, rims):
        shapely.prepare(prepared)
    cores = eroded(polygons, tolerance)
    core_tree, vertex_tree = shapely.STRtree(cores), shapely.STRtree(vertices)
    found = np.empty((0, 2), dtype=np.intp)
    for first in range(0, len(blocks), CHUNK):
        chosen = slice(first, first + CHUNK)
        i, j = core_tree.query(cores[chosen], predicate="intersects")
        k, v = vertex_tree.query(polygons[chosen])
        k, v = (k + first)[owner[v] != k + first], v[owner[v] != k + first]
        # the rim first: whether a point lies inside takes all edges at its height, of rough edges as many as there are
        deep = ~shapely.dwithin(rims[k], vertices[v], tolerance)
        deep[deep] = shapely.contains(polygons[k[deep]], vertices[v[deep]])
        near = np.concatenate([np.stack([i + first, j], 1), np.stack([owner[v], k], 1)[deep]])
        near = np.sort(near[near[:, 0] != near[:, 1]], axis=1)
        found = np.unique(np.concatenate([found, near]), axis=0) if len(near) else found
        if len(found) > most:
            return found[:most], True
    return found, False


def _copies(
    blocks: Sequence[Block], polygons: Polygons, pairs: Index, tolerance: float, surplus: Mask
) -> Iterator[Fault]:
    """Yield outlines drawn more than once, to be deleted where their role is the same; mark these as surplus."""
    bounds, rims = shapely.bounds(polygons), shapely.boundary(polygons)
    shapely.prepare(rims)

    def within(a: int, b: int) -> bool:
        return bool(shapely.dwithin(rims[a], shapely.points(blocks[b].polygon), tolerance).all())

    alike = (abs(bounds[pairs[:, 0]] - bounds[pairs[:, 1]]) <= tolerance).all(axis=1)
    copies: dict[int, list[int]] = defaultdict(list)
    for i, j in pairs[alike].tolist():
        if not surplus[i] and not surplus[j] and within(i, j) and within(j, i):
            copies[i].append(j)
            surplus[j] = True
    for i, found in copies.items():
        where = shapely.get_coordinates(shapely.point_on_surface(polygons[i]))
        others = " and ".join(name_of(blocks, j) for j in found[:2])
        more = f" and {len(found) - 2} more" if len(found) > 2 else ""
        times = "twice" if len(found) == 1 else f"{len(found) + 1} times"
        text = (
            f"{name_of(blocks, i)} and {others}{more} are the same outline drawn {times}, "
            f"at {place_of(where[0])}; keep one"
        )
        same = [j for j in found if _role(blocks[j]) == _role(blocks[i])]
        gone = tuple(handle for j in same if can_change(handle := blocks[j].handle))
        yield Fault(
            "twice", text, where, (blocks[i].polygon,), "delete" if gone else "", (blocks[i].handle, *gone)
        )


def _role(block: Block) -> tuple[object, ...]:
    """Return all that a block is, but for its place."""
    return (
        block.material, block.depth, block.support, block.vertical_load, block.load_has_mass, block.segments,
    )  # fmt: skip


def _overlap_faults(
    blocks: Sequence[Block], polygons: Polygons, pairs: Index, tolerance: float, surplus: Mask
) -> Iterator[Fault]:
    """Yield blocks that overlap MANY others, frames among them, marked as surplus, then the remaining pairs."""
    partners: dict[int, set[int]] = defaultdict(set)
    for i, j in pairs.tolist():
        partners[i].add(j)
        partners[j].add(i)
    for i in sorted(partners, key=lambda each: (-len(partners[each]), each)):
        if len(others := sorted(partners[i])) < MANY:  # the others have been told meanwhile
            continue
        for j in others:
            partners[j].discard(i)
        partners[i].clear()
        surplus[i] = bool(shapely.contains_properly(polygons[i], polygons[others]).all())
        some = ", ".join(str(j) for j in others[:3]) + (", …" if len(others) > 3 else "")
        if surplus[i]:
            corner = blocks[i].polygon[:1]
            text = (
                f"{name_of(blocks, i)} at {place_of(corner[0])} encloses {len(others)} other blocks ({some}); "
                "if it is a frame freeze its layer, or write ignore = true for it, else delete it"
            )
            yield Fault("frame", text, corner, (np.concatenate([blocks[i].polygon, corner]),))
            continue
        common, where = _common(polygons[i], shapely.union_all(polygons[others]))
        width = max(depth_of(polygons[i], polygons[j]) for j in others)
        mend = _mend("its outline", width, polygons[[i, *others]], tolerance)
        text = f"{name_of(blocks, i)} around {place_of(where[0])} overlaps {len(others)} other blocks"
        yield Fault("overlap", f"{text} ({some}){mend}", where, _rings(common))
    for i, j in sorted((i, j) for i, others in partners.items() for j in others if i < j):
        (common, where), width = _common(polygons[i], polygons[j]), depth_of(polygons[i], polygons[j])
        text = (
            f"{name_of(blocks, i)} and {name_of(blocks, j)} overlap by {common.area:.3g} m² "
            f"around {place_of(where[0])}{_mend('their outlines', width, polygons[[i, j]], tolerance)}"
        )
        fits = can_fit(blocks, (i, j), width, tolerance)
        yield Fault("overlap", text, where, _rings(common), "fit" if fits else "")


def _mend(what: str, width: float, polygons: Polygons, tolerance: float) -> str:
    """Return what to do about blocks that overlap by a width, m: a little of it may be the chords of a shared arc."""
    arc = f", or write geometry.tolerance_m = {_wider(width):g} if one arc is divided at different points"
    little = width <= max(NEAR * tolerance, 0.5 * SAGITTA * float(shapely.length(polygons).max()))
    return f"; correct {what}{arc if little else ''}"


def can_fit(blocks: Sequence[Block], pair: Sequence[int], width: float, tolerance: float) -> bool:
    """Whether a repair may make two blocks meet that overlap by, or leave a gap of, so much, m."""
    return width <= NEAR * tolerance and any(can_change(blocks[i].handle) for i in pair)


def depth_of(one: shapely.Polygon, other: shapely.Polygon) -> float:
    """Return how far two polygons overlap, m: how deep a vertex lies in the other one, or how wide their common is."""
    common, _ = _common(one, other)
    deepest = 2.0 * float(common.area) / max(float(common.length), 1e-300)
    for outer, inner in ((one, other), (other, one)):
        corners = shapely.points(shapely.get_coordinates(inner))
        inside = corners[shapely.contains(outer, corners)]
        deepest = max(deepest, float(shapely.distance(outer.boundary, inside).max(initial=0.0)))
    return deepest


def _common(one: shapely.Geometry, other: shapely.Geometry) -> tuple[shapely.Geometry, Array]:
    """Return the area that two outlines share, and a point (1, 2) in it, m.

    On a grid about a corner: of outlines with nearly the same edges a plain overlay may return a whole one, or nothing.
    """
    bounds = shapely.bounds(one)
    corner, width = bounds[:2], float(np.ptp(bounds[[0, 2]]))
    near = [shapely.transform(each, lambda points: points - corner) for each in (one, other)]
    common = shapely.intersection(*near, grid_size=GRID * width)
    if common.is_empty:  # shallower than the grid
        common = shapely.intersection(*near)
    common = shapely.transform(common, lambda points: points + corner)
    return common, shapely.get_coordinates(shapely.point_on_surface(common))


def _rings(area: shapely.Geometry) -> tuple[Array, ...]:
    parts = shapely.get_parts(area)
    rings = shapely.get_exterior_ring(parts[shapely.get_type_id(parts) == shapely.GeometryType.POLYGON])
    return tuple(shapely.get_coordinates(ring) for ring in rings)


def eroded(polygons: Polygons, tolerance: float) -> Polygons:
    """Take a rim of half the tolerance off: what two eroded polygons share is their common area, eroded."""
    return shapely.buffer(polygons, -0.5 * tolerance)


def name_of(blocks: Sequence[Block], index: int) -> Message:
    """Return number, layer and handle of a block, for a message."""
    block = blocks[index]
    origin = [f'layer "{block.layer}"'] * bool(block.layer) + [f"handle {block.handle}"] * bool(block.handle)
    if not origin:
        return message("block {number}", number=index)
    return message("block {number} ({where})", number=index, where=", ".join(origin))


def place_of(point: Array) -> str:
    """Return a point (2,) m as text, for a message."""
    x, z = np.round(point, 9) + 0.0  # no −0, no rounding's remains
    digits = max(6, len(str(int(abs(np.asarray(point)).max()))) + 4)  # 0.1 mm, far from the origin too
    return f"({x:.{digits}g}, {z:.{digits}g}) m"
