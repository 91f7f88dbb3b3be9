"""Seismic hazard of a site: reference grid of D.M. 14/01/2008, Allegato B; limit states of NTC 2018."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import exp, log
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from assessment.ntc.calculation import Step, Trace, datum, step
from assessment.ntc.demand.hazard_grid import (
    ALLEGATO_B,
    RETURN_PERIODS,
    HazardError,
    HazardGrid,
    allegato_b,
    read_grid,
    read_site_table,
)
from assessment.ntc.demand.return_period import EXCEEDANCE, USE_COEFFICIENT, return_period
from mechanics.errors import ArgumentError, require

Array = NDArray[np.float64]

_KM_PER_DEGREE = 111.195
_PARAMETERS = ("a_g", "F_0", "T_C_star")
_UNITS = ("g", "", "s")
_ALLEGATO = "D.M. 14/01/2008, Allegato A"
# within the reach of a cell: a site has at most this many nodes nearer than the far corner of its cell
_NEAR = 12


@dataclass(frozen=True, slots=True)
class Hazard:
    """a_g (g), F0 and T_C* (s) of a site for a return period (years)."""

    ag: float
    F0: float
    Tc_star: float
    return_period: float


@dataclass(frozen=True, eq=False)
class HazardCurve:
    """Hazard of one site for the nine return periods.

    `values` (9, 3) are a_g (g), F0, T_C* (s) at RETURN_PERIODS, the average of `node_values` (m, 9, 3) of the
    m = 4 nodes of the cell (1 when the site is a node), at `distances` (m,) in km.
    """

    name: str
    values: Array
    node_values: Array
    distances: Array

    def at(self, return_period: float) -> Hazard:
        """Return the hazard for a return period (years): log p linear in log T_R (Allegato A, eq. 1).

        Raises ValueError outside 30–2475 years.
        """
        k = _interval(return_period)
        T1, T2 = RETURN_PERIODS[k : k + 2]
        share = log(return_period / T1) / log(T2 / T1)
        p1, p2 = self.values[k : k + 2]
        ag, F0, Tc_star = (p1 * (p2 / p1) ** share).tolist()
        return Hazard(ag, F0, Tc_star, return_period)

    def return_period(self, ag: float) -> float:
        """Return T_R (years) whose a_g (g) is the given one; 30 or 2475 where a_g lies outside the table."""
        table = self.values[:, 0]
        if not table[0] < ag < table[-1]:
            return float(RETURN_PERIODS[0] if ag <= table[0] else RETURN_PERIODS[-1])
        return exp(float(np.interp(log(ag), np.log(table), np.log(RETURN_PERIODS))))

    def return_period_step(self, ag: float) -> Step:
        """Return the inverse interpolation of return_period(ag) by hand; its bounds are 30 and 2475 years."""
        table = self.values[:, 0]
        k = int(np.clip(np.searchsorted(table, ag), 1, len(table) - 1))
        formula = "min(2475, max(30, exp(log(T_R_1) + log(T_R_2/T_R_1)*log(a_g/a_1)/log(a_2/a_1))))"
        return step("T_R_capacity", formula, self.return_period(ag), "years", f"{_ALLEGATO}, eq. 1", a_g=ag,
                    a_1=table[k - 1], a_2=table[k], T_R_1=RETURN_PERIODS[k - 1], T_R_2=RETURN_PERIODS[k])  # fmt: skip

    def steps(self, return_period: float) -> Trace:
        """Return the interpolation of a_g, F0 and T_C* in space, then in the return period."""
        k = _interval(return_period)
        T1, T2 = RETURN_PERIODS[k : k + 2]
        hazard = self.at(return_period)
        lines = [datum("T_R", return_period, "years", "NTC 2018, §3.2.1")]
        for j, (symbol, unit) in enumerate(zip(_PARAMETERS, _UNITS, strict=True)):
            first, second = f"{symbol}_1", f"{symbol}_2"
            ends = {first: self.values[k, j], second: self.values[k + 1, j]}
            lines += [self._space(first, unit, k, j), self._space(second, unit, k + 1, j)]
            formula = f"exp(log({first}) + log({second}/{first})*log(T_R/T_R_1)/log(T_R_2/T_R_1))"
            lines.append(
                step(symbol, formula, (hazard.ag, hazard.F0, hazard.Tc_star)[j], unit, f"{_ALLEGATO}, eq. 1",
                     **ends, T_R=return_period, T_R_1=T1, T_R_2=T2)
            )  # fmt: skip
        return tuple(lines)

    def _space(self, symbol: str, unit: str, column: int, j: int) -> Step:
        p, d, at = self.node_values[:, column, j], self.distances, f"; T_R = {RETURN_PERIODS[column]:g}"
        if len(d) == 1:
            return datum(symbol, p[0], unit, f"{self.name}: one node, the site itself{at}")
        inputs = {f"p_{i + 1}": p[i] for i in range(4)} | {f"d_{i + 1}": d[i] for i in range(4)}
        formula = "(p_1/d_1 + p_2/d_2 + p_3/d_3 + p_4/d_4)/(1/d_1 + 1/d_2 + 1/d_3 + 1/d_4)"
        return step(symbol, formula, self.values[column, j], unit, f"{_ALLEGATO}, eq. 2{at}", **inputs)


def return_period_steps(limit_state: str, nominal_life: float = 50.0, use_class: str = "II") -> Trace:
    """Return the calculation of V_R and T_R by hand."""
    C_U, P = USE_COEFFICIENT[use_class], EXCEEDANCE[limit_state]
    T_R = return_period(limit_state, nominal_life, use_class)
    return (
        datum("V_N", nominal_life, "years", "NTC 2018, Tab. 2.4.I"),
        datum("C_U", C_U, "", f"NTC 2018, Tab. 2.4.II, {use_class}"),
        datum("P_VR", P, "", f"NTC 2018, Tab. 3.2.I, {limit_state}"),
        step("V_R", "V_N*C_U", nominal_life * C_U, "years", "NTC 2018, §2.4.3", V_N=nominal_life, C_U=C_U),
        step("T_R", "min(2475, max(30, -V_R/log(1 - P_VR)))", T_R, "years", "NTC 2018, §3.2.1",
             V_R=nominal_life * C_U, P_VR=P),
    )  # fmt: skip


def site_curve(
    grid: HazardGrid | str | Path | None = None, latitude: float | None = None, longitude: float | None = None
) -> HazardCurve:
    """Return the hazard of a site for the nine return periods: p = Σ(p_i/d_i)/Σ(1/d_i) over its cell's nodes.

    Without `grid` the nodes are those of Allegato B. latitude and longitude in degrees, in the datum of the grid (ED50
    in Allegato B [k]). A file of nine lines, one per return period, is the site's own table and needs no coordinates.
    Raises HazardError where no cell of four nodes holds the site: outside the grid, at its edge, on an island.
    """
    if grid is None:
        grid = allegato_b()
    if not isinstance(grid, HazardGrid):
        own = read_site_table(grid)
        if own is not None:
            return HazardCurve(Path(grid).name, own, own[None], np.zeros(1))
        grid = read_grid(grid)
    if latitude is None or longitude is None:
        raise HazardError(
            f"{grid.name}: is a grid of many nodes; give the latitude and longitude of the site"
        )
    x = (grid.longitude - longitude) * np.cos(np.radians(latitude)) * _KM_PER_DEGREE
    y = (grid.latitude - latitude) * _KM_PER_DEGREE
    distance = np.hypot(x, y)
    near = np.argsort(distance)[:_NEAR]
    if distance[near[0]] < 1e-3:
        node = near[:1]
        return HazardCurve(grid.name, grid.values[node[0]], grid.values[node], np.zeros(1))
    cell = _cell(np.column_stack([x[near], y[near]]))
    if cell is None:
        raise HazardError(_outside(grid, latitude, longitude, int(near[0]), float(distance[near[0]])))
    nodes = near[cell]
    weights = 1.0 / distance[nodes]
    values = np.tensordot(weights / weights.sum(), grid.values[nodes], axes=1)
    return HazardCurve(grid.name, values, grid.values[nodes], distance[nodes])


def hazard_range(return_period: float) -> tuple[Hazard, Hazard]:
    """Return the least and the greatest a_g, F0 and T_C* of the nodes of Allegato B at a return period (years).

    Raises ValueError outside 30–2475 years.
    """
    values = allegato_b().values
    bounds = [
        HazardCurve(ALLEGATO_B, v, v[None], np.zeros(1)).at(return_period)
        for v in (values.min(axis=0), values.max(axis=0))
    ]
    return bounds[0], bounds[1]


def site_hazard(
    grid: HazardGrid | str | Path | None = None,
    latitude: float | None = None,
    longitude: float | None = None,
    return_period: float | None = None,
) -> Hazard:
    """Return a_g (g), F0 and T_C* (s) of a site for a return period (years).

    `grid`: a grid, its file or a site's own table; without it the grid of D.M. 14/01/2008, Allegato B. Raises
    ArgumentError without a return period and for a file that cannot be read, HazardError for a file that is no grid
    and for a site outside the grid.
    """
    if return_period is None:
        raise ArgumentError("return_period: missing; must be from 30 to 2475 years")
    try:
        curve = site_curve(grid, latitude, longitude)
    except OSError as error:
        raise ArgumentError(
            f"grid = {str(grid)!r}: must be a file that can be read ({error.strerror})"
        ) from None
    return curve.at(return_period)


def _cell(nodes: Array) -> Sequence[int] | None:
    """Return the four of `nodes` (n, 2), km from the site, that make the near-square cell holding the site.

    The grid's rows turn with longitude, so no direction is assumed: of all quadrilaterals whose sides are
    about the spacing of the nodes, the one that holds the origin and whose corners are nearest.
    """
    if len(nodes) < 4:
        return None
    gaps = np.hypot(*(nodes[:, None] - nodes[None]).transpose(2, 0, 1))
    spacing = np.median(np.sort(gaps, axis=1)[:, 1])
    fours = np.array(list(combinations(range(len(nodes)), 4)))
    corners = nodes[fours]
    centred = corners - corners.mean(axis=1, keepdims=True)
    order = np.argsort(np.arctan2(centred[..., 1], centred[..., 0]), axis=1)
    p = np.take_along_axis(corners, order[..., None], axis=1)
    q = np.roll(p, -1, axis=1)
    side = np.hypot(*(q - p).transpose(2, 0, 1))
    square = ((side > 0.7 * spacing) & (side < 1.4 * spacing)).all(axis=1)
    holds = (p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0] >= -1e-9 * spacing**2).all(axis=1)
    found = np.flatnonzero(square & holds)
    if not found.size:
        return None
    reach = np.hypot(corners[found, :, 0], corners[found, :, 1]).sum(axis=1)
    return fours[found[np.argmin(reach)]].tolist()


def _outside(grid: HazardGrid, latitude: float, longitude: float, node: int, distance: float) -> str:
    lon, lat = grid.longitude, grid.latitude
    inside = lon.min() <= latitude <= lon.max() and lat.min() <= longitude <= lat.max()
    swapped = (
        f"They are swapped: write latitude = {longitude:g}, longitude = {latitude:g}. " if inside else ""
    )
    return (
        f"{grid.name}: site latitude = {latitude:g}, longitude = {longitude:g}: no cell of four nodes holds "
        f"it; the nearest node is {distance:.1f} km away (latitude {lat[node]:g}, longitude {lon[node]:g}; "
        f"the grid spans latitude {lat.min():g}–{lat.max():g}, longitude {lon.min():g}–{lon.max():g}). {swapped}Check "
        "the coordinates; at the edge of the grid and on islands (Allegato B, table 2) give ag_g, F0 and "
        "Tc_star_s of each limit state instead of coordinates"
    )


def _interval(return_period: float) -> int:
    low, high = RETURN_PERIODS[0], RETURN_PERIODS[-1]
    require(low <= return_period <= high, "return_period", return_period, "from 30 to 2475 years")
    return int(np.clip(np.searchsorted(RETURN_PERIODS, return_period) - 1, 0, len(RETURN_PERIODS) - 2))
