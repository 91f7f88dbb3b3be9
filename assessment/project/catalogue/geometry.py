"""Parametric geometry of the built-in templates: closed polygons (n, 2) in m, by drawing layer.

Everything is symmetric about x = 0 unless stated otherwise, z = 0 at the foot of the masonry. Edges are
straight: a ring is bounded by chords between its radial joints, so neighbours share their boundaries exactly.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from shapely import intersection
from shapely.geometry import Polygon
from shapely.ops import unary_union

Array = NDArray[np.float64]
Layout = dict[str, list[Array]]

THINNEST = 0.06  # m; a cut block thinner than this is joined to its neighbour
DECIMALS = 12  # of coordinates in m: shared vertices become identical


@dataclass(frozen=True)
class Ring:
    """Circular arch of equal voussoirs: clear span and rise of the intrados, thickness, springing level (m).

    Raises ValueError for a rise above half the span (a horseshoe has no springing ledge here).
    """

    span: float
    rise: float
    thickness: float
    voussoirs: int
    springing: float = 0.0

    def __post_init__(self) -> None:
        if self.rise > 0.5 * self.span * (1.0 + 1e-9):
            raise ValueError(f"rise_m: {self.rise:g} is more than half of span_m ({self.span:g}); lower it")

    @property
    def radius(self) -> float:
        """Radius of the intrados, m."""
        return (0.25 * self.span**2 + self.rise**2) / (2.0 * self.rise)

    @property
    def half_angle(self) -> float:
        """Half of the angle of embrace, rad."""
        return 2.0 * float(np.arctan2(2.0 * self.rise, self.span))

    def joints(self, offset: float) -> Array:
        """Return the ends (voussoirs + 1, 2) of the radial joints at radius + offset, left to right."""
        angle = np.linspace(-self.half_angle, self.half_angle, self.voussoirs + 1)
        centre = self.springing + self.rise - self.radius
        r = self.radius + offset
        return np.column_stack([r * np.sin(angle), centre + r * np.cos(angle)])

    def blocks(self) -> list[Array]:
        """Return the voussoirs, each (4, 2) m, from left to right."""
        inner, outer = self.joints(0.0), self.joints(self.thickness)
        return [np.array([inner[k], inner[k + 1], outer[k + 1], outer[k]]) for k in range(self.voussoirs)]

    def springer(self, width: float, bottom: float) -> Array:
        """Return the right-hand block (5, 2), m, below the ring; its inner face is flush with the intrados.

        `width` (m); `bottom` (m): level of its foot. Raises ValueError for a ring whose foot is wider than the block.
        """
        (xi, zi), (xe, ze) = self.joints(0.0)[-1], self.joints(self.thickness)[-1]
        if xe - xi > width + 1e-9:
            raise ValueError(f"thickness: the ring's foot is {xe - xi:.3g} m wide, its support {width:g} m")
        return np.array([(xi, bottom), (xi + width, bottom), (xi + width, ze), (xe, ze), (xi, zi)])


def rectangle(x0: float, x1: float, z0: float, z1: float) -> Array:
    """Return a rectangle (4, 2), m, anticlockwise."""
    return np.array([(x0, z0), (x1, z0), (x1, z1), (x0, z1)])


def course(x0: float, x1: float, z0: float, z1: float, *, blocks: int, shifted: bool) -> list[Array]:
    """Return a course of equal blocks, each (4, 2) m; a shifted one begins and ends with half a block."""
    cuts = np.linspace(x0, x1, 2 * blocks + 1)
    cuts = np.concatenate([cuts[:1], cuts[1::2], cuts[-1:]]) if shifted else cuts[::2]
    return [rectangle(a, b, z0, z1) for a, b in pairwise(cuts)]


def running_bond(x0: float, x1: float, levels: Array, blocks: int) -> list[Array]:
    """Return courses of blocks (4, 2) m between the levels (k,) m, every second one shifted by half a block."""
    return [
        block
        for k, (z0, z1) in enumerate(pairwise(levels))
        for block in course(x0, x1, z0, z1, blocks=blocks, shifted=k % 2 == 1)
    ]


def fitted(cells: Iterable[Array], region: Polygon) -> list[Array]:
    """Return the cells (n, 2) m cut to a region without gap or overlap; slivers are joined to a neighbour.

    Symmetric cells in a symmetric region stay symmetric: of neighbours that share equally much with a sliver
    the one nearer the axis takes it, or both where it stands on the axis itself.
    """
    # of a cell that only touches the region a plain overlay may give the whole: one on a grid does not
    inside = [each for each in map(Polygon, cells) if intersection(each, region, grid_size=1e-9).area > 1e-9]
    cut = [each.intersection(region) for each in inside]
    pieces = [part for c in cut for part in getattr(c, "geoms", [c]) if part.area > 1e-9]
    while len(pieces) > 1 and (slivers := [piece for piece in pieces if _is_sliver(piece)]):
        sliver = min(slivers, key=lambda piece: (round(piece.area, 9), _off_axis(piece)))
        others = [piece for piece in pieces if piece is not sliver]
        bond = [(round(other.intersection(sliver).length, 9), -_off_axis(other)) for other in others]
        joined = [other for other, each in zip(others, bond, strict=True) if each == max(bond)]
        pieces = [other for other in others if other not in joined] + [unary_union([sliver, *joined])]
    return [np.array(piece.exterior.coords[:-1]) for piece in pieces]


def mirrored(blocks: Iterable[Array]) -> list[Array]:
    """Return the mirror images of polygons (n, 2) about x = 0, anticlockwise as before."""
    return [(block * (-1.0, 1.0))[::-1] for block in blocks]


def block(*, width_m: float, height_m: float) -> Layout:
    """Return one block on a wider base."""
    half, base = 0.5 * width_m, 0.5 * width_m
    return tidied(
        BASE=[rectangle(-half - base, half + base, -base, 0.0)],
        BLOCCO=[rectangle(-half, half, 0.0, height_m)],
    )


def wall(
    *, block_length_m: float, block_height_m: float, blocks: int, courses: int, moving_blocks: int
) -> Layout:
    """Return a running-bond wall from x = 0 on two bases, the right one under the last `moving_blocks`.

    Raises ValueError if no block is left on the other base.
    """
    if moving_blocks >= blocks:
        raise ValueError(f"moving_blocks: must be fewer than blocks ({blocks}), is {moving_blocks}")
    length, split = blocks * block_length_m, (blocks - moving_blocks) * block_length_m
    levels = np.linspace(0.0, courses * block_height_m, courses + 1)
    return tidied(
        BASE_SINISTRA=[rectangle(-block_length_m, split, -block_height_m, 0.0)],
        BASE_DESTRA=[rectangle(split, length + block_length_m, -block_height_m, 0.0)],
        PARETE=running_bond(0.0, length, levels, blocks),
    )


def arch(*, span_m: float, rise_m: float, thickness_m: float, voussoirs: int) -> Layout:
    """Return a voussoir arch on two springer supports. Raises ValueError as Ring."""
    ring = Ring(span_m, rise_m, thickness_m, voussoirs)
    springer = ring.springer(thickness_m, -thickness_m)
    return tidied(BASE_SINISTRA=mirrored([springer]), BASE_DESTRA=[springer], ARCO=ring.blocks())


def buttressed_arch(
    *,
    span_m: float,
    rise_m: float,
    thickness_m: float,
    voussoirs: int,
    pier_width_m: float,
    pier_height_m: float,
    blocks_per_pier: int,
) -> Layout:
    """Return a voussoir arch on two piers, stacks of blocks on a base; the top block is cut to the arch's foot."""
    ring = Ring(span_m, rise_m, thickness_m, voussoirs, springing=pier_height_m)
    levels = np.linspace(0.0, pier_height_m, blocks_per_pier + 1)
    inner, outer = 0.5 * span_m, 0.5 * span_m + pier_width_m
    pier = [rectangle(inner, outer, a, b) for a, b in pairwise(levels[:-1])]
    pier.append(ring.springer(pier_width_m, float(levels[-2])))
    base = base_below(inner, outer)
    return tidied(
        BASE_SINISTRA=mirrored([base]),
        BASE_DESTRA=[base],
        PIEDRITTI=mirrored(pier) + pier,
        ARCO=ring.blocks(),
    )


