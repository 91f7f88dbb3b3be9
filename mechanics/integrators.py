"""One time step of blocks in contact: the program with a scaled mass, load and gaps (design.md §4).

Both schemes are one, with a share θ of the step at which balance and contact forces are taken: implicit Euler, the
paper's (θ = 1, at its end), and the midpoint rule (θ = ½, in its middle). With rigid contacts the midpoint rule needs
its impacts located: see impacts.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechanics.block import Array
from mechanics.scene import Load, Motion, Scene


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
    compliance = scene.compliance / stretch
    gap = np.where(start > 0.0, start, start / stretch)
    gap[:, 1] = -compliance[:, 1] * motion.shear
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
    change = np.stack([scene.relative(normal, dx), scene.relative(tangent, dx)], axis=1)
    slip = compliance[:, 1] * forces[:, 1] + gap[:, 1] + change[:, 1]
    shear, viscous, stepping = _springs(scene, motion, forces, start[:, 0], change, slip, stretch, step)
    return replace(
        motion,
        x=motion.x + dx,
        v=v,
        forces=forces,
        shear=shear,
        friction=motion.friction - float(forces[:, 1] @ slip),
        viscous=motion.viscous + viscous,
        integrator=motion.integrator
        + stepping
        + (share - 0.5) * float((scene.model.mass * (v - motion.v) ** 2).sum()),
        input=motion.input + scene.work_of_loads(load, dx),
    )


def _springs(
    scene: Scene, motion: Motion, forces: Array, gap: Array, change: Array, slip: Array, stretch: float, step: float
) -> tuple[Array, float, float]:  # fmt: skip
    """Shear (c,) kN of the springs at the end; what dashpots took in the step, and what the time stepping did (kNm).

    From `gap` (c,) at the start, the `change` (c, 2) of gaps and slides and the `slip` (c,) of the step: work of the
    contact forces, less that of friction and dashpots, less what the springs store. Where sliding dilates, that work
    comes back when the gap closes.
    """
    n, t = forces.T
    work = -float(n @ change[:, 0]) - float(t @ (change[:, 1] - slip))
    if scene.behaviour == "rigid":
        return motion.shear, 0.0, work
    k, flexible = scene.contacts.stiffness[:, 0], scene.compliance[:, 1]
    dashpot = scene.damping / step / stretch
    before, after = k * np.maximum(-gap, 0.0), k * np.maximum(-gap - change[:, 0], 0.0)
    limit = scene.contacts.friction * np.where(n > 0.0, np.maximum(n, after), 0.0)
    shear = np.clip(motion.shear + (t - motion.shear) / stretch, -limit, limit)
    grown = np.where(n > 0.0, n - before, 0.0), t - motion.shear
    viscous = dashpot / stretch * float((grown[0] ** 2 / k).sum() + flexible @ grown[1] ** 2)
    stored = 0.5 * float(((after**2 - before**2) / k).sum() + flexible @ (shear**2 - motion.shear**2))
    return shear, viscous, work - viscous - stored
