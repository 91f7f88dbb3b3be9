"""Whether blocks make an assembly: what overlaps, floats or leaves a gap, each told once, with what would mend it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from mechanics.faults import Fault, FaultyDrawingError, listed
from mechanics.messages import Message, message
from mechanics.model.block import Block, Joints, find_joints
from mechanics.model.overlaps import (
    NEAR,
    Polygons,
    can_fit,
    depth_of,
    eroded,
    find_overlaps,
    name_of,
    place_of,
    polygons_of,
)
from mechanics.types import Array, Index, Mask

MOST_NEIGHBOURS = 2e7  # pairs of edges within NEAR tolerances of each other, as many as memory holds
ROOM = 1.5  # least ratio of a proposed tolerance to the widest gap


@dataclass(frozen=True, eq=False)
class Layout:
    """What is wrong (`faults`) or odd (`warnings`) with blocks; `hint`: the tolerance that would close every gap."""

    faults: tuple[Fault, ...]
    warnings: tuple[Message, ...] = ()
    hint: str = ""


@dataclass(frozen=True, eq=False)
class Gaps:
    """Pairs (g, 2) of blocks that face each other across `width` (g, 2: least, most) m, with nothing between.

    `places` (g, 2): the middle of the widest stretch; `stretches`: the ends (s, 2, 2) of all of them.
    """

    pairs: Index
    width: Array
    places: Array
    stretches: tuple[Array, ...]

    def take(self, chosen: Mask) -> Gaps:
        """Return the chosen (g,) ones."""
        stretches = tuple(s for s, taken in zip(self.stretches, chosen, strict=True) if taken)
        return Gaps(self.pairs[chosen], self.width[chosen], self.places[chosen], stretches)


def survey_layout(blocks: Sequence[Block], tolerance: float, whole: bool = True) -> Layout:
    """Find what keeps blocks from being an assembly, with the `tolerance` (m) with which its joints are found.

    Faults, with number, layer, handle and coordinates in m: blocks thinner than the tolerance; blocks drawn twice, or
    that overlap by more than the tolerance (a circle of that diameter fits into the common area, or a vertex lies
    that deep inside); movable blocks that no chain of joints connects to a support. Warnings: edges that face each
    other across more than the tolerance but less than NEAR tolerances, and supports that touch nothing.

    Each is told once: blocks that overlap count as touching; blocks that only a gap separates from a support are told
    by their gap; a copy, or a frame around others, is left out of what follows. `whole`: whether the blocks are all
    there are; otherwise gaps and floating blocks are not told.
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
    held = np.concatenate([np.stack([joints.a, joints.b], axis=1), overlaps.pairs])
    held = held[~overlaps.surplus[held].any(axis=1)]
    fixed = np.array([block.support is not None for block in blocks])
    body, floating = _bodies(held, fixed)
    if floating[body[kept]].all():
        text = "no block is a support; name one in the table of a layer: support = …"
        return Layout((*faults, Fault("floating", text)))
    parting = np.logical_or(*floating[body[gaps.pairs]].T)
    apart, adrift = _bodies(np.concatenate([held, gaps.pairs[parting]]), fixed)
    floats = _floating(blocks, kept[adrift[apart[kept]]], apart)
    falls = _gap_faults(blocks, gaps.take(parting), body, floating, tolerance)
    texts = _gap_texts(blocks, gaps.take(~parting), tolerance)
    warnings = listed([message("{text}; if they should touch, draw them so", text=text) for text in texts])
    hints = [_hint(blocks, polygons, kept, gaps.take(chosen)) for chosen in (parting, ~parting)]
    return Layout(
        (*faults, *floats, *falls),
        (*warnings, *filter(None, hints[1:]), *_idle_supports(blocks, polygons, tolerance)),
        hints[0] or "",
    )


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
    pairs = np.concatenate([overlapping, np.sort(gaps.pairs, axis=1)])
    width = np.concatenate([depths, gaps.width[:, 1]])
    order = np.argsort(-width, kind="stable")  # of a pair that does both the larger one
    pairs, first = np.unique(pairs[order], axis=0, return_index=True)
    width = width[order][first]
    return pairs[width <= reach], width[width <= reach]


def touching(blocks: Sequence[Block], tolerance: float) -> set[tuple[int, int]]:
    """Return the pairs of blocks that have a joint."""
    joints = find_joints(blocks, tolerance)
    return set(zip(joints.a.tolist(), joints.b.tolist(), strict=True))


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
    edges = np.concatenate([np.hypot(*(np.roll(b.polygon, -1, axis=0) - b.polygon).T) for b in blocks])
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
    n = len(fixed)
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    count, body = connected_components(graph, directed=False)
    floating = np.ones(count, dtype=bool)
    floating[body[fixed]] = False
    return np.asarray(body, dtype=np.intp), floating


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
) -> Gaps:
    """Return the gaps of at most `reach` (m) with nothing between, those between the same blocks as one."""
    facing = _joints(blocks, kept, reach)
    pair = np.stack([facing.a, facing.b], axis=1)
    apart = _apart(blocks, polygons, facing, 0.51 * reach)
    middle = facing.ends.mean(axis=1)
    midway = shapely.STRtree(shapely.points(middle))
    k, at = midway.query(polygons[kept], predicate="dwithin", distance=tolerance)
    between = at[(kept[k] != pair[at, 0]) & (kept[k] != pair[at, 1])]
    open_ = apart.max(axis=1, initial=0.0) > 1.001 * tolerance
    open_[between] = False
    stretches = np.flatnonzero(open_)
    stretches = stretches[np.lexsort((-apart[stretches].max(axis=1, initial=0.0), *pair[stretches].T[::-1]))]
    pairs, first = np.unique(pair[stretches], axis=0, return_index=True)
    groups = np.split(stretches, first[1:]) if len(first) else []
    return Gaps(
        pairs, np.array([(apart[group].min(), apart[group].max()) for group in groups]).reshape(-1, 2),
        middle[stretches[first]], tuple(facing.ends[group] for group in groups),
    )  # fmt: skip


