"""What a run reads before anything is analysed: model, records, demand, and the results that need no analysis."""

import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from assessment.analyses.chosen_mechanism import refused_as_drawn
from assessment.analyses.demand import Demands, demand_spectra
from assessment.analyses.found import accuracy_of
from assessment.analyses.lateral import with_control
from assessment.analyses.paths import pressed_in, stand
from assessment.ntc.tables import psi_2
from assessment.project import motions as base
from assessment.project.masonry import table_of
from assessment.project.model import ProjectModel, build_model
from assessment.project.plausibility import implausible_hazard
from assessment.project.project import Project, load_project, spelt
from assessment.project.schema import ORIGINAL, MotionTable, SensitivityTable, StatesTable
from assessment.results.joint_states import described
from assessment.results.schema import FORMAT, Convergence, Incremental, Results, StateResults, finite, present
from assessment.results.schema import model as parts
from assessment.results.schema.static import Settlement, Strengthening
from assessment.results.summary import EMPTY
from assessment.runtime.cache import installed
from assessment.runtime.pool import cores
from mechanics import Assembly
from mechanics.messages import Message, headed, visible
from mechanics.records import Record
from mechanics.types import GRAVITY

PACKAGES = (
    "numpy", "scipy", "piqp", "ezdxf", "shapely", "pandas", "matplotlib", "jinja2", "weasyprint", "pydantic",
)  # fmt: skip
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


def describe(project: Project, model: ProjectModel) -> Results:
    """Return the results before any analysis, every state empty. Raises OSError for a file that cannot be read."""
    moving = (project.pushover, project.history, project.incremental, project.campaign, project.mechanism)
    states = project.states if any(moving) else project.unstrengthened[1:]
    return Results(
        format=FORMAT, assesto=installed("assesto"), title=project.title, summary=EMPTY,
        inputs={visible(name): digest for name, digest in project.digests().items()},
        model=_summary(project, model), geometry=_geometry(project, model), loads=_loads(project, model.assembly),
        echo=parts.Echo.model_validate(spelt(project.echoed())),
        states={name: _empty(project, name, len(model.assembly.blocks)) for name in states},
        comparison=[], convergence=Convergence(tolerance=accuracy_of(project).tolerance, rows=[]),
        quality=parts.Quality(solves=0, warnings=[], by_stage=[]), timing_s={},
        software=parts.Software(
            version=installed("assesto"), python=platform.python_version(), platform=platform.system(),
            packages={name: installed(name) for name in PACKAGES},
        ),
    )  # fmt: skip


def _summary(project: Project, model: ProjectModel) -> parts.ModelSummary:
    a = model.assembly
    ties = {name: project.ties_of(name) for name in project.states}
    drawn = []
    for tie in project.tie:
        later = [name for name, (_, later) in ties.items() if tie in later]
        drawn.append(parts.DrawnTie(
            name=tie.name, start_m=list(tie.from_m), end_m=list(tie.to_m),
            blocks=[a.block_at(tie.from_m), a.block_at(tie.to_m)], yield_force_kN=finite(tie.yield_force_kN),
            stiffness_kN_m=tie.stiffness_kN_m, pretension_kN=tie.pretension_kN,
            ultimate_elongation=finite(tie.ultimate_elongation),
            states=[name for name, (there, _) in ties.items() if tie in there or name in later], set_in=later,
        ))  # fmt: skip
    return parts.ModelSummary(
        blocks=len(a.blocks), movable_blocks=int(a.movable.sum()), joints=len(a.joints.a),
        unknowns=3 * len(a.joints.a),  # N, P and T of each joint
        contact_points=4 * int(np.maximum(a.contacts.segments, 1).sum()), weight_kN=a.weight, self_weight_stable=True,
        warnings=list(model.warnings), **present({"ties": drawn or None}),
    )  # fmt: skip


def _empty(project: Project, name: str, blocks: int) -> StateResults:
    made = project.strengthening_of(name)
    moved = None if made else project.settlement_of(name)
    keys = {"support", "displacement_m", "rotation_rad", "increment_m", "after"}
    found = StateResults(
        configuration=[[0.0, 0.0, 0.0]] * blocks,
        settlement=Settlement(**moved.model_dump(mode="json", include=keys, exclude_none=True)) if moved else None,
        pushdown={}, pushover={}, capacity={}, history=[], incremental=Incremental(),
    )  # fmt: skip
    if made is None:
        return found
    ties = [tie.name for tie in project.ties_of(name)[1]]
    return found.replace(strengthening=Strengthening(of=made.of, ties=ties, layers=list(made.layers)))


