"""The validation table that every report prints is what this version gives, digit by digit."""

import tomllib
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from mechanics import limit_analysis, pushdown, pushover, time_history
from tests.support.drawn_projects import drawn
from tests.support.structures import block_on_base, running_bond
from tests.validation import test_buttressed_arch as buttressed
from tests.validation import test_coulomb as coulomb
from tests.validation import test_paper_table_1 as paper
from tests.validation import test_rocking as rocking
from tests.validation import test_ties as ties
from tests.validation import test_triumphal_arch as triumphal
from tests.validation.test_rectangular_block import BREADTH, HEIGHT
from tests.validation.test_semicircular_arch import least_thickness, thrust

CASES = tomllib.loads((files("templates") / "validation.toml").read_text(encoding="utf-8"))["case"]


def block_curve():
    curve = pushover(block_on_base(BREADTH, HEIGHT), (BREADTH, HEIGHT), increment=0.005)
    return CubicSpline(curve.displacement, curve.multiplier)([0.05, 0.10, 0.15, 0.18])


def block_end():
    curve = pushover(block_on_base(BREADTH, HEIGHT), (BREADTH, HEIGHT), increment=0.02)
    return [curve.displacement[-1]]


def rocking_peaks():
    model, state, alpha = rocking.released(0.6, 4.2, 0.5)
    motion = time_history(model, np.zeros(230), 0.02, "rigid", state, "second-order")
    return rocking.peaks(motion.positions[:, 1, 2], alpha)


def tied_wall():
    """α0, and α at a rotation of 1/30."""
    curve = pushover(ties.tied_wall(), (ties.B, ties.H), increment=0.02)
    turns = [-state.positions[1, 2] for state in curve.states]
    return [curve.multiplier[0], float(CubicSpline(turns, curve.multiplier)(1.0 / 30.0))]


def walls_of_ferris_and_tin_loi():
    """Wall 2 with dilation, then walls 1 and 2 without."""
    walls = running_bond(), running_bond(5, 10)
    return [limit_analysis(walls[1], sliding="associative").alpha] + [
        limit_analysis(w, sliding="coulomb").alpha for w in walls
    ]


def buttressed_ends():
    """mm, as drawn and settled."""
    model, control = drawn("buttressed_arch"), buttressed.control("+x")
    moved = pushdown(model, "destro", buttressed.SETTLEMENT, increment=0.001).final
    curves = [pushover(model, control, "+x", "rigid", 0.001, state) for state in (None, moved)]
    return [1000.0 * curve.displacement[-1] for curve in curves]


def buttressed_peaks():
    """Elastic and settled, towards +x and −x."""
    model = drawn("buttressed_arch")
    moved = pushdown(model, "destro", buttressed.SETTLEMENT, increment=0.002, contacts="elastic").final
    curves = [
        pushover(model, buttressed.control(direction), direction, "elastic", 0.00025, moved, until=0.9)
        for direction in ("+x", "-x")
    ]
    return [curve.multiplier.max() for curve in curves]


COMPUTED = {
    "block_onset": lambda: [limit_analysis(block_on_base(BREADTH, HEIGHT)).alpha],
    "block_curve": block_curve,
    "block_end": block_end,
    "block_sliding": lambda: [limit_analysis(block_on_base(BREADTH, HEIGHT, friction=0.15)).alpha],
    "leaf": lambda: [limit_analysis(block_on_base(0.5, 3.9, friction=0.58)).alpha],
    "wall": lambda: [limit_analysis(running_bond(), sliding="associative").alpha],
    "walls_coulomb": walls_of_ferris_and_tin_loi,
    "wedge": lambda: coulomb.opened(0.3, 0.001),
    "incline": lambda: coulomb.drawn_away(0.001),
    "arch_thickness": lambda: [least_thickness(7), least_thickness(27)],
    "arch_friction": lambda: [least_thickness(27, friction) for friction in (0.40, 0.38, 0.35)],
    "arch_thrust": lambda: [thrust(0.15, 1e-4), thrust(0.15, -1e-4)],
    "buttressed_arch": buttressed_ends,
    "buttressed_arch_elastic": buttressed_peaks,
    "paper_periods": lambda: [paper._capacity(column).T_0 for column in paper.COLUMNS.values()],
    "paper_displacements": lambda: [
        1000.0 * paper._check(paper._capacity(column), paper.NTC).d_star_m
        for column in paper.COLUMNS.values()
    ],
    "paper_periods_NC": lambda: [
        paper._check(paper._capacity(column), paper.NTC).T_s for column in paper.COLUMNS.values()
    ],
    "paper_a_g_NC": list,  # not computed: the record is not distributed
    "triumphal_arch": triumphal.participation,
    "triumphal_arch_settled": lambda: [triumphal.settled(until=0.9)[0]],
    "rocking": rocking_peaks,
    "tied_wall": tied_wall,
}


def test_every_row_is_computed():
    assert [case["id"] for case in CASES] == list(COMPUTED)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["id"])
def test_the_printed_numbers_are_this_versions(case):
    printed = [text for text in case["computed"].split("; ") if text != "–"]
    for text, value in zip(printed, COMPUTED[case["id"]](), strict=True):
        assert f"{value:.{len(text.partition('.')[2])}f}" == text


def test_no_row_is_farther_from_its_source_than_seven_percent():
    """The periods T_NC are (test_paper_table_1 says why), all others are within 1.2 %; peaks of blocks 1e-3."""
    for case in CASES:
        pairs = zip(case["expected"].split("; "), case["computed"].split("; "), strict=False)
        close = 0.07 if case["id"] == "paper_periods_NC" else 0.012
        for source, own in pairs:
            assert own == "–" or float(own) == pytest.approx(float(source), rel=close), case["id"]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["id"])
def test_the_test_that_a_row_names_exists_and_both_languages_are_there(case):
    assert (Path(__file__).parent / f"{case['test']}.py").is_file()
    for language in ("it", "en"):
        assert case[language].keys() == {"case", "source"}
        assert all(case[language].values())
