"""A project's content as a spreadsheet, read and written: one sheet per table.

Single tables are sheets of key | value | comment, a table within one with a point (`control.+x`, `SLV.ag_g`). Lists of
tables, and layers by name, have a header of keys and a row per entry, with columns such as `layers.NAME.friction`; the
entries of a list within a single table have rows of their own, `hypotheses.1.NAME`. A list stands in one cell, "0.020;
-0.020". An empty cell is an absent key; a missing sheet, or one whose row ACTIVE says no, an absent table.
"""

import csv
import math
import re
import struct
import warnings
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from difflib import get_close_matches
from io import BytesIO
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args, get_origin
from zipfile import BadZipFile, ZipFile

from pydantic_core import PydanticUndefined

from assessment.project import schema
from assessment.project.toml import MARK
from assessment.runtime.errors import ProjectError, nearest

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
_FORMS = schema.tables_of(schema.ProjectContent)
_SINGLE: dict[str, schema.KeyPath] = {
    "project": (),
    **{name: (name,) for name, form in _FORMS.items() if form == "single"},
    "site": ("assessment", "site"),
}
_SHEETS = _SINGLE | {name: (name,) for name, form in _FORMS.items() if form != "single"}
_NAME = {name: "layer" if name == "layers" else "name" for name, form in _FORMS.items() if form == "named"}
WIDEST = 90  # letters of a column
ACTIVE = "active"  # the row of a sheet that says whether its table is in the project
YES, NO = ("sì", "si", "yes", "true", "vero"), ("no", "false", "falso")  # the first ones are written
HEADS = {"en": ("key", "value", "comment"), "it": ("chiave", "valore", "nota")}
IN_USE = {"en": "sì: the table is in the project; no: it is left out"}
IN_USE["it"] = "sì: la tabella vale; no: è tralasciata"
# sheets with names to choose from
_OF = {"support": "layers", "control point": "control", "settlement": "settlements"}
LAST = 200  # row of a list down to which cells have a drop-down list


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
            found = [[(sheet.title, _rows(sheet, path)) for sheet in book.worksheets] for book in books]
        except ProjectError:
            raise
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
    fault = _NO_WORKBOOK
    try:
        with ZipFile(packed) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
            if size > MOST_BYTES:
                text = f"holds {size} bytes, at most {MOST_BYTES}; delete rows, sheets and pictures"
                fault = f"file: {text} that are no part of the project"
            elif archive.testzip() is None:
                # openpyxl passes over a sheet whose part is missing, and its stage would be switched off; of one that
                # is there it reads on to the end, whatever it is asked for
                sheets = [*filter(_SHEET_PART.search, archive.namelist())]
                declared = archive.read(_WORKBOOK) if _WORKBOOK in archive.namelist() else b""
                whole = len(_SHEET.findall(declared)) <= len(sheets)
                longest = max((len(_ROW.findall(archive.read(part))) for part in sheets), default=0)
                if longest > MOST_ROWS:
                    text = f"a sheet of {longest} rows, at most {MOST_ROWS}, empty ones included"
                    fault = f"file: {text}; delete those below the last entry"
                elif whole:
                    fault = ""
    except _UNREADABLE:
        fault = _NO_WORKBOOK
    if fault:
        raise ProjectError(f"{path.name}: {fault}")
    return packed


def _rows(sheet: Any, path: Path) -> Rows:
    """Return the rows of a sheet that hold something, by number; blank texts are None. Raises ProjectError for many."""
    sheet.reset_dimensions()  # some programs store a wrong size
    rows: Rows = {}
    for number, row in enumerate(sheet.iter_rows(max_row=MOST_ROWS + 1, values_only=True), 1):
        values = tuple(None if isinstance(v, str) and not v.strip() else v for v in row)
        if number > MOST_ROWS:
            text = f"a row beyond the {MOST_ROWS}th; delete those below the last entry"
            raise ProjectError(f'{path.name}: sheet "{sheet.title}": {text}')
        if len(values) > WIDEST_ROW or any(value is not None for value in values[MOST_COLUMNS:]):
            text = f"more than {MOST_COLUMNS} columns; delete those right of the last key"
            raise ProjectError(f'{path.name}: sheet "{sheet.title}", row {number}: {text}')
        if any(value is not None for value in values):
            rows[number] = values[:MOST_COLUMNS]
    return rows