def _apart(blocks: Sequence[Block], polygons: Polygons, facing: Joints, reach: float) -> Array:
    """Return how far facing blocks are apart (f, 2), m, at both ends of their stretch; `reach` (m) holds both."""
    side = np.stack([facing.a, facing.b], axis=1)  # (f, 2), beside (f, 2) ends
    place = np.repeat(facing.ends.reshape(-1, 2), 2, axis=0)  # of each end twice: (f · end · side, 2)
    of = np.repeat(side[:, None, :], 2, axis=1).ravel()
    points = shapely.points(place)
    start = np.concatenate([b.polygon for b in blocks])
    end = np.concatenate([np.roll(b.polygon, -1, axis=0) for b in blocks])
    owner = np.repeat(np.arange(len(blocks)), [len(b.polygon) for b in blocks])
    edges = shapely.STRtree(shapely.linestrings(np.stack([start, end], axis=1)))
    i, e = edges.query(points, predicate="dwithin", distance=reach)
    i, e = i[owner[e] == of[i]], e[owner[e] == of[i]]
    along = end[e] - start[e]
    share = np.clip(((place[i] - start[e]) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    distance = np.full(len(place), reach)
    np.minimum.at(distance, i, np.hypot(*(place[i] - start[e] - share[:, None] * along).T))
    k, inside = shapely.STRtree(points).query(polygons, predicate="contains")
    distance[inside[of[inside] == k]] = 0.0
    return distance.reshape(-1, 2, 2).sum(axis=2)


def _gap_faults(
    blocks: Sequence[Block], gaps: Gaps, body: Index, floating: Mask, tolerance: float
) -> list[Fault]:
    """Return the gaps that separate blocks from every support."""
    sizes = np.bincount(body)
    faults = []
    for k, text in enumerate(_gap_texts(blocks, gaps, tolerance)):
        pair = gaps.pairs[k]
        hanging = pair[floating[body[pair]]][0]
        more = sizes[body[hanging]] - 1
        hangs = f"block {hanging} and {more} more hang" if more else f"block {hanging} hangs"
        full = f"{text}, and {hangs} in the air; draw them so that they touch"
        fits = can_fit(blocks, pair, gaps.width[k, 1], tolerance)
        faults.append(
            Fault("gap", full, gaps.places[k][None], tuple(gaps.stretches[k]), "fit" if fits else "")
        )
    return faults


def _gap_texts(blocks: Sequence[Block], gaps: Gaps, tolerance: float) -> list[Message]:
    return [
        message(
            "{block} and {other} face each other at {where} across {width:.3g} m, more than the joint tolerance of "
            "{tolerance:.3g} m: no joint",
            block=name_of(blocks, a),
            other=name_of(blocks, b),
            where=place_of(place),
            width=high
            if high - low < 0.01 * high
            else message("{low:.3g} to {high:.3g}", low=low, high=high),
            tolerance=tolerance,
        )
        for (a, b), (low, high), place in zip(gaps.pairs.tolist(), gaps.width, gaps.places, strict=True)
    ]


def _hint(blocks: Sequence[Block], polygons: Polygons, kept: Index, gaps: Gaps) -> Message | None:
    """Return the tolerance with which every gap is a joint and no block too thin; None: there is none, or no gap."""
    if not len(gaps.pairs):
        return None
    widest = float(gaps.width.max())
    unit = 10.0 ** math.floor(math.log10(ROOM * widest))
    wider = math.ceil(ROOM * widest / unit - 1e-9) * unit
    joints = _joints(blocks, kept, wider)
    joined = {*map(tuple, np.sort(np.stack([joints.a, joints.b], axis=1)).tolist())}
    if shapely.is_empty(eroded(polygons[kept], wider)).any() or not joined.issuperset(
        map(tuple, np.sort(gaps.pairs).tolist())
    ):
        return None
    return message(
        "gaps of up to {width:.3g} mm: geometry.tolerance_m = {wider} closes all of them",
        width=1e3 * widest,
        wider=f"{wider:g}",
    )


def _idle_supports(blocks: Sequence[Block], polygons: Polygons, tolerance: float) -> list[Message]:
    i, j = shapely.STRtree(polygons).query(polygons, predicate="dwithin", distance=tolerance)
    alone = np.setdiff1d(np.flatnonzero([b.support is not None for b in blocks]), i[i != j]).tolist()
    return listed(
        [
            message(
                "{block} at {where} is a support and touches nothing",
                block=name_of(blocks, k),
                where=place_of(blocks[k].centroid),
            )
            for k in alone
        ]
    )
