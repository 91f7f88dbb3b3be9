"""The benchmark command; that skipping changes no answer; and what does not depend on the clock."""

from __future__ import annotations

import csv
import sys
from collections import Counter
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from assessment.benchmark import command, table
from assessment.benchmark.cases import (
    campaigns,
    chain,
    dynamics,
    ensembles,
    skips,
    sliding,
    statics,
    steps,
    walls,
)
from assessment.benchmark.cases.dynamics import Case, pulse, rocking_freely, sine, stack, swinging_column
from assessment.benchmark.command import BENCHMARKS, Benchmark
from assessment.benchmark.measure import history_programs, path_programs
from assessment.cli import arguments, exit_codes
from assessment.cli.main import main
from assessment.runtime.tasks import Workers
from assessment.studies.campaign.search import Combination, Judged
from mechanics import ConvergenceError, pushover, time_history
from mechanics.procedures import step_control
from mechanics.procedures import time_history as histories
from mechanics.procedures.time_history import HistoryTolerances
from mechanics.program import certify
from mechanics.solvers import qp_piqp
from mechanics.steps.dynamic_system import DynamicSystem
from tests.support.structures import block_on_base

EXACT = [skip for skip in skips.all_skips() if np.isfinite(skip.tolerance)]


@pytest.mark.parametrize("skip", EXACT, ids=lambda skip: skip.name)
def test_the_answer_is_the_same_with_and_without(skip):
    if skip.name == "a stage whose inputs have not changed":
        skip.done()
    answer, count = skip.done()
    whole, count_without = skip.without()
    assert skips.difference(answer, whole) <= skip.tolerance
    assert count < count_without


def test_a_window_of_a_rocking_block_is_no_exact_skip():
    """Nothing cuts a record unasked: what rocks is sensitive to its weak parts too."""
    (skip,) = (skip for skip in skips.all_skips() if not np.isfinite(skip.tolerance))
    assert skips.difference(skip.done()[0], skip.without()[0]) > 0.01


def test_a_looser_tolerance_solves_less():
    """The tolerance that the benchmark varies is the one that the solver keeps."""
    block, record = block_on_base(0.6, 4.2), 0.3 * pulse(1.0, 0.2)(0.005 * np.arange(60))
    worst = [
        time_history(block, record, 0.005, "elastic", tolerances=HistoryTolerances(accepted=each)).worst
        for each in (1e-3, 1e-7)
    ]
    assert worst[1] <= 1e-7 < worst[0] <= 1e-3


def test_a_step_is_timed_in_blocks_without_the_state_at_rest(monkeypatch):
    """By a clock that only these parts of a history move: 100 s for its state at rest, 1 s for each of 46 steps."""
    clock = SimpleNamespace(now=0.0)
    settled, march = histories._settled, DynamicSystem.march

    def slowly(*arguments):
        clock.now += 100.0
        return settled(*arguments)

    def step_by_step(system, motion, base, step):
        clock.now += len(base) - 1.0
        return march(system, motion, base, step)

    monkeypatch.setattr(histories, "_settled", slowly)
    monkeypatch.setattr(DynamicSystem, "march", step_by_step)
    monkeypatch.setattr(steps, "time", SimpleNamespace(perf_counter=lambda: clock.now))
    model = block_on_base(0.6, 4.2, stiffness=1e6)
    blocks = steps._blocks(partial(time_history, model, np.zeros(47), 0.005, "elastic"))
    assert blocks[:, 0].tolist() == [20.0, 20.0, 6.0, 0.0] and not blocks[:, 1].any()


def test_the_baseline_solves_the_steps_of_the_motion():
    """From its states implicit Euler's program leads to its next states, by another solver."""
    record = 0.3 * pulse(1.0, 0.2)(0.005 * np.arange(61))
    model = block_on_base(0.6, 4.2, friction=0.1)  # it slides
    motion = time_history(model, record, 0.005, "elastic", integrator="implicit-euler")
    programs = history_programs(model, "elastic", motion, record, 10)
    assert len(programs) == 6
    for k, program in enumerate(programs):
        forces, alpha, moved = qp_piqp.solve(program, 1e-11)
        assert certify(program, forces, alpha, moved).equilibrium < 1e-6
        expected = (motion.positions[10 * k + 1] - motion.positions[10 * k])[1]
        assert moved == pytest.approx(
            expected, abs=1e-2 * abs(motion.positions[-1] - motion.positions[0]).max()
        )


