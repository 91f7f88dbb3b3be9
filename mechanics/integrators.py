"""One time step of blocks in contact: the program with a scaled mass, load and gaps (design.md §4).

Both schemes are one, with a share θ of the step at which balance and contact forces are taken: implicit Euler, the
paper's (θ = 1, at its end), and the midpoint rule (θ = ½, in its middle). With rigid contacts the midpoint rule needs
its impacts located: see impacts.
"""

from __future__ import annotations

import numpy as np

from mechanics.block import Array
from mechanics.scene import Load, Motion, Scene
from mechanics.solvers.compiled import at_start, springs

RINGING = 0.3  # share of the last forces in the start of a midpoint step: it keeps what rings


def implicit_euler(scene: Scene, motion: Motion, load: Load, time: float, step: float) -> Motion:
    """The paper's step (eqs 2 and 3): v = Δx/Δt, a = (v − v₀)/Δt; geometry of its start, forces of its end."""
    return theta_step(scene, motion, load(time + step), step, 1.0)


def midpoint(scene: Scene, motion: Motion, load: Load, time: float, step: float) -> Motion:
    """The midpoint rule with elastic contacts: (v₀ + v)/2 = Δx/Δt; geometry, loads and forces of the middle.

    Second order, and without loss, while contacts stay closed or open. One that closes in the step is met with half
    the force of its end, one that opens lets go in the middle: both take energy, never give any, and less the better
    the step resolves the impact. So impacts shorter than a step are inelastic, and none needs locating.
    """
    return theta_step(scene, motion, load(time + 0.5 * step), step, 0.5)


def theta_step(scene: Scene, motion: Motion, load: Array, step: float, share: float) -> Motion:
    """The step with balance, loads (b, 3) and contact forces at a `share` θ of it.

    M(v − v₀)/Δt = f + A₀c and Δx/Δt = v₀ + θ(v − v₀), hence M̄ = M/(θΔt²). Of a gap that is u₀ at the start and changes
    by Δu, springs closed at the start have n = −k(u₀ + θΔu), those that close −kθ(u₀ + Δu); dashpots add −kβΔu/Δt from
    where they touch. In one: n = −k(θ + β/Δt)(Δu + g), g = u₀ where open and u₀/(θ + β/Δt) where closed.
    """
    start, normal, tangent = scene.geometry(motion.x)
    if share < 1.0:
        _, normal, tangent = scene.geometry(motion.x + (1.0 - share) * step * motion.v)
    stretch = 1.0 if scene.behaviour == "rigid" else share + scene.damping / step
    gap, compliance = np.empty_like(start), np.empty_like(start)
    at_start(start, motion.shear, scene.compliance, stretch, gap, compliance)
    mass = scene.mass / (share * step**2)
    inertia = step * motion.v[scene.movable].ravel()
    span = scene.span(motion.v, step)
    if scene.behaviour == "rigid":
        # blocks that penetrate each other are pushed apart in one step
        span = max(span, -float(gap[:, 0].min(initial=0.0)))
    solution = scene.solve(
        mass, load[scene.movable].ravel() + mass * inertia, (normal, tangent), gap, compliance, motion, inertia, span
    )  # fmt: skip
    dx, forces = scene.spread(solution.displacement), solution.forces
    v = motion.v + (dx / step - motion.v) / share
    shear = np.empty_like(motion.shear)
    rubbed, viscous, stepping = springs(
        scene.contacts.a, scene.contacts.b, normal, tangent, dx, forces, start[:, 0], gap[:, 1], compliance,
        scene.stiffness, scene.contacts.friction, motion.shear, shear, stretch, scene.damping / step / stretch,
    )  # fmt: skip
    x = motion.x + dx
    return Motion(
        x=x,
        v=v,
        forces=forces,
        shear=shear,
        elastic=scene.strain_energy(x, shear),
        friction=motion.friction + rubbed,
        impact=motion.impact,
        viscous=motion.viscous + viscous,
        integrator=motion.integrator
        + stepping
        + (0.0 if share == 0.5 else (share - 0.5) * float((scene.model.mass * (v - motion.v) ** 2).sum())),
        input=motion.input + scene.work_of_loads(load, dx),
    )
