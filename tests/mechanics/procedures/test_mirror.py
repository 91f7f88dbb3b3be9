"""Structures that are their own mirror image: recognised exactly, and the image of a path is the path the other way."""

from dataclasses import replace

import numpy as np
import pytest

from mechanics import Assembly, Block, Material, limit_analysis, pushover
from mechanics.messages import message
from mechanics.model.block import Tie
from mechanics.procedures.mirror import Mirror
from mechanics.program import certify
from mechanics.steps.static_step import StepProblem
from tests.support.structures import arch_on_piers, on_base, rectangle, tied_arch

# of the peak: far beyond that of elastic joints blocks snap from place to place, and rounding decides where to
UNTIL = {"rigid": 0.3, "elastic": 0.95}
CONTROL = {"+x": (0.6, 0.84), "-x": (-0.6, 0.84)}


@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
def test_the_image_of_a_path_is_the_path_the_other_way(behaviour):
    """About an axis at 1.25 m."""
    aside = np.array([1.25, 0.0])
    model = Assembly([replace(block, vertices=block.polygon + aside) for block in arch_on_piers().blocks])
    mirror = Mirror.of(model, behaviour)
    one, other = (
        pushover(model, tuple(CONTROL[way] + aside), way, behaviour, 0.001, until=UNTIL[behaviour])
        for way in ("+x", "-x")
    )
    image = mirror.pushover(one)
    assert (one.direction, image.direction, other.direction) == ("+x", "-x", "-x")
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
        pushover(model, CONTROL["+x"], "+x", behaviour, 0.002, until=UNTIL[behaviour])
    )
    for step in image.steps[1:]:
        problem = StepProblem(step.system, step.state, model.dead_load, 1e-3, model.lateral_load("-x"))
        program, index = problem.pose(step.state.positions, step.forces)
        found = certify(program, step.forces[index], step.alpha, np.zeros(len(program.load)))
        assert max(found.equilibrium, found.cone) < 1e-6
        np.testing.assert_allclose(step.places, model.contacts.places(step.state.positions), atol=1e-12)
    assert len(image.steps) > 4


def test_a_message_names_the_image_of_its_block_and_the_other_direction():
    falls = message("{direction}: {reason}", direction="+x", reason=message("block {block} falls", block=0))
    assert Mirror.of(arch_on_piers(voussoirs=23), "rigid")._mirrored(falls) == "-x: block 22 falls"


def test_ties_are_mirrored_and_one_that_has_no_image_breaks_the_symmetry():
    model = tied_arch(0.005)
    assert Mirror.of(model, "rigid") is None
    chain = model.tied(model.ties[:1])
    mirror = Mirror.of(chain, "rigid")
    one, other = (pushover(chain, (x, 0.84), way, increment=0.006) for x, way in ((0.6, "+x"), (-0.6, "-x")))
    image = mirror.pushover(one)
    np.testing.assert_allclose(image.multiplier, other.multiplier, atol=1e-6)
    found, expected = (path.states[-2].lengthened for path in (image, other))
    assert expected == pytest.approx(found, abs=1e-6)
    assert expected[0] > 0.005


def test_a_diagonal_has_the_middle_the_length_and_the_blocks_of_its_image_and_is_not_it():
    """Both directions had the multiplier of +x, 0.35, where −x has 0.25 (limit analysis)."""
    stone = Material(20.0, 0.6)
    shapes = [
        ((-2.3, -0.4, -1.1, 0.0), "left"), ((1.1, -0.4, 2.3, 0.0), "right"), ((-2.0, 0.0, -1.4, 2.4), None),
        ((1.4, 0.0, 2.0, 2.4), None), ((-2.0, 2.4, 2.0, 2.9), None),
    ]  # fmt: skip
    portal = Assembly(
        [Block(rectangle(*corners), 0.8, stone, support=support) for corners, support in shapes]
    )
    tied = portal.tied([Tie("diagonal", (-1.7, 0.6), (1.7, 2.2), 20.0)])
    assert Mirror.of(portal, "rigid") is not None and Mirror.of(tied, "rigid") is None
    assert limit_analysis(tied, "+x").alpha > 1.3 * limit_analysis(tied, "-x").alpha
    level = portal.tied([Tie("chain", (-1.7, 2.2), (1.7, 2.2), 20.0)])
    assert Mirror.of(level, "rigid") is not None
    for most, alike in ((0.01, True), (0.02, False)):  # one of two images breaks before the other
        one, two = (
            Tie(name, (x, -0.2), (x, 2.2), 20.0, ultimate_elongation=share)
            for name, x, share in (("left", -1.7, 0.01), ("right", 1.7, most))
        )
        assert (Mirror.of(portal.tied([one, two]), "rigid") is not None) is alike


def test_outlines_and_masses_have_to_be_each_others_image():
    """A parallelogram has the centroid, the area and the joints of its image, and leans the other way."""
    stone, base = Material(20.0, 0.6), (-2.0, -0.4, 2.0)
    leaning = [[-0.6, 0.0], [0.4, 0.0], [0.6, 0.0], [0.6, 1.0], [-0.4, 1.2], [-0.6, 1.0]]
    upright = [[-0.6, 0.0], [0.6, 0.0], [0.6, 1.0], [0.4, 1.2], [-0.4, 1.2], [-0.6, 1.0]]
    for outline, symmetrical in ((leaning, False), (upright, True)):
        to_the_middle = np.array([on_base(stone, base, outline).blocks[1].centroid[0], 0.0])
        model = on_base(stone, base, np.array(outline) - to_the_middle)
        assert (Mirror.of(model, "rigid") is not None) is symmetrical


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


@pytest.mark.parametrize("field", ["unit_weight", "friction"])
def test_stones_have_to_be_alike_on_both_sides(field):
    model = arch_on_piers()
    stone = model.blocks[0].material
    other = replace(stone, **{field: 0.9 * getattr(stone, field)})
    assert isinstance(other, Material)
    blocks = [replace(model.blocks[0], material=other), *model.blocks[1:]]
    assert Mirror.of(model, "elastic") is not None
    assert Mirror.of(Assembly(blocks), "elastic") is None


def test_a_path_on_which_blocks_met_has_no_image():
    """Faces that met are none of the drawing's joints."""
    model = arch_on_piers()
    path = pushover(model, CONTROL["+x"], "+x", "rigid", 0.005, until=0.9)
    touched = replace(path.steps[-1], forces=np.vstack([path.steps[-1].forces, [[1.0, 0.0, 0.0]]]))
    assert Mirror.of(model, "rigid").pushover(replace(path, steps=(*path.steps[:-1], touched))) is None
