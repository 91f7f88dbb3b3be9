"""Certificates, warnings and configurations of paths, of settlements as of lateral loads."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np

from assessment.results.schema.model import QualityRow
from assessment.results.schema.part import Part
from mechanics import Assembly, State, UnstableError
from mechanics.messages import Message, headed, message
from mechanics.procedures import PATH, Pushdown, Pushover
from mechanics.program import Certificate
from mechanics.steps import check_self_weight

if TYPE_CHECKING:
    from numpy.typing import NDArray

Found = TypeVar("Found", bound=Part)

AT_LIMIT = 1e-5  # of the friction limit: a joint whose T is closer to it slides
SLIDING_CARRIES = 1e-3  # of the weight of the model: the slide of a joint that carries less has no effect


@dataclass
class Quality:
    """The worst certificate of the programs solved in a stage."""

    state: str
    stage: str
    solves: int = 0
    worst: Certificate | None = None
    penetration: float = 0.0

    def add(self, path: Pushdown | Pushover) -> None:
        """Add the certificates of all steps of a path."""
        for certificate in path.certificates:
            self.worst = certificate if self.worst is None else self.worst.joined(certificate)
        self.solves += sum(step.solves for step in path.steps) + len(path.certificates) - len(path.steps)
        self.penetration = max([self.penetration, *(step.penetration for step in path.steps)])

    @property
    def row(self) -> QualityRow:
        """The row of the table of certificates."""
        worst = self.worst or Certificate(0.0, 0.0, 0.0, 0.0, 0.0)
        return QualityRow(
            state=self.state,
            stage=self.stage,
            solves=self.solves,
            worst_equilibrium_residual=worst.equilibrium,
            worst_penetration_m=max(worst.penetration, self.penetration),
            worst_complementarity=worst.complementarity,
            worst_cone_violation=worst.cone,
        )


@dataclass
class PathResult(Generic[Found]):
    """Result of one static analysis: what it `found`, as a part of the results; None if nothing.

    `reached`: the settled state, at rest; None where the structure collapses before. `activated`: where a rigid curve
    has its largest multiplier. `failures`: what could not be completed. `scatters`: whether the path amplifies the last
    digits of its input.
    """

    found: Found | None = None
    reached: State | None = None
    activated: State | None = None
    quality: list[QualityRow] = field(default_factory=list)
    warnings: list[Message] = field(default_factory=list)
    failures: list[Message] = field(default_factory=list)
    seconds: float = 0.0
    scatters: bool = False


def stand(model: Assembly) -> Message | None:
    """Return why the structure cannot stand under its own weight; None if it can."""
    try:
        check_self_weight(model)
    except UnstableError as error:
        return error.message
    return None


def turns_on_rounding(model: Assembly, path: Pushdown | Pushover) -> bool:
    """Whether a path amplifies the last digits of its input: a joint that carries slides, or a part jumps."""
    if len(path.crossed):
        return True
    least = SLIDING_CARRIES * model.weight
    for step in path.steps:
        carries = (step.forces[:, 0] > least) & ~step.contacts.ties
        N, T = step.forces[carries, 0], step.forces[carries, 2]
        if (abs(T) >= (1.0 - AT_LIMIT) * step.contacts.friction[carries] * N).any():
            return True
    return False


def crossings(title: str, crossed: NDArray[np.float64], increment: float) -> list[Message]:
    """Return a warning for each stretch (n, 2) m in which a part moves by itself; adjoining stretches are joined.

    A stretch shorter than 1/32 of the increment (m) is below the accuracy of the path and left out.
    """
    stretches: list[list[float]] = []
    for left, held in np.sort(crossed, axis=1):
        if held - left < 0.99 * PATH.shortest(increment):
            continue
        if stretches and left <= stretches[-1][1]:
            stretches[-1][1] = max(held, stretches[-1][1])
        else:
            stretches.append([left, held])
    return [
        headed(
            title,
            message(
                "between d = {start:.4g} and {end:.4g} m a part moves by itself, until others hold it again",
                start=left,
                end=held,
            ),
        )
        for left, held in stretches
    ]


def configuration(model: Assembly, state: State) -> list[list[float]]:
    """Return displacements (m) and rotations (rad) (b, 3) of the blocks from the drawing."""
    moved: NDArray[np.float64] = state.positions - model.initial.positions
    rows: list[list[float]] = moved.tolist()
    return rows
