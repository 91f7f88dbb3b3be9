"""Elastic equilibria are accepted only where they are stable: columns on soft joints at their critical stiffness."""

from dataclasses import replace

import numpy as np
import pytest

from mechanics.errors import RunawayError
from mechanics.procedures.pushover import pushover
from mechanics.steps import geometry_iteration
from mechanics.steps.equilibrium import rest
from mechanics.steps.static_system import static_system
from tests.support.structures import column

WIDTH, HEIGHT, UNIT_WEIGHT = 0.5, 3.0, 20.0  # m, m, kN/m³


def critical_stiffness(blocks: int) -> float:
    """Stiffness (kN/m³) at which an upright column buckles: K = k b³/12 of each joint against the blocks' weight.

    With θ_i the rotations of the joints and Θ = Lθ those of the blocks, the weight does the work ½ ΘᵀDΘ, where block i
    of weight w and height a lowers its centre by ½ aΘ_i²/2 and those above by ½ aΘ_i². Compression is neglected.
    """
    height = HEIGHT / blocks
    weight = UNIT_WEIGHT * WIDTH * height
    above = np.arange(blocks - 1, -1, -1)
    sums = np.tril(np.ones((blocks, blocks)))
    work = sums.T @ np.diag(weight * height * (0.5 + above)) @ sums
    return float(np.linalg.eigvalsh(work).max() / (WIDTH**3 / 12.0))


def settled(stiffness: float, blocks: int):
    model = column(WIDTH, HEIGHT, blocks, stiffness)
    return rest(static_system(model, "elastic", "associative"), model.initial)


@pytest.mark.parametrize("blocks", [1, 2, 6])
def test_an_upright_column_stands_above_its_critical_stiffness(blocks):
    assert settled(1.001 * critical_stiffness(blocks), blocks).stable


@pytest.mark.parametrize("blocks", [1, 2, 6])
@pytest.mark.parametrize("share", [0.98, 0.5])  # the joints' compression, neglected, is 1 % of a block here
def test_an_upright_column_on_softer_joints_is_refused(blocks, share):
    """Its symmetry leaves no direction in which to fall: forces balance, and only the stiffness tells."""
    with pytest.raises(RunawayError, match="balances on an unstable equilibrium"):
        settled(share * critical_stiffness(blocks), blocks)


def test_beyond_the_peak_one_direction_is_held_by_the_push(monkeypatch):
    """K − G has one negative direction there; the work of the push holds it, and under dead load it is refused."""
    found = []
    certified = geometry_iteration.certified

    def kept(problem, now):
        reached = certified(problem, now)
        if problem.lateral is not None:
            dead = problem.load + now.alpha * problem.lateral
            free = certified(replace(problem, lateral=None, load=dead), now)
            found.append((reached.alpha, reached.stable, free.stable))
        return reached

    monkeypatch.setattr(geometry_iteration, "certified", kept)
    curve = pushover(column(0.5, 3.0, 1, 2e5), (0.25, 2.9), contacts="elastic", increment=0.01)
    peak = int(np.argmax([alpha for alpha, _, _ in found]))
    assert len(found) > peak + 20
    assert all(pushed for _, pushed, _ in found)
    assert all(free for *_, free in found[: peak - 1])
    assert not any(free for *_, free in found[peak + 2 :])
    assert curve.steps
