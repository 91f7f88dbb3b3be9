"""Time histories: the motion of the blocks under an earthquake, or from an initial position (paper, §3 and §4)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import (
    ConvergenceError,
    NoEquilibriumError,
    UnstableError,
    array_of,
    is_number,
    require,
)
from mechanics.kernels.dynamics.motion import TURNED
from mechanics.messages import Message, message
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.model.contacts import end_gaps
from mechanics.pictures import draw_curve, film
from mechanics.procedures.collapse import ControlPoint, collapse, far, passing_through
from mechanics.procedures.elastic_periods import contact_period, first_frequency
from mechanics.procedures.energy import Energy, may_fall
from mechanics.procedures.model_check import departure_in_motion
from mechanics.progress import tell
from mechanics.steps.contact_values import carried, with_springs
from mechanics.steps.dynamic_system import (
    DynamicSystem,
    Halving,
    Motion,
    Recorded,
)
from mechanics.steps.equilibrium import check_self_weight, rest, rest_size
from mechanics.steps.rest import come_down, way
from mechanics.steps.static_system import Sliding, static_system
from mechanics.steps.tolerances import REST
from mechanics.types import GRAVITY, Array

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes

Integrator = Literal["auto", "moreau-jean", "second-order", "implicit-euler"]


@dataclass(frozen=True, slots=True)
class HistoryTolerances:
    """Tolerances of a time history.

    Halving of steps. `few`: most movable blocks for which every impact is located; `located`, second order with rigid
    joints: steps down to 1/1024 at impacts; `resolved`, Moreau and Jean: down to 1/64 where impacts take energy;
    `closing`, second order with elastic joints. Elastic joints by either rule: at most `contacts` times, until half the
    period of the stiffest contact has `steps_a_contact` steps. `unsolved`, implicit Euler: only steps that are not
    solved are halved.

    `accepted`: residual of a program, per weight and span; `skips`: whether rest is skipped; `chunk`: steps after which
    collapse is looked for; `checked`: steps of which one is checked against the model.

    Warnings. `balanced`: imbalance, as a share of the energy turned over, that needs none; `lifting`: share of the
    programs that are solved by the associative law which needs none; `slides`: error of slides that needs none, where
    friction takes more than the share `rubs` of the energy; `nothing`: energy, as a share of the weight lifted by a
    block's size, below which nothing moves; `rests`, rigid, and `trembles`, elastic joints: speed, of √(g·size), below
    which a block rests, the largest in the last `lately` s; `spent`: share of the potential energy from which the
    structure has come back, with less of which it does not fall.
    """

    few: int = 3
    located: Halving = Halving(10, 1e-4, of_moment=True)
    resolved: Halving = Halving(6, 4e-3, unsure=1e-4)
    closing: Halving = Halving(10, 2.5e-4, unsure=1e-4)
    contacts: int = 10
    steps_a_contact: int = 8
    unsolved: Halving = Halving(0, np.inf)
    accepted: float = 1e-7
    skips: bool = True
    chunk: int = 200
    checked: int = 100
    balanced: float = 1e-4
    lifting: float = 1e-3
    slides: float = 0.02
    rubs: float = 0.05
    nothing: float = 1e-6
    rests: float = 1e-5
    trembles: float = 1e-2
    lately: float = 0.5
    spent: float = 0.5


HISTORY = HistoryTolerances()
# of motions that are asked only whether they collapse: 11.7 → 9.2 iterations a program of the triumphal arch
SEARCH = HistoryTolerances(resolved=Halving(6, 4e-3, unsure=1e-2))


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
    strength have to be elastic: what is crushed of them stays so (kernels.crushing).

    The motion ends at collapse: a block has turned by more than 1 rad from the drawing, has fallen by more than its
    size and still falls, or is out of reach of all its contacts; or the control point moves outward past its `ultimate`
    displacement (m). Raises ArgumentError for an argument out of its range, ConvergenceError if a step is not solved.
    """
    # thirteen arguments: the public function of the package, called with keywords
    Assembly.check(model)
    base = _base(acceleration, vertical_acceleration, time_step)
    _check(model, contacts, integrator, damping_ratio, restitution)
    point = _control_point(model, control, ultimate)
    used, chosen = _chosen(model, contacts, integrator, tolerances.few)
    halving, resolved = _halving(model, contacts, used, time_step, tolerances)
    system, start, motion, undecided = _begun(
        model, contacts, sliding, model.starting(state), used, halving, damping_ratio, restitution, tolerances
    )

    parts: list[Recorded] = []
    done, reason = 0, None
    begun = start.positions if start.motion is None else start.motion.begun
    while done < len(base) - 1 and not reason:
        system = system.around(motion)
        ahead = (float(base[done:, 0].min()), float(base[done:, 0].max()))
        marched = system.march(motion, base[done : done + tolerances.chunk + 1], time_step, ahead)
        _check_motion(system, marched, done, time_step, tolerances.checked)
        part, reason = _until_collapse(system, marched, begun, point)
        parts.append(part)
        done += len(part.x) - 1
        tell(done / (len(base) - 1))
    found = _history(
        system, start, begun, motion, parts, time_step, point, reason, used, chosen + resolved, tolerances
    )
    notes = (undecided, *found.notes, unfinished(found))
    return replace(found, notes=tuple(note for note in notes if note is not None))


