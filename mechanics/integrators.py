"""One time step of blocks in contact: each scheme is the program with its own mass, load and gaps (design.md §4).

Everything moves in the frame of the ground: the supports rest there and base motion acts as inertia on the blocks.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from mechanics.assembly import Assembly, Behaviour, Mask
from mechanics.block import GRAVITY, Array
from mechanics.errors import ConvergenceError
from mechanics.program import Certificate, Program, Solution
from mechanics.solvers import solve
from mechanics.solvers.newton import ACCEPTED, Newton

CLOSED = 1e-6  # of the block size: a gap that is none
RESTING = 1e-6  # of √(g·size): an approach that is none
CARRYING = 1e-5  # of a block's weight: a contact force that is one
MOST_EVENTS = 6  # impacts located in one step; where more come, contacts chatter
FAR = 1e3  # displacements of a step: a gap that cannot close in it
SETTLED = 1e-5  # of a displacement: dilation that is no longer corrected
STUCK = 1e-4  # of a displacement: a slip that is none
MOST_TRIALS = 12  # of the time of one impact, or of the slip that dilates
STAGE = 1.0 - math.sqrt(0.5)  # of the step: the stages of the L-stable second-order scheme

Load = Callable[[float], Array]


@dataclass(frozen=True, eq=False)
class Motion:
    """Blocks at a time: `x` and `v` (b, 3), contact forces (c, 2) kN of the step that led here.

    `friction`, `impact`, `viscous` and `input` (kNm) are what has been dissipated, and put in by the loads other than
    the dead ones, since the beginning.
    """

    x: Array
    v: Array
    forces: Array
    friction: float = 0.0
    impact: float = 0.0
    viscous: float = 0.0
    input: float = 0.0


@dataclass(eq=False)
class Scene:
    """What does not change in a motion, laid out once; and the count of what was done.

    `damping` (s): viscous contact force per elastic one and rate of gap; `restitution`: of normal velocity at impacts.
    `fallbacks`: steps left to the implicit scheme; `resolved`: programs that the Newton solver left to PIQP.
    """

    model: Assembly
    behaviour: Behaviour
    damping: float = 0.0
    restitution: float = 0.0
    fallbacks: int = 0
    impacts: int = 0
    resolved: int = 0
    solves: int = 0
    certificate: Certificate = field(default_factory=lambda: Certificate(0.0, 0.0, 0.0, 0.0, 0.0))
    worst: float = 0.0

    def __post_init__(self) -> None:
        model, contacts = self.model, self.model.contacts(self.behaviour)
        self.contacts = contacts
        self.dof = np.concatenate([model.dof[contacts.a], model.dof[contacts.b]], axis=1)
        self.movable = np.flatnonzero(model.movable)
        self.newton = Newton(self.dof, model.initial.positions[self.movable, :2])
        self.mass = model.mass[self.movable].ravel()
        self.compliance = np.zeros((len(contacts), 2))
        if self.behaviour == "elastic":
            self.compliance = 1.0 / contacts.stiffness
        self.block_size = np.sqrt([b.area for b in model.blocks])
        self.weight = model.weight / len(self.movable)
        self.impulse = np.sqrt(
            model.size / GRAVITY
        )  # s: velocities stand for displacements, impulses for forces

    def geometry(self, x: Array) -> tuple[Array, Array, Array]:
        """Gap and slide (c, 2), and the rows (c, 6) of A₀ᵀ, normal and tangential."""
        c, k = len(self.contacts), self.contacts
        gap, normal, tangent = np.empty((c, 2)), np.empty((c, 6)), np.empty((c, 6))
        self.newton.kernels.geometry(k.a, k.b, k.p, k.q, k.n, x, gap, normal, tangent)
        return gap, normal, tangent

    def relative(self, rows: Array, moved: Array) -> Array:
        """Change (c,) of gaps or slides that displacements or velocities (b, 3) cause."""
        change = np.empty(len(rows))
        self.newton.kernels.relative(self.contacts.a, self.contacts.b, rows, moved, change)
        return change

    def solve(
        self, mass: Array, load: Array, rows: tuple[Array, Array], gap: Array, compliance: Array, motion: Motion,
        guess: Array, step: float,
    ) -> Solution:  # fmt: skip
        """The certified solution of the program with mass (m,) and load (m,); PIQP's where the Newton solver fails."""
        program = Program(
            self.dof, *rows, gap, self.contacts.friction, compliance, load, None, 0.0, mass,
            self.weight, self.model.size, step,
        )  # fmt: skip
        self.solves += 1
        solution = self.newton.solve(program, guess, motion.forces)
        if solution is None or solution.certificate.worst(step) > ACCEPTED:
            self.resolved += 1
            try:
                solution = solve(program)
            except ConvergenceError:
                if solution is None or solution.certificate.worst(step) > 1e-5:
                    raise
        self.worst = max(self.worst, solution.certificate.worst(step))
        self.certificate = self.certificate.joined(solution.certificate)
        return solution

    def spread(self, values: Array) -> Array:
        """Values (m,) of the degrees of freedom as (b, 3), zero for supports."""
        out = np.zeros((len(self.model.blocks), 3))
        out[self.movable] = values.reshape(-1, 3)
        return out


