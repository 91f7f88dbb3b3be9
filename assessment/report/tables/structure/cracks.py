"""Cracks of settled states: joints that a movement opened or made slide, to be compared with a survey."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from assessment.results.configurations.faces import faces_of
from assessment.results.schema import Results
from assessment.results.table import Table, columns_of
from mechanics.model import H, V, end_gaps, end_points

SEEN = 0.5e-3  # m: the least opening that a survey sees
DIGITS = 6  # of metres: what is less is rounding, not a crack
PRINTED = 40  # joints of a state in the report, the widest first; tables/cracks.csv has all


@dataclass(frozen=True)
class Crack:
    """A joint of a settled state, between `block_a` and `block_b`, that opened or slipped by more than `SEEN`.

    `opening_m` is that of the end that opens more, at (x_m, z_m) in the settled state; `slip_m` is without a sign, as a
    survey has it; None: the faces have slid off each other.
    """

    state: str
    joint: int
    block_a: int
    block_b: int
    x_m: float
    z_m: float
    opening_m: float | None
    other_opening_m: float | None
    slip_m: float | None


def cracks(results: Results) -> Table:
    """List the cracks of every settled state."""
    return _table(results, None)


def reported_cracks(results: Results) -> Table:
    """Return the rows of the report: of each state the widest."""
    return _table(results, PRINTED)


def cracks_of(results: Results, state: str) -> list[Crack]:
    """Return the cracks of a settled state, the widest first; of any other state none."""
    if not results.states[state].settlement:
        return []
    faces = faces_of(results)
    contacts = faces.contacts
    positions = faces.positions(np.asarray(results.states[state].configuration, dtype=float))
    places, ends = contacts.places(positions), end_points(contacts, positions)
    gaps, slips = end_gaps(places), places[:, V]
    apart = places[:, H] <= 0.0
    shown = np.flatnonzero(apart | (gaps.max(axis=1) > SEEN) | (abs(slips) > SEEN))
    found = []
    for joint in shown[np.argsort(-np.where(apart, np.inf, gaps.max(axis=1))[shown], kind="stable")]:
        wide = int(np.argmax(gaps[joint]))
        opening, other = gaps[joint, wide], gaps[joint, 1 - wide]
        found.append(
            Crack(
                state=state,
                joint=int(joint),
                block_a=int(contacts.a[joint]),
                block_b=int(contacts.b[joint]),
                x_m=float(ends[joint, wide, 0]),
                z_m=float(ends[joint, wide, 1]),
                opening_m=None if apart[joint] else round(float(opening), DIGITS),
                other_opening_m=None if apart[joint] else max(0.0, round(float(other), DIGITS)),
                slip_m=None if apart[joint] else round(float(abs(slips[joint])), DIGITS),
            )
        )
    return found


def _table(results: Results, most: int | None) -> Table:
    rows = [asdict(each) for state in results.states for each in cracks_of(results, state)[:most]]
    return Table("cracks", rows, columns_of(Crack))
