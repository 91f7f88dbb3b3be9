"""One static step: the program in the geometry in which its forces act, solved until the two agree."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np

from mechanics.errors import ConvergenceError, NoEquilibriumError, UnsettledError
from mechanics.kernels.interior_iteration import BED, FRICTION, LAW, LIFT, SEGMENTS, SHEAR, SLID, STRENGTH
from mechanics.kernels.joint import ARM, BETA, MV, PHI, H, U, V, curvature
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.model.contacts import Contacts, end_gaps
from mechanics.model.proximity import near
from mechanics.program import (
    LARGEST_MULTIPLIER,
    Certificate,
    Program,
    Solution,
    bed_gaps,
    certify,
    end_forces,
)
from mechanics.solvers import interior, solve
from mechanics.solvers.elimination import Elimination
from mechanics.solvers.interior import Iterate
from mechanics.types import Array, Index, Mask

Sliding = Literal["coulomb", "associative"]

# what is missed, per weight and step, when the geometry is taken anew; rigid joints have no give in a wrong one
STAGES = {"rigid": (1e-5, 1e-8), "elastic": (1e-2, 1e-4, 1e-6, 1e-8)}
DISTANCE = 0.03  # per weight and step, from the bounds: where the first stage begins near an earlier solution
CLOSER = 0.1  # of what the last stage missed: the same of the next one
SETTLED = 1e-8  # certificate of the forces in the geometry to which they lead
MOST_ROUNDS = {"rigid": 8, "elastic": 12}  # more stages, of the last kind, until they agree
CARRYING = 1e-6  # of the weight: a force that is one
JUMP = 30.0  # a step this many times larger than asked is a fall, not a path of equilibrium
TURN = 0.5  # rad: a step that turns a block by more leaves the range in which its geometry is linear
NEARLY = 1e-4  # the same, where forces and geometry approach each other only slowly
SLIDES = 6  # the stages in which slips are taken anew
SHORT, FEWEST = 1e-2, 4  # of the block size: the length of a short step; of a step
LONG = 1.0  # s: the time of a short step, in which inertia hardly counts
LEVEL = 1e-3  # of a step: a gap left by slips that changed
VANISHED = 1e-9  # of the block size: an overlap that is none
SEEN = 0.05  # of the block size: how far beyond a step contacts are looked for
INSIDE = 1e-6  # of the block size: a penetration that is one


@dataclass(frozen=True, eq=False)
class StaticSystem:
    """What does not change along a path: an assembly, how its joints behave, and where blocks touch.

    `law` (j, LAW): see kernels.interior_iteration, but for the slip from which slides count. The contacts are those of
    configurations whose corners are within `reach` (m) of where they are at `seen` (b, 3); None: no others than drawn.
    """

    model: Assembly
    behaviour: Behaviour
    sliding: Sliding
    contacts: Contacts
    seen: Array | None = None
    reach: float = np.inf

    def __getstate__(self) -> dict[str, object]:
        """What is kept of it: matrices are laid out anew where it is used again."""
        return {name: value for name, value in self.__dict__.items() if name not in {"layout", "law", "dof"}}

    def around(self, positions: Array, way: float) -> StaticSystem:
        """The system with the contacts of configurations within a `way` (m) of positions (b, 3)."""
        model = self.model
        if not model.collisions:
            return self
        if self.seen is not None and model.farthest(self.seen, positions) + way <= self.reach:
            return self
        reach = 2.0 * way + SEEN * model.size
        contacts = near(model.outlines, model.contacts, self.contacts, positions, 2.0 * reach)
        found = replace(self, contacts=contacts, seen=positions.copy(), reach=reach)
        if np.array_equal(contacts.edges, self.contacts.edges):
            found.__dict__["layout"] = self.layout  # the same pairs of blocks
        return found

    def met_inside(self, before: StaticSystem, positions: Array) -> bool:
        """Whether faces that the system `before` did not know lie in each other at positions (b, 3)."""
        known = set(map(tuple, before.contacts.edges.tolist()))
        new = np.array([tuple(e) not in known for e in self.contacts.edges.tolist()], dtype=bool)
        places = self.contacts.take(np.flatnonzero(new)).places(positions)
        inside = end_gaps(places).min(axis=1) < -INSIDE * self.model.size
        return bool((inside & (places[:, H] > 0.0)).any())

    @property
    def rigid(self) -> bool:
        """Whether joints are rigid."""
        return self.behaviour == "rigid"

    @cached_property
    def law(self) -> Array:
        """What each joint obeys (j, LAW)."""
        c = self.contacts
        law = np.zeros((len(c), LAW))
        law[:, FRICTION] = law[:, LIFT] = np.maximum(c.friction, LEAST_FRICTION)
        law[:, STRENGTH], law[:, BED] = c.strength, np.inf
        if not self.rigid:
            law[:, BED], law[:, SEGMENTS] = c.bed, c.segments
            with np.errstate(divide="ignore"):
                law[:, SHEAR] = np.where(np.isinf(c.shear), 0.0, 1.0 / c.shear)
        return law

    @cached_property
    def dof(self) -> Index:
        """Degrees of freedom (j, 6) of blocks a and b of each joint."""
        dof = self.model.dof
        return np.concatenate([dof[self.contacts.a], dof[self.contacts.b]], axis=1)

    @cached_property
    def layout(self) -> Elimination:
        """In which order the matrices are eliminated; signed factors, of elastic joints, stand in a band."""
        centres = self.model.initial.positions[self.model.movable, :2]
        return Elimination.of(self.dof, centres, banded=not self.rigid)

    @property
    def weight(self) -> float:
        """The size of a force, kN: the mean weight of the movable blocks."""
        return self.model.weight / float(self.model.movable.sum())


LEAST_FRICTION = 1e-9  # a joint without friction has this


@lru_cache(maxsize=8)
def static_system(model: Assembly, behaviour: Behaviour, sliding: Sliding = "associative") -> StaticSystem:
    """The system of an assembly with its joints as drawn."""
    model.check_behaviour(behaviour)
    return StaticSystem(model, behaviour, sliding, model.contacts)


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Forces and a geometry that agree: a point of a path.

    `places` (j, PLACE) of the system's contacts in the state; `forces` (j, 3): N, P and T, kN and kNm; `alpha` of the
    lateral
    load; `iterate` near which the next one is sought; `certificate` of the forces in this geometry; `penetration` m:
    deepest true interpenetration that no bed explains; `solves`: programs solved to get there.
    """

    state: State
    system: StaticSystem
    places: Array
    forces: Array
    alpha: float
    iterate: Iterate | None
    certificate: Certificate
    penetration: float
    solves: int

    @property
    def contacts(self) -> Contacts:
        """Where blocks touch, the drawn joints first."""
        return self.system.contacts


