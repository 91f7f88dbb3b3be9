"""Dynamics: run time against error of integrators, time steps and tolerances, and what time stepping dissipates."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from assessment.benchmark.cases.structures import assembly, block_on_base, rectangle, template
from assessment.benchmark.measure import FAILURES, SAMPLES, beside_piqp, history_programs
from assessment.benchmark.table import Precision, Row
from mechanics import Assembly, Block, Material, State, TimeHistory, time_history
from mechanics.model.assembly import Behaviour
from mechanics.procedures.time_history import HISTORY, HistoryTolerances, Integrator
from mechanics.types import GRAVITY, Array

INTEGRATORS: dict[Behaviour, tuple[Integrator, ...]] = {
    "rigid": ("implicit-euler", "moreau-jean", "second-order"),
    "elastic": ("implicit-euler", "second-order"),
}
STEPS = (0.02, 0.01, 0.005, 0.0025, 0.00125)  # s
QUICK_STEPS = (0.02, 0.005)
REFERENCE = 0.0003125  # s
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)  # of a step
EXACT = 1e-8
DEFAULT_STEP, DEFAULT_TOLERANCE = 0.005, HISTORY.accepted
DAMPING = 0.05
MEMBERS = (0.99, 0.995, 1.0, 1.005, 1.01)  # of an ensemble: factors of the amplitude


@dataclass(frozen=True, eq=False)
class Case:
    """A motion to be computed at several steps: `record` gives base accelerations in g at times (k,) s.

    `damping`: ratio; `displaced` (m): where the control point begins; `after` (s): from when on its largest
    displacement counts; `exact`: that displacement (m) and its time (s) where there is a closed form; `timed`: whether
    the time is what errors are of.
    """

    name: str
    model: Assembly
    contacts: Behaviour
    control: tuple[float, float]
    duration: float
    record: Callable[[Array], Array]
    damping: float = 0.0
    state: State | None = None
    displaced: float = 0.0
    after: float = 0.0
    exact: tuple[float, float] | None = None
    timed: bool = False

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
        times: Array = step * np.arange(round(self.duration / step) + 1, dtype=float)
        return self.record(times)

    def peak(self, motion: TimeHistory) -> tuple[float, float]:
        """Largest control displacement (m) and its time (s): of the parabola through three samples."""
        assert motion.displacement is not None
        d, step = abs(motion.displacement + self.displaced), motion.time[1]
        first = min(round(self.after / step), len(d) - 1)
        k = first + int(d[first:].argmax())
        if k in (first, len(d) - 1):
            return float(d[k]), float(motion.time[k])
        a, b, c = d[k - 1 : k + 2]
        bend = a - 2.0 * b + c
        shift = 0.5 * (a - c) / bend if bend < 0.0 else 0.0
        return float(b - 0.25 * (a - c) * shift), float(motion.time[k] + shift * step)

    def error(self, found: tuple[float, float], exact: tuple[float, float]) -> float:
        """Relative error of a largest displacement, or of its time."""
        return abs(found[self.timed] / exact[self.timed] - 1.0)


def shaking(amplitude: float, frequency: float = 1.5) -> Callable[[Array], Array]:
    """Two sines that grow over half a second, for two seconds; then rest."""

    def at(times: Array) -> Array:
        phase = 2.0 * np.pi * frequency * times
        wave = np.sin(phase) + 0.5 * np.sin(2.7 * phase + 1.0)
        envelope = np.minimum(times / 0.5, 1.0) * np.clip((2.0 - times) / 0.2, 0.0, 1.0)
        motion: Array = amplitude * envelope * wave
        return motion

    return at


def pulse(amplitude: float, duration: float) -> Callable[[Array], Array]:
    """A half sine."""

    def at(times: Array) -> Array:
        motion: Array = amplitude * np.sin(np.pi * times / duration) * (times < duration)
        return motion

    return at


def rest(times: Array) -> Array:
    """No base motion."""
    return np.zeros_like(times)


def cases() -> list[Case]:
    """Motions that converge, from one block to the buttressed arch; others are ensembles."""
    rigid, soft, tall = (
        block_on_base(0.6, 4.2, stiffness=1e6),
        block_on_base(0.6, 4.2, stiffness=1e5),
        (0.6, 4.2),
    )
    return [
        rocking_freely(),
        Case("rocking block, pulse, rigid", rigid, "rigid", tall, 3.0, pulse(0.3, 0.5)),
        Case("rocking block, pulse, elastic", soft, "elastic", tall, 3.0, pulse(0.2, 0.5), DAMPING),
        swinging_column(),
        shaken_arch(),
    ]


def shaken_arch() -> Case:
    """The buttressed arch with elastic joints, shaken so that some of them open."""
    springing = template("buttressed-arch").pushover_control("+x").point_m
    arch = assembly("buttressed-arch")
    return Case("buttressed arch, shaken, elastic", arch, "elastic", springing, 3.0, shaking(0.03), DAMPING)


def rocking_freely(width: float = 0.6, height: float = 4.2) -> Case:
    """A rigid block (m) released at half its slenderness α: the third peak.

    Housner (1963): θ'' = −p² sin(α − θ), and an impact leaves e² of the energy, e = 1 − 1.5 sin² α.
    """
    model, alpha = block_on_base(width, height, stiffness=1e6), float(np.arctan(width / height))
    p, e = float(np.sqrt(1.5 * GRAVITY / np.hypot(width, height))), 1.0 - 1.5 * float(np.sin(alpha)) ** 2
    state = model.rotated(1, (width, 0.0), -0.5 * alpha)
    left = np.cos(0.5 * alpha) - np.cos(alpha)  # of the energy over weight and half-diagonal
    leans = [0.5 * alpha, *(alpha - float(np.arccos(np.cos(alpha) + left * e ** (2 * n))) for n in (1, 2))]
    quarters = [quarter_period(lean, alpha, p) for lean in leans]
    after = quarters[0] + 2.0 * quarters[1]
    return Case(
        "rocking block, free, rigid", model, "rigid", (width, height), 3.0, rest, state=state,
        displaced=height * float(np.sin(leans[0])), after=after,
        exact=(height * float(np.sin(leans[2])), after + quarters[2]),
    )  # fmt: skip


def quarter_period(lean: float, alpha: float, p: float) -> float:
    """Time (s) in which a rigid block of slenderness α, released at rest at an angle, comes back upright."""
    from scipy.integrate import quad

    low = (
        alpha - lean
    )  # angle of the half-diagonal from the vertical; the speed vanishes there as a square root

    def pace(angle: float) -> float:
        fallen = max(angle - low, 1e-12)
        return float(np.sqrt(fallen / (2.0 * (np.cos(low) - np.cos(low + fallen)))) / p)

    return float(quad(pace, low, alpha, weight="alg", wvar=(-0.5, 0.0))[0])


def swinging_column(width: float = 0.5, height: float = 2.0, stiffness: float = 2e6) -> Case:
    """A block (m) pushed gently, that turns about the middle of its closed joint (kN/m³), whose shear sticks.

    ω² = (k d B³/12 − W H/2) / (m (B² + 4 H²)/12). The time of its seventh quarter of a period, when the top is
    displaced by H θ'/ω.
    """
    model = block_on_base(width, height, friction=2.0, stiffness=stiffness)
    speed, mass = 5e-3, model.weight / GRAVITY  # rad/s, t
    moving = np.zeros_like(model.initial.positions)
    moving[1] = (-0.5 * height * speed, 0.0, speed)
    state = State(time_history(model, np.zeros(2), 1e-3, "elastic").start.positions, moving)
    turning = stiffness * width**3 / 12.0 - 0.5 * model.weight * height
    omega = float(np.sqrt(turning / (mass * (width**2 + 4.0 * height**2) / 12.0)))
    quarter = 0.5 * np.pi / omega
    return Case(
        "column, free vibration, elastic", model, "elastic", (width, height), 8.0 * quarter, rest, state=state,
        after=6.0 * quarter, exact=(height * speed / omega, 7.0 * quarter), timed=True,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Point(Precision):
    """The largest displacement found (m), its time's error (s), and what its motion took."""

    integrator: Integrator
    found_m: float = np.nan
    time_error_s: float = np.nan
    steps: int | None = None
    programs_per_step: float = np.nan
    iterations_per_step: float = np.nan
    integrator_share: float = np.nan
    imbalance: float = np.nan
    cold: int | None = None
    collapsed: bool | None = None


