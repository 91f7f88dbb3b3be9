"""From the text of an accelerogram file to samples in g and a time step; the format is recognised by its content."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mechanics.errors import RecordError
from mechanics.messages import visible
from mechanics.records.headings import KNOWN, Column, HeadingError, column, labels, speaks_of_units, unit
from mechanics.types import Array

Entry = tuple[str, str, int]
"""Key, value and line of what a header says."""


class Samples(NamedTuple):
    """What a file holds: acceleration (n,), g; time step, s; the unit in which the file has them."""

    acceleration: Array
    time_step: float
    unit: str


ESM_LINE = re.compile(r"[A-Z][A-Z0-9_/^]*\s*:")
FIVE_COLUMN_KEY = re.compile(r"(Time Increment|Number of Data|PGA) *(\(.*\))? *:")
PEER_SIGN = re.compile(r"\bNPTS\b|TIME (SERIES|HISTORY) IN UNITS OF", re.IGNORECASE)
NUMBER = r"\d*\.?\d+(?:[Ee][+-]?\d+)?"
PEER_SIZES = (
    re.compile(rf"NPTS\s*=\s*(?P<count>\d+)\s*,?\s*DT\s*=\s*(?P<step>{NUMBER})\s*(s|,|$)", re.IGNORECASE),
    re.compile(rf"^\s*(?P<count>\d+)\s*,?\s*(?P<step>{NUMBER})\s*,?\s*NPTS\s*,\s*DT", re.IGNORECASE),
)
V2_BLOCK = re.compile(
    rf"\s*(?P<count>\d+) points of accel data equally spaced at\s+(?P<step>{NUMBER}) sec, in (?P<unit>\S+?)\.?"
    r"(?:\s*\(\d+f(?P<width>\d+)\.\d+\))?\s*$",
    re.IGNORECASE,
)
FOREIGN = (  # formats that are recognised and not read: name, sign in the header
    ("V1 file, uncorrected", r"^\s*uncorrected accelerogram|^\s*raw acceleration counts"),
    ("V3 file of spectra", r"response and fourier amplitude spectra"),
    ("V2 file of the COSMOS form", r"\(format v\d\d\.\d\d"),
    ("GeoNet file", r"gns science|geonet"),
    ("V2 file of another form", r"^\s*corrected accelerogram"),
    ("SMC file", r"^\d (un)?corrected accelerogram"),
    ("AFAD file of three components", r"strong ground motion records of t"),
    ("CWB file of three components", r"^#\s*earthquake information"),
)
SUPPORTED = (
    "supported are ESM/ITACA .ASC, PEER .AT2, K-NET, CESMD V2 of one channel, five-column .acc, "
    "and text with a column of times and one of accelerations"
)
HEADER_LINES, HEADER_WIDTH = 100, 250  # lines, characters: no known header is longer, or wider
MOST_BYTES = 100_000_000  # of a file
MOST_VALUES = 2_000_000  # of a file: an hour at 250 Hz, with its times
LARGEST = 1e6  # of a value in a file, in any of the units
SHORTEST, LONGEST = 1e-6, 10.0  # s: time steps of a record
SAME_PEAK = 0.02  # of the largest acceleration that a header states
SAME_UNIT = 0.8  # the same, of a record that was scaled or not: five times more or less is another unit
NO_UNIT = "no header line states the unit, such as 'Acceleration time series in units of g'; add it"
SHOWN = 40  # characters of a text that a message shows


@dataclass(frozen=True)
class RecordText:
    """The lines of a record file, and errors that name them (counted from 1)."""

    path: Path
    lines: list[str]

    @property
    def head(self) -> list[str]:
        """The lines among which a header may stand, as much of each as it may take."""
        return [line[:HEADER_WIDTH] for line in self.lines[:HEADER_LINES]]

    def error(self, line: int | None, message: str) -> RecordError:
        """Return a RecordError that reads `FILE: line N: message`."""
        place = visible(str(self.path)) if line is None else f"{visible(str(self.path))}: line {line}"
        return RecordError(f"{place}: {visible(message)}")

    def field(self, form: str, end: int, absent: str = "") -> tuple[str, int]:
        """Return what a form's group holds in the first of `end` lines that has it, and the line.

        Raises RecordError, with what is `absent`, where none has; without that it returns "" and 0.
        """
        for n, line in enumerate(self.lines[:end], 1):
            if match := re.search(form, line[:HEADER_WIDTH], re.IGNORECASE):
                return match[1].strip(), n
        if absent:
            raise self.error(None, absent)
        return "", 0

    def entry(self, key: str, end: int) -> Entry:
        """Return the entry `KEY: value` of the first `end` lines. Raises RecordError if there is none."""
        absent = f"the header has no {key}; get the file again from its source"
        return key, *self.field(rf"^\s*{re.escape(key)}\s*:(.*)", end, absent)

    def positive(self, key: str, value: str, line: int) -> float:
        """Return a positive number of the header. Raises RecordError for anything else."""
        if not _is_number(value, math.inf) or float(value) <= 0.0:
            raise self.error(line, f"{key} is {value[:SHOWN]!r}; must be a positive number")
        return float(value)

    def step(self, step: float, line: int | None) -> float:
        """Return a time step (s). Raises RecordError where no record has one like it."""
        if not SHORTEST <= step <= LONGEST:
            must = f"must be from {SHORTEST:g} to {LONGEST:g} s; name the unit in the heading"
            raise self.error(line, f"a time step of {step:.3g} s; {must}, as in time [ms]")
        return step

    def unit(self, name: str, line: int) -> Column:
        """Return a unit of acceleration. Raises RecordError for any other."""
        found = unit(name)
        if found is None or found.quantity != "acceleration":
            raise self.error(line, f"{name[:SHOWN]!r} is no unit of acceleration; {KNOWN}")
        return found


def parse_record(path: Path, time_step: float | None) -> Samples:
    """Return the samples of a file, of one column at the `time_step` (s). Raises RecordError naming line and remedy."""
    try:
        size = path.stat().st_size
        with path.open("rb") as file:
            # what has no size may have no end
            raw = file.read(MOST_BYTES + 1) if 0 < size <= MOST_BYTES else b""
    except OSError as error:
        unread = f"cannot be read: {error.strerror}; check the name of the record"
        raise RecordError(f"{visible(str(path))}: {unread}") from error
    if size > MOST_BYTES:
        much = f"more than {MOST_BYTES} bytes; give one record, of one component"
        raise RecordError(f"{visible(str(path))}: {much}")
    content = _decoded(raw)
    for line_end in ("\r\r\n", "\r\n", "\r"):  # the first is common in copies of PEER files
        content = content.replace(line_end, "\n")
    text = RecordText(path, content.rstrip().replace("\u2212", "-").replace("\xa0", " ").split("\n"))
    if "\0" in content:
        raise text.error(None, f"is no text; {SUPPORTED}")
    return _format_of(text)(text, time_step)


def _decoded(raw: bytes) -> str:
    """Return the text of a file, in UTF-8, UTF-16 with or without its mark, or as Windows writes it."""
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        return raw.decode("utf-16", errors="replace")
    for start, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
        if raw[start:400:2] and not any(raw[start:400:2]) and all(raw[1 - start : 400 : 2]):
            return raw.decode(encoding, errors="replace")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")


def _format_of(text: RecordText) -> Callable[[RecordText, float | None], Samples]:
    head = text.head
    if ESM_LINE.match(head[0]):
        return _esm
    if any(FIVE_COLUMN_KEY.match(line) for line in head):
        return _five_column
    if any(PEER_SIGN.search(line) for line in head):
        return _peer
    if any(line.startswith("Sampling Freq") for line in head):
        return _knet
    if any(V2_BLOCK.match(line) for line in head):
        return _v2
    for name, sign in FOREIGN:
        if any(re.search(sign, line, re.IGNORECASE) for line in head):
            raise text.error(None, f"this is a {name}; {SUPPORTED}")
    if match := re.fullmatch(r"\.(v[0-3])\w?", text.path.suffix, re.IGNORECASE):
        form = f"this is a {match[1].upper()} file by its name, of an unknown form"
        raise text.error(None, f"{form}; {SUPPORTED}")
    return _columns


def _esm(text: RecordText, _: float | None) -> Samples:
    """ESM and ITACA ASCII: `KEY: value` lines up to USER5 (shortened ones: to the first value), one value a line."""
    end = next((n for n, line in enumerate(text.head, 1) if line.startswith("USER5")), None)
    if end is None:
        end = next((n for n, line in enumerate(text.head) if _is_number(line)), None)
    if end is None:
        lost = "no USER5 line ends the header, and no value follows; get the file again from its source"
        raise text.error(None, lost)
    kind, line = text.field(r"^\s*DATA_TYPE\s*:(.*)", end)
    if kind.upper() not in ("", "ACCELERATION"):
        raise text.error(line, f"DATA_TYPE is {kind[:SHOWN]!r}; give the file of the ACCELERATION")
    own = text.unit(*text.entry("UNITS", end)[1:])
    return _counted(text, end, own, text.entry("SAMPLING_INTERVAL_S", end), text.entry("NDATA", end))


def _five_column(text: RecordText, _: float | None) -> Samples:
    """`Key : value` lines, a line that names the unit, then values of 14 characters, mostly five a line."""
    name, end = text.field(r"^Acc\w* time series in (\S+)", HEADER_LINES, NO_UNIT)
    step, count = text.entry("Time Increment (s)", end - 1), text.entry("Number of Data", end - 1)
    return _counted(text, end, text.unit(name, end), step, count)


def _peer(text: RecordText, _: float | None) -> Samples:
    """PEER AT2, old and new: a line that states the unit, a line with NPTS and DT, then values."""
    absent = "no line with NPTS and DT; a PEER record needs 'NPTS= 4000, DT= 0.005 SEC'"
    line, end = text.field(r"(.*\bNPTS\b.*)", HEADER_LINES, absent)
    sizes = next((match for form in PEER_SIZES if (match := form.search(line))), None)
    if sizes is None:
        raise text.error(end, "must read 'NPTS= 4000, DT= 0.005 SEC' or '4000 0.005 NPTS, DT'")
    own = text.unit(*text.field(r"IN UNITS OF\s+(\S+)", end - 1, NO_UNIT))
    return _counted(text, end, own, ("DT", sizes["step"], end), ("NPTS", sizes["count"], end))


def _knet(text: RecordText, _: float | None) -> Samples:
    """K-NET and KiK-net ASCII: 17 lines, then counts; the mean of the record is its offset, as in the header's peak."""

    def read(key: str, form: str) -> tuple[re.Match[str], int]:
        value, n = text.field(rf"^(?=\s*{key}).{{1,18}}(.*)", 17)
        match = re.match(form, value, re.IGNORECASE)
        if match is None:
            raise text.error(n or None, f"{key} of a K-NET file is {value[:SHOWN]!r}; get the file again")
        return match, n

    rate, rated = read("Sampling Freq", NUMBER)
    scale, scaled = read("Scale Factor", rf"({NUMBER})\((.+)\)/({NUMBER})")
    peak, peaked = read("Max", NUMBER)
    seconds = float(read("Duration Time", NUMBER)[0][0])
    frequency = text.positive("Sampling Freq", rate[0], rated)
    counts, own = _values(text, 17, str.split), text.unit(scale[2], scaled)
    if abs(counts.size - frequency * seconds) > frequency:
        message = f"{counts.size} values where Duration Time says {frequency * seconds:g}"
        raise text.error(len(text.lines), f"{message}; the file was cut or edited: get it again")
    factor = float(scale[1]) / text.positive("Scale Factor", scale[3], scaled)
    acceleration = factor * (counts - counts.mean())
    _check_peak(text, peaked, float(peak[0]), acceleration)
    return Samples(own.size * acceleration, text.step(1.0 / frequency, rated), own.unit)


