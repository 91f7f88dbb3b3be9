"""Results as far as a run has come: each stage adds its parts."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from assessment.results.quality import quality_of
from assessment.results.schema import Results, State
from assessment.results.schema.model import QualityRow
from assessment.results.schema.studies import ConvergenceRow
from assessment.results.summary import summary_of
from mechanics.messages import Message

if TYPE_CHECKING:
    from assessment.analyses.dynamic.time_history import DynamicResult
    from assessment.studies.campaign.incremental import Found


@dataclass
class Draft:
    """The results of a run while its stages add to them; `finished` returns them.

    `results`: what needs no analysis, then the parts that were found; `warnings`: what the reader has to know;
    `quality`: certificates of the analyses; `seconds`: their computing time by stage; `errors` and `search_errors`:
    estimated errors of pushovers and histories, and of the PGA at collapse.
    """

    results: Results
    warnings: list[Message] = field(default_factory=list)
    quality: list[QualityRow] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)
    errors: list[ConvergenceRow] = field(default_factory=list)
    search_errors: list[ConvergenceRow] = field(default_factory=list)

    @property
    def states(self) -> dict[str, State]:
        """Every state of the project by name, as far as it was analysed."""
        return self.results.states

    def put(self, **parts: Any) -> None:
        """Set parts of the results by their keys. Raises pydantic's ValidationError for one that is not described."""
        self.results = self.results.replace(**parts)

    def put_state(self, name: str, **parts: Any) -> None:
        """Set parts of a state by their keys. Raises as `put`."""
        self.put(states=self.states | {name: self.states[name].replace(**parts)})

    def took(self, stage: str, seconds: float) -> None:
        """Add the computing time (s) of a stage."""
        self.seconds[stage] = self.seconds.get(stage, 0.0) + seconds

    def add(self, stage: str, found: DynamicResult | Found) -> bool:
        """Add messages, certificates and time of an analysis of a stage; return whether it was completed."""
        self.warnings += [*found.warnings, *found.failures]
        self.quality += found.quality
        self.took(stage, found.seconds)
        return not found.failures

    def finished(self) -> Results:
        """Return the results with warnings, certificates, estimated errors and computing times."""
        convergence = self.results.convergence.replace(rows=self.errors)
        if self.search_errors:
            convergence = convergence.replace(incremental=self.search_errors)
        return self.results.replace(
            summary=summary_of(self.results),
            convergence=convergence,
            quality=quality_of(self.quality, self.warnings),
            timing_s=self.seconds,
        )
