"""Error of a peak from three or more levels of the time step, by the observed order, or its scatter.

v₀, v₁, v₂… at time steps h, h/2, h/4…, and at each how far a perturbed pair is apart
three levels are always there: two may agree by chance
the pair is farther apart than the levels    the quantity scatters: no time step makes it surer
differences shrink as those of a method      Richardson's extrapolation, of first order at most
else                                         the levels converge to nothing that is known: all they differ by
"""

from __future__ import annotations

from dataclasses import dataclass

from assessment.analyses.accuracy import FIRST_ORDER, LEVELS, observed_order
from assessment.results.schema.studies import ConvergenceRow
from mechanics.messages import Message, headed, message

PEAK = "peak_displacement_m"


@dataclass(frozen=True)
class Refinement:
    """The peak displacement at time steps h, h/2, h/4…: `values` (m), None for a collapse, and `scatter` of each level.

    `least`: a value that is none.
    """

    values: tuple[float | None, ...]
    scatter: tuple[float, ...]
    least: float

    @property
    def collapsed(self) -> bool:
        """Whether the last levels all collapse: there is neither a value nor an error."""
        return all(value is None for value in self.values[-LEVELS:])

    @property
    def _known(self) -> list[float]:
        """The values of the last levels, if there are enough."""
        known = [value for value in self.values[-LEVELS:] if value is not None]
        return known if len(known) == LEVELS else []

    @property
    def scatters(self) -> float | None:
        """Distance of a perturbed pair if it exceeds that of the levels; else None."""
        known, apart = self._known, max(self.scatter[-LEVELS:])
        return apart if known and apart > max(known) - min(known) else None

    @property
    def order(self) -> float | None:
        """The order observed in the last three levels; None if their differences do not shrink as with a method."""
        return observed_order(self.values)

    @property
    def error(self) -> float | None:
        """Estimated error of the finest level; None if not known."""
        if not self._known:
            return None
        _, b, c = self._known
        if self.order is None:
            return max(self._known) - min(self._known)
        return abs(c - b) / (min(2.0**self.order, FIRST_ORDER) - 1.0)

    @property
    def unsure(self) -> float | None:
        """Scatter or error, relative to the value of the finest level."""
        amount = self.error if self.scatters is None else self.scatters
        return None if amount is None else amount / max(abs(self.values[-1] or 0.0), self.least)

    def within(self, tolerance: float) -> bool:
        """Whether scatter or error is within the tolerance."""
        if len(self.values) < LEVELS:
            return False
        return self.collapsed or (self.unsure is not None and self.unsure <= tolerance)

    def finished(self, tolerance: float) -> bool:
        """Whether no finer level is needed."""
        return len(self.values) >= LEVELS and (self.within(tolerance) or self.scatters is not None)

    def row(self, state: str, record: str, tolerance: float) -> ConvergenceRow:
        """Return the row of the results: order, error or scatter, the same relative to the value, and the levels."""
        found = ConvergenceRow(
            state=state, record=record, met=self.within(tolerance), levels={PEAK: list(self.values)}
        )
        if self.scatters is not None:
            return found.replace(relative_scatter=self.unsure, peak_displacement_scatter_m=self.scatters)
        if self.collapsed:
            return found
        return found.replace(
            order=self.order, relative_error=self.unsure, peak_displacement_error_m=self.error
        )

    def missed(self, title: Message, tolerance: float) -> list[Message]:
        """Return a warning if the tolerance is not met."""
        return [] if self.within(tolerance) else [headed(title, self._missed(tolerance))]

    def _missed(self, tolerance: float) -> Message:
        if len(self.values) < LEVELS:
            return message("discretisation error not known")
        if self.unsure is None:
            return message("error of {key} not known: not every time step reaches it", key=PEAK)
        unsure, asked = 100.0 * self.unsure, 100.0 * tolerance
        if self.scatters is not None:
            return message(
                "{key} scatters by {error:.2g} % between records that differ by 1 %, more than between time steps, "
                "tolerance {tolerance:.2g} %; the range tells how sure it is",
                key=PEAK,
                error=unsure,
                tolerance=asked,
            )
        return message(
            "estimated error of {key} {error:.2g} % by time steps down to 1/{times} of those given, "
            "tolerance {tolerance:.2g} %; take a smaller {keys}",
            key=PEAK,
            error=unsure,
            times=2 ** (len(self.values) - 1),
            tolerance=asked,
            keys="time_step_s",
        )
