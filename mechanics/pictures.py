"""Drawings of blocks and curves, of plain arrays, on matplotlib axes, which only who draws imports: it takes long."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np
import shapely
from numpy.typing import ArrayLike

from mechanics.types import Array, Index, Mask, turned

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes
    from matplotlib.patches import PathPatch


@dataclass(frozen=True, eq=False)
class Shape:
    """The blocks (b,) in a configuration.

    Vertices `points` (n, 2) in m, the block `owner` (n,) of each; `centroids` (b, 2), m; whether they are `supports`.
    """

    points: Array
    owner: Index
    centroids: Array
    supports: Mask

    @classmethod
    def of(cls, rings: Sequence[ArrayLike], centroids: ArrayLike, supports: Sequence[bool]) -> Shape:
        """Return the shape of blocks from the vertices (n, 2) of each."""
        corners = [np.asarray(ring, dtype=float) for ring in rings]
        owner = np.repeat(np.arange(len(corners)), [len(ring) for ring in corners])
        middles = np.asarray(centroids, dtype=float)
        return cls(np.vstack(corners), owner, middles, np.asarray(supports, dtype=bool))

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Return (x0, z0, x1, z1) in m."""
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])

    @property
    def size(self) -> float:
        """Return the larger side of the bounds, in m."""
        x0, z0, x1, z1 = self.bounds
        return max(x1 - x0, z1 - z0)

    def moved(self, configuration: ArrayLike, magnification: float = 1.0) -> Shape:
        """Return the outlines displaced by (b, 3) finite motions about the centroids, magnified."""
        motion = np.asarray(configuration, dtype=float)
        shift = magnification * (place(self.points, self.owner, self.centroids, motion) - self.points)
        middles = self.centroids + magnification * motion[:, :2]
        return replace(self, points=self.points + shift, centroids=middles)

    def swept(self, velocity: ArrayLike, amount: float) -> Shape:
        """Return the outlines displaced by `amount` times the (b, 3) infinitesimal motions `velocity`."""
        rate = np.asarray(velocity, dtype=float)
        shift = amount * field(self.points, self.owner, self.centroids, rate)
        return replace(self, points=self.points + shift, centroids=self.centroids + amount * rate[:, :2])

    def nearest(self, point: ArrayLike) -> int:
        """Return the block whose outline passes nearest to a point (2,) m."""
        outlines = [shapely.linearrings(ring) for ring in self.rings(self.every)]
        return int(np.argmin(shapely.distance(outlines, shapely.Point(point))))

    @property
    def every(self) -> Index:
        """Numbers of all blocks."""
        return np.arange(len(self.centroids))

    def rings(self, chosen: Sequence[int] | Index) -> list[Array]:
        """Return the vertices (n, 2) of each of the chosen blocks."""
        cuts = np.searchsorted(self.owner, np.arange(len(self.centroids) + 1))
        return [self.points[cuts[block] : cuts[block + 1]] for block in chosen]


def place(points: Array, owner: Index, centroids: Array, motion: Array) -> Array:
    """Move points (n, 2) with their blocks by finite motions (b, 3): dx, dz in m, rotation in rad."""
    arm = points - centroids[owner]
    return centroids[owner] + turned(arm, motion[owner, 2]) + motion[owner, :2]


def field(points: Array, owner: Index, centroids: Array, rate: Array) -> Array:
    """Return the displacement (n, 2) of points under infinitesimal motions (b, 3) of their blocks."""
    arm = points - centroids[owner]
    turn = rate[owner, 2][:, None] * np.column_stack([-arm[:, 1], arm[:, 0]])
    return rate[owner, :2] + turn


def through_blocks(pairs: Index, points: Array, loaded: ArrayLike) -> list[Array]:
    """Return a line (2, 2) m through each block that exactly two loaded joints press: there the line of thrust is one.

    `pairs` (j, 2): blocks of the joints; `points` (j, 2) m: where the resultants cross them; `loaded` (j,): which are.
    """
    pressed: dict[int, list[int]] = {}
    for number in np.flatnonzero(loaded).tolist():
        for block in pairs[number].tolist():
            pressed.setdefault(block, []).append(number)
    return [points[both] for both in pressed.values() if len(both) == 2]


