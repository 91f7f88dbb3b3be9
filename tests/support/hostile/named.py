"""Hostile inputs by name: each makes its files in an empty folder, tries them and returns the verdict."""

import io
import math
import re
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

from assessment.project.xlsx import to_xlsx
from assessment.report.chapters.judgement import to_html
from mechanics.records.record import read_record
from tests.support.block_project import ASSESSMENT, HAZARD, PROJECT, write_block
from tests.support.hostile.corpus import SHEETS, WALL
from tests.support.hostile.dxf_text import WALL as BLOCKS
from tests.support.hostile.dxf_text import block as definition
from tests.support.hostile.dxf_text import drawing, insert, polyline, rectangle
from tests.support.hostile.judge import COMPLETED, commanded, judged

Case = Callable[[Path], str]
RECORD = '[[history]]\nrecord = "wave.csv"\ncontacts = "rigid"\n'
DISK = '[incremental]\nrecords = ["/**/*"]\ncontacts = "rigid"\n'
GRID = 'latitude = 42.02\nlongitude = 13.02\ngrid = "grid.txt"\n'
BY_GRID = PROJECT + ASSESSMENT.replace(HAZARD, GRID)
ARRAY = [(70, 32000), (71, 32000), (44, 2), (45, 2)]
TRIANGLE = polyline([(0, 0), (1, 0), (1, 1)])
STONE = definition("B", TRIANGLE)
ABOVE = [(0, 2), (1, 2), (1, 3), (0, 3)]
PEER = "ACCELERATION TIME SERIES IN UNITS OF G\n"
ESCAPE = "\x1b[31m\x9b2J"


def _checked(text: str, **files: str | bytes) -> Case:
    """Check the block with another project file, and other files beside it."""

    def case(folder: Path) -> str:
        write_block(folder, text)
        for name, content in files.items():
            raw = content if isinstance(content, bytes) else content.encode("utf-8", "surrogateescape")
            (folder / name.replace("__", ".")).write_bytes(raw)
        return commanded("check", folder)

    return case


def _drawn(entities: str, blocks: str = "", text: str = WALL) -> Case:
    """Check a drawing."""
    return _checked(text, geometry__dxf=drawing(entities, blocks))


def _workbook(content: Callable[[], bytes]) -> Case:
    """Check a workbook, made where it is tried: some are large."""

    def case(folder: Path) -> str:
        write_block(folder)
        (folder / "project.toml").unlink()
        (folder / "project.xlsx").write_bytes(content())
        return commanded("check", folder)

    return case


def _sheets(rows: bytes) -> bytes:
    """A workbook whose second sheet has other rows."""
    space = b"http://schemas.openxmlformats.org/spreadsheetml/2006/main"
    sheet = b'<worksheet xmlns="' + space + b'"><sheetData>' + rows + b"</sheetData></worksheet>"
    file = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(to_xlsx(SHEETS))) as good,
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as bad,
    ):
        for name in good.namelist():
            bad.writestr(name, sheet if name.endswith("sheet2.xml") else good.read(name))
    return file.getvalue()


def _archive(offset: int, value: int) -> bytes:
    """A workbook in whose directory one number is another: 10 is the method of compression, 8 the flags."""
    raw = bytearray(to_xlsx(SHEETS))
    for entry in re.finditer(rb"PK\x01\x02", bytes(raw)):
        struct.pack_into("<H", raw, entry.start() + offset, value)
    for entry in re.finditer(rb"PK\x03\x04", bytes(raw)):
        struct.pack_into("<H", raw, entry.start() + offset - 2, value)
    return bytes(raw)


def _flipped() -> bytes:
    """A workbook with a byte of its compressed parts overwritten: zlib.error."""
    raw = bytearray(to_xlsx(SHEETS))
    for entry in re.finditer(rb"PK\x03\x04", bytes(raw)):
        name, extra = struct.unpack_from("<HH", raw, entry.start() + 26)
        raw[entry.start() + 30 + name + extra] ^= 0xFF
    return bytes(raw)


def _results(content: str) -> Case:
    def case(folder: Path) -> str:
        write_block(folder)
        (folder / "output").mkdir()
        (folder / "output" / "results.json").write_text(content, encoding="utf-8")
        return commanded("report", folder)

    return case


