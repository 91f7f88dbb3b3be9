"""The motions that [incremental] and [campaign] share: a record of one sign from one state is scanned once."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from assessment.analyses.accuracy import LEVELS, accuracy_of
from assessment.analyses.dynamic.ensemble import Scatter, scatter_of
from assessment.analyses.dynamic.fragility import Observed, observed
from assessment.analyses.dynamic.inputs import WORTHWHILE
from assessment.analyses.dynamic.scan import EXPECTED, SPACING, Reach, Scan, scan
from assessment.project.schema import MotionTable
from assessment.results.schema.dynamic import Scanned
from assessment.results.schema.studies import ConvergenceRow
from assessment.runtime.fingerprint import fingerprint
from assessment.runtime.tasks import From
from mechanics.messages import Message, headed, message
from mechanics.procedures import Mirror

if TYPE_CHECKING:
    from assessment.analyses.dynamic.time_history import Shaking
    from assessment.project.project import Project
    from assessment.runtime.tasks import Workers
    from mechanics import Assembly

SCALED = 3.0  # factor on a record beyond which its level is no longer that of such an earthquake


@dataclass(frozen=True, eq=False)
class Asked:
    """A record of one sign from a state; `shaking` has the sign that is run.

    Both signs of a structure that is its own mirror image are one run. `after`: the one at whose level it begins.
    """

    title: Message
    shaking: Shaking
    sign: int
    run_sign: int
    reach: Reach
    after: Asked | None = None

    @cached_property
    def key(self) -> str:
        """Key of the scan: what its motions depend on."""
        of = self.shaking
        return fingerprint(scan, (of.model, of.motion, of.setting, of.start, self.reach))


@dataclass
class Scans:
    """Scans of a run by key, each with those of the time step halved once, twice…; what is there is not run again."""

    project: Project
    workers: Workers
    found: dict[str, list[Scan]] = field(default_factory=dict)
    told: set[str] = field(default_factory=set)

    def run(self, stage: str, asked: Sequence[Asked], halvings: int = 0) -> None:
        """Scan what has not been scanned, the longest records first, at a time step that is halved so often."""
        scatter = scatter_of(self.project)
        wanted: dict[str, Asked] = {}
        for each in asked:
            key = each.key
            if not isinstance(each.shaking.start, str) and len(self.found.get(key, [])) == halvings:
                wanted.setdefault(key, each)
        order = sorted(wanted, key=lambda key: -wanted[key].shaking.motion.record.acceleration.size)
        numbers = {key: number for number, key in enumerate(order)}
        tasks = [self._task(wanted[key], halvings, scatter, numbers) for key in order]
        samples = [task[1].record.acceleration.size for task in tasks]
        work = EXPECTED * sum(len(task[0].contacts) * n for task, n in zip(tasks, samples, strict=True))
        titles = [wanted[key].title for key in order]
        for key, found in zip(
            order, self.workers.each(stage, scan, tasks, titles, work > WORTHWHILE, samples), strict=True
        ):
            self.found.setdefault(key, []).append(found)

    def _task(
        self, asked: Asked, halvings: int, scatter: Scatter, numbers: Mapping[str, int]
    ) -> tuple[Any, ...]:
        shaking, motion = asked.shaking, asked.shaking.motion
        near: float | From | None = None
        for _ in range(halvings):
            motion = motion.at_half_step()
        if halvings:
            near = level_found(self.found[asked.key][-1])
        elif asked.after is not None and not asked.reach.stripes:
            key = asked.after.key
            near = level_found(self.found[key][0]) if key in self.found else None
            if key in numbers:
                near = From(numbers[key], level_found)
        start = (shaking.model, motion, shaking.setting, shaking.start, scatter)
        campaign = self.project.campaign
        return (*start, asked.reach, near, (campaign.curve_members if campaign else None) or ())

    def of(self, asked: Asked, halvings: int | None = None) -> Scan:
        """Return the scan that was asked for at the time step halved so often, None: at the finest that was run.

        One that could not be completed at a finer step is that of the step before.
        """
        if isinstance(asked.shaking.start, str):
            return Scan(reason=asked.shaking.start)
        found = self.found[asked.key]
        if halvings is not None:
            return found[halvings]
        return next((each for each in reversed(found) if each.reason is None), found[0])

    def paired(self, one: Asked, other: Asked) -> tuple[Scan, Scan]:
        """Return the scans of two at the finest time step that both have."""
        if isinstance(one.shaking.start, str) or isinstance(other.shaking.start, str):
            return self.of(one), self.of(other)
        last = min(len(self.found[one.key]), len(self.found[other.key])) - 1
        return self.found[one.key][last], self.found[other.key][last]

    def first_told(self, asked: Asked) -> bool:
        """Whether messages and costs of a scan have not been told yet."""
        if isinstance(asked.shaking.start, str):
            return True
        first = asked.key not in self.told
        self.told.add(asked.key)
        return first

    def refine(self, stage: str, asked: Sequence[Asked]) -> list[tuple[Asked, ConvergenceRow, list[Message]]]:
        """Scan again, over all levels, with the time step halved twice: two may agree by chance; then until they do.

        Return the estimated error of each; nothing where the project asks for no accuracy.
        """
        accuracy = accuracy_of(self.project)
        if accuracy.tolerance is None:
            return []
        waiting = [
            each for each in asked if not isinstance(each.shaking.start, str) and not self.of(each).reason
        ]
        for halvings in range(1, accuracy.halvings + 1):
            self.run(stage, waiting, halvings)
            if halvings + 1 >= LEVELS:
                waiting = [each for each in waiting if (self._moved(each) or 0.0) > accuracy.tolerance]
        return [
            (each, *self._row(each, accuracy.tolerance))
            for each in asked
            if not isinstance(each.shaking.start, str) and not self.of(each, 0).reason
        ]

    def _moved(self, asked: Asked) -> float | None:
        """By how much, relative, the last halving moved the lowest collapse; None where one is not known."""
        last = [observed_in(each).lowest for each in self.found[asked.key][-2:]]
        if len(last) < 2 or last[0] is None or last[1] is None:
            return None
        return abs(last[1] / last[0] - 1.0)

    def _row(self, asked: Asked, tolerance: float) -> tuple[ConvergenceRow, list[Message]]:
        found, moved = self.found[asked.key], self._moved(asked)
        seen = [observed_in(each) for each in found]
        levels = [each.capacity for each in seen]
        failed = next((each.reason for each in found if each.reason), None)
        none = not any(levels) and not failed  # no step finds a collapse
        met = none or (moved is not None and moved <= tolerance and not failed)
        row = ConvergenceRow(
            state=asked.shaking.state,
            record=asked.shaking.motion.name,
            halvings=len(found) - 1,
            met=met,
            levels={"pga_collapse_g": levels},
        )
        last = levels[-1]
        if moved is not None and last is not None:
            error = moved * last + last * (1.0 - math.exp(-seen[-1].spacing))
            row = row.replace(pga_collapse_error_g=error, relative_error=error / last)
        if met:
            return row, []
        if failed:
            text = message("a finer time step fails: {reason}", reason=failed)
        elif moved is None:
            text = message("error of {key} not known: not every time step reaches it", key="pga_collapse_g")
        else:
            text = message(
                "the level at collapse moves by {moved:.0%} where the time step is halved to {step:g} s; "
                "take a smaller time_step_s",
                moved=moved,
                step=found[-1].time_step,
            )
        return row, [headed(asked.title, text)]


def reach_of(project: Project) -> Reach:
    """Return the levels that [incremental] and [campaign] share: the finer, and the farther, of what both ask for."""
    incremental, campaign = project.incremental, project.campaign
    scales = [table.max_scale for table in (incremental, campaign) if table is not None]
    ratio = SPACING if campaign is None else min(SPACING, 1.0 + campaign.tolerance)
    width = math.inf if incremental is None else incremental.tolerance_g
    return Reach(max(scales), ratio, width, project.scatter)


def own_setting(table: MotionTable) -> MotionTable:
    """Return how the motions of a table are integrated: the same for both tables, where they say the same."""
    return MotionTable(**{key: getattr(table, key) for key in MotionTable.model_fields})


def mirrored(project: Project, model: Assembly, table: MotionTable) -> bool:
    """Whether the structure as drawn responds to a record and to its negative with mirror images.

    The control point has to be its own mirror image too: its ultimate displacement may decide about collapse.
    """
    mirror = Mirror.of(model, table.contacts)
    point = project.control_point(table.control).point_m
    return mirror is not None and mirror.swaps(point, point)


def signed(shaking: Shaking, sign: int) -> Shaking:
    """Return the shaking by a record of this sign."""
    motion = shaking.motion
    return replace(shaking, motion=replace(motion, record=motion.record.scaled(float(sign))))


def observed_in(found: Scan) -> Observed:
    """Return what a scan shows; nothing of one that was not completed."""
    if found.reason is not None:
        return Observed(safe=0.0)
    return observed([each.pga_g for each in found.points], [each.collapsed for each in found.points])


def level_found(found: Scan) -> float | None:
    """Return a level (g) near the collapse of a scan, the largest one where none collapsed; None: not completed."""
    seen = observed_in(found)
    return seen.middle or seen.safe or None


def numbers(found: Scan) -> dict[str, Any]:
    """Return the keys of Scanned."""
    seen, known = observed_in(found), found.reason is None
    low, middle, high = seen.probable or (None, None, None)
    part = Scanned(
        pga_collapse_g=seen.capacity,
        pga_safe_g=seen.safe if known else None,
        lowest_collapse_g=seen.lowest,
        level_16_g=low,
        level_50_g=middle,
        level_84_g=high,
        beta=seen.beta if seen.probable else None,
        widest_gap_g=list(seen.gap) if seen.gap else None,
        time_step_s=found.time_step if known else None,
        resurrections_g=list(seen.stands),
        runs=found.counts.motions if found.counts else 0,
        points=found.points,
        reason=found.reason,
        notes=list(found.notes),
        counts=found.counts,
    )
    return {name: getattr(part, name) for name in Scanned.model_fields}
