"""judgement.md: drafted, edited, kept, printed; and told when its numbers have changed."""

from types import SimpleNamespace

import pytest

from assessment.cli.main import main
from assessment.report.chapters.judgement import NAME, judgement, to_html
from assessment.report.figures.index import write_figures
from assessment.report.language import words_of
from assessment.runtime.pool import Pool
from assessment.workflow.run import write
from tests.support.results_example import results_example
from tests.support.typed import typed


@pytest.fixture
def results():
    return results_example("en")


def test_the_draft_is_replaced_by_the_next_one_while_nobody_edits_it(results, tmp_path):
    first = judgement(typed(results), words_of(typed(results)), tmp_path)
    assert first.edited is None
    assert "ζ_E" in first.content.decode()
    assert "<sub>" not in first.content.decode()
    (tmp_path / NAME).write_bytes(first.content)
    results["states"]["original"]["capacity"]["+x"]["SLV"]["zeta_E"] = 0.01
    second = judgement(typed(results), words_of(typed(results)), tmp_path)
    assert second.content.decode() != first.content.decode()
    assert second.edited is None
    assert not second.warnings


def test_an_edited_text_is_kept_and_a_change_of_the_numbers_is_said(results, tmp_path):
    words = words_of(typed(results))
    draft = judgement(typed(results), words, tmp_path).content.decode()
    edited = draft + "\nThe **pier** must be tied <at once>.\n"
    (tmp_path / NAME).write_text(edited, encoding="utf-8")
    kept = judgement(typed(results), words, tmp_path)
    assert kept.content.decode() == edited
    assert "<p>The <b>pier</b> must be tied &lt;at once&gt;.</p>" in str(kept.edited)
    assert not kept.warnings
    results["states"]["original"]["capacity"]["+x"]["SLV"]["zeta_E"] = 0.01
    later = judgement(typed(results), words, tmp_path)
    assert later.content.decode() == edited
    assert "changed" in later.warnings[0]


def test_a_draft_that_an_editor_saved_in_its_own_way_is_still_the_draft(results, tmp_path):
    words = words_of(typed(results))
    draft = judgement(typed(results), words, tmp_path).content.decode()
    for saved in (draft.encode("utf-16"), draft.replace("\n", "\r\n").encode("utf-8-sig")):
        (tmp_path / NAME).write_bytes(saved)
        assert judgement(typed(results), words, tmp_path).edited is None


@pytest.mark.parametrize("content", [b"PK\x03\x04\x00\x00", b"\x81\x8d"])
def test_what_is_no_text_is_told_before_any_analysis(project, capsys, monkeypatch, content):
    monkeypatch.setattr("assessment.workflow.stages.run", lambda *_: pytest.fail("an analysis ran"))
    path = project / "output" / NAME
    path.parent.mkdir()
    path.write_bytes(content)
    assert main(["check", str(project)]) == 2
    assert capsys.readouterr().err == (
        f"error: {path}: not readable as text; save it as UTF-8, or delete it to have a new draft\n"
    )
    assert path.read_bytes() == content


@pytest.mark.parametrize(
    ("text", "html"),
    [
        (
            "# Opinion\n\nA line\nand *more*.\n\n- one\n  goes on\n- two & three\n",
            "<h3>Opinion</h3> <p>A line and <i>more</i>.</p> <ul> <li>one goes on</li> <li>two &amp; three</li> </ul>",
        ),
        ("a <!-- not\n\nthis --> b <!-- open", "<p>a  b &lt;!-- open</p>"),
        ("ζ_E and S_De are 2 * 3, 4 * 5", "<p>ζ_E and S_De are 2 * 3, 4 * 5</p>"),
        (
            "- one\n\n      - below *it*",
            "<ul> <li> <p>one</p> <ul> <li>below <i>it</i></li> </ul> </li> </ul>",
        ),
        (
            "<script>x</script> [a](http://b) ![c](d)",
            "<p>&lt;script&gt;x&lt;/script&gt; [a](http://b) ![c](d)</p>",
        ),
        ("## **Bold** \\*starred\\*", "<h3><b>Bold</b> *starred*</h3>"),
    ],
    ids=["blocks", "comments", "symbols", "nested", "no HTML and no network", "escapes"],
)
def test_markdown_of_a_judgement(text, html):
    assert to_html(text).replace("\n", " ") == html


def test_a_run_prints_the_edited_judgement_and_leaves_the_file(results, tmp_path, monkeypatch):
    monkeypatch.setattr("assessment.report.figures.index.pictures", lambda _: [])
    monkeypatch.setattr("assessment.report.document.pictures", lambda _: [])
    monkeypatch.setattr("assessment.report.figures.deformed_dxf.write_deformed", lambda *_: None)
    write_figures(Pool(0, typed(results)), tmp_path / "figures")
    write(typed(results), tmp_path, report=False)
    path = tmp_path / NAME
    path.write_text(path.read_text(encoding="utf-8") + "\nStrut the right pier.\n", encoding="utf-8")
    before = path.read_bytes()
    monkeypatch.setitem(__import__("sys").modules, "weasyprint", _Printer)
    write(typed(results), tmp_path)
    assert path.read_bytes() == before
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<p>Strut the right pier.</p>" in page
    assert "A draft written from the numbers" not in page


class _Printer:
    class HTML:
        def __init__(self, string):
            self.string = string

        def write_pdf(self):
            return b"%PDF-"

        def render(self):  # without heights, so that the page stays as it is
            return SimpleNamespace(pages=[])
