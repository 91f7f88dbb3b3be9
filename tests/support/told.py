"""What is told of an analysis before it is finished."""

from __future__ import annotations

import time
from pathlib import Path

from assessment.runtime.progress import Show
from mechanics.progress import tell


class Seen(Show):
    """Lets analyses go on once it was told that they are at work; keeps what it was told."""

    def __init__(self, flag):
        self.flag, self.lines = flag, []

    def begin(self, stage, total, taken, work):
        self.lines.append(("begin", work))

    def reached(self, done):
        self.lines.append(("reached", done))
        self.flag.touch()

    def advance(self, done):
        self.lines.append(("advance", done))


def quarter(flag: str) -> bool:
    """Return whether somebody was told that a quarter is done."""
    for _ in range(600):
        tell(0.25)
        if Path(flag).exists():
            return True
        time.sleep(0.05)
    return False
