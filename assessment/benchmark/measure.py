"""What is measured, and how: structures, some built here, others of templates; processor time and error of a case.

A time is a ratio to PIQP called once a step, for the same program and in the same run: a ratio carries over to other
and to busy machines. Whatever its bed, a joint is there one of two contact points at its ends.
"""

import csv
import io
import math
import os
import platform
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeVar

import numpy as np

import mechanics
from assessment.analyses.paths import NO_ANSWER
from assessment.project.catalogue.geometry import course, rectangle
from assessment.project.catalogue.new_project import new_project
from assessment.project.model import build_model
from assessment.project.project import Project, load_project
from assessment.runtime.cache import installed
from mechanics import Assembly, Block, Material, Pushdown, Pushover, State, pushdown, pushover
from mechanics.kernels.law import SEGMENTS
from mechanics.model.assembly import Behaviour, Direction
from mechanics.program import Program
from mechanics.solvers import qp_piqp
from mechanics.steps.equilibrium import closed_program
from mechanics.steps.static_step import StepProblem
from mechanics.steps.static_system import static_system
from mechanics.types import GRAVITY, Array


def block_on_base(
    width: float = 0.2, height: float = 1.0, friction: float = 0.7, stiffness: float = 5e5, segments: int | None = None
) -> Assembly:  # fmt: skip
    """A block 1 m deep, its lower left corner at the origin, on a wide support; `segments` of its bed, None: exact."""
    stone = Material(18.0, friction, stiffness)
    base = Block(rectangle(-5 * width, -0.1 * height, 5 * width, 0.0), 1.0, stone, support="base")
    return Assembly([base, Block(rectangle(0.0, 0.0, width, height), 1.0, stone)], segments)


def running_bond(
    columns: int = 5, courses: int = 6, length: float = 0.4, height: float = 0.175, friction: float = 0.65,
    stiffness: float = 1e6, full_on_top: bool = True,
) -> Assembly:  # fmt: skip
    """Courses of whole bricks alternating with half-brick-ended ones; by default wall 1 of Ferris and Tin-Loi."""
    stone = Material(18.0, friction, stiffness)
    width = columns * length
    blocks = [Block(rectangle(-length, -height, width + length, 0.0), 0.1, stone, support="base")]
    for j in range(courses):
        shifted = ((courses - 1 - j) % 2 == 0) != full_on_top
        row = course(0.0, width, j * height, (j + 1) * height, blocks=columns, shifted=shifted)
        blocks += [Block(each, 0.1, stone) for each in row]
    return Assembly(blocks)


def in_frame(model: Assembly, length: float, origin: tuple[float, float], weight: float) -> Assembly:
    """Return the model with lengths and unit weights multiplied, and then moved to an origin (m)."""
    blocks = []
    for block in model.blocks:
        material = replace(block.material, unit_weight=weight * block.material.unit_weight)
        blocks.append(replace(block, vertices=length * block.polygon + np.array(origin), material=material))
    return Assembly(blocks)


@cache
def template(name: str) -> Project:
    """A new project from a built-in template, in a folder that lasts as long as the process."""
    folder = Path(_scratch().name) / name
    new_project(folder, name, {})
    return load_project(folder)


@cache
def assembly(name: str, segments: int | None = None) -> Assembly:
    """The assembly of a template, its elastic joints of `segments`; None: exact."""
    project = template(name)
    geometry = project.geometry.model_copy(update={"segments_per_joint": segments})
    return build_model(project.model_copy(update={"geometry": geometry})).assembly


def settled(
    name: str, contacts: Behaviour, times: float = 1.0, segments: int | None = None, to_collapse: bool = False
) -> Pushdown:
    """A template's movement, in `times` its increment."""
    (table,) = template(name).settlements
    assert table.increment_m is not None
    return pushdown(
        assembly(name, segments), table.support, table.displacement_m, 0.0, times * table.increment_m, contacts,
        to_collapse=to_collapse,
    )  # fmt: skip


def pushed(
    name: str, way: Direction = "+x", contacts: Behaviour = "rigid", times: float = 1.0,
    state: State | None = None, segments: int | None = None, until: float = 0.0,
) -> Pushover:  # fmt: skip
    """A template's capacity curve, in `times` its increment."""
    point, increment = control(name, way)
    return pushover(assembly(name, segments), point, way, contacts, times * increment, state, until)


def control(name: str, way: Direction = "+x") -> tuple[tuple[float, float], float]:
    """The control point (m) of a template, and its increment (m)."""
    project = template(name)
    assert project.pushover is not None
    return project.pushover_control(way).point_m, project.pushover.increment_m


@cache
def _scratch() -> TemporaryDirectory[str]:
    return TemporaryDirectory(prefix="assesto-benchmark-")


Row = dict[str, Any]
"""Fields by name, `case` first; None or NaN: not measured; `failed`: why."""

Answer = TypeVar("Answer")

# what an analysis that does not succeed raises: a row says so
FAILURES = (*NO_ANSWER, mechanics.ControlError)

