"""Tables by which equilibrium is checked: reactions of the supports and their balance, joints, the hand check."""

from collections.abc import Iterator

import numpy as np

from assessment.report.tables.rows import Found, table
from assessment.results.configurations import hand_check as by_hand
from assessment.results.configurations.frames import tie_ends, ties_of
from assessment.results.configurations.joint_states import Situation, joint_states, loaded, situations
from assessment.results.schema import Results
from assessment.results.table import Row, sense
from mechanics.types import Array

NOISE = 1e-6  # of the weight: a force no larger is within the tolerance of equilibrium
WHERE = "state direction contacts alpha"
JOINT = "joint block_a block_b normal_kN shear_kN eccentricity_m contact_length_m edge_pressure_kN_m2"
JOINT += " uncrushed_pressure_kN_m2 opening_1_m opening_2_m slip_m condition"


@table("reactions", f"{WHERE} support reaction_x_kN reaction_z_kN")
def reactions(results: Results) -> Found:
    """List the force of each support on the structure in every situation whose joint forces are known."""
    for each in situations(results):
        for support, force in _forces(results, each):
            own = _components("reaction", force, results.model.weight_kN)
            yield _where(each) | {"support": support} | own


@table("balance", f"{WHERE} reaction_x_kN load_x_kN reaction_z_kN load_z_kN unbalanced")
def balance(results: Results) -> Found:
    """Set the sum of the reactions against the loads, worked out from outlines, depths and unit weights.

    `unbalanced` is the larger component of what is left over, per weight of the blocks that move.
    """
    movable = np.array([block.support is None for block in results.geometry.blocks])
    weight, seismic = (float(each[movable].sum()) for each in by_hand.weights(results))
    for each in situations(results):
        reaction = sum((force for _, force in _forces(results, each)), np.zeros(2))
        load = np.array([each.alpha * seismic * sense(each.direction or "+x"), -weight])
        row = _where(each) | _components("reaction", reaction, weight) | _components("load", load, weight)
        yield row | {"unbalanced": float(abs(reaction + load).max() / weight)}


@table("joints", f"{WHERE.removesuffix(' alpha')} {JOINT}")
def joint_table(results: Results) -> Found:
    """List what every joint does at rest, in every mechanism and at every elastic peak (see JointStates).

    Numbers beyond those of the drawing are pairs of faces that met as blocks moved.
    """
    for each in loaded(results):
        s = joint_states(results, each)
        forces = [s.normal, s.shear, s.eccentricity, s.contact, s.pressure, s.uncrushed]
        numbers = np.column_stack([np.arange(len(s.blocks)), s.blocks]).tolist()
        values = zip(
            numbers, np.column_stack([*forces, s.opening, s.slip]).tolist(), s.condition, strict=True
        )
        for number, value, condition in values:
            yield _where(each) | dict(zip(JOINT.split(), (*number, *value, condition), strict=True))


@table("macro_blocks", by_hand.MacroBlockFigures)
def macro_block_table(results: Results) -> Found:
    """List the macro-blocks of every mechanism."""
    for name, direction, _ in by_hand.mechanisms(results):
        yield from by_hand.figures_of(results, name, direction)


# the program's multiplier beside virtual work over all its blocks, and over the macro-blocks as printed
hand_check = table("hand_check", by_hand.HandCheck)(by_hand.hand_checks)


def _forces(results: Results, situation: Situation) -> Iterator[tuple[str, Array]]:
    """Yield each support and its force (2,) kN on the structure."""
    blocks, states = results.geometry.blocks, joint_states(results, situation)
    ties = ties_of(results, situation.state)
    pulls = []
    for tie, tension in zip(ties, situation.tension, strict=len(situation.tension) > 0):
        start, end = tie_ends(results, tie, situation.configuration)
        pulls.append((tension * (end - start) / np.hypot(*(end - start)), tie.blocks))
    for support in sorted({block.support for block in blocks if block.support}):
        total = np.zeros(2)
        for force, pair in [*zip(states.force, states.blocks.tolist(), strict=True), *pulls]:
            first, second = (blocks[block].support == support for block in pair)
            total += float(second) * force - float(first) * force
        yield support, total


def _components(name: str, force: Array, weight: float) -> Row:
    """Return the components of a force (2,) kN; 0 for one that is no more than rounding beside the weight (kN)."""
    x, z = np.where(abs(force) <= NOISE * weight, 0.0, force).tolist()
    return {f"{name}_x_kN": x, f"{name}_z_kN": z}


def _where(situation: Situation) -> Row:
    return {name: getattr(situation, name) for name in WHERE.split()}
