"""Checks of the limit states: a closed form by hand, properties, floor spectra, and the trace recomputed."""

from dataclasses import replace

import numpy as np
import pytest

from assessment.ntc.capacity_curve import (
    Activation,
    CurveFit,
    Way,
    capacity_curve,
    fit_curve,
    fit_rigid,
    participation,
)
from assessment.ntc.floor_spectrum import FloorSpectrum, FloorSpectrum2009, Mode, first_mode
from assessment.ntc.hazard import HazardCurve, return_period_steps, site_curve
from assessment.ntc.spectrum import ElasticSpectrum, RecordSpectrum
from assessment.ntc.tables import return_period
from assessment.ntc.verification import Method, check_nonlinear, verify
from mechanics.types import GRAVITY
from tests.support.trace_check import recomputed

SOIL_A = ElasticSpectrum(0.25, 2.4, 0.30)
STATES = ("SLO", "SLD", "SLV", "SLC")
T = np.arange(0.0, 10.0, 0.01)
RECORD = RecordSpectrum(
    0.02 * np.sin(2.2 * T) * np.exp(-0.2 * T) + 0.3 * np.sin(9.0 * T) * np.exp(-0.5 * T), 0.01
)


def _block(alpha_0=1 / 7, d_0=0.6, F_C=1.0, model="none", e_star=1.0):
    """A rigid branch from α0 straight to d_0, and an elastic one; Γ* = 0.5."""
    d = np.linspace(0.0, d_0, 21)
    elastic = np.linspace(0.0, 0.2 * d_0, 201)
    peak = 0.8 * alpha_0 * (1.0 - np.exp(-elastic / (0.02 * d_0)))
    fit = fit_curve(model, (d, alpha_0 * (1.0 - d / d_0)), (elastic, peak))
    return capacity_curve(fit, e_star, 0.5, F_C)


@pytest.fixture
def hazard():
    """A site whose a_g grows tenfold over the nine return periods, F0 = 2.4 to 2.5, T_C* = 0.27 to 0.35 s."""
    values = np.column_stack(
        [np.geomspace(0.05, 0.5, 9), np.linspace(2.4, 2.5, 9), np.linspace(0.27, 0.35, 9)]
    )
    return HazardCurve("hand-made", values, values[None], np.zeros(1))