def unfinished(*parts: TimeHistory) -> Message | None:
    """Return a warning that blocks may fall after motions that follow each other; None if not, and at collapse."""
    speed = parts[-1].speed_at_end
    if not speed or not may_fall([part.energy for part in parts], HISTORY.spent):
        return None
    return message(
        "blocks still move at the end, at {speed:.2g} m/s, and may fall after it: collapse and residual displacement "
        "are not known; continue the base motion with zeros",
        speed=speed,
    )


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
    may_have = far(system.model, begun, part.x, point) & part.v.any(
        axis=(1, 2)
    )  # what rests does not collapse
    for k in np.flatnonzero(may_have):
        if k and (reason := collapse(system.model, system.contacts, begun, part.x[k], part.v[k], point)):
            return part.until(int(k)), reason
    return part, None


def _check(
    model: Assembly, contacts: Behaviour, integrator: Integrator, damping_ratio: float, restitution: float
) -> None:
    """Raise ArgumentError for contacts that cannot move so, and what the contacts do not have of the others."""
    require(contacts == "elastic" or not model.crushes, "contacts", contacts,
            '"elastic" where joints have a compressive_strength: rigid ones forget what was crushed')  # fmt: skip
    names = ("auto", "moreau-jean", "second-order", "implicit-euler")
    require(integrator in names, "integrator", integrator, ", ".join(f'"{name}"' for name in names))
    require(
        is_number(damping_ratio) and 0.0 <= damping_ratio < 1.0,
        "damping_ratio",
        damping_ratio,
        "from 0 to less than 1",
    )
    require(damping_ratio == 0.0 or contacts == "elastic", "damping_ratio", damping_ratio,
            "0 with rigid contacts, which have no stiffness to be proportional to")  # fmt: skip
    require(is_number(restitution) and 0.0 <= restitution <= 1.0, "restitution", restitution, "from 0 to 1")
    require(restitution == 0.0 or (contacts == "rigid" and integrator != "implicit-euler"), "restitution", restitution,
            "0 except with rigid contacts and an integrator of second order")  # fmt: skip


def _chosen(model: Assembly, contacts: Behaviour, integrator: Integrator, few: int) -> tuple[Integrator, str]:
    """Return the integrator that is used, and why; `few`: see HistoryTolerances."""
    if integrator != "auto":
        return integrator, "as asked for"
    if contacts == "elastic":
        return "second-order", "elastic joints: steps are halved where closing joints take energy"
    movable = int(model.movable.sum())
    if movable <= few:
        return "second-order", f"{movable} movable blocks: every impact is located"
    return "moreau-jean", f"{movable} movable blocks: many impacts, resolved where they take energy"


