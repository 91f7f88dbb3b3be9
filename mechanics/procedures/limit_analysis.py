"""Limit analysis: the multiplier at which a mechanism forms, and the mechanism (paper, eq. 5).

By the associative law it is the largest multiplier of forces in equilibrium, and unique. By Coulomb's law, ψ = 0, a
flow is a mechanism and forces that fit it: where a gap opens the force is none, where a joint slides T = ∓μN. Flows
form a continuum of multipliers. The interior point finds one amid them, the *central* one. From it the least is sought:

    A ← the gaps and slips of the central flow
    until so many A in a row lead no lower:
        f ← the forces of least α that balance the loads and fit A            a linear program
        A ← the gaps and slips of another mechanism that fits f, or of        another one
            the central flow of other frictions, in turns                     by chance

Each pair is a flow, certified on its own. Ends that are open bear nothing: by the static theorem no flow has more than
the associative law. Where ψ = 0 has no flow of the given work (blocks wedge, slips grow without bound), a slight
dilation has one: its multiplier is returned with that dilation.

Of a mechanism: its hinges, the joints that slide, the weight that it moves, and its multiplier by virtual work.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from mechanics.errors import ConvergenceError, NoEquilibriumError
from mechanics.kernels.joint import H
from mechanics.kernels.law import FRICTION, STEEP, STRENGTH
from mechanics.messages import message
from mechanics.model.assembly import Assembly, Direction, State
from mechanics.model.contacts import Contacts, end_points, relative_motion
from mechanics.pictures import draw_mechanism, through_blocks
from mechanics.program import BOUNDED, LARGEST_MULTIPLIER, Certificate, Program, Solution, certify, end_forces
from mechanics.solvers import ACCEPTED, GOOD, USABLE, interior, iterated, solve
from mechanics.solvers.elimination import Elimination
from mechanics.solvers.interior import Iterate, with_dilation
from mechanics.steps.equilibrium import ClosedProgram, check_self_weight, standing_program
from mechanics.steps.flow_step import flows_at, margins
from mechanics.steps.static_system import Sliding, check_sliding
from mechanics.steps.tolerances import LIMIT
from mechanics.types import Array, Index, Mask

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

NOTICEABLE = 0.02  # of the largest rotation, or displacement, of a block: a relative one that counts
CARRYING = 2e-3  # of the weight: a joint that carries less is no part of the load path


@dataclass(frozen=True, eq=False, repr=False)
class Limit:
    """Onset of collapse of a `state` of the `model`, pushed in a `direction`.

    `alpha`: multiplier of the lateral load, by Coulomb's law the least found. It is what sets the first blocks of the
    state in motion: α_onset of reports and results, the first multiplier of its pushover curve. α_0 is the curve's
    largest: in a settled state, whose cracks must close first, it may be many times α_onset. As drawn they are one.
    `central`: that of the central flow;
    `mechanism` (b, 3): virtual displacements, scaled so that the largest centroid displacement is 1; `forces` (j, 3): N
    (kN), P (kNm) and T (kN) of the `contacts`, the drawn joints first; `dilation`: share of μ|slip| by which sliding
    lifts joints in the mechanism: 1 by the associative law, 0 by Coulomb's, one of LimitTolerances.slight where that
    has no flow, and 1 where neither has one of α ≥ 0, as in some settled states.
    """

    alpha: float
    central: float
    mechanism: Array
    forces: Array
    contacts: Contacts
    certificate: Certificate
    model: Assembly
    state: State
    direction: Direction
    dilation: float = 1.0
    sliding: Sliding = "coulomb"

    def __repr__(self) -> str:
        return f"Limit({self.direction}, α = {self.alpha:.6g}, {self.sliding} friction)"

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the mechanism where it begins, hinges, joints that slide, and the line of thrust; return the axes.

        Blocks that move are grey, where they go is dashed; `axes` of matplotlib: by default those of a new figure.
        """
        model, contacts, at = self.model, self.contacts, self.state.positions
        found = hinges(model, contacts, self.state, self.mechanism, self.forces)
        points = model.as_drawn(pressure_centres(contacts, at, self.forces))
        loaded = (self.forces[:, 0] > 1e-3 * CARRYING * model.weight) & ~contacts.ties
        return draw_mechanism(
            model.shape.moved(model.displaced(self.state)),
            self.mechanism,
            model.as_drawn(found.points).reshape(-1, 2),
            list(model.as_drawn(end_points(contacts.take(found.sliding), at))),
            through_blocks(np.stack([contacts.a, contacts.b], axis=1), points, loaded),
            model.tie_ends(self.state),
            f"{self.direction}, α = {self.alpha:.4g}",
            axes,
        )

    def to_frame(self) -> pd.DataFrame:
        """Return the virtual displacements of the blocks as a table: x and z, –, and rotation, 1/m."""
        import pandas as pd  # late: only tables need it

        return pd.DataFrame(self.mechanism, columns=["x", "z", "rotation"])


