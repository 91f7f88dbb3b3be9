"""Incremental dynamic analysis: the search, what several records come to, and the pulse that overturns a block."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from assessment.analyses.dynamic import incremental
from assessment.analyses.dynamic.bracket import find_collapse
from assessment.analyses.dynamic.ensemble import Scatter
from assessment.analyses.dynamic.incremental import Levels, fragility, point, search, summarise
from assessment.analyses.dynamic.response import Setting
from assessment.analyses.dynamic.time_history import Shaking
from assessment.project.motions import BaseMotion
from assessment.project.schema import ControlTable, IncrementalTable
from assessment.results.schema.dynamic import Level, Search
from mechanics.records.record import Record
from tests.support.structures import block_on_base
from tests.support.typed import made

SINGLE = Scatter(1, 0.05)


class Trial:
    """A structure that collapses in some intervals of the PGA; counts the runs."""

    def __init__(self, *falls):
        self.falls, self.tried = falls, []

    def __call__(self, pga):
        self.tried.append(pga)
        return self.falls_at(pga)

    def falls_at(self, pga):
        return any(low <= pga < high for low, high in self.falls)

    def bracket(self, first, largest, tolerance):
        """The bracket of an ensemble of one: what some do all do."""
        return find_collapse(
            self, lambda pga: any(low <= pga < high for low, high in self.falls), first, largest, tolerance
        )


@given(
    limit=st.floats(0.02, 4.0),
    first=st.floats(0.05, 1.0),
    tolerance=st.floats(0.005, 0.1),
)
def test_the_bracket_holds_the_collapse_and_both_ends_were_run(limit, first, tolerance):
    assume(limit > tolerance)
    trial = Trial((limit, math.inf))
    found = trial.bracket(first, 5.0, tolerance)
    assert found.safe < limit <= found.collapse
    assert found.collapse - found.safe <= tolerance
    assert found.collapse in trial.tried
    assert found.safe in {0.0, *trial.tried}
    assert found.resurrections == ()
    assert len(set(trial.tried)) == len(trial.tried) < 40


def test_nothing_falls_up_to_the_largest_level():
    trial = Trial()
    found = trial.bracket(0.3, 2.0, 0.01)
    assert (found.safe, found.collapse, found.certain, found.resurrections) == (2.0, None, None, ())
    assert max(trial.tried) == 2.0


def test_the_first_level_is_not_above_the_largest():
    trial = Trial((0.5, 9.0))
    trial.bracket(3.0, 1.0, 0.01)
    assert max(trial.tried) <= 1.0


def test_a_fall_at_any_level_leaves_only_rest():
    found = Trial((0.0, 9.0)).bracket(0.4, 2.0, 0.01)
    assert found.safe == 0.0
    assert found.collapse <= 0.01


def test_resurrections_are_reported():
    """Falls from 0.30 g, stands again from 0.40 to 0.44 g (1.4 times), falls for good above."""
    found = Trial((0.30, 0.40), (0.44, 9.0)).bracket(0.35, 2.0, 0.01)
    assert 0.30 <= found.collapse < 0.311
    assert len(found.resurrections) == 1
    assert 0.40 <= found.resurrections[0] < 0.44


def test_a_fall_below_the_first_bracket_is_found_and_counts():
    """A window of collapse at 0.55–0.65 g hides below the collapse at 1 g; the grid's 0.6 finds it."""
    found = Trial((0.55, 0.65), (1.0, 9.0)).bracket(0.8, 2.0, 0.01)
    assert found.safe < 0.55 <= found.collapse < 0.56
    assert 0.8 in found.resurrections


@given(
    low=st.floats(0.1, 2.0),
    width=st.floats(0.0, 1.0),
    first=st.floats(0.05, 1.0),
    tolerance=st.floats(0.01, 0.1),
)
def test_the_range_goes_from_where_none_collapse_to_where_all_do(low, width, first, tolerance):
    """The share of members that collapse grows from `low` to `low` + `width`."""
    standing, all_fallen = [], []

    def some(pga):
        if pga < low:
            standing.append(pga)
        return pga >= low

    def every(pga):
        if pga >= low + width:
            all_fallen.append(pga)
        return pga >= low + width

    found = find_collapse(some, every, first, 8.0, tolerance)
    assert found.safe < low <= found.collapse <= low + tolerance
    assert found.safe in {0.0, *standing} and found.certain in all_fallen
    assert found.collapse <= found.certain <= max(low + width, found.collapse) + tolerance


