"""Where the interior point method of the dynamics begins: the last solution, moved off the cone.

A start too near is held up by the rays that change sides, from bearing to open or back; one too far away has all the
way to go again. So it keeps off by as much as the last solution differed from the one that it began from: gaps by the
root mean square of their changes, forces by that of theirs, the less the fewer rays changed sides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechanics.block import Array
from mechanics.solvers.compiled import changed

FORCES = 0.01  # least distance per weight
GAPS = 0.003, 0.01  # least and most per step


@dataclass(eq=False)
class WarmStart:
    """The start of the next solution.

    `last`: forces (c, 2) kN and gaps (c, 2) m along the rays of the last solution
    that it has found; `newest`: its share in them, the rest being what it began from. `forces`, `gaps`: distance from
    the cone at which the next one is sought, per weight and step.
    """

    newest: float = 1.0
    last: tuple[Array, Array] | None = None
    forces: float = FORCES
    gaps: float = GAPS[1]

    def begin(self, count: int, weight: float, step: float) -> tuple[Array, Array]:
        """Forces kN and gaps m (c, 2) to begin at, of so many contact points."""
        s, z = self.last or (np.zeros((count, 2)), np.zeros((count, 2)))
        return np.maximum(s, self.forces * weight), np.maximum(z, self.gaps * step)

    def keep(self, s: Array, z: Array, weight: float, step: float) -> None:
        """Forces kN and gaps m (c, 2) of a solution, from which the next one begins."""
        if self.last is not None:
            sides, forces, gaps = changed(s, z, *self.last, weight, step)
            self.forces = max(FORCES, sides**0.5 * forces)
            self.gaps = min(max(GAPS[0], gaps), GAPS[1])
            if self.newest < 1.0:
                s, z = (old + self.newest * (new - old) for old, new in zip(self.last, (s, z), strict=True))
        self.last = s, z

    def forget(self) -> None:
        """The last solution is no start for the next one."""
        self.last, self.forces, self.gaps = None, FORCES, GAPS[1]