def limit_analysis(
    model: Assembly,
    direction: Direction = "+x",
    state: State | None = None,
    sliding: Sliding = "coulomb",
) -> Limit:
    """Return the onset of collapse under f_D + α f_L over the joints closed in a state (paper, eq. 5).

    `state`: default as drawn. `sliding`: "associative", as in the paper, opens a joint that slides; "coulomb" does not.
    Raises UnstableError if the joints cannot carry gravity alone, NoEquilibriumError if the load meets no mechanism (an
    interlocked assembly), ConvergenceError if hinges that crush do not settle, ArgumentError for an argument out of its
    range.
    """
    Assembly.check(model)
    check_sliding(sliding)
    state = model.starting(state)
    return _limit(model, direction, state, check_self_weight(model, state), sliding)


def limit_in(model: Assembly, direction: Direction, state: State, sliding: Sliding = "coulomb") -> Limit:
    """Return the onset of collapse of a state that is known to stand under gravity; raises as limit_analysis."""
    return _limit(model, direction, state, standing_program(model, state), sliding)


def _limit(
    model: Assembly, direction: Direction, state: State, standing: ClosedProgram, sliding: Sliding
) -> Limit:
    """Return the onset of collapse over the closed joints of a state. Raises as limit_in.

    A hinge that crushes its edge lies N/2s within it: the program is repeated until N is that of the solution.
    """
    closed = standing.pushed(model, model.lateral_load(direction))
    flow = _associative if sliding == "associative" else _coulomb
    for k in range(LIMIT.repeats):
        on_edges, lever = closed.on_edges()
        found, central, dilation = flow(on_edges)
        again = closed.hinged(found.forces[:, 0], k)
        if again is None:
            break
        closed = again
    else:
        raise ConvergenceError(message("the hinges that crush do not settle where their forces have them"))
    if sliding == "coulomb" and model.crushes:
        found, central, dilation = _no_more_than_whole(on_edges, (found, central, dilation))
    if abs(found.alpha) > BOUNDED:
        raise NoEquilibriumError(message(
            "{direction}: no mechanism, the load only wedges the blocks (α > {bound:g})",
            direction=direction, bound=LARGEST_MULTIPLIER,
        ))  # fmt: skip
    mechanism = np.zeros((len(model.blocks), 3))
    mechanism[model.movable] = found.displacement.reshape(-1, 3)
    forces = np.zeros((len(closed.contacts), 3))
    forces[closed.index] = found.forces
    forces[closed.index, 1] += lever * found.forces[:, 0]
    return Limit(
        found.alpha,
        central,
        mechanism / abs(mechanism[:, :2]).max(),
        forces,
        closed.contacts,
        found.certificate,
        model,
        state,
        direction,
        dilation,
        sliding,
    )


