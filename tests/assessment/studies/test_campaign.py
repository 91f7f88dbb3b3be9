"""Campaigns: fits against closed forms and scipy, record sets, and a small campaign on the rocking block."""

from __future__ import annotations

import math
from contextlib import suppress
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.special import ndtr
from scipy.stats import CensoredData, norm

from assessment.analyses.dynamic.fragility import (
    RecordLevel,
    confidence,
    fit_levels,
    fit_stripes,
    samples_of_records,
)
from assessment.analyses.dynamic.record_set import Measures, Target, compatibility, scaled_to
from assessment.analyses.dynamic.scan import Reach, Scan
from assessment.ntc.spectrum import ElasticSpectrum
from assessment.project.motions import BaseMotion, check_record_set, doubtful_records
from assessment.project.project import load_project
from assessment.project.schema import CampaignTable
from assessment.project.structure.model import build_model
from assessment.results.numbers import plain
from assessment.results.schema.dynamic import CampaignCombination, CampaignFragility, Level
from assessment.runtime.cache import Store
from assessment.runtime.errors import ProjectError
from assessment.runtime.progress import Show
from assessment.studies.campaign import stage
from assessment.studies.campaign.scans import Asked, Scans
from assessment.studies.campaign.stage import doubts
from assessment.studies.campaign.summary import loss_of, standard_of
from assessment.workflow.stages import run as workflow
from mechanics.records.record import Record
from tests.support.block_project import edit, read_results, run, timeless
from tests.support.campaign_project import SEARCHES, write_campaign
from tests.support.typed import made
from tests.support.wording import in_italian


def whole(count):
    return np.ones((1, count))


def test_levels_give_mean_and_root_mean_square_of_their_logarithms():
    levels = np.array([0.21, 0.34, 0.30, 0.55])
    fit = fit_levels(levels, np.zeros(4, bool), whole(4))
    assert fit.median[0] == pytest.approx(math.exp(np.log(levels).mean()))
    assert fit.beta[0] == pytest.approx(np.log(levels).std())


def test_what_withstood_is_a_lower_bound_as_scipy_has_it():
    levels, withstood = np.array([0.21, 0.34, 0.30, 0.55, 0.6, 0.4]), np.array([0, 0, 0, 0, 1, 1], bool)
    fit = fit_levels(levels, withstood, whole(6))
    mean, beta = norm.fit(CensoredData(np.log(levels[~withstood]), right=np.log(levels[withstood])))
    assert fit.median[0] == pytest.approx(math.exp(mean), rel=1e-4)
    assert fit.beta[0] == pytest.approx(beta, rel=1e-3)


def test_equal_levels_beside_lower_bounds_are_a_distribution_all_the_same():
    """Two collapse at one level: the two that withstand three times of it widen it; half of it would not."""
    levels, withstood = np.array([0.9, 0.9, 2.6, 2.6]), np.array([0, 0, 1, 1], bool)
    fit = fit_levels(levels, withstood, whole(4))

    def minus_likelihood(x):
        return -2.0 * (
            norm.logpdf(math.log(0.9), x[0], math.exp(x[1])) + norm.logsf(math.log(2.6), x[0], math.exp(x[1]))
        )

    expected = minimize(
        minus_likelihood, (0.5, -0.5), method="Nelder-Mead", options={"xatol": 1e-8, "fatol": 1e-12}
    ).x
    assert fit.median[0] == pytest.approx(math.exp(expected[0]), rel=1e-4)
    assert fit.beta[0] == pytest.approx(math.exp(expected[1]), rel=1e-4)
    low = fit_levels(np.array([0.9, 0.9, 0.45]), np.array([0, 0, 1], bool), whole(3))
    assert low.median[0] == pytest.approx(0.9) and low.beta[0] == 0.0


def test_a_weight_counts_an_observation_as_often():
    levels, withstood = np.array([0.2, 0.3, 0.5]), np.array([False, False, True])
    twice = fit_levels(levels, withstood, np.array([[2.0, 1.0, 1.0]]))
    again = fit_levels(np.append(levels, 0.2), np.append(withstood, False), whole(4))
    assert twice.median == pytest.approx(again.median) and twice.beta == pytest.approx(again.beta)


