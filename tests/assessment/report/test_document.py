"""The report: what NTC 2018 chapter 10 asks is in the PDF, and the numbers; the Word file says what the page says."""

import re
import shutil
import sys
from pathlib import Path
from string import Formatter

import pypdf
import pytest
from docx import Document
from docx.oxml.ns import qn
from hypothesis import given
from hypothesis import strategies as st
from lxml import html
from markupsafe import Markup

from assessment.report.chapters.synthesis import basis, lead, synthesis_grid
from assessment.report.document import CHAPTERS, render_html, write_docx, write_page, write_pdf
from assessment.report.figures import index
from assessment.report.figures.index import pictures
from assessment.report.language import LANGUAGES, Words, words_of
from assessment.report.printing import APT_COMMAND, COMMANDS
from assessment.workflow.run import write
from tests.support.pictured import draw_sections
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed
from tests.support.wording import squeezed


def strings(language):
    return Words.of(language).strings


def leaves(node, key=""):
    if isinstance(node, dict):
        for name, inner in node.items():
            yield from leaves(inner, f"{key}.{name}" if key else name)
    else:
        yield key, node


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    pytest.importorskip("weasyprint", exc_type=OSError)
    folder = tmp_path_factory.mktemp("it")
    results = results_example("it")
    one_direction(results)  # half the time
    assert write(typed(results), folder) == []
    pages = [page.extract_text() for page in pypdf.PdfReader(folder / "report.pdf").pages]
    return "it", results, folder, pages


def test_both_languages_have_the_same_keys_and_fields():
    italian, english = (dict(leaves(strings(language))) for language in LANGUAGES)
    assert italian.keys() == english.keys()
    for key, text in italian.items():
        assert text.strip()
        fields = [
            {name for _, name, _, _ in Formatter().parse(each) if name} for each in (text, english[key])
        ]
        assert fields[0] == fields[1], key


def test_the_answer_stands_on_the_page_after_the_title(report):
    """Sintesi on page 2, whole: the sentence, the table, what it rests on; the chapters begin behind it."""
    language, results, _, pages = report
    words, found = words_of(typed(results)), typed(results)
    page = squeezed(pages[1])
    for said in [*lead(found, words), *basis(found, words)]:
        assert squeezed(Markup(said).striptags()) in page
    assert squeezed(synthesis_grid(found, words).caption.striptags()) in page
    assert squeezed(strings(language)["section"]["norms"]) in squeezed(pages[2])


def test_expected_sections_stand_in_order_with_page_numbers(report):
    language, _results, _, pages = report
    contents, body = squeezed(pages[0]), squeezed("".join(pages[1:]))
    places = []
    there = [chapter for chapter in CHAPTERS if chapter != "dynamic"]
    for number, chapter in enumerate(there, 1):
        heading = squeezed(f"{number}. {strings(language)['section'][chapter]}")
        assert heading in contents
        places.append(body.index(heading))
    assert places == sorted(places)
    assert squeezed(f"{len(pages)} {strings(language)['page']['of']} {len(pages)}") in squeezed(pages[-1])
    assert len(pages) <= 16


def test_numbers_of_the_results_are_in_the_document(report):
    language, results, made, pages = report
    words, text = words_of(typed(results)), squeezed("".join(pages))
    for content in results["states"].values():
        for direction, pushover in content["pushover"].items():
            capacity = content["capacity"][direction]
            assert words.number(pushover["rigid"]["alpha_0"]) in text
            assert words.number(1000 * pushover["rigid"]["d_0_m"]) in text
            for limit in ("SLD", "SLV", "SLC"):
                assert words.ratio(capacity[limit]["zeta_E"]) in text
    assert ("0,153" if language == "it" else "0.153") in text
    assert squeezed(results["model"]["warnings"][0][1:]) in text
    assert "Comune<A&B>" in squeezed(pages[0])
    assert f"<td>{words.number(1000 * 0.192)}</td>" in (made / "report.html").read_text()


def test_figures_and_tables_are_numbered_without_gaps(report):
    language, _, made, pages = report
    text = "".join(pages)
    for kind in ("figure", "table"):
        word = strings(language)["page"][kind]
        numbers = [int(found) for found in re.findall(rf"{word}\s+(\d+)\.", text)]
        assert numbers == list(range(1, len(numbers) + 1))
        assert len(numbers) > 5
    assert (made / "report.html").read_text().count("<figure ") == (made / "report.html").read_text().count(
        "<figcaption>"
    )


def test_no_page_is_empty_and_nothing_is_left_unfilled(report):
    _, _, made, pages = report
    assert {"figures", "report.html", "report.pdf"} <= {path.name for path in made.iterdir()}
    assert min(len(page) for page in pages) > 100
    html = (made / "report.html").read_text()
    assert not re.search(
        r"\bNone\b|\bnan\b|\{\w+\}|http",
        re.sub(r"base64,[^\"]*|<(style|script).*?</\1>", "", html, flags=re.S),
    )


def test_the_same_results_leave_the_same_bytes(report, tmp_path, monkeypatch):
    """In two processes what was made in one: some figures, and all that is made of them but the PDF (test_fonts)."""
    _, results, made, _ = report
    found, some = typed(results), index.pictures(typed(results))[::3]
    shutil.copytree(made / "figures", tmp_path / "page" / "figures")
    write_page(found, tmp_path / "page")
    write_docx(found, tmp_path / "page")
    monkeypatch.setattr(index, "pictures", lambda _: some)
    assert write(found, tmp_path / "again", report=False, jobs=2) == []
    compared = set()
    for folder in (tmp_path / "page", tmp_path / "again"):
        for path in filter(Path.is_file, folder.rglob("*")):
            assert path.read_bytes() == (made / path.relative_to(folder)).read_bytes(), path.name
            compared.add(path.suffix)
    assert compared >= {".docx", ".html", ".svg", ".png", ".csv", ".json"}


