"""What standards tabulate, by hand: indices of safety and risk, confidence factors, loads, the vertical component."""

import pytest
from scipy.optimize import brentq

from assessment.ntc.risk import (
    CLASSES,
    attained,
    expected_annual_loss,
    heritage_and_risk_indices,
    required_zeta,
)
from assessment.ntc.spectrum import ElasticSpectrum
from assessment.ntc.tables import COMPONENTS, confidence_factor, psi_2
from assessment.ntc.verification import vertical_component
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.report.chapters.remarks import vertical as vertical_sentences
from assessment.report.language import Words
from assessment.report.tables.capacity import vertical
from assessment.report.tables.structure import reported_loads
from assessment.results.schema.part import plain
from assessment.workflow.stages import run
from mechanics import Assembly, Block, Material, limit_analysis
from tests.support.block_project import ASSESSMENT, PROJECT, write_block
from tests.support.structures import rectangle
from tests.support.trace_check import recomputed
from tests.support.typed import typed


def test_heritage_indices_by_hand():
    """a_SLV = 0.15 g of 0.25 g on rock, S 1.2 on both sides: f_a = ζ = 0.6; T_SLV = 140, T_R,SLV = 475 years.

    I_S = 140/475 = 0.294737; V_N = 140·0.1053605/C_U = 14.7505 years in class II, 9.83365 in class III. T_SLD = 40
    years: λ_SLD = 0.025, λ_SLV = 0.00714286, λ_SLO = 0.04175, λ_SLC = 0.0035.
    PAM = 0.0035 + 0.00364286·0.65 + 0.01785714·0.325 + 0.01675·0.11 + 0.05825·0.035 = 0.0155526: class C; IS-V 0.6: B.
    """
    found = heritage_and_risk_indices(0.15, 0.25, 0.6, "II", 140.0, 475.0, 40.0)
    assert (found.f_a, found.IS_V) == (pytest.approx(0.6), pytest.approx(0.6))
    assert found.IS_V_class == "B"
    assert pytest.approx(0.294737, abs=1e-6) == found.I_S
    assert found.acceptable_nominal_life_years == pytest.approx(14.7505, abs=1e-4)
    third = heritage_and_risk_indices(0.15, 0.25, 0.6, "III", 140.0, 475.0)
    assert third.acceptable_nominal_life_years == pytest.approx(9.83365, abs=1e-4)
    assert (third.PAM, third.risk_class) == (None, None)
    assert pytest.approx(0.0155527, abs=1e-7) == found.PAM
    assert (found.PAM_class, found.risk_class) == ("C", "C")
    units = {line.symbol: line.unit for line in found.trace}
    assert units["a_g_SLV"] == units["a_g_demand"] == "g"
    assert units["T_SLV"] == units["T_R_SLV"] == units["T_SLD"] == "years"
    for line in (row for row in found.trace if row.formula):
        assert recomputed(line.formula, line.inputs) == pytest.approx(line.result, rel=1e-9)


def test_a_new_building_loses_1_1_per_cent_a_year():
    """T_SLD = 50, T_SLV = 475 years: λ = 0.1, 0.0334, 0.02, 0.00210526, 0.00103158.

    PAM = 0.00103158 + 0.00107368·0.65 + 0.01789474·0.325 + 0.0134·0.11 + 0.0666·0.035 = 0.0113503: class B.
    """
    assert expected_annual_loss(50.0, 475.0)[0] == pytest.approx(0.0113503, abs=1e-7)
    found = heritage_and_risk_indices(0.25, 0.25, 1.0, "II", 475.0, 475.0, 50.0)
    assert (found.IS_V_class, found.PAM_class, found.risk_class) == ("A+", "B", "B")


@pytest.mark.parametrize(
    ("zeta", "expected"),
    [(1.0, "A+"), (0.99, "A"), (0.8, "A"), (0.6, "B"), (0.45, "C"), (0.3, "D"), (0.15, "E"), (0.14, "F")],
)
def test_classes_of_is_v(zeta, expected):
    assert heritage_and_risk_indices(zeta, 1.0, zeta, "II").IS_V_class == expected


@pytest.mark.parametrize(
    ("most", "within"),
    [(0.005, "A+"), (0.01, "A"), (0.015, "B"), (0.025, "C"), (0.035, "D"), (0.045, "E"), (0.075, "F")],
)
def test_classes_of_pam(most, within):
    """D.M. 58/2017, Tab. 1: the largest PAM of each class; capacities of one return period at SLD and SLV have it."""
    for share, expected in ((0.9999, within), (1.0001, CLASSES[CLASSES.index(within) + 1])):
        T = brentq(lambda years, pam=share * most: expected_annual_loss(years, years)[0] - pam, 10.0, 1e4)
        assert heritage_and_risk_indices(1.0, 1.0, 1.0, "II", T, 475.0, T).PAM_class == expected


