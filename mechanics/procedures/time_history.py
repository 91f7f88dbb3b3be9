"""Time histories: the motion of the blocks under an earthquake, or from an initial position (paper, §3 and §4)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import ConvergenceError, array_of, is_number, require
from mechanics.kernels.dynamics.motion import LONGER, SPRING, TURNED
from mechanics.messages import Message, message
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.pictures import draw_curve, film
from mechanics.procedures.collapse import ControlPoint, broken_tie, collapse, far, passing_through
from mechanics.procedures.energy import Energy, may_fall
from mechanics.procedures.model_check import departure_in_motion
from mechanics.procedures.motion_start import (
    HISTORY,
    HistoryTolerances,
    Integrator,
    Rule,
    base_acceleration,
    begun_motion,
    check_arguments,
    chosen_rule,
)
from mechanics.progress import tell
from mechanics.steps.dynamic_system import DynamicSystem, Motion, Recorded
from mechanics.steps.static_system import Sliding, with_springs
from mechanics.types import GRAVITY, Array

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class TimeHistory:
    """The motion of the b blocks of a `model` at k times in the frame of the ground.

    Supports rest, the base motion acts as inertia.

    `time` (k,) s; `positions` (k, b, 3): x, z (m) and ω (rad); `velocities` (k, b, 3): m/s and rad/s; `forces`
    (k, j, 3): N (kN), P (kNm) and T (kN) of the drawn joints in the step that led to each time, 0 at the first, where
    they are not known; `start`: the state in which the motion begins; `final`: its last state. `displacement` (k,) m:
    of the control point along x from `start`, None without a control point. `collapsed`, `time_of_collapse` (s) and
    `collapse_reason`: see time_history; the arrays end there. `energy`: the balance at each time.

    `integrator`: the one used; `chosen`: why. Numbers of `programs` solved, of their `iterations`, of `halvings` of
    steps, of `cold` starts, of steps in which what slides is `lifting`, and of steps that were `skipped` at rest;
    `worst`: largest unbalanced force, per weight of a block; `unsure`: largest energy that errors of velocities may
    have, as a share of what was turned over. `notes`: warnings about the motion; `sliding_error`:
    about the least error of displacements by sliding, a share of them, which slides that turn back within steps have.
    """

    time: Array
    positions: Array
    velocities: Array
    forces: Array
    start: State
    final: State
    displacement: Array | None
    collapsed: bool
    time_of_collapse: float | None
    collapse_reason: str
    energy: Energy
    integrator: Integrator
    chosen: str
    programs: int
    iterations: int
    halvings: int
    cold: int
    worst: float
    unsure: float
    sliding_error: float
    notes: tuple[Message, ...]
    lifting: int
    skipped: int
    model: Assembly

    @property
    def steps(self) -> int:
        """Number of time steps."""
        return len(self.time) - 1

    @property
    def speed_at_end(self) -> float:
        """The largest component (m/s) of a centroid's velocity lately; 0 if all blocks rest, and at collapse.

        At the very end a block that rocks may just be turning back. Rigid joints come to rest, elastic ones nearly.
        """
        if self.final.motion is None:
            return 0.0
        lately = self.time >= self.time[-1] - HISTORY.lately
        speed = float(abs(self.velocities[lately, :, :2]).max())
        least = HISTORY.rests if self.final.motion.rigid else HISTORY.trembles
        return speed if speed > least * np.sqrt(GRAVITY * self.model.size) else 0.0

    def __repr__(self) -> str:
        fell = f"collapse at {self.time_of_collapse:.4g} s" if self.collapsed else f"{self.time[-1]:.4g} s"
        peak = "" if self.displacement is None else f", peak {1000.0 * abs(self.displacement).max():.4g} mm"
        return f"TimeHistory({fell}, {self.steps} steps, {self.integrator}{peak})"

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the displacement of the control point, without one of the block that goes farthest; return the axes."""
        moved = self.positions[:, :, 0] - self.start.positions[:, 0]
        block = int(abs(moved).max(axis=0).argmax())
        whose, x = f"block {block}", moved[:, block]
        if self.displacement is not None:
            whose, x = "the control point", self.displacement
        labels = ("time [s]", f"displacement of {whose} [mm]")
        return draw_curve(self.time, 1000.0 * x, {}, labels, "collapse" if self.collapsed else "", axes)

    def animate(self, frames_per_second: int = 25) -> FuncAnimation:
        """Return the motion as a film in real time; `.save("motion.gif")` writes it."""
        wanted = np.arange(0.0, self.time[-1], 1.0 / frames_per_second)
        kept = np.unique(np.searchsorted(self.time, wanted - 1e-9))
        shapes = [self.model.shape.moved(self.positions[at] - self.model.initial.positions) for at in kept]
        titles = [f"{self.time[at]:.2f} s" for at in kept]
        return film(shapes, self.model.shape, titles, 1.0 / frames_per_second)

    def to_frame(self) -> pd.DataFrame:
        """Return the motion as a table by time (s): displacement (m) of the control point; x, z, ω of every block."""
        import pandas as pd  # late: only tables need it

        found = {} if self.displacement is None else {"displacement_m": self.displacement}
        for at, block in enumerate(self.positions.transpose(1, 2, 0)):
            found |= dict(zip((f"x_{at}_m", f"z_{at}_m", f"rotation_{at}_rad"), block, strict=True))
        return pd.DataFrame(found, index=pd.Index(self.time, name="time_s"))


