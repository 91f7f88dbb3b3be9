"""The control point that the program chooses: the corner that goes farthest along the push."""

import pytest

from assessment.benchmark.structures import assembly, rectangle, template
from mechanics import Assembly, Block, Material, pushdown, pushover
from mechanics.procedures import Mirror, farthest_corner
from tests.support.structures import running_bond

STONE = Material(18.0, 0.7, 5e5)


def wall_on_base() -> Assembly:
    base = Block(rectangle(-1.0, -0.3, 1.0, 0.0), 1.0, STONE, support="base")
    return Assembly([base, Block(rectangle(-0.3, 0.0, 0.3, 4.2), 1.0, STONE)])


@pytest.mark.parametrize(("direction", "foremost"), [("+x", 0.3), ("-x", -0.3)])
@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_without_a_control_point_the_top_of_a_wall_is_followed(direction, foremost, contacts):
    model = wall_on_base()
    chosen = pushover(model, direction=direction, contacts=contacts, increment=0.02)
    assert chosen.control == pytest.approx([foremost, 4.2]) and chosen.block == 1
    given = pushover(model, chosen.control, direction, contacts, 0.02)
    assert chosen.displacement == pytest.approx(given.displacement, abs=1e-12)
    assert chosen.multiplier == pytest.approx(given.multiplier, abs=1e-12)


def test_of_a_wall_whose_top_courses_turn_it_is_a_corner_of_theirs():
    model = running_bond(3, 6)
    path = pushover(model, increment=0.02, until=0.9)
    moved = path.mechanism[path.block]
    assert abs(moved[:2]).max() > 0.5 * abs(path.mechanism[:, :2]).max()
    assert abs(path.mechanism[model.movable, :2]).max(axis=1).min() < 1e-6, "what lies below does not move"


def test_a_corner_that_two_blocks_share_is_not_chosen():
    """Which of the two a drawn point is of would be luck."""
    blocks = [Block(rectangle(-1.0, -0.3, 1.0, 0.0), 1.0, STONE, support="base")]
    blocks += [Block(rectangle(-0.3, z, 0.3, z + 0.5), 1.0, STONE) for z in (0.0, 0.5, 1.0)]
    model = Assembly(blocks)
    begun = model.initial.positions
    moved = begun.copy()
    moved[2, 0] += 0.1  # its lower corners are of the block below, its upper ones of that above
    point, block = farthest_corner(model, begun, moved, "+x")
    assert block == 2 == model.block_at(point)


def test_the_image_of_a_push_has_the_image_of_its_control_point():
    model = wall_on_base()
    path = pushover(model, increment=0.1)
    image = Mirror.of(model, "rigid").pushover(path)
    other = pushover(model, direction="-x", increment=0.1)
    assert image.control == pytest.approx(other.control) and image.block == other.block


def test_where_the_first_mechanism_is_local_the_curve_is_of_what_goes_farthest():
    """From a settled state the first motion may close a hinge; the point chosen moves with the curve all the same."""
    project, model = template("buttressed-arch"), assembly("buttressed-arch", 1)
    (table,) = project.settlements
    state = pushdown(model, table.support, table.displacement_m, increment=0.004).final
    for direction in ("+x", "-x"):
        path = pushover(model, direction=direction, increment=0.002, state=state)
        assert path.displacement.max() > 0.01 and path.multiplier.max() > 0.1