def test_single_rigid_block_by_hand():
    """Block 0.6 × 4.2 m, rigid base, control point at its top; soil A, a_g = 0.25 g, F0 = 2.4, T_C* = 0.3 s.

    α0 = 0.6/4.2 = 0.142857; d_0 = 0.6 m, α = α0 (1 − d/d_0); one block: e* = 1, Γ* = δ_G/δ_C = 0.5; F_C = 1.
    a_0* = 0.142857 g, d_0* = 0.300 m. S = 1, T_C = 0.3 s, T_D = 4·0.25 + 1.6 = 2.6 s.

    SLD  a_g S = a_0*: a_g = 0.142857 g.                          SLV linear, q = 2: a_g = 0.285714 g
    SLV  d = 0.4·0.3 = 0.12 m, a = 0.6·0.142857 = 0.0857143 g = 0.840570 m/s²,
         T = 1.68 π √(0.12/0.840570) = 5.277876·0.377836 = 1.994173 s (below T_D), η = √(10/13) = 0.877058,
         S_e = 0.25·0.877058·2.4·0.3/1.994173 = 0.0791659 g,
         S_De = 0.0791659·9.80665·(1.994173/2π)² = 0.0782032 m, a_g = 0.25·0.12/0.0782032 = 0.383616 g
    SLC  d = 0.6·0.3 = 0.18 m, a = 0.4·0.142857 = 0.0571429 g = 0.560380 m/s²,
         T = 1.56 π √(0.18/0.560380) = 4.900885·0.566754 = 2.777598 s (> T_D), η = √(10/15) = 0.816497,
         S_e = 0.25·0.816497·2.4·0.3·2.6/2.777598² = 0.0495292 g,
         S_De = 0.0495292·9.80665·(2.777598/2π)² = 0.0949208 m, a_g = 0.25·0.18/0.0949208 = 0.474080 g
    """
    block = participation([7.0], [0.5], 1.0)
    assert (block.e_star, block.gamma_star) == (1.0, 0.5)
    checks = verify(_block(), dict.fromkeys(STATES, SOIL_A))
    assert checks["SLD"].a_g_g == pytest.approx(0.142857, abs=1e-6)
    assert checks["SLV linear"].a_g_g == pytest.approx(0.285714, abs=1e-6)
    expected = {
        "SLV": (0.12, 0.0857143, 1.994173, 0.0791659, 0.0782032, 0.383616),
        "SLC": (0.18, 0.0571429, 2.777598, 0.0495292, 0.0949208, 0.474080),
    }
    for state, (d, a, period, S_e, S_De, a_g) in expected.items():
        check = checks[state]
        found = {line.symbol: line.result for line in check.trace[: len(check.trace) // 2 + 8]}
        first = next(line for line in check.trace if line.symbol == "S_De")
        assert check.d_star_m == pytest.approx(d, rel=1e-6)
        assert check.a_star_g == pytest.approx(a, rel=1e-6)
        np.testing.assert_allclose(check.T_s, period, rtol=1e-6)
        assert first.inputs["S_e"] == pytest.approx(S_e, rel=1e-6)
        assert first.result == pytest.approx(S_De, rel=1e-6)
        assert check.a_g_g == pytest.approx(a_g, rel=2e-6)
        assert check.zeta_E == pytest.approx(a_g / 0.25, rel=2e-6)
        assert check.verified
        assert check.governing.endswith("d_0")
        assert found["a_0_star"] == pytest.approx(1 / 7)
    assert not checks["SLD"].verified


def test_what_is_activated_first_is_what_linear_checks_are_of():
    """A wall of α0 = 1/7, e* = 1 leans on a neighbour: together α0 = 0.3, e* = 0.8. Soil A, q = 2, F_C = 1.35.

    SLD  a_0* = 0.142857/(1·1.35) = 0.105820 g;  SLV linear 0.211640 g; of α0 it would be 0.3/(0.8·1.35) = 0.277778 g.
    The nonlinear checks of the rigid branch are not below 0.105820 g, the activation, either.
    """
    d = np.linspace(0.0, 0.004, 21)
    fit = fit_rigid((d, 0.3 * (1.0 - d / 0.004)))
    together = capacity_curve(fit, 0.8, 0.5, 1.35)
    assert together.a_0_star == pytest.approx(0.277778, rel=2e-6)
    capacity = capacity_curve(fit, 0.8, 0.5, 1.35, activation=Activation(1.0 / 7.0, 1.0))
    checks = verify(capacity, dict.fromkeys(("SLD", "SLV"), SOIL_A))
    assert checks["SLD"].a_g_g == pytest.approx(0.105820, rel=2e-6)
    assert checks["SLV linear"].a_g_g == pytest.approx(0.211640, rel=2e-6)
    assert (checks["SLV"].governing, checks["SLV"].a_g_g) == ("activation", pytest.approx(0.105820, rel=2e-6))
    assert verify(together, {"SLV": SOIL_A})["SLV"].a_g_g == pytest.approx(0.277778, rel=2e-6)
    for line in checks["SLD"].trace:
        if line.formula:
            assert recomputed(line.formula, line.inputs) == pytest.approx(line.result, rel=1e-12)


def test_references_by_hand():
    """The same block, soil A on a ridge (T2, S = 1.2): SLC a_g = 0.474080/1.2 = 0.395067 g on rock, S a_g = 0.474080 g.

    a_g demanded 0.25 g on rock, 0.30 g at the surface; the peak of a record is that of its surface.
    """
    check = verify(_block(), {"SLC": ElasticSpectrum(0.25, 2.4, 0.30, "A", "T2")})["SLC"]
    assert (check.reference, check.S, check.demand_S) == ("rock", 1.2, 1.2)
    assert (check.a_g_g, check.pga_g) == (
        pytest.approx(0.395067, rel=2e-6),
        pytest.approx(0.474080, rel=2e-6),
    )
    assert check.demand_pga_g == pytest.approx(0.30)
    assert check.zeta_E == pytest.approx(check.pga_g / 0.30)
    of_record = verify(_block(), {"SLC": RECORD})["SLC"]
    assert (of_record.reference, of_record.pga_g) == ("surface", of_record.a_g_g)


def test_circular_of_2009_by_hand():
    """Same block: d_u* = 0.4·0.3 = 0.12 m; d_s = 0.4·0.12 = 0.048 m, a_s = 0.84·0.142857 = 0.12 g.

    T_s = 2π √(0.048/(0.12·9.80665)) = 2π·0.201962 = 1.268965 s; S_e = 0.25·2.4·0.3/1.268965 = 0.141848 g,
    S_De = 0.141848·9.80665·(1.268965/2π)² = 0.0567392 m, a_g = 0.25·0.12/0.0567392 = 0.528735 g.
    """
    checks = verify(_block(), {"SLV": SOIL_A, "SLC": SOIL_A}, Method(circular="2009"))
    np.testing.assert_allclose(checks["SLV"].T_s, 1.268965, rtol=1e-6)
    assert checks["SLV"].a_g_g == pytest.approx(0.528735, rel=2e-6)
    assert checks["SLV"].damping == 0.05
    assert checks["SLC"].a_g_g is None
    assert "2009" in checks["SLC"].notes[0]


def test_linear_check_at_the_ground_by_hand():
    """a_0* = 0.1273/(0.7574·1.35) = 0.124500 g; soil B, a_g = 0.261 g, F0 = 2.36: S = 1.4 − 0.4·2.36·0.261 = 1.153616.

    SLV, q = 2: a_g S/q = 0.150547 g > a_0*; a_g = 2·0.124500/1.153616 = 0.215843 g, ratio 0.826985, however soft the
    elastic branch is.
    """
    ground = ElasticSpectrum(0.261, 2.36, 0.35, "B")
    for model in ("none", "trilinear"):
        check = verify(_block(0.1273, 0.034, 1.35, model, 0.7574), {"SLV": ground})["SLV linear"]
        assert (check.a_star_g, check.T_s) == (pytest.approx(0.124500, abs=1e-6), 0.0)
        assert check.demand_a_star_g == pytest.approx(0.150547, abs=1e-6)
        assert check.a_g_g == pytest.approx(0.215843, abs=1e-6)
        assert check.zeta_E == pytest.approx(0.826985, abs=1e-6)
        assert check.zeta_E == pytest.approx(check.a_star_g / check.demand_a_star_g)


def test_linear_check_at_height_by_hand():
    """T_1 = 0.5 s, γ = 1.2, soil A, a_g = 0.25 g: S_e(T_1) = 0.25·2.4·0.3/0.5 = 0.36 g; q = 2, a_0* = 1/7 g.

    ψ = 1: a_Z = 0.36·1.2·√(1 + 0.0004·25) = 0.434155 g (2009: 0.432 g), a_Z/q = 0.217077 g,
    a_g = 0.25·0.142857/0.217077 = 0.164523 g. ψ = 0.5: a_Z = 0.217077 g < a_g S = 0.25 g, which counts:
    a_g S/q = 0.125 g.
    """
    expected = {1.0: (0.217077, 0.164523), 0.5: (0.125, 0.285714)}
    for psi, (demand, a_g) in expected.items():
        check = verify(_block(), {"SLV": FloorSpectrum(SOIL_A, (Mode(0.5, 1.2, psi),))})["SLV linear"]
        assert check.demand_a_star_g == pytest.approx(demand, abs=1e-6)
        assert check.a_g_g == pytest.approx(a_g, abs=1e-6)
        assert check.zeta_E == pytest.approx(check.a_star_g / check.demand_a_star_g)
    floor = FloorSpectrum2009(SOIL_A, Mode(0.5, 1.2, 1.0))
    assert verify(_block(), {"SLD": floor}, Method(circular="2009"))["SLD"].demand_a_star_g == pytest.approx(
        0.432
    )


def test_activation_with_an_elastic_branch():
    """S_e(T_0, 5 %) = a_y*: the demand spectrum scaled to a_g passes through (T_0, a_y*)."""
    capacity = _block(model="trilinear")
    check = verify(capacity, {"SLD": SOIL_A})["SLD elastic"]
    assert check.T_s == capacity.T_0
    assert check.a_g_g / 0.25 * SOIL_A.acceleration(capacity.T_0) == pytest.approx(
        capacity.a_y_star, rel=1e-12
    )


def test_collapse_before_life_safety_on_the_plateau():
    """d_0* = 0.02 m, α0* = 0.1 g, elastic branch to (0.0002 m, 0.05 g), plateau to 0.01 m; soil D, T_C = 0.88388 s.

    F0 a_g = 0.6: S = 1.5, T_C = 1.25·√0.5 = 0.88388 s, plateau 0.25·1.5·2.4 η = 0.9 η g.
    SLV d = 0.008 m, a = 0.05 g: T = 5.277876 √(0.008/0.490333) = 0.674154 s < T_C, η = 0.877058:
        S_De = 0.789352·9.80665·(0.674154/2π)² = 0.0891147 m, a_g = 0.25·0.008/0.0891147 = 0.0224430 g
    SLC d = 0.012 m, a = 0.04 g: T = 4.900885 √(0.012/0.392266) = 0.857185 s < T_C, η = 0.816497:
        S_De = 0.734847·9.80665·(0.857185/2π)² = 0.134124 m, a_g = 0.25·0.012/0.134124 = 0.0223673 g: it counts for SLV.
    """
    d, alpha = np.array([0.0, 0.0002, 0.01, 0.02]), np.array([0.0, 0.05, 0.05, 0.0])
    capacity = capacity_curve(CurveFit("trilinear", 0.1, 0.02, 0.05 / 0.9, 0.05, 0.0002, d, alpha), 1.0, 1.0)
    demand = ElasticSpectrum(0.25, 2.4, 0.5, "D")
    checks = verify(capacity, dict.fromkeys(("SLV", "SLC"), demand))
    life, collapse = checks["SLV"], checks["SLC"]
    np.testing.assert_allclose([life.a_g_g, collapse.a_g_g], 0.0223673, rtol=1e-5)
    assert (life.d_star_m, life.governing) == (pytest.approx(0.012), "SLC reached first: 0.60 d_0")
    assert any("d_SLC is reached" in note for note in life.notes)
    steps = {line.symbol: line.result for line in life.trace}
    np.testing.assert_allclose([steps["a_g_life"], steps["a_g_collapse"]], [0.0224430, 0.0223673], rtol=1e-5)
    assert steps["a_g_SLV"] == life.a_g_g
    assert not any("differ in shape" in note for note in collapse.notes)
    other = verify(capacity, {"SLV": demand, "SLC": replace(demand, F0=2.6)})
    assert other["SLC"].a_g_g < other["SLV"].a_g_g and "differ in shape" in other["SLC"].notes[-1]


def test_local_limit():
    """A beam unseats at 0.2 m of the control point: d = 0.2·0.5 = 0.1 m < 0.18 m; at 0.5 m it does not."""
    near = verify(_block(), {"SLC": SOIL_A}, Method(local_limits={"SLC": 0.2}))["SLC"]
    assert (near.d_star_m, near.governing) == (pytest.approx(0.1), "local limit")
    far = verify(_block(), {"SLC": SOIL_A}, Method(local_limits={"SLC": 0.5}))["SLC"]
    assert (far.d_star_m, far.governing) == (pytest.approx(0.18), "0.60 d_0")
    # the blocks go 0.7 times as far as the point: 0.07 m
    slow = Way(np.array([0.0, 1.0]), np.array([0.0, 0.7]))
    capacity = _block()
    capacity = replace(capacity, fit=replace(capacity.fit, way=slow))
    near = check_nonlinear(capacity, "SLC", SOIL_A, Method(local_limits={"SLC": 0.2}))
    assert (near.d_star_m, near.governing) == (pytest.approx(0.07), "local limit")


def test_the_blocks_and_the_point_lead_to_each_other_between_points_of_a_way_and_beyond():
    """0.7 m at 1 m, 1 m at 2 m: 0.85 m at 1.5 m, and beyond the last point in its proportion of a half."""
    way = Way(np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.7, 1.0]))
    assert way.blocks([0.0, 1.5, 3.0]) == pytest.approx([0.0, 0.85, 1.5])
    assert way.control_point([0.0, 0.85, 1.5]) == pytest.approx([0.0, 1.5, 3.0])


