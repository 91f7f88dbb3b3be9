"""Structures that are their own mirror image, pushed either way."""

from __future__ import annotations

import numpy as np
import pytest

from mechanics import pushover
from tests.support.drawn_projects import drawn, tables
from tests.support.structures import running_bond


def test_directions_agree_in_an_arch_that_is_its_own_mirror_image():
    """The triumphal arch, 14 of whose joints slide; towards +x and -x its curves differ by 2e-4 of α0."""
    model, curves = drawn("triumphal_arch"), []
    points = {point["name"]: point["point_m"] for point in tables("triumphal_arch")["control"]}
    for direction, name in (("+x", "C1"), ("-x", "C2")):
        curves.append(pushover(model, points[name], direction, "rigid", 0.02, until=0.9))
    at = np.linspace(0.0, 0.95 * min(max(curve.displacement) for curve in curves), 20)
    found, expected = (np.interp(at, curve.displacement, curve.multiplier) for curve in curves)
    assert found == pytest.approx(expected, abs=0.01 * curves[0].multiplier.max())


def test_a_wall_whose_mechanisms_alternate_has_one_curve_at_every_increment():
    model = running_bond()
    control = model.blocks[-1].centroid
    curves = [pushover(model, control, "+x", "rigid", increment, until=0.8) for increment in (0.004, 0.002)]
    found = [float(np.interp(0.1, curve.displacement, curve.multiplier)) for curve in curves]
    assert max(found) == pytest.approx(min(found), rel=0.03)