@pytest.fixture
def stripes():
    """Of 10 records 0, 2, 3, 7, 9 collapse at five levels."""
    levels = np.array([0.1, 0.2, 0.3, 0.4, 0.5])
    return levels, np.array([[k < fallen for fallen in (0, 2, 3, 7, 9)] for k in range(10)])


def test_stripes_maximise_the_binomial_likelihood(stripes):
    levels, collapsed = stripes
    share = collapsed.mean(axis=0)

    def minus_likelihood(x):
        p = ndtr(np.log(levels / math.exp(x[0])) / math.exp(x[1]))
        return -10.0 * np.sum(share * np.log(p) + (1.0 - share) * np.log1p(-p))

    best = minimize(minus_likelihood, [math.log(0.3), math.log(0.4)], method="Nelder-Mead",
                    options={"xatol": 1e-9, "fatol": 1e-12})  # fmt: skip
    fit = fit_stripes(levels, collapsed, whole(10))
    assert (fit.median[0], fit.beta[0]) == pytest.approx(np.exp(best.x), rel=1e-5)


def test_stripes_that_a_level_parts_have_no_dispersion_and_those_without_collapse_no_median():
    levels = np.array([0.1, 0.2, 0.4])
    outcomes = np.array([[0, 0, 1], [0, 0, 0], [1, 1, 1], [1, 0, 0]], bool)
    fit = fit_stripes(levels, outcomes, np.eye(4))
    assert fit.median[0] == pytest.approx(math.sqrt(0.08)) and fit.beta[0] == 0.0
    assert fit.median[1] == math.inf and fit.median[2] == 0.0
    assert math.isnan(fit.median[3])


def _fitted(levels, fell, of):
    """The fit of stripes of `of` records, so many of which collapse at each level."""
    collapsed = np.arange(of)[:, None] < np.array(fell)
    fit = fit_stripes(np.array(levels), collapsed, whole(of))
    return fit.median[0], fit.beta[0]


def test_stripes_of_any_levels_maximise_the_likelihood():
    """The reference is scipy.optimize.minimize on the likelihood, from several starts; where it has a maximum."""
    random, compared = np.random.default_rng(0), 0
    while compared < 60:
        levels = np.sort(np.exp(random.uniform(math.log(0.05), math.log(1.5), random.integers(2, 8))))
        of = int(random.integers(4, 22))
        capacity = np.exp(random.normal(math.log(0.35), random.uniform(0.05, 0.6), of))
        fell = (capacity[:, None] <= levels).sum(axis=0)
        if not ((fell > 0) & (fell < of)).sum() > 1 or len(set(fell)) == 1:
            continue

        x = np.log(levels)

        def minus_likelihood(c, x=x, fell=fell, of=of):
            z = (x - c[0]) / math.exp(c[1])
            return -(fell * norm.logcdf(z) + (of - fell) * norm.logcdf(-z)).sum()

        best = min(
            (
                minimize(minus_likelihood, [math.log(start), math.log(spread)], method="Nelder-Mead",
                         options={"xatol": 1e-9, "fatol": 1e-13, "maxiter": 4000})
                for start in (0.1, 0.35, 1.0)
                for spread in (0.1, 0.4)
            ),
            key=lambda found: found.fun,
        )  # fmt: skip
        median, beta = _fitted(levels, fell, of)
        assert minus_likelihood([math.log(median), math.log(beta)]) <= best.fun + 1e-9
        assert (median, beta) == pytest.approx(np.exp(best.x), rel=1e-4)
        compared += 1


def test_two_partial_stripes_close_together_by_hand():
    """2 and 4 of 15 collapse at 0.331 and 0.333 g; the other levels are too far away to tell.

    β = ln(0.333/0.331)/(Φ⁻¹(4/15) − Φ⁻¹(2/15)) = 0.0060241/(−0.622926 + 1.110772) = 0.0123484,
    median = 0.333 exp(0.622926 β) = 0.3355714 g.
    """
    levels, fell = [0.067, 0.188, 0.331, 0.333, 0.653, 0.668, 0.838], [0, 0, 2, 4, 15, 15, 15]
    assert _fitted(levels, fell, 15) == (
        pytest.approx(0.3355714, rel=1e-6),
        pytest.approx(0.0123484, rel=1e-5),
    )


