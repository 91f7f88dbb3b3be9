"""Histories: the error that finer time steps tell against closed forms and references; ensembles and their use."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assessment.analyses import histories
from assessment.analyses.histories import Refinement, Scatter, Track, agree, lowest_median_highest, together
from assessment.analyses.time_history import FoundHistory, Setting, Shaking, quality_row, respond, ultimate_of
from assessment.project.motions import BaseMotion
from assessment.project.schema import ControlTable, HistoryTable
from assessment.results.schema.dynamic import History
from assessment.results.schema.model import QualityRow
from assessment.results.schema.static import Pushovers, RigidPush
from mechanics.records.record import Record
from mechanics.types import GRAVITY
from tests.support.structures import arch_on_piers, block_on_base
from tests.support.typed import made

STEP = 0.02
TIME = STEP * np.arange(76)
SINE = 0.27 * np.sin(4.0 * np.pi * TIME) * (TIME <= 0.5)  # g: a block of 0.2 × 1.0 m rocks and comes back
PUSH = np.where((TIME > 0.5 * STEP) & (TIME < 10.5 * STEP), 0.3, 0.0)  # g: one of low friction slides


class Asked:
    """A campaign of one history, run one by one, and what of its project histories depend on; `runs`: amplitudes."""

    states = ("original",)

    def __init__(
        self, model, acceleration, accuracy, integrator="implicit-euler", step=STEP, scatter=1, *,
        spacing=STEP, at=(0.2, 1.0), contacts="rigid",
    ):  # fmt: skip
        table = HistoryTable(record="pulse", contacts=contacts, integrator=integrator)
        record = Record(acceleration, spacing, "pulse").resampled(step)
        self.motion = BaseMotion(record, record, float(abs(acceleration).max()), 1.0)
        setting = Setting(table, ControlTable(name="top", point_m=at))
        self.task = Shaking(model, self.motion, setting, model.initial, "original")
        self.project, self.history, self.scatter, self.accuracy = self, (table,), scatter, accuracy
        self.runs = []

    def tasks(self, *_):
        return [self.task]

    def histories(self, tasks):
        self.runs += [task.motion.amplitude for task, *_ in tasks]
        return [histories.time_history.history(*task) for task in tasks]

    def found(self):
        [found] = histories.histories(self, [self.motion])
        return found


def bounded(found: FoundHistory, exact: float) -> dict:
    """Check a history's estimate against the true error of its peak; return its row."""
    row, peak = found.convergence, found.numbers.peak_displacement_m
    assert row is not None and row.met
    assert peak == row.levels["peak_displacement_m"][-1]
    assert found.numbers.time_step_s == STEP / 2**row.halvings
    assert abs(peak - exact) <= row.peak_displacement_error_m == pytest.approx(row.relative_error * peak)
    return row


def test_the_error_of_a_slide_is_bounded_by_the_estimate():
    """A block on μ = 0.1 slides by ∫∫ (a − μ) g from the instant that a exceeds μ to its rest."""
    friction = 0.1
    model = block_on_base(width=1.0, friction=friction)
    rise = STEP * (1.0 - friction / 0.3)  # while the broken line is above μ, before and after the plateau
    slope, plateau = 0.3 * GRAVITY / STEP, 9 * STEP
    net = (0.3 - friction) * GRAVITY
    v1, u1 = slope * rise**2 / 2.0, slope * rise**3 / 6.0
    v2, u2 = v1 + net * plateau, u1 + v1 * plateau + net * plateau**2 / 2.0
    v3 = v2 + net * rise - slope * rise**2 / 2.0
    u3 = u2 + v2 * rise + net * rise**2 / 2.0 - slope * rise**3 / 6.0
    fall = STEP - rise  # the line goes on to zero
    v4, u4 = v3 - slope * fall**2 / 2.0, u3 + v3 * fall - slope * fall**3 / 6.0
    exact = u4 + v4**2 / (2.0 * friction * GRAVITY)
    found = Asked(model, PUSH, 0.02).found()
    row = bounded(found, exact)
    assert abs(row.levels["peak_displacement_m"][0] / exact - 1.0) > 0.02 >= row.relative_error


def test_the_error_of_a_rocking_block_is_bounded_by_the_estimate():
    """Second order, one cycle of a sine; reference: the same with a sixteenth of the step."""
    model = block_on_base()
    reference = respond(Asked(model, SINE, "fast", "second-order", STEP / 16).task)
    assert not reference.collapsed
    bounded(Asked(model, SINE, "fine", "second-order").found(), float(abs(reference.displacement).max()))


def test_two_time_steps_that_agree_do_not_end_the_search(monkeypatch):
    """Implicit Euler on a rocking arch at 5, 2.5 and 1.25 ms, and then finer: the first two are equal."""
    peaks = {1.0: 3.22, 0.5: 3.22, 0.25: 3.88, 0.125: 6.7, 0.0625: 11.6}
    found = made_up(monkeypatch, "fine", lambda share: (peaks[share], False))
    row = found.convergence
    assert row.levels["peak_displacement_m"] == [3.22, 3.22, 3.88, 6.7, 11.6]
    assert not row.met and row.relative_error > 0.4 and row.order is None
    assert "estimated error of peak_displacement_m" in found.warnings[0]


