"""report.docx: the chapters, tables and figures of the page, in named styles; opened again, and by LibreOffice."""

import pytest
from docx import Document
from docx.oxml.ns import qn
from lxml import html

from assessment.report.document import CHAPTERS, write_docx, write_page
from assessment.report.figures.index import write_images
from assessment.report.language import words_of
from assessment.runtime.pool import Pool, result_of
from tests.support.pictured import draw_sections
from tests.support.results_example import results_example
from tests.support.typed import typed
from tests.support.wording import squeezed


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("it")
    results = results_example("it")
    for content in results["states"].values():
        content["pushover"].pop("-x", None)  # half the figures
        content["capacity"].pop("-x", None)
    pool = Pool(0, typed(results))
    (folder / "figures").mkdir()
    draw_sections(typed(results), folder / "figures")  # those of the page
    for work in write_images(pool, folder / "figures"):
        result_of(work)
    write_page(typed(results), folder)
    write_docx(typed(results), folder)
    return results, folder


def test_the_document_says_what_the_page_says(made):
    """Every chapter in its order, every paragraph, table and cell, every figure with its caption."""
    results, folder = made
    words = words_of(typed(results))
    document = Document(folder / "report.docx")
    page = html.document_fromstring((folder / "report.html").read_text(encoding="utf-8"))
    page.get_element_by_id("viewer").drop_tree()
    headings = [p.text for p in document.paragraphs if p.style.name == "Heading 1"]
    assert headings == [each.text_content() for each in page.iterfind(".//main//h2")]
    assert len(headings) > len(CHAPTERS)
    body = squeezed("".join(document.element.body.itertext()))
    for element in page.find(".//main").iter("p", "li", "figcaption", "caption", "td", "th"):
        assert squeezed(element.text_content()) in body
    tables = page.findall(".//main//table")
    native = [table for table in document.tables if table.style.name == "Report Table"]
    assert [len(t.rows) for t in native] == [
        len(t.findall(".//tr")) for t in tables if "fields" not in t.classes
    ]
    assert len(document.inline_shapes) == len(page.findall(".//main//figure"))
    assert document.core_properties.title == f"{results['title']} – {words('page.evaluation')}"


def test_equations_keep_their_subscripts_and_styles_are_named(made):
    _, folder = made
    document = Document(folder / "report.docx")
    table = next(t for t in document.tables if any("α0" in c.text for c in t.rows[0].cells))
    cell = next(c for c in table.rows[0].cells if "α0" in c.text)
    assert [run.text for run in cell.paragraphs[0].runs if run.font.subscript] == ["0"]
    assert all(row._tr.trPr.find(qn("w:cantSplit")) is not None for row in table.rows)
    assert table.rows[0]._tr.trPr.find(qn("w:tblHeader")) is not None
    used = {p.style.name for p in document.paragraphs}
    assert used >= {
        "Title", "Heading 1", "Heading 2", "Body Text", "List Bullet", "Caption", "Table Caption", "Figure",
    }  # fmt: skip
    assert not [p.text for p in document.paragraphs if p.style.name == "Normal" and p.text]
