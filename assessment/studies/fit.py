"""Least squares: the values of the unknowns that minimise χ² = Σ ((predicted − measured)/σ)², and how sure they are.

Gauss–Newton with central differences and bounds (Nocedal and Wright, Numerical Optimization, 2006, ch. 10); damped
steps (Levenberg–Marquardt) are tried beside the full one, as each is a path of its own and paths run side by side.
Predictions jump and have kinks where hinges move to other joints: a difference across a jump is the jump over its step,
and no slope. So values at a distance along each axis are tried too, nearer where none is better (pattern search: Kolda,
Lewis and Torczon, SIAM Review 45, 2003). Standard errors rest on slopes that two steps on one side of the fit agree on,
and on those beyond kinks.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from mechanics.messages import Message, linked, message
from mechanics.procedures import SupportMovement
from mechanics.types import Array, Mask

COMPONENTS = ("x", "z", "rotation")
WORDS: dict[str, str] = {"x": "x", "z": "z", "rotation": message("rotation")}
PART = 0.1  # of a direction that is not determined: an unknown with more of it has no error
TOGETHER = 3  # unknowns that a direction of the search moves at once; where there are more, pairs


@dataclass(frozen=True)
class Unknowns:
    """The unknown components (support, component) of a hypothesis; `lever` (m): the arc of a rotation of 1 rad.

    Their values u (n,) are lengths, m: of a rotation the arc at the lever. `downward_only`: z is not positive.
    """

    components: tuple[tuple[str, str], ...]
    lever: float
    downward_only: bool

    def __len__(self) -> int:
        return len(self.components)

    @property
    def title(self) -> Message:
        """The hypothesis in words: "right: x, z, rotation"."""
        words = {at: [WORDS[name] for other, name in self.components if other == at] for at in self.supports}
        return linked([message("{name}: {components}", name=at, components=own) for at, own in words.items()])

    @property
    def supports(self) -> tuple[str, ...]:
        """The supports that move."""
        return tuple(dict.fromkeys(support for support, _ in self.components))

    @property
    def size(self) -> Array:
        """Length (n,) of a unit of each unknown: 1 for m, the lever for rad."""
        return np.array([self.lever if name == "rotation" else 1.0 for _, name in self.components])

    @property
    def falling(self) -> Mask:
        """Which unknowns (n,) may not be positive."""
        return np.array([self.downward_only and name == "z" for _, name in self.components])

    def bounded(self, u: Array) -> Array:
        """Return the values within the bounds."""
        return np.where(self.falling, np.minimum(u, 0.0), u)

    def movements(self, u: Array) -> tuple[SupportMovement, ...]:
        """Return the movement of each support at values u (n,), m; of none, 0 has no sign."""
        value = {each: float(v) + 0.0 for each, v in zip(self.components, u / self.size, strict=True)}
        by_support = {each: [value.get((each, name), 0.0) for name in COMPONENTS] for each in self.supports}
        return tuple(SupportMovement(each, (x, z), turn) for each, (x, z, turn) in by_support.items())

    def directions(self) -> list[Array]:
        """Return unit vectors (n,): every sign of one unknown alone and of several together, within the bounds."""
        most = TOGETHER if len(self) <= TOGETHER else 2
        found = []
        for signs in product((0.0, 1.0, -1.0), repeat=len(self)):
            u = np.array(signs)
            if 0 < np.count_nonzero(u) <= most and (self.bounded(u) == u).all():
                found.append(u / np.linalg.norm(u))
        return found


Predict = Callable[[Sequence[Array]], Sequence[Array | None]]
"""Residuals over σ (m,) at each of some values (n,), m, of the unknowns; None: the structure does not survive them."""


@dataclass(frozen=True)
class FitTolerances:
    """Tolerances of the fit; shares are of the movement."""

    difference: float = 0.01  # share: of finite differences, at least `least` (m)
    least: float = 1e-6
    reach: float = 0.25  # share: first distance of the pattern search, which ends at that of the differences
    rounds: int = 40  # of it, at most
    dampings: tuple[float, ...] = (0.0, 1e-2, 1.0)  # of the trial steps, over the largest curvature
    gain: float = 1e-6  # of χ², or of `exact` where it is less, below which a step has none
    exact: float = 1e-2
    smooth: float = 0.1  # of slopes over two successive steps, by which they may differ
    linear: float = 0.5  # of what is predicted within a standard error, in σ, from its linear part


FIT = FitTolerances()


@dataclass(frozen=True, eq=False)
class Fit:
    """The best values `u` (n,), m; `residual` (m,) over σ; `slopes` (m,), 1/m, of each unknown, two at a kink."""

    u: Array
    residual: Array
    slopes: tuple[tuple[Array, ...], ...]
    stopped: bool  # whether a step towards a better fit ended where the structure does not survive

    @property
    def chi_squared(self) -> float:
        """Sum of the squared residuals over σ."""
        return float(self.residual @ self.residual)


def best_length(share: Array, residual: Array) -> tuple[float, float]:
    """Return the share of a path (`share` (k,), `residual` (k, m), linear between) at which χ² is least, and χ²."""
    if len(share) < 2:
        return float(share[0]), float(residual[0] @ residual[0])
    start, change = residual[:-1], np.diff(residual, axis=0)
    slope = np.einsum("km,km->k", change, change)
    along = np.einsum("km,km->k", start, change)
    part = np.clip(-along / np.where(slope > 0.0, slope, 1.0), 0.0, 1.0)
    squares = np.sum((start + part[:, None] * change) ** 2, axis=1)
    k = int(np.argmin(squares))
    return float(share[k] + part[k] * (share[k + 1] - share[k])), float(squares[k])


def refined(unknowns: Unknowns, start: Array, residual: Array, predict: Predict, measured: float) -> Fit:
    """Return the fit near `start` (n,), m, of given residuals over σ (m,); open `_directions` stay."""
    u, stopped, radius = start, False, FIT.reach * float(np.linalg.norm(start))
    axes, newton = np.eye(len(u)), _newton(unknowns, u, residual, predict, measured)
    for _ in range(FIT.rounds):
        if not newton and radius <= _difference(u):
            break
        trials = [unknowns.bounded(u + step) for step in [*newton, *radius * axes, *-radius * axes]]
        found = predict(trials)
        if newton:
            stopped = any(each is None for each in found[: len(newton)])
        squares = [np.inf if each is None else float(each @ each) for each in found]
        best = int(np.argmin(squares))
        if float(residual @ residual) - squares[best] < FIT.gain * max(squares[best], FIT.exact):
            newton, radius = [], 0.5 * radius  # nothing better so far away
            continue
        u, residual = trials[best], np.asarray(found[best])
        newton = _newton(unknowns, u, residual, predict, measured)
    return Fit(u, residual, _slopes(unknowns, u, residual, predict), stopped)


def _newton(unknowns: Unknowns, u: Array, residual: Array, predict: Predict, measured: float) -> list[Array]:
    """Return steps x (n,), m, within bounds of least |J x + r|² + s₁² (damping |x|² + |V x|²), V: what is open."""
    from scipy.optimize import lsq_linear  # late: few runs fit, and it takes long to import

    jacobian, most = _jacobian(unknowns, u, residual, predict), np.where(unknowns.falling, -u, np.inf)
    (s1, *_), right, open_ = _directions(u, jacobian, measured)
    held = [s1 * np.vstack([np.sqrt(each) * np.eye(len(u)), right[open_]]) for each in FIT.dampings]
    target = np.append(-residual, np.zeros(len(held[0])))
    rows = [np.vstack([jacobian, each]) for each in held]
    return [lsq_linear(each, target, (-np.inf, most), method="bvls").x for each in rows]


def _jacobian(unknowns: Unknowns, u: Array, residual: Array, predict: Predict) -> Array:
    """Return the derivatives (m, n), 1/m, by central differences; one-sided at a bound, or where one side falls."""
    steps = _difference(u) * np.eye(len(u))
    sides = [np.array([unknowns.bounded(u + step), unknowns.bounded(u - step)]) for step in steps]
    found = predict([side for pair in sides for side in pair])
    columns = []
    for k, pair in enumerate(sides):
        known = [
            (float(side[k] - u[k]), each)
            for side, each in zip(pair, found[2 * k : 2 * k + 2], strict=True)
            if each is not None and side[k] != u[k]
        ]
        if len(known) == 2:
            columns.append((known[0][1] - known[1][1]) / (known[0][0] - known[1][0]))
        elif known:
            columns.append((known[0][1] - residual) / known[0][0])
        else:
            columns.append(np.zeros_like(residual))
    return np.array(columns).T


def _difference(u: Array) -> float:
    return max(FIT.difference * float(np.linalg.norm(u)), FIT.least)


def _slopes(unknowns: Unknowns, u: Array, residual: Array, predict: Predict) -> tuple[tuple[Array, ...], ...]:
    """Return the slopes (m,), 1/m, of each unknown on either side of `u` (n,); where both agree, their mean alone.

    A side whose slopes over two successive steps differ has a jump or a kink in the first one: where the other side has
    none it is left out; where it has one too, the slopes of the second steps count.
    """
    size = _difference(u)
    steps = [
        (k, sign, np.array([unknowns.bounded(u + n * sign * size * unit) for n in (1, 2)]))
        for k, unit in enumerate(np.eye(len(u)))
        for sign in (1.0, -1.0)
    ]
    found = predict([value for *_, pair in steps for value in pair])
    smooth: list[list[Array]] = [[] for _ in u]
    beyond: list[list[Array]] = [[] for _ in u]
    for (k, sign, pair), first, second in zip(steps, found[::2], found[1::2], strict=True):
        if first is None or pair[0][k] == u[k]:
            continue
        near = (first - residual) / (sign * size)
        far = near if second is None else (second - first) / (sign * size)
        (smooth if _alike(near, far) else beyond)[k].append(far)
    return tuple(_distinct(sides or others, residual) for sides, others in zip(smooth, beyond, strict=True))


def _alike(one: Array, other: Array) -> bool:
    largest = max(np.linalg.norm(one), np.linalg.norm(other))
    return bool(np.linalg.norm(one - other) <= FIT.smooth * largest)


def _distinct(sides: list[Array], residual: Array) -> tuple[Array, ...]:
    """Return the slopes (m,) of the sides, the flatter one first, or their mean; of none, those of no effect."""
    if not sides:
        return (np.zeros_like(residual),)
    if len(sides) == 2 and _alike(sides[0], sides[1]):
        return (0.5 * (sides[0] + sides[1]),)
    return tuple(sorted(sides, key=lambda slope: float(np.linalg.norm(slope))))


def over_kinks(unknowns: Unknowns, fit: Fit, error: Array, predict: Predict) -> tuple[Mask, Fit]:
    """Return where the prediction has a kink within a standard error (n,), m, below and above (n, 2), and the fit.

    There it departs by more than `linear` from its linear part; the fit has the slopes beyond such a kink too. Unknowns
    without an error, and movements that the structure does not survive, have none.
    """
    found, slopes = np.zeros((len(error), 2), dtype=bool), [list(each) for each in fit.slopes]
    known = np.flatnonzero(np.isfinite(error))
    ends = [
        (k, side, [unknowns.bounded(fit.u + n * sign * error[k] * np.eye(len(error))[k]) for n in (1, 2)])
        for k in known
        for side, sign in enumerate((-1.0, 1.0))
    ]
    shown = predict([end for *_, pair in ends for end in pair])
    for (k, side, (end, farther)), at, beyond in zip(ends, shown[::2], shown[1::2], strict=True):
        far, on = end[k] - fit.u[k], farther[k] - end[k]
        if at is None or far == 0.0:
            continue
        departs = min(np.linalg.norm(at - fit.residual - far * slope) for slope in fit.slopes[k])
        found[k, side] = departs > FIT.linear
        if found[k, side] and beyond is not None and on != 0.0:
            slopes[k].append((beyond - at) / on)
    lengths = [sorted(each, key=lambda slope: float(np.linalg.norm(slope))) for each in slopes]
    return found, replace(fit, slopes=tuple(tuple(each) for each in lengths))


def _directions(u: Array, jacobian: Array, measured: float) -> tuple[Array, Array, Mask]:
    """Return singular values (n,), 1/m, and vectors (n, n) of derivatives (m, n), and which are open (`sureness`)."""
    _, s, right = np.linalg.svd(jacobian, full_matrices=True)
    s = np.concatenate([s, np.zeros(len(u) - len(s))])
    return s, right, s * max(float(np.linalg.norm(u)), measured) < 1.0


@dataclass(frozen=True, eq=False)
class Sureness:
    """Standard errors `error` (n,) m, infinite where not determined; `open` (d, n): unit vectors not determined."""

    error: Array
    open: Array


def sureness(fit: Fit, measured: float) -> Sureness:
    """Return standard errors from (JᵀJ)⁻¹, and the directions that the measurements leave open.

    A direction is open where its standard error is longer than the whole movement and than the largest `measured`
    displacement (m); unknowns with more than PART in one have no error. Of all combinations of slopes the largest
    error holds.
    """
    found = [_sureness(fit, np.array(each).T, measured) for each in product(*fit.slopes)]
    return Sureness(np.max([error for error, _ in found], axis=0), found[0][1])


def _sureness(fit: Fit, jacobian: Array, measured: float) -> tuple[Array, Array]:
    """Return standard errors (n,), m, and open directions (d, n) of derivatives (m, n), 1/m."""
    s, right, open_ = _directions(fit.u, jacobian, measured)
    variance = np.sum((right[~open_] / s[~open_, None]) ** 2, axis=0)
    touched = (abs(right[open_]) > PART).any(axis=0)
    return np.where(touched, np.inf, np.sqrt(variance)), right[open_]
