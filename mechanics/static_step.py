"""One static step: the program set up in the geometry in which its forces act, and solved until the two agree."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from mechanics.assembly import Assembly, Behaviour, State
from mechanics.block import Array
from mechanics.errors import NoEquilibriumError
from mechanics.joints import Index
from mechanics.program import LARGEST_MULTIPLIER, Certificate, Neighbour, Program, Solution
from mechanics.solvers import solve, suits_central_path
from mechanics.solvers.compiled import geometry
from mechanics.solvers.elimination import Elimination

GEOMETRY_TOLERANCE = 1e-3  # of the step: how closely the geometry of forces and of positions must agree
ALTERNATION = 0.5  # of the step: how far apart alternating mechanisms of rigid blocks may leave the blocks
ASTRAY = 1e-4  # of a block: by how much gaps that count may err where a large model's step ends
MOST_ITERATIONS = 30
LARGE = 400  # contact points
SETTLING = {"rigid": 3, "elastic": 8}  # iterations in which the geometry may go astray first
CARRYING = 1e-6  # of the weight: a contact force that is one
JUMP = 30.0  # a step this many times larger than asked is a fall, not a path of equilibrium
TURN = 0.5  # rad: a step that turns a block by more leaves the range in which its geometry is linear


@dataclass(frozen=True, eq=False)
class Step:
    """An equilibrium: its state, and the solution of the last program.

    `at` (b, 3): the positions, the state's but for the geometry tolerance or alternating mechanisms, in which the
    `program` is posed and the forces act; `neighbour`: what the path's next step is like; `solves`: programs solved
    to get there; `penetration` m: deepest true interpenetration that no compliance explains.
    """

    state: State
    at: Array
    program: Program
    solution: Solution
    neighbour: Neighbour
    penetration: float
    solves: int

    @property
    def forces(self) -> Array:
        """Contact forces (c, 2) kN."""
        return self.solution.forces

    @property
    def alpha(self) -> float:
        """The multiplier of the lateral load."""
        return self.solution.alpha

    @property
    def certificate(self) -> Certificate:
        """The certificate of the last program."""
        return self.solution.certificate

    @property
    def opening(self) -> Array:
        """Gaps and slips (c, 2) left, m."""
        return self.program.opening(self.forces, self.solution.displacement)


def find_step(
    model: Assembly,
    behaviour: Behaviour,
    start: State,
    guess: Array,
    load: Array,
    size: float,
    lateral: Array | None = None,
    work: float = 0.0,
    last: Step | None = None,
) -> Step:
    """The equilibrium reached from `start` under `load` (b, 3), or under load + α·lateral doing the work γ.

    `guess` (b, 3): positions expected; those of the supports are imposed. `size` (m): the displacement expected;
    `last`: the path's last step, near whose forces and gaps this one's are sought. The geometry (arms, normals, gaps)
    is that of the guess, then that of each result, until both agree: the sequential solution of the paper (§4),
    implicit in the geometry. A large model's first result is where central_path ends that follows the geometry. Raises
    NoEquilibriumError where none lies near, and ConvergenceError where that cannot be decided.
    """
    pose = programs(model, behaviour, start, load, size, lateral, work)
    sought = Sought(model, behaviour, start, size, pose)
    near = last.neighbour if last is not None and sought.large else None
    rigid, scale = behaviour == "rigid", np.array([1.0, 1.0, model.size])
    layout = elimination_of(model, behaviour) if suits_central_path(len(model.contacts(behaviour))) else None
    at, earlier, ahead = guess, np.full_like(guess, np.inf), 1.0
    for count in range(1, MOST_ITERATIONS + 1):
        followed = sought.followed(at, near) if near is not None and count == 1 else None
        if followed is not None:
            at, solution = followed
        program = pose(at)
        if followed is None:
            solution = solve(program, near, layout)
        if lateral is not None and abs(solution.alpha) > 0.99 * LARGEST_MULTIPLIER:
            raise NoEquilibriumError(
                "no mechanism: the load only wedges the blocks, the multiplier has no bound"
            )
        found = sought.checked(_displaced(model, at, solution.displacement))
        change = (found - at) * scale
        largest, before = float(abs(change).max()), float(abs(earlier).max())
        if largest <= GEOMETRY_TOLERANCE * size:
            break
        settles = largest < 0.9 * before or count <= SETTLING[behaviour]
        if rigid and sought.large and sought.astray(program, solution, found) <= ASTRAY:
            break
        if not settles or count == MOST_ITERATIONS:
            followed = None if sought.large else sought.followed(at, solution.neighbour(program))
            if followed is not None and sought.left(*followed) <= GEOMETRY_TOLERANCE * size:
                at, solution = followed
                found = _displaced(model, at, solution.displacement)
                return sought.step(at, pose(at), solution, found, solves=count + 1)
            if rigid and largest <= ALTERNATION * size:
                break  # two mechanisms alternate, each the answer in the other's geometry: both are close enough
            block = int(np.argmax(abs(change).max(axis=1)))
            raise NoEquilibriumError(
                f"the geometry of the step does not settle: loss of stability, at block {block} first"
            )
        near = solution.neighbour(program) if sought.large else None
        if not rigid and count > 1:
            # Aitken's extrapolation; never backwards, which would settle on an unstable equilibrium
            turn = change - earlier
            ahead = float(np.clip(-ahead * (earlier * turn).sum() / (turn * turn).sum(), 0.1, 10.0))
        at, earlier = at + ahead * change / scale, change
    return sought.step(at, program, solution, found, solves=count)


@dataclass(frozen=True, eq=False)
class Sought:
    """The equilibrium about `size` (m) from `start`, where the program that is `pose`d there is solved by no motion."""

    model: Assembly
    behaviour: Behaviour
    start: State
    size: float
    pose: Callable[[Array], Program]

    @property
    def large(self) -> bool:
        """Whether the last step is begun from: it saves half the iterations, but of several mechanisms any may result.

        Begun from nowhere it is the one in their middle, whatever the rounding.
        """
        return len(self.model.contacts(self.behaviour)) >= LARGE

    @property
    def farthest(self) -> float:
        """The displacement (m) from which on it is a fall: joints in a row may all be compressed by the size."""
        return max(JUMP, self.model.joints_in_a_row if self.behaviour == "elastic" else 0.0) * self.size

    def checked(self, found: Array) -> Array:
        """The positions (b, 3) found; NoEquilibriumError where the path does not lead there."""
        motion = abs(found - self.start.positions)
        moved = float((motion * (1.0, 1.0, self.model.size)).max())
        if moved > self.farthest:
            raise NoEquilibriumError(
                f"the structure falls: a step of {self.size:.3g} m moves it by {moved:.3g} m"
            )
        turned = float(motion[self.model.movable, 2].max())
        if turned > TURN:
            raise NoEquilibriumError(f"a step of {self.size:.3g} m turns a block by {turned:.2g} rad")
        return found

    def followed(self, at: Array, near: Neighbour) -> tuple[Array, Solution] | None:
        """Positions and their program's solution where the central path ends, its geometry followed; None: nowhere."""
        from mechanics.solvers import central_path

        def pose(x: Array) -> Program:
            return self.pose(self.checked(_displaced(self.model, at, x)))

        layout = elimination_of(self.model, self.behaviour)
        try:
            ended = central_path.follow(pose, layout, near)
            if ended is None:
                return None
            there = _displaced(self.model, at, ended[0])
            self.checked(_displaced(self.model, there, ended[1].displacement))
        except NoEquilibriumError:
            return None
        return there, ended[1]

    def left(self, at: Array, solution: Solution) -> float:
        """How far (m) the blocks are from where the solution of the program posed at positions (b, 3) puts them."""
        moved = abs(_displaced(self.model, at, solution.displacement) - at)
        return float((moved * (1.0, 1.0, self.model.size)).max())

    def astray(self, program: Program, solution: Solution, found: Array) -> float:
        """How far gaps at the positions found are from those of the program's solution, where they count; per block."""
        gap = self.model.kinematics(self.behaviour, found).gap
        bears = solution.forces[:, 0] > CARRYING * self.model.weight
        expected = program.opening(solution.forces, solution.displacement)[:, 0]
        worst = max(abs(gap - expected)[bears].max(initial=0.0), (-gap).max(initial=0.0))
        return float(worst) / self.model.size

    def step(self, at: Array, program: Program, solution: Solution, found: Array, solves: int) -> Step:
        """The step that ends at positions (b, 3) found by the solution of the program posed `at` others."""
        contacts, rigid = self.model.contacts(self.behaviour), self.behaviour == "rigid"
        has_shear = not rigid and np.isfinite(contacts.stiffness[:, 1]).any()
        return Step(
            State(
                found,
                np.zeros_like(found),
                solution.forces[:, 1] if has_shear else None,
                solution.forces[:, 0] > CARRYING * self.model.weight,
            ),
            at,
            program,
            solution,
            solution.neighbour(program),
            _penetration(self.model, self.behaviour, found, solution.forces),
            solves,
        )


