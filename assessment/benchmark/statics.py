"""Statics: run time against error as increments shrink, joints get more segments, the solver more exact."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np

from assessment.benchmark.measure import Row, once_a_step
from assessment.benchmark.structures import assembly, block_on_base, running_bond, template
from mechanics import Assembly, pushdown, pushover
from mechanics.assembly import Behaviour
from mechanics.equilibrium import closed_program
from mechanics.program import Program
from mechanics.pushdown import Pushdown
from mechanics.pushover import Pushover
from mechanics.solvers import interior_point, linear
from mechanics.types import Array

Parameter = Literal["increment", "segments", "tolerance"]
Errors = dict[str, float]

INCREMENTS, FINEST_INCREMENT = (4.0, 2.0, 1.0, 0.5), 0.25  # times the template's
FEWER_INCREMENTS, FEWER_FINEST = (4.0, 2.0, 1.0), 0.5
# of a joint; the buttressed arch has twice as many in its piers
SEGMENTS, FINEST_SEGMENTS = (1, 2, 4, 8, 16, 32), 64
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12)
WIDTH, HEIGHT, STIFFNESS = 1.0, 4.0, 1e6  # of the block with an elastic joint: m, m, kN/m³


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


def statics(quick: bool) -> Iterator[Row]:
    """Every case: a row for each value of its parameter and each quantity that is measured."""
    for case in cases(quick):
        yield from precision(case)


def precision(case: Case) -> Iterator[Row]:
    """Processor time, its ratio to PIQP once a step, and the relative errors."""
    exact = case.exact or case.measure(case.run(case.reference))
    for value in case.values:
        run = partial(case.run, value)
        result = run()
        programs = [result[0]] if isinstance(result, tuple) else [step.program for step in result.steps]
        seconds, ratio = once_a_step(run, programs)
        for quantity, found in case.measure(result).items():
            yield {
                "case": case.name,
                "parameter": case.parameter,
                "value": value,
                "default": value == case.default,
                "quantity": quantity,
                "found": found,
                "error": abs(found / exact[quantity] - 1.0),
                "steps": len(programs),
                "seconds": seconds,
                "ratio": ratio,
            }


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
        pushing("buttressed-arch", "elastic"),
        pushing("buttressed-arch", "rigid", settled=True),
        settling("buttressed-arch", "elastic"),
        segments("buttressed-arch"),
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
        model = block_on_base(WIDTH, HEIGHT, stiffness=STIFFNESS, segments=round(number))
        return pushover(model, (WIDTH, HEIGHT), contacts="elastic", increment=0.02)

    def measure(curve: Pushover) -> Errors:
        lean = np.array([-state.positions[1, 2] for state in curve.states])
        off = float(abs(curve.multiplier - winkler(lean)).max()) / highest
        return {"α": 1.0 + off, "α_u": float(curve.multiplier.max()) / highest}

    exact = {"α": 1.0, "α_u": 1.0}
    return Case("rocking block, pushover, elastic", "segments", SEGMENTS, run, measure, exact, default=16)


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
    program = closed_program(model, model.initial, model.lateral_load("+x"))[0]
    second = linear.solve(program)
    assert second is not None

    def run(tolerance: float) -> tuple[Program, float]:
        answer = interior_point.solve(program, tolerance)
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
    state = None
    if settled:
        (table,) = project.settlements
        assert table.increment_m is not None
        state = pushdown(
            model, table.support, table.displacement_m, increment=table.increment_m, contacts=contacts
        ).final

    def run(times: float) -> Pushover:
        return pushover(model, control, "+x", contacts, times * increment, state)

    def measure(curve: Pushover) -> Errors:
        if contacts == "elastic":
            return {"α_u": float(curve.multiplier.max())}
        return {"d_0": float(curve.displacement[-1])}

    of = "settled, " if settled else ""
    return _incremental(f"{_spoken(name)}, {of}pushover, {contacts}", run, measure, fewer)


def segments(name: str) -> Case:
    """The peak of the elastic curve as joints get more segments."""
    project = template(name)
    assert project.pushover is not None
    control, increment = project.pushover_control("+x").point_m, project.pushover.increment_m

    def run(number: float) -> Pushover:
        return pushover(
            assembly(name, number / project.geometry.segments_per_joint), control, "+x", "elastic", increment
        )

    def measure(curve: Pushover) -> Errors:
        return {"α_u": float(curve.multiplier.max())}

    title = f"{_spoken(name)}, pushover, elastic"
    return Case(title, "segments", SEGMENTS, run, measure, reference=FINEST_SEGMENTS, default=16)


def _incremental(
    name: str, run: Callable[[float], Any], measure: Callable[[Any], Errors], fewer: bool
) -> Case:
    values, finest = (FEWER_INCREMENTS, FEWER_FINEST) if fewer else (INCREMENTS, FINEST_INCREMENT)
    return Case(name, "increment", values, run, measure, reference=finest)


def _spoken(template_name: str) -> str:
    return template_name.replace("-", " ")
