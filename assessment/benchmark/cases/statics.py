"""Statics: run time against error as increments shrink, of beds of points and the exact one, of looser solvers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any, Literal

import numpy as np

from assessment.benchmark.cases.structures import assembly, block_on_base, rectangle, running_bond, template
from assessment.benchmark.measure import FAILURES, beside_piqp, once_a_step
from assessment.benchmark.table import Precision
from mechanics import Assembly, Block, Material, State, pushdown, pushover
from mechanics.model.assembly import Behaviour, Direction
from mechanics.procedures.pushdown import Pushdown
from mechanics.procedures.pushover import Pushover
from mechanics.program import Program
from mechanics.solvers import lp_highs, qp_piqp
from mechanics.steps.equilibrium import closed_program
from mechanics.types import Array

Parameter = Literal["increment", "segments", "tolerance"]
Errors = dict[str, float]

INCREMENTS, FINEST_INCREMENT = (4.0, 2.0, 1.0, 0.5), 0.25  # times the template's
FEWER_INCREMENTS, FEWER_FINEST = (4.0, 2.0, 1.0), 0.5
SEGMENTS = (1, 2, 4, 8, 16, 32, 64, np.inf)  # of a joint; infinite: the exact bed
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12)
FEWER_SEGMENTS = (1, 4, 16, 64, np.inf)
REFERENCE = -np.inf  # the exact bed, in a quarter of the increments
WIDTH, HEIGHT, STIFFNESS = 1.0, 4.0, 1e6  # of the block with an elastic joint: m, m, kN/m³
# of elastic columns 0.5 m wide, 3 m high, 20 kN/m³: blocks, stiffness in kN/m³, α_u by integration along the column
COLUMNS = ((1, 2e4, 0.06671), (1, 2e5, 0.12026), (6, 1e5, 0.10145), (6, 1e6, 0.1383))


@dataclass(frozen=True, eq=False)
class Case:
    """An analysis at several values of a parameter; `measure` reads numbers off its result.

    Errors are relative to `exact` or, where that is None, to the result at the value `reference`.
    """

    name: str
    parameter: Parameter
    values: Sequence[float]
    run: Callable[[float], Any]
    measure: Callable[[Any], Errors]
    exact: Errors | None = None
    reference: float = 0.0
    default: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Point(Precision):
    """A `quantity` `found` at a value of the parameter, of a path of so many steps."""

    quantity: str = ""
    found: float = np.nan
    steps: int | None = None


def statics(quick: bool) -> Iterator[Point]:
    """Every case: a row for each value of its parameter and each quantity that is measured."""
    for case in cases(quick):
        yield from precision(case)


def precision(case: Case) -> Iterator[Point]:
    """Processor time, its ratio to PIQP once a step, and the relative errors; a failure is a row too."""
    row = Point(case=case.name, parameter=case.parameter, value=case.reference)
    try:
        exact = case.exact or case.measure(case.run(case.reference))
    except FAILURES as error:
        yield replace(row, failed=str(error))
        return
    for value in case.values:
        row = replace(row, value=value, default=value == case.default)
        run = partial(case.run, value)
        try:
            result = run()
        except FAILURES as error:
            yield from (replace(row, quantity=quantity, failed=str(error)) for quantity in exact)
            continue
        if isinstance(result, tuple):
            steps, (seconds, each) = 1, beside_piqp(run, [result[0]])
            ratio = seconds / each
        else:
            steps, (seconds, ratio) = len(result.steps), once_a_step(run, result)
        for quantity, found in case.measure(result).items():
            yield replace(
                row,
                quantity=quantity,
                found=found,
                error=abs(found / exact[quantity] - 1.0),
                steps=steps,
                seconds=seconds,
                ratio=ratio,
            )


def cases(quick: bool) -> list[Case]:
    """From one block to the triumphal arch; quick: without the latter, and fewer values."""
    some = [
        rocking_rigid(),
        rocking_elastic(),
        wall("Ferris and Tin-Loi's wall 1", running_bond()),
        settling("buttressed-arch", "rigid", quick),
        pushing("buttressed-arch", "rigid", quick),
    ]
    if quick:
        return some
    return [
        *some,
        *(column(*values) for values in COLUMNS),
        pushing("buttressed-arch", "elastic"),
        pushing("buttressed-arch", "rigid", settled=True),
        settling("buttressed-arch", "elastic"),
        beds("buttressed-arch"),
        *(beds("buttressed-arch", way) for way in ("+x", "-x")),
        wall("triumphal arch", assembly("triumphal-arch")),
        settling("triumphal-arch", "rigid", fewer=True),
        pushing("triumphal-arch", "rigid", fewer=True),
        pushing("triumphal-arch", "elastic", fewer=True),
        pushing("triumphal-arch", "rigid", fewer=True, settled=True),
    ]


def rocking_rigid() -> Case:
    """A rigid block: α = tan(arctan(B/H) − θ) at every point, zero at a displacement H sin(arctan(B/H))."""
    model, slenderness = block_on_base(), float(np.arctan(0.2))

    def run(times: float) -> Pushover:
        return pushover(model, (0.2, 1.0), increment=0.005 * times)

    def measure(curve: Pushover) -> Errors:
        lean = np.array([-state.positions[1, 2] for state in curve.states])
        off = float(abs(curve.multiplier - np.tan(slenderness - lean)).max())
        return {"α": 1.0 + off / 0.2, "d_0": float(curve.displacement[-1])}

    exact = {"α": 1.0, "d_0": float(np.sin(slenderness))}
    return Case("rocking block, pushover, rigid", "increment", INCREMENTS, run, measure, exact)


def rocking_elastic() -> Case:
    """A rigid block on an elastic joint, the whole curve: a Winkler bed without tension."""
    highest = float(winkler(np.geomspace(1e-6, 0.1, 1000)).max())

    def run(number: float) -> Pushover:
        model = block_on_base(WIDTH, HEIGHT, stiffness=STIFFNESS, segments=_segments(number))
        return pushover(model, (WIDTH, HEIGHT), contacts="elastic", increment=0.02)

    exact = {"α_u": highest}
    return Case("rocking block, pushover, elastic", "segments", SEGMENTS, run, _peak, exact, default=np.inf)


def column(count: int, stiffness: float, strength: float) -> Case:
    """The strength α_u of a column of blocks with elastic joints, see COLUMNS."""

    def run(number: float) -> Pushover:
        stone, height = Material(20.0, 0.6, stiffness), 3.0 / count
        base = Block(rectangle(-0.5, -0.1, 1.0, 0.0), 1.0, stone, support="base")
        drums = [Block(rectangle(0.0, k * height, 0.5, (k + 1) * height), 1.0, stone) for k in range(count)]
        model = Assembly([base, *drums], _segments(number))
        return pushover(model, (0.5, 3.0), contacts="elastic", increment=0.005)

    return Case(
        f"column of {count} with k = {stiffness:.0e}, pushover, elastic".replace("e+0", "e"),
        "segments",
        FEWER_SEGMENTS,
        run,
        _peak,
        {"α_u": strength},
        default=np.inf,
    )


def _segments(number: float) -> int | None:
    """As an assembly takes them; None: the exact bed."""
    return None if np.isinf(number) else round(number)


def _peak(curve: Pushover) -> Errors:
    return {"α_u": float(curve.multiplier.max())}


def winkler(lean: Array) -> Array:
    """Multipliers (k,) at which the block leans so: e = H/2 (α + φ) is the eccentricity of weight and load.

    Up to e = B/6 the joint is closed and W e = k d B³/12 · φ; beyond, contact is left over 3(B/2 − e).
    """
    weight = 18.0 * WIDTH * HEIGHT
    e = STIFFNESS * WIDTH**3 / 12.0 * lean / weight
    contact = np.sqrt(2.0 * weight / (STIFFNESS * np.maximum(lean, 1e-9)))
    e = np.where(e <= WIDTH / 6.0, e, WIDTH / 2.0 - contact / 3.0)
    alpha: Array = 2.0 * e / HEIGHT - lean
    return alpha


def wall(name: str, model: Assembly) -> Case:
    """Limit analysis by PIQP at several of its tolerances, against HiGHS."""
    program = closed_program(model, model.initial).pushed(model, model.lateral_load("+x")).program
    second = lp_highs.solve(program)
    assert second is not None

    def run(tolerance: float) -> tuple[Program, float]:
        answer = qp_piqp.solve(program, tolerance)
        assert answer is not None
        return program, answer[1]

    return Case(
        f"{name}, limit analysis",
        "tolerance",
        TOLERANCES,
        run,
        lambda result: {"α_0": result[1]},
        {"α_0": second[1]},
        default=1e-9,
    )


def settling(name: str, contacts: Behaviour, fewer: bool = False) -> Case:
    """Pushdown to collapse: the movement at which the structure falls, and the reaction of the moved support."""
    project, model = template(name), assembly(name)
    (table,) = project.settlements
    assert table.increment_m is not None
    increment = table.increment_m
    movement = max(map(abs, table.displacement_m))

    def run(times: float) -> Pushdown:
        return pushdown(
            model, table.support, table.displacement_m, 0.0, times * increment, contacts, to_collapse=True
        )

    def measure(path: Pushdown) -> Errors:
        at = int(np.argmin(abs(path.movement - movement)))
        found = {"reaction": float(np.hypot(*path.reaction[at]))}
        return found if path.ultimate is None else {**found, "ultimate movement": path.ultimate}

    return _incremental(f"{_spoken(name)}, pushdown, {contacts}", run, measure, fewer)


def pushing(name: str, contacts: Behaviour, fewer: bool = False, settled: bool = False) -> Case:
    """Pushover as drawn, or settled: rigid, where the multiplier comes down to zero; elastic, its peak."""
    project, model = template(name), assembly(name)
    assert project.pushover is not None
    control, increment = project.pushover_control("+x").point_m, project.pushover.increment_m
    at_rest = cache(partial(settled_state, name, contacts))

    def run(times: float) -> Pushover:
        return pushover(model, control, "+x", contacts, times * increment, at_rest() if settled else None)

    def measure(curve: Pushover) -> Errors:
        if contacts == "elastic":
            return {"α_u": float(curve.multiplier.max())}
        return {"d_0": float(curve.displacement[-1])}

    of = "settled, " if settled else ""
    return _incremental(f"{_spoken(name)}, {of}pushover, {contacts}", run, measure, fewer)


def settled_state(name: str, contacts: Behaviour, segments: int | None = None) -> State:
    """A template after its movement; `segments` of its joints, None: the exact bed."""
    (table,) = template(name).settlements
    assert table.increment_m is not None
    model = assembly(name, segments)
    return pushdown(
        model, table.support, table.displacement_m, increment=table.increment_m, contacts=contacts
    ).final


def beds(name: str, settled: Direction | None = None) -> Case:
    """The peak of the elastic curve, of beds of points and of the exact one in a quarter of the increments.

    As drawn towards +x; or towards a direction after its movement, which every bed goes through by itself.
    """
    project, way = template(name), settled or "+x"
    assert project.pushover is not None
    control, increment = project.pushover_control(way).point_m, project.pushover.increment_m
    at_rest = cache(partial(settled_state, name, "elastic"))

    def run(number: float) -> Pushover:
        fine, segments = 0.25 if number == REFERENCE else 1.0, _segments(abs(number))
        state = at_rest(segments) if settled else None
        return pushover(assembly(name, segments), control, way, "elastic", fine * increment, state)

    of = f"settled, {way}" if settled else "pushover"
    title, values = f"{_spoken(name)}, {of}, elastic", FEWER_SEGMENTS if settled else SEGMENTS
    return Case(title, "segments", values, run, _peak, reference=REFERENCE, default=np.inf)


def _incremental(
    name: str, run: Callable[[float], Any], measure: Callable[[Any], Errors], fewer: bool
) -> Case:
    values, finest = (FEWER_INCREMENTS, FEWER_FINEST) if fewer else (INCREMENTS, FINEST_INCREMENT)
    return Case(name, "increment", values, run, measure, reference=finest)


def _spoken(template_name: str) -> str:
    return template_name.replace("-", " ")
