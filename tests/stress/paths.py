"""Mechanisms with several solutions, none, or none at all; steps too large; states at the edge of collapse."""

from collections.abc import Iterator
from functools import partial

import numpy as np
import pytest

from mechanics import Assembly, Block, Material, limit_analysis, pushdown, pushover
from mechanics.errors import CollapseError, ControlError, NoEquilibriumError, UnstableError
from tests.stress.harness import Case, sound
from tests.support.structures import arch_on_piers, block_on_base, rectangle

STONE = Material(18.0, 0.7, 1e6)
BASE = Block(rectangle(-5.0, -1.0, 5.0, 0.0), 1.0, STONE, support="base")


def twins(count: int, contacts: str) -> None:
    """Equal blocks apart overturn at the same α, any share of them: the multiplier is one, the mechanism is not."""
    blocks = [Block(rectangle(0.5 * i, 0.0, 0.5 * i + 0.2, 1.0), 1.0, STONE) for i in range(count)]
    model = Assembly([BASE, *blocks])
    if contacts == "rigid":
        limit = limit_analysis(model)
        sound(limit, 1e-3)
        assert limit.alpha == pytest.approx(0.2, abs=1e-7)
    curve = pushover(model, (0.2, 1.0), contacts=contacts, increment=0.01)
    sound(curve)
    assert curve.multiplier.max() <= 0.2 + 1e-6
    # whichever blocks lean, none can lean at a multiplier above its own
    for state, alpha in zip(curve.states, curve.multiplier, strict=True):
        least = np.tan(np.arctan(0.2) - abs(state.positions[1:, 2]).max())
        assert alpha <= 0.2 + 1e-6
        if contacts == "rigid":
            assert alpha >= least - 1e-6


def frictionless_curve(contacts: str) -> None:
    curve = pushover(block_on_base(friction=0.0), (0.2, 1.0), contacts=contacts, increment=0.01)
    sound(curve)
    assert curve.multiplier.max() == pytest.approx(0.0, abs=1e-6)


def poised(off: float) -> None:
    """A block leaning to within `off` (rad) of where its centroid stands over its toe: nothing but that stands."""
    model = block_on_base()
    lean = np.arctan(0.2) - off
    state = model.rotated(1, (0.2, 0.0), -lean)
    limit = limit_analysis(model, "+x", state)
    sound(limit, 1e-3)
    assert limit.alpha == pytest.approx(np.tan(off), abs=1e-6)


def interlocked(friction: float, contacts: str) -> None:
    """A block in a slot of a fixed frame: no load moves it."""
    stone = Material(18.0, friction, 1e6)
    frame = [
        Block(rectangle(-1.0, -1.0, 2.0, 0.0), 1.0, stone, support="frame"),
        Block(rectangle(-1.0, 0.0, 0.0, 1.0), 1.0, stone, support="frame"),
        Block(rectangle(1.0, 0.0, 2.0, 1.0), 1.0, stone, support="frame"),
        Block(rectangle(-1.0, 1.0, 2.0, 2.0), 1.0, stone, support="frame"),
    ]
    model = Assembly([*frame, Block(rectangle(0.0, 0.0, 1.0, 1.0), 1.0, stone)])
    if contacts == "limit":
        limit_analysis(model)
    else:
        sound(pushover(model, (1.0, 1.0), contacts=contacts, increment=0.01))


def too_large(contacts: str, factor: float) -> None:
    """Steps far beyond the whole curve: one within it, or a refusal; every point given is on tan(β − θ)."""
    model = block_on_base(stiffness=1e8)
    curve = pushover(model, (0.2, 1.0), contacts=contacts, increment=0.001 * factor)
    sound(curve)
    lean = np.array([-state.positions[1, 2] for state in curve.states])
    if contacts == "rigid":
        np.testing.assert_allclose(curve.multiplier, np.tan(np.arctan(0.2) - lean), atol=1e-5)
    assert curve.multiplier.max() <= 0.2 + 1e-6
    if curve.reached_zero:
        assert curve.displacement[-1] == pytest.approx(np.sin(np.arctan(0.2)), rel=1e-2)


