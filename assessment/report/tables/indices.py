"""Tables of the indices of safety and risk, of what interventions must reach, and of the level of knowledge."""

from __future__ import annotations

from assessment.results.table import Results, Row, Table

INDICES: tuple[str, ...] = ("zeta_SLV", "zeta_SLC", "ratio_SLD", "T_SLV_years", "T_R_SLV_years", "I_S", "f_a")
INDICES += ("acceptable_nominal_life_years", "IS_V_class", "PAM", "PAM_class", "risk_class")
INTERVENTIONS = ("improvement", "improvement_school", "retrofit_use", "retrofit")
KNOWLEDGE = ("parameter", "factor_component", "origin")


def index_tables(results: Results) -> list[Table]:
    """List the tables of indices, interventions and knowledge."""
    return [indices(results), interventions(results), knowledge(results)]


def indices(results: Results) -> Table:
    """List the indices of every state; what is not known for want of a return period is left out."""
    rows = [
        {"state": name} | {key: found[key] for key in INDICES if found.get(key) is not None}
        for name, found in _found(results)
    ]
    return Table("indices", rows, ("state", *INDICES))


def interventions(results: Results) -> Table:
    """List ζ_E of every state and what each kind of intervention must reach (NTC 2018, §8.4)."""
    rows = [
        {"state": name, "use_class": found["use_class"], "zeta_SLV": found["zeta_SLV"]}
        | {key: value for key, value in found["required_zeta"].items() if value is not None}
        for name, found in _found(results)
    ]
    return Table("interventions", rows, ("state", "use_class", "zeta_SLV", *INTERVENTIONS))


def knowledge(results: Results) -> Table:
    """List the components of F_C and the origin of each parameter, as given."""
    found = results.get("knowledge") or {}
    origins = found.get("origins") or {}
    rows: list[Row] = [
        {"parameter": name, "factor_component": value, "origin": origins.get(name, "")}
        for name, value in (found.get("components") or {}).items()
    ]
    rows += [
        {"parameter": name, "origin": text}
        for name, text in origins.items()
        if text and name not in (found.get("components") or {})
    ]
    return Table("knowledge", rows, KNOWLEDGE)


def _found(results: Results) -> list[tuple[str, Row]]:
    return [(name, state["indices"]) for name, state in results["states"].items() if state.get("indices")]
