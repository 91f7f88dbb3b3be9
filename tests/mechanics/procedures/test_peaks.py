"""The peak of a curve is that of its own flow: what another flow, a lift or forces left open would bear is not."""

from dataclasses import replace

import numpy as np
import pytest

from mechanics import Assembly, Material, limit_analysis, pushdown, pushover
from mechanics.procedures import held_load
from mechanics.procedures.limit_analysis import limit_in
from mechanics.procedures.push_path import PUSHOVER, PushInput, PushPath, PushPoint
from mechanics.steps.static_system import static_system
from tests.stress.corpus import assemblies
from tests.support.structures import block_on_base, built, in_bond, semicircular_arch


def settled_wall(friction, height, split, width, rows, movement, step, strength=np.inf):
    """A wall in bond on two supports that meet at `split`, the right one settled; rows of ends of bricks."""
    bases = {"left": (-0.4, -0.3, split, 0.0), "right": (split, -0.3, width + 0.6, 0.0)}
    stone = Material(20.0, friction, compressive_strength=strength)
    model = built(stone, *in_bond(rows, height), **bases)
    return model, pushdown(model, "right", movement, increment=step).final


def test_the_peak_of_a_curve_is_that_of_limit_analysis_in_its_state():
    """Behind a joint that closes, forces that slides leave open balance other multipliers: 0.447 and 0.409."""
    rows = [(0.0, 0.636, 1.272, 1.908), (0.0, 0.2961, 0.9321, 1.5682)]
    rows = [*rows, rows[0], (0.0, 0.368, 1.004, 1.6401)]
    model, settled = settled_wall(0.7756, 0.3, 0.954, 2.0, rows, (0.0262461, -0.0111493), 0.002)
    curve = pushover(model, increment=0.01, state=settled, until=0.7)
    peak = curve.states[curve.peak]
    assert curve.alpha_0 == pytest.approx(limit_analysis(model, "+x", peak).alpha, rel=1e-3)
    assert curve.alpha_0 == pytest.approx(0.353, rel=0.01)
    assert (curve.dropped[:, 1] > 1.2 * curve.alpha_0).all() and len(curve.dropped)


def test_a_finite_strength_raises_no_peak():
    """Held against no limit analysis it was 0.555, where joints that cannot be crushed have 0.539."""
    rows = [(0.0, 0.5, 1.0, 1.5), (0.0, 0.25, 0.75, 1.25, 1.5)]
    rows = [*rows, *rows, rows[0]]
    model, settled = settled_wall(0.7, 0.25, 0.5, 1.5, rows, (0.02259, -0.02556), 0.005, strength=1e7)
    curve = pushover(model, (1.5, 1.25), increment=0.004, state=settled, until=0.8)
    limit = limit_in(model.uncrushed, "+x", curve.states[curve.peak])
    assert curve.alpha_0 <= 1.001 * limit.alpha and len(curve.dropped)


def test_the_least_dilation_that_has_a_flow_decides():
    """A toothed wall of twelve, settled: contact dynamics of its own stands at 0.473 and falls at 0.477.

    Where a hinge has closed, forces by Coulomb's law miss equilibrium by 5 · 10⁻⁵. With a dilation of 0.001 limit
    analysis has 0.475, with one of 0.01 in some states 0.588: up to increments of 1 mm a point of that was told.
    """
    rows = [(0.0, 0.6, 1.2, 1.8), (0.0, 0.3, 0.9, 1.5)] * 2
    model, settled = settled_wall(0.7, 0.3, 1.2, 2.2, rows, (0.01, -0.006), 0.001)
    curve = pushover(model, increment=0.001, state=settled, until=0.8)
    assert curve.alpha_0 == pytest.approx(0.475, abs=2e-3)


@pytest.mark.parametrize(
    ("dilation", "shear", "placed"), [(0.0, 0.0, [0.3] * 6), (1.0, 0.0, []), (0.0, 2.0, [])]
)
def test_limit_analysis_replaces_a_peak_of_another_flow(monkeypatch, dilation, shear, placed):
    """Points looked at have the multiplier of their state, those between go; so do all where only lifting has one, or
    forces that depart from the model.
    """
    told = (0.4, 0.61, 0.62, 0.63, 0.62, 0.61, 0.61, 0.6, 0.5, 0.3)
    model = block_on_base()
    push = PushInput(np.array([0.0, 1.0]), "+x", 0.01, 0.0, PUSHOVER)
    path = PushPath(push, static_system(model, "rigid", "coulomb"), None)
    path.points = [
        PushPoint(replace(path.points[0].step, alpha=alpha), 0.01 * k, k == 6) for k, alpha in enumerate(told)
    ]
    of_state = limit_analysis(model, "+x")
    of_state = replace(of_state, forces=of_state.forces + shear * model.weight * np.eye(3)[2])

    def limit_at(own, point, model):
        other = 0.6 <= own.multiplier[point] < 0.7
        return replace(of_state, alpha=0.3 if other else 1.0, dilation=dilation if other else 0.0)

    monkeypatch.setattr(PushPath, "limit_at", limit_at)
    assert path.take_least_flow()
    assert path.multiplier.tolist() == [0.4, *placed, 0.5, 0.3]
    jumped = [k for k, point in enumerate(path.points) if point.jumped]
    assert jumped == [6 if placed else 1]  # the first point behind the one that has gone
    assert [alpha for _, alpha in path.dropped] == list(told[1:8])
    assert not path.take_least_flow()


