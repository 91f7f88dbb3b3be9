"""Participation, idealised curves and the capacity curve (Circolare 7/2019, C8.7.1.2; paper §7.1)."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assessment.ntc.capacity_curve import (
    CapacityError,
    capacity_curve,
    fit_curve,
    fit_rigid,
    mass_share,
    mechanism_participation,
    participation,
    yield_point,
)
from mechanics import Material
from mechanics.types import GRAVITY
from tests.support.structures import column
from tests.support.trace_check import recomputed


def _rigid(alpha_0=0.1, d_0=0.3):
    d = np.linspace(0.0, d_0, 31)
    return d, alpha_0 * (1.0 - d / d_0)


def _elastic(alpha_u=0.07, scale=0.004, end=0.05):
    """A concave curve: α_u (1 − exp(−d/scale)), with its peak at the end."""
    d = np.linspace(0.0, end, 501)
    return d, alpha_u * (1.0 - np.exp(-d / scale))


@pytest.mark.parametrize(("kept", "why"), [(31, "rigid contacts: α = 0"), (20, "lost before α = 0")])
def test_the_trace_says_why_the_curve_ends_at_d_0(kept, why):
    """A branch that drops vertically at its end has lost its equilibrium there."""
    d, alpha = (each[:kept] for each in _rigid())
    if kept < 31:
        d, alpha = np.r_[d, d[-1] * (1.0 + 1e-9)], np.r_[alpha, 0.0]
    fit = fit_rigid((d, alpha))
    [line] = [each for each in capacity_curve(fit, 0.8, 0.6, 1.35).steps() if each.symbol == "d_0"]
    assert line.result == d[-1] and line.paragraph.endswith(why)


def test_one_wall_turning_about_its_base():
    """A wall of n equal courses, control at its top: δ_i/δ_C = (i − ½)/n, so e* → 3/4 and Γ* → 2/3.

    n = 4: δ/δ_C = 1/8, 3/8, 5/8, 7/8; Σδ = 2, Σδ² = 1.3125; e* = 4/(4·1.3125) = 0.761905, Γ* = 0.65625.
    """
    result = participation(np.full(4, 10.0), np.array([1, 3, 5, 7]) / 8.0, 1.0)
    assert result.e_star == pytest.approx(0.761905, abs=1e-6)
    assert result.gamma_star == pytest.approx(0.65625)
    fine = participation(np.ones(2000), (np.arange(2000) + 0.5) / 2000, 1.0)
    assert (fine.e_star, fine.gamma_star) == (pytest.approx(0.75, abs=1e-6), pytest.approx(2 / 3, abs=1e-6))


def test_blocks_that_stay_still_do_not_count():
    moving = participation([10.0, 20.0], [0.5, 1.0], 1.0)
    with_still = participation([10.0, 20.0, 500.0, 30.0], [0.5, 1.0, 0.0, 3e-9], 1.0)
    assert with_still.e_star == pytest.approx(moving.e_star)
    assert with_still.gamma_star == pytest.approx(moving.gamma_star)
    assert with_still.weight == pytest.approx(30.0)


def test_a_mechanism_is_of_what_it_moves_noticeably():
    """The top block of five goes, the others by 0.3 %: with their weight e* was 0.20, for 1 of one block."""
    model = column(1.0, 5.0, 5)
    mechanism = np.zeros((len(model.blocks), 3))
    mechanism[model.movable, 0] = [0.003, 0.003, 0.003, 0.003, 1.0]
    found = mechanism_participation(model, mechanism, 1.0)
    assert (found.e_star, found.gamma_star) == (pytest.approx(1.0), pytest.approx(1.0))
    assert found.weight == pytest.approx(model.weight / 5.0)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_share_of_the_mass_does_not_depend_on_what_stays(sense):
    """One block of two on a support of 10⁹ times their weight: e* = 1, also of what moves towards −x."""
    model = column(1.0, 2.0, 2)
    heavy = [replace(b, material=Material(2e10, 0.7)) if b.support else b for b in model.blocks]
    model, mechanism = replace(model, blocks=heavy), np.zeros((3, 3))
    mechanism[np.flatnonzero(model.movable)[-1], 0] = sense
    assert mass_share(model, mechanism) == pytest.approx(1.0)


def test_a_block_that_only_rises_counts_when_said_to_move():
    """P = 10, 10; δ = 1, 0; both move: e* = 10²/(20·10) = 0.5, Γ* unchanged."""
    result = participation([10.0, 10.0, 99.0], [1.0, 0.0, 0.0], 1.0, moving=[True, True, False])
    assert (result.e_star, result.gamma_star) == (pytest.approx(0.5), pytest.approx(1.0))


@pytest.mark.parametrize(
    ("dx", "control", "says"),
    [
        ([0.0, 0.0], 1.0, "no weight moves"),
        ([0.5, 1.0], 0.0, "control point does not move"),
        ([0.5, 1.0], -1.0, "against the moving weights"),
        ([1.0, -0.99], 1.0, r"50 % of ΣP\|δ\| goes against the rest"),
        ([1.0, -0.12], 1.0, r"11 % of ΣP\|δ\| goes against the rest"),
        ([1.0, -0.5], -0.5, r"33 % of ΣP\|δ\| goes against the rest"),  # no other control point would do
    ],
)
def test_mechanisms_without_participation_are_refused(dx, control, says):
    with pytest.raises(CapacityError, match=says):
        participation([1.0, 1.0], dx, control)


def test_a_little_that_goes_back_is_left_in_the_sums():
    """δ = 1 and −0.1: e* = 0.9²/(2 · 1.01), Γ* = 1.01/0.9."""
    found = participation([1.0, 1.0], [1.0, -0.1], 1.0)
    assert (found.e_star, found.gamma_star) == pytest.approx((0.81 / 2.02, 1.01 / 0.9))


def test_rigid_branch_is_cut_where_the_multiplier_vanishes():
    """α = 0.1, 0.05, −0.03 at 0, 0.1, 0.2 m: d_0 = 0.1 + 0.1·0.05/0.08 = 0.1625 m."""
    fit = fit_rigid(([0.0, 0.1, 0.2], [0.1, 0.05, -0.03]))
    assert fit.d_0 == pytest.approx(0.1625)
    assert (fit.displacement[-1], fit.multiplier[-1]) == (fit.d_0, 0.0)
    assert fit_rigid(([0.0, 0.1], [0.1, 0.05])).d_0 is None


def test_trilinear():
    """α_u = 0.07 at d = 0.05; 0.4 α_u = 0.028 at d = 0.004·ln(1/0.6) = 0.00204330 m: K = 13.7033 /m.

    α_y = 0.063, d_y = 0.063/13.7033 = 0.00459743 m; the plateau meets 0.1 (1 − d/0.3) at d = 0.111 m.
    """
    d, alpha = _elastic()
    alpha = alpha * 0.07 / alpha[-1]
    fit = fit_curve("trilinear", _rigid(), (d, alpha))
    assert fit.alpha_u == pytest.approx(0.07)
    assert fit.alpha_y == pytest.approx(0.063)
    assert fit.d_y == pytest.approx(0.00459743, rel=5e-4)  # the curve is sampled
    np.testing.assert_allclose(fit.displacement[:3], [0.0, fit.d_y, 0.111], rtol=1e-12)
    np.testing.assert_allclose(fit.multiplier[:3], [0.0, 0.063, 0.063])
    np.testing.assert_allclose(np.interp(0.2, fit.displacement, fit.multiplier), 0.1 / 3.0)
    assert fit.d_0 == pytest.approx(0.3)
    assert yield_point((d, alpha)) == pytest.approx((fit.d_y, fit.alpha_y), rel=1e-12)


def test_bilinear_has_the_area_of_the_curve():
    """Area of min(elastic, rigid) by fine summation equals the area under the fit; α_y ≤ α_u."""
    rigid, elastic = _rigid(), _elastic()
    fit = fit_curve("bilinear", rigid, elastic)
    d = np.linspace(0.0, 0.3, 600_001)
    curve = np.minimum(np.interp(d, *elastic), np.interp(d, *rigid))
    area = np.trapezoid(curve, d)
    assert np.trapezoid(fit.multiplier, fit.displacement) == pytest.approx(area, rel=1e-4)
    assert fit.alpha_y < fit.alpha_u
    assert fit.d_y == pytest.approx(
        fit.alpha_y
        / fit_curve("trilinear", rigid, elastic).alpha_y
        * fit_curve("trilinear", rigid, elastic).d_y
    )


@given(
    model=st.sampled_from(["trilinear", "bilinear", "none"]), alpha_0=st.floats(0.02, 0.5),
    d_0=st.floats(0.02, 2.0), share=st.floats(0.1, 0.99), stiff=st.floats(0.002, 0.05),
    scale=st.floats(0.1, 10.0),
)  # fmt: skip
def test_fits_scale_with_the_drawing_and_stay_under_the_rigid_branch(
    model, alpha_0, d_0, share, stiff, scale
):
    """A drawing s times as large: displacements s times, multipliers the same."""
    rigid = _rigid(alpha_0, d_0)
    elastic = _elastic(share * alpha_0, stiff * d_0, 0.5 * d_0)
    fit = fit_curve(model, rigid, elastic)
    large = fit_curve(model, (scale * rigid[0], rigid[1]), (scale * elastic[0], elastic[1]))
    assert large.d_0 == pytest.approx(scale * fit.d_0, rel=1e-9)
    assert large.alpha_0 == fit.alpha_0
    if model != "none":
        assert large.d_y == pytest.approx(scale * fit.d_y, rel=1e-6)
        assert large.alpha_y == pytest.approx(fit.alpha_y, rel=1e-6)
        assert fit.alpha_y <= fit.alpha_u * (1 + 1e-12)
    assert (np.diff(fit.displacement) > 0.0).all()
    assert (fit.multiplier <= np.interp(fit.displacement, *rigid) + 1e-12).all()


def test_soft_elastic_branch_meets_the_rigid_branch_before_the_plateau():
    """K = 0.2 /m from (0.15, 0.03): 0.2 d = 0.1 (1 − d/0.3) at d = 0.1875 m, α = 0.0375 < 0.9·0.0599."""
    elastic = ([0.0, 0.2995], [0.0, 0.0599])
    fit = fit_curve("trilinear", _rigid(), elastic)
    assert (fit.d_y, fit.alpha_y) == (pytest.approx(0.1875, rel=1e-6), pytest.approx(0.0375, rel=1e-6))
    assert any("no plateau" in note for note in fit.notes)
    for line in fit.steps:
        assert not line.formula or recomputed(line.formula, line.inputs) == pytest.approx(line.result)


def test_elastic_peak_above_the_rigid_onset_is_noted_and_cut():
    fit = fit_curve("trilinear", _rigid(), _elastic(alpha_u=0.12))
    assert fit.multiplier.max() <= 0.1
    assert any("above the rigid onset" in note for note in fit.notes)


def test_a_control_point_that_sways_back_a_little_as_hinges_close_is_no_fault():
    d, alpha = (np.array(values) for values in _elastic())
    swaying = np.insert(d, 1, -2e-3 * d[np.argmax(alpha)]), np.insert(alpha, 1, 0.1 * alpha[1])
    straight, swayed = fit_curve("trilinear", _rigid(), (d, alpha)), fit_curve("trilinear", _rigid(), swaying)
    assert swayed.d_y == pytest.approx(straight.d_y, rel=1e-2)
    assert swayed.alpha_y == straight.alpha_y


@pytest.mark.parametrize("model", ["trilinear", "bilinear"])
@pytest.mark.parametrize(("at", "down"), [(0.1, 0.01), (0.95, 0.9)])
def test_a_part_that_snaps_through_is_no_turn_of_the_control_point(model, at, down):
    """A crown that snaps from one hinge to another: α falls as the control point goes back, and both come again."""
    d, alpha = np.linspace(0.0, 0.02, 41), 0.06 * np.linspace(0.0, 1.0, 41)
    k = int(40 * at)
    snap = np.linspace(at, down * at, 4)[1:]
    snapped = np.insert(d, k + 1, 0.02 * snap), np.insert(alpha, k + 1, 0.06 * snap)
    whole, fit = fit_curve(model, _rigid(), (d, alpha)), fit_curve(model, _rigid(), snapped)
    assert (fit.d_y, fit.alpha_y) == pytest.approx((whole.d_y, whole.alpha_y), rel=5e-3)


@pytest.mark.parametrize(
    ("rigid", "elastic", "says"),
    [
        (_rigid(), None, 'model = "none"'),
        (([0.0, 0.1], [0.0, -0.1]), _elastic(), "no seismic capacity"),
        (_rigid(), ([0.0, -0.01, -0.02], [0.0, 0.05, 0.06]), "does not advance"),
        (_rigid(), ([0.0, 0.01], [0.0, -0.05]), "alpha_u"),
        (([0.0, 0.001], [0.1, 0.0999]), _elastic(), "further"),
    ],
)
def test_curves_without_a_fit_are_refused(rigid, elastic, says):
    with pytest.raises(CapacityError, match=says):
        fit_curve("trilinear", rigid, elastic)


def test_capacity_curve_divides_by_the_confidence_factor_once():
    """e* = 0.8, Γ* = 0.7, F_C = 1.25: a* = α/(0.8·1.25) = α, d* = 0.7 d; T_0 = 2π √(0.7 d_y/(α_y g))."""
    fit = fit_curve("trilinear", _rigid(), _elastic())
    curve = capacity_curve(fit, 0.8, 0.7, 1.25)
    np.testing.assert_allclose(curve.acceleration, fit.multiplier)
    np.testing.assert_allclose(curve.displacement, 0.7 * fit.displacement)
    assert curve.a_0_star == pytest.approx(0.1)
    T_0 = 2 * np.pi * (0.7 * fit.d_y / (fit.alpha_y * GRAVITY)) ** 0.5
    np.testing.assert_allclose(curve.T_0, T_0)
    assert capacity_curve(fit_rigid(_rigid()), 0.8, 0.7).T_0 is None
    for arguments, named in (
        ((1.2, 0.7), "e_star"),
        ((0.8, -0.7), "gamma_star"),
        ((0.8, 0.7, 0.9), "confidence"),
    ):
        with pytest.raises(ValueError, match=named):
            capacity_curve(fit, *arguments)