@pytest.mark.parametrize(
    ("levels", "fell", "of", "median"),
    [
        ([0.087, 0.237, 0.434, 1.474], [0, 0, 15, 19], 19, 0.434),
        ([0.074, 0.273, 0.334], [0, 0, 2], 17, 0.334),
        ([0.572, 1.112, 1.233], [19, 20, 20], 20, 0.572),
        ([0.2, 1.19, 1.2], [0, 0, 4], 6, 1.2),
        ([0.2, 0.4], [0, 6], 6, math.sqrt(0.08)),
    ],
)
def test_stripes_without_a_maximum_have_the_limit_of_ever_steeper_distributions(levels, fell, of, median):
    """One partial level x: with ln median = ln x − β z, Φ(z) the share at it, the likelihood grows as β falls.

    It has no maximum: p is 0 below, the share there and 1 above only for β → 0, when the median becomes x.
    """
    assert _fitted(levels, fell, of) == (pytest.approx(median, rel=1e-15), 0.0)
    k = next((k for k, count in enumerate(fell) if 0 < count < of), None)
    if k is None:
        return
    x, share = np.log(levels), np.array(fell) / of
    gained = []
    for beta in (0.2, 0.1, 0.05, 0.0005):
        z = (x - x[k]) / beta + norm.ppf(share[k])
        with np.errstate(all="ignore"):
            logs = np.where(share > 0, share * norm.logcdf(z), 0.0)
            logs += np.where(share < 1, (1 - share) * norm.logcdf(-z), 0.0)
        gained.append(logs.sum())
    highest = share[k] * math.log(share[k]) + (1 - share[k]) * math.log(1 - share[k])
    assert gained == sorted(gained) and gained[-1] == pytest.approx(highest, abs=1e-9)


@pytest.mark.parametrize(
    ("levels", "fell"),
    [([0.3], [5]), ([0.1, 0.2, 0.4], [3, 3, 3]), ([0.1, 0.2, 0.4], [5, 3, 1]), ([0.1, 0.2, 0.4], [1, 0, 0])],
    ids=["one level", "as many at each", "fewer above", "below alone"],
)
def test_stripes_whose_collapses_do_not_grow_have_no_median(levels, fell):
    assert all(math.isnan(value) for value in _fitted(levels, fell, 10))


def test_a_median_beyond_all_numbers_is_none():
    """22, 28, 25 of 28: 25 in the mean at the two lowest levels, which are nearly one, and 25 at the highest."""
    assert all(math.isnan(value) for value in _fitted([0.07801843, 0.07801913, 1.22054528], [22, 28, 25], 28))


def test_stripes_without_dispersion_are_warned_of():
    told = {"combinations": 2, "failed": 0, "withstood": 0}
    [warning] = doubts(made(CampaignFragility, told | {"median_g": 0.4, "beta": 0.0}), True)
    assert "a median acceleration of 0.4 g" in warning and "dispersione" in in_italian(warning)
    assert not list(doubts(made(CampaignFragility, told | {"median_g": 0.4, "beta": 0.2}), True))


def test_the_bootstrap_keeps_the_signs_of_a_record_together_and_is_the_same_at_every_run():
    record = np.array([0, 0, 1, 1, 2, 2])
    samples = samples_of_records(record)
    assert (samples[:, ::2] == samples[:, 1::2]).all() and (samples.sum(axis=1) == 6.0).all()
    assert (samples == samples_of_records(record)).all()


def test_the_bootstrap_covers_the_median_as_often_as_it_says():
    """Of 200 sets of 30 records the 95 % bounds hold the true median in 88-99 %."""
    random = np.random.default_rng(1)
    inside = 0
    for _ in range(200):
        levels = 0.3 * np.exp(0.4 * random.standard_normal(30))
        samples = samples_of_records(np.arange(30))
        low, high = confidence(fit_levels(levels, np.zeros(30, bool), samples).median)
        inside += low < 0.3 < high
    assert 176 <= inside <= 198


def test_lower_bounds_and_a_missing_median_are_warned_of():
    stand = {"combinations": 2, "failed": 0, "withstood": 2, "median_g": None}
    [bounds, none] = doubts(made(CampaignFragility, stand), False)
    assert "2 of 2 combinations do not collapse" in bounds and "no median of collapse" in none
    [bounds] = doubts(made(CampaignFragility, stand | {"combinations": 3, "median_g": 0.5}), False)
    assert "2 of 3 combinations" in bounds
    assert not list(doubts(made(CampaignFragility, stand | {"withstood": 0, "median_g": 0.5}), False))
    for warning in (bounds, none):
        assert "combinazioni" in in_italian(warning) or "mediana" in in_italian(warning)


