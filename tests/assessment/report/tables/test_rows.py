"""Tables of the fields of a part: a number that the schema describes in one line is in every product."""

import pytest
from markupsafe import Markup

from assessment.report.chapters.grids import grid
from assessment.report.language import Words
from assessment.report.tables import write_tables
from assessment.report.tables.rows import TABLES, table
from assessment.results.schema.model import QualityRow
from assessment.results.schema.part import QUANTITIES, key
from tests.support.results_example import results_example
from tests.support.typed import typed
from tools.docs_pages import _section


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
    for language, heading, cell in (("it", "Deriva [mm]", "1,2"), ("en", "Drift [mm]", "1.2")):
        printed = grid(made(results), Words.of(language), Markup(""))
        assert str(printed.head[-1]) == heading and str(printed.rows[0][-1]) == cell
    write_tables(results, tmp_path)
    head, line = (tmp_path / "tried.csv").read_text().splitlines()
    assert head.endswith(",storey_drift_m") and line.endswith(",0.001234")
    told = Tried.model_json_schema()["properties"]["storey_drift_m"]
    assert (told["unit"], told["description"]) == ("m", "largest drift of a storey")
    assert "| `storey_drift_m` | number | m | largest drift of a storey |" in _section(Tried)