def test_the_baseline_solves_the_steps_of_a_curve():
    curve = pushover(block_on_base(), (0.2, 1.0), increment=0.02)
    for program, step in zip(path_programs(curve), curve.steps[1:], strict=True):
        _, alpha, _ = qp_piqp.solve(program, 1e-10)
        assert alpha == pytest.approx(
            step.alpha, abs=0.03
        )  # of a step's length, in the geometry that it begins in


def test_peak_memory_of_limit_analysis():
    """Python and its libraries take 190 MB of it; dense matrices of this wall would take 500 MB more."""
    row = walls.apart(*walls.WALLS[300])
    assert row.memory_MB < 260.0
    assert row.error < 1e-8


def test_errors_of_the_rocking_block_are_those_of_closed_forms():
    case = statics.rocking_rigid()
    curve = case.run(4.0)
    found = case.measure(curve)
    assert found == pytest.approx(case.exact, rel=1e-5)
    curve.multiplier[3] += 0.002
    assert case.measure(curve)["α"] == pytest.approx(1.01, abs=1e-4)


def test_the_elastic_block_comes_nearer_to_the_winkler_bed_with_every_segment():
    case = statics.rocking_elastic()
    true = case.exact["α_u"]
    one, four, exact = (abs(case.measure(case.run(value))["α_u"] / true - 1.0) for value in (1, 4, np.inf))
    assert exact < 0.005 < four < one


def test_an_elastic_column_has_its_strength():
    case = statics.column(*statics.COLUMNS[2])
    assert case.measure(case.run(np.inf))["α_u"] == pytest.approx(case.exact["α_u"], rel=3e-3)


@pytest.mark.parametrize(
    ("case", "step", "within"), [(rocking_freely(), 0.005, 1e-3), (swinging_column(), 0.00125, 2e-3)]
)
def test_motions_in_closed_form(case, step, within):
    """The third peak of free rocking; the time of a quarter period, of second order in the step, and its size."""
    found = case.peak(case.run(step, "second-order"))
    assert found == pytest.approx(case.exact, rel=within)
    assert case.error(found, case.exact) == pytest.approx(
        abs(found[case.timed] / case.exact[case.timed] - 1.0)
    )


def test_the_third_peak_of_the_paper():
    """Over the slenderness: 0.4204 (its §6.1); impacts at 2.0201 and 3.2468 s."""
    case = rocking_freely()
    alpha = np.arctan(0.6 / 4.2)
    assert case.exact[0] == pytest.approx(4.2 * np.sin(0.4204 * alpha), rel=2e-4)
    assert case.exact[1] == pytest.approx(0.5 * (2.0201 + 3.2468), abs=5e-3)


def test_beds_of_the_settled_arch_go_through_its_movement_themselves():
    """The exact one has a quarter of the strength of that of four points."""
    case = statics.beds("buttressed-arch", "-x")
    four, exact = (case.measure(case.run(value))["α_u"] for value in (4, np.inf))
    assert exact == pytest.approx(0.0139, abs=1e-4) and four == pytest.approx(0.0599, abs=1e-3)


@pytest.fixture
def overturning():
    """A block that overturns where its pulse is a little stronger."""
    case = Case("block", block_on_base(), "rigid", (0.2, 1.0), 1.0, pulse(0.3, 0.5))
    return ensembles.Shaken(case, {}, (0.01, np.ones(1)))


def test_the_stack_is_followed_until_it_lies():
    """At 0.62 g, where a second and a half of motion does not yet tell; it stands 0.55 g."""
    fallen = [
        replace(stack(), record=sine(size)).run(0.01, "second-order").collapsed for size in (0.55, 0.62)
    ]
    assert fallen == [False, True]


