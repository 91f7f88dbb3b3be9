"""The accuracy that a project asks for, and bounds for errors estimated from increments or time steps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from assessment.project.project import Project

SHOWN = 1.25  # ratio of successive differences below which they hardly shrink
# ratio of a first-order method: a higher observed order is not relied on
FIRST_ORDER = 2.0
# of α, of a_g in g and of the model's size: smaller values and differences are errors of the solver
NOISE = 1e-6
LEVELS = 3  # at least: two may agree by chance
FASTEST = 6.0  # largest ratio of differences that counts as convergence: second order has 4


@dataclass(frozen=True)
class Accuracy:
    """A relative `tolerance` of the estimated error (None: no error is estimated) and the most `halvings` allowed."""

    tolerance: float | None
    halvings: int


PRESETS = {"fast": Accuracy(None, 0), "standard": Accuracy(0.05, 2), "fine": Accuracy(0.01, 4)}
MOST_HALVINGS = 4  # for a tolerance given as a number


def accuracy_of(project: Project) -> Accuracy:
    """Return the preset of the project's key `accuracy`."""
    asked = project.accuracy
    return PRESETS[asked] if isinstance(asked, str) else Accuracy(asked, MOST_HALVINGS)


def observed_order(values: Sequence[float | None]) -> float | None:
    """Return the order that the last three of the values at steps h, h/2, h/4… show.

    None: fewer are known, or their differences do not shrink as with a method.
    """
    if len(values) < LEVELS:
        return None
    a, b, c = values[-LEVELS:]
    if a is None or b is None or c is None or c == b:
        return None
    ratio = abs((b - a) / (c - b))
    return math.log2(ratio) if SHOWN <= ratio <= FASTEST else None
