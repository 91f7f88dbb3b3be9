"""The level at collapse of a search beside dense scans: `python -m tests.stress.levels RECORD [STRUCTURE …]`.

A search runs as [incremental] does with accuracy = "fast": at the record's step, and at the step halved as often as the
mean of its lowest collapses asks for. The dense scan runs every level 1 % apart at a quarter of the step.
"""

import math
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np

from assessment.analyses.histories import Scatter
from assessment.analyses.scan import Reach, scan
from assessment.analyses.time_history import Setting, respond
from assessment.project.motions import BaseMotion
from assessment.project.schema import ControlTable, MotionTable
from assessment.studies.scans import LOOKED_TO, LOOKS, level_found, observed_in
from mechanics import Assembly, Block, Material, read_record
from tests.support.structures import column, on_base, rectangle

STEP, LENGTH = 0.005, 8.0  # s
# ratio of the dense levels; down to this share; collapses in a row that end it
FINE, DEEP, SURE = (1.01, 0.7, 10)
INTRADOS, THICKNESS = 2.0, 0.45  # m, of the arches


def arch(voussoirs: int, stiffness: float | None = None) -> Assembly:
    """A semicircular arch of radial joints on two supports."""
    stone = Material(20.0, 0.9, stiffness)
    radii = np.array([INTRADOS, INTRADOS + THICKNESS])
    angles = np.linspace(0.0, np.pi, voussoirs + 1)
    corner = np.stack([np.outer(np.cos(angles), radii), np.outer(np.sin(angles), radii)], axis=2)
    ring = [Block([*corner[i], *corner[i + 1, ::-1]], 1.0, stone) for i in range(voussoirs)]
    bases = [
        Block(rectangle(min(x), -0.3, max(x), 0.0), 1.0, stone, support=name)
        for x, name in ((radii, "right"), (-radii, "left"))
    ]
    return Assembly([*ring, *bases])


def portal() -> Assembly:
    """A lintel on two piers."""
    stone = Material(20.0, 0.7)
    blocks = (0.0, 0.0, 0.5, 2.0), (2.0, 0.0, 2.5, 2.0), (0.0, 2.0, 2.5, 2.4)
    return on_base(stone, (-1.0, -0.3, 3.5), *blocks)


STRUCTURES = {
    "block 0.5 × 2.0 m": partial(column, 0.5, 2.0, 1),
    "stack of two": partial(column, 0.5, 2.0, 2),
    "stack of three": partial(column, 0.7, 2.1, 3),
    "portal": portal,
    **{f"arch, {n} voussoirs": partial(arch, n) for n in (5, 7, 9, 11, 13, 15)},
    "arch, 7 voussoirs, elastic, 5·10⁶ kN/m³": partial(arch, 7, 5e6),
}


def searched(model: Assembly, motion: BaseMotion, setting: Setting) -> tuple[int, float, float, float]:
    """Motions, time step (s), lowest collapse and level at collapse (g) of a search."""
    start, scatter, reach = model.starting(None), Scatter(1, 0.02), Reach(40.0, width=math.inf)
    found = [scan(model, motion, setting, start, scatter, reach)]
    for _ in range(LOOKS):
        motion = motion.at_half_step()
        found.append(scan(model, motion, setting, start, scatter, reach, level_found(found[-1])))
        last, before = (observed_in(each).lowest or math.inf for each in (found[-1], found[-2]))
        if abs(last / before - 1.0) <= LOOKED_TO:
            break
    lowest = [observed_in(each).lowest or math.inf for each in found]
    wrong = [n for n, level in enumerate(lowest) if not abs(level / lowest[-1] - 1.0) <= LOOKED_TO]
    used = found[min(wrong[-1] + 1, len(found) - 1) if wrong else 0]
    seen = observed_in(used)
    return len(used.points), used.time_step, seen.lowest or math.inf, seen.capacity or math.inf


def densely(model: Assembly, motion: BaseMotion, setting: Setting, lowest: float) -> dict[float, bool]:
    """Whether the structure collapses at levels (g) FINE apart around a lowest collapse, at a quarter of the step."""
    motion, start = motion.at_half_step().at_half_step(), model.starting(None)

    def falls(place: int) -> bool:
        factor = lowest * FINE**place / motion.pga
        return respond(model, motion, setting, start, factor, to_rest=False).collapsed

    found: dict[int, bool] = {}
    place, row = 0, 0
    while row < SURE:
        found[place] = falls(place)
        row = row + 1 if found[place] else 0
        place += 1
    depth, place = math.ceil(math.log(1.0 / DEEP) / math.log(FINE)), -1
    while place >= min((each for each in found if found[each]), default=0) - depth:
        found[place] = falls(place)
        place -= 1
    return {lowest * FINE**each: found[each] for each in sorted(found)}


def bands(found: dict[float, bool]) -> str:
    """The bands of collapse, in words."""
    levels, ends = list(found), []
    edges = [n for n, (a, b) in enumerate(pairwise([False, *found.values()])) if a != b]
    for first, last in zip(edges[::2], [*edges[1::2], None], strict=False):
        if last is None:
            ends.append(f"from {levels[first]:.3f}")
        elif last == first + 1:
            ends.append(f"{levels[first]:.3f}")
        else:
            ends.append(f"{levels[first]:.3f}–{levels[last - 1]:.3f}")
    return ", ".join(ends)


def rows(record: Path, wanted: list[str]) -> Iterator[str]:
    """A row of the table for each structure (all, or those `wanted`), under the LENGTH s around the record's peak."""
    whole = read_record(record).resampled(STEP)
    first = max(int(abs(whole.acceleration).argmax()) - round(0.5 * LENGTH / STEP), 0)
    cut = replace(whole, acceleration=whole.acceleration[first : first + round(LENGTH / STEP) + 1])
    motion = BaseMotion(cut, cut, cut.pga, 1.0)
    for name in wanted or STRUCTURES:
        model, began = STRUCTURES[name](), time.process_time()
        highest = max(
            (each.polygon[each.polygon[:, 1].argmax()] for each in model.blocks), key=lambda p: p[1]
        )
        point = (float(highest[0]), float(highest[1]))
        table = MotionTable(contacts="elastic" if "elastic" in name else "rigid")
        setting = Setting(table, ControlTable(name="control", point_m=point))
        motions, step, lowest, level = searched(model, motion, setting)
        if lowest == math.inf:
            yield f"| {name} | {1000.0 * step:g} | {motions} | none |"
            continue
        dense = densely(model, motion, setting, lowest)
        least = min(each for each, fell in dense.items() if fell)
        yield (
            f"| {name} | {1000.0 * step:g} | {motions} | {lowest:.3f} | {level:.3f} | {bands(dense)} | "
            f"{100.0 * (level / least - 1.0):+.1f} % | {time.process_time() - began:.0f} s"
        )


def main(arguments: list[str]) -> None:
    """Print the table."""
    for row in rows(Path(arguments[0]), arguments[1:]):
        print(row, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
