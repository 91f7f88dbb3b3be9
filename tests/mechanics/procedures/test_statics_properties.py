"""What must hold for the static procedures whatever the structure: invariance, equilibrium, bounds, agreement."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from assessment.project.catalogue.new_project import TEMPLATES, new_project
from mechanics import Assembly, limit_analysis, pushdown, pushover
from mechanics.kernels.joint import H
from mechanics.model.contacts import end_gaps
from mechanics.procedures.limit_analysis import virtual_work_multiplier
from mechanics.steps.equilibrium import reaction, rest
from mechanics.steps.static_system import static_system
from tests.support.drawn_projects import drawn
from tests.support.steps import by_highs
from tests.support.structures import arch_on_piers, block_on_base, semicircular_arch

SIZE = 0.02  # m, of the movement imposed


@cache
def arch() -> Assembly:
    return arch_on_piers(voussoirs=9, courses=3)


CONTROL = (0.65, 0.8)  # top of the arch's right pier, outer edge of the ring


def stiffer(model, stiffness, weight=1.0):
    """The same blocks of one material whose stiffness and weight are multiplied by these."""
    [stone] = {b.material for b in model.blocks}
    other = replace(
        stone, normal_stiffness=stiffness * stone.normal_stiffness, unit_weight=weight * stone.unit_weight
    )
    return Assembly([replace(b, material=other) for b in model.blocks], model.segments_per_joint)


@cache
def curves(model, control=CONTROL, scale=1.0):
    """α, reaction and both pushover curves, original and settled: what a change of frame must not change."""
    moved = pushdown(model, "right", scale * np.array([SIZE, -SIZE]), increment=scale * SIZE / 4)
    start = pushover(model, control, "+x", "rigid", scale * 0.01)
    settled = pushover(model, control, "+x", "rigid", scale * 0.01, moved.final)
    elastic = pushover(model, control, "+x", "elastic", scale * 0.01)
    return limit_analysis(model).alpha, moved, (start, settled, elastic)


@pytest.mark.parametrize(("scale", "factor"), [(1e-3, 1e5), (30.0, 1e-3)])
def test_in_other_units_and_places_and_another_order_the_curves_only_stretch(scale, factor):
    """Weights per volume and stiffnesses per volume times a factor: their ratio is a length per length."""
    shift = np.array([17.3, -4.9])
    blocks = [
        replace(b, vertices=scale * (b.polygon + shift)) for b in stiffer(arch(), factor, factor).blocks
    ]
    order = np.random.default_rng(2).permutation(len(blocks))
    alpha, moved, pushed = curves(
        Assembly([blocks[i] for i in order]), tuple(scale * np.add(CONTROL, shift)), scale
    )
    expected = curves(arch())
    assert alpha == pytest.approx(expected[0], rel=1e-7)
    assert moved.movement == pytest.approx(scale * expected[1].movement)
    reactions = factor * scale**2 * expected[1].reaction
    assert moved.reaction == pytest.approx(reactions, abs=1e-4 * abs(reactions).max())
    for new, old in zip(pushed, expected[2], strict=True):
        assert new.reached_zero == old.reached_zero
        assert new.multiplier.max() == pytest.approx(old.multiplier.max(), rel=1e-4)
        # α = 0 is reached within a part of an increment of 10 mm, of which the order of the blocks decides the last
        end = scale * old.displacement[-1]
        assert new.displacement[-1] == pytest.approx(end, rel=2e-3, abs=scale * 1e-4)
        d = np.linspace(0.0, 0.98 * old.displacement[-1], 20)  # some end in a jump
        before = np.interp(d, old.displacement, old.multiplier)
        after = np.interp(scale * d, new.displacement, new.multiplier)
        assert after == pytest.approx(before, abs=2e-3 * before.max())


def residual(model, step):
    """ΣFx, ΣFz and ΣM (3,) of reactions and loads, per weight and per weight times the structure's size."""
    total = sum(reaction(step, np.array([i])) for i in np.flatnonzero(~model.movable))
    loads = np.where(model.movable[:, None], model.dead_load + step.alpha * model.lateral_load("+x"), 0.0)
    x, z = step.state.positions[:, :2].T
    total = total + loads.sum(axis=0) + (0.0, 0.0, (x * loads[:, 1] - z * loads[:, 0]).sum())
    extent = np.ptp(model.initial.positions[:, :2])
    return abs(total) / (model.weight, model.weight, model.weight * extent)


STRUCTURES = {
    "block": (block_on_base, (0.2, 1.0), "base"),
    "arch on piers": (arch, CONTROL, "right"),
    "arch": (lambda: semicircular_arch(10, 0.2, 0.7), (0.0, 1.1), "right"),
}


