"""What templates are made of, z = 0 at the foot: closed polygons (n, 2) m by layer; radial joints shared exactly."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from shapely import intersection, is_ccw, linearrings
from shapely.geometry import Polygon
from shapely.ops import unary_union

Array = NDArray[np.float64]
Layout = dict[str, list[Array]]

THINNEST = 0.06  # m; a cut block thinner than this is joined to its neighbour
DECIMALS = 12  # of coordinates in m: shared vertices become identical
MOST_COURSES = 100  # of a wall, whose blocks are cut one by one


@dataclass(frozen=True)
class Ring:
    """Arch of equal voussoirs: dimensions, springing level, centre line (m); above half the span it is pointed.

    A pointed one has two centres, on the springing, and a joint at the crown. Raises ValueError.
    """

    span_m: Annotated[float, "clear span"]
    rise_m: Annotated[float, "rise of the intrados; above half the span the arch is pointed"]
    thickness_m: Annotated[float, "thickness of the ring"]
    voussoirs: Annotated[int, "voussoirs of a ring"]
    springing: float = 0.0
    middle: float = 0.0

    def __post_init__(self) -> None:
        if self.voussoirs < 2:
            raise ValueError(f"voussoirs: must be 2 or more, is {self.voussoirs}")
        if self.pointed and self.voussoirs % 2:
            text = "a pointed arch (rise_m above half of span_m) has a joint at its crown"
            raise ValueError(f"voussoirs: {self.voussoirs} is odd; {text}")

    @property
    def pointed(self) -> bool:
        """Whether the arch has two centres."""
        return self.rise_m > 0.5 * self.span_m * (1.0 + 1e-9)

    @property
    def radius(self) -> float:
        """Radius of the intrados, m."""
        return (0.25 * self.span_m**2 + self.rise_m**2) / (self.span_m if self.pointed else 2.0 * self.rise_m)

    @property
    def half_angle(self) -> float:
        """Angle at its centre, rad, of the half of a round arch, of one arc of a pointed one."""
        if self.pointed:
            return float(np.arcsin(self.rise_m / self.radius))
        return 2.0 * float(np.arctan2(2.0 * self.rise_m, self.span_m))

    def joints(self, offset: float) -> Array:
        """Return the ends (voussoirs + 1, 2) of the joints at radius + offset, left to right: radial but a crown's."""
        r = self.radius + offset
        if not self.pointed:
            angle = np.linspace(-self.half_angle, self.half_angle, self.voussoirs + 1)
            centre = self.springing + self.rise_m - self.radius
            return np.column_stack([self.middle + r * np.sin(angle), centre + r * np.cos(angle)])
        apart = self.radius - 0.5 * self.span_m  # of a centre from the axis
        angle = np.linspace(0.0, self.half_angle, self.voussoirs // 2 + 1)[:-1]
        x, z = r * np.cos(angle) - apart, self.springing + r * np.sin(angle)
        crown = [(self.middle, self.springing + float(np.sqrt(r**2 - apart**2)))]
        left, right = (np.column_stack([self.middle + sign * x, z]) for sign in (-1.0, 1.0))
        return np.vstack([left, crown, right[::-1]])

    def blocks(self) -> list[Array]:
        """Return the voussoirs, each (4, 2) m, from left to right."""
        inner, outer = self.joints(0.0), self.joints(self.thickness_m)
        return [np.array([inner[k], inner[k + 1], outer[k + 1], outer[k]]) for k in range(self.voussoirs)]

    def foot(self, width: float) -> tuple[Array, Array]:
        """Return inner and outer end (2,) m of the right-hand springing joint; ValueError if wider than `width`, m."""
        inner, outer = self.joints(0.0)[-1], self.joints(self.thickness_m)[-1]
        if outer[0] - inner[0] > width + 1e-9:
            text = f"the ring's foot is {outer[0] - inner[0]:.3g} m wide, its support {width:g} m"
            raise ValueError(f"thickness: {text}")
        return inner, outer

    def springer(self, width: float, bottom: float) -> Array:
        """Return the right-hand block (5, 2), m, of a `width` from `bottom` (m) up to the ring. Raises as `foot`."""
        (xi, zi), (xe, ze) = self.foot(width)
        return np.array([(xi, bottom), (xi + width, bottom), (xi + width, ze), (xe, ze), (xi, zi)])


def rectangle(x0: float, z0: float, x1: float, z1: float) -> Array:
    """Return the rectangle (4, 2) between two corners, m, anticlockwise."""
    return np.array([(x0, z0), (x1, z0), (x1, z1), (x0, z1)])


def stack(x0: float, x1: float, levels: Iterable[float]) -> list[Array]:
    """Return blocks (4, 2) m one on the other between the levels, m."""
    return [rectangle(x0, a, x1, b) for a, b in pairwise(levels)]


def course(x0: float, x1: float, z0: float, z1: float, *, blocks: int, shifted: bool) -> list[Array]:
    """Return a course of equal blocks, each (4, 2) m; a shifted one begins and ends with half a block."""
    cuts = np.linspace(x0, x1, 2 * blocks + 1)
    cuts = np.concatenate([cuts[:1], cuts[1::2], cuts[-1:]]) if shifted else cuts[::2]
    return [rectangle(a, z0, b, z1) for a, b in pairwise(cuts)]


def running_bond(x0: float, x1: float, levels: Array, blocks: int) -> list[Array]:
    """Return courses of blocks (4, 2) m between the levels (k,) m, every second one shifted by half a block."""
    rows = enumerate(pairwise(levels))
    return [one for k, (z0, z1) in rows for one in course(x0, x1, z0, z1, blocks=blocks, shifted=k % 2 == 1)]


def courses(z0: float, z1: float, height: float, key: str = "course_height_m") -> Array:
    """Return the levels, m, of the nearest whole number of equal courses. Too many raise ValueError naming the key."""
    count = max(1, round((z1 - z0) / height))
    if count > MOST_COURSES:
        raise ValueError(f"{key}: {height:g} makes {count} courses, at most {MOST_COURSES}; write more")
    return np.linspace(z0, z1, count + 1)


def fitted(cells: Iterable[Array], region: Polygon, thinnest: float = THINNEST) -> list[Array]:
    """Return the cells (n, 2) m cut to a region without gap or overlap; what is thinner (m) is joined to a neighbour.

    Symmetric cells in a symmetric region stay symmetric: of neighbours that share equally much with a sliver
    the one nearer the axis takes it, or both where it stands on the axis itself.
    """
    # of a cell that only touches the region a plain overlay may give the whole: one on a grid does not
    inside = [each for each in map(Polygon, cells) if intersection(each, region, grid_size=1e-9).area > 1e-9]
    cut = [each.intersection(region) for each in inside]
    pieces = [part for c in cut for part in getattr(c, "geoms", [c]) if part.area > 1e-9]
    while len(pieces) > 1 and (slivers := [each for each in pieces if each.buffer(-0.5 * thinnest).is_empty]):
        # symmetric cells stay so: of equal neighbours the one nearer the axis takes it, both if it stands on the axis
        sliver = min(slivers, key=lambda piece: (round(piece.area, 9), _off_axis(piece)))
        others = [piece for piece in pieces if piece is not sliver]
        bond = [(round(other.intersection(sliver).length, 9), -_off_axis(other)) for other in others]
        joined = [other for other, each in zip(others, bond, strict=True) if each == max(bond)]
        pieces = [other for other in others if other not in joined] + [unary_union([sliver, *joined])]
    return [np.array(piece.exterior.coords[:-1]) for piece in pieces]


def mirrored(blocks: Iterable[Array]) -> list[Array]:
    """Return the mirror images of polygons (n, 2) about x = 0, anticlockwise as before."""
    return [(block * (-1.0, 1.0))[::-1] for block in blocks]


def base_below(inner: float, outer: float, nearest: float = np.inf) -> Array:
    """Return a base (4, 2), m, wider than the pier by a quarter on either side, by 0.4 of `nearest` at most."""
    margin = min(0.25 * (outer - inner), 0.4 * nearest)
    return rectangle(inner - margin, -0.5 * (outer - inner), outer + margin, 0.0)


def two_bases(right: Array) -> Layout:
    """Return a base (n, 2), m, and its mirror image by their layers."""
    return {"BASE_SINISTRA": mirrored([right]), "BASE_DESTRA": [right]}


def _off_axis(piece: Polygon) -> float:
    return round(abs(float(piece.centroid.x)), 9)


def tidied(**layers: list[Array]) -> Layout:
    """Return the layers with every polygon rounded, anticlockwise, without repeated or collinear vertices."""
    return {layer: [_tidy(polygon) for polygon in polygons] for layer, polygons in layers.items()}


def _tidy(polygon: Array) -> Array:
    p: Array = polygon.round(DECIMALS) + 0.0
    p = p[np.hypot(*(p - np.roll(p, 1, axis=0)).T) > 1e-9]
    back, ahead = p - np.roll(p, 1, axis=0), np.roll(p, -1, axis=0) - p
    p = p[np.abs(back[:, 0] * ahead[:, 1] - back[:, 1] * ahead[:, 0]) > 1e-9]
    return p if is_ccw(linearrings(p)) else p[::-1]


Made = tuple[Layout, dict[str, Any]]
"""What a template makes of its dimensions: polygons by layer, and the content of the project file."""

DRAWING = "geometry.dxf"
ASSESSMENT = {
    "limit_states": ["SLD", "SLV", "SLC"],
    "confidence_factor": 1.35,
    "behaviour_factor": 2.0,
    "model": "trilinear",
    "spectrum": "ntc",
    "site": {  # L'Aquila
        "latitude": 42.35, "longitude": 13.40, "soil": "B", "topography": "T1", "nominal_life_years": 50,
        "use_class": "II",
    },
}  # fmt: skip
TWO_SUPPORTS = {"BASE_SINISTRA": {"support": "sinistro"}, "BASE_DESTRA": {"support": "destro"}}


def project(
    title: str, depth: float, stone: tuple[float, float, float], layers: Mapping[str, Any],
    control: Mapping[str, tuple[float, float]], increment: float,
    settlements: Sequence[Mapping[str, Any]] = (), **tables: Any,
) -> dict[str, Any]:  # fmt: skip
    """Return a project file; `stone`: kN/m³, tangent of friction, kN/m³ of joints; `increment` (m) of the pushover.

    `control`: points (m) by name, of two each followed where it goes ahead; `tables`: others, [assessment] adds.
    """
    ahead = sorted(control, key=lambda name: -control[name][0])
    pushover: dict[str, Any] = {"contacts": ["rigid", "elastic"], "directions": ["+x", "-x"]}
    pushover["increment_m"] = increment
    pushover["control"] = dict(zip(("+x", "-x"), ahead, strict=True)) if ahead[1:] else ahead[0]
    own, keys = tables.pop("assessment", {}), ("unit_weight_kN_m3", "friction", "normal_stiffness_kN_m3")
    return {
        "title": title,
        "geometry": {"drawing": DRAWING, "unit": "m", "depth_m": depth},
        "material": dict(zip(keys, stone, strict=True)),
        "layers": layers,
        **tables,
        "control": [{"name": key, "point_m": [round(x, 9), round(z, 9)]} for key, (x, z) in control.items()],
        **({"settlements": [*settlements]} if settlements else {}),
        "pushover": pushover,
        "assessment": ASSESSMENT | own,
        "report": {"language": "it", "client": "", "engineer": "", "location": ""},
    }


def outward(movement: float, increment: float = 0.0) -> dict[str, Any]:
    """Return the paper's [[settlements]]: outward and down by `movement` (m), in steps `increment` (0: a twentieth)."""
    step = increment or round(0.05 * movement, 7)
    way = {"displacement_m": [movement, -movement], "increment_m": step, "to_collapse": True}
    return sinking(movement) | way


def sinking(movement: float) -> dict[str, Any]:
    """Return [[settlements]] of the right support by a `movement` (m), downward."""
    return {
        "name": f"appoggio destro {1e3 * movement:.4g} mm", "support": "destro",
        "displacement_m": [0.0, -movement], "increment_m": round(movement / 10.0, 7),
    }  # fmt: skip
