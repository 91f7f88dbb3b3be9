"""Tables of mechanisms: those of the analysis, by two programs, and together with those that the engineer chose."""

from __future__ import annotations

from markupsafe import Markup

from assessment.ntc.limit_states import LINEAR
from assessment.report.tables.capacity import capacities, mechanism_text
from assessment.report.text.language import Words
from assessment.report.text.quantities import WHOLE
from assessment.results.configurations.hand_check import macro_blocks, rigid_push
from assessment.results.configurations.hand_check import mechanisms as found_mechanisms
from assessment.results.schema import Results
from assessment.results.schema.checks import Capacity, Direction, GivenMechanism
from assessment.results.schema.part import Configuration, present
from assessment.results.schema.static import SecondSolver
from assessment.results.table import Row, Table, cells

ALL = (
    "macro_element",
    "mechanism",
    "state",
    "direction",
    "alpha_0",
    "alpha_onset",
    "a_0_star_g",
    "d_0_star_m",
    "ratio_SLV_linear",
    "zeta_SLV",
    "zeta_SLC",
)
MOVES = 1e-6  # of the largest displacement
RATIOS = {"ratio_SLV_linear": "SLV linear", "zeta_SLV": "SLV", "zeta_SLC": "SLC"}
OTHER_LAW = ("alpha_0_coulomb", "alpha_0_associative")
SECOND_SOLVER = ("alpha_0", "alpha_program", "alpha_linear_program", "relative_difference")


def mechanisms(results: Results) -> Table:
    """List the rigid mechanism of every state and direction.

    It is that of α0, beside it that by the other law of friction where the two differ; where the control point takes no
    part in that mechanism, `mechanism_alpha` is the multiplier at which the one listed is activated.
    """
    rows = []
    for name, direction, rigid in found_mechanisms(results):
        mechanism = rigid.mechanism
        rows.append(
            {"state": name, "direction": direction, "alpha_0": rigid.alpha_0}
            | ({} if mechanism.alpha == rigid.alpha_0 else {"mechanism_alpha": mechanism.alpha})
            | ({f"alpha_0_{other.sliding}": other.alpha_0} if (other := rigid.other_law) else {})
            | cells(mechanism, ("hinges", "moving_weight_kN", "e_star", "gamma_star"))
            | {"sliding_joints": len(mechanism.sliding_joints)}
        )
    named = [key for key in (*OTHER_LAW, "mechanism_alpha") if any(key in each for each in rows)]
    columns = ("hinges", "sliding_joints", "moving_weight_kN", "e_star", "gamma_star")
    return Table("mechanisms", rows, ("state", "direction", "alpha_0", *named, *columns))


def second_solver(results: Results) -> Table:
    """List the multipliers of limit analysis by two programs, beside α0 and the friction law of its curve.

    Where an ensemble was run α0 is the least of it, and what is compared is the state's own run: `alpha_own_run`.
    """
    rows = [
        {
            "state": name,
            "direction": direction,
            "sliding": rigid.sliding,
            **_compared(rigid.second_solver),
        }
        for name, direction, rigid in found_mechanisms(results)
        if rigid.second_solver
    ]
    return Table(
        "second_solver", rows, ("state", "direction", "sliding", "alpha_own_run", *SECOND_SOLVER[1:])
    )


def reported_second_solver(results: Results, words: Words) -> Table:
    """Return the table as the report has it: without the friction law, and the difference in two digits."""
    rows: list[Row] = []
    for name, direction, rigid in found_mechanisms(results):
        if pair := rigid.second_solver:
            apart = pair.relative_difference
            shown = None if apart is None else Markup.escape(words.number(apart, 2))
            row = {"state": name, "direction": direction, **_compared(pair)}
            rows.append(row | {"relative_difference": shown})
    return Table("second_solver", rows, ("state", "direction", "alpha_own_run", *SECOND_SOLVER[1:]))


COUNTED = 10  # hinges that have a word


def mechanism_name(results: Results, state: str, direction: Direction, words: Words) -> str:
    """Name the rigid mechanism of a state: overturning, sliding, of so many hinges or parts, and of which layers."""
    rigid = rigid_push(results, state, direction)
    parts = macro_blocks(results, state, direction)
    turning = sum(bool(part.rotation) for part in parts)
    hinges = rigid.mechanism.hinges
    if not turning:
        name = words.plain("mechanism.sliding")
    elif turning == 1:
        name = words.plain("mechanism.overturning")
    elif hinges <= COUNTED:
        name = words.plain("mechanism.hinges", count=words.plain(f"mechanism.n{hinges}"))
    else:
        name = words.plain("mechanism.parts", count=turning)
    if turning and rigid.mechanism.sliding_joints:
        name = words.plain("mechanism.and_sliding", name=name)
    element = macro_element(results, rigid.mechanism.displacements)
    return name if element == WHOLE else f"{name} ({element})"


def _compared(pair: SecondSolver) -> Row:
    return {"alpha_own_run": pair.alpha_0, **cells(pair, SECOND_SOLVER[1:])}


def all_mechanisms(results: Results) -> Table:
    """List every mechanism that has a capacity: its macro-element, which are the layers that move, and its ratios.

    Found ones are named by their hinges and sliding joints.
    """
    by_element: dict[str, list[Row]] = {}
    for name, direction, capacity in capacities(results):
        pushover = results.states[name].pushover.get(direction)
        if pushover and pushover.rigid:
            element = macro_element(results, pushover.rigid.mechanism.displacements)
            row = _row(element, mechanism_text(capacity.mechanism), name, direction, capacity)
            by_element.setdefault(element, []).append(row)
    for given in results.mechanisms or []:
        if given.direction and given.displacements:
            element = macro_element(results, given.displacements)
            row = _row(element, given.name, given.state, given.direction, given)
            by_element.setdefault(element, []).append(row)
    return Table("all_mechanisms", [row for _, rows in sorted(by_element.items()) for row in rows], ALL)


def _row(
    element: str, mechanism: str, state: str, direction: Direction, found: Capacity | GivenMechanism
) -> Row:
    checks = found.checks
    onset = started = None
    if isinstance(found, GivenMechanism):
        started = found.a_0_star_g
    elif linear := next((checks[name] for name in LINEAR if name in checks), None):
        onset, started = linear.alpha_0, linear.a_star_g
    numbers = {
        "macro_element": element,
        "mechanism": mechanism,
        "state": state,
        "direction": direction,
        "alpha_0": found.alpha_0,
        "alpha_onset": onset,
        "a_0_star_g": started,
        "d_0_star_m": found.d_0_star_m,
    }
    numbers |= {key: checks[check].zeta_E for key, check in RATIOS.items() if check in checks}
    return present(numbers)


def macro_element(results: Results, displacements: Configuration) -> str:
    """Return the layers whose blocks move in a mechanism; WHOLE where all do that can."""
    size = [max(abs(x), abs(z)) for x, z, _ in displacements]
    least = MOVES * max(size)
    blocks = results.geometry.blocks
    movable = {block.layer for block in blocks if block.support is None}
    moving = {
        block.layer
        for block, moved in zip(blocks, size, strict=True)
        if moved > least and block.support is None
    }
    return WHOLE if moving == movable else ", ".join(sorted(moving))
