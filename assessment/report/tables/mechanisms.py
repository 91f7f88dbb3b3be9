"""Tables of mechanisms, found, chosen, by a second program; of equilibrium: reactions, balance, joints, hand check."""

import math
from collections.abc import Iterator

import numpy as np

from assessment.ntc.tables import LINEAR
from assessment.report.language import WHOLE, Words
from assessment.report.tables import Found, capacities, table
from assessment.report.tables.capacity import mechanism_text
from assessment.results import hand_check as by_hand
from assessment.results.frames import tie_ends, ties_of
from assessment.results.joint_states import Situation, joint_states, loaded, situations
from assessment.results.schema import Capacity, Direction, GivenMechanism, Results, RigidPush
from assessment.results.schema.part import Configuration, known, present
from assessment.results.table import Row, cells, sense
from mechanics.types import Array

MOVES = 1e-6  # of the largest displacement
RATIOS = {"ratio_SLV_linear": "SLV linear", "zeta_SLV": "SLV", "zeta_SLC": "SLC"}
MECHANISM = "hinges sliding_joints moving_weight_kN e_star gamma_star"
ALL = f"macro_element mechanism state direction alpha_0 alpha_onset a_0_star_g d_0_star_m {' '.join(RATIOS)}"
OTHER_LAW = ("alpha_0_coulomb", "alpha_0_associative")
FOUND = f"state direction alpha_0 {' '.join(f'?{key}' for key in OTHER_LAW)} ?mechanism_alpha {MECHANISM}"
SECOND_SOLVER = ("alpha_0", "alpha_program", "alpha_linear_program", "relative_difference")
COUNTED = 10  # hinges that have a word


@table("mechanisms", FOUND)
def mechanisms(results: Results) -> Found:
    """List the rigid mechanism of every state and direction.

    It is that of α0, beside it that by the other law of friction where the two differ; where the control point takes no
    part in that mechanism, `mechanism_alpha` is the multiplier at which the one listed is activated.
    """
    for name, direction, rigid in by_hand.mechanisms(results):
        found, other = rigid.mechanism, rigid.other_law
        row: Row = {"state": name, "direction": direction, "alpha_0": rigid.alpha_0}
        # where the one listed is activated, if the control point takes no part in that of α0
        row |= {} if found.alpha == rigid.alpha_0 else {"mechanism_alpha": found.alpha}
        row |= {f"alpha_0_{other.sliding}": other.alpha_0} if other else {}
        yield row | {"sliding_joints": len(found.sliding_joints)}, found


@table("second_solver", f"state direction sliding alpha_own_run {' '.join(SECOND_SOLVER[1:])}")
def second_solver(results: Results) -> Found:
    """List the multipliers of limit analysis by two programs, beside α0 and the friction law of its curve.

    Where an ensemble was run α0 is the least of it, and what is compared is the state's own run: `alpha_own_run`.
    """
    for name, direction, rigid in by_hand.mechanisms(results):
        if pair := rigid.second_solver:
            where = {"state": name, "direction": direction, "sliding": rigid.sliding}
            yield where | {"alpha_own_run": pair.alpha_0}, pair


def mechanism_name(results: Results, state: str, direction: Direction, words: Words) -> str:
    """Name the rigid mechanism of a state: overturning, sliding, of so many hinges or parts, and of which layers."""
    found = by_hand.rigid_push(results, state, direction).mechanism
    turning = sum(bool(part.omega) for part in by_hand.macro_blocks(results, state, direction))
    if not turning:
        name = words.plain("mechanism.sliding")
    elif turning == 1:
        name = words.plain("mechanism.overturning")
    elif 1 < found.hinges <= COUNTED:
        name = words.plain("mechanism.hinges", count=words.plain(f"mechanism.n{found.hinges}"))
    else:
        name = words.plain("mechanism.parts", count=turning)
    if turning and found.sliding_joints:
        name = words.plain("mechanism.and_sliding", name=name)
    element = macro_element(results, found.displacements)
    return name if element == WHOLE else f"{name} ({element})"


@table("all_mechanisms", ALL)
def all_mechanisms(results: Results) -> Found:
    """List every mechanism that has a capacity: its macro-element, which are the layers that move, and its ratios.

    Found ones are named by their hinges and sliding joints.
    """
    rows: list[Row] = []

    def add(own: Row, moved: Configuration, found: Capacity | GivenMechanism) -> None:
        ratios = {key: found.checks[check].zeta_E for key, check in RATIOS.items() if check in found.checks}
        shared = {"macro_element": macro_element(results, moved), **cells(found, ("alpha_0", "d_0_star_m"))}
        rows.append(present(own | shared | ratios))

    for name, direction, capacity in capacities(results):
        pushover = results.states[name].pushover.get(direction)
        if pushover and pushover.rigid:
            linear = next((capacity.checks[each] for each in LINEAR if each in capacity.checks), None)
            row: Row = {"alpha_onset": linear.alpha_0, "a_0_star_g": linear.a_star_g} if linear else {}
            row |= {"mechanism": mechanism_text(capacity.mechanism), "state": name, "direction": direction}
            add(row, pushover.rigid.mechanism.displacements, capacity)
    for given in results.mechanisms or []:
        if given.direction and given.displacements:
            where = {"mechanism": given.name} | cells(given, ("state", "direction", "a_0_star_g"))
            add(where, given.displacements, given)
    return sorted(rows, key=lambda row: row["macro_element"])


