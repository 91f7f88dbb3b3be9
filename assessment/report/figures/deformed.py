"""Drawings to scale of what states do: settlements, cracks, mechanisms, the end of capacity, what joints carry."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from assessment.report.figures import drawing as parts
from assessment.report.figures.drawing import Panels, key, sheet
from assessment.report.language import Words
from assessment.report.tables.mechanisms import alpha_at_d_0
from assessment.report.tables.structure import cracks_of, surveyed
from assessment.results import hand_check
from assessment.results.frames import tie_ends, ties_of
from assessment.results.joint_states import Situation, faces_of, joint_states, outlines, thrust_lines
from assessment.results.schema import Configuration, Direction, Face, GivenMechanism, Point, Results, known
from assessment.results.summary import best_of
from mechanics import pictures
from mechanics.model import end_points
from mechanics.types import Array

View = tuple[str, Direction]
"""A state and the direction in which it is pushed."""
LIGHT = 0.01  # of the moving weight: a macro-block that is lighter is not numbered
SMALLEST_PT, LARGEST_PT = 4.5, 6.5  # of the number of a block, as large as the block has room for
ROOM = 1.1  # points of that number for each mm on paper of the root of the block's area
CRACK: dict[str, Any] = {"color": pictures.INK, "linewidth": 2.0, "solid_capstyle": "butt"}
SURVEYED: dict[str, Any] = {"color": "#a33c0a", "linewidth": 1.6, "linestyle": (0, (3, 1)), "marker": "|"}
MEASURED: dict[str, Any] = pictures.HINGE | {"marker": "D", "markersize": 4.0, "markeredgewidth": 1.0}
MOVED: dict[str, Any] = {"facecolor": pictures.MOVING, "edgecolor": pictures.INK, "linewidth": 0.5}
WHITE = {"facecolor": "1.0", "edgecolor": "none", "pad": 0.5}
NUMBER: dict[str, Any] = {"fontsize": 6.5, "fontweight": "bold", "bbox": WHITE, "zorder": 5}
CLEAR_MM = np.array([7.5, 3.0])  # between two of these numbers
BESIDE = (10.0, 0.0)  # points, of a number from its mark
FRAME = {"facecolor": "1.0", "edgecolor": pictures.INK, "linewidth": 0.4, "pad": 1.4}
BOXED: dict[str, Any] = {"fontsize": 7.0, "fontweight": "bold", "bbox": FRAME}


def draw_settlement(results: Results, words: Words, state: str) -> Figure:
    """Draw a settled state, magnified until it shows, and the last one before collapse where it was found."""
    shape, content = outlines(results), results.states[state]
    times = pictures.magnification(shape, content.configuration)
    assigned = words.plain("figure.assigned", times=_times(times, words))
    views: list[tuple[str, Configuration, float]] = [(assigned, content.configuration, times)]
    for contacts, path in content.pushdown.items():
        if path.ultimate_configuration is not None:
            title = words.plain("figure.ultimate", contacts=contacts, movement=path.ultimate_movement_m)
            views.append((title, path.ultimate_configuration, 1.0))
    shapes = [shape.moved(at, by) for _, at, by in views]
    sizes = {"border_mm": 5.0, "below_mm": 8.0, "height_mm": 122.0, "most_mm": 75.0}
    page = sheet(pictures.union([shape, *shapes]), len(views), **sizes)
    for axes, (title, at, by), view in zip(page.panels, views, shapes, strict=True):
        axes.set_title(title)
        pictures.ghost(axes, shape)
        pictures.fill_roles(axes, view)
        parts.draw_ties(page, axes, tie_ends(results, state, at, by))
    parts.movement_arrow(page, page.panels[0], shape, results, known(content.settlement))
    outline = parts.ghost_handle(words.plain("figure.original_outline"))
    page.legend([outline, *parts.tie_handles(results, words, state)], words)
    return page.figure


def draw_synthesis(results: Results, words: Words, settled: str | None, governing: View | None) -> Figure:
    """Draw a settled state, magnified until it shows, beside the mechanism that governs; as drawn without any."""
    shape = outlines(results)
    mechanism = found_mechanism(results, *governing) if governing else None
    at = results.states[settled].configuration if settled else np.zeros((len(shape.centroids), 3))
    times = pictures.magnification(shape, at)
    view = shape.moved(at, times)
    shown = [shape, view, *([mechanism.start, mechanism.swept] if mechanism else [])]
    sizes = {"border_mm": 7.0, "below_mm": 7.0, "height_mm": 76.0, "most_mm": 55.0}
    page = sheet(pictures.union(shown), 2 if mechanism else 1, **sizes)
    axes, handles = page.panels[0], [parts.ghost_handle(words.plain("figure.before"))]
    axes.set_title(words.state(settled or "original") + (f", {_times(times, words)}" if settled else ""))
    if settled:
        pictures.ghost(axes, shape)
    pictures.fill_roles(axes, view)
    if settled:
        parts.draw_ties(page, axes, tie_ends(results, settled, at, times))
        parts.movement_arrow(page, axes, shape, results, known(results.states[settled].settlement))
    if mechanism:
        mechanism.draw(page, page.panels[1], words)
        handles += mechanism_handles([mechanism], words)[1:]
    page.legend(handles, words)
    return page.figure


def draw_overturned(results: Results, words: Words, views: Sequence[View]) -> Figure:
    """Draw states where their capacity ends (d_0, rigid contacts), to true scale over each one's own rest."""
    drawing = outlines(results)
    pushed = [hand_check.rigid_push(results, *view) for view in views]
    starts = [drawing.moved(results.states[name].configuration) for name, _ in views]
    ends = [drawing.moved(rigid.final_configuration) for rigid in pushed]
    page = sheet(pictures.union([*starts, *ends]), len(views), border_mm=7.0)
    for axes, (name, way), start, end, rigid in zip(page.panels, views, starts, ends, pushed, strict=True):
        left = alpha_at_d_0(rigid)
        lost = "" if left is None else f", α = {words.show(left)}"
        axes.set_title(f"{words.state(name)}\nd₀ = {words.told('d_0_m', rigid.d_0_m)}{lost}")
        pictures.ghost(axes, start)
        pictures.fill_roles(axes, end)
        parts.draw_ties(page, axes, tie_ends(results, name, rigid.final_configuration))
        parts.push_arrow(page, axes, end.bounds, way)
    start_outline = parts.ghost_handle(words.plain("figure.start_outline"))
    page.legend([start_outline, *parts.tie_handles(results, words, *(name for name, _ in views))], words)
    return page.figure


