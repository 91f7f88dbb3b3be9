"""How columns are written: units of the heading, digits, dashes; no specification of a column that there is not."""

import ast
import pickle
from string import Formatter

import pytest

from assessment.report.chapters.judgement import all_warnings
from assessment.report.language import (
    LANGUAGES,
    Words,
    cell,
    heading,
    templates,
    translated,
    words_of,
    written,
)
from assessment.results.schema import as_bytes, read_results
from assessment.results.schema.part import QUANTITIES, Part, key
from mechanics import UnstableError
from mechanics.messages import Message, SaidError, headed, linked, message
from tests import ROOT
from tests.support.analysed import analysed
from tests.support.typed import typed
from tests.support.wording import in_italian

ENGLISH = Words.of("en")


def test_every_quantity_is_labelled_in_both_languages_and_once():
    """A column of a table that nothing describes stops the report; one described twice stops the program."""
    assert all(found.label.keys() == set(LANGUAGES) for found in QUANTITIES.values())
    with pytest.raises(ValueError, match="alpha_0: described in another table too"):
        type("Again", (Part,), {"__annotations__": {"alpha_0": float}, "alpha_0": key("", "α")})


def test_a_ratio_is_told_from_one():
    """ "1,00 non verificato" was printed of 0.9996."""
    assert [ENGLISH.ratio(each) for each in (0.9996, 1.0, 0.0975, 0.004, 0.48, 3.434, 12.34)] == [
        *("0.9996", "1.00", "0.098", "0.0040", "0.48", "3.43", "12.3")
    ]


def test_a_value_is_written_in_the_unit_of_its_heading():
    assert heading("d_0_m", ENGLISH).striptags() == "d0 [mm]"
    assert written("d_0_m", 0.01234, ENGLISH) == "12.3"
    assert heading("static_loss", ENGLISH).endswith("[%]")
    assert written("static_loss", 0.1234, ENGLISH) == "12", "no more digits than it is known with"
    losses = [name for name in QUANTITIES if "loss" in name or "reduction" in name]
    assert {written(name, -6.3e-13, ENGLISH) for name in losses} == {"0"}, (
        "of what rounding leaves no power of ten"
    )
    assert written("weight_kN", 12.34, ENGLISH) == "12.3", "any other number as results.json has it"


def test_only_the_headings_of_accelerations_say_what_they_refer_to():
    assert ENGLISH.plain("value.on_surface") in heading("a_g_g", Words.of("en", "surface"))
    assert ENGLISH.plain("value.on_surface") in heading("pga_g", ENGLISH)
    assert ENGLISH.plain("value.on_rock") not in heading("alpha_0", ENGLISH)


def test_what_differs_by_rounding_alone_is_written_alike():
    words = Words.of("en")
    assert words.number(0.07865) == words.number(0.07865 * (1.0 + 3e-16)) == words.number(0.07865000000001)


def test_what_is_not_there_is_told_from_what_was_not_reached():
    dash, not_reached = ENGLISH("value.none"), ENGLISH("value.not_reached")
    assert cell("d_0_m", {}, ENGLISH) == dash != not_reached
    assert cell("d_0_m", {"d_0_m": None}, ENGLISH) == not_reached
    assert written("x_C_m", None, ENGLISH) == written("direction", None, ENGLISH) == dash
    assert written("median_low_g", None, ENGLISH) == written("beta_high", None, ENGLISH) == dash
    assert written("median_g", None, ENGLISH) == not_reached


def test_a_displacement_below_a_micrometre_is_rounding():
    """ "peak 4.62e-10 mm" was printed of a block that does not move."""
    words = Words.of("en")
    assert (
        words.told("movement_m", 4.6e-13) == "< 0.001\u00a0mm"
        and words.told("movement_m", 0.0) == "0\u00a0mm"
    )
    assert words.told("movement_m", 2.3e-6) == "0.00230\u00a0mm"
    assert str(written("peak_displacement_m", 4.6e-13, words)) == "0"


TITLE = message(
    "{state}, pushover {direction}, {contacts} contacts",
    state="moved 20 mm",
    direction="-x",
    contacts="rigid",
)


def calls():
    """Yield where each message is made in the code, and its template."""
    for package in ("assessment", "mechanics"):
        for path in sorted((ROOT / package).rglob("*.py")):
            text = path.read_text(encoding="utf-8")
            for node in ast.walk(ast.parse(text if "message(" in text else "")):
                if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "message":
                    yield f"{path.relative_to(ROOT)}:{node.lineno}", node


def fields(template):
    """The fields of a template with their formats; no other way of writing a value."""
    parts = [part for part in Formatter().parse(template) if part[1] is not None]
    assert not any(conversion for *_, conversion in parts), template
    return {(name, form) for _, name, form, _ in parts}


CALLS = dict(calls())
MADE = {node.args[0].value for node in CALLS.values() if isinstance(node.args[0], ast.Constant)}


