"""What a run leaves behind, from a real analysis: the page holds its numbers, the figures are there."""

import re
from xml.etree import ElementTree

import pytest
from markupsafe import Markup
from PIL import Image

from assessment.report.document import render_html, write_page
from assessment.report.figures import index as figures
from assessment.report.figures.drawing import PNG_DPI
from assessment.report.figures.index import write_figures, write_images
from assessment.report.language import cell, slug, words_of
from assessment.report.tables.mechanisms import balance, hand_check, reactions
from assessment.results.hand_check import governing_view, macro_blocks, virtual_work_table
from assessment.runtime.pool import Pool
from tests.support.analysed import SETTLED, analysed
from tests.support.typed import typed
from tests.support.wording import squeezed
from tests.validation.test_printed_table import CASES


@pytest.fixture(scope="module")
def products(tmp_path_factory):
    folder = tmp_path_factory.mktemp("products")
    results = typed(analysed("it"))
    with Pool(0, results) as pool, pytest.MonkeyPatch.context() as patch:
        write_figures(pool, folder / "figures")
        some = figures.pictures(results)[::4]  # of all it would take half of the time
        patch.setattr(figures, "pictures", lambda _: some)
        write_images(pool, folder / "figures")
    write_page(results, folder)
    return folder


@pytest.fixture(scope="module")
def text(products):
    page = (products / "report.html").read_text(encoding="utf-8")
    return squeezed(Markup(re.sub(r"<(style|script).*?</\1>", "", page, flags=re.S)).striptags())


def printed(rows, columns, words, significant=3):
    """Rows as the page has them, cell after cell: a number by itself would be found in some other place."""
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
        figures = virtual_work_table(macro_blocks(typed(results), state, direction))
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
    assert {"synthesis", "thrust_at_rest", "thrust", "overturned", "history_1", "model"} <= names
    assert {"mechanism", "pushover", "spectra_SLV", "spectra_SLC"} <= names
    stem = slug(typed(analysed("it")), SETTLED)
    assert {f"settlement_{stem}", f"pushdown_{stem}"} <= names
    assert names > {path.stem for path in (products / "figures").glob("*.png")} > set()
    assert squeezed("linea delle pressioni") in text
    for path in (products / "figures").glob("*.svg"):
        assert [each for each in ElementTree.parse(path).iter() if each.tag.endswith("text")], path.name


def test_drawings_are_grey_and_coloured_lines_print_in_grey(products):
    """States have colours, dark enough to be seen in grey; pictures without any are grey."""
    for path in (products / "figures").glob("*.svg"):
        colours = re.findall(r"#([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})\b", path.read_text(encoding="utf-8"))
        assert colours, path.name
        for colour in colours:
            red, green, blue = (int(part, 16) for part in colour)
            assert red == green == blue or 0.299 * red + 0.587 * green + 0.114 * blue < 128, path.name
    for path in (products / "figures").glob("*.png"):
        with Image.open(path) as image:
            assert (image.mode, round(image.info["dpi"][0])) == ("P", PNG_DPI)
            assert image.convert("L").getextrema() == (0, 255), path.name
