"""Which stages a project needs, in what order, and what they leave behind."""

from __future__ import annotations

import hashlib
import json
import math
import os
import platform
import shutil
import tempfile
import time
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assessment.checks import assess, assess_chosen, governing
from assessment.convergence import accuracy_of, converge
from assessment.demand import demand_spectra, spectra_numbers
from assessment.dynamic_stages import add_dynamics, dynamic_contacts, read_motions
from assessment.files import write_atomically
from assessment.messages import ProjectError
from assessment.model import Model
from assessment.parallel import SMALL, spread
from assessment.stages import ORIGINAL, StateResult, analyse_state
from assessment.study import Demands
from assessment.study_stages import add_studies
from assessment.table import reduction, static_pga
from mechanics import Assembly, UnstableError
from mechanics.block import GRAVITY
from mechanics.equilibrium import check_self_weight

if TYPE_CHECKING:
    from assessment.project import Project
    from assessment.project_schema import SettlementTable
    from mechanics.assembly import Behaviour

Results = dict[str, Any]
Progress = Callable[[str], None]
PACKAGES = (
    "numpy",
    "scipy",
    "piqp",
    "ezdxf",
    "shapely",
    "pandas",
    "matplotlib",
    "jinja2",
    "weasyprint",
    "pydantic",
)
SCRATCH = ".assesto-"  # where files are made before they take their place


@dataclass(frozen=True)
class Outcome:
    """What a run came to: its results and whether every analysis asked for was completed."""

    results: Results
    complete: bool


STAGES = {  # stage: table
    "pushdown": "settlements",
    "pushover": "pushover",
    "history": "history",
    "incremental": "incremental",
    "assessment": "assessment",
    "scenarios": "settlements",
    "sensitivity": "sensitivity",
}


def select(project: Project, only: Iterable[str] | None) -> Project:
    """The project with only some of its stages; ProjectError for a stage that does not exist.

    A settled state is made where a stage needs it: settlements stay unless no other stage but the assessment is left.
    """
    if only is None:
        return project
    wanted = list(only)
    for name in wanted:
        if name not in STAGES:
            raise ProjectError(f"--only: {name}: no such stage; choose from {', '.join(STAGES)}")
    if "sensitivity" in wanted and "assessment" not in wanted:
        wanted.append("assessment")
    if {"assessment", "scenarios"} & {*wanted} and "pushover" not in wanted:
        wanted.append("pushover")
    by_record = project.assessment is not None and project.assessment.spectrum == "record"
    if "assessment" in wanted and "history" not in wanted and by_record:
        raise ProjectError('--only: assessment: spectrum = "record" needs the history stage; add history')
    dropped: dict[str, Any] = {
        table: () if table == "history" else None
        for stage, table in STAGES.items()
        if stage not in wanted and table != "settlements"
    }
    if "scenarios" not in wanted:
        whole = (each.model_copy(update={"steps": None}) for each in project.settlements)
        dropped["settlements"] = tuple(whole)
    return project.model_copy(update=dropped)


def run(project: Project, model: Model, jobs: int = 0, progress: Progress = lambda _: None) -> Outcome:
    """Carry out every stage that the project asks for (jobs: processes, 0: as many as help)."""
    assembly = model.assembly
    motions = read_motions(project)
    demands, hazard = demand_spectra(project, motions.history) if project.assessment else ({}, None)
    results = describe(project, model)
    results["quality"]["warnings"] += motions.notes
    try:
        check_self_weight(assembly)
    except UnstableError as error:
        results["model"]["self_weight_stable"] = False
        results["quality"]["warnings"].append(str(error))
        _sum_up(results["quality"])
        return Outcome(_without_nan(results), complete=False)
    converged = converge(
        project,
        assembly,
        Demands(demands, hazard),
        lambda finer, names: list(_analyses(finer, assembly, names, jobs, progress)),
    )
    stages = converged.stages
    warnings = results["quality"]["warnings"]
    warnings += converged.warnings
    results["convergence"]["rows"] += converged.rows
    states = results["states"]
    for stage in stages:
        _merge(states[stage.state], stage)
        warnings += stage.warnings + stage.failures
        results["quality"]["by_stage"] += stage.quality
        for name, seconds in stage.seconds.items():
            results["timing_s"][name] = results["timing_s"].get(name, 0.0) + seconds
    if project.assessment:
        began = time.perf_counter()
        for name, state in states.items():
            notes: list[str] = []
            state["capacity"] = assess(project, assembly, state["pushover"], demands, hazard, notes)
            state["governing"] = governing(state["capacity"])
            warnings += [f"{name}: {note}" for note in notes]
        results["spectra"] = spectra_numbers(project, demands, hazard)
        results["timing_s"]["assessment"] = time.perf_counter() - began
    if project.mechanism:
        results["mechanisms"] = assess_chosen(project, assembly, states, demands, hazard, warnings)
    studied = add_studies(
        results, project, assembly, stages, converged.halvings, demands, hazard, jobs, progress
    )
    shaken = add_dynamics(results, project, assembly, motions, stages, jobs, progress)
    if project.assessment or project.incremental:
        results["comparison"] = _comparison(states)
    _sum_up(results["quality"])
    complete = shaken and studied and not any(stage.failures for stage in stages)
    return Outcome(_without_nan(results), complete)


