"""Cracks of settled states: joints that a movement opened or made slide, to be compared with a survey."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from assessment.results.configurations.faces import faces_of
from assessment.results.configurations.outlines import outlines
from assessment.results.schema import Results
from assessment.results.schema.part import Point
from assessment.results.table import Table, columns_of
from mechanics.model import H, V, end_gaps, end_points

SEEN = 0.5e-3  # m: the least opening that a survey sees
DIGITS = 6  # of metres: what is less is rounding, not a crack
PRINTED = {"short": 10, "full": 40}  # joints of a state in the report, the widest; tables/cracks.csv has all
SURVEY = {"crack": "opening_mm", "slip": "slip_mm"}  # kinds of measurements that a joint shows


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


def printed(results: Results) -> int:
    """Return how many cracks of a state the report prints."""
    return PRINTED[results.echo.report.annexes or "short"]


def reported_cracks(results: Results) -> Table:
    """Return the rows of the report: of each state the widest."""
    return _table(results, printed(results))


@dataclass(frozen=True)
class Surveyed:
    """A crack or slip that was measured, beside what the joint nearest to it does in a settled state.

    `number`: its place among the measurements, from 1; `point_m`, `block`: where it was measured, and the block there.
    """

    state: str
    number: int
    measurement: str
    measured_kind: str
    measured_mm: float
    sigma_mm: float
    calculated_mm: float | None
    point_m: Point
    block: int


def surveyed(results: Results, state: str) -> list[Surveyed]:
    """Return the measured cracks and slips beside those of a settled state; of any other state none."""
    measured = [
        (number, each)
        for number, each in enumerate(results.echo.measurement or (), 1)
        if each.get("kind") in SURVEY and each.get(SURVEY[each["kind"]]) is not None
    ]
    joints = results.geometry.joints
    if not measured or not joints or not results.states[state].settlement:
        return []
    faces = faces_of(results)
    places = faces.contacts.places(
        faces.positions(np.asarray(results.states[state].configuration, dtype=float))
    )
    gaps, slips = end_gaps(places), abs(places[:, V])
    start, end = np.array([joint.ends_m for joint in joints], dtype=float).transpose(1, 0, 2)
    found = []
    for number, each in measured:
        point = np.asarray(each["point_m"], dtype=float)
        along = np.sum((point - start) * (end - start), axis=1) / np.maximum(
            np.sum((end - start) ** 2, axis=1), 1e-12
        )
        along = np.clip(along, 0.0, 1.0)
        nearest = int(np.argmin(np.hypot(*(start + along[:, None] * (end - start) - point).T)))
        share = along[nearest]
        opening = (1.0 - share) * gaps[nearest, 0] + share * gaps[nearest, 1]
        calculated = 1000.0 * float(max(0.0, opening) if each["kind"] == "crack" else slips[nearest])
        found.append(
            Surveyed(
                state=state,
                number=number,
                measurement=each["name"],
                measured_kind=each["kind"],
                measured_mm=float(each[SURVEY[each["kind"]]]),
                sigma_mm=float(each.get("sigma_mm") or 0.0),
                calculated_mm=calculated if places[nearest, H] > 0.0 else None,
                point_m=each["point_m"],
                block=outlines(results).nearest(point),
            )
        )
    return found


def survey_table(results: Results) -> Table:
    """List what was measured beside what each settled state has there."""
    columns = columns_of(Surveyed)[:-2]
    rows = [asdict(each) for state in results.states for each in surveyed(results, state)]
    return Table("survey", [{key: row[key] for key in columns} for row in rows], columns)


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
