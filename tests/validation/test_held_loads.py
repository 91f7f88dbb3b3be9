"""A settled state whose multiplier falls and rises again: what it bears of a load that grows and is held.

A block b × h leans on a wall at a distance g at φ = arcsin(g/h), past its balance β = arctan(b/h). Pushed off the wall
it turns about one corner: α = tan(φ − β) at first, and 0 at the balance, where it falls back on its foot. There a push
needs b/h; but what falls there under a held load rocks on over the other corner (Housner 1963).
"""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from mechanics import Assembly, Block, CollapseError, Following, Material, pushdown, pushover, time_history
from mechanics.procedures import held_load
from mechanics.procedures.held_load import borne
from tests.support.contact_dynamics import motion
from tests.support.drawn_projects import drawn, tables
from tests.support.leaning_block import GAP, B, H, leaning
from tests.support.random_masonry import random_masonry
from tests.support.structures import block_on_base, built, on_base, rectangle

BALANCE = math.atan(B / H)


@pytest.fixture(scope="module")
def settled():
    """The block, its state against the wall, and its lean."""
    model, state = leaning(0.9, 0.3, -GAP)
    lean = -float(state.positions[2, 2])
    assert lean == pytest.approx(math.asin(GAP / H), rel=1e-3)  # its foot may have slid a little
    return model, state, lean


def test_a_curve_ends_where_it_falls_under_the_load_that_moved_it(settled):
    model, state, lean = settled
    curve = pushover(model, (0.0, H), "-x", increment=0.01, state=state)
    assert curve.alpha_0 == pytest.approx(math.tan(lean - BALANCE), rel=1e-4)
    way = B * (math.cos(BALANCE) - math.cos(lean)) + H * (math.sin(lean) - math.sin(BALANCE))
    assert curve.displacement[-1] == pytest.approx(way, rel=1e-4)
    assert curve.reached_zero


@pytest.mark.parametrize(("share", "falls"), [(0.9, False), (1.1, True)])
def test_a_motion_under_a_load_that_is_held_agrees(settled, share, falls):
    model, state, lean = settled
    time = np.arange(0.0, 9.0, 0.005)
    load = share * math.tan(lean - BALANCE) * np.clip(time / 6.0, 0.0, 1.0)
    assert time_history(model, load, 0.005, contacts="rigid", state=state).collapsed is falls


@pytest.fixture(scope="module")
def portal():
    """Two piers of four blocks and a lintel, its right support let down by 0.45 of what it bears, and its curve."""
    stone, piers = Material(20.0, 0.65), (0.0, 2.5)
    feet = [Block(rectangle(x, -0.5, x + 0.5, 0.0), 1.0, stone, support=f"{x:g}") for x in piers]
    shafts = [
        Block(rectangle(x, 0.5 * k, x + 0.5, 0.5 * k + 0.5), 1.0, stone) for x in piers for k in range(4)
    ]
    model = Assembly([*feet, *shafts, Block(rectangle(0.0, 2.0, 3.0, 2.5), 1.0, stone)])
    state = pushdown(model, "2.5", (0.0, -0.2025), increment=0.01).final
    return model, pushover(model, direction="+x", state=state, increment=0.01)


def test_a_curve_that_rises_behind_a_trough_goes_on_and_its_first_peak_counts(portal):
    """It ended in the trough, at a tenth of the displacement from which it comes back when it is let go."""
    _, curve = portal
    trough = curve.multiplier[curve.peak : int(curve.multiplier.argmax())].min()
    assert trough < 0.9 * curve.alpha_0 < 0.9 * 0.7 * curve.multiplier.max()
    assert curve.reached_zero
    assert curve.displacement[-1] > 20.0 * curve.displacement[curve.peak]


@pytest.mark.parametrize(("share", "falls"), [(0.97, False), (1.03, True)])
def test_the_first_peak_is_what_the_portal_bears_held(portal, share, falls):
    """The base is accelerated to the left: what stands on it is pushed to the right."""
    model, curve = portal
    load = -share * curve.alpha_0 * np.clip(np.arange(0.0, 12.0, 0.005) / 6.0, 0.0, 1.0)
    motion = time_history(model, load, 0.005, contacts="rigid", state=curve.states[0])
    assert motion.collapsed is falls


def test_what_is_pushed_beyond_the_trough_comes_back_when_it_is_let_go(portal):
    model, curve = portal
    far = int(np.searchsorted(curve.displacement, 0.9 * curve.displacement[-1]))
    motion = time_history(model, np.zeros(400), 0.005, contacts="rigid", state=curve.states[far])
    assert not motion.collapsed


