"""Ties against closed forms: a wall 0.5 × 3 m on a base, tied at 2.5 m to a pier that does not move.

With rotation θ about its toe and the tension F: α W z = W x + F r, from its moments in the turned configuration.
"""

from dataclasses import replace

import numpy as np
import pytest

from mechanics import (
    Assembly,
    Block,
    CollapseError,
    Material,
    Tie,
    limit_analysis,
    pushdown,
    pushover,
    time_history,
)
from mechanics.procedures import limit_in, static_theorem
from mechanics.procedures.collapse import broken_tie
from mechanics.steps.static_system import static_system
from tests.support.structures import arch_on_piers, rectangle, tied_arch

B, H, AT, AWAY = 0.5, 3.0, 2.5, 1.5  # width and height of the wall, height of the tie, its length, m
STONE = Material(20.0, 5.0, normal_stiffness=1e6)
BLOCKS = [
    Block(rectangle(-3.0, -0.5, 4.0, 0.0), 1.0, STONE, support="base"),
    Block(rectangle(0.0, 0.0, B, H), 1.0, STONE),
    Block(rectangle(-2.0, 0.0, -AWAY, 4.0), 1.0, STONE, support="pier"),
]
WEIGHT = 20.0 * B * H
FORCE = 3.0  # kN


def tied_wall(force=FORCE, **tie):
    return Assembly(BLOCKS, ties=[Tie("chain", (-AWAY, AT), (0.0, AT), force, **tie)])


def multiplier(positions, force):
    """α of the wall turned about its toe by its rotation, with the tension in the tie."""
    x, z, turn = positions[1]
    arm = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ (-B, AT)
    pull = np.array([-AWAY, AT]) - (arm + np.array([B, 0.0]))
    pull *= force / np.linalg.norm(pull)
    return (WEIGHT * (B - x) + arm[0] * pull[1] - arm[1] * pull[0]) / (WEIGHT * z)


def test_the_onset_with_a_tie_that_yields():
    """α₀ = (W b/2 + F h_t)/(W h/2), by the program written apart too; towards the pier the tie is slack."""
    force = 10.0
    model = tied_wall(force)
    expected = (WEIGHT * B / 2 + force * AT) / (WEIGHT * H / 2)
    assert limit_analysis(model, "+x").alpha == pytest.approx(expected, rel=1e-7)
    assert static_theorem(model, "+x") == pytest.approx(expected, rel=1e-7)
    assert limit_analysis(model, "+x").forces[-1, 0] == pytest.approx(force, rel=1e-6)
    assert limit_analysis(model, "-x").alpha == pytest.approx(B / H, rel=1e-6)
    assert limit_analysis(model, "-x").forces[-1, 0] == pytest.approx(0.0, abs=1e-5 * force)


def test_a_tie_that_does_not_yield_leaves_sliding():
    """With μ = 0.3 the wall slides at its foot as it is held at the tie; without the tie it overturns at b/h."""
    slippery = [Block(b.polygon, 1.0, Material(20.0, 0.3), support=b.support) for b in BLOCKS]
    model = Assembly(slippery, ties=[Tie("chain", (-AWAY, AT), (0.0, AT))])
    # held at the tie its foot slides out when μW(AT) resists: α W (AT − h/2) = μ W AT − W (b/2 − e), |e| ≤ b/2
    expected = (0.3 * AT + B / 2) / (AT - H / 2)
    assert limit_analysis(model, "+x").alpha == pytest.approx(expected, rel=1e-6)


def test_a_rigid_curve_with_a_tie_that_yields():
    """Exact in any configuration, at any increment: the tie pulls along the line of its ends."""
    path = pushover(tied_wall(), (B, H), "+x", increment=0.1)
    for state, found in zip(path.states[1:-1], path.multiplier[1:-1], strict=True):
        assert found == pytest.approx(multiplier(state.positions, FORCE), abs=5e-8)
        assert state.lengthened == pytest.approx(
            np.hypot(*(tip(state.positions) - (-AWAY, AT))) - AWAY, abs=1e-8
        )
    assert path.reached_zero


def tip(positions):
    x, z, turn = positions[1]
    return (x, z) + np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ (
        -B / 2,
        AT - H / 2,
    )


@pytest.mark.parametrize("stiffness", [1e3, None])
def test_an_elastic_curve_comes_to_that_of_the_tie_that_yields(stiffness):
    """Peak: of a rigid wall less what the bed's compression takes; the same at any stiffness of the tie."""
    path = pushover(tied_wall(stiffness=stiffness), (B, H), "+x", contacts="elastic", increment=0.01)
    assert path.multiplier.max() == pytest.approx(0.3062, rel=1e-3)
    assert path.reached_zero