class _Entry(NamedTuple):
    """A value, or the empty table that values go into, and the cell or row it was read from."""

    path: schema.KeyPath
    value: Any
    place: str


def read_xlsx(path: Path) -> tuple[dict[str, Any], dict[schema.KeyPath, str], list[str]]:
    """Return the unchecked content of a spreadsheet, where each value stands, and what is wrong.

    Raises ProjectError.
    """
    rows, formulas = read_sheets(path)
    faults = [
        f'{path.name}: sheet "{name}", cell {place}: a formula whose value is not stored; '
        "open the file in a spreadsheet program and save it, or write the value"
        for name, sheet in formulas.items()
        if (place := _unevaluated(sheet, rows[name]))
    ]
    faults += [
        f'{path.name}: sheet "{name}": unknown sheet; {nearest(name, _SHEETS)}'
        for name in sorted(rows.keys() - _SHEETS.keys() - {"help"})  # which earlier versions wrote
        if rows[name] or get_close_matches(name, _SHEETS, cutoff=0.8)
    ]
    content: dict[str, Any] = {}
    places: dict[schema.KeyPath, str] = {}
    active = {name: _is_active(rows[name]) for name in _SINGLE if name in rows}
    faults += [
        f'{path.name}: sheet "{name}", row "{ACTIVE}": {word!r} is neither {YES[0]} nor {NO[0]}; write one of them'
        for name, word in active.items()
        if isinstance(word, str)
    ]
    off = [_SINGLE[name] for name, word in active.items() if word is False]
    for name, table in _SHEETS.items():
        if name not in rows or any(table[: len(path)] == path for path in off):
            continue
        entries = _table_entries(name, rows[name]) if name in _SINGLE else _list_entries(name, rows[name])
        for entry in entries:
            places[entry.path] = f'sheet "{name}"{entry.place}'
            if fault := _put(content, entry):
                faults.append(f"{path.name}: {places[entry.path]}: {fault}")
    return _with_lists(content), places, faults


def _with_lists(node: Any) -> Any:
    """Return a content with the tables of indices that `_put` makes as lists."""
    if not isinstance(node, dict):
        return node
    values = {key: _with_lists(value) for key, value in node.items()}
    return list(values.values()) if values and all(isinstance(key, int) for key in values) else values


def _is_active(rows: Rows) -> bool | str:
    """Whether a sheet of a single table is in use: the row ACTIVE does not say no. What is neither is returned."""
    said = (row[1] for row in rows.values() if len(row) > 1 and str(row[0]).strip().lower() == ACTIVE)
    words: list[bool | str] = [_number(_text(each), (bool,)) for each in said if each is not None]
    return min(words, key=lambda word: (word is not False, word is True), default=True)


def to_xlsx(content: Mapping[str, Any], marked: Collection[schema.KeyPath] = ()) -> bytes:
    """Return a project's content as a spreadsheet that explains its keys, those `marked` as to be filled in.

    Keys that the content leaves out have an empty cell, tables that it leaves out the row ACTIVE with no.
    """
    from openpyxl import Workbook
    from openpyxl.comments import Comment

    language = content.get("report", {}).get("language", "it")
    book = Workbook()
    book.remove(book.active)
    for name, table in _SHEETS.items():
        node: Any = content
        for part in table:
            node = node.get(part) if node else None
        sheet = book.create_sheet(name)
        if name in _SINGLE:
            _fill(sheet, _table_rows(table, node, marked, language))
            _offer(sheet, [(f"B{cell.row}", _path(table, cell.value)) for cell in sheet["A"][1:]])
            continue
        _fill(sheet, _list_rows(name, node or {}))
        headings = [(cell, _path((name, 0), _text(cell.value))) for cell in sheet[1]]
        for cell, path in headings:
            if meaning := schema.keys_at(path[:-1], language).get(str(path[-1])):
                cell.comment = Comment(meaning, "Assesto", height=80, width=260)
        columns = ((cell.column_letter, path) for cell, path in headings)
        _offer(sheet, [(f"{column}2:{column}{LAST}", path) for column, path in columns])
    file = BytesIO()
    book.save(file)
    return file.getvalue()


