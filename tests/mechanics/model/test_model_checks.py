"""Layout checks: overlaps, duplicates, floating blocks and gaps, with the places where they are."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.errors import DrawingError, FaultyDrawingError
from mechanics.model.block import Block, Material
from mechanics.model.layout import depth_of, survey_layout, touching

STONE = Material(18.0)
TOLERANCE = 1e-3


def check_layout(blocks, tolerance):
    """The warnings of a survey; its faults are raised."""
    layout = survey_layout(blocks, tolerance)
    if layout.faults:
        raise FaultyDrawingError("", layout.faults, (), layout.hint)
    return layout.warnings


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


@settings(max_examples=15)
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


@pytest.mark.parametrize(
    ("other", "depth"), [((0.5, 0.98, 2.0, 2.0), 0.02), ((0.0, 0.98, 1.0, 2.0), 0.02 / 1.02)]
)
def test_the_depth_of_an_overlap(other, depth):
    """That of a corner in the other block; where none is, 2A/p of what both share: 2 · 0.02/(2 · 1.02)."""
    assert depth_of(shapely.box(0.0, 0.0, 1.0, 1.0), shapely.box(*other)) == pytest.approx(depth, rel=1e-6)


def test_duplicate_with_other_start_and_extra_vertices():
    again = Block([[1, 1], [0, 1], [0, 0.5], [0, 0], [1, 0]], 1.0, STONE, layer="WALL", handle="A2")
    message = error([BASE, rectangle(0, 0, 1, 1, "A1"), again])
    assert "handle A1" in message and "handle A2" in message
    assert "drawn twice, at (0.5, 0.5) m; keep one" in message
    assert len(message.splitlines()) == 1


@pytest.mark.parametrize("left", [2, 1])
def test_a_block_that_floats_or_shares_a_corner_alone_is_told(left):
    message = error([BASE, rectangle(0, 0, 1, 1, "A1"), rectangle(left, 1, left + 1, 2, "A2")])
    assert f'block 2 (layer "WALL", handle A2) at ({left + 0.5}, 1.5) m touches nothing' in message
    assert "A1" not in message


def test_what_a_gap_keeps_in_the_air_is_told_with_the_gap_and_the_tolerance_that_closes_it():
    blocks = [
        BASE, rectangle(0, 0, 1, 1, "A1"), rectangle(0, 1.0026, 1, 2, "A2"), rectangle(0, 2, 1, 3, "A3"),
    ]  # fmt: skip
    gap, remedy = error(blocks).splitlines()
    assert "handle A2) face each other at (0.5, 1.0013) m across 0.0026 m" in gap
    assert gap.endswith("no joint, and block 2 and 1 more hang in the air; draw them so that they touch")
    assert remedy == "gaps of up to 2.6 mm: geometry.tolerance_m = 0.004 closes all of them"
    assert check_layout(blocks, 0.004) == ()


@settings(max_examples=20)
@given(st.lists(st.floats(1.1, 19.0), min_size=1, max_size=6), st.floats(-4.0, 1.0))
def test_the_tolerance_that_is_proposed_closes_every_gap(gaps, decade):
    """Columns of two blocks on one base, the upper ones in the air by 1.1 to 19 tolerances, at any scale."""
    size = 10.0**decade
    columns = [
        (rectangle(2 * k, 0, 2 * k + 1, 1), rectangle(2 * k, 1 + gap * TOLERANCE, 2 * k + 1, 2))
        for k, gap in enumerate(gaps)
    ]
    blocks = [rectangle(-1, -1, 2 * len(gaps), 0, support="base"), *(b for column in columns for b in column)]
    scaled = [Block(size * b.polygon, 1.0, STONE, b.support) for b in blocks]
    *faults, remedy = error(scaled, size * TOLERANCE).splitlines()
    assert len(faults) == len(gaps)
    assert check_layout(scaled, float(remedy.split(" = ")[1].split()[0])) == ()


def test_no_tolerance_is_proposed_that_a_block_would_not_survive():
    chip = rectangle(2, 0, 3, 0.004, "CHIP")
    message = error([BASE, rectangle(0, 0, 1, 1, "A1"), rectangle(0, 1.01, 1, 2, "A2"), chip])
    assert "across 0.01 m" in message and "tolerance_m" not in message


def test_no_support_at_all():
    assert "no block is a support" in error([rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)])


def test_gap_just_above_the_tolerance():
    left, right = rectangle(0, 0, 1, 1, "A1"), rectangle(1.004, 0, 2, 1, "A2")
    warning, remedy = check_layout([BASE, left, right], TOLERANCE)
    assert remedy == "gaps of up to 4 mm: geometry.tolerance_m = 0.006 closes all of them"
    assert 'layer "WALL", handle A1' in warning and 'layer "WALL", handle A2' in warning
    assert "(1.002, 0.5) m across 0.004 m" in warning


@pytest.mark.parametrize("share", [0.9995, 1.0005])
def test_what_is_no_joint_by_little_is_told(share):
    """Between a joint and a gap of which there is a warning there once was nothing."""
    blocks = [BASE, rectangle(0, 0, 1, 1), rectangle(1 + share * TOLERANCE, 0, 2, 1)]
    assert ((1, 2) in touching(blocks, TOLERANCE)) == (share < 1.0)
    assert bool(check_layout(blocks, TOLERANCE)) == (share > 1.0)


def test_gaps_that_are_meant():
    far = [rectangle(0, 0, 1, 1), rectangle(1.03, 0, 2, 1)]
    shim = [rectangle(0, 0, 1, 1), rectangle(1, 0, 1.004, 1), rectangle(1.004, 0, 2, 1)]
    within = [rectangle(0, 0, 1, 1), rectangle(1.0008, 0, 2, 1)]
    for blocks in (far, shim, within):
        assert check_layout([BASE, *blocks], TOLERANCE) == ()


def test_one_frame_is_one_fault_and_hides_no_other():
    """A frame once caused 20 of 40 lines and hid a block drawn twice."""
    wall = running_bond(12, 8)
    frame = rectangle(-1, -1, 5, 5, "FRAME")
    again = Block(wall[40].polygon, 1.0, STONE, layer="WALL", handle="AGAIN")
    floating = rectangle(3.5, 3, 4, 4, "FLOATING")
    message = error([*wall, frame, again, floating])
    assert len(message.splitlines()) == 3
    assert "handle FRAME) at (-1, -1) m encloses 98 other blocks (0, 1, 2, …); if it is a frame" in message
    assert "block 40 and block 98" in message and "drawn twice" in message
    assert "handle FLOATING) at (3.75, 3.5) m touches nothing" in message


def test_a_tolerance_beyond_most_edges_is_refused_before_all_pairs_are_looked_at():
    angle = np.linspace(0.0, np.pi, 20_000)
    ring = np.stack([0.5 + np.cos(angle), np.sin(angle)], axis=1)
    message = error([BASE, Block(ring, 1.0, STONE)], 0.3)
    assert "it is too large for edges of 0.000157 m; write a smaller geometry.tolerance_m" in message