def test_the_end_of_the_elastic_curve_governs_where_it_comes_first():
    """d_0* = 0.3 m; elastic contacts fall at 0.3 m of the control point: d = 0.3·0.5 = 0.15 m < 0.18 m, not < 0.12 m.

    SLC: α = 0.142857·(1 − 0.15/0.3) = 0.0714286 g, T = 4.900885 √(0.15/0.700475) = 2.267900 s. At 0.15 m it governs SLV
    too, and a local limit of 0.1 m comes before it.
    """
    capacity = _block()
    soft = replace(capacity, fit=replace(capacity.fit, elastic_end=0.3))
    checks = verify(soft, dict.fromkeys(("SLV", "SLC"), SOIL_A))
    assert (checks["SLC"].d_star_m, checks["SLC"].governing) == (
        pytest.approx(0.15),
        "end of the elastic curve",
    )
    assert pytest.approx(2.267900, rel=1e-6) == checks["SLC"].T_s
    assert checks["SLV"].governing == "0.40 d_0"
    softer = replace(capacity, fit=replace(capacity.fit, elastic_end=0.15))
    assert check_nonlinear(softer, "SLV", SOIL_A).d_star_m == pytest.approx(0.075)
    near = check_nonlinear(softer, "SLC", SOIL_A, Method(local_limits={"SLC": 0.1}))
    assert (near.d_star_m, near.governing) == (pytest.approx(0.05), "local limit")