def draw_mechanisms(results: Results, words: Words, shown: Sequence[View | GivenMechanism]) -> Figure:
    """Draw mechanisms on the deformed shapes at their activation, hinges and sliding joints marked.

    Of one that the user chose the centres of rotation are marked as hinges.
    """
    views = []
    for each in shown:
        if isinstance(each, GivenMechanism):
            centres, at = [part.about_m for part in known(each.macro_blocks)], results.states[each.state]
            motion = known(each.displacements), centres, known(each.sliding_joints), at.configuration
            way: Direction = known(each.direction)
            views.append(MechanismView(results, (each.state, way), *motion, known(each.met)))
        else:
            views.append(found_mechanism(results, *each))
    bounds = pictures.union([outline for view in views for outline in (view.start, view.swept)])
    page = sheet(bounds, len(views), border_mm=7.0, height_mm=156.0, most_mm=75.0)
    for axes, view in zip(page.panels, views, strict=True):
        view.draw(page, axes, words)
    page.legend(mechanism_handles(views, words), words)
    return page.figure


def mechanism_handles(views: Sequence["MechanismView"], words: Words) -> list[Any]:
    """Return the legend of mechanisms."""
    handles: list[Any] = [
        parts.ghost_handle(words.plain("figure.start_outline")),
        Patch(**MOVED, label=words.plain("figure.moving")),
        key(words.plain("figure.hinge"), **pictures.HINGE),
    ]
    if any(len(view.sliding) for view in views):
        handles.append(key(words.plain("figure.sliding"), **pictures.SLIDING))
    if any(view.ties for view in views):
        handles.append(key(words.plain("figure.tie"), **pictures.TIE))
    return handles


