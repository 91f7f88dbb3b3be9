"""The search for the movements that explain the measurements: directions first, then the best of them refined."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from assessment.analyses.static.paths import configuration, quality_row
from assessment.project.structure.places import Gauge, readings
from assessment.results.schema.model import QualityRow
from assessment.results.schema.part import Configuration
from assessment.runtime.tasks import Workers, large
from assessment.studies.identification.fit import Fit, Predict, best_length, kinks, refined
from assessment.studies.identification.unknowns import Unknowns
from mechanics import Assembly, CollapseError, ConvergenceError, NoEquilibriumError
from mechanics.messages import Message
from mechanics.procedures import Pushdown, SupportMovement, pushdown_together, whole_movement
from mechanics.steps import Sliding
from mechanics.types import Array, Mask

if TYPE_CHECKING:
    from assessment.studies.variants import Study

ROUNDING = 1e-8  # of a block's size: a movement that is none
FARTHEST = 10.0  # of the largest measured displacement: the length of the paths of the search
COARSE = 50  # increments of a path of the search
FINE = 20  # increments of a movement that is refined
STARTS = 3  # directions that are refined


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
    size = model.size
    moved = tuple(
        each
        for each in movements
        if max(*map(abs, each.displacement), abs(each.rotation) * size) > ROUNDING * size
    )
    if not moved:
        start = model.initial
        shown = readings(model, gauges, start.positions)
        return Followed(np.zeros(1), shown[None, :], configuration=configuration(model, start))
    whole = max(whole_movement(model, each.support, each.displacement, each.rotation) for each in moved)
    reached, path, stopped = False, None, None
    try:
        path = pushdown_together(model, moved, whole / increments, sliding)
        reached = True
    except (NoEquilibriumError, ConvergenceError) as error:
        path = error.path if isinstance(error.path, Pushdown) else None
        stopped = None if isinstance(error, CollapseError) else error.message
    found = Followed(np.zeros(0), np.zeros((0, len(gauges))), stopped=stopped)
    if path is not None:
        states = [*path.states[:-1], path.final if reached else path.states[-1]]
        found.share = path.movement / whole
        found.shown = np.array([readings(model, gauges, state.positions) for state in states])
        found.configuration = configuration(model, path.final) if reached else None
        found.quality.append(quality_row("", "identification", path))
    found.seconds = time.perf_counter() - began
    return found


@dataclass(frozen=True, eq=False)
class Measured:
    """What was measured: `value` and `sigma` (m,), mm or mrad, at the gauges; `largest` (m): a displacement."""

    gauges: tuple[Gauge, ...]
    value: Array
    sigma: Array
    largest: float

    def residual(self, shown: Array) -> Array:
        """Return the residuals over σ of readings (…, m)."""
        return (shown - self.value) / self.sigma


@dataclass(frozen=True, eq=False)
class Search:
    """How movements are followed: model, law of sliding, gauges and measured values, processes; messages to `study`.

    `stopped`: why paths of a hypothesis could not be followed to their end, other than by a collapse.
    """

    model: Assembly
    sliding: Sliding
    measured: Measured
    workers: Workers
    study: Study
    stopped: dict[Unknowns, list[Message]] = field(default_factory=lambda: defaultdict(list))

    def best(self, unknowns: Unknowns) -> Fit | None:
        """Return the best fit of a hypothesis; None where no movement could be followed."""
        directions = unknowns.directions()
        length = FARTHEST * self.measured.largest
        paths = self._followed(unknowns, [length * each for each in directions], COARSE, "search")
        starts: list[tuple[float, Array]] = []
        for direction, path in zip(directions, paths, strict=True):
            if len(path.share):
                share, square = best_length(path.share, self.measured.residual(path.shown))
                starts.append((square, share * length * direction))
        starts.sort(key=lambda each: each[0])
        fits = [fit for _, start in starts[:STARTS] if (fit := self._refined(unknowns, start)) is not None]
        return min(fits, key=lambda fit: fit.chi_squared, default=None)

    def at(self, unknowns: Unknowns, u: Array) -> Followed:
        """Return the path to values u (n,), m, of the unknowns."""
        [found] = self._followed(unknowns, [u], FINE, "best movement")
        return found

    def kinks(self, unknowns: Unknowns, fit: Fit, error: Array) -> Mask:
        """Return whether the prediction has a kink within a standard error (n,), m, below and above: (n, 2)."""
        return kinks(unknowns, fit, error, self._predict(unknowns))

    def _refined(self, unknowns: Unknowns, start: Array) -> Fit | None:
        predict = self._predict(unknowns)
        [residual] = predict([start])
        return None if residual is None else refined(unknowns, start, residual, predict)

    def _predict(self, unknowns: Unknowns) -> Predict:
        def predict(values: Sequence[Array]) -> list[Array | None]:
            paths = self._followed(unknowns, values, FINE, "fit")
            return [
                None if path.configuration is None else self.measured.residual(path.shown[-1])
                for path in paths
            ]

        return predict

    def _followed(
        self, unknowns: Unknowns, values: Sequence[Array], increments: int, what: str
    ) -> list[Followed]:
        tasks = [
            (self.model, unknowns.movements(u), increments, self.sliding, self.measured.gauges)
            for u in values
        ]
        titles = [f"{unknowns.title}, path {number}" for number in range(1, len(tasks) + 1)]
        found = self.workers.each(
            f"identification: {what}", follow, tasks, titles, large(*[self.model] * len(tasks))
        )
        for path in found:
            self.study.quality += path.quality
            self.study.seconds += path.seconds
            if path.stopped is not None:
                self.stopped[unknowns].append(path.stopped)
        return found