STONES = (
    ((0.0, 0.0), (0.457, 0.0), (0.489, 0.522), (0.0, 0.708)),
    ((0.457, 0.0), (0.881, 0.0), (1.025, 0.466), (0.642, 0.619), (0.489, 0.522)),
    ((0.881, 0.0), (1.487, 0.0), (1.443, 0.401), (1.105, 0.5), (1.025, 0.466)),
    ((1.487, 0.0), (2.0, 0.0), (2.0, 0.532), (1.696, 0.607), (1.443, 0.401)),
    ((0.0, 0.708), (0.489, 0.522), (0.642, 0.619), (0.688, 1.039), (0.545, 1.125), (0.0, 0.925)),
    ((0.642, 0.619), (1.025, 0.466), (1.105, 0.5), (1.154, 0.969), (0.95, 1.116), (0.688, 1.039)),
    ((1.105, 0.5), (1.443, 0.401), (1.696, 0.607), (1.563, 1.034), (1.154, 0.969)),
    ((1.696, 0.607), (2.0, 0.532), (2.0, 1.199), (1.569, 1.045), (1.563, 1.034)),
    ((0.0, 0.925), (0.545, 1.125), (0.422, 1.6), (0.0, 1.6)),
    ((0.545, 1.125), (0.688, 1.039), (0.95, 1.116), (1.071, 1.6), (0.422, 1.6)),
    ((0.95, 1.116), (1.154, 0.969), (1.563, 1.034), (1.569, 1.045), (1.438, 1.6), (1.071, 1.6)),
    ((1.569, 1.045), (2.0, 1.199), (2.0, 1.6), (1.438, 1.6)),
)


def wall_of_polygons():
    """A wall of twelve stones on two bases, the right one moved: its curve goes on to 0.331 beyond the first peak."""
    stone = Material(20.0, 0.8, 2e7, 2e7)
    bases = ((-0.4, 1.15, "left"), (1.15, 2.4, "right"))
    blocks = [Block(rectangle(a, -0.3, b, 0.0), 1.0, stone, support=name) for a, b, name in bases]
    model = Assembly([*blocks, *(Block(ring, 1.0, stone) for ring in STONES)])
    state = pushdown(model, "right", (0.0262, -0.0123), increment=0.001, contacts="elastic").final
    return pushover(model, (2.0, 1.6), "+x", "elastic", 0.004, state)


def buttressed_arch():
    """The arch of the example, its right pier moved, pushed to the left: 0.105 beyond where α vanishes."""
    model, table = drawn("buttressed_arch"), tables("buttressed_arch")["settlements"][0]
    state = pushdown(model, table["support"], table["displacement_m"], increment=table["increment_m"]).final
    return pushover(model, direction="-x", increment=5e-4, state=state)


@pytest.mark.parametrize("pushed", [wall_of_polygons, buttressed_arch])
def test_contact_dynamics_stands_under_what_a_curve_with_a_trough_has_and_falls_above(pushed):
    """They had 0.331 and 0.105, of equilibria behind the trough that no growing load reaches."""
    curve = pushed()
    grown = np.clip(np.arange(0.0, 4.5, 2e-3) / 3.0, 0.0, 1.0)
    for share, falls in ((0.95, False), (1.08, True)):
        load = share * curve.alpha_0 * (grown if curve.direction == "+x" else -grown)
        moved = motion(curve.model, load, 2e-3, curve.states[0])[-1] - curve.states[0].positions
        assert (abs(moved[:, :2]).max() > curve.model.size) is np.bool_(falls)


def loaded(monkeypatch, alpha, most, jumps=(), flat=1e-3):
    """What is borne of the multipliers of a curve if motions stand up to `most`, and the loads that were tried."""
    tried = []

    def stands(*given):
        tried.append(-given[-1])  # towards +x the base is accelerated towards −x
        return tried[-1] <= most

    monkeypatch.setattr(held_load, "stands", stands)
    jumped = np.isin(np.arange(len(alpha)), jumps)
    model = block_on_base()
    return borne(np.array(alpha), jumped, flat, model, "+x", "rigid", "coulomb", model.initial), tried


@pytest.mark.parametrize("most", [0.0, 0.52, 0.6, 0.75])
def test_what_is_borne_is_between_the_first_peak_and_what_fells_the_structure(monkeypatch, most):
    found, tried = loaded(monkeypatch, [0.4, 0.5, 0.3, 0.45, 0.8, 0.1], most)
    least = max(most, 0.5)
    assert 0.95 * least <= found <= least and len(tried) < 8


def test_all_of_a_curve_is_borne_where_a_motion_is_under_nearly_all_of_it(monkeypatch):
    assert loaded(monkeypatch, [0.4, 0.5, 0.3, 0.45, 0.8, 0.1], 0.77) == (math.inf, [pytest.approx(0.76)])


