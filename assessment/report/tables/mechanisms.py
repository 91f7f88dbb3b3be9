"""One table of all mechanisms, those found by analysis and those chosen by the engineer, by macro-element."""

from __future__ import annotations

from assessment.ntc.limit_states import LINEAR
from assessment.report.tables.capacity import capacities, mechanism_text
from assessment.results.schema import Results
from assessment.results.schema.checks import Capacity, Direction, GivenMechanism
from assessment.results.schema.part import Configuration, present
from assessment.results.table import Row, Table

ALL = (
    "macro_element",
    "mechanism",
    "state",
    "direction",
    "alpha_0",
    "a_0_star_g",
    "d_0_star_m",
    "ratio_SLV_linear",
    "zeta_SLV",
    "zeta_SLC",
)
WHOLE = "*"  # the macro-element of a mechanism in which every layer moves
MOVES = 1e-6  # of the largest displacement
RATIOS = {"ratio_SLV_linear": "SLV linear", "zeta_SLV": "SLV", "zeta_SLC": "SLC"}


def all_mechanisms(results: Results) -> Table:
    """List every mechanism that has a capacity: its macro-element, which are the layers that move, and its ratios.

    Found ones are named by their hinges and sliding joints.
    """
    rows: list[Row] = []
    for name, direction, capacity in capacities(results):
        pushover = results.states[name].pushover.get(direction)
        if pushover and pushover.rigid:
            found = mechanism_text(capacity.mechanism)
            rows.append(
                _row(results, found, name, direction, pushover.rigid.mechanism.displacements, capacity)
            )
    rows += [
        _row(results, given.name, given.state, given.direction, given.displacements, given)
        for given in results.mechanisms or []
        if given.direction and given.displacements
    ]
    return Table("all_mechanisms", sorted(rows, key=lambda row: str(row["macro_element"])), ALL)


def _row(
    results: Results,
    mechanism: str,
    state: str,
    direction: Direction,
    displacements: Configuration,
    found: Capacity | GivenMechanism,
) -> Row:
    checks = found.checks
    if isinstance(found, GivenMechanism):
        started = found.a_0_star_g
    else:
        started = next((checks[name].a_star_g for name in LINEAR if name in checks), None)
    numbers = {
        "macro_element": macro_element(results, displacements),
        "mechanism": mechanism,
        "state": state,
        "direction": direction,
        "alpha_0": found.alpha_0,
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