def _record(text: str) -> Case:
    def case(folder: Path) -> str:
        (folder / "motion.txt").write_text(text, encoding="utf-8")
        return judged(lambda: read_record(folder / "motion.txt"))

    return case


def _grid(change: Callable[[list[float]], list[float]]) -> Case:
    """Check a project whose grid has other values at its nodes: nine times a_g in g/10, F0, T_C*."""
    good = [number for k in range(9) for number in (0.5 + k, 2.4, 0.3)]
    nodes = [(13.0 + 0.06 * i, 42.0 + 0.05 * j) for i in range(3) for j in range(3)]
    lines = [
        "\t".join(map(repr, (x, y, *(change(list(good)) if n == 4 else good))))
        for n, (x, y) in enumerate(nodes)
    ]
    return _checked(BY_GRID, grid__txt="\n".join(lines))


def _at(index: int, value: float) -> Callable[[list[float]], list[float]]:
    return lambda numbers: [*numbers[:index], value, *numbers[index + 1 :]]


def _markdown(folder: Path) -> str:
    for text in ("<!--" * 25_000, "*" * 25_001, "**" * 12_501, "- a\n" + "  b\n" * 7_500):
        assert len(to_html(text)) < 10 * len(text)
    return COMPLETED


def _folder_name(folder: Path) -> str:
    write_block(folder / f"a{ESCAPE}")
    return commanded("check", folder / f"a{ESCAPE}")


def _record_name(folder: Path) -> str:
    text = PROJECT + '[incremental]\nrecords = ["*.csv"]\ncontacts = "rigid"\n'
    write_block(folder, text)
    (folder / f"{ESCAPE}\udcff\n.csv").write_text("no record", encoding="utf-8")
    return commanded("check", folder)


def _half_circle(count: int) -> list[tuple[float, float]]:
    angles = (math.pi * k / (count - 1) for k in range(count))
    return [(round(3 * math.cos(angle), 12), round(3 * math.sin(angle), 12)) for angle in angles]