def test_capacity_that_is_not_defined():
    fit = fit_rigid(([0.0, 0.1], [0.1, 0.08]))
    checks = verify(capacity_curve(fit, 1.0, 0.5), dict.fromkeys(("SLD", "SLV", "SLC"), SOIL_A))
    assert checks["SLD"].a_g_g == pytest.approx(0.1)
    assert checks["SLV linear"].a_g_g == pytest.approx(0.2)
    assert checks["SLC"].a_g_g is None
    assert checks["SLC"].zeta_E is None
    assert "d_0 is not reached" in checks["SLC"].notes[0]


def test_return_period_scaling_solves_its_own_equation(hazard):
    """The spectrum of the capacity's return period, S_S, F0, T_C*, T_D with it, meets d* to 1e-10."""
    spectrum = ElasticSpectrum(0.15, 2.4, 0.30, "C")
    method = Method(scaling="return_period", hazard=hazard)
    for d_0 in (0.2, 0.4, 0.6):
        check = verify(_block(d_0=d_0), {"SLC": spectrum}, method)["SLC"]
        assert check.governing == "0.60 d_0"
        there = hazard.at(check.return_period_years)
        found = ElasticSpectrum(there.ag, there.F0, there.Tc_star, "C", damping=0.10)
        assert check.a_g_g == pytest.approx(there.ag, rel=1e-9)
        assert found.displacement(check.T_s) == pytest.approx(check.d_star_m, rel=1e-10)
        assert check.zeta_E == pytest.approx(check.a_g_g * found.S / (0.15 * spectrum.S), rel=1e-9)
    huge = verify(_block(d_0=20.0), {"SLC": spectrum}, method)["SLC"]
    assert any("2475" in note for note in huge.notes)
    assert huge.return_period_years == pytest.approx(2475.0)


