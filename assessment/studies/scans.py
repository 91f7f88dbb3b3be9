"""The motions that [incremental] and [campaign] share: a record of one sign from one state is scanned once."""

import math
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from operator import attrgetter
from pathlib import Path
from typing import Any

from assessment.analyses.found import LEVELS, accuracy_of
from assessment.analyses.histories import scatter_of
from assessment.analyses.scan import EXPECTED, SPACING, Reach, Scan, scan
from assessment.analyses.time_history import WORTHWHILE, Setting, Shaking, Start, quality_row
from assessment.project.motions import BaseMotion
from assessment.project.project import Project
from assessment.project.schema import MotionTable
from assessment.results.schema.studies import ConvergenceRow
from assessment.runtime.cache import fingerprint
from assessment.runtime.tasks import From, Workers
from assessment.studies.variants import Study
from mechanics import Assembly
from mechanics.messages import Message, headed, message, visible
from mechanics.procedures import Mirror

# without an accuracy: scans at which the time step is halved, how often, and by how much their levels may move
LOOKED_AT, LOOKS, LOOKED_TO = 3, 2, 0.05
SCALED = 3.0  # factor on a record beyond which its level is no longer that of such an earthquake


@dataclass(frozen=True, eq=False)
class Place:
    """A state that is shaken: its assembly, where it rests or why not; `path`: the movement it follows on."""

    title: Message
    path: str
    model: Assembly
    start: Start
    ultimate: float | None  # m: where the static capacity vanishes in both directions; None: not known
    d_0_m: float | None  # m: in the first; None: not known


@dataclass(frozen=True, eq=False)
class Asked:
    """A record of one `sign` from a state; `shaking` has the sign that is run."""

    shaking: Shaking
    sign: int
    run_sign: int  # one for both signs of a structure that is its own mirror image
    reach: Reach
    state: Place
    after: "Asked | None" = None  # the one at whose level it begins
    ratio: float = 1.0  # measure of intensity over the PGA of the record

    @property
    def record(self) -> str:
        """Name of the record."""
        return self.shaking.motion.name

    @property
    def title(self) -> Message:
        """State, record and sign, for messages."""
        sign = "+" if self.sign > 0 else "−"
        return message("{state}, {record}, {sign}", state=self.shaking.state, record=self.record, sign=sign)

    @cached_property
    def key(self) -> str:
        """Key of the scan: what its motions depend on."""
        return fingerprint(scan, (replace(self.shaking, state=""), self.reach))


def asked_for(
    project: Project, table: MotionTable, drawn: Assembly, places: Iterable[Place], motions: Sequence[BaseMotion],
    signs: Sequence[int], reach: Reach, ratio: Mapping[str, float],
) -> list[Asked]:  # fmt: skip
    """Return every record with every sign from every state.

    A scan begins at the level found for the same record and sign at the state before on its path, else for the record's
    first sign, else the first record. Where the structure as `drawn` is its own mirror image one sign of it is run.
    """
    control, mirror = project.control_point(table.control), Mirror.of(drawn, table.contacts)
    symmetric = mirror is not None and mirror.swaps(control.point_m, control.point_m)
    integrated = MotionTable(**{key: getattr(table, key) for key in MotionTable.model_fields})
    found: list[Asked] = []
    before: dict[Hashable, Asked] = {}
    for place, motion in product(places, motions):
        setting = Setting(integrated, control, place.ultimate, project.contacts.sliding)
        for sign in signs:
            run_sign = signs[0] if symmetric and place.start is drawn.initial else sign
            at, by = (place.path, motion.name, sign), ratio[motion.name]
            # begins at the level of the state before on its path, else of the first sign, else of the first record
            after = before.get(at) or before.get(motion.name) or (found[0] if found else None)
            turned = replace(motion, record=motion.record.scaled(float(run_sign)))
            shaking = Shaking(place.model, turned, setting, place.start, str(place.title))
            own = replace(reach, stripes=tuple(level / by for level in reach.stripes))
            before[at] = Asked(shaking, sign, run_sign, own, place, after, by)
            before.setdefault(motion.name, before[at])
            found.append(before[at])
    return found


