"""The states of a campaign: each movement by each of its shares, settled, at rest, and what the static check gives."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from assessment.analyses.checks.capacity import assess
from assessment.analyses.dynamic.inputs import ultimates
from assessment.analyses.dynamic.time_history import Start
from assessment.analyses.static.states import Request, StateResult, analyse_states
from assessment.ntc.spectrum import ElasticSpectrum, Spectrum
from assessment.project.schema import ORIGINAL
from assessment.studies.increments import refined
from assessment.studies.scenarios import part
from assessment.studies.variants import (
    Demands,
    Numbers,
    Study,
    behaviours,
    capacity_numbers,
    quantity,
    quoted_limit_state,
)
from mechanics.procedures import whole_movement

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.schema import CampaignTable, SettlementTable
    from assessment.runtime.tasks import Workers
    from mechanics import Assembly


@dataclass(frozen=True, eq=False)
class Moved:
    """A movement by a share: its largest component (m), the state at rest or why there is none, static capacity.

    `static`: PGA at the surface (g), or α where there is no assessment, of the weaker direction; `ultimate` (m):
    control displacement at which the static capacity vanishes. None: not known.
    """

    settlement: str
    share: float
    movement: float
    start: Start
    static: float | None
    ultimate: float | None

    @property
    def title(self) -> str:
        """The state, for messages."""
        return f"{self.settlement} × {self.share:g}"


def moved_states(
    project: Project,
    model: Assembly,
    states: Mapping[str, Any],
    stages: Sequence[StateResult],
    halvings: Mapping[str, int],
    demands: Demands,
    workers: Workers,
    study: Study,
) -> list[Moved]:
    """Settle and push over each share of each movement that [campaign] asks for; movement by movement.

    Nothing is computed of the original state and of whole movements: they are in `states`, from `stages`.
    """
    table = project.campaign
    assert table is not None
    asked = table.settlements or project.states[1:]
    wholes = {
        each.name: (refined(project, halvings.get(each.name, 0)), number)
        for number, each in enumerate(project.settlements)
        if each.name in asked
    }
    between = [
        (finer, finer.settlements[number], share)
        for finer, number in wholes.values()
        for share in table.shares
        if 0.0 < share < 1.0
    ]
    parts = _parts(between, model, table, workers)
    found = []
    for name, (finer, number) in wholes.items():
        whole = finer.settlements[number]
        length = whole_movement(model, whole.support, whole.displacement_m, whole.rotation_rad)
        for share in table.shares:
            own = parts.get((name, share)) or [stage for stage in stages if stage.state == name]
            if share == 0.0:
                start: Start = model.initial
                own, curves, checks = [], *_of(states, ORIGINAL)
            elif share == 1.0:
                start = _rest(own, table)
                curves, checks = _of(states, name)
            else:
                start = _rest(own, table)
                curves, checks = _curves(own), {}
                study.quality += [row for stage in own for row in stage.quality]
                study.seconds += sum(sum(stage.seconds.values()) for stage in own)
                study.warnings += [f"{name} × {share:g}: {text}" for stage in own for text in stage.failures]
                if project.assessment:
                    checks = assess(project, model, curves, demands.spectra, demands.hazard, study.warnings)
            ultimate = ultimates({name: {"pushover": curves}})
            point = project.control_point(table.control).name
            found.append(
                Moved(
                    name,
                    share,
                    share * length,
                    start,
                    _static(project, own, curves, checks, demands),
                    ultimate.get((name, point)),
                )
            )
    return found


def _parts(
    between: Sequence[tuple[Project, SettlementTable, float]],
    model: Assembly,
    table: CampaignTable,
    workers: Workers,
) -> dict[tuple[str, float], list[StateResult]]:
    """Analyse the shares of movements between none and the whole, under every behaviour that is needed."""
    keys, requests = [], []
    for finer, whole, share in between:
        for behaviour in dict.fromkeys([*behaviours(finer), table.contacts]):
            keys.append((whole.name, share))
            requests.append(Request(finer, model, part(whole, share), behaviour, f"× {share:g}: "))
    parts: dict[tuple[str, float], list[StateResult]] = {}
    for key, result in zip(keys, analyse_states(requests, workers, "campaign"), strict=True):
        parts.setdefault(key, []).append(result)
    return parts


def _rest(stages: Iterable[StateResult], table: CampaignTable) -> Start:
    """Return the state at rest under the contacts of the campaign, or why it was not reached."""
    [own] = [stage for stage in stages if stage.behaviour == table.contacts]
    if own.reached is not None:
        return own.reached
    return "; ".join(own.failures) or "the settled state was not reached"


def _of(states: Mapping[str, Any], name: str) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
    return states[name]["pushover"], states[name]["capacity"]


def _curves(stages: Iterable[StateResult]) -> Numbers:
    """Return the pushover numbers of a state as results.json has them."""
    found: Numbers = {}
    for stage in stages:
        for direction, numbers in stage.pushover.items():
            rest = {key: value for key, value in numbers.items() if key != "control"}
            found.setdefault(direction, {"control": numbers["control"]})[stage.behaviour] = rest
    return found


def _static(
    project: Project,
    stages: Sequence[StateResult],
    curves: Mapping[str, Any],
    checks: Mapping[str, Any],
    demands: Demands,
) -> float | None:
    """Return the static capacity of the weaker direction; None where that of a direction is not known."""
    if project.pushover is None:
        return None
    found = []
    for direction in project.pushover.directions:
        numbers = capacity_numbers(project, stages, curves.get(direction, {}), checks.get(direction))
        value = numbers[quantity(project)]
        limit_state = quoted_limit_state(project)
        if value is not None and limit_state is not None:
            value = surface_pga(demands.spectra[limit_state], value)
        found.append(value)
    return None if None in found else min(found)


def surface_pga(spectrum: Spectrum, a_g: float) -> float:
    """Return the PGA at the surface (g) where the reference acceleration is a_g (g): a_g S, S that of a_g itself."""
    ground = getattr(spectrum, "ground", spectrum)
    return float(replace(ground, ag=a_g).S * a_g) if isinstance(ground, ElasticSpectrum) else a_g