def _begun(
    model: Assembly,
    contacts: Behaviour,
    sliding: Sliding,
    state: State,
    integrator: Integrator,
    halving: Halving,
    damping_ratio: float,
    restitution: float,
    tolerances: HistoryTolerances,
) -> tuple[DynamicSystem, State, Motion, Message | None]:
    """Return the system, the state in which the motion begins, the motion, and a warning about that state."""
    # nine arguments: the system and the beginning, as time_history has them
    start, forces, undecided = _settled(model, contacts, sliding, state)
    statics = static_system(model, contacts, sliding).around(start.positions, 0.0)
    gaps = np.zeros(len(statics.contacts))
    if contacts == "rigid":
        # dilatant sliding leaves gaps in joints that carry: loose blocks must not fall through them
        gap = end_gaps(statics.places(start.positions, start)).min(axis=1).clip(0.0)
        gaps = np.where(carried(statics.contacts, start), gap, 0.0)
    theta = 1.0 if integrator == "implicit-euler" else 0.5
    damping, accepted = _damping(model, damping_ratio), tolerances.accepted
    system = DynamicSystem(statics, theta, damping, restitution, halving, accepted, skips=tolerances.skips)
    if forces is not None and len(forces) != len(statics.contacts):
        forces = None
    return system, start, system.begun(start, forces, gaps), undecided


def _damping(model: Assembly, damping_ratio: float) -> float:
    """Return viscous forces over elastic ones, s, that damp the first frequency as drawn by a share of critical."""
    if damping_ratio == 0.0:
        return 0.0
    frequency = first_frequency(model)
    require(frequency > 0.0, "damping_ratio", damping_ratio,
            "0 where nothing holds some block as drawn: there is no frequency to refer it to")  # fmt: skip
    return 2.0 * damping_ratio / frequency


def _halving(
    model: Assembly,
    contacts: Behaviour,
    integrator: Integrator,
    time_step: float,
    tolerances: HistoryTolerances,
) -> tuple[Halving, str]:
    """Return when steps are halved, and how often, and what there is to say of it."""
    if integrator == "implicit-euler":
        return tolerances.unsolved, ""
    if contacts == "rigid":
        return tolerances.located if integrator == "second-order" else tolerances.resolved, ""
    halving = tolerances.closing if integrator == "second-order" else tolerances.resolved
    if int(model.movable.sum()) <= tolerances.few:
        halving = replace(halving, of_moment=True)
    if halving.levels == 0:
        return halving, ""
    half_period = np.pi * contact_period(model)
    asked = max(int(np.ceil(np.log2(tolerances.steps_a_contact * time_step / half_period))), 0)
    levels = min(asked, tolerances.contacts)
    shortest = 1e3 * time_step / 2**levels
    if levels < asked:
        return replace(halving, levels=levels), (
            f"; down to {shortest:.2g} ms: contacts of the stiffest joint last {1e3 * half_period:.2g} ms and are "
            "impacts without bounce"
        )
    return replace(
        halving, levels=levels
    ), f"; down to {shortest:.2g} ms, contacts of the stiffest joint are resolved"


def _settled(
    model: Assembly, contacts: Behaviour, sliding: Sliding, state: State
) -> tuple[State, Array | None, Message | None]:
    """Return the state in which the motion begins, and its joint forces (j, 3); None where they are not known.

    What cannot stand is released as it is; what only may not, too, with a warning.
    """
    if contacts == "rigid" or state.velocities.any():
        return state, None, None
    size = rest_size(model, contacts)
    try:
        if state.carrying is None:
            check_self_weight(model, state)
        system = static_system(model, contacts, sliding).around(state.positions, size)
        step = come_down(rest(system, state), size)
        # the joints of a pushed state carry the push too: that it stands without it has to be checked
        if (
            state.carrying is not None
            and way(state.positions, step.state.positions, model.size) > REST.lifted * model.size
        ):
            check_self_weight(model, state)
    except (UnstableError, NoEquilibriumError):
        return state, None, None
    except ConvergenceError as error:
        released = message(
            "whether the structure rests on its elastic joints before the motion was not decided: {reason}; it is "
            "released as it is",
            reason=error.message,
        )
        return state, None, released
    return replace(step.state, motion=None), step.forces, None


