"""Analysis of states: settlements first, then strengthenings are set at rest, then pushovers in every direction."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

from assessment.analyses.found import Found, joined
from assessment.analyses.lateral import Pushed, PushSetting, push, pushover_title
from assessment.analyses.paths import Settled, not_back, path_title, rest_as_drawn, settle
from assessment.project.model import StateModel
from assessment.project.project import Project
from assessment.project.schema import ControlTable, SettlementTable
from assessment.results.schema import Configuration, PushdownPath, Pushovers, QualityRow, Run, known
from assessment.runtime.tasks import Workers
from mechanics import Assembly, State
from mechanics.messages import Message, headed, message
from mechanics.model import Behaviour, Direction
from mechanics.procedures import Mirror
from mechanics.steps import Sliding

PAST_PEAK = 0.25  # of the peak of an elastic curve


@dataclass(frozen=True, eq=False)
class Request:
    """One state (settlement None: as drawn) under one behaviour; `what` distinguishes it from others of that name.

    `member`: its number in the ensemble of the state, 1: the run itself.
    """

    project: Project
    model: StateModel
    settlement: SettlementTable | None
    behaviour: Behaviour
    what: str = ""
    member: int = 1

    def within(self, project: Project) -> Self:
        """Return the request for a state of the project in a project of other increments, the settlement's too."""
        return replace(self, project=project, settlement=project.settlement_of(self.state))

    @property
    def state(self) -> str:
        """Name of the state."""
        return self.model.name

    @property
    def movement(self) -> "Movement | None":
        """How it settles; requests that settle alike share it. None: as drawn."""
        if self.settlement is None:
            return None
        earlier = self.project.movements_to(self.settlement.name)[:-1]
        return self.model.settling, (*earlier, self.settlement), self.behaviour

    def title(self, state: str = "") -> str:
        """Return what is analysed, for people; `state`: another one that leads to its own."""
        path = path_title(state or self.state, self.behaviour)
        return f"{self.what}: {path}" if self.what else path

    @property
    def sliding(self) -> Sliding:
        """How its joints slide."""
        return self.project.contacts.sliding

    @property
    def directions(self) -> tuple[Direction, ...]:
        """Directions of the pushover, none where the project has none under this behaviour."""
        table = self.project.pushover
        return table.directions if table and self.behaviour in table.contacts else ()


Movement = tuple[Assembly, tuple[SettlementTable, ...], Behaviour]
"""Settlements of an assembly under a behaviour, the first as drawn, each other begun in the state of that before."""

Pushing = tuple[Request, tuple["Direction", ...]]
"""A request, and the directions in which its curves are followed in one task."""


@dataclass(frozen=True, eq=False)
class Beginning:
    """What is pushed, or shaken, and from where: `state` at rest, None: as drawn."""

    model: Assembly
    state: State | None


@dataclass
class StateResult:
    """One state under one behaviour: its movement and its curves by direction, each with what is to be told of it."""

    state: str
    behaviour: Behaviour
    begun: Beginning | None = None  # what is pushed, and from where; None: it falls before, or finds no rest
    moved: Found[Settled] | None = None
    pushed: dict[Direction, Found[Pushed]] = field(default_factory=dict)
    configuration: Configuration | None = None  # displacements of the settled state from the drawing
    member: int = 1  # its number in the ensemble of the state
    scatters: bool = False  # whether a path amplifies the last digits of its input
    own_failures: list[Message] = field(default_factory=list)
    coarser_seconds: dict[str, float] = field(default_factory=dict)

    @property
    def reached(self) -> State | None:
        """The settled state, at rest; None as drawn, and where it was not reached."""
        return self.begun.state if self.begun else None

    @property
    def pushdown(self) -> PushdownPath | None:
        """The movement that leads to the state."""
        return self.moved.value.path if self.moved and self.moved.value else None

    @property
    def pushover(self) -> dict[Direction, Pushovers]:
        """The curves that were found, by direction."""
        return {way: each.value.curves for way, each in self.pushed.items() if each.value}

    @property
    def parts(self) -> dict[str, list[Found[Any]]]:
        """What was found, by stage."""
        found: dict[str, list[Found[Any]]] = {"pushdown": [self.moved]} if self.moved else {}
        return found | ({"pushover": list(self.pushed.values())} if self.pushed else {})

    @property
    def warnings(self) -> list[Message]:
        """What to know about movement and curves."""
        return [text for parts in self.parts.values() for each in parts for text in each.warnings]

    @property
    def failures(self) -> list[Message]:
        """Why analyses could not be completed."""
        found = [text for parts in self.parts.values() for each in parts for text in each.failures]
        return [*found, *self.own_failures]

    @property
    def quality(self) -> list[QualityRow]:
        """The worst certificate of each stage."""
        rows = ([row for each in parts for row in each.quality] for parts in self.parts.values())
        return [joined(each[0].state, each[0].stage, each) for each in rows if each]

    @property
    def seconds(self) -> dict[str, float]:
        """Computing time by stage, that of coarser runs of the state included."""
        own = {stage: sum(each.seconds for each in parts) for stage, parts in self.parts.items()}
        before = self.coarser_seconds
        return {stage: own.get(stage, 0.0) + before.get(stage, 0.0) for stage in {**before, **own}}


