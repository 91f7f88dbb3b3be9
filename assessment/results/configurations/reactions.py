"""Reactions of the supports at rest and at the activation of every mechanism, and their balance with the loads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from assessment.results.configurations.hand_check import weights
from assessment.results.configurations.joint_states import Situation, joint_states, loaded, situations
from assessment.results.configurations.ties import tie_ends, ties_of
from assessment.results.schema import Results
from assessment.results.table import Row, Table, sense
from mechanics.types import Array

NOISE = 1e-6  # of the weight: a force no larger is within the tolerance of equilibrium
WHERE = ("state", "direction", "contacts", "alpha")
REACTIONS = (*WHERE, "support", "reaction_x_kN", "reaction_z_kN")
BALANCE = (*WHERE, "reaction_x_kN", "load_x_kN", "reaction_z_kN", "load_z_kN", "unbalanced")
JOINTS = (
    "state",
    "direction",
    "contacts",
    "joint",
    "block_a",
    "block_b",
    "normal_kN",
    "shear_kN",
    "eccentricity_m",
    "contact_length_m",
    "edge_pressure_kN_m2",
    "uncrushed_pressure_kN_m2",
    "opening_1_m",
    "opening_2_m",
    "slip_m",
    "condition",
)


@dataclass(frozen=True)
class Balance:
    """Sum of the reactions and of the loads (2,) kN in a situation, and the weight of the blocks that move, kN."""

    situation: Situation
    reaction: Array
    load: Array
    weight: float

    @property
    def unbalanced(self) -> float:
        """The larger component of what is left over, per weight."""
        return float(abs(self.reaction + self.load).max() / self.weight)


def reactions(results: Results) -> Table:
    """List the force of each support on the structure in every situation whose joint forces are known."""
    rows = [
        _where(each) | {"support": support} | _components("reaction", force, results.model.weight_kN)
        for each in situations(results)
        for support, force in _forces(results, each)
    ]
    return Table("reactions", rows, REACTIONS)


def balance(results: Results) -> Table:
    """Set the sum of the reactions against the loads, worked out from outlines, depths and unit weights.

    `unbalanced` is the larger component of what is left over, per weight.
    """
    rows = [
        _where(each.situation)
        | _components("reaction", each.reaction, each.weight)
        | _components("load", each.load, each.weight)
        | {"unbalanced": each.unbalanced}
        for each in balances(results)
    ]
    return Table("balance", rows, BALANCE)


def balances(results: Results) -> Iterator[Balance]:
    """Yield the balance of every situation whose joint forces are known."""
    movable = np.array([block.support is None for block in results.geometry.blocks])
    dead, seismic = (float(each[movable].sum()) for each in weights(results))
    for each in situations(results):
        total = sum((force for _, force in _forces(results, each)), np.zeros(2))
        along = each.alpha * seismic * sense(each.direction or "+x")
        yield Balance(each, total, np.array([along, -dead]), dead)


def joint_table(results: Results) -> Table:
    """List what every joint does at rest, in every mechanism and at every elastic peak (see JointStates).

    Numbers beyond those of the drawing are pairs of faces that met as blocks moved.
    """
    rows: list[Row] = []
    for each in loaded(results):
        states = joint_states(results, each)
        for number, (a, b) in enumerate(states.blocks.tolist()):
            values = {
                "normal_kN": states.normal[number],
                "shear_kN": states.shear[number],
                "eccentricity_m": states.eccentricity[number],
                "contact_length_m": states.contact[number],
                "edge_pressure_kN_m2": states.pressure[number],
                "uncrushed_pressure_kN_m2": states.uncrushed[number],
                "opening_1_m": states.opening[number, 0],
                "opening_2_m": states.opening[number, 1],
                "slip_m": states.slip[number],
            }
            rows.append(
                {
                    "state": each.state,
                    "direction": each.direction,
                    "contacts": each.contacts,
                    "joint": number,
                    "block_a": a,
                    "block_b": b,
                    **{key: float(value) for key, value in values.items()},
                    "condition": states.condition[number],
                }
            )
    return Table("joints", rows, JOINTS)


def _forces(results: Results, situation: Situation) -> Iterator[tuple[str, Array]]:
    """Yield each support and its force (2,) kN on the structure."""
    blocks, states = results.geometry.blocks, joint_states(results, situation)
    pulls = list(tie_pulls(results, situation))
    for support in sorted({block.support for block in blocks if block.support}):
        total = np.zeros(2)
        for force, pair in zip(states.force, states.blocks.tolist(), strict=True):
            first, second = (blocks[block].support == support for block in pair)
            total += float(second) * force - float(first) * force
        for force, pair in pulls:
            first, second = (blocks[block].support == support for block in pair)
            total += float(second) * force - float(first) * force
        yield support, total


def tie_pulls(results: Results, situation: Situation) -> Iterator[tuple[Array, list[int]]]:
    """Yield of each tie of a situation its force (2,) kN on the first of its blocks, and these."""
    ties = ties_of(results, situation.state)
    for tie, tension in zip(ties, situation.tension, strict=len(situation.tension) > 0):
        start, end = tie_ends(results, tie, situation.configuration)
        yield tension * (end - start) / np.hypot(*(end - start)), tie.blocks


def _components(name: str, force: Array, weight: float) -> Row:
    """Return the components of a force (2,) kN; 0 for one that is no more than rounding beside the weight (kN)."""
    x, z = np.where(abs(force) <= NOISE * weight, 0.0, force).tolist()
    return {f"{name}_x_kN": x, f"{name}_z_kN": z}


def _where(situation: Situation) -> Row:
    return {
        "state": situation.state,
        "direction": situation.direction,
        "contacts": situation.contacts,
        "alpha": situation.alpha,
    }
