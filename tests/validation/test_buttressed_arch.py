"""The buttressed arch of the paper at 1:10 (projects/buttressed_arch): rigid, elastic, settled, with finite strength.

Rigid joints: the curve ends (α = 0) at 34.35 mm as drawn and at 26.18 mm settled, by an earlier version with contact
points. Exact beds, by a trial written apart: α_u 0.0476 as drawn, 0.02494 and 0.01388 settled. Rigid joints that
crush: α_0 of independent linear programs with tangent cuts. The last three of these were given for strengths rounded to
41.5, 24.9 and 16.6 kPa; at exactly those the same programs (tests/mechanics/solvers/test_program.py) give 0.07992,
0.04748 and 0.00665.
"""

import numpy as np
import pytest

from mechanics import limit_analysis, pushdown, pushover
from tests.support.drawn_projects import drawn, tables

CRUSHING = [
    (np.inf, 0.12730, 1e-5), (829.0, 0.12491, 1e-5), (249.0, 0.11935, 1e-5), (82.9, 0.10350, 1e-5),
    (41.5, 0.07992, 1e-5), (24.9, 0.04748, 1e-5), (16.6, 0.00665, 1e-5),
]  # fmt: skip


@pytest.mark.parametrize(("strength", "expected", "tolerance"), CRUSHING)
def test_rigid_multiplier_falls_with_the_strength(strength, expected, tolerance):
    model = drawn("buttressed_arch", 1.0, strength)
    assert limit_analysis(model).alpha == pytest.approx(expected, abs=tolerance)


SETTLEMENT = (0.02, -0.02)  # m, of the right support


def control(direction: str) -> tuple[float, float]:
    """The top of the pier towards which it is pushed, as in the project."""
    project = tables("buttressed_arch")
    points = {point["name"]: point["point_m"] for point in project["control"]}
    return points[project["pushover"]["control"][direction]]


def test_elastic_multiplier_as_drawn():
    curve = pushover(drawn("buttressed_arch"), control("+x"), "+x", "elastic", 0.001, until=0.9)
    assert curve.multiplier.max() == pytest.approx(0.0476, abs=1e-4)


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_elastic_multiplier_settled_does_not_depend_on_how_it_settled(direction):
    """Rigid or elastic on the way, at half the project's settlement: the elastic rest is one."""
    model, found = drawn("buttressed_arch"), []
    for contacts in ("rigid", "elastic"):
        moved = pushdown(model, "destro", (0.01, -0.01), increment=0.002, contacts=contacts)
        curve = pushover(model, control(direction), direction, "elastic", 0.001, moved.final, until=0.9)
        found.append(curve.multiplier.max())
    assert found[0] == pytest.approx(found[1], rel=1e-4)
    assert found[0] == pytest.approx({"+x": 0.0391, "-x": 0.0362}[direction], rel=0.01)  # this program's


def test_stiff_beds_come_to_the_rigid_multiplier():
    model = drawn("buttressed_arch", 1e6)
    curve = pushover(model, control("+x"), "+x", "elastic", 0.001, until=0.9)
    assert curve.multiplier.max() == pytest.approx(0.12730, rel=0.01)