TOLERANCE = 1e-9  # of the baseline: what the statics ask of PIQP
SAMPLES = 20  # programs of a path, or of a motion, that the baseline solves
ROUNDS, ENOUGH = 3, 1.5  # calls that take turns: least number of each, and least time in s
PACKAGES = ("assesto", "numpy", "scipy", "piqp", "numba", "ezdxf", "matplotlib", "weasyprint")


def seconds_of(work: Callable[[], Answer]) -> tuple[float, Answer]:
    """Processor time (s) of this process in one call, and what it returns."""
    began = time.process_time()
    answer = work()
    return time.process_time() - began, answer


def in_turn(*works: Callable[[], object]) -> Array:
    """The least processor time (s) of calls (k,) in turn: a machine that is slow for seconds is so for all."""
    rounds: list[list[float]] = []
    while len(rounds) < ROUNDS or np.sum(rounds) < ENOUGH:
        rounds.append([seconds_of(work)[0] for work in works])
    return np.min(rounds, axis=0)


def piqp(program: Program) -> Callable[[], object]:
    """PIQP on one program with beds of one segment, its matrices built anew in every call."""
    law = program.law.copy()
    law[:, SEGMENTS] = 1.0
    return partial(qp_piqp.solve, replace(program, law=law), TOLERANCE)


def rows_of(case: "Case") -> Iterator[Row]:
    """A row for each value and each number that is measured: time, ratio to PIQP, error; a failure is a row too."""
    exact, values = case.exact, list(case.values)
    if not math.isnan(case.reference):
        values.insert(0, case.reference)
    for value in values:
        row: Row = {"case": case.name, "way": case.way, "parameter": case.parameter, "value": value}
        row |= {"default": value == case.default}
        run = partial(case.run, value)
        try:
            seconds, result = seconds_of(run)
        except FAILURES as error:
            yield row | {"failed": str(error)}
            if value == case.reference:
                return
            continue
        found = case.measure(result)
        if value == case.reference:
            exact = found
            continue
        row |= case.more(result)
        if case.baseline is not None:
            programs, row["steps"] = case.baseline(result)
            seconds, *solves = in_turn(run, *map(piqp, programs)).tolist()
            row["ratio"] = seconds / row["steps"] / float(np.mean(solves))
        row["seconds"] = seconds
        if row.get("steps"):
            row["step_ms"] = 1e3 * seconds / row["steps"]
        for quantity, number in found.items():
            off = abs(number / exact[quantity] - 1.0) if exact else math.nan
            yield row | {"quantity": quantity, "found": number, "error": off}
        if not found:
            yield row


