"""What does not change while blocks move, and the motion itself: what every integrator works on (design.md §4).

Everything moves in the frame of the ground: the supports rest there and base motion acts as inertia on the blocks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from mechanics.assembly import Assembly, Behaviour
from mechanics.block import GRAVITY, Array
from mechanics.errors import ConvergenceError
from mechanics.program import Certificate, Program, Solution
from mechanics.solvers import compiled, solve
from mechanics.solvers.newton import ACCEPTED, Newton

POOREST = 1e-5  # certificate: a step worse than this has failed

Load = Callable[[float], Array]
"""Loads (b, 3), kN, at a time (s) after the beginning of a step."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Blocks at a time: positions `x` and velocities `v` (b, 3), and where the energy went.

    `forces` (c, 2) kN of the contacts in the step that led here; `shear` (c,) kN of their tangential springs.
    `elastic` (kNm) is what springs store; `friction`, `impact`, `viscous`, `integrator` and `input` (kNm) are what has
    been dissipated, and put in by the loads other than the dead ones, since the beginning. Each is computed from forces
    and displacements of its own kind, none as what is missing from the others.
    """

    x: Array
    v: Array
    forces: Array
    shear: Array
    elastic: float = 0.0
    friction: float = 0.0
    impact: float = 0.0
    viscous: float = 0.0
    integrator: float = 0.0
    input: float = 0.0


@dataclass(eq=False)
class Scene:
    """What does not change in a motion, laid out once; and the count of what was done.

    `speed` (m/s): √(g·size); `mobility` (b, 3): 1/mass, 0 for supports; `smallest` (m): size of the smallest block.
    `lifted` (c,) m: gaps that count as none, those of joints that carried as the motion began.
    `damping` (s): viscous contact force per elastic one and rate of gap; `restitution`: of normal velocity at impacts.
    `impacts`: located ones; `fallbacks`: rests of steps left to the implicit step without locating more of them;
    `solves`: programs, of them `resolved`: those that the Newton solver left to PIQP.
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
        self.lifted = np.zeros(len(contacts))
        self.compliance, self.stiffness = np.zeros((len(contacts), 2)), np.full(len(contacts), np.inf)
        if self.behaviour == "elastic":
            self.compliance, self.stiffness = 1.0 / contacts.stiffness, contacts.stiffness[:, 0].copy()
        self.block_size = np.sqrt([b.area for b in model.blocks])
        self.smallest = float(self.block_size.min())
        self.weight = model.weight / len(self.movable)
        self.speed = np.sqrt(GRAVITY * model.size)
        # s: velocities stand for displacements, impulses for forces
        self.impulse = np.sqrt(model.size / GRAVITY)
        self.mobility = np.where(model.movable[:, None], 1.0 / model.mass, 0.0)
        self._configuration: tuple[bytes, tuple[Array, Array, Array]] | None = None

    def geometry(self, x: Array) -> tuple[Array, Array, Array]:
        """Gap and slide (c, 2), and the rows (c, 6) of A₀ᵀ, normal and tangential; to be read only.

        The configuration looked at last is remembered: where a step ends the next one begins.
        """
        key = x.tobytes()
        if self._configuration is not None and self._configuration[0] == key:
            return self._configuration[1]
        c, k = len(self.contacts), self.contacts
        gap, normal, tangent = np.empty((c, 2)), np.empty((c, 6)), np.empty((c, 6))
        compiled.geometry(k.a, k.b, k.p, k.q, k.n, x, gap, normal, tangent)
        gap[:, 0] -= self.lifted
        self._configuration = key, (gap, normal, tangent)
        return gap, normal, tangent

    def strain_energy(self, x: Array, shear: Array) -> float:
        """Energy (kNm) of the springs in a configuration, with their `shear` (c,)."""
        if self.behaviour == "rigid":
            return 0.0
        gap, _, _ = self.geometry(x)
        energy: float = compiled.strain_energy(gap, self.stiffness, self.compliance, shear)
        return energy

    def relative(self, rows: Array, moved: Array) -> Array:
        """Change (c,) of gaps or slides that displacements or velocities (b, 3) cause."""
        change = np.empty(len(rows))
        compiled.relative(self.contacts.a, self.contacts.b, rows, moved, change)
        return change

    def span(self, v: Array, step: float) -> float:
        """The size (m) of a displacement in a step with velocities (b, 3)."""
        return max(GRAVITY * step**2, float(abs(v[:, :2]).max()) * step)

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
        worst = np.inf if solution is None else solution.certificate.worst(step)
        if worst > ACCEPTED:
            self.resolved += 1
            try:
                solution = solve(program)
                worst = solution.certificate.worst(step)
            except ConvergenceError:
                if worst > POOREST:
                    raise
        assert solution is not None
        self.worst = max(self.worst, worst)
        self.certificate = self.certificate.joined(solution.certificate)
        return solution

    def spread(self, values: Array) -> Array:
        """Values (m,) of the degrees of freedom as (b, 3), zero for supports."""
        out = np.zeros((len(self.model.blocks), 3))
        out[self.movable] = values.reshape(-1, 3)
        return out

    def work_of_loads(self, load: Array, dx: Array) -> float:
        """Work (kNm) of loads (b, 3), less the dead ones, in displacements (b, 3) that leave the supports at rest."""
        return float(np.vdot(load - self.model.dead_load, dx))