def describe(project: Project, model: Model) -> Results:
    """The part of the results that needs no analysis: inputs, model, geometry, echo."""
    a = model.assembly
    return {
        "assesto": _version("assesto"),
        "title": project.title,
        "inputs": {
            name: hashlib.sha256(project.path(name).read_bytes()).hexdigest() for name in _inputs(project)
        },
        "model": {
            "blocks": len(a.blocks),
            "movable_blocks": int(a.movable.sum()),
            "joints": len(a.joints.a),
            "contact_points": len(a.elastic_contacts),
            "weight_kN": a.weight,
            "self_weight_stable": True,
            "warnings": list(model.warnings),
        },
        "geometry": _geometry(project, a),
        "echo": project.content(),
        "states": {
            name: {
                "configuration": [[0.0, 0.0, 0.0]] * len(a.blocks),
                "settlement": settlement,
                "pushdown": {},
                "pushover": {},
                "capacity": {},
                "history": [],
                "incremental": {},
            }
            for name, settlement in _states(project)
        },
        "comparison": [],
        "convergence": {"tolerance": accuracy_of(project).tolerance, "rows": []},
        "quality": {"solves": 0, "warnings": [], "by_stage": []},
        "timing_s": {},
        "software": {
            "version": _version("assesto"),
            "python": platform.python_version(),
            "platform": platform.system(),
            "packages": {name: _version(name) for name in PACKAGES},
        },
    }


def write(results: Results, folder: Path, report: bool = True) -> list[str]:
    """Write results.json, tables, figures and report into `folder`; each appears whole or not at all.

    A judgement.md that was edited is kept and printed. Returns warnings (a PDF that could not be made). results.json
    comes last: where it is new, all is.
    """
    from assessment.animation import write_animations
    from assessment.figures import write_figures
    from assessment.judgement_file import NAME, judgement
    from assessment.report import render_report
    from assessment.tables import write_tables
    from assessment.words import words_of

    folder.mkdir(parents=True, exist_ok=True)
    for left in folder.glob(f"{SCRATCH}*"):  # of a run that was killed
        shutil.rmtree(left)
    warnings: list[str] = []
    with tempfile.TemporaryDirectory(prefix=SCRATCH, dir=folder) as scratch:
        new = Path(scratch)
        write_tables(results, new / "tables")
        write_figures(results, new / "figures")
        opinion = judgement(results, words_of(results), folder)
        write_atomically(new / NAME, opinion.text.encode())
        warnings += opinion.warnings
        write_animations(results, new / "figures")
        if report:
            warnings += render_report(results, new / "figures", new, opinion.edited).warnings
        write_atomically(
            new / "results.json", json.dumps(results, ensure_ascii=False, allow_nan=False).encode()
        )
        ours, made_now = (folder / "results.json").exists(), {item.name for item in new.iterdir()}
        for item in sorted(new.iterdir(), key=lambda path: path.name == "results.json"):
            _replace(item, folder / item.name, ours)
        for name in ("report.pdf", "report.html"):  # one of earlier results would stand beside the new ones
            if ours and name not in made_now:
                (folder / name).unlink(missing_ok=True)
    return warnings


def _replace(new: Path, old: Path, ours: bool) -> None:
    """Put a finished file, or each file of a finished folder, in the place of an earlier one.

    `ours`: an earlier run filled the folder, so that what it made and this one did not is removed.
    """
    if not new.is_dir():
        new.replace(old)
        return
    old.mkdir(exist_ok=True)
    names = {item.name for item in new.iterdir()}
    for name in sorted(names):
        (new / name).replace(old / name)
    if ours:
        for stale in {
            item
            for item in old.iterdir()
            if item.suffix in {".csv", ".svg", ".png", ".dxf", ".gif"} and item.name not in names
        }:
            stale.unlink()


