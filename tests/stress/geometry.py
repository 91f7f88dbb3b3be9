"""Slender and flat blocks, tiny and tilted joints, redundant contact points, tall columns, arches at their limit."""

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
import pytest

from mechanics import Assembly, Block, Material, limit_analysis, pushover, time_history
from mechanics.errors import UnstableError
from mechanics.solvers import lp_highs
from mechanics.steps.equilibrium import check_self_weight, closed_program, reaction, rest
from mechanics.steps.static_system import static_system
from tests.stress.harness import Case, sound
from tests.support.steps import by_highs
from tests.support.structures import block_on_base, built, on_base, rectangle, semicircular_arch

STONE = Material(18.0, 0.7, 1e8)


def slender(width: float, height: float) -> None:
    """α = B/H or μ; the rigid curve is tan(arctan(B/H) − θ)."""
    model = block_on_base(width, height)
    limit = limit_analysis(model)
    sound(limit, 1e-3 * model.size)
    ratio = width / height
    assert limit.alpha == pytest.approx(min(ratio, 0.7), rel=1e-6)
    if ratio < 0.7:
        curve = pushover(model, (width, height), increment=0.02 * width)
        sound(curve)
        lean = np.array([-state.positions[1, 2] for state in curve.states])
        np.testing.assert_allclose(curve.multiplier, np.tan(np.arctan(ratio) - lean), atol=1e-5 * ratio)


def slender_in_motion(width: float, height: float) -> None:
    """At rest it stays; energy is not made."""
    motion = time_history(block_on_base(width, height, stiffness=1e9), np.zeros(40), 0.01, "elastic")
    sound(motion)
    assert abs(motion.positions[-1] - motion.positions[0]).max() < 1e-6 * width


def needle(width: float) -> None:
    """A needle, 1 : 10, beside a block of 10 m on one base: it overturns first, at 0.1."""
    wide, thin = (-5.0, 0.0, 5.0, 10.0), (6.0, 0.0, 6.0 + width, 10.0 * width)
    model = built(STONE, wide, thin, base=(-20.0, -1.0, 20.0, 0.0), tolerance=1e-3 * width)
    limit = limit_analysis(model)
    sound(limit, 1e-3)
    assert limit.alpha == pytest.approx(0.1, rel=1e-6)


def ledge(width: float, tolerance: float) -> None:
    """A lintel of 10 m on a bearing of 1 m and a ledge, which carries between 4/9 and 1/2 of it, or its whole width."""
    lintel = Block(rectangle(0.0, 0.0, 10.0, 0.5), 1.0, STONE)
    left = Block(rectangle(-1.0, -1.0, 1.0, 0.0), 1.0, STONE, support="left")
    right = Block(rectangle(10.0 - width, -1.0, 12.0, 0.0), 1.0, STONE, support="right")
    model = Assembly([lintel, left, right], tolerance=tolerance)
    limit = limit_analysis(model)
    sound(limit, 1e-3)
    assert limit.alpha == pytest.approx(0.7, rel=1e-6)
    for contacts in ("rigid", "elastic"):
        step = rest(static_system(model, contacts), model.initial)
        share = reaction(step, model.support("right"))[1] / model.weight
        tilt = abs(step.state.positions[0, 2])  # of a soft ledge's making: it moves the forces a little
        assert 4.0 / 9.0 - 1e-6 - 0.2 * tilt <= share <= 5.0 / (10.0 - width) + 1e-6


def tilted(angle: float) -> None:
    """A base tilted by less than the tolerance: α = tan(arctan(B/H) + θ), as near as the joint is drawn."""
    cos, sin = np.cos(angle), np.sin(angle)
    corners = np.array(rectangle(0.0, 0.0, 0.2, 1.0)) @ np.array([[cos, sin], [-sin, cos]])
    model = on_base(STONE, (-1.0, -0.1, 1.0), corners)
    limit = limit_analysis(model)
    sound(limit, 1e-3)
    assert limit.alpha == pytest.approx(0.2, abs=2.0 * abs(angle) + 1e-9)


def tee(overlap: float) -> None:
    """A block across the joint of two: a T; α of each part in closed form, the whole as HiGHS has it."""
    boxes = (0.0, 0.0, 0.5, 0.4), (0.5, 0.0, 1.0, 0.4), (0.5 - overlap, 0.4, 0.9, 0.8)
    model = built(STONE, *boxes, base=(-2.0, -0.5, 3.0, 0.0), tolerance=1e-10)
    limit = limit_analysis(model)
    sound(limit, 1e-3)
    assert limit.alpha == pytest.approx(by_highs(model), abs=1e-7)
    assert len(model.joints.a) == 5
    sound(rest(static_system(model, "elastic"), model.initial).certificate, 1e-3)


