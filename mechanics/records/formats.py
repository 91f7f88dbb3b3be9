"""From the text of an accelerogram file to samples in g and a time step; four formats, recognised by content."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mechanics.errors import RecordError
from mechanics.faults import visible
from mechanics.types import GRAVITY, Array

Samples = tuple[Array, float]  # acceleration (n,), g; time step, s

UNITS = {"g": 1.0, "cm/s2": 0.01 / GRAVITY, "gal": 0.01 / GRAVITY, "m/s2": 1.0 / GRAVITY}  # in g

ESM_LINE = re.compile(r"[A-Z][A-Z0-9_/^]*\s*:")
FIVE_COLUMN_KEY = re.compile(r"(Time Increment|Number of Data|PGA) *(\(.*\))? *:")
PEER_SIGN = re.compile(r"\bNPTS\b|TIME (SERIES|HISTORY) IN UNITS OF", re.IGNORECASE)
NUMBER = r"[\d.]+(?:[Ee][+-]?\d+)?"
PEER_SIZES = (
    re.compile(rf"NPTS\s*=\s*(?P<count>\d+)\s*,?\s*DT\s*=\s*(?P<step>{NUMBER})", re.IGNORECASE),
    re.compile(rf"^\s*(?P<count>\d+)\s*,?\s*(?P<step>{NUMBER})\s*,?\s*NPTS\s*,\s*DT", re.IGNORECASE),
)
KNOWN = "known are ESM/ITACA and PEER files, five-column .acc files and columns: g, or s and g"
HEADER_LINES, HEADER_WIDTH = 100, 250  # lines, characters: no known header is longer, or wider
MOST_BYTES = 100_000_000  # of a file
MOST_VALUES = 2_000_000  # of a file: an hour at 250 Hz, with its times
LARGEST = 1e6  # of a value in a file, in any of the units
SHORTEST, LONGEST = 1e-6, 10.0  # s: time steps of a record
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
        return RecordError(
            f"{visible(str(self.path))}: {message}"
            if line is None
            else f"{visible(str(self.path))}: line {line}: {message}"
        )


@dataclass(frozen=True)
class Header:
    """`KEY: value` lines of a record file: value and line number of each key."""

    text: RecordText
    entries: dict[str, tuple[str, int]]

    @classmethod
    def of(cls, text: RecordText, size: int) -> Header:
        """Read the first `size` lines; values may be empty or contain colons."""
        parts = [(line.partition(":"), n) for n, line in enumerate(text.lines[:size], 1)]
        return cls(text, {key.strip(): (value.strip(), n) for (key, _, value), n in parts})

    def value(self, key: str) -> tuple[str, int]:
        """Return value and line number of `key`. Raises RecordError if it is absent."""
        if key not in self.entries:
            raise self.text.error(None, f"the header has no {key}; get the file again from its source")
        return self.entries[key]

    def number(self, key: str) -> float:
        """Return the positive number of `key`. Raises RecordError if it is absent or no such number."""
        value, line = self.value(key)
        return _positive(self.text, line, key, value)

    def step(self, key: str) -> float:
        """Time step (s) of `key`; RecordError if absent or no such number."""
        return _check_step(self.text, self.value(key)[1], self.number(key))


def parse_record(path: Path, time_step: float | None) -> Samples:
    """Acceleration (n,), g, and time step, s, of the file; `time_step` is for one column without times.

    Raises ValueError naming file, line and remedy.
    """
    try:
        size = path.stat().st_size
        with path.open("rb") as file:
            raw = (
                file.read(MOST_BYTES + 1) if 0 < size <= MOST_BYTES else b""
            )  # what has no size may have no end
    except OSError as error:
        raise RecordError(
            f"{visible(str(path))}: cannot be read: {error.strerror}; check the name of the record"
        ) from error
    if size > MOST_BYTES:
        raise RecordError(
            f"{visible(str(path))}: more than {MOST_BYTES} bytes; give one record, of one component"
        )
    content = raw.decode("utf-8-sig", errors="replace")
    for line_end in ("\r\r\n", "\r\n", "\r"):  # the first is common in copies of PEER files
        content = content.replace(line_end, "\n")
    text = RecordText(path, content.rstrip().split("\n"))
    return _format_of(text)(text, time_step)


def _format_of(text: RecordText) -> Callable[[RecordText, float | None], Samples]:
    head = text.head
    if ESM_LINE.match(head[0]):
        return _esm
    if any(FIVE_COLUMN_KEY.match(line) for line in head):
        return _five_column
    if any(PEER_SIGN.search(line) for line in head):
        return _peer
    return _columns


def _esm(text: RecordText, _: float | None) -> Samples:
    """ESM and ITACA ASCII: `KEY: value` lines up to USER5 (shortened ones: to the first value), one value a line."""
    end = next((n for n, line in enumerate(text.head, 1) if line.startswith("USER5")), None)
    if end is None:
        end = next((n for n, line in enumerate(text.head) if _is_number(line)), None)
    if end is None:
        raise text.error(
            None,
            "the header does not end with a USER5 line, and no value follows; get the file again from its source",
        )
    header = Header.of(text, end)
    unit = _unit(text, *header.value("UNITS"))
    step, count = header.step("SAMPLING_INTERVAL_S"), header.number("NDATA")
    return unit * _counted(text, end, count, "NDATA"), step


def _five_column(text: RecordText, _: float | None) -> Samples:
    """`Key : value` lines, a line that names the unit, then values of 14 characters, mostly five a line."""
    end, unit = _unit_line(text, r"^Acc\w* time series in (\S+)", len(text.lines))
    header = Header.of(text, end - 1)
    step, count = header.step("Time Increment (s)"), header.number("Number of Data")
    return unit * _counted(text, end, count, "Number of Data"), step


def _peer(text: RecordText, _: float | None) -> Samples:
    """PEER AT2, old and new: a line that states the unit, a line with NPTS and DT, then values."""
    head = text.head
    end = next((n for n, line in enumerate(head, 1) if re.search(r"\bNPTS\b", line, re.IGNORECASE)), None)
    if end is None:
        raise text.error(None, "no line with NPTS and DT; a PEER record needs 'NPTS= 4000, DT= 0.005 SEC'")
    sizes = next((match for form in PEER_SIZES if (match := form.search(head[end - 1]))), None)
    if sizes is None:
        raise text.error(end, "must read 'NPTS= 4000, DT= 0.005 SEC' or '4000 0.005 NPTS, DT'")
    _, unit = _unit_line(text, r"IN UNITS OF\s+(\S+)", end - 1)
    step = _check_step(text, end, _positive(text, end, "DT", sizes["step"]))
    return unit * _counted(text, end, float(sizes["count"]), "NPTS"), step


def _columns(text: RecordText, time_step: float | None) -> Samples:
    """Read one column (g) or two (s, g) after at most one header line.

    Semicolons separate wherever there are any; commas separate where points are used for decimals or the
    header line holds commas too; in all other cases blanks separate and a comma is a decimal comma.
    """
    header = 0 if _is_number(re.split(r"[;,\s]", text.head[0].strip())[0]) else 1
    title, lines = "".join(text.head[:header]), text.lines[header:]
    if re.search(r"m/s|\bgal\b", title, re.IGNORECASE):
        raise text.error(
            header, f"{title.strip()[:SHOWN]!r}: columns must be in s and g; convert the accelerations"
        )
    body = "\n".join(lines)
    commas_separate = "," in body and ";" not in body and ("." in body or "," in title)
    separator = "," if commas_separate else ";" if ";" in body else None

    def cells(line: str) -> list[str]:
        return (line if commas_separate else line.replace(",", ".")).split(separator)

    widths = np.array([len(cells(line)) for line in lines], dtype=int)
    odd = np.flatnonzero((widths != widths[:1]) | (widths > 2) | (widths < 1))
    if odd.size:
        message = "every line must hold one column (g) or two (s, g), separated alike throughout"
        raise text.error(header + int(odd[0]) + 1, message)
    values = _values(text, header, cells)
    if len(lines) < 2:
        raise text.error(len(text.lines), "fewer than two samples; give one column (g) or two (s, g)")
    if widths[0] == 2:
        times, acceleration = values.reshape(-1, 2).T
        return acceleration, _uniform_step(text, header, times)
    if time_step is None:
        raise text.error(None, "one column of accelerations needs its time step; give time_step, in s")
    return values, time_step


def _uniform_step(text: RecordText, header: int, times: Array) -> float:
    steps = np.diff(times)
    step = float(times[-1] - times[0]) / steps.size
    drift = np.abs(times - times[0] - step * np.arange(times.size)).max()
    if not drift < 0.1 * step:
        line = header + int(np.abs(steps - np.median(steps)).argmax()) + 2
        message = "the times are not evenly spaced; interpolate the record or give one column and time_step"
        raise text.error(line, message)
    _check_step(text, None, step)
    return float(f"{step:.9g}")  # the times are printed decimals: 0.005, not 0.00499999999


def _counted(text: RecordText, header: int, count: float, key: str) -> Array:
    """Read the values (n,) after the header, as many as the field `key` gives."""
    values = _values(text, header, lambda line: _apart(line).split())
    if values.size != count:
        message = f"{values.size} values where {key} says {count:g}; the file was cut or edited: get it again"
        raise text.error(len(text.lines), message)
    return values


def _apart(line: str) -> str:
    """Part the numbers of fixed columns that touch, where a minus starts the next one."""
    return line.replace("-", " -").replace("E -", "E-").replace("e -", "e-")


def _values(text: RecordText, header: int, cells: Callable[[str], list[str]]) -> Array:
    lines = text.lines[header:]
    found: list[float] = []
    for number, line in enumerate(lines, header + 1):
        try:
            found += map(float, cells(line))
        except ValueError:
            found.append(np.nan)
        if len(found) > MOST_VALUES:
            raise text.error(number, f"more than {MOST_VALUES} numbers; give one record, of one component")
    values = np.array(found)
    if not (abs(values) <= LARGEST).all():
        numbered = ((n, cell) for n, line in enumerate(lines, header + 1) for cell in cells(line))
        line_number, cell = next((n, cell) for n, cell in numbered if not _is_number(cell, LARGEST))
        wrong = f"is larger than {LARGEST:g}" if _is_number(cell, math.inf) else "is not a finite number"
        raise text.error(line_number, f"{cell.strip()[:SHOWN]!r} {wrong}; correct it; {KNOWN}")
    return values


def _unit_line(text: RecordText, form: str, end: int) -> tuple[int, float]:
    """Find the line of this form before line `end`: its number and the unit it states, in g."""
    for n, line in enumerate(text.head[:end], 1):
        if match := re.search(form, line, re.IGNORECASE):
            return n, _unit(text, match[1], n)
    message = "no header line states the unit, such as 'Acceleration time series in units of g'; add it"
    raise text.error(None, message)


def _unit(text: RecordText, name: str, line: int) -> float:
    """Size of the unit in g, whichever way it is spelt (cm/s^2, cm/s/s, cm/sec**2, G.)."""
    key = name.lower().rstrip(".,;").replace("²", "2").replace("^", "").replace("**", "")
    key = key.replace("sec", "s").replace("s/s", "s2")
    if key not in UNITS:
        raise text.error(
            line, f"{name[:SHOWN]!r} is no unit of acceleration; use a record in g, m/s^2 or cm/s^2"
        )
    return UNITS[key]


def _positive(text: RecordText, line: int, key: str, value: str) -> float:
    if not _is_number(value, math.inf) or float(value) <= 0.0:
        raise text.error(line, f"{key} is {value[:SHOWN]!r}; must be a positive number")
    return float(value)


def _check_step(text: RecordText, line: int | None, step: float) -> float:
    """Return a time step; RecordError where no record has one like it."""
    if not SHORTEST <= step <= LONGEST:
        must = f"must be from {SHORTEST:g} to {LONGEST:g} s: times are in seconds"
        raise text.error(line, f"a time step of {step:.3g} s; {must}")
    return step


def _is_number(cell: str, most: float | None = None) -> bool:
    """Whether a cell is a number; one of that size at most, and finite, where `most` is given."""
    try:
        number = float(cell)
    except ValueError:
        return False
    return most is None or (math.isfinite(number) and abs(number) <= most)
