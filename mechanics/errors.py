"""The exceptions of the mechanics and the faults of drawings, in the words of the person who has to act on them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from numbers import Integral, Real
from typing import Literal, TypeVar

import numpy as np

from mechanics.messages import Message, SaidError, message
from mechanics.types import Array

Text = TypeVar("Text", bound=str)

LISTED = 20  # faults of one kind that are listed in full

Kind = Literal["outline", "lines", "layer", "thin", "short", "twice", "frame", "overlap", "floating", "gap"]

Remedy = Literal["", "close", "trim", "delete", "fit"]


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


class RunawayError(NoEquilibriumError):
    """Left to itself the structure moves on and does not come to rest: it collapses."""


class CollapseError(NoEquilibriumError):
    """A support cannot make its whole movement: the structure collapses first. `path`: the pushdown so far."""

    def __init__(self, reason: Message, path: object) -> None:
        super().__init__(reason)
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


@dataclass(frozen=True, eq=False)
class Fault:
    """What is wrong: `text` names the entity, where it is and what to do.

    `points` (p, 2) and `lines` (each (n, 2)), m: what a picture marks; none where the fault is at no place. `remedy`:
    what a repair does about it, "" where that is for the user to decide; `handles`: of the entities that it does it to.
    """

    kind: Kind
    text: str
    points: Array = field(default_factory=lambda: np.empty((0, 2)))
    lines: tuple[Array, ...] = ()
    remedy: Remedy = ""
    handles: tuple[str, ...] = ()

    def scaled(self, factor: float) -> Fault:
        """Return the fault with its places multiplied by a factor."""
        return replace(self, points=factor * self.points, lines=tuple(factor * line for line in self.lines))


@dataclass(frozen=True, eq=False)
class Outline:
    """An outline (n, 2), m, of a drawing, for a picture: a block or what was meant as one."""

    points: Array
    layer: str
    closed: bool = True
    support: bool = False


class FaultyDrawingError(DrawingError):
    """A drawing that could be read and is no assembly: its `faults` in the order of their numbers, its `outlines`.

    The message has a line per fault, each with `origin`, the drawing's name, in front; a last line is the `remedy`.
    """

    def __init__(
        self, origin: str, faults: Sequence[Fault], outlines: Sequence[Outline] = (), remedy: str = ""
    ) -> None:
        self.faults, self.outlines = tuple(faults), tuple(outlines)
        lines = [*numbered(faults), *([remedy] if remedy else [])]
        super().__init__("\n".join(f"{origin}: {line}" if origin else line for line in lines))


def numbered(faults: Sequence[Fault]) -> list[str]:
    """Return a line per fault with its number, counted from 1; of one kind those beyond LISTED are only counted."""
    if len(faults) == 1:
        return [faults[0].text]
    lines: list[str] = []
    for _, group in groupby(enumerate(faults, 1), lambda item: item[1].kind):
        of_kind = list(group)
        lines += [f"fault {number}: {fault.text}" for number, fault in of_kind[:LISTED]]
        if rest := of_kind[LISTED:]:
            lines.append(f"and {len(rest)} more of this kind (faults {rest[0][0]} to {rest[-1][0]})")
    return lines


def listed(items: Sequence[Text]) -> list[Text | Message]:
    """Return the items, those beyond `LISTED` being only counted."""
    more = len(items) - LISTED
    rest = [message("and {count} more of this kind", count=more)] if more > 0 else []
    return [*items[:LISTED], *rest]


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


def point_of(name: str, value: object) -> Array:
    """Return the point (2,) m of an argument. Raises ArgumentError naming it if it is none."""
    found, must_be = array_of(name, value, "a point (x, z) in m"), "a point (x, z) in m"
    require(found.shape == (2,) and bool(np.isfinite(found).all()), name, value, must_be)
    return found


def array_of(name: str, value: object, must_be: str) -> Array:
    """Return the value of an argument as an array of numbers. Raises ArgumentError naming it if it is none."""
    try:
        found: Array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise ArgumentError(f"{name} = {value!r}: must be {must_be}") from None
    return found
