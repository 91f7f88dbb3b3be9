"""The benchmark command; that skipping changes no answer; and what does not depend on the clock."""

from __future__ import annotations

import csv
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from assessment import cli
from assessment.benchmark import command, skips, statics, steps, table, walls
from assessment.benchmark.command import BENCHMARKS, Benchmark
from assessment.benchmark.dynamics import certified_to, pulse
from mechanics import time_history
from mechanics.solvers.newton import Newton
from tests.structures import block_on_base, running_bond

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
    record = 0.3 * pulse(1.0, 0.2)(0.005 * np.arange(60))
    worst = []
    for tolerance in (1e-3, 1e-9):
        with certified_to(tolerance):
            worst.append(time_history(running_bond(3, 3), record, 0.005, "elastic").worst)
    assert worst[1] <= 1e-9 < worst[0] <= 1e-3


def test_a_step_is_timed_in_blocks_without_the_state_at_rest(monkeypatch):
    """By a clock that only these parts of a history move: 100 s for its state at rest, 1 s for each of 46 steps."""
    histories, clock = sys.modules["mechanics.time_history"], SimpleNamespace(now=0.0)
    settled, collapse = histories._settled, histories.collapse

    def taking(seconds, function):
        def slow(*arguments):
            clock.now += seconds
            return function(*arguments)

        return slow

    monkeypatch.setattr(histories, "_settled", taking(100.0, settled))
    monkeypatch.setattr(histories, "collapse", taking(1.0, collapse))
    monkeypatch.setattr(steps, "time", SimpleNamespace(perf_counter=lambda: clock.now))
    model = block_on_base(0.6, 4.2, stiffness=1e6)
    blocks = steps._blocks(lambda record: time_history(model, record, 0.005, "elastic"), np.zeros(47))
    assert blocks.tolist() == [0.0, 19.0, 20.0, 7.0]


def test_programs_of_a_row_of_steps_are_kept_as_they_were_solved(monkeypatch):
    """A history shifts the gaps of a program in place before it is solved again."""
    gaps, solve = [], Newton.solve

    def noted(newton, program, *near):
        gaps.append(program.gap.copy())
        return solve(newton, program, *near)

    monkeypatch.setattr(Newton, "solve", noted)
    monkeypatch.setattr(steps, "EVERY", 2)
    model = block_on_base(0.6, 4.2, friction=0.1)  # it slides, and sliding dilates
    record = 0.3 * pulse(1.0, 0.2)(0.005 * np.arange(61))
    counts, programs = steps._counted(lambda shaking: time_history(model, shaking, 0.005, "rigid"), record)
    assert counts["steps"] == 60 and counts["solves_per_step"] == len(gaps) / 60 > 1.0
    assert len(programs) == len(gaps[::2])
    for program, gap in zip(programs, gaps[::2], strict=True):
        assert (program.gap == gap).all()


def test_peak_memory_of_limit_analysis():
    """Python and its libraries take 190 MB of it; dense matrices of this wall would take 500 MB more."""
    row = walls.apart(*walls.WALLS[300])
    assert row["memory_MB"] < 260.0
    assert row["error"] < 1e-8


def test_errors_of_the_rocking_block_are_those_of_closed_forms():
    case = statics.rocking_rigid()
    curve = case.run(4.0)
    found = case.measure(curve)
    assert found == pytest.approx(case.exact, rel=1e-5)
    curve.multiplier[3] += 0.002
    assert case.measure(curve)["α"] == pytest.approx(1.01, abs=1e-4)


def test_the_elastic_block_comes_nearer_to_the_winkler_bed_with_every_segment():
    case = statics.rocking_elastic()
    errors = [case.measure(case.run(value)) for value in (4, 16)]
    assert all(abs(errors[1][key] - 1.0) < 0.3 * abs(errors[0][key] - 1.0) for key in ("α", "α_u"))


def test_the_command_line_knows_every_benchmark():
    assert tuple(BENCHMARKS) == cli.BENCHMARKS


@pytest.fixture
def measured(monkeypatch):
    """One benchmark of rows made up."""
    rows = [
        {
            "case": f"arch, {name}",
            "parameter": "increment",
            "quantity": "α",
            "value": value,
            "default": value == 1.0,
            "error": 1e-3 * value,
            "seconds": 0.1 / value,
            "ratio": 2.0,
        }
        for name in ("rigid", "elastic")
        for value in (2.0, 1.0, 0.5)
    ]
    made = Benchmark("made up.", lambda _: iter(rows), command.by_parameter(("case", "quantity")), "quantity")
    monkeypatch.setattr(command, "BENCHMARKS", {"made": made})
    return rows


def test_tables_plots_and_summary_are_written(measured, tmp_path, capsys):
    assert cli.main(["benchmark", "--quick", "--out", str(tmp_path / "out")]) == cli.DONE
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "made.csv",
        "made-increment.svg",
        "made-increment.png",
        "summary.md",
    }
    with (tmp_path / "out" / "made.csv").open(encoding="utf-8") as file:
        assert [float(row["error"]) for row in csv.DictReader(file)] == [row["error"] for row in measured]
    summary = (tmp_path / "out" / "summary.md").read_text(encoding="utf-8")
    assert "| arch, elastic | α | 0.20 %; 2.0 | 0.10 %; 2.0 | 0.050 %; 2.0 |" in summary
    assert "| case | quantity | × 2 | **× 1** | × 0.5 |" in summary
    assert "piqp" in summary.splitlines()[0] and "commit" in summary.splitlines()[0]
    assert "arch, elastic" in capsys.readouterr().out


def test_a_benchmark_that_there_is_none_of(tmp_path, capsys):
    assert cli.main(["benchmark", "wals", "--out", str(tmp_path / "out")]) == cli.WRONG_INPUT
    assert 'wals: no such benchmark; did you mean "walls"?' in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_numbers_of_the_tables():
    shown = [table.number(value) for value in (0.0, 0.0123, 1.26, 152.0, 3.3e-9)]
    assert shown == ["0", "0.012", "1.3", "152", "3e-09"]
    assert [table.percent(share) for share in (0.0, 1e-9, 0.0162)] == ["0 %", "< 1e-5 %", "1.6 %"]


def test_a_value_that_a_row_lacks_is_empty():
    rows = [{"case": "a", "x": 1.0}, {"case": "b", "y": 2.0}]
    assert table.as_csv(rows).decode().splitlines() == ["case,x,y", "a,1.0,", "b,,2.0"]
    columns = (("case", "case", str), ("y", "y", table.number))
    assert table.listed(rows, columns).splitlines()[2:] == ["| a |  |", "| b | 2.0 |"]


def test_the_table_of_the_chain_shows_what_is_whole():
    rows = [
        {"case": "arch, pushdown, rigid", "steps": 28, "seconds": 0.1, "ratio": 3.7},
        {"case": "arch, static chain", "whole": True, "steps": 497, "seconds": 5.8, "ratio": 4.3},
        {"case": "assesto --help", "whole": True, "seconds": 0.06, "elapsed_s": 0.07},
    ]
    text = BENCHMARKS["chain"].show(rows)
    assert "static chain" in text
    assert "--help" in text
    assert "pushdown" not in text