def _v2(text: RecordText, _: float | None) -> Samples:
    """CESMD (CSMIP) V2 of one channel: the values of the block of accelerations, in columns of fixed width."""
    blocks = [(n, match) for n, line in enumerate(text.lines, 1) if (match := V2_BLOCK.match(line))]
    (start, block), *more = blocks
    if more:
        raise text.error(more[0][0], f"this is a V2 file of {len(blocks)} channels; give one channel a file")
    count, width = int(block["count"]), int(block["width"] or 10)
    ends = (n for n, line in enumerate(text.lines[start:], start) if re.search(r"points of|/&", line))
    end, own = next(ends, len(text.lines)), text.unit(block["unit"], start)

    def cells(line: str) -> list[str]:
        return [line[k : k + width] for k in range(0, len(line.rstrip()), width)]

    values = _values(RecordText(text.path, text.lines[:end]), start, cells)
    if values.size != count:
        raise text.error(end, f"{values.size} values where the V2 file says {count}; get the file again")
    peak, line = text.field(rf"^Peak acceleration = *(-?{NUMBER} +\S+)", start)
    if peak:
        stated, name = peak.split()
        _check_peak(text, line, float(stated) * text.unit(name, line).size, own.size * values)
    step = text.step(text.positive("the step", block["step"], start), start)
    return Samples(own.size * values, step, own.unit)


