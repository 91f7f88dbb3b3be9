"""The pages of docs/: what is made is up to date, code and gallery work, what is named exists; words of the page."""

import doctest
import json
import re
import shlex
import tomllib
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from assessment.app.server import page_words
from assessment.cli import main as cli
from assessment.project.catalogue.new_project import TEMPLATES, new_project
from assessment.project.project import json_schema, load_project
from assessment.workflow import run as workflow
from tests import ROOT
from tools import docs_pages, floor_spectra
from tools.gallery import carried_out, scripts

DOCS = ROOT / "docs"
GUIDES = [
    DOCS / "tutorial.md", DOCS / "avvio_rapido.md", *sorted(DOCS.glob("howto/*.md")), ROOT / "README.md",
]  # fmt: skip
NAMES = [path.relative_to(ROOT).as_posix() for path in GUIDES]


def code(path: Path, language: str) -> list[str]:
    """The blocks of a page in a language."""
    text = path.read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("name", docs_pages.PARTS)
def test_what_is_made_is_up_to_date(name):
    """If not: python -m tools.docs_pages."""
    assert (DOCS / name).read_text(encoding="utf-8") == docs_pages.page(name)


def test_picture_of_floor_spectra():
    """At the top, T in 0.8 to 1.1 T_1 = 0.32237 s, on the plateau of the ground: S_eZ = A a_Z.

    S = 1.4 − 0.4·2.36·0.261 = 1.153616, S_e(T_1) = 0.261·1.153616·2.36 = 0.710581 g; γ_1 = 9/7, ψ_1 = 1: a_Z =
    0.710581·9/7·√(1 + 0.0004·25) = 0.918157 g; A = 1.1/√0.05 = 4.919350.
    """
    axes = Figure().subplots()
    floor_spectra.draw(axes)
    *floors, ground = axes.lines[:4]
    T = ground.get_xdata()
    plateau = (T >= 0.8 * 0.32237) & (T < 1.1 * 0.32237)
    top, middle, low = (line.get_ydata()[plateau] for line in floors)
    assert top == pytest.approx(4.919350 * 0.918157, rel=1e-5)
    assert middle == pytest.approx(top * 2 / 3) and low == pytest.approx(top / 3)
    assert all((line.get_ydata() >= ground.get_ydata()).all() for line in floors)
    picture = DOCS / "pictures" / "floor_spectra.svg"
    assert picture.stat().st_size < 40_000 and "z = 12 m" in picture.read_text(encoding="utf-8")


@pytest.mark.parametrize("path", [DOCS / "api.md", ROOT / "README.md"], ids=lambda path: path.name)
def test_examples_in_python_give_what_is_printed(path):
    examples = "".join(code(path, "python"))
    assert ">>> " in examples
    test = doctest.DocTestParser().get_doctest(examples, {}, path.name, str(path), 0)
    said: list[str] = []
    doctest.DocTestRunner().run(test, out=said.append)
    assert not said, "".join(said)


@pytest.fixture
def arch(tmp_path):
    """The buttressed arch of the template, with two records."""
    new_project(tmp_path / "arch", "buttressed-arch", {})
    (tmp_path / "arch" / "records").mkdir(exist_ok=True)
    time = np.arange(0.0, 1.0, 0.01)
    for name in ("aqv", "amt"):
        table = np.column_stack([time, 0.1 * np.sin(6.0 * time)])
        np.savetxt(tmp_path / "arch" / "records" / f"{name}.csv", table, delimiter=",", fmt="%.6f")
    return tmp_path / "arch"


@pytest.mark.parametrize("path", GUIDES, ids=NAMES)
def test_tables_of_a_project_file_are_accepted(path, arch):
    """Each block in the place of the template's own tables."""
    file = arch / "project.toml"
    whole = tomllib.loads(file.read_text(encoding="utf-8"))
    for block in code(path, "toml"):
        if "# in projects/" in block:
            continue  # of another project, which has it
        given = tomllib.loads(block)
        file.write_text("\n".join(toml({**whole, **given})), encoding="utf-8")
        project = load_project(arch)
        for key in given:
            assert getattr(project, key), key


def toml(table: dict[str, Any], name: str = "") -> Iterator[str]:
    """Lines of a table: values as JSON writes them, which TOML reads."""
    inner = {key: value for key, value in table.items() if isinstance(value, dict)}
    lists = {
        key: value
        for key, value in table.items()
        if isinstance(value, list) and value and isinstance(value[0], dict)
    }
    for key, value in table.items():
        if key not in inner and key not in lists:
            yield f"{json.dumps(key)} = {json.dumps(value)}"
    for key, value in inner.items():
        yield f"[{name}{json.dumps(key)}]"
        yield from toml(value, f"{name}{json.dumps(key)}.")
    for key, values in lists.items():
        for value in values:
            yield f"[[{name}{json.dumps(key)}]]"
            yield from toml(value, f"{name}{json.dumps(key)}.")


class StoppedError(Exception):
    """Where an analysis would begin."""


@pytest.mark.parametrize("path", GUIDES, ids=NAMES)
def test_commands_work_and_print_what_is_shown(path, tmp_path, monkeypatch, capsys):
    """Up to where analyses begin: those are the affair of other tests."""

    def stop(*_: object) -> None:
        raise StoppedError

    monkeypatch.setattr(workflow, "carry_out", stop)
    monkeypatch.setattr(workflow, "print_again", stop)
    monkeypatch.chdir(tmp_path)
    for block in code(path, "console"):
        for command, shown in re.findall(r"^\$ assesto (.*)\n((?:(?!\$ ).*\n)*)", block, flags=re.MULTILINE):
            try:
                assert cli.main(shlex.split(command)) == 0
            except StoppedError:
                assert command.startswith(("run ", "report "))
                continue
            said = re.escape(shown).replace("…", ".*")
            assert re.fullmatch(said, capsys.readouterr().out), command


