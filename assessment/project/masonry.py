"""The blocks of a project's drawing: bonds cut, regions put on them, and those that a mechanism or a point names."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon
from shapely.ops import unary_union

from assessment.ntc.tables import psi_2
from assessment.project.catalogue.geometry import courses, fitted, rectangle, running_bond, tidied
from assessment.project.project import Project
from assessment.project.schema import BondTable, LayerTable, MaterialTable, MechanismTable
from assessment.runtime.errors import ProjectError, nearest
from mechanics import ArgumentError, Assembly, Block, Material
from mechanics.messages import layer_key
from mechanics.model import Drawing, Layer, of_block
from mechanics.types import Array

MOST_BLOCKS = 10_000  # that a bond makes of one outline
TOUCHING = 1e-6  # of an outline's size: an opening may end at its edge
SLIVER = 0.2  # of a block's least size: what is thinner is joined to its neighbour
# keys of [material] and of layers, and what a material calls them: without their unit
MATERIAL = {key: key.partition("_kN")[0] for key in MaterialTable.model_fields}


def as_built(project: Project, drawing: Drawing) -> Drawing:
    """Return the drawing with its bonds cut and with what regions say of the blocks whose centroids lie in them.

    Raises ProjectError for a region that is no outline or holds no block, and for a bond as `running`.
    """
    if not project.region and not any(each.bond for each in project.layers.values()):
        return drawing
    keys = [f"{project.source}: region.{region.name}.outline_m" for region in project.region]
    outlines = [Polygon(region.outline_m) for region in project.region]
    for key, outline in zip(keys, outlines, strict=True):
        if not outline.is_valid or not outline.area:
            raise ProjectError(f"{key}: crosses itself or has no area; write its corners in order")
    blocks = []
    for block in _bonded(project, outlines, drawing.blocks):
        name = _region_at(project, outlines, block)
        table = table_of(project, block.layer, name)
        if not name:
            blocks.append(block)
        elif not table.ignore:
            blocks.append(replace(block, **of_block(layer_of(project, table)), region=name))
    for key, region in zip(keys, project.region, strict=True):
        if not region.ignore and all(block.region != region.name for block in blocks):
            text = "no block has its centroid in it, or a later region has it too; correct its corners, in m"
            raise ProjectError(f"{key}: {text}")
    return replace(drawing, blocks=tuple(blocks))


def layer_of(project: Project, table: LayerTable | None) -> Layer:
    """What blocks are: a table's keys before [material] and [geometry]. Raises ProjectError where no joint is such."""
    own = table.model_dump(include={*MATERIAL}, exclude_none=True) if table else {}
    given = project.material.model_dump() | own
    try:
        material = Material(**{MATERIAL[key]: value for key, value in given.items()})
    except ValueError as error:
        raise ProjectError(f"{project.source}: material: {error}") from None
    if table is None:
        return Layer(material, project.geometry.depth_m)
    return Layer(
        material, table.depth_m or project.geometry.depth_m, table.support,
        table.vertical_load_kN + psi_2(table.use_category, table.psi_2) * table.variable_load_kN,
        table.load_has_mass, table.segments_per_joint, table.ignore,
    )  # fmt: skip


def table_of(project: Project, layer: str, region: str) -> LayerTable:
    """Return what a layer and a region ("": none) say together: the keys of the region before those of the layer."""
    own = (table for name, table in project.layers.items() if layer_key(name) == layer_key(layer))
    table = next(own, LayerTable())
    given = next((each for each in project.region if each.name == region), None)
    if given is None:
        return table
    over = given.model_fields_set & LayerTable.model_fields.keys()
    return table.model_copy(update={key: getattr(given, key) for key in over})


def _region_at(project: Project, outlines: Sequence[Polygon], block: Block) -> str:
    place = shapely.Point(block.centroid)
    found = [r.name for r, o in zip(project.region, outlines, strict=True) if o.intersects(place)]
    return found[-1] if found else ""


def _bonded(project: Project, regions: Sequence[Polygon], blocks: Sequence[Block]) -> list[Block]:
    within = [_region_at(project, regions, block) for block in blocks]
    tables = [table_of(project, block.layer, region) for block, region in zip(blocks, within, strict=True)]
    shapes = [Polygon(block.polygon) for block in blocks]
    gone, made = set[int](), list[Block]()
    for k in sorted(range(len(blocks)), key=lambda k: -shapes[k].area):
        if (bond := tables[k].bond) is None or k in gone:
            continue
        near = shapely.STRtree(shapes).query(shapes[k], predicate="intersects")
        around = shapes[k].buffer(TOUCHING * float(np.ptp(blocks[k].polygon)))
        inside = [j for j in near.tolist() if j != k and around.contains(shapes[j])]
        openings = [j for j in inside if layer_key(blocks[j].layer) == layer_key(blocks[k].layer)]
        gone |= {k, *openings}
        own = any(each.name == within[k] and each.bond for each in project.region)
        key = f"{project.source}: {f'region.{within[k]}' if own else f'layers.{blocks[k].layer}'}.bond"
        others = [shapes[j] for j in inside if j not in openings]
        try:
            pieces = running(shapes[k], [shapes[j] for j in openings], others, bond)
        except ValueError as error:
            raise ProjectError(f"{key}.{error}") from None
        made += [replace(blocks[k], vertices=piece) for piece in pieces]
    return [*(block for k, block in enumerate(blocks) if k not in gone), *made]


