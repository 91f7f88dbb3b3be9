"""Run time against error of the statics: `make benchmark`.

Every time is also given as a ratio to a baseline measured in the same run: one PIQP solve of the limit program of an
18 × 18 running-bond wall. The error of limit analysis is the difference from HiGHS, that of a whole run the largest
difference between a rigid multiplier and the one recomputed from its mechanism by virtual work.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.metadata import version
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from assessment.model import build_model
from assessment.project import Project, load_project
from assessment.workflow import Results, run
from mechanics import limit_analysis
from mechanics.equilibrium import closed_program
from mechanics.program import Program
from mechanics.solvers import interior_point, linear
from tests.structures import running_bond

ROOT = Path(__file__).parents[2]
PACKAGES = ("numpy", "scipy", "piqp", "ezdxf", "matplotlib", "weasyprint")
JOBS = 2
WALLS = {100: (10, 10), 300: (17, 17), 1000: (31, 31)}  # blocks: columns, courses
COMPARED = 300  # blocks of the largest wall that HiGHS also solves


@dataclass(frozen=True)
class Row:
    """A case: what it is, its size, seconds, and what is known of its error (– where there is none)."""

    case: str
    size: str
    seconds: float
    certificate: float = np.nan
    error: float = np.nan


def main() -> None:
    """Print the table, a row as soon as it is measured."""
    print(
        f"{processor()}, {os.cpu_count()} cores, {platform.system()}, load {os.getloadavg()[0]:.1f} at the start"
    )
    print(f"Python {platform.python_version()}, " + ", ".join(f"{name} {version(name)}" for name in PACKAGES))
    program = wall_program(18, 18)
    baseline, _ = median(lambda: interior_point.solve(program, 1e-9))
    print(f"baseline: PIQP, limit program of an 18 × 18 wall, {1e3 * baseline:.1f} ms\n")
    print(f"{'case':58} {'size':24} {'time [s]':>9} {'ratio':>7} {'certificate':>12} {'error':>8}")
    for row in chain(walls(), triumphal_arch(), commands()):
        print(
            f"{row.case:58} {row.size:24} {row.seconds:9.3f} {row.seconds / baseline:7.1f} "
            f"{number(row.certificate):>12} {number(row.error):>8}",
            flush=True,
        )
    print(f"\nload {os.getloadavg()[0]:.1f} at the end")


def walls() -> Iterator[Row]:
    """Limit analysis of running-bond walls, self-weight check and set-up included."""
    for columns, courses in WALLS.values():
        model = running_bond(columns, courses)
        seconds, limit = median(lambda model=model: limit_analysis(model), 3)
        blocks, points = int(model.movable.sum()), len(model.rigid_contacts)
        error = np.nan
        if blocks <= 1.2 * COMPARED:
            program = wall_program(columns, courses)
            took, answer = median(lambda program=program: linear.solve(program), 1)
            error = abs(answer[1] - limit.alpha)
            yield Row(f"the same by HiGHS, {blocks} blocks", f"{blocks} × {points}", took)
        yield Row(
            f"limit analysis, running-bond wall of {blocks} blocks",
            f"{blocks} × {points}",
            seconds,
            limit.certificate.worst(1e-3 * model.size),
            error,
        )


def triumphal_arch() -> Iterator[Row]:
    """Pushdown in 15 increments and rigid and elastic pushover of both states; then the whole project file."""
    whole = load_project(ROOT / "projects" / "triumphal_arch")
    project = whole.model_copy(update={"history": (), "incremental": None})  # the statics alone
    assert project.pushover is not None
    only_down = tuple(s.model_copy(update={"to_collapse": False}) for s in project.settlements)
    one_way = project.pushover.model_copy(update={"directions": ("+x",)})
    paper = project.model_copy(update={"settlements": only_down, "pushover": one_way})
    both = project.model_copy(update={"settlements": only_down})
    yield timed("triumphal arch: pushdown, pushovers, +x", paper)
    yield timed("triumphal arch: pushdown, pushovers, +x and −x", both)
    yield timed("triumphal arch: the same and the ultimate movement", project)


def timed(case: str, project: Project) -> Row:
    """A project's analyses through the workflow on two processes, without files."""
    model = build_model(project)
    seconds, outcome = median(lambda: run(project, model, jobs=JOBS), 1)
    results = outcome.results
    size = f"{results['model']['blocks']} × {results['model']['contact_points']}"
    certificate = results["quality"]["worst_equilibrium_residual"]
    return Row(
        case if outcome.complete else f"{case} (INCOMPLETE)",
        size,
        seconds,
        certificate,
        virtual_work(results),
    )


def virtual_work(results: Results) -> float:
    """Largest relative difference of a rigid multiplier from the one that its mechanism gives by virtual work."""
    rigid = [
        p["rigid"] for state in results["states"].values() for p in state["pushover"].values() if "rigid" in p
    ]
    return max(abs(r["virtual_work_alpha"] / r["virtual_work_reference"] - 1.0) for r in rigid)


def commands() -> Iterator[Row]:
    """Whole commands, from the shell and back."""
    assesto = (sys.executable, "-m", "assessment.cli")

    def call(*arguments: str) -> float:
        return median(
            lambda: subprocess.run([*assesto, *arguments], cwd=ROOT, check=True, capture_output=True), 3
        )[0]

    yield Row("assesto --help", "", call("--help"))
    with tempfile.TemporaryDirectory() as folder:
        yield Row("assesto run projects/buttressed_arch, to the PDF", "", call(
            "run", "projects/buttressed_arch", "--out", folder
        ))  # fmt: skip
        assert (Path(folder) / "report.pdf").is_file()


def median(work: Callable[[], Any], times: int = 7) -> tuple[float, Any]:
    """The median time (s) of a number of runs, and the last answer."""
    seconds, answer = [], None
    for _ in range(times):
        began = time.perf_counter()
        answer = work()
        seconds.append(time.perf_counter() - began)
    return float(np.median(seconds)), answer


def wall_program(columns: int, courses: int) -> Program:
    """The program of limit analysis of a running-bond wall."""
    model = running_bond(columns, courses)
    return closed_program(model, model.initial, model.lateral_load("+x"))[0]


def processor() -> str:
    """The processor's name."""
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        for line in cpuinfo.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def number(value: float) -> str:
    """A residual for the table."""
    return "–" if np.isnan(value) else f"{value:.0e}"


if __name__ == "__main__":
    main()
