"""Every figure of a state belongs to its α0; displacements in the results are those along x, in either direction."""

import json

import numpy as np
import pytest

from assessment.analyses.capacity import activation_of
from assessment.analyses.lateral import PushSetting, push
from assessment.benchmark.measure import assembly, rectangle, template
from assessment.ntc.capacity_curve import participation
from assessment.project.schema import ControlTable
from assessment.report.figures.deformed import found_mechanism
from assessment.report.tables.structure import pushover_curves
from assessment.results.hand_check import weights
from assessment.results.joint_states import outlines, situations
from assessment.results.table import sense
from mechanics import Assembly, Block, Material, limit_analysis, pushdown, pushover
from mechanics.pictures import field, place
from mechanics.procedures.limit_analysis import friction_work, virtual_work_multiplier
from mechanics.steps.equilibrium import reaction
from tests.support.analysed import SETTLED, analysed
from tests.support.random_masonry import small_wall
from tests.support.structures import block_on_base
from tests.support.typed import typed
from tests.support.wording import in_italian

PUSHED = [(state, direction) for state in ("original", SETTLED) for direction in ("+x", "-x")]


@pytest.mark.parametrize("motion", [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)])
def test_a_motion_on_which_the_horizontal_load_does_no_work_has_no_multiplier(motion):
    """A mechanism where blocks fall by themselves: a division by zero that stops no run, and is no finite number."""
    model = block_on_base()
    assert not np.isfinite(
        virtual_work_multiplier(model, np.tile(motion, (len(model.initial.positions), 1)), "+x")
    )


@pytest.mark.parametrize("number", [47, 58, 323])
def test_virtual_work_with_that_of_friction_gives_the_multiplier_of_what_slides(number):
    """Without it the check misses by a third and more, and a buttressed arch that slides was refused a capacity."""
    limit = limit_analysis(small_wall(number))
    taken = friction_work(limit.contacts, limit.state, limit.mechanism, limit.forces)
    found = [virtual_work_multiplier(limit.model, limit.mechanism, "+x", work) for work in (taken, 0.0)]
    assert found[0] == pytest.approx(limit.alpha, rel=1e-6)
    assert found[1] < 0.9 * limit.alpha


@pytest.mark.parametrize(("state", "direction"), PUSHED)
def test_the_mechanism_is_drawn_where_it_is_activated(state, direction):
    results = analysed()
    at = found_mechanism(typed(results), state, direction).start.points
    [onset] = [s for s in situations(typed(results)) if (s.state, s.direction) == (state, direction)]
    np.testing.assert_allclose(at, outlines(typed(results)).moved(onset.configuration).points, atol=1e-5)


@pytest.mark.parametrize(("state", "direction"), PUSHED)
def test_e_and_gamma_star_follow_from_the_virtual_displacements_printed(state, direction):
    results = analysed()
    content = results["states"][state]
    mechanism = content["pushover"][direction]["rigid"]["mechanism"]
    delta = np.array(mechanism["displacements"])
    movable = np.array([block["support"] is None for block in results["geometry"]["blocks"]])
    seismic = np.where(movable, weights(typed(results))[1], 0.0)
    size = abs(delta[:, :2]).max(axis=1)
    expected = participation(seismic, delta[:, 0], sense(direction), movable & (size > 1e-6 * size.max()))
    for key in ("e_star", "gamma_star"):
        # of an ensemble the mechanism is that of a member, whose corners are moved in the seventh digit
        assert mechanism[key] == pytest.approx(getattr(expected, key), rel=1e-6)
        assert content["capacity"][direction][key] == pytest.approx(mechanism[key], rel=1e-6)


def test_where_a_block_slides_the_first_of_equal_multipliers_is_the_activation():
    model = block_on_base(0.6, 4.2, friction=0.1)
    curve = pushover(model, (0.6, 4.2), increment=0.1)
    assert np.ptp(curve.multiplier) < 1e-6
    assert (curve.peak, curve.formed) == (0, 0)


