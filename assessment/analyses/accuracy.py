"""How accurate results are asked to be, and what differences between increments or time steps can tell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from assessment.project.project import Project

SHOWN = 1.25  # ratio of successive differences below which they hardly shrink
# the ratio of a method of first order: differences that shrink faster are not trusted to go on so
FIRST_ORDER = 2.0
# of α, of a_g in g and of the model's size: values below it are none, differences are the solver's
NOISE = 1e-6


@dataclass(frozen=True)
class Accuracy:
    """A relative `tolerance` of the estimated error (None: none is estimated) and the most `halvings` to get there."""

    tolerance: float | None
    halvings: int


PRESETS = {"fast": Accuracy(None, 0), "standard": Accuracy(0.05, 2), "fine": Accuracy(0.01, 4)}
MOST_HALVINGS = 4  # for a tolerance given as a number


def accuracy_of(project: Project) -> Accuracy:
    """Return what the project's key `accuracy` stands for."""
    asked = project.accuracy
    return PRESETS[asked] if isinstance(asked, str) else Accuracy(asked, MOST_HALVINGS)
