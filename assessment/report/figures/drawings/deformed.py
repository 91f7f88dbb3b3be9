"""Drawings of an assembly: a settlement, the mechanisms, the end of capacity; all to scale, in black and white."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch

from assessment.report.figures.drawings.labels import Labels
from assessment.report.figures.drawings.ties import LINE, draw_ties, moved_ends, tie_handles
from assessment.report.figures.style import WIDTH_MM, Sheet, nice, sheet
from assessment.report.tables.curves import alpha_at_d_0
from assessment.report.text.language import Words, direction_name
from assessment.results.configurations.faces import faces_of
from assessment.results.configurations.hand_check import BY_HAND, MacroBlock, macro_blocks, rigid_push
from assessment.results.configurations.outlines import Array, Outlines, field, outlines
from assessment.results.configurations.tie_ends import ties_of
from assessment.results.schema import Results
from assessment.results.schema.checks import Direction, GivenMechanism
from assessment.results.schema.model import Face
from assessment.results.schema.part import Configuration, Point, known
from assessment.results.schema.static import Settlement
from assessment.results.table import sense
from mechanics.model import end_points

Bounds = tuple[float, float, float, float]
INK, FAINT, SUPPORT, MOVING = "0.0", "0.55", "0.55", "0.82"
LIGHT = 0.01  # of the moving weight: a macro-block that is lighter is not numbered
LETTER_MM, KEY_MM = (
    1.4,
    9.0,
)  # of a legend: an average letter; the key before the words and the gap after them
LINE_MM, FREE_MM = 3.8, 4.0  # of a legend: a line; what is free above and below
ARROW = {"arrowstyle": "-|>,head_width=0.18,head_length=0.4", "shrinkA": 0.0, "shrinkB": 0.0, "lw": 0.8}
GHOST = {"fill": False, "edgecolor": FAINT, "linewidth": 0.5, "linestyle": (0, (4, 2))}


def draw_settlement(results: Results, words: Words, state: str) -> Figure:
    """Draw a settled state, magnified until it shows, and the last one before collapse where it was found."""
    shape, content = outlines(results), results.states[state]
    travel = float(np.abs(shape.moved(content.configuration).points - shape.points).max())
    times = nice(max(1.0, 0.06 * shape.size / travel)) if travel > 0.0 else 1.0
    views = {words.plain("figure.settled_true"): shape.moved(content.configuration)}
    moved = [(content.configuration, 1.0)]
    if times > 1.0:
        title = words.plain("figure.settled", times=f"{times:g}")
        views[title] = shape.moved(content.configuration, times)
        moved.append((content.configuration, times))
    for contacts, path in content.pushdown.items():
        if path.ultimate_configuration is not None:
            title = words.plain(
                "figure.ultimate",
                contacts=words.plain(f"value.{contacts}"),
                movement=words.millimetres(path.ultimate_movement_m),
            )
            views[title] = shape.moved(path.ultimate_configuration)
            moved.append((path.ultimate_configuration, 1.0))
    page = sheet(union([shape, *views.values()]), len(views), border_mm=5.0, below_mm=8.0, foot_mm=foot([""]))
    for axes, (title, view), at in zip(page.panels, views.items(), moved, strict=True):
        axes.set_title(title)
        axes.add_artist(PathPatch(shape.path(_all(shape)), **GHOST))
        fill_roles(axes, view, results)
        draw_ties(page, axes, moved_ends(results, state, *at))
    _movement(page, shape, results, known(content.settlement))
    ghost = ghost_handle(words.plain("figure.original_outline"))
    legend(page, [ghost, *tie_handles(results, words, state)])
    return page.figure


def draw_overturned(results: Results, words: Words, states: Sequence[str], direction: Direction) -> Figure:
    """Draw each state where its capacity ends (d_0, rigid contacts), to true scale over the state's own rest."""
    drawing = outlines(results)
    pushed = [rigid_push(results, name, direction) for name in states]
    starts = [drawing.moved(results.states[name].configuration) for name in states]
    ends = [drawing.moved(rigid.final_configuration) for rigid in pushed]
    page = sheet(union([*starts, *ends]), len(states), border_mm=7.0, foot_mm=foot([""]))
    for axes, name, start, end, rigid in zip(page.panels, states, starts, ends, pushed, strict=True):
        left = alpha_at_d_0(rigid)
        lost = "" if left is None else f", α = {words.show(left)}"
        axes.set_title(f"{words.state(name)}\nd₀ = {words.millimetres(rigid.d_0_m)}{lost}")
        axes.add_artist(PathPatch(start.path(_all(start)), **GHOST))
        fill_roles(axes, end, results)
        draw_ties(page, axes, moved_ends(results, name, rigid.final_configuration))
        push_arrow(page, axes, end.bounds, direction)
    ghost = ghost_handle(words.plain("figure.start_outline"))
    legend(page, [ghost, *tie_handles(results, words, *states)])
    return page.figure