def row(record, collapse, safe=0.1, sign=1, reason=None):
    levels = {"pga_collapse_g": collapse, "pga_safe_g": safe, "sign": sign, "reason": reason}
    return made(CampaignCombination, levels | {"record": record})


def test_the_standard_takes_the_worse_sign_the_lowest_of_three_and_the_mean_of_seven():
    levels = [0.30, 0.36, 0.42, 0.33, 0.39, 0.35, 0.37]
    both = [row(f"{k}", level + extra, sign=sign) for k, level in enumerate(levels)
            for sign, extra in ((1, 0.0), (-1, 0.1))]  # fmt: skip
    three, seven = (standard_of(both[: 2 * count]) for count in (3, 7))
    assert (three.rule, three.pga) == ("lowest", 0.30)
    assert (seven.rule, seven.pga) == ("mean", pytest.approx(np.mean(levels)))
    failed = [*both[:6], row("d", None, safe=None, reason="not solved")]
    assert standard_of(failed).pga is None


class Levels:
    """Combinations of two states and their scans, made up: each record's lowest collapse, None: it stands."""

    def __init__(self, before, after):
        self.scans, self.combinations = Scans(None, None), []
        self.before, self.after = (SimpleNamespace(settlement="s", share=share, movement=0.02 * share,
                                                   static=0.5 - 0.1 * share) for share in (0.0, 1.0))  # fmt: skip
        for state, levels in ((self.before, before), (self.after, after)):
            for record, level in levels.items():
                shaking = SimpleNamespace(start=None, motion=SimpleNamespace(name=record))
                asked = Asked(shaking, 1, 1, Reach(5.0), state=state)
                asked.__dict__["key"] = f"{record} {state.share}"
                self.combinations.append(asked)
                runs = [(0.9, False)] if level is None else [(0.998 * level, False), (1.002 * level, True)]
                points = [made(Level, {"pga_g": pga, "collapsed": fell}) for pga, fell in runs]
                self.scans.found[asked.key] = {0: Scan(points)}

    def loss(self, beta=0.0):
        return loss_of(self.after, self.before, self.combinations, self.scans, beta, {})


def test_losses_are_those_of_each_record_by_itself():
    before = {"a": 0.2, "b": 0.4, "c": 0.8}
    found = Levels(before, {"a": 0.1, "b": 0.36, "c": 0.6}).loss()
    assert found.dynamic == pytest.approx(0.25, rel=1e-3) and found.static == pytest.approx(0.2)
    low, high = found.dynamic_range
    assert 0.09 < low < 0.12 and 0.45 < high < 0.52 and found.distinguishable is True
    stood = Levels(before, {"a": 0.1, "b": None, "c": 0.6}).loss()
    assert stood.dynamic == pytest.approx(0.25, rel=1e-3) and stood.dynamic_range[0] is None
    assert Levels({"a": None, "b": 0.4}, {"a": 0.1, "b": 0.3}).loss().left_out == 1


def test_a_loss_smaller_than_its_levels_are_known_to_is_not_distinguishable_from_none():
    """Levels of 15 records lose 2 %: with brackets alone that is seen, with a scatter of 30 % within them it is not."""
    random = np.random.default_rng(2)
    before = {f"{k}": 0.3 * math.exp(0.3 * random.standard_normal()) for k in range(15)}
    levels = Levels(before, {name: 0.98 * level for name, level in before.items()})
    assert levels.loss().distinguishable is True
    unsure = levels.loss(beta=30.0)
    low, high = unsure.dynamic_range
    assert unsure.distinguishable is False and low < 0.0 < high
    assert unsure.dynamic == pytest.approx(0.02, abs=1e-3)


def test_the_measure_that_collapse_follows_has_the_least_dispersion():
    """Sines of 0.25 to 1 s that collapse at one peak velocity: β of PGV is none, that of PGA is not."""
    motions, levels = [], []
    for period in (0.25, 0.5, 1.0):
        time = 0.005 * np.arange(1001)
        motions.append(motion(f"{period}", 0.3 * np.sin(2.0 * np.pi * time / period), 0.005))
        levels.append(RecordLevel(f"{period}", 0.2 / period, False, 0.0))
    measures = Measures.of(SimpleNamespace(campaign=None), motions)
    found = {each.measure: each for each in measures.fits(levels)}
    assert found["PGV"].beta < 0.02 < 0.5 < found["PGA"].beta
    assert found["PGV"].median == pytest.approx(2.0 * 0.2 * 9.80665 / (2.0 * math.pi), rel=0.02)
    assert found["Sa(T)"].period_s == 1.0


