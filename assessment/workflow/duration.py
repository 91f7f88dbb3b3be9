"""About how long a run takes: its programs and time steps, times what each of them takes on a core of 2 GHz.

Measured on examples of 1 to 249 joints: static chains take a half to twice the estimate. Programs, members and motions
are counted when a run is over; walls in bond that slide, and ensembles that are not needed, differ most.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from assessment.project.project import load_project
from assessment.project.structure.model import build_model
from assessment.runtime.pool import cores
from assessment.workflow.checking import Checked, read_inputs

if TYPE_CHECKING:
    from assessment.project.schema import StatesTable
    from assessment.project.schema.motions import SensitivityTable

PROGRAM = (1e-3, 8e-6)  # s of a program of a static step, and for each joint of it
STEP = {"rigid": (5e-5, 9e-6), "elastic": (3e-5, 5e-6)}  # s of a sample of a motion, and for each joint
PROGRAMS = 6.0  # of an increment
BOND = 10.0  # times the programs, for each joint of a block beyond two: what lies in bond slides, and hangs together
COLLAPSE = 4.0  # times the movement at which a structure falls
CURVE, HIGH = 40.0, 1e-3  # increments of a pushover, each so much of the height; of others in proportion
AGAIN = 0.75  # of the time of a path or motion: each further member of its ensemble
SEARCH = {"rigid": 10, "elastic": 30}  # motions for a PGA at collapse; elastic ones near it take many steps
GENERATED = 2500  # samples of a record that is made
FITS = 60  # movements that are tried to fit what was measured, for each hypothesis
MUCH = 40.0  # s: less of it is not shared out among cores
PRINTED = 15.0  # s of figures, tables and the report


def expected(read: Checked) -> dict[str, float]:
    """Return the processor time (s) of every stage that a run of the project has, about, and of its `report`."""
    project, motions, joints = read.project, read.motions, len(read.model.assembly.joints.a)
    height = float(np.ptp(np.concatenate([block.polygon[:, 1] for block in read.model.assembly.blocks])))
    ensemble = 1.0 + AGAIN * (project.scatter - 1)
    bonded = 1.0 + BOND * max(0.0, joints / int(read.model.assembly.movable.sum()) - 2.0)
    increment = PROGRAMS * bonded * (PROGRAM[0] + PROGRAM[1] * joints)
    step = {contacts: once + each * joints for contacts, (once, each) in STEP.items()}

    def states(table: StatesTable | SensitivityTable) -> int:
        return len(table.states or project.states)

    contacts = {*project.pushed_contacts, *project.dynamic_contacts, *project.moved_contacts} or {"rigid"}
    paths = increment * sum(
        each.increments * (COLLAPSE if each.to_collapse else 1.0) for each in project.settlements
    )
    found = {"pushdown": paths * len(contacts) * ensemble}
    curves = 0.0  # s of those of one state under one behaviour of its joints
    if push := project.pushover:
        curves = increment * len(push.directions) * CURVE * max(0.5, HIGH * height / push.increment_m)
        found["pushover"] = curves * len(push.contacts) * len(project.states) * ensemble
    for table, motion in zip(project.history, motions.history, strict=True):
        own = states(table) * motion.record.time.size * step[table.contacts] * ensemble
        found["history"] = found.get("history", 0.0) + own
    if search := project.incremental:
        samples = sum(each.record.time.size for each in motions.incremental)
        runs = (
            4 * states(search) * SEARCH[search.contacts]
        )  # of both signs, and as long again at half the step
        found["incremental"] = runs * samples * step[search.contacts]
    if study := project.campaign:
        moved = len(study.settlements or project.settlements)
        cases = len(study.signs) * sum(moved if share else 1 for share in study.shares)
        runs = cases * (len(study.levels_g) if study.levels_g else SEARCH[study.contacts])
        samples = sum(each.record.time.size for each in motions.campaign) + study.generated * GENERATED
        found["campaign"] = runs * samples * step[study.contacts]
    found["scenarios"] = curves * sum(each.steps or 0 for each in project.settlements)
    if varied := project.sensitivity:
        found["sensitivity"] = 2 * len(varied.factors) * (paths + curves * states(varied))
    if fit := project.identification:
        found["identification"] = FITS * len(fit.hypotheses) * CURVE * increment
    return {stage: seconds for stage, seconds in found.items() if seconds} | {"report": PRINTED}


def elapsed(seconds: Mapping[str, float]) -> float:
    """Return how long stages take (s) that compute side by side where there is much of them; the report goes last."""
    work = sum(seconds.values()) - seconds["report"]
    return work / (cores() if work > MUCH else 1) + seconds["report"]


def first_run(folder: Path) -> str:
    """Return `expected_line` of a project; for one that cannot be read, how to find out why."""
    try:
        project = load_project(folder)
        return expected_line(read_inputs(project, build_model(project)))
    except (ValueError, OSError):
        return f"it cannot be run as it is: assesto check {folder} says why"


def expected_line(read: Checked) -> str:
    """Return what a run computes and about how long it takes with all cores of this machine, as a line."""
    seconds = expected(read)
    parts = ", ".join(f"{stage} {about(each)}" for stage, each in seconds.items())
    return f"a run: about {about(elapsed(seconds))} ({parts}), a minute more where nothing is compiled yet"


def about(seconds: float) -> str:
    """Return a time in the unit and digits of an estimate."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 1.5 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{5.0 * round(seconds / 5.0):.0f} s" if seconds >= 10.0 else f"{max(1.0, seconds):.0f} s"
