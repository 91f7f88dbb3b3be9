"""Time histories: the motion of the blocks under an earthquake, or from an initial position (paper, §3 and §4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import ConvergenceError, NoEquilibriumError, UnstableError, require
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.model.contacts import end_gaps
from mechanics.procedures.collapse import ControlPoint, collapse, passing_through
from mechanics.procedures.energy import Energy
from mechanics.steps.contact_values import carried, with_springs
from mechanics.steps.dynamic_system import DynamicSystem, Halving, Motion, Recorded, first_frequency
from mechanics.steps.equilibrium import check_self_weight, rest, rest_size
from mechanics.steps.rest import lifted, motion_to_rest, way
from mechanics.steps.static_step import StepProblem
from mechanics.steps.static_system import static_system
from mechanics.steps.tolerances import REST
from mechanics.types import GRAVITY, Array

Integrator = Literal["auto", "moreau-jean", "second-order", "implicit-euler"]

FEW = 3  # movable blocks up to which impacts are located
LOCATED = Halving(10, 1e-4)  # steps of 1/1024 at impacts
RESOLVED = Halving(6, 1e-2)
UNSOLVED = Halving(6, np.inf)  # only steps that are not solved
CHUNK = 200  # steps between looks at what was recorded
BALANCED = 1e-3  # of the energy turned over: an imbalance that needs no word
TAKEN = 0.2  # of all that was dissipated: a share of the integrator that is told
NOTHING = 1e-6  # of the weight lifted by a block's size: an energy that is no motion


@dataclass(frozen=True, eq=False)
class TimeHistory:
    """The motion of b blocks at k times, in the frame of the ground: supports rest, the base motion is inertia.

    `time` (k,) s; `positions` (k, b, 3): x, z, ω as in State, `velocities` (k, b, 3); `forces` (k, j, 3): N, P and T
    (kN, kNm) of the drawn joints in the step that led to each time; `start` the state at rest the motion began from;
    `final` its last one. `displacement` (k,) m: of the control point along x from `start`, None without a control
    point.
    `collapsed`, `time_of_collapse` (s) and `collapse_reason`: see time_history; the arrays end there. `energy`: its
    balance at each time. `integrator` used, and `chosen` why. `programs` solved, in so many `iterations`, `halvings` of
    steps, `cold` starts; `worst`: the largest residual of a program, relative. `notes`: what to know about the motion.
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
    notes: tuple[str, ...]


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
) -> TimeHistory:
    """Integrate the motion under base accelerations (k,) in g, sampled at `time_step` (s) and linear in between.

    `integrator`: "second-order" is the midpoint rule, with rigid joints and their impacts located in steps of 1/1024;
    "moreau-jean" the same with steps of down to 1/64, halved where impacts take more than 1 % of the kinetic energy;
    "implicit-euler" the paper's; "auto" the second of them for rigid joints of more than three blocks, else the first.
    `vertical_acceleration` (k,) g, upward. A state at rest that gravity lets stand first settles on its elastic
    joints; any other, tilted or moving, is released as it is (default: as drawn). `damping_ratio`: of the viscous
    forces, proportional to the contact stiffness, at the first frequency of the structure as drawn, all joints closed
    (elastic joints). `restitution`: of normal velocities at impacts (rigid joints, second order). `control`: a drawn
    point whose horizontal displacement is followed.

    The run stops at collapse: a block turned by more than 1 rad, or fallen by more than its size and still falling,
    or out of reach of all its contacts; or the control point past its `ultimate` displacement (m) and moving outward.
    Raises ValueError naming a bad argument, ConvergenceError where a step is not solved.
    """
    base = _base(acceleration, vertical_acceleration, time_step)
    names = ("auto", "moreau-jean", "second-order", "implicit-euler")
    require(integrator in names, "integrator", integrator, ", ".join(f'"{name}"' for name in names))
    require(contacts == "rigid" or integrator != "moreau-jean", "integrator", integrator,
            '"auto", "second-order" or "implicit-euler" with elastic contacts')  # fmt: skip
    require(0.0 <= damping_ratio < 1.0, "damping_ratio", damping_ratio, "from 0 to less than 1")
    require(damping_ratio == 0.0 or contacts == "elastic", "damping_ratio", damping_ratio,
            "0 with rigid contacts, which have no stiffness to be proportional to")  # fmt: skip
    require(0.0 <= restitution <= 1.0, "restitution", restitution, "from 0 to 1")
    require(restitution == 0.0 or (contacts == "rigid" and integrator != "implicit-euler"), "restitution", restitution,
            "0 except with rigid contacts and an integrator of second order")  # fmt: skip
    require(ultimate is None or (control is not None and ultimate > 0.0), "ultimate", ultimate,
            "positive, in m, and given with a control point")  # fmt: skip
    point = None
    if control is not None:
        point = ControlPoint(np.asarray(control, dtype=float), model.block_at(control), ultimate)
    used, chosen = _chosen(model, contacts, integrator)
    system, start, motion = _begun(model, contacts, model.starting(state), used, damping_ratio, restitution)

    parts: list[Recorded] = []
    done, reason = 0, ""
    while done < len(base) - 1 and not reason:
        system = system.around(motion)
        part = system.march(motion, base[done : done + CHUNK + 1], time_step)
        for k in range(1, len(part.x)):
            reason = collapse(model, system.contacts, start, part.x[k], part.v[k], point)
            if reason:
                part = part.until(k)
                break
        parts.append(part)
        done += len(part.x) - 1
    return _history(system, start, motion, parts, time_step, point, reason, used, chosen)


