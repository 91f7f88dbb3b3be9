"""What is read off curves: where a rigid one ends, and the elastic one beside the fitted capacity curve."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from assessment.report.tables.rows import capacities
from assessment.results.schema import Results
from assessment.results.schema.checks import Direction
from assessment.results.schema.static import RigidPush
from assessment.results.table import sense
from mechanics.types import Array

ABOVE = 0.2  # of the elastic curve: a larger excess of the fitted curve is reported


class Excess(NamedTuple):
    """Where a fitted curve lies above the elastic one: at the displacement of a limit state; d* in m, a* in g."""

    state: str
    direction: Direction
    limit_state: str
    d_star_m: float
    fitted_g: float
    elastic_g: float


def alpha_at_d_0(rigid: RigidPush) -> float | None:
    """Return the multiplier at d_0 where equilibrium is lost before it vanishes; None where it has vanished there."""
    left, end = rigid.curve.multiplier[-1], abs(rigid.curve.displacement_m[-1])
    ends = rigid.d_0_m is not None and math.isclose(
        rigid.d_0_m, end
    )  # an ensemble may have d_0 of another run
    return left if rigid.lost and ends and left > 0.0 else None


def elastic_capacity(results: Results, state: str, direction: Direction) -> tuple[Array, Array] | None:
    """Return d* (k,) in m and a* (k,) in g of the curve with elastic joints: d*, α/(e* F_C); None without one."""
    found = results.states[state]
    capacity, pushovers = found.capacity.get(direction), found.pushover.get(direction)
    if capacity is None or pushovers is None or pushovers.elastic is None:
        return None
    curve, d_star = pushovers.elastic.curve, pushovers.elastic.d_star_m
    if d_star is None:
        d_star = (
            sense(direction) * capacity.gamma_star * np.asarray(curve.displacement_m, dtype=float)
        ).tolist()
    factor = float((results.echo.assessment or {}).get("confidence_factor", 1.0))
    return np.asarray(d_star), np.asarray(curve.multiplier, dtype=float) / (capacity.e_star * factor)


def excesses(results: Results) -> Iterator[Excess]:
    """Yield where a nonlinear check takes an acceleration more than ABOVE higher than the elastic curve has there."""
    for name, direction, capacity in capacities(results):
        elastic = elastic_capacity(results, name, direction)
        for limit, check in capacity.checks.items():
            if elastic is None or check.method != "nonlinear" or not check.d_star_m or not check.a_star_g:
                continue
            at = _on_the_way(*elastic, check.d_star_m)
            if at is not None and check.a_star_g > (1.0 + ABOVE) * at:
                yield Excess(name, direction, limit, check.d_star_m, check.a_star_g, at)


def _on_the_way(d_star: Array, a_star: Array, place: float) -> float | None:
    """Return a* where the curve first comes to a displacement; None where it ends before."""
    first = np.r_[True, d_star[1:] > np.maximum.accumulate(d_star)[:-1]]  # farther than ever before
    if place > d_star[first][-1] * (1.0 + 1e-9):
        return None
    return max(0.0, float(np.interp(place, d_star[first], a_star[first])))