def motion(name, acceleration, step=0.01):
    record = Record(np.asarray(acceleration), step, name)
    return BaseMotion(record, record, record.pga, 1.0)


def noise(seed, peak=0.3, count=1000):
    a = np.random.default_rng(seed).standard_normal(count) * np.sin(np.linspace(0.0, math.pi, count)) ** 2
    return peak * a / abs(a).max()


@pytest.fixture
def block(tmp_path, no_figures):
    return write_campaign(tmp_path / "block", SEARCHES, 3)


def test_a_set_with_one_motion_twice_is_refused_scaled_and_turned_too(block):
    project = load_project(block)
    other = motion("b", noise(2))
    with pytest.raises(ProjectError, match="same motion"):
        check_record_set(project, [motion("a", noise(1)), other, motion("c", -0.5 * noise(1))])
    with pytest.raises(ProjectError, match=r'campaign\.records: two records are called "a"'):
        check_record_set(project, [motion("a", noise(1)), motion("a", noise(2))])
    check_record_set(project, [motion("a", noise(1)), other])


def test_doubtful_records_are_warned_of():
    assert doubtful_records([motion("a", noise(1))]) == []
    for text, doubtful in (
        ("unit", motion("a", noise(1, 3.0))),
        ("lasts", motion("a", noise(1, count=300))),
        ("begins or ends", motion("a", noise(1)[450:960])),
    ):
        [said] = doubtful_records([doubtful])
        assert text in said and said.startswith("campaign, a: ")


def test_records_are_scaled_to_the_spectrum_within_limits():
    target = Target("SLC", ElasticSpectrum(0.3, 2.4, 0.36, "B", "T1", 0.05))
    table = CampaignTable(records=("r",), spectrum_compatible=True, scale_limits=(0.5, 20.0))
    one = scaled_to(target, [motion("a", noise(1))], table)
    weak, strong = scaled_to(target, [motion("a", 0.8 * noise(1)), motion("b", 1e-3 * noise(1))], table)
    assert weak.pga == pytest.approx(one[0].pga) and weak.notes == ()
    assert strong.scale == 20.0 and "scale_limits = [0.5, 20]" in strong.notes[0]
    found = compatibility(target, one, table)
    assert found.lowest_deviation < 0.0 < found.highest_deviation


def test_a_small_campaign(tmp_path, request):
    """Its first run draws figures, the second does not."""
    block = write_campaign(tmp_path / "block", SEARCHES, 3)
    assert run(block) == 0
    assert (block / "output" / "figures" / "campaign_loss.svg").is_file()
    request.getfixturevalue("no_figures")
    found = read_results(block / "output")["campaign"]
    rows = found["combinations"]
    assert [(row["record"], row["share"], row["sign"]) for row in rows] == [
        (f"wave{k}", share, 1) for share in (0.0, 1.0) for k in (1, 2, 3)
    ]
    for row in rows:
        safe, collapse, lowest = row["pga_safe_g"], row["pga_collapse_g"], row["lowest_collapse_g"]
        assert 0.0 < collapse - safe <= 0.05 * collapse and row["pga_collapse_range"][0] == collapse
        fallen = {point["pga_g"]: point["collapsed"] for point in row["points"]}
        assert fallen[lowest] and not fallen[safe] and row["runs"] == row["counts"]["motions"] == len(fallen)
    original, settled = found["fragility"]
    assert original["median_g"] == pytest.approx(
        math.exp(np.mean([math.log(row["level_50_g"]) for row in rows[:3]]))
    )
    assert settled["rule"] == "lowest"
    assert settled["pga_collapse_g"] == min(row["pga_collapse_g"] for row in rows[3:])
    at_rest, lost = found["loss"]
    assert at_rest["dynamic"] == at_rest["static"] == 0.0
    pairs = sorted(1.0 - b["level_50_g"] / a["level_50_g"] for a, b in zip(rows[:3], rows[3:], strict=True))
    assert lost["dynamic"] == pytest.approx(pairs[1]) and 0.0 < lost["static"] < 0.3
    _static_of_the_checks(read_results(block / "output"))
    before = timeless(read_results(block / "output"))
    assert run(block, "--jobs", "2", "--fresh") == 0
    assert timeless(read_results(block / "output")) == before