def test_a_collapse_is_confirmed_by_three_time_steps(monkeypatch):
    """Where one says collapse and another does not, nothing is known."""
    three = made_up(monkeypatch, "standard", lambda _: (9.9, True))
    assert three.convergence.met and three.convergence.halvings == 2 and not three.warnings
    assert "peak_displacement_error_m" not in three.convergence
    late = made_up(monkeypatch, "standard", lambda share: (0.1, share == 1.0))
    assert not late.convergence.met and "not known" in late.warnings[0]


def made_up(monkeypatch, accuracy, told):
    """A history whose peak and collapse are told for each share of the time step."""

    def moved(shaking):
        peak, fell = told(shaking.motion.record.time_step / STEP)
        curve = {"time_s": [0.0, 1.0, 2.0], "displacement_m": [0.0, peak, 0.0]}
        numbers = {"peak_displacement_m": peak, "collapsed": fell, "curve": curve}
        numbers["time_of_collapse_s"] = 2.0 if fell else None
        quality = [made(QualityRow, {"solves": 1})]
        return FoundHistory(made(History, numbers), quality=quality, state=shaking.state)

    monkeypatch.setattr(histories.time_history, "history", moved)
    return Asked(block_on_base(), SINE, accuracy).found()


def test_a_half_step_shakes_by_the_same_lines_and_a_member_by_a_factor_on_both():
    motion = Asked(block_on_base(), SINE, "fast").motion
    vertical = np.cos(3.0 * TIME)
    both = replace(motion, vertical=Record(vertical, STEP, "up"))
    member, half = both.at_amplitude(0.99), both.halved()
    assert member.vertical is not None
    np.testing.assert_allclose(member.vertical.acceleration, 0.99 * vertical)
    np.testing.assert_allclose(member.record.acceleration, 0.99 * motion.record.acceleration)
    assert half.record.time_step == STEP / 2 and half.vertical is not None
    np.testing.assert_array_equal(half.record.acceleration[::2], motion.record.acceleration)
    found = half.vertical.acceleration
    np.testing.assert_allclose(found[::2], vertical, atol=1e-12)
    np.testing.assert_allclose(found[1::2], 0.5 * (vertical[1:] + vertical[:-1]), atol=1e-12)


def levels(*values, scatter=0.0):
    return Refinement(values, (scatter,) * len(values), 1e-9)


@given(
    exact=st.floats(0.1, 9.0),
    share=st.floats(-0.5, 0.5).filter(lambda s: abs(s) > 1e-3),
    order=st.floats(0.5, 2.0),
    count=st.integers(3, 5),
)
def test_the_error_bounds_that_of_any_order_which_is_told(exact, share, order, count):
    values = [exact * (1.0 + share * 2.0 ** (-order * n)) for n in range(count)]
    found = levels(*values)
    assert found.order == pytest.approx(order, abs=1e-3)
    if order >= 1.0:
        assert found.error >= 0.999 * abs(values[-1] - exact)
    assert found.finished(0.5) == found.within(0.5)


def test_two_levels_never_tell_that_it_is_enough():
    assert not levels(3.22, 3.22).within(0.05) and not levels(3.22, 3.22).finished(0.05)
    assert levels(3.22, 3.22).row("s", "r", 0.05).relative_error is None


def test_two_equal_levels_and_a_third_that_differs_are_not_believed():
    """Implicit Euler on a rocking arch: 3.22, 3.22, 3.88 and then 6.7 mm."""
    found = levels(3.22, 3.22, 3.88)
    assert found.order is None and found.error == pytest.approx(0.66)
    assert not found.within(0.05)
    assert not levels(3.22, 3.22, 3.88, 6.7).within(0.05)
    last = levels(3.88, 3.22, 3.22)
    assert last.order is None and last.error == pytest.approx(0.66), "nor where the last two are the same"


def test_scatter_that_levels_do_not_exceed_is_told_as_such():
    """3.28, 3.25, 3.22 mm look converged; records that differ by 1 % say how far they are to be believed."""
    found = levels(3.28, 3.25, 3.22, scatter=0.4)
    assert found.scatters == 0.4 and found.finished(0.05) and not found.within(0.05)
    row = found.row("s", "r", 0.05)
    assert row.peak_displacement_scatter_m == 0.4 and "peak_displacement_error_m" not in row.model_fields_set
    [said] = found.missed("original", 0.05)
    assert "scatters by 12 %" in said
    assert levels(3.9, 3.5, 3.22, scatter=0.4).scatters is None