@dataclass
class Scans:
    """Scans of a run by key and by how often the time step is halved; what is there is not run again.

    `counts`: halvings of the step that counts, where finer ones were run only to look at it; None: the finest counts.
    """

    project: Project
    workers: Workers
    found: dict[str, dict[int, Scan]] = field(default_factory=dict)
    told: set[str] = field(default_factory=set)
    counts: int | None = None

    def run(self, stage: str, asked: Sequence[Asked], halvings: int = 0) -> None:
        """Scan what has not been scanned, the longest records first, at a time step that is halved so often."""
        new: dict[str, Asked] = {}
        for each in asked:
            if each.shaking.starts and halvings not in self._by_step(each):
                new.setdefault(each.key, each)
        wanted = sorted(new.values(), key=lambda each: -each.shaking.motion.record.acceleration.size)
        numbers = {each.key: number for number, each in enumerate(wanted)}
        campaign = self.project.campaign
        curves, scatter = (campaign.curve_members if campaign else None) or (), scatter_of(self.project)
        tasks: list[tuple[Any, ...]] = []
        for each in wanted:
            # states of several names are one scan
            shaking = replace(each.shaking, motion=each.shaking.motion.halved(halvings), state="")
            tasks.append((shaking, scatter, each.reach, self._near(each, numbers), curves))
        samples = [shaking.motion.record.acceleration.size for shaking, *_ in tasks]
        work = EXPECTED * sum(len(of.model.contacts) * n for (of, *_), n in zip(tasks, samples, strict=True))
        titles = [each.title for each in wanted]
        done = self.workers.each(stage, scan, tasks, titles, work > WORTHWHILE, samples)
        for each, found in zip(wanted, done, strict=True):
            self.found.setdefault(each.key, {})[halvings] = found

    def _near(self, asked: Asked, numbers: Mapping[str, int]) -> float | From | None:
        """Return the level that a scan begins at, or which of the tasks it is taken `From`."""
        known = [each for each in (asked, asked.after) if each is not None and each.key in self.found]
        if known:
            return self.of(known[0]).near
        if asked.after is not None and asked.after.key in numbers and not asked.reach.stripes:
            return From(numbers[asked.after.key], attrgetter("near"))
        return None

    def _by_step(self, asked: Asked) -> dict[int, Scan]:
        """The scans of what is asked for, by halvings of the time step."""
        return self.found.get(asked.key, {}) if asked.shaking.starts else {}

    def of(self, asked: Asked) -> Scan:
        """Return the scan at the time step that counts; of one not completed that of the finest that was."""
        if isinstance(asked.shaking.start, str):
            return Scan(reason=asked.shaking.start)
        found = self.found[asked.key]
        if self.counts in found and found[self.counts].reason is None:
            return found[self.counts]
        finest = (found[n] for n in sorted(found, reverse=True) if found[n].reason is None)
        return next(finest, found[min(found)])

    def paired(self, one: Asked, other: Asked) -> tuple[Scan, Scan]:
        """Return the scans of two at one time step: where both are completed, that which counts, else the finest."""
        steps, others = self._by_step(one), self._by_step(other)
        if not (both := steps.keys() & others.keys()):
            return self.of(one), self.of(other)
        completed = {n for n in both if steps[n].reason is None and others[n].reason is None} or both
        at = self.counts if self.counts in completed else max(completed)
        return steps[at], others[at]

    def tell(self, asked: Asked, stage: str, study: Study) -> None:
        """Add messages, certificates and seconds of a scan to a study, once."""
        found = self.of(asked)
        if not asked.shaking.starts:
            study.warnings += [headed(asked.title, found.reason)] if found.reason else []
            return
        if asked.key in self.told:
            return
        self.told.add(asked.key)
        if found.counts:
            what = asked.shaking.state, f"{stage}, {asked.record}"
            study.quality.append(quality_row(*what, found.counts.programs, found.worst))
        study.failures += [headed(asked.title, found.reason)] if found.reason is not None else []
        study.warnings += [headed(asked.title, text) for text in (*found.notes, *_doubts(asked, found))]
        study.seconds += found.seconds

    def refine(self, asked: Sequence[Asked], study: Study) -> list[ConvergenceRow]:
        """Scan again with the time step halved twice, then until levels agree; return errors, if accuracy is asked."""
        accuracy = accuracy_of(self.project)
        if accuracy.tolerance is None:
            return []
        known = [each for each in asked if each.shaking.starts and self.found[each.key][0].reason is None]
        waiting = known
        for halvings in range(1, accuracy.halvings + 1):
            self.run("finer: incremental", waiting, halvings)
            if halvings + 1 >= LEVELS:
                waiting = [each for each in waiting if (self._moved(each) or 0.0) > accuracy.tolerance]
        return [self._row(each, accuracy.tolerance, study) for each in known]

    def settle(self, stage: str, asked: Sequence[Asked], looks: bool, study: Study) -> None:
        """Scan all at the time step that some of them need, or those known at several; not `looks`: as given."""
        tables = [each.shaking.setting.table for each in asked]
        elastic = [t for t in tables if t.contacts == "elastic" and t.integrator != "implicit-euler"]
        if not all(table.damping_ratio for table in elastic):
            study.warnings.append(message(
                "{stage}: elastic joints without {key} lose nothing at impacts, and levels at collapse depend on the "
                "time step: those of an arch of nine blocks were 20 % too high at 2.5 ms; with {key} = 0.02 it bore "
                "twice as much", stage=stage, key="damping_ratio",
            ))  # fmt: skip
        looked = [each for each in asked if len(self._by_step(each)) > 1]
        if not looked:
            self.run(stage, asked)
            looked = self._spread(asked) if looks else []
            for halvings in range(1, LOOKS + 1 if looked else 1):
                self.run(f"finer: {stage}", looked, halvings)
                if self.needed(looked)[0] < halvings:
                    break
            self.counts = self.needed(looked)[0] if looked else None
        halvings, moved = self.needed(looked)
        self.run(stage, asked, halvings)
        if halvings:
            study.warnings.append(message(
                "{stage}: time step halved {count} times: levels at collapse at the one given differ by {moved:.0%} "
                "in the mean", stage=stage, moved=math.exp(moved) - 1.0, count=halvings,
            ))  # fmt: skip

    def _spread(self, asked: Sequence[Asked]) -> list[Asked]:
        """Return LOOKED_AT scans, evenly spaced among those that collapse: of several records and of several states."""
        each_once = {each.key: each for each in asked if each.shaking.starts}.values()
        every = [each for each in each_once if self.of(each).seen.lowest] or list(each_once)
        spread = sorted({k * (len(every) - 1) // (LOOKED_AT - 1) for k in range(LOOKED_AT)})
        return [every[k] for k in spread if every]

    def needed(self, asked: Sequence[Asked]) -> tuple[int, float]:
        """Return how often the time step has to be halved, and by how much, in ln, the one given moves the levels.

        That is as often as the mean of the lowest collapses differs from that of the finest step by more than the
        tolerance: a level by itself may turn on the last digits. A scan counts that was run at
        several steps and collapses at one; at the others its largest level stands for the lowest collapse.
        """
        moved: dict[int, list[float]] = {}
        for found in {each.key: self._by_step(each) for each in asked}.values():
            seen = {n: each.seen for n, each in found.items()}
            lowest = {n: each.lowest or each.safe for n, each in seen.items() if each.lowest or each.safe}
            fell = len(lowest) > 1 and any(each.lowest for each in seen.values())
            for n, level in lowest.items() if fell else ():
                moved.setdefault(n, []).append(math.log(level / lowest[max(lowest)]))
        mean = {n: sum(moved[n]) / len(moved[n]) for n in sorted(moved)}
        tolerance = accuracy_of(self.project).tolerance or LOOKED_TO
        wrong = [n for n in mean if abs(mean[n]) > tolerance]
        return (wrong[-1] + 1 if wrong else 0), mean.get(0, 0.0)

    def _moved(self, asked: Asked) -> float | None:
        """By how much, relative, the last halving moved the lowest collapse; None where one is not known."""
        found = self.found[asked.key]
        last = [found[n].seen.lowest for n in sorted(found)[-2:]]
        if len(last) < 2 or last[0] is None or last[1] is None:
            return None
        return abs(last[1] / last[0] - 1.0)

    def _row(self, asked: Asked, tolerance: float, study: Study) -> ConvergenceRow:
        by_step, moved = self.found[asked.key], self._moved(asked)
        found = [by_step[n] for n in sorted(by_step)]
        levels = [each.seen.capacity for each in found]
        failed = next((each.reason for each in found if each.reason), None)
        none = not any(levels) and not failed  # no step finds a collapse
        met = none or (moved is not None and moved <= tolerance and not failed)
        row = ConvergenceRow(
            state=asked.shaking.state, record=asked.record, halvings=len(found) - 1, met=met,
            levels={"pga_collapse_g": levels},
        )  # fmt: skip
        if moved is not None and (last := levels[-1]) is not None:
            error = moved + 1.0 - math.exp(-found[-1].seen.spacing)
            row = row.replace(pga_collapse_error_g=error * last, relative_error=error)
        if met:
            return row
        if failed:
            text = message("a finer time step fails: {reason}", reason=failed)
        elif moved is None:
            text = message("error of {key} not known: not every time step reaches it", key="pga_collapse_g")
        else:
            text = message(
                "the level at collapse moves by {moved:.0%} where the time step is halved to {step:g} s; "
                "take a smaller time_step_s", moved=moved, step=found[-1].time_step,
            )  # fmt: skip
        study.warnings.append(headed(asked.title, text))
        return row


def _doubts(asked: Asked, found: Scan) -> Iterator[Message]:
    """Yield what to know of the levels of a record: no collapse, bands, a record scaled far."""
    seen, motion = found.seen, asked.shaking.motion
    if found.reason is not None or found.stripes:
        return
    if seen.lowest is None:
        yield message("no collapse up to a PGA of {safe:.3g} g at the surface, max_scale = {scale:g}; raise it to find "
                      "one", safe=seen.safe, scale=asked.reach.max_scale)  # fmt: skip
    elif seen.stands:
        yield message(
            "collapse at a PGA of {pga:.3g} g at the surface, but stands at {levels:.3g} g; "
            "{counts:.3g} g counts, of 16 % of the levels around", pga=seen.lowest, levels=list(seen.stands),
            counts=seen.capacity or seen.lowest,
        )  # fmt: skip
    factor = abs(motion.scale) * (seen.lowest or seen.safe) / motion.pga
    if factor > SCALED:
        yield message("the record is scaled by {factor:.2g}; earthquakes so strong have other durations and spectra",
                      factor=factor)  # fmt: skip


def reach_of(project: Project) -> Reach:
    """Return the levels that [incremental] and [campaign] share: the finer, and the farther, of what both ask for."""
    incremental, campaign = project.incremental, project.campaign
    scales = [table.max_scale for table in (incremental, campaign) if table is not None]
    ratio = SPACING if campaign is None else min(SPACING, 1.0 + campaign.tolerance)
    width = math.inf if incremental is None else incremental.tolerance_g
    histories = tuple((visible(Path(table.record).stem), table.scale) for table in project.history)
    return Reach(max(scales), ratio, width, histories=histories)
