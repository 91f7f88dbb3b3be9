"""Seismic hazard of a site: grid of D.M. 14/01/2008, Allegato B, others, nine lines of one site; return periods."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from itertools import combinations
from math import exp, log
from pathlib import Path

import numpy as np

from assessment.ntc.tables import EXCEEDANCE, USE_COEFFICIENT, Trace, datum, return_period, step, worked
from assessment.results.schema.model import Line
from mechanics.errors import ArgumentError, is_between, require
from mechanics.types import Array

RETURN_PERIODS = np.array([30.0, 50.0, 72.0, 101.0, 140.0, 201.0, 475.0, 975.0, 2475.0])  # years
_COLUMNS = 2 + 3 * len(RETURN_PERIODS)
ALLEGATO_B = "D.M. 14/01/2008, Allegato B"
_DIGITS = {"longitude": 4, "latitude": 3, "ag": 3, "F0": 2, "Tc_star": 2}  # decimals that the act prints
MOST_BYTES = 50_000_000  # of a file; Allegato B has two and a half
MOST_AG, MOST_F0, MOST_TC = 10.0, 100.0, 10.0  # g, –, s: beyond them it is another quantity, or another unit
SITE_COLUMNS = ("T_R", "a_g", "F0", "T_C*")


class HazardError(ValueError):
    """A file of hazard that cannot be used, or a site that it does not hold; the message names file and line."""


@dataclass(frozen=True, eq=False)
class HazardGrid:
    """Reference grid: longitude, latitude (n,) in degrees, values (n, 9, 3): a_g (g), F0, T_C* (s)."""

    name: str
    longitude: Array
    latitude: Array
    values: Array


@cache
def allegato_b() -> HazardGrid:
    """Return the reference grid of D.M. 14/01/2008 (Gazzetta Ufficiale 29, 4/2/2008), Allegato B, table 1."""
    # digits as printed, whole numbers; an official act of the State is in no one's copyright (L. 633/1941, art. 5)
    with files("assessment.ntc").joinpath("allegato_b.npz").open("rb") as file, np.load(file) as table:
        read = {name: table[name] / 10.0**digits for name, digits in _DIGITS.items()}
    values = np.stack([read["ag"].T / 10.0, read["F0"].T, read["Tc_star"].T], axis=2)
    return HazardGrid(ALLEGATO_B, read["longitude"], read["latitude"], values)


@dataclass(frozen=True)
class _File:
    """A file of hazard: its header lines as one text, and the cells of the lines after them with their line numbers."""

    path: Path
    header: str
    rows: list[tuple[int, list[str]]]

    def error(self, text: str, line: int | None = None) -> HazardError:
        return HazardError(f"{self.path}: {text}" if line is None else f"{self.path}: line {line}: {text}")

    def numbers(self, columns: int, meaning: str, numbered: bool = True) -> Array:
        """Return the last `columns` cells of rows as numbers, one before them or not. Raises HazardError for others."""
        allowed: Sequence[int] = (columns, columns + 1) if numbered else (columns,)
        for line, cells in self.rows:
            if len(cells) not in allowed or not all(map(_is_number, cells)):
                found = ", ".join(cell.strip()[:12] for cell in cells[:4])
                text = f"{columns} numbers expected ({meaning}), found {len(cells)} cells: {found}…"
                raise self.error(f"{text}; correct the line, or get the file again from its source", line)
        return np.array([cells[-columns:] for _, cells in self.rows], dtype=float)

    def check(self, values: Array, unit: str) -> None:
        """Raise HazardError naming the line where values (n, 9, 3), a_g in g, are those of no site."""
        most = np.array([MOST_AG, MOST_F0, MOST_TC])
        for name, fits, must in (
            ("a_g, F0 and T_C*", (values > 0.0) & (values < most), f"be positive numbers, a_g {unit}"),
            ("F0", values[..., 1:2] >= 1.0, "be 1 or more: the spectrum is not below a_g"),
            ("a_g", np.diff(values[..., 0], axis=1) > 0.0, "grow with the return period"),
        ):
            if not (good := fits.reshape(len(values), -1).all(axis=1)).all():
                line = self.rows[int(np.argmin(good))][0]
                raise self.error(f"{name} must {must}; get the file again from its source", line)


def _read(path: str | Path) -> _File:
    """Read a file; tabs or semicolons part its cells. Raises HazardError for one that is too large, or damaged."""
    path = Path(path)
    size = path.stat().st_size
    with path.open("rb") as file:
        content = file.read(MOST_BYTES) if 0 < size <= MOST_BYTES else b""  # what has no size may have no end
    if size > MOST_BYTES:
        raise HazardError(f"{path}: more than {MOST_BYTES} bytes; give the grid of Allegato B")
    lines = content.decode("latin-1").splitlines()
    separator = ";" if any(";" in line for line in lines[:5]) else "\t"
    rows = [(i, line.replace(",", ".").split(separator)) for i, line in enumerate(lines, 1) if line.strip()]
    start = next((k for k, (_, cells) in enumerate(rows) if _is_number(cells[0])), len(rows))
    header = "\n".join(lines[: rows[start][0] - 1] if start < len(rows) else lines)
    found = _File(path, header, rows[start:])
    for line, cells in rows[:start]:
        if 2 * sum(map(_is_number, cells)) >= len(cells):
            odd = f"{cells[0].strip()[:12]!r} is no number, and a heading has none; correct the line"
            raise found.error(odd, line)
    return found


def read_grid(path: str | Path) -> HazardGrid:
    """Read a grid in the layout of Allegato B: lon, lat, then a_g, F0, T_C* for nine return periods.

    Tab- or semicolon-separated, decimal point or comma, a_g in g/10, header lines first, and optionally the
    node's number before lon. Raises HazardError naming file and line; OSError where it cannot be opened.
    """
    file = _read(path)
    if not file.rows:
        raise file.error("no row of numbers; give the grid of Allegato B, tab- or semicolon-separated")
    meaning = "lon, lat, then a_g, F0, T_C* for nine return periods; optionally the node's number first"
    table = file.numbers(_COLUMNS, meaning)
    values = table[:, 2:].reshape(-1, len(RETURN_PERIODS), 3) / np.array([10.0, 1.0, 1.0])
    if not (placed := (abs(table[:, :2]) <= (180.0, 90.0)).all(axis=1)).all():
        text = "longitude and latitude must be degrees, longitude first; correct it"
        raise file.error(text, file.rows[int(np.argmin(placed))][0])
    file.check(values, "in g/10, as in Allegato B")
    if (most := values[:, 6, 0].max()) < 0.03:  # at 475 years everywhere
        raise file.error(f"a_g at 475 years is {most:.2g} g at most; it must be in g/10, as in Allegato B")
    return HazardGrid(file.path.name, table[:, 0], table[:, 1], values)


def read_site_table(path: str | Path) -> Array | None:
    """Read a site's own table (9, 3): a_g (g), F0, T_C* (s), from nine lines T_R; a_g; F0; T_C*.

    None where the file is no such table but may be a grid. A header names the unit of a_g, [g] or [g/10]: the
    two cannot be distinguished by their size. Raises HazardError naming the file; OSError where it cannot be opened.
    """
    file = _read(path)
    if not file.rows or len(file.rows[0][1]) != 4:
        return None
    table = file.numbers(4, "T_R, a_g, F0, T_C*", numbered=False)
    if len(table) != len(RETURN_PERIODS) or not np.array_equal(table[:, 0], RETURN_PERIODS):
        periods = ", ".join(f"{T_R:g}" for T_R in RETURN_PERIODS)
        raise file.error(f"a site's table must have one line for each return period: {periods} years")
    names = re.split(r"[;\t]", file.header.strip().split("\n")[-1])
    for name, column in zip(names, SITE_COLUMNS, strict=False):
        plain = re.sub(r"[^a-z0-9]", "", name.lower())
        if len(names) == 4 and not plain.startswith(re.sub(r"[^a-z0-9]", "", column.lower())):
            called = f"the header calls a column {name.strip()[:12]!r} that is read as {column}"
            raise file.error(f"{called}; the columns must be T_R; a_g [g]; F0; T_C*")
    unit = next((unit for unit in ("g/10", "g") if f"[{unit}]" in file.header.replace(" ", "")), None)
    if unit is None:
        raise file.error("the unit of a_g is not given; write it in a header line: T_R; a_g [g]; F0; T_C*")
    values = table[:, 1:] / np.array([10.0 if unit == "g/10" else 1.0, 1.0, 1.0])
    file.check(values[None], f"in {unit}, as the header says")
    return values


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


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
    """Hazard of one site for the nine return periods: a_g (g), F0, T_C* (s) at RETURN_PERIODS."""

    name: str
    values: Array  # (9, 3), the average of the nodes
    node_values: Array  # (m, 9, 3), of the m = 4 nodes of the cell (1 when the site is a node)
    distances: Array  # (m,), km

    def at(self, return_period: float) -> Hazard:
        """Return the hazard for T_R (30 to 2475 years): log p linear in log T_R (Allegato A, eq. 1)."""
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

    def return_period_step(self, ag: float) -> Line:
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
        results = zip(_PARAMETERS, _UNITS, (hazard.ag, hazard.F0, hazard.Tc_star), strict=True)
        for j, (symbol, unit, result) in enumerate(results):
            first, second = f"{symbol}_1", f"{symbol}_2"
            lines += [self._space(first, unit, k, j), self._space(second, unit, k + 1, j)]
            formula = f"exp(log({first}) + log({second}/{first})*log(T_R/T_R_1)/log(T_R_2/T_R_1))"
            lines.append(step(symbol, formula, result, unit, f"{_ALLEGATO}, eq. 1"))
        return worked(*lines, T_R_1=T1, T_R_2=T2)

    def _space(self, symbol: str, unit: str, column: int, j: int) -> Line:
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
    return worked(
        datum("V_N", nominal_life, "years", "NTC 2018, Tab. 2.4.I"),
        datum("C_U", C_U, "", f"NTC 2018, Tab. 2.4.II, {use_class}"),
        datum("P_VR", P, "", f"NTC 2018, Tab. 3.2.I, {limit_state}"),
        step("V_R", "V_N*C_U", nominal_life * C_U, "years", "NTC 2018, §2.4.3"),
        step("T_R", "min(2475, max(30, -V_R/log(1 - P_VR)))", T_R, "years", "NTC 2018, §3.2.1"),
    )


def site_curve(
    grid: HazardGrid | str | Path | None = None, latitude: float | None = None, longitude: float | None = None
) -> HazardCurve:
    """Return the hazard of a site for the nine return periods: p = Σ(p_i/d_i)/Σ(1/d_i) over its cell's nodes.

    `grid`: default Allegato B; a file of nine lines is the site's own table. Latitude and longitude in degrees, in the
    datum of the grid (ED50 in Allegato B [k]). Raises HazardError where no cell of four nodes holds the site.
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
    for name, angle, most in (("latitude", latitude, 90.0), ("longitude", longitude, 180.0)):
        require(is_between(angle, -most, most, "[]"), name, angle, f"from -{most:g} to {most:g}, in degrees")
    x = (grid.longitude - longitude) * np.cos(np.radians(latitude)) * _KM_PER_DEGREE
    y = (grid.latitude - latitude) * _KM_PER_DEGREE
    distance = np.hypot(x, y)
    near = np.argsort(distance)[:_NEAR]
    if distance[near[0]] < 1e-3:
        node = near[:1]
        return HazardCurve(grid.name, grid.values[node[0]], grid.values[node], np.zeros(1))
    cell = _cell(np.column_stack([x[near], y[near]]))
    if cell is None:
        lon, lat, first = grid.longitude, grid.latitude, int(near[0])
        inside = bool(lon.min() <= latitude <= lon.max() and lat.min() <= longitude <= lat.max())
        turned = f"They are swapped: write latitude = {longitude:g}, longitude = {latitude:g}. " * inside
        raise HazardError(
            f"{grid.name}: site latitude = {latitude:g}, longitude = {longitude:g}: no cell of four nodes holds it; "
            f"the nearest node is {distance[first]:.1f} km away (latitude {lat[first]:g}, longitude {lon[first]:g}; "
            f"the grid spans latitude {lat.min():g}–{lat.max():g}, longitude {lon.min():g}–{lon.max():g}). {turned}"
            "Check the coordinates; at the edge of the grid and on islands (Allegato B, table 2) give ag_g, F0 and "
            "Tc_star_s of each limit state instead of coordinates"
        )
    nodes = near[cell]
    weights = 1.0 / distance[nodes]
    values = np.tensordot(weights / weights.sum(), grid.values[nodes], axes=1)
    return HazardCurve(grid.name, values, grid.values[nodes], distance[nodes])


