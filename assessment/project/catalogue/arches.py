"""Templates of arches, vaults and arcades: masonry and project file as a function of dimensions."""

from dataclasses import dataclass, replace
from itertools import chain, pairwise
from typing import Annotated, Any

import numpy as np
from shapely.geometry import Polygon, box
from shapely.ops import unary_union

from assessment.project.catalogue import geometry
from assessment.project.catalogue.geometry import Array, Made, Ring


@dataclass(frozen=True)
class Piers:
    """Piers below the rings, each a stack of blocks, the top one cut to the ring's foot."""

    pier_width_m: Annotated[float, "width of a pier"]
    pier_height_m: Annotated[float, "height of a pier up to the springing"]
    blocks_per_pier: Annotated[int, "blocks of a pier"]


PAPER = Ring(0.54, 0.24, 0.055, 21), Piers(0.15, 0.55, 5)  # the model of the paper, 1:10


def arch(ring: Ring = Ring(3.0, 1.5, 0.3, 21)) -> Made:
    """Return a voussoir arch on two springer supports."""
    layout = geometry.tidied(
        **geometry.two_bases(ring.springer(ring.thickness_m, -ring.thickness_m)), ARCO=ring.blocks()
    )
    crown = max(float(polygon[:, 1].max()) for polygons in layout.values() for polygon in polygons)
    title, control = "Arco acuto" if ring.pointed else "Arco", {"chiave": (0.0, crown)}
    increment, moved = round(0.001 * ring.span_m, 6), geometry.outward(round(0.01 * ring.span_m, 6))
    stone = (20.0, 0.6, 1e6)
    return layout, geometry.project(title, 1.0, stone, geometry.TWO_SUPPORTS, control, increment, [moved])


def pointed_arch(ring: Ring = Ring(3.0, 2.4, 0.3, 20)) -> Made:
    """Return an arch of two centres: `arch` with a higher rise."""
    return arch(ring)


def buttressed_arch(ring: Ring = PAPER[0], piers: Piers = PAPER[1]) -> Made:
    """Return a voussoir arch on two piers, stacks of blocks on a base: the paper's model, 1:10, by default."""
    drawn = (replace(ring, voussoirs=21), replace(piers, blocks_per_pier=5)) == PAPER
    ring = replace(ring, springing=piers.pier_height_m)
    inner, outer = 0.5 * ring.span_m, 0.5 * ring.span_m + piers.pier_width_m
    pier = _pier(ring, piers.pier_width_m, piers.blocks_per_pier)
    bases = geometry.two_bases(geometry.base_below(inner, outer, inner))
    layout = geometry.tidied(**bases, PIEDRITTI=geometry.mirrored(pier) + pier, ARCO=ring.blocks())
    title, scale = "Arco su piedritti, modello 1:10" if drawn else "Arco su piedritti", ring.span_m / 0.54
    control = {"C1": (-outer, ring.springing), "C2": (outer, ring.springing)}
    increment, moved = round(0.0005 * scale, 7), geometry.outward(round(0.02 * scale, 3))
    depth, stone = round(0.1 * scale, 2), (11.5, 0.6, 1.2e5)
    return layout, geometry.project(title, depth, stone, geometry.TWO_SUPPORTS, control, increment, [moved])


