"""Where a capacity curve begins: a mechanism at its onset, or elastic rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechanics.assembly import Assembly, Direction, State
from mechanics.equilibrium import check_self_weight, rest, rest_size
from mechanics.errors import NoEquilibriumError, UnstableError
from mechanics.limit import limit_analysis
from mechanics.program import Certificate
from mechanics.relaxation import come_to_rest
from mechanics.static_step import Step, find_step
from mechanics.types import Array

FIRST = 0.02  # of the rigid multiplier: the first step of an elastic curve
SETTLED_FIRST = 0.1  # of an increment: the first step from a settled state, whose open hinges may close first
SOFT = 1e-2  # of the block size: a compression at which shears on the two faces of a joint carry moments


@dataclass(frozen=True, eq=False)
class Onset:
    """A curve's first point: its state, multiplier, contact forces (c, 2) kN and certificate.

    `step`: the equilibrium behind it (rigid: none); `rate` (b, 3): displacements per unit work with which the
    structure leaves it; `share`: how much of an increment the first step is.
    """

    state: State
    step: Step | None
    alpha: float
    forces: Array
    certificate: Certificate
    rate: Array
    share: float


def mechanism_onset(model: Assembly, direction: Direction, state: State | None) -> Onset:
    """The onset of a rigid curve: the mechanism of limit analysis, which see for the errors raised."""
    limit = limit_analysis(model, direction, state)
    rate = limit.mechanism / float((model.lateral_load(direction) * limit.mechanism).sum())
    share = 1.0 if state is None else SETTLED_FIRST
    return Onset(state or model.initial, None, limit.alpha, limit.forces, limit.certificate, rate, share)


def elastic_onset(model: Assembly, direction: Direction, state: State | None, increment: float) -> Onset:
    """The onset of an elastic curve: rest, and the displacements of a small load; `increment` (m) of its steps.

    Raises UnstableError.
    """
    start = settled(model, state)
    lateral = model.lateral_load(direction)
    try:
        alpha = FIRST * limit_analysis(model, direction).alpha
    except NoEquilibriumError:  # interlocked rigid blocks have no multiplier to go by
        alpha = FIRST
    size = rest_size(model, "elastic")
    load = model.dead_load + alpha * lateral
    try:
        begun = find_step(model, "elastic", start.state, start.state.positions, load, size, last=start)
    except NoEquilibriumError as stop:
        if state is not None:
            raise
        raise no_way_from_rest(str(stop)) from stop
    moved = begun.state.positions - start.state.positions
    share = min(1.0, float(abs(moved[:, :2]).max()) / increment)
    rate = moved / float((lateral * moved).sum())
    return Onset(start.state, start, 0.0, start.forces, start.certificate, rate, share)


def no_way_from_rest(why: str) -> UnstableError:
    """The refusal of a structure that stands on elastic joints, but from whose rest no path leads."""
    return UnstableError(
        f"with elastic joints no equilibrium leads away from rest: {why}; joints too soft to keep the structure "
        "upright (check normal_stiffness, in kN/m³), or the increment is too large"
    )


def settled(model: Assembly, state: State | None) -> Step:
    """Elastic rest under gravity from a state (default: as drawn).

    Raises UnstableError where there is none, or where joints as drawn are too soft to be small beside the blocks.
    """
    check_self_weight(model)
    try:
        step = come_to_rest(model, rest(model, "elastic", model.starting(state)))
    except NoEquilibriumError as fall:
        raise UnstableError(
            f"with elastic joints the structure cannot stand under its own weight: {fall}"
        ) from fall
    joints = model.elastic_contacts
    compression = step.forces[:, 0] / joints.stiffness[:, 0]
    worst = int(np.argmax(compression))
    if state is None and compression[worst] > SOFT * model.size:
        first, second = sorted((int(joints.a[worst]), int(joints.b[worst])))
        raise UnstableError(
            f"gravity alone presses blocks {first} and {second} {compression[worst]:.3g} m into each other, more than "
            "a hundredth of a block: their joints are too soft; check normal_stiffness, in kN/m³"
        )
    return step
