"""[identification] and [[measurement]]: what is said of wrong ones, and that a spreadsheet holds them."""

import pytest

from assessment.project.model import build_model
from assessment.project.project import ProjectError, load_project
from tests.support.surveyed_arch import CROWN, PIER, SPRINGING, entry, write_surveyed

GOOD = '[{ destro = ["x"] }]'
CRACK, LEAN, SPAN = (
    entry("crown", "crack", CROWN, 2.0),
    entry("pier", "lean", PIER, 1.0),
    entry("span", "span", SPRINGING, 9.0),
)


def said(folder, hypotheses, *entries):
    with pytest.raises(ProjectError) as error:
        build_model(load_project(write_surveyed(folder, hypotheses, *entries)))
    return str(error.value)


@pytest.mark.parametrize(
    ("hypotheses", "entries", "expected"),
    [
        ('[{ dstro = ["x"] }]', [CRACK], 'identification.hypotheses[1].dstro: no support "dstro"'),
        (
            f"{GOOD[:-1]}, {GOOD[1:]}",
            [CRACK],
            "identification.hypotheses[2]: the same as an earlier hypothesis",
        ),
        (
            '[{ destro = ["x", "z"] }]',
            [CRACK],
            "identification.hypotheses[1]: 2 unknowns from 1 measurements",
        ),
        (GOOD, [], "identification: there is nothing to explain; add [[measurement]]"),
        (GOOD, [CRACK.replace('"crack"', '"crak"')], 'measurement[1].kind: "crak" is wrong; write "crack"'),
        (
            GOOD,
            [CRACK.replace("sigma_mm = 0.2", "")],
            "measurement[1].sigma_mm: missing; a measurement of kind",
        ),
        (GOOD, [CRACK.replace("2.0", "-2.0")], "measurement[1].opening_mm: -2 is negative"),
        (
            GOOD,
            [LEAN.replace("sigma_mrad", "sigma_mm")],
            'measurement[1].sigma_mm: does not go with kind = "lean"',
        ),
        (
            GOOD,
            [SPAN.replace("[-0.27, 0.5]", "[0.28, 0.5]")],
            "measurement.span.from_m: in the same block as point_m",
        ),
        (
            GOOD,
            [SPAN.replace("[0.27, 0.5]", "[0.0, 0.5]", 1)],
            "span.point_m: [0.0, 0.5] must be in or on a block",
        ),
        (
            GOOD,
            [entry("air", "crack", (0.0, 0.5), 1.0)],
            "measurement.air.point_m: [0.0, 0.5] is at no joint",
        ),
    ],
)
def test_one_message_for_each_slip(tmp_path, hypotheses, entries, expected):
    found = said(tmp_path, hypotheses, *entries)
    assert expected in found and len(found.splitlines()) <= 2