def _loads(project: Project, a: Assembly) -> list[parts.LayerLoads]:
    """Return the vertical loads of each layer with movable blocks, all its blocks together, as they are combined."""
    found = []
    moving = (block for block, moves in zip(a.blocks, a.movable, strict=True) if moves)
    for layer, region in sorted({(block.layer, block.region) for block in moving}):
        own = [block for block in a.blocks if (block.layer, block.region) == (layer, region)]
        given = table_of(project, layer, region)
        variable, combined = len(own) * given.variable_load_kN, sum(block.weight for block in own)
        found.append(parts.LayerLoads(
            layer=f"{layer}, {region}" if region else layer, blocks=len(own),
            own_weight_kN=combined - sum(block.vertical_load for block in own),
            permanent_load_kN=len(own) * given.vertical_load_kN, variable_load_kN=variable,
            use_category=given.use_category, psi_2=psi_2(given.use_category, given.psi_2) if variable else None,
            combined_kN=combined, seismic_weight_kN=GRAVITY * sum(block.mass for block in own),
        ))  # fmt: skip
    return found


def _geometry(project: Project, model: ProjectModel) -> parts.Geometry:
    a = model.assembly
    blocks = [
        parts.DrawnBlock(
            vertices_m=block.polygon.tolist(), centroid_m=block.centroid.tolist(), depth_m=block.depth,
            layer=block.layer, handle=block.handle, region=block.region or None, support=block.support,
            vertical_load_kN=block.vertical_load, weight_kN=block.weight,
        )
        for block in a.blocks
    ]  # fmt: skip
    controls = [
        parts.Control(name=point.name, point_m=list(point.point_m), block=a.block_at(point.point_m))
        for point in project.control
    ]
    faces = zip(described(a, a.contacts), a.joints.ends, strict=True)
    joints = [parts.Joint(**dict(face), ends_m=ends.tolist()) for face, ends in faces]
    cracks, far = [line.tolist() for line in model.cracks], a.as_drawn([0.0, 0.0])
    beside = present({"cracks_m": cracks or None, "origin_m": far.tolist() if far.any() else None})
    return parts.Geometry(
        blocks=blocks, controls=controls, joints=joints, joint_tolerance_m=a.joint_tolerance,
        gravity_m_s2=GRAVITY, **beside,
    )  # fmt: skip


@dataclass(frozen=True)
class Motions:
    """The base motions of [[history]], [incremental] and the files of [campaign]; `records`: every file, as it is."""

    history: list[base.BaseMotion]
    incremental: list[base.BaseMotion]
    campaign: list[base.BaseMotion]
    records: list[Record]

    @property
    def notes(self) -> list[Message]:
        """What the user should know about the records."""
        every = (*self.history, *self.incremental, *self.campaign)
        named = {motion.name for motion in self.campaign}
        units = [
            headed(visible(record.name), doubt)
            for record in self.records
            if record.name not in named
            for doubt in base.doubtful_units(record)
        ]
        notes = (note for motion in every for note in motion.notes)
        return [*notes, *base.doubtful_records(self.campaign), *units]


@dataclass(frozen=True, eq=False)
class Checked:
    """A project that a run would accept, with model, records, demand, empty results, and `notes` on the files.

    `results.model.self_weight_stable`: whether it stands as drawn; `warnings`: of all that was checked.
    """

    project: Project
    model: ProjectModel
    motions: Motions
    demands: Demands
    results: Results
    notes: tuple[Message, ...]
    warnings: tuple[str, ...] = ()


def read_motions(project: Project) -> Motions:
    """Read every record that the project names. Raises ProjectError or ValueError naming file, line or key."""
    incremental, campaign = (base.set_motions(project, key) for key in ("incremental", "campaign"))
    base.check_record_set(project, "incremental", incremental)
    base.check_record_set(project, "campaign", campaign)
    return Motions(base.history_motions(project), incremental, campaign, base.records_of(project))


