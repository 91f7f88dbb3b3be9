"""The base motions that a project asks for: records read, scaled, cut, resampled; refused or doubted before any run."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations, zip_longest
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np

from assessment.project.project import Project
from assessment.project.schema import HistoryTable, MotionTable
from assessment.runtime.errors import ProjectError
from mechanics.messages import Message, headed, message, visible
from mechanics.records import HIGHEST_CREDIBLE_PGA, SAME_TIME, Record, read_record
from mechanics.types import Array

STRONGEST, WEAKEST = 2.0, 0.005  # g: beyond them the unit is probably another one
COARSEST = 0.05  # s: frequencies above 10 Hz, which records have, would be lost
SHORTEST = 5.0  # s
OFFSET = 0.02  # of the PGA: records that are corrected have a mean of some millionths
CUT = 0.2  # of the PGA: a record that begins or ends with more was cut off
KEPT = 0.02  # of the PGA: a step that changes it by more leaves another motion
SAME = 1e-4  # of the PGA: closer than this two records are one
MOST_SAMPLES = 200_000  # of a motion: a hundred seconds at half a millisecond
WHOLE = 1e-3  # of the peak acceleration: a window that loses no more of it holds the strong motion


@dataclass(frozen=True, eq=False)
class BaseMotion:
    """What shakes the base: `record` at the analysis' step in the window that begins at `start` (s) of the file."""

    record: Record
    original: Record  # the whole record, scaled
    pga: float  # g: largest horizontal acceleration in the window before resampling, `scale` included
    scale: float
    start: float = 0.0
    vertical: Record | None = None  # upward, at the instants of `record`
    notes: tuple[Message, ...] = ()  # what the user should know
    amplitude: float = 1.0  # of a member of an ensemble, a factor that `pga` and `scale` leave out

    @property
    def name(self) -> str:
        """Name in tables and figures."""
        return self.record.name

    @property
    def told_vertical(self) -> dict[str, Any]:
        """The vertical record and its largest acceleration (g), where there is one, as results name them."""
        return {"vertical_record": it.name, "vertical_pga_g": it.pga} if (it := self.vertical) else {}

    def halved(self, times: int = 1) -> Self:
        """Return the same broken lines with a sample between any two, so many times over."""
        if times == 0:
            return self
        step = 0.5 * self.record.time_step
        vertical = self.vertical and self.vertical.resampled(step)
        return replace(self, record=self.record.resampled(step), vertical=vertical).halved(times - 1)

    def at_amplitude(self, factor: float) -> Self:
        """Return the motion of a member of an ensemble."""
        record, vertical = self.record.scaled(factor), self.vertical and self.vertical.scaled(factor)
        return replace(self, record=record, vertical=vertical, amplitude=factor * self.amplitude)


def records_of(project: Project) -> list[Record]:
    """Return the records of all files of the project, each once, as read; RecordError names file, line and remedy."""
    files = [
        (project.path(name), each.time_step_s)
        for each in project.history
        for name in filter(None, (each.record, each.vertical_record))
    ]
    for table in (project.incremental, project.campaign):
        files += [(path, table.time_step_s) for path in project.record_files(table)] if table else []
    return list({(path, (record := _read(path, step)).time_step): record for path, step in files}.values())


def described(record: Record) -> str:
    """Return what `assesto check` prints of a record."""
    pga, step, length = f"PGA {record.pga:.3g} g", f"step {record.time_step:g} s", f"{record.duration:.1f} s"
    return f"record {visible(record.name)}: {pga}, {step}, {length}, unit {record.unit}"


def _read(path: Path, time_step: float | None) -> Record:
    """Read a record, or return it as it was read before of the same file."""
    return _read_once(path, time_step, path.stat().st_mtime_ns if path.exists() else 0)


_read_once = lru_cache(maxsize=64)(lambda path, time_step, changed: read_record(path, time_step))