def test_members_of_an_arch_collapse_at_their_own_amplitudes(monkeypatch):
    """Made up: every member falls where its own amplitude passes 0.1 g."""

    def run(case, *_):
        return SimpleNamespace(collapsed=abs(case.record(at)).max() > limit)

    at = np.linspace(0.0, 3.0, 301)
    limit = abs(dynamics.shaking(0.1)(at)).max()
    monkeypatch.setattr(Case, "run", run)
    row = next(dynamics.collapse((0.01,)))
    assert row.stands_g < row.first_g <= row.collapse_g <= row.all_g
    assert row.first_g == pytest.approx(0.1 / 1.01, rel=0.02) and row.all_g == pytest.approx(
        0.1 / 0.99, rel=0.02
    )
    assert row.members == 5 and row.share >= 0.6
    assert "of 5" in BENCHMARKS["collapse"].show([row])


RESOLVED_PEAKS = np.array([100.0, 180.0, 190.0, 200.0, 210.0, 220.0, 400.0])  # mm


def test_members_of_an_ensemble_are_scaled_and_halved(overturning, monkeypatch):
    seen = []

    def noted(model, acceleration, *arguments, **more):
        seen.append((float(acceleration.max()), more["tolerances"].resolved.levels))
        return time_history(model, acceleration, *arguments, **more)

    monkeypatch.setattr("assessment.benchmark.cases.dynamics.time_history", noted)
    way = ensembles.Way("moreau-jean", 2)
    row = ensembles.measured(overturning, way, 0.01, np.array([0.5, 1.0, 1.2]), RESOLVED_PEAKS)
    assert [levels for _, levels in seen] == [2, 2, 2]
    assert [size for size, _ in seen] == pytest.approx([0.15, 0.3, 0.36])
    assert row.least <= row.median <= row.most and row.not_solved == 0
    assert row.error == pytest.approx(abs(row.median / 200.0 - 1.0))
    assert ensembles.Way("moreau-jean").tolerances.resolved.levels == ensembles.DEFAULT.levels


def test_the_table_says_how_sure_the_resolved_median_is(overturning):
    row = ensembles.measured(overturning, ensembles.DEFAULT, 0.01, np.array([0.5]), RESOLVED_PEAKS)
    assert "displacement, mm is 200 of 7 members, with 95 % confidence between 100 and 400." in (
        ensembles.summed_up([row])
    )


def test_of_what_falls_the_time_is_measured(overturning):
    falling = replace(overturning, measure=ensembles.FELL, case=replace(overturning.case, duration=3.0))
    times = np.linspace(0.5, 0.8, 7)
    row = ensembles.measured(falling, ensembles.DEFAULT, 0.01, np.array([0.1, 1.4, 1.5]), times)
    assert (row.members, row.collapsed) == (3, 2) and 0.3 < row.least <= row.most < 3.0
    assert "2 of 3 collapse" in ensembles.summed_up([row])
    row = ensembles.measured(falling, ensembles.DEFAULT, 0.01, np.array([0.1]), times)
    assert "no member collapses" in ensembles.summed_up([row])


def test_the_median_is_within_its_bounds_as_often_as_they_say():
    rng = np.random.default_rng(19)
    drawn = [ensembles.median_between(rng.exponential(size=21)) for _ in range(2000)]
    held = np.mean([low <= np.log(2.0) <= high for low, high in drawn])
    assert 0.94 < held < 0.99  # 97.3 % for 21 values
    with pytest.raises(ValueError, match="median of 5 values"):
        ensembles.median_between(np.arange(5.0))


def test_an_ensemble_counts_members_that_are_not_solved(overturning, monkeypatch):
    def fails(model, acceleration, *arguments, **more):
        if acceleration.max() > limit:
            raise ConvergenceError("not solved")
        return time_history(model, acceleration, *arguments, **more)

    monkeypatch.setattr("assessment.benchmark.cases.dynamics.time_history", fails)
    factors = np.array([0.5, 0.6, 1.0])
    limit = 0.29
    row = ensembles.measured(overturning, ensembles.DEFAULT, 0.01, factors, RESOLVED_PEAKS)
    assert (row.members, row.not_solved) == (2, 1)
    assert "1 not solved" in ensembles.summed_up([row])
    limit = 0.17
    row = ensembles.measured(overturning, ensembles.DEFAULT, 0.01, factors, RESOLVED_PEAKS)
    assert "not solved" in ensembles.summed_up([row]) and np.isnan(row.median)


