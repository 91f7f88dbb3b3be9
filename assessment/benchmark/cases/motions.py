"""Motions: run time against error, ensembles, what time stepping dissipates, collapse, and the time of a step."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np
from scipy.stats import binom

from assessment.benchmark.cases.structures import (
    assembly,
    block_on_base,
    control,
    rectangle,
    running_bond,
    template,
)
from assessment.benchmark.measure import FAILURES, Case, exponent, history_baseline, rows_of
from assessment.benchmark.table import Row, percent
from assessment.project.catalogue.new_project import RECORD
from mechanics import (
    Assembly,
    Block,
    ConvergenceError,
    Material,
    State,
    TimeHistory,
    read_record,
    time_history,
)
from mechanics.model.assembly import Behaviour
from mechanics.procedures.time_history import HISTORY, HistoryTolerances, Integrator
from mechanics.types import Array

Wave = Callable[[Array], Array]
"""Base accelerations (k,) in g at times (k,) s."""

INTEGRATORS: dict[Behaviour, tuple[Integrator, ...]] = {
    "rigid": ("implicit-euler", "moreau-jean", "second-order"),
    "elastic": ("implicit-euler", "second-order"),
}
STEPS, FINE, STEP = (0.02, 0.01, 0.005, 0.0025, 0.00125), 0.0003125, 0.005  # s
TOLERANCES, EXACT = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7), 1e-8  # of a step
WALLS, QUICK_WALLS = ((9, 10), (18, 19), (31, 32), (54, 55)), ((6, 6), (9, 10), (14, 14))
DAMPING, SHORT = 0.05, 0.49  # ratio; s, of motions of large structures
ARCH, TRIUMPHAL = "buttressed-arch", "triumphal-arch"


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion to be computed at several steps.

    `damping`: ratio; `displaced` (m): where the control point begins; `after` (s): from when on its largest
    displacement counts; `exact`: that displacement (m) where there is a closed form.
    """

    name: str
    model: Assembly
    contacts: Behaviour
    control: tuple[float, float] | None
    duration: float
    record: Wave
    damping: float = 0.0
    state: State | None = None
    displaced: float = 0.0
    after: float = 0.0
    exact: float | None = None

    def run(
        self, step: float, integrator: Integrator, tolerances: HistoryTolerances = HISTORY
    ) -> TimeHistory:
        """The motion at a time step (s)."""
        return time_history(
            self.model, self.acceleration(step), step, self.contacts, self.state, integrator, control=self.control,
            damping_ratio=self.damping, tolerances=tolerances,
        )  # fmt: skip

    def acceleration(self, step: float) -> Array:
        """Base accelerations (k,) in g, a time step (s) apart."""
        return self.record(step * np.arange(round(self.duration / step) + 1, dtype=float))

    def peak(self, motion: TimeHistory) -> float:
        """Largest control displacement (m): of the parabola through three samples."""
        assert motion.displacement is not None
        d = abs(motion.displacement + self.displaced)
        first = min(round(self.after / float(motion.time[1])), len(d) - 1)
        k = first + int(d[first:].argmax())
        if k in (first, len(d) - 1):
            return float(d[k])
        a, b, c = d[k - 1 : k + 2]
        return float(b - 0.125 * (a - c) ** 2 / min(a - 2.0 * b + c, -1e-300))

    def scaled(self, factor: float) -> Motion:
        """The same with its base motion multiplied by a factor."""
        return replace(self, record=lambda times: factor * self.record(times))

    def case(self, integrator: Integrator, values: Sequence[float] = (STEP,), **more: Any) -> Case:
        """The benchmark of an integrator at some time steps."""
        return Case(
            self.name, lambda step: self.run(step, integrator), "time step [s]", values, default=STEP, way=integrator,
            more=counted, baseline=lambda found: history_baseline(
                self.model, self.contacts, self.acceleration(float(found.time[1])), found
            ), **more,
        )  # fmt: skip


def shaking(amplitude: float, frequency: float = 1.5) -> Wave:
    """Two sines that grow over half a second, for two seconds; then rest."""

    def at(times: Array) -> Array:
        phase = 2.0 * np.pi * frequency * times
        envelope = np.minimum(times / 0.5, 1.0) * np.clip((2.0 - times) / 0.2, 0.0, 1.0)
        motion: Array = amplitude * envelope * (np.sin(phase) + 0.5 * np.sin(2.7 * phase + 1.0))
        return motion

    return at


