"""The part of the results that needs no analysis: inputs, model, geometry, versions."""

from __future__ import annotations

import math
import platform
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from assessment.analyses.accuracy import accuracy_of
from assessment.ntc.load_factors import psi_2
from assessment.project.schema import ORIGINAL, LayerTable
from assessment.results.configurations.faces import described
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
)
from assessment.results.schema.static import Settlement
from assessment.results.schema.studies import Convergence
from assessment.runtime.fingerprint import installed
from mechanics.faults import visible
from mechanics.types import GRAVITY

if TYPE_CHECKING:
    from assessment.project.model import ProjectModel
    from assessment.project.project import Project
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
        inputs={visible(name): digest for name, digest in project.digests().items()},
        model=_summary(model),
        geometry=_geometry(project, a),
        loads=_loads(project, a),
        echo=Echo.model_validate(_spelt(project.content())),
        states={name: _empty(settlement, len(a.blocks)) for name, settlement in _states(project)},
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


def _summary(model: ProjectModel) -> ModelSummary:
    a = model.assembly
    return ModelSummary(
        blocks=len(a.blocks),
        movable_blocks=int(a.movable.sum()),
        joints=len(a.joints.a),
        unknowns=3 * len(a.joints.a),  # N, P and T of each joint
        paper_contact_points=4 * int(np.maximum(a.contacts.segments, 1).sum()),
        weight_kN=a.weight,
        self_weight_stable=True,
        warnings=list(model.warnings),
    )


def _empty(settlement: Settlement | None, blocks: int) -> State:
    return State(
        configuration=[[0.0, 0.0, 0.0]] * blocks,
        settlement=settlement,
        pushdown={},
        pushover={},
        capacity={},
        history=[],
        incremental=Incremental(),
    )


def _spelt(value: Any) -> Any:
    """Return the content of the project file with infinity as the text "inf": JSON has no infinity."""
    if isinstance(value, dict):
        return {key: _spelt(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_spelt(each) for each in value]
    return "inf" if value == math.inf else value


def _states(project: Project) -> Iterable[tuple[str, Settlement | None]]:
    """Yield the states by name: the original one where an analysis needs it, then the settled ones."""
    if project.pushover or project.history or project.incremental or project.campaign or project.mechanism:
        yield ORIGINAL, None
    for s in project.settlements:
        yield (
            s.name,
            Settlement(
                support=s.support,
                displacement_m=list(s.displacement_m),
                rotation_rad=s.rotation_rad,
                increment_m=s.increment_m,
            ),
        )


def _loads(project: Project, a: Assembly) -> list[LayerLoads]:
    """Return the vertical loads of each layer with movable blocks, all its blocks together, as they are combined."""
    found = []
    for layer in sorted({block.layer for block, moves in zip(a.blocks, a.movable, strict=True) if moves}):
        own = [block for block in a.blocks if block.layer == layer]
        given = project.layers.get(layer) or LayerTable()
        variable = len(own) * given.variable_load_kN
        combined = sum(block.weight for block in own)
        loads = sum(block.vertical_load for block in own)
        found.append(
            LayerLoads(
                layer=layer,
                blocks=len(own),
                own_weight_kN=combined - loads,
                permanent_load_kN=len(own) * given.vertical_load_kN,
                variable_load_kN=variable,
                use_category=given.use_category,
                psi_2=psi_2(given.use_category, given.psi_2) if variable else None,
                combined_kN=combined,
                seismic_weight_kN=GRAVITY * sum(block.mass for block in own),
            )
        )
    return found


def _geometry(project: Project, a: Assembly) -> Geometry:
    """Return blocks, control points and joints as drawn."""
    return Geometry(
        blocks=[
            Block(
                vertices_m=block.polygon.tolist(),
                centroid_m=block.centroid.tolist(),
                depth_m=block.depth,
                layer=block.layer,
                handle=block.handle,
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
