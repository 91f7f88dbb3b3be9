"""judgement.md: drafted, edited, kept, printed; and told when its numbers have changed."""

import pytest

from assessment.earlier import NO_REPORT
from assessment.figures import write_figures
from assessment.judgement_file import NAME, judgement, to_html
from assessment.output import write
from assessment.pool import Pool
from assessment.words import words_of
from tests.results_example import results_example


@pytest.fixture
def results():
    return results_example("en")


def test_the_draft_is_replaced_by_the_next_one_while_nobody_edits_it(results, tmp_path):
    first = judgement(results, words_of(results), tmp_path)
    assert first.edited is None
    assert "- The governing condition is the state" in first.content.decode()
    assert "ζ_E" in first.content.decode()
    assert "<sub>" not in first.content.decode()
    (tmp_path / NAME).write_bytes(first.content)
    results["states"]["original"]["capacity"]["+x"]["SLC"]["zeta_E"] = 0.01
    second = judgement(results, words_of(results), tmp_path)
    assert second.content.decode() != first.content.decode()
    assert second.edited is None
    assert not second.warnings


def test_an_edited_text_is_kept_and_a_change_of_the_numbers_is_said(results, tmp_path):
    words = words_of(results)
    draft = judgement(results, words, tmp_path).content.decode()
    edited = draft + "\nThe **pier** must be tied <at once>.\n"
    (tmp_path / NAME).write_text(edited, encoding="utf-8")
    kept = judgement(results, words, tmp_path)
    assert kept.content.decode() == edited
    assert "<p>The <b>pier</b> must be tied &lt;at once&gt;.</p>" in str(kept.edited)
    assert not kept.warnings
    results["states"]["original"]["capacity"]["+x"]["SLC"]["zeta_E"] = 0.01
    later = judgement(results, words, tmp_path)
    assert later.content.decode() == edited
    assert "changed" in later.warnings[0]


def test_a_text_of_ones_own_without_the_mark_is_kept(results, tmp_path):
    (tmp_path / NAME).write_text("Mine.\n", encoding="utf-8")
    kept = judgement(results, words_of(results), tmp_path)
    assert kept.content.decode() == "Mine.\n"
    assert kept.warnings


def test_markdown_of_a_judgement():
    text = "# Opinion\n\nA line\nand *more*.\n\n- one\n  goes on\n- two & three\n"
    assert to_html(text).replace("\n", "") == (
        "<h3>Opinion</h3><p>A line and <i>more</i>.</p><ul><li>one goes on</li><li>two &amp; three</li></ul>"
    )


def test_a_run_prints_the_edited_judgement_and_leaves_the_file(results, tmp_path, monkeypatch):
    monkeypatch.setattr("assessment.figures.pictures", lambda _: [])
    monkeypatch.setattr("assessment.report.pictures", lambda _: [])
    monkeypatch.setattr("assessment.deformed_dxf.write_deformed", lambda *_: None)
    write_figures(Pool(0, results), tmp_path / "figures")
    write(results, tmp_path, NO_REPORT)
    path = tmp_path / NAME
    path.write_text(path.read_text(encoding="utf-8") + "\nStrut the right pier.\n", encoding="utf-8")
    before = path.read_bytes()
    monkeypatch.setitem(__import__("sys").modules, "weasyprint", _Printer)
    write(results, tmp_path)
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
