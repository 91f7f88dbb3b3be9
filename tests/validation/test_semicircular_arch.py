"""The semicircular voussoir arch: minimum thickness, friction, thrusts, the spread of its supports at which it falls.

Minimum t/R on the centre line [literature and computed independently]: 0.0957, 0.1061, 0.1067, 0.1074 with 7, 15, 27,
51 voussoirs without sliding (limit 0.1075); with 27 voussoirs 0.1067, 0.1211, 0.1512 at μ = 0.40, 0.38, 0.35 and none
at 0.30. Thrust over weight at t/R = 0.12, 0.15, 0.20, many voussoirs: least 0.1908, 0.1759, 0.1540, greatest 0.2070,
0.2270, 0.2546. Ultimate spread at the same t/R, 26 voussoirs, friction 0.7 [computed independently]: 0.0354, 0.1134,
0.2962 of the mean radius.
"""

import pytest

from mechanics import UnstableError, pushdown
from mechanics.steps.equilibrium import check_self_weight
from tests.support.structures import semicircular_arch


def stands(voussoirs: int, thickness: float, friction: float = 1e3) -> bool:
    try:
        check_self_weight(semicircular_arch(voussoirs, thickness, friction))
    except UnstableError:
        return False
    return True


def least_thickness(voussoirs: int, friction: float = 1e3) -> float:
    low, high = 0.05, 0.5
    while high - low > 1e-5:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if stands(voussoirs, middle, friction) else (middle, high)
    return high


def test_no_thickness_stands_at_low_friction():
    assert not any(stands(27, thickness, 0.30) for thickness in (0.2, 0.5, 0.9))


def thrust(thickness: float, spread: float) -> float:
    """Horizontal thrust over weight as the right support begins to move outwards (or inwards)."""
    model = semicircular_arch(151, thickness)
    path = pushdown(model, "right", (spread, 0.0), increment=abs(spread))
    return -float(path.reaction[0, 0]) / model.weight


def test_the_edge_of_stability_is_sharp():
    """27 voussoirs: t = 0.10672 ± 1e-6 around the thickness found to 1e-8 stands and falls."""
    low, high = 0.1067, 0.1068
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if stands(27, middle) else (middle, high)
    assert stands(27, high + 1e-6)
    assert not stands(27, low - 1e-6)


@pytest.mark.parametrize(("thickness", "expected"), [(0.12, 0.0354), (0.15, 0.1134), (0.20, 0.2962)])
def test_ultimate_spread(thickness, expected):
    model = semicircular_arch(26, thickness, friction=0.7)
    path = pushdown(model, "right", (0.001, 0.0), increment=0.004, to_collapse=True)
    assert path.ultimate == pytest.approx(expected, abs=3e-4)
