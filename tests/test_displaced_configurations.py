"""The multiplier of a rigid curve is that of limit analysis in each displaced configuration."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from assessment.benchmark.structures import assembly, running_bond, template
from mechanics import limit, pushdown, pushover
from mechanics.procedures.mechanism import virtual_work_multiplier
from mechanics.procedures.pushover import Pushover
from tests.structures import arch_on_piers


@pytest.fixture(scope="module")
def arch_that_slides() -> tuple[Pushover, np.ndarray]:
    """The triumphal arch, some of whose joints slide: the curve, and the multipliers of the steps themselves."""
    model, on_the_way = assembly("triumphal-arch", 1.0), []

    def watched(model, direction, step):
        on_the_way.append(step.alpha)
        return limit.limit_of(model, direction, step)

    control = template("triumphal-arch").pushover_control("+x").point_m
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys.modules["mechanics.pushover"], "limit_of", watched)
        return pushover(model, control, "+x", "rigid", 0.03, until=0.6), np.array(on_the_way)


def test_it_is_no_less_than_that_of_the_step(arch_that_slides):
    """Static theorem: the step's forces are admissible in the configuration; they act in a geometry close to it."""
    curve, on_the_way = arch_that_slides
    assert (curve.multiplier[1:] - on_the_way).min() > -1e-3 * curve.multiplier.max()


def test_it_is_not_drawn_down_by_what_the_step_lets_down(arch_that_slides):
    """A step that lets down what dilatant sliding lifted has a multiplier several per cent below the curve's."""
    curve, on_the_way = arch_that_slides
    assert (1.0 - on_the_way / curve.multiplier[1:]).max() > 0.05
    assert _roughness(curve.multiplier[1:]) < 0.7 * _roughness(on_the_way)


def test_directions_agree_in_an_arch_that_is_its_own_mirror_image(arch_that_slides):
    curve, _ = arch_that_slides
    model, control = (
        assembly("triumphal-arch", 1.0),
        template("triumphal-arch").pushover_control("-x").point_m,
    )
    mirrored = pushover(model, control, "-x", "rigid", 0.03, until=0.6)
    at = np.linspace(0.0, 0.95 * min(max(curve.displacement), max(mirrored.displacement)), 20)
    found, expected = (np.interp(at, path.displacement, path.multiplier) for path in (mirrored, curve))
    assert found == pytest.approx(expected, abs=0.01 * curve.multiplier.max())


def test_the_mechanism_of_a_settled_state_gives_the_multiplier_by_virtual_work():
    """Also where mechanisms alternate as it forms: it is that of the configuration in which the step's forces act."""
    project, model = template("triumphal-arch"), assembly("triumphal-arch", 1.0)
    (table,) = project.settlements
    settled = pushdown(model, table.support, table.displacement_m, 0.0, 0.01).final
    curve = pushover(model, project.pushover_control("-x").point_m, "-x", "rigid", 0.02, settled)
    assert curve.formed > 0
    expected = curve.multiplier[curve.formed]
    assert virtual_work_multiplier(model, curve.mechanism, "-x") == pytest.approx(expected, rel=1e-6)


def test_the_forces_of_a_point_are_those_of_its_multiplier():
    """Equilibrium of every block in the configuration, with |t| ≤ μn; nothing pulls."""
    model = arch_on_piers()
    curve = pushover(model, (0.0, 1.4), "+x", "rigid", 0.001)
    for step, alpha in zip(curve.steps, curve.multiplier[1:-1], strict=False):
        load = step.program.load + alpha * step.program.lateral
        unbalanced = step.program.resultant(step.forces) + load
        assert abs(unbalanced).max() < 1e-8 * model.weight
        n, t = step.forces.T
        assert min(n.min(), (step.program.friction * n - abs(t)).min()) > -1e-8 * model.weight
    assert len(curve.steps) > 8


def test_a_wall_whose_mechanisms_alternate_has_one_curve_at_every_increment():
    model = running_bond()
    control = model.blocks[-1].centroid
    curves = [
        pushover(model, control, "+x", "rigid", increment, until=0.8) for increment in (0.004, 0.002, 0.001)
    ]
    found = [float(np.interp(0.1, curve.displacement, curve.multiplier)) for curve in curves]
    assert max(found) == pytest.approx(min(found), rel=0.01)


def _roughness(curve: np.ndarray) -> float:
    return float(abs(np.diff(curve, 2)).sum())
