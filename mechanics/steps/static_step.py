"""One static step: its program in a given geometry, and the equilibrium that follows from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np

from mechanics.errors import ConvergenceError, NoEquilibriumError
from mechanics.kernels.joint import (
    CURVED,
    PHI,
    SHIFTS,
    H,
    U,
    V,
    bearing,
    curvatures,
    friction_between,
    lay_shear,
)
from mechanics.kernels.law import BED, DILATION, FRICTION, SEGMENTS, SHEAR, SLID, STEEP, STRENGTH
from mechanics.messages import message
from mechanics.model.assembly import Assembly, State
from mechanics.model.contacts import Contacts, end_gaps
from mechanics.program import BOUNDED, Certificate, Program, Solution, bed_gaps, end_forces
from mechanics.solvers import GOOD, interior
from mechanics.solvers.elimination import Elimination
from mechanics.solvers.interior import Iterate
from mechanics.steps.static_system import (
    StaticSystem,
    over_all,
    spread,
    spring_forces,
    state_at_rest,
)
from mechanics.steps.tolerances import STEP
from mechanics.types import Array, Index, Mask


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A point of a path: forces and a geometry in agreement.

    `places` (j, PLACE) of the system's contacts in the state; `forces` (j, 3): N, P and T, kN and kNm; `alpha`: the
    multiplier of the lateral load; `iterate`: start of the next program; `certificate` of the forces in this geometry;
    `solves`: number of programs solved; `lifting`: whether they had a dilation that the law does not have; `stable`:
    whether the stiffness of elastic joints is positive there (interior.stable); rigid joints, whose geometry is
    followed exactly, are not checked.
    """

    state: State
    system: StaticSystem
    places: Array
    forces: Array
    alpha: float
    iterate: Iterate | None
    certificate: Certificate
    solves: int
    lifting: bool = False
    stable: bool = True

    @property
    def contacts(self) -> Contacts:
        """The contacts, the drawn joints first."""
        return self.system.contacts

    @property
    def penetration(self) -> float:
        """The deepest penetration (m) beyond the elastic compression."""
        overlapping = (self.places[:, H] > self.system.no_overlap) & ~self.contacts.ties
        places, forces = self.places[overlapping], self.forces[overlapping]
        gaps = end_gaps(places)
        if not self.system.rigid:
            half = places[:, H]
            gaps = gaps - bed_gaps(end_forces(forces, half), half, self.system.law[overlapping])
        return float(max(0.0, -gaps.min(initial=0.0)))


@dataclass(frozen=True, eq=False)
class StepProblem:
    """A step: the equilibrium at about `size` (m) from `start` under `load` (b, 3), kN and kNm.

    With a `lateral` load the multiplier α is free, and the lateral load does the given `work` (kNm). `mass` (b, 3),
    Mg/s²: of a step from rest, the mass over the square of its time; None in statics. `lifts`: whether what slides
    lifts as by the associative law, whatever the law.
    """

    system: StaticSystem
    start: State
    load: Array
    size: float
    lateral: Array | None = None
    work: float = 0.0
    mass: Array | None = None
    lifts: bool = False

    @cached_property
    def slid(self) -> Array:
        """Slips (j,) m from which sliding is measured: those at the start, less the deformation of the springs."""
        system = self.system
        slid: Array = system.places(self.start.positions, self.start)[:, V]
        if self.start.shear is not None and not system.rigid:
            slid = slid + system.law[:, SHEAR] * spring_forces(system.contacts, self.start)
        return slid

    def pose(self, at: Array, forces: Array | None, touching: Index | None = None) -> tuple[Program, Index]:
        """Return the program in the geometry of the positions `at` (b, 3), and the indices of its joints.

        The displacements are measured from `at`. `forces` (j, 3): estimate of the joint forces, whose change with the
        geometry the program contains, None if there is none. `touching`: indices of the program's joints, None:
        all joints that overlap, and ties that twice the expected displacement may pull taut.
        """
        system, movable = self.system, self.system.model.movable
        places = self._places(at, forces)
        law = system.law.copy()
        law[:, SLID] = self.slid
        overlapping = np.empty(len(places), dtype=bool)
        bearing(places, law, system.no_overlap, overlapping)
        friction_between(places, law)
        slack = system.contacts.ties & (places[:, U] > 2.0 * self.size)
        index = np.flatnonzero(overlapping & ~slack) if touching is None else touching
        places[~overlapping, H] = system.no_overlap
        law = law[index]
        if self.lifts:
            law[:, DILATION] = 1.0
        moved = (at - self.start.positions)[movable].ravel()
        load = self.load[movable].ravel()
        mass = None if self.mass is None else self.mass[movable].ravel()
        lateral = None if self.lateral is None else self.lateral[movable].ravel()
        program = Program(
            dof=system.dof[index],
            places=places[index],
            law=law,
            load=load if mass is None else load - mass * moved,
            lateral=lateral,
            work=self.work - (0.0 if lateral is None else float(lateral @ moved)),
            mass=mass,
            weight=system.weight,
            size=system.model.size,
            step=self.size,
            curved=None if forces is None else _curvatures(places[index], forces[index], law),
        )
        return program, index

    def _places(self, at: Array, forces: Array | None) -> Array:
        """Return the joints' places (j, PLACE) at positions (b, 3); T acts where N acts."""
        contacts = self.system.contacts
        places = self.system.places(at, self.start)
        if forces is not None:
            turned = (at - self.start.positions)[:, 2]
            lay_shear(places, forces, turned[contacts.a] - turned[contacts.b])
        return places


