"""Symbols and formulas of the annex, as the report sets them."""

import pytest

from assessment.report.chapters.calculation_annex import typeset
from assessment.report.language import Words

ENGLISH, ITALIAN = Words.of("en"), Words.of("it")


@pytest.mark.parametrize(
    ("formula", "printed"),
    [
        ("a_0_star", "a<sub>0</sub>*"),
        ("T_C_star", "T<sub>C</sub>*"),
        ("a_0_star_v", "a<sub>0,v</sub>*"),
        ("Gamma_star", "Γ*"),
        ("IS_V", "IS-V"),
        ("Sigma_P_delta_2", "ΣPδ<sub>x</sub>²"),
        ("Sigma_P_delta**2/(Sigma_P*Sigma_P_delta_2)", "(ΣPδ<sub>x</sub>)<sup>2</sup>/(ΣP·ΣPδ<sub>x</sub>²)"),
        ("1.56*pi*sqrt(d/(a*g))", "1.56·π·√(d/(a·g))"),
        ("-T_SLV*log(1 - P_VR)/C_U", "−T<sub>SLV</sub>·ln(1 − P<sub>VR</sub>)/C<sub>U</sub>"),
        ("abs(gamma*psi)", "|γ·ψ|"),
        ("<b>*d_0", "&lt;b&gt;·d<sub>0</sub>"),
        (
            "T_R_demand*(PGA_capacity/PGA_demand)**(1/0.41)",
            "T<sub>R,D</sub>·(PGA<sub>C</sub>/PGA<sub>D</sub>)<sup>1/0.41</sup>",
        ),
        ("x**(2 - (1)**3)*y", "x<sup>2 − (1)<sup>3</sup></sup>·y"),
    ],
)
def test_signs_subscripts_and_superscripts(formula, printed):
    assert typeset(formula, ENGLISH) == printed


def test_decimal_comma_parts_arguments_by_a_semicolon():
    assert typeset("max(0.55, sqrt(10/(5 + 100*xi)))", ITALIAN) == "max(0,55; √(10/(5 + 100·ξ)))"
    assert typeset("1.1*T_C_star**(-0.2)", ITALIAN) == "1,1·T<sub>C</sub>*<sup>−0,2</sup>"
