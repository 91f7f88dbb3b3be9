"""States of equilibrium: whether a structure stands, where it comes to rest, and the reactions of its supports."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from mechanics.errors import ConvergenceError, NoEquilibriumError, UnstableError
from mechanics.kernels.joint import MPHI, MU, PHI, H, U, V, bearing, friction_between, lay_shear
from mechanics.kernels.law import SLID, STRENGTH
from mechanics.messages import message
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.model.contacts import Contacts, end_gaps, forces_on_blocks
from mechanics.program import Program
from mechanics.solvers import ACCEPTED, BALANCED, OPEN, interior, least_acceleration
from mechanics.solvers.elimination import Elimination
from mechanics.steps.geometry_iteration import find_equilibrium
from mechanics.steps.rest import motion_to_rest
from mechanics.steps.static_step import Equilibrium, StepProblem
from mechanics.steps.static_system import StaticSystem, carried, static_system
from mechanics.steps.tolerances import LIMIT, STEP
from mechanics.types import GRAVITY, Array, Index, Mask

FALL = 0.1  # of a block: the way in which unpressed ones are looked for
YIELD = 1e-4  # of a block: what the weight of the whole structure presses a face in
SMALL = (1e-2, 1e-4, 1.0)  # of the forces of a cold start


@dataclass(frozen=True, eq=False)
class ClosedProgram:
    """The rigid program over the contacts closed in a state, their `index` among all contacts, and its layout.

    `edges` (j, 2): half-length h, m, and strength s, kN/m, of the joints that turn on one edge and crush there, s = inf
    of all others. Their resultant N is N/2s within the edge: there the program has their hinge.
    """

    program: Program
    contacts: Contacts
    index: Index
    layout: Elimination
    edges: Array

    def pushed(self, model: Assembly, lateral: Array) -> ClosedProgram:
        """Return the program with a lateral load (b, 3), kN, of free multiplier; it moves blocks by about a step."""
        work = self.program.step * model.weight
        program = replace(self.program, lateral=lateral[model.movable].ravel(), work=work)
        return replace(self, program=program)

    def hinged(self, normal: Array, tried: int) -> ClosedProgram | None:
        """Return the program with its hinges where normal forces (j,) kN have them; None if they are there.

        An edge that its force crushes over the whole of a joint, as a corner on a narrow ledge, carries nothing.
        `tried`: number of programs before. Two faces that share a force may take it in turns: after a quarter of the
        programs no hinge moves back to its edge. What a larger force has crushed bears a smaller one at its middle.
        """
        half, strength = self.edges.T
        if (whole := normal >= 2.0 * half * strength).any():
            return self.without(whole)
        places = self.program.places
        now = np.minimum(
            half - 0.5 * normal / strength, places[:, H] if tried >= LIMIT.repeats // 4 else half
        )
        if abs(now - places[:, H]).max(initial=0.0) <= STEP.inside * self.program.size:
            return None
        moved = places.copy()
        moved[:, H], moved[:, PHI] = now, places[:, PHI] * places[:, H] / now
        return replace(self, program=replace(self.program, places=moved))

    def without(self, joints: Mask) -> ClosedProgram:
        """Return the program without those of its joints (j,)."""
        kept, own = np.flatnonzero(~joints), self.program
        program = replace(own, dof=own.dof[kept], places=own.places[kept], law=own.law[kept])
        layout, edges = self.layout.take(kept), self.edges[kept]
        return replace(self, program=program, index=self.index[kept], layout=layout, edges=edges)

    def on_edges(self) -> tuple[ClosedProgram, Array]:
        """Return the program whose joints with one open end are hinges at the other, N and T alone.

        And the lever (j,) m of N about the middle of each overlap: there such a hinge has P = lever · N. At its onset a
        mechanism is infinitesimal: an open end bears nothing, however little work the mechanism does and however far it
        moves for the work of the program.
        """
        places = self.program.places.copy()
        first, second = (end_gaps(places) > 0.5 * OPEN * self.program.step).T
        hinge = first ^ second
        lever = np.where(hinge, np.where(first, 1.0, -1.0) * places[:, H], 0.0)
        places[:, MU] += lever * places[:, MPHI]
        places[hinge, H] *= STEP.rounding
        places[hinge, U], places[hinge, PHI] = 0.0, 0.0
        return replace(self, program=replace(self.program, places=places)), lever


def closed_program(model: Assembly, state: State, tolerance: float | None = None) -> ClosedProgram:
    """Return the rigid program under gravity over the joints closed in a state.

    An end of a joint is closed if its gap is zero within the tolerance, a share of the block size: None, that of the
    drawing as drawn, LIMIT.closed in another state. If the joint is known to carry, the gap of its nearer end is
    subtracted first: sliding has lifted that joint. A joint of finite strength that has turned on its edge has crushed
    there: its faces meet at the end of what has. A corner that has met a face bears nothing before it has crushed, but
    for a block that rests on corners alone: it has crushed them as far as they bear it.
    """
    if tolerance is None:
        drawn = model.joint_tolerance / model.size if state is model.initial else np.inf
        tolerance = min(drawn, LIMIT.closed)
    step = LIMIT.onset * model.size
    system = static_system(model, "rigid").around(state.positions, step)
    places = system.places(state.positions, state)
    gaps = end_gaps(places)
    carrying = np.flatnonzero(carried(system.contacts, state))
    gaps[carrying] -= np.maximum(gaps[carrying].min(axis=1), 0.0)[:, None]  # the gap that sliding has left
    closed = gaps <= tolerance * model.size
    law = system.law.copy()
    law[:, SLID] = 0.0
    bears = np.empty(len(places), dtype=bool)
    bearing(places, law, system.no_overlap, bears)
    friction_between(places, law)
    turned = (closed.sum(axis=1) == 1) & ~system.contacts.ties
    edges = np.column_stack([places[:, H], np.where(turned, law[:, STRENGTH], np.inf)])
    crushed = np.isfinite(edges[:, 1])
    on_corners, met = model.movable.copy(), slice(system.ties.stop, None)
    on_corners[model.joints.a] = on_corners[model.joints.b] = False
    alone = (on_corners[system.contacts.a] | on_corners[system.contacts.b])[met]
    bears[met] &= alone | ~crushed[met] | (gaps.min(axis=1) < -tolerance * model.size)[met]
    index = np.flatnonzero(closed.any(axis=1) & bears)
    law[crushed, STRENGTH] = np.inf
    # crushed up to where the gap vanishes: half of that is the resultant's distance from the edge
    share = np.maximum(-gaps.min(axis=1), 0.0) / np.maximum(np.ptp(gaps, axis=1), 1e-300)
    places[crushed, H] *= 1.0 - np.minimum(share[crushed], 0.5)
    low, high = np.where(closed, 0.0, OPEN * step).T
    places[:, U], places[:, PHI] = 0.5 * (low + high), 0.5 * (high - low) / np.maximum(places[:, H], 1e-300)
    places[:, V] = 0.0
    program = Program(
        dof=system.dof[index], places=places[index], law=law[index], load=model.dead_load[model.movable].ravel(),
        lateral=None, work=0.0, mass=None, weight=system.weight, size=model.size, step=step,
    )  # fmt: skip
    return ClosedProgram(program, system.contacts, index, system.layout.take(index), edges[index])


def check_self_weight(model: Assembly, state: State | None = None) -> ClosedProgram:
    """Return the program of a state (default: as drawn); raise UnstableError where gravity alone cannot be carried.

    Joints are closed within the tolerance of the drawing as drawn, and within LIMIT.closed as placed by hand. A state
    whose forces are known is exact: the least tolerance counts with which it stands, for a wider one closes its cracks.
    """
    state = state or model.initial
    if state.carrying is None:
        return _standing(model, state, None)
    tolerance = STEP.inside
    while tolerance < 0.5 * LIMIT.closed:
        try:
            return _standing(model, state, tolerance)
        except UnstableError:
            tolerance *= 10.0
    return _standing(model, state, LIMIT.closed)


def standing_program(model: Assembly, state: State) -> ClosedProgram:
    """Return the program of a state that is known to stand, even if it does so only within the accuracy of its path."""
    try:
        return check_self_weight(model, state)
    except UnstableError:
        return closed_program(model, state)


@lru_cache(maxsize=4)  # every path of a model begins with it as drawn
def _standing(model: Assembly, state: State, tolerance: float | None) -> ClosedProgram:
    """Return the program over the joints closed within a tolerance; raise UnstableError where it cannot stand."""
    closed = closed_program(model, state, tolerance)
    # the last equilibrium of a path balances within the accuracy of the path, a share of the whole weight on any block
    allowed = BALANCED if state.carrying is None else STEP.slow * model.weight / closed.program.weight
    for k in range(LIMIT.repeats):
        acceleration, forces = least_acceleration(closed.program, closed.layout)
        if acceleration <= allowed:
            return closed
        if (again := closed.hinged(forces[:, 0], k)) is None:
            break
        closed = again
    raise UnstableError(message(
        "the structure cannot stand under its own weight: some block would start to move with {acceleration:.2g} g; "
        "check supports, friction, strength and joints (open ones carry nothing)", acceleration=acceleration,
    ))  # fmt: skip


def unpressed(model: Assembly) -> Index:
    """Return the blocks as drawn that friction alone holds, of faces that nothing presses.

    Rigid joints may press on each other as they like: a beam between two walls hangs by self-stress. Joints that yield
    a little, unstressed as drawn, have no force there, and the beam falls: blocks are left to themselves for a moment
    in which they would fall by FALL of a block. The program begins with small forces: there may be others.
    """
    way = FALL * model.size
    bed = dict.fromkeys(("normal_stiffness", "tangential_stiffness"), model.weight / (YIELD * model.size**3))
    blocks = [replace(block, material=replace(block.material, **bed)) for block in model.uncrushed.blocks]
    soft = replace(model.uncrushed, blocks=blocks)
    system = static_system(soft, "elastic", "coulomb")
    still = StepProblem(system, soft.initial, soft.dead_load, way, mass=soft.mass / (way / GRAVITY))
    program, index = still.pose(soft.initial.positions, None)
    cold = interior.cold(program)
    for share in SMALL:
        begun = replace(cold, forces=share * cold.forces)
        found, outcome = interior.run(program, system.layout.take(index), begun, ACCEPTED)
        if outcome.accepted:
            break
    moved = abs(found.displacement.reshape(-1, 3)[:, :2]).max(axis=1)
    fallen = outcome.accepted & (moved > 0.5 * way)
    return np.flatnonzero(model.movable)[fallen]


@lru_cache(maxsize=4)  # as `_standing`
def rest(system: StaticSystem, state: State) -> Equilibrium:
    """Return the equilibrium under gravity into which a state settles: gaps closed, elastic joints compressed.

    A slender arch sinks by a hundred times the compression of its joints: if no static step finds that, the blocks are
    released until they rest. Raises NoEquilibriumError or ConvergenceError if they do not come to rest.
    """
    model = system.model
    problem = StepProblem(system, state, model.dead_load, rest_size(model, system.behaviour))
    try:
        return find_equilibrium(problem, state.positions)
    except (NoEquilibriumError, ConvergenceError):
        if system.rigid:
            raise
        return motion_to_rest(problem, state.positions)


def rest_size(model: Assembly, behaviour: Behaviour) -> float:
    """Return a displacement (m) on the scale of the joints' compression under gravity.

    Rigid, or without joints: that of a mechanism at its onset.
    """
    contacts = model.contacts.take(np.flatnonzero(~model.contacts.ties))
    if behaviour == "rigid" or len(contacts) == 0:
        return LIMIT.onset * model.size
    length = 2.0 * contacts.places(model.initial.positions)[:, H]
    return float(np.median(model.weight / (contacts.bed * length)))


def reaction(step: Equilibrium, support: Index) -> Array:
    """Return the force (x, z), kN, and the moment about the origin, kNm, (3,) of a support on the structure."""
    contacts, x, places = step.contacts, step.state.positions, step.places.copy()
    if not step.system.rigid:
        lay_shear(places, step.forces, np.zeros(len(places)))
    entries = forces_on_blocks(places, step.forces)
    total = np.zeros(3)
    for part, owner in ((entries[:, :3], contacts.a), (entries[:, 3:], contacts.b)):
        on = np.isin(owner, support)
        force, arm = part[on], x[owner[on]]
        moment = force[:, 2] + arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
        total -= (*force[:, :2].sum(axis=0), moment.sum())
    return total