def _curvatures(places: Array, forces: Array, law: Array) -> Array:
    """Return how the forces (j, 3) of joints change with the geometry, (j, CURVED): see kernels.joint.curvature."""
    curved = np.empty((len(places), CURVED))
    curvatures(places, forces, curved)
    # the associative program is the minimum of an energy: what is not symmetric has none
    curved[law[:, DILATION] >= 1.0, SHIFTS:] = 0.0
    return curved


def equilibrium(
    problem: StepProblem,
    at: Array,
    index: Index,
    found: Solution,
    iterate: Iterate | None,
    solves: int,
    stable: bool = True,
) -> Equilibrium:
    """Return the equilibrium at positions `at` (b, 3) that a program of the joints `index` (k,) has found there."""
    system, count = problem.system, len(problem.system.contacts)
    forces = spread(found.forces, index, count)
    return Equilibrium(
        state_at_rest(system, at, forces, problem.start), system, system.places(at, problem.start), forces, found.alpha,
        iterate and over_all(iterate, index, count), found.certificate, solves, problem.lifts, stable,
    )  # fmt: skip


def proximal(program: Program, forces: Array) -> Program:
    """Return the program whose joints yield a little to changes of T, rigid ones also to changes of N₁ and N₂.

    `forces` (j, 3): N₁, N₂ and T, kN, of the last solution. Forces that Coulomb's law leaves open then
    stay near those that were there, and what they yield vanishes as the solutions settle (a proximal point method).
    """
    p, law, places = program, program.law.copy(), program.places.copy()
    soft = STEP.yielding * p.step / p.weight
    yields = np.isinf(law[:, BED]) & np.isinf(law[:, STRENGTH])
    half = places[:, H]
    law[yields, BED], law[yields, SEGMENTS] = 1.0 / (soft * half[yields]), 1.0
    back = np.where(yields[:, None], soft * forces[:, :2], 0.0)
    places[:, U] -= 0.5 * back.sum(axis=1)
    places[:, PHI] -= 0.5 * (back[:, 1] - back[:, 0]) / half
    law[:, SHEAR] += soft
    law[:, SLID] += soft * forces[:, 2]
    return replace(p, law=law, places=places)


def sticking(program: Program, stuck: Mask) -> Program:
    """Return the program in which the joints `stuck` (j,) have a little more friction than those that slide.

    Where several mechanisms have the same multiplier, courses that may all slide, the one that has begun goes on. The
    flow has ended where a joint makes use of it: see `slips`.
    """
    law = program.law.copy()
    law[stuck, FRICTION] *= 1.0 + STEP.sticks
    return replace(program, law=law)


def slips(program: Program, stuck: Mask, found: Iterate) -> bool:
    """Whether one of the joints `stuck` (j,) would slide under its own friction, that of the program."""
    normal, shear = found.forces[:, :2].sum(axis=1), abs(found.forces[:, 2])
    bound = (1.0 + 0.5 * STEP.sticks) * np.minimum(program.law[:, FRICTION], STEEP) * normal
    return bool((stuck & (normal > STEP.carrying * program.weight) & (shear > bound)).any())


def solve_program(
    program: Program,
    layout: Elimination,
    near: Iterate | None,
    accepted: float,
    held_first: bool,
    moved: Callable[[Iterate], Array],
) -> tuple[Iterate, Array, int, bool]:
    """Return the iterate that solves a program to a residual, where it leads, the solves, and whether that is reached.

    The search begins `near` an iterate, with the geometry that changes, or with the geometry held and then with that
    (`held_first`). Then it begins from a cold start with the geometry held: what the forces change with the geometry
    makes the program non-convex, and far from its solution it does not converge. `moved`: positions (b, 3) to which a
    solution leads; one for which it raises a NoEquilibriumError does not count. Raises that error if there is no other,
    NoEquilibriumError if the structure is unstable or no load moves it, ConvergenceError if it is not solved.
    """
    unstable, refused = False, None
    held = interior.frozen(program)
    skew = bool((program.law[:, DILATION] < 1.0).any())
    solved = STEP.slow if skew else GOOD
    kinds = [held, program] if held_first and program.curved is not None else [program]
    first = [(kind, near) for kind in kinds] if near else []
    attempts = chain(first, ((held, start) for start in interior.cold_starts(held, layout)))
    for solves, (tried, start) in enumerate(attempts, 1):
        found, outcome = interior.run(tried, layout, start, accepted)
        if abs(found.alpha) > BOUNDED:
            raise NoEquilibriumError(
                message("no mechanism: the load only wedges the blocks, the multiplier has no bound")
            )
        if outcome.accepted or max(outcome.force, outcome.product) <= solved:
            try:
                return found, moved(found), solves, outcome.accepted
            except NoEquilibriumError as error:
                refused = error
                continue
        unstable = unstable or outcome.unstable
    if refused:
        raise refused
    if unstable:
        raise NoEquilibriumError(
            message("loss of stability: the stiffness of the structure is no longer positive")
        )
    raise ConvergenceError(message("a step of the path was not solved to the required accuracy"))


def displaced(model: Assembly, positions: Array, displacement: Array) -> Array:
    """Return the positions (b, 3) after displacements (m,) of the movable blocks."""
    moved = positions.copy()
    moved[model.movable] += displacement.reshape(-1, 3)
    return moved


def check_motion(problem: StepProblem, positions: Array) -> None:
    """Raise NoEquilibriumError if positions (b, 3) are farther from the start than a step of a path may lead.

    The compressions of elastic joints in a row add up: blocks may then move by as many times the step.
    """
    model, size = problem.system.model, problem.size
    moved = model.farthest(problem.start.positions, positions)
    times = STEP.fall if problem.system.rigid else max(STEP.fall, model.joints_in_a_row)
    if moved > times * size:
        falls = message(
            "the structure falls: a step of {size:.3g} m moves it by {moved:.3g} m", size=size, moved=moved
        )
        raise NoEquilibriumError(falls)
