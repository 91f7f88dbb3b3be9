"""What each sentence of the draft judgement claims: it is read back and held against the tables."""

import re
from collections.abc import Callable, Mapping
from operator import itemgetter
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


class Read:
    """The tables of a set of results, and what a sentence of the judgement says of them."""

    def __init__(self, results: Results) -> None:
        self.results, found = results, typed(results)
        self.at_surface = reference_of(found) == "surface"
        made = [make(found) for make in TABLES]
        self.rows = {table.name: table.rows for table in made} | {"comparison": results["comparison"]}

    @property
    def settled(self) -> list[str]:
        """The states that a movement leads to; what strengthens one is no loss."""
        states = self.results["states"].items()
        return [name for name, each in states if name != "original" and not each.get("strengthening")]

    def made(self, table: str = "verification") -> list[Mapping[str, Any]]:
        return [row for row in self.rows[table] if row.get("zeta_E") is not None]

    def row(self, table: str, said: Fields, *keys: str) -> Mapping[str, Any]:
        """The one row of a table that a sentence names."""
        [found] = [
            row
            for row in self.rows[table]
            if all(WORDS_OF[key](row[COLUMN.get(key, key)]) == said[key] for key in keys)
        ]
        return found


TABLES = (
    capacity_tables.verification, capacity_tables.chosen_checks, mechanism_tables.mechanisms,
    structure.settlements, structure.quality, mechanism_tables.second_solver, study_tables.scenarios,
    study_tables.tornado, study_tables.convergence, study_tables.history_convergence,
    study_tables.incremental_convergence, hand_check, balance,
)  # fmt: skip
CONVERGENCE = ("convergence", "history_convergence", "incremental_convergence")
COLUMN = {"limit": "limit_state"}
WORDS_OF: dict[str, Callable[[Any], str]] = {
    "state": WORDS.state, "direction": direction_name, "limit": lambda check: check_name(check, WORDS),
    "mechanism": str, "contacts": lambda kind: WORDS.plain(f"value.{kind}"),
}  # fmt: skip
show, ratio = WORDS.show, WORDS.ratio
ratio_of = WORDS.ratio


def _chosen(said: Fields, read: Read) -> None:
    row = read.row("chosen_checks", said, "mechanism", "state", "limit")
    assert row["zeta_E"] == min(each["zeta_E"] for each in read.made("chosen_checks"))
    assert said["ratio"] == ratio(row["zeta_E"])


def _linear(said: Fields, read: Read) -> None:
    """The weakest state of the nonlinear check at SLV, beside its linear one."""
    rows = {(row["state"], row["direction"], row["limit_state"]): row["zeta_E"] for row in read.made()}
    pairs = {
        key[:2]: ratio for key, ratio in rows.items() if key[2] == "SLV" and (*key[:2], "SLV linear") in rows
    }
    [place] = [
        key
        for key in pairs
        if (WORDS.state(key[0]), direction_name(key[1])) == (said["state"], said["direction"])
    ]
    assert pairs[place] == min(pairs.values()) and said["full"] == ratio_of(pairs[place])
    assert said["linear"] == ratio_of(rows[(*place, "SLV linear")])


def _interventions(said: Fields, read: Read) -> None:
    found = read.results["states"][said["state"]]["indices"]
    assert (said["zeta"], said["before"]) == (ratio(found["zeta_SLV"]), ratio(found["zeta_before"]))
    pattern = re.compile(r"(?P<kind>.+) \(at least (?P<least>.+)\) (?P<how>attained|not attained)")
    told = {
        match["kind"]: (match["least"], match["how"] == "attained")
        for each in said["told"].split("; ")
        if (match := pattern.fullmatch(each))
    }
    assert told == {
        WORDS.plain(f"judgement.of_{kind}"): (ratio(least), found["zeta_SLV"] >= least)
        for kind, least in found["required_zeta"].items()
        if least is not None and kind != "improvement_school"
    }


def _history(said: Fields, read: Read) -> None:
    """Which states collapse under a record, and the largest peak of the others."""
    entries = {
        name: entry
        for name, state in read.results["states"].items()
        for entry in state["history"]
        if entry["record"] == said["record"]
    }
    fallen = [name for name, entry in entries.items() if entry["collapsed"]]
    assert said["pga"] == show(next(iter(entries.values()))["pga_g"])
    if "states" in said:
        assert said["states"] == ", ".join(f"“{WORDS.state(name)}”" for name in fallen)
        return
    peaks = {name: entry["peak_displacement_m"] for name, entry in entries.items() if not entry["collapsed"]}
    [name] = [name for name in peaks if WORDS.state(name) == said["state"]]
    assert peaks[name] == max(peak for peak in peaks.values() if peak is not None)
    assert said["peak"] == show(1000.0 * peaks[name])