def test_a_case_that_fails_says_so_in_its_rows():
    def fails(value):
        if value < 1.0:
            raise ConvergenceError("not solved")
        return case.run(value)

    case = statics.rocking_rigid()
    rows = list(
        statics.precision(statics.Case("block", "increment", (4.0, 0.5), fails, case.measure, case.exact))
    )
    assert [row.failed for row in rows] == [None, None, "not solved", "not solved"]
    assert "| block | α |" in command.by_parameter(("case", "quantity"))(rows)
    assert "fails" in command.by_parameter(("case", "quantity"))(rows)


def test_engines_of_a_campaign_are_compared_by_time_and_by_result(monkeypatch):
    def searched(model, motion, *_) -> Combination:
        return Combination(Judged(motion.pga), runs=3, seconds=1.0)

    monkeypatch.setattr(campaigns, "search_collapse", searched)
    monkeypatch.setattr(campaigns, "Workers", lambda *_, **__: Workers(1))
    monkeypatch.setattr(campaigns, "cores", lambda: 2)
    monkeypatch.setitem(sys.modules, "distributed", None)  # not installed
    alone, four, sixteen, two = campaigns.campaigns(True)
    assert (alone.combinations, alone.motions, alone.ratio, alone.ideal) == (8, 24, 1.0, 1.0)
    assert (two.case, two.ideal, two.equal) == ("2 processes", 0.5, True) and two.ratio > 0.0
    assert four.ratio == pytest.approx(0.25, rel=0.01)
    assert (sixteen.combinations, sixteen.motions) == (200, 600)
    assert sixteen.ratio == pytest.approx(13 / 200, rel=0.01)  # a second each: the last of 13 rounds has 8
    assert 10.0 < sixteen.sent_kB < 100.0 and sixteen.returned_kB < 1.0


def test_a_simulated_cluster_computes_side_by_side_what_has_arrived():
    dispatch, link, task = campaigns.DISPATCH, campaigns.LINK, campaigns.Task
    assert campaigns.simulated([task(2.0), task(1.0), task(1.0)], 2) == pytest.approx(
        2.0 + 3 * dispatch, abs=3e-3
    )
    slow = round(5.0 * link)  # 5 s on the link each: nothing is gained by a second worker
    assert campaigns.simulated([task(1.0, slow)] * 3, 2) == pytest.approx(16.0 + 3 * dispatch)
    assert campaigns.simulated([task(1.0, 0, slow)] * 2, 2) == pytest.approx(11.0 + dispatch)


def test_a_simulated_search_waits_for_its_neighbour():
    dispatch, link, task = campaigns.DISPATCH, campaigns.LINK, campaigns.Task
    assert campaigns.simulated([task(1.0), task(1.0, after=0)], 2) == pytest.approx(2.0 + 2 * dispatch)
    slow = round(5.0 * link)  # its result is 5 s on the way back
    assert campaigns.simulated([task(1.0, 0, slow), task(1.0, after=0)], 2) == pytest.approx(
        7.0 + 2 * dispatch
    )
    first, *others = campaigns.neighbours_of(3, 1, 2)
    assert first is None and others == [0, 0, 1, 2, 3]  # its other sign; then the share before
    seven = [task(1.0, after=each) for each in campaigns.neighbours_of(5, 7, 2)]
    assert campaigns.simulated(seven, 14) == pytest.approx(
        campaigns.simulated(seven, 70)
    )  # 14 at once, at most


def test_the_command_line_knows_every_benchmark():
    assert tuple(BENCHMARKS) == arguments.BENCHMARKS


@pytest.fixture
def measured(monkeypatch):
    """One benchmark of rows made up."""
    rows = [
        statics.Point(
            case=f"arch, {name}",
            parameter="increment",
            quantity="α",
            value=value,
            default=value == 1.0,
            error=1e-3 * value,
            seconds=0.1 / value,
            ratio=2.0,
        )
        for name in ("rigid", "elastic")
        for value in (2.0, 1.0, 0.5)
    ]
    made = Benchmark("made up.", lambda _: iter(rows), command.by_parameter(("case", "quantity")), "quantity")
    monkeypatch.setattr(command, "BENCHMARKS", {"made": made})
    return rows