def pulse(amplitude: float, duration: float) -> Wave:
    """A half sine."""
    return lambda times: amplitude * np.sin(np.pi * times / duration) * (times < duration)


def sine(amplitude: float, period: float = 0.5) -> Wave:
    """One sine."""
    return lambda times: amplitude * np.sin(2.0 * np.pi * times / period) * (times < period)


def strong_record(first: float = 4.0, last: float = 11.0) -> Wave:
    """A part (s) of the artificial record of the templates, at STEP, of unit peak."""
    record = read_record(template(TRIUMPHAL).folder / RECORD).resampled(STEP).windowed(first, last)
    return lambda times: np.interp(times, record.time, record.acceleration / record.pga)


def shaken_arch(contacts: Behaviour = "elastic", amplitude: float = 0.03) -> Motion:
    """The buttressed arch, shaken so that some of its joints open."""
    name, damping = f"buttressed arch, shaken, {contacts}", DAMPING if contacts == "elastic" else 0.0
    return Motion(name, assembly(ARCH), contacts, control(ARCH)[0], 3.0, shaking(amplitude), damping)


def rocking_freely() -> Motion:
    """A rigid block of 0.6 × 4.2 m released at half its slenderness α: the third peak, after impacts at 2.02 s.

    Housner (1963): θ'' = −p² sin(α − θ), and an impact leaves e² of the energy, e = 1 − 1.5 sin² α.
    """
    model, alpha = block_on_base(0.6, 4.2, stiffness=1e6), float(np.arctan(0.6 / 4.2))
    e, left = 1.0 - 1.5 * np.sin(alpha) ** 2, np.cos(0.5 * alpha) - np.cos(alpha)  # of the energy over W R
    third = alpha - float(np.arccos(np.cos(alpha) + left * e**4))
    return Motion(
        "rocking block, free, rigid", model, "rigid", (0.6, 4.2), 3.0, np.zeros_like,
        state=model.rotated(1, (0.6, 0.0), -0.5 * alpha), displaced=4.2 * float(np.sin(0.5 * alpha)), after=2.1,
        exact=4.2 * float(np.sin(third)),
    )  # fmt: skip


def stack() -> Motion:
    """Two blocks of 0.5 × 1.5 m upon each other under one sine."""
    stone = Material(18.0, 0.7, 1e6)
    base = Block(rectangle(-2.0, -0.2, 2.5, 0.0), 1.0, stone, support="base")
    two = [Block(rectangle(0.0, z, 0.5, z + 1.5), 1.0, stone) for z in (0.0, 1.5)]
    model = Assembly([base, *two])
    return Motion("stack of two, one sine, rigid", model, "rigid", (0.5, 3.0), 6.0, sine(0.5))


def dynamics(quick: bool) -> Iterator[Row]:
    """Error of the largest displacement against processor time, of every motion, integrator and step or tolerance."""
    soft, stiff = (block_on_base(0.6, 4.2, stiffness=stiffness) for stiffness in (1e5, 1e6))
    at, name = (0.6, 4.2), "rocking block, pulse"
    rigid = Motion(f"{name}, rigid", stiff, "rigid", at, 3.0, pulse(0.3, 0.5))
    elastic = Motion(f"{name}, elastic", soft, "elastic", at, 3.0, pulse(0.2, 0.5), DAMPING)
    for motion in (rocking_freely(), rigid, elastic, shaken_arch()):

        def measure(found: TimeHistory, motion: Motion = motion) -> dict[str, float]:
            return {"peak, m": motion.peak(found)}

        fine, steps = (4.0 * FINE, (0.02, STEP)) if quick else (FINE, STEPS)
        exact = {"peak, m": motion.exact or motion.peak(motion.run(fine, "second-order"))}
        for integrator in INTEGRATORS[motion.contacts]:
            yield from rows_of(motion.case(integrator, steps, measure=measure, exact=exact))
        if len(motion.model.blocks) > 2:

            def run(accepted: float, motion: Motion = motion) -> TimeHistory:
                return motion.run(STEP, "second-order", HistoryTolerances(accepted=accepted))

            case = motion.case("second-order", TOLERANCES, measure=measure)
            varied: dict[str, Any] = {
                "parameter": "tolerance",
                "run": run,
                "reference": EXACT,
                "default": HISTORY.accepted,
            }
            yield from rows_of(replace(case, **varied))


