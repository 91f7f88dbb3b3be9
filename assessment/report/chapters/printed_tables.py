"""The tables that the report prints, each as far as it is needed there; the CSV files have them whole."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from importlib.resources import files

from markupsafe import Markup

from assessment.ntc.demand.return_period import EXCEEDANCE, USE_COEFFICIENT, return_period
from assessment.report.chapters.grid import Grid, grid, ranges_grid
from assessment.report.tables import capacity as capacity_tables
from assessment.report.tables import index as tables
from assessment.report.tables.campaign import measures, reported_campaign
from assessment.report.tables.convergence import convergence_tables, reported
from assessment.report.tables.dynamic import (
    energy,
    histories,
    incremental,
    incremental_states,
    static_dynamic,
)
from assessment.report.tables.dynamic import ranges as history_ranges
from assessment.report.tables.identification import reported_identification
from assessment.report.tables.indices import knowledge, reported_indices, reported_interventions
from assessment.report.tables.ranges import ranges
from assessment.report.tables.structure.cracks import reported_cracks, survey_table
from assessment.report.tables.structure.joints import reported_pressures
from assessment.report.tables.structure.loads import reported_loads
from assessment.report.tables.structure.mechanisms import (
    all_mechanisms,
    mechanism_name,
    mechanisms,
    reported_second_solver,
)
from assessment.report.tables.structure.ties import shaken_ties, tie_demands, tie_tensions, ties
from assessment.report.tables.studies import reported_studies
from assessment.report.tables.synthesis import index_limit, index_of, least_row
from assessment.report.text.input_table import echoed
from assessment.report.text.language import Words, direction_name
from assessment.report.text.quantities import check_name
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
from assessment.results.schema.part import present
from assessment.results.table import Row, Table, cells, reference_of

SIGNIFICANT = {"hand_check": 4, "second_solver": 5}  # digits of tables that show how near two values are
CHECKED = (
    *("direction", "limit_state", "d_star_m", "a_star_g", "T_s", "pga_g", "demand_pga_g", "zeta_E"),
    *("return_period_years", "verified", "governing"),
)


def printed_tables(results: Results, words: Words) -> dict[str, Grid]:
    """Return the tables of the report that have rows, by name."""
    reference = reference_of(results)
    found = {
        table.name: grid(
            table, words, words(f"caption.{table.name}"), SIGNIFICANT.get(table.name, 3), reference
        )
        for table in _tables(results, words)
        if table.rows
    }
    if scattering := list(ranges(results)):
        found["static_ranges"] = ranges_grid(scattering, words, reference)
    return found


def _tables(results: Results, words: Words) -> list[Table]:
    """Return the tables of the report, also those without rows."""
    return [
        _validation(words),
        _without(tables.layers(results), *(["vertical_load_kN"] if results.loads else [])),
        reported_loads(results, words),
        ties(results),
        *reported_identification(results),
        tables.settlements(results),
        reported_cracks(results),
        survey_table(results),
        _mechanisms(results, words),
        tie_tensions(results),
        tie_demands(results),
        reactions(results),
        balance(results),
        reported_pressures(results),
        _action(results),
        *reported_indices(results),
        reported_interventions(results, words),
        _interventions(results),
        knowledge(results),
        _without(capacity_tables.chosen_mechanisms(results), "refused"),
        capacity_tables.chosen_checks(results),
        all_mechanisms(results),
        capacity_tables.linear_checks(results),
        capacity_tables.scalings(results),
        *reported_studies(results),
        histories(results),
        history_ranges(results),
        energy(results),
        shaken_ties(results),
        incremental(results),
        incremental_states(results),
        *reported_campaign(results),
        measures(results),
        static_dynamic(results),
        *(reported(table, words) for table in convergence_tables(results)),
        tables.quality(results),
        hand_check(results),
        reported_second_solver(results, words),
        Table("echo", list(echoed(printed(results.echo), words)), ("table", "setting", "value")),
    ]


def check_grids(results: Results, words: Words) -> Iterator[Grid]:
    """Yield the checks of each state: every direction and limit state, the vertical component with them."""
    whole = capacity_tables.verification(results)
    surface = all(row.get("pga_g") is not None for row in whole.rows if row.get("a_g_g") is not None)
    columns = [name if surface else name.replace("pga", "a_g") for name in CHECKED]
    columns = [name for name in columns if any(row.get(name) is not None for row in whole.rows)]
    factor = words.number((results.echo.assessment or {}).get("confidence_factor", 1.0))
    for name, state in results.states.items():
        own = [row for row in whole.rows if row["state"] == name]
        made = [row for row in own if row["direction"] in state.capacity]
        rows: list[Row] = [{key: row[key] for key in columns if key in row} for row in made]
        for direction, capacity in state.capacity.items():
            if (checked := capacity.vertical) is not None:
                label = words("value.vertical_check")
                lifted: Row = {"direction": direction, "limit_state": label, "a_star_g": checked.a_0_star_g}
                place = max(at for at, row in enumerate(rows) if row["direction"] == direction) + 1
                rows.insert(place, lifted | {"zeta_E": checked.ratio, "verified": checked.verified})
        limits = Markup("; ").join(dict.fromkeys(check_name(row["limit_state"], words) for row in own))
        rows += [
            {"direction": way, "limit_state": limits, "zeta_E": None, "verified": None}
            for way in dict.fromkeys(row["direction"] for row in own if row not in made)
        ]
        if rows:
            caption = words("caption.checks", state=words.state(name), factor=factor)
            yield grid(Table("checks", rows, tuple(columns)), words, caption, reference=reference_of(results))


def macro_block_grids(results: Results, words: Words, most: int = BY_HAND) -> Iterator[Grid]:
    """Yield the macro-blocks of each state's weakest direction, `most` or fewer, with the sums of the virtual work."""
    for name, direction in governing_mechanisms(results):
        figures = figures_of(results, name, direction)
        if len(figures) <= most:
            where = {"state": words.state(name), "direction": direction_name(direction)}
            table = virtual_work_table(figures, ties_in(results, name, direction))
            yield grid(table, words, words("caption.macro_blocks", **where), 4)