def test_a_structure_that_bears_nothing_ends_the_search(monkeypatch):
    found, tried = loaded(monkeypatch, [0.0, 0.5, 0.3, 0.8], 0.0, jumps=[1])
    assert found == 0.0 and len(tried) < 8


def test_a_curve_that_rises_and_falls_needs_no_motion_but_one_that_jumps_does(monkeypatch):
    assert loaded(monkeypatch, [0.4, 0.5, 0.6, 0.3], 0.0) == (math.inf, [])
    assert loaded(monkeypatch, [0.4, 0.5, 0.6, 0.3], 0.0, jumps=[2])[1]


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
@pytest.mark.parametrize(("alpha", "holds"), [(0.28, True), (0.35, False)])
def test_what_slides_on_a_base_that_goes_on_for_ever_does_not_stand(contacts, alpha, holds):
    """Friction 0.3: it is never out of reach of its base."""
    model = on_base(Material(20.0, 0.3, 1e6), (-200.0, -1.0, 200.0), (0.0, 0.0, 1.0, 1.0))
    assert held_load.stands(model, contacts, "coulomb", model.initial, alpha) is holds


@pytest.mark.parametrize(("width", "stiffness"), [(0.01, 1e8), (0.2, 3600.0), (5.0, 3060.0)])
def test_an_elastic_block_released_where_it_balances_falls_however_slowly(width, stiffness):
    """After 5 √(L/g) it moved by less than elastic joints tremble, faster from step to step, and was told to stand."""
    model = block_on_base(width, 5.0 * width, stiffness=stiffness)
    curve = pushover(model, (width, 5.0 * width), "+x", "elastic", 0.01 * width)
    assert curve.reached_zero
    before, balance = curve.states[-2:]
    way = balance.positions - before.positions
    assert not held_load.stands_kicked(model, "elastic", "coulomb", balance, way, held_load.KICKS[:1])


@pytest.mark.parametrize("seed", [102, 135])
def test_the_last_state_of_a_path_that_falls_by_creeping_does_not_stand(seed, monkeypatch):
    """It falls after 8 and 11 √(L/g), from a thousandth of the energy of its kick: a hundredth counted as spent."""
    model = random_masonry(seed)
    monkeypatch.setattr("mechanics.procedures.pushdown.KICKED", ())
    way = model.size * np.array([0.2, -0.1])
    path = pushdown(model, "right", way, increment=0.02 * model.size, to_collapse=True)
    before, last = path.states[-2:]
    way = last.positions - before.positions
    assert not held_load.stands_kicked(model, "rigid", "coulomb", last, way, held_load.KICKS[:1])


def test_what_balances_beside_a_heavy_block_that_slides_falls():
    """The heavy block had spent the kick, of which the column beside it had 1/5000: released it was told to stand."""
    model = on_base(Material(20.0, 0.7), (-10.0, -0.5, 10.0), (-6.0, 0.0, -2.0, 6.0), (2.0, 0.0, 2.1, 2.0))
    lean = math.atan(0.1 / 2.0)
    positions, way = model.initial.positions.copy(), np.zeros_like(model.initial.positions)
    positions[2] = (2.1, 0.5 * math.hypot(0.1, 2.0), -lean)
    way[1], way[2] = (1.0, 0.0, 0.0), (0.1, 0.0, -0.1)
    balance = replace(model.initial, positions=positions)
    assert not held_load.stands_kicked(model, "rigid", "coulomb", balance, way, held_load.KICKS[:1])


@pytest.mark.parametrize(("seed", "falls"), [(12, True), (66, True), (72, False)])
def test_contact_dynamics_falls_and_stands_where_a_part_snaps_on_a_moving_support(seed, falls):
    """Without inertia the arches rest farther on: their ultimate movements were 0.726 and 0.516 m."""
    model = random_masonry(seed)
    way = model.size * np.array([0.2, -0.1])
    path = pushdown(model, "right", way, increment=0.02 * model.size, to_collapse=True)
    before, beyond = (path.ultimate, path.ultimate + 0.02 / 32 * model.size) if falls else path.crossed[0]
    state = path.states[int(np.argmin(abs(path.movement - before)))]
    moved = model.moved_support(state.positions, "right", beyond / way[0] * way, 0.0)
    snapped = motion(model, np.zeros(3000), 1e-3, replace(state, positions=moved))[-1] - moved
    assert (abs(snapped[:, :2]).max() > model.size) is np.bool_(falls)
    assert len(path.crossed) == (0 if falls else 1)