def dynamics(quick: bool) -> Iterator[Point]:
    """Error of the largest displacement against processor time, of every case, integrator and step or tolerance."""
    steps = QUICK_STEPS if quick else STEPS
    for case in cases():
        finest = 4.0 * REFERENCE if quick else REFERENCE
        try:
            exact = case.exact or case.peak(case.run(finest, "second-order"))
        except FAILURES as error:
            yield replace(_point(case, "second-order", "time step [s]", finest), failed=str(error))
            continue
        for integrator in INTEGRATORS[case.contacts]:
            for step in steps:
                yield measured(case, integrator, "time step [s]", step, exact)
        if len(case.model.blocks) > 2 and case.contacts == "elastic":
            strict = HistoryTolerances(accepted=EXACT)
            converged = case.peak(case.run(DEFAULT_STEP, "second-order", strict))
            for tolerance in TOLERANCES:
                yield measured(case, "second-order", "tolerance", tolerance, converged)


def measured(
    case: Case, integrator: Integrator, parameter: str, value: float, exact: tuple[float, float]
) -> Point:
    """A row of dynamics: `exact` are the largest displacement (m) and its time (s)."""
    step, tolerances = DEFAULT_STEP, HISTORY
    if parameter == "tolerance":
        tolerances = HistoryTolerances(accepted=value)
    else:
        step = value
    row = _point(case, integrator, parameter, value)
    run = partial(case.run, step, integrator, tolerances)
    try:
        motion = run()
    except FAILURES as error:
        return replace(row, failed=str(error))
    programs = history_programs(case.model, case.contacts, motion, case.acceleration(step), _every(motion))
    seconds, each = beside_piqp(run, programs)
    size, at = found = case.peak(motion)
    if case.timed and at <= case.after:
        return replace(row, failed="no peak where it is looked for: its time is farther off")
    count = len(motion.time) - 1
    return replace(
        row,
        found_m=size,
        error=case.error(found, exact),
        time_error_s=at - exact[1],
        steps=count,
        seconds=seconds,
        ratio=seconds / count / each,
        programs_per_step=motion.programs / count,
        iterations_per_step=motion.iterations / count,
        integrator_share=motion.energy.integrator_share,
        imbalance=motion.energy.imbalance,
        cold=motion.cold,
        collapsed=motion.collapsed,
    )