def flowing_iterate(program: Program, found: Solution) -> Iterate:
    """Return the iterate near a flow: its forces, gaps and slips, from which displacements are counted."""
    u, phi, slip = program.deformation(found.displacement).T
    tilt = program.places[:, H] * phi
    gaps = np.column_stack([u - tilt, u + tilt, slip, -slip]).clip(0.0)
    ends = end_forces(found.forces, program.places[:, H])
    return Iterate(np.column_stack([ends, found.forces[:, 2]]), gaps, found.alpha, 0.0 * found.displacement)


def _no_more_than_whole(
    closed: ClosedProgram, flow: tuple[Solution, float, float]
) -> tuple[Solution, float, float]:
    """Return a flow of joints that crush; where joints that do not have less, one near theirs, or theirs.

    Where joints crush the program is not linear, and its least flow is not sought.
    """
    program, law = closed.program, closed.program.law.copy()
    law[~closed.contacts.ties[closed.index], STRENGTH] = np.inf
    try:
        least, central, psi = _coulomb(replace(closed, program=replace(program, law=law)))
    except (NoEquilibriumError, ConvergenceError):  # joints that do not crush may be wedged
        return flow
    if least.alpha >= flow[0].alpha:
        return flow
    crushes = with_dilation(program, psi)
    ended, _ = interior.run(crushes, closed.layout, flowing_iterate(program, least).warm(crushes), ACCEPTED)
    found = interior.solution(crushes, ended)
    good = found.certificate.worst(crushes.step) <= GOOD and found.alpha <= least.alpha
    return found if good else least, central, psi


def _associative(closed: ClosedProgram) -> tuple[Solution, float, float]:
    """Return the flow of the associative law, its multiplier and its dilation."""
    found, _ = solve(with_dilation(closed.program, 1.0), closed.layout)
    return found, found.alpha, 1.0


def _coulomb(closed: ClosedProgram) -> tuple[Solution, float, float]:
    """Return the flow of least multiplier that is found by Coulomb's law, the multiplier of the central one, and ψ."""
    for psi in (0.0, *LIMIT.slight):
        program = with_dilation(closed.program, psi)
        answer = iterated(program, closed.layout)
        if answer is not None and (worst := answer[0].certificate.worst(program.step)) <= USABLE:
            central, iterate = answer
            if central.alpha < 0.0:  # joints that a settlement has let slide may go on without a push
                continue
            if worst > GOOD:  # no flow has more than the associative law (Radenković)
                bound = _associative(closed)
                return bound if central.alpha > bound[1] else (central, central.alpha, psi)
            if psi > 0.0 or len(program.places) > LIMIT.most_joints:
                return central, central.alpha, psi
            return _least(program, closed.layout, central, iterate) or central, central.alpha, 0.0
        if psi == 0.0 and len(program.places) <= LIMIT.most_joints:  # the central flow is one of many
            found = _least(program, closed.layout, None, None)
            if found is not None:
                return found, found.alpha, 0.0
    return _associative(closed)


