"""Tables of the indices of safety and risk, of what interventions must reach, and of the level of knowledge."""

from __future__ import annotations

from typing import Any

from assessment.report.text.language import Words
from assessment.results.schema import Results
from assessment.results.schema.part import present
from assessment.results.table import Row, Table, cells
from assessment.results.undetermined import determined_indices, undetermined

SAFETY: tuple[str, ...] = ("zeta_SLV", "zeta_SLC", "ratio_SLD", "T_SLV_years", "T_R_SLV_years", "I_S", "f_a")
SAFETY += ("acceptable_nominal_life_years",)
RISK = ("IS_V", "IS_V_class", "PAM", "PAM_class", "risk_class")
INDICES = (*SAFETY, *RISK)
HEADLINES = ("zeta_SLV", "acceptable_nominal_life_years", "IS_V", "risk_class")
INTERVENTIONS = ("improvement", "improvement_school", "retrofit_use", "retrofit")
KNOWLEDGE = ("parameter", "factor_component", "origin")


def index_tables(results: Results) -> list[Table]:
    """List the tables of indices, interventions and knowledge."""
    return [indices(results), interventions(results), knowledge(results)]


def indices(results: Results) -> Table:
    """List the indices of every state; what is not known for want of a return period is left out.

    Null: the state has no capacity in a direction.
    """
    known = {name: present(cells(found, INDICES)) for name, found in determined_indices(results).items()}
    told = {key for row in known.values() for key in row} | {"zeta_SLV", "IS_V"}
    nothing = dict.fromkeys((key for key in HEADLINES if key in told), None)
    rows: list[Row] = [{"state": name} | known.get(name, nothing) for name in _states(results)]
    return Table("indices", rows, ("state", *INDICES))


def reported_indices(results: Results) -> list[Table]:
    """Return the indices as the report prints them: those of safety apart from the classes of risk."""
    rows = indices(results).rows
    return [
        Table(
            name,
            [{key: row[key] for key in ("state", *columns) if key in row} for row in rows],
            ("state", *columns),
        )
        for name, columns in (("indices", SAFETY), ("risk", RISK))
    ]


def interventions(results: Results) -> Table:
    """List ζ_E of every state and what each kind of intervention must reach (NTC 2018, §8.4).

    Of a strengthened state that follows from ζ_E before, and whether it is attained stands behind.
    """
    known, rows = determined_indices(results), []
    for name in _states(results):
        row: Row = {"state": name, "zeta_SLV": None}
        if found := known.get(name):
            row |= {"use_class": found.use_class, "zeta_SLV": found.zeta_SLV}
            row |= cells(found, ["zeta_before"]) | present(found.required_zeta)
            row |= {f"{kind}_attained": whether for kind, whether in (found.attained or {}).items()}
        rows.append(row)
    attained = [name for name in map("{}_attained".format, INTERVENTIONS) if any(name in row for row in rows)]
    before = ["zeta_before"] if any("zeta_before" in row for row in rows) else []
    columns = ("state", "use_class", *before, "zeta_SLV", *INTERVENTIONS, *attained)
    return Table("interventions", rows, columns)


def reported_interventions(results: Results, words: Words) -> Table:
    """Return the interventions as the report prints them: behind each value whether it is attained."""
    table = interventions(results)
    rows = [
        {key: _with_outcome(key, row, words) for key in row if not key.endswith("_attained")}
        for row in table.rows
    ]
    return Table(table.name, rows, tuple(key for key in table.columns if not key.endswith("_attained")))


def _with_outcome(key: str, row: Row, words: Words) -> Any:
    outcome = row.get(f"{key}_attained")
    if outcome is None:
        return row[key]
    return words(f"value.{'attained' if outcome else 'not_attained'}", least=row[key])


def knowledge(results: Results) -> Table:
    """List the components of F_C and the origin of each parameter, as given."""
    found = results.knowledge
    origins, components = (found.origins, found.components) if found else ({}, {})
    rows: list[Row] = [
        {"parameter": name, "factor_component": value, "origin": origins.get(name, "")}
        for name, value in components.items()
    ]
    rows += [
        {"parameter": name, "origin": text}
        for name, text in origins.items()
        if text and name not in components
    ]
    return Table("knowledge", rows, KNOWLEDGE)


def _states(results: Results) -> list[str]:
    """Return the states with indices, and those that would have them had they a capacity in every direction."""
    known, missing = determined_indices(results), undetermined(results)
    assessment = results.echo.assessment or {}
    asked = bool(known) or ("site" in assessment and assessment.get("spectrum") != "record")
    return [name for name in results.states if name in known or (asked and name in missing)]