def read_inputs(project: Project, model: ProjectModel) -> Checked:
    """Read every file that a run reads, and choose the control points; self-weight is not looked at.

    Raises ProjectError, RecordError or ValueError naming file and key, OSError for a file that cannot be read.
    """
    project, chosen = with_control(project, model.assembly)
    motions = read_motions(project)
    demands = demand_spectra(project, motions.history) if project.assessment else Demands()
    notes = (*chosen, *motions.notes, *implausible_hazard(project, demands.spectra))
    return Checked(project, model, motions, demands, describe(project, model), notes)


def checked(project: Project, model: ProjectModel | None = None) -> Checked:
    """Read every file that a run reads, and refuse what it would refuse; `model`: where it is built already.

    Raises as `read_inputs`, and FaultyDrawingError with all faults of a drawing that is no assembly.
    """
    found = read_inputs(project, model := model or build_model(project))
    results, refused = found.results, refused_as_drawn(project, model.states[ORIGINAL])
    if unstable := stand(model.assembly):
        results = results.replace(model=results.model.replace(self_weight_stable=False))
    more = [unstable] if unstable else pressed_in(model.assembly)
    warnings = (*results.model.warnings, *found.notes, *refused, *more)
    return replace(found, project=project, results=results, warnings=warnings)


def expected(read: Checked) -> dict[str, float]:
    """Return the processor time (s) of every stage that a run of the project has, about, and of its `report`."""
    project, motions, joints = read.project, read.motions, len(read.model.assembly.joints.a)
    height = float(np.ptp(np.concatenate([block.polygon[:, 1] for block in read.model.assembly.blocks])))
    ensemble = 1.0 + AGAIN * (project.scatter - 1)
    bonded = 1.0 + BOND * max(0.0, joints / int(read.model.assembly.movable.sum()) - 2.0)
    increment = PROGRAMS * bonded * (PROGRAM[0] + PROGRAM[1] * joints)

    def states(table: StatesTable | SensitivityTable) -> int:
        return len(table.states or project.states)

    def samples(table: MotionTable, shaking: Sequence[base.BaseMotion], more: int = 0) -> float:
        """Return the time of all samples of some motions, each run once."""
        once, each = STEP[table.contacts]
        return (more + sum(motion.record.time.size for motion in shaking)) * (once + each * joints)

    contacts = {*project.pushed_contacts, *project.dynamic_contacts, *project.moved_contacts} or {"rigid"}
    ways = [each.increments * (COLLAPSE if each.to_collapse else 1.0) for each in project.settlements]
    paths = increment * sum(ways)
    found = {"pushdown": paths * len(contacts) * ensemble}
    curves = 0.0  # s of those of one state under one behaviour of its joints
    if push := project.pushover:
        curves = increment * len(push.directions) * CURVE * max(0.5, HIGH * height / push.increment_m)
        found["pushover"] = curves * len(push.contacts) * len(project.states) * ensemble
    tables = zip(project.history, motions.history, strict=True)
    found["history"] = ensemble * sum(states(each) * samples(each, [motion]) for each, motion in tables)
    if search := project.incremental:  # of both signs, and as long again at half the step
        runs = 4 * states(search) * SEARCH[search.contacts]
        found["incremental"] = runs * samples(search, motions.incremental)
    if study := project.campaign:
        moved = len(study.settlements or project.settlements)
        cases = len(study.signs) * sum(moved if share else 1 for share in study.shares)
        runs = cases * (len(study.levels_g) if study.levels_g else SEARCH[study.contacts])
        found["campaign"] = runs * samples(study, motions.campaign, study.generated * GENERATED)
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
        return expected_line(read_inputs(project := load_project(folder), build_model(project)))
    except (ValueError, OSError):
        return f"it cannot be run as it is: assesto check {folder} says why"


def expected_line(read: Checked) -> str:
    """Return what a run computes and about how long it takes with all cores of this machine, as a line."""
    seconds = expected(read)
    parts = ", ".join(f"{stage} {about(each)}" for stage, each in seconds.items())
    shared = f" on {cores()} cores" if elapsed(seconds) < sum(seconds.values()) else ""
    return f"a run: about {about(elapsed(seconds))}{shared} ({parts}), a minute more where nothing is compiled yet"


def about(seconds: float) -> str:
    """Return a time in the unit and digits of an estimate."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 1.5 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{5.0 * round(seconds / 5.0):.0f} s" if seconds >= 10.0 else f"{max(1.0, seconds):.0f} s"
