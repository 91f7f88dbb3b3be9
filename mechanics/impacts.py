"""The midpoint rule with rigid contacts: impacts located in the step and resolved as inelastic (design.md §4)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mechanics.block import GRAVITY, Array
from mechanics.errors import ConvergenceError
from mechanics.integrators import implicit_euler
from mechanics.joints import Index
from mechanics.scene import Load, Motion, Scene
from mechanics.solvers import compiled_impacts as loops

CLOSED = 1e-6  # of the block size: a gap that is none
RESTING = 1e-5  # of √(g·size): an approach that is none
CARRYING = 1e-5  # of a block's weight: a contact force that is one
FAINT = 0.01  # of the energy scale: what impacts in a step may take without being located
MOST_EVENTS = 6  # impacts located in one step; where more come, contacts chatter
FAR = 30  # displacements of a step: a gap that cannot close in it
SETTLED = 1e-4  # of a displacement: dilation that is no longer corrected
STRAIGHT = 1e-6  # of a displacement: the same of what the gaps open beyond linear rows
LEAST, MOST = 0.3, 10.0  # of a correction: how far an extrapolated one goes
STUCK = 1e-4  # of a displacement: a slip that is none
MOST_TRIALS = 12  # of the time of one impact, or of the slip that dilates


def midpoint_with_impacts(scene: Scene, motion: Motion, load: Load, time: float, step: float) -> Motion:
    """The midpoint rule at velocity level on closed contacts, impacts located in the step and resolved there.

    It keeps the energy between events. Where more than a few impacts fall into one step, the rest of it is taken
    without locating them, and counted; where friction leaves no such motion, by implicit Euler.
    """
    done = 0.0
    try:
        for _ in range(MOST_EVENTS):
            gap = _gaps(scene, motion)
            motion = _impact(scene, motion, gap)
            whole = _midpoint(scene, motion, gap, load, time + done, step - done)
            taken = whole.impact - motion.impact
            if taken <= 0.0 or taken <= FAINT * _energy_scale(scene, motion, step):
                return whole
            motion, h = _until_impact(scene, motion, load, time + done, step - done)
            done += h
            if step - done <= 1e-9 * step:
                return motion
        scene.fallbacks += 1
        return _midpoint(scene, motion, _gaps(scene, motion), load, time + done, step - done)
    except ConvergenceError:
        # jammed by friction: no motion without dilation exists (Painlevé)
        scene.fallbacks += 1
        return implicit_euler(scene, motion, load, time + done, step - done)


def _energy_scale(scene: Scene, motion: Motion, step: float) -> float:
    """Kinetic energy (kNm), and that of the speed which gravity gives in a step."""
    kinetic = 0.5 * float((scene.model.mass * motion.v**2).sum())
    return kinetic + 0.5 * scene.model.weight * GRAVITY * step**2


def _gaps(scene: Scene, motion: Motion) -> Array:
    """Gaps (c,) m, zero where blocks lie in each other: by a solver's tolerance, which is left as it is."""
    return np.maximum(scene.geometry(motion.x)[0][:, 0], 0.0)


def _until_impact(scene: Scene, motion: Motion, load: Load, time: float, step: float) -> tuple[Motion, float]:
    """The motion after the step, or after the part of it at whose end the first open contact closes (Illinois)."""
    tolerance = CLOSED * scene.model.size
    start = _gaps(scene, motion)
    is_open = start > tolerance
    apart = np.where(is_open, FAR * scene.span(motion.v, step), start)
    new = _midpoint(scene, motion, apart, load, time, step)

    def closest(to: Motion) -> float:
        return float(scene.geometry(to.x)[0][is_open, 0].min(initial=np.inf))

    high, at_high = step, closest(new)
    if at_high >= -tolerance:
        return new, step
    low, at_low, side = 0.0, float(start[is_open].min()), 0
    for _ in range(MOST_TRIALS):
        h = high - at_high * (high - low) / (at_high - at_low)
        new = _midpoint(scene, motion, apart, load, time, h)
        here = closest(new)
        if abs(here) <= 0.1 * tolerance:
            return new, h
        if here < 0.0:
            high, at_high, at_low = h, here, at_low * (0.5 if side < 0 else 1.0)
            side = -1
        else:
            low, at_low, at_high = h, here, at_high * (0.5 if side > 0 else 1.0)
            side = 1
    return new, h


