"""Motions: run time against error, ensembles of many impacts, and the time of a step as structures grow."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Self

import numpy as np
from scipy.stats import binom

from assessment.benchmark import measure as runner
from assessment.benchmark.measure import Case, Row, exponent, history_baseline, rows_of
from assessment.project.catalogue.new_project import RECORD
from mechanics import Assembly, ConvergenceError, State, TimeHistory, read_record, time_history
from mechanics.model.assembly import Behaviour
from mechanics.procedures.motion_start import HISTORY, HistoryTolerances, Integrator
from mechanics.types import Array

Wave = Callable[[Array], Array]  # base accelerations (k,) in g at times (k,) s

INTEGRATORS: dict[Behaviour, tuple[Integrator, ...]] = {
    "rigid": ("implicit-euler", "moreau-jean", "second-order"),
    "elastic": ("implicit-euler", "second-order"),
}
STEPS, FINE, STEP = (0.02, 0.01, 0.005, 0.0025, 0.00125), 0.0003125, 0.005  # s
TOLERANCES, EXACT = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7), 1e-8  # of a step
WALLS, QUICK_WALLS = ((9, 10), (18, 19), (31, 32), (54, 55)), ((6, 6), (9, 10), (14, 14))
DAMPING, SHORT = 0.05, 0.49  # ratio; s, of motions of large structures
ARCH, TRIUMPHAL = "buttressed-arch", "triumphal-arch"
CONFIDENCE = 0.95


@dataclass(frozen=True, eq=False)
class ShakenCase:
    """A motion to be computed at several steps."""

    name: str
    model: Assembly
    contacts: Behaviour
    control: tuple[float, float] | None
    duration: float
    record: Wave
    damping: float = 0.0  # ratio
    state: State | None = None
    displaced: float = 0.0  # m: where the control point begins
    after: float = 0.0  # s: from when on its largest displacement counts
    exact: float | None = None  # that displacement (m) where there is a closed form

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

    def scaled(self, factor: float) -> Self:
        """The same with its base motion multiplied by a factor."""
        return replace(self, record=lambda times: factor * self.record(times))

    def case(self, integrator: Integrator, values: Sequence[float] = (STEP,), **more: Any) -> Case:
        """The benchmark of an integrator at some time steps."""
        return Case(
            self.name, lambda step: self.run(step, integrator), "time step [s]", values, default=STEP, way=integrator,
            more=lambda found: counted([found]), baseline=lambda found: history_baseline(
                self.model, self.contacts, self.acceleration(float(found.time[1])), found
            ), **more,
        )  # fmt: skip


def shaking(amplitude: float, frequency: float = 1.5) -> Wave:
    """Two sines that grow over half a second, for two seconds; then rest."""

    def at(times: Array) -> Array:
        phase = 2.0 * np.pi * frequency * times
        envelope = np.minimum(times / 0.5, 1.0) * np.clip((2.0 - times) / 0.2, 0.0, 1.0)
        return amplitude * envelope * (np.sin(phase) + 0.5 * np.sin(2.7 * phase + 1.0))

    return at


def pulse(amplitude: float, duration: float) -> Wave:
    """A half sine."""
    return lambda times: amplitude * np.sin(np.pi * times / duration) * (times < duration)


def shaken_arch(contacts: Behaviour = "elastic", amplitude: float = 0.03) -> ShakenCase:
    """The buttressed arch, shaken so that some of its joints open."""
    name, damping = f"buttressed arch, shaken, {contacts}", DAMPING if contacts == "elastic" else 0.0
    model, point = runner.assembly(ARCH), runner.control(ARCH)[0]
    return ShakenCase(name, model, contacts, point, 3.0, shaking(amplitude), damping)


def rocking_freely() -> ShakenCase:
    """A rigid block of 0.6 × 4.2 m released at half its slenderness α: the third peak, after impacts at 2.02 s.

    Housner (1963): θ'' = −p² sin(α − θ), and an impact leaves e² of the energy, e = 1 − 1.5 sin² α.
    """
    model, alpha = runner.block_on_base(0.6, 4.2, stiffness=1e6), float(np.arctan(0.6 / 4.2))
    e, left = 1.0 - 1.5 * np.sin(alpha) ** 2, np.cos(0.5 * alpha) - np.cos(alpha)  # of the energy over W R
    third = alpha - float(np.arccos(np.cos(alpha) + left * e**4))
    return ShakenCase(
        "rocking block, free, rigid", model, "rigid", (0.6, 4.2), 3.0, np.zeros_like,
        state=model.rotated(1, (0.6, 0.0), -0.5 * alpha), displaced=4.2 * float(np.sin(0.5 * alpha)), after=2.1,
        exact=4.2 * float(np.sin(third)),
    )  # fmt: skip


def dynamics(quick: bool) -> Iterator[Row]:
    """Error of the largest displacement against processor time, of every motion, integrator and step or tolerance."""
    soft, stiff = (runner.block_on_base(0.6, 4.2, stiffness=stiffness) for stiffness in (1e5, 1e6))
    at, name = (0.6, 4.2), "rocking block, pulse"
    rigid = ShakenCase(f"{name}, rigid", stiff, "rigid", at, 3.0, pulse(0.3, 0.5))
    elastic = ShakenCase(f"{name}, elastic", soft, "elastic", at, 3.0, pulse(0.2, 0.5), DAMPING)
    fine, steps = (4.0 * FINE, (0.02, STEP)) if quick else (FINE, STEPS)
    arch = shaken_arch()

    def measure(motion: ShakenCase, found: TimeHistory) -> dict[str, float]:
        return {"peak, m": motion.peak(found)}

    for motion in (rocking_freely(), rigid, elastic, arch):
        exact = {"peak, m": motion.exact or motion.peak(motion.run(fine, "second-order"))}
        for integrator in INTEGRATORS[motion.contacts]:
            yield from rows_of(motion.case(integrator, steps, measure=partial(measure, motion), exact=exact))
    case = arch.case("second-order", TOLERANCES, measure=partial(measure, arch), reference=EXACT)

    def within(accepted: float) -> TimeHistory:
        return arch.run(STEP, "second-order", HistoryTolerances(accepted=accepted))

    yield from rows_of(replace(case, parameter="tolerance", run=within, default=HISTORY.accepted))


def counted(motions: Sequence[TimeHistory]) -> Row:
    """What motions took, and what the integrator took of their energy."""
    steps = sum(len(motion.time) - 1 for motion in motions)
    return {
        "steps": steps,
        "programs_per_step": sum(motion.programs for motion in motions) / steps,
        "iterations_per_step": sum(motion.iterations for motion in motions) / steps,
        "halvings": sum(motion.halvings for motion in motions),
        "cold": sum(motion.cold for motion in motions),
        "collapsed": sum(motion.collapsed for motion in motions),
        "integrator_share": float(np.median([motion.energy.integrator_share for motion in motions])),
        "imbalance": max(motion.energy.imbalance for motion in motions),
    }


def steps(quick: bool) -> Iterator[Row]:
    """A step of 5 ms of every structure, contact behaviour and integrator; implicit Euler's of ever larger walls."""
    record = read_record(runner.template(TRIUMPHAL).folder / RECORD).resampled(STEP).windowed(4.0, 11.0)
    length = 1.0 if quick else 7.0
    structures = [
        ("2 blocks", runner.block_on_base(0.6, 4.2, stiffness=1e6), 0.3, length),
        ("buttressed arch", runner.assembly(ARCH), 0.03, length),
        ("wall 18 × 19", runner.running_bond(18, 19, stiffness=1e7), 0.55, length),
        ("triumphal arch", runner.assembly(TRIUMPHAL), 0.2, SHORT),
    ]

    def strong(times: Array) -> Array:
        return np.interp(times, record.time, record.acceleration / record.pga)

    def sized(motion: ShakenCase, integrator: Integrator) -> Iterator[Row]:
        model, contacts = motion.model, motion.contacts
        for row in rows_of(motion.case(integrator)):
            size = {"blocks": int(model.movable.sum()), "joints": len(model.contacts), "contacts": contacts}
            yield {"case": row["case"]} | size | row

    for name, model, pga, duration in structures[: 2 if quick else None]:
        for contacts, integrators in INTEGRATORS.items():
            motion = ShakenCase(name, model, contacts, None, duration, strong).scaled(pga)
            for integrator in integrators:
                yield from sized(motion, integrator)
    for contacts in INTEGRATORS:
        rows: list[Row] = []
        for columns, courses in QUICK_WALLS if quick else WALLS:
            model = runner.running_bond(columns, courses, stiffness=1e7)
            name = f"growth, wall {columns} × {courses}"
            motion = ShakenCase(name, model, contacts, None, SHORT, strong).scaled(0.55)
            rows += sized(motion, "implicit-euler")
            yield rows[-1]
        solved = [row for row in rows if row.get("failed") is None]
        yield {"case": "growth, exponent", "contacts": contacts, "step_ms": exponent(solved, "step_ms")}