def column(blocks: int, stiffness: float = 1e9) -> Assembly:
    stone = Material(18.0, 0.7, stiffness)
    return on_base(stone, (-1.0, -0.5, 2.0), *((0.0, 0.1 * i, 1.0, 0.1 * i + 0.1) for i in range(blocks)))


def stacked(blocks: int) -> None:
    """α = B/H of the whole, the compression of every joint, and no motion at rest."""
    model = column(blocks)
    limit = limit_analysis(model)
    sound(limit, 1e-3)
    assert limit.alpha == pytest.approx(10.0 / blocks, rel=1e-6)
    step = rest(static_system(model, "elastic"), model.initial)
    sound(step.certificate, 1e-6)
    shortening = 1.8 * np.cumsum(np.arange(blocks, 0, -1)) / 1e9
    settled = model.initial.positions[1:, 1] - step.state.positions[1:, 1]
    np.testing.assert_allclose(settled, shortening, rtol=1e-5)
    for contacts in ("rigid", "elastic"):
        motion = time_history(model, np.zeros(20), 0.005, contacts)
        sound(motion)
        assert abs(motion.positions[-1] - motion.positions[0]).max() < 1e-7


@cache
def least_thickness(voussoirs: int) -> float:
    """By bisection with HiGHS: the thinnest arch in which α = 0 has equilibrium, to 1e-9."""

    def stands(thickness: float) -> bool:
        model = semicircular_arch(voussoirs, thickness)
        return lp_highs.solve(closed_program(model, model.initial).program) is not None

    low, high = 0.09, 0.12
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if stands(middle) else (middle, high)
    return high


def thin_arch(voussoirs: int, off: float) -> None:
    model = semicircular_arch(voussoirs, least_thickness(voussoirs) + off)
    check_self_weight(model)
    limit = limit_analysis(model)
    sound(limit, 1e-3)
    assert 0.0 <= limit.alpha < max(1e-4, 10.0 * off)
    assert limit.alpha == pytest.approx(by_highs(model), abs=1e-7)


def cases() -> Iterator[Case]:
    for width, height in ((0.01, 10.0), (1e-3, 1.0), (10.0, 0.01), (1.0, 1e-3)):
        name = f"{width:g} × {height:g} m"
        yield Case("slender and flat", name, partial(slender, width, height))
        yield Case("slender and flat", f"{name} at rest in time", partial(slender_in_motion, width, height))
    yield Case("1 µm beside 10 m", "needle of 1 m", partial(needle, 1.0))
    for width in (1e-6, 1e-4, 1e-2):
        name = f"needle of {width:g} m"
        yield Case("1 µm beside 10 m", name, partial(needle, width), bad_input="weight times size of block 2")
    for width in (1e-6, 1e-4, 1e-2, 1.0):
        yield Case("1 µm beside 10 m", f"ledge of {width:g} m", partial(ledge, width, 1e-8))
    yield Case(
        "1 µm beside 10 m", "ledge below the tolerance", partial(ledge, 1e-6, 1e-3), (UnstableError,), True
    )
    for angle in (0.0, 1e-12, 1e-9, 1e-6, 1e-4, -1e-6, -1e-4):
        yield Case("nearly parallel and T-joints", f"tilted by {angle:g}", partial(tilted, angle))
    yield Case(
        "nearly parallel and T-joints", "tilted by 0.01", partial(tilted, 1e-2), (UnstableError,), True
    )
    for overlap in (1e-9, 1e-6, 1e-3, 0.25, 0.4):
        yield Case("nearly parallel and T-joints", f"T over {overlap:g} m", partial(tee, overlap))
    for blocks in (20, 200):
        yield Case("stacked columns", f"{blocks} blocks", partial(stacked, blocks))
    yield Case("stacked columns", "2000 blocks", partial(stacked, 2000), long=True)
    for voussoirs in (7, 15, 27):
        for off in (1e-3, 1e-6, -1e-6, -1e-3):
            refusal = (UnstableError,) if off < 0 else ()
            name = f"{voussoirs} voussoirs, t_min {off:+g}"
            yield Case(
                "arch at its least thickness", name, partial(thin_arch, voussoirs, off), refusal, off < 0
            )
