"""A workbook as rows of values: its archive is checked, and bounded, before anything is made of it."""

from __future__ import annotations

import re
import struct
import warnings
import zlib
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

from assessment.runtime.errors import ProjectError

MOST_BYTES = 20_000_000  # of a workbook's parts, unpacked; one with every key has a hundredth of it
MOST_ROWS, MOST_COLUMNS = 20_000, 200  # of a sheet
WIDEST_ROW = 2000  # empty cells included
_WORKBOOK, _SHEET = "xl/workbook.xml", re.compile(rb"<(?:\w+:)?sheet\s")
_ROW = re.compile(rb"<(?:\w+:)?row[\s/>]")
_SHEET_PART = re.compile(r"sheets/[^/]*\.xml$", re.IGNORECASE)
_NO_WORKBOOK = "file: not an XLSX workbook, or a damaged one; save it as .xlsx"
# What openpyxl, which checks nothing, and the modules below it raise on parts that are not as they should be.
_UNREADABLE = (
    BadZipFile, zlib.error, struct.error, OSError, EOFError, SyntaxError, NotImplementedError, RuntimeError,
    LookupError, ValueError, TypeError, AttributeError, ArithmeticError, AssertionError,
)  # fmt: skip

Rows = dict[int, tuple[Any, ...]]


class _Oversized(Exception):  # noqa: N818 - not an error of the file's form
    """A sheet that is larger than any project's."""


def read_sheets(path: Path) -> tuple[dict[str, Rows], dict[str, Rows]]:
    """Return the rows of every sheet with values of formulas, and with formulas.

    Raises ProjectError if damaged or too large.
    """
    from openpyxl import load_workbook

    archive = _archive(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of features of a spreadsheet that no project needs
        try:
            books = [load_workbook(archive, read_only=True, data_only=values) for values in (True, False)]
            found = [[(sheet.title, _rows(sheet)) for sheet in book.worksheets] for book in books]
        except _Oversized as error:
            raise ProjectError(f"{path.name}: {error}") from None
        except _UNREADABLE as error:
            raise ProjectError(f"{path.name}: {_NO_WORKBOOK}") from error
    for book in books:
        book.close()
    values, formulas = map(dict, found)
    if len(values) < len(found[0]):
        raise ProjectError(f"{path.name}: file: two sheets have one name; rename one of them")
    return values, formulas


def _archive(path: Path) -> BytesIO:
    """Return the bytes of a workbook. Raises ProjectError if damaged or too large, OSError if there are none."""
    with path.open("rb") as file:
        packed = BytesIO(file.read(MOST_BYTES + 1))
    try:
        with ZipFile(packed) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
            damaged = archive.testzip() if size <= MOST_BYTES else None
            whole = damaged is None and size <= MOST_BYTES
            # openpyxl passes over a sheet whose part is missing, and its stage would be switched off; of one that is
            # there it reads on to the end, whatever it is asked for
            sheets = [*filter(_SHEET_PART.search, archive.namelist())] if whole else []
            declared = (
                _SHEET.findall(archive.read(_WORKBOOK)) if whole and _WORKBOOK in archive.namelist() else []
            )
            missing = len(declared) > len(sheets)
            longest = max((len(_ROW.findall(archive.read(part))) for part in sheets), default=0)
    except _UNREADABLE:
        raise ProjectError(f"{path.name}: {_NO_WORKBOOK}") from None
    if size > MOST_BYTES:
        raise ProjectError(
            f"{path.name}: file: holds {size} bytes, at most {MOST_BYTES}; delete rows, sheets and pictures that "
            "are no part of the project"
        )
    if longest > MOST_ROWS:
        text = f"a sheet of {longest} rows, at most {MOST_ROWS}, empty ones included"
        raise ProjectError(f"{path.name}: file: {text}; delete those below the last entry")
    if damaged is not None or missing:
        raise ProjectError(f"{path.name}: {_NO_WORKBOOK}")
    return packed


def _rows(sheet: Any) -> Rows:
    """Return the rows of a sheet that hold something, by number; blank texts are None."""
    sheet.reset_dimensions()  # some programs store a wrong size
    rows: Rows = {}
    for number, row in enumerate(sheet.iter_rows(max_row=MOST_ROWS + 1, values_only=True), 1):
        values = tuple(None if isinstance(v, str) and not v.strip() else v for v in row)
        if number > MOST_ROWS:
            text = f"a row beyond the {MOST_ROWS}th; delete those below the last entry"
            raise _Oversized(f'sheet "{sheet.title}": {text}')
        if len(values) > WIDEST_ROW or any(value is not None for value in values[MOST_COLUMNS:]):
            text = f"more than {MOST_COLUMNS} columns; delete those right of the last key"
            raise _Oversized(f'sheet "{sheet.title}", row {number}: {text}')
        if any(value is not None for value in values):
            rows[number] = values[:MOST_COLUMNS]
    return rows
