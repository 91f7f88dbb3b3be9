"""Pushover: the multiplier of lateral loads against the displacement of a control point (paper, §4, eqs 4 and 5)."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mechanics.errors import (
    ControlError,
    ConvergenceError,
    NoEquilibriumError,
    UnstableError,
    array_of,
    is_number,
    require,
)
from mechanics.messages import Message, message
from mechanics.model.assembly import Assembly, Behaviour, Direction, State
from mechanics.model.contacts import Contacts
from mechanics.pictures import draw_curve, film
from mechanics.procedures.limit_analysis import farthest_corner, limit_analysis
from mechanics.procedures.model_check import check_path
from mechanics.procedures.path_start import START, no_way_from_rest
from mechanics.procedures.push_path import PUSHOVER, PushInput, PushoverTolerances, PushPath
from mechanics.procedures.step_control import Bisection, follow
from mechanics.program import Certificate
from mechanics.steps.static_step import Equilibrium
from mechanics.steps.static_system import Sliding, StaticSystem, static_system
from mechanics.types import Array

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class Pushover:
    """A capacity curve from a state's own equilibrium.

    `displacement` (k,) m of the `control` point, a drawn point (2,) m of the `block` of that number, positive along the
    push; `multiplier` (k,); `states` of each point; `steps`: the equilibria of the points (rigid joints: none at the
    onset); `certificates` of every point. `reached_zero`: whether the last point has α = 0; `lost`: whether the curve
    ends because no equilibrium lies beyond its last point; `end`: why it ends; `crossed` (n, 2) m: displacements
    between which a part moves by itself, until other blocks hold it again. `formed`: index of the point of the
    mechanism, the first from the peak on in which the control point moves; `mechanism` (b, 3): its virtual
    displacements; `forces` (j, 3): N, P and T of the `contacts` there, kN and kNm. `sliding`: whether what slides lifts
    ("associative") or not ("coulomb"); `lifting`: number of points solved with a dilation where the latter was not;
    `dropped` (n, 2): displacements (m) and multipliers of those replaced or left out, as limit analysis has less in
    their states. Of the `model`, pushed in a `direction`. `peak`: index of the first point of the largest multiplier,
    or that is no less than `alpha_0`: the largest multiplier that, held, does not fell the structure, where that is
    less (α_0 of results with rigid joints, α_u with elastic ones). In a settled state the onset may be a local motion
    that closes a hinge of the settlement: the multiplier then rises before it falls.
    """

    control: Array
    block: int
    displacement: Array
    multiplier: Array
    states: tuple[State, ...]
    steps: tuple[Equilibrium, ...]
    certificates: tuple[Certificate, ...]
    reached_zero: bool
    lost: bool
    end: Message
    crossed: Array
    mechanism: Array
    formed: int
    forces: Array
    contacts: Contacts
    sliding: Sliding
    lifting: int
    dropped: Array
    model: Assembly
    direction: Direction
    peak: int
    alpha_0: float

    @property
    def alpha_onset(self) -> float:
        """The first multiplier: rigid joints begin to move by it, as `limit_analysis` of the state has it."""
        return float(self.multiplier[0])

    def __repr__(self) -> str:
        at = 1000.0 * self.displacement[[self.peak, -1]]
        end = 0.0 if self.reached_zero else self.multiplier[-1]
        return (
            f"Pushover({self.direction}, {len(self.multiplier)} points, α_onset = {self.alpha_onset:.4g}, "
            f"α_0 = {self.alpha_0:.4g} at {at[0]:.4g} mm, ends at {at[1]:.4g} mm with α = {end:.3g})"
        )

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the curve with α_0, and d_0 where α vanishes or equilibrium ends; return the matplotlib axes."""
        d = 1000.0 * self.displacement
        marks = {"α_0": (float(d[self.peak]), self.alpha_0)}
        if self.reached_zero or self.lost:
            marks["d_0"] = (float(d[-1]), float(self.multiplier[-1]))
        labels = ("displacement of the control point [mm]", "multiplier α")
        return draw_curve(d, self.multiplier, marks, labels, self.direction, axes)

    def animate(self, interval: float = 0.05) -> FuncAnimation:
        """Return the points of the curve as a film, one each `interval`, s; `.save("push.gif")` writes it."""
        shapes = [self.model.shape.moved(self.model.displaced(state)) for state in self.states]
        points = zip(1000.0 * self.displacement, self.multiplier, strict=True)
        return film(shapes, self.model.shape, [f"d = {d:.4g} mm, α = {a:.4g}" for d, a in points], interval)

    def to_frame(self) -> pd.DataFrame:
        """Return the points of the curve as a table: displacement (m) and multiplier."""
        import pandas as pd  # late: only tables need it

        return pd.DataFrame({"displacement_m": self.displacement, "multiplier": self.multiplier})


