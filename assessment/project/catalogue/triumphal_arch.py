"""Parametric geometry of the triumphal arch between two nave walls (paper, §7): polygons (n, 2) in m, by layer."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from shapely.geometry import Polygon, box
from shapely.ops import unary_union

from assessment.project.catalogue.geometry import (
    THINNEST,
    Array,
    Layout,
    Ring,
    base_below,
    fitted,
    mirrored,
    rectangle,
    running_bond,
    tidied,
)

MOST_COURSES = 100  # of a wall, whose blocks are cut one by one


@dataclass(frozen=True)
class TriumphalArch:
    """Triumphal arch between two nave walls seen in section, roof beams on top; lengths in m.

    The ring stands on a ledge: above the springing the nave walls are set back by the width of its foot.
    Spandrels are running bond between the walls, cut to the ring's extrados; courses run through. Raises
    ValueError where the ring does not fit below the top or the beams do not fit side by side.
    """

    span_m: float
    rise_m: float
    thickness_m: float
    voussoirs: int
    springing_m: float
    height_m: float
    wall_thickness_m: float
    course_height_m: float
    wall_blocks: int
    spandrel_blocks: int
    beams: int
    beam_side_m: float

    def __post_init__(self) -> None:
        crown = self.springing_m + self.rise_m + self.thickness_m
        if crown + THINNEST > self.height_m:
            raise ValueError(
                f"height_m: must be above the ring's crown at {crown:.3g} m, is {self.height_m:g}"
            )

    @cached_property
    def ring(self) -> Ring:
        """The ring of voussoirs, on its springing."""
        return Ring(self.span_m, self.rise_m, self.thickness_m, self.voussoirs, self.springing_m)

    @cached_property
    def foot(self) -> Array:
        """The right nave wall (5, 2), m, up to the ring's foot, its top cut to the skewback."""
        return self.ring.springer(self.wall_thickness_m, 0.0)

    @property
    def inner(self) -> float:
        """Distance of the nave walls' inner faces from the axis, below the springing."""
        return 0.5 * self.span_m

    @property
    def outer(self) -> float:
        """Distance of the nave walls' outer faces from the axis."""
        return 0.5 * self.span_m + self.wall_thickness_m

    @property
    def face(self) -> float:
        """Distance of the nave walls' inner faces from the axis, above the ring's foot."""
        return float(self.foot[3, 0])

    @cached_property
    def upper_levels(self) -> Array:
        """Levels (k,), m, of the courses above the springing."""
        return _levels(self.springing_m, self.height_m, self.course_height_m)

    def layout(self) -> Layout:
        """Return the polygons of the supports, the nave walls, the arch wall and the roof."""
        nave = self.nave_wall()
        nave = mirrored(nave) + nave
        arch = self.ring.blocks() + self.spandrels()
        base = base_below(self.inner, self.outer)
        return tidied(
            BASE_SINISTRA=mirrored([base]),
            BASE_DESTRA=[base],
            NAVATA=nave,
            ARCO=arch,
            COPERTURA=self.roof(nave + arch),
        )

    def nave_wall(self) -> list[Array]:
        """Return the blocks (n, 2), m, of the right nave wall."""
        lower = _levels(0.0, self.springing_m, self.course_height_m)
        upper, ledge = self.upper_levels, self.foot[3, 1]
        skewback = int((upper < ledge - 1e-9).sum())
        cut = running_bond(
            self.inner, self.outer, np.append(lower, upper[1 : skewback + 1]), self.wall_blocks
        )
        region = unary_union([Polygon(self.foot), box(self.face, 0.0, self.outer, self.height_m)])
        across = max(1, round(self.wall_blocks * (self.outer - self.face) / self.wall_thickness_m))
        return fitted(cut, region) + running_bond(self.face, self.outer, upper[skewback:], across)

    def spandrels(self) -> list[Array]:
        """Return the blocks (n, 2), m, between the nave walls above the ring."""
        below = np.vstack([[(-self.face, 0.0)], self.ring.joints(self.thickness_m), [(self.face, 0.0)]])
        region = box(-self.face, self.springing_m, self.face, self.height_m).difference(Polygon(below))
        return fitted(running_bond(-self.face, self.face, self.upper_levels, self.spandrel_blocks), region)

    def roof(self, masonry: list[Array]) -> list[Array]:
        """Return square beams (4, 2), m, at about equal distances, each over the middle of a block of the top course.

        Raises ValueError if they do not fit side by side.
        """
        top = [block for block in masonry if block[:, 1].max() > self.height_m - 1e-9]
        middles = np.array([0.5 * (block[:, 0].min() + block[:, 0].max()) for block in top])
        spots = self.outer * (np.arange(1, 2 * self.beams, 2) / self.beams - 1.0)
        # of two blocks equally near, the one nearer the axis: the roof stays symmetric
        nearest = [middles[np.argmin(np.abs(middles - x) + 1e-6 * np.abs(middles))] for x in spots]
        side, z = self.beam_side_m, self.height_m
        if min(np.diff(nearest), default=np.inf) < side:
            raise ValueError(
                f"beams: {self.beams} beams of {side:g} m do not fit side by side on the top course"
            )
        return [rectangle(x - 0.5 * side, x + 0.5 * side, z, z + side) for x in nearest]


def triumphal_arch(**dimensions: Any) -> Layout:
    """Polygons of a TriumphalArch of these dimensions, by layer."""
    return TriumphalArch(**dimensions).layout()


def _levels(z0: float, z1: float, course_height: float) -> Array:
    """Levels of the nearest whole number of equal courses."""
    courses = max(1, round((z1 - z0) / course_height))
    if courses > MOST_COURSES:
        raise ValueError(
            f"course_height_m: {course_height:g} makes {courses} courses, at most {MOST_COURSES}"
        )
    return np.linspace(z0, z1, courses + 1)
