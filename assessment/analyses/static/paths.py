"""The static analyses of one state under one contact behaviour, as plain numbers for results.json."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from assessment.analyses.static.local_loss import local_loss, loss_told
from assessment.ntc.capacity import mechanism_participation
from assessment.ntc.curve_fit import CapacityError
from assessment.results.faces import Met
from assessment.results.frames import pushdown_frames, pushover_frames
from assessment.results.table import sense
from mechanics import (
    Assembly,
    CollapseError,
    ControlError,
    ConvergenceError,
    NoEquilibriumError,
    State,
    UnstableError,
    pushdown,
    pushover,
)
from mechanics.model import Behaviour, Direction
from mechanics.procedures import (
    HALVINGS,
    Mirror,
    Pushdown,
    Pushover,
    hinges,
    limit_in,
    virtual_work_multiplier,
    whole_movement,
)
from mechanics.program import Certificate
from mechanics.steps import Sliding, check_self_weight

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from assessment.project.schema import ControlTable, SettlementTable

STILL = 1e-6  # of the largest virtual displacement: a control point that takes no part in a mechanism
AT_LIMIT = 1e-5  # of the bound on friction: a force nearer to it slides
OTHER_LAW: dict[Sliding, Sliding] = {"associative": "coulomb", "coulomb": "associative"}
DIFFERS = 0.01  # of a multiplier: one by another law of friction that is worth telling
SLIDING_CARRIES = 1e-3  # of the weight of the model: a joint that carries less does not turn a path


@dataclass
class Quality:
    """The worst certificate of the programs solved in a stage."""

    state: str
    stage: str
    solves: int = 0
    worst: Certificate | None = None
    penetration: float = 0.0

    def add(self, path: Pushdown | Pushover) -> None:
        """Take in every step of a path."""
        for certificate in path.certificates:
            self.worst = certificate if self.worst is None else self.worst.joined(certificate)
        self.solves += sum(step.solves for step in path.steps) + len(path.certificates) - len(path.steps)
        self.penetration = max([self.penetration, *(step.penetration for step in path.steps)])

    def numbers(self) -> dict[str, Any]:
        """The row of the results' table."""
        worst = self.worst or Certificate(0.0, 0.0, 0.0, 0.0, 0.0)
        return {
            "state": self.state,
            "stage": self.stage,
            "solves": self.solves,
            "worst_equilibrium_residual": worst.equilibrium,
            "worst_penetration_m": max(worst.penetration, self.penetration),
            "worst_complementarity": worst.complementarity,
            "worst_cone_violation": worst.cone,
        }


@dataclass
class Part:
    """What one static analysis gave: `numbers` for results.json, None where there are none.

    `reached`: the settled state, at rest; None where the structure collapses before. `failures`: what could not be
    completed. `scatters`: whether the path amplifies the last digits of its input.
    """

    numbers: dict[str, Any] | None = None
    reached: State | None = None
    quality: list[dict[str, Any]] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    seconds: float = 0.0
    scatters: bool = False


def stand(model: Assembly) -> str | None:
    """Return why the structure cannot stand under its own weight, None where it can."""
    try:
        check_self_weight(model)
    except UnstableError as error:
        return str(error)
    return None


def settle(
    model: Assembly,
    settlement: SettlementTable,
    behaviour: Behaviour,
    sliding: Sliding,
    control: ControlTable | None,
) -> Part:
    """Move a support as a scenario asks; the path of the control point, if there is one, is followed."""
    began = time.perf_counter()
    result = Part()
    _settle(model, settlement, behaviour, sliding, control, result)
    result.seconds = time.perf_counter() - began
    return result


