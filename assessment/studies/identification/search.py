"""The search for the movements that explain the measurements: directions first, then the best of them refined."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from assessment.project.structure.gauges import Gauge
from assessment.runtime.tasks import Workers, large
from assessment.studies.identification.fit import Fit, Predict, best_length, kinks, refined
from assessment.studies.identification.path import Followed, follow
from assessment.studies.identification.unknowns import Unknowns
from mechanics.messages import Message
from mechanics.types import Array, Mask

if TYPE_CHECKING:
    from assessment.studies.variants import Study
    from mechanics import Assembly
    from mechanics.steps import Sliding

FARTHEST = 10.0  # of the largest measured displacement: the length of the paths of the search
COARSE = 50  # increments of a path of the search
FINE = 20  # increments of a movement that is refined
STARTS = 3  # directions that are refined


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