def test_both_ways_of_scaling_by_hand():
    """Soil B, a_g = 0.25 g, F0 = 2.5, T_C* = 0.3 s: S = 1.4 − 0.4·2.5·0.25 = 1.15, T_C = 1.1·0.3^0.8 = 0.419842 s,
    T_D = 4·0.25 + 1.6 = 2.6 s; S_De beyond it, 10 %: η = √(10/15) = 0.816497, 0.25·1.15·0.816497·2.5·0.419842·2.6·
    9.80665/4π² = 0.159130 m. The block reaches half of that, 0.079565 m, at T = 1.56 π √0.374708 = 3.0 s.

    Shape of the demand kept: ratio 0.5, a_g = 0.125 g. Along the hazard, F0 and T_C* the same at all T_R, S is 1.2 and
    T_D = 4 a_g + 1.6, so that r (4·r·0.2875/1.2 + 1.6) = 0.5·2.6: 0.958333 r² + 1.6 r − 1.3 = 0,
    r = (2.746513 − 1.6)/1.916667 = 0.598181, a_g = 0.143314 g. a_g grows tenfold from 30 to 2475 years:
    T_R = 30·82.5^log10(0.143314/0.05) = 30·82.5^0.457319 = 225.7 years; of 0.125 g 30·82.5^0.397940 = 173.7 years.
    """
    spectrum = ElasticSpectrum(0.25, 2.5, 0.3, "B")
    T_R = np.array([30.0, 50.0, 72.0, 101.0, 140.0, 201.0, 475.0, 975.0, 2475.0])
    values = np.column_stack(
        [0.05 * 10.0 ** (np.log(T_R / 30.0) / np.log(82.5)), np.full(9, 2.5), np.full(9, 0.3)]
    )
    hazard = HazardCurve("hand-made", values, values[None], np.zeros(1))
    block = _block(alpha_0=0.079565 / (0.374708 * GRAVITY) / 0.4, d_0=2.0 * 0.079565 / 0.6)
    shape = verify(block, {"SLC": spectrum}, Method(hazard=hazard))["SLC"]
    along = verify(block, {"SLC": spectrum}, Method(scaling="return_period", hazard=hazard))["SLC"]
    assert (shape.d_star_m, shape.T_s) == (pytest.approx(0.079565), pytest.approx(3.0, abs=1e-3))
    assert (shape.zeta_E, shape.a_g_g) == (pytest.approx(0.5, abs=2e-5), pytest.approx(0.125, abs=5e-6))
    assert (along.zeta_E, along.a_g_g) == (
        pytest.approx(0.598181, abs=2e-5),
        pytest.approx(0.143314, abs=5e-6),
    )
    assert along.return_period_years == pytest.approx(225.7, abs=0.1)
    assert shape.return_period_years == pytest.approx(173.7, abs=0.1)