def _analyses(
    project: Project, assembly: Assembly, states: Collection[str], jobs: int, progress: Progress
) -> Iterable[StateResult]:
    """Each of the states under every contact behaviour, on several processes where that pays."""
    pushed: tuple[Behaviour, ...] = project.pushover.contacts if project.pushover else ()
    settled = list(dict.fromkeys([*pushed, *dynamic_contacts(project)])) or ["rigid"]
    tasks: list[tuple[SettlementTable | None, Behaviour]] = [(None, b) for b in pushed if ORIGINAL in states]
    tasks += [(s, b) for s in project.settlements if s.name in states for b in settled]
    names = [f"{task[0].name if task[0] else ORIGINAL}: {task[1]} contacts" for task in tasks]
    worthwhile = len(assembly.elastic_contacts) * len(tasks) > SMALL
    return spread(
        analyse_state,
        [(project, assembly, *task) for task in tasks],
        jobs,
        worthwhile,
        lambda number: progress(names[number]),
    )


def _merge(state: Results, stage: StateResult) -> None:
    if stage.pushdown is not None:
        state["pushdown"][stage.behaviour] = stage.pushdown
    if stage.configuration is not None and (
        stage.behaviour == "rigid" or not any(map(any, state["configuration"]))
    ):
        state["configuration"] = stage.configuration
    for direction, numbers in stage.pushover.items():
        control = numbers.pop("control")
        state["pushover"].setdefault(direction, {"control": control})[stage.behaviour] = numbers


def _comparison(states: Mapping[str, Any]) -> list[Results]:
    """Capacities of each settled state beside the original one's; the dynamic one is the same in every direction."""
    rows: list[Results] = []
    original = states.get(ORIGINAL)
    if original is None:
        return rows
    for name, state in states.items():
        if name == ORIGINAL:
            continue
        dynamic = state["incremental"].get("pga_collapse_g")
        for direction in original["pushover"] or ([None] if state["incremental"] else []):
            before = static_pga(original["capacity"].get(direction))
            after = static_pga(state["capacity"].get(direction))
            rows.append(
                {
                    "state": name,
                    "direction": direction,
                    "static_pga_g": after,
                    "static_reduction": reduction(before, after),
                    "dynamic_pga_g": dynamic,
                    "dynamic_reduction": reduction(original["incremental"].get("pga_collapse_g"), dynamic),
                }
            )
    return rows


def _sum_up(quality: Results) -> None:
    rows = quality["by_stage"]
    quality["solves"] = sum(row["solves"] for row in rows)
    for key in (
        "worst_equilibrium_residual",
        "worst_penetration_m",
        "worst_complementarity",
        "worst_cone_violation",
    ):
        quality[key] = max((row[key] for row in rows), default=None)


def _states(project: Project) -> Iterable[tuple[str, Results | None]]:
    if project.pushover or project.history or project.incremental or project.mechanism:
        yield ORIGINAL, None
    for s in project.settlements:
        yield (
            s.name,
            {
                "support": s.support,
                "displacement_m": list(s.displacement_m),
                "rotation_rad": s.rotation_rad,
                "increment_m": s.increment_m,
            },
        )


def _geometry(project: Project, a: Assembly) -> Results:
    return {
        "blocks": [
            {
                "vertices_m": block.polygon.tolist(),
                "centroid_m": block.centroid.tolist(),
                "depth_m": block.depth,
                "layer": block.layer,
                "handle": block.handle,
                "support": block.support,
                "vertical_load_kN": block.vertical_load,
                "weight_kN": block.weight,
            }
            for block in a.blocks
        ],
        "controls": [
            {"name": point.name, "point_m": list(point.point_m), "block": a.block_at(point.point_m)}
            for point in project.control
        ],
        "joints": [
            {
                "blocks": [int(i), int(j)],
                "ends_m": ends.tolist(),
                "friction": min(a.blocks[i].material.friction, a.blocks[j].material.friction),
            }
            for i, j, ends in zip(a.joints.a, a.joints.b, a.joints.ends, strict=True)
        ],
        "gravity_m_s2": GRAVITY,
    }


def _inputs(project: Project) -> list[str]:
    names = [project.source, project.geometry.drawing]
    if project.assessment and project.assessment.site and project.assessment.site.grid:
        names.append(project.assessment.site.grid)
    for history in project.history:
        names += [name for name in (history.record, history.vertical_record) if name]
    names += [os.path.relpath(path, project.folder) for path in project.incremental_records()]
    return list(dict.fromkeys(names))


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"


def _without_nan(value: Any) -> Any:
    """JSON has no NaN and no infinity: null in their place."""
    if isinstance(value, Mapping):
        return {key: _without_nan(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value.item() if hasattr(value, "item") else value
