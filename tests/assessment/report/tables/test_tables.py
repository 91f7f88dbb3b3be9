"""The tables hold the numbers of the results; reductions compare settled states with the original."""

import csv

import pandas as pd
import pytest
from markupsafe import Markup

from assessment.project.project import json_schema
from assessment.report.chapters.grids import check_grids, grid, printed_tables
from assessment.report.chapters.judgement import draft_judgement, told
from assessment.report.chapters.remarks import indices as index_sentences
from assessment.report.chapters.synthesis import synthesis_grid
from assessment.report.document import write_tables
from assessment.report.language import LANGUAGES, Words, cell, words_of
from assessment.report.tables import TABLES, table
from assessment.report.tables.capacity import indices, interventions, summary, verification
from assessment.results.schema.model import QualityRow
from assessment.results.schema.part import QUANTITIES, key
from assessment.results.summary import checks_asked, undetermined
from tests.support.judgement.claims import hold
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed
from tools.docs_pages import _section


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tables")
    write_tables(typed(results_example()), folder)
    return {path.stem: path for path in folder.iterdir()}


def test_curves_come_back_as_they_were(written):
    frame = pd.read_csv(written["pushover"])
    chosen = frame[(frame.state == SETTLED) & (frame.direction == "'-x") & (frame.contacts == "elastic")]
    curve = results_example()["states"][SETTLED]["pushover"]["-x"]["elastic"]["curve"]
    assert chosen.displacement_m.to_list() == pytest.approx(curve["displacement_m"], rel=1e-14)
    assert chosen.multiplier.to_list() == pytest.approx(curve["multiplier"], rel=1e-14)


def test_the_summary_and_the_checks_have_the_reductions_of_the_papers_table():
    results = results_example()
    [row] = [r for r in summary(typed(results)).rows if (r["state"], r["direction"]) == (SETTLED, "+x")]
    assert row["alpha_0"] == 0.131 and row["reduction"] == pytest.approx(1.0 - 0.131 / 0.153)
    checks = {(r["state"], r["direction"], r["limit_state"]): r for r in verification(typed(results)).rows}
    pga = results["comparison"][0]["static_reduction"]
    assert checks[SETTLED, "+x", "SLC"]["reduction"] == pytest.approx(pga)
    assert "reduction" not in checks["original", "+x", "SLC"]


def test_null_is_kept_apart_from_not_asked_for():
    results = results_example()
    results["states"]["original"]["pushover"]["+x"]["rigid"]["d_0_m"] = None
    del results["states"][SETTLED]["pushover"]["+x"]["elastic"]
    rows = {(r["state"], r["direction"]): r for r in summary(typed(results)).rows}
    assert rows["original", "+x"]["d_0_m"] is None
    assert "alpha_y" not in rows[SETTLED, "+x"]


def test_a_movement_that_begins_after_another_one_says_so():
    """The report stopped at a column without a label."""
    results = results_example("en")
    results["states"]["back"] = results["states"][SETTLED] | {
        "settlement": results["states"][SETTLED]["settlement"] | {"after": SETTLED}
    }
    printed = printed_tables(typed(results), Words.of("en"))["settlements"]
    assert dict(zip(printed.head, printed.rows[1], strict=True))["After"] == SETTLED


def test_no_cell_begins_like_a_formula(tmp_path):
    results = results_example()
    for name in ("=1+1", "+SUM(A1)", "-2", "@A1", "=cmd|'/c calc'!A0"):
        results["states"][name] = results["states"][SETTLED]
    results["geometry"]["blocks"][0]["layer"] = "=HYPERLINK(0)"
    write_tables(typed(results), tmp_path)
    words = 0
    for path in tmp_path.iterdir():
        with path.open(encoding="utf-8", newline="") as file:
            for cell in (cell for row in csv.reader(file) for cell in row):
                try:
                    float(cell)
                except ValueError:
                    words += 1
                    assert not cell.startswith(("=", "+", "-", "@", "\t", "\r"))
    assert words > 100


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_key_of_a_project_has_a_name_in_the_report(language):
    schema, named = json_schema(), set(Words.of(language).strings["input"])
    tables = [schema, *schema["$defs"].values()]
    keys = {key for table in tables for key in table.get("properties", {})}
    assert keys - {"SLO", "SLD", "SLV", "SLC"} <= named


@pytest.mark.parametrize(
    ("column", "value", "shown"),
    [
        ("x_m", -0.003228, "−0,003"),  # a survey's millimetre
        ("x_m", 0.0, "0"),
        ("opening_m", 0.000557, "0,6"),  # mm
        ("slip_m", 4e-8, "0"),
        ("static_reduction", 0.00096, "0,1"),  # %
        ("return_period_years", 50.29, "50"),
        ("return_period_years", 474.56, "475"),
        ("return_period_years", 0.0636191, "&lt; 30 (0,064)"),
        ("I_S", 0.00101808, "0,0010"),
        ("hand_deviation", -0.0005708, "−0,057"),  # %
        ("IS_V", 0.168152, "17"),  # %
    ],
)
def test_no_number_has_digits_that_mean_nothing(column, value, shown):
    """A joint at x = −0.00323 m, T_R = 50.0 years, e* reduced by 0.0960 % stood there."""
    assert cell(column, {column: value}, Words.of("it"), 4) == shown