@dataclass(frozen=True, eq=False)
class StepProblem:
    """The equilibrium sought about `size` (m) from `start`, under `load` (b, 3) or load + α·`lateral` doing `work`.

    `mass` (b, 3), Mg/s²: of a step from rest in a time whose square divides it; None in statics.
    """

    system: StaticSystem
    start: State
    load: Array
    size: float
    lateral: Array | None = None
    work: float = 0.0
    mass: Array | None = None

    @cached_property
    def slid(self) -> Array:
        """Slips (j,) from which slides count: those at the start, less what the springs of joints have taken."""
        system = self.system
        slid: Array = system.contacts.places(self.start.positions)[:, V]
        if self.start.shear is not None and not system.rigid:
            slid = slid + system.law[:, SHEAR] * spring_forces(system.contacts, self.start)
        return slid

    def pose(
        self, at: Array, forces: Array | None, slips: Array | None = None, touching: Index | None = None
    ) -> tuple[Program, Index]:
        """The program counted from the positions `at` (b, 3), in their geometry, over the joints that overlap there.

        `touching`: over these joints instead.

        `forces` (j, 3): about what the joints carry, None: nothing known; what they change with the geometry belongs to
        an elastic program. `slips` (j,) m: those whose lift is taken back, None: of none.
        """
        system, model, movable = self.system, self.system.model, self.system.model.movable
        places = system.contacts.places(at)
        if slips is not None:
            places[:, U] += system.law[:, FRICTION] * slips
        if forces is not None:
            turned = (at - self.start.positions)[:, 2]
            lay_shear(places, forces, turned[system.contacts.a] - turned[system.contacts.b])
        overlapping = places[:, H] > VANISHED * model.size
        index = np.flatnonzero(overlapping) if touching is None else touching
        places[~overlapping, H] = VANISHED * model.size
        law = system.law[index].copy()
        law[:, SLID] = self.slid[index]
        curved = None
        if not system.rigid and forces is not None:
            curved = np.empty((len(index), 7))
            for k, j in enumerate(index):
                curvature(places[j], *forces[j], curved[k])
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
            size=model.size,
            step=self.size,
            curved=curved,
        )
        return program, index


