"""Elastic joints of few segments, whose error nobody is told: a warning before any analysis.

What the segments of a joint leave of the peak displacement, against 64 (wall and panel: 32): the templates of block,
arch, buttressed arch and wall, a block on a soft joint, an arch on piers and the tuff panel, as drawn and settled, two
sines and one or two records at two levels each, 5 ms, 5 % damping; 70 histories that come back, 6 that collapse.

    segments               2      4      8     16     32
    error, median        38 %   18 %    6 %  1.4 %  0.7 %
    error, largest       98 %   90 %   64 %   60 %   16 %
    beyond 10 %         63/70  47/70  24/70   6/70   1/54
    collapse not seen     6/6    4/6    4/6    1/6    1/6

And of the elastic peak α_u, always too high, against 64: the templates of block, wall, arch and buttressed arch, as
drawn and settled (with 2 the settled arch does not stand).

    segments               2      4      8     16     32
    too high, median     15 %   19 %   10 %    3 %    1 %
    too high, largest   268 %  129 %   42 %   18 %    3 %

Rigid contacts have one segment whatever is given: with 2, 16 and 64 peaks are the same to the last digit.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from assessment.convergence import accuracy_of

if TYPE_CHECKING:
    from assessment.project import Project
    from mechanics import Assembly, Block
    from mechanics.types import Index

ENOUGH = 16


def coarse_joints(project: Project, model: Assembly) -> list[str]:
    """Return a warning where pushover or motions ask for elastic contacts, and a joint has fewer than ENOUGH segments.

    Nothing is said where `accuracy` lets the report tell the error.
    """
    stages = {
        "pushover": (project.pushover,),
        "history": project.history,
        "incremental": (project.incremental,),
    }
    elastic = [name for name in stages if any(each and "elastic" in each.contacts for each in stages[name])]
    coarse = np.flatnonzero(model.segments < ENOUGH)
    if not elastic or not coarse.size or accuracy_of(project).tolerance is not None:
        return []
    return [
        f"{project.source}: {_keys(model, coarse)}: too few segments for the elastic contacts of {', '.join(elastic)}: "
        "peaks, of the multiplier as of motions, can be off by half and more, and collapses stay unseen; "
        f'write {ENOUGH} or more, or accuracy = "standard", with which the report tells the error'
    ]


def _keys(model: Assembly, joints: Index) -> str:
    """Return the keys that the segments of joints come from: of two blocks the one that asks for more decides."""
    wished = np.array([block.segments or model.segments_per_joint for block in model.blocks])
    a, b = model.joints.a[joints], model.joints.b[joints]
    deciding = np.unique(np.where(wished[a] >= wished[b], a, b))
    keys = {(int(wished[i]), _key(model.blocks[i])) for i in deciding}
    return ", ".join(f"{key} ({segments})" for segments, key in sorted(keys))


def _key(block: Block) -> str:
    where = "geometry" if block.segments is None else f"layers.{block.layer}"
    return f"{where}.segments_per_joint"
