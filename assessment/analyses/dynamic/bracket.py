"""The peak ground accelerations at which a structure collapses: some members of an ensemble, and all of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

# shares of the PGA at collapse that are run as well: a weaker motion may collapse a structure too
BELOW = (0.2, 0.4, 0.6, 0.8)
ABOVE = (1.2, 1.4, 1.6)
DOUBLE = 2.0  # the longest step, a factor, in search of a level on the other side

Judge = Callable[[float], bool]
"""Whether some, or all, members of an ensemble collapse at a level (g)."""


@dataclass(frozen=True)
class Bracket:
    """All members withstood the level `safe` (g); `collapse` (g): the lowest level tried at which a member collapsed.

    `certain` (g): the lowest level tried at which all members collapsed. None: there was no such level. `resurrections`
    (g): levels above `collapse` that all members withstood.
    """

    safe: float
    collapse: float | None
    certain: float | None
    resurrections: tuple[float, ...]

    @property
    def width(self) -> float:
        """Distance of the two levels between which the first member collapses, g; 0 if none collapsed."""
        return 0.0 if self.collapse is None else self.collapse - self.safe


def find_collapse(
    some: Judge,
    every: Judge,
    first: float,
    largest: float,
    tolerance: float,
    relative: float = 0.0,
    grid: Sequence[float] = (*BELOW, *ABOVE),
    stride: float = DOUBLE,
) -> Bracket:
    """Bracket the lowest level at which `some` member and at which `every` one collapses, within `tolerance`; in g.

    `relative`: tolerance relative to the level; the wider of both counts, and the bisection is one of ratios. `grid`:
    shares of the level at collapse that are tried as well.

    `first` is doubled, up to `largest`, or halved until there is a level on each side; then follows a bisection between
    levels that were both run. `stride`: factor of the first steps in place of 2, where `first` is near what is
    expected. A structure that collapses at one level may stand at a higher one: a collapse found on the grid below
    starts the bisection again. At zero the state stands by itself.
    """
    levels = _Levels(some, tolerance, relative)
    _first_collapse(levels, min(first, largest), largest, stride)
    while True:
        collapse, safe = levels.lowest_collapse(), levels.highest_safe()
        if collapse is not None and collapse - safe > levels.within(collapse):
            levels.falls(levels.middle(safe, collapse))
            continue
        about = collapse or largest
        wanted = (share * about for share in grid if share * about <= largest)
        untried = next((level for level in wanted if not levels.near(level)), None)
        if untried is None:
            break
        levels.falls(untried)
    if collapse is None:
        return Bracket(largest, None, None, ())
    certain = _certain(every, levels.collapses(), largest, levels.within)
    return Bracket(safe, collapse, certain, levels.resurrections(collapse))


class _Levels:
    """The levels (g) that were run, and whether some member collapsed at each; each is run once."""

    def __init__(self, some: Judge, tolerance: float, relative: float) -> None:
        self.some, self.tolerance, self.relative = some, tolerance, relative
        self.tried: dict[float, bool] = {}

    def falls(self, level: float) -> bool:
        if level not in self.tried:
            self.tried[level] = self.some(level)
        return self.tried[level]

    def within(self, level: float) -> float:
        """Tolerance at a level, g."""
        return max(self.tolerance, self.relative * level)

    def near(self, level: float) -> bool:
        """Whether a level within the tolerance of this one was run."""
        return min(abs(level - other) for other in self.tried) <= self.within(level)

    def middle(self, low: float, high: float) -> float:
        return math.sqrt(low * high) if self.relative and low else 0.5 * (low + high)

    def collapses(self) -> list[float]:
        """Return the levels at which some member collapsed, the lowest first."""
        return sorted(level for level, fallen in self.tried.items() if fallen)

    def lowest_collapse(self) -> float | None:
        return min(self.collapses(), default=None)

    def highest_safe(self) -> float:
        """Return the highest safe level below every collapse; 0 where there is none: at rest the state stands."""
        limit = min(self.collapses(), default=math.inf)
        return max(
            (level for level, fallen in self.tried.items() if not fallen and level < limit), default=0.0
        )

    def resurrections(self, collapse: float) -> tuple[float, ...]:
        """Return the levels above a collapse at which no member collapsed."""
        return tuple(sorted(level for level, fallen in self.tried.items() if level > collapse and not fallen))


def _first_collapse(levels: _Levels, first: float, largest: float, stride: float) -> None:
    """Run levels from `first` on: upwards until some member collapses, or downwards until none does."""
    level, factors = first, _factors(stride)
    if levels.falls(level):
        while level > levels.tolerance and levels.falls(level):
            level /= next(factors)
    else:
        while level < largest and not levels.falls(level):
            level = min(next(factors) * level, largest)
        levels.falls(level)


def _factors(stride: float) -> Iterator[float]:
    """Yield the factors between levels: `stride` twice, then each the square of the one before, DOUBLE at most."""
    yield stride
    while True:
        yield stride
        stride = min(stride**2, DOUBLE)


def _certain(
    every: Judge, reached: list[float], largest: float, within: Callable[[float], float]
) -> float | None:
    """Return the lowest level at which all members collapse, searched upward from `reached` and then by bisection.

    `reached`: levels at which some member collapses. The first step is the tolerance, since most ensembles collapse
    soon after their first member; steps double, but do not pass the next level of `reached`. None: not up to `largest`.
    """
    below, top, step = 0.0, None, within(reached[0])
    level = reached[0]
    while top is None:
        if every(level):
            top = level
        elif level >= largest:
            return None
        else:
            below = level
            level = min([below + step, largest, *(other for other in reached if other > below)])
            step *= 2.0
    while top > reached[0] and top - below > within(top):
        middle = 0.5 * (below + top)
        below, top = (below, middle) if every(middle) else (middle, top)
    return top


def collapse_near(some: Judge, near: Bracket, largest: float, tolerance: float) -> Bracket:
    """Bracket a first collapse within `tolerance` that is expected in the bracket `near`; all levels in g.

    If it lies in `near`, two runs show it. If `near.safe` collapses, lower levels are tried, if `near.collapse` is
    withstood, higher ones up to `largest`, in steps that double from the width of `near`; a bisection between the last
    two levels follows. Levels below the safe one are not tried.
    """
    low, high, step = near.safe, near.collapse, near.width or tolerance
    if low > 0.0 and some(low):
        low, high = max(low - step, 0.0), low
        while low > 0.0 and some(low):
            step *= 2.0
            low, high = max(low - step, 0.0), low
    elif high is None:
        return near
    else:
        while not some(high):
            if high >= largest:
                return Bracket(high, None, None, ())
            low, high, step = high, min(high + step, largest), 2.0 * step
    while high - low > tolerance:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if some(middle) else (middle, high)
    return Bracket(low, high, None, ())
