"""`assesto benchmark`: measures, and writes tables (CSV) and a summary."""

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from assessment.benchmark import motions, statics
from assessment.benchmark.measure import Row, as_csv, load, machine, table
from assessment.runtime.console import say
from assessment.runtime.errors import nearest
from assessment.runtime.files import write_atomically


@dataclass(frozen=True)
class Benchmark:
    """What is measured, `about` in a sentence, its `rows`, and how table shows them."""

    about: str
    rows: Callable[[bool], Iterator[Row]]
    index: str = ""
    across: str = ""
    cells: str = ""


BENCHMARKS = {
    "statics": Benchmark(
        "relative error; time as a ratio to PIQP once a step. Increments are multiples of the template's.",
        statics.statics, "case quantity", "value", "error ratio",
    ),
    "dynamics": Benchmark(
        "relative error of the largest displacement; time as a ratio to PIQP once a step.",
        motions.dynamics, "case way", "value", "error ratio",
    ),
    "ensembles": Benchmark(
        "least, median and largest displacement (mm) of members at amplitudes within 1 %; ms a step; how many fall.",
        motions.ensembles, "case way", "value", "least median most step_ms collapsed",
    ),
    "steps": Benchmark(
        "a step of 5 ms of a time history, over 7 s of strong motion; as walls grow, and the exponent over blocks.",
        motions.steps, "case blocks joints contacts way step_ms ratio programs_per_step iterations_per_step failed",
    ),
    "walls": Benchmark("limit analysis of running-bond walls; the ratio is to one PIQP solve.", statics.walls),
    "chain": Benchmark(
        "static analyses one by one, together, on all processors; whole commands.",
        statics.chain, "case steps seconds ratio elapsed_s failed",
    ),
    "sliding": Benchmark(
        "where rigid curves end, by both laws, by variants that may not matter, then by multiples of the increment.",
        statics.sliding,
    ),
}  # fmt: skip


def benchmark(names: Sequence[str], quick: bool, folder: Path) -> None:
    """Measure what is named (nothing: all), print tables, write the files. Raises ValueError for another name."""
    for name in names:
        if name not in BENCHMARKS:
            raise ValueError(f"benchmark: {name}: no such benchmark; {nearest(name, BENCHMARKS)}")
    summary = [machine()]
    say(summary[0])
    for name in names or BENCHMARKS:
        chosen = BENCHMARKS[name]
        rows = []
        for row in chosen.rows(quick):  # each named on a terminal as soon as it is measured
            rows.append(row)
            if sys.stderr.isatty():
                print(f"\r\033[K{name}: {row['case']}", end="", file=sys.stderr, flush=True)
        if sys.stderr.isatty():
            print("\r\033[K", end="", file=sys.stderr, flush=True)
        write_atomically(folder / f"{name}.csv", as_csv(rows))
        part = [f"**{name}**: {chosen.about}"]
        for parameter in dict.fromkeys(row.get("parameter", "") for row in rows):
            some = [row for row in rows if row.get("parameter", "") == parameter]
            shown = table(some, chosen.index.split(), chosen.across, chosen.cells.split())
            part.append(f"{parameter}:\n\n{shown}" if parameter else shown)
        say("\n" + "\n\n".join(part))
        summary += part
    summary.append(f"Load {load()} at the end.")
    write_atomically(folder / "summary.md", ("\n\n".join(filter(None, summary)) + "\n").encode())