def spring_forces(contacts: Contacts, state: State) -> Array:
    """Tangential forces (j,) kN that the springs of contacts bring from a state."""
    forces = np.zeros(len(contacts))
    if state.shear is not None:
        forces[: len(state.shear)] = state.shear
    if state.met is not None:
        known = {(int(e), int(f)): t for e, f, t in state.met}
        for k in range(0 if state.shear is None else len(state.shear), len(contacts)):
            forces[k] = known.get((int(contacts.edges[k, 0]), int(contacts.edges[k, 1])), 0.0)
    return forces


def carried(contacts: Contacts, state: State) -> Mask:
    """Which contacts (j,) carry in the equilibrium that led to a state, as far as is known."""
    found = np.zeros(len(contacts), dtype=bool)
    if state.carrying is not None:
        found[: len(state.carrying)] = state.carrying
    if state.carrying is not None and state.met is not None:
        known = {(int(e), int(f)) for e, f, _ in state.met}
        found |= np.array([tuple(pair) in known for pair in contacts.edges.tolist()], dtype=bool)
    return found


def with_springs(contacts: Contacts, state: State, drawn: int, forces: Array) -> State:
    """A state with the tangential forces (j,) of its contacts' springs."""
    met = np.column_stack([contacts.edges[drawn:], forces[drawn:]])
    met = met[met[:, 2] != 0.0]
    return replace(state, shear=forces[:drawn].copy(), met=met if len(met) else None)


def lay_shear(places: Array, forces: Array, turned: Array) -> None:
    """Let T act where the pressure does, midway between the faces: in places (j, PLACE), which are changed.

    At a corner (β = 0 or 1) it would act along the face that the corner touches, though both are pressed into each
    other. `forces` (j, 3); `turned` (j,): what a has turned against b since slips are counted.
    """
    n = np.maximum(forces[:, 0], 1e-300)
    e = np.clip(forces[:, 1] / n, -abs(places[:, H]), abs(places[:, H]))
    at_corner = places[:, U] - places[:, ARM] * places[:, PHI]
    at_pressure = np.where(at_corner > 0.0, at_corner, np.minimum(places[:, U] + e * places[:, PHI], 0.0))
    height = np.where(forces[:, 0] > 0.0, (0.5 - places[:, BETA]) * (at_pressure - 2.0 * at_corner), 0.0)
    places[:, V] -= height * turned
    places[:, MV] -= height