def _midpoint(scene: Scene, motion: Motion, gap: Array, load: Load, time: float, step: float) -> Motion:
    """The midpoint rule, (v₀ + v)/2 = Δx/Δt, with the geometry of the middle, for contacts with gaps (c,) m.

    One that closes in the step stays closed, without bounce; what that takes counts as impact.
    """
    start, normal, tangent = scene.geometry(motion.x)
    force = load(time + 0.5 * step)
    guess = step * motion.v + 0.5 * step**2 * _acceleration(scene, force, (normal, tangent), motion.forces)

    def rows(dx: Array) -> tuple[Array, Array]:
        # at half the time, not half the way: the phase is the better for it
        return scene.geometry(motion.x + 0.25 * (dx + step * motion.v))[1:]

    def opened(dx: Array) -> Array:
        change: Array = scene.geometry(motion.x + dx)[0][:, 0] - start[:, 0]
        return change

    mass, span = 2.0 * scene.mass / step**2, scene.span(motion.v, step)
    momentum = force + 2.0 * scene.model.mass * motion.v / step
    dx, forces, opening, slip, change = _without_dilation(
        scene, mass, momentum, rows, opened, gap, motion, guess, span
    )
    x, v = motion.x + dx, 2.0 * dx / step - motion.v
    v, taken, hold = _kept_together(scene, x, v, forces, gap + change, slip, STUCK * span)
    a, b = scene.contacts.a, scene.contacts.b
    closes = loops.strikes(
        a, b, normal, motion.v, gap, hold, CLOSED * scene.model.size, RESTING * scene.speed
    )
    # what contacts take: friction on their slip, and of normal forces where gaps close, or rows turn with the blocks
    taken -= float(forces[:, 0] @ opening)
    return Motion(
        x=x,
        v=v,
        forces=forces,
        shear=motion.shear,
        friction=motion.friction - float(forces[:, 1] @ slip),
        impact=motion.impact + (taken if closes else 0.0),
        viscous=motion.viscous,
        integrator=motion.integrator + (0.0 if closes else taken),
        input=motion.input + scene.work_of_loads(force, dx),
    )


def _acceleration(scene: Scene, load: Array, rows: tuple[Array, Array], forces: Array) -> Array:
    """Accelerations (b, 3) under loads (b, 3) and the last contact forces (c, 2): none where these are not known yet.

    None either where the solver's tolerance is all that sets blocks at rest in motion.
    """
    found = np.empty_like(load)
    a, b = scene.contacts.a, scene.contacts.b
    largest = loops.accelerations(a, b, *rows, forces, load, scene.mobility, found)
    if largest <= RESTING * GRAVITY or not forces.any():
        return np.zeros_like(found)
    return found


def _kept_together(
    scene: Scene, x: Array, v: Array, forces: Array, gap: Array, slip: Array, stuck: float
) -> tuple[Array, float, Index]:
    """Velocities with the contacts that carry together, and those that came to rest in the step at rest; energy taken.

    A contact stuck in the mean, or whose slip (c,) turned in the step, would go back as fast as it came. Which contacts
    (c,) are held, see compiled_impacts.held.
    """
    _, normal, tangent = scene.geometry(x)
    contacts, rate, hold = scene.contacts, np.empty_like(forces), np.empty(len(gap), np.intp)
    fastest = loops.held(
        contacts.a, contacts.b, normal, tangent, v, forces, gap, slip, contacts.friction, CARRYING * scene.weight,
        CLOSED * scene.model.size, stuck, rate, hold,
    )  # fmt: skip
    if fastest <= RESTING * scene.speed:
        return v, 0.0, hold
    new = v + scene.spread(scene.newton.close(scene.mass, normal, tangent, rate, hold))
    # the impulses that hold do work at the mean velocity
    return new, -0.5 * float((scene.model.mass * (new - v) * (new + v)).sum()), hold