def counted(*motions: TimeHistory) -> Row:
    """What motions took, and what the integrator took of their energy."""
    steps = sum(len(motion.time) - 1 for motion in motions)
    return {
        "programs_per_step": sum(motion.programs for motion in motions) / steps,
        "iterations_per_step": sum(motion.iterations for motion in motions) / steps,
        "halvings": sum(motion.halvings for motion in motions),
        "cold": sum(motion.cold for motion in motions),
        "collapsed": sum(motion.collapsed for motion in motions),
        "integrator_share": float(np.median([motion.energy.integrator_share for motion in motions])),
        "imbalance": max(motion.energy.imbalance for motion in motions),
    }


def steps(quick: bool) -> Iterator[Row]:
    """A step of 5 ms of every structure, contact behaviour and integrator under a strong motion of unit peak."""
    strong, length = strong_record(), 1.0 if quick else 7.0
    structures = [
        ("2 blocks", block_on_base(0.6, 4.2, stiffness=1e6), 0.3, length),
        ("buttressed arch", assembly(ARCH), 0.03, length),
        ("wall 18 × 19", running_bond(18, 19, stiffness=1e7), 0.55, length),
        ("triumphal arch", assembly(TRIUMPHAL), 0.2, SHORT),
    ]
    for name, model, pga, duration in structures[: 2 if quick else None]:
        for contacts, integrators in INTEGRATORS.items():
            motion = Motion(name, model, contacts, None, duration, strong).scaled(pga)
            for integrator in integrators:
                yield from _sized(model, contacts, rows_of(motion.case(integrator)))


def growth(quick: bool) -> Iterator[Row]:
    """The same of walls, implicit Euler; and the exponent of the time of a step over the number of blocks."""
    for contacts in INTEGRATORS:
        rows: list[Row] = []
        for columns, courses in QUICK_WALLS if quick else WALLS:
            model, name = running_bond(columns, courses, stiffness=1e7), f"wall {columns} × {courses}"
            motion = Motion(name, model, contacts, None, SHORT, strong_record()).scaled(0.55)
            rows += _sized(model, contacts, rows_of(motion.case("implicit-euler")))
            yield rows[-1]
        solved = [row for row in rows if row.get("failed") is None]
        yield {"case": "exponent", "contacts": contacts, "step_ms": exponent(solved, "step_ms")}


def _sized(model: Assembly, contacts: Behaviour, rows: Iterator[Row]) -> Iterator[Row]:
    for row in rows:
        size = {"blocks": int(model.movable.sum()), "joints": len(model.contacts), "contacts": contacts}
        yield {"case": row["case"]} | size | row


def dissipation(
    steps: Sequence[float] = (0.01, 0.005, 0.002, 0.001), stiffness: Sequence[float] = (5e5, 5e6, 5e7, np.inf)
) -> Iterator[Row]:
    """The paper's Fig. 9: energy dissipated in the first cycle of free rocking, a share of that at release.

    Specimen 2 of its §6.1: 0.17 × 1.0 m, μ = 0.58, released at 0.64 of the slenderness angle. `stiffness` kN/m³ of the
    joint, infinite: rigid contacts. A cycle: from release to the second largest rotation on the same side.
    """
    alpha = float(np.arctan(0.17))
    for k in stiffness:
        contacts: Behaviour = "rigid" if np.isinf(k) else "elastic"
        model = block_on_base(0.17, 1.0, friction=0.58, stiffness=5e6 if np.isinf(k) else k)
        state = model.rotated(1, (0.17, 0.0), -0.64 * alpha)
        released = 0.5 * model.weight * float(np.hypot(0.17, 1.0) * (np.cos(0.36 * alpha) - np.cos(alpha)))
        for integrator in INTEGRATORS[contacts]:
            for step in steps:
                motion = time_history(model, np.zeros(round(1.6 / step)), step, contacts, state, integrator)
                rotation, energy = motion.positions[:, 1, 2], motion.energy
                left = np.flatnonzero(rotation > 0.0)[0]
                back = left + int(np.flatnonzero(rotation[left:] < 0.0)[0])
                end = back + int(rotation[back : back + round(0.6 / step)].argmin())
                row: Row = {"case": "rigid" if np.isinf(k) else f"k = {k:.0e} kN/m³", "stiffness_kN_m3": k}
                row |= {"integrator": integrator, "step_s": step}
                row["dissipated"] = float(energy.dissipated[end]) / released
                parts = ("integrator", "impact", "friction")
                yield row | {f"by_{part}": float(getattr(energy, part)[end]) / released for part in parts}


