"""Cracks of settled states: joints that a movement opened or made slide, to be compared with a survey."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from assessment.results.faces import faces_of
from assessment.results.schema import Results
from assessment.results.table import Row, Table
from mechanics.model import H, V, end_gaps, end_points

SEEN = 0.5e-3  # m: what a survey can tell from nothing
DIGITS = 6  # of metres: what is less is rounding, not a crack
PRINTED = 40  # joints of a state in the report, the widest first; tables/cracks.csv has all
COLUMNS = ("state", "joint", "block_a", "block_b", "x_m", "z_m", "opening_m", "other_opening_m", "slip_m")


def cracks(results: Results, states: Sequence[str] | None = None) -> Table:
    """List the joints of each settled state (of all, or of some) that open or slip by more than `SEEN`, widest first.

    `opening_m` is that of the end that opens more, at (x_m, z_m) in the settled state; `slip_m` is without a sign, as a
    survey has it; None: the faces have slid off each other.
    """
    rows: list[Row] = []
    for name, state in results.states.items():
        if state.settlement and (states is None or name in states):
            rows += _of_state(results, name)
    return Table("cracks", rows, COLUMNS)


def reported_cracks(results: Results) -> Table:
    """Return the rows of the report."""
    names = dict.fromkeys(row["state"] for row in cracks(results).rows)
    return Table("cracks", [row for name in names for row in cracks(results, [name]).rows[:PRINTED]], COLUMNS)


def _of_state(results: Results, name: str) -> list[Row]:
    faces = faces_of(results)
    contacts = faces.contacts
    positions = faces.positions(np.asarray(results.states[name].configuration, dtype=float))
    places, ends = contacts.places(positions), end_points(contacts, positions)
    gaps, slips = end_gaps(places), places[:, V]
    apart = places[:, H] <= 0.0
    shown = np.flatnonzero(apart | (gaps.max(axis=1) > SEEN) | (abs(slips) > SEEN))
    rows = []
    for joint in shown[np.argsort(-np.where(apart, np.inf, gaps.max(axis=1))[shown], kind="stable")]:
        wide = int(np.argmax(gaps[joint]))
        opening, other = gaps[joint, wide], gaps[joint, 1 - wide]
        rows.append(
            {
                "state": name,
                "joint": int(joint),
                "block_a": int(contacts.a[joint]),
                "block_b": int(contacts.b[joint]),
                "x_m": float(ends[joint, wide, 0]),
                "z_m": float(ends[joint, wide, 1]),
                "opening_m": None if apart[joint] else round(float(opening), DIGITS),
                "other_opening_m": None if apart[joint] else max(0.0, round(float(other), DIGITS)),
                "slip_m": None if apart[joint] else round(float(abs(slips[joint])), DIGITS),
            }
        )
    return rows