def history_motions(project: Project) -> list[BaseMotion]:
    """Return the base motion of each [[history]]. Raises ProjectError or ValueError naming key or file."""
    motions = [
        _motion(project, f"history[{n}]", table, project.path(table.record), vertical, table)
        for n, table in enumerate(project.history, 1)
        for vertical in [project.path(table.vertical_record) if table.vertical_record else None]
    ]
    doubles = Counter(motion.name for motion in motions)
    for k, motion in enumerate(motions):
        if doubles[motion.name] > 1:
            record = replace(motion.record, name=f"{motion.name} × {motion.scale:g}")
            motions[k] = replace(motion, record=record)
    return motions


def set_motions(project: Project, key: Literal["incremental", "campaign"]) -> list[BaseMotion]:
    """Return the base motion, unscaled, of each record file of the table of that name. Raises as history_motions."""
    table = project.incremental if key == "incremental" else project.campaign
    files, vertical = (project.record_files(table, name) for name in ("records", "vertical_records"))
    if vertical and len(vertical) != len(files):
        text = f"{len(vertical)} files for {len(files)} records; write one of each, in the same order"
        raise ProjectError(f"{project.source}: {key}.vertical_records: {text}")
    pairs = dict.fromkeys(zip_longest(files, vertical))
    return [_motion(project, key, table, *pair) for pair in pairs] if table else []


def _motion(
    project: Project, key: str, table: MotionTable, path: Path, vertical: Path | None,
    history: HistoryTable | None = None,
) -> BaseMotion:  # fmt: skip
    scale = history.scale if history else 1.0
    record = _read(path, table.time_step_s).scaled(scale)
    if abs(scale) > 1.0 and record.pga > HIGHEST_CREDIBLE_PGA:
        raise ProjectError(f"{project.source}: {key}.scale: makes a PGA of {record.pga:.3g} g; write less")
    original = replace(record, name=history.name if history and history.name else visible(record.name))
    motion = replace(motion_of(project, key, table, original, path.name), scale=scale)
    if vertical is None:
        return motion
    where = f"{project.source}: {key}.{'vertical_record' if history else 'vertical_records'}: {vertical.name}"
    if vertical == path:
        raise ProjectError(f"{where} is the horizontal record itself; name its vertical component")
    whole = _read(vertical, table.time_step_s).scaled(scale)
    return replace(motion, vertical=_vertical(whole, motion.record, motion.start, where))


def motion_of(project: Project, key: str, table: MotionTable, whole: Record, source: str = "") -> BaseMotion:
    """Return the motion of a record (of the file `source`) in a table's window and step. Raises ProjectError."""
    if table.damping_ratio and table.contacts == "rigid":
        text = 'rigid contacts have no stiffness to damp; leave it out or write contacts = "elastic"'
        raise ProjectError(f"{project.source}: {key}.damping_ratio: {text}")
    where = f"{project.source}: {key}: {source or whole.name}"
    try:
        window = whole.strong_window() if table.window_s == "arias" else table.window_s
        cut = whole.windowed(*window) if window else whole
        if table.time_step_s and cut.duration > MOST_SAMPLES * table.time_step_s:
            most = f"more than {MOST_SAMPLES} samples of {cut.duration:g} s; write more, or a window_s"
            raise ValueError(f"time_step_s = {table.time_step_s:g} makes {most}")
    except ValueError as error:
        raise ProjectError(f"{where}: {error}") from None
    record = _at_step(cut, table.time_step_s or cut.time_step, where)
    start = 0.0
    if window:  # it begins at the first sample inside it
        start = float(whole.time[whole.time > window[0] - SAME_TIME * whole.time_step][0])
    notes: tuple[Message, ...] = ()
    if cut.pga < (1.0 - WHOLE) * whole.pga:
        notes = (headed(whole.name, message(
            "the window leaves out the peak of {peak:.3g} g; PGA means {pga:.3g} g, "
            "the largest acceleration inside it", peak=whole.pga, pga=cut.pga,
        )),)  # fmt: skip
    return BaseMotion(record, whole, cut.pga, 1.0, start, notes=notes)


