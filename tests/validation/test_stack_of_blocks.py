"""Two rigid blocks upon each other under one sine, against contact dynamics (tests/support/contact_dynamics.py)."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from assessment.benchmark.motions import ShakenCase
from mechanics import Material
from tests.support.contact_dynamics import motion
from tests.support.structures import on_base

FINE = 2e-4  # s; with 2e-5 it falls between 0.570 and 0.571 g, and between 0.2250 and 0.2255 g
# g: stands the first, falls under the second, by period in s
FALLS = {0.5: (0.570, 0.572), 1.0: (0.2245, 0.2255)}


def sine(amplitude: float, period: float = 0.5) -> Callable[[np.ndarray], np.ndarray]:
    """One sine, g."""
    return lambda times: amplitude * np.sin(2.0 * np.pi * times / period) * (times < period)


def stack() -> ShakenCase:
    """Two blocks of 0.5 × 1.5 m upon each other under one sine, followed for 6 s."""
    stone = Material(18.0, 0.7, 1e6)
    model = on_base(stone, (-2.0, -0.2, 2.5), *((0.0, z, 0.5, z + 1.5) for z in (0.0, 1.5)))
    return ShakenCase("stack of two", model, "rigid", (0.5, 3.0), 6.0, sine(0.5))


@pytest.mark.parametrize(("period", "levels"), FALLS.items())
def test_the_reference_falls_between_these_levels(period: float, levels: tuple[float, float]) -> None:
    middles = np.arange(0.5 * FINE, 6.0, FINE)
    turned = [
        abs(motion(stack().model, -sine(level, period)(middles), FINE)[:, :, 2]).max() for level in levels
    ]
    assert turned[0] < 0.2 and turned[1] > 1.0


@pytest.mark.parametrize(("period", "levels"), FALLS.items())
@pytest.mark.parametrize("integrator", ["auto", "moreau-jean"])
def test_the_stack_falls_within_one_percent_at_the_usual_step(
    integrator: str, period: float, levels: tuple[float, float]
) -> None:
    low, high = (
        replace(stack(), record=sine(level, period)).run(0.005, integrator)
        for level in (0.99 * levels[0], 1.01 * levels[1])
    )
    assert not low.collapsed and high.collapsed


def test_implicit_euler_stands_what_the_others_do_not() -> None:
    """At 5 ms it falls at 0.619 g only: a scheme that damps is on the unsafe side."""
    assert not replace(stack(), record=sine(0.61)).run(0.005, "implicit-euler").collapsed