def _static_of_the_checks(results):
    """One static capacity a state: S a_g of its check; the shape of the spectrum and its S are kept, and cancel."""
    states, loss = results["states"].values(), results["campaign"]["loss"]
    checks = [state["capacity"]["+x"]["SLV"] for state in states]
    assert checks[0]["S"] == checks[1]["S"] == checks[0]["demand_S"] > 1.0
    assert [row["static_capacity"] for row in loss] == [check["pga_g"] for check in checks]
    assert loss[1]["static"] == pytest.approx(results["comparison"][0]["static_reduction"], rel=1e-12)


def test_a_scan_begins_where_its_neighbour_ends_and_levels_do_not_depend_on_what_is_finished(block):
    edit(block, 'records = ["wave*.csv"]', 'records = ["wave[12].csv"]')
    edit(block, "shares = [0.0, 1.0]", "shares = [0.0, 0.5, 1.0]")
    edit(block, "scatter = 2", "scatter = 1")
    project = load_project(block)
    model = build_model(project)
    whole = workflow(project, model, jobs=2)
    shows = [Stopping(after) for after in (1, 2, 6)]
    for show in shows:  # stopped twice, then run to its end, in one process
        with suppress(KeyboardInterrupt):
            again = workflow(project, model, jobs=1, store=Store(block / "kept"), show=show)
    assert again.complete and sum(show.finished for show in shows) == whole.computed
    assert timeless(plain(again.results)) == timeless(plain(whole.results))
    rows = plain(whole.results)["campaign"]["combinations"]
    # eight levels down to 0.7 of the lowest, two above, and what is passed on the way from the neighbour's
    assert all(row["runs"] <= 16 for row in rows[2:])


class Stopping(Show):
    """Interrupts a campaign of six combinations before so many are finished; counts all that is `finished`."""

    def __init__(self, after):
        self.left, self.searches, self.finished = after, False, 0

    def begin(self, stage, total, taken, work):
        self.searches = (stage, total) == ("campaign", 6)

    def advance(self, done):
        self.finished += 1
        self.left -= self.searches
        if self.left < 0:
            raise KeyboardInterrupt


def test_curves_are_kept_of_the_members_asked_for_and_change_nothing_else(block):
    edit(block, 'records = ["wave*.csv"]', 'records = ["wave1.csv"]')
    edit(block, "tolerance = 0.2\n", 'method = "stripes"\nlevels_g = [0.1, 0.3]\n')
    assert run(block, "--only", "campaign") == 0
    without = timeless(read_results(block / "output"))
    edit(block, "signs = [1]", "signs = [1]\ncurve_members = [2]\nwindow_s = [0.1, 1.1]")
    assert run(block, "--only", "campaign") == 0
    late = read_results(block / "output")["campaign"]["combinations"][0]["points"]
    assert all(curve["time_s"][0] == 0.1 for point in late for curve in point["curves"])
    edit(block, "curve_members = [2]\nwindow_s = [0.1, 1.1]", "curve_members = [2, 1]")
    assert run(block, "--only", "campaign") == 0
    found = timeless(read_results(block / "output"))
    for row in found["campaign"]["combinations"]:
        for point in row["points"]:
            curves = point.pop("curves")
            members = [(curve["member"], curve["factor"]) for curve in curves]
            assert members == [(1, 1.0), (2, 0.99)][: point["members"]]
            assert all(len(curve["time_s"]) == len(curve["displacement_m"]) <= 400 for curve in curves)
            if not point["collapsed"]:
                peaks = [max(map(abs, curve["displacement_m"])) for curve in curves]
                assert [min(peaks), max(peaks)] == pytest.approx(point["peak_displacement_m_range"], abs=1e-7)
    assert found["campaign"] == without["campaign"]


