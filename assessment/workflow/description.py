"""The part of the results that needs no analysis: inputs, model, geometry, versions."""

from __future__ import annotations

import math
import platform
from typing import TYPE_CHECKING, Any

import numpy as np

from assessment.analyses.accuracy import accuracy_of
from assessment.ntc.load_factors import psi_2
from assessment.project.structure.masonry import table_of
from assessment.results.configurations.faces import described
from assessment.results.plain import finite
from assessment.results.schema import FORMAT, Results, State
from assessment.results.schema.dynamic import Incremental
from assessment.results.schema.model import (
    Block,
    Control,
    Echo,
    Geometry,
    Joint,
    LayerLoads,
    ModelSummary,
    Quality,
    Software,
    Tie,
)
from assessment.results.schema.static import Settlement, Strengthening
from assessment.results.schema.studies import Convergence
from assessment.results.summary import EMPTY
from assessment.runtime.fingerprint import installed
from mechanics.faults import visible
from mechanics.types import GRAVITY

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.schema import SettlementTable, TieTable
    from assessment.project.structure.model import ProjectModel
    from mechanics import Assembly

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


def describe(project: Project, model: ProjectModel) -> Results:
    """Return the results before any analysis: every state is present, and empty.

    Raises OSError for a file of the project that cannot be read.
    """
    a = model.assembly
    return Results(
        format=FORMAT,
        assesto=installed("assesto"),
        title=project.title,
        summary=EMPTY,
        inputs={visible(name): digest for name, digest in project.digests().items()},
        model=_summary(project, model),
        geometry=_geometry(project, model),
        loads=_loads(project, a),
        echo=Echo.model_validate(_spelt(project.echoed())),
        states={name: _empty(project, name, len(a.blocks)) for name in _states(project)},
        comparison=[],
        convergence=Convergence(tolerance=accuracy_of(project).tolerance, rows=[]),
        quality=Quality(solves=0, warnings=[], by_stage=[]),
        timing_s={},
        software=Software(
            version=installed("assesto"),
            python=platform.python_version(),
            platform=platform.system(),
            packages={name: installed(name) for name in PACKAGES},
        ),
    )


def _summary(project: Project, model: ProjectModel) -> ModelSummary:
    a = model.assembly
    points = 4 * int(np.maximum(a.contacts.segments, 1).sum())
    found = ModelSummary(
        blocks=len(a.blocks),
        movable_blocks=int(a.movable.sum()),
        joints=len(a.joints.a),
        unknowns=3 * len(a.joints.a),  # N, P and T of each joint
        paper_contact_points=points,
        contact_points=points,
        weight_kN=a.weight,
        self_weight_stable=True,
        warnings=list(model.warnings),
    )
    return found.replace(ties=[_tie(project, a, each) for each in project.tie]) if project.tie else found


def _tie(project: Project, a: Assembly, tie: TieTable) -> Tie:
    """Return a tie as it is drawn, and the states in which it is there."""
    ties = {name: project.ties_of(name) for name in project.states}
    later = [name for name, (_, later) in ties.items() if tie in later]
    return Tie(
        name=tie.name,
        start_m=list(tie.from_m),
        end_m=list(tie.to_m),
        blocks=[a.block_at(tie.from_m), a.block_at(tie.to_m)],
        yield_force_kN=finite(tie.yield_force_kN),
        stiffness_kN_m=tie.stiffness_kN_m,
        pretension_kN=tie.pretension_kN,
        states=[name for name, (there, _) in ties.items() if tie in there or name in later],
        set_in=later,
    )


def _empty(project: Project, name: str, blocks: int) -> State:
    made = project.strengthening_of(name)
    moved = None if made else project.settlement_of(name)
    found = State(
        configuration=[[0.0, 0.0, 0.0]] * blocks,
        settlement=None if moved is None else _settlement(moved),
        pushdown={},
        pushover={},
        capacity={},
        history=[],
        incremental=Incremental(),
    )
    if made is None:
        return found
    ties = [tie.name for tie in project.ties_of(name)[1]]
    return found.replace(strengthening=Strengthening(of=made.of, ties=ties, layers=list(made.layers)))


def _spelt(value: Any) -> Any:
    """Return the content of the project file with infinity as the text "inf": JSON has no infinity."""
    if isinstance(value, dict):
        return {key: _spelt(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_spelt(each) for each in value]
    return "inf" if value == math.inf else value


def _states(project: Project) -> tuple[str, ...]:
    """Return the states by name: the original one and the strengthened ones where an analysis needs them."""
    if project.pushover or project.history or project.incremental or project.campaign or project.mechanism:
        return project.states
    return project.unstrengthened[1:]


def _settlement(moved: SettlementTable) -> Settlement:
    found = Settlement(
        support=moved.support,
        displacement_m=list(moved.displacement_m),
        rotation_rad=moved.rotation_rad,
        increment_m=moved.increment_m,
    )
    return found if moved.after is None else found.replace(after=moved.after)


def _loads(project: Project, a: Assembly) -> list[LayerLoads]:
    """Return the vertical loads of each layer with movable blocks, all its blocks together, as they are combined."""
    found = []
    moving = (block for block, moves in zip(a.blocks, a.movable, strict=True) if moves)
    for layer, region in sorted({(block.layer, block.region) for block in moving}):
        own = [block for block in a.blocks if (block.layer, block.region) == (layer, region)]
        given = table_of(project, layer, region)
        variable = len(own) * given.variable_load_kN
        combined = sum(block.weight for block in own)
        found.append(
            LayerLoads(
                layer=f"{layer}, {region}" if region else layer,
                blocks=len(own),
                own_weight_kN=combined - sum(block.vertical_load for block in own),
                permanent_load_kN=len(own) * given.vertical_load_kN,
                variable_load_kN=variable,
                use_category=given.use_category,
                psi_2=psi_2(given.use_category, given.psi_2) if variable else None,
                combined_kN=combined,
                seismic_weight_kN=GRAVITY * sum(block.mass for block in own),
            )
        )
    return found


def _geometry(project: Project, model: ProjectModel) -> Geometry:
    """Return blocks, control points, joints and surveyed cracks as drawn."""
    a = model.assembly
    found = Geometry(
        blocks=[
            Block(
                vertices_m=block.polygon.tolist(),
                centroid_m=block.centroid.tolist(),
                depth_m=block.depth,
                layer=block.layer,
                handle=block.handle,
                region=block.region or None,
                support=block.support,
                vertical_load_kN=block.vertical_load,
                weight_kN=block.weight,
            )
            for block in a.blocks
        ],
        controls=[
            Control(name=point.name, point_m=list(point.point_m), block=a.block_at(point.point_m))
            for point in project.control
        ],
        joints=[
            Joint(**dict(face), ends_m=ends.tolist())
            for face, ends in zip(described(a, a.contacts), a.joints.ends, strict=True)
        ],
        joint_tolerance_m=a.joint_tolerance,
        gravity_m_s2=GRAVITY,
    )
    if model.cracks:
        found = found.replace(cracks_m=[line.tolist() for line in model.cracks])
    far = a.as_drawn([0.0, 0.0])
    return found.replace(origin_m=far.tolist()) if far.any() else found
