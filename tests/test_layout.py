"""Layout checks: overlaps, duplicates, floating blocks and gaps, with the places where they are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.block import Block, Material
from mechanics.errors import DrawingError
from mechanics.layout import LISTED, check_layout

STONE = Material(18.0)
TOLERANCE = 1e-3


def rectangle(
    x0: float, z0: float, x1: float, z1: float, handle: str = "", support: str | None = None
) -> Block:
    corners = [[x0, z0], [x1, z0], [x1, z1], [x0, z1]]
    return Block(corners, 1.0, STONE, support, layer="WALL" if handle else "", handle=handle)


def running_bond(columns: int, courses: int, joint: float = 0.0) -> list[Block]:
    """Bricks of 0.2 × 0.1 m, every other course moved by half a brick, on one support."""
    base = rectangle(-0.2, -0.1, 0.2 * columns + 0.2, 0.0, support="base")
    shift = [0.1 * (course % 2) for course in range(courses)]
    return [base] + [
        rectangle(0.2 * i + shift[k], 0.1 * k, 0.2 * (i + 1) + shift[k] - joint, 0.1 * (k + 1))
        for k in range(courses)
        for i in range(columns)
    ]


def moved(block: Block, rotation: float, shift: tuple[float, float], mirror: bool) -> Block:
    c, s = np.cos(rotation), np.sin(rotation)
    p = block.polygon * (-1.0 if mirror else 1.0, 1.0) @ [[c, s], [-s, c]] + shift
    return Block(p, block.depth, block.material, block.support, layer=block.layer, handle=block.handle)


def error(blocks: list[Block], tolerance: float = TOLERANCE) -> str:
    with pytest.raises(DrawingError) as caught:
        check_layout(blocks, tolerance)
    return str(caught.value)


BASE = rectangle(0, -1, 4, 0, handle="B1", support="base")


def test_a_running_bond_wall_has_no_remarks():
    assert check_layout(running_bond(6, 5), TOLERANCE) == ()


@settings(max_examples=25, deadline=None)
@given(
    rotation=st.floats(-3.2, 3.2),
    shift=st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)),
    mirror=st.booleans(),
    order=st.randoms(use_true_random=False),
)
def test_rigid_motions_and_order_change_no_verdict(rotation, shift, mirror, order):
    good = [moved(b, rotation, shift, mirror) for b in running_bond(3, 3)]
    order.shuffle(good)
    assert check_layout(good, TOLERANCE) == ()
    intruder = moved(rectangle(0.05, 0.05, 0.06, 0.06), rotation, shift, mirror)
    assert "overlap" in error([*good, intruder])


def test_overlap_names_both_blocks_and_the_place():
    message = error([BASE, rectangle(0, 0, 1, 1, "A1"), rectangle(0.9, 0, 2, 1, "A2")])
    assert 'layer "WALL", handle A1' in message and 'layer "WALL", handle A2' in message
    assert "overlap by 0.1 m² around (0.95, 0.5) m" in message


@pytest.mark.parametrize(("depth", "wrong"), [(0.5 * TOLERANCE, False), (1.5 * TOLERANCE, True)])
def test_overlaps_within_the_tolerance_are_none(depth, wrong):
    blocks = [BASE, rectangle(0, -depth, 1, 1, "A1")]
    if wrong:
        assert "overlap" in error(blocks)
    else:
        assert check_layout(blocks, TOLERANCE) == ()


def test_small_block_inside_a_large_one():
    assert "handle A2) overlap by 4e-06 m²" in error(
        [BASE, rectangle(0, 0, 4, 4, "A1"), rectangle(2, 2, 2.002, 2.002, "A2")]
    )


def test_slivers_that_cross():
    upright, flat = rectangle(1, 0, 1.0015, 1, "A1"), rectangle(0.5, 0.5, 1.5, 0.5015, "A2")
    assert "overlap by 2.25e-06 m² around (1.00075, 0.50075) m" in error([BASE, upright, flat])


def test_slender_tip_inside_a_block():
    wedge = Block([[2, -0.004], [2.2, 2], [1.8, 2]], 1.0, STONE, layer="WEDGE", handle="W")
    assert 'layer "WEDGE", handle W) overlap' in error([BASE, rectangle(0, 0, 1, 1, "A1"), wedge])


def test_slivers_wider_than_the_tolerance_are_blocks():
    sliver = rectangle(0, 0, 4, 0.002, "A1")
    assert check_layout([BASE, sliver, rectangle(0, 0.002, 4, 1, "A2")], TOLERANCE) == ()


def test_block_thinner_than_the_tolerance():
    message = error([BASE, rectangle(0, 0, 4, 0.0008, "A1"), rectangle(0, 0.0008, 4, 1, "A2")])
    assert "handle A1) at (2, 0.0004) m is nowhere wider than the joint tolerance of 0.001 m" in message


def test_duplicate_with_other_start_and_extra_vertices():
    again = Block([[1, 1], [0, 1], [0, 0.5], [0, 0], [1, 0]], 1.0, STONE, layer="WALL", handle="A2")
    message = error([BASE, rectangle(0, 0, 1, 1, "A1"), again])
    assert "handle A1" in message and "handle A2" in message
    assert "drawn twice, at (0.5, 0.75) m" in message


def test_floating_block():
    message = error([BASE, rectangle(0, 0, 1, 1, "A1"), rectangle(2, 1, 3, 2, "A2")])
    assert 'block 2 (layer "WALL", handle A2) at (2.5, 1.5) m touches nothing' in message
    assert "A1" not in message


def test_a_corner_alone_carries_nothing():
    assert "handle A2) at (1.5, 1.5) m touches nothing" in error(
        [BASE, rectangle(0, 0, 1, 1, "A1"), rectangle(1, 1, 2, 2, "A2")]
    )


def test_floating_group_comes_with_the_gap_below_it():
    blocks = [BASE, rectangle(0, 0, 1, 1, "A1"), rectangle(0, 1.005, 1, 2, "A2"), rectangle(0, 2, 1, 3, "A3")]
    message = error(blocks)
    assert (
        "handle A2) at (0.5, 1.5025) m and 1 more touch one another but nothing that leads to a support"
        in message
    )
    assert "handle A2) face each other at (0.5, 1.0025) m across 0.005 m" in message


def test_no_support_at_all():
    assert "no block is a support" in error([rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)])


def test_gap_just_above_the_tolerance():
    left, right = rectangle(0, 0, 1, 1, "A1"), rectangle(1.004, 0, 2, 1, "A2")
    (warning,) = check_layout([BASE, left, right], TOLERANCE)
    assert 'layer "WALL", handle A1' in warning and 'layer "WALL", handle A2' in warning
    assert "(1.002, 0.5) m across 0.004 m" in warning


def test_wedge_shaped_gap():
    leaning = Block([[1, 0], [2, 0], [2, 1], [1.006, 1]], 1.0, STONE, layer="WALL", handle="A2")
    (warning,) = check_layout([BASE, rectangle(0, 0, 1, 1, "A1"), leaning], TOLERANCE)
    assert "across 0 to 0.006 m" in warning


def test_gaps_that_are_meant():
    far = [rectangle(0, 0, 1, 1), rectangle(1.03, 0, 2, 1)]
    shim = [rectangle(0, 0, 1, 1), rectangle(1, 0, 1.004, 1), rectangle(1.004, 0, 2, 1)]
    within = [rectangle(0, 0, 1, 1), rectangle(1.0008, 0, 2, 1)]
    for blocks in (far, shim, within):
        assert check_layout([BASE, *blocks], TOLERANCE) == ()


def test_bond_moved_by_little_is_no_gap():
    """The corners of bricks a few tolerances apart along a bed joint do not face each other."""
    lower = [rectangle(0, 0, 1, 1), rectangle(1, 0, 2, 1)]
    upper = [rectangle(0, 1, 1.005, 2), rectangle(1.005, 1, 2, 2)]
    assert check_layout([BASE, *lower, *upper], TOLERANCE) == ()


def test_support_that_touches_nothing():
    idle = rectangle(8, 0, 9, 1, "S9", support="right")
    (warning,) = check_layout([BASE, rectangle(0, 0, 1, 1, "A1"), idle], TOLERANCE)
    assert 'layer "WALL", handle S9) at (8.5, 0.5) m is a support and touches nothing' in warning


def test_everything_at_once_and_long_lists_cut():
    overlapping = [rectangle(0.01 * k, 0, 1 + 0.01 * k, 1, f"A{k}") for k in range(8)]
    floating = [rectangle(3, 2 * k, 4, 2 * k + 1, f"F{k}") for k in range(1, 4)]
    message = error([BASE, *overlapping, *floating])
    assert message.count("overlap by") == LISTED and "and 8 more of this kind" in message
    assert message.count("touches nothing") == 3


def test_open_head_joints_are_counted():
    warnings = check_layout(running_bond(8, 5, joint=0.003), TOLERANCE)
    assert len(warnings) == LISTED + 1
    assert warnings[-1] == f"and {7 * 5 - LISTED} more of this kind"
