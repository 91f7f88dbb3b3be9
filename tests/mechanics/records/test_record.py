"""Records: each format and what is wrong in it; scale, window, time scale, resampling."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.records import formats as record_formats
from mechanics.records.record import Record, read_record
from mechanics.records.response_spectrum import response_spectrum
from mechanics.types import GRAVITY

VALUES = np.array(
    [0.01, -0.25, 0.1234567, 3.5e-05, -0.0125, 0.2, -1.0e-07, 0.0, 0.07, -0.03, 0.015, 0.002]
)  # g
STEP = 0.005


@pytest.fixture
def write(tmp_path):
    def write(text, name="motion.txt"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


def esm(values=VALUES, unit="cm/s^2", sensor_depth=True, **changes):
    size = 100.0 * GRAVITY if unit == "cm/s^2" else 1.0
    header = {f"KEY_{n}": "" for n in range(50)}
    header |= {"EVENT_NAME": "", "EVENT_TIME": "01:32:39"} | ({"SENSOR_DEPTH_M": ""} if sensor_depth else {})
    header |= {
        "SAMPLING_INTERVAL_S": STEP,
        "NDATA": len(values),
        "UNITS": unit,
        "BASELINE_CORRECTION": "a: b",
    }
    header |= {f"USER{n}": "" for n in range(1, 6)} | changes
    lines = [f"{key}: {value}" for key, value in header.items() if value is not None]
    return "\n".join(lines + [f"{size * v:.9f}" for v in values]) + "\n"


NEW = "NPTS=  {n}, DT=   .0050 SEC,"
OLD = "  {n}    0.0050    NPTS, DT"


def peer(values=VALUES, sizes=NEW, a_line=5, end="\n", unit="G", n=None):
    lines = [
        "PEER NGA STRONG MOTION DATABASE RECORD",
        "Somewhere, 1/1/2000, A station, 90",
        f"ACCELERATION TIME SERIES IN UNITS OF {unit}",
        sizes.format(n=len(values) if n is None else n),
    ]
    rows = [values[k : k + a_line] for k in range(0, len(values), a_line)]
    return end.join(lines + ["".join(f"{v:15.7E}" for v in row) for row in rows]) + end


def five_column(values=VALUES, **changes):
    header = {"Event Date & Time": "2009-04-06 01:32:39", "Orientation": "NS"}
    header |= {"Time Increment (s)": STEP, "Number of Data": len(values), "PGA (m/s/s)": 2.0} | changes
    lines = [f"{key:<30}: {value}" for key, value in header.items() if value is not None]
    rows = [values[k : k + 5] for k in range(0, len(values), 5)]
    rows = ["".join(f"{GRAVITY * v:14.7E}" for v in row) for row in rows]
    return "\n".join([*lines, "Accelaration time series in m/s/s", *rows])


def columns(separator, point=".", header="", values=VALUES, bom="", spaces=""):
    rows = [f"{STEP * k:.3f}{separator}{spaces}{v:.9f}" for k, v in enumerate(values)]
    return bom + header + "\n".join(rows).replace(".", point if separator != "," else ".") + "\n"


def column(point=".", header="", values=VALUES):
    return header + "\n".join(f"{v:.9f}".replace(".", point) for v in values)


FORMATS = {
    "esm": esm(),
    "esm without sensor depth": esm(sensor_depth=False),
    "esm without the end of its header": esm(USER5=None),
    "esm in g": esm(unit="g"),
    "esm, Windows": esm().replace("\n", "\r\n"),
    "peer": peer(),
    "peer, eight a line, old header": peer(a_line=8, sizes=OLD),
    "peer, one a line, doubled returns": peer(a_line=1, end="\r\r\n"),
    "peer without a comma": peer(sizes="NPTS=   {n}  DT=  0.0050 SEC,"),
    "peer, history": peer(unit="G. FILTER POINTS: HP=0.1 Hz LP=30.0 Hz").replace("SERIES", "HISTORY"),
    "five columns": five_column(),
    "five columns, last line ended": five_column() + "\n",
    "commas": columns(","),
    "commas and blanks": columns(",", spaces=" "),
    "commas, header, BOM": columns(",", header="time (s),acceleration (g)\n", bom="\ufeff"),
    "semicolons": columns(";", header="t;a\n"),
    "semicolons, decimal commas": columns(";", point=","),
    "tabs": columns("\t"),
    "tabs, decimal commas, header": columns("\t", point=",", header="t\ta\n"),
    "blanks": columns("  "),
    "semicolons, doubled returns": columns(";").replace("\n", "\r\r\n"),
    "commas, BOM, no header": columns(",", bom="\ufeff"),
    "one column": column(),
    "one column, decimal commas": column(point=",", header="a\n"),
}


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_reads_the_same(write, name):
    record = read_record(write(FORMATS[name], "aqv_ns.acc"), time_step=STEP if "one col" in name else None)
    assert record.acceleration == pytest.approx(VALUES, rel=1e-7, abs=1.1e-9)
    assert record.time_step == STEP
    assert record.name == "aqv_ns"


@pytest.mark.parametrize("name", ["esm", "peer", "five columns", "commas"])
def test_a_stated_time_step_wins(write, name):
    assert read_record(write(FORMATS[name]), time_step=0.02).time_step == STEP


def test_whole_numbers_under_a_header_with_a_comma_are_two_columns(write):
    record = read_record(write("t,a\n0,0\n1,1\n2,-1\n"))
    assert record.acceleration.tolist() == [0.0, 1.0, -1.0]
    assert record.time_step == 1.0


NAN = np.where(np.arange(VALUES.size) == 7, np.nan, VALUES)
GARBLED = columns(",").replace("-0.250000000", "-0.25x")

FAULTS = {
    "empty": ("", "line 1: fewer than two samples"),
    "prose": (
        "Dear reader,\nhere is\nthe record\n",
        "line 2: 'here' is not a finite number; .*known are ESM",
    ),
    "esm no step": (esm(SAMPLING_INTERVAL_S=None), "no SAMPLING_INTERVAL_S; get the file again"),
    "esm empty step": (esm(SAMPLING_INTERVAL_S=""), "line 54: SAMPLING_INTERVAL_S is ''; must be a positive"),
    "esm no unit": (esm(UNITS=None), "no UNITS"),
    "esm velocity": (esm(UNITS="cm/s"), "line 56: 'cm/s' is no unit of acceleration"),
    "esm cut": (esm(NDATA=15), "line 74: 12 values where NDATA says 15; .*get it again"),
    "esm no end": (esm((), USER5=None), "USER5"),
    "esm nan, doubled returns": (esm(NAN).replace("\n", "\r\r\n"), "line 70: 'nan' is not a finite number"),
    "esm nan": (esm(NAN), "line 70: 'nan' is not a finite number"),
    "peer no sizes": (peer(sizes="4000 points"), "no line with NPTS and DT"),
    "peer odd sizes": (peer(sizes="NPTS unknown"), "line 4: must read 'NPTS="),
    "peer too long": (peer(n=10), "line 7: 12 values where NPTS says 10"),
    "peer zero step": (peer(sizes="NPTS= {n}, DT= 0.000 SEC"), "line 4: DT is '0.000'"),
    "peer velocity": (peer(unit="CM/S"), "line 3: 'CM/S' is no unit of acceleration"),
    "peer no unit": (peer().replace("IN UNITS OF G", ""), "no header line states the unit"),
    "five columns cut": (five_column()[:-3], "line 9: '.*E' is not a finite number"),
    "five columns short": (
        five_column(VALUES[:-1], **{"Number of Data": 12}),
        "line 9: 11 values where Number of Data says 12",
    ),
    "five columns no step": (five_column(**{"Time Increment (s)": None}), r"no Time Increment \(s\)"),
    "five columns no title": (
        five_column().replace("Accelaration", "Series"),
        "no header line states the unit",
    ),
    "garbled": (GARBLED, "line 2: '-0.25x' is not a finite number; correct it"),
    "overflow": (columns(",").replace("0.200000000", "1e999"), "line 6: '1e999' is not a finite"),
    "missing cell": (columns(",").replace(",0.200000000", ""), "line 6: every line must hold"),
    "three columns": ("0.0,1.0,2.0\n0.1,1.0,2.0\n", "line 1: every line must hold"),
    "commas for everything": ("0,005,0,001\n0,010,0,002\n", "line 1: '0.005.0.001' is not a finite number"),
    "gap": (columns(",").replace("0.025,", "0.027,"), "line 6|line 7: the times are not evenly spaced"),
    "backwards": ("0.2,0.1\n0.1,0.2\n0.0,0.1\n", "not evenly spaced"),
    "other unit": (columns(",", header="t [s],a [m/s2]\n"), "line 1: .*must be in s and g"),
    "one sample": ("0.0,0.1\n", "fewer than two samples"),
    "no step": (column(), "needs its time step; give time_step"),
    "zero": (columns(",", values=np.zeros(9)), "every sample is 0 g"),
    "constant": (columns(";", values=np.full(9, 0.1)), "every sample is 0.1 g"),
    "no motion": (columns(",", values=1e-12 * VALUES), "every sample is 0 g"),
    "too large": (
        columns(",").replace("0.200000000", "1e7"),
        "line 6: '1e7' is larger than 1e.06; correct it",
    ),
    "peer step in ms": (
        peer(sizes="NPTS= {n}, DT= 50.0 SEC"),
        "line 4: a time step of 50 s; must be from 1e-06 to",
    ),
    "times in ms": (
        "0,0.1\n50,0.2\n100,0.1\n",
        "a time step of 50 s; must be from 1e-06 to 10 s: times are in sec",
    ),
    "esm step of nothing": (
        esm(SAMPLING_INTERVAL_S=1e-9),
        "line 54: a time step of 1e-09 s; must be from 1e-06",
    ),
    "wrong unit": (columns(",", values=981.0 * VALUES), "peak of 245.2 g; the unit is not"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_are_named_with_file_and_line(write, name):
    text, message = FAULTS[name]
    with pytest.raises(ValueError, match=message) as caught:
        read_record(write(text, "faulty.dat"))
    assert "faulty.dat: " in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("limit", "said"),
    [("MOST_BYTES", "more than 20 bytes"), ("MOST_VALUES", "line 11: more than 20 numbers")],
)
def test_files_have_a_limit(write, monkeypatch, limit, said):
    monkeypatch.setattr(record_formats, limit, 20)
    with pytest.raises(ValueError, match=f"{said}; give one record, of one component"):
        read_record(write(columns(",")))


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(ValueError, match=r"absent.asc: cannot be read: No such file.*check the name"):
        read_record(tmp_path / "absent.asc")
    with pytest.raises(ValueError, match=r"cannot be read"):
        read_record(tmp_path)


# --- scale, window, time scale ---

NOISE = Record(np.random.default_rng(3).normal(size=2001) * np.hanning(2001), 0.01, "noise")


def velocity_and_displacement(record):
    a, h = record.acceleration, record.time_step
    v = np.concatenate([[0.0], np.cumsum(a[1:] + a[:-1])]) * h / 2.0
    d = np.concatenate([[0.0], np.cumsum(v[:-1] * h + (2.0 * a[:-1] + a[1:]) * h**2 / 6.0)])
    return v, d


def test_properties():
    record = Record([0.0, -0.3, 0.2], 0.5, "three")
    assert (record.pga, record.duration) == (0.3, 1.0)
    assert record.time.tolist() == [0.0, 0.5, 1.0]
    with pytest.raises(ValueError):
        record.acceleration[0] = 1.0


def test_scaled_and_compressed():
    assert NOISE.scaled(-2.5).pga == pytest.approx(2.5 * NOISE.pga)
    fast = NOISE.compressed(np.sqrt(10.0))
    assert np.array_equal(fast.acceleration, NOISE.acceleration)
    assert fast.duration == pytest.approx(NOISE.duration / np.sqrt(10.0))
    assert fast.name == "noise"


def test_window_keeps_the_samples_inside():
    part = NOISE.windowed(3.0, 7.005)
    assert np.array_equal(part.acceleration, NOISE.acceleration[300:701])
    assert np.array_equal(NOISE.windowed(0.0, NOISE.duration).acceleration, NOISE.acceleration)
    assert NOISE.windowed(0.005, 1.0).acceleration[0] == NOISE.acceleration[1]


@pytest.mark.parametrize(
    "window", [(-1.0, 5.0), (5.0, 5.0), (7.0, 3.0), (15.0, 22.0), (0.001, 0.009), (np.nan, 1.0)]
)
def test_windows_outside_the_record_are_refused(window):
    with pytest.raises(ValueError, match="window"):
        NOISE.windowed(*window)


def test_arias_window_of_a_constant_is_linear():
    record = Record(np.full(101, 0.2), 0.1, "constant")
    assert record.arias_window() == pytest.approx((0.5, 9.5))
    assert record.arias_window(0.0, 1.0) == pytest.approx((0.0, 10.0))


@given(low=st.floats(0.0, 0.45), high=st.floats(0.55, 1.0), factor=st.floats(0.1, 10.0))
@settings(max_examples=30, deadline=None)
def test_arias_window_holds_its_share(low, high, factor):
    start, end = NOISE.scaled(factor).arias_window(low, high)
    inside = (NOISE.time >= start) & (NOISE.time <= end)
    share = (NOISE.acceleration[inside] ** 2).sum() / (NOISE.acceleration**2).sum()
    assert share == pytest.approx(high - low, abs=0.02)


def test_arias_window_refusals():
    with pytest.raises(ValueError, match="fractions"):
        NOISE.arias_window(0.9, 0.1)
    with pytest.raises(ValueError, match="zero throughout"):
        Record(np.zeros(5), 0.1, "still").arias_window()


# --- resampling ---


@pytest.mark.parametrize("parts", [1, 2, 5, 7])
def test_refining_is_exact_and_undone_by_coarsening(parts):
    fine = NOISE.resampled(NOISE.time_step / parts)
    assert fine.acceleration[::parts] == pytest.approx(NOISE.acceleration, abs=1e-12)
    assert fine.duration == pytest.approx(NOISE.duration)
    for ours, theirs in zip(velocity_and_displacement(fine), velocity_and_displacement(NOISE), strict=True):
        assert ours[::parts] == pytest.approx(theirs, abs=1e-9)
    assert fine.resampled(NOISE.time_step).acceleration == pytest.approx(NOISE.acceleration, abs=1e-9)


@given(ratio=st.floats(1.01, 9.0))
@settings(max_examples=30, deadline=None)
def test_coarsening_keeps_final_velocity_and_displacement(ratio):
    coarse = NOISE.resampled(ratio * NOISE.time_step)
    end = coarse.duration
    time = np.append(NOISE.time[NOISE.time < end], end)  # the record up to there, to its last kink
    a, h = np.interp(time, NOISE.time, NOISE.acceleration), np.diff(time)
    v = np.append(0.0, np.cumsum((a[1:] + a[:-1]) * h / 2.0))
    d = np.sum(v[:-1] * h + (2.0 * a[:-1] + a[1:]) * h**2 / 6.0)
    velocity, displacement = velocity_and_displacement(coarse)
    assert velocity[-1] == pytest.approx(v[-1], abs=1e-9)
    assert displacement[-1] == pytest.approx(d, abs=1e-9)
    assert NOISE.duration - coarse.time_step < end <= NOISE.duration * (1.0 + 1e-9)


def test_coarsening_keeps_the_spectrum_better_than_picking_samples():
    smooth = np.convolve(np.random.default_rng(5).normal(size=8000), np.hanning(25), "same") * np.hanning(
        8000
    )
    record = Record(0.05 * smooth, 0.005, "smooth")
    periods = np.geomspace(0.3, 3.0, 40)
    S_a = response_spectrum(record.acceleration, 0.005, periods)[0]
    projected = response_spectrum(record.resampled(0.02).acceleration, 0.02, periods)[0] / S_a - 1.0
    picked = response_spectrum(record.acceleration[::4], 0.02, periods)[0] / S_a - 1.0
    assert np.abs(projected).max() < 5e-3 < np.abs(picked).max()


def test_a_broken_line_on_the_coarser_grid_is_reproduced():
    corners = np.array([0.0, 0.3, -0.2, 0.1, 0.4])
    record = Record(np.interp(np.arange(41) / 10.0, np.arange(5.0), corners), 0.1, "broken")
    assert record.resampled(1.0).acceleration == pytest.approx(corners, abs=1e-12)


def test_the_same_step_is_the_same_record():
    assert NOISE.resampled(0.01 * (1.0 + 1e-12)) is NOISE


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: Record(np.zeros((2, 2)), 0.1, ""), "acceleration"),
        (lambda: Record([0.0, np.inf], 0.1, ""), "acceleration"),
        (lambda: Record([0.0], 0.1, ""), "acceleration"),
        (lambda: Record([0.0, 1.0], 0.0, ""), "time_step"),
        (lambda: NOISE.scaled(np.nan), "acceleration"),
        (lambda: NOISE.compressed(0.0), "time_factor"),
        (lambda: NOISE.resampled(-0.1), "time_step"),
        (lambda: NOISE.resampled(50.0), "time_step"),
        (lambda: read_record("x", time_step=0.0), "time_step"),
    ],
)
def test_bad_arguments_are_named(call, name):
    with pytest.raises(ValueError, match=f"^{name} = "):
        call()