def _campaign(kind: str) -> Callable[[Fields, Read], None]:
    def check(said: Fields, read: Read) -> None:
        fits, losses = (
            sorted(
                (row for row in read.results["campaign"][key] if row["settlement"] == said["settlement"]),
                key=itemgetter("share"),
            )
            for key in ("fragility", "loss")
        )
        first, last, loss = fits[0], fits[-1], losses[-1]
        assert first["share"] == 0.0 and said["share"] == f"{100.0 * last['share']:g}"
        assert (said["before"], said["after"]) == (show(first["median_g"]), show(last["median_g"]))
        assert said["dynamic"] == WORDS.number(100.0 * loss["dynamic"], 2)
        static = loss["static"]
        assert said.get("static") == (None if static is None else WORDS.number(100.0 * static, 2))
        opposed = static is not None and static * loss["dynamic"] < 0.0
        opposed = opposed and min(abs(static), abs(loss["dynamic"])) >= 0.01
        opposed = opposed and loss.get("distinguishable") is not False
        assert kind == ("alone" if static is None else "opposed" if opposed else "beside")

    return check


def _indistinct(said: Fields, read: Read) -> None:
    [*_, loss] = sorted(
        (row for row in read.results["campaign"]["loss"] if row["settlement"] == said["settlement"]),
        key=itemgetter("share"),
    )
    assert loss["distinguishable"] is False
    low, high = (WORDS.number(100.0 * bound, 2) for bound in loss["dynamic_range"])
    assert (said["low"], said["high"]) == (low, high)


def _ties_yield(said: Fields, read: Read) -> None:
    pushed = [push for state in read.results["states"].values() for push in state["pushover"].values()]
    curves = [push[kind] for push in pushed for kind in ("rigid", "elastic") if push.get(kind)]
    yielding = {each["tie"] for curve in curves for each in curve.get("ties") or () if each["yields"]}
    assert set(said["ties"].split(", ")) == yielding


def _worst(quantity: str | None) -> Callable[[Fields, Read], None]:
    def check(said: Fields, read: Read) -> None:
        settled = [row for row in read.rows["scenarios"] if row["state"] != "original"]
        [row] = [row for row in settled if row["worst"]]
        assert (said["state"], said["movement"]) == (row["state"], show(1000.0 * row["movement_m"]))
        if quantity is None:
            fallen = [each["movement_m"] for each in settled if each["collapses"]]
            assert row["collapses"] and row["movement_m"] == min(fallen)
            return
        assert not any(each["collapses"] for each in settled)
        known = [each[quantity] for each in settled if each[quantity] is not None]
        assert row[quantity] == min(known)
        among = re.search(r"among the (\d+) of (\d+) cases", said["among"])
        counts = (int(among[1]), int(among[2])) if among else (len(settled),) * 2
        assert counts == (len(known), len(settled)) and (among is None) == (len(known) == len(settled))
        assert said["capacity"] == show(row[quantity]) and said["direction"] == direction_name(
            row["direction"]
        )
        if quantity == "a_g_g":
            assert said["limit"] == row["limit_state"]
        if "reduction" in said:
            assert said["reduction"] == written("reduction", row["reduction"], WORDS)

    return check


def _sensitive(said: Fields, read: Read) -> None:
    rows = [row for row in read.rows["tornado"] if row["swing_g"] is not None]
    widest = max(row["swing_g"] for row in rows)
    [row] = [
        row
        for row in rows
        if (row["state"], WORDS.plain(f"value.{row['property']}")) == (said["state"], said["property"])
    ]
    assert row["swing_g"] == widest > 0.0
    span = [row[key] for key in ("a_g_low_g", "a_g_base_g", "a_g_high_g")]
    assert (said["least"], said["most"]) == (show(min(span)), show(max(span)))
    assert (said["low"], said["high"]) == (show(row["low_factor"]), show(row["high_factor"]))
    assert said["limit"] == read.results["sensitivity"]["limit_state"]


def _sensitive_open(said: Fields, read: Read) -> None:
    expected = {
        WORDS.plain(f"value.{row['property']}") for row in read.rows["tornado"] if row["swing_g"] is None
    }
    assert set(said["properties"].split(", ")) == expected


def _margin(collapses: bool) -> Callable[[Fields, Read], None]:
    def check(said: Fields, read: Read) -> None:
        [row] = [row for row in read.rows["settlements"] if row["state"] == said["state"]]
        contacts = "rigid" if said["contacts"] == "rigid contacts" else "elastic"
        ultimate = row[f"ultimate_{contacts}_m"]
        applied = read.results["states"][said["state"]]["pushdown"][contacts]["applied_movement_m"]
        assert said["ultimate"] == show(1000.0 * ultimate) and said["applied"] == show(1000.0 * applied)
        assert said["share"] == WORDS.number(100.0 * applied / ultimate, 2)
        assert (applied >= ultimate) == collapses

    return check


def _loses(tie: bool) -> Callable[[Fields, Read], None]:
    def check(said: Fields, read: Read) -> None:
        contacts = "rigid" if said["contacts"] == "rigid contacts" else "elastic"
        loss = read.results["states"][said["state"]]["pushdown"][contacts]["local_loss"]
        assert said["at"] == show(1000.0 * loss["displacement_m"])
        assert bool(loss.get("tie")) == tie

    return check


