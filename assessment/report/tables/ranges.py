"""Ranges of what scatters: the value that is used, and the least and the greatest of the members of an ensemble."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass

from assessment.results.schema import Results
from assessment.results.schema.checks import Direction
from assessment.results.schema.part import Part
from assessment.results.schema.static import Contacts
from assessment.results.table import Table, cells, columns_of

RANGE = "_range"  # behind the name of a quantity, in the schema: the ends of its range


@dataclass(frozen=True)
class Range:
    """Range of a quantity, in its unit in results.json; None where it does not depend on direction, joints or check."""

    state: str
    direction: Direction | None
    contacts: Contacts | None
    limit_state: str | None
    quantity: str
    value: float | None
    lowest: float | None
    highest: float | None


def ranges(results: Results) -> Iterator[Range]:
    """Yield the ranges of the states whose paths scatter: pushdowns, pushovers, checks."""
    for name, state in results.states.items():
        for contacts, path in state.pushdown.items():
            yield from _of(path, name, contacts=contacts)
        for direction, pushover in state.pushover.items():
            for contacts, curve in pushover.by_contacts.items():
                yield from _of(curve, name, direction, contacts)
        for direction, capacity in state.capacity.items():
            for limit, check in capacity.checks.items():
                yield from _of(check, name, direction, limit_state=limit)


def static_ranges(results: Results) -> Table:
    """List the ranges of the states whose paths scatter; what a range does not depend on is left out of its row."""
    rows = []
    for each in ranges(results):
        where = {"direction": each.direction, "contacts": each.contacts, "limit_state": each.limit_state}
        rows.append({key: value for key, value in asdict(each).items() if where.get(key, "") is not None})
    return Table("static_ranges", rows, columns_of(Range))


def _of(
    part: Part,
    state: str,
    direction: Direction | None = None,
    contacts: Contacts | None = None,
    limit_state: str | None = None,
) -> Iterator[Range]:
    """Yield every quantity of a part that has its range beside it."""
    numbers = cells(part, type(part).model_fields)
    for name, ends in numbers.items():
        if name.endswith(RANGE):
            quantity = name.removesuffix(RANGE)
            yield Range(state, direction, contacts, limit_state, quantity, numbers[quantity], *ends)