Bounds = tuple[float, float, float, float]
STYLE = {
    "font.family": "DejaVu Sans",  # shipped with matplotlib
    "font.size": 7.5,
    "svg.fonttype": "none",  # words stay words: searchable, and faster to set in the PDF
    "svg.hashsalt": "assesto",
    "mathtext.fontset": "dejavusans",
    "text.parse_math": False,  # the dollar of a name is a dollar; what is a formula says so
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 8.0,
    "patch.facecolor": "0.0",  # drawings are black, white and grey, heads of arrows too
    "axes.titley": 1.0,  # no labels above axes that a title would have to clear: measuring them all takes time
    "axes.grid": True,
    "grid.linewidth": 0.3,
    "grid.color": "0.8",
    "legend.frameon": False,
    "legend.fontsize": 7.0,
    "lines.linewidth": 1.0,
}
INK, FAINT, SUPPORT, MOVING, MASONRY = "0.0", "0.55", "0.55", "0.82", "0.92"
FILLED = {"edgecolor": INK, "linewidth": 0.45}
GHOST = {"fill": False, "edgecolor": FAINT, "linewidth": 0.5, "linestyle": (0, (4, 2))}
TIE: dict[str, Any] = {"color": INK, "linewidth": 1.1, "linestyle": (0, (7, 1.2, 1.5, 1.2))}
THRUST: dict[str, Any] = {"color": INK, "linewidth": 1.8}
SLIDING: dict[str, Any] = {"color": INK, "linewidth": 2.4, "solid_capstyle": "butt"}
HOLLOW: dict[str, Any] = {"linestyle": "none", "markerfacecolor": "1.0"}
HINGE = HOLLOW | {"marker": "o", "markersize": 5.0, "markeredgecolor": INK, "markeredgewidth": 1.2}
MARKS = {  # of the points of a curve, by their names in the legend
    name: HOLLOW | {"marker": marker, "markersize": size}
    for name, marker, size in (("α_0", "o", 4.5), ("d_0", "^", 5.0), ("d_y, α_y", "s", 4.0))
}
SHOWN = 0.06  # of the size of the model: the largest displacement of a settlement, magnified
SWEPT = 0.08  # likewise, of the virtual displacements of a mechanism


