"""The tables that the report prints, each as far as it is needed there; the CSV files have them whole."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from importlib.resources import files

from markupsafe import Markup

from assessment.report.chapters.grid import Grid, grid, ranges_grid, strengthening_grid
from assessment.report.tables import capacity as capacity_tables
from assessment.report.tables import index as tables
from assessment.report.tables.campaign import reported_campaign
from assessment.report.tables.convergence import convergence_tables, reported
from assessment.report.tables.dynamic import (
    energy,
    histories,
    incremental,
    incremental_states,
    static_dynamic,
)
from assessment.report.tables.dynamic import (
    ranges as history_ranges,
)
from assessment.report.tables.identification import reported_identification
from assessment.report.tables.indices import knowledge, reported_indices, reported_interventions
from assessment.report.tables.ranges import ranges
from assessment.report.tables.structure.cracks import reported_cracks
from assessment.report.tables.structure.joints import reported_pressures
from assessment.report.tables.structure.loads import reported_loads, vertical
from assessment.report.tables.structure.mechanisms import all_mechanisms, mechanisms, reported_second_solver
from assessment.report.tables.structure.ties import shaken_ties, tie_tensions, ties
from assessment.report.tables.studies import reported_studies
from assessment.report.text.input_table import echoed
from assessment.report.text.language import Words, direction_name
from assessment.results.configurations.hand_check import (
    BY_HAND,
    figures_of,
    governing_mechanisms,
    hand_check,
    ties_in,
    virtual_work_table,
)
from assessment.results.configurations.reactions import balance, reactions
from assessment.results.echo import printed
from assessment.results.schema import Results
from assessment.results.table import COMPARISON, Row, Table, cells, reference_of

SIGNIFICANT = {"hand_check": 4, "second_solver": 8}  # digits of tables that show how near two values are


def printed_tables(results: Results, words: Words) -> dict[str, Grid]:
    """Return the tables of the report that have rows, by name."""
    made = _tables(results, words)
    found = {
        table.name: grid(
            table,
            words,
            words(f"caption.{table.name}"),
            SIGNIFICANT.get(table.name, 3),
            reference_of(results),
        )
        for table in made
        if table.rows
    }
    if results.strengthening:
        found["strengthening"] = strengthening_grid(results, words)
    if scattering := list(ranges(results)):
        found["static_ranges"] = ranges_grid(scattering, words, reference_of(results))
    return found


def _tables(results: Results, words: Words) -> list[Table]:
    """Return the tables of the report in the order of its chapters, also those without rows."""
    return [
        _validation(words),
        _without(tables.layers(results), *(["vertical_load_kN"] if results.loads else [])),
        reported_loads(results, words),
        ties(results),
        *reported_identification(results),
        tables.settlements(results),
        reported_cracks(results),
        mechanisms(results),
        tie_tensions(results),
        reactions(results),
        balance(results),
        reported_pressures(results),
        _without(capacity_tables.verification(results), *capacity_tables.BEHIND),
        capacity_tables.verification_surface(results),
        capacity_tables.action(results),
        *reported_indices(results),
        reported_interventions(results, words),
        knowledge(results),
        _without(capacity_tables.chosen_mechanisms(results), "refused"),
        capacity_tables.chosen_checks(results),
        all_mechanisms(results),
        capacity_tables.linear_checks(results),
        vertical(results),
        capacity_tables.scalings(results),
        Table("comparison", _compared(results), COMPARISON),
        *reported_studies(results),
        histories(results),
        history_ranges(results),
        energy(results),
        shaken_ties(results),
        incremental(results),
        incremental_states(results),
        *reported_campaign(results),
        static_dynamic(results),
        *(reported(table, words) for table in convergence_tables(results)),
        tables.quality(results),
        hand_check(results),
        reported_second_solver(results, words),
        Table("echo", list(echoed(printed(results.echo), words)), ("table", "setting", "value")),
    ]


def macro_block_grids(results: Results, words: Words, most: int = BY_HAND) -> Iterator[Grid]:
    """Yield the macro-blocks of each state's weakest direction, `most` or fewer, with the sums of the virtual work."""
    for name, direction in governing_mechanisms(results):
        figures = figures_of(results, name, direction)
        if len(figures) > most:
            continue
        caption = words("caption.macro_blocks", state=words.state(name), direction=direction_name(direction))
        table = virtual_work_table(figures, ties_in(results, name, direction))
        yield grid(table, words, caption, 4)


def _validation(words: Words) -> Table:
    """Return the validation table of this version; tests compute every row again."""
    cases = tomllib.loads((files("templates") / "validation.toml").read_text(encoding="utf-8"))["case"]
    rows = [
        {
            **{name: Markup(text) for name, text in case[words.language].items()},
            "expected": words.comma(case["expected"]),
            "computed": words.comma(case["computed"]),
        }
        for case in cases
    ]
    return Table("validation", rows, ("case", "source", "expected", "computed"))


def _without(table: Table, *columns: str) -> Table:
    """Return the table without some columns, and without the rows that have nothing else but what they are called."""
    kept = tuple(column for column in table.columns if column not in columns)
    rows = [{key: value for key, value in row.items() if key in kept} for row in table.rows]
    return Table(table.name, [row for row in rows if len(row) > 2], kept)


def _compared(results: Results) -> list[Row]:
    """Return the comparison of the settled states, without dynamic columns where no dynamic analysis was made.

    What strengthens a state is no loss due to a settlement: those states have a table of their own.
    """
    static_only = all(each.dynamic_pga_g is None for each in results.comparison)
    kept = [key for key in COMPARISON if not (static_only and key.startswith("dynamic"))]
    settled = [each for each in results.comparison if not results.states[each.state].strengthening]
    return [cells(each, kept) for each in settled]