def hazard_range(return_period: float) -> tuple[Hazard, Hazard]:
    """Return the least and greatest a_g, F0 and T_C* of the nodes of Allegato B at T_R (30 to 2475 years)."""
    values = allegato_b().values
    least, most = values.min(axis=0), values.max(axis=0)
    low, high = (HazardCurve(ALLEGATO_B, v, v[None], np.zeros(1)).at(return_period) for v in (least, most))
    return low, high


def site_hazard(
    grid: HazardGrid | str | Path | None = None, latitude: float | None = None, longitude: float | None = None,
    return_period: float | None = None,
) -> Hazard:  # fmt: skip
    """Return a_g (g), F0, T_C* (s) of a site at T_R (years), by a grid, its file, a site's table. Raises ValueError."""
    if return_period is None:
        raise ArgumentError("return_period: missing; must be from 30 to 2475 years")
    try:
        curve = site_curve(grid, latitude, longitude)
    except OSError as error:
        text = f"grid = {str(grid)!r}: must be a file that can be read ({error.strerror})"
        raise ArgumentError(text) from None
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


def _interval(return_period: float) -> int:
    low, high = RETURN_PERIODS[0], RETURN_PERIODS[-1]
    require(low <= return_period <= high, "return_period", return_period, "from 30 to 2475 years")
    return int(np.clip(np.searchsorted(RETURN_PERIODS, return_period) - 1, 0, len(RETURN_PERIODS) - 2))


