"""P(collapse | level) of one record from one state: which levels are run, and what they came to.

Collapse of rocking masonry comes in bands of the level: no bisection finds the lowest. Levels form a lattice, a factor
`ratio` apart (5 % at most), through the record's own PGA:

    outwards from where collapse is expected, in strides that double downwards, until a level on the other side is found
    every level down to DOWN of the lowest that collapses; a collapse there begins this again
    upwards, until CERTAIN levels in a row above the highest that stands collapse
    the levels of the project's histories of the record
    downwards in strides of DOWN, until the level that counts is not below all that were run (probit of bands far apart)
    where a level may hide a collapse: half-way to the next that was run, or below all, to DOWN² of the lowest
    the lowest bracket is halved to the width asked for

A level with a peak displacement u hides no collapse nearer than CLOSEST (u_max/u)³ in ln level. u_max is the largest
with which the structure stood (docs/campaigns.md, "Where a collapse hides"); so far counts any level within SPACING of
the lowest collapse.
"""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from assessment.analyses.fragility import Observed, observed
from assessment.analyses.histories import Scatter, Track, enough, lowest_median_highest
from assessment.analyses.time_history import Shaking, respond, thinned
from assessment.results.schema import Counts, Level, MemberCurve, present
from mechanics import ConvergenceError
from mechanics.messages import Message, message
from mechanics.progress import stretch

SPACING = 1.05  # the largest ratio of levels
DOWN = 0.7  # of the lowest collapse: down to there every level is run
CERTAIN = 2  # levels in a row above all that stand
FARTHEST = 8  # levels: the longest stride down to the first that stands
UPWARDS = 2  # levels: the longest stride up to the first collapse, not to pass over a band
CLOSEST = 0.0125  # ln level: the spacing beside a level that moves the structure as far as it ever stood
LEAST = 1e-3  # g: the lowest level
CURVE_POINTS = 400  # of a curve: those of ten thousand motions stay below 100 MB
EXPECTED = 25  # motions of a scan, about


@dataclass(frozen=True)
class Reach:
    """Which levels are run: up to `max_scale` times the record's PGA, a factor `ratio` apart."""

    max_scale: float
    ratio: float = SPACING
    width: float = math.inf  # g, of the lowest bracket, at most
    stripes: tuple[float, ...] = ()  # these levels (PGA, g) alone
    # record and factor of motions that are computed too: none of them falls below what the scan has found
    histories: tuple[tuple[str, float], ...] = ()


@dataclass
class Scan:
    """What a scan found: `points` of every level (PGA, g) run, time step (s), counts, worst residual, seconds."""

    points: list[Level] = field(default_factory=list)
    time_step: float = 0.0
    stripes: bool = False
    reason: Message | None = None  # why there is no answer
    # warnings of the motions, and levels whose outcome is not known
    notes: list[Message] = field(default_factory=list)
    counts: Counts | None = None
    worst: float = 0.0
    seconds: float = 0.0

    @cached_property
    def seen(self) -> Observed:
        """What the levels show; nothing of a scan that was not completed."""
        runs = [] if self.reason is not None else self.points
        return observed([point.pga_g for point in runs], [point.collapsed for point in runs])

    @property
    def near(self) -> float | None:
        """A level (g) near the collapse, the largest one where none collapsed; None: not completed."""
        return self.seen.middle or self.seen.safe or None

    @property
    def numbers(self) -> dict[str, Any]:
        """What the results have of it, by the keys of Scanned."""
        seen, done = self.seen, self.reason is None
        low, middle, high = seen.probable or (None, None, None)
        tie = next((point.broken_tie for point in self.points if point.pga_g == seen.lowest), None)
        more: dict[str, Any] = {"broken_tie": tie} if tie else {}
        more |= {"collapsed": [point.collapsed for point in self.points]} if self.stripes and done else {}
        return more | {
            "pga_collapse_g": seen.capacity, "pga_safe_g": seen.safe if done else None,
            "lowest_collapse_g": seen.lowest, "level_16_g": low, "level_50_g": middle, "level_84_g": high,
            "beta": seen.beta if seen.probable else None, "widest_gap_g": list(seen.gap) if seen.gap else None,
            "time_step_s": self.time_step if done else None, "resurrections_g": list(seen.stands),
            "runs": self.counts.motions if self.counts else 0, "points": self.points, "reason": self.reason,
            "notes": list(self.notes), "counts": self.counts,
            "pga_collapse_range": None if seen.lowest is None else [seen.capacity, seen.certain],
        }  # fmt: skip


