"""One table from a list of fields: its rows are parts of the results, behind where they are."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import wraps
from typing import Any

from assessment.results.schema import Results
from assessment.results.schema.checks import Capacity, Direction
from assessment.results.schema.part import Part
from assessment.results.schema.static import ElasticPush, PushdownPath, RigidPush
from assessment.results.table import Row, Table, cells

Found = Iterator[tuple[Row, Part | None]]
Curves = Iterator[tuple[Sequence[Any], Sequence[Sequence[Any]]]]


TABLES: dict[str, Callable[[Results], Table]] = {}
"""Every table of the results, long ones included, by its name: that of its CSV file."""


def table(name: str, columns: str) -> Callable[[Callable[[Results], Found]], Callable[[Results], Table]]:
    """Enter a table of these columns: the function yields what each row has of its own, and the part of the rest."""
    named = tuple(columns.split())

    def entered(found: Callable[[Results], Found]) -> Callable[[Results], Table]:
        @wraps(found)
        def made(results: Results) -> Table:
            rows = [(cells(part, named) if part else {}) | own for own, part in found(results)]
            return Table(name, rows, named)

        TABLES[name] = made
        return made

    return entered


def curves(name: str, columns: str) -> Callable[[Callable[[Results], Curves]], Callable[[Results], Table]]:
    """Enter a table of curves: the function yields the place of each, for the first columns, and its coordinates."""
    named = tuple(columns.split())

    def entered(found: Callable[[Results], Curves]) -> Callable[[Results], Table]:
        @wraps(found)
        def made(results: Results) -> Table:
            points = (
                (*place, *point) for place, arrays in found(results) for point in zip(*arrays, strict=True)
            )
            return Table(name, [dict(zip(named, point, strict=True)) for point in points], named)

        TABLES[name] = made
        return made

    return entered


def whole(made: Callable[[Results], Table]) -> Callable[[Results], Table]:
    """Enter a table whose columns follow from its rows."""
    TABLES[made.__name__] = made
    return made


def without(table: Table, *columns: str) -> Table:
    """Return the table without some columns."""
    return Table(table.name, table.rows, tuple(name for name in table.columns if name not in columns))


def capacities(results: Results) -> Iterator[tuple[str, Direction, Capacity]]:
    """Yield state, direction and capacity wherever there is one."""
    for name, state in results.states.items():
        for direction, capacity in state.capacity.items():
            yield name, direction, capacity


def pushes(results: Results) -> Iterator[tuple[Row, RigidPush | ElasticPush]]:
    """Yield every push, behind its state, direction and contacts."""
    for name, state in results.states.items():
        for direction, pushed in state.pushover.items():
            for contacts, push in pushed.by_contacts.items():
                yield {"state": name, "direction": direction, "contacts": contacts}, push


def moves(results: Results) -> Iterator[tuple[Row, PushdownPath]]:
    """Yield every movement of a support, behind its state and contacts."""
    for name, state in results.states.items():
        for contacts, path in state.pushdown.items():
            yield {"state": name, "contacts": contacts}, path
