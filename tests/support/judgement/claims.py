"""What each sentence of the draft judgement claims: it is read back and held against the tables."""

import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from markupsafe import Markup

from assessment.report.chapters.judgement import all_warnings, draft_judgement
from assessment.report.chapters.synthesis import lead
from assessment.report.language import NO_BREAK, check_name, direction_name, words_of, written
from assessment.report.tables import capacity as capacity_tables
from assessment.report.tables import mechanisms as mechanism_tables
from assessment.report.tables import structure
from assessment.report.tables import studies as study_tables
from assessment.report.tables.mechanisms import balance, hand_check
from assessment.results.schema.part import QUANTITIES
from assessment.results.table import reference_of
from tests.support.results_example import results_example
from tests.support.typed import typed

Results = dict[str, Any]
Fields = Mapping[str, str]
LIMITS = ("SLO", "SLD", "SLV", "SLC")
# at most, of good ones
RESIDUALS = {"equilibrium_residual": 1e-6, "cone_violation": 1e-6, "complementarity": 1e-3}
WORDS = words_of(typed(results_example("en")))
TABLES = (
    capacity_tables.verification, capacity_tables.chosen_checks, mechanism_tables.mechanisms,
    structure.settlements, structure.quality, mechanism_tables.second_solver, study_tables.scenarios,
    study_tables.tornado, study_tables.convergence, study_tables.history_convergence,
    study_tables.incremental_convergence, hand_check, balance,
)  # fmt: skip
CONVERGENCE = ("convergence", "history_convergence", "incremental_convergence")


class Read:
    """The tables of a set of results, and what a sentence of the judgement says of them."""

    def __init__(self, results: Results) -> None:
        self.results, found = results, typed(results)
        self.at_surface = reference_of(found) == "surface"
        made = [make(found) for make in TABLES]
        self.rows = {table.name: table.rows for table in made}

    def shares(self, table: str, said: Fields) -> list[Mapping[str, Any]]:
        """The rows of a campaign of the movement that a sentence names, from none to the whole of it."""
        rows = self.results["campaign"][table]
        return sorted(
            (r for r in rows if r["settlement"] == said["settlement"]), key=lambda row: row["share"]
        )

    def pushed_down(self, said: Fields) -> Mapping[str, Any]:
        """The path of the movement that a sentence names."""
        contacts = said["contacts"].removesuffix(" contacts")
        found: Mapping[str, Any] = self.results["states"][said["state"]]["pushdown"][contacts]
        return found


show, ratio, plain = WORDS.show, WORDS.ratio, WORDS.plain
# each function returns what the sentence says, field by field


def two_digits(value: float) -> str:
    return WORDS.number(value, 2)


def percent(share: float) -> str:
    return two_digits(100.0 * share)


def millimetres(length: float) -> str:
    return show(1000.0 * length)


def _chosen(_: Fields, read: Read) -> Fields:
    known = [row for row in read.rows["chosen_checks"] if row.get("zeta_E") is not None]
    row = min(known, key=lambda row: row["zeta_E"])
    return {
        "mechanism": row["mechanism"], "state": WORDS.state(row["state"]), "ratio": ratio(row["zeta_E"]),
        "limit": check_name(row["limit_state"], WORDS),
    }  # fmt: skip


def _linear(said: Fields, read: Read) -> Fields:
    """The weakest state of the nonlinear check at SLV, beside its linear one."""
    rows = {
        (row["state"], row["direction"], row["limit_state"]): row.get("zeta_E")
        for row in read.rows["verification"]
    }
    pairs = {
        (WORDS.state(state), direction_name(way)): (full, rows.get((state, way, "SLV linear")))
        for (state, way, limit), full in rows.items()
        if limit == "SLV" and None not in (full, rows.get((state, way, "SLV linear")))
    }
    full, linear = pairs[said["state"], said["direction"]]
    assert full == min(full for full, _ in pairs.values())
    return {"full": ratio(full), "linear": ratio(linear)}


