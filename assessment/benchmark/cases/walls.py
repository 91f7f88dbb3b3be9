"""Limit analysis of ever larger running-bond walls: processor time and memory, each wall in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator

from assessment.benchmark.cases.structures import running_bond
from assessment.benchmark.measure import Row, exponent, in_turn, peak_memory, piqp, seconds_of
from mechanics import Assembly, limit_analysis
from mechanics.solvers import lp_highs
from mechanics.steps.equilibrium import closed_program

WALLS = {100: (10, 10), 300: (17, 17), 1000: (31, 31), 3000: (55, 54), 10000: (100, 100)}
QUICK = 1000  # blocks of the largest wall then
COMPARED = 400  # blocks of the largest wall that HiGHS also solves
REPEATED = 3000  # blocks of the largest wall that is measured more than once
FITTED = 200  # blocks from which the exponent is fitted


def walls(quick: bool) -> Iterator[Row]:
    """A row for every wall; last, the exponent of time over the number of blocks."""
    rows = []
    for blocks, size in WALLS.items():
        if not quick or blocks <= QUICK:
            rows.append(apart(*size))
            yield rows[-1]
    yield {
        "case": f"exponent, from {FITTED} blocks",
        "seconds": exponent([row for row in rows if row["blocks"] >= FITTED], "seconds"),
    }


def apart(columns: int, courses: int) -> Row:
    """The row of a wall, measured in another process."""
    done = subprocess.run(
        [sys.executable, "-m", __name__, str(columns), str(courses)],
        check=True,
        capture_output=True,
        text=True,
    )
    row: Row = json.loads(done.stdout)
    return row


def measured(columns: int, courses: int) -> Row:
    """Processor time of building the model and of limit analysis, its check under self-weight included.

    HiGHS is the reference of walls that it solves in seconds.
    """
    limit_analysis(running_bond(8, 8))  # what is imported and compiled once
    building, model = seconds_of(lambda: running_bond(columns, courses))
    seconds, limit = seconds_of(lambda: limit_analysis(model))
    memory = peak_memory()
    blocks = int(model.movable.sum())
    program = closed_program(model, model.initial, model.lateral_load("+x")).program
    if blocks <= REPEATED:
        seconds, baseline = in_turn(lambda: limit_analysis(model), lambda: piqp(program))
    else:
        baseline = piqp(program)
    return {
        "case": f"wall {columns} × {courses}",
        "blocks": blocks,
        "joints": len(model.contacts),
        "building_s": building,
        "seconds": seconds,
        "ratio": seconds / baseline,
        "memory_MB": memory,
        "alpha": limit.alpha,
        "certificate": limit.certificate.worst(1e-3 * model.size),
        **(_by_highs(model, limit.alpha) if blocks <= COMPARED else {}),
    }


def _by_highs(model: Assembly, alpha: float) -> Row:
    program = closed_program(model, model.initial, model.lateral_load("+x")).program
    seconds, answer = seconds_of(lambda: lp_highs.solve(program))
    assert answer is not None
    return {"error": abs(alpha / answer[1] - 1.0), "highs_s": seconds}


if __name__ == "__main__":
    print(json.dumps(measured(int(sys.argv[1]), int(sys.argv[2]))))