def implicit_euler(scene: Scene, motion: Motion, load: Load, time: float, step: float) -> Motion:
    """The paper's step (eqs 2 and 3): v = Δx/Δt, a = (v − v₀)/Δt; geometry of its start, forces of its end."""
    return _euler(scene, motion, motion.x, load(time + step), step)


def _euler(scene: Scene, motion: Motion, at: Array, load: Array, step: float) -> Motion:
    """Implicit Euler with the geometry of the positions `at` (b, 3), the gaps carried back to the start."""
    gap, normal, tangent = scene.geometry(at)
    if at is not motion.x:
        gap[:, 0] += scene.relative(normal, motion.x - at)
    gap[:, 1] = -scene.compliance[:, 1] * motion.forces[:, 1]
    compliance, stretch = scene.compliance, 1.0
    if scene.damping:
        # n = −k(u + β u̇) with u = g₀ + A₀ᵀΔx at the end and u̇ = A₀ᵀΔx/Δt
        stretch = 1.0 + scene.damping / step
        compliance = compliance / (stretch, 1.0)
    program_gap = gap / (stretch, 1.0) if scene.damping else gap
    mass = scene.mass / step**2
    v = motion.v[scene.movable].ravel()
    span = _span(motion.v, step)
    if scene.behaviour == "rigid":
        # blocks that penetrate each other are pushed apart in one step
        span = max(span, -float(gap[:, 0].min(initial=0.0)))
    solution = scene.solve(
        mass, load[scene.movable].ravel() + mass * v * step, (normal, tangent), program_gap, compliance, motion,
        step * v, span,
    )  # fmt: skip
    dx = scene.spread(solution.displacement)
    force = solution.forces
    opening, slip = scene.relative(normal, dx), scene.relative(tangent, dx)
    slip += scene.compliance[:, 1] * force[:, 1] + gap[:, 1]
    viscous = 0.0
    if scene.damping:
        elastic = -np.minimum(gap[:, 0] + opening, 0.0) / scene.compliance[:, 0]
        viscous = -float((force[:, 0] - elastic) @ opening)
    return Motion(
        motion.x + dx,
        dx / step,
        force,
        motion.friction - float(force[:, 1] @ slip),
        motion.impact,
        motion.viscous + viscous,
        motion.input + float(((load - scene.model.dead_load) * dx).sum()),
    )


def second_order_elastic(scene: Scene, motion: Motion, load: Load, time: float, step: float) -> Motion:
    """Two stages of implicit Euler, L-stable and of second order (SDIRK2), with the geometry of each stage's end.

    Elastic contacts have no impacts to locate, and stiff ones vibrate faster than any step: what cannot be resolved
    is damped as by implicit Euler, what can is integrated to second order.
    """
    h, rest = STAGE * step, (1.0 - STAGE) * step
    first = _euler(scene, motion, motion.x + h * motion.v, load(time + h), h)
    shear = motion.forces + rest / h * (first.forces - motion.forces)
    middle = Motion(motion.x + rest * first.v, motion.v + rest / h * (first.v - motion.v), shear)
    last = _euler(scene, middle, motion.x + step * first.v, load(time + step), h)

    def weighted(start: float, after: float, more: float) -> float:
        return start + rest / h * (after - start) + more

    return replace(
        last,
        friction=weighted(motion.friction, first.friction, last.friction),
        impact=motion.impact,
        viscous=weighted(motion.viscous, first.viscous, last.viscous),
        input=weighted(motion.input, first.input, last.input),
    )


def second_order_rigid(scene: Scene, motion: Motion, load: Load, time: float, step: float) -> Motion:
    """The midpoint rule at velocity level on closed contacts, impacts located in the step and resolved there.

    It keeps the energy between events. Where more than a few impacts fall into one step, the rest of it is left to
    implicit Euler, and counted.
    """
    done = 0.0
    try:
        for _ in range(MOST_EVENTS):
            motion = _impact(scene, motion)
            motion, h = _until_impact(scene, motion, load, time + done, step - done)
            done += h
            if step - done <= 1e-9 * step:
                return motion
    except ConvergenceError:
        # jammed by friction: no motion without dilation exists (Painlevé)
        pass
    scene.fallbacks += 1
    return implicit_euler(scene, motion, load, time + done, step - done)