def test_record_against_the_demand_of_the_site():
    check = verify(_block(), {"SLC": RECORD}, Method(site_acceleration={"SLC": 0.3}))["SLC"]
    assert check.demand_a_g_g == 0.3
    assert check.zeta_E == pytest.approx(check.a_g_g / 0.3)
    assert check.return_period_years is None
    with pytest.raises(ValueError, match="return_period"):
        hazard = HazardCurve("h", np.ones((9, 3)), np.ones((1, 9, 3)), np.zeros(1))
        verify(_block(), {"SLC": RECORD}, Method(scaling="return_period", hazard=hazard))


def test_floor_spectrum_by_hand():
    """One mode T_1 = 0.5 s, γ ψ = 1.2·0.5 = 0.6, ξ_1 = 5 %; ground: soil A, a_g = 0.25 g: S_e(0.5) = 0.36 g.

    a_Z = 0.36·0.6·√(1 + 0.0004·25) = 0.217077 g; ξ = 8 %: η = 0.877058, A = 1.1·0.877058/√0.05 = 4.314555.
    T = 0: a_Z; 0.4 ≤ T < 0.55: A a_Z = 0.936592 g; T = 0.2: A a_Z/(1 + 3.314555·0.5^1.6) = 0.447403 g;
    T = 1.1: A a_Z/(1 + 3.314555) = 0.217077 g, above S_e(1.1, 8 %) = 0.25·2.4·0.877058·0.3/1.1 = 0.143519 g.
    The ground governs at T = 0 (a_g S = 0.25 g) and T = 0.2 (0.25·2.4·0.877058 = 0.526235 g); at twice the height the
    modes do, with twice as much.
    """
    floor = FloorSpectrum(SOIL_A.with_damping(0.08), (Mode(0.5, 1.2, 0.5),))
    a_Z = 0.36 * 0.6 * 1.01**0.5
    A = 1.1 * (10 / 13) ** 0.5 / 0.05**0.5
    assert a_Z == pytest.approx(0.217077, abs=1e-6)
    np.testing.assert_allclose(A, 4.314555, atol=1e-6)
    T, modes = [0.0, 0.2, 0.4, 0.54, 1.1], np.array([0.217077, 0.447403, 0.936592, 0.936592, 0.217077])
    np.testing.assert_allclose(floor.acceleration(T), [0.25, 0.526235, *modes[2:]], atol=1e-6)
    top = FloorSpectrum(SOIL_A.with_damping(0.08), (Mode(0.5, 1.2, 1.0),))
    np.testing.assert_allclose(top.acceleration(T), 2.0 * modes, atol=2e-6)
    low = FloorSpectrum(SOIL_A, (Mode(0.5, 1.2, 0.05),))  # near the ground: nowhere below S_e
    assert low.acceleration(0.8) == SOIL_A.acceleration(0.8)
    assert low.acceleration(0.2) == SOIL_A.acceleration(0.2)
    plateau_end = A * a_Z * GRAVITY * (0.55 / (2 * np.pi)) ** 2
    assert floor.largest_displacement(0.0, 0.7) == (pytest.approx(plateau_end), 0.55)
    assert first_mode(0.5, 3, 4.0, 10.0).gamma == pytest.approx(9 / 7)