def found_mechanism(results: Results, state: str, direction: Direction) -> "MechanismView":
    """Return the rigid mechanism of a state in a direction, its macro-blocks numbered where they are printed."""
    rigid = hand_check.rigid_push(results, state, direction)
    found = rigid.mechanism
    motion = found.displacements, found.hinge_points_m, found.sliding_joints
    parts = hand_check.macro_blocks(results, state, direction)
    numbered = parts if len(parts) <= hand_check.BY_HAND else ()
    at = rigid.mechanism_configuration
    return MechanismView(results, (state, direction), *motion, at, rigid.frames.met, numbered)


class MechanismView:
    """A mechanism made visible: its displacements scaled to 8 % of the model's size.

    `displacements` (b, 3): virtual ones; `hinges` (n, 2) m; `sliding`: numbers of the joints that slide;
    `configuration` (b, 3): where the blocks are as it begins to move, from the drawing; `met`: pairs of faces, after
    the drawn joints, that touch there and did not as drawn; `numbered`: the macro-blocks of the hand check, whose
    numbers are written into the drawing.
    """

    def __init__(
        self, results: Results, view: View, displacements: Configuration, hinges: Sequence[Point],
        sliding: Sequence[int], configuration: Configuration, met: Sequence[Face],
        numbered: Sequence[hand_check.MacroBlock] = (),
    ) -> None:  # fmt: skip
        self.view, self.macro_blocks = view, numbered
        self.configuration = np.asarray(configuration, dtype=float)
        self.velocity = np.asarray(displacements, dtype=float)
        self.drawing = outlines(results)
        self.start = self.drawing.moved(self.configuration)
        speed = np.linalg.norm(self._rate(self.start.points, self.start.owner), axis=1)
        self.amount = pictures.swept_by(self.start, self.velocity)
        self.swept = self.start.swept(self.velocity, self.amount)
        self.moving = np.bincount(self.start.owner, speed > 1e-4 * speed.max()) > 0
        self.hinges = hinges
        self.ties = ties_of(results, view[0])
        self.tie_ends = tie_ends(results, view[0], self.configuration)
        faces = faces_of(results, met)
        self.sliding = faces.contacts.take(np.array(sliding, dtype=np.intp))
        self.slides = end_points(self.sliding, faces.positions(self.configuration))

    def draw(self, page: Panels, axes: Axes, words: Words) -> None:
        """Draw start outline, displaced blocks, hinges, sliding joints, ties, numbers of macro-blocks, the push."""
        axes.set_title(words.at(*self.view))
        pictures.ghost(axes, self.start)
        pictures.fill(axes, self.swept, np.flatnonzero(~self.moving), "1.0")
        pictures.fill(axes, self.swept, np.flatnonzero(self.moving), pictures.MOVING)
        for owner, slide in zip(self.sliding.a, self.slides, strict=True):
            axes.plot(*self._carried(slide, np.full(2, owner)).T, **pictures.SLIDING)
        ends = zip(self.ties, self.tie_ends, strict=True)
        parts.draw_ties(page, axes, [self._carried(points, np.array(tie.blocks)) for tie, points in ends])
        owner = np.array([self.start.nearest(point) for point in self.hinges], dtype=np.intp)
        hinges = self._carried(np.asarray(self.hinges, dtype=float).reshape(-1, 2), owner)
        axes.plot(*hinges.T, **pictures.HINGE)
        least = LIGHT * sum(each.weight_kN for each in self.macro_blocks)
        for number, whole in enumerate(self.macro_blocks, 1):
            if whole.weight_kN >= least:
                places = self.start.centroids[whole.members]
                away = np.hypot(*(places - places.mean(axis=0)).T)
                nearest = whole.members[int(away.argmin())]
                parts.write_number(axes, str(number), self.swept.centroids[nearest], **BOXED)
        parts.push_arrow(page, axes, self.swept.bounds, self.view[1])

    def _rate(self, points: Array, owner: Any) -> Array:
        return pictures.field(points, owner, self.start.centroids, self.velocity)

    def _carried(self, points: Array, owner: Any) -> Array:
        return points + self.amount * self._rate(points, owner)