def _check_peak(text: RecordText, line: int, stated: float, values: Array, share: float = SAME_PEAK) -> None:
    """Raise RecordError where the header states another largest acceleration, by more than a `share`, in one unit."""
    found, size = float(abs(values).max()), abs(stated)
    if abs(found - size) > share * max(found, size):
        message = f"the largest acceleration is {size:.4g}, that of the values {found:.4g}; the file was changed, is "
        raise text.error(line, f"{message}damaged or names another unit: get it again from its source")


def _columns(text: RecordText, time_step: float | None) -> Samples:
    """Read a column of accelerations, or one of times and one of accelerations among others that a heading names.

    Semicolons separate wherever there are any; commas separate where points are used for decimals, cells are quoted or
    the heading holds commas too; in all other cases blanks separate and a comma is a decimal comma.
    """
    if text.lines == [""]:
        raise text.error(1, "fewer than two samples; the file is empty")
    start = next((n for n, line in enumerate(text.lines[:HEADER_LINES]) if _numeric(line)), None)
    if start is None:
        raise text.error(1, f"{text.lines[0].strip()[:SHOWN]!r}: no line of numbers follows; {SUPPORTED}")
    body = "\n".join(text.lines[start:])
    cells, separator = _cells(body, text.head[start - 1] if start else "")
    widths = np.array([len(cells(line)) for line in text.lines[start:]], dtype=int)
    if (odd := np.flatnonzero((widths != widths[0]) | (widths < 1))).size:
        message = f"{widths[odd[0]]} columns where the first line has {widths[0]}; correct the line"
        raise text.error(start + int(odd[0]) + 1, message)
    columns = _described(text, start, int(widths[0]), separator)
    values = _values(text, start, cells).reshape(-1, len(columns))
    if len(values) < 2:
        raise text.error(len(text.lines), "fewer than two samples; give one column (g) or two (s, g)")
    if separator is None and len(columns) == 1 and "," in body:
        whole = np.diff(np.trunc(values[:, 0]))
        if whole[0] > 0.0 and (whole == whole[0]).all():
            wrong = "commas may part columns or decimals; part the columns with semicolons"
            raise text.error(start + 1, wrong)
    which = next(k for k, each in enumerate(columns) if each.quantity == "acceleration")
    acceleration = columns[which].size * values[:, which]
    times = next((k for k, each in enumerate(columns) if each.quantity == "time"), None)
    if times is not None:
        step = _uniform_step(text, start, columns[times].size * values[:, times])
    elif time_step is None:
        raise text.error(None, "one column of accelerations needs its time step; give time_step_s, in s")
    else:
        step = time_step
    return Samples(acceleration, step, columns[which].unit)


