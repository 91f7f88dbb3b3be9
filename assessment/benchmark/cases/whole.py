"""Whole analyses: the static chain of a template, and commands from the shell and back."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from itertools import product
from tempfile import TemporaryDirectory
from typing import Any

from assessment.analyses.static.states import PAST_PEAK
from assessment.benchmark.cases.structures import assembly, pushed, settled, template
from assessment.benchmark.measure import FAILURES, Case, Row, rows_of
from mechanics.model.assembly import Behaviour, Direction
from mechanics.procedures.mirror import Mirror

WAYS: tuple[Direction, ...] = ("+x", "-x")
CONTACTS: tuple[Behaviour, ...] = ("rigid", "elastic")


def chain(quick: bool) -> Iterator[Row]:
    """Pushdown, rigid and elastic pushover of both states and directions, one by one and together; whole commands."""
    for name in ("buttressed-arch",) if quick else ("buttressed-arch", "triumphal-arch"):
        yield from analyses(name)
        with TemporaryDirectory() as out:
            arguments = ("run", str(template(name).folder), "--out", out)
            statics = (*arguments, "--only", "pushdown,pushover", "--no-report", "--fresh")
            yield command(f"assesto run, {name.replace('-', ' ')}, statics", *statics)
            if not quick:
                yield command(f"assesto run, {name.replace('-', ' ')}, to the PDF", *arguments)
                yield command("assesto run again, nothing changed", *arguments)
    yield command("assesto --help", "--help")


def analyses(name: str) -> Iterator[Row]:
    """Every analysis of a template on one processor; last, of all together."""
    rows: list[Row] = []
    for contacts in CONTACTS:
        mirror, paths = Mirror.of(assembly(name), contacts), dict[str, Any]()
        for title, way in [("pushdown", None), *product(("original", "settled"), WAYS)]:
            if title == "settled" and "pushdown" not in paths:
                continue
            work = partial(_path, name, title, way, contacts, paths, mirror)
            full = f"{title}, pushover {way}" if way else title
            with suppress(*FAILURES):
                paths[full] = work(1.0)
            rows += rows_of(Case(f"{name.replace('-', ' ')}, {full}, {contacts}", work))
            yield rows[-1]
    solved = [row for row in rows if row.get("failed") is None]
    total: Row = {field: sum(row.get(field, 0) for row in rows) for field in ("steps", "seconds")}
    total["ratio"] = total["seconds"] / sum(row["seconds"] / row["ratio"] for row in solved)
    lost = len(rows) - len(solved)
    failed = f"{lost} of {len(rows)}, and what depends on them" if lost else None
    yield {"case": f"{name.replace('-', ' ')}, static chain", "whole": True, "failed": failed} | total


def _path(
    name: str, title: str, way: Direction | None, contacts: Behaviour, paths: dict[str, Any], mirror: Mirror | None,
    _: float,
) -> Any:  # fmt: skip
    """The movement of a template, or its curve as drawn or settled; as drawn towards −x by reflection if exact."""
    if way is None:
        return settled(name, contacts)
    other = paths.get("original, pushover +x") if way == "-x" and title == "original" else None
    if mirror and other and (image := mirror.pushover(other)):
        return image
    state = paths["pushdown"].final if title == "settled" else None
    return pushed(name, way, contacts, 1.0, state, None, PAST_PEAK if contacts == "elastic" else 0.0)


def command(case: str, *arguments: str) -> Row:
    """Processor time and time elapsed of a whole command."""
    before = os.times()
    subprocess.run([sys.executable, "-m", "assessment.cli", *arguments], check=True, capture_output=True)
    _, _, user, system, elapsed = (now - then for now, then in zip(os.times(), before, strict=True))
    return {"case": case, "whole": True, "seconds": user + system, "elapsed_s": elapsed}
