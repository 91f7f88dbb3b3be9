"""Where joints are pressed most: the greatest edge pressure of each, with and without crushing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass

from assessment.results.configurations.joint_states import joint_states, loaded
from assessment.results.schema import Results
from assessment.results.schema.checks import Direction
from assessment.results.schema.part import present
from assessment.results.schema.static import Contacts
from assessment.results.table import Table, columns_of

PRINTED = {"short": 10, "full": 40}  # joints of the report's table, those that are pressed most


@dataclass(frozen=True)
class EdgePressure:
    """The greatest edge pressure of a joint, and in which state, towards where and with which joints it was found.

    `joint`: its number in the drawing, None for a pair of faces that met as blocks moved; `block_a`, `block_b`: the
    blocks that it lies between; `direction`: of the push, None at rest. Without a strength both pressures are the same.
    """

    joint: int | None
    block_a: int
    block_b: int
    edge_pressure_kN_m2: float
    uncrushed_pressure_kN_m2: float
    state: str
    direction: Direction | None
    contacts: Contacts


def edge_pressures(results: Results) -> list[EdgePressure]:
    """Return the greatest edge pressure of every joint, the greatest first.

    Over the states at rest and the peaks of the pushover curves with elastic joints, as far as there are any: in a
    rigid mechanism hinges press without bound.
    """
    situations = list(loaded(results))
    elastic = [each for each in situations if each.contacts == "elastic"]
    drawn = len(results.geometry.joints)
    greatest: dict[int | str, EdgePressure] = {}
    for situation in elastic or situations:
        states = joint_states(results, situation)
        for number, (a, b) in enumerate(states.blocks.tolist()):
            key = number if number < drawn else str(situation.met[number - drawn].faces_m)
            pressed = EdgePressure(
                joint=number if number < drawn else None,
                block_a=a,
                block_b=b,
                edge_pressure_kN_m2=float(states.pressure[number]),
                uncrushed_pressure_kN_m2=float(states.uncrushed[number]),
                state=situation.state,
                direction=situation.direction,
                contacts=situation.contacts,
            )
            if (
                key not in greatest
                or pressed.uncrushed_pressure_kN_m2 > greatest[key].uncrushed_pressure_kN_m2
            ):
                greatest[key] = pressed
    return sorted(greatest.values(), key=lambda each: -each.uncrushed_pressure_kN_m2)


def edge_pressure_table(results: Results) -> Table:
    """List the greatest edge pressure of every joint, the greatest first."""
    return Table(
        "edge_pressures", [asdict(each) for each in edge_pressures(results)], columns_of(EdgePressure)
    )


def printed(results: Results) -> int:
    """Return how many joints the report prints."""
    return PRINTED[results.echo.report.annexes or "short"]


def reported_pressures(results: Results) -> Table:
    """Return the joints that are pressed most; without the pressures of no crushing where no joint crushes.

    No rows where the greatest has no bound, as in the hinges of rigid joints.
    """
    found = edge_pressures(results)
    left_out = () if crushes(results) else ("uncrushed_pressure_kN_m2",)
    columns = tuple(column for column in columns_of(EdgePressure) if column not in left_out)
    rows = [present(asdict(each)) for each in (found[: printed(results)] if bounded(found) else ())]
    return Table("edge_pressures", rows, columns)


def bounded(found: Sequence[EdgePressure]) -> bool:
    """Return whether the greatest pressure, the first, is a number."""
    return not found or math.isfinite(found[0].uncrushed_pressure_kN_m2)


def crushes(results: Results) -> bool:
    """Return whether any joint has a compressive strength."""
    return any(joint.compressive_strength_kN_m2 is not None for joint in results.geometry.joints)
