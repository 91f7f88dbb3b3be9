"""Both laws of friction: limit analysis, closed forms of what slides, and the paths of an arch."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import get_args

import numpy as np

from assessment.benchmark.cases.structures import (
    assembly,
    block_on_base,
    control,
    rectangle,
    running_bond,
    template,
)
from assessment.benchmark.measure import FAILURES, seconds_of
from assessment.benchmark.table import Row
from mechanics import Assembly, Block, Material, State, limit_analysis, pushdown, pushover, time_history
from mechanics.steps.static_step import Equilibrium
from mechanics.steps.static_system import Sliding
from mechanics.types import GRAVITY

LAWS: tuple[Sliding, ...] = tuple(reversed(get_args(Sliding)))
SLOPE = float(np.radians(20.0))  # of the wedge from vertical, of the incline from level


def limits(quick: bool) -> Iterator[Row]:
    """α_0 by the associative law; by Coulomb's law that of the central flow, the least found, and its residual."""
    models = {
        "Ferris and Tin-Loi's wall 1": running_bond(),
        "Ferris and Tin-Loi's wall 2, inferred": running_bond(5, 10),
        "wall of 13 blocks": running_bond(2, 5, 0.341, 0.15, 0.78, full_on_top=False),
    }
    if not quick:
        models |= {name.replace("-", " "): assembly(name) for name in ("triumphal-arch", "buttressed-arch")}
    for name, model in models.items():
        lifting, one = seconds_of(partial(limit_analysis, model, sliding="associative"))
        least, other = seconds_of(partial(limit_analysis, model, sliding="coulomb"))
        yield {
            "parameter": "limit analysis", "case": name, "associative_g": one.alpha, "central_g": other.central,
            "least_g": other.alpha, "residual": other.certificate.worst(1e-3 * model.size),
            "associative_s": lifting, "coulomb_s": least,
        }  # fmt: skip


def closed_forms() -> Iterator[Row]:
    """Closed forms, and both laws."""
    forms: dict[str, tuple[float, Callable[[Sliding], float]]] = {
        "wedge, way down over the opening": (1.0 / (2.0 * np.tan(SLOPE)), wedge),
        "incline, way down over the way of the incline": (np.tan(SLOPE), incline),
        "sliding block, m": (0.5 * GRAVITY * 0.5**2 * 0.3 * 0.6 / 0.3, sliding_block),
        "wall beside a support, end, m": (3.0 * np.sin(np.arctan(1.0 / 6.0)), beside_support),
        "beam between walls, fall in 0.3 s, m": (0.5 * GRAVITY * 0.3**2, beam_between_walls),
    }
    for name, (exact, measure) in forms.items():
        row: Row = {"parameter": "closed forms", "case": name, "exact": f"{exact:.5f}"}
        yield row | {law: f"{measure(law):.5f}" for law in LAWS}


def wedge(law: Sliding) -> float:
    """A voussoir between two supports, of which one goes away by 20 mm in steps of 5 mm; μ = 0.3."""
    stone, out = Material(20.0, 0.3), 0.4 * np.tan(SLOPE)
    blocks = [
        Block([[-0.5, 0.0], [0.5, 0.0], [0.5 + out, 0.4], [-0.5 - out, 0.4]], 1.0, stone),
        Block([[-1.5, 0.0], [-0.5, 0.0], [-0.5 - out, 0.4], [-1.5, 0.4]], 1.0, stone, support="left"),
        Block([[0.5, 0.0], [1.5, 0.0], [1.5, 0.4], [0.5 + out, 0.4]], 1.0, stone, support="right"),
    ]
    return _went_down(Assembly(blocks), "right", 0.02, law)


def incline(law: Sliding) -> float:
    """A block on an incline and against a wall; the incline goes away by 20 mm in steps of 5 mm; μ = 0.5."""
    stone, fall = Material(20.0, 0.5), float(np.tan(SLOPE))
    blocks = [
        Block([[0.0, 0.0], [1.0, -fall], [1.0, 1.0], [0.0, 1.0]], 1.0, stone),
        Block([[-1.0, -2.5], [3.0, -2.5], [3.0, -3.0 * fall], [-1.0, fall]], 1.0, stone, support="base"),
        Block(rectangle(-0.5, 0.45, 0.0, 3.0), 1.0, stone, support="wall"),
    ]
    return _went_down(Assembly(blocks), "base", -0.02, law)