def push(
    model: Assembly,
    name: str,
    state: State | None,
    behaviour: Behaviour,
    sliding: Sliding,
    directions: tuple[Direction, ...],
    controls: tuple[tuple[ControlTable, ...], ...],
    increment: float,
    until: float,
) -> list[Part]:
    """Push the state of that name over (None: as drawn), by the first control point that moves; see pushover.

    A second direction is that of the mirror image, and so is its curve: model and control points are each other's.
    """
    parts = []
    found: tuple[ControlTable, Pushover] | None = None
    for direction, points in zip(directions, controls, strict=True):
        began = time.perf_counter()
        result, quality = Part(), Quality(name, f"pushover, {behaviour}")
        title = f"{name}, pushover {direction}, {behaviour} contacts"
        # where control points were passed over, that is found and told of each direction
        image = None
        if found is not None and found[0] == controls[0][0]:
            image = mirror_of(model, behaviour).pushover(found[1])
        if image is not None:
            found = points[0], image
        else:
            followed = partial(
                pushover,
                direction=direction,
                contacts=behaviour,
                increment=increment,
                state=state,
                until=until,
                sliding=sliding,
            )
            found = _path(title, model, points, followed, result)
            if found is not None:
                quality.add(found[1])
        if found is not None:
            _curve_followed(title, model, behaviour, sliding, direction, *found, increment, result)
        result.quality.append(quality.numbers())
        result.seconds = time.perf_counter() - began
        parts.append(result)
    return parts


def turns_on_rounding(model: Assembly, path: Pushdown | Pushover) -> bool:
    """Whether a path amplifies the last digits of its input: a joint that carries slides in it, or a part snaps."""
    if len(path.crossed):
        return True
    least = SLIDING_CARRIES * model.weight
    for step in path.steps:
        carries = step.forces[:, 0] > least
        N, T = step.forces[carries, 0], step.forces[carries, 2]
        if (abs(T) >= (1.0 - AT_LIMIT) * step.contacts.friction[carries] * N).any():
            return True
    return False


def mirror_of(model: Assembly, behaviour: Behaviour) -> Mirror:
    """Return the mirror of a model that has one."""
    mirror = Mirror.of(model, behaviour)
    assert mirror is not None
    return mirror


def _settle(
    model: Assembly,
    settlement: SettlementTable,
    behaviour: Behaviour,
    sliding: Sliding,
    control: ControlTable | None,
    result: Part,
) -> None:
    title = f"{settlement.name}, {behaviour} contacts"
    path: Pushdown
    whole = whole_movement(model, settlement.support, settlement.displacement_m, settlement.rotation_rad)
    try:
        path = pushdown(
            model,
            settlement.support,
            settlement.displacement_m,
            settlement.rotation_rad,
            whole / settlement.increments,
            behaviour,
            settlement.to_collapse,
            sliding,
        )
        result.reached = path.final
    except CollapseError as collapse:
        result.failures.append(f"{title}: {collapse}")
        assert isinstance(collapse.path, Pushdown)
        path = collapse.path
    except (UnstableError, ConvergenceError, NoEquilibriumError) as error:
        result.failures.append(f"{title}: {error}")
        return
    if settlement.to_collapse and path.ultimate is None:
        result.warnings.append(f"{title}: no ultimate movement up to {path.movement[-1]:.3g} m ({path.end})")
    result.warnings += crossings(title, path.crossed, whole / settlement.increments)
    result.scatters = turns_on_rounding(model, path)
    quality = Quality(settlement.name, f"pushdown, {behaviour}")
    quality.add(path)
    result.quality.append(quality.numbers())
    lost = local_loss(model, path.states, path.movement, path.steps[0].forces) if path.steps else None
    if lost is not None:
        said = loss_told(lost)
        result.warnings.append(f"{title}: {said}")
    result.numbers = {
        "sliding": sliding,
        "movement_m": path.movement.tolist(),
        "reaction_x_kN": path.reaction[:, 0].tolist(),
        "reaction_z_kN": path.reaction[:, 1].tolist(),
        "ultimate_movement_m": path.ultimate,
        "local_loss": lost,
        "applied_movement_m": whole,
        "end": path.end,
        "configuration": configuration(model, path.final),
        "ultimate_configuration": configuration(model, path.states[-1])
        if path.ultimate is not None
        else None,
        "control_displacement_m": _control_path(model, control, path) if control else None,
        "frames": pushdown_frames(model, path, whole),
    }


def _control_path(model: Assembly, control: ControlTable, path: Pushdown) -> list[list[float]]:
    block = model.block_at(control.point_m)
    start = model.point_displacement(control.point_m, block, path.states[0].positions)
    return [
        (model.point_displacement(control.point_m, block, state.positions) - start).tolist()
        for state in path.states
    ]


