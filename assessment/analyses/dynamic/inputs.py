"""The inputs of the motions of a run: models, settings and the states at rest in which they begin."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from assessment.analyses.dynamic.response import Setting
from assessment.analyses.dynamic.time_history import DynamicResult, Shaking, Start
from assessment.project.schema import ORIGINAL
from mechanics.messages import Message, linked, message

if TYPE_CHECKING:
    from assessment.analyses.static.states import StateResult
    from assessment.project.motions import BaseMotion
    from assessment.project.project import Project
    from assessment.project.schema import MotionTable, StatesTable
    from assessment.project.structure.model import StateModel
    from assessment.results.schema.static import Pushovers
    from assessment.runtime.tasks import Workers
    from mechanics import Assembly
    from mechanics.model import Behaviour, Direction

WORTHWHILE = 50_000  # joints times steps: below it a second process costs more than it saves


@dataclass(frozen=True, eq=False)
class Resting:
    """An assembly, and the state at rest in which a motion finds it, or why that was not reached."""

    model: Assembly
    start: Start


@dataclass(frozen=True)
class MotionInputs:
    """The inputs that all motions of a run share.

    `starts`: assembly and rest by state and contacts; `ultimates`: ultimate displacement by state and control point.
    """

    project: Project
    starts: Mapping[tuple[str, str], Resting]
    ultimates: Mapping[tuple[str, str], float]
    workers: Workers

    def tasks(
        self, table: StatesTable, motions: Sequence[BaseMotion], integrated: MotionTable | None = None
    ) -> list[Shaking]:
        """Return the motions from every state that the table asks for, `integrated` as the table says or otherwise."""
        control, sliding = self.project.control_point(table.control), self.project.contacts.sliding
        found = []
        for state in self.project.states:
            if table.states is None or state in table.states:
                resting, ultimate = (
                    self.starts[state, table.contacts],
                    self.ultimates.get((state, control.name)),
                )
                setting = Setting(integrated or _own(table), control, ultimate, sliding)
                found += [Shaking(resting.model, each, setting, state, resting.start) for each in motions]
        return found

    def each(
        self, stage: str, function: Callable[[Shaking], DynamicResult], tasks: Sequence[tuple[Shaking]]
    ) -> list[DynamicResult]:
        """Return function(task) for every task, in order."""
        samples = [shaking.motion.record.acceleration.size for (shaking,) in tasks]
        work = sum(len(shaking.model.contacts) * n for (shaking,), n in zip(tasks, samples, strict=True))
        titles = [f"{shaking.state}, {shaking.motion.name}" for (shaking,) in tasks]
        return self.workers.each(stage, function, tasks, titles, work > WORTHWHILE, samples)


def _own(table: MotionTable) -> MotionTable:
    """Return the table without its choice of states and records: one analysis does not depend on the others."""
    choice: dict[str, Any] = {"states": None, "records": ()}
    return table.model_copy(update={key: choice[key] for key in choice if key in type(table).model_fields})


def starts_of(
    behaviours: Iterable[Behaviour], models: Mapping[str, StateModel], stages: Iterable[StateResult]
) -> dict[tuple[str, str], Resting]:
    """Return the state at rest by name and behaviour, or the reason why it was not reached.

    The original state, and a strengthened one of rigid joints, are at rest as drawn.
    """
    drawn = models[ORIGINAL].assembly
    starts: dict[tuple[str, str], Resting] = {
        (ORIGINAL, behaviour): Resting(drawn, drawn.initial) for behaviour in behaviours
    }
    for stage in stages:
        if stage.state != ORIGINAL:
            model = stage.model or models[stage.state].assembly
            start: Start = why_not_reached(stage)
            if stage.reached is not None:
                start = stage.reached
            elif stage.from_drawing:
                start = model.initial
            starts[stage.state, stage.behaviour] = Resting(model, start)
    return starts


def why_not_reached(stage: StateResult) -> Message:
    """Return why a settled state was not reached."""
    return linked(stage.failures) if stage.failures else message("the settled state was not reached")


def ultimates(
    pushovers: Mapping[str, Mapping[Direction, Pushovers]],
) -> dict[tuple[str, str], float]:
    """Return the displacement (m) at which the static capacity vanishes, by state and control point.

    `pushovers`: of each state, by direction. Only where both directions have such a displacement, of one point.
    """
    found = {}
    for state, pushed in pushovers.items():
        rigid = [(each.control, each.rigid) for each in pushed.values() if each.rigid is not None]
        ends = [curve.d_0_m for _, curve in rigid if curve.reached_zero and curve.d_0_m is not None]
        controls = {control for control, _ in rigid}
        if len(ends) == 2 and len(controls) == 1:
            found[state, controls.pop()] = max(ends)
    return found