def arcade(
    bays: Annotated[int, "arches side by side"] = 3,
    ring: Ring = Ring(2.4, 1.2, 0.3, 15),
    piers: Piers = Piers(0.8, 2.4, 5),
) -> Made:
    """Return equal arches side by side on piers, each pier on a support of its own."""
    width, height = piers.pier_width_m, piers.pier_height_m
    pitch = ring.span_m + width
    middles = pitch * (np.arange(bays) - 0.5 * (bays - 1))
    rings = [replace(ring, springing=height, middle=float(x)) for x in middles]
    last = _pier(rings[-1], width, piers.blocks_per_pier)
    levels = np.linspace(0.0, height, piers.blocks_per_pier + 1)
    stacks = [geometry.mirrored(last)]
    for left, right in pairwise(rings):
        (x0, z0), (x1, z1) = left.foot(0.5 * width)
        x2, x3 = 2.0 * right.middle - (x1 + pitch), 2.0 * right.middle - (x0 + pitch)  # the mirrored foot
        top = np.array([(x0, levels[-2]), (x3, levels[-2]), (x3, z0), (x2, z1), (x1, z1), (x0, z0)])
        stacks.append([*geometry.stack(x0, x3, levels[:-1]), top])
    stacks.append(last)
    names = ["BASE_SINISTRA", *(f"BASE_CENTRALE_{k}" for k in range(1, bays)), "BASE_DESTRA"]
    supports = ["sinistro", *(f"centrale {k}" for k in range(1, bays)), "destro"]
    outer = float(last[0][:, 0].max())
    left_ends = -outer + pitch * np.arange(bays + 1)
    below = [[geometry.base_below(x, x + width, 0.5 * ring.span_m)] for x in left_ends]
    bases = dict(zip(names, below, strict=True))
    masonry, arches = [*chain(*stacks)], [*chain(*(each.blocks() for each in rings))]
    layout = geometry.tidied(**bases, PIEDRITTI=masonry, ARCHI=arches)
    tables = {name: {"support": support} for name, support in zip(bases, supports, strict=True)}
    control = {"C1": (-outer, height), "C2": (outer, height)}
    increment, moved = round(0.001 * ring.span_m, 6), geometry.outward(round(0.01 * ring.span_m, 6))
    title, stone = f"Arcata di {bays} campate", (20.0, 0.6, 1e6)
    return layout, geometry.project(title, 0.6, stone, tables, control, increment, [moved])


def barrel_vault(
    ring: Ring = Ring(4.0, 1.2, 0.25, 21),
    wall_width_m: Annotated[float, "thickness of a wall below the vault"] = 1.2,
    wall_height_m: Annotated[float, "height of a wall up to the springing"] = 2.5,
    blocks_per_wall: Annotated[int, "blocks of a wall, one on the other"] = 6,
    cover_m: Annotated[float, "height of the fill above the crown's extrados"] = 0.1,
    fill_kN_m3: Annotated[float, "unit weight of the fill"] = 16.0,
) -> Made:
    """Return a strip, 1 m deep, of a vault between walls with a fill up to one level, which loads what is below it."""
    ring = replace(ring, springing=wall_height_m)
    wall = _pier(ring, wall_width_m, blocks_per_wall)
    inner, outer = 0.5 * ring.span_m, 0.5 * ring.span_m + wall_width_m
    extrados = ring.joints(ring.thickness_m)
    top = float(extrados[:, 1].max()) + cover_m
    above = np.diff(extrados[:, 0]) * (top - 0.5 * (extrados[:-1, 1] + extrados[1:, 1]))
    beside = (outer - extrados[-1, 0]) * (top - extrados[-1, 1])
    place = np.arange(ring.voussoirs)
    number = np.minimum(place, place[::-1]) + 1  # the same on either side
    blocks = ring.blocks()
    layers = {
        f"VOLTA_{k:02d}": [block for block, own in zip(blocks, number, strict=True) if own == k]
        for k in range(1, int(number.max()) + 1)
    }
    layout = geometry.tidied(
        **geometry.two_bases(geometry.base_below(inner, outer, inner)), MURI=geometry.mirrored(wall[:-1]) + wall[:-1],
        IMPOSTE=geometry.mirrored(wall[-1:]) + wall[-1:], **layers,
    )  # fmt: skip
    areas = {"IMPOSTE": beside} | {f"VOLTA_{own:02d}": area for own, area in zip(number, above, strict=True)}
    loads = {name: {"vertical_load_kN": round(fill_kN_m3 * float(area), 6)} for name, area in areas.items()}
    control = {"C1": (-outer, wall_height_m), "C2": (outer, wall_height_m)}
    increment, moved = round(0.001 * ring.span_m, 6), geometry.outward(round(0.005 * ring.span_m, 6))
    title, stone, tables = "Volta a botte con rinfianco", (18.0, 0.6, 1e6), geometry.TWO_SUPPORTS | loads
    return layout, geometry.project(title, 1.0, stone, tables, control, increment, [moved])