@lru_cache(maxsize=8)
def elimination_of(model: Assembly, behaviour: Behaviour) -> Elimination:
    """In which order the matrices of a model's programs are eliminated."""
    return Elimination.of(_rows(model, behaviour), model.initial.positions[model.movable, :2])


def _rows(model: Assembly, behaviour: Behaviour) -> Index:
    """Rows of equilibrium (c, 6) of the two blocks of each contact point."""
    contacts = model.contacts(behaviour)
    return np.concatenate([model.dof[contacts.a], model.dof[contacts.b]], axis=1)


def _displaced(model: Assembly, positions: Array, displacement: Array) -> Array:
    moved = positions.copy()
    moved[model.movable] += displacement.reshape(-1, 3)
    return moved


def assemble(
    model: Assembly,
    behaviour: Behaviour,
    start: State,
    at: Array,
    load: Array,
    size: float,
    lateral: Array | None = None,
    work: float = 0.0,
) -> Program:
    """The static program of a step from `start`, in the geometry of the positions `at` (b, 3) and counted from them."""
    return programs(model, behaviour, start, load, size, lateral, work)(at)


def programs(
    model: Assembly,
    behaviour: Behaviour,
    start: State,
    load: Array,
    size: float,
    lateral: Array | None = None,
    work: float = 0.0,
) -> Callable[[Array], Program]:
    """The static program of a step from `start` as a function of the positions (b, 3) in whose geometry it is posed.

    Its displacements are what is missing from those positions to equilibrium: they vanish as the geometry settles, and
    with them the rounding in the gaps.
    """
    contacts, movable = model.contacts(behaviour), model.movable
    compliance = np.zeros((len(contacts), 2)) if behaviour == "rigid" else 1.0 / contacts.stiffness

    def kinematics(positions: Array) -> tuple[Array, Array, Array]:
        gap, normal, tangent = (np.empty((len(contacts), k)) for k in (2, 6, 6))
        parts = (contacts.a, contacts.b, contacts.p, contacts.q, contacts.n)
        geometry(*parts, positions, gap, normal, tangent)
        return gap, normal, tangent

    slid = kinematics(start.positions)[0][:, 1]
    if start.shear is not None and behaviour == "elastic":
        slid = slid + compliance[:, 1] * start.shear
    still = Program(
        dof=_rows(model, behaviour),
        normal=np.zeros((0, 6)),
        tangent=np.zeros((0, 6)),
        gap=np.zeros((0, 2)),
        friction=contacts.friction,
        compliance=compliance,
        load=load[movable].ravel(),
        lateral=None if lateral is None else lateral[movable].ravel(),
        work=work,
        mass=None,
        weight=model.weight / movable.sum(),
        size=model.size,
        step=size,
    )

    def pose(at: Array) -> Program:
        gap, normal, tangent = kinematics(at)
        gap[:, 1] -= slid
        done = 0.0 if lateral is None else float((lateral * (at - start.positions))[movable].sum())
        return replace(still, normal=normal, tangent=tangent, gap=gap, work=work - done)

    return pose


def _penetration(model: Assembly, behaviour: Behaviour, positions: Array, forces: Array) -> float:
    contacts = model.contacts(behaviour)
    compression = forces[:, 0] / contacts.stiffness[:, 0] if behaviour == "elastic" else 0.0
    gap = model.kinematics(behaviour, positions).gap + compression
    return float(max(0.0, -gap.min(initial=0.0)))