def _went_down(model: Assembly, support: str, way: float, law: Sliding) -> float:
    """How far the first block goes down, of the horizontal way (m) of a support."""
    path = pushdown(model, support, (way, 0.0), increment=0.005, sliding=law)
    return float(path.states[0].positions[0, 1] - path.states[-1].positions[0, 1]) / abs(way)


def sliding_block(law: Sliding) -> float:
    """How far a block of μ = 0.3 slides under 0.6 g for 0.5 s and after it: g T² (A − μ) A/2μ; steps of 1 ms."""
    pulse = np.where((np.arange(1801) > 100) & (np.arange(1801) <= 600), 0.6, 0.0)
    motion = time_history(block_on_base(1.0, 0.5, friction=0.3), pulse, 0.001, "rigid", sliding=law)
    return float(abs(motion.positions[-1, 1, 0] - motion.positions[0, 1, 0]))


def beside_support(law: Sliding) -> float:
    """Where the curve of a wall of 0.5 × 3 m ends that leans away from a support, 0.5 mm beside it; μ = 0.6."""
    stone = Material(18.0, 0.6)
    blocks = [
        Block(rectangle(-2.0, -0.3, 2.0, 0.0), 1.0, stone, support="base"),
        Block(rectangle(0.0, 0.0, 0.5, 3.0), 1.0, stone),
        Block(rectangle(-0.5005, 0.0, -0.0005, 3.0), 1.0, stone, support="neighbour"),
    ]
    return float(pushover(Assembly(blocks), (0.5, 3.0), "+x", increment=0.01, sliding=law).displacement[-1])


def beam_between_walls(law: Sliding) -> float:
    """How far a beam falls in 0.3 s that fits between two walls, unpressed; elastic joints, steps of 5 ms."""
    stone = Material(20.0, 0.84, 1e6)
    blocks = [
        Block(rectangle(-0.5, 0.0, 0.0, 2.0), 1.0, stone, support="left"),
        Block(rectangle(1.8, 0.0, 2.3, 2.0), 1.0, stone, support="right"),
        Block(rectangle(0.0, 1.0, 1.8, 1.8), 1.0, stone),
    ]
    motion = time_history(Assembly(blocks), np.zeros(61), 0.005, "elastic", sliding=law)
    return float(motion.positions[0, 2, 1] - motion.positions[-1, 2, 1])


def paths(name: str) -> Iterator[Row]:
    """A template's rigid curve, movement, curve after it, and ultimate movement: programs, time, and where it ends."""
    model, (point, increment), (moved,) = assembly(name), control(name), template(name).settlements
    assert moved.increment_m is not None
    state: dict[Sliding, State] = {}

    def push(law: Sliding, start: State | None) -> Row:
        run = partial(pushover, model, point, "+x", "rigid", increment, start, sliding=law)
        seconds, curve = seconds_of(run)
        return _told(law, seconds, curve.steps, curve.lifting, float(curve.displacement[-1]))

    def move(law: Sliding, to_collapse: bool) -> Row:
        run = partial(
            pushdown, model, moved.support, moved.displacement_m, 0.0, moved.increment_m, to_collapse=to_collapse,
            sliding=law,
        )  # fmt: skip
        seconds, path = seconds_of(run)
        state[law] = path.final
        end = float(path.movement[-1]) if path.ultimate is None else path.ultimate
        return _told(law, seconds, path.steps, path.lifting, end)

    works: dict[str, Callable[[Sliding], Row]] = {
        "rigid curve, d_0": lambda law: push(law, None),
        "movement": lambda law: move(law, False),
        "curve after it, d_0": lambda law: push(law, state[law]),
        "ultimate movement": lambda law: move(law, True),
    }
    for title, work in works.items():
        row: Row = {"parameter": f"{name.replace('-', ' ')}, rigid joints", "case": title}
        for law in LAWS:
            try:
                row |= work(law)
            except FAILURES as error:
                row |= {f"{law}_end_m": str(error)}
        yield row


def _told(law: Sliding, seconds: float, steps: Sequence[Equilibrium], lifting: int, end: float) -> Row:
    programs = sum(step.solves for step in steps)
    return {f"{law}_end_m": end, f"{law}_programs": programs, f"{law}_lifting": lifting, f"{law}_s": seconds}
