"""No message of the analyses stands in English in an Italian report: every one that the code can make is known."""

import ast
import re
import tomllib

import pytest

from assessment.report.chapters.judgement import all_warnings
from assessment.report.text.language import Words
from assessment.report.text.messages import _entries, _translated, sentence, translated
from tests import ROOT
from tests.support.analysed import analysed
from tests.support.typed import typed

RAISED = {"UnstableError", "NoEquilibriumError", "CollapseError", "ConvergenceError", "ControlError"}
RAISED |= {"CapacityError", "MechanismError"}
LISTS = {"warnings", "notes", "failures", "findings"}
ELSEWHERE = {"mechanics/records/synthetic.py", "assessment/benchmark/cases/dynamics.py"}  # no part of a run
NAMED = {"_SHAPES", "_COLLAPSE_FIRST", "end"}
SAYING = {
    "loss_sentence",
    "not_met",
    "missed",
    "collapse",
    "overruns",
    "passing_through",
    "_notes",
    "scatter",
}
SAYING |= {"_gap_texts", "_gap_warnings", "_remedy", "_scattered", "_spread", "_rigid_notes"}
MESSAGE = "the whole movement is applied"  # in the place of a message within a message
WITHIN = {
    "error",
    "collapse",
    "stop",
    "fall",
    "refusal",
    "note",
    "text",
    "why",
    "start",
    "end",
    "sentence",
    "missed",
}
WITHIN |= {"self.end", "unstable", "path.end", "last.collapse_reason", "failed[state]", "warnings[0]"}
WITHIN |= {"what", "names"}
ITALIAN, ENGLISH = Words.of("it"), Words.of("en")


def messages():
    """Yield where each message stands in the code, and an example of it."""
    for package in ("assessment", "mechanics"):
        for path in sorted((ROOT / package).rglob("*.py")):
            name = str(path.relative_to(ROOT))
            if name not in ELSEWHERE:
                for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                    for text in texts(node):
                        yield f"{name}:{text.lineno}:{text.col_offset}", example(text)


def texts(node):
    """Return the texts (strings, with or without fields) that a statement adds to warnings or raises.

    Of some functions, whose answer is a message, all.
    """
    if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and called(node.exc) in RAISED:
        parts = node.exc.args[:1]
    elif isinstance(node, ast.AugAssign) and last(node.target) in LISTS:
        parts = getattr(node.value, "elts", [getattr(node.value, "elt", None)])
    elif isinstance(node, ast.Call) and called(node) == "append" and last(node.func.value) in LISTS:
        parts = node.args
    elif isinstance(node, ast.Assign) and last(node.targets[0]) in LISTS | NAMED:
        parts = getattr(node.value, "elts", [node.value])
    elif isinstance(node, ast.FunctionDef) and node.name in SAYING:
        everything = [each for statement in node.body[1:] for each in ast.walk(statement)]
        outer = [each for each in everything if isinstance(each, ast.JoinedStr)]
        inner = {part for each in outer for part in ast.walk(each) if part is not each}
        parts = [each for each in everything if each not in inner and (each in outer or is_sentence(each))]
    else:
        parts = []
    return [part for part in parts if isinstance(part, ast.JoinedStr | ast.Constant)]


def is_sentence(node):
    return isinstance(node, ast.Constant) and isinstance(node.value, str) and len(node.value.split()) > 2


def called(call):
    return last(call.func)


def last(node):
    return node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")


def example(text):
    if isinstance(text, ast.Constant):
        return text.value
    return "".join(
        part.value if isinstance(part, ast.Constant) else value(ast.unparse(part.value))
        for part in text.values
    )


def value(expression):
    if expression in WITHIN:
        return "increments" if expression == "what" else "depth" if expression == "names" else MESSAGE
    if expression in {"title", "name", "state"}:
        return "original, rigid contacts" if expression == "title" else "original"
    if expression.startswith("name_of("):
        return 'block 3 (layer "WALL", handle 2F)'
    return {"direction": "+x", "limit_state": "SLV"}.get(expression, "1.5")