def _path(
    title: str,
    model: Assembly,
    controls: tuple[ControlTable, ...],
    followed: Callable[[Assembly, tuple[float, float]], Pushover],
    result: Part,
) -> tuple[ControlTable, Pushover] | None:
    """Return the first control point that moves, and its curve; where there is none `result` says why."""
    for control in controls:
        try:
            return control, followed(model, control.point_m)
        except ControlError as error:
            result.warnings.append(f"{title}: control point {control.name}: {error}")
        except (UnstableError, ConvergenceError, NoEquilibriumError) as error:
            result.failures.append(f"{title}: {error}")
            return None
    result.failures.append(
        f"{title}: no control point takes part in the mechanism; add one on a part that moves"
    )
    return None


def _curve_followed(
    title: str,
    model: Assembly,
    behaviour: Behaviour,
    sliding: Sliding,
    direction: Direction,
    control: ControlTable,
    path: Pushover,
    increment: float,
    result: Part,
) -> None:
    result.warnings += crossings(title, path.crossed, increment)
    result.scatters = turns_on_rounding(model, path)
    rigid = behaviour == "rigid"
    met = Met(model)
    numbers = _rigid(model, control, direction, path, met) if rigid else _elastic(model, direction, path)
    if rigid and numbers["mechanism"]["sliding_joints"]:
        numbers |= _other_law(model, sliding, direction, path)
        if "alpha_0_coulomb" in numbers:
            result.warnings.append(
                f"{title}: with friction that does not lift what slides (Coulomb) α0 is "
                f"{numbers['alpha_0_coulomb']:.4g}, not {numbers['alpha_0']:.4g}"
            )
    result.numbers = {
        "control": control.name,
        "sliding": sliding,
        **numbers,
        "frames": pushover_frames(model, path, met),
    }
    if rigid and numbers["local_loss"] is not None:
        said = loss_told(numbers["local_loss"])
        result.warnings.append(f"{title}: {said}")
    if rigid and path.formed != path.peak:
        result.warnings.append(
            f"{title}: the control point takes no part in the mechanism at α0: displacements, e*, Γ*, forces and hand "
            f"check are those of d = {path.displacement[path.formed]:.4g} m, α = {path.multiplier[path.formed]:.4g}"
        )
    # an elastic curve has served once it is past its peak; a rigid one is the capacity to its end
    if not path.reached_zero and (rigid or path.multiplier[-1] > 0.5 * max(path.multiplier)):
        result.warnings.append(
            f"{title}: ends at d = {path.displacement[-1]:.4g} m, α = {path.multiplier[-1]:.4g}: {path.end}"
        )


def crossings(title: str, crossed: NDArray[np.float64], increment: float) -> list[str]:
    """Warnings of where parts move by themselves (n, 2) m, those that follow each other together.

    What is shorter than 1/32 of the increment (m) is below the accuracy of the path and left out.
    """
    stretches: list[list[float]] = []
    for left, held in np.sort(crossed, axis=1):
        if held - left < 0.99 * increment / 2.0**HALVINGS:
            continue
        if stretches and left <= stretches[-1][1]:
            stretches[-1][1] = max(held, stretches[-1][1])
        else:
            stretches.append([left, held])
    return [
        f"{title}: between d = {left:.4g} and {held:.4g} m a part moves by itself, until others hold it again"
        for left, held in stretches
    ]