def scan(
    shaking: Shaking, scatter: Scatter, reach: Reach, near: float | None = None, curves: tuple[int, ...] = ()
) -> Scan:
    """Run the levels of a record from a state at rest.

    `near` (g): where collapse is expected, None: not known. `curves`: numbers of the motions of a level whose curves
    are kept. A motion that cannot be completed counts as a collapse: most of these fall.
    """
    levels, motion = _Motions(shaking, scatter, reach, curves), shaking.motion
    found = Scan(time_step=motion.record.time_step, stripes=bool(reach.stripes))
    began = time.perf_counter()
    if reach.stripes:
        for pga in reach.stripes:
            levels.peak(pga)
    else:
        also = [abs(factor) * motion.pga for name, factor in reach.histories if name == motion.name]
        scan_levels(levels.peak, motion.pga, reach, near, also)
    found.points = [levels.points[pga] for pga in sorted(levels.points)]
    if levels.refused and len(levels.refused) == len(found.points):
        found.reason = next(iter(levels.refused.values()))
    every = levels.counts["motions"]
    for alike in levels.notes.values():
        count, text = len(alike), alike[0]
        found.notes.append(message("{count} of {all} motions: {text}", count=count, all=every, text=text))
    if levels.refused and found.reason is None:
        text = message("whether it collapses at {levels:.3g} g is not known and counts as a collapse: {reason}",
                       levels=list(levels.refused), reason=next(iter(levels.refused.values())))  # fmt: skip
        found.notes.append(text)
    if every:
        found.counts = Counts(**levels.counts)
    found.worst, found.seconds = levels.worst, time.perf_counter() - began
    return found


def scan_levels(
    peak: Callable[[float], float], pga: float, reach: Reach, near: float | None = None, also: Sequence[float] = ()
) -> None:  # fmt: skip
    """Ask for the `peak` displacement (m) at levels (g) near the lowest collapse; `pga` (g): of the record.

    The peak of a collapse is ∞. `also` (g): levels that are run, and around which collapse is looked
    for as well.
    """
    lattice = _Lattice(peak, pga, reach)
    # outwards from the level expected: upwards until one falls, or downwards until one stands
    place, stride = lattice.nearest(near or pga), 1
    fell = lattice.falls(place)
    end = lattice.bottom if fell else lattice.top
    while place != end and lattice.falls(place) is fell:
        place = max(place - stride, end) if fell else min(place + stride, end)
        stride = min(2 * stride, FARTHEST if fell else UPWARDS)
    lattice.run(place)
    for level in also:
        lattice.run(lattice.place(level))
    while (next_one := lattice.suspected()) is not None:
        lattice.run(next_one)
    while (bracket := lattice.bracket()) and bracket[1] - bracket[0] > reach.width:
        half = lattice.place(math.sqrt(bracket[0] * bracket[1]) if bracket[0] else 0.5 * bracket[1])
        if half in lattice.peaks:  # no narrower
            break
        lattice.falls(half)


class _Lattice:
    """The levels pga·ratio^k, up to the largest; peaks of the places k that were run, whole numbers or not."""

    def __init__(self, peak: Callable[[float], float], pga: float, reach: Reach) -> None:
        self.peak, self.pga, self.ratio = peak, pga, reach.ratio
        self.largest = reach.max_scale * pga
        self.step = math.log(reach.ratio)
        self.top = math.ceil(math.log(reach.max_scale) / self.step - 1e-9)
        self.bottom = min(math.ceil(math.log(LEAST / pga) / self.step), self.top)
        self.depth = math.ceil(math.log(1.0 / DOWN) / self.step - 1e-9)
        self.peaks: dict[float, float] = {}

    def place(self, level: float) -> float:
        """Return the place of a level (g); a level of the lattice to rounding is there."""
        return round(math.log(level / self.pga) / self.step, 9)

    def nearest(self, level: float) -> int:
        """Return the place of the lattice that is nearest to a level (g)."""
        return min(max(round(self.place(level)), self.bottom), self.top)

    def level(self, place: float) -> float:
        """Return the level (g) of a place."""
        return min(self.pga * self.ratio**place, self.largest)

    def falls(self, place: float) -> bool:
        if place not in self.peaks:
            self.peaks[place] = self.peak(self.level(place))
        return self.peaks[place] == math.inf

    def run(self, place: float) -> None:
        """Run a place, and those that have then still to be run, each next one by what the last has shown."""
        missing: float | None = place
        while missing is not None:
            self.falls(missing)
            low = math.ceil(min(self.those(True), default=self.top + 1))
            high = math.floor(max(self.those(False), default=low - 1))
            below = range(low - 1, max(low - self.depth, self.bottom) - 1, -1)
            above = range(low + 1, min(max(high, low - 1) + CERTAIN, self.top) + 1)
            missing = next((each for each in (*below, *above) if each not in self.peaks), None)

    def those(self, fell: bool) -> list[float]:
        return [place for place in self.peaks if self.falls(place) is fell]

    def suspected(self) -> float | None:
        """Return the place where a lower collapse is to be looked for next; None: nowhere.

        It is below all that were run where the level that counts is there, else where one is most likely to hide.
        """
        lowest, levels = math.floor(min(self.peaks)), [self.level(place) for place in self.peaks]
        counts = observed(levels, [self.falls(place) for place in self.peaks]).capacity
        if counts is not None and counts < self.level(min(self.peaks)) and lowest > self.bottom:
            return max(lowest - self.depth, self.bottom)
        return self.hiding()

    def hiding(self) -> float | None:
        """Return the place below the lowest collapse that is most likely to hide another; None: no place is."""
        low = min(self.those(True), default=-math.inf)
        largest = max((self.peaks[place] for place in self.those(False)), default=0.0)
        runs = sorted(place for place in self.peaks if place <= low)
        if not largest or not runs:
            return None
        near = low - math.log(SPACING) / self.step - 1e-9
        shares = [1.0 if place >= near else (self.peaks[place] / largest) ** 3 for place in runs]
        hidden = [
            ((above - below) * max(both), 0.5 * (below + above))
            for (below, above), both in zip(pairwise(runs), pairwise(shares), strict=True)
        ]
        closest, lowest = CLOSEST / self.step, math.floor(runs[0])
        if lowest > max(self.bottom, low - 2 * self.depth):
            known = min(closest / shares[0], self.depth) if shares[0] else self.depth
            hidden.append((self.depth * shares[0], max(lowest - max(math.floor(known), 1), self.bottom)))
        most, place = max(hidden, default=(0.0, 0.0))
        return place if most > closest else None

    def bracket(self) -> tuple[float, float] | None:
        """Return the largest level (g) below all collapses, 0: none, and the lowest collapse; None without one."""
        low = min(self.those(True), default=None)
        if low is None:
            return None
        below = (self.level(place) for place in self.those(False) if place < low)
        return max(below, default=0.0), self.level(low)


