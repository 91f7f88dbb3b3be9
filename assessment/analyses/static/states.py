"""Analysis of states: all settlements first, then the pushover in every direction from the states at rest."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from assessment.analyses.static.lateral import PushSetting, push
from assessment.analyses.static.paths import PathResult, configuration
from assessment.analyses.static.settlement import settle
from assessment.project.schema import ORIGINAL
from assessment.results.quality import joined
from assessment.results.schema.part import present
from assessment.results.schema.static import Pushovers
from assessment.runtime.tasks import Workers, large
from mechanics.procedures import Mirror

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.schema import ControlTable, SettlementTable
    from assessment.results.schema.model import QualityRow
    from assessment.results.schema.static import PushdownPath
    from mechanics import Assembly, State
    from mechanics.model import Behaviour, Direction
    from mechanics.steps import Sliding

PAST_PEAK = 0.25  # of the peak of an elastic curve


@dataclass(frozen=True, eq=False)
class Request:
    """One state (settlement None: as drawn) under one behaviour; `what` distinguishes it from others of that name."""

    project: Project
    model: Assembly
    settlement: SettlementTable | None
    behaviour: Behaviour
    what: str = ""

    @property
    def state(self) -> str:
        """Name of the state."""
        return self.settlement.name if self.settlement else ORIGINAL

    @property
    def title(self) -> str:
        """What is analysed, for people."""
        return f"{self.what}{self.state}, {self.behaviour} contacts"

    @property
    def sliding(self) -> Sliding:
        """How its joints slide."""
        return self.project.contacts.sliding

    @property
    def directions(self) -> tuple[Direction, ...]:
        """Directions of the pushover, none where the project has none under this behaviour."""
        table = self.project.pushover
        return table.directions if table and self.behaviour in table.contacts else ()


@dataclass
class StateResult:
    """Result of one state under one behaviour; `failures`: analyses that could not be completed.

    `reached`: the settled state, at rest; None where the structure collapses before. `activated`: by direction, where a
    rigid curve has its largest multiplier. `scatters`: whether a path amplifies the last digits of its input.
    """

    state: str
    behaviour: Behaviour
    pushdown: PushdownPath | None = None
    pushover: dict[Direction, Pushovers] = field(default_factory=dict)
    configuration: list[list[float]] | None = None
    reached: State | None = None
    activated: dict[Direction, State] = field(default_factory=dict)
    quality: list[QualityRow] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)
    scatters: bool = False

    def take(self, stage: str, parts: Sequence[PathResult[Any]]) -> None:
        """Add the messages, certificates and times of the analyses of a stage."""
        for part in parts:
            self.warnings += part.warnings
            self.failures += part.failures
            self.scatters |= part.scatters
        rows = [row for part in parts for row in part.quality]
        if rows:
            self.quality.append(joined(rows[0].state, rows[0].stage, rows))
        if parts:
            self.seconds[stage] = sum(part.seconds for part in parts)


def analyse_states(requests: Sequence[Request], workers: Workers, study: str = "") -> list[StateResult]:
    """Settle the structure as each request asks, then push over the states at rest; return the results in order.

    An analysis has only the arguments that it depends on: a stored result is used again while these are unchanged.
    `study`: name of the study that the requests are for, "" for the states themselves.
    """
    prefix = f"{study}: " if study else ""
    settling = [request for request in requests if request.settlement is not None]
    settled = workers.each(
        f"{prefix}pushdown",
        settle,
        [
            (r.model, _alone(r.settlement), r.behaviour, r.sliding, _first_control(r.project))
            for r in settling
        ],
        [request.title for request in settling],
        large(*(request.model for request in settling)),
    )
    reached = dict(zip(map(id, settling), settled, strict=True))

    standing = [r for r in requests if r.settlement is None or reached[id(r)].reached is not None]
    pushing = [(request, together) for request in standing for together in _together(request)]
    pushing.sort(key=lambda each: each[0].behaviour, reverse=True)  # rigid first: they take longest
    pushed = workers.each(
        f"{prefix}pushover",
        push,
        [_push_arguments(request, together, reached.get(id(request))) for request, together in pushing],
        [f"{request.title}, {' and '.join(together)}" for request, together in pushing],
        large(*(request.model for request, _ in pushing)),
    )
    results = []
    for request in requests:
        own = {
            direction: part
            for (asked, together), parts in zip(pushing, pushed, strict=True)
            if asked is request
            for direction, part in zip(together, parts, strict=True)
        }
        results.append(_result(request, reached.get(id(request)), own))
    return results


def curves(results: Iterable[StateResult]) -> dict[Direction, Pushovers]:
    """Return the pushover of one state by direction, the curves of every behaviour together."""
    found: dict[Direction, Pushovers] = {}
    for result in results:
        for direction, pushed in result.pushover.items():
            own = found.setdefault(direction, pushed)
            found[direction] = own.replace(**pushed.by_contacts)
    return found


def _together(request: Request) -> list[tuple[Direction, ...]]:
    """Return the directions of a request; two whose curves are mirror images of each other are one task."""
    alone: list[tuple[Direction, ...]] = [(direction,) for direction in request.directions]
    if len(alone) < 2 or request.settlement is not None:
        return alone
    mirror = Mirror.of(request.model, request.behaviour)
    points = zip(*(_controls(request.project, direction) for direction in request.directions), strict=True)
    if mirror is None or not all(mirror.swaps(one.point_m, other.point_m) for one, other in points):
        return alone
    return [request.directions]


def _result(
    request: Request,
    settled: PathResult[PushdownPath] | None,
    pushed: dict[Direction, PathResult[Pushovers]],
) -> StateResult:
    result = StateResult(request.state, request.behaviour)
    if settled is not None:
        result.take("pushdown", [settled])
        result.pushdown, result.reached = settled.found, settled.reached
        if settled.reached is not None:
            result.configuration = configuration(request.model, settled.reached)
    result.take("pushover", list(pushed.values()))
    result.pushover = present({direction: part.found for direction, part in pushed.items()})
    result.activated = present({direction: part.activated for direction, part in pushed.items()})
    return result


def _push_arguments(
    request: Request, together: tuple[Direction, ...], settled: PathResult[PushdownPath] | None
) -> tuple[Any, ...]:
    """Return the arguments of `push`."""
    project = request.project
    assert project.pushover is not None
    controls = tuple(_controls(project, direction) for direction in together)
    state = settled.reached if settled else None
    # of an elastic curve the part up to its peak is used; a bilinear fit needs the area of the whole curve
    whole = request.behaviour == "rigid" or (project.assessment and project.assessment.model == "bilinear")
    setting = PushSetting(
        request.behaviour, request.sliding, project.pushover.increment_m, 0.0 if whole else PAST_PEAK
    )
    return request.model, request.state, state, setting, together, controls


def _controls(project: Project, direction: Direction) -> tuple[ControlTable, ...]:
    """Return the control points, that of the direction first."""
    wished = project.pushover_control(direction)
    return (wished, *(point for point in project.control if point != wished))


def _alone(settlement: SettlementTable | None) -> SettlementTable:
    """Return the settlement without its sweep, on which the whole movement does not depend."""
    assert settlement is not None
    return settlement.model_copy(update={"steps": None})


def _first_control(project: Project) -> ControlTable | None:
    return project.control[0] if project.control else None
