"""A static and a dynamic capacity are compared on one reference only: PGA at the surface, without confidence factor."""

import numpy as np
import pytest

from assessment.analyses.checks.capacity import nominal_check
from assessment.ntc.capacity_curve import capacity_curve
from assessment.ntc.curve_fit import fit_rigid
from assessment.ntc.spectrum import ElasticSpectrum
from assessment.ntc.verification import Method, verify
from assessment.report.text.language import Words, heading
from assessment.results.table import brought_together


def test_static_capacity_is_brought_to_the_reference_of_the_dynamic_one():
    """Block of α0 = 1/7, d_0* = 0.3 m on a ridge (S = 1.2): with F_C = 1 the PGA of SLC is 0.474080 g at the surface.

    A dynamic PGA at collapse of 0.6 g is 0.6/0.474080 = 1.265609 times that, not 0.6/0.395067 of a_g on rock.
    At SLV, T = 1.994 s < T_D, F_C = 1 gives 0.383616 g at the surface.
    """
    d = np.linspace(0.0, 0.6, 21)
    capacity = capacity_curve(fit_rigid((d, (1.0 - d / 0.6) / 7.0)), 1.0, 0.5, 1.35)
    demands = dict.fromkeys(("SLV", "SLC"), ElasticSpectrum(0.25, 2.4, 0.30, "A", "T2"))
    nominal = nominal_check(capacity, demands, Method())
    assert nominal.limit_state == "SLC"
    assert nominal.pga_g == pytest.approx(0.474080, rel=2e-6)
    found = brought_together(nominal.pga_g, 0.6)
    assert found["dynamic_to_static"] == pytest.approx(1.265609, rel=2e-6)
    life = nominal_check(capacity, {"SLV": demands["SLV"]}, Method())
    assert life.pga_g == pytest.approx(0.383616, rel=2e-6)
    assert verify(capacity, demands)["SLV"].pga_g < life.pga_g
    assert brought_together(None, 0.6) == {"static_surface_pga_g": None, "dynamic_to_static": None}


def test_headings_say_what_an_acceleration_refers_to():
    words = Words.of("en")
    assert heading("a_g_g", words, "rock") == "a<sub>g</sub> on rock [g]"
    assert heading("a_g_g", words, "surface") == "a<sub>g</sub> at the surface [g]"
    assert heading("pga_collapse_g", words, "rock") == "PGA at collapse at the surface [g]"
    assert heading("e_star", words, "rock") == "e*"
