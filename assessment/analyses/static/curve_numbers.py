"""A pushover curve as results.json has it: rigid with its mechanism, and elastic."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from assessment.analyses.static.paths import configuration, local_loss
from assessment.ntc.capacity.curve import mass_share, mechanism_participation
from assessment.ntc.capacity.curve_fit import CapacityError, yield_point
from assessment.results.configurations.faces import Met
from assessment.results.configurations.frames import pushover_frames
from assessment.results.configurations.ties import along_path, determined, lengthenings, tensions, yielding
from assessment.results.plain import finite
from assessment.results.schema.static import Curve, ElasticPush, Mechanism, OtherLaw, RigidPush
from assessment.results.table import sense
from mechanics import Assembly, ConvergenceError, NoEquilibriumError, State
from mechanics.model import Contacts, Direction
from mechanics.procedures import Pushover, hinges, limit_in, virtual_work_multiplier
from mechanics.steps import Sliding

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from assessment.project.schema import ControlTable

STILL = 1e-6  # of the largest virtual displacement: a control point that moves less takes no part
DIFFERS = 0.01  # relative difference of the other friction law's multiplier from which it is reported


def rigid_push(
    model: Assembly, control: ControlTable, sliding: Sliding, direction: Direction, path: Pushover
) -> RigidPush:
    """Return a rigid curve; the mechanism is that at the point of α0 (C8.7.1.2).

    With the multiplier by the other law of friction: of a curve by the associative one where joints slide in it.
    """
    at, met = path.states[path.formed], Met(model)
    point = path.formed
    moving = _Moving(point, float(path.multiplier[point]), at, path.mechanism, path.contacts, path.forces)
    mechanism = _mechanism(model, control, met, moving)
    found = RigidPush(
        alpha_0=float(path.multiplier[path.peak]),
        alpha_onset=float(path.multiplier[0]),
        # if equilibrium is lost before α = 0 the capacity ends there; a path that was cut short has no d_0
        d_0_m=float(path.displacement[-1]) if path.reached_zero or path.lost else None,
        reached_zero=path.reached_zero,
        lost=path.lost,
        end=path.end,
        sliding=sliding,
        local_loss=local_loss(model, path.states, path.displacement, path.forces, path.lost),
        curve=_curve(path, direction),
        d_star_m=_way_of_blocks(model, direction, path, mechanism),
        mechanism=mechanism,
        virtual_work_alpha=finite(_virtual_work(model, direction, path, np.array(mechanism.displacements))),
        mechanism_configuration=configuration(model, at),
        final_configuration=configuration(model, path.states[-1]),
        frames=pushover_frames(model, path, met),
    )
    if path.formed:
        first = limit_in(model, direction, path.states[0], sliding)
        begins = float(path.multiplier[0])
        moving = _Moving(0, begins, path.states[0], first.mechanism, first.contacts, first.forces)
        found = found.replace(onset=_mechanism(model, control, met, moving))
    carried = [*([None] * (len(path.states) - len(path.steps))), *(step.forces for step in path.steps)]
    carried[path.formed] = path.forces
    moved = list(np.diff([state.positions for state in path.states], axis=0))
    moved = [*(moved[:1] or [path.mechanism]), *moved]
    moved[path.formed] = path.mechanism
    if ties := along_path(model, carried, path.formed, None, determined(model, moved)):
        found = found.replace(ties=ties)
    # by Coulomb's law a joint that opens may slip more than it opens, and not be one that slides
    slides = mechanism.sliding_joints or (found.onset and found.onset.sliding_joints)
    if (slides or sliding == "coulomb") and (
        other := _other_law(found, model, control, direction, path, met)
    ):
        found = found.replace(other_law=other)
    return found


def elastic_push(model: Assembly, sliding: Sliding, direction: Direction, path: Pushover) -> ElasticPush:
    """Return an elastic curve: its peak (α_u at d_u, m), its yield point and its end.

    A check against the standard replaces the yield point by that of the capacity curve that it fits.
    """
    yields = _yield_point(path)
    found = ElasticPush(
        alpha_u=float(path.multiplier[path.peak]),
        d_u_m=float(path.displacement[path.peak]),
        peak=path.peak,
        alpha_y=yields[1] if yields else None,
        d_y_m=yields[0] if yields else None,
        end=path.end,
        reached_zero=path.reached_zero,
        lost=path.lost,
        sliding=sliding,
        curve=_curve(path, direction),
        rest_configuration=configuration(model, path.states[0]),
        peak_configuration=configuration(model, path.states[path.peak]),
        frames=pushover_frames(model, path, Met(model)),
    )
    carried = [step.forces for step in path.steps]
    ties = along_path(model, carried, path.peak, carried[0])
    return found.replace(ties=ties) if ties else found


def _yield_point(path: Pushover) -> tuple[float, float] | None:
    """Return d_y (m) and α_y of an elastic curve; None where the control point does not advance as the load grows."""
    try:
        return yield_point((path.displacement, path.multiplier))
    except CapacityError:
        return None


class _Moving(NamedTuple):
    """What moves at a point of a curve: virtual displacements (b, 3), contacts and the forces (j, 3) in them."""

    point: int
    alpha: float
    at: State
    displacements: NDArray[np.float64]
    contacts: Contacts
    forces: NDArray[np.float64]


def _mechanism(model: Assembly, control: ControlTable, met: Met, moving: _Moving) -> Mechanism:
    """Return a mechanism; pairs of faces that slide in it although they did not touch as drawn are added to `met`."""
    point, alpha, at, moved, contacts, forces = moving
    displacements, control_dx = _scaled(model, control, at, moved)
    found = hinges(model, contacts, at, displacements, forces)
    slides = np.isin(np.arange(len(contacts)), found.sliding)
    e_star, gamma_star = _participation(model, displacements, control_dx)
    return Mechanism(
        point=point,
        alpha=alpha,
        hinges=len(found.points),
        e_star=e_star,
        gamma_star=gamma_star,
        displacements=displacements.tolist(),
        control_displacement_x=control_dx,
        hinge_points_m=model.as_drawn(found.points).tolist(),
        sliding_joints=met.numbers(contacts, slides)[found.sliding].tolist(),
        moving_weight_kN=float(found.moving_weight),
    )


def _way_of_blocks(
    model: Assembly, direction: Direction, path: Pushover, mechanism: Mechanism
) -> list[float] | None:
    """Return d* (k,) m of the blocks that move: ΣPδu/ΣPδ, u how far each has gone since the mechanism formed.

    Of a mechanism that goes on as it begins u = δ d_C, and that is Γ* d_C (C8.7.1.2), as it is taken to be before. None
    where Γ* is not defined.
    """
    if mechanism.gamma_star is None:
        return None
    weighed = model.lateral_load(direction)[:, 0] * np.array(mechanism.displacements)[:, 0]
    x = np.array([state.positions[:, 0] for state in path.states])
    gone = sense(direction) * ((x - x[path.formed]) @ weighed) / float(weighed.sum())
    gone[: path.formed] = mechanism.gamma_star * (
        path.displacement[: path.formed] - path.displacement[path.formed]
    )
    way: list[float] = (mechanism.gamma_star * path.displacement[path.formed] + gone).tolist()
    return way


def _virtual_work(
    model: Assembly, direction: Direction, path: Pushover, mechanism: NDArray[np.float64]
) -> float:
    """Return the multiplier of virtual displacements (b, 3) at α0 by the work of weights, and of ties that yield."""
    by_weights = virtual_work_multiplier(model, mechanism, direction)
    if not model.ties:
        return by_weights
    pulled = tensions(model, path.forces)
    longer = lengthenings(model, path.states[path.formed].positions, mechanism)
    lateral = float((model.lateral_load(direction) * mechanism)[model.movable].sum())
    return by_weights + float(np.where(yielding(model, pulled), pulled, 0.0) @ longer) / lateral


def _other_law(
    found: RigidPush, model: Assembly, control: ControlTable, direction: Direction, path: Pushover, met: Met
) -> OtherLaw | None:
    """Return limit analysis by the other law of friction where the mechanism forms, and at the onset.

    None where the two multipliers differ by less than DIFFERS, or where the other law has no flow.
    """
    law: Sliding = "coulomb" if found.sliding == "associative" else "associative"
    moving = {}
    for point in sorted({path.formed, 0}):
        try:
            limit = limit_in(model, direction, path.states[point], law)
        except (NoEquilibriumError, ConvergenceError):  # the curve has its own multiplier
            return None
        moving[point] = _Moving(
            point, limit.alpha, path.states[point], limit.mechanism, limit.contacts, limit.forces
        )
    own = {0: found.alpha_onset, path.formed: found.mechanism.alpha}
    if all(abs(moving[point].alpha - alpha) <= DIFFERS * abs(alpha) for point, alpha in own.items()):
        return None
    at_peak = moving[path.formed]
    other = OtherLaw(sliding=law, alpha_0=at_peak.alpha, mechanism=_mechanism(model, control, met, at_peak))
    if not path.formed:
        return other
    return other.replace(alpha_onset=moving[0].alpha, onset=_mechanism(model, control, met, moving[0]))


def _scaled(
    model: Assembly, control: ControlTable, at: State, mechanism: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float]:
    """Return virtual displacements (b, 3) scaled to 1 m of the control point along ±x, and its own displacement.

    If the control point takes no part, the largest displacement is 1 m.
    """
    block, fastest = model.block_at(control.point_m), float(abs(mechanism[:, :2]).max())
    small = 1e-6 * model.size / fastest
    shift = model.point_displacement(control.point_m, block, at.positions + small * mechanism)
    rate = float((shift - model.point_displacement(control.point_m, block, at.positions))[0]) / small
    size = abs(rate) if abs(rate) > STILL * fastest else fastest
    return mechanism / size, rate / size


def _participation(
    model: Assembly, mechanism: NDArray[np.float64], control_dx: float
) -> tuple[float | None, float | None]:
    """Return e* and Γ*; None where they are not defined: the capacity is refused later, with its reason."""
    e_star = None
    try:
        e_star = mass_share(model, mechanism)
        return e_star, mechanism_participation(model, mechanism, control_dx).gamma_star
    except CapacityError:
        return e_star, None


def _curve(path: Pushover, direction: Direction) -> Curve:
    """Return the points of a curve; displacements (m) are along x: towards −x they are negative."""
    along_x = sense(direction) * path.displacement + 0.0  # + 0.0: no −0.0
    return Curve(displacement_m=along_x.tolist(), multiplier=path.multiplier.tolist())