FOUND = dict(messages())


def test_the_code_is_looked_through():
    assert len(FOUND) > 80


@pytest.mark.parametrize("where", FOUND)
def test_every_message_is_known_in_italian(where):
    words = ITALIAN
    text = _translated(FOUND[where], words, _entries("it"))
    assert text is not None, FOUND[where]
    assert MESSAGE not in text


@pytest.mark.parametrize(
    ("english", "italian"),
    [
        (
            "right support 20 mm, pushover -x, rigid contacts: ends at d = 0.0123 m, α = 0.05: the structure falls: "
            "a step of 0.001 m moves it by 0.2 m",
            "stato “right support 20 mm”, pushover in direzione −x, contatti rigidi: la curva termina a d = 0,0123 m, "
            "α = 0,05: la struttura perde l’equilibrio: un incremento di 0,001 m la sposta di 0,2 m",
        ),
        (
            "original: +x: SLC: no acceleration capacity is left at d* = 0.1 m",
            "originale: +x: SLC: a d* = 0,1 m la capacità in accelerazione è esaurita",
        ),
        (
            'geometry.dxf: layer "A.1": 3 frozen, off or invisible polylines left out',
            "geometry.dxf: layer «A.1»: 3 polilinee congelate, spente o invisibili tralasciate",
        ),
        ("something new", "something new"),
    ],
)
def test_messages_within_messages_numbers_and_names(english, italian):
    assert translated(english, ITALIAN) == italian
    assert translated(english, ENGLISH) == english


def test_warnings_are_sentences_in_the_report():
    """A capital, a full stop, powers of ten; the state is told as one, whatever its name."""
    message = (
        "moved 20 mm, pushover -x, rigid contacts: between d = 7.7e-12 and 1e-05 m a part moves by itself"
    )
    english = ENGLISH
    assert sentence(message, english) == (
        "State “moved 20 mm”, pushover in direction −x, rigid contacts: "
        "between d = 7.7·10⁻¹² and 1·10⁻⁵ m a part moves by itself."
    )
    italian = sentence(f"{message}, until others hold it again", ITALIAN)
    assert italian.startswith(
        "Stato “moved 20 mm”, pushover in direzione −x, contatti rigidi: fra d = 7,7·10⁻¹² e"
    )
    assert italian.endswith("fino a trovare un nuovo contrasto.")
    assert sentence("$INSUNITS says mm.", english) == "$INSUNITS says mm."
    assert sentence("α = 0", english) == "α = 0."


def test_symbols_of_warnings_are_set_as_symbols():
    message = (
        "original, pushover +x, rigid contacts: with friction that does not lift what slides (Coulomb) "
        "α0 is 0.07, not 0.08"
    )
    assert sentence(message, ENGLISH).count("α<sub>0</sub> is") == 1
    assert "α<sub>0</sub> vale 0,07" in sentence(message, ITALIAN)
    text = "SLV: S_De at T_SLV; see max_scale, Tc_star_s, d_0_m"
    assert sentence(text, ENGLISH) == (
        "SLV: S<sub>De</sub> at T<sub>SLV</sub>; see max_scale, Tc_star_s, d_0_m."
    )
    assert sentence("<b> a_g", ENGLISH) == "&lt;b&gt; a<sub>g</sub>."


def test_the_warnings_of_a_run_are_known():
    words = ITALIAN
    for warning in all_warnings(typed(analysed("it"))):
        assert _translated(warning, words, _entries("it")) is not None, warning


def test_a_message_with_an_acceleration_says_which_it_is():
    """ "Collapse at 0.31 g" did not say of what: PGA, a_g, or the acceleration that is left of a block."""
    named = re.compile(r"PGA|a_g|accelera|\{ag\}")
    entries = tomllib.loads((ROOT / "templates/messages_it.toml").read_text(encoding="utf-8"))
    found = [both for both in entries.items() if re.search(r"\} g\b", both[1])]
    assert len(found) > 8
    assert [both for both in found if not all(map(named.search, both))] == []
