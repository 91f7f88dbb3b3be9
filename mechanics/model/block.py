"""A block: a simple polygon with depth and material, and its mass properties."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import ArrayLike

from mechanics.errors import array_of, is_number, is_whole, require, require_positive
from mechanics.types import GRAVITY, Array


@dataclass(frozen=True, slots=True)
class Material:
    """Stone and its dry joints.

    unit_weight: kN/m³; friction: tangent of the friction angle, infinite: no sliding; normal_stiffness and
    tangential_stiffness: of a joint per unit area, kN/m³. Without normal_stiffness only rigid analyses are possible; an
    infinite tangential_stiffness is the paper's choice (§4). compressive_strength: of a joint, kN/m². Raises
    ArgumentError naming the argument.
    """

    unit_weight: float
    friction: float = 0.6
    normal_stiffness: float | None = None
    tangential_stiffness: float = float("inf")
    compressive_strength: float = float("inf")

    def __post_init__(self) -> None:
        require_positive(
            self, unit_weight="positive, in kN/m³", normal_stiffness="positive, in kN/m³, or None"
        )
        require_positive(self, "[]", friction="zero or positive")
        require_positive(
            self, "(]", tangential_stiffness="positive, in kN/m³ (inf: rigid in shear)",
            compressive_strength="positive, in kN/m² (inf: no limit)",
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Block:
    """A rigid block: simple polygon `vertices` (n, 2) in m, kept anticlockwise, `depth` in m out of plane.

    `support`: name of the support that the block belongs to (None: movable). `vertical_load` (kN) acts downward at the
    centroid and counts as seismic mass if `load_has_mass`. `segments`: instead of the assembly's segments per joint.
    `layer`, `handle`: origin of the block in the drawing; `region`: of the project. Raises ArgumentError for fewer than
    three distinct vertices, zero area, an outline that crosses itself, an upward load with mass, or numbers that are
    not finite.
    """

    vertices: ArrayLike
    depth: float
    material: Material
    support: str | None = None
    vertical_load: float = 0.0
    load_has_mass: bool = True
    segments: int | None = None
    layer: str = ""
    handle: str = ""
    region: str = ""

    def __post_init__(self) -> None:
        must_be = "three or more finite (x, z) pairs"
        v = array_of("vertices", self.vertices, must_be)
        pairs = v.ndim == 2 and v.shape[1] == 2 and len(v) >= 3 and bool(np.isfinite(v).all())
        require(pairs, "vertices", v.shape, must_be)
        require_positive(self, depth="positive, in m")
        load, segments, name = self.vertical_load, self.segments, self.support
        require(is_number(load) and abs(load) < np.inf, "vertical_load", load, "finite, in kN")
        # an upward force is no mass: it made the mass of a block negative
        require(load >= 0.0 or not self.load_has_mass, "vertical_load", load,
                "zero or positive where load_has_mass, in kN")  # fmt: skip
        whole = segments is None or (is_whole(segments) and segments >= 1)
        require(whole, "segments", segments, "a whole number ≥ 1")
        require(isinstance(self.material, Material), "material", self.material, "a Material")
        require(name is None or (isinstance(name, str) and name != ""), "support", name, "a name, or None")
        size = float(np.ptp(v, axis=0).max())
        v = v[np.hypot(*(v - np.roll(v, 1, axis=0)).T) > 1e-12 * size]  # repeated vertices are dropped
        require(len(v) >= 3, "vertices", len(v), "three or more distinct points")
        area = _signed_area(v)
        require(abs(area) > 1e-12 * size**2, "vertices", area, "a polygon with an area")
        require(bool(shapely.is_valid(shapely.polygons(v))), "vertices", "an outline that crosses or touches itself",
                "a simple polygon")  # fmt: skip
        if area < 0.0:
            v = v[::-1].copy()
        v.flags.writeable = False
        object.__setattr__(self, "vertices", v)

    @property
    def polygon(self) -> Array:
        """Vertices (n, 2), m, anticlockwise."""
        return self.vertices  # type: ignore[return-value]

    @cached_property
    def area(self) -> float:
        """Area of the polygon, m²."""
        return _signed_area(self.polygon)

    @cached_property
    def centroid(self) -> Array:
        """Centroid (2,), m."""
        origin = self.polygon[0]
        p, q = self.polygon - origin, np.roll(self.polygon, -1, axis=0) - origin
        cross = p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]
        return origin + ((p + q) * cross[:, None]).sum(axis=0) / (6.0 * self.area)

    @cached_property
    def mass(self) -> float:
        """Seismic mass, Mg: that of the stone, and of the load if it has mass."""
        load = self.vertical_load if self.load_has_mass else 0.0
        return (self.material.unit_weight * self.area * self.depth + load) / GRAVITY

    @cached_property
    def inertia(self) -> float:
        """Polar moment of inertia of the stone about the centroid, Mg·m² (a load is a point mass there)."""
        p = self.polygon - self.centroid
        q = np.roll(p, -1, axis=0)
        cross = p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]
        second_moment = float((cross * ((p * p).sum(1) + (p * q).sum(1) + (q * q).sum(1))).sum()) / 12.0
        return self.material.unit_weight / GRAVITY * self.depth * second_moment

    @property
    def weight(self) -> float:
        """Vertical force, kN: own weight and load."""
        return self.material.unit_weight * self.area * self.depth + self.vertical_load


def _signed_area(v: Array) -> float:
    p = v - v[0]
    q = np.roll(p, -1, axis=0)
    return 0.5 * float((p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]).sum())