def test_unknown_return_periods_leave_their_indices_out():
    found = heritage_and_risk_indices(0.1, 0.2, 0.5, "II")
    assert (found.I_S, found.acceptable_nominal_life_years, found.PAM, found.risk_class) == (
        None, None, None, None,
    )  # fmt: skip


def test_a_capacity_lost_at_once_costs_no_more_than_all():
    """T_SLD = T_SLV = 1 year: every frequency but SLC's is 0.1: PAM = 0.049 + 0.051·0.65 = 0.08215."""
    assert expected_annual_loss(1.0, 1.0)[0] == pytest.approx(0.08215)


def test_thresholds_of_interventions():
    """§8.4.2: 0.1 more in class II and the rest of class III; 0.6 in class IV and for schools of class III."""
    assert required_zeta(0.35, "II") == {
        "repair": None, "improvement": pytest.approx(0.45), "improvement_school": None, "retrofit_use": 0.8,
        "retrofit": 1.0,
    }  # fmt: skip
    assert required_zeta(0.35, "IV")["improvement"] == 0.6
    assert required_zeta(0.55, "IV")["improvement"] == 0.6  # not 0.1 more
    assert required_zeta(0.7, "IV")["improvement"] == 0.7
    assert required_zeta(0.35, "III")["improvement"] == pytest.approx(0.45)
    assert required_zeta(0.55, "III")["improvement_school"] == 0.6
    assert required_zeta(0.35, "I")["improvement"] is None
    assert required_zeta(0.95, "II")["improvement"] == 1.0
    unknown = required_zeta(None, "III")
    assert unknown["improvement"] is None and unknown["retrofit"] == 1.0


def test_an_intervention_is_attained_from_the_state_before():
    """1.01 from 0.299: improvement has to reach 0.399, not the 1.00 that follows from 1.01."""
    required = required_zeta(0.299, "III")
    assert required["improvement"] == pytest.approx(0.399)
    assert all(attained(1.01, required).values())
    assert attained(0.45, required) == {
        "improvement": True, "improvement_school": False, "retrofit_use": False, "retrofit": False,
    }  # fmt: skip


def test_confidence_factor_by_hand():
    """C8.5.4: LC2 1.20; D.P.C.M.: 1 + 0.05 + 0.12 + 0.06 + 0.03 = 1.26."""
    assert confidence_factor("LC2", {}).result == 1.20
    parts = {"geometry": 0.05, "construction": 0.12, "mechanical": 0.06, "ground": 0.03}
    found = confidence_factor(None, parts)
    assert found.result == pytest.approx(1.26)
    assert found.formula == "1 + F_C1 + F_C2 + F_C3 + F_C4"
    told = {
        "geometry": (5, 0),
        "construction": (12, 6, 0),
        "mechanical": (12, 6, 0),
        "ground": (6, 3, 0),
    }  # Tab. 4.1
    assert {
        name: tuple(round(100.0 * each, 9) for each in values) for name, values in COMPONENTS.items()
    } == told


OWN = 0.6 * 4.2 * 1.0 * 18.0  # kN
LOADED = '[layers.BLOCCO]\nvertical_load_kN = 6.0\nvariable_load_kN = 10.0\nuse_category = "C"\n[layers.BASE]'


def project(folder, *replaced, text=PROJECT + ASSESSMENT):
    for old, new in (("[layers.BASE]", LOADED), *replaced):
        assert old in text
        text = text.replace(old, new)
    return load_project(write_block(folder, text))


def results(project):
    return plain(run(project, build_model(project), jobs=1).results)


def test_table_of_the_standard():
    """NTC 2018, Tab. 2.5.I: dwellings 0.3, crowds 0.6, archives 0.8, roofs 0; I and K only as the designer judges."""
    assert [psi_2(category, None) for category in "ABCDEFGH"] == [0.3, 0.3, 0.6, 0.6, 0.8, 0.6, 0.3, 0.0]
    assert psi_2("snow above 1000 m", None) == 0.2
    assert psi_2("K", 0.5) == 0.5
    assert psi_2(None, None) == 0.0


