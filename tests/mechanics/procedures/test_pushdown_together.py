"""Several supports that move at once: what follows from the movement of one, and from rigid motions."""

import numpy as np
import pytest

from mechanics import ArgumentError, pushdown
from mechanics.procedures import SupportMovement, pushdown_together
from tests.support.structures import arch_on_piers


@pytest.fixture(scope="module")
def arch():
    return arch_on_piers(voussoirs=7, courses=3)


def test_supports_that_move_alike_carry_the_structure_with_them(arch):
    # equilibrium is solved to 1e-8 of a weight, positions to 1e-8 of a block: 1e-7 m
    by = (0.004, -0.003)
    found = pushdown_together(arch, [SupportMovement("right", by), SupportMovement("left", by)], 0.001)
    moved = found.final.positions - arch.initial.positions
    assert moved == pytest.approx(np.tile([*by, 0.0], (len(moved), 1)), abs=1e-7)


def test_what_one_support_spreads_is_what_two_share():
    """In another frame the right support alone moves by 8 mm: shapes differ by a translation of half of it.

    The arch has a joint at its crown: beside a keystone the hinge would open on either side, as rounding chooses.
    """
    arch = arch_on_piers(voussoirs=8, courses=3)
    both = pushdown_together(
        arch, [SupportMovement("right", (0.004, 0.0)), SupportMovement("left", (-0.004, 0.0))], 0.001
    )
    one = pushdown(arch, "right", (0.008, 0.0), increment=0.002)
    shift = one.final.positions - both.final.positions
    assert shift == pytest.approx(np.tile([0.004, 0.0, 0.0], (len(shift), 1)), abs=1e-6)


def test_wrong_movements_are_named(arch):
    with pytest.raises(ArgumentError, match="movements"):
        pushdown_together(arch, [], 0.001)
    with pytest.raises(ArgumentError, match="one of left, right"):
        pushdown_together(arch, [SupportMovement("middle", (0.1, 0.0))], 0.001)