@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
@pytest.mark.parametrize("name", STRUCTURES)
def test_reactions_balance_the_loads_in_every_step_and_no_joint_carries_more_than_it_can(name, behaviour):
    """|T| ≤ μN and |P| ≤ hN at every point of a settlement and of pushes before and after; no face lies in another."""
    make, control, support = STRUCTURES[name]
    model = make()
    moved = pushdown(model, support, (0.01, -0.005), increment=0.002, contacts=behaviour)
    pushed = [pushover(model, control, "+x", behaviour, 0.005, state) for state in (None, moved.final)]
    for path in (moved, *pushed):
        assert len(path.steps) > 3
        for step in path.steps:
            assert residual(model, step) == pytest.approx(np.zeros(3), abs=3e-6)
            within_cones(model, step)


@pytest.mark.parametrize("name", STRUCTURES)
def test_virtual_work_and_another_solver_give_the_multiplier_in_displaced_configurations(name):
    """Within 1 %: the paper's check, α of the motion out of a configuration, and that of the joints closed there."""
    make, control, _ = STRUCTURES[name]
    model = make()
    path = pushover(model, control, "+x", "rigid", 0.002)
    assert len(path.states) > 10
    for k in np.linspace(0, len(path.states) - 2, 5).astype(int):
        found = by_highs(model, path.states[k])
        assert found == pytest.approx(path.multiplier[k], abs=0.01 * path.multiplier.max())
    jumps = set(path.crossed[:, 0])
    for k in range(1, len(path.states) - 2):
        if path.displacement[k] in jumps:
            continue  # a part moves by itself
        motion = path.states[k + 1].positions - path.states[k].positions
        between = sorted(path.multiplier[k : k + 2])
        slack = 0.01 * path.multiplier.max()
        assert between[0] - slack <= virtual_work_multiplier(model, motion, "+x") <= between[1] + slack


@pytest.mark.parametrize("name", STRUCTURES)
def test_the_elastic_peak_stays_below_the_rigid_multiplier_and_tends_to_it(name):
    make, control, _ = STRUCTURES[name]
    soft = make()
    onset = limit_analysis(soft).alpha
    models = [stiffer(soft, factor) for factor in (1.0, 100.0, 1e5)]
    peaks = [pushover(each, control, "+x", "elastic", 0.01, until=0.8).multiplier.max() for each in models]
    assert peaks == sorted(peaks)
    assert peaks[-1] <= onset * (1.0 + 1e-6)
    assert peaks[-1] == pytest.approx(onset, rel=2e-2)


def test_the_reaction_at_the_onset_of_a_movement_is_the_least_and_the_greatest_thrust():
    # moving out a springing calls for the least thrust, moving it in for the greatest; at rest any between
    model = semicircular_arch(15, 0.18)
    out, inward = (pushdown(model, "right", (d, 0.0), increment=1e-3).reaction[0] for d in (2e-3, -2e-3))
    assert abs(out[0]) < abs(inward[0])
    assert out[1] == pytest.approx(0.5 * model.weight, rel=1e-6)
    at_rest = reaction(rest(static_system(model, "rigid"), model.initial), model.support("right"))
    assert abs(out[0]) - 1e-6 <= abs(at_rest[0]) <= abs(inward[0]) + 1e-6
    # the reaction against the movement does the least work of all admissible ones
    sunk, raised = (pushdown(model, "right", (0.0, d), increment=1e-3).reaction[0] for d in (-2e-3, 2e-3))
    assert sunk[1] < at_rest[1] + 1e-6 < raised[1] + 2e-6


@pytest.mark.parametrize("template", TEMPLATES)
def test_a_template_can_be_pushed_over_and_limit_analysis_agrees_with_highs(template, tmp_path):
    new_project(tmp_path / "new", template, {})
    model = drawn(tmp_path / "new")
    alpha = limit_analysis(model, sliding="associative").alpha
    assert alpha == pytest.approx(by_highs(model, method="highs-ipm"), abs=1e-6) and 0.02 < alpha < 1.0


def within_cones(model, step):
    n, p, t = step.forces.T
    slight = 1e-6 * model.weight
    assert (n > -slight).all()
    assert (abs(t) <= step.contacts.friction * n + slight).all()
    assert (abs(p) <= np.maximum(step.places[:, H], 0.0) * n + slight * model.size).all()
    if step.system.rigid:
        overlapping = step.places[:, H] > 1e-6 * model.size
        assert end_gaps(step.places[overlapping]).min() > -1e-3 * model.size