WALK = re.compile(r"^\d+\. `([\w/]+\.py)`", re.MULTILINE)


def test_each_walk_has_eight_stops_at_most_and_no_room_twice():
    text = (DOCS / "architecture.md").read_text(encoding="utf-8")
    walks = re.split(r"^### ", text, flags=re.MULTILINE)[1:]
    found = [WALK.findall(walk) for walk in walks]
    assert len(found) == 3
    for stops in found:
        assert 6 <= len(stops) <= 8
        assert len(set(stops)) == len(stops)
        for stop in stops:
            assert (ROOT / stop).is_file(), stop


def test_nothing_refers_to_a_document_outside_of_the_repository():
    """The method's paper is cited in docs/theory.md; all else that explains is here."""
    outside = re.compile(
        r"shared/(?!data)|\b(exact_joint|layout\.md|contract\.md|design\.md|contract §|reference/paper)"
    )
    for folder in ("assessment", "mechanics", "templates", "tools", "docs", "tests"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in {".py", ".md", ".toml", ".j2", ".js"} and path != Path(__file__):
                found = outside.search(path.read_text(encoding="utf-8"))
                assert not found, f"{path}: {found[0] if found else ''}"


def test_the_files_that_architecture_names_are_there():
    text = (DOCS / "architecture.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`((?:assessment|mechanics|templates)/[\w/.]+)`", text))
    assert [name for name in sorted(named) if not (ROOT / name).exists()] == []


PAGE = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")


def _thinnest(names):
    """Milankovitch: 0.1075 of the mean radius; the bisection leaves 0.0024 m of 0.538."""
    assert names["high"] / 5.0 == pytest.approx(0.1075, rel=5e-3)


def _spread(names):
    """The horizontal thrust of the flatter arch is larger, and the arch as drawn stood."""
    moved = names["moved"]
    assert moved.ultimate == pytest.approx(moved.movement[-1], abs=0.02)
    assert -moved.reaction[-1, 0] > -moved.reaction[0, 0] > 0.0


def _rocking(names):
    """The rotation of what does not fall decreases with size; the smallest falls."""
    peaks = np.array(names["peaks"])
    assert np.isnan(peaks[0]) and (np.diff(peaks[1:]) < 0.0).all() and peaks[1] < 1.0


def _fragile(names):
    """Longer pulses overturn at less; of three records β is the root mean square of the logarithms."""
    levels = [curve.collapse for curve in names["curves"]]
    assert levels == sorted(levels, reverse=True) and min(levels) > 0.2
    assert names["fit"].median == pytest.approx(np.exp(np.mean(np.log(levels))))
    assert names["fit"].beta == pytest.approx(np.std(np.log(levels)))


def _facade(names):
    """Moments about the foot, kNm: 64.8 kN at 3 m and 10 kN at 5.75 m against 0.3 m of both, and 8 kN at 5.75 m."""
    turning = 64.8 * 3.0 + 10.0 * 5.75
    assert names["alone"].alpha == pytest.approx(74.8 * 0.3 / turning, rel=1e-6)
    assert names["held"].alpha == pytest.approx((74.8 * 0.3 + 8.0 * 5.75) / turning, rel=1e-6)


HOLDS = dict(zip(scripts(), (_thinnest, _spread, _rocking, _fragile, _facade), strict=True))


@pytest.mark.parametrize("heading", HOLDS)
def test_a_script_does_what_it_says(heading, tmp_path):
    names, _ = carried_out(scripts()[heading], tmp_path)
    HOLDS[heading](names)
    [picture] = tmp_path.glob("*.svg")
    assert f"(pictures/{picture.name})" in PAGE and (ROOT / "docs" / "pictures" / picture.name).is_file()


def words(language):
    return tomllib.loads((files("templates") / f"app_{language}.toml").read_text(encoding="utf-8"))


def test_both_languages_have_the_same_words():
    it, en = words("it"), words("en")
    assert it["page"].keys() == en["page"].keys()
    assert [*it["templates"]] == [*en["templates"]] == [*TEMPLATES]
    for key, text in en["page"].items():
        assert [part.partition("}")[0] for part in text.split("{")[1:]] == [
            part.partition("}")[0] for part in it["page"][key].split("{")[1:]
        ]


def test_every_word_that_the_page_says_is_there():
    said = set()
    for script in (files("templates") / "app").iterdir():
        if script.name.endswith(".js"):
            said |= set(re.findall(r"\bw\(\"(\w+)\"", script.read_text(encoding="utf-8")))
    assert said - words("en")["page"].keys() == set()


def test_every_key_of_the_project_file_has_its_italian():
    keys, schema = words("it")["keys"], json_schema()
    tables = {"ProjectContent": schema, **schema["$defs"]}
    named = [(table, key) for table, each in tables.items() for key in each["properties"]]
    assert [pair for pair in named if ".".join(pair) not in keys and pair[1] not in keys] == []
    assert {key for key in keys if key.partition(".")[2]} <= {".".join(pair) for pair in named}
    assert all(isinstance(each, str) or (len(each) == 2 and all(each)) for each in keys.values())


def test_keys_are_called_as_in_the_report():
    italian, english = page_words("it")["keys"], page_words("en")["keys"]
    assert italian["depth_m"][0] == "Spessore fuori piano [m]"
    assert english["depth_m"][0] == "Out-of-plane depth [m]"
    assert italian["FloorTable.period_s"][0] == "Periodo T_1 [s]"
