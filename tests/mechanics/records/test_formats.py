"""Record files: each format, what is wrong in it, units of headings."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.records import formats as record_formats
from mechanics.records.record import read_record
from mechanics.types import GRAVITY

# g
VALUES = np.array([0.01, -0.25, 0.1234567, 3.5e-05, -0.0125, 0.2, -1.0e-07, 0.0, 0.07, -0.03, 0.015, 0.002])
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
        "SAMPLING_INTERVAL_S": STEP, "NDATA": len(values), "UNITS": unit, "BASELINE_CORRECTION": "a: b",
    }  # fmt: skip
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


def knet(values=VALUES, peak=None, offset=4230, seconds=None, freq="100Hz"):
    """Counts of 7845 gal/8223790 about an offset, which is what a mean of the record leaves of it: none here."""
    gal = 100.0 * GRAVITY * (values - values.mean())
    counts = np.round(gal * 8223790 / 7845).astype(int) + offset
    seconds = round(len(values) / 100.0) if seconds is None else seconds
    header = {
        "Origin Time": "2018/01/24 19:51:00", "Lat.": "41.0", "Long.": "142.5", "Depth. (km)": "30", "Mag.": "6.2",
        "Station Code": "AOM999", "Station Lat.": "41.2", "Station Long.": "141.1", "Station Height(m)": "10",
        "Record Time": "2018/01/24 19:51:40", "Sampling Freq(Hz)": freq, "Duration Time(s)": seconds, "Dir.": "N-S",
        "Scale Factor": "7845(gal)/8223790", "Max. Acc. (gal)": f"{abs(gal).max() if peak is None else peak:.3f}",
        "Last Correction": "2018/01/24 19:51:41", "Memo.": "",
    }  # fmt: skip
    rows = ["".join(f"{c:8d} " for c in counts[k : k + 8]) for k in range(0, len(counts), 8)]
    return "\n".join([*(f"{key:<18}{value}" for key, value in header.items()), *rows]) + "\n"


def v2(values=VALUES, peak=None, n=None, channels=1):
    """A V2 file: text, parameters, then accelerations and velocities, eight a line, ten characters each."""
    cm = 100.0 * GRAVITY * values
    block = [
        f" {len(values) if n is None else n} points of accel data equally spaced at  .005 sec, in cm/sec2. (8f10.6) ",
        *("".join(f"{v:10.6f}"[:10] for v in cm[k : k + 8]) for k in range(0, len(cm), 8)),
        f" {len(values)} points of veloc data equally spaced at  .005 sec, in cm/sec.  (8f10.6) ",
        *("".join(f"{v:10.6f}"[:10] for v in cm[k : k + 8]) for k in range(0, len(cm), 8)),
        "/&  ----------  End of data for channel  1",
    ]
    head = [
        "Corrected accelerogram   15481673.XX.YYY.--.HN      Chan  1:  90 Deg     from   ",
        "Uncorrected Accelerogram Data             Processed: 04/30/14                 ",
        f"Peak acceleration =  {max(cm, key=abs) if peak is None else peak:.3f}    cm/sec/sec  at   14.840   sec.",
        "    1  100    1    3    3  100 -999    3    1    0 -999 4310    050660   41    0",
        "  .0050000  .7071000 301.30000  .0038554-999.00000 4996.0580  .0861213 14.830000",
    ]
    return "\n".join([*head, *(line for _ in range(channels) for line in block)]) + "\n"


def heading(title, separator=",", point="."):
    rows = [separator.join((f"{STEP * k:.3f}", f"{v:.9f}")).replace(".", point) for k, v in enumerate(VALUES)]
    return "\n".join([title, *rows]) + "\n"


def four(title):
    """Times, accelerations, velocities and displacements."""
    rows = [f"{STEP * k:.3f};{v:.9f};{0.1 * k:.3f};{-0.2 * k:.3f}" for k, v in enumerate(VALUES)]
    return "\n".join([*([title] if title else []), *rows]) + "\n"


QUOTED = '"time","acc"\n' + "".join(f'"{STEP * k:.3f}","{v:.9f}"\n' for k, v in enumerate(VALUES))

FORMATS = {
    "esm": esm(),
    "esm, PGA scaled by hand": esm().replace("KEY_9: ", "PGA_CM/S^2: -100.0"),
    "esm without sensor depth": esm(sensor_depth=False),
    "esm, Windows": esm().replace("\n", "\r\n"),
    "peer": peer(),
    "peer, eight a line, old header": peer(a_line=8, sizes=OLD),
    "peer, one a line, doubled returns": peer(a_line=1, end="\r\r\n"),
    "peer, history": peer(unit="G. FILTER POINTS: HP=0.1 Hz LP=30.0 Hz").replace("SERIES", "HISTORY"),
    "five columns": five_column(),
    "commas": columns(","),
    "commas, header, BOM": columns(",", header="time (s),acceleration (g)\n", bom="\ufeff"),
    "semicolons": columns(";", header="t;a\n"),
    "semicolons, decimal commas": columns(";", point=","),
    "tabs, decimal commas, header": columns("\t", point=",", header="t\ta\n"),
    "blanks": columns("  "),
    "cesmd v2": v2(),
    "utf-16": heading("time [s],acc [g]").encode("utf-16"),
    "utf-16 without its mark": heading("time [s],acc [g]").encode("utf-16-le"),
    "trailing commas": columns(",", header="time,acc\n").replace("\n", ",\n"),
    "quoted": QUOTED,
    "quoted, semicolons, decimal commas": QUOTED.replace(",", ";").replace(".", ","),
    "four columns": four("t [s]; a [g]; v [m/s]; d [m]"),
    "an index": "\n".join(
        f"{k},{line}" if k else f",{line}" for k, line in enumerate(heading("time,acc").splitlines())
    ),
    "accelerations first": "acc,time\n" + "".join(f"{v:.9f},{STEP * k:.3f}\n" for k, v in enumerate(VALUES)),
    "a comment": columns(",", header="# made by hand in 2020\n# time [s], acc [g]\n"),
    "a title": columns(";", header="Somewhere, north\n\nt;a\n"),
    "units below names": columns(",", header="time,acc\ns,g\n"),
    "blanks in the heading": columns("   ", header="Time (s)  Acceleration (g)\n"),
    "italian": heading("Tempo [s];Accelerazione [g]", ";", ","),
    "hard blanks, a true minus": columns(";").replace("-", "\u2212").replace(";", ";\xa0"),
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


NAN = np.where(np.arange(VALUES.size) == 7, np.nan, VALUES)
GARBLED = columns(",").replace("-0.250000000", "-0.25x")

FAULTS = {
    "empty": ("", "line 1: fewer than two samples"),
    "prose": ("Dear reader,\nhere is\nthe record\n", "line 1: 'Dear reader,': no line of numbers follows; supported"),
    "esm empty step": (esm(SAMPLING_INTERVAL_S=""), "line 54: SAMPLING_INTERVAL_S is ''; must be a positive"),
    "esm no unit": (esm(UNITS=None), "no UNITS"),
    "esm cut": (esm(NDATA=15), "line 74: 12 values where NDATA says 15; .*get it again"),
    "esm nan, doubled returns": (esm(NAN).replace("\n", "\r\r\n"), "line 70: 'nan' is not a finite number"),
    "esm nan": (esm(NAN), "line 70: 'nan' is not a finite number"),
    "esm of another unit": (
        esm().replace("KEY_9: ", "PGA_CM/S^2: -24516.6"),
        "line 10: the largest acceleration is 2.452e.04, that of the values 245.2; .*another unit: get it again",
    ),
    "five columns of another unit": (
        five_column(**{"PGA (m/s/s)": 0.0245166}),
        "line 5: the largest acceleration is 0.02452, that of the values 2.452",
    ),
    "peer milliseconds": (peer(sizes="NPTS= {n}, DT= 5.0 MSEC"), "line 4: must read 'NPTS= 4000, DT= 0.005 SEC'"),
    "peer no sizes": (peer(sizes="4000 points"), "no line with NPTS and DT"),
    "peer too long": (peer(n=10), "line 7: 12 values where NPTS says 10"),
    "five columns cut": (five_column()[:-3], "line 9: '.*E' is not a finite number"),
    "five columns no step": (five_column(**{"Time Increment (s)": None}), r"no Time Increment \(s\)"),
    "garbled": (GARBLED, "line 2: '-0.25x' is not a finite number; correct it"),
    "missing cell": (columns(",").replace(",0.200000000", ""), "line 6: 1 columns where the first line has 2"),
    "three columns": ("0.0,1.0,2.0\n0.1,1.0,2.0\n", "line 1: 3 columns without a heading; write a line"),
    "gap": (columns(",").replace("0.025,", "0.027,"), "line 6|line 7: the times are not evenly spaced"),
    "unknown unit": (
        heading("t [s],a [m/s3]"),
        r"line 1: 'm/s3' in the heading .*no unit.*; known are g, % g, mg, gal",
    ),
    "velocity": (heading("time (s),velocity (cm per s)"), "line 1: the heading .* names time and velocity; give acc"),
    "two units": (heading("t,a [g] (m/s2)"), "line 1: .* gives two units"),
    "two components": (four("t;NS;EW;UP"), "line 1: 3 columns of accelerations; give a record of one component"),
    "four columns, no heading": (four(""), "line 1: 4 columns without a heading; write a line that names them"),
    "first line, a letter": (heading("O.000,0.5"), "line 1: 'O.000,0.5' holds the number '0.5' and is no line"),
    "line in the middle, a letter": (columns(",").replace("0.035,", "O.035,"), "line 8: 'O.035' is not a finite"),
    "a comment that states the unit": (columns(",", header="# unit: m/s2\n"), "line 1: .*known are g"),
    "whole numbers": ("0,1\n1,2\n2,3\n", "line 1: commas may part columns or decimals; .*semicolons"),
    "esm spectrum": (
        esm().replace("KEY_9: ", "DATA_TYPE: ACCELERATION RESPONSE SPECTRUM"),
        "DATA_TYPE is 'ACCELERATION RESPONSE SPECT",
    ),
    "v2 cut": (v2(n=20), "line 8: 12 values where the V2 file says 20"),
    "v2 of two channels": (v2(channels=2), "line 13: this is a V2 file of 2 channels; give one channel a file"),
    "v2 changed": (v2(peak=200.0), "line 3: the largest acceleration is 0.2039, that of the values 0.25"),
    "v1": (
        "Uncorrected Accelerogram Data     Processed: 02\n  .1 .2\n",
        "this is a V1 file, uncorrected; supported are ESM",
    ),
    "cwb": ("#Earthquake Information\n#Data\n0.0 1.0 1.0 1.0\n", "this is a CWB file of three components"),
    "binary": (bytes(range(256)) * 4, "is no text; supported are ESM"),
    "no step": (column(), "needs its time step; give time_step"),
    "zero": (columns(",", values=np.zeros(9)), "every sample is 0 g"),
    "too large": (columns(",").replace("0.200000000", "1e7"), "line 6: '1e7' is larger than 1e.06; correct it"),
    "peer step in ms": (peer(sizes="NPTS= {n}, DT= 50.0 SEC"), "line 4: a time step of 50 s; must be from 1e-06 to"),
    "wrong unit": (columns(",", values=981.0 * VALUES), "peak of 245.2 g; the unit is not g: name it in the heading"),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_faults_are_named_with_file_and_line(write, name):
    text, message = FAULTS[name]
    with pytest.raises(ValueError, match=message) as caught:
        read_record(write(text, "faulty.dat"))
    assert "faulty.dat: " in str(caught.value)
    assert "\n" not in str(caught.value)


KNET_FAULTS = {
    "another rate": ({"freq": "none"}, "line 11: Sampling Freq of a K-NET file is 'none'"),
    "cut": ({"seconds": 20}, "values where Duration Time says 2000; the file was cut"),
    "changed": ({"peak": 100.0}, "line 15: the largest acceleration is 100, that of the values"),
}
SHAKEN = np.random.default_rng(4).normal(size=1000) * np.hanning(1000) / 10.0


def test_counts_of_k_net_are_read_about_their_mean(write):
    record = read_record(write(knet(SHAKEN), "AOM9991801241951.NS"))
    assert record.acceleration == pytest.approx(SHAKEN - SHAKEN.mean(), abs=1e-6)
    assert (record.time_step, record.unit) == (0.01, "gal")


@pytest.mark.parametrize("name", KNET_FAULTS)
def test_faults_of_k_net_files_are_named(write, name):
    change, message = KNET_FAULTS[name]
    with pytest.raises(ValueError, match=message):
        read_record(write(knet(SHAKEN, **change)))


UNITS = {
    "time (s),acceleration (ms-2)": ("m/s²", 1.0 / GRAVITY, STEP),
    "Time [ms],Acc [m/s²]": ("m/s²", 1.0 / GRAVITY, STEP / 1e3),
    "t,a [cm/s/s]": ("cm/s²", 0.01 / GRAVITY, STEP),
    "t(s),a(%g)": ("% g", 0.01, STEP),
    "tempo,accelerazione [gal]": ("gal", 0.01 / GRAVITY, STEP),
    "t,a": ("g", 1.0, STEP),
}


@pytest.mark.parametrize("title", UNITS)
@pytest.mark.parametrize("encoding", ["utf-8-sig", "cp1252"])
def test_units_of_the_heading_are_converted_and_kept(write, title, encoding):
    unit, size, step = UNITS[title]
    record = read_record(write(heading(title).encode(encoding)))
    assert record.acceleration == pytest.approx(size * VALUES, rel=1e-6, abs=1.1e-9)
    assert (record.time_step, record.unit) == (pytest.approx(step), unit)


@given(line=st.integers(0, 11), place=st.integers(0, 14), letter=st.sampled_from("OolIx'*?"))
@settings(max_examples=30)
def test_a_line_damaged_by_a_letter_is_never_passed_over(tmp_path_factory, line, place, letter):
    lines = columns(";").splitlines()
    lines[line] = lines[line][:place] + letter + lines[line][place + 1 :]
    path = tmp_path_factory.mktemp("damaged") / "a.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(ValueError, match=f"line {line + 1}: "):
        read_record(path)


@pytest.mark.parametrize(
    ("limit", "said"),
    [("MOST_BYTES", "more than 20 bytes"), ("MOST_VALUES", "line 11: more than 20 numbers")],
)
def test_files_have_a_limit(write, monkeypatch, limit, said):
    monkeypatch.setattr(record_formats, limit, 20)
    with pytest.raises(ValueError, match=f"{said}; give one record, of one component"):
        read_record(write(columns(",")))
