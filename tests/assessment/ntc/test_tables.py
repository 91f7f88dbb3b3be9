"""Confidence factors, loads and their combination, and the vertical component, by hand."""

import pytest

from assessment.ntc.spectrum import ElasticSpectrum
from assessment.ntc.tables import COMPONENTS, confidence_factor, psi_2
from assessment.ntc.verification import vertical_component
from assessment.project.project import load_project
from assessment.report.chapters.remarks import vertical as vertical_sentences
from assessment.report.language import Words
from assessment.report.tables.capacity import vertical
from assessment.report.tables.structure import reported_loads
from mechanics import Assembly, Block, Material, limit_analysis
from tests.support.block_project import ASSESSMENT, PROJECT, results_of, write_block
from tests.support.structures import rectangle
from tests.support.trace_check import recomputed
from tests.support.typed import typed


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


def test_table_of_the_standard():
    """NTC 2018, Tab. 2.5.I: dwellings 0.3, crowds 0.6, archives 0.8, roofs 0; I and K only as the designer judges."""
    assert [psi_2(category, None) for category in "ABCDEFGH"] == [0.3, 0.3, 0.6, 0.6, 0.8, 0.6, 0.3, 0.0]
    assert psi_2("snow above 1000 m", None) == 0.2
    assert psi_2("K", 0.5) == 0.5
    assert psi_2(None, None) == 0.0


def test_permanent_and_variable_loads_are_combined(tmp_path):
    """G_1 = 45.36 kN, G_2 = 6 kN, Q = 10 kN of category C: 45.36 + 6 + 0.6·10 = 57.36 kN, all of it mass."""
    found = results_of(project(tmp_path))
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
    found = results_of(project(tmp_path, replaced))
    assert "vertical" not in found["states"]["original"]["capacity"]["+x"]
    [told] = vertical_sentences(typed(found), Words.of("en"))
    assert key in told


def test_the_vertical_component_is_checked_from_0_15_g_on(tmp_path):
    found = results_of(project(tmp_path, ("ag_g = 0.261", "ag_g = 0.151")))
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
