"""One static step: the program set up in the geometry in which its forces act, and solved until the two agree."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from mechanics.assembly import Assembly, Behaviour, Mask, State
from mechanics.block import Array
from mechanics.errors import NoEquilibriumError, UnstableError
from mechanics.joints import Index
from mechanics.program import LARGEST_MULTIPLIER, Certificate, Neighbour, Program, Solution
from mechanics.solvers import BALANCED, LARGE, imbalance, kernels, solve
from mechanics.solvers.band import Band
from mechanics.solvers.kernels import fastest

GEOMETRY_TOLERANCE = 1e-3  # of the step: how closely the geometry of forces and of positions must agree
ALTERNATION = 0.5  # of the step: how far apart alternating mechanisms of rigid blocks may leave the blocks
MOST_ITERATIONS = 30
JUMP = 30.0  # a step this many times larger than asked is a fall, not a path of equilibrium
TURN = 0.5  # rad: a step that turns a block by more leaves the range in which its geometry is linear
CLOSED = 1e-3  # of the block size: a gap that is none (dilatant sliding leaves some in a settled state)


@dataclass(frozen=True, eq=False)
class Step:
    """An equilibrium: its state, contact forces (c, 2) kN, multiplier, and the certificate.

    `at` (b, 3): the positions, within the geometry tolerance the state's, in which the `program` is posed and the
    forces act; `opening` (c, 2) m: gaps and slips left; `solves`: programs solved to get there; `penetration` m:
    deepest true interpenetration that no compliance explains.
    """

    state: State
    forces: Array
    alpha: float
    at: Array
    program: Program
    opening: Array
    certificate: Certificate
    penetration: float
    solves: int

    @property
    def neighbour(self) -> Neighbour:
        """What the path's next step is like."""
        return Neighbour(self.forces, self.opening, self.alpha)


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
    implicit in the geometry. Large models follow it within one run of central_path; where that fails, and in small
    ones, a program is solved for each geometry. Raises NoEquilibriumError where none lies near, and ConvergenceError
    where that cannot be decided.
    """
    pose = programs(model, behaviour, start, load, size, lateral, work)
    # joints in a row may all be compressed by the expected displacement
    farthest = max(JUMP, model.joints_in_a_row if behaviour == "elastic" else 0.0) * size
    if last is not None and len(model.contacts(behaviour)) >= LARGE:
        followed = _follow(model, behaviour, pose, guess, last.neighbour, farthest)
        if followed is not None:
            return _step(model, behaviour, *followed, pose, 1)
    scale = np.array([1.0, 1.0, model.size])
    at, earlier, ahead = guess, np.full_like(guess, np.inf), 1.0
    for count in range(1, MOST_ITERATIONS + 1):
        solution = solve(pose(at))
        if lateral is not None and abs(solution.alpha) > 0.99 * LARGEST_MULTIPLIER:
            raise NoEquilibriumError(
                "no mechanism: the load only wedges the blocks, the multiplier has no bound"
            )
        found = _displaced(model, at, solution.displacement)
        moved = float(abs((found - start.positions) * scale).max())
        if moved > farthest:
            raise NoEquilibriumError(f"the structure falls: a step of {size:.3g} m moves it by {moved:.3g} m")
        turned = float(abs(found - start.positions)[model.movable, 2].max())
        if turned > TURN:
            raise NoEquilibriumError(f"a step of {size:.3g} m turns a block by {turned:.2g} rad")
        change = (found - at) * scale
        largest, before = float(abs(change).max()), float(abs(earlier).max())
        if largest <= GEOMETRY_TOLERANCE * size:
            break
        settles = largest < 0.9 * before or count <= (3 if behaviour == "rigid" else 8)
        if not settles or count == MOST_ITERATIONS:
            opening = pose(at).opening(solution.forces, solution.displacement)
            near = Neighbour(solution.forces, opening, solution.alpha)
            followed = _follow(model, behaviour, pose, at, near, farthest)
            if followed is not None:
                return _step(model, behaviour, *followed, pose, count + 1)
            if behaviour == "rigid" and largest <= ALTERNATION * size:
                break  # two mechanisms alternate, each the answer in the other's geometry: both are close enough
            block = int(np.argmax(abs(change).max(axis=1)))
            raise NoEquilibriumError(
                f"the geometry of the step does not settle: loss of stability, at block {block} first"
            )
        if behaviour == "elastic" and count > 1:
            # Aitken's extrapolation; never backwards, which would settle on an unstable equilibrium
            turn = change - earlier
            ahead = float(np.clip(-ahead * (earlier * turn).sum() / (turn * turn).sum(), 0.1, 10.0))
        at, earlier = at + ahead * change / scale, change
    return _step(model, behaviour, at, solution, pose, count)


def _follow(
    model: Assembly,
    behaviour: Behaviour,
    pose: Callable[[Array], Program],
    guess: Array,
    near: Neighbour,
    farthest: float,
) -> tuple[Array, Solution] | None:
    """The equilibrium that the central path leads to from a neighbour, its geometry followed; None: not reached."""
    from mechanics.solvers import central_path

    ended = central_path.follow(
        lambda x: pose(_displaced(model, guess, x)),
        _layout(model, behaviour),
        np.zeros(3 * int(model.movable.sum())),
        near,
        farthest,
    )
    return None if ended is None else (_displaced(model, guess, ended[0]), ended[1])


@lru_cache(maxsize=8)
def _layout(model: Assembly, behaviour: Behaviour) -> Band:
    return Band.of(_rows(model, behaviour), model.initial.positions[model.movable, :2])


def _rows(model: Assembly, behaviour: Behaviour) -> Index:
    """Rows of equilibrium (c, 6) of the two blocks of each contact point."""
    contacts = model.contacts(behaviour)
    return np.concatenate([model.dof[contacts.a], model.dof[contacts.b]], axis=1)


def _displaced(model: Assembly, positions: Array, displacement: Array) -> Array:
    moved = positions.copy()
    moved[model.movable] += displacement.reshape(-1, 3)
    return moved


def _step(
    model: Assembly,
    behaviour: Behaviour,
    at: Array,
    solution: Solution,
    pose: Callable[[Array], Program],
    solves: int,
) -> Step:
    program = pose(at)
    found = _displaced(model, at, solution.displacement)
    has_shear = behaviour == "elastic" and np.isfinite(model.contacts(behaviour).stiffness[:, 1]).any()
    return Step(
        State(found, np.zeros_like(found), solution.forces[:, 1] if has_shear else None),
        solution.forces,
        solution.alpha,
        at,
        program,
        program.opening(solution.forces, solution.displacement),
        solution.certificate,
        _penetration(model, behaviour, found, solution.forces),
        solves,
    )


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
    geometry = (fastest() if len(contacts) >= LARGE else kernels).geometry
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


def local(rows: Array, a: Index, b: Index, displacement: Array) -> Array:
    """Change (c,) of gaps or slides that block displacements (b, 3) cause."""
    change: Array = (rows[:, :3] * displacement[a]).sum(axis=1) + (rows[:, 3:] * displacement[b]).sum(axis=1)
    return change


def closed_program(
    model: Assembly, state: State, lateral: Array | None = None, carrying: Mask | None = None
) -> tuple[Program, Index]:
    """The rigid program over the contacts closed in a state, and their indices; γ moves the blocks by about a step.

    `carrying` (c,) bool: contacts that are closed whatever gap dilatant sliding has left them.
    """
    size = 1e-3 * model.size
    program = assemble(
        model, "rigid", state, state.positions, model.dead_load, size, lateral, size * model.weight
    )
    touching = program.gap[:, 0] <= CLOSED * model.size
    closed = np.flatnonzero(touching if carrying is None else touching | carrying)
    taken = program.take(closed)
    return replace(taken, gap=np.zeros_like(taken.gap)), closed


def check_self_weight(model: Assembly, state: State | None = None) -> None:
    """Raise UnstableError where gravity alone cannot be carried in a state (default: as drawn)."""
    acceleration = imbalance(closed_program(model, state or model.initial)[0])
    if acceleration > BALANCED:
        raise UnstableError(
            "the structure cannot stand under its own weight: some block would start to move with "
            f"{acceleration:.2g} g; check supports, friction and joints (open ones carry nothing)"
        )


def rest(
    model: Assembly, behaviour: Behaviour, state: State, size: float | None = None, last: Step | None = None
) -> Step:
    """The equilibrium under gravity into which a state settles: gaps closed, elastic joints compressed."""
    size = rest_size(model, behaviour) if size is None else size
    return find_step(model, behaviour, state, state.positions, model.dead_load, size, last=last)


def rest_size(model: Assembly, behaviour: Behaviour) -> float:
    """A displacement (m) on the scale of the joints' compression under gravity; rigid: 1/1000 of a block."""
    if behaviour == "rigid":
        return 1e-3 * model.size
    stiffness = model.contacts(behaviour).stiffness[:, 0]
    return float(np.median(model.weight / stiffness)) / 4.0


def reaction(model: Assembly, behaviour: Behaviour, step: Step, support: Index) -> Array:
    """Force (x, z) in kN and moment about the origin in kNm (3,) that a support exerts on the structure."""
    contacts = model.contacts(behaviour)
    entries = step.forces[:, :1] * step.program.normal + step.forces[:, 1:] * step.program.tangent
    total = np.zeros(3)
    for part, owner in ((entries[:, :3], contacts.a), (entries[:, 3:], contacts.b)):
        on = np.isin(owner, support)
        force, arm = part[on], step.at[owner[on]]
        total -= (
            *force[:, :2].sum(axis=0),
            (force[:, 2] + arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]).sum(),
        )
    return total


def _penetration(model: Assembly, behaviour: Behaviour, positions: Array, forces: Array) -> float:
    contacts = model.contacts(behaviour)
    compression = forces[:, 0] / contacts.stiffness[:, 0] if behaviour == "elastic" else 0.0
    gap = model.kinematics(behaviour, positions).gap + compression
    return float(max(0.0, -gap.min(initial=0.0)))
