"""Indices of safety and of risk, and what interventions must reach, by hand."""

import pytest
from scipy.optimize import brentq

from assessment.ntc.tables import (
    CLASSES,
    attained,
    expected_annual_loss,
    heritage_and_risk_indices,
    required_zeta,
)
from tests.support.trace_check import recomputed


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
