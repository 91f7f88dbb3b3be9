"""Ensembles: which members are run, when two are enough, what is used of several."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assessment.analyses import histories
from assessment.analyses.found import Accuracy
from assessment.analyses.histories import Scatter, Track, agree, lowest_median_highest, together
from assessment.analyses.time_history import FoundHistory, Setting, Shaking, quality_row, respond
from assessment.project.motions import BaseMotion
from assessment.project.schema import ControlTable, HistoryTable
from assessment.results.schema.dynamic import History
from mechanics.records.record import Record
from tests.support.structures import arch_on_piers, block_on_base
from tests.support.typed import made

FAST, FIVE = Accuracy(None, 0), Scatter(5, 0.05)


@given(st.integers(1, 30))
def test_members_are_evenly_spread_and_the_record_itself_is_one(count):
    amplitudes = Scatter(count, 0.05).amplitudes
    assert amplitudes[0] == 1.0 and len(set(amplitudes)) == count
    assert min(amplitudes) >= 0.99 - 1e-12 and max(amplitudes) <= 1.01 + 1e-12
    if count > 1:
        assert amplitudes[1] == min(amplitudes) == pytest.approx(0.99)
        assert np.ptp(np.diff(sorted(amplitudes))) < 1e-12


TIME = np.linspace(0.0, 2.0, 201)
SWING = np.sin(2.0 * np.pi * TIME) * TIME


def test_members_agree_only_where_they_go_the_same_way():
    one, near = Track(TIME, SWING, False), Track(TIME, 0.99 * SWING, False)
    assert agree(one, near, 0.05, 1.0)
    mirrored = Track(TIME, -SWING, False)
    assert abs(mirrored.displacement).max() == abs(one.displacement).max()
    assert not agree(one, mirrored, 0.05, 1.0), "equal peaks may be chance"
    assert not agree(one, Track(TIME, SWING, True), 0.05, 1.0)
    # what follows the peak does not count
    parting = np.where(np.arange(201) > abs(SWING).argmax(), 0.0, SWING)
    assert agree(one, Track(TIME, parting, False), 0.05, 1.0)
    assert agree(Track(TIME, 1e-9 * SWING, False), Track(TIME, -1e-9 * SWING, False), 0.05, 1.0)


@given(st.lists(st.none() | st.floats(0.0, 9.0), min_size=1, max_size=9))
def test_the_range_holds_every_member_and_a_collapse_is_beyond_all(values):
    low, middle, high = lowest_median_highest(values)
    known = [value for value in values if value is not None]
    assert low == (min(known) if known else None)
    assert high == (None if None in values else max(known))
    assert middle is None or low <= middle


# Histories


class Alone:
    """A campaign that runs its tasks one by one, and counts them."""

    def __init__(self, project, *tasks):
        self.project, self.own, self.runs = project, tasks, []

    def tasks(self, table, motions):
        return list(self.own)

    def each(self, stage, function, tasks):
        self.runs += [task.motion.amplitude for task, *_ in tasks]
        return [function(*task) for task in tasks]


class Asked:
    """The keys of a project that histories depend on."""

    states = ("original",)

    def __init__(self, table, scatter=5, accuracy="fast"):
        self.history, self.scatter, self.accuracy = (table,), scatter, accuracy


def shaken(model, point, contacts, acceleration, step, scatter=5, accuracy="fast"):
    """The history of a model under an acceleration, and the campaign that ran it."""
    table = HistoryTable(record="r", contacts=contacts)
    record = Record(acceleration, step, "r")
    motion = BaseMotion(record, record, record.pga, 1.0)
    setting = Setting(table, ControlTable(name="top", point_m=point))
    task = Shaking(model, motion, setting, "original", model.initial)
    campaign = Alone(Asked(table, scatter, accuracy), task)
    [found] = histories.histories(campaign, [motion])
    return found, campaign.runs


STEP = 0.01
WAVE = np.sin(4.0 * np.pi * STEP * np.arange(100))


def test_a_smooth_motion_ends_after_two_members():
    """A block that swings on its soft joint: as much as its record shakes it."""
    model = block_on_base(0.6, 2.4, stiffness=1e5)
    found, runs = shaken(model, (0.6, 2.4), "elastic", 0.02 * WAVE, STEP)
    assert runs == [1.0, 0.99]
    numbers = found.numbers
    assert numbers.members == 2 and numbers.amplitude == 1.0
    low, high = numbers.peak_displacement_m_range
    assert numbers.peak_displacement_m == high > low == pytest.approx(0.99 * high, rel=1e-3)
    assert numbers.band is None
    assert not any("within 1 %" in text for text in found.warnings)


def test_an_arch_that_rocks_has_a_range_that_contains_each_member():
    model, point = arch_on_piers(), (0.0, 1.44)
    acceleration = 0.185 * np.r_[WAVE, np.zeros(40)]
    found, runs = shaken(model, point, "rigid", acceleration, STEP)
    numbers = found.numbers
    assert sorted(runs) == pytest.approx([0.99, 0.995, 1.0, 1.005, 1.01])
    assert numbers.members == 5 and numbers.members_collapsed == 0
    low, high = numbers.peak_displacement_m_range
    assert numbers.integrator == "moreau-jean" and "impacts" in numbers.integrator_chosen
    assert low <= numbers.peak_displacement_median_m <= high == numbers.peak_displacement_m
    table = HistoryTable(record="r", contacts="rigid")
    setting = Setting(table, ControlTable(name="top", point_m=point))
    record = Record(acceleration, STEP, "r")
    motion = BaseMotion(record, record, record.pga, 1.0)
    for amplitude in (1.0, 0.99):
        member = respond(model, motion, setting, model.initial, amplitude)
        assert low <= abs(member.displacement).max() <= high
    band = numbers.band
    curve = np.array(numbers.curve.displacement_m)
    assert (np.array(band.low_m) <= curve).all() and (curve <= np.array(band.high_m)).all()
    assert any("5 records within 1 %" in text for text in found.warnings)


# What is used of several


def member(peak=0.1, collapsed=False, time=None):
    """A history that is made up."""
    time_s = [0.0, 1.0] if time is None else [0.0, time]
    numbers = {
        "peak_displacement_m": peak,
        "collapsed": collapsed,
        "time_of_collapse_s": time,
        "curve": {"time_s": time_s, "displacement_m": [0.0, peak]},
    }
    return FoundHistory(made(History, numbers), quality=[row(2, peak)], seconds=1.0, state="s")


def row(solves, residual):
    return quality_row("s", "h", solves, residual)


def test_the_largest_demand_is_used():
    found = together("s, r", [member(0.1), member(0.3), member(0.2)])
    assert found.numbers.peak_displacement_m == 0.3 and found.numbers.time_of_collapse_s is None
    assert found.numbers.peak_displacement_m_range == [0.1, 0.3]
    assert found.numbers.peak_displacement_median_m == 0.2
    assert found.quality == [row(6, 0.3)]


def test_a_collapse_is_beyond_any_peak_and_the_earliest_counts():
    found = together("s, r", [member(0.5), member(9.0, True, 4.0), member(8.0, True, 3.0)])
    numbers = found.numbers
    assert (numbers.peak_displacement_m, numbers.time_of_collapse_s) == (8.0, 3.0)
    assert numbers.members_collapsed == 2
    assert found.numbers.peak_displacement_m_range == [0.5, None]
    assert found.numbers.peak_displacement_median_m is None
    assert "2 of 3 records" in found.warnings[-1]


def test_a_member_that_fails_is_told_and_the_others_count():
    failed = FoundHistory(made(History, {"reason": "no"}), failures=["s, r: no"], state="s")
    found = together("s, r", [member(0.1), failed])
    assert found.failures == ["s, r: no"] and found.numbers.members == 1
    assert together("s, r", [failed, failed]) is failed


def test_a_fall_under_way_is_followed_to_its_end():
    """A block that leans almost over its edge falls for longer than one stretch of free motion."""
    model = block_on_base(0.6, 2.4)
    table = HistoryTable(record="r", contacts="rigid")
    setting = Setting(table, ControlTable(name="top", point_m=(0.6, 2.4)))
    leaning = model.rotated(1, (0.6, 0.0), -np.arctan(0.6 / 2.4) - 2e-4)
    record = Record(np.zeros(3), 0.02, "rest")
    found = respond(model, BaseMotion(record, record, 0.0, 1.0), setting, leaning)
    assert found.collapsed or len(found.parts) == 1