def draw_cracks(results: Results, words: Words, state: str, most: int) -> Figure:
    """Draw a settled state, not magnified: its cracks, `most` of them numbered, blocks, and where it was surveyed."""
    drawn, moved = outlines(results), np.asarray(results.states[state].configuration, dtype=float)
    shape = drawn.moved(moved)
    page = sheet(pictures.union([shape]), border_mm=8.0)
    axes = page.panels[0]
    pictures.fill_roles(axes, shape)
    found, named = cracks_of(results, state), list[Array]()  # joints, and where their numbers stand
    middle = np.asarray(shape.bounds).reshape(2, 2).mean(axis=0)
    for place, crack in enumerate(found):  # the face of the second block
        face, owner = np.asarray(results.geometry.joints[crack.joint].ends_m), np.full(2, crack.block_b)
        ends = pictures.place(face, owner, drawn.centroids, moved)
        axes.plot(*ends.T, **CRACK)
        if place < most:  # numbered beyond its end that is farther out, or where no other number is
            inner, outer = sorted(ends, key=lambda end: float(np.hypot(*(end - middle))))
            out = page.paper(3.0) / max(float(np.hypot(*(outer - inner))), 1e-12) * (outer - inner)
            tried = [end + far * out for far in (1.0, 2.0, 3.0) for end, far in ((outer, far), (inner, -far))]
            crowd = [sum((abs(at - to) < page.paper(1.0) * CLEAR_MM).all() for to in named) for at in tried]
            named.append(tried[int(np.argmin(crowd))])
            parts.write_number(axes, f"G{crack.joint}", named[-1], **NUMBER)
    for number, (ring, centroid) in enumerate(zip(shape.rings(shape.every), shape.centroids, strict=True)):
        size = min(LARGEST_PT, ROOM * 1000.0 * hand_check.outline_area(ring) ** 0.5 / page.scale)
        if size >= SMALLEST_PT:
            dark = results.geometry.blocks[number].support is not None
            style: dict[str, Any] = {"fontsize": size, "color": "1.0" if dark else "0.25"}
            parts.write_number(axes, str(number), centroid, **style)
    handles = [key(words.plain("figure.crack"), **CRACK)] if found else []
    for each in surveyed(results, state):
        line = np.asarray(each.line, dtype=float)
        at = pictures.place(line, np.array([drawn.nearest(point) for point in line]), drawn.centroids, moved)
        look, kind = (MEASURED, "measured_crack") if len(line) == 1 else (SURVEYED, "surveyed_crack")
        label = words.plain(f"figure.{kind}")
        axes.plot(*at.T, **look)
        if label not in [handle.get_label() for handle in handles]:
            handles.append(key(label, **look))
        parts.write_number(axes, each.mark, at[len(at) // 2], BESIDE, **NUMBER)
    page.legend(handles, words)
    return page.figure


def draw_identification(results: Results, words: Words) -> Figure:
    """Draw the best movement, magnified until it shows, the measurements marked by their numbers."""
    found = known(results.identification)
    drawn, moved = outlines(results), np.asarray(known(known(best_of(found)).configuration), dtype=float)
    times = pictures.magnification(drawn, moved)
    shape = drawn.moved(moved, times)
    points = np.array([site.point_m for site in found.sites], dtype=float)
    owner = np.array([site.block for site in found.sites], dtype=np.intp)
    marked = points + times * (pictures.place(points, owner, drawn.centroids, moved) - points)
    page = sheet(pictures.union([drawn, shape]), border_mm=8.0)
    axes = page.panels[0]
    axes.set_title(_times(times, words))
    pictures.ghost(axes, drawn)
    pictures.fill_roles(axes, shape)
    axes.plot(*marked.T, **MEASURED)
    for number, point in enumerate(marked, 1):
        parts.write_number(axes, str(number), point, BESIDE, **NUMBER)
    mark = key(words.plain("figure.measurement"), **MEASURED)
    page.legend([parts.ghost_handle(words.plain("figure.original_outline")), mark], words)
    return page.figure


def _times(times: float, words: Words) -> str:
    return words.plain("figure.magnified" if times > 1.0 else "figure.true_scale", times=f"{times:g}")


UNIT_MM = 10.0  # on paper, of a round force
LONGEST = 1.3  # times that, the largest resultant
CROWD = 150  # joints: beyond them marks become finer, so that a wall stays readable
RESULTANT: dict[str, Any] = {"color": "0.45", "linewidth": 0.6}
JOINTS: dict[str, dict[str, Any]] = {  # by condition; a joint that presses as a whole is a plain outline
    "partial": {"color": pictures.INK, "linewidth": 1.2, "linestyle": (0, (1.2, 0.8))},
    "sliding": {"color": pictures.INK, "linewidth": 2.4},
    "idle": {"color": "0.6", "linewidth": 1.0, "linestyle": (0, (0.8, 1.6))},
}


def draw_thrust(results: Results, words: Words, shown: Sequence[Situation]) -> Figure:
    """Draw each situation: resultants as lines as long as they are large, joined through blocks of two joints.

    Joints are marked by their condition (JointStates.condition); a hinge is a circle where the resultant crosses.
    """
    drawing = outlines(results)
    shapes = [drawing.moved(situation.configuration) for situation in shown]
    joints = [joint_states(results, situation) for situation in shown]
    largest = max(float(np.hypot(*states.force.T).max()) for states in joints)
    unit = round_force(largest)
    scale = words.plain("figure.resultant", force=words.comma(f"{unit:g}"), length=f"{UNIT_MM:g}")
    lines = [thrust_lines(states) for states in joints]
    handles: list[Any] = [key(words.plain("figure.thrust"), **pictures.THRUST)] if any(lines) else []
    handles.append(key(scale, **RESULTANT))
    conditions = {each for states in joints for each in states.condition}
    named = [(each, look) for each, look in (*JOINTS.items(), ("edge", pictures.HINGE)) if each in conditions]
    handles += [key(words.plain(f"figure.joint_{each}"), **look) for each, look in named]
    handles += parts.tie_handles(results, words, *(situation.state for situation in shown))
    above = 7.0 if any(situation.direction for situation in shown) else 3.0  # the arrow of the loads
    page = sheet(pictures.union(shapes), len(shown), border_mm=above, height_mm=136.0)
    for axes, situation, shape, states, line in zip(page.panels, shown, shapes, joints, lines, strict=True):
        if situation.direction is None:
            forces = words.plain("figure.at_rest_forces", contacts=situation.contacts)
            axes.set_title(f"{words.state(situation.state)}\n{forces}")
        else:
            push = words.at(situation.state, situation.direction)
            axes.set_title(f"{push}\nα = {words.show(situation.alpha)}")
        pictures.fill_roles(axes, shape)
        fine = min(1.0, (CROWD / len(states.condition)) ** 0.5)
        are = np.array(states.condition)
        for condition, style in JOINTS.items():
            width = style["linewidth"] * fine
            ends = list(states.ends[are == condition])
            axes.add_collection(LineCollection(ends, **(style | {"linewidth": width})))
        half = 0.5 * page.paper(UNIT_MM) / unit * states.force
        resultants = np.stack([states.point - half, states.point + half], axis=1)[are != "idle"]
        axes.add_collection(LineCollection(list(resultants), **RESULTANT))
        axes.add_collection(LineCollection(line, **pictures.THRUST))
        mark = pictures.HINGE | {"markersize": 3.6 * fine, "markeredgewidth": 0.9 * fine}
        axes.plot(*states.point[are == "edge"].T, **mark)
        parts.draw_ties(page, axes, tie_ends(results, situation.state, situation.configuration))
        if situation.direction:
            parts.push_arrow(page, axes, shape.bounds, situation.direction)
    page.legend(handles, words)
    return page.figure


def round_force(largest: float) -> float:
    """Return 1, 2 or 5 times a power of ten, the least of which the largest force is at most `LONGEST` times."""
    least = largest / LONGEST
    power = 10.0 ** math.floor(math.log10(least))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= least * (1.0 - 1e-9))
