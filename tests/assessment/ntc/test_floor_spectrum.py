"""Floor spectra begin at the ground: a mechanism at height never sees less than it (C7.2.3; C8A.4.2.3 of 2009)."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assessment.ntc.capacity_curve import capacity_curve, fit_curve, fit_rigid
from assessment.ntc.floor_spectrum import FloorSpectrum, FloorSpectrum2009, Mode, first_mode
from assessment.ntc.spectrum import ElasticSpectrum
from assessment.ntc.verification import Method, verify
from tests.support.block_project import HAZARD, PUSHED, block, results_of, write_block
from tests.support.trace_check import recomputed

PERIODS = np.concatenate([[0.0], np.geomspace(0.01, 12.0, 400)])
H = 10.0  # m, height of the building
STATES = ("SLD", "SLV", "SLC")


def floor_spectrum(circular, ground, z, period=0.4, storeys=3, higher=()):
    first = first_mode(period, storeys, z, H)
    return FloorSpectrum2009(ground, first) if circular == "2009" else FloorSpectrum(ground, (first, *higher))


def capacity(alpha_0, d_0, model="none", e_star=0.75, gamma_star=0.66):
    d = np.linspace(0.0, d_0, 50)
    rigid = (d, alpha_0 * (1.0 - d / d_0))
    elastic = (np.array([0.0, 0.02, 0.06]) * d_0, np.array([0.0, 0.8, 0.85]) * alpha_0)
    fit = fit_rigid(rigid) if model == "none" else fit_curve("trilinear", rigid, elastic)
    return capacity_curve(fit, e_star, gamma_star, 1.35)


@st.composite
def grounds(draw):
    return ElasticSpectrum(
        draw(st.floats(0.03, 0.5)), draw(st.floats(2.2, 3.0)), draw(st.floats(0.2, 0.6)),
        draw(st.sampled_from("ABCDE")), draw(st.sampled_from(["T1", "T4"])),
    )  # fmt: skip


@given(
    ground=grounds(), circular=st.sampled_from(["2019", "2009"]), period=st.floats(0.05, 1.5),
    storeys=st.integers(1, 8), z=st.floats(0.0, H), damping=st.sampled_from([0.05, 0.08, 0.10]),
)  # fmt: skip
@settings(max_examples=15)
def test_the_spectrum_at_height_is_nowhere_below_that_of_the_ground(
    ground, circular, period, storeys, z, damping
):
    """S_eZ(T) ≥ S_e(T) and S_DeZ(T) ≥ S_De(T) for every T, so a_Z ≥ a_g S."""
    floor = floor_spectrum(circular, ground, z, period, storeys).with_damping(damping)
    under = ground.with_damping(damping)
    assert (floor.acceleration(PERIODS) >= under.acceleration(PERIODS)).all()
    assert (floor.displacement(PERIODS) >= under.displacement(PERIODS)).all()
    assert float(floor.acceleration(0.0)) >= ground.ag * ground.S * (1.0 - 1e-12)
    for T in (0.1, 1.0, 3.0, 8.0):
        assert floor.largest_displacement(0.0, T)[0] >= under.largest_displacement(0.0, T)[0]


@given(
    ground=grounds(), circular=st.sampled_from(["2019", "2009"]), period=st.floats(0.05, 1.5),
    alpha_0=st.floats(0.03, 0.4), d_0=st.floats(0.02, 4.0), model=st.sampled_from(["none", "trilinear"]),
)  # fmt: skip
@settings(max_examples=15)
def test_capacity_starts_at_the_ground_and_never_rises_with_height(
    ground, circular, period, alpha_0, d_0, model
):
    """A sweep of z from 0 to H; d_0 up to 4 m takes T past T_E, where the ground's S_De falls."""
    limits = STATES if circular == "2019" else ("SLD", "SLV")
    method, curve = Method(circular=circular), capacity(alpha_0, d_0, model)

    def borne(spectrum):
        return [check.a_g_g for check in verify(curve, dict.fromkeys(limits, spectrum), method).values()]

    at = [borne(floor_spectrum(circular, ground, z, period)) for z in np.linspace(0.0, H, 6)]
    np.testing.assert_allclose(at[0], borne(ground), rtol=1e-12)
    for lower, higher in itertools.pairwise(at):
        assert all(b <= a * (1.0 + 1e-12) for a, b in zip(lower, higher, strict=True))


