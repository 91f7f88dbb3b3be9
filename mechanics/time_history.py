"""Time histories: the motion of the blocks under an earthquake, or from an initial position (paper, §3 and §4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mechanics.assembly import Assembly, Behaviour, State
from mechanics.collapse import collapse, control_displacement, passing_through
from mechanics.energy import Energy, first_frequency
from mechanics.equilibrium import check_self_weight, rest
from mechanics.errors import NoEquilibriumError, UnstableError, require
from mechanics.impacts import midpoint_with_impacts
from mechanics.integrators import RINGING, implicit_euler, midpoint
from mechanics.mechanism import overruns
from mechanics.program import Certificate
from mechanics.relaxation import LIFTED, come_to_rest, way
from mechanics.scene import Load, Motion, Scene
from mechanics.solvers.threads import one_thread
from mechanics.types import GRAVITY, Array

Integrator = Literal["implicit-euler", "second-order"]

BALANCED = 0.05  # of the energy turned over: an imbalance that needs no word
NOTHING = 1e-6  # of the weight lifted by a block's size: an energy that is no motion
WATCHED = 20  # steps between configurations looked at for blocks past an edge


@dataclass(frozen=True, eq=False)
class TimeHistory:
    """The motion of b blocks at k times, in the frame of the ground: supports rest, the base motion is inertia.

    `time` (k,) s; `positions` (k, b, 3): x, z, ω as in State, `velocities` (k, b, 3); `forces`, k times (c, 2) kN: of
    the contacts, in the step that led to each time; `start` the state at rest the
    motion began from; `final` its last one. `displacement` (k,) m: of the control point along x from `start`, None
    without a control point. `collapsed`, `time_of_collapse` (s) and `collapse_reason`: see time_history; the arrays end
    there. `energy`: its balance at each time. `certificate`: worst residuals of every program; `worst`: the largest of
    them, relative; `fallbacks`: steps of the second-order scheme whose rest was taken without locating more
    impacts; `impacts` located; `solves` programs; `resolved`: of them, solved again by the reference solver. `notes`:
    what to know about the contacts.
    """

    time: Array
    positions: Array
    velocities: Array
    forces: tuple[Array, ...]
    start: State
    final: State
    displacement: Array | None
    collapsed: bool
    time_of_collapse: float | None
    collapse_reason: str
    energy: Energy
    certificate: Certificate
    worst: float
    fallbacks: int
    impacts: int
    solves: int
    resolved: int
    notes: tuple[str, ...]


@one_thread()
def time_history(
    model: Assembly,
    acceleration: ArrayLike,
    time_step: float,
    contacts: Behaviour = "rigid",
    state: State | None = None,
    integrator: Integrator = "second-order",
    vertical_acceleration: ArrayLike | None = None,
    damping_ratio: float = 0.0,
    control: ArrayLike | None = None,
    ultimate: float | None = None,
    restitution: float = 0.0,
) -> TimeHistory:
    """Integrate the motion under base accelerations (k,) in g, sampled at `time_step` (s) and linear in between.

    `integrator`: the midpoint rule, with rigid contacts and its impacts located, or the paper's implicit Euler.
    `vertical_acceleration` (k,) g, upward. A state at rest that gravity lets stand first settles on its elastic
    joints; any other, tilted or moving, is released as it is (default: as drawn). `damping_ratio`: of the viscous
    forces, proportional to the contact stiffness, at the first frequency of the structure as drawn, all contacts closed
    (elastic contacts).
    `restitution`: of normal velocities at impacts (rigid contacts, second-order integrator). `control`: a drawn
    point whose horizontal displacement is followed.

    The run stops at collapse: a block turned by more than 1 rad, or fallen by more than its size and still falling,
    or out of reach of all its contacts; or the control point past its `ultimate` displacement (m) and moving outward.
    Raises ValueError naming a bad argument, ConvergenceError where a step is not solved.
    """
    base = _base(acceleration, vertical_acceleration, time_step)
    require(integrator in {"implicit-euler", "second-order"}, "integrator", integrator,
            '"implicit-euler" or "second-order"')  # fmt: skip
    require(0.0 <= damping_ratio < 1.0, "damping_ratio", damping_ratio, "from 0 to less than 1")
    require(damping_ratio == 0.0 or contacts == "elastic", "damping_ratio", damping_ratio,
            "0 with rigid contacts, which have no stiffness to be proportional to")  # fmt: skip
    require(0.0 <= restitution <= 1.0, "restitution", restitution, "from 0 to 1")
    require(restitution == 0.0 or (contacts, integrator) == ("rigid", "second-order"), "restitution", restitution,
            "0 except with rigid contacts and the second-order integrator")  # fmt: skip
    require(ultimate is None or (control is not None and ultimate > 0.0), "ultimate", ultimate,
            "positive, in m, and given with a control point")  # fmt: skip
    point = None if control is None else (np.asarray(control, dtype=float), model.block_at(control))
    scene = Scene(model, contacts, restitution=restitution)
    start, forces, shear = _settled(model, contacts, state or model.initial)
    if contacts == "rigid":
        # dilatant sliding has left gaps under joints that carry, from which loose blocks would begin to fall
        gap = model.kinematics(contacts, start.positions).gap
        scene.lifted = np.where(model.carrying(start), gap.clip(0.0), 0.0)
    if damping_ratio > 0.0:
        frequency = first_frequency(scene)
        require(frequency > 0.0, "damping_ratio", damping_ratio,
                "0 where nothing holds some block as drawn: there is no frequency to refer it to")  # fmt: skip
        scene.damping = 2.0 * damping_ratio / frequency
    advance = implicit_euler
    if integrator == "second-order" and contacts == "elastic":
        advance, scene.newton.start.newest = midpoint, RINGING
    elif integrator == "second-order":
        advance = midpoint_with_impacts

    motion = Motion(
        start.positions, start.velocities, forces, shear, scene.strain_energy(start.positions, shear)
    )
    motions, reason = [motion], ""
    for k in range(1, len(base)):
        motion = advance(scene, motion, _load(model, base, k - 1, time_step), 0.0, time_step)
        motions.append(motion)
        reason = collapse(scene, start, motion, point, ultimate)
        if reason:
            break
    energy = Energy.of(model, motions)
    time: Array = time_step * np.arange(len(motions), dtype=float)
    return TimeHistory(
        time=time,
        positions=np.stack([m.x for m in motions]),
        velocities=np.stack([m.v for m in motions]),
        forces=tuple(m.forces for m in motions),
        start=start,
        final=State(motion.x, motion.v, motion.shear if contacts == "elastic" else None),
        displacement=None
        if point is None
        else np.array([control_displacement(model, point, start, m.x) for m in motions]),
        collapsed=bool(reason),
        time_of_collapse=float(time[-1]) if reason else None,
        collapse_reason=reason,
        energy=energy,
        certificate=scene.certificate,
        worst=scene.worst,
        fallbacks=scene.fallbacks,
        impacts=scene.impacts,
        solves=scene.solves,
        resolved=scene.resolved,
        notes=_notes(scene, motions, energy),
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


def _load(model: Assembly, base: Array, k: int, time_step: float) -> Load:
    """Dead load and inertia of the base motion (b, 3), kN, at a time after sample k."""

    def at(time: float) -> Array:
        share = time / time_step
        load: Array = model.dead_load - model.mass * ((1.0 - share) * base[k] + share * base[k + 1])
        return load

    return at


def _settled(model: Assembly, contacts: Behaviour, state: State) -> tuple[State, Array, Array]:
    """The state from which the motion begins, its contact forces (c, 2) and the shear of its springs (c,), kN."""
    none = np.zeros((len(model.contacts(contacts)), 2))
    shear = none[:, 1] if contacts == "rigid" or state.shear is None else state.shear
    if contacts == "rigid" or state.velocities.any():
        return state, none, shear
    try:
        if state.carrying is None:
            check_self_weight(model, state)
        step = come_to_rest(model, rest(model, contacts, state))
        moved = way(model, state.positions, step.state.positions)
        # what carries in a pushed state carries more than gravity
        if state.carrying is not None and moved > LIFTED * model.size:
            check_self_weight(model, state)
    except (UnstableError, NoEquilibriumError):
        return state, none, shear
    return step.state, step.forces, step.forces[:, 1]


def _notes(scene: Scene, motions: list[Motion], energy: Energy) -> tuple[str, ...]:
    """What to know about a motion: blocks carried past an edge or lying in each other, an open energy balance."""
    watched = [*motions[:-1:WATCHED], motions[-1]]
    notes = overruns(scene.model, scene.behaviour, ((m.x, m.forces) for m in watched))
    notes += passing_through(scene.model, motions[-1].x)
    moves = energy.turnover > NOTHING * scene.model.weight * scene.model.size
    if moves and energy.imbalance > BALANCED:
        notes += (
            f"the energy balance leaves {energy.imbalance:.0%} of what was turned over open: "
            "the geometry changes too much in a step; take a shorter one",
        )
    return notes