def test_an_elastic_tie_shares_the_push_with_the_bed():
    """Small turns about the foot: M = (k b³/12 + k_t h_t² − W h/2) θ, the tie takes k_t h_t θ."""
    stiffness = 100.0
    path = pushover(tied_wall(stiffness=stiffness), (B, H), "+x", contacts="elastic", increment=2e-3)
    assert path.displacement[2] < 7e-4  # the whole bed is pressed
    bed = 1e6 * B**3 / 12.0
    turn = path.multiplier[2] * WEIGHT * H / 2 / (bed + stiffness * AT**2 - WEIGHT * H / 2)
    assert path.steps[2].forces[-1, 0] == pytest.approx(stiffness * AT * turn, rel=1e-3)


def test_pretension_pulls_until_the_bed_holds_it():
    """The tension at rest: the pretension less what the turn of the wall on its bed takes, springs in series."""
    stiffness, pull = 1e4, 2.0
    path = pushover(
        tied_wall(stiffness=stiffness, pretension=pull), (B, H), "+x", contacts="elastic", increment=0.05
    )
    bed = 1e6 * B**3 / 12.0 - WEIGHT * H / 2
    # the foot, infinitely stiff in shear, stays where it is
    assert path.steps[0].forces[-1, 0] == pytest.approx(pull / (1.0 + stiffness * AT**2 / bed), rel=2e-3)


@pytest.mark.parametrize(("share", "breaks"), [(0.99, False), (1.01, True)])
def test_a_tie_breaks_in_a_motion_where_it_has_yielded_by_all_that_it_can(share, breaks):
    """A hundredth of its length; the elastic part does not count, 3 kN at 1000 kN/m."""
    model = tied_wall(stiffness=1e3, ultimate_elongation=0.01)
    moved = model.initial.positions.copy()
    moved[1, 0] += share * 0.01 * AWAY + FORCE / 1e3
    found = broken_tie(static_system(model, "elastic"), np.array([model.initial.positions, moved]))
    assert (found is not None) is breaks
    assert not breaks or (found[0] == 1 and "the tie chain breaks" in found[1])


def test_what_a_tie_has_yielded_it_keeps():
    """Pushed, and pushed again from there: the tie is taut at its new length, and yields at once."""
    first = pushover(tied_wall(), (B, H), "+x", increment=0.02)
    state = first.states[8]
    assert limit_in(tied_wall(), "+x", state).alpha == pytest.approx(first.multiplier[8], abs=1e-6)
    # half-way back it is slack by what it has yielded, though longer than as drawn
    back = first.states[4].positions
    half = type(state)(back, 0.0 * back, lengthened=state.lengthened)
    assert limit_in(tied_wall(), "+x", half).alpha == pytest.approx(multiplier(back, 0.0), abs=1e-6)


@pytest.mark.parametrize("direction", ["+x", "-x"])
@pytest.mark.parametrize("force", [0.1, np.inf])
def test_limit_analysis_of_a_tied_arch_by_a_program_written_apart(direction, force):
    model = tied_arch(force)
    assert limit_analysis(model, direction).alpha == pytest.approx(static_theorem(model, direction), rel=1e-6)


def test_an_arch_tied_at_its_springings_outlives_the_spread_of_a_support():
    """Without the tie it falls at 0.14 m; a tie that yields at 0.02 kN, a hundredth of the thrust, adds little."""
    chain = tied_arch().ties[:1]
    held = pushdown(tied_arch().tied(chain), "right", (0.2, 0.0), increment=0.02, contacts="elastic")
    assert held.movement[-1] == pytest.approx(0.2)
    ends = []
    for ties in ([], [replace(chain[0], yield_force=0.02)]):
        with pytest.raises(CollapseError) as fall:
            pushdown(tied_arch().tied(ties), "right", (0.2, 0.0), increment=0.02, contacts="elastic")
        ends.append(fall.value.path.movement[-1])
    assert ends[0] < 0.145
    assert ends[0] == pytest.approx(ends[1], rel=0.08)


SLIDER = Block(rectangle(0.0, 0.0, 1.0, 0.5), 1.0, Material(20.0, 0.0, normal_stiffness=1e6))
FLOOR = Block(rectangle(-3.0, -0.5, 6.0, 0.0), 1.0, SLIDER.material, support="floor")
POST = Block(rectangle(-3.0, 0.0, -2.0, 1.0), 1.0, SLIDER.material, support="post")
MASS, SPEED, YIELD = SLIDER.mass, 0.4, 2.0  # Mg, m/s, kN


@pytest.mark.parametrize(
    ("integrator", "close"), [("moreau-jean", 0.01), ("second-order", 0.01), ("implicit-euler", 0.05)]
)
@pytest.mark.parametrize("stiffness", [None, 200.0])
def test_a_block_that_slides_off_yields_its_tie_and_comes_back(integrator, close, stiffness):
    """½mv² = F²/2k + F e, e the length that it yields; a tie of stiffness k throws it back at F/√(km)."""
    contacts = "elastic" if stiffness else "rigid"
    model = Assembly([FLOOR, SLIDER, POST], ties=[Tie("chain", (-2.0, 0.25), (0.0, 0.25), YIELD, stiffness)])
    start = model.initial
    velocities = np.zeros_like(start.velocities)
    velocities[1, 0] = SPEED
    motion = time_history(
        model, np.zeros(401), 0.001, contacts, replace(start, velocities=velocities), integrator=integrator
    )
    springs = YIELD**2 / (2.0 * stiffness) if stiffness else 0.0
    assert motion.final.lengthened[0] == pytest.approx((0.5 * MASS * SPEED**2 - springs) / YIELD, rel=close)
    back = YIELD / np.sqrt(stiffness * MASS) if stiffness else 0.0
    assert motion.velocities[-1, 1, 0] == pytest.approx(-back, rel=2.0 * close, abs=1e-3)
    assert abs(motion.energy.residual).max() < 1e-4 * 0.5 * MASS * SPEED**2