def test_members_that_never_all_collapse_leave_the_upper_end_open():
    found = find_collapse(lambda pga: pga >= 0.5, lambda _: False, 0.3, 2.0, 0.01)
    assert 0.5 <= found.collapse < 0.51 and found.certain is None


def test_as_many_members_of_a_level_are_run_as_its_question_needs(monkeypatch, pulse, setting):
    """One that falls is enough for some, one that stands for all; a pair that stands alike for none."""
    ends = {}

    def made(model, motion, setting, start, factor):
        collapsed, peak = ends[round(factor, 4)]
        displacement = np.array([0.0, peak, 0.0])
        last = SimpleNamespace(collapse_reason="it falls")
        return SimpleNamespace(
            time=np.arange(3.0), displacement=displacement, collapsed=collapsed, last=last, worst=0.0,
            total=lambda _: 1,
        )  # fmt: skip

    monkeypatch.setattr(incremental, "respond", made)
    levels = Levels(block_on_base(), pulse, setting, None, Scatter(3, 0.05))
    ends |= {1.0: (False, 1.0), 1.01: (False, 1.01)}
    assert not levels.some(0.1) and len(levels.members[0.1]) == 2
    ends |= {2.0: (False, 1.0), 1.98: (True, 3.0), 2.02: (False, 2.0)}
    assert levels.some(0.2) and not levels.every(0.2)
    assert [each.collapsed for each in levels.members[0.2]] == [False, False, True]
    told = point(Level, 0.2, levels.members[0.2])
    assert told.peak_displacement_m_range == [1.0, None] and told.members_collapsed == 1
    ends |= {3.0: (True, 1.0), 2.97: (True, 2.0), 3.03: (True, 3.0)}
    assert levels.some(0.3) and len(levels.members[0.3]) == 1
    assert levels.every(0.3) and len(levels.members[0.3]) == 3


def test_fragility_by_maximum_likelihood():
    """Without censored records: mean and root mean square (over n) of the logarithms."""
    levels = [0.21, 0.34, 0.30, 0.55]
    found = fragility(levels)
    logs = np.log(levels)
    assert found.median_g == pytest.approx(math.exp(logs.mean()))
    assert found.dispersion == pytest.approx(logs.std())
    censored = fragility(levels, [0.6])
    assert censored.median_g > found.median_g
    assert (censored.records, censored.censored) == (5, 1)
    assert fragility([0.3]) is None
    assert fragility([0.3, 0.3]) is None


def _record(collapse, safe=None, **more):
    numbers = {"pga_collapse_g": collapse, "pga_safe_g": collapse if safe is None else safe}
    return made(Search, numbers | more)


def test_what_the_standard_takes_of_the_records():
    levels = [0.30, 0.36, 0.42, 0.33, 0.39, 0.35, 0.37]
    for count, rule, value in ((3, "lowest", 0.30), (6, "lowest", 0.30), (7, "mean", np.mean(levels))):
        warnings = []
        found = summarise([_record(level) for level in levels[:count]], warnings, "original")
        assert (found.rule, found.pga_collapse_g) == (rule, pytest.approx(value))
        assert found.mean_pga_collapse_g == pytest.approx(np.mean(levels[:count]))
        assert warnings == []


def test_of_fewer_than_three_records_the_standard_takes_nothing():
    """The lowest of two records was printed as the PGA of §7.3.5."""
    warnings = []
    found = summarise([_record(0.3), _record(0.4)], warnings, "original")
    assert (found.rule, found.pga_collapse_g) == (None, 0.3) and len(warnings) == 1


