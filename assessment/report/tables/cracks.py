"""Cracks of settled states: joints that a movement opened or made slide, beside those that were surveyed."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Annotated

import numpy as np
import shapely

from assessment.report.tables import Found, table
from assessment.report.tables.structure import printed
from assessment.results.hand_check import block_size
from assessment.results.joint_states import faces_of
from assessment.results.schema import Point, Results, named
from assessment.results.table import Table, columns_of
from mechanics.model import H, V, end_gaps, end_points
from mechanics.types import Array, Mask

SEEN = 0.5e-3  # m: the least opening that a survey sees
DIGITS = 6  # of metres: what is less is rounding, not a crack
SURVEY = {"crack": "opening_mm", "slip": "slip_mm"}  # kinds of measurements that a joint shows
BESIDE = 0.25  # of a block's size: a line that is farther from every joint goes through the stone
SAMPLES = np.linspace(0.05, 0.95, 11)  # along a line that was drawn: where its distance from joints is taken


@dataclass(frozen=True)
class Crack:
    """A joint of a settled state, between `block_a` and `block_b`, that opened or slipped by more than `SEEN`.

    `opening_m` is that of the end that opens more, at (x_m, z_m) in the settled state; `slip_m` is without a sign, as a
    survey has it; None: the faces have slid off each other.
    """

    state: str
    joint: int
    block_a: Annotated[int, named("Blocco a|Block a")]
    block_b: Annotated[int, named("Blocco b|Block b")]
    x_m: float
    z_m: float
    opening_m: Annotated[float | None, named("Apertura|Opening", shown="mm", decimals=1)]
    other_opening_m: Annotated[
        float | None, named("All’altro estremo|At the other end", shown="mm", decimals=1)
    ]
    slip_m: Annotated[float | None, named("Scorrimento|Slip", shown="mm", decimals=1)]


@dataclass(frozen=True)
class Surveyed:
    """What was surveyed, beside what the joint nearest to it does in a settled state.

    `mark`: M and the number of the measurement, F and that of a line drawn as a crack, of which nothing was measured;
    `joint`: None where the line is beside none; `calculated_mm`: the opening there, of a slip the slip, None without a
    joint or where its faces are apart; `line` (n, 2) m as drawn; `seen`: whether the joint opens or slips by `SEEN`.
    """

    state: str
    mark: Annotated[str, named("Segno|Mark")]
    measurement: str
    measured_kind: Annotated[str, named("Tipo|Kind")]
    measured_mm: Annotated[float | None, named("Misurato|Measured", decimals=1, null="none")]
    sigma_mm: Annotated[float | None, named("σ", decimals=1, null="none")]
    joint: int | None
    calculated_mm: Annotated[float | None, named("Calcolato|Calculated", decimals=1, null="none")]
    line: list[Point]
    seen: bool


def survey(results: Results) -> Iterator[tuple[str, str, str, float | None, float | None, list[Point]]]:
    """Yield mark, name, kind, measured value and its deviation (mm), and place (m) of every surveyed crack and slip."""
    for number, each in enumerate(results.echo.measurement or (), 1):
        kind = each.get("kind", "")
        if kind in SURVEY and each.get(SURVEY[kind]) is not None:
            value, sigma = each[SURVEY[kind]], each.get("sigma_mm")
            yield f"M{number}", each["name"], kind, value, sigma, [each["point_m"]]
    for number, line in enumerate(results.geometry.cracks_m or (), 1):
        yield f"F{number}", "", "crack", None, None, line


def surveyed(results: Results, state: str) -> list[Surveyed]:
    """Return what was surveyed beside the joints of a settled state; of any other state nothing."""
    found = list(survey(results))
    joints = np.array([joint.ends_m for joint in results.geometry.joints], dtype=float)
    if not found or not len(joints) or not results.states[state].settlement:
        return []
    gaps, slips, apart = _openings(results, state)
    reach = BESIDE * block_size(results)
    rows = []
    for mark, name, kind, value, sigma, line in found:
        points = np.asarray(line, dtype=float)  # of a line, points at even shares of its length
        if len(points) > 1:
            at = shapely.line_interpolate_point(shapely.linestrings(points), SAMPLES, normalized=True)
            points = shapely.get_coordinates(at)
        away = shapely.distance(shapely.linestrings(joints)[:, None], shapely.points(points)[None, :])
        k = int(np.argmin(away.mean(axis=1)))
        middle = points[len(points) // 2]
        joint = shapely.linestrings(joints[k])
        share = float(shapely.line_locate_point(joint, shapely.Point(middle), normalized=True))
        opening = float(max(0.0, (1.0 - share) * gaps[k, 0] + share * gaps[k, 1]))
        calculated = 1000.0 * (float(slips[k]) if kind == "slip" else opening)
        off = value is None and away[k].mean() > reach
        seen = not off and bool(apart[k] or max(gaps[k].max(), slips[k]) > SEEN)
        there = None if off else k, None if off or apart[k] else calculated
        rows.append(Surveyed(state, mark, name, kind, value, sigma, *there, line, seen))
    return rows


def survey_table(results: Results) -> Table:
    """List what was surveyed beside what each settled state has there."""
    columns = columns_of(Surveyed)[:-1]
    rows = [asdict(each) for state in results.states for each in surveyed(results, state)]
    kept = [name for name in columns if any(row[name] not in (None, "") for row in rows)]
    shown = [{key: row[key] for key in kept if key != "joint" or row[key] is not None} for row in rows]
    return Table("survey", shown, tuple(kept))


def cracks_of(results: Results, state: str) -> list[Crack]:
    """Return the cracks of a settled state, the widest first; of any other state none."""
    if not results.states[state].settlement:
        return []
    faces = faces_of(results)
    contacts = faces.contacts
    ends = end_points(contacts, faces.positions(np.asarray(results.states[state].configuration, dtype=float)))
    gaps, slips, apart = _openings(results, state)
    shown = np.flatnonzero(apart | (gaps.max(axis=1) > SEEN) | (slips > SEEN))
    found = []
    for joint in shown[np.argsort(-np.where(apart, np.inf, gaps.max(axis=1))[shown], kind="stable")]:
        wide = int(np.argmax(gaps[joint]))
        x, z = ends[joint, wide].tolist()
        between = int(contacts.a[joint]), int(contacts.b[joint])
        widths = float(gaps[joint, wide]), max(0.0, float(gaps[joint, 1 - wide])), float(slips[joint])
        known = [None if apart[joint] else max(0.0, round(width, DIGITS)) for width in widths]
        found.append(Crack(state, int(joint), *between, x, z, *known))
    return found


@table("cracks", Crack)
def cracks(results: Results) -> Found:
    """List the cracks of every settled state."""
    for state in results.states:
        yield from cracks_of(results, state)


def reported_cracks(results: Results) -> Table:
    """Return the rows of the report: of each state the widest."""
    most = printed(results)
    found = [asdict(each) for state in results.states for each in cracks_of(results, state)[:most]]
    return Table("cracks", found, columns_of(Crack))


def _openings(results: Results, state: str) -> tuple[Array, Array, Mask]:
    """Return the gaps at both ends (j, 2) and the slips (j,) of the joints of a state, m, and which are apart (j,)."""
    faces = faces_of(results)
    places = faces.contacts.places(faces.positions(np.asarray(results.states[state].configuration)))
    return end_gaps(places), abs(places[:, V]), places[:, H] <= 0.0