def _history(
    system: DynamicSystem, start: State, begun: Array, motion: Motion, parts: list[Recorded], time_step: float,
    point: ControlPoint | None, reason: Message | None, integrator: Integrator, chosen: str,
    tolerances: HistoryTolerances,
) -> TimeHistory:  # fmt: skip
    """Join the recorded parts of a motion to its result."""
    # eleven arguments: all that the run has, used once
    model, drawn = system.model, len(system.model.contacts)
    x, v, energies = (
        np.concatenate([parts[0].__dict__[name][:1], *(part.__dict__[name][1:] for part in parts)])
        for name in ("x", "v", "energy")
    )
    forces = np.concatenate([parts[0].forces[:1, :drawn], *(part.forces[1:, :drawn] for part in parts)])
    energy = Energy.of(model, x, v, energies)
    sliding_error = _sliding_error(model, energy, float(energies[-1, TURNED]), integrator, tolerances)
    lengthened = None
    if model.ties:
        lengthened = motion.longer[system.system.ties] + system.system.stretched
    final = State(x[-1], v[-1], lengthened=lengthened)
    if not system.system.rigid:
        final = with_springs(system.contacts, final, drawn, motion.shear)
    if not reason:  # at collapse the last steps are left out of the record
        final = replace(final, motion=system.remembered(motion, begun))
    programs, iterations, halvings, cold = (int(value) for value in system.counts[:4])
    time: Array = time_step * np.arange(len(x), dtype=float)
    return TimeHistory(
        time=time,
        positions=x,
        velocities=v,
        forces=forces,
        start=start,
        final=final,
        displacement=None if point is None else point.displacement(model, start.positions, x),
        collapsed=bool(reason),
        time_of_collapse=float(time[-1]) if reason else None,
        collapse_reason=reason or "",
        energy=energy,
        integrator=integrator,
        chosen=chosen,
        programs=programs,
        iterations=iterations,
        halvings=halvings,
        cold=cold,
        worst=float(system.counts[4]),
        unsure=float(system.counts[5]) / max(energy.turnover, tolerances.nothing * model.weight * model.size),
        sliding_error=sliding_error,
        notes=_notes(model, x[-1], energy, system.counts[6] / max(programs, 1), sliding_error, tolerances),
        lifting=int(system.counts[6]),
        skipped=int(system.counts[7]),
        model=model,
    )


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


def _base(horizontal: ArrayLike, vertical: ArrayLike | None, time_step: float) -> Array:
    """Return the base acceleration (k, 3) in m/s²: x, z, and 0 for the rotation."""
    require(is_number(time_step) and 0.0 < time_step < np.inf, "time_step", time_step, "positive, in s")
    given = {"acceleration": horizontal} | ({} if vertical is None else {"vertical_acceleration": vertical})
    components = {
        name: array_of(name, values, "two or more samples, (k,), in g") for name, values in given.items()
    }
    a = components["acceleration"]
    require(a.ndim == 1 and len(a) > 1, "acceleration", a.shape, "two or more samples, (k,), in g")
    base = np.zeros((len(a), 3))
    for axis, (name, values) in enumerate(components.items()):
        require(values.shape == a.shape, name, values.shape, f"of the horizontal one's shape {a.shape}")
        require(bool(np.isfinite(values).all()), name, "nan or inf", "finite")
        base[:, axis] = GRAVITY * values
    return base


def _notes(
    model: Assembly,
    last: Array,
    energy: Energy,
    lifting: float,
    sliding_error: float,
    tolerances: HistoryTolerances,
) -> tuple[Message, ...]:
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
            "take a shorter step",
            share=sliding_error,
        )
        notes = (*notes, text)
    moves = energy.turnover > tolerances.nothing * model.weight * model.size
    if moves and energy.imbalance > tolerances.balanced:
        text = message(
            "the energy balance leaves {share:.1%} of what was turned over open: "
            "a step is not solved as accurately as it should be; take a shorter one",
            share=energy.imbalance,
        )
        return (*notes, text)
    return notes
