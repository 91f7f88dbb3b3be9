"""What a run leaves behind, from a real analysis: the PDF holds its figures and numbers, and all is the same again."""

import re

import pypdf
import pytest
from markupsafe import Markup
from PIL import Image

from assessment.report.document import render_html
from assessment.report.figures.style import PNG_DPI
from assessment.report.language import cell, words_of
from assessment.report.tables.mechanisms import balance, hand_check, reactions
from assessment.results.hand_check import figures_of, virtual_work_table
from assessment.results.summary import governing_view
from assessment.workflow.run import write
from tests.assessment.report.test_document import one_direction, without_assessment, without_settlement
from tests.support.analysed import analysed
from tests.support.results_example import results_example
from tests.support.typed import typed
from tests.validation.test_printed_table import CASES


@pytest.fixture(scope="module")
def products(tmp_path_factory):
    pytest.importorskip("weasyprint", exc_type=OSError)
    folder = tmp_path_factory.mktemp("products")
    assert write(typed(analysed("it")), folder) == []
    return folder


@pytest.fixture(scope="module")
def text(products):
    return squeezed("".join(page.extract_text() for page in pypdf.PdfReader(products / "report.pdf").pages))


def squeezed(words):
    return re.sub(r"\s+", "", words)


def printed(rows, columns, words, significant=3):
    """Rows as the PDF has them, cell after cell: a number by itself would be found in some other place."""
    kept = [column for column in columns if any(column in row for row in rows)]
    return [
        squeezed("".join(cell(column, row, words, significant).striptags() for column in kept))
        for row in rows
    ]


def test_reactions_and_their_balance_are_printed(text):
    results = analysed("it")
    for table in (reactions(typed(results)), balance(typed(results))):
        rows = printed(table.rows, table.columns, words_of(typed(results)))
        assert len(rows) >= 6
        assert [row for row in rows if row not in text] == []


def test_the_hand_check_is_printed_with_all_its_figures(text):
    results = analysed("it")
    words, table = words_of(typed(results)), hand_check(typed(results))
    rows = printed(table.rows, table.columns, words, 4)
    for state, direction in [governing_view(typed(results))]:  # the others in full
        figures = virtual_work_table(figures_of(typed(results), state, direction))
        rows += printed(figures.rows, figures.columns, words, 4)
    assert len(rows) >= 6
    assert [row for row in rows if row not in text] == []


def test_full_annexes_have_the_validation_of_this_version(tmp_path, monkeypatch):
    """Short ones say that the producer declares it."""
    monkeypatch.setattr("assessment.report.document.pictures", lambda _: [])
    results = analysed("it")
    shown = {}
    for annexes in ("short", "full"):
        results["echo"]["report"]["annexes"] = annexes
        page = render_html(typed(results), tmp_path, words_of(typed(results)))
        shown[annexes] = squeezed(Markup(page).striptags())
    for case in CASES:
        numbers = (case[key].replace(".", ",") for key in ("expected", "computed"))
        words = (Markup(case["it"][key]).striptags() for key in ("case", "source"))
        assert squeezed("".join([*words, *numbers])) in shown["full"], case["id"]
    assert "Ilproduttoredichiara" in shown["short"] and len(shown["short"]) < 0.75 * len(shown["full"])


def test_figures_of_joints_and_of_the_end_of_capacity_are_there(products, text):
    names = {path.stem for path in (products / "figures").glob("*.svg")}
    assert {"synthesis", "thrust_at_rest", "thrust", "overturned", "history_1"} <= names
    assert names == {path.stem for path in (products / "figures").glob("*.png")}
    assert squeezed("linea delle pressioni") in text
    for path in (products / "figures").glob("*.svg"):
        words = re.findall(r">([^<>]+)</text>", path.read_text(encoding="utf-8"))
        assert words, path.name


def test_drawings_are_grey_and_coloured_lines_print_in_grey(products):
    """States have colours, dark enough to be seen in grey; pictures without any are grey."""
    for path in (products / "figures").glob("*.svg"):
        colours = re.findall(r"#([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})\b", path.read_text(encoding="utf-8"))
        assert colours, path.name
        plain = all(red == green == blue for red, green, blue in colours)
        for colour in colours:
            red, green, blue = (int(part, 16) for part in colour)
            assert red == green == blue or 0.299 * red + 0.587 * green + 0.114 * blue < 128, path.name
        with Image.open(path.with_suffix(".png")) as image:
            assert (image.mode, round(image.info["dpi"][0])) == ("L" if plain else "P", PNG_DPI)
            assert image.convert("L").getextrema() == (0, 255), path.name


def test_the_same_results_leave_the_same_bytes(tmp_path):
    """In two processes what was made in one: every file of a small report."""
    pytest.importorskip("weasyprint", exc_type=OSError)
    results = results_example("en")
    without_settlement(results)
    one_direction(results)
    without_assessment(results)
    shares: list[float] = []
    assert write(typed(results), tmp_path / "one") == []
    assert write(typed(results), tmp_path / "two", jobs=2, reached=shares.append) == []
    assert 0.0 < shares[0] < 0.05 and 0.9 < shares[-1] <= 1.0 and shares == sorted(shares)
    before, after = (
        {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
        for folder in (tmp_path / "one", tmp_path / "two")
    )
    assert before.keys() == after.keys() and {".pdf", ".docx", ".html", ".svg", ".png", ".csv", ".json"} <= {
        name.suffix for name in before
    }
    assert [name for name in before if before[name] != after[name]] == []
