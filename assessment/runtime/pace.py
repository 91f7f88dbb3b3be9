"""How long a stage still takes, at the pace so far: the one estimate of terminal, journal and status."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass
class Pace:
    """Work `done` until the time `latest`, of all the `work` of a stage that began at `began`; times in s of one clock.

    The unit of work is that of the stage: analyses, or samples of records; analyses at work count with their share.
    """

    work: float
    began: float
    done: float = 0.0
    latest: float = 0.0

    def reached(self, done: float, now: float) -> None:
        """Record the work done until `now`."""
        self.done, self.latest = done, now

    @property
    def ends(self) -> float | None:
        """When the stage ends; None where nothing is done yet."""
        if self.done <= 0.0:
            return None
        ends = self.latest + (self.latest - self.began) / self.done * max(self.work - self.done, 0.0)
        return ends if math.isfinite(ends) else None