def _until_impact(scene: Scene, motion: Motion, load: Load, time: float, step: float) -> tuple[Motion, float]:
    """The motion after the step, or after the part of it at whose end the first open contact closes (Illinois)."""
    tolerance = CLOSED * scene.model.size
    start = scene.geometry(motion.x)[0][:, 0]
    is_open = start > tolerance
    new = _midpoint(scene, motion, ~is_open, load, time, step)

    def closest(to: Motion) -> float:
        return float(scene.geometry(to.x)[0][is_open, 0].min(initial=np.inf))

    high, at_high = step, closest(new)
    if at_high >= -tolerance:
        return new, step
    low, at_low, side = 0.0, float(start[is_open].min()), 0
    for _ in range(MOST_TRIALS):
        h = high - at_high * (high - low) / (at_high - at_low)
        new = _midpoint(scene, motion, ~is_open, load, time, h)
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


def _midpoint(scene: Scene, motion: Motion, closed: Mask, load: Load, time: float, step: float) -> Motion:
    """The midpoint rule, v = (v₀ + v₁)/2 = Δx/Δt, with the geometry of the middle; only closed contacts act."""
    _, normal, tangent = scene.geometry(motion.x + 0.5 * step * motion.v)
    mass = 2.0 * scene.mass / step**2
    v = motion.v[scene.movable].ravel()
    force = load(time + 0.5 * step)
    moved, forces, slip = _without_dilation(
        scene, mass, force[scene.movable].ravel() + mass * v * step, (normal, tangent),
        np.where(closed, 0.0, FAR * _span(motion.v, step)), motion, step * v, _span(motion.v, step),
    )  # fmt: skip
    dx = scene.spread(moved)
    x, v1 = motion.x + dx, 2.0 * dx / step - motion.v
    carrying = closed & (forces[:, 0] > CARRYING * scene.weight)
    if carrying.any():
        x, v1 = _kept_together(scene, x, v1, carrying, slip, STUCK * _span(motion.v, step))
    return replace(
        motion,
        x=x,
        v=v1,
        forces=forces,
        friction=motion.friction - float(forces[:, 1] @ slip),
        input=motion.input + float(((force - scene.model.dead_load) * dx).sum()),
    )


def _kept_together(
    scene: Scene, x: Array, v: Array, carrying: Mask, slip: Array, least: float
) -> tuple[Array, Array]:
    """Positions and velocities with the contacts that carry closed, and those that came to rest in the step at rest.

    Constraints on mean velocities drift in position; and a contact stuck in the mean, or whose slip (c,) turned in the
    step, would go back as fast as it came.
    """
    gap, normal, tangent = scene.geometry(x)
    if abs(gap[carrying, 0]).max() > 1e-3 * CLOSED * scene.model.size:
        gap[:, 1] = 0.0
        x = x + scene.spread(scene.newton.close(scene.mass, normal, tangent, gap, carrying.astype(np.intp)))
    rate = np.stack([scene.relative(normal, v), scene.relative(tangent, v)], axis=1)
    stopped = (abs(slip) <= least) | (slip * rate[:, 1] < 0.0)
    held = carrying.astype(np.intp) + (carrying & stopped)
    off = np.where(held > [[0], [1]], abs(rate).T, 0.0).max()
    if off > RESTING * np.sqrt(GRAVITY * scene.model.size):
        v = v + scene.spread(scene.newton.close(scene.mass, normal, tangent, rate, held))
    return x, v


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
    moved, _, _ = _without_dilation(
        scene, scene.mass / scene.impulse, scene.mass / scene.impulse * v, (normal, tangent),
        np.where(closed, bounce, FAR * span), motion, v, span,
    )  # fmt: skip
    after = scene.spread(moved)
    loss = 0.5 * float((scene.model.mass * (motion.v**2 - after**2)).sum())
    return replace(motion, v=after, impact=motion.impact + loss)


def _without_dilation(
    scene: Scene, mass: Array, load: Array, rows: tuple[Array, Array], gap: Array, motion: Motion, guess: Array,
    span: float,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Displacements (m,), forces (c, 2) and slips (c,) of the program with friction that does not dilate.

    The program's sliding opens the contact by μ times the slip: a gap of as much, found by repetition, undoes it.
    """
    dilation = np.zeros_like(gap)
    for _ in range(MOST_TRIALS):
        both = np.stack([gap + dilation, np.zeros_like(gap)], axis=1)
        solution = scene.solve(mass, load, rows, both, scene.compliance, motion, guess, span)
        slip = scene.relative(rows[1], scene.spread(solution.displacement))
        slid = np.where(
            solution.forces[:, 0] > CARRYING * scene.weight, scene.contacts.friction * abs(slip), 0.0
        )
        if abs(slid - dilation).max(initial=0.0) <= SETTLED * span:
            return solution.displacement, solution.forces, slip
        dilation = slid
    raise ConvergenceError("no motion without dilation found")


def _span(v: Array, step: float) -> float:
    """The size (m) of a displacement in a step."""
    return max(GRAVITY * step**2, float(abs(v[:, :2]).max()) * step)