@pytest.mark.parametrize("where", CALLS)
def test_a_message_is_made_of_a_template_and_exactly_its_fields(where):
    """A template that is put together, as by an f-string, would not be found in Italian."""
    [template], given = CALLS[where].args, {keyword.arg for keyword in CALLS[where].keywords}
    assert isinstance(template, ast.Constant), ast.unparse(template)
    assert given == {name for name, _ in fields(template.value)}


def test_the_italian_messages_are_those_of_the_code():
    assert len(MADE) > 150
    assert sorted(MADE - templates("it").keys()) == []
    assert sorted(templates("it").keys() - MADE) == []


def test_the_wordings_have_the_fields_and_formats_of_their_templates():
    wrong = {one: other for one, other in templates("it").items() if fields(one) != fields(other)}
    assert wrong == {}


def test_a_message_is_its_english_sentence_and_keeps_what_it_is_made_of():
    inner = message("a step of {size:.3g} m turns a block by {turned:.2g} rad", size=0.00123, turned=0.5)
    outer = headed("original", message("{first}; {second}", first=inner, second=linked([inner, inner])))
    assert outer == f"original: {inner}; {inner}; {inner}"
    assert message("{levels:.3g} g", levels=[0.12345, 0.2]) == "0.123, 0.2 g"
    for copy in (pickle.loads(pickle.dumps(outer)), pickle.loads(pickle.dumps(SaidError(outer))).message):
        assert copy == outer and copy.template == "{title}: {text}"
        assert copy.fields["text"].fields["first"].fields == {"size": 0.00123, "turned": 0.5}
    error = UnstableError(inner)
    assert str(error) == inner and error.message is inner


def test_results_keep_messages_and_their_file_what_they_are_made_of(tmp_path):
    """Of a message within another one, too, in every list and text for people; of infinity only the word."""
    results = typed(analysed())
    note = message("{bound:g} {text}", bound=float("inf"), text=message("α = 0"))
    path = results.states["original"].pushover["+x"].rigid
    original = results.states["original"]
    ends = path.replace(end=message("α = {alpha:.2g}", alpha=0.123))
    pushed = {"+x": original.pushover["+x"].replace(rigid=ends)}
    changed = results.replace(
        model=results.model.replace(warnings=[note]),
        states=results.states | {"original": original.replace(pushover=pushed)},
    )
    file = tmp_path / "results.json"
    file.write_bytes(as_bytes(changed))
    again = read_results(file)
    [warning] = again.model.warnings
    assert warning == "inf α = 0" and warning.fields["bound"] == "inf"
    assert warning.fields["text"].template == "α = 0"
    assert again.states["original"].pushover["+x"].rigid.end.fields == {"alpha": 0.123}
    assert {"inf α = 0", "α = 0.12"} <= again.messages.keys()
    assert as_bytes(again) == file.read_bytes()


def test_messages_within_messages_numbers_and_names():
    falls = message(
        "the structure falls: a step of {size:.3g} m moves it by {moved:.3g} m", size=0.001, moved=-0.2
    )
    ends = message(
        "ends at d = {displacement:.4g} m, α = {multiplier:.4g}: {reason}",
        displacement=0.0123,
        multiplier=1e-5,
        reason=falls,
    )
    assert in_italian(headed(TITLE, ends)) == (
        "stato “moved 20 mm”, pushover in direzione −x, giunti rigidi: la curva termina a d = 0,0123 m, α = 1e−05: "
        "la struttura perde l’equilibrio: un incremento di 0,001 m la sposta di −0,2 m"
    )
    spent = message("{limit}: no acceleration capacity is left at d* = {displacement:.6g} m",
                    limit="SLC", displacement=0.1)  # fmt: skip
    told = message("{direction}: {text}", direction="-x", text=spent)
    assert in_italian(message("{state}: {text}", state="original", text=told)) == (
        "stato “originale”: direzione −x: SLC: a d* = 0,1 m la capacità in accelerazione è esaurita"
    )
    single = message("{state}, {record}, {sign}", state="moved", record="generated 1", sign="+")
    several = "{study}: {count} warnings of single runs, in results.json; the first: {text}"
    assert in_italian(message(several, study="campaign", count=7, text=single)) == (
        "campagna: avvertenze di singoli calcoli, in results.json: 7; la prima: moved, generato 1, +"
    )
    hidden = message(
        'layer "{name}": frozen, off or invisible polylines left out: {count}', name="A.1", count=3
    )
    assert in_italian(headed("geometry.dxf", hidden)) == (
        "geometry.dxf: layer «A.1»: polilinee congelate, spente o invisibili tralasciate: 3"
    )


def test_every_warning_of_a_run_is_worded_in_italian():
    """All the way through: from the analyses, through results.json, to the words of the report."""
    results = typed(analysed("it"))
    warnings = all_warnings(results)
    assert warnings and all(isinstance(each, Message) for each in warnings)
    assert not any(translated(each, words_of(results)) == each for each in warnings)