def collapse(steps: Sequence[float] = (0.01, 0.005, 0.0025, 0.00125)) -> Iterator[Row]:
    """Least amplitude (g) found to collapse one, most and all members of a structure, for every integrator and step.

    By bisection: of the arch with elastic joints to 2 %, by five members at amplitudes within 1 %; of a stack of two
    blocks to half a per cent: it falls at 0.571 g under one sine. `share`: of the members that fall where most do.
    """
    for motion, wave, accuracy, factors in (
        (shaken_arch(), shaking, 1.02, np.linspace(0.99, 1.01, 5)),
        (stack(), sine, 1.005, np.ones(1)),
    ):
        for integrator in INTEGRATORS[motion.contacts]:
            for step in steps:
                row: Row = {"case": motion.name, "integrator": integrator, "step_s": step}
                row["members"] = len(factors)
                try:
                    yield row | _least(replace(motion, record=wave(1.0)), integrator, step, accuracy, factors)
                except FAILURES as error:
                    yield row | {"failed": str(error)}


def _least(motion: Motion, integrator: Integrator, step: float, accuracy: float, factors: Array) -> Row:
    @cache
    def fallen(amplitude: float) -> int:
        return sum(motion.scaled(amplitude * f).run(step, integrator).collapsed for f in factors.tolist())

    def bracket(least: int) -> tuple[float, float]:
        low, high = 0.02, 1.28
        while high > accuracy * low:
            middle = (low * high) ** 0.5
            low, high = (low, middle) if fallen(middle) >= least else (middle, high)
        return low, high

    (stands, first), (_, most), (_, every) = map(bracket, (1, (len(factors) + 1) // 2, len(factors)))
    return {
        "stands_g": stands, "first_g": first, "collapse_g": most, "all_g": every, "share": fallen(most) / len(factors)
    }  # fmt: skip


Way = tuple[Integrator, int | None]
"""How a motion is integrated: down to how many levels Moreau and Jean's steps are halved, None with the others."""

EULER: Way = ("implicit-euler", None)
DEFAULT: Way = ("moreau-jean", HISTORY.resolved.levels)
SECOND: Way = ("second-order", None)
# factors of the amplitude
NINE, FIVE, FIFTEEN, MANY = (np.linspace(0.99, 1.01, count) for count in (9, 5, 15, 45))
MOVED, FELL = "largest displacement, mm", "time of collapse, s"
CONFIDENCE = 0.95


def ensembles(quick: bool) -> Iterator[Row]:
    """Motions of many impacts, and of stiff joints that fall: members at amplitudes within 1 %, at every time step.

    Second order has fewer members, and the triumphal arch only the time steps that take seconds; quick: one structure.
    """
    arch, few = shaken_arch("rigid", 0.12), ((0.01, STEP, 0.0025), FIVE)
    if quick:
        yield from ensemble(arch, dict.fromkeys((EULER, DEFAULT), ((STEP,), NINE[::4])), (4.0 * FINE, NINE))
        return
    top, every, most = (5 * 0.4, 6 * 0.175), ((*STEPS, 0.000625, FINE), NINE), (STEPS, NINE)
    name = "Ferris and Tin-Loi's wall 1, shaken, rigid"
    wall = Motion(name, running_bond(), "rigid", top, 3.0, shaking(0.5))
    soft = replace(wall, name=wall.name.replace("rigid", "elastic"), contacts="elastic", damping=DAMPING)
    unhalved: Way = ("moreau-jean", 0)
    levels: dict[Way, tuple[tuple[float, ...], Array]] = {("moreau-jean", k): most for k in (2, 4, 8)}
    ways = {EULER: every, unhalved: every, **levels, DEFAULT: every, SECOND: (STEPS, FIVE)}
    yield from ensemble(arch, ways, (FINE, MANY))
    ways = {EULER: most, unhalved: most, DEFAULT: most, SECOND: (STEPS[:2], FIVE)}
    yield from ensemble(wall, ways, (FINE, FIFTEEN))
    yield from ensemble(soft, dict.fromkeys((EULER, DEFAULT, SECOND), most), (FINE, FIFTEEN))
    for stiffness in (1e7, 1e8):  # kN/m³, of joints on which the arch falls
        blocks = arch.model.blocks
        stone = [replace(b, material=replace(b.material, normal_stiffness=stiffness)) for b in blocks]
        name = arch.name.replace("rigid", f"k = {stiffness:.0e}".replace("e+0", "e"))
        stiff = replace(arch, name=name, model=Assembly(stone), contacts="elastic", damping=DAMPING)
        yield from ensemble(stiff, dict.fromkeys((EULER, DEFAULT, SECOND), every), (FINE, FIFTEEN), FELL)
    name, model = "triumphal arch, shaken, rigid", assembly(TRIUMPHAL)
    motion = Motion(name, model, "rigid", control(TRIUMPHAL)[0], 0.75, strong_record()).scaled(0.2)
    two: Way = ("moreau-jean", 2)
    yield from ensemble(motion, dict.fromkeys((EULER, unhalved, two, DEFAULT), few), (0.00125, NINE))


def ensemble(
    motion: Motion, ways: Mapping[Way, tuple[Sequence[float], Array]], resolved: tuple[float, Array],
    measure: str = MOVED,
) -> Iterator[Row]:  # fmt: skip
    """Least, median and largest of what is measured of members, by way and time step.

    `resolved`: time step and factors of the members whose median the errors are relative to.
    """

    def sizes(motions: Sequence[TimeHistory]) -> Array:
        if measure == FELL:
            return np.array([m.time_of_collapse for m in motions if m.collapsed], dtype=float)
        return np.array([1e3 * motion.peak(m) for m in motions])

    exact = sizes(members(motion, DEFAULT, resolved[1], resolved[0]))
    low, high = median_between(exact)
    known: Row = {"resolved": float(np.median(exact)), "resolved_low": low, "resolved_high": high}
    for way, (steps_, factors) in ways.items():

        def more(motions: Sequence[TimeHistory], factors: Array = factors) -> Row:
            found = sizes(motions)
            row = {"measure": measure, **known, "resolved_members": len(exact), "members": len(motions)}
            row |= {"not_solved": len(factors) - len(motions)} | (counted(*motions) if motions else {})
            if len(motions) <= row["not_solved"]:
                return row | {"failed": "most members are not solved"}
            if not len(found):
                return row | {"failed": "no member collapses"}
            steps = sum(len(m.time) - 1 for m in motions)
            least, median, most = map(float, np.percentile(found, (0.0, 50.0, 100.0)))
            return row | {"least": least, "median": median, "most": most, "steps": steps}

        name = way[0] if way[1] is None else f"{way[0]}, {way[1]} levels"
        case = Case(
            motion.name, partial(members, motion, way, factors), "time step",
            steps_, default=STEP if way == DEFAULT else 0.0, way=name, more=more, baseline=None,
        )  # fmt: skip
        for row in rows_of(case):
            if row.get("failed") is None:
                row["step_ms"] = 1e3 * row["seconds"] / row["steps"]
                row["error"] = abs(row["median"] / row["resolved"] - 1.0)
            yield row


def members(motion: Motion, way: Way, factors: Array, step: float) -> list[TimeHistory]:
    """The motions at some factors of the amplitude, those that are solved."""
    (integrator, levels), tolerances, found = way, HISTORY, []
    if levels is not None:
        tolerances = HistoryTolerances(resolved=replace(HISTORY.resolved, levels=levels))
    for factor in factors.tolist():
        with suppress(ConvergenceError):
            found.append(motion.scaled(factor).run(step, integrator, tolerances))
    return found


def median_between(values: Array) -> tuple[float, float]:
    """Two of the values (k,) between which the median of all that might be drawn lies, with 95 % CONFIDENCE.

    The number of values below it is distributed as the heads of k tosses of a coin. Raises ValueError for fewer than
    six values.
    """
    count, ordered = len(values), np.sort(values)
    below = int(binom.ppf(0.5 * (1.0 - CONFIDENCE), count, 0.5))  # fewer of them are hardly ever below
    if below < 1:
        raise ValueError(f"the median of {count} values is not known with so much confidence")
    return float(ordered[below - 1]), float(ordered[count - below])


def resolved_medians(rows: Sequence[Row]) -> str:
    """A sentence for each ensemble: its resolved median and how sure it is."""
    return "\n\n".join(
        f"{row['case']}: resolved, the median {row['measure']} is {row['resolved']:.3g} of {row['resolved_members']} "
        f"members, with {percent(CONFIDENCE)} confidence between {row['resolved_low']:.3g} and "
        f"{row['resolved_high']:.3g}."
        for row in {row["case"]: row for row in rows}.values()
    )
