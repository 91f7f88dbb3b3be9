"""Both forms of a project file explain themselves, turn into each other, and follow one schema."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from assessment.cli.main import main
from assessment.project import formats
from assessment.project.catalogue.new_project import TEMPLATES
from assessment.project.project import load_project
from assessment.project.schema import ProjectContent, keys_at, table_at, tables_of


def tables(path=()):
    """Every table of the schema as its path in a content, entries of lists numbered 0."""
    yield path
    for name, form in tables_of(table_at(path)).items():
        inner = {"single": (), "list": (0,), "named": ("NAME",)}[form]
        yield from tables((*path, name, *inner))


def made(folder: Path, *options: str) -> Path:
    assert main(["new", str(folder), "--template", "block", *options]) == 0
    return folder


def test_a_new_project_shows_every_key_there_is(tmp_path):
    lines = (made(tmp_path / "p") / "project.toml").read_text(encoding="utf-8").splitlines()
    shown = {}
    for line in (line.removeprefix("# ") for line in lines):
        key, _, rest = line.partition(" = ")
        shown.setdefault(key, set()).add(rest.rpartition(" # ")[2])
    for path in tables():
        for key, meaning in keys_at(path).items():
            if key not in tables_of(table_at(path)) and (path, key) != (("pushover",), "control"):
                assert meaning in shown[key], (path, key)
            else:
                assert any(meaning in line for line in lines)


# the first tables left out that have keys without a default, or say something by being there
NEEDY = ("[[history]]", "[assessment.knowledge]", "[assessment.site.SLD]")


def test_what_is_commented_out_are_the_defaults(tmp_path):
    """Without the marks, and without the keys that have no default, the file says the same."""
    text = (made(tmp_path / "p") / "project.toml").read_text(encoding="utf-8")
    lines = [line.removeprefix("# ") for line in text.splitlines() if " = …" not in line]
    absent = next(number for number, line in enumerate(lines) if line.startswith(NEEDY))
    opened = ProjectContent.model_validate(tomllib.loads("\n".join(lines[:absent])))
    assert opened == ProjectContent.model_validate(tomllib.loads(text))


@pytest.mark.parametrize("template", TEMPLATES)
def test_a_new_spreadsheet_says_what_the_toml_says(template, tmp_path):
    for folder, options in (("toml", ()), ("xlsx", ("--excel",))):
        assert main(["new", str(tmp_path / folder), "--template", template, *options]) == 0
    assert {file.name for file in (tmp_path / "xlsx").iterdir()} == {
        "geometry.dxf",
        "project.xlsx",
        "records",
    }
    assert load_project(tmp_path / "xlsx").content() == load_project(tmp_path / "toml").content()


def test_conversion_either_way(tmp_path, capsys):
    folder = made(tmp_path / "p")
    before, text = load_project(folder).content(), (folder / "project.toml").read_bytes()
    assert main(["convert", str(folder)]) == 0
    assert "project.xlsx; the earlier file is kept as project.toml.old" in capsys.readouterr().out
    assert load_project(folder).source == "project.xlsx" and load_project(folder).content() == before
    assert (folder / "project.toml.old").read_bytes() == text
    assert main(["convert", str(folder)]) == 0
    assert load_project(folder).source == "project.toml" and load_project(folder).content() == before
    assert "# DXF file with one closed" in (folder / "project.toml").read_text(encoding="utf-8")
    (folder / "project.toml").write_bytes(text + b"# edited")
    capsys.readouterr()
    assert main(["convert", str(folder)]) == 2
    assert "project.toml.old: file: exists" in capsys.readouterr().err
    assert {file.name for file in folder.iterdir()} == {
        "geometry.dxf",
        "records",
        "project.toml",
        "project.toml.old",
        "project.xlsx.old",
    }


@pytest.mark.parametrize("moment", [1, 3])
def test_a_conversion_that_is_killed_at_any_moment_leaves_a_project(tmp_path, monkeypatch, moment):
    """It left both files, which every later command refused."""
    folder = made(tmp_path / "p")
    before, steps = load_project(folder).content(), iter(range(1, 10))

    def killed_before(step):
        def stepped(*arguments, **options):
            if next(steps) == moment:
                raise KeyboardInterrupt
            return step(*arguments, **options)

        return stepped

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(formats, "write_atomically", killed_before(formats.write_atomically))
        patch.setattr(Path, "unlink", killed_before(Path.unlink))
        patch.setattr(Path, "replace", killed_before(Path.replace))
        formats.convert(folder / "project.toml", load_project(folder).content(defaults=False))
    monkeypatch.undo()
    assert load_project(folder).content() == before
    assert main(["convert", str(folder)]) == 0
    assert main(["check", str(folder)]) == 0
    assert load_project(folder).content() == before
