"""The midpoint rule with rigid contacts: impacts located in the step and resolved as inelastic (design.md §4)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechanics.assembly import Mask
from mechanics.block import GRAVITY, Array
from mechanics.errors import ConvergenceError
from mechanics.integrators import implicit_euler
from mechanics.scene import Load, Motion, Scene

CLOSED = 1e-6  # of the block size: a gap that is none
RESTING = 1e-6  # of √(g·size): an approach that is none
CARRYING = 1e-5  # of a block's weight: a contact force that is one
FAINT = 0.01  # of the energy scale: what impacts in a step may take without being located
MOST_EVENTS = 6  # impacts located in one step; where more come, contacts chatter
FAR = 1e3  # displacements of a step: a gap that cannot close in it
SETTLED = 1e-4  # of a displacement: dilation that is no longer corrected
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
            motion = _impact(scene, motion)
            whole = _midpoint(scene, motion, _gaps(scene, motion), load, time + done, step - done)
            if whole.impact - motion.impact <= FAINT * _energy_scale(scene, motion, step):
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
    """Gaps (c,) m, zero where closed."""
    gap = scene.geometry(motion.x)[0][:, 0]
    return np.where(gap > CLOSED * scene.model.size, gap, 0.0)


def _until_impact(scene: Scene, motion: Motion, load: Load, time: float, step: float) -> tuple[Motion, float]:
    """The motion after the step, or after the part of it at whose end the first open contact closes (Illinois)."""
    tolerance = CLOSED * scene.model.size
    start = _gaps(scene, motion)
    is_open = start > 0.0
    apart = np.where(is_open, FAR * scene.span(motion.v, step), 0.0)
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
    _, normal, tangent = scene.geometry(motion.x + 0.5 * step * motion.v)
    mass = 2.0 * scene.mass / step**2
    inertia, span = step * motion.v[scene.movable].ravel(), scene.span(motion.v, step)
    force = load(time + 0.5 * step)
    moved, forces, slip, dilation = _without_dilation(
        scene, mass, force[scene.movable].ravel() + mass * inertia, (normal, tangent), gap, motion, inertia, span
    )  # fmt: skip
    dx = scene.spread(moved)
    x, v, taken = motion.x + dx, 2.0 * dx / step - motion.v, 0.0
    carrying = forces[:, 0] > CARRYING * scene.weight
    if carrying.any():
        x = _kept_closed(scene, x, carrying)
        v, taken = _kept_together(scene, x, v, carrying, slip, STUCK * span)
    # contacts do the work −n(g + dilation); what is not friction's is of those that close, or of the dilation left over
    friction = -float(forces[:, 1] @ slip)
    taken += float(forces[carrying, 0] @ (gap + dilation)[carrying]) - friction
    closes = bool((carrying & (gap > 0.0)).any())
    return replace(
        motion,
        x=x,
        v=v,
        forces=forces,
        friction=motion.friction + friction,
        impact=motion.impact + closes * taken,
        integrator=motion.integrator + (not closes) * taken,
        input=motion.input + scene.work_of_loads(force, dx),
    )


def _kept_closed(scene: Scene, x: Array, carrying: Mask) -> Array:
    """Positions with the contacts that carry closed: constraints on mean velocities drift."""
    gap, normal, tangent = scene.geometry(x)
    if abs(gap[carrying, 0]).max() <= 1e-3 * CLOSED * scene.model.size:
        return x
    gap[:, 1] = 0.0
    return x + scene.spread(scene.newton.close(scene.mass, normal, tangent, gap, carrying.astype(np.intp)))


def _kept_together(
    scene: Scene, x: Array, v: Array, carrying: Mask, slip: Array, least: float
) -> tuple[Array, float]:
    """Velocities with the contacts that carry together, and those that came to rest in the step at rest; energy taken.

    A contact stuck in the mean, or whose slip (c,) turned in the step, would go back as fast as it came.
    """
    _, normal, tangent = scene.geometry(x)
    rate = np.stack([scene.relative(normal, v), scene.relative(tangent, v)], axis=1)
    # without friction nothing stops
    stopped = (scene.contacts.friction > 0.0) & ((abs(slip) <= least) | (slip * rate[:, 1] < 0.0))
    held = carrying.astype(np.intp) + (carrying & stopped)
    off = np.where(held > [[0], [1]], abs(rate).T, 0.0).max()
    if off <= RESTING * np.sqrt(GRAVITY * scene.model.size):
        return v, 0.0
    change = scene.spread(scene.newton.close(scene.mass, normal, tangent, rate, held))
    # a projection in the norm of the mass
    return v + change, 0.5 * float((scene.model.mass * change**2).sum())


def _impact(scene: Scene, motion: Motion) -> Motion:
    """Velocities after the impulses of the closed contacts that approach: M(v₁ − v₀) = A₀p, v₁ₙ ≥ −e·v₀ₙ."""
    gap, normal, tangent = scene.geometry(motion.x)
    closed = gap[:, 0] <= CLOSED * scene.model.size
    approach = scene.relative(normal, motion.v)
    unit = np.sqrt(GRAVITY * scene.model.size)
    if approach[closed].min(initial=0.0) >= -RESTING * unit:
        return motion
    scene.impacts += 1
    v = motion.v[scene.movable].ravel()
    span = max(float(abs(motion.v[:, :2]).max()), RESTING * unit)
    bounce = scene.restitution * np.minimum(approach, 0.0)
    moved, impulses, _, _ = _without_dilation(
        scene, scene.mass / scene.impulse, scene.mass / scene.impulse * v, (normal, tangent),
        np.where(closed, bounce, FAR * span), motion, v, span,
    )  # fmt: skip
    after = scene.spread(moved)
    # impulses do work at the mean velocity of the impact
    mean = 0.5 * (motion.v + after)
    rates = np.stack([scene.relative(normal, mean), scene.relative(tangent, mean)], axis=1)
    loss = -scene.impulse * float((impulses * rates).sum())
    return replace(motion, v=after, impact=motion.impact + loss)


def _without_dilation(
    scene: Scene, mass: Array, load: Array, rows: tuple[Array, Array], gap: Array, motion: Motion, guess: Array,
    span: float,
) -> tuple[Array, Array, Array, Array]:  # fmt: skip
    """Displacements (m,), forces (c, 2), slips and dilations (c,) of the program with friction that does not dilate.

    The program's sliding opens the contact by μ times the slip: a gap of as much, found by repetition, undoes it. A
    contact that has ceased to carry keeps of it what cannot let blocks into each other: dropped, it would carry again.
    What is left of it after the last trial is a gap in the next step.
    """
    found = np.zeros_like(gap)
    for _ in range(MOST_TRIALS):
        dilation = found
        both = np.stack([gap + dilation, np.zeros_like(gap)], axis=1)
        solution = scene.solve(mass, load, rows, both, scene.compliance, motion, guess, span)
        slip = scene.relative(rows[1], scene.spread(solution.displacement))
        slid = scene.contacts.friction * abs(slip)
        found = np.where(solution.forces[:, 0] > CARRYING * scene.weight, slid, np.minimum(slid, dilation))
        if abs(found - dilation).max(initial=0.0) <= SETTLED * span:
            break
    return solution.displacement, solution.forces, slip, dilation
