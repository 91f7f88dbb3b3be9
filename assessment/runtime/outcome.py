"""What a run came to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Outcome:
    """What a run came to: its results, whether every analysis asked for was completed, and how they were come by.

    `computed`: analyses of this run; `taken`: those of earlier ones whose inputs have not changed.
    """

    results: dict[str, Any]
    complete: bool
    computed: int
    taken: int
