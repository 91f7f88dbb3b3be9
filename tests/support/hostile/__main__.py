"""Tries every hostile input and prints the counts: python -m tests.support.hostile [FACTOR]."""

import sys
import tempfile
import warnings
from collections import Counter
from pathlib import Path

from tests.support.hostile.corpus import KINDS, tried
from tests.support.hostile.named import COMPLETE, REFUSALS


def main() -> None:
    """Print a table of the kinds of input: tried, refused, completed, failed."""
    warnings.simplefilter("ignore")
    factor = float(sys.argv[1]) if len(sys.argv) > 1 else 1.0
    total: Counter[str] = Counter()
    print(f"| {'input':25} | {'tried':>7} | {'refused':>7} | {'completed':>9} | {'failed':>6} |")
    print("| --- | ---: | ---: | ---: | ---: |")
    for name, kind in KINDS.items():
        counts = tried(kind, factor)
        total += counts
        _row(name, counts)
    counts = Counter()
    for make in (REFUSALS | COMPLETE).values():
        with tempfile.TemporaryDirectory() as folder:
            counts["tried"] += 1
            counts[make(Path(folder))] += 1
    _row("named cases", counts)
    _row("all", total + counts)


def _row(name: str, counts: Counter[str]) -> None:
    failed = counts["tried"] - counts["refused"] - counts["completed"]
    print(
        f"| {name:25} | {counts['tried']:7} | {counts['refused']:7} | {counts['completed']:9} | {failed:6} |"
    )


if __name__ == "__main__":
    main()