def test_a_wall_as_drawn_that_meets_another_is_told_what_activates_it():
    """A panel of 4.2 × 0.6 m turns at α = t/h = 1/7, and after the 20 mm to its neighbour both have to turn."""
    stone = Material(18.0, 0.7)
    base, wall, neighbour = (
        Block(rectangle(x0, z0, x1, z1), 1.0, stone, support=support)
        for x0, z0, x1, z1, support in (
            (-1.0, -0.3, 4.0, 0.0, "base"), (0.0, 0.0, 0.6, 4.2, None), (0.62, 0.0, 2.02, 4.2, None),
        )
    )  # fmt: skip
    model, control = Assembly([base, wall, neighbour]), ControlTable(name="top", point_m=(0.6, 4.2))
    setting = PushSetting("rigid", "associative", increment=0.005)
    [pushed] = push(model, "original", None, setting, ("+x",), (control,))
    curve = pushed.value.curves.rigid
    assert curve.alpha_onset == pytest.approx(1.0 / 7.0, rel=1e-6) and curve.alpha_0 > 1.5 / 7.0
    [warning] = [each for each in pushed.warnings if "met others" in each]
    assert "blocks move from α = 0.1429 on; by d = 0.0203 m they have met others" in warning
    assert "da α = 0,1429 in poi" in in_italian(warning)
    first = activation_of(model, curve.alpha_onset, curve.onset)
    assert (first.alpha, first.e_star) == pytest.approx((1.0 / 7.0, 1.0), rel=1e-6), "one block, e* = 1"
    assert curve.onset.moving_weight_kN == pytest.approx(18.0 * 0.6 * 4.2)
    assert curve.mechanism.moving_weight_kN > 2.0 * curve.onset.moving_weight_kN
    [alone] = push(Assembly([base, wall]), "original", None, setting, ("+x",), (control,))
    assert not any("meet others" in each for each in alone.warnings)
    assert alone.value.curves.rigid.onset is None


@pytest.mark.parametrize(("state", "direction"), PUSHED)
@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_curves_are_in_the_axes_of_the_model(state, direction, contacts):
    """Displacements of −x were those of a mirror image: the control point goes where the frames show it."""
    results = analysed()
    stage = results["states"][state]["pushover"][direction][contacts]
    d = np.array(stage["curve"]["displacement_m"])
    assert d[0] == 0.0 and "-0.0" not in json.dumps(stage["curve"]["displacement_m"][:1])
    [control] = results["geometry"]["controls"]
    owner, drawn = np.array([control["block"]]), np.array([control["point_m"]])
    centroids = outlines(typed(results)).centroids
    at = [place(drawn, owner, centroids, np.array(each))[0, 0] for each in stage["frames"]["configuration"]]
    np.testing.assert_allclose(d[stage["frames"]["index"]], np.array(at) - at[0], atol=2e-6)
    assert sense(direction) * d[-1] > 0.0
    listed = [
        row["displacement_m"]
        for row in pushover_curves(typed(results)).rows
        if (row["state"], row["direction"], row["contacts"]) == (state, direction, contacts)
    ]
    assert listed == d.tolist()


@pytest.mark.parametrize(("state", "direction"), PUSHED)
def test_virtual_displacements_go_where_the_loads_push(state, direction):
    """They were scaled to +1 m at the control point in −x too: the mechanism ran backwards."""
    results = analysed()
    mechanism = results["states"][state]["pushover"][direction]["rigid"]["mechanism"]
    delta = np.array(mechanism["displacements"])
    [control] = results["geometry"]["controls"]
    at = found_mechanism(typed(results), state, direction)
    start = outlines(typed(results))
    owner = np.array([control["block"]])
    point = place(np.array([control["point_m"]]), owner, start.centroids, at.configuration)
    moved = field(point, owner, at.start.centroids, delta)[0, 0]
    assert moved == pytest.approx(sense(direction), rel=1e-6)
    assert mechanism["control_displacement_x"] == pytest.approx(moved, rel=1e-6)
    assert sense(direction) * float(weights(typed(results))[1] @ delta[:, 0]) > 0.0


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_forces_at_every_point_of_a_settled_curve_balance_its_loads(direction):
    """Where the arch came to rest under gravity and is pushed again, the forces were those of the rest, without α."""
    project, model = template("buttressed-arch"), assembly("buttressed-arch", 1)
    (table,) = project.settlements
    state = pushdown(model, table.support, table.displacement_m, increment=0.001).final
    control = project.pushover_control(direction).point_m
    curve = pushover(model, control, direction, "rigid", 0.0005, state, until=0.7)
    for step, alpha in zip(curve.steps, curve.multiplier[1:], strict=True):
        carried = reaction(step, np.flatnonzero(~model.movable))[0]
        assert abs(carried) == pytest.approx(alpha * model.weight, abs=1e-4 * model.weight)