def draw_mechanisms(results: Results, words: Words, states: Sequence[str], direction: Direction) -> Figure:
    """Draw the mechanism of each state on its deformed shape at activation, hinges and sliding joints marked."""
    views = [found_mechanism(results, name, direction) for name in states]
    return _draw_mechanisms(words, views, direction)


def draw_chosen(results: Results, words: Words, given: GivenMechanism) -> Figure:
    """Draw a mechanism that the user chose; its centres of rotation are marked as hinges."""
    centres = [part.about_m for part in known(given.macro_blocks)]
    motion = Kinematics(known(given.displacements), centres, known(given.sliding_joints))
    at = results.states[given.state].configuration
    view = Mechanism(results, given.state, motion, at, known(given.met))
    return _draw_mechanisms(words, [view], known(given.direction))


def _draw_mechanisms(words: Words, views: Sequence[Mechanism], direction: Direction) -> Figure:
    handles: list[Any] = [
        ghost_handle(words.plain("figure.start_outline")),
        Patch(facecolor=MOVING, edgecolor=INK, linewidth=0.5, label=words.plain("figure.moving")),
        Line2D([], [], **HINGE, label=words.plain("figure.hinge")),
    ]
    if any(len(view.sliding) for view in views):
        handles.append(Line2D([], [], **SLIDING, label=words.plain("figure.sliding")))
    if any(view.ties for view in views):
        handles.append(Line2D([], [], **LINE, label=words.plain("figure.tie")))
    bounds = union([outline for view in views for outline in (view.start, view.swept)])
    page = sheet(bounds, len(views), border_mm=7.0, foot_mm=foot(labels_of(handles)), most_mm=85.0)
    for axes, view in zip(page.panels, views, strict=True):
        axes.set_title(words.state(view.state))
        view.draw(page, axes)
        push_arrow(page, axes, view.swept.bounds, direction)
    legend(page, handles)
    return page.figure


HINGE: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 5.0,
    "markerfacecolor": "1.0",
    "markeredgecolor": INK,
    "markeredgewidth": 1.2,
}
LABEL: dict[str, Any] = {
    "fontsize": 7.0,
    "fontweight": "bold",
    "bbox": {"facecolor": "1.0", "edgecolor": INK, "linewidth": 0.4, "pad": 1.4},
}
SLIDING: dict[str, Any] = {"color": INK, "linewidth": 2.4, "solid_capstyle": "butt"}


def found_mechanism(results: Results, state: str, direction: Direction) -> Mechanism:
    """Return the rigid mechanism of a state in a direction, its macro-blocks numbered where they are printed."""
    rigid = rigid_push(results, state, direction)
    motion = Kinematics(
        rigid.mechanism.displacements, rigid.mechanism.hinge_points_m, rigid.mechanism.sliding_joints
    )
    parts = macro_blocks(results, state, direction)
    numbered = parts if len(parts) <= BY_HAND else ()
    return Mechanism(results, state, motion, rigid.mechanism_configuration, rigid.frames.met, numbered)


