"""Statics: run time against error of increments, beds and solvers; curves that slide; whole chains; large walls."""

import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import cache, partial
from itertools import product
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from assessment.analyses.governing import ENSEMBLE, shaken_corners
from assessment.analyses.states import PAST_PEAK
from assessment.benchmark import measure as runner
from mechanics import Assembly, Pushdown, Pushover, limit_analysis, pushover
from mechanics.model.assembly import Behaviour, Direction
from mechanics.procedures.mirror import Mirror
from mechanics.solvers import lp_highs, qp_piqp
from mechanics.steps.static_system import Sliding

INCREMENTS, FEWER = ((4.0, 2.0, 1.0, 0.5), (4.0, 2.0, 1.0))  # of the template's; reference: half the last
SEGMENTS, SETTLED_SEGMENTS = ((1, 2, 4, 8, 16, 32, 64, np.inf), (1, 4, 16, 64, np.inf))  # inf: exact
FINE = -np.inf  # the exact bed, in a quarter of the increments
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12)
ARCH, TRIUMPHAL = "buttressed-arch", "triumphal-arch"


def statics(quick: bool) -> Iterator[runner.Row]:
    """From one block to the triumphal arch; quick: without the latter, and fewer values."""
    cases = [
        rocking_rigid(),
        limit("Ferris and Tin-Loi's wall 1", runner.running_bond()),
        settling(ARCH, "rigid", FEWER if quick else INCREMENTS),
        pushing(ARCH, "rigid", FEWER if quick else INCREMENTS),
    ]
    if not quick:
        cases += [
            pushing(ARCH, "elastic"),
            pushing(ARCH, "rigid", moved=True),
            settling(ARCH, "elastic"),
            *(beds(ARCH, way) for way in (None, "+x", "-x")),
            limit("triumphal arch", runner.assembly(TRIUMPHAL)),
            settling(TRIUMPHAL, "rigid", FEWER),
            pushing(TRIUMPHAL, "rigid", FEWER),
            pushing(TRIUMPHAL, "elastic", FEWER),
            pushing(TRIUMPHAL, "rigid", FEWER, moved=True),
        ]
    for case in cases:
        yield from runner.rows_of(case)


def rocking_rigid() -> runner.Case:
    """A rigid block: α = tan(arctan(B/H) − θ) at every point, zero at a displacement H sin(arctan(B/H))."""
    model, slenderness = runner.block_on_base(), float(np.arctan(0.2))

    def measure(curve: Pushover) -> dict[str, float]:
        lean = np.array([-state.positions[1, 2] for state in curve.states])
        off = float(abs(curve.multiplier - np.tan(slenderness - lean)).max())
        return {"α": 1.0 + off / 0.2, "d_0": float(curve.displacement[-1])}

    def run(times: float) -> Pushover:
        return pushover(model, (0.2, 1.0), increment=0.005 * times)

    exact = {"α": 1.0, "d_0": float(np.sin(slenderness))}
    return runner.Case("rocking block, pushover, rigid", run, "increment", INCREMENTS, measure, exact)


def _peak(curve: Pushover) -> dict[str, float]:
    return {"α_u": curve.alpha_0}


def limit(name: str, model: Assembly) -> runner.Case:
    """Limit analysis by PIQP at several of its tolerances, against HiGHS."""
    program, title = runner.pushed_program(model), f"{name}, limit analysis"
    exact: Any = lp_highs.solve(program)
    return runner.Case(
        title, partial(qp_piqp.solve, program), "tolerance", TOLERANCES, lambda answer: {"α_0": answer[1]},
        {"α_0": exact[1]}, default=1e-9, baseline=lambda _: ([program], 1),
    )  # fmt: skip


def settling(name: str, contacts: Behaviour, values: Sequence[float] = INCREMENTS) -> runner.Case:
    """Pushdown to collapse: the movement at which the structure falls, and the reaction of the moved support."""
    movement = max(map(abs, runner.template(name).settlements[0].displacement_m))

    def measure(path: Pushdown) -> dict[str, float]:
        at = int(np.argmin(abs(path.movement - movement)))
        found = {"reaction": float(np.hypot(*path.reaction[at]))}
        return found if path.ultimate is None else {**found, "ultimate movement": path.ultimate}

    title = f"{name.replace('-', ' ')}, pushdown, {contacts}"
    run = partial(runner.settled, name, contacts, to_collapse=True)
    return runner.Case(title, run, "increment", values, measure, reference=0.5 * values[-1])


def pushing(
    name: str, contacts: Behaviour, values: Sequence[float] = INCREMENTS, moved: bool = False
) -> runner.Case:
    """Pushover as drawn, or settled: rigid, where the multiplier comes down to zero; elastic, its peak."""
    at_rest = cache(lambda: runner.settled(name, contacts).final)

    def run(times: float) -> Pushover:
        return runner.pushed(name, "+x", contacts, times, at_rest() if moved else None)

    title = f"{name.replace('-', ' ')}, {'settled, ' if moved else ''}pushover, {contacts}"
    measure = _peak if contacts == "elastic" else lambda curve: {"d_0": float(curve.displacement[-1])}
    return runner.Case(title, run, "increment", values, measure, reference=0.5 * values[-1])