def test_the_range_of_a_state_is_that_of_what_the_standard_takes():
    records = [_record(low, pga_collapse_g_range=[low, high]) for low, high in ((0.3, 0.5), (0.4, 0.4))]
    assert summarise(records, [], "original").pga_collapse_g_range == [0.3, 0.4]
    seven = [_record(0.3, pga_collapse_g_range=[0.3, 0.4])] * 7
    assert summarise(seven, [], "original").pga_collapse_g_range == pytest.approx([0.3, 0.4])
    seven[0] = _record(0.3, pga_collapse_g_range=[0.3, None])
    assert summarise(seven, [], "original").pga_collapse_g_range[1] is None
    assert summarise([_record(0.3)], [], "original").pga_collapse_g_range is None


def test_fewer_than_three_records_are_warned_about():
    warnings = []
    found = summarise([_record(0.33)], warnings, "original")
    assert found.pga_collapse_g == found.mean_pga_collapse_g == 0.33
    assert "at least 3" in warnings[0]


def test_records_without_collapse_leave_the_mean_open_and_the_lowest_where_they_cannot_be_lower():
    found = summarise([_record(0.30), _record(0.40), _record(None, 0.9)], [], "original")
    assert found.mean_pga_collapse_g is None
    assert found.pga_collapse_g == 0.30
    assert found.fragility.censored == 1
    assert summarise([_record(0.30), _record(0.40), _record(None, 0.2)], [], "s").pga_collapse_g is None
    never = _record(None)
    found = summarise([_record(0.30), _record(0.40), never], [], "s")
    assert found.pga_collapse_g is None
    assert found.fragility is None


@pytest.fixture
def pulse():
    """A rectangular pulse of 0.5 s and 0.1 g, then 2 s of rest."""
    a = np.zeros(251)
    a[:50] = 0.1
    record = Record(a, 0.01, "pulse")
    return BaseMotion(record, record, record.pga, 1.0)


@pytest.fixture
def setting():
    table = IncrementalTable(records=("r",), contacts="rigid", integrator="second-order")
    return Setting(table, ControlTable(name="top", point_m=(0.3, 4.2)))


def test_the_pulse_that_overturns_a_slender_block(pulse, setting):
    """cosh(p t) = 1 + 1/(2k(k − 1)), k = a/(g α) (slender rigid block, benchmark list [L]); α as its tangent, 5 %."""
    model = block_on_base(0.6, 4.2)
    found = search(Shaking(model, pulse, setting, "original", model.initial), SINGLE, 5.0, 0.005)
    numbers = found.numbers
    p = math.sqrt(3.0 * 9.80665 / (4.0 * 0.5 * math.hypot(0.6, 4.2)))
    share = 1.0 / (2.0 * (math.cosh(0.5 * p) - 1.0))
    expected = (1.0 + math.sqrt(1.0 + 4.0 * share)) / 2.0 * 0.6 / 4.2
    assert numbers.pga_collapse_g == pytest.approx(expected, rel=0.05)
    assert 0.0 < numbers.pga_collapse_g - numbers.pga_safe_g <= 0.005
    assert numbers.runs == sum(point.members for point in numbers.points)
    fallen = {point.pga_g: point.collapsed for point in numbers.points}
    assert fallen[numbers.pga_collapse_g]
    assert not fallen[numbers.pga_safe_g]
    assert all((point.peak_displacement_m is None) == point.collapsed for point in numbers.points)
    assert found.failures == found.warnings == []
    assert found.quality[0].worst_equilibrium_residual < 1e-6


def test_no_collapse_up_to_max_scale_is_null_with_a_warning(pulse, setting):
    model = block_on_base(0.6, 4.2)
    found = search(Shaking(model, pulse, setting, "original", model.initial), SINGLE, 1.2, 0.05)
    assert found.numbers.pga_collapse_g is None
    assert found.numbers.pga_safe_g == pytest.approx(0.12)
    assert "max_scale" in found.warnings[0]


def test_a_state_that_was_not_reached_is_null_with_the_reason(pulse, setting):
    found = search(
        Shaking(block_on_base(0.6, 4.2), pulse, setting, "settled", "it collapses"), SINGLE, 5.0, 0.05
    )
    assert found.numbers.pga_collapse_g is None
    assert found.numbers.reason == "it collapses"
    assert "it collapses" in found.warnings[0]
    assert found.numbers.runs == 0