def pushover(
    model: Assembly,
    control: ArrayLike | None = None,
    direction: Direction = "+x",
    contacts: Behaviour = "rigid",
    increment: float = 0.001,
    state: State | None = None,
    until: float = 0.0,
    sliding: Sliding = "coulomb",
    tolerances: PushoverTolerances = PUSHOVER,
) -> Pushover:
    """Push the assembly over, from the onset of its mechanism (rigid joints) or from rest (elastic) to α = 0.

    `control`: drawn point (2,) m in or on a block; default the corner that goes farthest along the push in the first
    mechanism; `increment`: step of its displacement along the push, m; `state`: where the push begins, default as
    drawn; `until`: share of the peak at which the curve ends.

    Every point is an equilibrium in its own displaced geometry: the multiplier is free, and the lateral loads do a
    given work (eq. 5; with elastic joints the same program follows the curve through its peak). If no equilibrium lies
    near, the blocks are released with that work held constant; at α = 0 they are released under gravity, but for a
    structure pushed as drawn whose control point moves: its capacity is spent, whatever it falls on. If they come
    to rest, the curve goes on (with rigid joints at the multiplier that moves them again; with elastic ones, past its
    peak, at the largest load so far). If they do not, or fall back behind an earlier jump, or α jumps below zero, the
    structure has collapsed: the last equilibrium before is located.

    Raises UnstableError if the state cannot stand, ArgumentError for a control point outside every block, ControlError
    for one that takes no part in the mechanism, NoEquilibriumError if the load meets no mechanism.
    """
    # nine arguments: the public function of the package, called with keywords
    Assembly.check(model)
    require(is_number(increment) and 0.0 < increment < np.inf, "increment", increment, "positive, in m")
    require(is_number(until) and 0.0 <= until < 1.0, "until", until, "a share of the peak")
    system = static_system(model, contacts, sliding)
    if control is not None:
        point = array_of("control", control, "a point (x, z) in m")
        return _result(_followed(PushInput(point, direction, increment, until, tolerances), system, state))
    first = PushInput(_first_to_move(system, direction, state), direction, increment, until, tolerances)
    curve = _followed(first, system, state)
    try:
        return _result(curve, along=True)
    except ControlError:  # another part moves farther on: the curve is of what goes farthest
        begun, moved = curve.points[curve.descent].step.state.positions, curve.last.positions
        point, _ = farthest_corner(model, begun, moved, direction)
        return _result(_followed(replace(first, control=point), system, state))


def _followed(push: PushInput, system: StaticSystem, state: State | None) -> PushPath:
    """Return a curve followed to its end."""
    curve = PushPath(push, system, state)
    follow(curve, Bisection(push.increment, curve.first.share * push.increment))
    if curve.system.rigid:
        curve.locate_peak()
    return curve


def _first_to_move(system: StaticSystem, direction: Direction, state: State | None) -> Array:
    """Return the drawn corner (2,), m, that goes farthest along the push in the first mechanism of rigid joints.

    The highest one where the load meets no mechanism, or elastic joints hold a state that rigid ones would not. Raises
    UnstableError if a state of rigid joints cannot stand.
    """
    model, held = system.model, () if system.rigid else (UnstableError,)
    begun = model.starting(state).positions
    moved = begun + np.where(model.movable[:, None], [1.0, 0.0, 0.0], 0.0)
    with suppress(NoEquilibriumError, ConvergenceError, *held):
        moved = begun + 1e-6 * model.size * limit_analysis(model, direction, state, system.sliding).mechanism
    return farthest_corner(model, begun, moved, direction)[0]


def _result(curve: PushPath, along: bool = False) -> Pushover:
    """Return the curve; raise ControlError if its control point takes no part (see PushPath.goes_over)."""
    assert curve.end is not None
    alone = len(curve.points) == 1
    if alone and curve.endless:
        raise NoEquilibriumError(curve.end)
    # it ends as it rises, and joints are compressed by hardly more than rounding
    hidden = curve.model.rounding > START.resolved and curve.alpha >= curve.largest
    if not curve.system.rigid and curve.drawn and (alone or hidden):
        raise no_way_from_rest(curve.model, curve.end)
    if alone or not curve.goes_over(along):
        raise ControlError(message(
            "control = {point} takes no part in the mechanism along {direction}, "
            "or the increment is too large: {reason}",
            point=str(tuple(curve.push.control.tolist())), direction=curve.push.direction, reason=curve.end,
        ))  # fmt: skip
    peak, alpha_0 = curve.peak_that_counts()
    equilibria = [point.step for point in curve.points]
    steps = equilibria[1:] if curve.system.rigid else equilibria
    check_path(steps)
    formed, mechanism = _mechanism(curve, peak)
    return Pushover(
        curve.push.control, curve.block, curve.displacement, curve.multiplier,
        tuple(step.state for step in equilibria), tuple(steps), tuple(step.certificate for step in equilibria),
        curve.reached, curve.lost, curve.end, np.array(curve.crossed).reshape(-1, 2), mechanism, formed,
        equilibria[formed].forces, equilibria[formed].contacts, curve.system.sliding,
        sum(step.lifting for step in equilibria), np.array(curve.dropped).reshape(-1, 2), curve.model,
        curve.push.direction, peak, alpha_0,
    )  # fmt: skip


def _mechanism(curve: PushPath, peak: int) -> tuple[int, Array]:
    """Return the point at which the mechanism of a peak forms, and its displacements (b, 3)."""
    little = 1e-6 * curve.model.size
    for point in range(peak, len(curve.points)):
        mechanism, at = _mechanism_at(curve, point), curve.points[point].step.state.positions
        moved = at + little / float(abs(mechanism[:, :2]).max()) * mechanism
        if curve.along(moved) - curve.along(at) >= curve.tolerances.still * little:
            return point, mechanism
    return peak, _mechanism_at(curve, peak)


def _mechanism_at(curve: PushPath, point: int) -> Array:
    """Return virtual displacements (b, 3) at a point: with elastic joints those of the step from it."""
    if curve.system.rigid and point == 0:
        return curve.first.rate
    limit = curve.limit_at(point, curve.model) if curve.system.rigid else None
    if limit is not None:
        return limit.mechanism
    begin = min(point, len(curve.points) - 2)
    one, two = (each.step.state.positions for each in curve.points[begin : begin + 2])
    return two - one
