"""Variants of a project that are analysed beside its states, for sweeps and sensitivities."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from assessment.analyses.checks.capacity import assess
from assessment.analyses.static.states import Request, StateResult, analyse_states
from assessment.ntc.limit_states import QUOTED
from assessment.project.schema import ORIGINAL

if TYPE_CHECKING:
    from assessment.analyses.checks.demand import Demands
    from assessment.project.project import Project
    from assessment.project.schema import SettlementTable
    from assessment.results.schema.checks import Capacity
    from assessment.runtime.tasks import Workers
    from mechanics import Assembly
    from mechanics.model import Behaviour, Direction

Numbers = dict[str, Any]
UNCHECKED = {"a_g_g": None, "zeta_E": None}


@dataclass(frozen=True)
class Variant:
    """A project and its model after a settlement (None: as drawn); `what`: how it differs from the state."""

    what: str
    project: Project
    model: Assembly
    settlement: SettlementTable | None

    @property
    def title(self) -> str:
        """The variant and its state, for messages."""
        return f"{self.what}: {self.settlement.name if self.settlement else ORIGINAL}"


@dataclass(frozen=True, eq=False)
class Statics:
    """What the static analyses gave: numbers of each state as results.json has them, and the results behind them.

    `halvings`: how often the increments of each state were halved; the studies of a state halve theirs as often.
    """

    states: Mapping[str, Any]
    stages: Sequence[StateResult]
    halvings: Mapping[str, int]

    def stages_of(self, name: str) -> list[StateResult]:
        """Return the results of a state, one for each contact behaviour."""
        return [stage for stage in self.stages if stage.state == name]

    def pushed(self, name: str) -> tuple[Mapping[Direction, Any], Mapping[Direction, Capacity]]:
        """Return the pushover curves and the checks of a state, by direction."""
        return self.states[name]["pushover"], self.states[name]["capacity"]


@dataclass
class Study:
    """Rows of quality, warnings and failures of the runs of a study, findings about all of them, and their time (s)."""

    quality: list[Numbers] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    findings: list[str] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    seconds: float = 0.0

    def take(self, variant: Variant, stages: Iterable[StateResult]) -> None:
        """Add quality, times and messages of the analyses of a variant; the messages get its name."""
        for stage in stages:
            self.quality += stage.quality
            self.seconds += sum(stage.seconds.values())
            self.warnings += [f"{variant.what}: {text}" for text in stage.warnings]
            self.failures += [f"{variant.what}: {text}" for text in stage.failures]


def analyse(
    variants: Sequence[Variant], demands: Demands, workers: Workers, study: Study, name: str
) -> Iterator[dict[str, Numbers]]:
    """Yield the capacity of each variant by direction; `name`: of the study."""
    requests = [
        Request(variant.project, variant.model, variant.settlement, behaviour, f"{variant.what}: ")
        for variant in variants
        for behaviour in behaviours(variant.project)
    ]
    each = len(requests) // max(1, len(variants))
    results = iter(analyse_states(requests, workers, name))
    for variant in variants:
        stages = [next(results) for _ in range(each)]
        study.take(variant, stages)
        pushovers = curves(stages)
        capacities: dict[Direction, Capacity] = {}
        if variant.project.assessment:
            notes: list[str] = []
            capacities = assess(variant.project, variant.model, pushovers, demands, notes)
            study.warnings += [f"{variant.title}: {note}" for note in notes]
        yield {
            direction: capacity_numbers(
                variant.project, stages, pushovers.get(direction, {}), capacities.get(direction)
            )
            for direction in directions(variant.project)
        }


def behaviours(project: Project) -> tuple[Behaviour, ...]:
    """Return the contact behaviours of the pushover."""
    return project.pushover.contacts if project.pushover else ()


def directions(project: Project) -> tuple[Direction, ...]:
    """Return the directions of the pushover."""
    return project.pushover.directions if project.pushover else ()


def curves(stages: Iterable[StateResult]) -> dict[Direction, Numbers]:
    """Return the pushover numbers of one state by direction and behaviour."""
    found: dict[Direction, Numbers] = {}
    for stage in stages:
        for direction, numbers in stage.pushover.items():
            found.setdefault(direction, {})[stage.behaviour] = numbers
    return found


def capacity_numbers(
    project: Project,
    stages: Iterable[StateResult],
    pushover: Mapping[str, Any],
    capacity: Capacity | None,
) -> Numbers:
    """Return the capacity of one state in one direction for a study; None: asked for, but not reached.

    `collapses`: under one of the contact behaviours the structure falls before the whole movement is applied;
    a_g and ζ_E are of the farthest limit state.
    """
    fallen = any(stage.pushdown is not None and stage.reached is None for stage in stages)
    numbers: Numbers = {"collapses": fallen}
    if "rigid" in behaviours(project):
        rigid = pushover.get("rigid") or {}
        numbers |= {key: rigid.get(key) for key in ("alpha_0", "d_0_m")}
    if "elastic" in behaviours(project):
        numbers["alpha_u"] = (pushover.get("elastic") or {}).get("alpha_u")
    if project.assessment:
        check = capacity and capacity.checks.get(quoted_limit_state(project) or "")
        numbers |= {"a_g_g": check.a_g_g, "zeta_E": check.zeta_E} if check else UNCHECKED
    return numbers


def quoted_limit_state(project: Project) -> str | None:
    """Return the limit state of the capacities a_g that are quoted: the farthest of those asked for."""
    asked = project.assessment.limit_states if project.assessment else ()
    return next((limit for limit in QUOTED if limit in asked), None)


def quantity(project: Project) -> str:
    """Return the quantity that capacities are compared by: a_g with an assessment, else α0, or α_u without it."""
    return "a_g_g" if project.assessment else "alpha_0" if "rigid" in behaviours(project) else "alpha_u"
