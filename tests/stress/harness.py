"""A case, its outcome, and the process of its own with a limit of processor time in which it runs."""

import multiprocessing
import os
import signal
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, is_dataclass
from multiprocessing.connection import Connection
from types import ModuleType

import numpy as np

from mechanics import Assembly
from mechanics.errors import ArgumentError, ControlError, ConvergenceError, NoEquilibriumError, UnstableError
from mechanics.model.contacts import Contacts
from mechanics.program import Certificate
from mechanics.solvers.interior import Iterate
from mechanics.steps.static_system import StaticSystem

resource: ModuleType | None
try:
    import resource
except ImportError:  # Windows
    resource = None
USABLE = 1e-6  # the certificate that the program itself asks for (mechanics.solvers)
REFUSALS = (UnstableError, NoEquilibriumError, ControlError, ConvergenceError)
START = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
HUNG = 24  # exit code of a process that has ended itself: the number of SIGXCPU
SECONDS, LONG_SECONDS = 60, 900  # of processor time, as every other process leaves it: more is a hang


@dataclass(frozen=True)
class Case:
    """`run` analyses and checks the numbers; a refusal of a class in `may_refuse` is an answer too.

    `bad_input` is text of the ValueError that a bad argument must meet, naming it. A case that `must_refuse` has no
    answer.
    """

    group: str
    name: str
    run: Callable[[], None]
    may_refuse: tuple[type[Exception], ...] = ()
    must_refuse: bool = False
    bad_input: str = ""
    long: bool = False

    @property
    def label(self) -> str:
        return f"{self.group}: {self.name}"


@dataclass(frozen=True)
class Outcome:
    """`verdict` certified, refused or failed, the words that go with it, and the CPU time (s)."""

    verdict: str
    words: str = ""
    seconds: float = 0.0


def sound(result: object, step: float = 0.0) -> None:
    """Assert that every number within a result is finite and every certificate good.

    `step` (m): the displacement to which penetration is relative; 0: its own test leaves penetration out.
    """
    for value in _within(result):
        if isinstance(value, Certificate):
            worst = value.worst(step) if step else max(value.equilibrium, value.cone, value.work)
            assert worst <= USABLE, f"certificate {worst:.2g}: {value}"
        elif isinstance(value, np.ndarray | float) and np.asarray(value).dtype.kind == "f":
            assert np.isfinite(value).all(), "a number that is not finite"


def _within(result: object) -> Iterator[object]:
    yield result
    inner: Iterable[object] = ()
    if isinstance(result, tuple | list):
        inner = result
    elif is_dataclass(result) and not isinstance(
        result, (Assembly, Certificate, Contacts, StaticSystem, Iterate)
    ):
        inner = (getattr(result, field.name) for field in fields(result))
    for value in inner:
        yield from _within(value)


def judge(case: Case) -> Outcome:
    """Run a case here."""
    begin = time.process_time()

    def outcome(verdict: str, words: str = "") -> Outcome:
        return Outcome(verdict, words, time.process_time() - begin)

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            case.run()
    except case.may_refuse as refusal:
        named = type(refusal) in REFUSALS or isinstance(refusal, NoEquilibriumError)
        said = f"{type(refusal).__name__}: {refusal}"
        return outcome("refused" if named and str(refusal) else "failed", said)
    except ValueError as refusal:
        known = (
            case.bad_input and type(refusal) in (ValueError, ArgumentError) and case.bad_input in str(refusal)
        )
        return outcome("refused" if known else "failed", f"{type(refusal).__name__}: {refusal}")
    except BaseException as failure:
        where = traceback.extract_tb(failure.__traceback__)[-1]
        said = f"{type(failure).__name__} at {where.name}, line {where.lineno}, {where.line}: {failure}"
        return outcome("failed", said[:600])
    if case.must_refuse or case.bad_input:
        return outcome("failed", "answered, where there is no answer")
    return outcome("certified")


def _send(case: Case, line: Connection, seconds: int) -> None:
    _limit(seconds)
    line.send(judge(case))


def _limit(seconds: int) -> None:
    """Have this process end after so much processor time; Windows limits none: a thread looks at the clock."""
    if resource is not None:
        # The soft limit alone: where the clock is read seldom, a hard limit near it kills first, as lack of memory
        # does.
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, resource.getrlimit(resource.RLIMIT_CPU)[1]))
        return

    def look() -> None:
        while time.process_time() < seconds:
            time.sleep(0.1)
        os._exit(HUNG)

    threading.Thread(target=look, daemon=True).start()


def apart(case: Case, seconds: int = SECONDS) -> Outcome:
    """Run a case in a process of its own: a crash or a hang is a failure of it alone."""
    context = multiprocessing.get_context(START)
    if START == "forkserver":
        context.set_forkserver_preload(["tests.stress.warm"])
    here, there = context.Pipe(duplex=False)
    limit = LONG_SECONDS if case.long else seconds
    process = context.Process(target=_send, args=(case, there, limit))
    process.start()
    there.close()
    try:
        return here.recv()
    except EOFError:
        process.join()
        if process.exitcode in {HUNG, -getattr(signal, "SIGXCPU", HUNG)}:
            return Outcome("failed", f"no answer within {limit} s of processor time", limit)
        return Outcome("failed", f"the process ended with {process.exitcode}")
    finally:
        process.kill()
        process.join()


def outcomes(cases: Iterable[Case], at_once: int = 2) -> list[tuple[Case, Outcome]]:
    """Every case with its outcome, in order."""
    listed = list(cases)
    with ThreadPoolExecutor(at_once) as pool:
        return list(zip(listed, pool.map(apart, listed), strict=True))


def table(judged: Iterable[tuple[Case, Outcome]]) -> str:
    """Markdown: cases, certified, refused and failed of each group and in all."""
    counts: dict[str, dict[str, int]] = {}
    for case, outcome in judged:
        for group in (case.group, "**all**"):
            row = counts.setdefault(group, dict.fromkeys(("certified", "refused", "failed"), 0))
            row[outcome.verdict] += 1
    counts["**all**"] = counts.pop("**all**")  # last
    lines = ["| group | cases | certified | refused | failed |", "|---|---|---|---|---|"]
    for group, row in counts.items():
        numbers = [sum(row.values()), *row.values()]
        lines.append(f"| {group} | {' | '.join(map(str, numbers))} |")
    return "\n".join(lines)