class Kinematics(NamedTuple):
    """What a mechanism does: virtual displacements (b, 3), hinges (n, 2) m, numbers of the joints that slide."""

    displacements: Configuration
    hinges: Sequence[Point]
    sliding: Sequence[int]


class Mechanism:
    """A mechanism made visible: its displacements scaled to 8 % of the model's size.

    `configuration` (b, 3): where the blocks are as it begins to move, from the drawing; `met`: pairs of faces, after
    the drawn joints, that touch there and did not as drawn; `numbered`: the macro-blocks of the hand check, whose
    numbers are written into the drawing.
    """

    def __init__(
        self,
        results: Results,
        state: str,
        motion: Kinematics,
        configuration: Configuration,
        met: Sequence[Face],
        numbered: Sequence[MacroBlock] = (),
    ) -> None:
        self.state, self.macro_blocks = state, numbered
        self.configuration = np.asarray(configuration, dtype=float)
        self.velocity = np.asarray(motion.displacements, dtype=float)
        self.drawing = outlines(results)
        self.start = self.drawing.moved(self.configuration)
        speed = np.linalg.norm(self._rate(self.start.points, self.start.owner), axis=1)
        self.amount = 0.08 * self.drawing.size / max(float(speed.max()), 1e-12)
        self.swept = self.start.swept(self.velocity, self.amount)
        self.moving = np.bincount(self.start.owner, speed > 1e-4 * speed.max()) > 0
        self.hinges = motion.hinges
        self.ties = ties_of(results, state)
        self.tie_ends = list(moved_ends(results, state, self.configuration))
        faces, sliding = faces_of(results, met), np.array(motion.sliding, dtype=np.intp)
        self.sliding = faces.contacts.take(sliding)
        self.slides = end_points(self.sliding, faces.positions(self.configuration))

    def draw(self, page: Sheet, axes: Axes) -> None:
        """Draw start outline, displaced blocks, hinges, sliding joints and ties."""
        axes.add_artist(PathPatch(self.start.path(_all(self.start)), **GHOST))
        fill(axes, self.swept, np.flatnonzero(~self.moving), "1.0")
        fill(axes, self.swept, np.flatnonzero(self.moving), MOVING)
        for owner, slide in zip(self.sliding.a, self.slides, strict=True):
            ends = self._carried(slide, np.full(2, owner))
            axes.plot(ends[:, 0], ends[:, 1], **SLIDING)
        carried = [
            self._carried(ends, np.array(tie.blocks))
            for tie, ends in zip(self.ties, self.tie_ends, strict=True)
        ]
        draw_ties(page, axes, iter(carried))
        labels = Labels(page, axes)
        if self.hinges:
            owner = np.array([self.start.nearest(point) for point in self.hinges])
            points = self._carried(np.asarray(self.hinges, dtype=float), owner)
            axes.plot(points[:, 0], points[:, 1], **HINGE)
            labels.avoid(points, HINGE["markersize"] + HINGE["markeredgewidth"])
        self._number_macro_blocks(labels)

    def _number_macro_blocks(self, labels: Labels) -> None:
        """Write the numbers of the macro-blocks, as in the table of the hand check, near their centroids.

        Those of less than LIGHT of the moving weight have none.
        """
        whole_weight = sum(each.weight for each in self.macro_blocks)
        for number, whole in enumerate(self.macro_blocks, 1):
            if whole.weight >= LIGHT * whole_weight:
                away = np.hypot(*(self.start.centroids[list(whole.members)] - whole.centroid).T)
                nearest = np.array(whole.members)[np.argsort(away, kind="stable")]
                labels.write(str(number), list(self.swept.centroids[nearest]), **LABEL)

    def _rate(self, points: Array, owner: Any) -> Array:
        return field(points, owner, self.start.centroids, self.velocity)

    def _carried(self, points: Array, owner: Any) -> Array:
        return points + self.amount * self._rate(points, owner)