def analyse_states(requests: Sequence[Request], workers: Workers, study: str = "") -> list[StateResult]:
    """Settle the structure as each request asks, then push over the states at rest; `study`: for titles."""
    prefix = f"{study}: " if study else ""
    settled = _settled(requests, workers, prefix)
    begun, restless = _beginnings(requests, settled, workers, prefix)
    pushing = [(each, together) for each in begun for together in _together(each, begun[each])]
    pushing.sort(key=lambda each: each[0].behaviour, reverse=True)  # rigid first: they take longest
    pushed = _pushed(pushing, begun, workers, prefix)
    again = _of_other_points(begun, pushed)
    pushed |= _pushed(again, begun, workers, prefix, again)
    for request, (way,) in _of_other_points(begun, pushed):
        title = pushover_title(request.state, way, request.behaviour)
        pushed[request, way] = Found(failures=[headed(title, message(
            "the control point of the rigid curve takes no part; give one that moves with elastic joints"
        ))])  # fmt: skip
    results = []
    for request in requests:
        title = path_title(request.state, request.behaviour)
        own, movement = begun.get(request), settled.get(request.movement) if request.movement else None
        result = StateResult(request.state, request.behaviour, own, member=request.member)
        if movement is not None:
            result.scatters = movement.scatters
            if request.model.strengthened is None:  # else it is of the state before
                result.moved = movement
                if (moved := movement.value) and request.settlement:
                    increment = moved.path.applied_movement_m / request.settlement.increments
                    path = moved.path.replace(run=Run(increment_m=increment, member=request.member))
                    result.moved = replace(movement, value=replace(moved, path=path))
            elif own is None:
                missing = message("the state that it strengthens was not reached")
                result.own_failures.append(headed(title, missing))
            if own is not None and own.state is not None:
                result.configuration = own.model.displaced(own.state).tolist()
        for way in (way for way in request.directions if (request, way) in pushed):
            found = pushed[request, way]
            if found.value is not None:
                run = Run(increment_m=known(request.project.pushover).increment_m, member=request.member)
                found = replace(found, value=replace(found.value, curves=found.value.curves.replace(run=run)))
            result.pushed[way] = found
            result.scatters |= found.scatters
        if request in restless:
            result.own_failures.append(headed(title, restless[request]))
        results.append(result)
    return results


def _pushed(
    pushing: Iterable[Pushing], begun: Mapping[Request, Beginning], workers: Workers, prefix: str,
    points: Mapping[Pushing, ControlTable] | None = None,
) -> dict[tuple[Request, Direction], Found[Pushed]]:  # fmt: skip
    """Return the curves of requests by direction; `points`: where not that of the project is followed."""
    tasks, arguments = list(pushing), []
    for request, together in tasks:
        project, point, own = request.project, (points or {}).get((request, together)), begun[request]
        controls = tuple(point or project.pushover_control(direction) for direction in together)
        # of an elastic curve the part up to its peak is used; a bilinear fit needs the area of the whole curve
        asked = project.assessment
        whole = request.behaviour == "rigid" or (asked and asked.model == "bilinear")
        increment, until = known(project.pushover).increment_m, 0.0 if whole else PAST_PEAK
        setting = PushSetting(request.behaviour, request.sliding, increment, until)
        arguments.append((own.model, request.state, own.state, setting, together, controls))
    titles = [f"{request.title()}, {' and '.join(together)}" for request, together in tasks]
    found = workers.each(f"{prefix}pushover", push, arguments, titles)
    return {
        (request, direction): part
        for (request, together), parts in zip(tasks, found, strict=True)
        for direction, part in zip(together, parts, strict=True)
    }


def _of_other_points(
    requests: Iterable[Request], pushed: Mapping[tuple[Request, Direction], Found[Pushed]]
) -> dict[Pushing, ControlTable]:
    """Return elastic curves of another control point than the rigid ones beside them, with the points of these."""
    followed = [
        (request, way, value.curves)
        for request in requests
        for way in request.directions
        if (value := pushed[request, way].value) is not None
    ]
    rigid = {(r.what, r.state, r.member, way): push for r, way, push in followed if r.behaviour == "rigid"}
    other: dict[Pushing, ControlTable] = {}
    for request, way, own in followed:
        beside = rigid.get((request.what, request.state, request.member, way), own)
        if own.control != beside.control:
            x, z = known(beside.control_m)
            other[request, (way,)] = ControlTable(name=beside.control, point_m=(x, z))
    return other