def find_equilibrium(problem: StepProblem, guess: Array, last: Equilibrium | None = None) -> Equilibrium:
    """The equilibrium near a `guess` (b, 3) of the positions; those of the supports are imposed.

    A sequence of programs: each is convex in the geometry of the positions that it begins at, with what the last forces
    change as that geometry does, and is solved as far as it is worth before the geometry is taken anew (Newton's method
    for geometry and forces together). With Coulomb friction the lift of the last slips is taken back in each: where
    these
    settle, sliding does not lift. `last`: a point of the path near which this one is sought. Raises NoEquilibriumError
    where none lies near, UnsettledError where geometry and forces do not come to agree, ConvergenceError where neither
    can be decided.
    """
    system = problem.system
    at, forces, iterate, solves = guess, None, None, 0
    if last is not None:
        forces = moved_over(last.forces, last.contacts, system.contacts)
        if last.iterate is not None:
            iterate, distance = iterate_over(last.iterate, last.contacts, system.contacts), DISTANCE
    stages = STAGES[system.behaviour]
    slips, touching = None, None
    past, relax, best = None, 1.0, None
    jump = max(JUMP, 0.0 if system.rigid else system.model.joints_in_a_row)
    for stage in range(len(stages) + MOST_ROUNDS[system.behaviour]):
        accepted = stages[min(stage, len(stages) - 1)]
        if system.sliding == "coulomb" and iterate is not None and stage <= SLIDES:
            slips = abs(iterate.gaps[:, 2] - iterate.gaps[:, 3])
        program, touching = problem.pose(at, forces, slips, touching)
        index = touching
        near = [] if iterate is None else [taken(iterate, index).warm(program, distance)]
        found, more = _solved(program, system.layout.take(index), near, accepted, first=stage == 0)
        solves += more
        before, at = at, _checked(problem, displaced(system.model, at, found.displacement), jump)
        forces = _spread(interior.solution(program, found).forces, index, len(system.contacts))
        iterate, distance = over_all(found, index, len(system.contacts)), CLOSER * accepted
        slides = slips is not None and stage < SLIDES and _lift(system, iterate, slips) > LEVEL * problem.size
        if stage >= len(stages) - 1 and not slides:
            others = _touching_after(system, at, forces, touching)
            if others is not None:
                touching = others
                continue
            settled = _settled(problem, at, forces, found.alpha, iterate, solves, slips, touching)
            if settled.certificate.worst(problem.size) <= SETTLED:
                return settled
            if best is None or settled.certificate.equilibrium < best.certificate.equilibrium:
                best = settled
            residual = (at - before)[system.model.movable] * (1.0, 1.0, system.model.size)
            if past is not None:
                change = residual - past
                relax = float(
                    np.clip(-relax * (past * change).sum() / max((change * change).sum(), 1e-300), 0.1, 1.0)
                )
            past = residual
            at = before + relax * (at - before)
    if best is not None and best.certificate.worst(problem.size) <= NEARLY:
        return best
    block = int(np.argmax(abs(found.displacement.reshape(-1, 3)[:, :2]).max(axis=1)))
    block = int(np.flatnonzero(system.model.movable)[block])
    raise UnsettledError(f"the geometry of the step does not settle, at block {block} first")