def _fill(sheet: Any, rows: Iterable[list[Any]]) -> None:
    from openpyxl.styles import Font

    for number, row in enumerate(rows, 1):
        for column, value in enumerate(row, 1):
            cell = sheet.cell(number, column, value)
            if isinstance(value, str):
                cell.data_type = "s"  # a text that begins with = is no formula
            if number == 1:
                cell.font = Font(bold=True)
    for column, cells in enumerate(sheet.columns):
        longest = max(len(str(cell.value or "")) for cell in cells)
        sheet.column_dimensions[_letter(column)].width = min(longest, WIDEST) + 2
    sheet.freeze_panes = "A2"


def _offer(sheet: Any, cells: Iterable[tuple[str, schema.KeyPath]]) -> None:
    """Give the cells of keys a drop-down list of what can be chosen; other values can be typed all the same."""
    from openpyxl.worksheet.datavalidation import DataValidation

    for place, path in cells:
        if formula := _choices(path):
            offered = DataValidation(type="list", formula1=formula, allow_blank=True, showErrorMessage=False)
            sheet.add_data_validation(offered)
            offered.add(place)


def _choices(path: schema.KeyPath) -> str:
    """Return the formula of a drop-down list of the key at a path; empty where nothing is to be chosen."""
    if path[-1] == ACTIVE:
        return f'"{YES[0]},{NO[0]}"'
    kinds = schema.alternatives(schema.annotation_at(path))
    sheet = _OF.get(schema.named_at(path) or "")
    if sheet and str in kinds:
        column = _letter(next(_list_rows(sheet, {})).index("support" if sheet == "layers" else "name"))
        return f"={sheet}!${column}$2:${column}${LAST}"
    chosen = [*map(str, _words(kinds))]
    for kind in (kind for kind in kinds if get_origin(kind) is tuple):
        members = _words(schema.alternatives(get_args(kind)[0]))
        if all(isinstance(member, str) for member in members) and members:
            chosen += [*members, "; ".join(members)]
    return f'"{",".join(chosen)}"' if chosen else f'"{YES[0]},{NO[0]}"' if bool in kinds else ""


def _words(kinds: Iterable[Any]) -> list[Any]:
    """Return what the literal ones of some types allow."""
    return [member for kind in kinds if get_origin(kind) is Literal for member in get_args(kind)]


def _unevaluated(formulas: Rows, values: Rows) -> str | None:
    """Return the first cell that has a formula and no value, which would else pass for an empty one."""
    for number, row in formulas.items():
        known = values.get(number, ())
        for column, text in enumerate(row):
            if isinstance(text, str) and text.startswith("=") and known[column : column + 1] in {(), (None,)}:
                return f"{_letter(column)}{number}"
    return None


def _letter(column: int) -> str:
    """Return the letters of a column, counted from 0."""
    from openpyxl.utils import get_column_letter

    return str(get_column_letter(column + 1))


def _table_entries(name: str, rows: Rows) -> Iterator[_Entry]:
    table = _SINGLE[name]
    if table and (_default_at(table) is None or _default_at(table) is PydanticUndefined):
        yield _Entry(table, {}, "")
    for index, (number, row) in enumerate(rows.items()):
        key, value = (*row, None)[:2]
        word = str(key).strip().lower()
        if value is None or word == ACTIVE or (index == 0 and word in {heads[0] for heads in HEADS.values()}):
            continue
        path = _path(table, _text(key).strip())
        yield _Entry(path, _typed(value, schema.annotation_at(path)), f", cell B{number}")


