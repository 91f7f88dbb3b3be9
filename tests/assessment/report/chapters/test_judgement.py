"""The draft judgement claims nothing that a table contradicts; judgement.md: drafted, edited, kept, printed, told."""

from types import SimpleNamespace

import pytest
from hypothesis import given, settings

from assessment.cli.main import main
from assessment.report.chapters.judgement import NAME, draft_judgement, judgement, to_html
from assessment.report.figures.index import write_figures
from assessment.report.language import NO_BREAK, words_of
from assessment.runtime.pool import Pool
from assessment.workflow.run import write
from tests.assessment.report.tables.test_study_tables import results_with_studies
from tests.support.analysed import analysed
from tests.support.judgement.claims import CLAIMS, PARTS, RESIDUALS, WORDS, Results, hold
from tests.support.judgement.random_results import random_results, summed_up
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed


def test_every_text_of_the_judgement_is_a_claim_that_is_checked():
    assert set(WORDS.strings["judgement"]) == CLAIMS.keys() | PARTS


@given(random_results())
@settings(max_examples=25)
def test_every_sentence_agrees_with_the_tables(results):
    hold(results)


@pytest.mark.parametrize(
    "make", [results_example, results_with_studies, analysed], ids=lambda make: make.__name__
)
def test_so_does_every_sentence_of_an_analysis(make):
    keys = hold(make("en"))
    assert {"certificates", "limits"} <= set(keys)


def text_of(results: Results) -> str:
    hold(results)
    return " ".join(draft_judgement(typed(results), words_of(typed(results)))).replace(NO_BREAK, " ")


def test_a_mechanism_chosen_by_the_engineer_is_not_forgotten():
    results = results_example("en")
    check = {
        "a_g_g": 0.01, "demand_a_g_g": 0.261, "zeta_E": 0.038, "verified": False, "return_period_years": None,
    }  # fmt: skip
    given_mechanism = {
        "name": "gable", "state": "original", "direction": "+x", "alpha_0": 0.1, "SLV linear": check,
    }  # fmt: skip
    results["mechanisms"] = [given_mechanism]
    assert "“gable”, SLV, linear, state “original”: ratio 0.038" in text_of(results)


def test_a_turn_of_a_support_has_its_margin():
    """The largest displacement of a pure rotation is 0: the sentence was left out."""
    results = results_example("en")
    results["states"][SETTLED]["settlement"] |= {"displacement_m": [0.0, 0.0], "rotation_rad": 0.01}
    text = text_of(results)
    assert "rigid contacts: the movement of 20.0 mm is 31 % of the ultimate one (65.0 mm)." in text


@pytest.mark.parametrize(("tie", "told"), [("chain", "a tie breaks"), (None, "a joint that bears is lost")])
def test_what_a_movement_costs_before_the_ultimate_one_stands_beside_it(tie, told):
    """ "13 % of the ultimate one" stood alone where the chain breaks at a sixth of that."""
    results = results_example("en")
    loss = {
        "displacement_m": 0.03,
        "joint": None if tie else 3,
        "blocks": [1, 2],
        "overlap_m": None,
        "tie": tie,
    }
    results["states"][SETTLED]["pushdown"]["rigid"]["local_loss"] = loss
    assert f"rigid contacts: at 30.0 mm of movement {told}." in text_of(results)


@pytest.mark.parametrize(("name", "allowed"), RESIDUALS.items())
def test_poor_certificates_are_not_hidden(name, allowed):
    for residual, poor in ((0.9 * allowed, False), (1.1 * allowed, True)):
        results = results_example("en")
        results["quality"]["by_stage"][1][f"worst_{name}"] = residual
        results["quality"] = summed_up(results["quality"])
        assert ("must be checked" in text_of(results)) == poor


def test_a_poor_hand_check_is_not_hidden():
    results = results_example("en")
    results["states"]["original"]["pushover"]["+x"]["rigid"]["virtual_work_alpha"] = 0.2
    assert "must be explained" in text_of(results)


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
        ("- one\n\n      - below *it*", "<ul> <li> <p>one</p> <ul> <li>below <i>it</i></li> </ul> </li> </ul>"),
        ("<script>x</script> [a](http://b) ![c](d)", "<p>&lt;script&gt;x&lt;/script&gt; [a](http://b) ![c](d)</p>"),
        ("## **Bold** \\*starred\\*", "<h3><b>Bold</b> *starred*</h3>"),
    ],
    ids=["blocks", "comments", "symbols", "nested", "no HTML and no network", "escapes"],
)  # fmt: skip
def test_markdown_of_a_judgement(text, html):
    assert to_html(text).replace("\n", " ") == html


def test_a_run_prints_the_edited_judgement_and_leaves_the_file(results, tmp_path, monkeypatch):
    monkeypatch.setattr("assessment.report.figures.index.pictures", lambda _: [])
    monkeypatch.setattr("assessment.report.document.pictures", lambda _: [])
    monkeypatch.setattr("assessment.report.figures.index.write_deformed", lambda *_: None)
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