def time_history(
    model: Assembly,
    acceleration: ArrayLike,
    time_step: float,
    contacts: Behaviour = "rigid",
    state: State | None = None,
    integrator: Integrator = "auto",
    vertical_acceleration: ArrayLike | None = None,
    damping_ratio: float = 0.0,
    control: ArrayLike | None = None,
    ultimate: float | None = None,
    restitution: float = 0.0,
    sliding: Sliding = "coulomb",
    tolerances: HistoryTolerances = HISTORY,
) -> TimeHistory:
    """Integrate the motion under base accelerations (k,) in g, sampled at `time_step` (s) and linear in between.

    `integrator`: "second-order" is the midpoint rule. It locates impacts of rigid joints in steps down to 1/1024.
    "moreau-jean" is the same rule with steps down to 1/64, halved where impacts take more than 0.4 % of the largest
    kinetic energy so far. With elastic joints both halve a step that takes more than 0.025 % (0.4 %) of that energy, or
    whose contacts hold more than 10 %, until half the period of the stiffest contact, π√(m/k), has eight steps; of at
    most three movable blocks also where slides turn back, all by the kinetic energy of the moment.
    "implicit-euler" is the paper's. "auto" is "moreau-jean" for rigid joints of more than three movable blocks,
    otherwise "second-order".

    `state` (default: as drawn): a state at rest that can stand first settles on its elastic joints; any other, tilted
    or moving, is released as it is. `vertical_acceleration` (k,) g, upward. `damping_ratio` (elastic joints): of
    viscous contact forces proportional to stiffness, at the first frequency of the structure as drawn with all joints
    closed. `restitution` (rigid joints, second order): of normal velocities at impacts. `control`: a drawn point (2,) m
    whose horizontal displacement is recorded. `sliding`: "coulomb", or "associative", by which what slides lifts; steps
    of rigid joints in which it lifts by Coulomb's law too, since that is not solved, are counted. Joints of finite
    strength have to be elastic: what is crushed of them stays so (kernels.bed).

    The motion ends at collapse: a block has turned by more than 1 rad from the drawing, half of it in the motion, has
    fallen by more than its size and still falls, or is out of reach of all its contacts; or the control point moves
    outward past its `ultimate` displacement (m); or a tie breaks. Raises ArgumentError for an argument out of its
    range, ConvergenceError if a step is not solved.
    """
    # thirteen arguments: the public function of the package, called with keywords
    Assembly.check(model)
    base = base_acceleration(acceleration, vertical_acceleration, time_step)
    check_arguments(model, contacts, integrator, damping_ratio, restitution)
    point = _control_point(model, control, ultimate)
    rule = chosen_rule(model, contacts, integrator, time_step, tolerances)
    system, start, motion, undecided = begun_motion(
        model, contacts, sliding, model.starting(state), rule, damping_ratio, restitution, tolerances
    )
    begun = start.positions if start.motion is None else start.motion.begun
    system, record, reason = _followed(system, motion, begun, base, time_step, point, tolerances)
    final = _final_state(system, motion, begun, record, bool(reason))
    found = _result(system, start, final, record, time_step, point, reason, rule, tolerances)
    notes = (undecided, *found.notes, unfinished(found))
    return replace(found, notes=tuple(note for note in notes if note is not None))