def test_an_index_that_needs_a_return_period_is_told_where_one_is_known():
    """I_S and V_N were explained under a table that had neither."""
    results = analysed_indices()
    told = " ".join(index_sentences(typed(results), Words.of("it")))
    assert "I<sub>S</sub>" in told and "V<sub>N</sub>" in told
    unknown = dict.fromkeys(
        ("T_SLV_years", "I_S", "acceptable_nominal_life_years", "PAM", "PAM_class", "risk_class")
    )
    results["states"]["original"]["indices"] |= unknown
    told = " ".join(index_sentences(typed(results), Words.of("it")))
    assert "I<sub>S</sub>" not in told and "V<sub>N</sub>" not in told


def analysed_indices():
    """Indices of the original state alone: I_S = 100/475, f_a = IS-V = 0.3."""
    results = results_example()
    results["states"]["original"]["indices"] = {
        "direction": "+x", "check": "SLV", "zeta_SLV": 0.3, "zeta_SLC": 0.4, "ratio_SLD": 0.5,
        "T_SLV_years": 100.0, "T_SLV_stated": None, "T_R_SLV_years": 475.0, "I_S": 100.0 / 475.0, "f_a": 0.3,
        "acceptable_nominal_life_years": 10.5, "IS_V": 0.3, "IS_V_class": "D", "PAM": 0.05, "PAM_class": "F",
        "risk_class": "F", "use_class": "II", "required_zeta": {}, "trace": [],
    }  # fmt: skip
    return results


@pytest.fixture
def described():
    """What is described and entered here is forgotten afterwards."""
    before, tables = set(QUANTITIES), set(TABLES)
    yield
    for registered, kept in ((QUANTITIES, before), (TABLES, tables)):
        for name in set(registered) - kept:
            del registered[name]


def test_a_number_is_added_by_one_line_of_the_schema(described, tmp_path):
    class Tried(QualityRow):
        """A certificate with one number more."""

        storey_drift_m: float = key("largest drift of a storey", "Deriva|Drift", shown="mm", digits=2)

    row = Tried(stage="pushover", solves=3, storey_drift_m=0.001234, state="original",
                worst_equilibrium_residual=1e-9, worst_complementarity=1e-9)  # fmt: skip
    made = table("tried", Tried)(lambda _: [row])
    results = typed(results_example())
    for language, heading, shown in (("it", "Deriva [mm]", "1,2"), ("en", "Drift [mm]", "1.2")):
        printed = grid(made(results), Words.of(language), Markup(""))
        assert str(printed.head[-1]) == heading and str(printed.rows[0][-1]) == shown
    write_tables(results, tmp_path)
    head, line = (tmp_path / "tried.csv").read_text().splitlines()
    assert head.endswith(",storey_drift_m") and line.endswith(",0.001234")
    told = Tried.model_json_schema()["properties"]["storey_drift_m"]
    assert (told["unit"], told["description"]) == ("m", "largest drift of a storey")
    assert "| `storey_drift_m` | number | m | largest drift of a storey |" in _section(Tried)


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
    assert told["original"]["zeta_SLV"] == 2.2
    assert told[SETTLED] == {"state": SETTLED, "zeta_SLV": None, "acceptable_nominal_life_years": None}
    assert {row["state"]: row["zeta_SLV"] for row in interventions(results).rows}[SETTLED] is None
    rows = [row for row in verification(results).rows if row["verified"] is None]
    assert [(row["state"], row["direction"], row["limit_state"]) for row in rows] == [
        (SETTLED, "+x", limit) for limit in ("SLD", "SLV", "SLC")
    ]
    assert all(row["demand_a_g_g"] is not None and row["zeta_E"] is None for row in rows)
    printed = printed_tables(results, words)
    assert printed["risk"].rows[1][1::2] == ["n.d.", "non determinato"]
    *_, settled = check_grids(results, words)
    [row] = [row for row in settled.rows if row[0] == "+x"]
    assert row[1] == "SLD; SLV; SLC" and {"n.d.", "non determinato"} <= {*row}
    [row] = [row for row in synthesis_grid(results, words).rows if row[:2] == [SETTLED, "+x"]]
    assert row[2:5] == 3 * [words("value.open")] and row[-1] == "non determinato"


def test_a_multiplier_that_was_asked_for_and_not_found_is_no_dash():
    content = halved("it")
    del content["states"][SETTLED]["pushover"]["+x"]
    words = words_of(results := typed(content))
    [row] = [row for row in synthesis_grid(results, words).rows if row[:2] == [SETTLED, "+x"]]
    assert words("value.none") not in row[:-2] and row.count(words("value.open")) > 5


def test_sentences_and_terminal_say_so():
    results = typed(halved())
    hold(halved())
    text = " ".join(draft_judgement(results, words_of(results)))
    said = f"not determined, no capacity was found: “{SETTLED}”, +x (annex D)"
    assert said in text
    assert f"ζ_E {said}." in told(results).splitlines()