def _interventions(said: Fields, read: Read) -> Fields:
    found = read.results["states"][said["state"]]["indices"]
    told = [
        f"{plain(f'judgement.of_{kind}')} (at least {ratio(least)}) {'not ' * (found['zeta_SLV'] < least)}attained"
        for kind, least in found["required_zeta"].items()
        if least is not None and kind != "improvement_school"
    ]
    return {"zeta": ratio(found["zeta_SLV"]), "before": ratio(found["zeta_before"]), "told": "; ".join(told)}


def _history(said: Fields, read: Read) -> Fields:
    """Which states collapse under a record, and the largest peak of the others."""
    every = [(name, each) for name, state in read.results["states"].items() for each in state["history"]]
    entries = [(WORDS.state(name), each) for name, each in every if each["record"] == said["record"]]
    pga = {"pga": show(entries[0][1]["pga_g"])}
    if "states" in said:
        return pga | {"states": ", ".join(f"“{name}”" for name, each in entries if each["collapsed"])}
    peaks = [(each["peak_displacement_m"], name) for name, each in entries if not each["collapsed"]]
    peak, name = max(each for each in peaks if each[0] is not None)
    return pga | {"state": name, "peak": millimetres(peak)}


def _campaign(kind: str, said: Fields, read: Read) -> Fields:
    (first, *_, last), loss = read.shares("fragility", said), read.shares("loss", said)[-1]
    static, dynamic = loss["static"], loss["dynamic"]
    opposed = static is not None and static * dynamic < 0.0 and min(abs(static), abs(dynamic)) >= 0.01
    opposed = opposed and loss["distinguishable"] is True and not loss.get("directions")
    assert (
        kind == ("alone" if static is None else "opposed" if opposed else "beside") and first["share"] == 0.0
    )
    beside = {} if static is None else {"static": percent(static)}
    return beside | {
        "share": f"{100.0 * last['share']:g}", "before": show(first["median_g"]), "after": show(last["median_g"]),
        "dynamic": percent(dynamic),
    }  # fmt: skip


def _indistinct(said: Fields, read: Read) -> Fields:
    loss = read.shares("loss", said)[-1]
    assert loss["distinguishable"] is False
    return dict(zip(("low", "high"), map(percent, loss["dynamic_range"]), strict=True))


def _one_sign(said: Fields, read: Read) -> Fields:
    loss = read.shares("loss", said)[-1]
    way = next(name for name, lost in loss["directions"].items() if lost == loss["dynamic"])
    return {"direction": direction_name(way)}


def _ties_yield(said: Fields, read: Read) -> Fields:
    pushed = [push for state in read.results["states"].values() for push in state["pushover"].values()]
    curves = [push[kind] for push in pushed for kind in ("rigid", "elastic") if push.get(kind)]
    yielding = {each["tie"] for curve in curves for each in curve.get("ties") or () if each["yields"]}
    assert set(said["ties"].split(", ")) == yielding
    return {}


def _worst(quantity: str | None, said: Fields, read: Read) -> Fields:
    settled = [row for row in read.rows["scenarios"] if row["state"] != "original"]
    [row] = [row for row in settled if row["worst"]]
    where = {"state": row["state"], "movement": millimetres(row["movement_m"])}
    fallen = [each["movement_m"] for each in settled if each["collapses"]]
    if quantity is None:
        assert row["collapses"] and row["movement_m"] == min(fallen)
        return where
    known = [each[quantity] for each in settled if each[quantity] is not None]
    assert not fallen and row[quantity] == min(known)
    if len(known) < len(settled):
        assert f"among the {len(known)} of {len(settled)} cases" in said["among"]
    limit = {"limit": row["limit_state"]} if quantity == "a_g_g" else {}
    reduction = {"reduction": written("reduction", row["reduction"], WORDS)} if "reduction" in said else {}
    told = said["among"] if len(known) < len(settled) else ""
    direction = direction_name(row["direction"])
    return (
        where | limit | reduction | {"capacity": show(row[quantity]), "direction": direction, "among": told}
    )