def _path(table: schema.KeyPath, key: str) -> schema.KeyPath:
    """Return the path of a key with points below a table: `control.+x`, `SLV.ag_g`, `layers.NAME.friction`.

    NAME, and that of an entry `hypotheses.1.NAME`, may have points itself.
    """
    first, _, rest = key.partition(".")
    path: schema.KeyPath = (*table, first)
    number, _, listed = rest.partition(".")
    if _listed(path) and number.isdigit():
        return (*path, int(number) - 1, listed)
    form = schema.tables_of(schema.table_at(table) or schema.ProjectContent).get(first)
    if form == "named":
        name, _, inner = rest.rpartition(".")
        return (*path, name, inner) if name else (*table, key)
    if form == "single" and rest:
        return _path(path, rest)
    return (*path, *rest.split(".")) if rest else path


def _listed(path: schema.KeyPath) -> bool:
    """Whether the value at a path is a list of entries by name, which are no tables."""
    kinds = schema.alternatives(schema.annotation_at(path))
    members = [get_args(kind)[0] for kind in kinds if get_origin(kind) is tuple]
    return any(get_origin(kind) is dict for member in members for kind in schema.alternatives(member))


def _list_entries(name: str, rows: Rows) -> Iterator[_Entry]:
    header, *entries = [*rows.items()] or [(0, ())]
    keys = [_text(key).strip() for key in header[1]]
    first = 1 if name in _NAME else 0
    for index, (number, row) in enumerate(entries):
        entry: schema.KeyPath = (name, _text(row[0]) if first else index)
        yield _Entry(entry, {}, f", row {number}")
        for column, value in enumerate(row[first:], first):
            if value is not None:
                path = _path(entry, keys[column] if column < len(keys) else "")
                place = f", cell {_letter(column)}{number}"
                yield _Entry(path, _typed(value, schema.annotation_at(path)), place)


def _put(content: dict[str, Any], entry: _Entry) -> str:
    """Put an entry into the content, lists as tables of their indices; return what is wrong, if anything."""
    node: Any = content
    for part in entry.path[:-1]:
        node = node.setdefault(part, {})
        if not isinstance(node, dict):
            return "is a value and a table at once; write one of them"
    key = entry.path[-1]
    if key == "":
        return "has no key or name; write it in the first column or in the header"
    if key in node:
        return f'"{key}" appears twice; write it once'
    node[key] = entry.value
    return ""


def _typed(value: Any, annotation: Any) -> Any:
    """Return the content of a cell as the type its key asks for; left as it is where that cannot be."""
    value = value.strip() if isinstance(value, str) else value
    kinds = schema.alternatives(annotation)
    members = _words(kinds)
    lists = [kind for kind in kinds if get_origin(kind) is tuple]
    words = any(isinstance(member, str) for member in members)
    takes_text = str in kinds or (words and value in members) or (words and float not in kinds)
    if lists and value not in members:
        member = get_args(lists[0])[0]
        if pairs := [kind for kind in schema.alternatives(member) if get_origin(kind) is tuple]:
            flat = _typed(value, tuple[get_args(pairs[0])[0], ...])  # type: ignore[misc]
            return [flat[k : k + 2] for k in range(0, len(flat), 2)]
        if {int, float} & {*schema.alternatives(member)}:  # only a separator is followed by a blank there
            parts = re.split(r";|,?\s", _text(value).strip().removeprefix("[").removesuffix("]"))
        else:
            one_line = _text(value).replace("\r", ";").replace("\n", ";")
            try:
                parts = next(csv.reader([one_line], delimiter=";", skipinitialspace=True))
            except csv.Error:  # more text than a cell can hold
                return value
        return [_typed(part.strip(), member) for part in parts if part.strip()]
    if isinstance(value, str):
        return value if takes_text else _number(value, kinds)
    if isinstance(value, int | float) and not isinstance(value, bool):
        whole = isinstance(value, float) and value.is_integer() and float not in kinds
        return _text(value) if takes_text else int(value) if whole else value
    return value