@dataclass(frozen=True, eq=False)
class _Member(Track):
    """A motion: when it ended (s of the window, ∞: not known), why it `fell`, and the share of the integrator."""

    end: float
    fell: str
    integrator: float


@dataclass
class _Motions:
    """The motions of a scan, level by level (g)."""

    shaking: Shaking
    scatter: Scatter
    reach: Reach
    curves: tuple[int, ...]
    points: dict[float, Level] = field(default_factory=dict)
    notes: dict[str, list[Message]] = field(default_factory=dict)  # by their template
    refused: dict[float, Message] = field(default_factory=dict)  # why a level could not be completed
    counts: dict[str, int] = field(default_factory=lambda: {"motions": 0})
    worst: float = 0.0

    def peak(self, pga: float) -> float:
        """Run the motions of a level, of stripes the members of an ensemble; return the peak (m), ∞: collapse."""
        scatter = self.scatter if self.reach.stripes else replace(self.scatter, members=1)
        members: list[_Member] = []
        while not enough(members, scatter, self.shaking.model.size):
            members.append(self._run(pga, len(members)))
        self.points[pga] = self._point(pga, members)
        peak = self.points[pga].peak_displacement_m
        return math.inf if peak is None else peak

    def _run(self, pga: float, number: int) -> _Member:
        factor = self.scatter.strongest_first[number] * pga / self.shaking.motion.pga
        done = self.counts["motions"]
        expected = max(len(self.reach.stripes) or EXPECTED, done + 1)
        with stretch(done / expected, (done + 1) / expected):
            try:
                found = respond(self.shaking, factor, to_rest=False)
            except ConvergenceError as error:
                self.refused[pga] = error.message
                return _Member(np.zeros(1), np.zeros(1), True, math.inf, error.message, 0.0)
        self.counts["motions"] += 1
        for name, count in found.counts().items():
            self.counts[name] = self.counts.get(name, 0) + count
        self.worst = max(self.worst, found.worst)
        firsts = {note.template: note for note in reversed(found.notes)}  # a motion counts once
        for template, note in firsts.items():
            self.notes.setdefault(template, []).append(note)
        end, fell = float(found.time[-1]), found.last.collapse_reason
        return _Member(found.time, found.displacement, found.collapsed, end, fell, found.integrator_share())

    def _point(self, pga: float, members: Sequence[_Member]) -> Level:
        """Return what the motions of a level come to; it counts as a collapse if any collapses."""
        first = min((each for each in members if each.collapsed), key=lambda each: each.end, default=None)
        peaks = [None if each.collapsed else float(abs(each.displacement).max()) for each in members]
        low, _, high = lowest_median_highest(peaks)
        ended = first is not None and first.end < math.inf
        tie = first.fell.fields.get("tie") if first and ended and isinstance(first.fell, Message) else None
        kept = [*self._curves(members)] if self.curves else None
        more: dict[str, Any] = present({"broken_tie": tie and str(tie), "curves": kept})
        return Level(
            pga_g=pga, peak_displacement_m=high, peak_displacement_m_range=[low, high],
            residual_displacement_m=None if first else max(abs(float(m.displacement[-1])) for m in members),
            members=len(members), members_collapsed=peaks.count(None), collapsed=first is not None,
            time_of_collapse_s=self.shaking.motion.start + first.end if first and ended else None,
            reason=first.fell if first else None, integrator_share=max(each.integrator for each in members),
            **more,
        )  # fmt: skip

    def _curves(self, members: Sequence[_Member]) -> Iterator[MemberCurve]:
        for number in sorted(number for number in self.curves if number <= len(members)):
            member = members[number - 1]
            kept = thinned(member.displacement, CURVE_POINTS)
            yield MemberCurve(
                member=number, factor=self.scatter.strongest_first[number - 1],
                time_s=(self.shaking.motion.start + member.time[kept]).round(6).tolist(),
                displacement_m=member.displacement[kept].round(7).tolist(),
            )  # fmt: skip