def test_stripes_by_spectral_acceleration(block):
    stripes = 'method = "stripes"\nlevels_g = [0.1, 0.2, 0.4]\nmeasure = "Sa(T)"\nperiod_s = 0.5\n'
    edit(block, "tolerance = 0.2\n", stripes)
    assert run(block, "--only", "campaign") == 0
    results = read_results(block / "output")
    found = results["campaign"]
    for row in found["combinations"]:
        record = next(each for each in found["records"] if each["record"] == row["record"])
        ratio = record["sa_g"] / record["record_pga_g"]
        assert [point["pga_g"] * ratio for point in row["points"]] == pytest.approx([0.1, 0.2, 0.4])
        assert len(row["collapsed"]) == 3
    assert all(row["rule"] is None for row in found["fragility"])
    assert found["loss"][1]["static"] is not None  # the static check comes with it


def test_the_static_loss_beside_rigid_motions_is_that_of_rigid_joints(block):
    """On soft joints the block loses more: that is another structure's loss."""
    edit(block, 'records = ["wave*.csv"]', 'records = ["wave1.csv"]')
    edit(block, "tolerance = 0.2\n", 'method = "stripes"\nlevels_g = [0.1]\n')
    edit(block, "normal_stiffness_kN_m3 = 1e6", "normal_stiffness_kN_m3 = 2e4")
    losses = []
    for soft in (False, True):
        if soft:
            edit(block, 'contacts = ["rigid"]', 'contacts = ["rigid", "elastic"]')
            edit(block, 'model = "none"', 'model = "trilinear"')
        assert run(block, "--only", "campaign") == 0
        losses.append(read_results(block / "output")["campaign"]["loss"])
    rigid, beside = losses
    assert beside[1]["static"] == pytest.approx(rigid[1]["static"], rel=1e-12)
    assert beside[1]["static_capacity"] == pytest.approx(rigid[1]["static_capacity"], rel=1e-12)


def test_equal_states_are_computed_once(block):
    edit(
        block,
        "[campaign]",
        '[[settlements]]\nname = "other"\nsupport = "base"\nrotation_rad = -0.01\n[campaign]',
    )
    edit(block, 'records = ["wave*.csv"]', 'records = ["wave1.csv"]')
    edit(block, "shares = [0.0, 1.0]", "shares = [0.0]")
    assert run(block, "--only", "campaign") == 0
    results = read_results(block / "output")
    one, other = results["campaign"]["combinations"]
    assert other["same_as"] == {"settlement": "base turned", "share": 0.0, "sign": 1}
    assert other["pga_collapse_g"] == one["pga_collapse_g"] and results["campaign"]["computed"] == 1
    assert any("1 of 2 combinations are the same" in text for text in results["quality"]["warnings"])


def test_losses_that_are_not_told_are_told_why(block):
    """They were null without a word."""
    edit(block, 'records = ["wave*.csv"]', 'records = ["wave1.csv"]')
    edit(block, "shares = [0.0, 1.0]", "shares = [1.0]")
    assert run(block, "--only", "campaign") == 0
    found = read_results(block / "output")
    assert found["campaign"]["loss"][0]["dynamic"] is None
    assert any("add 0.0 to shares" in text for text in found["quality"]["warnings"])


def test_both_signs_of_a_structure_that_is_its_own_mirror_image_are_one_run(block):
    """As drawn; the block whose base has turned is none. What is not run is what it would have been."""
    edit(block, "point_m = [0.3, 4.2]", "point_m = [0.0, 4.2]")
    edit(block, 'records = ["wave*.csv"]', 'records = ["wave1.csv"]')
    edit(block, "signs = [1]", "signs = [1, -1]")
    assert run(block, "--only", "campaign") == 0
    found = read_results(block / "output")["campaign"]
    one, image, settled, other = found["combinations"]
    assert found["computed"] == 3 and image["same_as"] == {
        "settlement": "base turned",
        "share": 0.0,
        "sign": 1,
    }
    assert image["pga_collapse_g"] == one["pga_collapse_g"] and not {"same_as"} & {*settled, *other}
    edit(block, "signs = [1, -1]", "signs = [-1]")
    edit(block, "shares = [0.0, 1.0]", "shares = [0.0]")
    assert run(block, "--only", "campaign") == 0
    [alone] = read_results(block / "output")["campaign"]["combinations"]
    assert alone["pga_collapse_g"] == pytest.approx(image["pga_collapse_g"]) and alone["runs"] == one["runs"]


