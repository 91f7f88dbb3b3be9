"""Sensitivity of the capacity to the properties of the masonry: each lower and higher, in all blocks at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from itertools import product
from math import inf, isfinite
from typing import TYPE_CHECKING

from assessment.analyses.static.increments import refined
from assessment.project.schema import Table
from assessment.project.structure.model import build_model
from assessment.results.schema.studies import Sensitivity, SensitivityRun
from assessment.studies.variants import Study, Variant, analyse, quoted_limit_state
from mechanics.messages import Message, message

if TYPE_CHECKING:
    from assessment.analyses.checks.demand import Demands
    from assessment.project.project import Project
    from assessment.project.schema import SettlementTable
    from assessment.runtime.tasks import Workers

SCATTER = 0.005  # relative difference of a_g from which scatter is reported: the third digit
KEYS = {  # property: the keys of [material], [geometry] and [layers] that it stands for
    "friction": ("friction",),
    "stiffness": ("normal_stiffness_kN_m3", "tangential_stiffness_kN_m3"),
    "unit_weight": ("unit_weight_kN_m3",),
    "depth": ("depth_m",),
}
NAMES = {
    "friction": message("friction"),
    "stiffness": message("stiffness"),
    "unit_weight": message("unit weight"),
    "depth": message("depth"),
}


def sensitivity(
    project: Project, halvings: Mapping[str, int], demands: Demands, workers: Workers, study: Study
) -> Sensitivity:
    """Analyse every state with each property lower and higher; return two runs for each property, state and direction.

    `halvings`: how often the increments of each state were halved; the runs halve theirs as often, so that only the
    property differs. Messages, certificates and times go to `study`. Raises ProjectError or DrawingError where a model
    cannot be built, KilledError where a process was ended from outside.
    """
    assert project.sensitivity is not None
    factors = [(key, factor) for key, pair in project.sensitivity.factors.items() for factor in pair]
    varied = {each: with_factor(project, *each) for each in factors}
    models = {each: build_model(changed).states for each, changed in varied.items()}
    cases = list(product(factors, _states(project, halvings).items()))
    variants = [
        Variant(
            message("{property} × {factor:g}", property=NAMES[key], factor=factor),
            refined(varied[key, factor], halvings.get(state, 0)),
            models[key, factor][state],
            settlement,
        )
        for (key, factor), (state, settlement) in cases
    ]
    runs = [
        SensitivityRun(
            state=state,
            property=key,
            factor=factor,
            direction=direction,
            **capacities.model_dump(exclude_unset=True),
        )
        for ((key, factor), (state, _)), found in zip(
            cases, analyse(variants, demands, workers, study, "sensitivity"), strict=True
        )
        for direction, capacities in found.items()
    ]
    study.findings += scatter(runs, without_effect(project))
    return Sensitivity(limit_state=quoted_limit_state(project), runs=runs, warnings=list(study.warnings))


def without_effect(project: Project) -> set[str]:
    """Return the properties to which all forces are proportional, so that no capacity depends on them.

    The depth is one unless loads, or ties, are given in kN; the unit weight is one if joints neither are elastic nor
    crush.
    """
    loads = any(part.vertical_load_kN or part.variable_load_kN for part in project.parts.values())
    if loads or project.tie:
        return set()
    strengths = [part.compressive_strength_kN_m2 for part in project.parts.values()]
    crushes = any(
        isfinite(strength or inf) for strength in (project.material.compressive_strength_kN_m2, *strengths)
    )
    rigid = project.pushover is not None and project.pushover.contacts == ("rigid",) and not crushes
    return {"depth", "unit_weight"} if rigid else {"depth"}


def scatter(runs: Sequence[SensitivityRun], properties: Set[str]) -> list[Message]:
    """Return a finding for each state and direction whose a_g changes with `properties` that it cannot depend on."""
    found = []
    varied = properties & {run.property for run in runs}
    for state, direction in dict.fromkeys((run.state, run.direction) for run in runs):
        same = [
            run.a_g_g
            for run in runs
            if (run.state, run.direction) == (state, direction) and run.property in properties
        ]
        known = [value for value in same if value is not None]
        spread = (
            (max(known) - min(known)) / max(known)
            if known and len(known) == len(same)
            else float(bool(known))
        )
        if spread > SCATTER:
            found.append(
                message(
                    "sensitivity, {state}, {direction}: a_g scatters by {spread:.3g} % with {names}, on which it "
                    "cannot depend: bars of this size mean nothing; take smaller increments, and see where paths end",
                    state=state,
                    direction=direction,
                    spread=100.0 * spread,
                    names=_named(varied),
                )
            )
    return found


def _named(properties: Set[str]) -> Message:
    """Return the names of one or both of depth and unit weight."""
    return message("unit weight and depth") if len(properties) > 1 else NAMES[min(properties)]


def with_factor(project: Project, key: str, factor: float) -> Project:
    """Return the project with a property (see KEYS) times a `factor` wherever it is given; loads stay as they are."""

    def scaled(table: Table) -> Table:
        values = {name: getattr(table, name, None) for name in KEYS[key]}
        return table.model_copy(
            update={name: factor * value for name, value in values.items() if value is not None}
        )

    return project.model_copy(
        update={
            "geometry": scaled(project.geometry),
            "material": scaled(project.material),
            "layers": {name: scaled(layer) for name, layer in project.layers.items()},
            "region": tuple(map(scaled, project.region)),
            "strengthening": tuple(
                made.model_copy(
                    update={"layers": {name: scaled(layer) for name, layer in made.layers.items()}}
                )
                for made in project.strengthening
            ),
        }
    )


def _states(project: Project, halvings: Mapping[str, int]) -> dict[str, SettlementTable | None]:
    """Return the states to vary with their movements, without the search for collapse; None: as drawn."""
    assert project.sensitivity is not None
    wanted = project.sensitivity.states or project.states
    found: dict[str, SettlementTable | None] = {}
    for name in (each for each in project.states if each in wanted):
        whole = refined(project, halvings.get(name, 0)).settlement_of(name)
        found[name] = whole and whole.model_copy(update={"to_collapse": False})
    return found
