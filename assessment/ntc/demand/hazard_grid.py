"""Seismic hazard: the grid of D.M. 14/01/2008, Allegato B, other grids, and the nine lines of one site."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RETURN_PERIODS = np.array([30.0, 50.0, 72.0, 101.0, 140.0, 201.0, 475.0, 975.0, 2475.0])  # years
_COLUMNS = 2 + 3 * len(RETURN_PERIODS)
ALLEGATO_B = "D.M. 14/01/2008, Allegato B"
_DIGITS = {"longitude": 4, "latitude": 3, "ag": 3, "F0": 2, "Tc_star": 2}  # decimals that the act prints
MOST_BYTES = 50_000_000  # of a file; Allegato B has two and a half
MOST_AG, MOST_F0, MOST_TC = 10.0, 100.0, 10.0  # g, –, s: beyond them it is another quantity, or another unit
SITE_COLUMNS = ("T_R", "a_g", "F0", "T_C*")
_Rows = list[tuple[int, list[str]]]


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
    """Return the reference grid of D.M. 14/01/2008 (Gazzetta Ufficiale 29, 4/2/2008), Allegato B, table 1.

    The text of an official act of the State is in no one's copyright (L. 633/1941, art. 5). `allegato_b.npz` holds the
    digits that the act prints, as whole numbers: degrees, a_g in g/10, F0 and T_C* (s) for nine return periods.
    """
    with files("assessment.ntc.demand").joinpath("allegato_b.npz").open("rb") as file, np.load(file) as table:
        read = {name: table[name] / 10.0**digits for name, digits in _DIGITS.items()}
    values = np.stack([read["ag"].T / 10.0, read["F0"].T, read["Tc_star"].T], axis=2)
    return HazardGrid(ALLEGATO_B, read["longitude"], read["latitude"], values)


def read_grid(path: str | Path) -> HazardGrid:
    """Read a grid in the layout of Allegato B: lon, lat, then a_g, F0, T_C* for nine return periods.

    Tab- or semicolon-separated, decimal point or comma, a_g in g/10, header lines first, and optionally the
    node's number before lon. Raises HazardError naming file and line; OSError where it cannot be opened.
    """
    path = Path(path)
    _, rows = _read(path)
    if not rows:
        raise HazardError(
            f"{path}: no row of numbers; give the grid of Allegato B, tab- or semicolon-separated"
        )
    table = _numbers(
        path, rows, _COLUMNS,
        "lon, lat, then a_g, F0, T_C* for nine return periods; optionally the node's number first",
    )  # fmt: skip
    values = table[:, 2:].reshape(-1, len(RETURN_PERIODS), 3) / np.array([10.0, 1.0, 1.0])
    place = abs(table[:, :2]) <= np.array([180.0, 90.0])
    if not (placed := place.all(axis=1)).all():
        line = rows[int(np.argmin(placed))][0]
        raise HazardError(
            f"{path}: line {line}: longitude and latitude must be degrees, longitude first; correct it"
        )
    _check_values(path, values, [line for line, _ in rows], "in g/10, as in Allegato B")
    if values[:, 6, 0].max() < 0.03:  # at 475 years everywhere
        raise HazardError(
            f"{path}: a_g at 475 years is {values[:, 6, 0].max():.2g} g at most; it must be in g/10, as in Allegato B"
        )
    return HazardGrid(path.name, table[:, 0], table[:, 1], values)


def read_site_table(path: str | Path) -> Array | None:
    """Read a site's own table (9, 3): a_g (g), F0, T_C* (s), from nine lines T_R; a_g; F0; T_C*.

    None where the file is no such table but may be a grid. A header names the unit of a_g, [g] or [g/10]: the
    two cannot be distinguished by their size. Raises HazardError naming the file; OSError where it cannot be opened.
    """
    path = Path(path)
    header, rows = _read(path)
    if not rows or len(rows[0][1]) != 4:
        return None
    table = _numbers(path, rows, 4, "T_R, a_g, F0, T_C*", numbered=False)
    if len(table) != len(RETURN_PERIODS) or not np.array_equal(table[:, 0], RETURN_PERIODS):
        periods = ", ".join(f"{T_R:g}" for T_R in RETURN_PERIODS)
        raise HazardError(
            f"{path}: a site's table must have one line for each return period: {periods} years"
        )
    names = re.split(r"[;\t]", header.strip().split("\n")[-1])
    for name, column in zip(names, SITE_COLUMNS, strict=False):
        plain = re.sub(r"[^a-z0-9]", "", name.lower())
        if len(names) == 4 and not plain.startswith(re.sub(r"[^a-z0-9]", "", column.lower())):
            raise HazardError(
                f"{path}: the header calls a column {name.strip()[:12]!r} that is read as {column}; "
                "the columns must be T_R; a_g [g]; F0; T_C*"
            )
    unit = next((unit for unit in ("g/10", "g") if f"[{unit}]" in header.replace(" ", "")), None)
    if unit is None:
        raise HazardError(
            f"{path}: the unit of a_g is not given; write it in a header line: T_R; a_g [g]; F0; T_C*"
        )
    values = table[:, 1:] / np.array([10.0 if unit == "g/10" else 1.0, 1.0, 1.0])
    _check_values(path, values[None], [rows[0][0]], f"in {unit}, as the header says")
    return values


def _check_values(path: Path, values: Array, lines: Sequence[int], unit: str) -> None:
    """Raise HazardError naming the line where values (n, 9, 3), a_g in g, are those of no site."""
    most = np.array([MOST_AG, MOST_F0, MOST_TC])
    for name, fits, must in (
        ("a_g, F0 and T_C*", (values > 0.0) & (values < most), f"be positive numbers, a_g {unit}"),
        ("F0", values[..., 1:2] >= 1.0, "be 1 or more: the spectrum is not below a_g"),
        ("a_g", np.diff(values[..., 0], axis=1) > 0.0, "grow with the return period"),
    ):
        if not (good := fits.reshape(len(values), -1).all(axis=1)).all():
            line = lines[int(np.argmin(good))]
            raise HazardError(f"{path}: line {line}: {name} must {must}; get the file again from its source")


def _read(path: Path) -> tuple[str, _Rows]:
    """Return the header lines as one text, and the cells of the lines after them with their line numbers."""
    size = path.stat().st_size
    with path.open("rb") as file:
        content = file.read(MOST_BYTES) if 0 < size <= MOST_BYTES else b""  # what has no size may have no end
    if size > MOST_BYTES:
        raise HazardError(f"{path}: more than {MOST_BYTES} bytes; give the grid of Allegato B")
    lines = content.decode("latin-1").splitlines()
    separator = ";" if any(";" in line for line in lines[:5]) else "\t"
    rows = [(i, line.replace(",", ".").split(separator)) for i, line in enumerate(lines, 1) if line.strip()]
    start = next((k for k, (_, cells) in enumerate(rows) if _is_number(cells[0])), len(rows))
    for line, cells in rows[:start]:
        if 2 * sum(map(_is_number, cells)) >= len(cells):
            raise HazardError(
                f"{path}: line {line}: {cells[0].strip()[:12]!r} is no number, and a heading has none; correct the line"
            )
    return "\n".join(lines[: rows[start][0] - 1] if start < len(rows) else lines), rows[start:]


def _numbers(path: Path, rows: _Rows, columns: int, meaning: str, numbered: bool = True) -> Array:
    """Return the last `columns` cells of every row as numbers (n, columns); a number may stand before them."""
    allowed: Sequence[int] = (columns, columns + 1) if numbered else (columns,)
    for i, cells in rows:
        if len(cells) not in allowed or not all(map(_is_number, cells)):
            found = ", ".join(cell.strip()[:12] for cell in cells[:4])
            raise HazardError(
                f"{path}: line {i}: {columns} numbers expected ({meaning}), found {len(cells)} cells: {found}…; "
                "correct the line, or get the file again from its source"
            )
    return np.array([cells[-columns:] for _, cells in rows], dtype=float)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
