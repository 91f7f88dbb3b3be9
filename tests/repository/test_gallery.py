"""The scripts of the gallery run as they are printed, and come to what theory says."""

from __future__ import annotations

import numpy as np
import pytest

from tests import ROOT
from tools.gallery import carried_out, scripts

PAGE = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")


def _thinnest(names):
    """Milankovitch: 0.1075 of the mean radius; the bisection leaves 0.0024 m of 0.538."""
    assert names["high"] / 5.0 == pytest.approx(0.1075, rel=5e-3)


def _spread(names):
    """The horizontal thrust of the flatter arch is larger, and the arch as drawn stood."""
    moved = names["moved"]
    assert moved.ultimate == pytest.approx(moved.movement[-1], abs=0.02)
    assert -moved.reaction[-1, 0] > -moved.reaction[0, 0] > 0.0


def _rocking(names):
    """The rotation of what does not fall decreases with size; the smallest falls."""
    peaks = np.array(names["peaks"])
    assert np.isnan(peaks[0]) and (np.diff(peaks[1:]) < 0.0).all() and peaks[1] < 1.0


def _fragile(names):
    """Longer pulses overturn at less; of three records β is the root mean square of the logarithms."""
    levels = [curve.collapse for curve in names["curves"]]
    assert levels == sorted(levels, reverse=True) and min(levels) > 0.2
    assert names["fit"].median == pytest.approx(np.exp(np.mean(np.log(levels))))
    assert names["fit"].beta == pytest.approx(np.std(np.log(levels)))


def _facade(names):
    """Moments about the foot, kNm: 64.8 kN at 3 m and 10 kN at 5.75 m against 0.3 m of both, and 8 kN at 5.75 m."""
    turning = 64.8 * 3.0 + 10.0 * 5.75
    assert names["alone"].alpha == pytest.approx(74.8 * 0.3 / turning, rel=1e-6)
    assert names["held"].alpha == pytest.approx((74.8 * 0.3 + 8.0 * 5.75) / turning, rel=1e-6)


HOLDS = dict(zip(scripts(), (_thinnest, _spread, _rocking, _fragile, _facade), strict=True))


@pytest.mark.parametrize("heading", HOLDS)
def test_a_script_does_what_it_says(heading, tmp_path):
    names, _ = carried_out(scripts()[heading], tmp_path)
    HOLDS[heading](names)
    [picture] = tmp_path.glob("*.svg")
    assert f"(pictures/{picture.name})" in PAGE and (ROOT / "docs" / "pictures" / picture.name).is_file()
