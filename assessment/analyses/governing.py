"""Ensembles of a state, and the run that counts in each direction: curves, mechanism and capacity all of one run.

A path on which joints slide or a part jumps depends on the last digits of its input. Such a state is settled and pushed
over again, with other increments and with corners moved by a ten-millionth of their block. If the first such member
agrees with the state itself, nothing scatters and no other member is run. Ranges stand beside the governing run.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any, TypeVar

import numpy as np

from assessment.analyses.capacity import Assessed, refused, towards
from assessment.analyses.found import Found, in_increments
from assessment.analyses.states import Request, StateResult, analyse_states, curves
from assessment.results.schema import Direction, Part, StateResults, known
from assessment.results.schema.static import Behaviour, ElasticPush, Pushovers, RigidPush
from assessment.results.table import cells, indices
from assessment.runtime.tasks import Workers
from mechanics import Assembly
from mechanics.messages import Message, headed, message

QUANTITIES = ("alpha_0", "d_0_m", "alpha_u")  # of a curve

Members = dict[str, list[list[StateResult]]]


@dataclass(frozen=True, slots=True)
class EnsembleTolerances:
    """How members differ, when their results are the same, and what their range says."""

    # of the project, of the first and the last member, what another user might have chosen; the first is the cheapest
    increments: tuple[float, float] = (2.0, 0.5)
    noise: float = 1e-7  # of a block's size, by which its corners are moved
    agree: float = 1e-3  # relative difference of two results that are the same
    # of five runs of one normal distribution a sixth lies within the range with 95 %, without this with two in three
    wider: float = 0.8  # of the span of the runs, by which their range is wider on either side


ENSEMBLE = EnsembleTolerances()


def members(requests: Sequence[Request], found: Sequence[StateResult], workers: Workers) -> Members:
    """Return the further members of the ensembles of states that scatter, results under every behaviour by state."""
    own = {(result.state, result.behaviour): result for result in found}
    suspected = {result.state for result in found if result.scatters}
    together = [request for request in requests if request.project.scatter > 1 and request.state in suspected]
    first = _follow(together, (0,), workers)
    scattering = {
        state
        for state, ((*results,),) in first.items()
        if any(apart(own[state, result.behaviour], result) for result in results)
    }
    together = [request for request in together if request.state in scattering]
    rest = range(1, together[0].project.scatter - 1) if together else ()
    others = _follow(together, rest, workers)
    return {state: first[state] + others.get(state, []) for state in first if state in scattering}


def apart(one: StateResult, other: StateResult) -> bool:
    """Whether two members differ in a quantity of their paths."""
    values, others = dict(quantities(one)), dict(quantities(other))
    if values.keys() != others.keys():
        return True
    return any(
        (a is None) != (b is None)
        or (a is not None and b is not None and abs(a - b) > ENSEMBLE.agree * abs(a))
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


def _follow(requests: Sequence[Request], numbers: Sequence[int], workers: Workers) -> Members:
    """Return the results of requests as members of those numbers, computed side by side."""
    if not requests or not numbers:
        return {}
    factors = np.geomspace(*ENSEMBLE.increments, max(requests[0].project.scatter - 1, 2))
    shaken = {  # a state and its strengthening settle as one
        (model, number): shaken_corners(model, number)
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


def shaken_corners(model: Assembly, seed: int) -> Assembly:
    """Return the assembly with corners of movable blocks moved at random by their `noise`; its joints stay."""
    drawn, still = _faces(model), set[int]()
    while True:
        random, blocks = np.random.default_rng(seed), []
        for number, block in enumerate(model.blocks):
            if block.support is None:
                corners, size = block.polygon, np.ptp(block.polygon, axis=0).max()
                moved = corners + ENSEMBLE.noise * size * random.uniform(-1.0, 1.0, corners.shape)
                block = block if number in still else replace(block, vertices=moved)  # noqa: PLW2901
            blocks.append(block)
        found = replace(model, blocks=blocks)
        if not (others := (_faces(found) - drawn) | (drawn - _faces(found))):
            return found
        still.update(number for pair in others for number in pair)


def _faces(model: Assembly) -> Counter[tuple[int, int]]:
    return Counter(zip(model.joints.a.tolist(), model.joints.b.tolist(), strict=True))


Run = Sequence[StateResult]
"""One run of a state: its results by contact behaviour."""
Assess = Callable[[Mapping[Direction, Pushovers]], Mapping[Direction, Found[Assessed]]]
Ranged = TypeVar("Ranged", bound=Part)
CHECKED = ("a_g_g", "zeta_E")


def governed(
    name: str, state: StateResults, runs: Sequence[Run], assess: Assess
) -> tuple[StateResults, list[Message], dict[Direction, Run]]:
    """Return a state with, in each direction, curves, mechanism and capacity of its governing run, and their ranges.

    Behind it what is to be told of it, and by direction the run that its curves are of. `runs`: that of the project,
    then those of its ensemble. `members` of a curve: the curves of the other runs. A movement is that of the run with
    the least ultimate one.
    """
    warnings: list[Message] = []
    governing: dict[Direction, Run] = {}
    pushdown = {}
    for own in runs[0]:
        same = (stage.moved for run in runs for stage in run if stage.behaviour == own.behaviour)
        moves = [moved for moved in same if moved is not None and moved.value is not None]
        if moves:
            paths = [known(each.value).path for each in moves]
            ends = [inf if path.ultimate_movement_m is None else path.ultimate_movement_m for path in paths]
            least = moves[ends.index(min(ends))]
            path = known(least.value).path
            pushdown[own.behaviour] = _ranged(path, ("ultimate_movement_m",), paths, len(runs))
            warnings.extend(least.warnings)
    pushover, capacity = {}, {}
    by_run = [curves(run) for run in runs]
    for direction in dict.fromkeys(way for stage in runs[0] for way in stage.pushed):
        pushed = [k for k, each in enumerate(by_run) if direction in each] if direction in by_run[0] else []
        followed = [by_run[k][direction] for k in pushed]
        checked = [assess({direction: each}).get(direction, Found[Assessed]()) for each in followed]
        number = _least_capacity(followed, checked) if pushed else 0
        run = governing[direction] = runs[pushed[number]] if pushed else runs[0]
        pushes = [stage.pushed[direction] for stage in run if direction in stage.pushed]
        warnings.extend(text for each in pushes for text in each.warnings)
        if not pushed:
            continue
        value = checked[number].value
        pushover[direction] = chosen = value.curves if value else followed[number]
        if len(runs) > 1:  # with the ranges of all runs, and the curves of the others
            with_ranges: dict[Behaviour, RigidPush | ElasticPush] = {}
            for behaviour, curve in chosen.by_contacts.items():
                of = {k: push for k, each in enumerate(followed) if (push := each.by_contacts.get(behaviour))}
                curve = curve.replace(members=[each.curve for k, each in of.items() if k != number])  # noqa: PLW2901
                with_ranges[behaviour] = _ranged(curve, QUANTITIES, list(of.values()), len(runs))
            pushover[direction] = chosen.replace(**with_ranges)
        if value is not None:
            others = [each.value.capacity.checks for each in checked if each.value]
            checks = {}
            for check, own_check in value.capacity.checks.items():
                ranged = _ranged(own_check, CHECKED, [x[check] for x in others if check in x], len(runs))
                low = ranged.zeta_E_range[0] if ranged.zeta_E_range else None
                if ranged.verified and low is not None and low < 1.0:  # the whole range is to be
                    ranged = ranged.replace(verified=None)
                checks[check] = ranged
            capacity[direction] = value.capacity.with_checks(checks)
        notes = [*_refusals(checked, len(runs)), *checked[number].warnings]
        told = (towards(direction, note) for note in notes)
        warnings += [message("{state}: {text}", state=name, text=text) for text in told]
    if len(runs) > 1:
        notes = [message(
            "joints slide, or a part moves by itself: {count} runs with other increments and corners moved by a "
            "ten-millionth of their block give the ranges; all numbers are those of the run with the least capacity",
            count=len(runs),
        )]  # fmt: skip
        if failed := [stage for run in runs[1:] for stage in run if stage.failures]:
            text = failed[0].failures[0]
            said = message("in {count} of the runs of the ensemble: {text}", count=len(failed), text=text)
            notes.append(said)
        warnings.extend(headed(message("{state}", state=name), note) for note in notes)
    made = state.replace(pushdown=pushdown, pushover=pushover, capacity=capacity)
    return made, warnings, governing


def _least_capacity(runs: Sequence[Pushovers], checked: Sequence[Found[Assessed]]) -> int:
    """Return the number of the run with the least index ζ_E at SLV and SLC, or ratio where neither was checked.

    Without any, that with the least α0 (where no run has rigid joints α_u); of several that agree in it, the least d_0.
    A rigid curve without d_0 may have been cut short: it does not govern where another has one.
    """
    ratios = [each.value.capacity.ratios if each.value else {} for each in checked]
    least = [min((indices(each) or each).values(), default=inf) for each in ratios]
    if min(least) < inf:
        return least.index(min(least))
    rigid = [each.rigid for each in runs]
    alpha = [each.alpha_0 if each else inf for each in rigid]
    if not any(rigid):
        alpha = [each.elastic.alpha_u if each.elastic else inf for each in runs]
    d_0 = [inf if each is None or each.d_0_m is None else each.d_0_m for each in rigid]
    if min(d_0) < inf:
        alpha = [inf if far == inf else each for each, far in zip(alpha, d_0, strict=True)]
    agreeing = [k for k, each in enumerate(alpha) if each <= min(alpha) * (1.0 + ENSEMBLE.agree)]
    return min(agreeing, key=lambda k: d_0[k])


def _ranged(part: Ranged, names: Sequence[str], runs: Sequence[Part], count: int) -> Ranged:
    """Return the part with the range of each of its quantities, in which another choice of increments is expected.

    It is wider than the span of the runs, not below zero, and open above where a run has no value. It begins at zero
    where not all of the `count` runs have the part: nothing is known of what the others bear. One run has no range.
    """
    if count == 1:
        return part
    ranges: dict[str, Any] = {}
    for name in names:
        values = [getattr(each, name) for each in runs if name in each.model_fields_set]
        known = [value for value in values if value is not None]
        if name in part.model_fields_set and known:
            more = ENSEMBLE.wider * (max(known) - min(known))
            above = max(known) + more if len(known) == len(values) else None
            low = max(0.0, min(known) - more) if len(runs) == count else 0.0
            ranges[f"{name}_range"] = [low, above]
    return part.replace(**ranges)


def _refusals(checked: Sequence[Found[Assessed]], runs: int) -> Iterator[Message]:
    """Yield why a direction has no capacity: of an ensemble once for each kind of reason, with how many runs it has."""
    reasons: dict[str, list[Message]] = {}
    for reason in (reason for each in checked for reason in each.failures):
        reasons.setdefault(reason.template, []).append(reason)
    for same in reasons.values():
        count, reason = len(same), same[0]
        yield refused(reason) if runs == 1 else message(
            "no capacity in {count} of {runs} runs: {reason}", count=count, runs=runs, reason=reason
        )  # fmt: skip
