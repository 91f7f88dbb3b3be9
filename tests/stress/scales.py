"""Ten orders of magnitude in stiffness; friction from 0 to 5."""

from collections.abc import Iterator
from functools import partial

import numpy as np
import pytest

from mechanics import Assembly, Block, Material, limit_analysis, pushover
from mechanics.errors import ControlError, RunawayError, UnstableError
from mechanics.kernels.joint import H
from mechanics.steps.equilibrium import rest
from mechanics.steps.static_system import static_system
from tests.stress.harness import Case, sound
from tests.support.steps import by_highs
from tests.support.structures import arch_on_piers, block_on_base, running_bond

SLENDERNESS = np.arctan(0.2)


def stiffness(k: float) -> None:
    """A block on its bed: it stands where K = k d l³/12 exceeds W h/2.

    Where it does not, the rest that is found is upright and unstable, and no curve leads away from it.
    """
    model = block_on_base(stiffness=k)
    rotational = k * 0.2**3 / 12.0
    curve = pushover(model, (0.2, 1.0), contacts="elastic", increment=0.002)
    sound(curve)
    assert curve.multiplier.max() <= 0.2 + 1e-9
    # the corner's displacement under α W at mid-height, second-order effect included. From the first point: before
    # it the shears of the two faces of a joint, apart by its compression u, turn round and add μu/h to α
    flexibility = 0.5 * model.weight / (rotational - 0.5 * model.weight)
    change = np.diff(curve.displacement[1:3]) / np.diff(curve.multiplier[1:3])
    assert change == pytest.approx(flexibility, rel=1e-2)
    if k >= 1e10:
        assert curve.multiplier.max() == pytest.approx(0.2, rel=1e-2)


def friction(mu: float) -> None:
    """A block slides at μ or rocks at B/H; a wall as HiGHS has it, and never above μ."""
    block = limit_analysis(block_on_base(friction=mu))
    sound(block, 1e-3)
    assert block.alpha == pytest.approx(min(mu, 0.2), abs=1e-7)
    wall = running_bond(4, 5, friction=mu)
    limit = limit_analysis(wall, sliding="associative")
    sound(limit, 1e-3)
    assert limit.alpha == pytest.approx(by_highs(wall), abs=1e-7)
    assert limit.alpha <= mu + 1e-7


def arch_friction(mu: float) -> None:
    model = arch_on_piers(friction=mu)
    limit = limit_analysis(model)
    sound(limit, 1e-3)
    assert limit.alpha == pytest.approx(by_highs(model), abs=1e-7)


def mixed(factor: float) -> None:
    """One joint in a column of three is stiffer by a factor: the soft ones govern, in closed form."""
    soft, stiff = (Material(18.0, 0.7, k) for k in (1e5, 1e5 * factor))
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.0, 0.5]])
    blocks = [Block(corners + np.array([0.0, 0.5 * i]), 1.0, m) for i, m in enumerate((stiff, stiff, soft))]
    base = Block([[-1, -1], [2, -1], [2, 0], [-1, 0]], 1.0, soft, support="base")
    model = Assembly([base, *blocks])
    step = rest(static_system(model, "elastic"), model.initial)
    sound(step.certificate, 1e-3)
    k = model.contacts.bed * 2.0 * step.places[: len(model.contacts), H]
    for joint, carried in ((0, 3), (1, 2), (2, 1)):
        closed = 9.0 * carried / k[joint]
        upper, lower = (
            step.state.positions[[joint + 1, joint], 1] - model.initial.positions[[joint + 1, joint], 1]
        )
        assert lower - upper == pytest.approx(closed, rel=1e-5, abs=1e-13)


def cases() -> Iterator[Case]:
    for k in 10.0 ** np.arange(2, 13):
        soft = k < 0.5 * 3.6 / (0.2**3 / 12.0)
        unresolved = k * 0.2 * np.spacing(0.5) > 2e-6 * 3.6
        refusal = (UnstableError, ControlError) if soft else ()
        bad = "normal_stiffness: joints are so stiff" if unresolved else ""
        name = f"k = {k:g} kN/m³"
        yield Case("stiffness", name, partial(stiffness, k), refusal, soft or unresolved, bad)
    for factor in 10.0 ** np.arange(-5, 6, 2):
        # k b³/12 of a soft joint below W h/2: no column stands on it
        soft = factor * 1e5 / 12.0 < 27.0 * 0.75
        refusal = (RunawayError,) if soft else ()
        yield Case(
            "stiffness", f"one of three joints stiffer by {factor:g}", partial(mixed, factor), refusal, soft
        )
    for mu in (0.0, 1e-9, 1e-6, 1e-3, 0.1, 0.5, 1.0, 2.0, 5.0):
        yield Case("friction", f"block and wall, μ = {mu:g}", partial(friction, mu))
        refusal = (UnstableError,) if mu < 0.35 else ()
        yield Case("friction", f"arch, μ = {mu:g}", partial(arch_friction, mu), refusal, bool(refusal))
