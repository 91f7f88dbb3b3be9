"""What a model and its analyses show of themselves, on matplotlib axes: blocks, mechanisms, curves, films."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.patches import PathPatch

from mechanics.pictures.parts import (
    GHOST,
    HINGE,
    INK,
    MARKS,
    MASONRY,
    MOVING,
    SLIDING,
    STYLE,
    SUPPORT,
    THRUST,
    TIE,
    Bounds,
    fill,
    fill_roles,
    ghost,
    swept_by,
    union,
)
from mechanics.pictures.shape import Shape
from mechanics.types import Array

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes

Given = ParamSpec("Given")
Shown = TypeVar("Shown")
AROUND = 0.06  # of the size of a drawing: what is free at its sides
WIDE, HIGH = 4.7, 3.4  # inches, of a new figure


def _styled(draw: Callable[Given, Shown]) -> Callable[Given, Shown]:
    """Draw in the common style, whatever the style of the session."""

    @wraps(draw)
    def styled(*args: Given.args, **kwargs: Given.kwargs) -> Shown:
        with mpl.rc_context(STYLE):  # type: ignore[arg-type]
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
    for chosen, grey in (
        (~fast & ~start.supports, MASONRY),
        (start.supports, SUPPORT),
        (fast & ~start.supports, MOVING),
    ):
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
    import matplotlib.pyplot as plt  # late: as above
    from matplotlib.animation import FuncAnimation

    bounds = union([drawn, *shapes])
    width, height = bounds[2] - bounds[0], bounds[3] - bounds[1]
    figure = plt.figure(figsize=(WIDE, WIDE * min(1.5, max(0.4, height / width))))
    axes = _axes(figure.add_axes((0.0, 0.0, 1.0, 0.92)), bounds)
    axes.add_artist(PathPatch(drawn.path(drawn.every), **GHOST))
    roles = [(np.flatnonzero(~drawn.supports), MASONRY), (np.flatnonzero(drawn.supports), SUPPORT)]
    groups: list[tuple[Any, PathPatch]] = []
    for chosen, grey in roles:
        if len(chosen):
            patch = PathPatch(shapes[0].path(chosen), facecolor=grey, edgecolor=INK, linewidth=0.45)
            axes.add_patch(patch)
            groups.append((chosen, patch))

    def show(frame: int) -> list[PathPatch]:
        for chosen, patch in groups:
            patch.set_path(shapes[frame].path(chosen))
        axes.set_title(titles[frame])
        return [patch for _, patch in groups]

    return FuncAnimation(figure, show, frames=len(shapes), interval=1000.0 * interval, blit=False)
