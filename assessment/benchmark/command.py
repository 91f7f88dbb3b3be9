"""`assesto benchmark`: measures, and writes tables (CSV), plots (SVG) and a summary."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Generic, TypeVar

from assessment.benchmark.cases import (
    app,
    campaigns,
    chain,
    dynamics,
    ensembles,
    skips,
    sliding,
    statics,
    steps,
    walls,
)
from assessment.benchmark.machine import load, machine
from assessment.benchmark.plots import shown, work_precision
from assessment.benchmark.table import Column, Precision, Row, as_csv, listed, number, percent, pivoted
from assessment.report.figures.style import save_png, save_svg
from assessment.runtime.errors import nearest
from assessment.runtime.files.atomic_files import write_atomically
from assessment.runtime.terminal.console import say

SUMMARY = "summary.md"


Kind = TypeVar("Kind", bound=Row)


@dataclass(frozen=True)
class Benchmark(Generic[Kind]):
    """What is measured, `about` in a sentence, the `rows`, and how they are shown in the summary.

    `series`: field of the rows, which are Precision, by which its plots have lines; empty: no plots.
    """

    about: str
    rows: Callable[[bool], Iterator[Kind]]
    show: Callable[[Sequence[Kind]], str]
    series: str = ""


def benchmark(names: Sequence[str], quick: bool, folder: Path) -> None:
    """Measure what is named (nothing: everything), print each table as soon as it is there, and write the files.

    Raises ValueError for a name that there is none of.
    """
    for name in names:
        if name not in BENCHMARKS:
            raise ValueError(f"benchmark: {name}: no such benchmark; {nearest(name, BENCHMARKS)}")
    summary = [machine()]
    say(summary[0])
    for name in names or BENCHMARKS:
        chosen = BENCHMARKS[name]
        rows = list(_named(name, chosen.rows(quick)))
        write_atomically(folder / f"{name}.csv", as_csv(rows))
        for parameter in dict.fromkeys(row.parameter for row in rows) if chosen.series else ():
            some = [row for row in rows if row.parameter == parameter]
            plot = partial(work_precision, some, chosen.series)
            save_svg(plot, folder / f"{name}-{parameter.split()[0]}.svg")
            save_png(plot, folder / f"{name}-{parameter.split()[0]}.png")
        summary.append(f"**{name}**: {chosen.about}\n\n{chosen.show(rows)}")
        say(f"\n{summary[-1]}")
    summary.append(f"Load {load()} at the end.")
    write_atomically(folder / SUMMARY, ("\n\n".join(summary) + "\n").encode())


def _named(name: str, rows: Iterator[Kind]) -> Iterator[Kind]:
    """The rows, each named on a terminal as soon as it is measured."""
    for row in rows:
        if sys.stderr.isatty():
            print(f"\r\033[K{name}: {row.case}", end="", file=sys.stderr, flush=True)
        yield row
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr, flush=True)


def by_parameter(index: Sequence[str]) -> Callable[[Sequence[Precision]], str]:
    """A table for each parameter: error and ratio to PIQP once a step, over its values; the program's own in bold."""

    def show(rows: Sequence[Precision]) -> str:
        tables = []
        for parameter in dict.fromkeys(row.parameter for row in rows):
            some = [row for row in rows if row.parameter == parameter]
            tables.append(f"{parameter}:\n\n" + pivoted(some, index, ["value"], _value, _error_and_ratio))
        return "\n\n".join(tables)

    return show


def _value(row: Precision) -> str:
    times = "× " if row.parameter == "increment" else ""
    text = f"{times}{shown(row.value)}"
    return f"**{text}**" if row.default else text


def _error_and_ratio(row: Precision) -> str:
    return "fails" if row.failed is not None else f"{percent(row.error)}; {number(row.ratio)}"


def plain(*columns: Column) -> Callable[[Sequence[Row]], str]:
    """A line for each row."""
    return lambda rows: listed(rows, columns)


def _dissipation(rows: Sequence[dynamics.Dissipation]) -> str:
    return pivoted(
        rows,
        ["case"],
        ["integrator", "step_s"],
        lambda row: f"{row.integrator}, {1e3 * row.step_s:g} ms",
        lambda row: f"{100 * row.dissipated:.3g} ({100 * row.by_integrator:.3g})",
    )


def _collapse(rows: Sequence[dynamics.Collapse]) -> str:
    return pivoted(
        rows,
        ["case", "integrator"],
        ["step_s"],
        lambda row: f"{1e3 * row.step_s:g} ms",
        _least_amplitude,
    )


def _least_amplitude(row: dynamics.Collapse) -> str:
    if row.failed is not None:
        return "fails"
    if row.members == 1:
        return f"{row.collapse_g:.3f} g"
    three = " – ".join(f"{level:.3f}" for level in (row.first_g, row.collapse_g, row.all_g))
    return f"{three} g; {row.share * row.members:.0f} of {row.members}"


CASE: Column = ("case", "case", str)
RATIO: Column = ("ratio", "ratio", number)
SECONDS: Column = ("seconds", "processor time, s", number)
CHAIN_COLUMNS: tuple[Column, ...] = (
    CASE,
    ("steps", "steps", str),
    ("attempts", "attempts", str),
    ("unsolved", "unsolved", str),
    SECONDS,
    RATIO,
    ("elapsed_s", "elapsed, s", number),
    ("failed", "fails", str),
)
STEP_COLUMNS: tuple[Column, ...] = (
    CASE,
    ("blocks", "blocks", str),
    ("joints", "joints", str),
    ("contacts", "contacts", str),
    ("integrator", "integrator", str),
    ("step_ms", "step, ms", number),
    ("march_ms", "of it compiled", number),
    ("piqp_ms", "PIQP, ms", number),
    RATIO,
    ("programs_per_step", "programs", number),
    ("iterations_per_step", "iterations", number),
    ("failed", "fails", str),
)

