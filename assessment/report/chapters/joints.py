"""What the report says of joints: the laws that they obey, and where they are pressed most."""

from __future__ import annotations

import math
from collections.abc import Iterator

from markupsafe import Markup

from assessment.report.text.language import Words
from assessment.results.echo import collisions, coulomb, segments
from assessment.results.joint_states import joint_states, loaded
from assessment.results.schema import Results
from assessment.results.schema.model import Echo
from assessment.results.table import Row, Table

PRINTED = 12  # joints of the report's table, those that are pressed most
COLUMNS = ("joint", "block_a", "block_b", "edge_pressure_kN_m2", "uncrushed_pressure_kN_m2")
WHERE = ("state", "direction", "contacts")


def assumptions(results: Results, words: Words, elastic: bool) -> Iterator[Markup]:
    """Yield what the model assumes of blocks, joints and supports; `elastic`: whether any joint is."""
    for key in ("blocks_rigid", "plane", "no_tension"):
        yield words(f"text.{key}")
    yield from joint_law(results, words, elastic)
    yield words("text.supports_rigid")


def joint_law(results: Results, words: Words, elastic: bool) -> Iterator[Markup]:
    """Yield the sentences on joints: how they are found, press, crush, slide and meet; `elastic`: whether any is."""
    yield words("text.joints")
    yield from _bed(results.echo, words) if elastic else [words("text.rigid_joints")]
    strengths = [joint.compressive_strength_kN_m2 for joint in results.geometry.joints]
    limits = sorted({each for each in strengths if each is not None})
    said = "; ".join(words.number(each) for each in limits)
    key = "no_strength" if not limits else "some_strength" if None in strengths else "strength"
    yield words(f"text.{key}", strength=said)
    if pressed := reported_pressures(results).rows:
        most = pressed[0]
        pressure = words.number(most["edge_pressure_kN_m2"])
        blocks = {"first": most["block_a"], "second": most["block_b"]}
        yield words("text.greatest_pressure", pressure=pressure, state=words.state(most["state"]), **blocks)
    yield words("text.sliding_coulomb" if coulomb(results.echo) else "text.sliding")
    yield words("text.collisions" if collisions(results.echo) else "text.no_collisions")


def _bed(echo: Echo, words: Words) -> Iterator[Markup]:
    if found := segments(echo):
        yield words("text.bed_points", segments=", ".join(map(str, found)))
    else:
        yield words("text.bed_exact")


def edge_pressures(results: Results) -> Table:
    """List the greatest edge pressure of every joint, with and without crushing, and where; greatest first.

    Over the states at rest and the peaks of the pushover curves with elastic joints, as far as there are any: in a
    rigid mechanism hinges press without bound. Pairs of faces that met as blocks moved have no number.
    """
    known = list(loaded(results))
    elastic = [each for each in known if each.contacts == "elastic"]
    drawn = len(results.geometry.joints)
    found: dict[int | str, Row] = {}
    for situation in elastic or known:
        states = joint_states(results, situation)
        for number, (a, b) in enumerate(states.blocks.tolist()):
            key = number if number < drawn else str(situation.met[number - drawn].faces_m)
            pressure, uncrushed = float(states.pressure[number]), float(states.uncrushed[number])
            if key not in found or uncrushed > found[key]["uncrushed_pressure_kN_m2"]:
                found[key] = {
                    "joint": number if number < drawn else None,
                    "block_a": a,
                    "block_b": b,
                    "edge_pressure_kN_m2": pressure,
                    "uncrushed_pressure_kN_m2": uncrushed,
                    **{name: getattr(situation, name) for name in WHERE},
                }
    rows = sorted(found.values(), key=lambda row: -row["uncrushed_pressure_kN_m2"])
    return Table("edge_pressures", rows, (*COLUMNS, *WHERE))


def reported_pressures(results: Results) -> Table:
    """Return the joints that are pressed most; without the pressures of no crushing where no joint crushes.

    No rows where the greatest has no bound, as in the hinges of rigid joints.
    """
    table = edge_pressures(results)
    left_out = () if crushes(results) else ("uncrushed_pressure_kN_m2",)
    columns = tuple(column for column in table.columns if column not in left_out)
    rows = [
        {key: value for key, value in row.items() if key in columns and value is not None}
        for row in (table.rows[:PRINTED] if _bounded(table) else ())
    ]
    return Table(table.name, rows, columns)


def pressures_told(results: Results, words: Words) -> Markup:
    """Return what the table of the report holds, or why it is left out; nothing where no forces are known."""
    table = edge_pressures(results)
    if not table.rows:
        return Markup("")
    if not _bounded(table):
        return words("text.unbounded_pressures")
    said = words("text.edge_pressures", count=min(PRINTED, len(table.rows)))
    return said + Markup(" ") + words("text.crushing") if crushes(results) else said


def _bounded(table: Table) -> bool:
    """Whether the greatest pressure, the first, is a number."""
    return not table.rows or math.isfinite(table.rows[0]["uncrushed_pressure_kN_m2"])


def crushes(results: Results) -> bool:
    """Return whether any joint has a compressive strength."""
    return any(joint.compressive_strength_kN_m2 is not None for joint in results.geometry.joints)
