"""Time histories: the motion of the blocks under an earthquake, or from an initial position (paper, §3 and §4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mechanics.assembly import Assembly, Behaviour, State
from mechanics.block import GRAVITY, Array
from mechanics.energy import Energy, first_frequency, stored
from mechanics.equilibrium import check_self_weight, rest
from mechanics.errors import NoEquilibriumError, UnstableError, require
from mechanics.impacts import midpoint_with_impacts
from mechanics.integrators import implicit_euler, midpoint
from mechanics.program import Certificate
from mechanics.scene import Load, Motion, Scene
from mechanics.solvers.threads import one_thread

Integrator = Literal["implicit-euler", "second-order"]

TURNED = 1.0  # rad from the beginning: a block that has turned so far does not come back


@dataclass(frozen=True, eq=False)
class TimeHistory:
    """The motion of b blocks at k times, in the frame of the ground: supports rest, the base motion is inertia.

    `time` (k,) s; `positions` (k, b, 3): x, z, ω as in State, `velocities` (k, b, 3); `start` the state at rest the
    motion began from; `final` its last one. `displacement` (k,) m: of the control point along x from `start`, None
    without a control point. `collapsed`, `time_of_collapse` (s) and `collapse_reason`: see time_history; the arrays end
    there. `energy`: its balance at each time. `certificate`: worst residuals of every program; `worst`: the largest of
    them, relative; `fallbacks`: steps of the second-order scheme left to implicit Euler; `impacts` located; `solves`
    programs; `resolved`: of them, solved again by the reference solver. `notes`: what to know about the contacts.
    """

    time: Array
    positions: Array
    velocities: Array
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


def time_history(
    model: Assembly,
    acceleration: ArrayLike,
    time_step: float,
    contacts: Behaviour = "rigid",
    state: State | None = None,
    integrator: Integrator = "implicit-euler",
    vertical_acceleration: ArrayLike | None = None,
    damping_ratio: float = 0.0,
    control: ArrayLike | None = None,
    ultimate: float | None = None,
    restitution: float = 0.0,
) -> TimeHistory:
    """Integrate the motion under base accelerations (k,) in g, sampled at `time_step` (s) and linear in between.

    `vertical_acceleration` (k,) g, upward. A state at rest that gravity lets stand first settles on its elastic
    joints; any other, tilted or moving, is released as it is (default: as drawn). `damping_ratio`: of the viscous
    forces, proportional to the contact stiffness, at the first frequency with all closed contacts (elastic contacts).
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
    if damping_ratio > 0.0:
        scene.damping = 2.0 * damping_ratio / first_frequency(scene, start.positions)
    advance = implicit_euler
    if integrator == "second-order":
        advance = midpoint if contacts == "elastic" else midpoint_with_impacts

    motion = Motion(start.positions, start.velocities, forces, shear)
    motions, reason = [motion], ""
    with one_thread():
        for k in range(1, len(base)):
            motion = advance(scene, motion, _load(model, base, k - 1, time_step), 0.0, time_step)
            motions.append(motion)
            reason = _collapse(scene, start, motion, point, ultimate)
            if reason:
                break
    time: Array = time_step * np.arange(len(motions), dtype=float)
    return TimeHistory(
        time=time,
        positions=np.stack([m.x for m in motions]),
        velocities=np.stack([m.v for m in motions]),
        start=start,
        final=State(motion.x, motion.v, motion.shear if contacts == "elastic" else None),
        displacement=None if point is None else np.array([_control(model, point, start, m) for m in motions]),
        collapsed=bool(reason),
        time_of_collapse=float(time[-1]) if reason else None,
        collapse_reason=reason,
        energy=Energy.of(motions, *stored(scene, motions)),
        certificate=scene.certificate,
        worst=scene.worst,
        fallbacks=scene.fallbacks,
        impacts=scene.impacts,
        solves=scene.solves,
        resolved=scene.resolved,
        notes=_notes(scene, motion),
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
        check_self_weight(model, state)
        step = rest(model, contacts, state)
    except (UnstableError, NoEquilibriumError):
        return state, none, shear
    return step.state, step.forces, step.forces[:, 1]


def _control(model: Assembly, point: tuple[Array, int], start: State, motion: Motion) -> float:
    now, then = (model.point_displacement(*point, x) for x in (motion.x, start.positions))
    return float(now[0] - then[0])


def _collapse(
    scene: Scene, start: State, motion: Motion, point: tuple[Array, int] | None, ultimate: float | None
) -> str:
    """Why the motion cannot come back; empty where it can."""
    model = scene.model
    moved = motion.x - start.positions
    if point is not None and ultimate is not None:
        displacement = _control(model, point, start, motion)
        block = point[1]
        outward = motion.v[block] * displacement
        arm = model.point_displacement(*point, motion.x) + point[0] - motion.x[block, :2]
        if abs(displacement) > ultimate and outward[0] - outward[2] * arm[1] > 0.0:
            return f"the control point is {displacement:.3g} m away, past its ultimate displacement, and moving outward"
    turned = abs(moved[:, 2])
    if turned.max() > TURNED:
        return f"block {int(turned.argmax())} has turned by {turned.max():.2f} rad"
    size = scene.block_size
    fallen = (-moved[:, 1] > size) & (motion.v[:, 1] < 0.0)
    if fallen.any():
        block = int(np.argmax(np.where(fallen, -moved[:, 1], -np.inf)))
        return f"block {block} has fallen by {-moved[block, 1]:.3g} m"
    if abs(moved[:, :2]).max() > size.min():
        gap = scene.geometry(motion.x)[0]
        room = scene.contacts.room
        slide = gap[:, 1]
        a, b = scene.contacts.a, scene.contacts.b
        least = np.minimum(size[a], size[b])
        beyond = np.maximum(room[:, 0] - slide, slide - room[:, 1])
        lost = np.maximum(gap[:, 0], beyond) > least
        has = np.zeros(len(size), dtype=bool)
        has[a[~lost]] = has[b[~lost]] = True
        alone = model.movable & ~has
        if alone.any():
            return f"block {int(np.flatnonzero(alone)[0])} is out of reach of all its contacts"
    return ""


def _notes(scene: Scene, motion: Motion) -> tuple[str, ...]:
    """What the last configuration shows that the contacts as drawn cannot: slides off a surface, blocks in blocks."""
    import shapely

    model, notes = scene.model, []
    slide = scene.geometry(motion.x)[0][:, 1]
    room = scene.contacts.room
    off = np.maximum(room[:, 0] - slide, slide - room[:, 1])
    carries = (motion.forces[:, 0] > 0.0) & (off > 1e-3 * model.size)
    if carries.any():
        k = int(np.argmax(np.where(carries, off, -np.inf)))
        notes.append(
            f"block {scene.contacts.a[k]} has slid {off[k]:.3g} m beyond the edge of block {scene.contacts.b[k]} "
            "and is still carried by it: contacts act as if surfaces had no end"
        )
    cos, sin = np.cos(motion.x[:, 2]), np.sin(motion.x[:, 2])
    shapes = []
    for block, c, s, x in zip(model.blocks, cos, sin, motion.x, strict=True):
        arm = block.polygon - block.centroid
        shapes.append(shapely.Polygon(x[:2] + arm @ np.array([[c, s], [-s, c]])))
    first, second = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    pair = first < second
    first, second = first[pair], second[pair]
    area = shapely.area(shapely.intersection(np.array(shapes)[first], np.array(shapes)[second]))
    least = np.minimum(shapely.area(np.array(shapes)[first]), shapely.area(np.array(shapes)[second]))
    through = area > 0.01 * least
    if through.any():
        k = int(np.argmax(np.where(through, area / least, 0.0)))
        notes.append(
            f"block {first[k]} passes through block {second[k]}: they did not touch as drawn, or slid off each other"
        )
    return tuple(notes)