def _mechanisms(results: Results, words: Words) -> Table:
    """Return the mechanisms by name, with the multiplier of the first motion beside the largest."""
    table = mechanisms(results)
    rows = []
    for row in table.rows:
        rigid = results.states[row["state"]].pushover[row["direction"]].rigid
        named = Markup.escape(mechanism_name(results, row["state"], row["direction"], words))
        rows.append(row | {"mechanism": named} | (cells(rigid, ["alpha_onset"]) if rigid else {}))
    kept = [name for name in table.columns if name not in {"hinges", "sliding_joints", "sliding_residual"}]
    return Table("mechanisms", rows, (*kept[:2], "mechanism", "alpha_onset", *kept[2:]))


def _action(results: Results) -> Table:
    """Return the demand with what the reference life follows from: P_VR and T_R of every limit state."""
    site = (results.echo.assessment or {}).get("site") or {}
    life, use = site.get("nominal_life_years"), site.get("use_class")
    table = capacity_tables.action(results)
    rows = []
    for row in table.rows:
        limit, told = row["limit_state"], {}
        if life and use in USE_COEFFICIENT and row["kind"] != "record":
            told = {"P_VR": EXCEEDANCE[limit]}
            if row.get("return_period_years") is None:
                told["return_period_years"] = return_period(limit, life, use)
        rows.append(present(row) | told)
    return Table("action", rows, ("limit_state", "kind", "P_VR", *table.columns[2:]))


def _interventions(results: Results) -> Table:
    """Return original, settled and strengthened states beside one another, each in its weakest direction."""
    limit = index_limit(results)
    strength = {tie.name: tie.yield_force_kN for tie in results.model.ties or ()}
    columns = (
        "state",
        "direction",
        "zeta_E",
        "reduction",
        "gain",
        "alpha_0",
        "d_0_m",
        "greatest_kN",
        "share_used",
        "verified",
    )
    rows: list[Row] = []
    for name in results.states:
        if (least := least_row(results, name)) is None:
            rows.append({"state": name})
            continue
        check = index_of(least, limit)
        row: Row = {
            "state": name,
            "direction": least.direction,
            "alpha_0": least.alpha_0,
            "d_0_m": least.d_0_m,
        }
        if check:
            row |= present(
                {
                    "zeta_E": check.zeta_E,
                    "reduction": check.loss,
                    "gain": check.gain,
                    "verified": check.verified,
                }
            )
        pulled = [
            (each.greatest_kN, each.tie)
            for pushed in results.states[name].pushover.values()
            for push in pushed.by_contacts.values()
            for each in push.ties or ()
            if each.greatest_kN is not None
        ]
        if pulled:
            force, tie = max(pulled)
            row["greatest_kN"] = force
            row |= {"share_used": force / limit_kN} if (limit_kN := strength[tie]) else {}
        rows.append(present(row))
    return Table("compared", rows if results.strengthening else [], columns)


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
