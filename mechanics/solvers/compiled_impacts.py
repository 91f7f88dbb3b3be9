"""The loops of `impact_kernels`, compiled by numba: same names, arguments and results."""

from __future__ import annotations

from typing import Any

from mechanics.block import Array
from mechanics.solvers.compiled import compiled


@compiled
def accelerations(
    a: Any, b: Any, normal: Array, tangent: Array, forces: Array, load: Array, mobility: Array, found: Array
) -> float:  # fmt: skip
    """See impact_kernels.accelerations."""
    found[:] = load
    for k in range(len(a)):
        fn, ft = forces[k, 0], forces[k, 1]
        for e in range(3):
            found[a[k], e] += fn * normal[k, e] + ft * tangent[k, e]
            found[b[k], e] += fn * normal[k, 3 + e] + ft * tangent[k, 3 + e]
    largest = 0.0
    for i in range(len(found)):
        for e in range(3):
            found[i, e] *= mobility[i, e]
        largest = max(largest, abs(found[i, 0]), abs(found[i, 1]))
    return largest


@compiled
def closing(a: Any, b: Any, normal: Array, v: Array, gap: Array, closed: float) -> float:
    """See impact_kernels.closing."""
    least = 0.0
    for k in range(len(a)):
        if gap[k] <= closed:
            least = min(least, _change(a, b, k, normal, v))
    return least


@compiled
def dilation(
    a: Any, b: Any, normal: Array, tangent: Array, moved: Array, forces: Array, friction: Array, gap: Array,
    change: Array, shift: Array, bend: Array, carrying: float, opening: Array, slip: Array, off: Array, matters: Array,
) -> tuple[float, float]:  # fmt: skip
    """See impact_kernels.dilation."""
    lacking, bends = 0.0, 0.0
    for k in range(len(a)):
        opening[k], slip[k] = _change(a, b, k, normal, moved), _change(a, b, k, tangent, moved)
        beyond = change[k] - opening[k]
        off[k] = friction[k] * abs(slip[k]) + beyond - shift[k]
        matters[k] = forces[k, 0] > carrying or gap[k] + change[k] <= abs(off[k])
        if matters[k]:
            lacking, bends = max(lacking, abs(off[k])), max(bends, abs(beyond - bend[k]))
        bend[k] = beyond
    return lacking, bends


@compiled
def held(
    a: Any, b: Any, normal: Array, tangent: Array, v: Array, forces: Array, gap: Array, slip: Array, friction: Array,
    carrying: float, closed: float, stuck: float, rate: Array, hold: Any,
) -> float:  # fmt: skip
    """See impact_kernels.held."""
    largest = 0.0
    for k in range(len(a)):
        rate[k, 0], rate[k, 1] = _change(a, b, k, normal, v), _change(a, b, k, tangent, v)
        hold[k] = 0
        opposite = k + 2 if k % 4 < 2 else k - 2
        carries = forces[k, 0] > carrying and gap[k] <= closed
        facing = forces[opposite, 0] > carrying and gap[opposite] <= closed
        if not carries or (facing and forces[opposite, 0] > forces[k, 0]):
            continue
        if facing and forces[opposite, 0] == forces[k, 0] and opposite < k:
            continue
        hold[k] = 1
        largest = max(largest, abs(rate[k, 0]))
        if friction[k] > 0.0 and (abs(slip[k]) <= stuck or slip[k] * rate[k, 1] < 0.0):
            hold[k] = 2
            largest = max(largest, abs(rate[k, 1]))
    return largest


@compiled
def strikes(
    a: Any, b: Any, normal: Array, v: Array, gap: Array, hold: Any, closed: float, resting: float
) -> bool:  # fmt: skip
    """See impact_kernels.strikes."""
    struck = False
    for k in range(len(a)):
        struck |= hold[k] > 0 and (gap[k] > closed or _change(a, b, k, normal, v) < -resting)
    return struck


@compiled
def _change(a: Any, b: Any, k: int, rows: Array, moved: Array) -> float:
    total = 0.0
    for e in range(3):
        total += rows[k, e] * moved[a[k], e] + rows[k, 3 + e] * moved[b[k], e]
    return total