def _chosen(model: Assembly, contacts: Behaviour, integrator: Integrator) -> tuple[Integrator, str]:
    """The integrator used, and why."""
    if integrator != "auto":
        return integrator, "as asked for"
    if contacts == "elastic":
        return "second-order", "elastic joints: no impact needs locating"
    movable = int(model.movable.sum())
    if movable <= FEW:
        return "second-order", f"{movable} movable blocks: every impact is located"
    return "moreau-jean", f"{movable} movable blocks: many impacts, resolved where they take energy"


def _begun(
    model: Assembly,
    contacts: Behaviour,
    state: State,
    integrator: Integrator,
    damping_ratio: float,
    restitution: float,
) -> tuple[DynamicSystem, State, Motion]:
    """The system, the state from which the motion begins, and the motion."""
    start, forces = _settled(model, contacts, state)
    statics = static_system(model, contacts).around(start.positions, 0.0)
    gaps = np.zeros(len(statics.contacts))
    if contacts == "rigid":
        # dilatant sliding has left gaps under joints that carry, from which loose blocks would begin to fall
        gap = end_gaps(statics.contacts.places(start.positions)).min(axis=1).clip(0.0)
        gaps = np.where(carried(statics.contacts, start), gap, 0.0)
    damping = 0.0
    if damping_ratio > 0.0:
        frequency = first_frequency(model)
        require(frequency > 0.0, "damping_ratio", damping_ratio,
                "0 where nothing holds some block as drawn: there is no frequency to refer it to")  # fmt: skip
        damping = 2.0 * damping_ratio / frequency
    theta = 1.0 if integrator == "implicit-euler" else 0.5
    halving = UNSOLVED
    if contacts == "rigid" and theta < 1.0:
        halving = LOCATED if integrator == "second-order" else RESOLVED
    system = DynamicSystem(statics, theta, damping, restitution, halving, gaps)
    if forces is not None and len(forces) != len(statics.contacts):
        forces = None
    return system, start, system.begun(start, forces)


