"""The benchmark command, and what does not depend on the clock."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from assessment.benchmark import motions, statics
from assessment.benchmark.command import BENCHMARKS
from assessment.benchmark.measure import Case, history_baseline, path_baseline, rows_of
from assessment.benchmark.motions import ShakenCase, pulse, rocking_freely
from assessment.cli import main as arguments
from mechanics import ConvergenceError, pushover, time_history
from mechanics.procedures.motion_start import HistoryTolerances
from mechanics.program import certify
from mechanics.solvers import qp_piqp
from tests.support.structures import block_on_base


@pytest.fixture
def overturning():
    """A block that overturns where its pulse is a little stronger."""
    return ShakenCase("block", block_on_base(), "rigid", (0.2, 1.0), 1.0, pulse(0.3, 0.5))


def test_a_looser_tolerance_solves_less():
    """The tolerance that the benchmark varies is the one that the solver keeps."""
    block, record = block_on_base(0.6, 4.2), 0.3 * pulse(1.0, 0.2)(0.005 * np.arange(60))
    worst = [
        time_history(block, record, 0.005, "elastic", tolerances=HistoryTolerances(accepted=each)).worst
        for each in (1e-3, 1e-7)
    ]
    assert worst[1] <= 1e-7 < worst[0] <= 1e-3


def test_the_baseline_solves_the_steps_of_the_motion():
    """From its states implicit Euler's program leads to its next states, by another solver."""
    record = 0.3 * pulse(1.0, 0.2)(0.005 * np.arange(61))
    model = block_on_base(0.6, 4.2, friction=0.1)  # it slides
    motion = time_history(model, record, 0.005, "elastic", integrator="implicit-euler")
    programs, steps = history_baseline(model, "elastic", record, motion)
    assert (len(programs), steps) == (20, 60)
    for k, program in enumerate(programs):
        forces, alpha, moved = qp_piqp.solve(program, 1e-11)
        assert certify(program, forces, alpha, moved).equilibrium < 1e-6
        expected = (motion.positions[3 * k + 1] - motion.positions[3 * k])[1]
        within = 1e-2 * abs(motion.positions[-1] - motion.positions[0]).max()
        assert moved == pytest.approx(expected, abs=within)


def test_the_baseline_solves_the_steps_of_a_curve():
    curve = pushover(block_on_base(), (0.2, 1.0), increment=0.02)
    programs, steps = path_baseline(curve)
    assert steps == len(curve.steps)
    for program, step in zip(programs, curve.steps[1:], strict=True):
        _, alpha, _ = qp_piqp.solve(program, 1e-10)
        # of a step's length, in the geometry that it begins in
        assert alpha == pytest.approx(step.alpha, abs=0.03)


def test_errors_of_the_rocking_block_are_those_of_closed_forms():
    case = statics.rocking_rigid()
    curve = case.run(4.0)
    assert case.measure(curve) == pytest.approx(case.exact, rel=1e-5)
    curve.multiplier[3] += 0.002
    assert case.measure(curve)["α"] == pytest.approx(1.01, abs=1e-4)


def test_the_third_peak_of_free_rocking():
    """Over the slenderness: 0.4204 (the paper's §6.1); found by second order to a thousandth."""
    motion = rocking_freely()
    assert motion.exact == pytest.approx(4.2 * np.sin(0.4204 * np.arctan(0.6 / 4.2)), rel=2e-4)
    assert motion.peak(motion.run(0.005, "second-order")) == pytest.approx(motion.exact, rel=1e-3)


def test_the_largest_displacement_is_that_of_a_parabola_through_three_samples(overturning):
    at = 0.1 * np.arange(11)
    shaped = SimpleNamespace(displacement=1.0 - (at - 0.47) ** 2, time=at)
    assert overturning.peak(shaped) == pytest.approx(1.0)
    assert replace(overturning, after=0.8).peak(shaped) == pytest.approx(1.0 - 0.33**2)


def test_beds_of_the_settled_arch_go_through_its_movement_themselves():
    """The exact one has a quarter of the strength of that of four points."""
    case = statics.beds("buttressed-arch", "-x")
    four, exact = (case.measure(case.run(value))["α_u"] for value in (4, np.inf))
    assert exact == pytest.approx(0.0139, abs=1e-4) and four == pytest.approx(0.0599, abs=1e-3)


@pytest.fixture
def limited(monkeypatch):
    """Motions whose peak is their amplitude; at 10 ms those beyond a limit, which a test writes, are not solved."""
    most = [np.inf]

    def run(model, acceleration, step, *_, **__):
        size = float(acceleration.max())
        if step == 0.01 and size > most[0]:
            raise ConvergenceError("not solved")
        shape = {"time": step * np.arange(3.0), "displacement": np.array([0.0, 0.0, size])}
        energy = SimpleNamespace(integrator_share=0.0, imbalance=0.0)
        counts = dict.fromkeys(("programs", "iterations", "halvings", "cold", "collapsed"), 1)
        return SimpleNamespace(**shape, **counts, energy=energy)

    monkeypatch.setattr("assessment.benchmark.motions.time_history", run)
    return most


def test_members_of_an_ensemble_are_at_amplitudes_within_one_percent(overturning, limited):
    """Of a block pushed by 0.3 g: the least, the middle and the largest of five; seven are resolved."""
    resolved, *rows = motions.ensemble(overturning, (0.01,), 5, 0.005, 7)
    assert (resolved["members"], resolved["median"]) == (7, pytest.approx(300.0))
    assert (resolved["least"], resolved["most"]) == pytest.approx((297.0, 303.0))
    assert [row["way"] for row in rows] == [*motions.INTEGRATORS["rigid"]]
    for row in rows:
        assert [row[name] for name in ("least", "median", "most")] == pytest.approx([297.0, 300.0, 303.0])
        assert (row["members"], row["not_solved"], row["collapsed"]) == (5, 0, 5)
        assert row["error"] == pytest.approx(0.0, abs=1e-12) and row["step_ms"] > 0.0


@pytest.mark.parametrize(
    ("limit", "members", "failed"), [(0.3005, 3, None), (0.298, 1, "most members are not solved")]
)
def test_an_ensemble_counts_members_that_are_not_solved(overturning, limited, limit, members, failed):
    limited[0] = limit
    _, row, *_ = motions.ensemble(overturning, (0.01,), 5, 0.005, 7)
    assert (row["members"], row["not_solved"], row.get("failed")) == (members, 5 - members, failed)


def test_the_median_is_within_its_bounds_as_often_as_they_say():
    rng = np.random.default_rng(19)
    drawn = [motions.median_between(rng.exponential(size=21)) for _ in range(2000)]
    held = np.mean([low <= np.log(2.0) <= high for low, high in drawn])
    assert 0.94 < held < 0.99  # 97.3 % for 21 values
    with pytest.raises(ValueError, match="median of 5 values"):
        motions.median_between(np.arange(5.0))


def test_a_reference_is_what_errors_are_of():
    case = Case("made", lambda value: value, "n", (4.0, 2.0), lambda found: {"x": 1.0 + found}, reference=1.0)
    rows = list(rows_of(replace(case, baseline=None)))
    assert [row["error"] for row in rows] == pytest.approx([1.5, 0.5])
    assert [row["default"] for row in rows] == [False, False]


def test_the_command_line_knows_every_benchmark():
    assert tuple(BENCHMARKS) == arguments.BENCHMARKS
