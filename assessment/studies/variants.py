"""Variants of a project, analysed beside its states by sweeps and sensitivities, and their capacities."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from assessment.analyses.checks.capacity import assess, capacities, told
from assessment.analyses.static.states import Request, StateResult, analyse_states, curves
from assessment.ntc.limit_states import QUOTED
from assessment.results.schema.studies import Capacities
from mechanics.messages import Message, headed, message

if TYPE_CHECKING:
    from assessment.analyses.checks.demand import Demands
    from assessment.project.project import Project
    from assessment.project.schema import SettlementTable
    from assessment.project.structure.model import StateModel
    from assessment.results.schema import State
    from assessment.results.schema.checks import Capacity
    from assessment.results.schema.model import QualityRow
    from assessment.results.schema.static import Pushovers
    from assessment.runtime.tasks import Workers
    from mechanics.model import Direction


@dataclass(frozen=True)
class Variant:
    """A project and the model of a state after a settlement (None: as drawn); `what`: how it differs from the state."""

    what: str
    project: Project
    model: StateModel
    settlement: SettlementTable | None

    @property
    def title(self) -> Message:
        """The variant and its state, for messages."""
        return message("{what}: {state}", what=self.what, state=self.model.name)


@dataclass(frozen=True, eq=False)
class Statics:
    """What the static analyses gave: each state as results.json has it, and the results behind it.

    `halvings`: how often the increments of each state were halved; the studies of a state halve theirs as often.
    """

    states: Mapping[str, State]
    stages: Sequence[StateResult]
    halvings: Mapping[str, int]

    def stages_of(self, name: str) -> list[StateResult]:
        """Return the results of a state, one for each contact behaviour."""
        return [stage for stage in self.stages if stage.state == name]


@dataclass
class Study:
    """Rows of quality, warnings and failures of the runs of a study, findings about all of them, and their time (s)."""

    quality: list[QualityRow] = field(default_factory=list)
    warnings: list[Message] = field(default_factory=list)
    findings: list[Message] = field(default_factory=list)
    failures: list[Message] = field(default_factory=list)
    seconds: float = 0.0

    def take(self, title: str, stages: Iterable[StateResult]) -> None:
        """Add quality, times and messages of the analyses of a variant; the messages get its title."""
        for stage in stages:
            self.quality += stage.quality
            self.seconds += sum(stage.seconds.values())
            self.warnings += [headed(title, text) for text in stage.warnings]
            self.failures += [headed(title, text) for text in stage.failures]


def analyse(
    variants: Sequence[Variant], demands: Demands, workers: Workers, study: Study, name: str
) -> Iterator[dict[Direction, Capacities]]:
    """Settle and push over every variant; yield the capacity of each by direction, in order; `name`: of the study.

    Messages, certificates and times go to `study`. Raises KilledError where a process was ended from outside.
    """
    requests = [
        Request(variant.project, variant.model, variant.settlement, behaviour, f"{variant.what}: ")
        for variant in variants
        for behaviour in variant.project.pushed_contacts
    ]
    each = len(requests) // max(1, len(variants))
    results = iter(analyse_states(requests, workers, name))
    for variant in variants:
        stages = [next(results) for _ in range(each)]
        study.take(variant.what, stages)
        pushovers = curves(stages)
        checked: dict[Direction, Capacity] = {}
        if variant.project.assessment:
            found = assess(variant.project, variant.model.assembly, pushovers, demands)
            checked = capacities(found)
            study.warnings += [headed(variant.title, note) for note in told(found)]
        yield capacities_of(variant.project, stages, pushovers, checked)


def directions(project: Project) -> tuple[Direction, ...]:
    """Return the directions of the pushover."""
    return project.pushover.directions if project.pushover else ()


def capacities_of(
    project: Project,
    stages: Collection[StateResult],
    pushovers: Mapping[Direction, Pushovers],
    checked: Mapping[Direction, Capacity],
) -> dict[Direction, Capacities]:
    """Return the capacity of one state for a study, by direction; null: asked for, but not reached.

    `collapses`: under one of the contact behaviours the structure falls before the whole movement is applied;
    a_g and ζ_E are of the farthest limit state.
    """
    fallen = any(stage.pushdown is not None and stage.reached is None for stage in stages)
    return {
        direction: _capacities(project, fallen, pushovers.get(direction), checked.get(direction))
        for direction in directions(project)
    }


def _capacities(
    project: Project, fallen: bool, pushed: Pushovers | None, capacity: Capacity | None
) -> Capacities:
    found = Capacities(collapses=fallen)
    if "rigid" in project.pushed_contacts:
        rigid = pushed.rigid if pushed else None
        found = found.replace(alpha_0=rigid.alpha_0 if rigid else None, d_0_m=rigid.d_0_m if rigid else None)
    if "elastic" in project.pushed_contacts:
        elastic = pushed.elastic if pushed else None
        found = found.replace(alpha_u=elastic.alpha_u if elastic else None)
    if project.assessment:
        check = capacity.checks.get(quoted_limit_state(project) or "") if capacity else None
        found = found.replace(a_g_g=check.a_g_g if check else None, zeta_E=check.zeta_E if check else None)
    return found


def quoted_limit_state(project: Project) -> str | None:
    """Return the limit state of the capacities a_g that are quoted: the farthest of those asked for."""
    asked = project.assessment.limit_states if project.assessment else ()
    return next((limit for limit in QUOTED if limit in asked), None)


def quantity(project: Project) -> str:
    """Return the key of the quantity that capacities are compared by: a_g with an assessment, else α0, else α_u."""
    return "a_g_g" if project.assessment else "alpha_0" if "rigid" in project.pushed_contacts else "alpha_u"