@pytest.mark.parametrize(
    ("contacts", "least", "told"), [("rigid", False, 0.6), ("rigid", True, 0.45), ("elastic", True, 0.45)]
)
def test_a_motion_decides_on_what_limit_analysis_has_replaced(monkeypatch, contacts, least, told):
    """A curve that rises up to its peak: only behind a point that limit analysis has placed it is asked for.

    Its joints are those of the curve.
    """
    model = block_on_base(stiffness=1e8)
    push = PushInput(np.array([0.0, 1.0]), "+x", 0.01, 0.0, PUSHOVER)
    path = PushPath(push, static_system(model, contacts, "coulomb"), None)
    step = path.points[0].step
    path.points = [
        PushPoint(replace(step, alpha=alpha), 0.01 * k, least=least and k == 2)
        for k, alpha in enumerate((0.3, 0.4, 0.5, 0.6, 0.2))
    ]
    monkeypatch.setattr(PushPath, "limit_at", lambda *_: None)
    monkeypatch.setattr(held_load, "stands", lambda *given: given[1] == contacts and -given[-1] <= 0.45)
    assert path.peak_that_counts()[1] == pytest.approx(told, rel=0.05)


def test_points_beside_a_peak_of_another_flow_are_their_own():
    """All down to the lesser multiplier were dropped, α_0 was 0.421 by 4 mm; contact dynamics of its own: 0.515."""
    piers = [
        (left + shift, 0.314 * k, left + shift + 0.3667, 0.314 * (k + 1))
        for k, shift in enumerate((0.0, 0.0043))
        for left in (-1.002, 0.648)
    ]
    lintels = [(-0.8561, 0.8561), (-1.0583, -0.8561), (0.8561, 1.0583)]
    courses = [(low, 0.628, high, 0.8898) for low, high in lintels]
    courses += [(low, 0.8898, high, 1.1608) for low, high in ((-1.0383, 0.2582), (0.2582, 1.0383))]
    bases = {name: (low, -0.3, low + 1.0667, 0.0) for low, name in ((-1.4083, "left"), (0.3416, "right"))}
    model = built(Material(20.0, 0.747), *piers, *courses, **bases)
    settled = pushdown(model, "right", (-0.004935, 0.0008034), increment=0.0004935).final
    curve = pushover(model, None, "-x", increment=0.004, state=settled)
    assert curve.alpha_0 == pytest.approx(0.515, rel=0.01)


def test_the_peak_of_joints_that_crush_is_kept():
    """Limit analysis in the state does not know how far they were crushed: α_0 was 0.025, the onset."""
    crushed = Material(20.0, 3.0, compressive_strength=100.0)
    arch = semicircular_arch(9, 0.26, friction=3.0).blocks
    model = Assembly([replace(block, material=crushed) for block in arch])
    settled = pushdown(model, "right", (-0.02, -0.03), increment=0.002).final
    told = [pushover(model, increment=step, state=settled).alpha_0 for step in (0.004, 0.002)]
    assert told == pytest.approx([0.226, 0.226], rel=1e-3)


@pytest.mark.parametrize(("case", "told"), [(9, 0.8583), (13, 0.4361)])
def test_an_elastic_curve_on_which_an_end_brick_rocks_does_not_change_to_its_sliding(case, told):
    """Told 1.16 and 1.08, where motions under a load that rises slowly fall from 0.88 and 0.44 on."""
    model = dict(assemblies(24, seed=5))[case]
    rigid = pushover(model, increment=0.02 * model.size, until=0.9)
    elastic = pushover(model, contacts="elastic", increment=0.02 * model.size, until=0.25)
    assert elastic.alpha_0 == pytest.approx(told, rel=1e-3)
    assert elastic.alpha_0 < rigid.alpha_0