def base_below(inner: float, outer: float) -> Array:
    """Return a base block (4, 2), m, a quarter of the pier wider on either side: a toe that slides stays on it."""
    margin = 0.25 * (outer - inner)
    return rectangle(inner - margin, outer + margin, -2.0 * margin, 0.0)


def _is_sliver(piece: Polygon) -> bool:
    """Whether no circle of the least thickness fits in."""
    return bool(piece.buffer(-0.5 * THINNEST).is_empty)


def _off_axis(piece: Polygon) -> float:
    return round(abs(float(piece.centroid.x)), 9)


def tidied(**layers: list[Array]) -> Layout:
    """Return the layers with every polygon rounded, anticlockwise, without repeated or collinear vertices."""
    return {layer: [_tidy(polygon) for polygon in polygons] for layer, polygons in layers.items()}


def _tidy(polygon: Array) -> Array:
    p: Array = polygon.round(DECIMALS) + 0.0
    p = p[np.hypot(*(p - np.roll(p, 1, axis=0)).T) > 1e-9]
    back, ahead = p - np.roll(p, 1, axis=0), np.roll(p, -1, axis=0) - p
    p = p[np.abs(back[:, 0] * ahead[:, 1] - back[:, 1] * ahead[:, 0]) > 1e-9]
    following = np.roll(p, -1, axis=0)
    clockwise = float((p[:, 0] * following[:, 1] - following[:, 0] * p[:, 1]).sum()) < 0.0
    return p[::-1] if clockwise else p
