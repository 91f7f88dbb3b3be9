"""What the gauges show while supports move: one path predicts every length of its direction."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from assessment.analyses.static.paths import configuration, quality_row
from assessment.project.structure.gauges import Gauge, readings
from assessment.results.schema.model import QualityRow
from assessment.results.schema.part import Configuration
from mechanics import Assembly, CollapseError, ConvergenceError, NoEquilibriumError
from mechanics.messages import Message
from mechanics.procedures import Pushdown, SupportMovement, pushdown_together, whole_movement
from mechanics.steps import Sliding
from mechanics.types import Array

ROUNDING = 1e-8  # of a block's size: a movement that is none


@dataclass
class Followed:
    """A path of moving supports: at each `share` (k,) of the whole movement the readings `shown` (k, m), mm or mrad.

    `configuration` (b, 3): after the whole movement; None where the structure falls before, or cannot be followed.
    `stopped`: why it cannot be followed farther; None where the structure falls, or the whole movement was followed.
    """

    share: Array
    shown: Array
    configuration: Configuration | None = None
    stopped: Message | None = None
    quality: list[QualityRow] = field(default_factory=list)
    seconds: float = 0.0


def follow(
    model: Assembly,
    movements: Sequence[SupportMovement],
    increments: int,
    sliding: Sliding,
    gauges: Sequence[Gauge],
) -> Followed:
    """Move the supports from their places as drawn, in so many increments; a fall on the way is a result.

    What was followed before another error stops the path counts as well.
    """
    began = time.perf_counter()
    moved = tuple(each for each in movements if _moves(model, each))
    if not moved:
        start = model.initial
        shown = readings(model, gauges, start.positions)
        return Followed(np.zeros(1), shown[None, :], configuration=configuration(model, start))
    reached, path, stopped = False, None, None
    try:
        path = pushdown_together(model, moved, _largest(model, moved) / increments, sliding)
        reached = True
    except CollapseError as error:
        path = _so_far(error)
    except (NoEquilibriumError, ConvergenceError) as error:
        path, stopped = _so_far(error), error.message
    found = Followed(np.zeros(0), np.zeros((0, len(gauges))), stopped=stopped)
    if path is not None:
        states = [*path.states[:-1], path.final if reached else path.states[-1]]
        found.share = path.movement / _largest(model, moved)
        found.shown = np.array([readings(model, gauges, state.positions) for state in states])
        found.configuration = configuration(model, path.final) if reached else None
        found.quality.append(quality_row("", "identification", path))
    found.seconds = time.perf_counter() - began
    return found


def _so_far(error: NoEquilibriumError | ConvergenceError) -> Pushdown | None:
    """Return the path that was followed before an error; None where it carries none."""
    return error.path if isinstance(error.path, Pushdown) else None


def _moves(model: Assembly, each: SupportMovement) -> bool:
    """Whether a movement is told from rounding."""
    far = max(*map(abs, each.displacement), abs(each.rotation) * model.size)
    return far > ROUNDING * model.size


def _largest(model: Assembly, movements: Sequence[SupportMovement]) -> float:
    return max(whole_movement(model, each.support, each.displacement, each.rotation) for each in movements)
