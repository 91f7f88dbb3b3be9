"""What keeps a drawing from being an assembly: faults with their places, each reported once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from typing import Literal, TypeVar

import numpy as np

from mechanics.errors import DrawingError
from mechanics.messages import Message, message
from mechanics.types import Array

Text = TypeVar("Text", bound=str)

LISTED = 20  # faults of one kind that are listed in full

Kind = Literal["outline", "lines", "layer", "thin", "short", "twice", "frame", "overlap", "floating", "gap"]

Remedy = Literal["", "close", "trim", "delete", "fit"]


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
