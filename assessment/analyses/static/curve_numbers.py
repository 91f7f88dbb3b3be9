"""The numbers of a pushover curve as results.json has them: rigid with its mechanism, and elastic."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from assessment.analyses.static.local_loss import local_loss
from assessment.analyses.static.paths import configuration
from assessment.ntc.capacity import mechanism_participation
from assessment.ntc.curve_fit import CapacityError
from assessment.results.faces import Met
from assessment.results.table import sense
from mechanics import Assembly, State
from mechanics.model import Direction
from mechanics.procedures import Pushover, hinges, limit_in, virtual_work_multiplier
from mechanics.steps import Sliding

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from assessment.project.schema import ControlTable

STILL = 1e-6  # of the largest virtual displacement: a control point that moves less takes no part
OTHER_LAW: dict[Sliding, Sliding] = {"associative": "coulomb", "coulomb": "associative"}
LIFTED = 1.0  # of the largest virtual displacement: more lift is left in no flow that follows Coulomb's law
DIFFERS = 0.01  # relative difference of the other friction law's multiplier from which it is reported


def rigid_numbers(
    model: Assembly, control: ControlTable, direction: Direction, path: Pushover, met: Met
) -> dict[str, Any]:
    """Return the numbers of a rigid curve; the mechanism is that at the point of α0 (C8.7.1.2).

    Pairs of faces that slide in the mechanism although they did not touch as drawn are added to `met`.
    """
    at = path.states[path.formed]
    mechanism, control_dx = _scaled(model, control, at, path.mechanism)
    found = hinges(model, path.contacts, at, mechanism, path.forces)
    slides = np.isin(np.arange(len(path.contacts)), found.sliding)
    return {
        "alpha_0": float(path.multiplier[path.peak]),
        "alpha_onset": float(path.multiplier[0]),
        # if equilibrium is lost before α = 0 the capacity ends there; a path that was cut short has no d_0
        "d_0_m": float(path.displacement[-1]) if path.reached_zero or path.lost else None,
        "reached_zero": path.reached_zero,
        "lost": path.lost,
        "end": path.end,
        "local_loss": local_loss(model, path.states, path.displacement, path.forces, path.lost),
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


def elastic_numbers(model: Assembly, direction: Direction, path: Pushover) -> dict[str, Any]:
    """Return the numbers of an elastic curve: its peak (α_u at d_u, m) and its end."""
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


def other_law(model: Assembly, sliding: Sliding, direction: Direction, path: Pushover) -> dict[str, float]:
    """Return the multiplier by the other law of friction at the peak where it differs by more than DIFFERS.

    With Coulomb friction a multiplier is not unique: `sliding_residual` is the lift that is left, and beyond LIFTED the
    flow is none of Coulomb's law, and its multiplier none either.
    """
    at, other = path.states[path.peak], OTHER_LAW[sliding]
    found = {law: limit_in(model, direction, at, law) for law in OTHER_LAW}
    alpha = float(path.multiplier[path.peak])
    if abs(found[other].alpha - alpha) <= DIFFERS * alpha:
        return {}
    residual = found["coulomb"].residual
    if other == "coulomb" and residual > LIFTED:
        return {"sliding_residual": residual}
    return {f"alpha_0_{other}": found[other].alpha, "sliding_residual": residual}


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
) -> dict[str, float | None]:
    try:
        part = mechanism_participation(model, mechanism, control_dx)
    except CapacityError:  # the capacity is refused later, with its reason
        return {"e_star": None, "gamma_star": None}
    return {"e_star": part.e_star, "gamma_star": part.gamma_star}


def _curve(path: Pushover, direction: Direction) -> dict[str, list[float]]:
    """Return the points of a curve; displacements (m) are along x: towards −x they are negative."""
    along_x = sense(direction) * path.displacement + 0.0  # + 0.0: no −0.0
    return {"displacement_m": along_x.tolist(), "multiplier": path.multiplier.tolist()}