def _cells(body: str, title: str) -> tuple[Callable[[str], list[str]], str | None]:
    """Return how a line is parted into cells, those that are empty at its end left out, and what parts them."""
    bare = re.sub(r'"[^"\n]*"', "0", body) if '"' in body else body
    commas = "," in bare and ";" not in bare and ("." in bare or "," in title or bare is not body)
    separator = "," if commas and ("\t" not in bare or "." in bare) else ";" if ";" in bare else None

    def cells(line: str) -> list[str]:
        if '"' in line and separator:
            parts = next(csv.reader([line], delimiter=separator, skipinitialspace=True))
            parts = [part.replace(",", ".") for part in parts]
        else:
            parts = (line if separator == "," else line.replace(",", ".")).replace('"', "").split(separator)
        while parts and not parts[-1].strip():
            parts.pop()
        return parts

    return cells, separator


def _described(text: RecordText, start: int, count: int, separator: str | None) -> list[Column]:
    """Return what each column holds: accelerations, and times where there are several; RecordError for others."""
    remedy = "write one name and unit a column, such as: time [s], acceleration [g]"
    lines = [
        (n, bool(re.match(r"\s*(#|%|//|!)", line)), re.sub(r"^\s*(#|%|//|!)+|\"", "", line).strip())
        for n, line in enumerate(text.head[:start], 1)
        if line.strip(' ,;\t"#%')
    ]
    columns, number, heading = None, start + 1, ""
    while lines and columns is None:
        number, comment, heading = lines.pop()
        _refuse_damaged(text, number, comment, heading, separator)
        if lines and separator and _names_units(heading, separator):  # below a line of names
            pairs = zip_longest(lines.pop()[2].split(separator), heading.split(separator), fillvalue="")
            marked = (f"{name} [{own.strip(' ()[]')}]" if own.strip() else name for name, own in pairs)
            heading = separator.join(marked)
        try:
            columns = [column(label) for label in labels(heading, count, separator)]
        except HeadingError as error:
            if not comment or speaks_of_units(heading):
                raise text.error(number, f"{error}; {KNOWN}; {remedy}") from None
    for n, comment, line in lines:
        _refuse_damaged(text, n, comment, line, separator)
        if speaks_of_units(line):
            wrong = f"{line[:SHOWN]!r} speaks of units or of time steps"
            raise text.error(n, f"{wrong}; write them into the heading of the columns, and delete it")
    if columns is None:
        if count > 2:
            names = "such as t [s], a [g], v [m/s], d [m]"
            wrong = f"{count} columns without a heading; write a line that names them, {names}"
            raise text.error(start + 1, wrong)
        columns = [Column("time", "s", 1.0), Column("acceleration", "g", 1.0)][2 - count :]
    kinds = [each.quantity for each in columns]
    accelerations = kinds.count("acceleration")
    if not accelerations:
        wrong = f"the heading {heading[:SHOWN]!r} names {' and '.join(kinds)}; give accelerations"
        raise text.error(number, wrong)
    if accelerations > 1:
        raise text.error(number, f"{accelerations} columns of accelerations; give a record of one component")
    if kinds.count("time") != (count > 1):
        raise text.error(number, f"{kinds.count('time')} columns of times beside the accelerations; {remedy}")
    return columns