def _patch(shape: Shape, chosen: Any, style: dict[str, Any]) -> PathPatch:
    """Return one compound path of the chosen blocks: one element of the SVG, however many blocks."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    closed = [Path(np.vstack([ring, ring[:1]]), closed=True) for ring in shape.rings(chosen)]
    return PathPatch(Path.make_compound_path(*closed), **style)


def fill(axes: Axes, shape: Shape, chosen: Any, grey: str) -> list[tuple[Any, PathPatch]]:
    """Fill some blocks with a grey; return these and what is drawn of them, if there are any."""
    if not len(chosen):
        return []
    patch = _patch(shape, chosen, FILLED | {"facecolor": grey})
    axes.add_artist(patch)
    return [(chosen, patch)]


def fill_roles(axes: Axes, shape: Shape) -> list[tuple[Any, PathPatch]]:
    """Fill supports dark and all other blocks light; return as `fill`."""
    light, dark = np.flatnonzero(~shape.supports), np.flatnonzero(shape.supports)
    return [*fill(axes, shape, light, MASONRY), *fill(axes, shape, dark, SUPPORT)]


def ghost(axes: Axes, shape: Shape) -> None:
    """Draw the outlines of an earlier configuration, dashed."""
    axes.add_artist(_patch(shape, shape.every, GHOST))


def union(shapes: Sequence[Shape]) -> Bounds:
    """Return the bounds of all shapes, m."""
    boxes = np.array([shape.bounds for shape in shapes])
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def nice(value: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is not above `value`."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= value * (1.0 + 1e-9))


def magnification(shape: Shape, configuration: Any) -> float:
    """Return a round factor that makes the largest displacement of a configuration (b, 3) `SHOWN` of the size."""
    travel = float(np.abs(shape.moved(configuration).points - shape.points).max()) / shape.size
    return nice(max(1.0, SHOWN / travel)) if travel > 1e-7 else 1.0  # less is rounding


def swept_by(shape: Shape, velocity: Array) -> float:
    """Return by how much virtual displacements (b, 3) are multiplied so that the largest is `SWEPT` of the size."""
    rate = shape.swept(velocity, 1.0).points - shape.points
    return SWEPT * shape.size / max(float(np.linalg.norm(rate, axis=1).max()), 1e-12)


Given = ParamSpec("Given")
Shown = TypeVar("Shown")
AROUND = 0.06  # of the size of a drawing: what is free at its sides
WIDE, HIGH = 4.7, 3.4  # inches, of a new figure


def _styled(draw: Callable[Given, Shown]) -> Callable[Given, Shown]:
    """Draw in the common style, whatever the style of the session."""

    @wraps(draw)
    def styled(*args: Given.args, **kwargs: Given.kwargs) -> Shown:
        from matplotlib import rc_context

        with rc_context(STYLE):  # type: ignore[arg-type]
            return draw(*args, **kwargs)

    return styled


def _axes(axes: Axes | None, bounds: Bounds | None = None) -> Axes:
    """Return the axes, by default those of a new figure; of a drawing with these bounds (m) to scale, without frame."""
    if axes is None:
        import matplotlib.pyplot as plt  # late: only who has no axes needs its figures

        axes = plt.subplots(figsize=(WIDE, HIGH), layout="constrained")[1]
    if bounds is not None:
        x0, z0, x1, z1 = bounds
        free = AROUND * max(x1 - x0, z1 - z0)
        axes.set(xlim=(x0 - free, x1 + free), ylim=(z0 - free, z1 + free), aspect="equal")
        axes.set_axis_off()
    return axes


@_styled
def draw_state(shape: Shape, drawn: Shape, ties: Iterable[Array], title: str, axes: Axes | None) -> Axes:
    """Draw blocks in a configuration, over their outlines as drawn; `ties`: ends (2, 2) m of each."""
    axes = _axes(axes, union([shape, drawn]))
    axes.set_title(title)
    ghost(axes, drawn)
    fill_roles(axes, shape)
    for ends in ties:
        axes.plot(*ends.T, **TIE)
    return axes


@_styled
def draw_mechanism(
    start: Shape,
    velocity: Array,
    hinges: Array,
    slides: Sequence[Array],
    thrust: Iterable[Array],
    ties: Iterable[Array],
    title: str,
    axes: Axes | None,
) -> Axes:
    """Draw a mechanism where it begins: blocks that move grey, where they go dashed, and the line of thrust.

    `velocity` (b, 3): virtual displacements; `hinges` (n, 2) m; `slides`: ends (2, 2) m of the joints that slide;
    `thrust`: pieces (2, 2) m of its line; `ties`: ends (2, 2) m of each.
    """
    swept = start.swept(velocity, swept_by(start, velocity))
    axes = _axes(axes, union([start, swept]))
    axes.set_title(title)
    ghost(axes, swept)
    fast = np.abs(velocity).max(axis=1) > 1e-4 * np.abs(velocity).max()
    own = ~start.supports
    for chosen, grey in ((~fast & own, MASONRY), (start.supports, SUPPORT), (fast & own, MOVING)):
        fill(axes, start, np.flatnonzero(chosen), grey)
    for style, pieces in ((THRUST, thrust), (SLIDING, slides), (TIE, ties)):
        for line in pieces:
            axes.plot(*line.T, **style)
    axes.plot(*hinges.T, **HINGE)
    return axes


@_styled
def draw_curve(
    x: Array,
    y: Array,
    marks: dict[str, tuple[float, float]],
    labels: tuple[str, str],
    title: str,
    axes: Axes | None,
) -> Axes:
    """Draw a curve, and the points of `marks` by their names."""
    axes = _axes(axes)
    axes.plot(x, y, color=INK)
    for name, point in marks.items():
        axes.plot(*point, color=INK, clip_on=False, label=name, **MARKS[name])
    axes.set(xlabel=labels[0], ylabel=labels[1], title=title)
    if marks:
        axes.legend()
    return axes


@_styled
def film(shapes: Sequence[Shape], drawn: Shape, titles: Sequence[str], interval: float) -> FuncAnimation:
    """Return an animation of blocks over their outlines as drawn, a frame each `interval`, s."""
    import matplotlib.pyplot as plt
    from matplotlib.animation import FuncAnimation

    bounds = union([drawn, *shapes])
    width, height = bounds[2] - bounds[0], bounds[3] - bounds[1]
    figure = plt.figure(figsize=(WIDE, WIDE * min(1.5, max(0.4, height / width))))
    axes = _axes(figure.add_axes((0.0, 0.0, 1.0, 0.92)), bounds)
    ghost(axes, drawn)
    groups = fill_roles(axes, shapes[0])

    def show(frame: int) -> list[PathPatch]:
        for chosen, patch in groups:
            patch.set_path(_patch(shapes[frame], chosen, {}).get_path())
        axes.set_title(titles[frame])
        return [patch for _, patch in groups]

    return FuncAnimation(figure, show, frames=len(shapes), interval=1000.0 * interval, blit=False)