def in_short_steps(problem: StepProblem, guess: Array) -> Equilibrium:
    """The step in short ones, to where the supports are in `guess` (b, 3).

    Each is a single program in the geometry in which it begins, with a little inertia, which keeps loose blocks where
    they are. What sliding has lifted stays lifted while it goes on: the change of the lift, the dilation, vanishes, as
    with Coulomb friction. Forces are those at the beginning of the last short step, short of equilibrium by the
    inertia,
    which the certificate tells. Raises NoEquilibriumError where blocks fall, ConvergenceError where a program is not
    solved.
    """
    system, model = problem.system, problem.system.model
    begun, fixed = problem.start.positions, ~model.movable
    count = max(FEWEST, int(np.ceil(problem.size / (SHORT * model.size))))
    at, state, iterate, solves = begun, problem.start, None, 0
    for k in range(count):
        posed = at.copy()
        posed[fixed] = begun[fixed] + (k + 1.0) / count * (guess - begun)[fixed]
        step = replace(
            problem,
            start=state,
            size=problem.size / count,
            work=problem.work / count,
            mass=model.mass / LONG**2,
        )
        program, index = step.pose(posed, None)
        near: list[Iterate] = [] if iterate is None else [taken(iterate, index).warm(program, DISTANCE)]
        found, more = _solved(program, system.layout.take(index), near, STAGES["rigid"][-1], first=k == 0)
        solves += more
        at = _checked(step, displaced(model, posed, found.displacement), JUMP)
        iterate = over_all(found, index, len(system.contacts))
        forces = _spread(interior.solution(program, found).forces, index, len(system.contacts))
        state = state_at_rest(system, at, forces)
    alpha = found.alpha
    if problem.lateral is not None and program.mass is not None:
        alpha -= float((program.mass * found.displacement**2).sum()) / step.work  # what inertia takes
    return Equilibrium(
        state,
        system,
        system.contacts.places(at),
        forces,
        alpha,
        iterate,
        certify(replace(program, mass=None), forces[index], found.alpha, found.displacement),
        0.0,
        solves,
    )


def _lift(system: StaticSystem, iterate: Iterate, slips: Array) -> float:
    """By how much (m) slips differ from those whose lift was taken back, as a gap."""
    missed = abs(iterate.gaps[:, 2] - iterate.gaps[:, 3]) - slips
    return float(abs(system.law[:, FRICTION] * missed).max(initial=0.0))


def _touching_after(system: StaticSystem, at: Array, forces: Array, touching: Index) -> Index | None:
    """The joints that touch where those `touching` are not all, or carry beyond their faces; None: they are right."""
    places = system.contacts.places(at)
    apart = places[:, H] <= VANISHED * system.model.size
    wrong = apart & (forces[:, 0] > CARRYING * system.model.weight)
    inside = ~apart & (end_gaps(places).min(axis=1) < -INSIDE * system.model.size)
    inside[touching] = False
    if not wrong.any() and not inside.any():
        return None
    taken = np.zeros(len(places), dtype=bool)
    taken[touching] = True
    return np.flatnonzero((taken & ~wrong) | inside)


def state_at_rest(system: StaticSystem, at: Array, forces: Array) -> State:
    """The state at rest at positions (b, 3) under forces (j, 3)."""
    carrying = forces[:, 0] > CARRYING * system.model.weight
    drawn = len(system.model.contacts)
    met = np.column_stack([system.contacts.edges, forces[:, 2]])[drawn:][carrying[drawn:]]
    shear = forces[:drawn, 2].copy() if system.law[:, SHEAR].any() else None
    return State(at, np.zeros_like(at), shear, met if len(met) else None, carrying[:drawn])


def _settled(
    problem: StepProblem,
    at: Array,
    forces: Array,
    alpha: float,
    iterate: Iterate,
    solves: int,
    slips: Array | None,
    touching: Index,
) -> Equilibrium:
    """The equilibrium of forces and positions where they agree; None where they do not."""
    system = problem.system
    program, index = problem.pose(at, forces, slips, touching)
    certificate = certify(program, forces[index], alpha, np.zeros(len(program.load)))
    places = system.contacts.places(at)
    return Equilibrium(
        state_at_rest(system, at, forces),
        system,
        places,
        forces,
        alpha,
        iterate,
        certificate,
        _penetration(system, places, forces),
        solves,
    )


def moved_over(values: Array, before: Contacts, now: Contacts) -> Array:
    """Values (j, k) of contacts, for others: 0 of those that are new."""
    if before is now:
        return values
    found = np.zeros((len(now), values.shape[1]))
    place = {tuple(e): k for k, e in enumerate(before.edges.tolist())}
    for k, e in enumerate(now.edges.tolist()):
        old = place.get(tuple(e))
        if old is not None:
            found[k] = values[old]
    return found


