"""Headings: units and quantities however they are spelt, and what is refused."""

import pytest

from mechanics.records.headings import column, labels, speaks_of_units
from mechanics.types import GRAVITY

SPELT = {
    "m/s²": "m/s2 m/s^2 m/s**2 m/s/s m/sec2 m/sec/sec m/sec^2 ms-2 ms^-2 m*s^-2 m.s-2 m·s⁻² m_s2 mps2 mpss "
    "m/(s^2) m/(s*s) m/s-2 m/s^{2} m/s²",
    "cm/s²": "cm/s2 cm/s^2 CM/SEC**2 cm/sec/sec cms-2 cm/s² cmps2",
    "mm/s²": "mm/s2 mm/s/s mms-2",
    "ft/s²": "ft/s2 ft/sec2 ft/s^2",
    "in/s²": "in/s2 in/sec^2",
    "g": "g G g's G.",
    "% g": "%g",
    "mg": "mg",
    "gal": "gal Gal gals GAL",
    "mgal": "mGal",
}
PHRASES = {
    "m/s²": [
        "m s^-2", "m per s2", "m s -2", "metres per second squared", "metri al secondo quadrato",
        "m/s al quadrato",
    ],
    "% g": ["% g", "percent g", "per cento g", "% of g"],
    "g": ["in g", "units of g"],
}  # fmt: skip
IN_METRES = {  # per second squared
    "m/s²": 1.0, "cm/s²": 0.01, "mm/s²": 1e-3, "ft/s²": 0.3048, "in/s²": 0.0254, "gal": 0.01, "mgal": 1e-5,
    "g": GRAVITY, "% g": 0.01 * GRAVITY, "mg": 1e-3 * GRAVITY,
}  # fmt: skip
ALL = [(name, text) for name, own in SPELT.items() for text in own.split()]
ALL += [(name, text) for name, own in PHRASES.items() for text in own]


@pytest.mark.parametrize(("name", "text"), ALL)
@pytest.mark.parametrize("label", ["{}", "Accelerazione NS, {}"])
def test_a_unit_is_known_however_it_is_spelt(name, text, label):
    found = column(label.format(text))
    assert (found.quantity, found.unit) == ("acceleration", name)
    assert found.size == pytest.approx(IN_METRES[name] / GRAVITY, rel=1e-12)


@pytest.mark.parametrize(
    ("label", "unit_name", "size"),
    [("time [ms]", "ms", 1e-3), ("Time_s", "s", 1.0), ("Time [µs]", "µs", 1e-6)],
)
def test_times(label, unit_name, size):
    found = column(label)
    assert (found.quantity, found.unit, found.size) == ("time", unit_name, size)


@pytest.mark.parametrize(
    "label", ["a", "acc", "NS", "Ground acceleration", "a_g", "ax", "accelerazione orizzontale"]
)
def test_accelerations_without_a_unit_are_in_g(label):
    assert column(label).unit == "g"


@pytest.mark.parametrize(
    ("label", "quantity"),
    [
        ("velocity (cm per s)", "velocity"), ("velocità", "velocity"), ("Displacement (cm)", "displacement"),
        ("index", "count"), ("", "count"),
    ],
)  # fmt: skip
def test_what_is_no_acceleration_is_told(label, quantity):
    assert column(label).quantity == quantity


@pytest.mark.parametrize(
    ("heading", "separator", "parted"),
    [
        ("t;a", ";", ["t", "a"]),
        ("t;a;", ";", ["t", "a"]),
        ("Time, s\tAcc, g", None, ["Time, s", "Acc, g"]),
        ("Time (s)  Acceleration (m/s2)", None, ["Time (s)", "Acceleration (m/s2)"]),
        ("Time (s) Acceleration (m/s2)", None, ["time (s) ", "acceleration (m/s2)"]),
        ("t s a m s^-2", None, ["t s ", "a m s^-2"]),
    ],
)
def test_a_heading_is_parted_as_its_numbers_or_by_its_words(heading, separator, parted):
    assert labels(heading, 2, separator) == parted


def test_comments_that_speak_of_units():
    assert all(
        map(
            speaks_of_units, ["in m/s", "cm/s^2", "gal", "Unità: g", "dt=0.01", "200 Hz", "passo", "velocità"]
        )
    )
    assert not any(
        map(speaks_of_units, ["L'Aquila 2009", "north", "made by hand", "filtered", "stazione AQG"])
    )
