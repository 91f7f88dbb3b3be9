"""The exceptions of the mechanics, in the words of the person who has to act on them."""

from __future__ import annotations

import math
from numbers import Integral, Real
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mechanics.messages import Message, SaidError


class MechanicsError(Exception):
    """Base of all errors of this package."""


class ArgumentError(MechanicsError, ValueError):
    """An argument is not what it must be; the message names it."""


class RecordError(MechanicsError, ValueError):
    """A record cannot be read; the message names file and line."""


class UnstableError(MechanicsError, SaidError, ValueError):
    """Gravity alone cannot be carried: no equilibrium exists in this configuration."""


class NoEquilibriumError(MechanicsError, SaidError, ValueError):
    """No equilibrium near a configuration under its loads: a mechanical statement, the end of a path.

    `path`: what a pushdown has followed of it so far, None elsewhere.
    """

    path: object = None


class UnsettledError(NoEquilibriumError):
    """The forces of a step and the geometry in which they act do not come to agree."""


class RunawayError(NoEquilibriumError):
    """Left to itself the structure moves on and does not come to rest: it collapses."""


class CollapseError(NoEquilibriumError):
    """A support cannot make its whole movement: the structure collapses first. `path`: the pushdown so far."""

    def __init__(self, message: Message, path: object) -> None:
        super().__init__(message)
        self.path = path


class ControlError(MechanicsError, SaidError, ValueError):
    """The control point takes no part in the mechanism."""


class ConvergenceError(MechanicsError, SaidError, RuntimeError):
    """A program has, or may have, a solution that no solver found to the required accuracy.

    `path`: as of NoEquilibriumError.
    """

    path: object = None


class DrawingError(MechanicsError, ValueError):
    """The drawing cannot be read as blocks; the message names layer, entity handle and coordinates."""


def require(condition: bool, name: str, value: object, must_be: str) -> None:
    """Raise ArgumentError naming the argument unless the condition holds."""
    if not condition:
        raise ArgumentError(f"{name} = {value!r}: must be {must_be}")


def is_number(value: object) -> bool:
    """Whether a value is a real number and not nan; texts, None and truth values are none."""
    return isinstance(value, Real) and not isinstance(value, bool) and not math.isnan(value)


Ends = Literal["()", "[)", "(]", "[]"]


def is_between(value: object, low: float, high: float, ends: Ends = "()") -> bool:
    """Whether a value is a number between two others; a square bracket of `ends` counts that end in."""
    if not isinstance(value, Real) or not is_number(value):
        return False
    x = float(value)
    return (low <= x if ends[0] == "[" else low < x) and (x <= high if ends[1] == "]" else x < high)


def is_whole(value: object) -> bool:
    """Whether a value is a whole number, of whole type."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def require_positive(of: object, ends: Ends = "()", **must_be: str) -> None:
    """Raise ArgumentError naming the first of some fields that is no number between 0 and infinity: see is_between.

    What a field must be ends with "None" where it may be that too.
    """
    for name, text in must_be.items():
        value = getattr(of, name)
        absent = value is None and text.endswith("None")
        require(absent or is_between(value, 0.0, math.inf, ends), name, value, text)


def point_of(name: str, value: object) -> NDArray[np.float64]:
    """Return the point (2,) m of an argument. Raises ArgumentError naming it if it is none."""
    found, must_be = array_of(name, value, "a point (x, z) in m"), "a point (x, z) in m"
    require(found.shape == (2,) and bool(np.isfinite(found).all()), name, value, must_be)
    return found


def array_of(name: str, value: object, must_be: str) -> NDArray[np.float64]:
    """Return the value of an argument as an array of numbers. Raises ArgumentError naming it if it is none."""
    try:
        found: NDArray[np.float64] = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise ArgumentError(f"{name} = {value!r}: must be {must_be}") from None
    return found
