"""Ranges of static results: a path on which joints slide or a part jumps depends on the last digits of its input.

Such a state is settled and pushed over again, with other increments and with corners moved by a ten-millionth of their
block. If the first such member agrees with the state itself, nothing scatters and no other member is run.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from assessment.analyses.static.increments import in_increments
from assessment.analyses.static.states import Request, StateResult, analyse_states
from assessment.results.table import cells
from assessment.runtime.tasks import Workers

if TYPE_CHECKING:
    from mechanics import Assembly

QUANTITIES = ("alpha_0", "d_0_m", "alpha_u")  # of a curve

Members = dict[str, list[list[StateResult]]]


@dataclass(frozen=True, slots=True)
class EnsembleTolerances:
    """How members differ, when their results are the same, and what their range says.

    `increments`: of the project, of the first and the last member, what another user might have chosen; the first is
    the cheapest. `noise`: of a block's size, by which its corners are moved; `agree`: relative difference of two
    results that are the same; `wider`: of the span of the runs, by which their range is wider on either side. Of five
    runs of one normal distribution a sixth then lies within it with 95 %, and without it with two in three.
    """

    increments: tuple[float, float] = (2.0, 0.5)
    noise: float = 1e-7
    agree: float = 1e-3
    wider: float = 0.8


ENSEMBLE = EnsembleTolerances()


def members(
    requests: Sequence[Request],
    found: Sequence[StateResult],
    workers: Workers,
    tolerances: EnsembleTolerances = ENSEMBLE,
) -> Members:
    """Return the further members of each state's ensemble, each with its results under every behaviour.

    A state whose paths do not scatter has none.

    `requests` and the results `found`, in the same order.
    """
    own = {(result.state, result.behaviour): result for result in found}
    suspected = {result.state for result in found if result.scatters}
    together = [request for request in requests if request.project.scatter > 1 and request.state in suspected]
    first = _follow(together, (0,), workers, tolerances)
    scattering = {
        state
        for state, ((*results,),) in first.items()
        if any(apart(own[state, result.behaviour], result, tolerances.agree) for result in results)
    }
    together = [request for request in together if request.state in scattering]
    rest = range(1, together[0].project.scatter - 1) if together else ()
    others = _follow(together, rest, workers, tolerances)
    return {state: first[state] + others.get(state, []) for state in first if state in scattering}


def apart(one: StateResult, other: StateResult, agree: float = ENSEMBLE.agree) -> bool:
    """Whether two members differ in a quantity of their paths, by more than a relative `agree`."""
    values, others = dict(quantities(one)), dict(quantities(other))
    if values.keys() != others.keys():
        return True
    return any(
        (a is None) != (b is None) or (a is not None and b is not None and abs(a - b) > agree * abs(a))
        for a, b in ((values[key], others[key]) for key in values)
    )


def quantities(result: StateResult) -> Iterator[tuple[tuple[str, str], float | None]]:
    """Yield the quantities of a state's paths by direction ("": the settlement) and name."""
    if result.pushdown is not None:
        yield ("", "ultimate_movement_m"), result.pushdown.ultimate_movement_m
    for direction, pushed in result.pushover.items():
        for curve in pushed.by_contacts.values():
            for name, value in cells(curve, QUANTITIES).items():
                yield (direction, name), value


def _follow(
    requests: Sequence[Request], numbers: Sequence[int], workers: Workers, tolerances: EnsembleTolerances
) -> Members:
    """Return the results of requests as members of those numbers, computed side by side."""
    if not requests or not numbers:
        return {}
    factors = np.geomspace(*tolerances.increments, max(requests[0].project.scatter - 1, 2))
    shaken = {  # a state and its strengthening settle as one
        (model, number): shaken_corners(model, number, tolerances.noise)
        for model in dict.fromkeys(request.model.settling for request in requests)
        for number in numbers
    }
    varied = [
        replace(
            request.within(in_increments(request.project, float(factors[number]))),
            model=request.model.varied(shaken[request.model.settling, number]),
            member=number + 2,
        )
        for number in numbers
        for request in requests
    ]
    results = iter(analyse_states(varied, workers, "ensemble"))
    found: Members = {}
    for _ in numbers:
        member: dict[str, list[StateResult]] = {}
        for request in requests:
            member.setdefault(request.state, []).append(next(results))
        for state, each in member.items():
            found.setdefault(state, []).append(each)
    return found


def shaken_corners(model: Assembly, seed: int, noise: float = ENSEMBLE.noise) -> Assembly:
    """Return the assembly with every corner of its movable blocks moved by `noise` of the block, each at random."""
    random = np.random.default_rng(seed)
    blocks = [
        block
        if block.support is not None
        else replace(
            block,
            vertices=block.polygon
            + noise * np.ptp(block.polygon, axis=0).max() * random.uniform(-1.0, 1.0, block.polygon.shape),
        )
        for block in model.blocks
    ]
    return replace(model, blocks=blocks)