def test_permanent_and_variable_loads_are_combined(tmp_path):
    """G_1 = 45.36 kN, G_2 = 6 kN, Q = 10 kN of category C: 45.36 + 6 + 0.6·10 = 57.36 kN, all of it mass."""
    found = results(project(tmp_path))
    [row] = found["loads"]
    assert (row["layer"], row["use_category"], row["psi_2"]) == ("BLOCCO", "C", 0.6)
    assert row["own_weight_kN"] == pytest.approx(OWN)
    assert (row["permanent_load_kN"], row["variable_load_kN"]) == (6.0, 10.0)
    assert [row["combined_kN"], row["seismic_weight_kN"]] == pytest.approx([57.36, 57.36])
    assert found["model"]["weight_kN"] == pytest.approx(57.36)
    [printed] = reported_loads(typed(found), Words.of("it")).rows
    assert printed["combined_kN"] == pytest.approx(57.36)
    capacity = found["states"]["original"]["capacity"]["+x"]
    assert found["states"]["original"]["pushover"]["+x"]["rigid"]["alpha_0"] == pytest.approx(1 / 7)
    check_vertical(capacity, found)


def check_vertical(capacity, found):
    """a_v = 1.35 √0.261 0.261 = 0.180009 g; λ = 1 − 0.3·0.180009 = 0.945997, (1 − a_v)/0.3 = 2.73.

    α0 = 1/7·0.945997 = 0.135142, a_0* = α0/1.35 = 0.100106 g; soil B, S = 1.4 − 0.4·2.36·0.261 = 1.153616, q = 2:
    demand 0.150547 g, ratio 0.664950.
    """
    made = capacity["vertical"]
    assert made["a_v_g"] == pytest.approx(0.180009, abs=1e-6)
    assert made["alpha_0"] == pytest.approx(0.135142, abs=2e-6)
    assert made["a_0_star_g"] == pytest.approx(0.100106, abs=2e-6)
    assert made["ratio"] == pytest.approx(0.664950, abs=1e-5)
    for line in made["trace"]:
        if line["formula"]:
            assert recomputed(line["formula"], line["inputs"]) == pytest.approx(line["result"], rel=1e-12)
    assert vertical(typed(found)).rows[0]["verified"] is made["verified"]
    [told] = vertical_sentences(typed(found), Words.of("it"))
    assert "0,261" in told and "è ripetuta" in told


def test_vertical_leading_governs_beyond_077_g():
    """S_T = 1.4, a_g = 0.6 g: a_v = 1.35·1.4·√0.6·0.6 = 0.878393; (1 − a_v)/0.3 = 0.405358 < 1 − 0.3 a_v = 0.736482."""
    made = vertical_component(ElasticSpectrum(0.6, 2.4, 0.3, "B", "T4"), 0.2, 0.2, 0.4)
    factor = next(line.result for line in made.trace if line.symbol == "lambda_v")
    assert made.a_v_g == pytest.approx(0.878393, abs=1e-6)
    assert factor == pytest.approx(0.405358, abs=3e-6)
    assert made.ratio == pytest.approx(0.5 * factor) == made.trace[-1].result


@pytest.mark.parametrize(
    ("replaced", "key"),
    [
        (("vertical_load_kN = 6.0", "vertical_load_kN = 6.0\nload_has_mass = false"), "left out"),
        (("friction = 0.7", "friction = 0.7\ncompressive_strength_kN_m2 = 3000.0"), "left out"),
        (("ag_g = 0.261", "ag_g = 0.149"), "not needed"),
    ],
)
def test_vertical_component_that_is_not_checked_is_told(tmp_path, replaced, key):
    found = results(project(tmp_path, replaced))
    assert "vertical" not in found["states"]["original"]["capacity"]["+x"]
    [told] = vertical_sentences(typed(found), Words.of("en"))
    assert key in told


def test_the_vertical_component_is_checked_from_0_15_g_on(tmp_path):
    found = results(project(tmp_path, ("ag_g = 0.261", "ag_g = 0.151")))
    assert found["states"]["original"]["capacity"]["+x"]["vertical"]["a_v_g"] > 0.0


def test_lighter_weights_scale_the_multiplier():
    """Blocks of the same mass that are lifted by a tenth of their weight bear 0.9 of α0, with sliding joints too."""

    def wall(load, mass):
        stone = Material(18.0, 0.4)
        base = Block(rectangle(-1.0, -0.3, 1.6, 0.0), 1.0, stone, support="base")
        blocks = [
            Block(rectangle(0.0, k, 0.6, k + 1), 1.0, stone, vertical_load=load, load_has_mass=mass)
            for k in range(3)
        ]
        return limit_analysis(Assembly([base, *blocks]), "+x").alpha

    whole, lighter = wall(0.0, True), wall(-0.1 * 0.6 * 18.0, False)
    assert lighter == pytest.approx(0.9 * whole, rel=1e-6)
