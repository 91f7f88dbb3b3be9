"""Records of L'Aquila, 6 April 2009 (ITACA): peaks, steps and significant durations of the benchmark list.

The peaks are also those that the files state themselves, in m/s². Skipped where the records are absent.
"""

from pathlib import Path

import pytest

from mechanics.records.record import read_record
from mechanics.types import GRAVITY

RECORDS = Path(__file__).parents[2] / ".." / "shared" / "data" / "records"

pytestmark = pytest.mark.skipif(not RECORDS.is_dir(), reason="needs ../shared/data/records")

PEAKS = {  # g, to the three digits printed
    "16833_H1": 0.517,
    "16833_H2": 0.477,
    "16837_H1": 0.547,
    "16837_H2": 0.663,
    "16889_H1": 0.318,
    "16889_H2": 0.298,
    "16858_H1": 0.145,
}
WINDOWS = {"16833_H1": (22.1, 30.7), "16837_H1": (33.1, 41.2), "16889_H1": (32.4, 58.3)}  # s, to 0.1 s


@pytest.mark.parametrize("name", PEAKS)
def test_peak_and_time_step(name):
    path = RECORDS / f"{name}.cor.acc"
    record = read_record(path)
    stated = next(line for line in path.read_text().splitlines()[:12] if line.startswith("PGA"))
    assert record.time_step == 0.005
    assert record.pga == pytest.approx(PEAKS[name], abs=6e-4)
    assert record.pga == pytest.approx(float(stated.split(":")[1]) / GRAVITY, rel=1e-6)


@pytest.mark.parametrize("name", WINDOWS)
def test_significant_duration(name):
    assert read_record(RECORDS / f"{name}.cor.acc").arias_window() == pytest.approx(WINDOWS[name], abs=0.05)
