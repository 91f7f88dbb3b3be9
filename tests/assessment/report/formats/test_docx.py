"""report.docx: the chapters, tables and figures of the page, in named styles; opened again, and by LibreOffice."""

import io
import re
import shutil
import subprocess

import pypdf
import pytest
from docx import Document
from docx.oxml.ns import qn
from lxml import html

from assessment.report.document import CHAPTERS, write_docx, write_page
from assessment.report.figures.index import write_images
from assessment.report.formats.docx import to_docx
from assessment.report.text.language import LANGUAGES, words_of
from assessment.runtime.pool import Pool, result_of
from tests.support.pictured import draw_sections
from tests.support.results_example import results_example
from tests.support.typed import typed


@pytest.fixture(scope="module", params=LANGUAGES)
def made(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    results = results_example(request.param)
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


def squeezed(text):
    return re.sub(r"\s+", "", text)


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
        "Title",
        "Heading 1",
        "Heading 2",
        "Body Text",
        "List Bullet",
        "Caption",
        "Table Caption",
        "Figure",
    }
    assert not [p.text for p in document.paragraphs if p.style.name == "Normal" and p.text]


def test_figures_fit_the_page_and_say_what_they_show(made):
    _, folder = made
    document = Document(folder / "report.docx")
    section = document.sections[-1]
    width = section.page_width - section.left_margin - section.right_margin
    for shape in document.inline_shapes:
        assert 0 < shape.width <= width and 0 < shape.height < 0.65 * section.page_height
        assert shape._inline.docPr.get("descr")


def test_tables_of_twenty_rows_stand_on_one_and_the_stamp_has_its_room(made):
    """Of a longer one three rows at its head and three at its end go together."""
    _, folder = made
    document = Document(folder / "report.docx")
    whole = 0
    for table in (each for each in document.tables if each.style.name == "Report Table"):
        *rows, last = table.rows
        kept = [row.cells[0].paragraphs[0].paragraph_format.keep_with_next is True for row in rows]
        assert all(kept[:3]) and all(kept[-2:])
        whole += all(kept)
        assert all(kept) if len(rows) < 20 else not any(kept[3:-2])
        assert not last.cells[0].paragraphs[0].paragraph_format.keep_with_next
    assert whole > 10
    cover = document.tables[0]
    assert [row.height.mm for row in cover.rows if row.height is not None] == [pytest.approx(22.0, abs=0.1)]


def test_contents_refer_to_the_pages_of_the_headings(made):
    _, folder = made
    document = Document(folder / "report.docx")
    headings = [p for p in document.paragraphs if p.style.name == "Heading 1"]
    entries = [p for p in document.paragraphs if p.style.name == "toc 1"]
    assert [p.text.partition("\t")[0] for p in entries] == [p.text for p in headings]
    for entry, heading in zip(entries, headings, strict=True):
        [field] = [each.get(qn("w:instr")).split() for each in entry._p.iter(qn("w:fldSimple"))]
        [start] = heading._p.iter(qn("w:bookmarkStart"))
        assert field[:2] == ["PAGEREF", start.get(qn("w:name"))]
    numbers = [each.get(qn("w:id")) for each in document.element.body.iter(qn("w:bookmarkStart"))]
    assert len(set(numbers)) == len(numbers) == len(headings)


def test_running_heads_reach_the_right_margin(made):
    """One tab stop, at the right margin: the styles of the library bring others."""
    _, folder = made
    document = Document(folder / "report.docx")
    section = document.sections[-1]
    width = section.page_width - section.left_margin - section.right_margin
    for part in (section.header, section.footer):
        [stop] = part.paragraphs[0].paragraph_format.tab_stops
        assert stop.position == pytest.approx(width, abs=1000)
        assert not list(document.styles[part.paragraphs[0].style.name].paragraph_format.tab_stops)


def test_same_report_same_bytes(made):
    results, folder = made
    before = (folder / "report.docx").read_bytes()
    write_docx(typed(results), folder)
    assert (folder / "report.docx").read_bytes() == before


def test_spaces_between_words_of_different_format_are_kept(tmp_path):
    cover = "<section class='cover'><p class='subtitle'>s</p><h1>t</h1><p class='program'>p</p></section>"
    page = f"""<html lang='en'><body>{cover}<nav><h2>c</h2><ul><li><a href='#a'>1</a></li></ul></nav><main>
        <p>  Let <b>a<sub>g</sub></b> be
        <i>given</i> <b>here</b>: 0.3 g. </p></main></body></html>"""
    document = Document(io.BytesIO(to_docx(page, tmp_path)))
    assert document.paragraphs[-1].text == "Let ag be given here: 0.3\u00a0g."
    assert [r.text for r in document.paragraphs[-1].runs if r.font.bold] == ["a", "g", "here"]


@pytest.mark.skipif(not shutil.which("soffice"), reason="LibreOffice is not installed")
def test_libreoffice_renders_the_document(made, tmp_path):
    _, folder = made
    subprocess.run(
        ["soffice", "--headless", "--convert-to", "pdf", "--outdir", tmp_path, folder / "report.docx"],
        check=True,
        capture_output=True,
    )
    pages = pypdf.PdfReader(tmp_path / "report.pdf").pages
    assert len(pages) > len(CHAPTERS) // 2
    words = set("\n".join(page.extract_text() for page in pages).split())
    numbers = [
        cell.text
        for table in Document(folder / "report.docx").tables
        for row in table.rows
        for cell in row.cells
        if re.fullmatch(r"−?\d+[.,]\d+", cell.text)
    ]
    assert len(numbers) > 100
    assert [number for number in numbers if number not in words] == []  # none is broken over two lines