def test_a_check_with_the_demand_at_one_period_is_verified_by_the_maximum_of_the_circular():
    """An index of 1.15 was told as verified where the maximum of a record's S_De over [T_0, T] gave 0.46."""
    swinging = RecordSpectrum(0.1 * np.sin(9.0 * T) * np.sin(0.2 * T), 0.01)
    found = {"at_period": [], "maximum": []}
    for d_0 in np.geomspace(0.1, 3.0, 25):
        for demand, checks in found.items():
            method = Method(displacement_demand=demand)
            checks.append(check_nonlinear(_block(0.05, d_0), "SLC", swinging, method))
    pairs = list(zip(*found.values(), strict=True))
    assert any(at.zeta_E >= 1.0 > most.zeta_E for at, most in pairs)
    assert all(at.verified == most.verified for at, most in pairs)
    told = ["maximum over [T_0, T]" in " ".join(at.notes) for at, most in pairs]
    assert told == [at.a_g_g > 1.001 * most.a_g_g for at, most in pairs]


def test_mechanism_at_height():
    """Activation: a_Z(z) = a_0*; the nonlinear check solves S_DeZ = d with the floor spectrum."""
    floor = FloorSpectrum(SOIL_A, (first_mode(0.4, 3, 7.0, 10.0), Mode(0.13, -0.4, 0.6)))
    checks = verify(_block(), {"SLD": floor, "SLC": floor})
    assert checks["SLD"].a_g_g / 0.25 * floor.acceleration(0.0) == pytest.approx(1 / 7)
    damped = floor.with_damping(0.10)
    demand, _ = damped.largest_displacement(0.0, checks["SLC"].T_s)
    assert checks["SLC"].a_g_g / 0.25 * demand == pytest.approx(checks["SLC"].d_star_m, rel=1e-10)