def running(
    outline: Polygon, openings: Sequence[Polygon], others: Sequence[Polygon], bond: BondTable
) -> list[Array]:
    """Return the blocks (n, 2) m in running bond of an outline but for `openings` and `others`, lintels last.

    A lintel bears by half a block on either side. Raises ValueError for too many blocks, or one around an opening.
    """
    low, bottom, high, top = outline.bounds
    levels = courses(bottom, top, bond.course_m, "course_m")
    along = max(1, round((high - low) / bond.block_m))
    if along * len(levels) > MOST_BLOCKS:
        raise ValueError(f"block_m: {bond.block_m:g} makes more than {MOST_BLOCKS} blocks; lengthen it")
    walled = outline.difference(unary_union([*openings, *others]))
    lintels = []
    for opening in openings:
        left, _, right, head = opening.bounds
        above = levels[levels > head + 0.5 * bond.course_m]
        if not len(above):  # it ends at the top
            continue
        box = rectangle(left - 0.5 * bond.block_m, head, right + 0.5 * bond.block_m, float(above[0]))
        lintel = Polygon(box).intersection(walled)
        lintel = max(getattr(lintel, "geoms", [lintel]), key=lambda part: part.area)
        if lintel.area and lintel.bounds[0] < left and right < lintel.bounds[2]:
            lintels.append(lintel)
    joined = unary_union(lintels)
    beams = [part for part in getattr(joined, "geoms", [joined]) if part.area]
    thinnest = SLIVER * min(bond.course_m, bond.block_m)
    cells = running_bond(low, high, levels, along)
    pieces = fitted(cells, walled.difference(joined), thinnest)
    pieces += [np.array(beam.exterior.coords[:-1]) for beam in beams]
    if sum(Polygon(piece).area for piece in pieces) > walled.area * (1.0 + 1e-6):
        text = "a block would enclose an opening, or another block"
        raise ValueError(f"block_m: {text}; write a shorter one, or draw these blocks")
    return tidied(blocks=pieces)["blocks"]


def block_at(model: Assembly, key: str, point: tuple[float, float], note: str = "") -> int:
    """Return the block that contains a point (m). Raises ProjectError naming its key, with a note, where none does."""
    try:
        return model.block_at(point)
    except ArgumentError as error:
        reason = str(error).partition("must be ")[2] + note
        raise ProjectError(f"{key}: {list(point)} must be {reason}; move it there") from None


@dataclass(frozen=True, eq=False)
class RotatingBlocks:
    """Blocks (n,) that rotate as one by `rotation`, anticlockwise, about the point `about` (2,) m, from the origin."""

    about: NDArray[np.float64]
    rotation: float
    blocks: NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Chosen:
    """A mechanism chosen by the user, in the configuration of a state."""

    name: str
    state: str
    parts: tuple[RotatingBlocks, ...]


def chosen_mechanisms(project: Project, model: Assembly) -> list[Chosen]:
    """Return the mechanisms, entries of one name joined. Raises ProjectError for an entry of wrong blocks."""
    found: dict[str, Chosen] = {}
    for index, entry in enumerate(project.mechanism):
        key = f"{project.source}: mechanism[{index + 1}]"
        blocks = _blocks(entry, model, key)
        before = found.get(entry.name, Chosen(entry.name, entry.state, ()))
        for part in before.parts:
            if (twice := np.intersect1d(part.blocks, blocks)).size:
                text = f'block {twice[0]} is in another macro-block of "{entry.name}"'
                raise ProjectError(f"{key}: {text}; a block has one rotation")
        part = RotatingBlocks(model.from_origin(entry.about_m), entry.rotation, blocks)
        found[entry.name] = replace(before, parts=(*before.parts, part))
    return [*found.values()]


def _blocks(entry: MechanismTable, model: Assembly, key: str) -> NDArray[np.intp]:
    """Return the blocks of the layers within the region, and those named by number; sorted."""
    of_layer = {layer_key(block.layer): block.layer for block in model.blocks}
    for layer in entry.layers or ():
        if layer_key(layer) not in of_layer:
            names = sorted(set(of_layer.values()))
            raise ProjectError(f'{key}.layers: no block on layer "{layer}"; {nearest(layer, names)}')
    for number in entry.blocks or ():
        if not 0 <= number < len(model.blocks):
            raise ProjectError(f"{key}.blocks: no block {number}; write 0 to {len(model.blocks) - 1}")
        if not model.movable[number]:
            text = f"block {number} is a support, which a mechanism leaves where it is; leave it out"
            raise ProjectError(f"{key}.blocks: {text}")
    chosen = np.zeros(len(model.blocks), dtype=bool)
    if entry.layers or entry.region_m:
        chosen |= model.movable
    if entry.layers:
        chosen &= np.isin([layer_key(block.layer) for block in model.blocks], [*map(layer_key, entry.layers)])
    if entry.region_m:
        corners = np.reshape(entry.region_m, (-1, 2))
        if len(corners) == 2:
            region = shapely.box(*corners.min(axis=0), *corners.max(axis=0))
        elif not (region := shapely.Polygon(corners)).is_valid:
            raise ProjectError(f"{key}.region_m: the outline crosses itself; write its corners in order")
        chosen &= shapely.intersects(region, shapely.points([block.centroid for block in model.blocks]))
    chosen[list(entry.blocks or ())] = True
    if not chosen.any():
        raise ProjectError(f"{key}: no movable block is chosen; correct layers, region_m or blocks")
    return np.flatnonzero(chosen)