def test_the_word_file_says_what_the_page_says(report):
    """Every chapter in its order, every paragraph, table and cell, every figure with its caption."""
    _, results, folder, _ = report
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


def test_equations_keep_their_subscripts_and_styles_are_named(report):
    _, _, folder, _ = report
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


def without_settlement(results):
    del results["states"][SETTLED]
    results["comparison"] = []
    results["echo"]["settlements"] = []


def without_rigid(results):
    for content in results["states"].values():
        for pushover in content["pushover"].values():
            del pushover["rigid"]


def without_assessment(results):
    for content in results["states"].values():
        del content["capacity"]
    results["comparison"], results["spectra"] = [], {}
    results["echo"]["assessment"] = None


def one_direction(results):
    for content in results["states"].values():
        content["pushover"].pop("-x", None)
        content["capacity"].pop("-x", None)


def unstable_state(results):
    content = results["states"][SETTLED]
    content["pushover"], content["capacity"], content["configuration"] = {}, {}, [[0.0] * 3] * 7
    for stage in content["pushdown"].values():
        stage["ultimate_configuration"] = None
    results["model"]["warnings"].append("the settled state cannot stand")


def unstable_model(results):
    results["model"]["self_weight_stable"] = False
    for content in results["states"].values():
        content.update(pushover={}, capacity={}, pushdown={})
    results["comparison"], results["spectra"], results["quality"]["by_stage"] = [], {}, []


def nothing_reached(results):
    for content in results["states"].values():
        for stage in content.get("pushdown", {}).values():
            stage["ultimate_movement_m"] = stage["ultimate_configuration"] = None
        for pushover in content["pushover"].values():
            pushover["rigid"]["d_0_m"] = pushover["rigid"]["virtual_work_alpha"] = None
            pushover["elastic"].update(alpha_y=None, d_y_m=None)
        for capacity in content["capacity"].values():
            capacity["T_0_s"] = None
            for limit in ("SLV", "SLC"):
                keys = ("d_star_m", "a_star_g", "T_s", "a_g_g", "zeta_E", "verified")
                capacity[limit].update(dict.fromkeys(keys))
    for row in results["comparison"]:
        row.update(static_pga_g=None, static_reduction=None)


def only_the_model(results):
    results["states"] = {"original": {"configuration": [[0.0] * 3] * 7, "settlement": None}}
    results["comparison"], results["quality"]["by_stage"] = [], []
    results["echo"] = {"report": results["echo"]["report"]}
    del results["spectra"], results["software"], results["inputs"]


FORMS = [
    without_settlement, without_rigid, without_assessment, unstable_state, unstable_model, nothing_reached,
    only_the_model,
]  # fmt: skip


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.__name__)
def test_degraded_forms_render(form, tmp_path):
    results = results_example("en")
    one_direction(results)
    form(results)
    draw_sections(typed(results), tmp_path)
    for picture in pictures(typed(results)):
        assert picture.draw().axes
    html = render_html(typed(results), tmp_path, words_of(typed(results)))
    for chapter in CHAPTERS:
        assert (f'<h2 id="{chapter}">' in html) == (
            chapter not in {"dynamic", "cracks"} or (chapter == "cracks" and SETTLED in results["states"])
        )
    if form is nothing_reached:
        assert "not reached" in html and "no capacity was found" in html
    if form is unstable_state:
        assert "the pushover in direction +x is not available" in html
    if form is unstable_model:
        assert "NO equilibrium" in html
        assert "must be reviewed" in html.partition('<h2 id="norms">')[0]


def test_without_system_libraries_the_html_is_written_and_the_command_given(tmp_path, monkeypatch, capsys):
    class Broken:
        def find_spec(self, name, path=None, target=None):
            if name.partition(".")[0] == "weasyprint":
                print("WeasyPrint could not import some external libraries.")  # as it does
                raise OSError("cannot load library 'libpango-1.0-0': not found")

    for name in [name for name in sys.modules if name.partition(".")[0] == "weasyprint"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", [Broken(), *sys.meta_path])
    results = results_example("en")
    only_the_model(results)
    for system, command in {"Linux": APT_COMMAND, **COMMANDS}.items():
        monkeypatch.setattr("platform.system", lambda system=system: system)
        [warning] = write_pdf(typed(results), tmp_path)
        assert command in warning
        assert "(cannot load library 'libpango-1.0-0': not found)" in warning
        assert "print report.html from a browser" in warning
    assert capsys.readouterr().out == ""
    assert not list(tmp_path.iterdir())


@given(st.floats(allow_nan=False, allow_infinity=False, min_value=-1e12, max_value=1e12))
def test_written_numbers_keep_three_digits(value):
    text = words_of(typed(results_example("en"))).number(value)
    superscripts = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻−", "0123456789--")
    back = float(text.translate(superscripts).replace("·10", "e"))
    assert back == pytest.approx(value, rel=5.1e-3)


def test_italian_numbers_have_a_comma():
    words = words_of(typed(results_example("it")))
    assert [words.number(x) for x in (0.1532, 12345.6, -0.5, 0.0, 3.2e-10)] == [
        "0,153", "12346", "−0,500", "0", "3,20·10⁻¹⁰",
    ]  # fmt: skip