def _certificates(said: Fields, read: Read) -> None:
    for name, allowed in RESIDUALS.items():
        worst = max(row.get(f"worst_{name}", 0.0) for row in read.rows["quality"])
        assert said[name] == WORDS.number(worst, 2) and worst <= allowed


def _poor(said: Fields, read: Read) -> None:
    [name] = [name for name in RESIDUALS if WORDS.plain(f"judgement.{name}") == said["what"]]
    worst = max(row.get(f"worst_{name}", 0.0) for row in read.rows["quality"])
    assert said["residual"] == WORDS.number(worst, 2) and worst > RESIDUALS[name]


def _converged(good: bool) -> Callable[[Fields, Read], None]:
    def check(said: Fields, read: Read) -> None:
        errors = [row["relative_error"] for table in CONVERGENCE for row in read.rows[table]]
        known = [error for error in errors if error is not None]
        tolerance = read.results["convergence"]["tolerance"]
        assert said["error"] == WORDS.number(100.0 * max(known), 2)
        assert said["tolerance"] == f"{100.0 * tolerance:g}"
        assert (max(known) <= tolerance and None not in errors) == good

    return check


def _no_convergence(_: Fields, read: Read) -> None:
    assert not any(read.rows[table] for table in CONVERGENCE)


def _second(agrees: bool) -> Callable[[Fields, Read], None]:
    def check(said: Fields, read: Read) -> None:
        found = [row["relative_difference"] for row in read.rows["second_solver"]]
        worst = max(abs(each) for each in found if each is not None)
        assert (worst <= 1e-4) == agrees and said.get("difference") == (
            None if agrees else WORDS.number(worst, 2)
        )

    return check


def _second_missing(said: Fields, read: Read) -> None:
    found = [row["relative_difference"] for row in read.rows["second_solver"]]
    assert int(said["count"]) == found.count(None) > 0


def _hand(key: str) -> Callable[[Fields, Read], None]:
    def check(said: Fields, read: Read) -> None:
        rows = read.rows["hand_check"]
        worst = max(abs(row[name]) for row in rows for name in ("deviation", "hand_deviation"))
        assert said["deviation"] == WORDS.number(100.0 * worst, 2) and (worst <= 0.01) == (
            key == "hand_agrees"
        )

    return check


def _balance(good: bool) -> Callable[[Fields, Read], None]:
    def check(said: Fields, read: Read) -> None:
        worst = max(row["unbalanced"] for row in read.rows["balance"])
        assert said["unbalanced"] == WORDS.number(worst, 2) and (worst <= 1e-3) == good

    return check


def _warnings(said: Fields, read: Read) -> None:
    assert int(said["count"]) == len(all_warnings(typed(read.results)))


def _unstable(_: Fields, read: Read) -> None:
    assert not read.results["model"]["self_weight_stable"]


CLAIMS: dict[str, Callable[[Fields, Read], None]] = {
    "unstable": _unstable, "chosen": _chosen, "linear": _linear, "limits": lambda said, read: None,
    "interventions": _interventions, "ties_yield": _ties_yield, "history_collapse": _history,
    "history_stands": _history, "history_peak": _history, "campaign_alone": _campaign("alone"),
    "campaign_beside": _campaign("beside"), "campaign_opposed": _campaign("opposed"),
    "campaign_indistinct": _indistinct, "worst_a_g_g": _worst("a_g_g"),
    "worst_alpha_0": _worst("alpha_0"), "worst_alpha_u": _worst("alpha_u"), "worst_collapses": _worst(None),
    "sensitive": _sensitive, "sensitive_open": _sensitive_open, "margin": _margin(False),
    "no_margin": _margin(True), "loses_tie": _loses(True), "loses_joint": _loses(False),
    "certificates": _certificates, "poor_certificates": _poor,
    "converged": _converged(True), "not_converged": _converged(False), "no_convergence": _no_convergence,
    "second_agrees": _second(True), "second_differs": _second(False), "second_missing": _second_missing,
    **{key: _hand(key) for key in ("hand_agrees", "hand_differs")}, "balanced": _balance(True),
    "unbalanced": _balance(False), "warnings": _warnings,
}  # fmt: skip
PARTS = {
    "worst_reduction",
    "worst_among",
    "campaign_sa",
    "attained",
    "not_attained",
    *("of_improvement", "of_improvement_school", "of_retrofit", "of_retrofit_use"),
    *RESIDUALS,
    "file",
}  # of sentences, or of the file


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
    said_all = draft_judgement(found_results, words)
    assert said_all[: len(answer)] == answer
    for sentence in said_all[len(answer) :]:
        text = Markup(sentence).unescape().replace(NO_BREAK, " ")
        found = {key: match for key, each in PATTERNS.items() if (match := each.fullmatch(text))}
        assert len(found) == 1, text
        [(key, match)] = found.items()
        said = {name: value for name, value in match.groupdict().items() if value is not None}
        CLAIMS[key](said, read)
        assert said.get("reference", REFERENCES[read.at_surface]) == REFERENCES[read.at_surface]
        keys.append(key)
    return keys