def macro_element(results: Results, displacements: Configuration) -> str:
    """Return the layers whose blocks move in a mechanism; WHOLE where all do that can."""
    size = [max(abs(x), abs(z)) for x, z, _ in displacements]
    blocks = zip(results.geometry.blocks, size, strict=True)
    movable = [(block.layer, moved) for block, moved in blocks if block.support is None]
    moving = {layer for layer, moved in movable if moved > MOVES * max(size)}
    return WHOLE if moving == {layer for layer, _ in movable} else ", ".join(sorted(moving))


ABOVE = 0.2  # of the elastic curve: a larger excess of the fitted curve is reported


def alpha_at_d_0(rigid: RigidPush) -> float | None:
    """Return the multiplier at d_0 where equilibrium is lost before it vanishes; None where it has vanished there."""
    left, end = rigid.curve.multiplier[-1], abs(rigid.curve.displacement_m[-1])
    ends = rigid.d_0_m is not None and math.isclose(rigid.d_0_m, end)  # an ensemble may have another run's
    return left if rigid.lost and ends and left > 0.0 else None


def elastic_capacity(results: Results, state: str, direction: Direction) -> tuple[Array, Array] | None:
    """Return d* (k,) in m and a* (k,) in g of the curve with elastic joints: d*, α/(e* F_C); None without one."""
    found = results.states[state]
    capacity, pushovers = found.capacity.get(direction), found.pushover.get(direction)
    if capacity is None or pushovers is None or pushovers.elastic is None:
        return None
    curve, d_star = pushovers.elastic.curve, pushovers.elastic.d_star_m
    if d_star is None:
        d_star = (sense(direction) * known(capacity.gamma_star) * np.asarray(curve.displacement_m)).tolist()
    factor = float((results.echo.assessment or {}).get("confidence_factor", 1.0))
    return np.asarray(d_star), np.asarray(curve.multiplier, dtype=float) / (known(capacity.e_star) * factor)


def excesses(results: Results) -> Iterator[Row]:
    """Yield where a nonlinear check takes an acceleration more than ABOVE higher than the elastic curve has there."""
    for name, direction, capacity in capacities(results):
        elastic = elastic_capacity(results, name, direction)
        for limit, check in capacity.checks.items():
            if elastic is None or check.method != "nonlinear" or not check.d_star_m or not check.a_star_g:
                continue
            d_star, a_star = elastic
            first = np.r_[True, d_star[1:] > np.maximum.accumulate(d_star)[:-1]]  # farther than ever before
            if check.d_star_m > d_star[first][-1] * (1.0 + 1e-9):  # where the curve has ended
                continue
            at = max(0.0, float(np.interp(check.d_star_m, d_star[first], a_star[first])))
            if check.a_star_g > (1.0 + ABOVE) * at:
                place: Row = {"state": name, "direction": direction, "limit_state": limit}
                yield place | {"d_star_m": check.d_star_m, "fitted_g": check.a_star_g, "elastic_g": at}


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
        told = zip(numbers, np.column_stack([*forces, s.opening, s.slip]).tolist(), s.condition, strict=True)
        for number, value, condition in told:
            yield _where(each) | dict(zip(JOINT.split(), (*number, *value, condition), strict=True))


@table("macro_blocks", by_hand.MacroBlock)
def macro_block_table(results: Results) -> Found:
    """List the macro-blocks of every mechanism."""
    for name, direction, _ in by_hand.mechanisms(results):
        yield from by_hand.macro_blocks(results, name, direction)


# the program's multiplier beside virtual work over all its blocks, and over the macro-blocks as printed
hand_check = table("hand_check", by_hand.HandCheck)(by_hand.hand_checks)


def _forces(results: Results, situation: Situation) -> Iterator[tuple[str, Array]]:
    """Yield each support and its force (2,) kN on the structure."""
    blocks, states = results.geometry.blocks, joint_states(results, situation)
    ties = ties_of(results, situation.state)
    ends = tie_ends(results, situation.state, situation.configuration)
    pulls = []
    for tie, (start, end), tension in zip(ties, ends, situation.tension, strict=len(situation.tension) > 0):
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
