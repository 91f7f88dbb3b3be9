"""One static step: the program set up in the geometry in which its forces act, and solved until the two agree."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mechanics.assembly import Assembly, Behaviour, Mask, State
from mechanics.block import Array
from mechanics.contacts import Kinematics
from mechanics.errors import NoEquilibriumError, UnstableError
from mechanics.joints import Index
from mechanics.program import LARGEST_MULTIPLIER, Certificate, Program
from mechanics.solvers import BALANCED, imbalance, solve

GEOMETRY_TOLERANCE = 1e-3  # of the step: how closely the geometry of forces and of positions must agree
ALTERNATION = 0.5  # of the step: how far apart alternating mechanisms of rigid blocks may leave the blocks
MOST_ITERATIONS = 30
JUMP = 30.0  # a step this many times larger than asked is a fall, not a path of equilibrium
CLOSED = 1e-3  # of the block size: a gap that is none (dilatant sliding leaves some in a settled state)


@dataclass(frozen=True, eq=False)
class Step:
    """An equilibrium: its state, contact forces (c, 2) kN, multiplier, and the certificate.

    `at` (b, 3): the positions, within the geometry tolerance the state's, in which the forces act through `rows`;
    `solves`: programs solved to get there; `penetration` m: deepest true interpenetration that no compliance explains.
    """

    state: State
    forces: Array
    alpha: float
    at: Array
    rows: Kinematics
    certificate: Certificate
    penetration: float
    solves: int


def find_step(
    model: Assembly,
    behaviour: Behaviour,
    start: State,
    guess: Array,
    load: Array,
    size: float,
    lateral: Array | None = None,
    work: float = 0.0,
) -> Step:
    """The equilibrium reached from `start` under `load` (b, 3), or under load + α·lateral doing the work γ.

    `guess` (b, 3): positions expected; those of the supports are imposed. `size` (m): the displacement expected. The
    geometry (arms, normals, gaps) is that of the guess, then that of each result, until both agree: the sequential
    solution of the paper (§4), implicit in the geometry. Raises NoEquilibriumError where none lies near, and
    ConvergenceError where that cannot be decided.
    """
    at = guess
    scale = np.array([1.0, 1.0, model.size])
    worst = Certificate(0.0, 0.0, 0.0, 0.0, 0.0)
    earlier, ahead = np.full_like(at, np.inf), 1.0
    for count in range(1, MOST_ITERATIONS + 1):
        program, rows = assemble(model, behaviour, start, at, load, size, lateral, work)
        solution = solve(program)
        if lateral is not None and abs(solution.alpha) > 0.99 * LARGEST_MULTIPLIER:
            raise NoEquilibriumError(
                "no mechanism: the load only wedges the blocks, the multiplier has no bound"
            )
        worst = worst.joined(solution.certificate)
        found = at.copy()
        found[model.movable] = start.positions[model.movable] + solution.displacement.reshape(-1, 3)
        moved = float(abs((found - start.positions) * scale).max())
        if moved > JUMP * size:
            raise NoEquilibriumError(f"the structure falls: a step of {size:.3g} m moves it by {moved:.3g} m")
        change = (found - at) * scale
        largest, before = float(abs(change).max()), float(abs(earlier).max())
        if largest <= GEOMETRY_TOLERANCE * size:
            break
        if behaviour == "rigid" and count > 3 and largest <= ALTERNATION * size and largest > 0.9 * before:
            break  # two mechanisms alternate, each the answer in the other's geometry: both are close enough
        if count > 8 and largest > 0.9 * before:
            raise NoEquilibriumError("the geometry of the step does not settle: loss of stability")
        if behaviour == "elastic" and count > 1:
            # Aitken's extrapolation; never backwards, which would settle on an unstable equilibrium
            turn = change - earlier
            ahead = float(np.clip(-ahead * (earlier * turn).sum() / (turn * turn).sum(), 0.1, 10.0))
        at, earlier = at + ahead * change / scale, change
    penetration = _penetration(model, behaviour, found, solution.forces)
    shear = solution.forces[:, 1] if np.isfinite(model.contacts(behaviour).stiffness[:, 1]).any() else None
    return Step(
        State(found, np.zeros_like(found), shear if behaviour == "elastic" else None),
        solution.forces,
        solution.alpha,
        at,
        rows,
        worst,
        penetration,
        count,
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
) -> tuple[Program, Kinematics]:
    """The static program of a step from `start`, in the geometry of the positions `at` (b, 3)."""
    contacts = model.contacts(behaviour)
    rows = model.kinematics(behaviour, at)
    movable = model.movable
    # gap and slip since the start are true at `at`; carried back to the start of the movable blocks for the program
    begun = model.kinematics(behaviour, start.positions) if at is not start.positions else rows
    back = np.where(movable[:, None], start.positions - at, 0.0)
    compliance = np.zeros((len(contacts), 2)) if behaviour == "rigid" else 1.0 / contacts.stiffness
    gap = np.stack(
        [
            rows.gap + local(rows.normal, contacts.a, contacts.b, back),
            rows.slide - begun.slide + local(rows.tangent, contacts.a, contacts.b, back),
        ],
        axis=1,
    )
    if start.shear is not None and behaviour == "elastic":
        gap[:, 1] -= compliance[:, 1] * start.shear
    program = Program(
        dof=np.concatenate([model.dof[contacts.a], model.dof[contacts.b]], axis=1),
        normal=rows.normal,
        tangent=rows.tangent,
        gap=gap,
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
    return program, rows


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
    program, rows = assemble(
        model, "rigid", state, state.positions, model.dead_load, size, lateral, size * model.weight
    )
    touching = rows.gap <= CLOSED * model.size
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


def rest(model: Assembly, behaviour: Behaviour, state: State, size: float | None = None) -> Step:
    """The equilibrium under gravity into which a state settles: gaps closed, elastic joints compressed."""
    size = rest_size(model, behaviour) if size is None else size
    return find_step(model, behaviour, state, state.positions, model.dead_load, size)


def rest_size(model: Assembly, behaviour: Behaviour) -> float:
    """A displacement (m) on the scale of the joints' compression under gravity; rigid: 1/1000 of a block."""
    if behaviour == "rigid":
        return 1e-3 * model.size
    stiffness = model.contacts(behaviour).stiffness[:, 0]
    return float(np.median(model.weight / stiffness)) / 4.0


def reaction(model: Assembly, behaviour: Behaviour, step: Step, support: Index) -> Array:
    """Force (x, z) in kN and moment about the origin in kNm (3,) that a support exerts on the structure."""
    contacts = model.contacts(behaviour)
    entries = step.forces[:, :1] * step.rows.normal + step.forces[:, 1:] * step.rows.tangent
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