EXPONENT = 0.41  # slope of log a_g over log T_R for Italy as a whole (not compared with the text [k])
_LAW = "D.M. 58/2017, Allegato A; NTC 2018, §3.2.1"


def capacity_return_period(
    a_g: float, pga: float, demand_pga: float, demand_T_R: float | None, hazard: HazardCurve | None
) -> Line | None:
    """Return the step of T_R,C (years); None where neither the hazard curve nor the demand's T_R is known.

    a_g (g) on rock is looked up on the site's hazard between 30 and 2475 years; beyond, and without a curve,
    T_R,C = T_R,D (PGA_C/PGA_D)^(1/0.41), PGA at the surface, and not back inside the bound of the curve. Where
    the demand's T_R is not known either, the bound stands for what lies beyond it.
    """
    if hazard is not None and (demand_T_R is None or hazard.values[0, 0] <= a_g <= hazard.values[-1, 0]):
        return hazard.return_period_step(a_g)
    if demand_T_R is None:
        return None
    formula = f"T_R_demand*(PGA_capacity/PGA_demand)**(1/{EXPONENT:g})"
    T_R = demand_T_R * (pga / demand_pga) ** (1.0 / EXPONENT)
    if hazard is not None:
        low, *_, high = RETURN_PERIODS.tolist()
        above = a_g > hazard.values[-1, 0]
        T_R = max(high, T_R) if above else min(low, T_R)
        formula = f"max({high:g}, {formula})" if above else f"min({low:g}, {formula})"
    return step("T_R_capacity", formula, T_R, "years", _LAW, T_R_demand=demand_T_R, PGA_capacity=pga,
                PGA_demand=demand_pga)  # fmt: skip


def stated(T_R: float | None) -> str | None:
    """Return "> 2475" or "< 30" for a return period (years) outside what the hazard is known for, otherwise None."""
    low, *_, high = RETURN_PERIODS.tolist()
    if T_R is None or low <= T_R <= high:
        return None
    return f"> {high:g}" if high < T_R else f"< {low:g}"