WALLS = {  # of three rows, 2 m wide: friction, tops of the rows, joints in each; the path went on to so many m or more
    "442": (0.8, (0.506, 0.902, 1.254), ((0.582, 1.335), (0.507, 0.958, 1.421), (0.678, 1.323)), 0.73),
    "405": (
        0.6,
        (0.435, 0.845, 1.444),
        ((0.436, 1.064, 1.574), (0.569, 1.273), (0.555, 1.043, 1.532)),
        0.68,
    ),
    "408": (0.6, (0.441, 1.008, 1.457), ((0.549, 1.233), (0.527, 0.976, 1.42), (0.607, 1.255)), 0.73),
}


def wall(name):
    friction, tops, joints, _ = WALLS[name]
    rows = [
        (left, low, right, top)
        for low, top, row in zip((0.0, *tops), tops, joints, strict=False)
        for left, right in pairwise((0.0, *row, 2.0))
    ]
    return built(Material(20.0, friction), *rows, left=(-0.4, -0.3, 1.0, 0.0), right=(1.0, -0.3, 2.4, 0.0))


@pytest.mark.parametrize("name", WALLS)
def test_contact_dynamics_holds_a_wall_up_to_its_ultimate_movement_and_not_beyond(name, monkeypatch):
    """Equilibria go on behind it, which stay where nothing moves. By contact dynamics they fall at once."""
    model, beyond = wall(name), WALLS[name][3]
    movement, increment = model.size * np.array([-0.02, -0.005]), 0.02 * model.size
    told = pushdown(model, "right", movement, increment=increment, to_collapse=True)
    monkeypatch.setattr("mechanics.procedures.pushdown.KICKED", ())
    whole = pushdown(model, "right", movement, increment=increment, to_collapse=True)
    assert beyond < whole.ultimate < 1.1 * beyond
    for share, falls in ((0.95, False), (1.05, True)):
        state = whole.states[int(np.argmin(abs(whole.movement - share * told.ultimate)))]
        held = motion(model, np.zeros(2000), 1e-3, state)
        assert (abs(held[-1] - held[0])[:, :2].max() > model.size) is np.bool_(falls)


@pytest.mark.parametrize("whole", [0.70, 0.82])
def test_an_ultimate_movement_is_that_of_a_smaller_one_where_the_whole_falls(whole):
    """It was the last point before the whole movement, or the last equilibrium: 0.694 and 0.744 m."""
    model = wall("442")
    way = np.array([-1.0, -0.25])
    told = pushdown(model, "right", 0.1 * way, increment=0.02 * model.size, to_collapse=True).ultimate
    with pytest.raises(CollapseError) as fall:
        pushdown(model, "right", whole * way, increment=0.02 * model.size)
    assert fall.value.path.ultimate == pytest.approx(told, rel=0.01)
    assert len(fall.value.path.certificates) == len(fall.value.path.steps) + 1
    follow = Following(model, "right", increment=0.02 * model.size)
    follow.to(whole * way)
    assert follow.fallen is (whole > 0.8)
    follow.release()
    assert follow.fallen


def test_an_elastic_arch_does_not_stand_because_it_lingers_where_it_balances():
    """Released at 0.001 √(size·g) alone it was told 0.222 m; at 0.005 it falls in its snap."""
    model = random_masonry(120)
    way = model.size * np.array([0.2, -0.1])
    path = pushdown(model, "right", way, increment=0.02 * model.size, contacts="elastic", to_collapse=True)
    assert path.ultimate == pytest.approx(0.1941, rel=5e-3)


def test_an_arch_on_the_edge_of_its_snap_falls_at_the_slower_release():
    """Eleven voussoirs, 1.5 m to the intrados, 0.276 m thick: released at 0.005 √(size·g) alone it was told 0.437 m."""
    stone, ends = Material(20.0, 0.7), np.radians(np.linspace(158.8876, 21.1124, 12))
    ray = np.column_stack([np.cos(ends), np.sin(ends)])
    blocks = [
        Block([1.5 * ray[k], 1.776 * ray[k], 1.776 * ray[k + 1], 1.5 * ray[k + 1]], 0.5, stone)
        for k in range(11)
    ]
    for name, at, sign in (("left", ray[0], -1.0), ("right", ray[-1], 1.0)):
        out = 0.3 * sign * np.array([at[1], -at[0]])
        face = [1.5 * at, 1.776 * at, 1.776 * at + out, 1.5 * at + out]
        blocks.append(Block(face, 0.5, stone, support=name))
    model = Assembly(blocks)
    way = model.size * np.array([0.2, -0.1])
    path = pushdown(model, "right", way, increment=0.02 * model.size, to_collapse=True)
    assert path.ultimate == pytest.approx(0.3752, rel=5e-3)
