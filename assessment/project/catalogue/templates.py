"""Templates of arches, vaults and arcades, of walls, façades and gables: masonry and project file by dimensions."""

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
    return [geometry.rectangle(x - 0.5 * side, height, x + 0.5 * side, height + side) for x in nearest]


BlockLength = Annotated[float, "length of a block"]
CourseHeight = Annotated[float, "height of the courses, adapted to whole numbers of them"]
FootHeight = Annotated[float, "height of its foot above the foundation, for the floor spectrum"]
MOST_LEAN = 60.0  # degrees of the crack of a side wall, from vertical
TIE = 1000.0  # E/f_y of steel of 210 N/mm²: E A/L of a tie is that of its yield force
RAFTER = 0.2  # m, height of a rafter
CRACK = 0.02  # m between a façade and its side walls: in simple overturning they do not rub
Storeys = Annotated[int, "storeys"]
StoreyHeight = Annotated[float, "height of a storey"]


def block(
    width_m: Annotated[float, "width of the block"] = 0.6,
    height_m: Annotated[float, "height of the block"] = 4.2,
) -> Made:
    """Return one block on a wider base."""
    half, base = 0.5 * width_m, 0.5 * width_m
    layout = geometry.tidied(
        BASE=[geometry.rectangle(-half - base, -base, half + base, 0.0)],
        BLOCCO=[geometry.rectangle(-half, 0.0, half, height_m)],
    )
    moved = {"name": "base ruotata 20 mrad", "support": "base", "rotation_rad": -0.02}
    moved |= {"increment_rad": 0.001, "to_collapse": True}
    layers, stone = {"BASE": {"support": "base"}}, (18.0, 0.7, 5e8)
    control, increment = _corners(half, -half, height_m), round(0.01 * width_m, 6)
    return layout, geometry.project("Blocco oscillante", 1.0, stone, layers, control, increment, [moved])


def wall(
    block_length_m: BlockLength = 0.5,
    block_height_m: Annotated[float, "height of a course"] = 0.3,
    blocks: Annotated[int, "blocks along the wall"] = 6,
    courses: Annotated[int, "courses"] = 8,
    moving_blocks: Annotated[int, "blocks at the right end that stand on the support 'destro'"] = 2,
) -> Made:
    """Return a running-bond wall from x = 0, its last blocks on a base of their own. Raises ValueError if all are."""
    if moving_blocks >= blocks:
        raise ValueError(f"moving_blocks: must be fewer than blocks ({blocks}), is {moving_blocks}")
    length, height = blocks * block_length_m, courses * block_height_m
    layout = geometry.tidied(
        **_two_bases((blocks - moving_blocks) * block_length_m, length, block_length_m, block_height_m),
        PARETE=geometry.running_bond(0.0, length, np.linspace(0.0, height, courses + 1), blocks),
    )
    return layout, _wall("Parete a corsi sfalsati", length, height, block_length_m, block_height_m)