def beds(name: str, moved: Direction | None = None) -> runner.Case:
    """The elastic peak of beds of points and of the exact one, as drawn towards +x or settled towards `moved`."""
    at_rest = cache(lambda segments: runner.settled(name, "elastic", 1.0, segments).final)

    def run(number: float) -> Pushover:
        fine, segments = 0.25 if number == FINE else 1.0, None if np.isinf(number) else round(number)
        start = at_rest(segments) if moved else None
        return runner.pushed(name, moved or "+x", "elastic", fine, start, segments)

    title = f"{name.replace('-', ' ')}, {f'settled, {moved}' if moved else 'pushover'}, elastic"
    values = SETTLED_SEGMENTS if moved else SEGMENTS
    return runner.Case(title, run, "segments", values, _peak, reference=FINE, default=np.inf)


def sliding(quick: bool) -> Iterator[runner.Row]:
    """α_0 and where the curve ends over variants, by structure and law of sliding, then by increment."""
    small = runner.running_bond(2, 5, 0.341, 0.15, 0.78, full_on_top=False)
    x, z = map(float, small.blocks[-1].centroid)
    cases = [
        ("wall of 13 blocks", small, (x, z), 0.005),
        ("Ferris and Tin-Loi's wall 1", runner.running_bond(), (5 * 0.4, 6 * 0.175), 0.005),
    ]
    if not quick:  # wall 2 is inferred from its multiplier: tests/validation/test_masonry_wall.py
        wall = runner.running_bond(5, 10)
        cases.append(("Ferris and Tin-Loi's wall 2", wall, (5 * 0.4, 10 * 0.175), 0.005))
        whole = (ARCH, TRIUMPHAL)
        cases += [(name.replace("-", " "), runner.assembly(name), *runner.control(name)) for name in whole]
    laws: tuple[Sliding, ...] = ("associative", "coulomb")
    for name, model, at, increment in cases:
        for law in laws:
            row = {"case": name, "law": law, "alpha": limit_analysis(model, sliding=law).alpha}
            yield row | ends(model, at, increment, law, (1.0, *np.linspace(*ENSEMBLE.increments, 5)), True)
            for factor in (0.5, 0.7, 1.0, 1.4, 2.0):
                yield row | {"factor": factor} | ends(model, at, factor * increment, law)


def ends(
    model: Assembly, at: tuple[float, float], increment: float, law: Sliding, factors: Sequence[float] = (1.0,),
    frames: bool = False,
) -> runner.Row:  # fmt: skip
    """Range (m) of ends that must not differ: of other increments, corners moved by rounding, units, origins."""
    tried = [(model, factor, 1.0, (0.0, 0.0), 1.0) for factor in factors]
    tried += [(shaken_corners(model, seed), 1.0, 1.0, (0.0, 0.0), 1.0) for seed in range(3)]
    if frames:
        others = [(1000.0, (0.0, 0.0), 1.0), (1.0, (137.3, -41.9), 1.0), (1.0, (0.0, 0.0), 37.0)]
        tried += [(model, 1.0, *frame) for frame in others]
    found, seconds = [], []
    for each, factor, length, (x, z), weight in tried:
        point = (length * at[0] + x, length * at[1] + z)
        step, moved = length * factor * increment, runner.in_frame(each, length, (x, z), weight)
        try:
            push = partial(pushover, moved, point, "+x", "rigid", step, sliding=law)
            taken, curve = runner.seconds_of(push)
        except runner.FAILURES:
            continue
        seconds.append(taken)
        found.append(float(curve.displacement[-1]) / length)
    row: runner.Row = {"variants": len(tried), "not_solved": len(tried) - len(found)}
    if not found:
        return row | {"failed": "no variant is solved"}
    row |= {"least_end_m": min(found), "median_end_m": float(np.median(found)), "most_end_m": max(found)}
    return row | {"seconds": float(np.median(seconds))}


WAYS: tuple[Direction, ...] = ("+x", "-x")
CONTACTS: tuple[Behaviour, ...] = ("rigid", "elastic")


def chain(quick: bool) -> Iterator[runner.Row]:
    """Pushdown, rigid and elastic pushover of both states and directions, one by one and together; whole commands."""
    for name in ("buttressed-arch",) if quick else ("buttressed-arch", "triumphal-arch"):
        yield from analyses(name)
        with TemporaryDirectory() as out:
            arguments = ("run", str(runner.template(name).folder), "--out", out)
            statics = (*arguments, "--only", "pushdown,pushover", "--no-report", "--fresh")
            yield command(f"assesto run, {name.replace('-', ' ')}, statics", *statics)
            if not quick:
                yield command(f"assesto run, {name.replace('-', ' ')}, to the PDF", *arguments)
                yield command("assesto run again, nothing changed", *arguments)
    yield command("assesto --help", "--help")