def _impact(scene: Scene, motion: Motion, gap: Array) -> Motion:
    """Velocities after the impulses of the closed contacts that approach: M(v₁ − v₀) = A₀p, v₁ₙ ≥ −e·v₀ₙ."""
    _, normal, tangent = scene.geometry(motion.x)
    closed, least = CLOSED * scene.model.size, RESTING * scene.speed
    if loops.closing(scene.contacts.a, scene.contacts.b, normal, motion.v, gap, closed) >= -least:
        return motion
    scene.impacts += 1
    span = max(float(abs(motion.v[:, :2]).max()), least)
    bounce = scene.restitution * np.minimum(scene.relative(normal, motion.v), 0.0)
    after, impulses, *_ = _without_dilation(
        scene, scene.mass / scene.impulse, scene.model.mass * motion.v / scene.impulse, lambda _: (normal, tangent),
        lambda moved: scene.relative(normal, moved), np.where(gap <= closed, bounce, FAR * span), motion, motion.v,
        span,
    )  # fmt: skip
    # impulses do work at the mean velocity of the impact
    mean = 0.5 * (motion.v + after)
    rates = np.stack([scene.relative(normal, mean), scene.relative(tangent, mean)], axis=1)
    loss = -scene.impulse * float((impulses * rates).sum())
    return replace(motion, v=after, impact=motion.impact + loss)


def _without_dilation(
    scene: Scene, mass: Array, load: Array, rows: Callable[[Array], tuple[Array, Array]],
    opened: Callable[[Array], Array], gap: Array, motion: Motion, guess: Array, span: float,
) -> tuple[Array, Array, Array, Array, Array]:  # fmt: skip
    """Displacements (b, 3), forces (c, 2); of each contact (c,) opening and slip by its rows, true opening of its gap.

    The program opens a contact that slides by μ times its slip, and knows the opening by the rows of A₀ᵀ only. Gaps
    shifted by the first, and by what the gap has `opened` (c,) beyond the second, are left as they should be: closed
    where they carry. The shift is found by repetition, each correction extrapolated from the last two (Irons and Tuck,
    Int. J. Numer. Methods Eng. 1 (1969) 275). `rows` normal and tangential, (c, 6), follow the displacements.
    """
    a, b, friction = scene.contacts.a, scene.contacts.b, scene.contacts.friction
    (normal, tangent), near, share, last = rows(guess), guess[scene.movable].ravel(), 1.0, np.zeros_like(gap)
    shift = opened(guess) - scene.relative(normal, guess)
    bend, both = shift.copy(), np.zeros((len(gap), 2))
    opening, slip, off = np.empty_like(gap), np.empty_like(gap), np.empty_like(gap)
    matters = np.empty(len(gap), bool)
    for trial in range(MOST_TRIALS):
        both[:, 0] = gap + shift
        solution = scene.solve(
            mass, load[scene.movable].ravel(), (normal, tangent), both, scene.compliance, motion, near, span
        )  # fmt: skip
        moved = scene.spread(solution.displacement)
        change = opened(moved)
        lacking, bends = loops.dilation(
            a, b, normal, tangent, moved, solution.forces, friction, gap, change, shift, bend, CARRYING * scene.weight,
            opening, slip, off, matters,
        )  # fmt: skip
        if lacking <= SETTLED * span and bends <= STRAIGHT * span:
            break
        turn = (off - last)[matters]
        if trial and turn.any():
            share = float(np.clip(-share * (last[matters] @ turn) / (turn @ turn), LEAST, MOST))
        shift, last = shift + share * off, off.copy()
        normal, tangent = rows(moved)
    return moved, solution.forces, opening, slip, change
