"""The assembly of every state of a project: which ties are in it, and what its strengthening makes of joints."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from assessment.runtime.errors import ProjectError, nearest
from mechanics import ArgumentError, Assembly, State, Tie
from mechanics.messages import layer_key

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.schema import ChangedLayerTable, StrengtheningTable, TieTable
    from mechanics.types import Array

Kind = TypeVar("Kind", bound=np.generic)

KEYS = {  # of a changed layer, and of the material that it is
    "friction": "friction",
    "normal_stiffness_kN_m3": "normal_stiffness",
    "tangential_stiffness_kN_m3": "tangential_stiffness",
    "compressive_strength_kN_m2": "compressive_strength",
}


@dataclass(frozen=True, eq=False)
class StateModel:
    """The assembly of a state: `settling` as its support moves, or as drawn.

    `strengthened`: what is pushed and shaken where the state is a strengthening, its last ties, `later` of them, as
    long as drawn; None where nothing strengthens it.
    """

    name: str
    settling: Assembly
    strengthened: Assembly | None = None
    later: int = 0

    @property
    def assembly(self) -> Assembly:
        """What is pushed and shaken; ties that are set after the movement are as long as drawn."""
        return self.strengthened or self.settling

    def tied_at(self, reached: State | None) -> Assembly:
        """Return what is pushed and shaken from a state (None: as drawn), where the last ties are set without slack."""
        if self.strengthened is None or reached is None or not self.later:
            return self.assembly
        ties = self.strengthened.ties
        lengths = tie_lengths(self.strengthened, reached.positions)
        first = len(ties) - self.later
        taut = [replace(ties[k], length=float(lengths[k])) for k in range(first, len(ties))]
        return self.strengthened.tied((*ties[:first], *taut))

    def taken_over(self, reached: State) -> State:
        """Return the settled state as one of the strengthened assembly: ties that are set there remember nothing."""
        if self.strengthened is None or not self.later:
            return reached
        return replace(
            reached,
            shear=_longer(reached.shear, self.later),
            carrying=_longer(reached.carrying, self.later),
            forces=_longer(reached.forces, self.later),
            lengthened=_longer(reached.lengthened, self.later),
        )

    def varied(self, settling: Assembly) -> StateModel:
        """Return the model of another assembly that settles: `settling` with corners elsewhere."""
        if self.strengthened is None:
            return replace(self, settling=settling)
        blocks = [
            replace(block, vertices=other.vertices)
            for block, other in zip(self.strengthened.blocks, settling.blocks, strict=True)
        ]
        return replace(self, settling=settling, strengthened=replace(self.strengthened, blocks=blocks))


def _longer(values: NDArray[Kind] | None, count: int) -> NDArray[Kind] | None:
    """Return an array of contacts (n,) or (n, k) with zeros for `count` more at its end."""
    if values is None:
        return None
    return np.concatenate([values, np.zeros((count, *values.shape[1:]), dtype=values.dtype)])


def tie_lengths(model: Assembly, positions: Array) -> Array:
    """Return the distance (t,) m of the ends of each tie at positions (b, 3)."""
    found = []
    for tie, blocks in zip(model.ties, model.tie_blocks.tolist(), strict=True):
        ends = [
            point + model.point_displacement(point, block, positions)
            for point, block in zip(tie.points, blocks, strict=True)
        ]
        found.append(float(np.hypot(*(ends[1] - ends[0]))))
    return np.array(found)


def state_models(project: Project, drawn: Assembly) -> dict[str, StateModel]:
    """Return the assembly of every state by its name; `drawn`: blocks and joints without ties.

    Raises ProjectError naming the key for a tie that joins no two blocks, or a layer that has none.
    """
    known: dict[tuple[str, ...], Assembly] = {(): drawn}
    found = {}
    for name in project.states:
        there, later = project.ties_of(name)
        names = tuple(tie.name for tie in there)
        if names not in known:  # one assembly for all states of the same ties
            known[names] = _tied(project, drawn, there)
        made, settling = project.strengthening_of(name), known[names]
        if made is None:
            found[name] = StateModel(name, settling)
            continue
        changed = _with_changed_layers(project, settling, made)
        found[name] = StateModel(name, settling, _tied(project, changed, (*there, *later)), len(later))
    return found


def block_at(model: Assembly, key: str, point: tuple[float, float], note: str = "") -> int:
    """Return the block that contains a point (m). Raises ProjectError naming its key, with a note, where none does."""
    try:
        return model.block_at(point)
    except ArgumentError as error:
        reason = str(error).partition("must be ")[2] + note
        raise ProjectError(f"{key}: {list(point)} must be {reason}; move it there") from None


def _tied(project: Project, model: Assembly, tables: Iterable[TieTable]) -> Assembly:
    """Return the assembly with ties. Raises ProjectError for one that does not join two of its blocks."""
    ties = []
    for table in tables:
        key = f"{project.source}: tie.{table.name}"
        blocks = [block_at(model, f"{key}.{end}", getattr(table, end)) for end in ("from_m", "to_m")]
        if blocks[0] == blocks[1]:
            raise ProjectError(
                f"{key}.to_m: both ends are in block {blocks[0]}; write a point of another one"
            )
        if not model.movable[blocks].any():
            text = "both ends are in supports, between which a tie bears nothing; write a point of a movable block"
            raise ProjectError(f"{key}.to_m: {text}")
        ties.append(
            Tie(
                table.name,
                table.from_m,
                table.to_m,
                table.yield_force_kN,
                table.stiffness_kN_m,
                table.pretension_kN,
            )
        )
    return model.tied(ties)


def _with_changed_layers(project: Project, model: Assembly, made: StrengtheningTable) -> Assembly:
    """Return the assembly with the joints of some layers changed."""
    if not made.layers:
        return model
    layers = {layer_key(block.layer) for block in model.blocks}
    names = sorted({block.layer for block in model.blocks})
    number = project.strengthening.index(made) + 1
    for layer in made.layers:
        if layer_key(layer) not in layers:
            key = f"{project.source}: strengthening[{number}].layers.{layer}"
            raise ProjectError(f"{key}: no block on that layer; {nearest(layer, names)}")
    tables = {layer_key(layer): table for layer, table in made.layers.items()}
    blocks = [
        replace(block, material=replace(block.material, **_values(tables[layer_key(block.layer)])))
        if layer_key(block.layer) in tables
        else block
        for block in model.blocks
    ]
    return replace(model, blocks=blocks)


def _values(table: ChangedLayerTable) -> dict[str, float]:
    """Return what a changed layer has of its own, by the keys of a material."""
    given = {own: getattr(table, key) for key, own in KEYS.items()}
    return {key: value for key, value in given.items() if value is not None}