def _rigid(
    model: Assembly, control: ControlTable, direction: Direction, path: Pushover, met: Met
) -> dict[str, Any]:
    """The numbers of a rigid curve; those of the mechanism are of its activation: the point of α0 (C8.7.1.2).

    Pairs of faces that slide in the mechanism although they did not touch as drawn are added to `met`.
    """
    at = path.states[path.formed]
    mechanism, control_dx = _scaled(model, control, at, path.mechanism)
    found = hinges(model, path.contacts, at, mechanism, path.forces)
    slides = np.isin(np.arange(len(path.contacts)), found.sliding)
    return {
        "alpha_0": float(path.multiplier[path.peak]),
        "alpha_onset": float(path.multiplier[0]),
        # where equilibrium is lost before α = 0 the capacity ends there; a path that was cut short has no d_0
        "d_0_m": float(path.displacement[-1]) if path.reached_zero or path.lost else None,
        "reached_zero": path.reached_zero,
        "lost": path.lost,
        "end": path.end,
        "local_loss": local_loss(model, path.states, path.displacement, path.forces),
        "curve": _curve(path, direction),
        "mechanism": {
            "point": path.formed,
            "alpha": float(path.multiplier[path.formed]),
            "hinges": len(found.points),
            **_participation(model, mechanism, control_dx),
            "displacements": mechanism.tolist(),
            "control_displacement_x": control_dx,
            "hinge_points_m": found.points.tolist(),
            "sliding_joints": met.numbers(path.contacts, slides)[found.sliding].tolist(),
            "moving_weight_kN": float(found.moving_weight),
        },
        "virtual_work_alpha": virtual_work_multiplier(model, mechanism, direction),
        "mechanism_configuration": configuration(model, at),
        "final_configuration": configuration(model, path.states[-1]),
    }


def _other_law(model: Assembly, sliding: Sliding, direction: Direction, path: Pushover) -> dict[str, float]:
    """Return the multiplier by the other law of friction at the peak where it differs by more than DIFFERS.

    With Coulomb friction a multiplier is not unique: `sliding_residual` tells how far its lift is from settled.
    """
    at, other = path.states[path.peak], OTHER_LAW[sliding]
    found = {law: limit_in(model, direction, at, law) for law in OTHER_LAW}
    alpha = float(path.multiplier[path.peak])
    if abs(found[other].alpha - alpha) <= DIFFERS * alpha:
        return {}
    return {f"alpha_0_{other}": found[other].alpha, "sliding_residual": found["coulomb"].residual}


def _scaled(
    model: Assembly, control: ControlTable, at: State, mechanism: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float]:
    """Return virtual displacements (b, 3) that move the control point by 1 m along x, either way, and its own.

    Where the control point takes no part, the largest one is 1 m.
    """
    block, fastest = model.block_at(control.point_m), float(abs(mechanism[:, :2]).max())
    small = 1e-6 * model.size / fastest
    shift = model.point_displacement(control.point_m, block, at.positions + small * mechanism)
    rate = float((shift - model.point_displacement(control.point_m, block, at.positions))[0]) / small
    size = abs(rate) if abs(rate) > STILL * fastest else fastest
    return mechanism / size, rate / size


def _participation(
    model: Assembly, mechanism: NDArray[np.float64], control_dx: float
) -> dict[str, float | None]:
    try:
        part = mechanism_participation(model, mechanism, control_dx)
    except CapacityError:  # said again, with its reason, where the capacity is asked for
        return {"e_star": None, "gamma_star": None}
    return {"e_star": part.e_star, "gamma_star": part.gamma_star}


def _elastic(model: Assembly, direction: Direction, path: Pushover) -> dict[str, Any]:
    return {
        "alpha_u": float(path.multiplier[path.peak]),
        "d_u_m": float(path.displacement[path.peak]),
        "peak": path.peak,
        "alpha_y": None,
        "d_y_m": None,
        "end": path.end,
        "reached_zero": path.reached_zero,
        "lost": path.lost,
        "curve": _curve(path, direction),
        "rest_configuration": configuration(model, path.states[0]),
        "peak_configuration": configuration(model, path.states[path.peak]),
    }


def _curve(path: Pushover, direction: Direction) -> dict[str, list[float]]:
    """The points of a curve; displacements along x, as everywhere in the results: towards −x they are negative."""
    along_x = sense(direction) * path.displacement + 0.0  # + 0.0: no −0.0
    return {"displacement_m": along_x.tolist(), "multiplier": path.multiplier.tolist()}


def configuration(model: Assembly, state: State) -> list[list[float]]:
    """Displacements and rotation (b, 3) of the blocks from the drawing."""
    moved: NDArray[np.float64] = state.positions - model.initial.positions
    rows: list[list[float]] = moved.tolist()
    return rows
