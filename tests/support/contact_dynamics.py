"""Contact dynamics of rigid blocks: a referee that shares with the program the outlines of the blocks alone.

Non-smooth contact dynamics (Moreau 1988, Jean 1999): steps of fixed length at velocity level, no bounce, Signorini's
condition and Coulomb's law without dilation at the ends of every overlap of two edges, impulses by the method of Gauss
and Seidel. Blocks are free of gaps where they are drawn free of gaps.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from mechanics import Assembly, State
from mechanics.kernels.jit import compiler
from mechanics.types import GRAVITY, Array, Index

compiled = compiler()
REACH = 0.3  # of the mean block's size: edges farther apart never meet before a motion has been told
OVERLAP = 2e-3  # of the mean block's size: shorter overlaps are corners that pass each other
NEAR = 0.1  # of the mean block's size: a contact across a wider gap, or deeper, is none
SWEEPS = 200
SOLVED = 1e-7  # of the impulse of the mean block's weight: change of an impulse in the last sweep


@dataclass(frozen=True, eq=False)
class Bodies:
    """Blocks as the referee sees them.

    `drawn` (b, 3): centroid (m) and rotation; `mass` (b, 3), with zeros for what is held; `arms` (e, 2, 2): start and
    end of every edge, anticlockwise round its block, from the centroid, m; `owner` (e,); `pairs` (p, 2): edges that may
    meet; `friction` (p,); `size` (m): root of the mean block's area.
    """

    drawn: Array
    mass: Array
    arms: Array
    owner: Index
    pairs: Index
    friction: Array
    size: float

    @classmethod
    def of(cls, model: Assembly) -> Self:
        """Return the blocks of a model: weights without loads, the lesser friction of each pair."""
        drawn, mass, arms, owner = [], [], [], []
        for number, block in enumerate(model.blocks):
            ring = np.asarray(block.vertices, dtype=float)
            area, centre, polar = _moments(ring)
            density = block.material.unit_weight * block.depth / GRAVITY
            drawn.append([*centre, 0.0])
            mass.append(density * (block.support is None) * np.array([area, area, polar]))
            arms.extend(np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) - centre)
            owner.extend([number] * len(ring))
        edges, home = np.array(arms), np.array(owner)
        size = float(
            np.sqrt(np.mean([_moments(np.asarray(b.vertices))[0] for b in model.blocks if not b.support]))
        )
        pairs = _may_meet(
            edges + np.array(drawn)[home, None, :2], home, np.array(mass)[home, 0] > 0.0, REACH * size
        )
        mu = np.array([block.material.friction for block in model.blocks])
        friction = np.minimum(mu[home[pairs[:, 0]]], mu[home[pairs[:, 1]]])
        return cls(np.array(drawn), np.array(mass), edges, home, pairs, friction, size)


def _moments(ring: Array) -> tuple[float, Array, float]:
    """Return area, centroid and polar moment about it of a polygon (n, 2)."""
    from_first = ring - ring[0]
    after = np.roll(from_first, -1, axis=0)
    cross = from_first[:, 0] * after[:, 1] - after[:, 0] * from_first[:, 1]
    area = 0.5 * cross.sum()
    centre = (cross[:, None] * (from_first + after)).sum(axis=0) / (6.0 * area)
    squares = (from_first**2 + from_first * after + after**2).sum(axis=1)
    return area, ring[0] + centre, (cross * squares).sum() / 12.0 - area * (centre @ centre)


def _may_meet(edges: Array, owner: Index, moves: Array, reach: float) -> Index:
    """Return pairs (p, 2) of edges (e, 2, 2) of different blocks that look at each other from near."""
    along = edges[:, 1] - edges[:, 0]
    along /= np.hypot(*along.T)[:, None]
    found = []
    for one in range(len(edges)):
        for other in range(one):
            if owner[one] == owner[other] or not (moves[one] or moves[other]):
                continue
            s = (edges[[one, other]] - edges[one, 0]) @ along[one]
            away = (edges[other] - edges[one, 0]) @ np.array([along[one, 1], -along[one, 0]])
            meets = s[0].min() - reach < s[1].max() and s[1].min() - reach < s[0].max()
            if along[one] @ along[other] < -0.8 and meets and abs(away).min() < reach:
                found.append((one, other))
    return np.array(found, dtype=np.intp).reshape(-1, 2)


@compiled
def ends_of_overlap(
    x: Array, arms: Array, blocks: Index, pairs: Index, least: float, rows: Array, gaps: Array
) -> None:
    """Fill rows (c, 2, 2, 3), x, z, ω of the first and the second block, and gaps (c,), m, infinite where none is.

    A pair of edges has two contacts: at either end of the overlap the corner of one block is upon the other's edge.
    Rows of the normal, from the second block into the first, and of the tangent. `blocks` (p, 2) of the edges.
    """
    point, way, reach = np.empty((2, 2, 2)), np.empty((2, 2)), np.empty((2, 2))
    for p in range(len(pairs)):
        gaps[2 * p], gaps[2 * p + 1] = np.inf, np.inf
        for k in range(2):
            b = blocks[p, k]
            cos, sin = np.cos(x[b, 2]), np.sin(x[b, 2])
            for end in range(2):
                along, across = arms[pairs[p, k], end, 0], arms[pairs[p, k], end, 1]
                point[k, end, 0] = x[b, 0] + cos * along - sin * across
                point[k, end, 1] = x[b, 1] + sin * along + cos * across
            dx, dz = point[k, 1, 0] - point[k, 0, 0], point[k, 1, 1] - point[k, 0, 1]
            way[k, 0], way[k, 1] = dx / np.hypot(dx, dz), dz / np.hypot(dx, dz)
        mx, mz = way[0, 0] - way[1, 0], way[0, 1] - way[1, 1]
        for k in range(2):  # along the mean direction the first edge runs forward, the second back
            for end in range(2):
                reach[k, end] = (
                    mx * point[k, (end + k) % 2, 0] + mz * point[k, (end + k) % 2, 1]
                ) / np.hypot(mx, mz)
        if min(reach[0, 1], reach[1, 1]) - max(reach[0, 0], reach[1, 0]) < least:
            continue
        for end in range(2):
            # whose corner
            of = int(reach[1, 0] > reach[0, 0]) if end == 0 else int(reach[1, 1] < reach[0, 1])
            face, corner = 1 - of, (end + of) % 2
            out_x, out_z = way[face, 1], -way[face, 0]
            px, pz = point[of, corner, 0], point[of, corner, 1]
            gaps[2 * p + end] = out_x * (px - point[face, 0, 0]) + out_z * (pz - point[face, 0, 1])
            for k in range(2):
                sign = 1.0 if k == of else -1.0
                lx, lz = px - x[blocks[p, k], 0], pz - x[blocks[p, k], 1]
                for d in range(2):
                    nx, nz = (out_x, out_z) if d == 0 else (out_z, -out_x)
                    row = rows[2 * p + end, d, k]
                    row[0], row[1], row[2] = sign * nx, sign * nz, sign * (lx * nz - lz * nx)


@compiled
def sweep(
    v: Array, inverse: Array, blocks: Index, rows: Array, gaps: Array, step: float, friction: Array, impulses: Array,
    first: bool,
) -> float:  # fmt: skip
    """Correct the impulses (c, 2) of contacts one after the other, and v (b, 3); return the largest correction.

    A contact lets a normal velocity of −gap/step be. `first`: the impulses act as they are.
    """
    largest = 0.0
    for c in range(len(gaps)):
        if gaps[c] == np.inf:
            continue
        for d in range(2):
            u, compliance = 0.0, 0.0
            for k in range(2):
                b = blocks[c // 2, k]
                for r in range(3):
                    u += rows[c, d, k, r] * v[b, r]
                    compliance += rows[c, d, k, r] ** 2 * inverse[b, r]
            more = impulses[c, d]
            if not first:
                held = impulses[c, d] - u / compliance
                if d == 0:
                    held = max(held - max(gaps[c], 0.0) / (step * compliance), 0.0)
                else:
                    held = min(
                        max(held, -friction[c // 2] * impulses[c, 0]), friction[c // 2] * impulses[c, 0]
                    )
                more = held - impulses[c, d]
                impulses[c, d] = held
                largest = max(largest, abs(more))
            for k in range(2):
                b = blocks[c // 2, k]
                for r in range(3):
                    v[b, r] += inverse[b, r] * rows[c, d, k, r] * more
    return largest


@compiled
def march(
    x: Array, v: Array, inverse: Array, arms: Array, blocks: Index, pairs: Index, friction: Array, size: float,
    added: Array, step: float, solved: float, rows: Array, gaps: Array, impulses: Array, path: Array,
) -> None:  # fmt: skip
    """Fill the positions (k, b, 3) after each step, which adds velocities (k, 2), m/s, to what is not held."""
    for k in range(len(path)):
        for b in range(len(x)):
            for r in range(3):
                x[b, r] += 0.5 * step * v[b, r]
                if r < 2 and inverse[b, r] > 0.0:
                    v[b, r] += added[k, r]
        ends_of_overlap(x, arms, blocks, pairs, OVERLAP * size, rows, gaps)
        for c in range(len(gaps)):
            if abs(gaps[c]) > NEAR * size:
                gaps[c] = np.inf
                impulses[c, 0] = impulses[c, 1] = 0.0
        sweep(v, inverse, blocks, rows, gaps, step, friction, impulses, True)
        for _ in range(SWEEPS):
            if sweep(v, inverse, blocks, rows, gaps, step, friction, impulses, False) < solved:
                break
        for b in range(len(x)):
            for r in range(3):
                x[b, r] += 0.5 * step * v[b, r]
                path[k, b, r] = x[b, r]


def motion(model: Assembly, loads: Array, step: float, start: State | None = None) -> Array:
    """Return the positions (k, b, 3), m and rad, of a model that starts at rest, after every step.

    `start`: where, None: as drawn; `loads` (k,): horizontal body force of each step as a share of the weight.
    `step` in s.
    """
    of, path = Bodies.of(model), np.empty((len(loads), len(model.blocks), 3))
    contacts, moves = 2 * len(of.pairs), of.mass[:, 0] > 0.0
    moved = 0.0 if start is None else start.positions - model.initial.positions
    march(
        x=of.drawn + moved, v=np.zeros_like(of.drawn),
        inverse=np.divide(1.0, of.mass, out=np.zeros_like(of.mass), where=of.mass > 0.0), arms=of.arms,
        blocks=of.owner[of.pairs], pairs=of.pairs, friction=of.friction, size=of.size,
        added=step * GRAVITY * np.column_stack([loads, np.full(len(loads), -1.0)]), step=step,
        solved=SOLVED * step * GRAVITY * of.mass[moves, 0].mean(), rows=np.zeros((contacts, 2, 2, 3)),
        gaps=np.empty(contacts), impulses=np.zeros((contacts, 2)), path=path,
    )  # fmt: skip
    return path


def farthest(model: Assembly, alpha: float, time: float = 1.0, step: float = 2e-3) -> float:
    """Return how far a block goes or turns within `time` (s) under a load held at alpha g, of the mean block's size."""
    of = Bodies.of(model)
    moved = abs(motion(model, np.full(round(time / step), alpha), step) - of.drawn)
    return float((np.hypot(moved[..., 0], moved[..., 1]) / of.size + moved[..., 2]).max())
