"""Contradictions in [[tie]] and [[strengthening]]."""

from __future__ import annotations

from collections.abc import Iterator

from assessment.project.consistency.names import repeated_names, unknown_name
from assessment.project.errors import Problem
from assessment.project.schema import ChangedLayerTable, KeyPath, ProjectContent, TieTable

SHORTEST = 1e-6  # m, of a tie


def tie_problems(project: ProjectContent) -> Iterator[Problem]:
    """Yield a problem for each tie that joins nothing, is set beyond its yield force, or names no state."""
    yield from repeated_names("tie", [tie.name for tie in project.tie])
    for index, tie in enumerate(project.tie):
        path: KeyPath = ("tie", index)
        if _length(tie) < SHORTEST:
            yield Problem((*path, "to_m"), "the same point as from_m; write the point of another block")
        if tie.pretension_kN >= tie.yield_force_kN:
            text = (
                f"{tie.pretension_kN:g} kN is not below yield_force_kN = {tie.yield_force_kN:g}, and the tie would "
                "yield as it is set; write less"
            )
            yield Problem((*path, "pretension_kN"), text)
        for place, name in enumerate(tie.states or ()):
            yield from unknown_name((*path, "states", place), name, project.states, "state")
            made = project.strengthening_of(name)
            if made and made.of in (tie.states or ()):
                text = f'the tie is in "{made.of}" already, which "{name}" strengthens; name one of the two'
                yield Problem((*path, "states", place), text)


def strengthening_problems(project: ProjectContent) -> Iterator[Problem]:
    """Yield a problem for each strengthening of no state, of a name that another state has, or that changes nothing."""
    yield from repeated_names("strengthening", [each.name for each in project.strengthening])
    for index, made in enumerate(project.strengthening):
        path: KeyPath = ("strengthening", index)
        if made.name in project.unstrengthened:
            yield Problem((*path, "name"), f'"{made.name}" is the name of another state; write another')
            continue
        if project.strengthening_of(made.of):
            text = f'"{made.of}" is a strengthening itself; write the state that it is of, and name its ties here too'
            yield Problem((*path, "of"), text)
        else:
            yield from unknown_name((*path, "of"), made.of, project.unstrengthened, "state to strengthen")
        for layer, table in made.layers.items():
            if not _changes(table):
                text = "changes nothing; write what it makes of the joints, or leave it out"
                yield Problem((*path, "layers", layer), text)
        if not made.layers and not project.ties_of(made.name)[1]:
            text = f'changes nothing; add a [[tie]] with states = ["{made.name}"], or [strengthening.layers.NAME]'
            yield Problem(path, text)
    if project.strengthening and not (project.pushover or project.history or project.incremental):
        text = "nothing pushes or shakes the strengthened state; add [pushover], [[history]] or [incremental]"
        yield Problem(("strengthening",), text)


def _changes(table: ChangedLayerTable) -> bool:
    return any(getattr(table, key) is not None for key in type(table).model_fields)


def _length(tie: TieTable) -> float:
    return max(abs(one - other) for one, other in zip(tie.from_m, tie.to_m, strict=True))
