"""The states of a campaign: each share of each movement at rest, and its static capacity."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from assessment.analyses.checks.capacity import assess, capacities, told
from assessment.analyses.dynamic.inputs import ultimates, why_not_reached
from assessment.analyses.dynamic.time_history import Start
from assessment.analyses.static.increments import finest
from assessment.analyses.static.states import Request, StateResult, analyse_states, curves
from assessment.project.schema import ORIGINAL
from assessment.results.table import compared
from assessment.studies.scenarios import part
from assessment.studies.variants import (
    Statics,
    Study,
    capacities_of,
    directions,
    quantity,
    quoted_limit_state,
)
from mechanics.messages import Message, headed, message
from mechanics.procedures import whole_movement

if TYPE_CHECKING:
    from assessment.analyses.checks.demand import Demands
    from assessment.project.project import Project
    from assessment.project.schema import CampaignTable, SettlementTable
    from assessment.project.structure.model import StateModel
    from assessment.results.schema.checks import Direction
    from assessment.results.schema.static import Pushovers
    from assessment.runtime.tasks import Workers
    from mechanics import Assembly


@dataclass(frozen=True, eq=False)
class Moved:
    """A share of a movement: its largest component (m), assembly, state at rest or why there is none, static capacity.

    `static`: PGA at the surface (g) of the check, or α where there is none, of the weaker direction; `ultimate` (m):
    control displacement at which the static capacity vanishes. None: not known.
    """

    settlement: str
    share: float
    movement: float
    model: Assembly
    start: Start
    static: float | None
    ultimate: float | None

    @property
    def title(self) -> Message:
        """The state, for messages."""
        return moved_title(self.settlement, self.share)


def moved_title(settlement: str, share: float) -> Message:
    """Return the beginning of messages about the state after a share of a movement."""
    return message("{state} × {share:g}", state=settlement, share=share)


def moved_states(
    project: Project,
    models: Mapping[str, StateModel],
    statics: Statics,
    demands: Demands,
    workers: Workers,
    study: Study,
) -> list[Moved]:
    """Return the states after each share of each movement that [campaign] asks for, settled and pushed over.

    The original state and whole movements are taken from `statics`. Messages, certificates and times go to `study`.
    Raises KilledError where a process was ended from outside.
    """
    table = project.campaign
    assert table is not None
    asked, beside = table.settlements or project.unstrengthened[1:], _beside(project, table)
    movements = [each for each in finest(project, statics.halvings) if each[1].name in asked]
    parts = _parts(movements, models, table, workers)
    point, drawn = project.control_point(table.control).name, models[ORIGINAL].assembly
    found = []
    for _, whole in movements:
        model = models[whole.name].assembly
        length = whole_movement(model, whole.support, whole.displacement_m, whole.rotation_rad)
        for share in table.shares:
            name = whole.name if share else ORIGINAL
            place, warnings = (whole.name, share), []  # of the whole and of none: told with their states
            stages, pushed = statics.stages_of(name), statics.states[name].pushover
            if 0.0 < share < 1.0:
                stages, warnings = parts[place], study.warnings
                pushed = curves(stages)
                for stage in stages:
                    study.quality += stage.quality
                    study.seconds += sum(stage.seconds.values())
                    study.warnings += [headed(moved_title(*place), text) for text in stage.failures]
            start = drawn.initial if not share else _rest(stages, table)
            static = _static(
                beside, model if share else drawn, stages if share else [], pushed, demands, warnings
            )
            # of the control point, m: where the static capacity vanishes
            ultimate = ultimates({ORIGINAL: pushed}).get((ORIGINAL, point))
            found.append(Moved(*place, share * length, model if share else drawn, start, static, ultimate))
    return found


def _parts(
    movements: Sequence[tuple[Project, SettlementTable]],
    models: Mapping[str, StateModel],
    table: CampaignTable,
    workers: Workers,
) -> dict[tuple[str, float], list[StateResult]]:
    """Analyse the shares of movements between none and the whole, under every behaviour that is needed."""
    keys, requests = [], []
    for finer, whole in movements:
        for share in table.shares:
            if not 0.0 < share < 1.0:
                continue
            for behaviour in dict.fromkeys([*finer.pushed_contacts, table.contacts]):
                keys.append((whole.name, share))
                requests.append(
                    Request(finer, models[whole.name], part(whole, share), behaviour, f"× {share:g}: ")
                )
    parts: dict[tuple[str, float], list[StateResult]] = {}
    for key, result in zip(keys, analyse_states(requests, workers, "campaign"), strict=True):
        parts.setdefault(key, []).append(result)
    return parts


def _rest(stages: Iterable[StateResult], table: CampaignTable) -> Start:
    """Return the state at rest under the contacts of the campaign, or why it was not reached."""
    [own] = [stage for stage in stages if stage.behaviour == table.contacts]
    return own.reached if own.reached is not None else why_not_reached(own)


def _beside(project: Project, table: CampaignTable) -> Project:
    """Return the project whose static capacity stands beside the campaign's: of rigid joints without elastic curves.

    Soft joints may lose most of what a movement leaves to rigid ones: the two losses would be of different structures.
    """
    if project.pushover is None or table.contacts != "rigid" or "rigid" not in project.pushover.contacts:
        return project
    changed: dict[str, object] = {"pushover": project.pushover.model_copy(update={"contacts": ("rigid",)})}
    if project.assessment:
        changed["assessment"] = project.assessment.model_copy(update={"model": "none"})  # the rigid branch
    return project.model_copy(update=changed)


def _static(
    project: Project,
    model: Assembly,
    stages: Sequence[StateResult],
    pushed: Mapping[Direction, Pushovers],
    demands: Demands,
    warnings: list[Message],
) -> float | None:
    """Return the static capacity of the weaker direction, of the joints of `project`; None if one is not known."""
    if project.pushover is None:
        return None
    if "elastic" not in project.pushover.contacts:
        pushed = {direction: each.replace(elastic=None) for direction, each in pushed.items()}
    if project.assessment:
        assessed = assess(project, model, pushed, demands)
        warnings += told(assessed)
        checked, limit = capacities(assessed), quoted_limit_state(project) or ""
        checks = [
            checked[each].checks.get(limit) if each in checked else None for each in directions(project)
        ]
        values = [check.pga_g if check else None for check in checks]
    else:
        own = [stage for stage in stages if stage.behaviour in project.pushover.contacts]
        values = [
            compared(each, quantity(project)) for each in capacities_of(project, own, pushed, {}).values()
        ]
    known = [value for value in values if value is not None]
    return min(known) if known and len(known) == len(values) else None
