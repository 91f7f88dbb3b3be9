"""A state of which a direction has no capacity: no index, and rows that say so instead of none."""

from __future__ import annotations

from assessment.cli.summary import summary
from assessment.report.chapters.grids import check_grids, printed_tables
from assessment.report.chapters.judgement import draft_judgement
from assessment.report.chapters.synthesis import synthesis_grid
from assessment.report.language import words_of
from assessment.report.tables.capacity import indices, interventions, verification
from assessment.results.summary import checks_asked, undetermined
from assessment.runtime.tasks import Outcome
from tests.support.judgement.claims import hold
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed

INDICES = {
    "direction": "-x", "check": "SLV", "zeta_SLV": 2.2, "f_a": 2.2, "IS_V": 2.2, "IS_V_class": "A+",
    "risk_class": "A", "acceptable_nominal_life_years": 300.0, "use_class": "II",
    "required_zeta": {"retrofit": 1.0}, "trace": [],
}  # fmt: skip


def halved(language="en"):
    """The settled state has no capacity towards +x, and indices of the other direction, as were once given."""
    results = results_example(language)
    del results["states"][SETTLED]["capacity"]["+x"]
    for state in results["states"].values():
        state["indices"] = dict(INDICES)
    return results


def test_the_directions_and_checks_that_have_no_capacity():
    assert undetermined(typed(halved())) == {SETTLED: ["+x"]}
    assert undetermined(typed(results_example())) == {}
    nothing = results_example()
    for state in nothing["states"].values():
        state["capacity"] = {}
    assert undetermined(typed(nothing)) == {"original": ["+x", "-x"], SETTLED: ["+x", "-x"]}
    assert checks_asked(typed(nothing)) == ["SLD", "SLV linear", "SLV", "SLC"]
    del nothing["echo"]["assessment"]
    assert undetermined(typed(nothing)) == {}


def test_tables_have_its_rows_and_no_index():
    results = typed(halved("it"))
    words = words_of(results)
    told = {row["state"]: row for row in indices(results).rows}
    assert told["original"]["zeta_SLV"] == 2.2 and told[SETTLED] == {"state": SETTLED} | dict.fromkeys(
        ("zeta_SLV", "acceptable_nominal_life_years", "IS_V", "risk_class")
    )
    assert {row["state"]: row["zeta_SLV"] for row in interventions(results).rows}[SETTLED] is None
    rows = [row for row in verification(results).rows if row["verified"] is None]
    assert [(row["state"], row["direction"], row["limit_state"]) for row in rows] == [
        (SETTLED, "+x", limit) for limit in ("SLD", "SLV", "SLC")
    ]
    assert all(row["demand_a_g_g"] is not None and row["zeta_E"] is None for row in rows)
    printed = printed_tables(results, words)
    assert [str(cell) for cell in printed["risk"].rows[1]].count("non determinato") == 2
    *_, settled = check_grids(results, words)
    [row] = [row for row in settled.rows if row[0] == "+x"]
    assert row[1] == "SLD; SLV; SLC" and "non determinato" in row
    [row] = [row for row in synthesis_grid(results, words).rows if row[:2] == [SETTLED, "+x"]]
    assert row[2:5] == 3 * [words("value.open")] and row[-1] == "non determinato"


def test_sentences_and_terminal_say_so(tmp_path):
    results = typed(halved())
    hold(halved())
    text = " ".join(draft_judgement(results, words_of(results)))
    said = f"not determined, no capacity was found: “{SETTLED}”, +x (annex D)"
    assert said in text
    assert f"ζ_E {said}." in summary(Outcome(results, False, 0, 0), tmp_path, []).splitlines()