def arch_too_large(contacts: str, factor: float) -> None:
    model = arch_on_piers(voussoirs=9, courses=3, stiffness=1e7)
    onset = limit_analysis(model).alpha
    curve = pushover(model, (0.85, 0.8), contacts=contacts, increment=0.001 * factor)
    sound(curve)
    assert curve.multiplier.max() <= onset + 1e-6
    fine = pushover(model, (0.85, 0.8), contacts=contacts, increment=0.001)
    assert curve.displacement[-1] <= 1.1 * fine.displacement[-1]


def settled_too_large(contacts: str, factor: float) -> None:
    """A movement far beyond collapse in one increment: refused with a path no longer than the ultimate movement."""
    model = arch_on_piers(voussoirs=9, courses=3, stiffness=1e7)
    fine = pushdown(
        model, "right", (0.01, 0.0), increment=0.005, contacts=contacts, to_collapse=True
    ).ultimate
    assert fine is not None
    moved = pushdown(model, "right", (0.001 * factor, 0.0), increment=0.001 * factor, contacts=contacts)
    sound(moved)
    assert moved.movement[-1] <= 1.1 * fine, (
        f"stands at {moved.movement[-1]:.3g} m, {fine:.3g} m being the last"
    )


def at_the_edge(contacts: str, share: float) -> None:
    """Settled to a share of the ultimate movement: what is left of α0 is small, certified and falling."""
    model = arch_on_piers(voussoirs=9, courses=3, stiffness=1e7)
    found = pushdown(model, "right", (0.005, -0.005), increment=0.002, contacts=contacts, to_collapse=True)
    assert found.ultimate is not None
    target = share * found.ultimate
    moved = pushdown(model, "right", (target, -target), increment=0.002, contacts=contacts)
    sound(moved)
    original = limit_analysis(model).alpha
    for direction in ("+x", "-x"):
        limit = limit_analysis(model, direction, moved.final)
        sound(limit, 1e-3)
        assert -1e-9 <= limit.alpha < original
        curve = pushover(model, (0.0, 1.4), direction, contacts, 0.002, moved.final)
        sound(curve)
        assert curve.multiplier.max() < 1.01 * original


def cases() -> Iterator[Case]:
    end = (NoEquilibriumError, ControlError)
    for contacts in ("rigid", "elastic"):
        for count in (2, 5):
            yield Case(
                "several mechanisms",
                f"{count} twins, {contacts}",
                partial(twins, count, contacts),
                (ControlError,),
            )
    for contacts in ("rigid", "elastic"):
        yield Case("α0 = 0", f"frictionless curve, {contacts}", partial(frictionless_curve, contacts), end)
    for off in (1e-3, 1e-5, 1e-7, 0.0, -1e-7, -1e-5, -1e-3):
        name = f"poised, {off:+g} rad"
        yield Case("α0 = 0", name, partial(poised, off), (UnstableError,), abs(off) >= 1e-5)
    for friction in (0.0, 0.7, 5.0):
        for contacts in ("limit", "rigid", "elastic"):
            refusal = (NoEquilibriumError, ControlError)
            name = f"μ = {friction:g}, {contacts}"
            yield Case(
                "interlocked", name, partial(interlocked, friction, contacts), refusal, contacts != "elastic"
            )
    for contacts in ("rigid", "elastic"):
        for factor in (30.0, 1e3, 1e6):
            name = f"× {factor:g}, {contacts}"
            yield Case("steps too large", f"block {name}", partial(too_large, contacts, factor), end)
            yield Case("steps too large", f"arch {name}", partial(arch_too_large, contacts, factor), end)
            collapse = (CollapseError,)
            yield Case(
                "steps too large",
                f"settlement {name}",
                partial(settled_too_large, contacts, factor),
                collapse,
            )
        for share in (0.9, 0.99, 0.999, 1.0, 1.1):
            refusal = (UnstableError, *end) if share >= 0.99 else ()
            yield Case(
                "edge of collapse", f"{share:g} of the ultimate movement, {contacts}",
                partial(at_the_edge, contacts, share), refusal, share > 1.0,
            )  # fmt: skip