def analyses(name: str) -> Iterator[runner.Row]:
    """Every analysis of a template on one processor; last, of all together."""
    rows: list[runner.Row] = []
    for contacts in CONTACTS:
        mirror, paths = Mirror.of(runner.assembly(name), contacts), dict[str, Any]()
        for title, way in [("pushdown", None), *product(("original", "settled"), WAYS)]:
            if title == "settled" and "pushdown" not in paths:
                continue
            work = partial(_path, name, title, way, contacts, paths, mirror)
            full = f"{title}, pushover {way}" if way else title
            with suppress(*runner.FAILURES):
                paths[full] = work(1.0)
            rows += runner.rows_of(runner.Case(f"{name.replace('-', ' ')}, {full}, {contacts}", work))
            yield rows[-1]
    solved = [row for row in rows if row.get("failed") is None]
    total: runner.Row = {field: sum(row.get(field, 0) for row in rows) for field in ("steps", "seconds")}
    total["ratio"] = total["seconds"] / sum(row["seconds"] / row["ratio"] for row in solved)
    lost = len(rows) - len(solved)
    failed = f"{lost} of {len(rows)}, and what depends on them" if lost else None
    yield {"case": f"{name.replace('-', ' ')}, static chain", "whole": True, "failed": failed} | total


def _path(
    name: str, title: str, way: Direction | None, contacts: Behaviour, paths: dict[str, Any], mirror: Mirror | None,
    _: float,
) -> Any:  # fmt: skip
    """The movement of a template, or its curve as drawn or settled; as drawn towards −x by reflection if exact."""
    if way is None:
        return runner.settled(name, contacts)
    other = paths.get("original, pushover +x") if way == "-x" and title == "original" else None
    if mirror and other and (image := mirror.pushover(other)):
        return image
    state = paths["pushdown"].final if title == "settled" else None
    return runner.pushed(name, way, contacts, 1.0, state, None, PAST_PEAK if contacts == "elastic" else 0.0)


def command(case: str, *arguments: str) -> runner.Row:
    """Processor time and time elapsed of a whole command."""
    before = os.times()
    subprocess.run([sys.executable, "-m", "assessment.cli", *arguments], check=True, capture_output=True)
    _, _, user, system, elapsed = (now - then for now, then in zip(os.times(), before, strict=True))
    return {"case": case, "whole": True, "seconds": user + system, "elapsed_s": elapsed}


WALLS = {100: (10, 10), 300: (17, 17), 1000: (31, 31), 3000: (55, 54), 10000: (100, 100)}  # by blocks
COMPARED, FITTED, REPEATED = (400, 200, 3000)  # blocks: by HiGHS up to, fitted from, repeated up to


def walls(quick: bool) -> Iterator[runner.Row]:
    """A row for every running-bond wall, in a process of its own; last, the exponent of time over blocks."""
    rows = []
    for blocks, size in WALLS.items():
        if not quick or blocks <= 1000:
            rows.append(apart(*size))
            yield rows[-1]
    fitted = runner.exponent([row for row in rows if row["blocks"] >= FITTED], "seconds")
    yield {"case": f"exponent, from {FITTED} blocks", "seconds": fitted}


def apart(columns: int, courses: int) -> runner.Row:
    """The row of a wall, measured in another process."""
    command = [sys.executable, "-m", __name__, str(columns), str(courses)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def measured(columns: int, courses: int) -> runner.Row:
    """Times (s) of building a wall and of its limit analysis; memory (MB), α_0, residual, error against HiGHS."""
    limit_analysis(runner.running_bond(8, 8), sliding="associative")  # what is imported and compiled once
    building, model = runner.seconds_of(lambda: runner.running_bond(columns, courses))
    seconds, found = runner.seconds_of(lambda: limit_analysis(model, sliding="associative"))
    blocks, memory, program = int(model.movable.sum()), runner.peak_memory(), runner.pushed_program(model)
    baseline = runner.seconds_of(runner.piqp(program))[0]
    if blocks <= REPEATED:
        solve = partial(limit_analysis, model, sliding="associative")
        seconds, baseline = map(float, runner.in_turn(solve, runner.piqp(program)))
    row: runner.Row = {"case": f"wall {columns} × {courses}", "blocks": blocks, "joints": len(model.contacts)}
    row |= {"building_s": building, "seconds": seconds, "ratio": seconds / baseline, "memory_MB": memory}
    row |= {"alpha": found.alpha, "certificate": found.certificate.worst(1e-3 * model.size)}
    if blocks > COMPARED:
        return row | {"error": math.nan}
    highs, answer = runner.seconds_of(lambda: lp_highs.solve(program))
    assert answer is not None
    return row | {"error": abs(found.alpha / answer[1] - 1.0), "highs_s": highs}


if __name__ == "__main__":
    print(json.dumps(measured(int(sys.argv[1]), int(sys.argv[2]))))
