"""The array loops of rigid impacts (see mechanics.impacts) in plain NumPy; `compiled_impacts` has the same for numba.

Blocks `a` and `b` (c,) of the contact points, the rows `normal` and `tangent` (c, 6) of A₀ᵀ, forces (c, 2), gaps (c,).
"""

from __future__ import annotations

import numpy as np

from mechanics.block import Array
from mechanics.joints import Index


def accelerations(
    a: Index, b: Index, normal: Array, tangent: Array, forces: Array, load: Array, mobility: Array, found: Array
) -> float:  # fmt: skip
    """Of blocks of 1/mass `mobility` (b, 3) under loads (b, 3) and contact forces, into `found`; the largest, m/s²."""
    entries = forces[:, :1] * normal + forces[:, 1:] * tangent
    found[:] = load
    np.add.at(found, a, entries[:, :3])
    np.add.at(found, b, entries[:, 3:])
    found *= mobility
    return float(abs(found[:, :2]).max())


def closing(a: Index, b: Index, normal: Array, v: Array, gap: Array, closed: float) -> float:
    """The least rate, none above zero, at which gaps of at most `closed` change with velocities (b, 3)."""
    return float(_changes(a, b, normal, v)[gap <= closed].min(initial=0.0))


def dilation(
    a: Index, b: Index, normal: Array, tangent: Array, moved: Array, forces: Array, friction: Array, gap: Array,
    change: Array, shift: Array, bend: Array, carrying: float, opening: Array, slip: Array, off: Array, matters: Array,
) -> tuple[float, float]:  # fmt: skip
    """What displacements (b, 3) do to gaps that really `change` by so much, and what the `shift` (c,) of them lacks.

    Written: `opening` and `slip` by the rows, `bend` (what change has beyond opening), `off` (what dilation and bend
    have beyond the shift) and which contacts it `matters` to: with more than a `carrying` force, or closer than that.
    Returned: the largest of them in `off`, and the largest change of `bend`.
    """
    opening[:], slip[:] = _changes(a, b, normal, moved), _changes(a, b, tangent, moved)
    off[:] = friction * abs(slip) + change - opening - shift
    matters[:] = (forces[:, 0] > carrying) | (gap + change <= abs(off))
    bends = abs(change - opening - bend)[matters].max(initial=0.0)
    bend[:] = change - opening
    return float(abs(off[matters]).max(initial=0.0)), float(bends)


def held(
    a: Index, b: Index, normal: Array, tangent: Array, v: Array, forces: Array, gap: Array, slip: Array,
    friction: Array, carrying: float, closed: float, stuck: float, rate: Array, hold: Index,
) -> float:  # fmt: skip
    """Rates (c, 2) of gaps and slides with velocities (b, 3), and which are to be none: 1 the gap's, 2 both; 0 neither.

    It holds a closed gap that carries, and the slide of one that is `stuck` or goes back. Of the two contacts that see
    an end of a joint from either side it is the harder pressed: where the blocks have slid a little, both of them
    together would hold the rotation of the hinge that they are. Returned: the largest rate that is to be none.
    """
    rate[:, 0], rate[:, 1] = _changes(a, b, normal, v), _changes(a, b, tangent, v)
    carries = (forces[:, 0] > carrying) & (gap <= closed)
    one, other = np.moveaxis(np.where(carries, forces[:, 0], 0.0).reshape(-1, 2, 2), 1, 0)
    carries &= np.stack([one >= other, one < other], axis=1).ravel()
    # without friction nothing stops
    stopped = (friction > 0.0) & ((abs(slip) <= stuck) | (slip * rate[:, 1] < 0.0))
    hold[:] = carries * (1 + stopped)
    return float(np.where(hold > [[0], [1]], abs(rate).T, 0.0).max(initial=0.0))


def strikes(
    a: Index, b: Index, normal: Array, v: Array, gap: Array, hold: Index, closed: float, resting: float
) -> bool:  # fmt: skip
    """Whether a contact on `hold` had been open, or came faster than `resting`, with velocities (b, 3) before."""
    struck = (hold > 0) & ((gap > closed) | (_changes(a, b, normal, v) < -resting))
    return bool(struck.any())


def _changes(a: Index, b: Index, rows: Array, moved: Array) -> Array:
    change: Array = np.einsum("ij,ij->i", rows, np.concatenate([moved[a], moved[b]], axis=1))
    return change
