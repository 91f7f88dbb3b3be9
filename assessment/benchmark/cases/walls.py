"""Limit analysis of ever larger running-bond walls, each in a process of its own."""

import json
import math
import subprocess
import sys
from collections.abc import Iterator
from functools import partial

from assessment.benchmark.cases.structures import running_bond
from assessment.benchmark.measure import exponent, in_turn, peak_memory, piqp, pushed_program, seconds_of
from assessment.benchmark.table import Row
from mechanics import limit_analysis
from mechanics.solvers import lp_highs

WALLS = {100: (10, 10), 300: (17, 17), 1000: (31, 31), 3000: (55, 54), 10000: (100, 100)}  # by blocks
COMPARED, FITTED, REPEATED = (400, 200, 3000)  # blocks: by HiGHS up to, fitted from, repeated up to


def walls(quick: bool) -> Iterator[Row]:
    """A row for every running-bond wall, in a process of its own; last, the exponent of time over blocks."""
    rows = []
    for blocks, size in WALLS.items():
        if not quick or blocks <= 1000:
            rows.append(apart(*size))
            yield rows[-1]
    fitted = exponent([row for row in rows if row["blocks"] >= FITTED], "seconds")
    yield {"case": f"exponent, from {FITTED} blocks", "seconds": fitted}


def apart(columns: int, courses: int) -> Row:
    """The row of a wall, measured in another process."""
    command = [sys.executable, "-m", __name__, str(columns), str(courses)]
    row: Row = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return row


def measured(columns: int, courses: int) -> Row:
    """Times (s) of building a wall and of its limit analysis; memory (MB), α_0, residual, error against HiGHS."""
    limit_analysis(running_bond(8, 8), sliding="associative")  # what is imported and compiled once
    building, model = seconds_of(lambda: running_bond(columns, courses))
    seconds, found = seconds_of(lambda: limit_analysis(model, sliding="associative"))
    blocks, memory, program = int(model.movable.sum()), peak_memory(), pushed_program(model)
    baseline = seconds_of(piqp(program))[0]
    if blocks <= REPEATED:
        solve = partial(limit_analysis, model, sliding="associative")
        seconds, baseline = map(float, in_turn(solve, piqp(program)))
    row: Row = {"case": f"wall {columns} × {courses}", "blocks": blocks, "joints": len(model.contacts)}
    row |= {"building_s": building, "seconds": seconds, "ratio": seconds / baseline, "memory_MB": memory}
    row |= {"alpha": found.alpha, "certificate": found.certificate.worst(1e-3 * model.size)}
    if blocks > COMPARED:
        return row | {"error": math.nan}
    highs, answer = seconds_of(lambda: lp_highs.solve(program))
    assert answer is not None
    return row | {"error": abs(found.alpha / answer[1] - 1.0), "highs_s": highs}


if __name__ == "__main__":
    print(json.dumps(measured(int(sys.argv[1]), int(sys.argv[2]))))