def _refuse_damaged(text: RecordText, n: int, comment: bool, line: str, separator: str | None) -> None:
    """Raise RecordError where a line before the numbers holds a number: it is one of them, damaged, or not known."""
    cells = [] if comment else line.split(separator)
    if bad := next((cell.strip() for cell in cells if _is_number(cell.replace(",", "."))), None):
        wrong = f"{line[:SHOWN]!r} holds the number {bad[:SHOWN]!r} and is no line of numbers"
        raise text.error(n, f"{wrong}; correct it, or delete it; {SUPPORTED}")


def _names_units(line: str, separator: str) -> bool:
    """Whether every cell of a line is a unit, or empty."""
    cells = [cell.strip(" ()[]") for cell in line.split(separator)]
    return any(cells) and all(unit(cell) is not None for cell in cells if cell)


def _numeric(line: str) -> bool:
    """Whether every cell of a line is a number, whatever parts them."""
    cells = [cell for cell in re.split(r"[;,\s\"]+", line) if cell]
    return bool(cells) and all(_is_number(cell) for cell in cells)


def _uniform_step(text: RecordText, header: int, times: Array) -> float:
    steps = np.diff(times)
    step = float(times[-1] - times[0]) / steps.size
    drift = np.abs(times - times[0] - step * np.arange(times.size)).max()
    if not drift < 0.1 * step:
        line = header + int(np.abs(steps - np.median(steps)).argmax()) + 2
        wrong = "the times are not evenly spaced; interpolate the record, or give one column and time_step_s"
        raise text.error(line, wrong)
    text.step(step, None)
    return float(f"{step:.9g}")  # the times are printed decimals: 0.005, not 0.00499999999


