"""A project's content as a spreadsheet, read and written: one sheet per table.

Single tables are sheets of key | value | comment. Lists of tables, and layers by name, have a header of keys and a row
per entry. A list stands in one cell, "0.020; -0.020", a table within an entry as in the TOML file, { course_m = 0.3 }.
An empty cell is an absent key; a missing sheet, or one whose row ACTIVE says no, an absent table.
"""

import csv
import math
import re
import struct
import tomllib
import warnings
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from difflib import get_close_matches
from io import BytesIO
from pathlib import Path
from typing import Any, Literal, get_args, get_origin
from zipfile import BadZipFile, ZipFile

from assessment.project import schema
from assessment.project.toml import MARK, inline
from assessment.runtime.errors import ProjectError, nearest

MOST_BYTES = 20_000_000  # of a workbook's parts, unpacked; one with every key has a hundredth of it
MOST_ROWS, MOST_COLUMNS = 20_000, 200  # of a sheet
WIDEST_ROW = 2000  # empty cells included
_WORKBOOK, _SHEET = "xl/workbook.xml", re.compile(rb"<(?:\w+:)?sheet\s")
_SHEET_PART = re.compile(r"sheets/[^/]*\.xml$", re.IGNORECASE)
# What openpyxl, which checks nothing, and the modules below it raise on parts that are not as they should be.
_UNREADABLE = (
    BadZipFile, zlib.error, struct.error, OSError, EOFError, SyntaxError, NotImplementedError, RuntimeError,
    LookupError, ValueError, TypeError, AttributeError, ArithmeticError, AssertionError,
)  # fmt: skip

Rows = dict[int, tuple[Any, ...]]
_FORMS = schema.tables_of(schema.ProjectContent)


def _single(table: schema.KeyPath) -> Iterator[tuple[str, schema.KeyPath]]:
    """Yield the single tables below one, by the name of their sheet."""
    for name, form in schema.tables_of(schema.table_at(table) or schema.ProjectContent).items():
        if form == "single":
            yield name, (*table, name)
            yield from _single((*table, name))