def _at_step(record: Record, step: float, where: str) -> Record:
    """Return the record at another step (s). Raises ProjectError for one between whose instants its peaks fall."""
    if step <= min(max(COARSEST, (1.0 + SAME_TIME) * record.time_step), record.duration):
        found = record.resampled(step)
        if abs(found.pga - record.pga) <= KEPT * record.pga:
            return found
    text = f"a step of {step:g} s does not keep its PGA of {record.pga:.3g} g"
    raise ProjectError(f"{where}: {text}; write time_step_s = {record.time_step:g}, its own, or half of it")


def _vertical(whole: Record, horizontal: Record, start: float, where: str) -> Record:
    """Vertical acceleration at the samples of the horizontal one; both files begin at the same instant."""
    missing = start + horizontal.duration - whole.duration
    if missing > horizontal.time_step:
        raise ProjectError(f"{where} ends {missing:.3g} s before the horizontal one; give more or a window_s")
    a, step = _at(whole, start + horizontal.time), horizontal.time_step
    if step > (1.0 + SAME_TIME) * whole.time_step:  # what the step cannot carry is damped
        count = int(np.ceil(horizontal.duration / whole.time_step - SAME_TIME)) + 1
        begun = _at(whole, start + whole.time_step * np.arange(count, dtype=float))
        a = _at_step(replace(whole, acceleration=begun), step, where).acceleration[: a.size]
    return Record(a, step, visible(whole.name))


def _at(record: Record, time: Array) -> Array:
    """Return the accelerations (k,) g of the broken line at `time` (k,) s; zero beyond the record's end."""
    beyond = time > record.duration + SAME_TIME * record.time_step
    return np.where(beyond, 0.0, np.interp(time, record.time, record.acceleration))


def check_record_set(project: Project, key: str, motions: Sequence[BaseMotion]) -> None:
    """Raise ProjectError where two records of the table `key` have one name, or are one motion but for a factor."""
    for one, other in combinations(motions, 2):
        where, a, b = f"{project.source}: {key}.records", one.original, other.original
        if one.name == other.name:
            called = f'two records are called "{one.name}"'
            raise ProjectError(f"{where}: {called}; rename a file, tables tell them apart by their names")
        if a.acceleration.size == b.acceleration.size and a.time_step == b.time_step:
            x, y = (each.acceleration / each.pga for each in (a, b))
            if min(np.abs(x - y).max(), np.abs(x + y).max()) < SAME:
                same = f"{one.name} and {other.name} are the same motion"
                raise ProjectError(f"{where}: {same}; keep one, or both count as two records")


def doubtful_records(motions: Sequence[BaseMotion]) -> list[Message]:
    """Return a warning for each record of a campaign whose unit or length is implausible."""
    found = []
    for motion in motions:
        record, doubts = motion.original, [*doubtful_units(motion.original)]
        if record.duration < SHORTEST:
            doubts.append(message("lasts {duration:.3g} s; check that it is whole", duration=record.duration))
        elif max(abs(record.acceleration[[0, -1]])) > CUT * record.pga:
            doubts.append(message("begins or ends with strong motion; check that it is whole"))
        found += [message("campaign, {record}: {text}", record=motion.name, text=doubt) for doubt in doubts]
    return found


def doubtful_units(record: Record) -> Iterator[Message]:
    """Yield a warning where the unit of accelerations or times, or the base line, of a record is implausible."""
    pga, step, mean = record.pga, record.time_step, float(record.acceleration.mean())
    if not WEAKEST < pga < STRONGEST:
        yield message(
            "a PGA of {pga:.3g} g, read in {unit}; check the unit of the file, and name it in its heading",
            pga=pga, unit=record.unit,
        )  # fmt: skip
    if step > COARSEST:
        yield message("a time step of {step:.3g} s; name the unit of the times in the heading", step=step)
    if abs(mean) > OFFSET * pga:
        yield message("a mean of {mean:.2g} g; correct its base line, unless it is a pulse", mean=mean)