def test_tables_plots_and_summary_are_written(measured, tmp_path, capsys):
    assert main(["benchmark", "--quick", "--out", str(tmp_path / "out")]) == exit_codes.DONE
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "made.csv",
        "made-increment.svg",
        "made-increment.png",
        "summary.md",
    }
    with (tmp_path / "out" / "made.csv").open(encoding="utf-8") as file:
        assert [float(row["error"]) for row in csv.DictReader(file)] == [row.error for row in measured]
    plot = (tmp_path / "out" / "made-increment.svg").read_text(encoding="utf-8")
    assert ">0.001<" in plot and "$" not in plot  # decades of the errors in plain figures
    summary = (tmp_path / "out" / "summary.md").read_text(encoding="utf-8")
    assert "| arch, elastic | α | 0.20 %; 2.0 | 0.10 %; 2.0 | 0.050 %; 2.0 |" in summary
    assert "| case | quantity | × 2 | **× 1** | × 0.5 |" in summary
    assert "piqp" in summary.splitlines()[0] and "commit" in summary.splitlines()[0]
    assert "arch, elastic" in capsys.readouterr().out


def test_a_benchmark_that_there_is_none_of(tmp_path, capsys):
    assert main(["benchmark", "wals", "--out", str(tmp_path / "out")]) == exit_codes.WRONG_INPUT
    assert 'wals: no such benchmark; did you mean "walls"?' in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_numbers_of_the_tables():
    shown = [table.number(value) for value in (0.0, 0.0123, 1.26, 152.0, 3.3e-9)]
    assert shown == ["0", "0.012", "1.3", "152", "3e-09"]
    assert [table.percent(share) for share in (0.0, 1e-9, 0.0162)] == ["0 %", "< 1e-5 %", "1.6 %"]


def test_a_value_that_a_row_lacks_is_empty():
    rows = [
        chain.Analysis(case="a", seconds=1.0, whole=True),
        chain.Analysis(case="b", steps=2, failed="not solved"),
    ]
    assert table.as_csv(rows).decode().splitlines() == [
        "case,failed,whole,steps,seconds",
        "a,,True,,1.0",
        "b,not solved,False,2,",
    ]
    columns = (("case", "case", str), ("steps", "steps", table.number))
    assert table.listed(rows, columns).splitlines()[2:] == ["| a |  |", "| b | 2.0 |"]


def test_attempts_at_a_step_that_are_not_solved_are_counted(monkeypatch):
    find, calls = step_control.find_equilibrium, iter(range(1000))

    def once(*arguments):
        if next(calls) == 1:
            raise ConvergenceError("not solved")
        return find(*arguments)

    monkeypatch.setattr(step_control, "find_equilibrium", once)
    count = Counter()
    with chain.counting(count):
        curve = pushover(block_on_base(), (0.2, 1.0), increment=0.05)
    assert count["unsolved"] == 1 and count["attempts"] == next(calls) > 2
    assert curve.displacement[-1] == pytest.approx(np.sin(np.arctan(0.2)))


def test_the_table_of_the_chain_shows_what_is_whole():
    rows = [
        chain.Analysis(case="arch, pushdown, rigid", steps=28, seconds=0.1, ratio=3.7),
        chain.Analysis(case="arch, static chain", whole=True, steps=497, seconds=5.8, ratio=4.3),
        chain.Analysis(case="assesto --help", whole=True, seconds=0.06, elapsed_s=0.07),
    ]
    text = BENCHMARKS["chain"].show(rows)
    assert "static chain" in text
    assert "--help" in text
    assert "pushdown" not in text


def test_a_wall_that_slides_ends_where_it_does_in_any_increment_unit_and_rounding():
    """It ended between 0.061 and 0.58 m where a path stopped as soon as its control point stood still."""
    case = sliding.cases(quick=True)[0]
    row = sliding.measured(case, "associative", sliding.variants(case))
    assert row.not_solved == 0
    assert row.most_m < 1.01 * row.least_m