def _followed(
    system: DynamicSystem, motion: Motion, begun: Array, base: Array, time_step: float, point: ControlPoint | None,
    tolerances: HistoryTolerances,
) -> tuple[DynamicSystem, Recorded, Message | None]:  # fmt: skip
    """Return the system of the last contacts, the record of a motion to its end or to collapse, and why it collapsed.

    Forces are those of the drawn joints.
    """
    parts: list[Recorded] = []
    done, reason = 0, None
    while done < len(base) - 1 and not reason:
        system = system.around(motion)
        ahead = (float(base[done:, 0].min()), float(base[done:, 0].max()))
        marched = system.march(motion, base[done : done + tolerances.chunk + 1], time_step, ahead)
        _check_motion(system, marched, done, time_step, tolerances.checked)
        part, reason = _until_collapse(system, marched, begun, point)
        if broken := broken_tie(system.system, part.x):
            part, reason = part.until(max(broken[0], 1)), broken[1]
        parts.append(part._replace(forces=part.forces[:, : len(system.model.contacts)]))
        done += len(part.x) - 1
        tell(done / (len(base) - 1))
    whole = (
        np.concatenate([first[:1], *(part[1:] for part in (first, *more))])
        for first, *more in zip(*parts, strict=True)
    )
    return system, Recorded(*whole), reason


def unfinished(*parts: TimeHistory) -> Message | None:
    """Return a warning that blocks may fall after motions that follow each other; None if not, and at collapse."""
    speed = parts[-1].speed_at_end
    if not speed or not may_fall([part.energy for part in parts], HISTORY.spent):
        return None
    return message(
        "blocks still move at the end, at {speed:.2g} m/s, and may fall after it: collapse and residual displacement "
        "are not known; continue the base motion with zeros", speed=speed,
    )  # fmt: skip


def _check_motion(system: DynamicSystem, part: Recorded, done: int, step: float, every: int) -> None:
    """Raise ConvergenceError if one of the steps (s) that are checked departs from the model; `done` are before."""
    for k in range(every - done % every, len(part.x), every):
        moves = part.x[k - 1 : k + 1], part.v[k - 1 : k + 1], part.forces[k]
        wrong = departure_in_motion(system.system, *moves, step, system.halving.unsure)
        if wrong is not None:
            raise ConvergenceError(
                message(
                    "the motion at {time:.4g} s is not valid: {reason}", time=step * (done + k), reason=wrong
                )
            )


def _control_point(model: Assembly, control: ArrayLike | None, ultimate: float | None) -> ControlPoint | None:
    """Return the control point, None: none. Raises ArgumentError for an ultimate displacement without one."""
    require(ultimate is None or (control is not None and is_number(ultimate) and ultimate > 0.0), "ultimate", ultimate,
            "positive, in m, and given with a control point")  # fmt: skip
    if control is None:
        return None
    return ControlPoint(
        array_of("control", control, "a point (x, z) in m"), model.block_at(control), ultimate
    )


def _until_collapse(
    system: DynamicSystem, part: Recorded, begun: Array, point: ControlPoint | None
) -> tuple[Recorded, Message | None]:
    """Return a part of a motion up to the step at which it has collapsed, and why; None where it has not."""
    # what rests does not collapse
    may_have = far(system.model, begun, part.x, point) & part.v.any(axis=(1, 2))
    for k in np.flatnonzero(may_have):
        if k and (reason := collapse(system.model, system.contacts, begun, part.x[k], part.v[k], point)):
            return part.until(int(k)), reason
    return part, None