def _sensitive(said: Fields, read: Read) -> Fields:
    rows = [row for row in read.rows["tornado"] if row["swing_g"] is not None]
    place = [(row["state"], plain(f"value.{row['property']}")) for row in rows]
    row = rows[place.index((said["state"], said["property"]))]
    assert row["swing_g"] == max(each["swing_g"] for each in rows) > 0.0
    span = [row[key] for key in ("a_g_low_g", "a_g_base_g", "a_g_high_g")]
    numbers = {"least": min(span), "most": max(span), "low": row["low_factor"], "high": row["high_factor"]}
    return {"limit": read.results["sensitivity"]["limit_state"]} | {
        key: show(v) for key, v in numbers.items()
    }


def _sensitive_open(said: Fields, read: Read) -> Fields:
    expected = {plain(f"value.{row['property']}") for row in read.rows["tornado"] if row["swing_g"] is None}
    assert set(said["properties"].split(", ")) == expected
    return {}


def _margin(collapses: bool, said: Fields, read: Read) -> Fields:
    [row] = [row for row in read.rows["settlements"] if row["state"] == said["state"]]
    ultimate = row[f"ultimate_{said['contacts'].removesuffix(' contacts')}_m"]
    applied = read.pushed_down(said)["applied_movement_m"]
    assert (applied > ultimate * (1.0 + 1e-9)) == collapses
    ends = {"ultimate": millimetres(ultimate), "applied": millimetres(applied)}
    return ends | {"share": percent(applied / ultimate)}


def _loses(tie: bool, said: Fields, read: Read) -> Fields:
    loss = read.pushed_down(said)["local_loss"]
    assert bool(loss.get("tie")) == tie
    return {"at": millimetres(loss["displacement_m"])}


def _residual(name: str, read: Read) -> float:
    return max(row.get(f"worst_{name}", 0.0) for row in read.rows["quality"])


def _certificates(_: Fields, read: Read) -> Fields:
    assert all(_residual(name, read) <= allowed for name, allowed in RESIDUALS.items())
    return {name: two_digits(_residual(name, read)) for name in RESIDUALS}


def _poor(said: Fields, read: Read) -> Fields:
    [name] = [name for name in RESIDUALS if plain(f"judgement.{name}") == said["what"]]
    assert _residual(name, read) > RESIDUALS[name]
    return {"residual": two_digits(_residual(name, read))}


def _converged(good: bool, _: Fields, read: Read) -> Fields:
    errors = [row["relative_error"] for table in CONVERGENCE for row in read.rows[table]]
    worst, tolerance = max(e for e in errors if e is not None), read.results["convergence"]["tolerance"]
    assert (worst <= tolerance and None not in errors) == good
    return {"error": percent(worst), "tolerance": f"{100.0 * tolerance:g}"}


def _no_convergence(_: Fields, read: Read) -> Fields:
    assert not any(read.rows[table] for table in CONVERGENCE)
    return {}


def _second(agrees: bool, _: Fields, read: Read) -> Fields:
    found = [row["relative_difference"] for row in read.rows["second_solver"]]
    worst = max(abs(each) for each in found if each is not None)
    assert (worst <= 1e-4) == agrees
    return {} if agrees else {"difference": two_digits(worst)}


def _second_missing(_: Fields, read: Read) -> Fields:
    missing = [row["relative_difference"] for row in read.rows["second_solver"]].count(None)
    assert missing > 0
    return {"count": str(missing)}


def _hand(agrees: bool, _: Fields, read: Read) -> Fields:
    worst = max(abs(row[key]) for row in read.rows["hand_check"] for key in ("deviation", "hand_deviation"))
    assert (worst <= 0.01) == agrees
    return {"deviation": percent(worst)}


def _balance(good: bool, _: Fields, read: Read) -> Fields:
    worst = max(row["unbalanced"] for row in read.rows["balance"])
    assert (worst <= 1e-3) == good
    return {"unbalanced": two_digits(worst)}


def _warnings(_: Fields, read: Read) -> Fields:
    return {"count": str(len(all_warnings(typed(read.results))))}


def _unstable(_: Fields, read: Read) -> Fields:
    assert not read.results["model"]["self_weight_stable"]
    return {}


