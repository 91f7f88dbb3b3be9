"""A block that a tilt of its foot has left leaning on a wall."""

from mechanics import Assembly, Block, Following, Material, State
from tests.support.structures import rectangle

B, H, GAP = 0.30, 1.20, 0.36


def leaning(friction: float, wall: float, before: float) -> tuple[Assembly, State]:
    """The block whose foot ends so far (m) before its corner, and its state after its foot has tilted and gone back.

    `friction`: of the block and its foot; `wall`: of the wall.
    """
    stone, smooth = Material(20.0, friction), Material(20.0, wall)
    model = Assembly(
        [
            Block(rectangle(-0.5, -0.3, B - before, 0.0), 1.0, stone, support="foot"),
            Block(rectangle(B + GAP, -0.3, B + GAP + 0.4, 2.0), 1.0, smooth, support="wall"),
            Block(rectangle(0.0, 0.0, B, H), 1.0, stone),
        ]
    )
    follow = Following(model, support="foot")
    follow.to((0.0, 0.0), rotation=-0.26)
    return model, follow.to((0.0, 0.0), rotation=0.0)
