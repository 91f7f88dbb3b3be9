"""The peak ground accelerations between which a structure collapses, by the share of an ensemble that does at each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

# shares of the PGA at collapse where the order of collapse is not taken on trust
GRID = (0.2, 0.4, 0.6, 0.8, 1.2, 1.4, 1.6)

Share = Callable[[float], float]
"""The share of the members that collapse at a level (g)."""


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


def find_collapse(share: Share, first: float, largest: float, tolerance: float) -> Bracket:
    """Bracket the lowest level at which some member collapses, and at which all do, within `tolerance`; all in g.

    From `first` by doubling, up to `largest`, or halving to a level on each side, then by bisection between levels
    that were both run. A structure that falls at one level may stand at a higher one: levels on a coarse grid below
    and above are tried too, and a collapse found below starts the bisection again. At zero the state stands by itself.
    """
    tried: dict[float, float] = {}

    def falls(level: float) -> bool:
        if level not in tried:
            tried[level] = share(level)
        return tried[level] > 0.0

    def lowest() -> float | None:
        return min((level for level, fallen in tried.items() if fallen > 0.0), default=None)

    def safe_below(limit: float) -> float:
        return max((level for level, fallen in tried.items() if fallen == 0.0 and level < limit), default=0.0)

    level = min(first, largest)
    if falls(level):
        while level > tolerance and falls(level):
            level /= 2.0
    else:
        while level < largest and not falls(min(2.0 * level, largest)):
            level = min(2.0 * level, largest)
    while True:
        collapse = lowest()
        if collapse is not None and collapse - safe_below(collapse) > tolerance:
            falls(0.5 * (collapse + safe_below(collapse)))
            continue
        about = collapse or largest
        wanted = [share_ * about for share_ in GRID if share_ * about <= largest]
        new = [level for level in wanted if min(abs(level - other) for other in tried) > tolerance]
        if not new:
            break
        falls(new[0])
    if collapse is None:
        return Bracket(largest, None, None, ())
    certain = _all_fall(share, tried, collapse, largest, tolerance)
    above = (level for level, fallen in tried.items() if fallen == 0.0 and level > collapse)
    return Bracket(safe_below(collapse), collapse, certain, tuple(sorted(above)))


def _all_fall(
    share: Share, tried: dict[float, float], collapse: float, largest: float, tolerance: float
) -> float | None:
    """Return the lowest level of those `tried` at which all collapse, from `collapse` on by doubling and bisection."""

    def certain() -> float | None:
        return min((level for level, fallen in tried.items() if fallen == 1.0), default=None)

    level = max(tried)
    while certain() is None and level < largest:
        level = min(2.0 * level, largest)
        tried[level] = share(level)
    while (top := certain()) is not None and top > collapse:
        below = max(level for level in tried if level < top)
        if top - below <= tolerance:
            break
        middle = 0.5 * (top + below)
        tried[middle] = share(middle)
    return certain()


def collapse_near(share: Share, near: Bracket, largest: float, tolerance: float) -> Bracket:
    """Bracket a first collapse within `tolerance` that is expected in the bracket `near`; everything in g.

    Two runs where it is there. Else away from it, down where `near.safe` collapses, up to `largest` where
    `near.collapse` is withstood, by steps that double from its width, and by bisection between the last two. Levels
    below the one that is withstood then are not tried.
    """

    def collapses(level: float) -> bool:
        return share(level) > 0.0

    low, high, step = near.safe, near.collapse, near.width or tolerance
    if low > 0.0 and collapses(low):
        low, high = max(low - step, 0.0), low
        while low > 0.0 and collapses(low):
            step *= 2.0
            low, high = max(low - step, 0.0), low
    elif high is None:
        return near
    else:
        while not collapses(high):
            if high >= largest:
                return Bracket(high, None, None, ())
            low, high, step = high, min(high + step, largest), 2.0 * step
    while high - low > tolerance:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if collapses(middle) else (middle, high)
    return Bracket(low, high, None, ())