def triumphal_arch(
    ring: Ring = Ring(9.2, 3.48, 0.2, 27),
    springing_m: Annotated[float, "height of the springing above the bases"] = 5.4,
    height_m: Annotated[float, "height of the nave walls"] = 9.3,
    wall_thickness_m: Annotated[float, "thickness of the nave walls below the springing"] = 1.215,
    course_height_m: Annotated[float, "height of the courses, adapted to whole numbers of them"] = 0.3,
    wall_blocks: Annotated[int, "blocks across a nave wall"] = 3,
    spandrel_blocks: Annotated[int, "blocks along a course of the arch wall between the nave walls"] = 24,
    beams: Annotated[int, "roof beams on the top course"] = 8,
    beam_side_m: Annotated[float, "side of a roof beam"] = 0.2,
) -> Made:
    """Return the triumphal arch between two nave walls seen in section (paper, §7), roof beams on top.

    Above the springing the nave walls are set back by the ring's foot; spandrels are running bond cut to its extrados.
    By default α0 and d_0 as drawn are near the paper's. Raises ValueError for a ring higher than the walls.
    """
    crown = springing_m + ring.rise_m + ring.thickness_m
    if crown + geometry.THINNEST > height_m:
        raise ValueError(f"height_m: must be above the ring's crown at {crown:.3g} m, is {height_m:g}")
    ring = replace(ring, springing=springing_m)
    inner, outer = 0.5 * ring.span_m, 0.5 * ring.span_m + wall_thickness_m
    lower = geometry.courses(0.0, springing_m, course_height_m)
    upper = geometry.courses(springing_m, height_m, course_height_m)
    foot = ring.springer(wall_thickness_m, 0.0)
    face, ledge = float(foot[3, 0]), foot[3, 1]
    skewback = int((upper < ledge - 1e-9).sum())
    below = geometry.running_bond(inner, outer, np.append(lower, upper[1 : skewback + 1]), wall_blocks)
    cut = geometry.fitted(below, unary_union([Polygon(foot), box(face, 0.0, outer, height_m)]))
    across = max(1, round(wall_blocks * (outer - face) / wall_thickness_m))
    nave = cut + geometry.running_bond(face, outer, upper[skewback:], across)
    under = Polygon(np.vstack([[(-face, 0.0)], ring.joints(ring.thickness_m), [(face, 0.0)]]))
    spandrels = geometry.fitted(
        geometry.running_bond(-face, face, upper, spandrel_blocks),
        box(-face, springing_m, face, height_m).difference(under),
    )
    nave, masonry = geometry.mirrored(nave) + nave, ring.blocks() + spandrels
    roof = _beams(nave + masonry, outer, height_m, beams, beam_side_m)
    bases = geometry.two_bases(geometry.base_below(inner, outer, inner))
    layout = geometry.tidied(**bases, NAVATA=nave, ARCO=masonry, COPERTURA=roof)
    layers: dict[str, Any] = {name: {"depth_m": 5.5} | own for name, own in geometry.TWO_SUPPORTS.items()}
    layers |= {"NAVATA": {"depth_m": 5.5}, "COPERTURA": {"vertical_load_kN": 9.1}}
    control, stone = {"C1": (outer, height_m), "C2": (-outer, height_m)}, (16.0, 0.65, 5.33e6)
    moved = geometry.outward(0.15, 0.01)
    return layout, geometry.project("Arco trionfale", 0.6, stone, layers, control, 0.01, [moved])


def _pier(ring: Ring, width: float, blocks: int) -> list[Array]:
    """Return the blocks of the right-hand pier of a ring, the top one cut to the ring's foot."""
    inner = ring.middle + 0.5 * ring.span_m
    levels = np.linspace(0.0, ring.springing, blocks + 1)
    return [*geometry.stack(inner, inner + width, levels[:-1]), ring.springer(width, float(levels[-2]))]


def _beams(masonry: list[Array], outer: float, height: float, beams: int, side: float) -> list[Array]:
    """Return square beams (4, 2), m, over blocks of the top course, 2 `outer` m long. Raises ValueError if too many."""
    top = [block for block in masonry if block[:, 1].max() > height - 1e-9]
    middles = np.array([0.5 * (block[:, 0].min() + block[:, 0].max()) for block in top])
    spots = outer * (np.arange(1, 2 * beams, 2) / beams - 1.0)
    # of two blocks equally near, the one nearer the axis: the roof stays symmetric
    nearest = [middles[np.argmin(np.abs(middles - x) + 1e-6 * np.abs(middles))] for x in spots]
    if min(np.diff(nearest), default=np.inf) < side:
        raise ValueError(f"beams: {beams} beams of {side:g} m do not fit side by side on the top course")
    return [geometry.rectangle(x - 0.5 * side, x + 0.5 * side, height, height + side) for x in nearest]