def _final_state(
    system: DynamicSystem, motion: Motion, begun: Array, record: Recorded, collapsed: bool
) -> State:
    """Return the state in which a recorded motion ends."""
    model, lengthened = system.model, None
    if model.ties:  # one that breaks does so within a chunk of steps
        yielded = motion.joints[system.system.ties, LONGER] + system.system.stretched
        lengthened = np.minimum(yielded, [tie.longest for tie in model.ties])
    final = State(record.x[-1], record.v[-1], lengthened=lengthened)
    if not system.system.rigid:
        final = with_springs(system.contacts, final, len(model.contacts), motion.joints[:, SPRING])
    # at collapse the last steps are left out of the record
    return final if collapsed else replace(final, motion=system.remembered(motion, begun))


def _result(
    system: DynamicSystem, start: State, final: State, record: Recorded, time_step: float, point: ControlPoint | None,
    reason: Message | None, rule: Rule, tolerances: HistoryTolerances,
) -> TimeHistory:  # fmt: skip
    """Return the result of a recorded motion."""
    # nine arguments: all that the run has, used once
    model = system.model
    energy = Energy.of(model, record.x, record.v, record.energy)
    turned = float(record.energy[-1, TURNED])
    sliding_error = _sliding_error(model, energy, turned, rule.integrator, tolerances)
    programs, iterations, halvings, cold = (int(value) for value in system.counts[:4])
    lifting, time = system.counts[6], time_step * np.arange(len(record.x), dtype=float)
    notes = _notes(model, record.x[-1], energy, lifting / max(programs, 1), sliding_error, tolerances)
    return TimeHistory(
        time=time, positions=record.x, velocities=record.v, forces=record.forces, start=start, final=final,
        displacement=None if point is None else point.displacement(model, start.positions, record.x),
        collapsed=bool(reason), time_of_collapse=float(time[-1]) if reason else None, collapse_reason=reason or "",
        energy=energy, integrator=rule.integrator, chosen=rule.why, programs=programs, iterations=iterations,
        halvings=halvings, cold=cold, worst=float(system.counts[4]),
        unsure=float(system.counts[5]) / max(energy.turnover, tolerances.nothing * model.weight * model.size),
        sliding_error=sliding_error, notes=notes, lifting=int(lifting), skipped=int(system.counts[7]), model=model,
    )  # fmt: skip


def _sliding_error(
    model: Assembly, energy: Energy, turned: float, integrator: Integrator, tolerances: HistoryTolerances
) -> float:
    """Return about the least error of displacements by sliding, a share of them; 0 where next to nothing rubs.

    A slide that turns back late by a share of its time has that error, and its square of the energy is uncertain
    (`turned`, kNm). By implicit Euler no slide turns back within a step: what it takes of all the energy shows, where
    that is less than friction takes; what it takes at impacts is more.
    """
    rubbed, taken = float(energy.friction[-1]), float(energy.integrator[-1])
    least = max(tolerances.rubs * energy.turnover, tolerances.nothing * model.weight * model.size)
    if integrator == "implicit-euler":
        return energy.integrator_share if rubbed > max(least, taken) else 0.0
    return float(np.sqrt(turned / rubbed)) if rubbed > least else 0.0


def _notes(
    model: Assembly, last: Array, energy: Energy, lifting: float, sliding_error: float, tolerances: HistoryTolerances
) -> tuple[Message, ...]:  # fmt: skip
    """Return warnings: of blocks that overlap, of steps, and of an energy balance with an error.

    `lifting`: share of the steps that lift; `sliding_error`: see TimeHistory.
    """
    notes = () if model.collisions else passing_through(model, last)
    if lifting > tolerances.lifting:
        text = message(
            "Coulomb's law was not solved in {share:.1%} of the steps: what slides lifts in these; take a shorter step",
            share=lifting,
        )
        notes = (*notes, text)
    if sliding_error > tolerances.slides:
        text = message(
            "steps are long beside the slides of joints: displacements by sliding may be wrong by {share:.0%} or more; "
            "take a shorter step", share=sliding_error,
        )  # fmt: skip
        notes = (*notes, text)
    moves = energy.turnover > tolerances.nothing * model.weight * model.size
    if moves and energy.imbalance > tolerances.balanced:
        text = message(
            "the energy balance leaves {share:.1%} of what was turned over open: "
            "a step is not solved as accurately as it should be; take a shorter one", share=energy.imbalance,
        )  # fmt: skip
        return (*notes, text)
    return notes
