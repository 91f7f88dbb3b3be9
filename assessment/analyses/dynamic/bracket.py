"""The peak ground accelerations between which a structure collapses: where some of an ensemble do, and all."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

# shares of the PGA at collapse where the order of collapse is not taken on trust
BELOW = (0.2, 0.4, 0.6, 0.8)
ABOVE = (1.2, 1.4, 1.6)

Judge = Callable[[float], bool]
"""Whether some, or all, members of an ensemble collapse at a level (g)."""


@dataclass(frozen=True)
class Bracket:
    """All members withstood `safe` (g), and some did not `collapse`; no lower level tried collapsed any.

    `certain` (g): the lowest level tried at which all collapsed. None: nothing tried did. `resurrections` (g): what was
    tried above `collapse` and withstood by all.
    """

    safe: float
    collapse: float | None
    certain: float | None
    resurrections: tuple[float, ...]

    @property
    def width(self) -> float:
        """How far apart the levels are between which the first member collapses, g; 0 where nothing did."""
        return 0.0 if self.collapse is None else self.collapse - self.safe


def find_collapse(
    some: Judge,
    every: Judge,
    first: float,
    largest: float,
    tolerance: float,
    relative: float = 0.0,
    grid: Sequence[float] = (*BELOW, *ABOVE),
) -> Bracket:
    """Bracket the lowest level at which `some` member and at which `every` one collapses, within `tolerance`; in g.

    `relative`: to the level, where that is a wider tolerance; the bisection is then one of ratios. `grid`: shares of
    the level at collapse that are tried too.

    From `first` by doubling, up to `largest`, or halving to a level on each side, then by bisection between levels
    that were both run. A structure that falls at one level may stand at a higher one: a collapse found on the grid
    below starts the bisection again. At zero the state stands by itself.
    """
    tried: dict[float, bool] = {}

    def within(level: float) -> float:
        return max(tolerance, relative * level)

    def falls(level: float) -> bool:
        if level not in tried:
            tried[level] = some(level)
        return tried[level]

    def lowest() -> float | None:
        return min((level for level, fallen in tried.items() if fallen), default=None)

    def safe_below(limit: float) -> float:
        return max((level for level, fallen in tried.items() if not fallen and level < limit), default=0.0)

    def middle(low: float, high: float) -> float:
        return math.sqrt(low * high) if relative and low else 0.5 * (low + high)

    level = min(first, largest)
    if falls(level):
        while level > tolerance and falls(level):
            level /= 2.0
    else:
        while level < largest and not falls(min(2.0 * level, largest)):
            level = min(2.0 * level, largest)
    while True:
        collapse = lowest()
        safe = safe_below(math.inf if collapse is None else collapse)
        if collapse is not None and collapse - safe > within(collapse):
            falls(middle(safe, collapse))
            continue
        about = collapse or largest
        wanted = [share * about for share in grid if share * about <= largest]
        new = [level for level in wanted if min(abs(level - other) for other in tried) > within(level)]
        if not new:
            break
        falls(new[0])
    if collapse is None:
        return Bracket(largest, None, None, ())
    reached = [level for level, fallen in tried.items() if fallen]
    above = (level for level, fallen in tried.items() if level > collapse and not fallen)
    certain = _certain(every, sorted(reached), largest, within)
    return Bracket(safe, collapse, certain, tuple(sorted(above)))


def _certain(
    every: Judge, reached: list[float], largest: float, within: Callable[[float], float]
) -> float | None:
    """Return the lowest level at which all collapse: upward from where some do, then by bisection.

    Steps double from the tolerance on: most ensembles collapse soon after their first member. None is longer than to
    the next level of those `reached` by some.
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
    """Bracket a first collapse within `tolerance` that is expected in the bracket `near`; everything in g.

    Two runs where it is there. Else away from it, down where `near.safe` collapses, up to `largest` where
    `near.collapse` is withstood, by steps that double from its width, and by bisection between the last two. Levels
    below the one that is withstood then are not tried.
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