def wall_with_openings(
    length_m: Annotated[float, "length of the wall"] = 7.0,
    storeys: Storeys = 2,
    storey_height_m: StoreyHeight = 3.0,
    openings: Annotated[int, "openings of a storey, at equal distances"] = 2,
    opening_width_m: Annotated[float, "width of an opening"] = 1.0,
    opening_height_m: Annotated[float, "height of an opening, adapted to the courses"] = 1.5,
    sill_m: Annotated[float, "height of a sill above the floor, adapted to the courses"] = 0.9,
    lintel_bearing_m: Annotated[float, "length of a lintel on either side of its opening"] = 0.25,
    block_length_m: BlockLength = 0.5,
    course_height_m: CourseHeight = 0.3,
) -> Made:
    """Return a running-bond wall with openings below lintels, on two bases. Raises ValueError if they do not fit."""
    levels = geometry.courses(0.0, storey_height_m, course_height_m)
    per_storey, step = len(levels) - 1, float(levels[1])
    sill, rows = round(sill_m / step), max(1, round(opening_height_m / step))
    apart = length_m / max(openings, 1)
    if openings and sill + rows + 1 > per_storey:
        raise ValueError(
            f"opening_height_m: sill, opening and lintel take {sill + rows + 1} of {per_storey} courses; lower it"
        )
    if openings and opening_width_m + 2.0 * lintel_bearing_m > apart - 1e-9:
        raise ValueError(f"opening_width_m: with its lintel wider than the {apart:g} m that it has; lower it")
    holes, lintels = [], []
    for storey in range(storeys):
        floor = storey * storey_height_m
        bottom, top = floor + sill * step, floor + (sill + rows) * step
        for middle in apart * (np.arange(openings) + 0.5):
            low, high = middle - 0.5 * opening_width_m, middle + 0.5 * opening_width_m
            holes.append(box(low, bottom, high, top))
            low, high = low - lintel_bearing_m, high + lintel_bearing_m
            lintels.append(geometry.rectangle(low, top, high, top + step))
    height = storeys * storey_height_m
    region = box(0.0, 0.0, length_m, height).difference(unary_union([*holes, *map(Polygon, lintels)]))
    along = max(1, round(length_m / block_length_m))
    cells = geometry.running_bond(0.0, length_m, np.linspace(0.0, height, storeys * per_storey + 1), along)
    layout = geometry.tidied(
        **_two_bases(length_m * (1.0 - max(1, along // 3) / along), length_m, block_length_m, step),
        PARETE=geometry.fitted(cells, region),
        **({"ARCHITRAVI": lintels} if lintels else {}),
    )
    return layout, _wall("Parete con aperture", length_m, height, block_length_m, step)


def facade(
    storeys: Storeys = 2,
    storey_height_m: StoreyHeight = 3.5,
    thickness_m: Annotated[float, "thickness of the façade"] = 0.6,
    course_height_m: CourseHeight = 0.35,
    bearing_m: Annotated[float, "length on which floors and roof bear, from the inner face"] = 0.2,
    floor_load_kN: Annotated[float, "load of each floor, per metre of façade"] = 8.0,
    roof_load_kN: Annotated[float, "load of the roof, per metre of façade"] = 5.0,
    roof_span_m: Annotated[float, "horizontal length of a rafter that thrusts"] = 4.0,
    roof_rise_m: Annotated[float, "rise of a rafter that thrusts; 0: trusses, which do not thrust"] = 0.0,
    tie_kN: Annotated[float, "yield force of a tie at each floor and the roof, per metre; 0: no ties"] = 10.0,
    side_wall_m: Annotated[float, "thickness of the side walls, per metre of façade"] = 0.2,
    crack_deg: Annotated[float, "angle of the crack of the side walls, from vertical; 0: no bond"] = 30.0,
) -> Made:
    """Return a section of a façade, 1 m deep, that overturns outward, towards +x, about its outer edge x = thickness.

    Floors bear on blocks in pockets of the inner face, the roof on the top course. Thrusting rafters lean on a ridge
    and on an upstand of the top course, without friction. The side walls above the crack, course by course, turn with
    the façade in the compound mechanism (Circolare 7/2019, C8.7.1.2) and lie still in the simple one. Ties are a
    strengthened state. Raises ValueError for dimensions that do not go together.
    """
    thrusts, deep = roof_rise_m > 0.0, {"depth_m": side_wall_m}
    if crack_deg > MOST_LEAN:
        raise ValueError(f"crack_deg: must be {MOST_LEAN:g} at most, is {crack_deg:g}")
    if bearing_m >= thickness_m:
        raise ValueError(f"bearing_m: must be less than thickness_m ({thickness_m:g}), is {bearing_m:g}")
    per_storey = len(geometry.courses(0.0, storey_height_m, course_height_m)) - 1
    if per_storey < 2:
        raise ValueError(f"course_height_m: must be half of storey_height_m at most, is {course_height_m:g}")
    if roof_span_m < thickness_m:
        raise ValueError(f"roof_span_m: must be {thickness_m:g} or more, is {roof_span_m:g}")
    top = storeys * storey_height_m
    levels = np.linspace(0.0, top, storeys * per_storey + 1)
    step, t, b = float(levels[1]), thickness_m, bearing_m
    floors = levels[per_storey:-1:per_storey]
    room, steps, inner = _cracked(levels, crack_deg)
    # the top course holds the roof's bearing, and with it the thrust, behind an upstand
    low, high = top - step, top + step
    notched = np.array([(0, low), (t, low), (t, high), (b, high), (b, top), (0, top)])
    masonry = [geometry.rectangle(b if z in floors else 0.0, z, t, z + step) for z in levels[:-2]] + [notched]
    ridge, high = 0.5 * b - roof_span_m, top + roof_rise_m
    rafter = [(0, top), (b, top), (b, top + RAFTER), (ridge, high + RAFTER), (ridge, high)]
    wedge = [geometry.rectangle(x, z, -CRACK, z + step) for x, z in zip(steps, levels, strict=False)]
    # layer: its blocks, and what it has of its own
    load = {"vertical_load_kN": roof_load_kN}
    parts: dict[str, tuple[list[Array], dict[str, Any]]] = {
        "BASE": ([geometry.rectangle(room, -0.5, 1.5 * t, 0.0)], {"support": "base"}),
        "MURI": ([inner], {"support": "muri"} | deep),
        "COLMO": (
            [geometry.rectangle(ridge - 0.3, high, ridge, high + 2.0 * RAFTER)] * thrusts,
            {"support": "colmo"},
        ),
        "FACCIATA": (masonry, {}),
        "CUNEO": (wedge if crack_deg else [], deep),
        "SOLAI": (
            [geometry.rectangle(0.0, z, b, z + step) for z in floors],
            {"vertical_load_kN": floor_load_kN},
        ),
        "PUNTONI": ([np.array(rafter)] * thrusts, {"unit_weight_kN_m3": 5.0, "friction": 0.0} | load),
        "TETTO": ([geometry.rectangle(0.0, top, b, top + step)] * (not thrusts), load),
    }
    parts = {name: part for name, part in parts.items() if part[0]}
    tables: dict[str, Any] = {}
    if crack_deg and not thrusts:  # a rafter turns by itself
        turning = [name for name in parts if name not in {"BASE", "MURI", "CUNEO"}]
        names = {"ribaltamento semplice": turning, "ribaltamento composto": [*turning, "CUNEO"]}
        tables["mechanism"] = [{"name": n, "about_m": [t, 0.0], "layers": own} for n, own in names.items()]
    if tie_kN:
        far = room + 0.25
        ends = {k: round(z - 0.5 * step, 9) for k, z in enumerate((*floors.tolist(), top), 1)}
        tables["tie"] = [{
            "name": f"catena {k}", "from_m": [0.5 * t, z], "to_m": [round(far, 9), z], "yield_force_kN": tie_kN,
            "stiffness_kN_m": round(TIE * tie_kN / (0.5 * t - far), 3), "states": ["con catene"],
        } for k, z in ends.items()]  # fmt: skip
        tables["strengthening"] = [{"name": "con catene", "of": "original"}]
    title, stone, control = "Facciata, ribaltamento fuori piano", (18.0, 0.6, 5e5), {"in alto": (t, top)}
    own = {name: own for name, (_, own) in parts.items() if own}
    content = geometry.project(title, 1.0, stone, own, control, round(0.01 * t, 6), **tables)
    content["pushover"]["directions"] = ["+x"]
    return geometry.tidied(**{name: blocks for name, (blocks, _) in parts.items()}), content


def _cracked(levels: Array, crack_deg: float) -> tuple[float, Array, Array]:
    """Return where side walls end (m), where each of their courses is cracked (k,), and the outline (n, 2) beyond."""
    lean = np.tan(np.radians(crack_deg))
    room = -levels[-1] * lean - 1.5  # of the inner walls, which are a support
    steps = -CRACK - levels[1:] * lean if crack_deg else np.full(len(levels) - 1, room + 0.5)
    inner = [(room, levels[-1]), (room, 0.0), (steps[0], 0.0)]
    for x, after, z in zip(steps[:-1], steps[1:], levels[1:-1], strict=True):
        inner += [(x, z), (after, z)]
    return float(room), steps, np.array([*inner, (steps[-1], levels[-1])])


def tympanum(
    width_m: Annotated[float, "width of the base"] = 8.0,
    height_m: Annotated[float, "height above the base"] = 3.0,
    thickness_m: Annotated[float, "thickness"] = 0.4,
    course_height_m: CourseHeight = 0.3,
    foot_height_m: FootHeight = 9.0,
) -> Made:
    """Return a section of a triangular gable that overturns out of its plane, each course as deep as it is wide."""
    levels = geometry.courses(0.0, height_m, course_height_m)
    widths = width_m * (1.0 - 0.5 * (levels[:-1] + levels[1:]) / height_m)
    names = [f"TIMPANO_{k:02d}" for k in range(1, len(widths) + 1)]
    half = 0.5 * thickness_m
    blocks = geometry.stack(-half, half, levels)
    layout = geometry.tidied(
        BASE=[geometry.rectangle(-2.0 * half, -half, 2.0 * half, 0.0)],
        **{name: [each] for name, each in zip(names, blocks, strict=True)},
    )
    layers: dict[str, Any] = {"BASE": {"support": "base"}}
    layers |= {name: {"depth_m": round(float(w), 9)} for name, w in zip(names, widths, strict=True)}
    control, increment = _corners(half, -half, height_m), round(0.01 * thickness_m, 6)
    title, stone = "Timpano, ribaltamento fuori piano", (18.0, 0.6, 5e5)
    at = _at(foot_height_m, foot_height_m + height_m)
    return layout, geometry.project(title, width_m, stone, layers, control, increment, assessment=at)


def bell_gable(
    openings: Annotated[int, "openings for bells"] = 2,
    opening_width_m: Annotated[float, "width of an opening"] = 0.8,
    pier_width_m: Annotated[float, "width of a pier"] = 0.5,
    pier_height_m: Annotated[float, "height of the piers"] = 1.6,
    gable_height_m: Annotated[float, "height of the gable above the lintel"] = 1.2,
    thickness_m: Annotated[float, "thickness"] = 0.6,
    course_height_m: CourseHeight = 0.4,
    bells_kN: Annotated[float, "weight of the bells, on the lintel"] = 3.0,
    foot_height_m: FootHeight = 12.0,
) -> Made:
    """Return a bell-gable in its plane: piers of one block a course, one lintel over all openings, a gable on it."""
    half = 0.5 * (openings * opening_width_m + (openings + 1) * pier_width_m)
    levels = geometry.courses(0.0, pier_height_m, course_height_m)
    top = pier_height_m + float(levels[1])
    starts = -half + (pier_width_m + opening_width_m) * np.arange(openings + 1)
    along = max(1, round(2.0 * half / (2.0 * course_height_m)))
    rows = geometry.courses(top, top + gable_height_m, course_height_m)
    gable = Polygon([(-half, top), (half, top), (0.0, top + gable_height_m)])
    layout = geometry.tidied(
        BASE=[geometry.rectangle(-1.25 * half, -0.5 * half, 1.25 * half, 0.0)],
        PIEDRITTI=[each for x in starts for each in geometry.stack(x, x + pier_width_m, levels)],
        ARCHITRAVE=geometry.course(-half, half, pier_height_m, top, blocks=1, shifted=False),
        VELA=geometry.fitted(geometry.running_bond(-half, half, rows, along), gable),
    )
    layers = {"BASE": {"support": "base"}, "ARCHITRAVE": {"vertical_load_kN": bells_kN}}
    control, increment = {"in alto": (0.0, top + gable_height_m)}, round(0.01 * pier_width_m, 6)
    title, stone = "Vela campanaria, nel piano", (18.0, 0.65, 1e6)
    at = _at(foot_height_m, foot_height_m + top + gable_height_m)
    return layout, geometry.project(title, thickness_m, stone, layers, control, increment, assessment=at)


def _two_bases(split: float, length: float, margin: float, depth: float) -> dict[str, list[Array]]:
    """Return two bases below a wall from x = 0 to its length, the right one from `split` on, m."""
    return {
        "BASE_SINISTRA": [geometry.rectangle(-margin, -depth, split, 0.0)],
        "BASE_DESTRA": [geometry.rectangle(split, -depth, length + margin, 0.0)],
    }


def _wall(title: str, length: float, height: float, block: float, step: float) -> dict[str, Any]:
    """Return the project file of a wall on two bases, of blocks of a length in courses of a height `step`, m."""
    control, moved = _corners(length, 0.0, height), geometry.sinking(round(0.1 * step, 6))
    increment = round(0.02 * block, 6)
    return geometry.project(title, 0.3, (18.0, 0.65, 1e6), geometry.TWO_SUPPORTS, control, increment, [moved])


def _corners(right: float, left: float, top: float) -> dict[str, tuple[float, float]]:
    return {"in alto a destra": (right, top), "in alto a sinistra": (left, top)}


def _at(height: float, building: float) -> dict[str, Any]:
    """Return what [assessment] has of its own for a mechanism at a height (m) of a building (m) of one storey."""
    floor = {"height_m": height, "building_height_m": round(building, 6), "storeys": 1}
    return {"floor": floor} if height else {}