def test_a_collapse_that_all_levels_see_has_no_error_and_one_that_some_see_leaves_it_open():
    assert levels(None, None, None).within(0.05)
    assert "relative_error" not in levels(None, None, None).row("s", "r", 0.05).model_fields_set
    assert levels(0.1, None, None).error is None and not levels(0.1, None, None).within(0.05)
    assert "not known" in levels(0.1, 0.1, None).missed("original", 0.05)[0]


@given(st.integers(1, 30))
def test_members_are_evenly_spread_and_the_record_itself_is_one(count):
    amplitudes = Scatter(count, 0.05).amplitudes
    assert amplitudes[0] == 1.0 and len(set(amplitudes)) == count
    assert min(amplitudes) >= 0.99 - 1e-12 and max(amplitudes) <= 1.01 + 1e-12
    if count > 1:
        assert amplitudes[1] == min(amplitudes) == pytest.approx(0.99)
        assert np.ptp(np.diff(sorted(amplitudes))) < 1e-12


EVENLY = np.linspace(0.0, 2.0, 201)
SWING = np.sin(2.0 * np.pi * EVENLY) * EVENLY


def test_members_agree_only_where_they_go_the_same_way():
    one, near = Track(EVENLY, SWING, False), Track(EVENLY, 0.99 * SWING, False)
    assert agree(one, near, 0.05, 1.0)
    mirrored = Track(EVENLY, -SWING, False)
    assert abs(mirrored.displacement).max() == abs(one.displacement).max()
    assert not agree(one, mirrored, 0.05, 1.0), "equal peaks may be chance"
    assert not agree(one, Track(EVENLY, SWING, True), 0.05, 1.0)
    # what follows the peak does not count
    parting = np.where(np.arange(201) > abs(SWING).argmax(), 0.0, SWING)
    assert agree(one, Track(EVENLY, parting, False), 0.05, 1.0)
    assert agree(Track(EVENLY, 1e-9 * SWING, False), Track(EVENLY, -1e-9 * SWING, False), 0.05, 1.0)


@given(st.lists(st.none() | st.floats(0.0, 9.0), min_size=1, max_size=9))
def test_the_range_holds_every_member_and_a_collapse_is_beyond_all(values):
    low, middle, high = lowest_median_highest(values)
    known = [value for value in values if value is not None]
    assert low == (min(known) if known else None)
    assert high == (None if None in values else max(known))
    assert middle is None or low <= middle


# Histories

FINE = 0.01
WAVE = np.sin(4.0 * np.pi * FINE * np.arange(100))


def shaken(model, acceleration, **more):
    return Asked(model, acceleration, "fast", "auto", FINE, 5, spacing=FINE, **more)


def test_a_smooth_motion_ends_after_two_members():
    """A block that swings on its soft joint: as much as its record shakes it."""
    asked = shaken(block_on_base(0.6, 2.4, stiffness=1e5), 0.02 * WAVE, at=(0.6, 2.4), contacts="elastic")
    found = asked.found()
    numbers = found.numbers
    assert asked.runs == [1.0, 0.99]
    assert numbers.members == 2 and numbers.amplitude == 1.0
    low, high = numbers.peak_displacement_m_range
    assert numbers.peak_displacement_m == high > low == pytest.approx(0.99 * high, rel=1e-3)
    assert numbers.band is None
    assert not any("within 1 %" in text for text in found.warnings)


def test_an_arch_that_rocks_has_a_range_that_contains_each_member():
    asked = shaken(arch_on_piers(), 0.185 * np.r_[WAVE, np.zeros(40)], at=(0.0, 1.44))
    found = asked.found()
    numbers = found.numbers
    assert sorted(asked.runs) == pytest.approx([0.99, 0.995, 1.0, 1.005, 1.01])
    assert numbers.members == 5 and numbers.members_collapsed == 0
    low, high = numbers.peak_displacement_m_range
    assert numbers.integrator == "moreau-jean" and "impacts" in numbers.integrator_chosen
    assert low <= numbers.peak_displacement_median_m <= high == numbers.peak_displacement_m
    for amplitude in (1.0, 0.99):
        member = respond(asked.task, amplitude)
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
    asked = Asked(model, np.zeros(3), "fast", "auto", at=(0.6, 2.4))
    leaning = model.rotated(1, (0.6, 0.0), -np.arctan(0.6 / 2.4) - 2e-4)
    found = respond(replace(asked.task, start=leaning))
    assert found.collapsed or len(found.parts) == 1


def test_a_motion_is_ultimate_where_the_static_capacity_vanishes_in_both_directions():
    def pushed(d, control="C", **more):
        return Pushovers(control=control, rigid=made(RigidPush, {"d_0_m": d, "reached_zero": True} | more))

    assert ultimate_of({"+x": pushed(0.2), "-x": pushed(0.3)}, "C") == 0.3
    assert ultimate_of({"+x": pushed(0.2)}, "C") is None
    assert ultimate_of({"+x": pushed(0.2), "-x": pushed(0.3, "D")}, "C") is None
    assert ultimate_of({"+x": pushed(0.2), "-x": pushed(0.3, reached_zero=False)}, "C") is None