CLAIMS: dict[str, Callable[[Fields, Read], Fields]] = {
    "unstable": _unstable, "chosen": _chosen, "linear": _linear, "limits": lambda said, read: {},
    "interventions": _interventions, "ties_yield": _ties_yield, "campaign_indistinct": _indistinct,
    "one_sign": _one_sign,
    **{f"history_{kind}": _history for kind in ("collapse", "stands", "peak")},
    **{f"campaign_{kind}": partial(_campaign, kind) for kind in ("alone", "beside", "opposed")},
    **{f"worst_{quantity}": partial(_worst, quantity) for quantity in ("a_g_g", "alpha_0", "alpha_u")},
    "worst_collapses": partial(_worst, None), "sensitive": _sensitive, "sensitive_open": _sensitive_open,
    "margin": partial(_margin, False), "no_margin": partial(_margin, True), "loses_tie": partial(_loses, True),
    "loses_joint": partial(_loses, False), "certificates": _certificates, "poor_certificates": _poor,
    "converged": partial(_converged, True), "not_converged": partial(_converged, False),
    "no_convergence": _no_convergence, "second_agrees": partial(_second, True),
    "second_differs": partial(_second, False), "second_missing": _second_missing,
    "hand_agrees": partial(_hand, True), "hand_differs": partial(_hand, False),
    "balanced": partial(_balance, True), "unbalanced": partial(_balance, False), "warnings": _warnings,
}  # fmt: skip
PARTS = {  # of sentences, or of the file
    "worst_reduction", "worst_among", "campaign_sa", "attained", "not_attained", "of_improvement",
    "of_improvement_school", "of_retrofit", "of_retrofit_use", *RESIDUALS, "file",
}  # fmt: skip


def _unit(quantity: str) -> str:
    unit = QUANTITIES[quantity].printed_unit if quantity in QUANTITIES else quantity
    return f" {unit}" if unit else ""


def pattern(key: str) -> re.Pattern[str]:
    """What a sentence of the judgement looks like; its fields as named groups."""

    def fields(text: str) -> str:
        # what a value and its unit look like
        joined = re.sub(r"\{(\w+):(\w+|%)\}", lambda it: f"{{{it[1]}}}{_unit(it[2])}", text)
        named = re.sub(r"\\\{(\w+)\\\}", r"(?P<\1>.+?)", re.escape(joined))
        named = named.replace("(?P<dynamic>.+?)", r"(?P<dynamic>\S+?)")  # a number
        return named.replace("(?P<among>.+?)", "(?P<among>.*?)")  # nothing where all are known

    texts = WORDS.strings["judgement"]
    more = f"( {fields(texts['worst_reduction'])})?" if key.startswith("worst_") else ""
    return re.compile(fields(texts[key]) + more)


PATTERNS = {key: pattern(key) for key in CLAIMS}
REFERENCES = {False: "on rock (ground type A), without S", True: "at the surface, as the peak of the record"}


def hold(results: Results) -> list[str]:
    """Read every sentence of the draft back and hold it against the tables; return their keys.

    The sentences with which it begins are those of the first page: see test_synthesis.
    """
    results["echo"]["report"]["language"] = "en"
    read, keys = Read(results), []
    found_results = typed(results)
    words = words_of(found_results)
    answer = lead(found_results, words)
    said_all = list(draft_judgement(found_results, words))
    assert said_all[: len(answer)] == answer
    for sentence in said_all[len(answer) :]:
        text = Markup(sentence).unescape().replace(NO_BREAK, " ")
        found = {key: match for key, each in PATTERNS.items() if (match := each.fullmatch(text))}
        assert len(found) == 1, text
        [(key, match)] = found.items()
        said = {name: value for name, value in match.groupdict().items() if value is not None}
        claimed = CLAIMS[key](said, read)
        assert claimed == {name: said.get(name) for name in claimed}, text
        assert said.get("reference", REFERENCES[read.at_surface]) == REFERENCES[read.at_surface]
        keys.append(key)
    return keys
