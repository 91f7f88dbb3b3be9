"""Macro-blocks of the mechanisms that the user chooses: from the entries of [[mechanism]] to numbers of blocks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray

from assessment.runtime.errors import ProjectError, nearest
from mechanics.messages import layer_key

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.schema import MechanismTable
    from mechanics import Assembly


@dataclass(frozen=True, eq=False)
class MacroBlock:
    """Blocks (n,) that rotate as one by `rotation`, anticlockwise, about the point `about` (2,) m, from the origin."""

    about: NDArray[np.float64]
    rotation: float
    blocks: NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Chosen:
    """A mechanism chosen by the user, in the configuration of a state."""

    name: str
    state: str
    parts: tuple[MacroBlock, ...]


def chosen_mechanisms(project: Project, model: Assembly) -> list[Chosen]:
    """Return the mechanisms of [[mechanism]], entries of one name joined.

    Raises ProjectError naming the entry: an unknown layer, no such block, a support, a block chosen twice, none at all.
    """
    found: dict[str, Chosen] = {}
    for index, entry in enumerate(project.mechanism):
        key = f"{project.source}: mechanism[{index + 1}]"
        blocks = _blocks(entry, model, key)
        before = found.get(entry.name, Chosen(entry.name, entry.state, ()))
        for part in before.parts:
            if (twice := np.intersect1d(part.blocks, blocks)).size:
                text = (
                    f'block {twice[0]} is in another macro-block of "{entry.name}"; a block has one rotation'
                )
                raise ProjectError(f"{key}: {text}")
        part = MacroBlock(model.from_origin(entry.about_m), entry.rotation, blocks)
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
            raise ProjectError(
                f"{key}.blocks: block {number} is a support, which a mechanism leaves where it is; leave it out"
            )
    chosen = np.zeros(len(model.blocks), dtype=bool)
    if entry.layers or entry.region_m:
        chosen |= model.movable
    if entry.layers:
        chosen &= np.isin([layer_key(block.layer) for block in model.blocks], [*map(layer_key, entry.layers)])
    if entry.region_m:
        region = _region(entry.region_m, key)
        chosen &= shapely.intersects(region, shapely.points([block.centroid for block in model.blocks]))
    chosen[list(entry.blocks or ())] = True
    if not chosen.any():
        raise ProjectError(f"{key}: no movable block is chosen; correct layers, region_m or blocks")
    return np.flatnonzero(chosen)


def _region(corners: tuple[float, ...], key: str) -> shapely.Polygon:
    points = np.reshape(corners, (-1, 2))
    if len(points) == 2:
        return shapely.box(*points.min(axis=0), *points.max(axis=0))
    polygon = shapely.Polygon(points)
    if not polygon.is_valid:
        raise ProjectError(f"{key}.region_m: the outline crosses itself; write its corners in order")
    return polygon