def iterate_over(iterate: Iterate, before: Contacts, now: Contacts) -> Iterate:
    """An iterate of contacts, for others."""
    if before is now:
        return iterate
    forces, gaps = (moved_over(v, before, now) for v in (iterate.forces, iterate.gaps))
    return replace(iterate, forces=forces, gaps=gaps)


def _solved(
    program: Program, layout: Elimination, near: list[Iterate], accepted: float, first: bool
) -> tuple[Iterate, int]:
    """The iterate that solves a program, sought near another one, then from nowhere; and the programs that took.

    The `first` program of a step has forces of another geometry: what these change may make it unstable where the
    structure is not, so it is solved without that where nothing else helps. Raises NoEquilibriumError where there is no
    equilibrium, ConvergenceError where that cannot be decided.
    """
    unstable, solves = False, 0
    programs = [program] if program.curved is None else [program, interior.frozen(program)]
    attempts = [(program, start) for start in near]
    attempts += [(tried, interior.cold(program)) for tried in programs[: 2 if first else 1]]
    for tried, start in attempts:
        found, outcome = interior.run(tried, layout, start, accepted)
        solves += 1
        if outcome.accepted:
            return found, solves
        unstable = unstable or outcome.unstable
        if abs(found.alpha) > 0.99 * LARGEST_MULTIPLIER:
            raise NoEquilibriumError(
                "no mechanism: the load only wedges the blocks, the multiplier has no bound"
            )
    if unstable:
        raise NoEquilibriumError("loss of stability: the stiffness of the structure is no longer positive")
    _, iterate = solve(interior.frozen(program), layout)  # raises where there is no equilibrium
    if iterate is None:
        raise ConvergenceError("a step of the path was not solved to the required accuracy")
    return iterate, solves + 1


def _checked(problem: StepProblem, found: Array, jump: float) -> Array:
    """The positions (b, 3) found; NoEquilibriumError where the path does not lead there."""
    model, size = problem.system.model, problem.size
    motion = abs(found - problem.start.positions)
    moved = float((motion * (1.0, 1.0, model.size)).max())
    farthest = jump * size
    if moved > farthest:
        raise NoEquilibriumError(f"the structure falls: a step of {size:.3g} m moves it by {moved:.3g} m")
    turned = float(motion[model.movable, 2].max())
    if turned > TURN:
        raise NoEquilibriumError(f"a step of {size:.3g} m turns a block by {turned:.2g} rad")
    return found


def displaced(model: Assembly, positions: Array, displacement: Array) -> Array:
    """Positions (b, 3) after displacements (m,) of the movable blocks."""
    moved = positions.copy()
    moved[model.movable] += displacement.reshape(-1, 3)
    return moved


def taken(iterate: Iterate, index: Index) -> Iterate:
    """The iterate over a choice of the joints."""
    return replace(iterate, forces=iterate.forces[index], gaps=iterate.gaps[index])


def _spread(values: Array, index: Index, count: int) -> Array:
    out = np.zeros((count, values.shape[1]))
    out[index] = values
    return out


def over_all(found: Iterate, index: Index, count: int) -> Iterate:
    """An iterate over all joints: those without overlap carry nothing."""
    return replace(found, forces=_spread(found.forces, index, count), gaps=_spread(found.gaps, index, count))


def _penetration(system: StaticSystem, places: Array, forces: Array) -> float:
    overlapping = places[:, H] > VANISHED * system.model.size
    p, f = places[overlapping], forces[overlapping]
    gaps = end_gaps(p)
    if not system.rigid:
        gaps = gaps - bed_gaps(end_forces(f, p[:, H]), p[:, H], system.law[overlapping])
    return float(max(0.0, -gaps.min(initial=0.0)))


def unsolved(solution: Solution, size: float) -> bool:
    """Whether a solution misses more than is accepted of one."""
    return solution.certificate.worst(size) > SETTLED
