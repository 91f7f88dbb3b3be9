"""Runs after runs: what has not changed is left alone, and what was changed by hand is told."""

import json
import random
import shutil
from pathlib import Path

import pytest

from assessment.cli.main import main
from assessment.runtime.cache import FOLDER
from assessment.workflow import run as output
from assessment.workflow import stages as workflow
from assessment.workflow.run import ENTRY
from tests.support.block_project import PROJECT, command, edit, read_results, timeless, write_block
from tests.support.every_stage import REPORT
from tests.support.products import draw_nothing, print_nothing

CLIENT = 'client = "Parish"\n'


@pytest.fixture(autouse=True)
def _quick(monkeypatch):
    """Figures that are as good as empty, PDF and Word files that only look like one, and one process."""
    _make_nothing(monkeypatch)


def _make_nothing(monkeypatch):
    draw_nothing(monkeypatch)
    print_nothing(monkeypatch)
    monkeypatch.setattr("assessment.report.document.pictures", lambda _: [])
    monkeypatch.setattr("assessment.report.docx.to_docx", lambda page, _: page.encode())
    monkeypatch.setattr(output, "processes", lambda _: 1)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A project with a title page, run once."""
    with pytest.MonkeyPatch.context() as patch:
        _make_nothing(patch)
        folder = write_block(tmp_path_factory.mktemp("finished") / "block", PROJECT + REPORT + CLIENT)
        assert main(["run", str(folder), "--jobs", "1"]) == 0
    return folder


@pytest.fixture
def project(finished, tmp_path):
    """The same as if it had been run here."""
    return Path(shutil.copytree(finished, tmp_path / "block"))


@pytest.fixture
def idle(monkeypatch):
    """No analysis may be asked for, not even taken over."""
    monkeypatch.setattr(workflow, "run", lambda *_: pytest.fail("analyses were asked for"))


def state(folder: Path) -> dict[str, tuple[int, ...]]:
    """What the disk knows of every file and folder: written again, they are others."""
    known = {path.relative_to(folder).as_posix(): path.stat() for path in folder.rglob("*")}
    return {name: (it.st_ino, it.st_mtime_ns, it.st_size) for name, it in known.items()}


def written(folder: Path, before: dict[str, tuple[int, ...]]) -> set[str]:
    """Files that were written since."""
    now = state(folder)
    return {
        name
        for name in before.keys() | now.keys()
        if before.get(name) != now.get(name)
        and (folder / name).is_file()
        and not name.startswith((".stages", ".assesto"))
    }


def test_a_run_in_which_nothing_has_changed_writes_nothing(project, capsys, idle):
    capsys.readouterr()
    before = state(project)
    assert main(["run", str(project)]) == 0
    assert state(project) == before
    assert "taken over from earlier runs: 6 of 6 analyses, inputs unchanged" in capsys.readouterr().out
    assert main(["run", str(project), "--no-report", "--jobs", "1"]) == 0
    assert state(project) == before


def test_it_imports_nothing_that_computes_or_draws(project):
    """What keeps it quick: all of that takes seconds to load."""
    assert command("run", str(project), "--no-report").returncode == 0
    code = (
        "import sys\nfrom assessment.cli.main import main\n"
        f"assert main(['run', {str(project)!r}, '--no-report']) == 0\nprint(*sys.modules)"
    )
    done = command(code=code)
    assert done.returncode == 0, done.stderr
    heavy = {"numpy", "scipy", "numba", "shapely", "ezdxf", "matplotlib", "pandas", "weasyprint", "jinja2"}
    assert not heavy & set(done.stdout.splitlines()[-1].split())


def test_an_analysis_that_could_not_be_completed_stays_so(project, capsys, monkeypatch):
    edit(project, "rotation_rad = -0.02", "rotation_rad = -0.3")
    capsys.readouterr()
    assert main(["run", str(project)]) == 3
    first = capsys.readouterr().out
    monkeypatch.setattr(workflow, "run", lambda *_: pytest.fail("analyses were asked for"))
    before = state(project)
    assert main(["run", str(project)]) == 3
    assert capsys.readouterr().out.replace("taken over", "").splitlines()[:5] == first.splitlines()[:5]
    assert state(project) == before


PRINTED = {"report.html", "report.pdf", "report.docx"}


def computed(folder: Path, capsys, *options: str) -> int:
    """Run the project; return how many analyses it computed."""
    capsys.readouterr()
    assert main(["run", str(folder), "--json", *options]) == 0
    number: int = json.loads(capsys.readouterr().out)["analyses"]["computed"]
    return number


@pytest.mark.parametrize(
    ("old", "new"), [('client = "Parish"', 'client = "Diocese"'), ('language = "it"', 'language = "en"')]
)
def test_another_title_page_or_language_is_rendered_and_nothing_computed(project, capsys, old, new):
    before = state(project / "output")
    edit(project, old, new)
    assert computed(project, capsys) == 0
    assert written(project / "output", before) >= {"results.json", *PRINTED}
    before = state(project)
    assert computed(project, capsys) == 0
    assert state(project) == before


def test_what_is_rendered_is_what_a_fresh_run_gives(project):
    for old, new in (('"Parish"', '"Diocese"'), ('"it"', '"en"'), ('title = "Block"', 'title = "Stele"')):
        edit(project, old, new)
    assert main(["run", str(project)]) == 0
    rendered = timeless(read_results(project / "output"))
    page = (project / "output" / "report.html").read_text(encoding="utf-8")
    assert "Diocese" in page and "Parish" not in page and "Stele" in page
    assert main(["run", str(project), "--fresh"]) == 0
    assert timeless(read_results(project / "output")) == rendered


@pytest.mark.parametrize(
    ("name", "how"),
    [("report.pdf", "removed"), ("figures/model.svg", "changed"), ("tables/blocks.csv", "changed")],
)
def test_what_is_no_longer_as_it_was_is_made_again(project, capsys, name, how):
    path = project / "output" / name
    content = path.read_bytes()
    path.unlink() if how == "removed" else path.write_bytes(content + b"\n")
    assert computed(project, capsys) == 0
    assert path.read_bytes().strip() == content.strip()
    before = state(project)
    assert computed(project, capsys) == 0
    assert state(project) == before


def test_a_report_is_added_to_a_run_without_one(project, capsys):
    for name in PRINTED:
        (project / "output" / name).unlink()
    assert computed(project, capsys, "--no-report") == 0
    before = state(project)
    assert computed(project, capsys, "--no-report") == 0
    assert state(project) == before
    assert computed(project, capsys) == 0
    assert all((project / "output" / name).is_file() for name in PRINTED)


def test_a_pdf_that_could_not_be_made_is_made_once_its_libraries_are_there(project, capsys, monkeypatch):
    def lacking():
        raise OSError("cannot load library 'libpango-1.0-0'")

    with monkeypatch.context() as patch:
        for place in ("printing", "document"):
            patch.setattr(f"assessment.report.{place}.load_weasyprint", lacking)
        assert main(["run", str(project), "--fresh"]) == 0
        assert "report.pdf" in capsys.readouterr().out
        assert not (project / "output" / "report.pdf").exists()
        before = state(project)
        assert main(["run", str(project)]) == 0
        assert state(project) == before
        assert "report.pdf" in capsys.readouterr().out, "the warning is told again"
    assert main(["run", str(project)]) == 0
    assert (project / "output" / "report.pdf").exists()


def test_results_changed_by_hand_are_told_in_the_report(project, capsys):
    stored = project / "output" / "results.json"
    content = read_results(project / "output")
    content["model"]["weight_kN"] *= 2.0
    stored.write_text(json.dumps(content), encoding="utf-8")
    assert main(["report", str(project)]) == 0
    told = capsys.readouterr()
    assert "results.json was changed after the run that wrote it" in told.err
    assert told.out.endswith("report.pdf\n") == (project / "output" / "report.pdf").is_file()
    page = (project / "output" / "report.html").read_text(encoding="utf-8")
    assert "results.json è stato modificato" in page
    assert main(["report", str(project)]) == 0
    assert "results.json was changed after the run that wrote it" in capsys.readouterr().err, "said once"
    told = [
        text for text in read_results(project / "output")["quality"]["warnings"] if "changed after" in text
    ]
    assert len(told) == 1
    assert "results.json è stato modificato" in (project / "output" / "report.html").read_text(
        encoding="utf-8"
    )
    assert main(["run", str(project)]) == 0
    again = read_results(project / "output")
    assert again["model"]["weight_kN"] == pytest.approx(content["model"]["weight_kN"] / 2.0)
    assert "modificato" not in (project / "output" / "report.html").read_text(encoding="utf-8")


def test_results_damaged_in_any_place_are_told_without_a_traceback(project, capsys):
    """Any value of the file removed, or another kind of value in its place."""
    stored, last = project / "output" / "results.json", project / "output" / FOLDER / ENTRY
    whole, known = stored.read_text(encoding="utf-8"), last.read_bytes()
    chance, codes = random.Random(17), []
    for _ in range(25):
        content = json.loads(whole)
        _damage(content, chance)
        stored.write_text(json.dumps(content), encoding="utf-8")
        codes.append(main(["report", str(project)]))
        said = capsys.readouterr().err
        assert codes[-1] in {0, 2}
        assert said.startswith(f"error: {stored}: " if codes[-1] else "warning: results.json was changed"), (
            said
        )
        last.write_bytes(known)
    assert set(codes) == {0, 2}


def _damage(content, chance):
    """Go down to some value and put another one in its place, or none."""
    node = content
    for _ in range(chance.randrange(6)):
        keys = list(node) if isinstance(node, dict) else range(len(node))
        deeper = [key for key in keys if isinstance(node[key], dict | list) and node[key]]
        if not deeper:
            break
        node = node[chance.choice(deeper)]
    key = chance.choice(list(node) if isinstance(node, dict) else range(len(node)))
    if chance.random() < 0.3:
        del node[key]
    else:
        node[key] = chance.choice([None, "text", [], {}, -1, 1e300, True, [None], {"a": 1}])