def path_baseline(path: Pushdown | Pushover) -> tuple[list[Program], int]:
    """Programs that lead from points of a path, SAMPLES or a few more, to the next ones; and how many steps it has."""
    every = max(len(path.steps) // SAMPLES, 1)
    programs = []
    for before, step in list(pairwise(path.steps))[::every]:
        model = step.system.model
        moved = step.state.positions - before.state.positions
        size = max(float(abs(moved[:, :2]).max()), 1e-6 * model.size)
        lateral, work = None, 0.0
        if isinstance(path, Pushover):
            lateral = model.lateral_load("+x")
            work = float((lateral * moved).sum())
        at = np.where(model.movable[:, None], before.state.positions, step.state.positions)
        problem = StepProblem(step.system, before.state, model.dead_load, size, lateral, work)
        programs.append(problem.pose(at, None)[0])
    return programs, len(path.steps)


def history_baseline(
    model: Assembly, behaviour: Behaviour, acceleration: Array, motion: mechanics.TimeHistory
) -> tuple[list[Program], int]:
    """Implicit Euler steps (paper, eq. 3) from states of a motion, accelerations (k,) in g; its number of steps."""
    step, count = float(motion.time[1]), len(motion.time) - 1
    programs = []
    for k in range(0, count, max(count // SAMPLES, 1)):
        state = State(motion.positions[k], motion.velocities[k])
        speed = float(abs(state.velocities[:, :2]).max())
        size = max(GRAVITY * step**2, step * speed)
        system = static_system(model, behaviour).around(state.positions, size)
        inertia = model.mass / step**2
        load = model.dead_load - acceleration[k + 1] * GRAVITY * model.mass * (1.0, 0.0, 0.0)
        problem = StepProblem(system, state, load + step * inertia * state.velocities, size, mass=inertia)
        programs.append(problem.pose(state.positions, None)[0])
    return programs, count


def pushed_program(model: Assembly) -> Program:
    """The program of limit analysis towards +x."""
    return closed_program(model, model.initial).pushed(model, model.lateral_load("+x")).program


@dataclass(frozen=True, eq=False)
class Case:
    """An analysis `run` at some values of a parameter, and the numbers by name that are read off its result."""

    name: str
    run: Callable[[float], Any]
    parameter: str = ""
    values: Sequence[float] = (1.0,)
    measure: Callable[[Any], dict[str, float]] = lambda _: {}
    # errors are relative to it, or to what is measured at the value `reference`
    exact: dict[str, float] | None = None
    reference: float = math.nan
    default: float = 1.0
    way: str = ""  # how it is solved
    more: Callable[[Any], Row] = lambda _: {}  # other fields of a row
    # programs that PIQP solves, of how many steps; None: no ratio
    baseline: Callable[[Any], tuple[list[Program], int]] | None = path_baseline


def exponent(rows: Sequence[Row], field: str) -> float:
    """What a field grows with as a power of the number of blocks: the slope of a straight line in logarithms."""
    sizes, values = (np.log([row[name] for row in rows]) for name in ("blocks", field))
    return float(np.polyfit(sizes, values, 1)[0])


def peak_memory() -> float:
    """The largest memory (MB) of this process so far, with Python and its libraries; NaN where Linux does not count."""
    status = Path("/proc/self/status")
    lines = status.read_text(encoding="ascii").splitlines() if status.is_file() else []
    return next((float(line.split()[1]) / 1024.0 for line in lines if line.startswith("VmHWM")), math.nan)


def machine() -> str:
    """Processor, cores, memory, system, versions, commit (+: files differ) and load, in a sentence or two."""
    command = ["describe", "--always", "--abbrev=7", "--exclude=*", "--dirty=+"]
    commit = "unknown"  # outside a checkout
    with suppress(OSError, subprocess.CalledProcessError):
        asked = ["git", "-C", str(Path(__file__).parent), *command]
        commit = subprocess.run(asked, check=True, capture_output=True, text=True).stdout.strip()
    versions = ", ".join(f"{name} {installed(name)}" for name in PACKAGES)
    memory, cpuinfo = "", Path("/proc/cpuinfo")
    if hasattr(os, "sysconf"):  # Windows has none
        memory = f"{os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES') / 2**30:.0f} GB, "
    lines = cpuinfo.read_text(encoding="utf-8").splitlines() if cpuinfo.is_file() else []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    processor = next(names, platform.processor() or platform.machine())
    return (
        f"{processor}, {os.cpu_count()} cores, {memory}{platform.system()}; Python "
        f"{platform.python_version()}, {versions}; commit {commit}; load {load()} at the start."
    )


def load() -> str:
    """How many processes want to run, in the mean over a minute."""
    return f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"


IN_PER_CENT = ("error", "saves")


def known(value: object) -> bool:
    """Whether a cell has a value."""
    return value is not None and not (isinstance(value, float) and math.isnan(value))


def fields(rows: Sequence[Row]) -> list[str]:
    """Names of the fields that any row has a value of, in their order."""
    return list(dict.fromkeys(name for row in rows for name, value in row.items() if known(value)))


def as_csv(rows: Sequence[Row]) -> bytes:
    """All fields that are known of any row; one that is not is empty."""
    text, names = io.StringIO(), fields(rows)
    lines = [[row[name] if known(row.get(name)) else "" for name in names] for row in rows]
    csv.writer(text, lineterminator="\n").writerows([names, *lines])
    return text.getvalue().encode()


def table(rows: Sequence[Row], index: Sequence[str] = (), across: str = "", cells: Sequence[str] = ()) -> str:
    """A Markdown table: a line for each row or value of `index`, a column for each value of `across`."""
    if not across:
        names = [name for name in fields(rows) if name in index or (not index and name != "parameter")]
        return _markdown(names, [[written(name, row.get(name)) for name in names] for row in rows])
    headings = list(dict.fromkeys(written(across, row[across], row) for row in rows))
    lines: dict[tuple[str, ...], dict[str, str]] = {}
    for row in rows:
        told = [written(name, row.get(name)) for name in cells if known(row.get(name))]
        text = "; ".join(told) if row.get("failed") is None else "fails"
        line = lines.setdefault(tuple(str(row.get(name, "")) for name in index), {})
        line[written(across, row[across], row)] = f"**{text}**" if row.get("default") else text
    return _markdown(
        [*index, *headings], [[*at, *(line.get(each, "") for each in headings)] for at, line in lines.items()]
    )


def _markdown(headings: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(line)} |" for line in (headings, ["---"] * len(headings), *lines))


def written(name: str, value: Any, row: Row | None = None) -> str:
    """The text of a field; infinitely many segments are the exact bed."""
    if not known(value):
        return ""
    if name == "value" and row:
        times = row["parameter"] == "increment"
        text = "exact" if math.isinf(value) else f"{'× ' if times else ''}{value:g}"
        return f"{1e3 * value:.3g} ms" if row["parameter"].startswith("time step") else text
    if name in IN_PER_CENT:
        return "< 1e-5 %" if 0.0 < abs(value) < 1e-7 else f"{number(100.0 * value)} %"
    if name == "alpha" or name.endswith(("_end_m", "_g")):
        return f"{value:.5f}"
    if name in ("least", "median", "most"):
        return f"{value:.3g}"
    return number(value) if isinstance(value, float) else str(value)


def number(value: float) -> str:
    """Two significant digits."""
    if value != 0.0 and (abs(value) < 1e-3 or abs(value) >= 1e5):
        return f"{value:.0e}"
    return f"{value:.{max(0, 1 - math.floor(math.log10(abs(value))))}f}" if value else "0"
