"""The tables, each under its name with its columns; a row is what it has of its own, and the part of the rest."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, is_dataclass
from functools import wraps
from typing import Any

from assessment.results.schema import Capacity, Direction, ElasticPush, Part, PushdownPath, Results, RigidPush
from assessment.results.table import Row, Table, cells, columns_of

Found = Iterable[Any]
"""Rows: as dictionaries, dataclasses or parts of the results, or what a row has of its own and the part of the rest."""
Curves = Iterator[tuple[Sequence[Any], Sequence[Sequence[Any]]]]
Made = Callable[[Results], Table]

TABLES: dict[str, Made] = {}
"""Every table of the results, long ones included, by its name: that of its CSV file."""


def table(name: str, columns: str | type) -> Callable[[Callable[[Results], Found]], Made]:
    """Enter a table of these columns, or of those of a class; one with ? is left out where no row has it."""
    told = columns.split() if isinstance(columns, str) else columns_of(columns)
    named = [column.lstrip("?") for column in told]

    def entered(found: Callable[[Results], Found]) -> Made:
        @wraps(found)
        def made(results: Results) -> Table:
            rows = [_row(each, named) for each in found(results)]
            there = {key for row in rows for key in row}
            kept = [key for key, column in zip(named, told, strict=True) if key == column or key in there]
            return Table(name, rows, tuple(kept))

        return TABLES.setdefault(name, made)

    return entered


def _row(each: Any, columns: Iterable[str]) -> Row:
    own, part = each if isinstance(each, tuple) else (each, None)
    if isinstance(own, Part):
        return cells(own, columns)
    row: Row = asdict(own) if is_dataclass(own) and not isinstance(own, type) else own
    return (cells(part, columns) if part else {}) | row


def curves(name: str, columns: str) -> Callable[[Callable[[Results], Curves]], Made]:
    """Enter a table of curves: the function yields the place of each, for the first columns, and its coordinates."""

    def entered(found: Callable[[Results], Curves]) -> Made:
        @wraps(found)
        def rows(results: Results) -> Iterator[Row]:
            for place, arrays in found(results):
                for point in zip(*arrays, strict=True):
                    yield dict(zip(columns.split(), (*place, *point), strict=True))

        return table(name, columns)(rows)

    return entered


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