COMPLETE: dict[str, Case] = {
    "an extrusion of no direction": _drawn(BLOCKS + polyline(ABOVE, extra="210\n0\n220\n0\n230\n0\n")),
    "a bulge of 1e-300": _drawn(BLOCKS + polyline([(0, 2, 0), (0, 3, 0), (1, 3, "1e-300"), (1, 2, 0)])),
    "a polyline of 5 000 vertices": _drawn(rectangle(-4, -1, 4, 0, "BASE") + polyline(_half_circle(5_000))),
    "control characters in the name of a layer": _drawn(BLOCKS + polyline(ABOVE, f"A{ESCAPE}\x07")),
    "a name of a layer that is no UTF-8": _drawn(BLOCKS + polyline(ABOVE, "A\udcff")),
    "formulas in the name of a layer": _drawn(BLOCKS + polyline(ABOVE, "_$x^{$ \\frac")),
    "comments without end in a judgement": _markdown,
}  # fmt: skip
REFUSALS: dict[str, Case] = {
    "workbook, compressed part damaged (zlib.error)": _workbook(_flipped),
    "workbook, unknown compression (NotImplementedError)": _workbook(lambda: _archive(10, 99)),
    "workbook, encrypted (RuntimeError)": _workbook(lambda: _archive(8, 1)),
    "workbook, a number that is none (TypeError)": _workbook(lambda: _sheets(b"<row><c r='A1'><v>x</v></c></row>")),
    "workbook of 300 000 rows": _workbook(lambda: _sheets(b"<row/>" * 300_000)),
    "workbook with a row 4 000 000 000": _workbook(
        lambda: _sheets(b'<row r="4000000000"><c r="A4"><v>1</v></c></row>')
    ),
    "workbook with 18 000 columns": _workbook(lambda: _sheets(b'<row r="1"><c r="ZZZ1"><v>1</v></c></row>')),
    "workbook of 100 MB": _workbook(lambda: _sheets(b" " * 100_000_000)),
    "coordinates of 1e160": _drawn(BLOCKS + polyline([(0, 0), ("1e160", 0), ("1e160", "1e160")])),
    "coordinates of 1e308": _drawn(BLOCKS + polyline([("-1e308", 0), ("1e308", 0), (0, "1e308")])),
    "coordinates of 1e-300": _drawn(BLOCKS + polyline([(0, 0), ("1e-300", 0), (0, "1e-300")])),
    "an INSERT at 1e400": _drawn(BLOCKS + insert("B", ("1e400", 0)), STONE),
    "an INSERT array of 10^9": _drawn(BLOCKS + insert("B", tags=ARRAY), STONE),
    "an INSERT array of nothing": _drawn(BLOCKS + insert("B", tags=ARRAY), definition("B", "")),
    "INSERTs that double 25 times": _drawn(
        BLOCKS + insert("B25"),
        definition("B0", TRIANGLE)
        + "".join(definition(f"B{k}", insert(f"B{k - 1}") + insert(f"B{k - 1}", (1, 0))) for k in range(1, 26)),
    ),
    "INSERTs 60 deep": _drawn(
        BLOCKS + insert("B60"),
        definition("B0", TRIANGLE)
        + "".join(definition(f"B{k}", insert(f"B{k - 1}")) for k in range(1, 61)),
    ),
    "a polyline of 20 001 vertices": _drawn(rectangle(-4, -1, 4, 0, "BASE") + polyline(_half_circle(20_001))),
    "a bulge of 1e300": _drawn(BLOCKS + polyline([(0, 2, "1e300"), (1, 2, 0), (1, 3, 0)])),
    "a drawing of nothing but ENTITIES": _checked(WALL, geometry__dxf="SECTION\n" + "  2\nENTITIES\n" * 100_000),
    "sagitta_m = 1e-7 on an arc of 10 km": _drawn(
        BLOCKS + polyline([(0, 2, 1), (20_000, 2, 0)]), text=WALL.replace("[material]", "sagitta_m = 1e-7\n[material]")
    ),
    "time_step_s = 1e-9": _checked(PROJECT + RECORD + "time_step_s = 1e-9\n", wave__csv="0,0\n0.01,0.1\n0.02,0\n"),
    "time_step_s = 1e-6 of an hour": _checked(
        PROJECT + RECORD + "time_step_s = 1e-6\n", wave__csv="\n".join(f"{k},{0.1 * (k % 2)}" for k in range(3600))
    ),
    "a pattern of the whole disk": _checked(PROJECT + DISK),
    "a pattern of the whole disk, four levels": _checked(PROJECT + DISK.replace("**/*", "*/*/*/*/*.no")),
    "TOML nested 10 000 deep": _checked(f"x = {'[' * 10_000}{']' * 10_000}\n"),
    "TOML tables nested 10 000 deep": _checked(f"x = {'{a=' * 10_000}1{'}' * 10_000}\n"),
    "a key of 10 000 parts": _checked(f"{'a.' * 10_000}a = 1\n"),
    "a table of 10 000 parts": _checked(f"[{'a.' * 10_000}a]\nb = 1\n"),
    "a table in the place of a title": _checked(PROJECT.replace('title = "Block"', f"title.{'a.' * 30}a = 1")),
    "a syntax error with escapes": _checked(PROJECT + f"x{ESCAPE} = {ESCAPE}\n"),
    "an unknown key with escapes": _checked(PROJECT + '"\\u001b[31m" = 1\n'),
    "results nested 10 000 deep": _results('{"a":' * 10_000 + "1" + "}" * 10_000),
    "results of lists 10 000 deep": _results("[" * 10_000 + "]" * 10_000),
    "a grid with an infinite a_g": _grid(_at(0, float("inf"))),
    "a grid with a_g that falls": _grid(_at(3, 0.4)),
    "a grid with F0 below 1": _grid(_at(1, 0.9)),
    "a grid with a T_C* that is no number": _grid(_at(2, float("nan"))),
    "a grid of one node": _checked(BY_GRID, grid__txt="13\t42" + "".join(f"\t{k}\t2.4\t0.3" for k in range(1, 10))),
    "a record whose header is a long number": _record(f"{PEER}{'1' * 200_000} NPTS\n0 1\n"),
    "a record whose header is blanks": _record(f"{PEER}NPTS={' ' * 200_000}\n0 1\n"),
    "a record of brackets": _record(f"PGA {'(' + ')' * 200_000}\n1\n2\n"),
    "a record of one endless line": _record("1 " * 1_500_000),
    "escapes in the name of the folder": _folder_name,
    "escapes and a line's end in the name of a record": _record_name,
}  # fmt: skip