def _number(text: str, kinds: tuple[Any, ...]) -> Any:
    if bool in kinds:
        word = text.strip().lower()
        return True if word in YES else False if word in NO else text
    try:
        number = float(text.replace(",", "."))
    except ValueError:
        return text
    return int(number) if number.is_integer() and float not in kinds else number


def _text(value: Any) -> str:
    """Return a cell as text: the layer 0 is called "0", whether typed as text or number."""
    if value is None:
        return ""
    return str(int(value)) if isinstance(value, float) and value.is_integer() else str(value)


def _table_rows(
    table: schema.KeyPath, node: Mapping[str, Any] | None, marked: Collection[schema.KeyPath], language: str
) -> Iterator[list[Any]]:
    comments = schema.keys_at(table, language)
    yield [*HEADS[language]]
    own = {**(node or {}), **dict.fromkeys(comments, None), **(node or {})}
    here = [key for key in own if (*table, key) not in _SHEETS.values() and (table or key not in _FORMS)]
    absent = [key for key in here if own[key] is None and schema.table_at((*table, key))]
    rows = _flat(table, {key: own[key] for key in here if key not in absent})
    rows |= {f"{key}.{inner}": None for key in absent for inner in schema.keys_at((*table, key))}
    for key, value in rows.items():
        first, _, rest = key.partition(".")
        meaning = schema.keys_at((*table, first), language).get(rest, comments[first])
        yield [key, _cell(value), (MARK[language] if (*table, key) in marked else "") + meaning]
    if table and _default_at(table) is None:
        yield [ACTIVE, YES[0] if node is not None else NO[0], IN_USE[language]]


def _default_at(table: schema.KeyPath) -> Any:
    """Return the default of a table: None, it may be absent; PydanticUndefined, it must not."""
    above = schema.table_at(table[:-1]) or schema.ProjectContent
    return above.model_fields[str(table[-1])].default


def _list_rows(name: str, node: Any) -> Iterator[list[Any]]:
    entries = [{_NAME[name]: key, **table} for key, table in node.items()] if name in _NAME else node
    tables = schema.tables_of(schema.table_at((name, 0)) or schema.ProjectContent)
    rows = [_flat((name, 0), entry) for entry in entries]
    keys = dict.fromkeys([_NAME[name]] if name in _NAME else [])
    keys |= dict.fromkeys(key for key in schema.keys_at((name, 0)) if key not in tables)
    for key, form in tables.items():
        keys |= dict.fromkeys(f"{key}.{k}" for k in schema.keys_at((name, 0, key)) if form == "single")
    keys |= dict.fromkeys(key for row in rows for key in row if key.partition(".")[0] in tables)
    yield [*keys]
    yield from ([_cell(row.get(key)) for key in keys] for row in rows)


def _flat(table: schema.KeyPath, node: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a table by their keys, those of tables and named entries in it as `_path` reads them."""
    row: dict[str, Any] = {}
    for key, value in node.items():
        if _listed((*table, key)) and isinstance(value, list):
            row |= {f"{key}.{n}.{k}": each for n, entry in enumerate(value, 1) for k, each in entry.items()}
        elif isinstance(value, Mapping):
            row |= {f"{key}.{k}": each for k, each in _flat((*table, key), value).items()}
        else:
            row[key] = value
    return row


def _cell(value: Any) -> Any:
    """Return a value as one cell: lists joined by semicolons, with quotes where a text needs them."""
    if isinstance(value, list | tuple):
        if any(isinstance(each, list | tuple) for each in value):  # pairs
            value = [number for pair in value for number in pair]
        quoted = (
            '"' + text.replace('"', '""') + '"' if set(text) & set(';"') else text for text in map(str, value)
        )
        return "; ".join(quoted)
    if isinstance(value, bool):
        return YES[0] if value else NO[0]
    if isinstance(value, float) and (math.isinf(value) or float(f"{value:.16g}") != value):
        return repr(value)  # openpyxl stores 16 digits and no infinity
    return value