_SINGLE: dict[str, schema.KeyPath] = {"project": (), **dict(_single(()))}
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

    Raises ProjectError if damaged or too large, OSError if there is no such file.
    """
    from openpyxl import load_workbook

    with path.open("rb") as file:
        packed = BytesIO(file.read(MOST_BYTES + 1))
    try:
        with ZipFile(packed) as archive, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of features of a spreadsheet that no project needs
            size = sum(entry.file_size for entry in archive.infolist())
            if size > MOST_BYTES:
                text = f"holds {size} bytes, at most {MOST_BYTES}; delete rows, sheets and pictures"
                raise ProjectError(f"{path.name}: file: {text} that are no part of the project")
            # openpyxl passes over a sheet whose part is missing, and its stage would be switched off
            sheets = [*filter(_SHEET_PART.search, archive.namelist())]
            declared = archive.read(_WORKBOOK) if _WORKBOOK in archive.namelist() else b""
            if archive.testzip() is not None or len(_SHEET.findall(declared)) > len(sheets):
                raise BadZipFile
            books = [load_workbook(packed, read_only=True, data_only=values) for values in (True, False)]
            found = [[(sheet.title, _rows(sheet, path)) for sheet in book.worksheets] for book in books]
    except ProjectError:
        raise
    except _UNREADABLE as error:
        text = "file: not an XLSX workbook, or a damaged one; save it as .xlsx"
        raise ProjectError(f"{path.name}: {text}") from error
    values, formulas = map(dict, found)
    if len(values) < len(found[0]):
        raise ProjectError(f"{path.name}: file: two sheets have one name; rename one of them")
    return values, formulas


def _rows(sheet: Any, path: Path) -> Rows:
    """Return the rows of a sheet that hold something, by number; blank texts are None. Raises ProjectError for many."""
    sheet.reset_dimensions()  # some programs store a wrong size
    rows: Rows = {}
    for number, row in enumerate(sheet.iter_rows(max_row=MOST_ROWS + 1, values_only=True), 1):
        values = tuple(None if isinstance(v, str) and not v.strip() else v for v in row)
        if any(value is not None for value in values):
            rows[number] = values[:MOST_COLUMNS]
        too_wide = len(values) > WIDEST_ROW or any(value is not None for value in values[MOST_COLUMNS:])
        if too_wide or number > MOST_ROWS:
            text = f"more than {MOST_ROWS} rows or {MOST_COLUMNS} columns; delete those beyond the last entry and key"
            raise ProjectError(f'{path.name}: sheet "{sheet.title}": {text}')
    return rows


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
        for name in sorted(rows.keys() - _SHEETS.keys())
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
        for entry, place, cells in _entries(name, rows[name]):
            values = [((*entry, key), value, place) for key, value, place in cells if value is not None]
            if not values and isinstance(_default_of(entry), schema.ProjectTable):
                continue
            given: Any = content
            for part in entry:
                given = given.setdefault(part, {})
            values += [(entry, "", place)] if entry in places else []  # the second layer of a name
            places[entry] = f'sheet "{name}"{place}'
            for at, value, where in values:
                wrong = ""
                if at[-1:] == ("",):
                    wrong = "has no key or name; write it in the first column or in the header"
                elif at in _SINGLE.values():
                    wrong = f'"{at[-1]}" has a sheet of its own; write it there'
                elif at == entry or at[-1] in given:
                    wrong = f'"{at[-1]}" appears twice; write it once'
                else:
                    given[at[-1]] = _typed(value, schema.annotation_at(at))
                places[at] = f'sheet "{name}"{where}'
                faults += [f"{path.name}: {places[at]}: {wrong}"] if wrong else []
        if _FORMS.get(name) == "list" and name in content:
            content[name] = [*content[name].values()]
    return content, places, faults


def _entries(name: str, rows: Rows) -> Iterator[tuple[schema.KeyPath, str, list[tuple[str, Any, str]]]]:
    """Yield the tables of a sheet: their path and place, and the keys, values and places of their cells."""
    if name in _SINGLE:
        cells = [(_text(row[0]).strip(), (*row, None)[1], f", cell B{line}") for line, row in rows.items()]
        headed = bool(cells) and cells[0][0].lower() in {heads[0] for heads in HEADS.values()}
        yield _SINGLE[name], "", [cell for cell in cells[headed:] if cell[0].lower() != ACTIVE]
        return
    header, *entries = [*rows.items()] or [(0, ())]
    keys = [_text(key).strip() for key in header[1]]
    first = 1 if name in _NAME else 0
    for index, (number, row) in enumerate(entries):
        cells = [
            (keys[column] if column < len(keys) else "", value, f", cell {_letter(column)}{number}")
            for column, value in enumerate(row[first:], first)
        ]
        yield (name, _text(row[0]) if first else index), f", row {number}", cells


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
            _offer(sheet, [(f"B{cell.row}", (*table, cell.value)) for cell in sheet["A"][1:]])
            continue
        keys, named = _columns(name), _NAME.get(name, "")
        tables = [{named: key, **each} for key, each in (node or {}).items()] if named else node or ()
        _fill(sheet, [keys, *([_cell(each.get(key)) for key in keys] for each in tables)])
        meanings = schema.keys_at((name, 0), language)
        for cell in sheet[1]:
            if meaning := meanings.get(cell.value):
                cell.comment = Comment(meaning, "Assesto", height=80, width=260)
        letters = {key: _letter(column) for column, key in enumerate(keys)}
        _offer(sheet, [(f"{at}2:{at}{LAST}", (name, 0, key)) for key, at in letters.items()])
    file = BytesIO()
    book.save(file)
    return file.getvalue()


def _columns(name: str) -> list[str]:
    return [*([_NAME[name]] if name in _NAME else []), *schema.keys_at((name, 0))]


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
        column = _letter(_columns(sheet).index("support" if sheet == "layers" else "name"))
        return f"={sheet}!${column}$2:${column}${LAST}"
    chosen = [*map(str, _words(kinds))]
    for kind in (kind for kind in kinds if get_origin(kind) is tuple):
        members = _words(schema.alternatives(get_args(kind)[0]))
        if all(isinstance(member, str) for member in members) and members:
            chosen += [*members, "; ".join(members)]
    return f'"{",".join(chosen)}"' if chosen else f'"{YES[0]},{NO[0]}"' if bool in kinds else ""


def _words(kinds: Iterable[Any]) -> list[Any]:
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
    from openpyxl.utils import get_column_letter

    return str(get_column_letter(column + 1))


def _typed(value: Any, annotation: Any) -> Any:
    """Return the content of a cell as the type its key asks for; left as it is where that cannot be."""
    value = value.strip() if isinstance(value, str) else value
    kinds = schema.alternatives(annotation)
    if isinstance(value, str) and value.startswith(("{", "[{")) and any(map(_is_table, kinds)):
        with suppress(tomllib.TOMLDecodeError):
            return tomllib.loads(f"x = {value}")["x"]
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


def _is_table(kind: Any) -> bool:
    """Whether a type is of tables, or of values by name, or of lists of them: a cell has these as the TOML file."""
    if get_origin(kind) is tuple:
        return any(map(_is_table, schema.alternatives(get_args(kind)[0])))
    return get_origin(kind) is dict or (isinstance(kind, type) and issubclass(kind, schema.ProjectTable))


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
    meanings = schema.keys_at(table, language)
    yield [*HEADS[language]]
    for key, value in {**(node or {}), **dict.fromkeys(meanings), **(node or {})}.items():
        if (*table, key) not in _SHEETS.values():
            mark = MARK[language] if (*table, key) in marked else ""
            yield [key, _cell(value), mark + meanings[key]]
    if table and _default_of(table) is None:
        yield [ACTIVE, YES[0] if node is not None else NO[0], IN_USE[language]]


def _default_of(table: schema.KeyPath) -> Any:
    """Return what an absent table is: None, or one of defaults; anything else where it is required, or of a list."""
    above = schema.table_at(table[:-1]) or schema.ProjectContent
    return above.model_fields[str(table[-1])].default if table and table[-1] in above.model_fields else ()


def _cell(value: Any) -> Any:
    """Return a value as one cell: lists joined by semicolons, texts in quotes where they need them; tables as TOML."""
    listed = value if isinstance(value, list) else [value]
    if any(isinstance(each, Mapping) for each in listed):
        return inline(value)
    if isinstance(value, list | tuple):
        if any(isinstance(each, list | tuple) for each in value):  # pairs
            value = [number for pair in value for number in pair]
        texts = map(str, value)
        return "; ".join('"' + x.replace('"', '""') + '"' if set(x) & set(';"') else x for x in texts)
    if isinstance(value, bool):
        return YES[0] if value else NO[0]
    if isinstance(value, float) and (math.isinf(value) or float(f"{value:.16g}") != value):
        return repr(value)  # openpyxl stores 16 digits and no infinity
    return value