def test_the_higher_of_modes_and_ground_is_traced_by_hand():
    """Low down the ground governs, high up the modes; beyond b T_1 the plateau's end."""
    ground = ElasticSpectrum(0.25, 2.4, 0.5, "D")
    governs = set()
    for z, T in itertools.product((0.0, 0.3, 2.0, 9.0), (0.0, 0.2, 0.43, 0.45, 0.6, 3.0, 7.0)):
        floor = floor_spectrum("2019", ground, z, higher=(Mode(0.13, -0.4, 0.1),))
        lines = floor.demand_steps(0.0, T) if T else floor.steps(T)
        for line in lines:
            if line.formula:
                assert recomputed(line.formula, line.inputs) == pytest.approx(line.result, rel=1e-9)
        expected = floor.largest_displacement(0.0, T)[0] if T else float(floor.displacement(T))
        assert lines[-1].result == pytest.approx(expected, rel=1e-12)
        governs.add(lines[-1].formula)
    assert len(governs) >= 3


def test_modes_are_added_by_the_root_of_their_squares_by_hand():
    """Soil A, a_g = 0.25 g, F0 = 2.4, T_C = 0.3 s, 5 %: T_1 = 0.5 s, γψ = 0.6: a_Z1 = 0.36·0.6·√1.01 = 0.217077 g;
    T_2 = 0.15 s, γψ = −0.2: a_Z2 = 0.6·0.2·√1.01 = 0.120599 g; A = 1.1/√0.05 = 4.919350.

    T = 0.15 s: the second on its plateau, 4.919350·0.120599 = 0.593267 g; the first 4.919350·0.217077/(1 +
    3.919350·0.625^1.6) = 1.067877/2.847660 = 0.375002 g; √(0.351966 + 0.140627) = 0.701850 g, above the ground's 0.6.
    T = 0: √(0.047122 + 0.014544) = 0.248327 g, below the ground's a_g S = 0.25 g, which counts.
    """
    ground = ElasticSpectrum(0.25, 2.4, 0.3, "A")
    floor = FloorSpectrum(ground, (Mode(0.5, 1.2, 0.5), Mode(0.15, -0.4, 0.5)))
    assert float(floor.acceleration(0.15)) == pytest.approx(0.701850, abs=2e-6)
    assert float(floor.acceleration(0.0)) == 0.25
    twice = FloorSpectrum(ground, (Mode(0.5, 2.4, 0.5), Mode(0.15, -0.8, 0.5)))
    assert float(twice.acceleration(0.0)) == pytest.approx(2.0 * 0.2483275, abs=2e-6)


@pytest.mark.parametrize("circular", [2019, 2009])
def test_a_height_of_zero_means_the_ground(tmp_path, circular):
    """It divided by zero."""
    from assessment.project.project import load_project

    site = f'[assessment.site]\nsoil = "B"\n{HAZARD}'
    floor = f"[assessment.floor]\nheight_m = 0\nbuilding_height_m = {H}\nstoreys = 2\nperiod_s = 0.3\n"
    limits = '["SLD", "SLV"]'
    tables = f'[assessment]\ncircular = {circular}\nlimit_states = {limits}\nmodel = "none"\n'
    found = []
    for name, text in (("ground", tables + site), ("floor", tables + floor + site)):
        project = load_project(write_block(tmp_path / name, block() + PUSHED + text))
        results = results_of(project)
        found.append(results["states"]["original"]["capacity"]["+x"])
        assert {content["kind"] for content in results["spectra"].values()} == {"ground"}
    assert found[0] == found[1]


def test_the_period_of_the_building_follows_from_its_height_where_it_is_not_given(tmp_path):
    """H = 10 m, T_1 = 0.281171 s; with 0.4 s given that counts, and no formula is printed."""
    from assessment.analyses.demand import demand_parts, demand_spectra
    from assessment.project.project import load_project

    site = f'[assessment]\nmodel = "none"\n[assessment.site]\nsoil = "B"\n{HAZARD}'
    floor = f"[assessment.floor]\nheight_m = 7\nbuilding_height_m = {H}\nstoreys = 2\n"
    for name, period, expected in (("formula", "", 0.281171), ("given", "period_s = 0.4\n", 0.4)):
        project = load_project(write_block(tmp_path / name, block() + PUSHED + site + floor + period))
        demands = demand_spectra(project)
        assert pytest.approx(expected, abs=1e-6) == demands.spectra["SLV"].T_1
        lines = {line.symbol: line for line in demand_parts(project, demands)["SLV"].trace}
        assert ("T_1" in lines) == (not period)
        if not period:
            assert lines["T_1"].result == pytest.approx(expected, abs=1e-6)