BENCHMARKS: dict[str, Benchmark[Any]] = {
    "statics": Benchmark(
        "relative error; and processor time as a ratio to PIQP once a step. Increments are "
        "multiples of the template's, segments those of a joint, tolerances those of PIQP.",
        statics.statics,
        by_parameter(("case", "quantity")),
        "quantity",
    ),
    "dynamics": Benchmark(
        "relative error of the largest displacement, of the swinging column of its period; processor time as a ratio "
        "to PIQP once a step. Free rocking and the column have closed forms, the others are compared with themselves "
        "refined.",
        dynamics.dynamics,
        by_parameter(("case", "integrator")),
        "integrator",
    ),
    "ensembles": Benchmark(
        "motions that converge as distributions only, of many impacts, or on stiff joints until they collapse: least, "
        "median and largest of nine members (second order with rigid joints, the triumphal arch: five) at amplitudes "
        "within 1 %, and processor time of a step; the resolved median, and how sure it is.",
        ensembles.ensembles,
        ensembles.summed_up,
        "way",
    ),
    "dissipation": Benchmark(
        "energy that a cycle of rocking takes, per cent of that at release, and of it by the integrator "
        "(block 0.17 × 1.0 m released at 0.64 of its slenderness; Housner's impacts take 15.8).",
        lambda quick: dynamics.dissipation((0.005, 0.002)) if quick else dynamics.dissipation(),
        _dissipation,
    ),
    "collapse": Benchmark(
        "least amplitude that collapses one, most and all of five members at amplitudes within 1 %, of the buttressed "
        "arch with elastic joints, to 2 %, and how many collapse at the second; and a stack of two rigid blocks under "
        "one sine of half a second, to half a per cent (it falls at 0.571 g).",
        lambda quick: dynamics.collapse((0.01,)) if quick else dynamics.collapse(),
        _collapse,
    ),
    "steps": Benchmark(
        "a step of 5 ms of a time history, in the mean over 7 s of strong motion, elapsed: of every 20 steps, and of "
        "each program of PIQP, the quickest of six rounds or more.",
        steps.steps,
        plain(*STEP_COLUMNS),
    ),
    "growth": Benchmark(
        "the same as walls grow, and the exponent of its time over the number of blocks.",
        steps.growth,
        plain(*STEP_COLUMNS),
    ),
    "walls": Benchmark(
        "limit analysis of running-bond walls, self-weight check included; the ratio is to one PIQP solve.",
        walls.walls,
        plain(
            CASE,
            ("blocks", "blocks", str),
            ("joints", "joints", str),
            SECONDS,
            RATIO,
            ("memory_MB", "memory, MB", number),
            ("alpha", "α_0", lambda value: f"{value:.6f}"),
            ("certificate", "residual", number),
            ("error", "from HiGHS", number),
            ("highs_s", "HiGHS, s", number),
        ),
    ),
    "chain": Benchmark(
        "pushdown and pushover, rigid and elastic, both states and directions, on one processor, then on all, "
        "as whole commands are. Attempts at a step, and those that were not solved: the step was halved then. Each "
        "analysis is in the CSV.",
        chain.chain,
        lambda rows: listed([row for row in rows if row.whole], CHAIN_COLUMNS),
    ),
    "campaigns": Benchmark(
        "searches of the level at collapse of an arch, elapsed: motions a minute, and what a combination takes as a "
        "ratio to this process alone; the least is one over the number of cores in use, or of workers simulated. A "
        "search waits for that of its neighbour, in whose bracket it begins; what is sent and returned is that of a "
        "combination.",
        campaigns.campaigns,
        plain(
            CASE,
            ("combinations", "combinations", str),
            ("motions", "motions", str),
            ("motions_per_minute", "motions a minute", number),
            ("ratio", "ratio", number),
            ("ideal", "least", number),
            ("sent_kB", "sent, kB", number),
            ("returned_kB", "returned, kB", number),
            ("equal", "results equal", str),
        ),
    ),
    "sliding": Benchmark(
        "capacity curves of rigid joints by both laws of sliding: α_0, and where they end by twelve variants that may "
        "not matter: five increments, corners moved by rounding, other units of length and weight, another origin; "
        "then by multiples of the increment, four each, whose corners are moved by rounding.",
        sliding.sliding,
        plain(
            CASE,
            ("law", "sliding", str),
            ("factor", "increment", lambda value: f"× {value:g}"),
            ("alpha", "α_0", lambda value: f"{value:.5f}"),
            ("least_m", "least end, m", lambda value: f"{value:.5f}"),
            ("median_m", "median", lambda value: f"{value:.5f}"),
            ("most_m", "largest", lambda value: f"{value:.5f}"),
            ("variants", "variants", str),
            ("not_solved", "not solved", str),
            SECONDS,
        ),
    ),
    "app": Benchmark(
        "what who works in the page waits for, elapsed: median and largest.",
        app.latencies,
        plain(
            CASE,
            ("what", "waits for", str),
            ("seconds", "median, s", number),
            ("largest", "largest, s", number),
        ),
    ),
    "skips": Benchmark(
        "what is not computed, and how far the answer is from that without the skip.",
        skips.skips,
        plain(
            CASE,
            ("counted", "counted", str),
            ("count", "done", str),
            ("count_without", "without", str),
            ("saves", "time saved", percent),
            ("difference", "difference", number),
        ),
    ),
}
