"""The peak ground accelerations between which a structure collapses: where some of an ensemble do, and all."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

# shares of the PGA at collapse where the order of collapse is not taken on trust
GRID = (0.2, 0.4, 0.6, 0.8, 1.2, 1.4, 1.6)

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
    some: Judge, every: Judge, first: float, largest: float, tolerance: float, relative: float = 0.0
) -> Bracket:
    """Bracket the lowest level at which `some` member and at which `every` one collapses, within `tolerance`; in g.

    `relative`: to the level, where that is a wider tolerance.

    From `first` by doubling, up to `largest`, or halving to a level on each side, then by bisection between levels
    that were both run. A structure that falls at one level may stand at a higher one: levels on a coarse grid below
    and above are tried too, and a collapse found below starts the bisection again. At zero the state stands by itself.
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

    level = min(first, largest)
    if falls(level):
        while level > tolerance and falls(level):
            level /= 2.0
    else:
        while level < largest and not falls(min(2.0 * level, largest)):
            level = min(2.0 * level, largest)
    while True:
        collapse = lowest()
        if collapse is not None and collapse - safe_below(collapse) > within(collapse):
            falls(0.5 * (collapse + safe_below(collapse)))
            continue
        about = collapse or largest
        wanted = [share * about for share in GRID if share * about <= largest]
        new = [level for level in wanted if min(abs(level - other) for other in tried) > within(level)]
        if not new:
            break
        falls(new[0])
    if collapse is None:
        return Bracket(largest, None, None, ())
    reached = [level for level, fallen in tried.items() if fallen]
    above = (level for level, fallen in tried.items() if not fallen and level > collapse)
    certain = _certain(every, sorted(reached), largest, within)
    return Bracket(safe_below(collapse), collapse, certain, tuple(sorted(above)))


def _certain(
    every: Judge, reached: list[float], largest: float, within: Callable[[float], float]
) -> float | None:
    """Return the lowest level at which all collapse: the first of those `reached` by some, then by bisection."""
    below, top = 0.0, None
    level = reached[0]
    while top is None:
        if every(level):
            top = level
        elif level >= largest:
            return None
        else:
            below = level
            level = next((other for other in reached if other > below), min(2.0 * below, largest))
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
