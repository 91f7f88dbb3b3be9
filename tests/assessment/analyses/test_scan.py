"""Which levels of a record are run, and what their outcomes show."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.special import ndtr

from assessment.analyses import scan as scans
from assessment.analyses.fragility import Observed, RecordLevel, observed, over_records
from assessment.analyses.histories import Scatter
from assessment.analyses.scan import Reach, scan, scan_levels
from assessment.analyses.time_history import Setting, Shaking
from assessment.project.motions import BaseMotion
from assessment.project.schema import ControlTable, MotionTable
from mechanics import Assembly, Block, ConvergenceError, Material
from mechanics.messages import message
from mechanics.records.record import Record
from tests.support.structures import block_on_base, rectangle
from tests.support.wording import in_italian

RATIO = 1.05
SPACING, DOWN, CERTAIN, CLOSEST = 1.05, 0.7, 2, 0.0125  # of the analysis: see there


class Trial:
    """A structure that collapses in intervals of the level, else it moves by `moves`(level). Notes what is run."""

    def __init__(self, *falls, moves=lambda level: 0.0):
        self.falls, self.moves, self.tried = falls, moves, {}

    def __call__(self, level):
        assert level not in self.tried
        self.tried[level] = any(low <= level < high for low, high in self.falls)
        return math.inf if self.tried[level] else self.moves(level)

    def seen(self, near=None, pga=0.3, **reach):
        scan_levels(self, pga, Reach(**({"max_scale": 8.0} | reach)), near)
        return observed(list(self.tried), list(self.tried.values()))


def test_the_level_that_counts_is_among_those_that_were_run():
    """Of bands far apart the 16 % level of the probit lies below 0.7 of the lowest collapse: it is looked for there."""
    trial = Trial((0.415, 0.46), (0.51, 0.72), (0.76, 0.83), (1.12, 9.0))
    seen = trial.seen(near=0.9, pga=0.32)
    assert seen.capacity < DOWN * seen.lowest, "the case shows nothing"
    assert min(trial.tried) <= seen.capacity and 0.0 < seen.safe < seen.capacity


def test_no_band_of_two_levels_is_passed_over_on_the_way_up():
    trial = Trial((0.51, 0.571), (1.12, 9.0))
    assert trial.seen(near=0.35, pga=0.32).lowest < 0.571


def test_a_history_that_falls_lowers_the_scan():
    """A band far below the lowest collapse that the scan meets: a motion of the record that falls there shows it."""
    missed, found = (Trial((0.458, 0.49), (0.99, 9.0)) for _ in range(2))
    assert missed.seen(near=0.9, pga=0.32).lowest > 0.9
    scan_levels(found, 0.32, Reach(max_scale=8.0), 0.9, also=(0.47,))
    seen = observed(list(found.tried), list(found.tried.values()))
    assert seen.lowest == pytest.approx(0.458, rel=0.05) and min(found.tried) <= 0.33


def test_large_displacements_far_below_the_lowest_collapse_announce_a_band():
    """The band lies below 0.7 of the collapse that the scan meets first; the structure moves as far there as at it."""

    def moves(level):
        return 1.0 if 0.44 < level < 0.75 or level > 0.95 else 0.3 * level

    quiet, told = Trial((0.458, 0.466), (0.99, 9.0)), Trial((0.458, 0.466), (0.99, 9.0), moves=moves)
    assert quiet.seen(near=0.9, pga=0.32).lowest > 0.9
    assert told.seen(near=0.9, pga=0.32).lowest < 0.466


@given(
    limit=st.floats(0.2, 2.0),
    grows=st.floats(0.0, 6.0),
    bands=st.lists(st.tuples(st.floats(0.1, 2.0), st.floats(0.001, 0.1)), max_size=3),
    lost=st.integers(0, 60),
)
def test_a_level_that_moves_the_structure_far_has_close_neighbours(limit, grows, bands, lost):
    """Below the lowest collapse no gap exceeds CLOSEST (u_max/u)³; the lowest tells as far or is at half of it."""
    trial = Trial(
        (limit, 99.0), *((low, low * (1.0 + width)) for low, width in bands), moves=lambda u: u**grows
    )
    peaks = {}

    def peak(level):
        peaks[level] = math.inf if len(peaks) == lost else trial(level)
        return peaks[level]

    scan_levels(peak, 0.3, Reach(8.0))
    low = min(level for level, u in peaks.items() if u == math.inf)
    standing = {level: u for level, u in peaks.items() if u < math.inf}
    largest, runs = max(standing.values()), sorted(level for level in peaks if level <= low)
    within = [CLOSEST * (largest / standing[each]) ** 3 if each in standing else math.inf for each in runs]
    beside = [each in trial.tried and each * SPACING >= low for each in runs]
    within = [CLOSEST if near else width for near, width in zip(beside, within, strict=True)]
    for one, other, near, far in zip(runs, runs[1:], within, within[1:], strict=False):
        assert math.log(other / one) <= min(near, far) * (1.0 + 1e-6)
    assert runs[0] <= max(0.00106, 0.5 * low) or within[0] >= math.log(1.0 / DOWN) - math.log(RATIO)
    assert len(peaks) <= 250


def largest_ratio(levels):
    levels = sorted(levels)
    return max((b / a for a, b in pairwise(levels)), default=1.0)


@given(
    low=st.floats(0.05, 2.0), width=st.floats(0.06, 0.3), gap=st.floats(0.0, 0.2),
    near=st.one_of(st.none(), st.floats(0.02, 3.0)), ratio=st.sampled_from([1.02, 1.05]),
)  # fmt: skip
def test_a_band_no_more_than_thirty_percent_below_any_collapse_that_is_met_is_found(
    low, width, gap, near, ratio
):
    """Wherever the scan begins: the lowest collapse lies in the lowest band within its first step."""
    top = low * (1.0 + width)
    above = top * (1.0 + gap)
    assume(low < 2.0 and above / low < 1.0 / DOWN)
    trial = Trial((low, top), (above, 99.0))
    seen = trial.seen(near, ratio=ratio)
    assert low <= seen.lowest <= low * ratio * (1.0 + 1e-9)
    below = [level for level in trial.tried if DOWN * seen.lowest / ratio <= level <= seen.lowest]
    assert largest_ratio(below) <= ratio * (1.0 + 1e-9)
    assert min(below) <= DOWN * seen.lowest * ratio
    assert seen.safe < seen.capacity <= seen.lowest
    assert all(not fell for level, fell in trial.tried.items() if level < seen.lowest)


@given(limit=st.floats(0.05, 2.0), near=st.floats(0.02, 3.0))
def test_above_the_highest_level_that_stands_two_in_a_row_collapse(limit, near):
    trial = Trial((limit, 99.0))
    trial.seen(near)
    stands = max(level for level, fell in trial.tried.items() if not fell)
    assert sum(level > stands for level in trial.tried) >= CERTAIN


@given(limit=st.floats(0.1, 2.0), away=st.floats(-0.9, 0.9))
def test_a_scan_that_begins_at_the_collapse_runs_the_levels_around_it_and_no_others(limit, away):
    trial = Trial((limit, 99.0))
    trial.seen(limit * RATIO**away)
    depth = math.ceil(math.log(1.0 / DOWN) / math.log(RATIO))
    assert len(trial.tried) <= depth + 1 + CERTAIN


def test_nothing_falls_up_to_the_largest_level():
    trial = Trial()
    seen = trial.seen(max_scale=4.0)
    assert (seen.safe, seen.lowest, seen.capacity) == (pytest.approx(1.2), None, None)
    assert max(trial.tried) == pytest.approx(1.2)
    band = Trial((0.9, 1.0))
    assert 0.9 <= band.seen(max_scale=4.0).lowest < 0.9 * RATIO  # between two strides of the way up


def test_a_fall_at_any_level_leaves_only_rest():
    seen = Trial((0.0, 99.0)).seen()
    assert seen.safe == 0.0 and seen.lowest <= 0.0011


def test_a_scan_whose_level_lies_below_the_least_one_ends():
    """Levels half-way lie below the bottom of the lattice, and the 16 % level of the probit below them."""
    trial = Trial((0.0, 0.0011), (0.0012, 99.0), moves=lambda level: 1.0)
    assert trial.seen().capacity < min(trial.tried)


def test_the_lowest_bracket_is_halved_to_the_width_asked_for():
    trial = Trial((0.5, 99.0))
    seen = trial.seen(width=0.002)
    below = max(level for level, fell in trial.tried.items() if not fell)
    assert 0.0 < seen.lowest - below <= 0.002


def test_a_narrow_band_just_below_the_lowest_collapse_is_found_where_the_structure_moves_little_too():
    """1.3 % wide, a little below the next: among levels 5 % apart, with a fifth of the most moved, it was missed."""
    for low in np.linspace(0.525, 0.54, 6):
        band = (low, 1.013 * low)
        trial = Trial(band, (0.55, 0.6), (0.72, 9.0), moves=lambda level: 1.0 if level > 0.55 else 0.2)
        assert trial.seen(near=0.9, pga=0.32).lowest < band[1]


def test_a_collapse_half_way_between_levels_is_scanned_below_as_any_other():
    levels = [0.3 * RATIO**place for place in (8.4, 8.6, 9.9)]
    trial = Trial((levels[0], levels[1]), (levels[2], 99.0), moves=lambda level: 1.0)
    seen = trial.seen()
    assert levels[0] < seen.lowest < levels[1] and min(trial.tried) <= DOWN * seen.lowest


def test_probability_in_a_bracket_grows_evenly_in_ln_level():
    seen = observed([0.2, 0.3, 0.4], [False, True, True])
    assert seen.probable == pytest.approx([0.2 * 1.5**p for p in (0.16, 0.5, 0.84)])
    assert seen.capacity == seen.probable[0] and seen.beta == 0.0 and seen.certain == 0.3
    assert seen.gap == (0.2, 0.3)


def test_a_level_is_known_to_its_bracket_and_the_scatter_of_the_collapse():
    """δ/√12 of a bracket of δ in ln, and √(β δ/1.806) beside it."""
    assert Observed(0.2, spacing=0.06).known_to(0.0) == pytest.approx(0.06 / math.sqrt(12.0))
    both = math.sqrt(0.3 * 0.06 / 1.806 + 0.06**2 / 12.0)
    assert Observed(0.2, spacing=0.06).known_to(0.3) == pytest.approx(both, rel=1e-3)


def test_where_collapse_comes_in_bands_the_probit_counts_if_it_is_lower():
    levels = 0.3 * RATIO ** np.arange(20)
    random = np.random.default_rng(4)
    fallen = random.uniform(size=20) < ndtr(np.log(levels / 0.5) / 0.15)
    fallen[-2:] = True
    seen = observed(levels.tolist(), fallen.tolist())
    low, middle, high = seen.probable
    assert middle == pytest.approx(0.5, rel=0.15) and seen.beta == pytest.approx(0.15, rel=0.6)
    assert math.log(high / low) == pytest.approx(1.989 * seen.beta, rel=1e-3)
    assert seen.capacity == min(low, levels[fallen][0]) or seen.capacity < levels[fallen][0]
    assert seen.stands == tuple(levels[~fallen & (levels > levels[fallen][0])])
    assert seen.safe < seen.capacity


# A band between steps: five voussoirs on stiff joints, one sine of half a second


def semicircle():
    """Intrados of radius 2 m, 0.45 m thick."""
    stone = Material(20.0, 0.9, normal_stiffness=5e6)
    angles = np.linspace(0.0, np.pi, 6)
    corner = np.stack([np.outer(np.cos(angles), (2.0, 2.45)), np.outer(np.sin(angles), (2.0, 2.45))], axis=2)
    ring = [
        Block([corner[i, 0], corner[i, 1], corner[i + 1, 1], corner[i + 1, 0]], 1.0, stone) for i in range(5)
    ]
    feet = [
        Block(rectangle(min(x), -0.5, max(x), 0.0), 1.0, stone, support=name)
        for name, x in (("right", (2.0, 2.45)), ("left", (-2.0, -2.45)))
    ]
    return Assembly([*ring, *feet])


def test_the_band_below_the_collapse_that_a_search_would_meet_first_is_found():
    """Steps of 0.16 to 1.25 ms: from 0.505 to 0.54 g, and from 0.58 g on; an explicit code: from 0.50 g."""
    step, model = 0.005, semicircle()
    time = step * np.arange(101)
    record = Record(0.3 * np.sin(4.0 * np.pi * time), step, "sine")
    motion = BaseMotion(record, record, record.pga, 1.0)
    setting = Setting(
        MotionTable(contacts="elastic", damping_ratio=0.05), ControlTable(name="c", point_m=(0.0, 2.3))
    )
    reach, single = Reach(5.0), Scatter(1, 0.05)
    seen = scan(Shaking(model, motion.halved(), setting, model.initial), single, reach, 0.55).seen
    assert 0.50 < seen.lowest < 0.53
    assert seen.capacity < 1.02 * 0.505


def test_levels_of_a_rocking_block_carry_what_their_motions_came_to():
    """A rectangular pulse of 0.5 s, then 2 s of rest."""
    pulse = np.where(np.arange(251) < 50, 0.1, 0.0)
    record = Record(pulse, 0.01, "pulse")
    motion = BaseMotion(record, record, record.pga, 1.0)
    table = MotionTable(contacts="rigid", integrator="second-order")
    model = block_on_base(0.6, 4.2)
    setting = Setting(table, ControlTable(name="top", point_m=(0.3, 4.2)))
    found = scan(Shaking(model, motion, setting, model.initial), Scatter(1, 0.05), Reach(5.0, width=0.005))
    p = math.sqrt(3.0 * 9.80665 / (4.0 * 0.5 * math.hypot(0.6, 4.2)))
    share = 1.0 / (2.0 * (math.cosh(0.5 * p) - 1.0))
    # cosh(p t) = 1 + 1/(2k(k − 1)), k = a/(g α) (slender rigid block); α as its tangent, 5 %
    expected = (1.0 + math.sqrt(1.0 + 4.0 * share)) / 2.0 * 0.6 / 4.2
    seen = found.seen
    assert seen.lowest == pytest.approx(expected, rel=0.05)
    assert found.counts.motions == len(found.points) and found.counts.steps > 0 and found.worst < 1e-6
    assert all((point.peak_displacement_m is None) == point.collapsed for point in found.points)
    assert found.reason is None


def test_a_motion_that_is_not_solved_counts_as_a_collapse_and_is_told(monkeypatch):
    record = Record(np.where(np.arange(251) < 50, 0.1, 0.0), 0.01, "pulse")
    motion, model = BaseMotion(record, record, record.pga, 1.0), block_on_base(0.6, 4.2)
    setting = Setting(MotionTable(contacts="rigid"), ControlTable(name="top", point_m=(0.3, 4.2)))

    def scanned():
        return scan(Shaking(model, motion, setting, model.initial), Scatter(1, 0.05), Reach(5.0))

    whole = scanned()
    lost, true = next(p.pga_g for p in whole.points if p.collapsed is False), scans.respond

    def refused(*of, **how):
        if not lost or of[1] * record.pga == pytest.approx(lost):
            raise ConvergenceError(message("not solved"))
        return true(*of, **how)

    monkeypatch.setattr(scans, "respond", refused)
    found = scanned()
    assert found.reason is None
    others = {p.pga_g: p for p in found.points}
    assert others.pop(lost).collapsed and found.points[0].pga_g < lost
    assert len(others) >= CERTAIN + 5 and all(others.get(p.pga_g, p) == p for p in whole.points)
    [note] = [note for note in found.notes if "not known" in note]
    assert "not solved" in note and "non è noto" in in_italian(note)
    assert found.seen.lowest == lost < whole.seen.lowest

    two = (lost, 1.5 * lost)
    stripes = scan(
        Shaking(model, motion, setting, model.initial), Scatter(1, 0.05), Reach(5.0, stripes=two)
    ).points
    assert (stripes[0].members_collapsed, stripes[0].time_of_collapse_s) == (1, None)

    lost = None  # every motion
    assert "not solved" in scanned().reason


def test_the_band_of_a_fragility_is_that_of_its_samples():
    levels = [RecordLevel(str(k), 0.3 * 1.1**k, False, 0.0) for k in range(7)]
    found = over_records(levels)
    half = next(bounds for p, *bounds in found.band if p == 0.5)
    assert half == found.median_range
    assert [low for _, low, _ in found.band] == sorted(low for _, low, _ in found.band)
    assert not over_records(levels[:2]).band  # two records tell no range
