"""Tables of the indices of safety and risk, of what interventions must reach, and of the level of knowledge."""

from __future__ import annotations

from assessment.results.schema import Results
from assessment.results.schema.indices import Indices
from assessment.results.schema.part import present
from assessment.results.table import Row, Table, cells

SAFETY: tuple[str, ...] = ("zeta_SLV", "zeta_SLC", "ratio_SLD", "T_SLV_years", "T_R_SLV_years", "I_S", "f_a")
SAFETY += ("acceptable_nominal_life_years",)
RISK = ("IS_V", "IS_V_class", "PAM", "PAM_class", "risk_class")
INDICES = (*SAFETY, *RISK)
INTERVENTIONS = ("improvement", "improvement_school", "retrofit_use", "retrofit")
KNOWLEDGE = ("parameter", "factor_component", "origin")


def index_tables(results: Results) -> list[Table]:
    """List the tables of indices, interventions and knowledge."""
    return [indices(results), interventions(results), knowledge(results)]


def indices(results: Results) -> Table:
    """List the indices of every state; what is not known for want of a return period is left out."""
    rows = [{"state": name} | present(cells(found, INDICES)) for name, found in _found(results)]
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
    """List ζ_E of every state and what each kind of intervention must reach (NTC 2018, §8.4)."""
    rows = [
        {"state": name, "use_class": found.use_class, "zeta_SLV": found.zeta_SLV}
        | present(found.required_zeta)
        for name, found in _found(results)
    ]
    return Table("interventions", rows, ("state", "use_class", "zeta_SLV", *INTERVENTIONS))


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


def _found(results: Results) -> list[tuple[str, Indices]]:
    return [(name, state.indices) for name, state in results.states.items() if state.indices]
