"""Records of L'Aquila, 6 April 2009 (ITACA): peaks, steps, significant durations, and a motion under one of them.

Peaks and durations were computed apart; the peaks are also those that the files state themselves, in m/s². The motion:
the buttressed arch on exact elastic beds with 5 % damping under 16833_H1 at 0.03 g, 1.494 mm as drawn and 4.48 mm
settled by a program written apart. Which part of the record that program
took is not known. Skipped where the records are absent.
"""

from pathlib import Path

import pytest

from mechanics import State, pushdown, time_history
from mechanics.records.record import read_record
from mechanics.types import GRAVITY
from tests.support.drawn_projects import drawn

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


def peak(window: tuple[float, float], state: State | None = None) -> float:
    """Of the top of the right pier of the buttressed arch, mm, under a part (s) of the record at 0.03 g."""
    record = read_record(RECORDS / "16833_H1.cor.acc")
    part = record.scaled(0.03 / record.pga).windowed(*window)
    motion = time_history(
        drawn("buttressed_arch"), part.acceleration, part.time_step, "elastic", state,
        damping_ratio=0.05, control=(0.42, 0.55),
    )  # fmt: skip
    return 1000.0 * float(abs(motion.displacement).max())


STRONG, LONGER = (22.1, 30.7), (20.0, 32.0)  # s; every longer part has the peaks of the longer one


def test_peak_as_drawn():
    """The strong part alone, which begins abruptly, gives 1.61 mm."""
    assert peak(LONGER) == pytest.approx(1.494, rel=2e-3)


@pytest.fixture(scope="module")
def settled():
    return pushdown(
        drawn("buttressed_arch"), "destro", (0.02, -0.02), increment=0.002, contacts="elastic"
    ).final


def test_settled_the_longer_part_gives_more_than_the_trial(settled):
    """The trial's 4.48 mm lie between what two parts give: 4.634 mm here, 3.4 % more."""
    assert 4.48 < peak(LONGER, settled) < 1.035 * 4.48


def test_settled_the_strong_part_gives_less_than_the_trial(settled):
    """4.399 mm, 1.8 % less."""
    assert 0.98 * 4.48 < peak(STRONG, settled) < 4.48
