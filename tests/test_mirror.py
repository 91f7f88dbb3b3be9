"""Structures that are their own mirror image: recognised exactly, and the image of a path is the path the other way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assessment.benchmark.structures import assembly, template
from assessment.parallel import Workers
from assessment.states import Request, analyse_states
from mechanics import Assembly, Block, Material, pushover
from mechanics.mirror import Mirror
from mechanics.static_step import assemble
from tests.structures import arch_on_piers, rectangle

CONTROL = {"+x": (0.6, 0.84), "-x": (-0.6, 0.84)}


@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
def test_the_image_of_a_path_is_the_path_the_other_way(behaviour):
    model = arch_on_piers()
    mirror = Mirror.of(model, behaviour)
    one = pushover(model, CONTROL["+x"], "+x", behaviour, 0.001, until=0.3)
    other = pushover(model, CONTROL["-x"], "-x", behaviour, 0.001, until=0.3)
    image = mirror.pushover(one)
    close = 0.01 * 0.001  # m: a hundredth of a step
    np.testing.assert_allclose(image.displacement, other.displacement, atol=close)
    np.testing.assert_allclose(image.multiplier, other.multiplier, atol=1e-3 * max(other.multiplier))
    for found, expected in zip(image.states, other.states, strict=True):
        np.testing.assert_allclose(found.positions, expected.positions, atol=close)
    np.testing.assert_allclose(image.mechanism, other.mechanism, atol=1e-2 * abs(other.mechanism).max())


@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
def test_every_step_of_the_image_is_an_equilibrium(behaviour):
    """Its rows are those of the configuration, its loads push the other way, and its forces bear them."""
    model = arch_on_piers()
    image = Mirror.of(model, behaviour).pushover(
        pushover(model, CONTROL["+x"], "+x", behaviour, 0.002, until=0.3)
    )
    lateral = model.lateral_load("-x")[model.movable].ravel()
    for step in image.steps[1:]:
        program, forces = step.program, step.forces
        there = assemble(model, behaviour, step.state, step.at, model.dead_load, program.step)
        np.testing.assert_allclose(program.normal, there.normal, atol=1e-12)
        np.testing.assert_allclose(program.tangent, there.tangent, atol=1e-12)
        np.testing.assert_allclose(program.gap[:, 0], there.gap[:, 0], atol=1e-12)
        np.testing.assert_allclose(program.lateral, lateral, atol=1e-12)
        unbalanced = program.resultant(forces) + program.load + step.alpha * lateral
        assert abs(unbalanced).max() < 1e-8 * model.weight
    assert len(image.steps) > 4


def test_control_points_have_to_be_each_others_image():
    mirror = Mirror.of(arch_on_piers(), "rigid")
    assert mirror.swaps(CONTROL["+x"], CONTROL["-x"])
    assert not mirror.swaps(CONTROL["+x"], CONTROL["+x"])
    assert not mirror.swaps(CONTROL["+x"], (-0.6, 0.8))


def test_messages_name_the_image():
    model = arch_on_piers()
    mirror = Mirror.of(model, "rigid")
    path = pushover(model, CONTROL["+x"], "+x", "rigid", 0.005, until=0.9)
    image = mirror.pushover(replace(path, end="+x: lost, at block 0 first"))
    assert image.end == f"-x: lost, at block {mirror.block[0]} first"


def _changed(change):
    """A block of 1 m in the middle of a base, and what it is changed into."""
    stone = Material(20.0, 0.6)
    base = Block(rectangle(-1.0, -0.1, 2.0, 0.0), 1.0, stone, support="base")
    return Assembly([base, change(Block(rectangle(0.0, 0.0, 1.0, 1.0), 1.0, stone))])


@pytest.mark.parametrize(
    "change",
    [
        lambda block: Block(rectangle(1e-6, 0.0, 1.0, 1.0), block.depth, block.material),
        lambda block: Block([(0.0, 0.0), (1.0, 0.0), (1.0, 0.9), (0.0, 1.0)], block.depth, block.material),
    ],
    ids=["a micron aside", "a sloping top"],
)
def test_what_is_not_quite_its_image_has_no_mirror(change):
    assert Mirror.of(_changed(lambda block: block), "rigid") is not None
    assert Mirror.of(_changed(change), "rigid") is None


@pytest.mark.parametrize("field", ["unit_weight", "friction", "normal_stiffness"])
def test_stones_have_to_be_alike_on_both_sides(field):
    model = arch_on_piers()
    stone = model.blocks[0].material
    other = replace(stone, **{field: 0.9 * getattr(stone, field)})
    assert isinstance(other, Material)
    blocks = [replace(model.blocks[0], material=other), *model.blocks[1:]]
    assert Mirror.of(model, "elastic") is not None
    assert Mirror.of(Assembly(blocks), "elastic") is None


@pytest.mark.parametrize(("controls", "computed"), [({"+x": "C2", "-x": "C1"}, 1), ("C1", 2)])
def test_a_run_pushes_one_way_where_the_other_is_the_image(controls, computed):
    project, model = template("buttressed-arch"), assembly("buttressed-arch")
    push = project.pushover.model_copy(update={"control": controls, "increment_m": 0.002})
    project = project.model_copy(update={"pushover": push})
    workers = Workers(jobs=1)
    (result,) = analyse_states([Request(project, model, None, "rigid")], workers)
    assert workers.computed == computed
    one, other = (result.pushover[direction] for direction in ("+x", "-x"))
    assert (one["control"], other["control"]) == ("C2", "C1")  # C1 alone takes no part in the push towards +x
    assert one["alpha_0"] == pytest.approx(other["alpha_0"], rel=1e-6)
    assert result.failures == []