def _point(case: Case, integrator: Integrator, parameter: str, value: float) -> Point:
    """What a row is about."""
    default = DEFAULT_STEP if parameter == "time step [s]" else DEFAULT_TOLERANCE
    return Point(
        case=case.name, parameter=parameter, value=value, default=value == default, integrator=integrator
    )


def _every(motion: TimeHistory) -> int:
    """Of so many steps the baseline solves one: SAMPLES of them, or all of a short motion."""
    return max((len(motion.time) - 1) // SAMPLES, 1)


@dataclass(frozen=True, kw_only=True)
class Dissipation(Row):
    """Energies of a cycle of rocking over that at release; `stiffness_kN_m3`: None with rigid contacts."""

    stiffness_kN_m3: float | None
    integrator: Integrator
    step_s: float
    dissipated: float
    by_integrator: float
    by_impact: float
    by_friction: float


@dataclass(frozen=True, kw_only=True)
class Collapse(Row):
    """Amplitudes (g) that all of so many members stand, at which one, most and all collapse; `share`: at the third."""

    integrator: Integrator
    step_s: float
    members: int
    stands_g: float = np.nan
    first_g: float = np.nan
    collapse_g: float = np.nan
    all_g: float = np.nan
    share: float = np.nan


def dissipation(
    steps: Sequence[float] = (0.01, 0.005, 0.002, 0.001),
    stiffness: Sequence[float] = (5e5, 5e6, 5e7, np.inf),
) -> Iterator[Dissipation]:
    """The paper's Fig. 9: energy dissipated in the first cycle of free rocking, per cent of that at release.

    Specimen 2 of its §6.1: 0.17 × 1.0 m, μ = 0.58, released at 0.64 of the slenderness angle. `stiffness` kN/m³ of the
    joint, infinite: rigid contacts. A cycle: from release to the second largest rotation on the same side.
    """
    alpha = float(np.arctan(0.17))
    for k in stiffness:
        contacts: Behaviour = "rigid" if np.isinf(k) else "elastic"
        model = block_on_base(0.17, 1.0, friction=0.58, stiffness=5e6 if np.isinf(k) else k)
        state = model.rotated(1, (0.17, 0.0), -0.64 * alpha)
        weight, radius = model.weight, 0.5 * float(np.hypot(0.17, 1.0))
        released = weight * radius * float(np.cos(0.36 * alpha) - np.cos(alpha))
        for integrator in INTEGRATORS[contacts]:
            for step in steps:
                motion = time_history(model, np.zeros(round(1.6 / step)), step, contacts, state, integrator)
                rotation, energy = motion.positions[:, 1, 2], motion.energy
                left = np.flatnonzero(rotation > 0.0)
                back = left[0] + np.flatnonzero(rotation[left[0] :] < 0.0)
                end = int(back[0] + rotation[back[0] : back[0] + round(0.6 / step)].argmin())
                yield Dissipation(
                    case="rigid" if np.isinf(k) else f"k = {k:.0e} kN/m³",
                    stiffness_kN_m3=None if np.isinf(k) else k,
                    integrator=integrator,
                    step_s=step,
                    dissipated=float(energy.dissipated[end]) / released,
                    by_integrator=float(energy.integrator[end]) / released,
                    by_impact=float(energy.impact[end]) / released,
                    by_friction=float(energy.friction[end]) / released,
                )


def collapse(steps: Sequence[float] = (0.01, 0.005, 0.0025, 0.00125)) -> Iterator[Collapse]:
    """Least amplitude (g) found to collapse a structure, by bisection, for every integrator and step.

    The arch with elastic joints to 2 %, by MEMBERS at amplitudes within 1 %; to half a per cent a stack of two blocks:
    it falls at 0.571 g under one sine.
    """
    for case, motion, accuracy, factors in (
        (shaken_arch(), shaking, 1.02, MEMBERS),
        (stack(), sine, 1.005, (1.0,)),
    ):
        for integrator in INTEGRATORS[case.contacts]:
            for step in steps:
                row = Collapse(case=case.name, integrator=integrator, step_s=step, members=len(factors))
                try:
                    yield _bracketed(row, case, motion, accuracy, factors)
                except FAILURES as error:
                    yield replace(row, failed=str(error))


def _bracketed(
    row: Collapse, case: Case, motion: Callable[[float], Callable[[Array], Array]], accuracy: float,
    factors: Sequence[float],
) -> Collapse:  # fmt: skip
    """The row with its amplitudes (g)."""

    @cache
    def falls(amplitude: float, factor: float) -> bool:
        return replace(case, record=motion(amplitude * factor)).run(row.step_s, row.integrator).collapsed

    def bracket(least: int) -> tuple[float, float]:
        low, high = 0.02, 1.28
        while high > accuracy * low:
            middle = (low * high) ** 0.5
            fallen = sum(falls(middle, factor) for factor in factors) >= least
            low, high = (low, middle) if fallen else (middle, high)
        return low, high

    stands, first = bracket(1)
    most = bracket((len(factors) + 1) // 2)[1]
    return replace(
        row,
        stands_g=stands,
        first_g=first,
        collapse_g=most,
        all_g=bracket(len(factors))[1],
        share=sum(falls(most, factor) for factor in factors) / len(factors),
    )


def stack() -> Case:
    """Two blocks of 0.5 × 1.5 m upon each other."""
    stone = Material(18.0, 0.7, 1e6)
    base = Block(rectangle(-2.0, -0.2, 2.5, 0.0), 1.0, stone, support="base")
    two = [Block(rectangle(0.0, z, 0.5, z + 1.5), 1.0, stone) for z in (0.0, 1.5)]
    return Case("stack of two, one sine, rigid", Assembly([base, *two]), "rigid", (0.5, 3.0), 6.0, sine(0.5))


def sine(amplitude: float, period: float = 0.5) -> Callable[[Array], Array]:
    """One sine."""

    def at(times: Array) -> Array:
        motion: Array = amplitude * np.sin(2.0 * np.pi * times / period) * (times < period)
        return motion

    return at
