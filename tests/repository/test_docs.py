"""The pages of docs/: what is made is up to date, what is shown as code works, what is named exists."""

from __future__ import annotations

import doctest
import json
import re
import shlex
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from assessment.cli import main as cli
from assessment.project.catalogue.new_project import new_project
from assessment.project.project import load_project
from assessment.workflow import run as workflow
from tests import ROOT
from tools import docs_pages, floor_spectra

DOCS = ROOT / "docs"
GUIDES = [
    DOCS / "tutorial.md",
    DOCS / "avvio_rapido.md",
    *sorted(DOCS.glob("howto/*.md")),
    ROOT / "README.md",
]
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


def test_the_paper_is_cited_in_full_once():
    pages = [*DOCS.rglob("*.md"), ROOT / "README.md"]
    assert (
        sum("Soil Dynamics and Earthquake Engineering" in each.read_text(encoding="utf-8") for each in pages)
        == 1
    )


def test_the_files_that_architecture_names_are_there():
    text = (DOCS / "architecture.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`((?:assessment|mechanics|templates)/[\w/.]+)`", text))
    assert [name for name in sorted(named) if not (ROOT / name).exists()] == []