def released(ties, step, lean, longer=None, integrator="auto", contacts="rigid"):
    """Return the motion of the wall let go from a share of its angle b/h."""
    model = Assembly(BLOCKS, ties=ties)
    state = model.rotated(block=1, about=(0.0, 0.0), rotation=lean * np.arctan(B / H))
    state = state if longer is None else replace(state, lengthened=np.array([longer]))
    rest = np.zeros(round(1.8 / step) + 1)
    return time_history(model, rest, step, contacts, state, integrator, control=(B, H))


CHAIN = Tie("chain", (-AWAY, AT), (0.0, AT), FORCE)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_slack_tie_changes_nothing_of_a_motion(contacts):
    """The wall rocks to either side, its tie longer than it goes: the same impacts, to 1e-12 m."""
    free = released([], 2.5e-3, 0.35, contacts=contacts)
    slack = released([CHAIN], 2.5e-3, 0.35, longer=1.0, contacts=contacts)
    assert free.energy.impact[-1] > 0.0 or contacts == "elastic"
    np.testing.assert_allclose(slack.positions, free.positions, rtol=0.0, atol=1e-12)
    assert (free.programs, free.halvings) == (slack.programs, slack.halvings)


@pytest.mark.parametrize(("contacts", "amplitude"), [("rigid", 0.25), ("elastic", 0.1)])
def test_a_tied_arch_is_shaken_in_balance_of_energy(contacts, amplitude):
    """Of taut and slack, of yielding and of rocking; its ties hold it up where it falls without."""
    time = np.arange(0.0, 2.0, 0.005)
    shock = amplitude * np.sin(4.0 * np.pi * time) * (time < 1.0)
    motions = {
        force: time_history(tied_arch(force, stiffness=500.0), shock, 0.005, contacts)
        for force in (0.05, np.inf)
    }
    for motion in motions.values():
        assert abs(motion.energy.residual).max() < 1e-3 * motion.energy.kinetic.max()
    assert motions[0.05].forces[:, -2:, 0].max() == pytest.approx(0.05, rel=5e-3)
    assert motions[0.05].final.lengthened.max() > 1e-5
    assert not motions[np.inf].final.lengthened.any()
    assert not motions[np.inf].collapsed
    assert time_history(tied_arch().tied([]), shock, 0.005, contacts).collapsed


@pytest.mark.parametrize("stiffness", [None, 1400.0])
def test_an_elastic_structure_that_its_tie_holds_is_pushed_though_it_gives_way_at_once(stiffness):
    """A settled arch with open hinges moves by a hundred times the compression of its joints, until its tie pulls."""
    arch = arch_on_piers(
        voussoirs=12, thickness=0.126, pier_width=0.27, courses=5, friction=0.57, stiffness=1.7e6
    ).tied([Tie("chain", (-0.7, 0.77), (0.7, 0.77), stiffness=stiffness)])
    settled = pushdown(arch, "right", (0.03, -0.02), 0.002, contacts="elastic").final
    path = pushover(arch, (0.6, 0.84), "-x", contacts="elastic", increment=0.005, state=settled)
    assert path.multiplier.max() > 0.1
    tie = len(arch.joints.a)
    assert path.steps[int(np.argmax(path.multiplier))].forces[tie, 0] > 0.02 * arch.weight


def test_a_slack_tie_changes_nothing_of_an_elastic_curve():
    """To the last digit. With a slack of 1 m the wall did not come to rest; others had another α_u."""
    stone = Material(20.0, 0.7, 1e5)
    shapes = [((-1.0, -0.5, 2.0, 0.0), "base"), ((0.0, 0.0, 0.5, 0.5), None), ((0.5, 0.0, 1.0, 0.5), None),
              ((0.0, 0.5, 1.0, 1.0), None)]  # fmt: skip
    blocks = [Block(rectangle(*corners), 1.0, stone, support=support) for corners, support in shapes]
    chain = Tie("chain", (0.5, 0.75), (0.5, -0.25), length=2.0)
    free, held = (
        pushover(Assembly(blocks, ties=ties), (1.0, 1.0), "+x", "elastic", 0.02) for ties in ([], [chain])
    )
    assert held.multiplier == pytest.approx(free.multiplier, abs=1e-12)
    assert held.displacement == pytest.approx(free.displacement, abs=1e-12)
