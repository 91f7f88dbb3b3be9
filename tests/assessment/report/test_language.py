"""How columns are written: units of the heading, digits, dashes; no specification of a column that there is not."""

import pytest

from assessment.report.language import LANGUAGES, Words, cell, heading, written
from assessment.results.schema.part import QUANTITIES, Part, key

ENGLISH = Words.of("en")


def test_every_quantity_is_labelled_in_both_languages_and_once():
    """A column of a table that nothing describes stops the report; one described twice stops the program."""
    assert all(found.label.keys() == set(LANGUAGES) for found in QUANTITIES.values())
    with pytest.raises(ValueError, match="alpha_0: described in another table too"):
        type("Again", (Part,), {"__annotations__": {"alpha_0": float}, "alpha_0": key("", "α")})


def test_a_ratio_is_told_from_one():
    """ "1,00 non verificato" was printed of 0.9996."""
    assert [ENGLISH.ratio(each) for each in (0.9996, 1.0, 0.0975, 0.004, 0.48, 3.434, 12.34)] == [
        *("0.9996", "1.00", "0.098", "0.0040", "0.48", "3.43", "12.3")
    ]


def test_a_value_is_written_in_the_unit_of_its_heading():
    assert heading("d_0_m", ENGLISH, "rock").striptags() == "d0 [mm]"
    assert written("d_0_m", 0.01234, ENGLISH) == "12.3"
    assert heading("static_loss", ENGLISH, "rock").endswith("[%]")
    assert written("static_loss", 0.1234, ENGLISH) == "12", "no more digits than it is known with"
    assert written("weight_kN", 12.34, ENGLISH) == "12.3", "any other number as results.json has it"


def test_only_the_headings_of_accelerations_say_what_they_refer_to():
    assert ENGLISH.plain("value.on_surface") in heading("a_g_g", ENGLISH, "surface")
    assert ENGLISH.plain("value.on_surface") in heading("pga_g", ENGLISH, "rock")
    assert ENGLISH.plain("value.on_rock") not in heading("alpha_0", ENGLISH, "rock")


def test_what_differs_by_rounding_alone_is_written_alike():
    words = Words.of("en")
    assert words.number(0.07865) == words.number(0.07865 * (1.0 + 3e-16)) == words.number(0.07865000000001)


def test_what_is_not_there_is_told_from_what_was_not_reached():
    dash, not_reached = ENGLISH("value.none"), ENGLISH("value.not_reached")
    assert cell("d_0_m", {}, ENGLISH) == dash != not_reached
    assert cell("d_0_m", {"d_0_m": None}, ENGLISH) == not_reached
    assert written("x_C_m", None, ENGLISH) == written("direction", None, ENGLISH) == dash
    assert written("median_low_g", None, ENGLISH) == written("beta_high", None, ENGLISH) == dash
    assert written("median_g", None, ENGLISH) == not_reached


def test_a_displacement_below_a_micrometre_is_rounding():
    """ "peak 4.62e-10 mm" was printed of a block that does not move."""
    words = Words.of("en")
    assert (
        words.told("movement_m", 4.6e-13) == "< 0.001\u00a0mm"
        and words.told("movement_m", 0.0) == "0\u00a0mm"
    )
    assert words.told("movement_m", 2.3e-6) == "0.00230\u00a0mm"
    assert str(written("peak_displacement_m", 4.6e-13, words)) == "0"