def ensembles(quick: bool) -> Iterator[Row]:
    """Motions of many impacts: members within 1 % of amplitude by time step; first the resolved median, its bounds."""
    arch = shaken_arch("rigid", 0.12)
    name = "Ferris and Tin-Loi's wall 1, shaken, rigid"
    wall = ShakenCase(name, runner.running_bond(), "rigid", (5 * 0.4, 6 * 0.175), 3.0, shaking(0.5))
    few, many = (3, 9) if quick else (9, 45)
    for motion in (arch,) if quick else (arch, wall):
        yield from ensemble(motion, (STEP,) if quick else STEPS, few, (4.0 if quick else 1.0) * FINE, many)


def ensemble(motion: ShakenCase, steps: Sequence[float], count: int, fine: float, many: int) -> Iterator[Row]:
    """Displacements (mm) of `count` members by integrator and time step (s), and of `many` at the step `fine`."""
    resolved = sizes(motion, members(motion, "moreau-jean", many, fine))
    low, high = median_between(resolved)
    exact = float(np.median(resolved))
    first: Row = {"case": motion.name, "way": "resolved", "parameter": "time step", "value": fine}
    yield first | {"least": low, "median": exact, "most": high, "members": len(resolved)}
    for integrator in INTEGRATORS["rigid"]:

        def more(found: list[TimeHistory]) -> Row:
            row: Row = {"members": len(found), "not_solved": count - len(found)}
            if len(found) <= count - len(found):
                return row | {"failed": "most members are not solved"}
            least, median, most = map(float, np.percentile(sizes(motion, found), (0.0, 50.0, 100.0)))
            off = abs(median / exact - 1.0)
            return row | counted(found) | {"least": least, "median": median, "most": most, "error": off}

        run = partial(members, motion, integrator, count)
        default = STEP if integrator == "moreau-jean" else 0.0
        yield from rows_of(Case(
            motion.name, run, "time step", steps, default=default, way=integrator, more=more, baseline=None,
        ))  # fmt: skip


def members(motion: ShakenCase, integrator: Integrator, count: int, step: float) -> list[TimeHistory]:
    """The motions at so many amplitudes within 1 %, those that are solved."""
    found = []
    for factor in np.linspace(0.99, 1.01, count).tolist():
        with suppress(ConvergenceError):
            found.append(motion.scaled(factor).run(step, integrator))
    return found


def sizes(motion: ShakenCase, found: Sequence[TimeHistory]) -> Array:
    """Largest displacements (k,), mm."""
    return np.array([1e3 * motion.peak(each) for each in found])


def median_between(values: Array) -> tuple[float, float]:
    """Two of the values (k,) around the true median with 95 % CONFIDENCE. Raises ValueError for fewer than six."""
    count, ordered = len(values), np.sort(values)
    below = int(binom.ppf(0.5 * (1.0 - CONFIDENCE), count, 0.5))  # fewer of them are hardly ever below
    if below < 1:
        raise ValueError(f"the median of {count} values is not known with so much confidence")
    return float(ordered[below - 1]), float(ordered[count - below])