def _settled(model: Assembly, contacts: Behaviour, state: State) -> tuple[State, Array | None]:
    """The state from which the motion begins, and its forces (j, 3) where they are known."""
    if contacts == "rigid" or state.velocities.any():
        return state, None
    size = rest_size(model, contacts)
    try:
        if state.carrying is None:
            check_self_weight(model, state)
        step = rest(static_system(model, contacts).around(state.positions, size), state)
        if lifted(step, model.weight) > REST.lifted * model.size:
            step = motion_to_rest(
                StepProblem(step.system, step.state, model.dead_load, size), step.state.positions
            )
        # what carries in a pushed state carries more than gravity
        if (
            state.carrying is not None
            and way(state.positions, step.state.positions, model.size) > REST.lifted * model.size
        ):
            check_self_weight(model, state)
    except (UnstableError, NoEquilibriumError, ConvergenceError):
        return state, None
    return step.state, step.forces


def _history(
    system: DynamicSystem, start: State, motion: Motion, parts: list[Recorded], time_step: float,
    point: ControlPoint | None, reason: str, integrator: Integrator, chosen: str,
) -> TimeHistory:  # fmt: skip
    """What was recorded, in one."""
    model, drawn = system.model, len(system.model.contacts)
    x, v, energies = (
        np.concatenate([parts[0].__dict__[name][:1], *(part.__dict__[name][1:] for part in parts)])
        for name in ("x", "v", "energy")
    )
    forces = np.concatenate([parts[0].forces[:1, :drawn], *(part.forces[1:, :drawn] for part in parts)])
    energy = Energy.of(model, x, v, energies)
    final = State(x[-1], v[-1])
    if not system.system.rigid:
        final = with_springs(system.contacts, final, drawn, motion.shear)
    programs, iterations, halvings, cold = (int(value) for value in system.counts[:4])
    time: Array = time_step * np.arange(len(x), dtype=float)
    return TimeHistory(
        time=time,
        positions=x,
        velocities=v,
        forces=forces,
        start=start,
        final=final,
        displacement=None if point is None else np.array([point.displacement(model, start, at) for at in x]),
        collapsed=bool(reason),
        time_of_collapse=float(time[-1]) if reason else None,
        collapse_reason=reason,
        energy=energy,
        integrator=integrator,
        chosen=chosen,
        programs=programs,
        iterations=iterations,
        halvings=halvings,
        cold=cold,
        worst=float(system.counts[4:].max()),
        notes=_notes(model, x[-1], energy),
    )


def _base(horizontal: ArrayLike, vertical: ArrayLike | None, time_step: float) -> Array:
    """Base acceleration (k, 3) in m/s²: x, z and no rotation."""
    a = np.asarray(horizontal, dtype=float)
    require(a.ndim == 1 and len(a) > 1, "acceleration", a.shape, "two or more samples, (k,), in g")
    require(bool(np.isfinite(a).all()), "acceleration", "nan or inf", "finite")
    require(0.0 < time_step < np.inf, "time_step", time_step, "positive, in s")
    base = np.zeros((len(a), 3))
    base[:, 0] = GRAVITY * a
    if vertical is not None:
        v = np.asarray(vertical, dtype=float)
        require(
            v.shape == a.shape, "vertical_acceleration", v.shape, f"of the horizontal one's shape {a.shape}"
        )
        require(bool(np.isfinite(v).all()), "vertical_acceleration", "nan or inf", "finite")
        base[:, 1] = GRAVITY * v
    return base


def _notes(model: Assembly, last: Array, energy: Energy) -> tuple[str, ...]:
    """What to know about a motion: blocks lying in each other, an open energy balance, what the integrator took."""
    notes = () if model.collisions else passing_through(model, last)
    moves = energy.turnover > NOTHING * model.weight * model.size
    if moves and energy.imbalance > BALANCED:
        notes += (
            f"the energy balance leaves {energy.imbalance:.1%} of what was turned over open: "
            "the geometry changes too much in a step; take a shorter one",
        )
    if moves and energy.integrator_share > TAKEN:
        notes += (
            f"the integrator itself took {energy.integrator_share:.0%} of the energy dissipated: "
            "the motion is damped by the time stepping; take a shorter step or another integrator",
        )
    return notes