def _least(
    program: Program, layout: Elimination, central: Solution | None, iterate: Iterate | None
) -> Solution | None:
    """Return the flow of least multiplier that is found, from the central one, other mechanisms and other frictions.

    By Coulomb's law mechanisms do not depend on frictions: forces of the program that vanish at the gaps and slips of
    any mechanism, whatever its frictions, are with it one of its flows. Of the mechanisms that fit the forces in the
    end, that of least gaps and slips is taken. None where no flow is found, and the central one is not given.
    """
    from mechanics.solvers import lp_highs, qp_piqp  # late: with them comes scipy.optimize

    none, chance = LIMIT.idle * program.weight, np.random.default_rng(0)
    if central is None or iterate is None:
        others = (_of_other_frictions(program, layout, chance) for _ in range(LIMIT.tries // LIMIT.turn))
        begun = next((other for other in others if other is not None), None)
        if begun is None:
            return None
        displacement, flowing = begun
    else:
        room = margins(program, central.forces)
        displacement, flowing = central.displacement, flows_at(program, central.forces, iterate.gaps)
        if not (flowing[:, 2:].any(axis=1) & (room[:, :2].max(axis=1) > none)).any():
            return central  # what only turns has one multiplier
    best, tries, form = central, 0, qp_piqp.StandardForm.of(program)
    least = cache(lambda bits: lp_highs.least_multiplier(form, np.frombuffer(bits, bool).reshape(-1, 4)))
    while tries <= min(LIMIT.tries, LIMIT.tried // len(flowing)):
        answer, other, tries = least(flowing.tobytes()), None, tries + 1
        if answer is not None:
            found = Solution(*answer, displacement, certify(program, *answer, displacement))
            less = best is None or found.alpha < best.alpha - GOOD * max(1.0, abs(best.alpha))
            if less and found.certificate.worst(program.step) <= GOOD:
                best, tries = found, 0
            if tries % LIMIT.turn == 0:
                room = margins(program, answer[0])
                weights = chance.uniform(LIMIT.idle, 1.0, room.shape) ** 2 if tries else np.ones_like(room)
                other = lp_highs.mechanism_of(program, room <= none, weights)
        displacement, flowing = (
            other or _of_other_frictions(program, layout, chance) or (displacement, flowing)
        )
    if best is None or best is central:
        return best
    room = margins(program, best.forces)
    plain = lp_highs.mechanism_of(program, room <= none, np.ones_like(room))
    if plain is None:
        return best
    certificate = certify(program, best.forces, best.alpha, plain[0])
    good = certificate.worst(program.step) <= GOOD
    return replace(best, displacement=plain[0], certificate=certificate) if good else best


def _of_other_frictions(
    program: Program, layout: Elimination, chance: np.random.Generator
) -> tuple[Array, Mask] | None:
    """Return displacements (m,), gaps and slips (j, 4) of the central flow with frictions changed by chance."""
    law = program.law.copy()
    law[:, FRICTION] = np.minimum(law[:, FRICTION], STEEP)
    law[:, FRICTION] *= 1.0 + LIMIT.other * chance.uniform() * chance.uniform(-1.0, 1.0, len(law))
    other = replace(program, law=law)
    answer = iterated(other, layout)
    if answer is None or answer[0].certificate.worst(program.step) > GOOD:
        return None
    central, iterate = answer
    return central.displacement, flows_at(other, central.forces, iterate.gaps)


@dataclass(frozen=True, eq=False)
class Hinges:
    """Hinges, sliding joints and moving weight of a mechanism.

    `points` (h, 2) m: centres of pressure of the joints that carry and turn, in the state; hinges closer than a
    block count as one. `sliding`: joints that carry and slip; `moving_weight` kN.
    """

    points: Array
    sliding: Index
    moving_weight: float


def hinges(model: Assembly, contacts: Contacts, state: State, mechanism: Array, forces: Array) -> Hinges:
    """Return hinges and sliding joints of virtual displacements (b, 3) under joint forces N, P, T (j, 3).

    Relative motions below a fiftieth of the largest motion of a block do not count, nor do joints that carry next to
    nothing.
    """
    places = contacts.places(state.positions)
    moved = np.concatenate([mechanism[contacts.a], mechanism[contacts.b]], axis=1)
    slip = abs(relative_motion(places, moved)[:, 2])
    turn = abs(mechanism[contacts.a, 2] - mechanism[contacts.b, 2])
    carries = (forces[:, 0] > CARRYING * model.weight) & (places[:, H] > 0.0) & ~contacts.ties
    hinged = np.flatnonzero(carries & (turn > NOTICEABLE * float(abs(mechanism[:, 2]).max())))
    slides = np.flatnonzero(carries & (slip > NOTICEABLE * float(abs(mechanism[:, :2]).max())))
    moves = model.taking_part(mechanism)
    centre = pressure_centres(contacts.take(hinged), state.positions, forces[hinged])
    weight = -float(model.dead_load[moves, 1].sum())
    return Hinges(_merged(centre, turn[hinged], model.size), slides, weight)


def pressure_centres(contacts: Contacts, positions: Array, forces: Array) -> Array:
    """Return where forces N, P, T (j, 3) act in a configuration (j, 2), m; for a joint without force its middle."""
    low, high = end_points(contacts, positions).transpose(1, 0, 2)
    half = np.maximum(contacts.places(positions)[:, H], 1e-300)
    eccentricity = np.where(forces[:, 0] > 0.0, forces[:, 1] / np.maximum(forces[:, 0], 1e-300), 0.0)
    share = np.clip(eccentricity / half, -1.0, 1.0)[:, None]
    centre: Array = 0.5 * ((1.0 - share) * low + (1.0 + share) * high)
    return centre


def farthest_corner(model: Assembly, begun: Array, moved: Array, direction: Direction) -> tuple[Array, int]:
    """Return the drawn corner (2,), m, of a movable block that goes farthest along the push, and its block.

    `begun`, `moved` (b, 3): positions between which the blocks go. Of corners that go equally far, to NOTICEABLE,
    it is the highest, of those the foremost. A corner that another block has too is left out, for its block's centroid.
    """
    sense = 1.0 if direction == "+x" else -1.0
    turned = [np.stack([np.cos(at[:, 2]), -np.sin(at[:, 2])]).T for at in (begun, moved)]
    found = []
    for k in map(int, np.flatnonzero(model.movable)):
        block = model.blocks[k]
        points = np.vstack([block.polygon, block.centroid])
        way = moved[k, 0] - begun[k, 0] + (points - block.centroid) @ (turned[1][k] - turned[0][k])
        found.append(np.column_stack([sense * way, points, np.full(len(points), k)]))
    way, x, z, owner = np.vstack(found).T
    far = way / max(float(way.max()), 1e-300)
    order = np.lexsort((-sense * x, -z, -np.where(far > 1.0 - NOTICEABLE, 1.0, far)))
    of = (k for k in order if model.block_at((x[k], z[k])) == owner[k])
    best = next(of, order[0])
    point = np.array([x[best], z[best]])
    return point, model.block_at(point)


def _merged(points: Array, turn: Array, distance: float) -> Array:
    """Return the points (h, 2) m; of points closer than a distance (m) only the one that turns most is kept."""
    kept: list[Array] = []
    for k in np.argsort(-turn, kind="stable"):
        if all(np.hypot(*(points[k] - other)) > distance for other in kept):
            kept.append(points[k])
    return np.array(kept, dtype=float).reshape(-1, 2)


def friction_work(contacts: Contacts, state: State, mechanism: Array, forces: Array) -> float:
    """Return Σ T v (kNm) of virtual displacements (b, 3) under joint forces N, P, T (j, 3): joints that slide take it.

    By Coulomb's law; by the associative one N gives it back as they lift.
    """
    moved = np.concatenate([mechanism[contacts.a], mechanism[contacts.b]], axis=1)
    slip = relative_motion(contacts.places(state.positions), moved)[:, 2]
    return float(abs(forces[:, 2] * slip)[~contacts.ties].sum())


def virtual_work_multiplier(
    model: Assembly, mechanism: Array, direction: Direction, taken: float = 0.0
) -> float:
    """Return α = (W − f_Dᵀδ)/f_Lᵀδ of virtual displacements δ (b, 3); W (kNm): what friction and ties take.

    Infinite or NaN where the lateral load f_L does no work on δ.
    """
    moved = np.where(model.movable[:, None], mechanism, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        done = np.float64(taken) - (model.dead_load * moved).sum()
        return float(done / (model.lateral_load(direction) * moved).sum())