def test_mechanism_at_height_2009():
    """ψ = 0.5, γ = 1.2, T_1 = 0.5: S_e(T_1) ψ γ = 0.216 g < a_g S = 0.25 g, so the ground governs.

    S_De(0.5) = 0.36·9.80665·(0.5/2π)² = 0.0223563 m; at T = 1 s, ψ = 1: 1.2·0.0223563·2²/√(1 + 0.02·2) = 0.105227 m,
    the ground 0.0447127 m.
    """
    floor, top = (FloorSpectrum2009(SOIL_A, Mode(0.5, 1.2, psi)) for psi in (0.5, 1.0))
    assert floor.acceleration(0.0) == pytest.approx(0.25)
    assert top.acceleration(0.0) == pytest.approx(0.432)
    assert floor.acceleration(0.5) == pytest.approx(0.216 / 0.02**0.5), "in resonance"
    assert top.displacement(1.0) == pytest.approx(0.105227, rel=1e-5)
    assert top.demand_steps(0.0, 1.0)[-1].result == top.displacement(1.0)
    assert floor.displacement(1.268965) == SOIL_A.displacement(1.268965)


def _traces(hazard):
    floor = FloorSpectrum(SOIL_A, (first_mode(0.4, 3, 7.0, 10.0), Mode(0.13, -0.4, 0.6)))
    cases = [
        ("none", ElasticSpectrum(0.25, 2.4, 0.3, "C", "T2"), Method(hazard=hazard)),
        ("trilinear", ElasticSpectrum(0.25, 2.4, 0.3, "D"), Method(scaling="return_period", hazard=hazard)),
        ("bilinear", RECORD, Method(local_limits={"SLC": 0.3, "SLV": 0.9})),
        ("trilinear", RECORD, Method(displacement_demand="at_period", site_acceleration={"SLV": 0.3})),
        ("none", floor, Method()),
        ("trilinear", floor, Method()),
        ("none", SOIL_A, Method(circular="2009")),
        ("none", FloorSpectrum2009(SOIL_A, Mode(0.5, 1.2, 0.5)), Method(circular="2009")),
    ]
    for model, spectrum, method in cases:
        for d_0 in (0.02, 0.3, 3.0):
            demands = dict.fromkeys(STATES, spectrum)
            yield from verify(_block(0.2, d_0, 1.35, model, 0.8), demands, method).items()


def test_the_trace_ends_in_the_numbers_of_the_check(hazard):
    for name, check in _traces(hazard):
        if check.a_g_g is None:
            continue
        limit = name.split()[0]
        results = {line.symbol: line.result for line in check.trace}
        last = {"elastic": "a_g_act", "linear": "a_g_linear", "nonlinear": f"a_g_{limit}"}
        other = {"linear": "a_g_act", "nonlinear": "a_g_nonlinear"}
        symbol = last[check.method] if last[check.method] in results else other[check.method]
        assert results[symbol] == check.a_g_g
        indexed = limit == "SLV"  # §8.3: at the others it is a ratio and no index
        assert results["zeta_E" if indexed else f"r_{limit}"] == check.zeta_E
        assert ("zeta_E" in results) == indexed
        assert results["a_g_demand"] == check.demand_a_g_g


def test_trace_of_participation_hazard_and_return_period():
    lines = [*participation([10.0, 19.1], [0.5, 1.0], 1.0).steps(), *return_period_steps("SLV", 50, "III")]
    lines += site_curve(None, 42.35, 13.40).steps(return_period("SLV"))
    for line in lines:
        if line.formula:
            assert recomputed(line.formula, line.inputs) == pytest.approx(line.result, rel=1e-9)