def _settled(requests: Sequence[Request], workers: Workers, prefix: str) -> dict[Movement, Found[Settled]]:
    """Return the settlements of all requests, each once, those that begin in the state of another one after it."""
    asked: dict[Movement, Request] = {}
    for request in requests:
        if request.movement:
            model, path, behaviour = request.movement
            for count in range(len(path), 0, -1):
                asked.setdefault((model, path[:count], behaviour), request)
    found: dict[Movement, Found[Settled]] = {}
    for count in range(1, 1 + max((len(path) for _, path, _ in asked), default=0)):
        tasks, titles = {}, []
        for (model, path, behaviour), request in asked.items():
            if len(path) != count:
                continue
            last, start = path[-1], _reached(found.get((model, path[:-1], behaviour)))
            if count > 1 and start is None:
                missing = message("the state that the movement begins in was not reached")
                reason = headed(path_title(last.name, behaviour), missing)
                found[model, path, behaviour] = Found(failures=[reason])
                continue
            whole = last.model_copy(update={"steps": None})
            control = next(iter(request.project.control), None)
            tasks[model, path, behaviour] = (model, whole, behaviour, request.sliding, control, start)
            titles.append(request.title(last.name))
        moved = workers.each(f"{prefix}pushdown", settle, list(tasks.values()), titles)
        for movement, followed in zip(tasks, moved, strict=True):
            away = _not_back(movement, followed, found, asked[movement].sliding)
            found[movement] = replace(followed, warnings=[*followed.warnings, *away])
    return found


def _reached(movement: Found[Settled] | None) -> State | None:
    return movement.value.reached if movement and movement.value else None


def _not_back(
    movement: Movement, followed: Found[Settled], found: Mapping[Movement, Found[Settled]], sliding: Sliding
) -> list[Message]:
    """Return what does not come back where all supports are where they were, as drawn or after an earlier movement.

    As drawn elastic joints have sunk under gravity.
    """
    (model, path, behaviour), reached = movement, _reached(followed)
    places = [
        (message("after {state}", state=path[count - 1].name), state)
        for count in range(len(path) - 1, 0, -1)
        if (state := _reached(found[model, path[:count], behaviour])) is not None
    ]
    if reached is None or not places:
        return []
    drawn = rest_as_drawn(model, sliding) if behaviour == "elastic" else model.initial
    if not isinstance(drawn, Message):
        places.append((message("as drawn"), drawn))
    told = (not_back(model, reached, *place) for place in places)
    return [headed(path_title(path[-1].name, behaviour), text) for text in told if text][:1]


def _beginnings(
    requests: Sequence[Request], settled: Mapping[Movement, Found[Settled]], workers: Workers, prefix: str
) -> tuple[dict[Request, Beginning], dict[Request, Message]]:
    """Return where each request is pushed from, and why others find no rest; not those that collapse before."""
    resting = [r for r in requests if r.settlement is None and r.model.later and r.behaviour == "elastic"]
    tasks = [(request.model.settling, request.sliding) for request in resting]
    titles = [f"{request.title()}, at rest" for request in resting]
    rests = workers.each(f"{prefix}rest", rest_as_drawn, tasks, titles)
    at_rest = dict(zip(resting, rests, strict=True))
    found, restless = {}, {}
    for request in requests:
        moved = settled[request.movement] if request.movement else None
        reached = _reached(moved) if moved else at_rest.get(request)
        if isinstance(reached, Message):
            restless[request] = reached
        elif reached is not None:
            found[request] = Beginning(request.model.tied_at(reached), request.model.taken_over(reached))
        elif moved is None:
            found[request] = Beginning(request.model.assembly, None)
    return found, restless


def curves(results: Iterable[StateResult]) -> dict[Direction, Pushovers]:
    """Return the pushover of one state by direction, the curves of every behaviour together."""
    found: dict[Direction, Pushovers] = {}
    for result in results:
        for direction, pushed in result.pushover.items():
            found[direction] = found.setdefault(direction, pushed).replace(**pushed.by_contacts)
    return found


def _together(request: Request, begun: Beginning) -> list[tuple[Direction, ...]]:
    """Return the directions of a request; two whose curves are mirror images of each other are one task."""
    alone: list[tuple[Direction, ...]] = [(direction,) for direction in request.directions]
    if len(alone) < 2 or begun.state is not None:
        return alone
    mirror = Mirror.of(begun.model, request.behaviour)
    one, other = (request.project.pushover_control(direction).point_m for direction in request.directions)
    if mirror is None or not mirror.swaps(one, other):
        return alone
    return [request.directions]