def fill(axes: Axes, shape: Outlines, chosen: Any, grey: str) -> None:
    """Draw the chosen blocks in a grey."""
    if len(chosen):
        axes.add_artist(PathPatch(shape.path(chosen), facecolor=grey, edgecolor=INK, linewidth=0.45))


def fill_roles(axes: Axes, shape: Outlines, results: Results) -> None:
    """Draw movable blocks light and supports dark."""
    supports = np.array([block.support is not None for block in results.geometry.blocks])
    fill(axes, shape, np.flatnonzero(~supports), "0.92")
    fill(axes, shape, np.flatnonzero(supports), SUPPORT)


def _all(shape: Outlines) -> range:
    return range(len(shape.centroids))


def union(shapes: Sequence[Outlines]) -> Bounds:
    """Return the bounds of all shapes, m."""
    boxes = np.array([shape.bounds for shape in shapes])
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _movement(page: Sheet, shape: Outlines, results: Results, settlement: Settlement) -> None:
    moved = [i for i, block in enumerate(results.geometry.blocks) if block.support == settlement.support]
    x, z = shape.centroids[moved].mean(axis=0)
    dx, dz = settlement.displacement_m
    size = float(np.hypot(dx, dz))
    axes = page.panels[0]
    if size > 0.0:
        reach = page.paper(9.0) / size
        axes.annotate("", (x + reach * dx, z + reach * dz), (x, z), arrowprops=ARROW | {"lw": 1.4})
    if turn := settlement.rotation_rad:  # a half circle over the support, anticlockwise from right to left
        half = math.copysign(page.paper(5.0), turn)
        bent = {"connectionstyle": f"arc3,rad={math.copysign(1.0, turn)}"}
        axes.annotate("", (x - half, z), (x + half, z), arrowprops=ARROW | {"lw": 1.4} | bent)


def push_arrow(page: Sheet, axes: Axes, bounds: Bounds, direction: Direction) -> None:
    """Draw the arrow of the lateral loads above a model."""
    sign = sense(direction)
    x, z = (bounds[0] + bounds[2]) / 2.0, bounds[3] + page.paper(4.0)
    half = page.paper(8.0) * sign
    axes.annotate("", (x + half, z), (x - half, z), arrowprops=ARROW | {"lw": 1.2})
    axes.annotate(
        f"α ({direction_name(direction)})",
        (x + half, z),
        (4.0 * sign, 0.0),
        textcoords="offset points",
        ha="left" if sign > 0 else "right",
        va="center",
    )


def ghost_handle(label: str) -> Line2D:
    """Return the legend's line of an earlier outline."""
    return Line2D([], [], color=FAINT, linewidth=0.8, linestyle=(0, (4, 2)), label=label)


def legend_columns(labels: Sequence[str]) -> int:
    """Return how many columns, up to three, a legend has room for."""
    widest = max((LETTER_MM * len(label) + KEY_MM for label in labels), default=KEY_MM)
    return max(1, min(len(labels), 3, int(WIDTH_MM / widest)))


def foot(labels: Sequence[str]) -> float:
    """Return the height in mm of a legend with these labels."""
    return FREE_MM + LINE_MM * math.ceil(len(labels) / legend_columns(labels))


def labels_of(handles: Sequence[Any]) -> list[str]:
    """Return the text of a legend for its handles."""
    return [str(handle.get_label()) for handle in handles]


def legend(page: Sheet, handles: list[Any]) -> None:
    """Put the legend of a drawing below it, in as many columns, up to three, as the sheet has room for."""
    columns = legend_columns(labels_of(handles))
    labels = [
        f" {text}" if (text := str(h.get_label())).startswith("_") else text for h in handles
    ]  # "_": left out
    page.figure.legend(
        handles, labels, loc="lower center", ncols=columns, handlelength=1.8, columnspacing=1.6
    )
