"""The loops over contact points of rigid impacts (see mechanics.impacts), compiled by numba.

Blocks `a` and `b` (c,) of the contact points, the rows `normal` and `tangent` (c, 6) of A₀ᵀ, `forces` (c, 2) kN,
`gap` (c,) m, `friction` (c,).
"""

from __future__ import annotations

from typing import Any

from mechanics.block import Array
from mechanics.solvers.compiled import compiled


@compiled
def accelerations(
    a: Any, b: Any, normal: Array, tangent: Array, forces: Array, load: Array, mobility: Array, found: Array
) -> float:  # fmt: skip
    """Of blocks of 1/mass `mobility` (b, 3) under loads (b, 3) and contact forces, into `found`; the largest, m/s²."""
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
    """The least rate, at most zero, at which gaps of at most `closed` change with velocities `v` (b, 3)."""
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
    """The error of gaps shifted by `shift` (c,): dilation and curvature that it should make up for (see impacts).

    Displacements `moved` (b, 3) really `change` the gaps by so much (c,). Written, each (c,): `opening` and `slip` by
    the rows of A₀ᵀ; `bend`, what `change` has beyond `opening`; `off`, dilation and bend less the shift; and whether a
    contact `matters`: it has more than a `carrying` force, or its gap ends closer than `off`. Returned, of those that
    matter: the largest `off`, and the largest change of `bend`.
    """
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
    """Rates of gaps and slides (c, 2) with velocities `v` (b, 3), and which are to vanish, into `rate` and `hold` (c,).

    `hold`: 0 neither, 1 the gap's, 2 both. Held are a closed gap that carries, and its slide where the `slip` (c,) is
    `stuck` or turns back; without friction no slide is. Two contacts see an end of a joint, from either side: the one
    with the larger force is held, at equal force the first. Where the blocks have slid a little, both together would
    hold the rotation of the hinge that they are. Returned: the largest rate that is to vanish.
    """
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
    """Whether a contact on `hold` was open before, or closed faster than `resting`, with velocities `v` (b, 3) then."""
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