def test_a_control_point_beside_the_axis_leaves_both_signs_to_be_run(block):
    edit(block, 'records = ["wave*.csv"]', 'records = ["wave1.csv"]')
    edit(block, "signs = [1]", "signs = [1, -1]")
    edit(block, "shares = [0.0, 1.0]", "shares = [0.0]")
    assert run(block, "--only", "campaign") == 0
    assert read_results(block / "output")["campaign"]["computed"] == 2


def made_record(spectrum, seed) -> Record:
    """A record in the place of one made to the spectrum, which takes seconds: as strong."""
    return Record(noise(seed, spectrum.ag, count=600), 0.01, f"generated {seed}")


def test_records_are_made_to_the_spectrum_of_the_site(block, monkeypatch):
    monkeypatch.setattr(stage, "made_record", made_record)
    edit(block, 'records = ["wave*.csv"]', 'records = "generate:3"')
    edit(block, "tolerance = 0.2", 'method = "stripes"\nlevels_g = [0.01]\nspectrum_compatible = true')
    assert run(block, "--only", "campaign", "--jobs", "1") == 0
    found = read_results(block / "output")["campaign"]
    assert [each["record"] for each in found["records"]] == ["generated 1", "generated 2", "generated 3"]
    spectrum = found["spectrum"]
    deviation = np.array(spectrum["mean_g"]) / np.array(spectrum["target_g"]) - 1.0
    assert spectrum["limit_state"] == "SLV"  # the farthest of the project
    assert spectrum["lowest_deviation"] == pytest.approx(deviation.min())
    assert not any(row["collapsed"][0] for row in found["combinations"])
    assert all(row["median_g"] is None for row in found["fragility"])  # nothing fell


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ('records = ["wave*.csv"]', 'records = "generate:0"', 'campaign.records: "generate:0" is no number'),
        ('records = ["wave*.csv"]', 'records = ["wave4.csv"]', "campaign.records[1]: no file"),
        ("signs = [1]", 'settlements = ["base turnt"]', 'did you mean "base turned"'),
        ("signs = [1]", 'measure = "Sa(T)"', "campaign.period_s: missing"),
        ("signs = [1]", 'method = "stripes"', "campaign.levels_g: missing"),
        ("signs = [1]", "levels_g = [0.1]", "campaign.levels_g"),
        ("signs = [1]", "scale_limits = [2.0, 0.5]", "campaign.scale_limits: [2, 0.5] is no range; write"),
        ("signs = [1]", "periods_s = [2.0, 0.5]", "campaign.periods_s: [2, 0.5] is no range; write"),
        (
            "shares = [0.0, 1.0]",
            "shares = [0.0, 1e-6, 1.0]",
            "campaign.shares[2]: 1e-06 of the movement moves",
        ),
        ("shares = [0.0, 1.0]", "shares = [1.0, 0.0]", "campaign.shares: not in order"),
        ("signs = [1]", "signs = [2]", "campaign.signs[1]"),
        (
            "signs = [1]",
            "curve_members = [1, 3]",
            "campaign.curve_members[2]: 3: scatter = 2 runs no such member",
        ),
        ("signs = [1]", "curve_members = [0]", "campaign.curve_members[1]"),
    ],
)
def test_wrong_input_is_refused_by_key(block, capsys, old, new, text):
    edit(block, old, new)
    assert run(block) == 2
    assert text in capsys.readouterr().err


@pytest.mark.parametrize(
    ("levels", "halvings"),
    [
        ([(0.58, 0.507, 0.507)], 1),
        ([(0.58, 0.54, 0.50)], 2),
        ([(0.5, 0.51, 0.5), (0.52, 0.49, 0.5)], 0),
        ([(0.55, 0.5, 0.5), (0.46, 0.5, 0.5)], 0),  # by chance this way and that
        ([(None, None, None)], 0),
        ([(0.5,)], 0),
    ],
)
def test_the_time_step_is_halved_as_often_as_the_mean_of_the_levels_needs(levels, halvings):
    scans, asked = Scans(SimpleNamespace(accuracy="standard"), None), []
    for k, by_step in enumerate(levels):
        asked.append(Asked(SimpleNamespace(start=None), 1, 1, Reach(5.0)))
        asked[-1].__dict__["key"] = str(k)
        scans.found[str(k)] = {
            n: Scan([made(Level, {"pga_g": level or 0.9, "collapsed": level is not None})])
            for n, level in enumerate(by_step)
        }
    assert scans.needed(asked)[0] == halvings
