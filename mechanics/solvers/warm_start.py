"""Where the interior point method of the dynamics begins: the last solution, moved off the cone.

A start too near is held up by the rays that change sides, from bearing to open or back; one too far away has all the
way to go again. So it keeps off by as much as the last solution differed from its own start: gaps by the root mean
square of their changes, forces by that of theirs, the less the fewer rays changed sides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mechanics.block import Array

FORCES = 0.01  # least distance per weight
GAPS = 0.003, 0.01  # least and most per step


@dataclass(eq=False)
class WarmStart:
    """The last solution's forces and gaps (c, 2) along the rays; None where there is none.

    `newest`: its share in them, the rest being what it began from. `forces`, `gaps`: distance from the cone at which
    the next solution is sought, per weight and step. `kernels`: the loops of its solver.
    """

    kernels: Any
    newest: float = 1.0
    along: Array | None = None
    apart: Array | None = None
    forces: float = FORCES
    gaps: float = GAPS[1]

    def begin(self, count: int, weight: float, step: float) -> tuple[Array, Array]:
        """Forces and gaps (c, 2) to begin at, of so many contact points."""
        if self.along is None or self.apart is None:
            return np.full((count, 2), self.forces * weight), np.full((count, 2), self.gaps * step)
        return np.maximum(self.along, self.forces * weight), np.maximum(self.apart, self.gaps * step)

    def keep(self, s: Array, z: Array, weight: float, step: float) -> None:
        """Those of a solution (c, 2)."""
        if self.along is not None and self.apart is not None:
            sides, forces, gaps = self.kernels.changed(s, z, self.along, self.apart, weight, step)
            self.forces = max(FORCES, sides**0.5 * forces)
            self.gaps = min(max(GAPS[0], gaps), GAPS[1])
            if self.newest < 1.0:
                s, z = (old + self.newest * (new - old) for old, new in ((self.along, s), (self.apart, z)))
        self.along, self.apart = s, z

    def forget(self) -> None:
        """The last solution is no start for the next one."""
        self.along, self.apart, self.forces, self.gaps = None, None, FORCES, GAPS[1]