def _counted(text: RecordText, header: int, own: Column, step: Entry, count: Entry) -> Samples:
    """Read the values after the header, whose entries have their step (s) and how many they are."""
    time_step, stated = text.step(text.positive(*step), step[2]), text.positive(*count)
    # numbers of fixed columns that touch are parted where a minus starts the next one
    values = _values(text, header, lambda line: re.sub(r"(?<![Ee])-", " -", line).split())
    if values.size != stated:
        message = f"{values.size} values where {count[0]} says {stated:g}"
        raise text.error(len(text.lines), f"{message}; the file was cut or edited: get it again")
    peak, line = text.field(r"^PGA[ _]\(?(.*:.*)", header)
    name, _, size = peak.partition(":")
    if (its := unit(name.rstrip(" )"))) and _is_number(size) and float(size):
        _check_peak(text, line, float(size), own.size / its.size * values, SAME_UNIT)
    return Samples(own.size * values, time_step, own.unit)


def _values(text: RecordText, header: int, cells: Callable[[str], list[str]]) -> Array:
    lines = text.lines[header:]
    found: list[float] = []
    for number, line in enumerate(lines, header + 1):
        try:
            found += map(float, cells(line))
        except ValueError:
            found.append(np.nan)
        if "_" in line:  # which float() passes over
            found.append(np.nan)
        if len(found) > MOST_VALUES:
            raise text.error(number, f"more than {MOST_VALUES} numbers; give one record, of one component")
    values = np.array(found)
    if not (abs(values) <= LARGEST).all():
        numbered = ((n, cell) for n, line in enumerate(lines, header + 1) for cell in cells(line))
        line_number, cell = next((n, cell) for n, cell in numbered if not _is_number(cell, LARGEST))
        wrong = f"is larger than {LARGEST:g}" if _is_number(cell, math.inf) else "is not a finite number"
        raise text.error(line_number, f"{cell.strip()[:SHOWN]!r} {wrong}; correct it")
    return values


def _is_number(cell: str, most: float | None = None) -> bool:
    """Whether a cell is a number; one of that size at most, and finite, where `most` is given."""
    try:
        number = math.nan if "_" in cell else float(cell)
    except ValueError:
        return False
    return "_" not in cell and (most is None or (math.isfinite(number) and abs(number) <= most))
