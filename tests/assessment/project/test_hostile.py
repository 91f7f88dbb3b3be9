"""Hostile inputs are refused in one message with file, key and remedy, or complete; see tests/support/hostile."""

import csv
import json
import os
import shutil
import zipfile
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest

from assessment.cli.main import main
from assessment.project.xlsx import to_xlsx
from assessment.runtime.cache import FOLDER
from assessment.runtime.progress import NAME as JOURNAL
from tests.support.block_project import PUSHED, block, command, write_block
from tests.support.hostile.corpus import KINDS, SHEETS, tried
from tests.support.hostile.judge import COMPLETED, REFUSED
from tests.support.hostile.named import COMPLETE, REFUSALS

SHARE = 1.0 if os.environ.get("ASSESTO_STRESS") == "long" else 0.03  # of the inputs


@pytest.mark.parametrize("kind", KINDS)
def test_inputs_of_a_kind(kind):
    counts = tried(KINDS[kind], SHARE)
    assert counts["tried"] == counts[REFUSED] + counts[COMPLETED] >= int(SHARE * KINDS[kind].count)


@pytest.mark.parametrize("case", REFUSALS)
def test_what_is_refused_by_name(tmp_path, case):
    assert REFUSALS[case](tmp_path) == REFUSED


@pytest.mark.parametrize("case", COMPLETE)
def test_what_completes_by_name(tmp_path, case):
    assert COMPLETE[case](tmp_path) == COMPLETED


STATE, CONTROL = "a, b contacts: c; =cmd|'/c calc'!A0", "=<script>alert(1)</script> $x^{$"
NAMED = (
    block().replace('"Block"', '"{state} %s $\\\\frac$ </svg>"').replace('"right"', json.dumps(CONTROL))
    + f'[[settlements]]\nname = {json.dumps(STATE)}\nsupport = "base"\nrotation_rad = -0.02\nincrement_rad = 0.01\n'
    + PUSHED
    + '[report]\nengineer = "<b>&amp;{{ 7*7 }}"\n'
)


class _Tags(HTMLParser):
    """Counts the tags of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.scripts: list[dict[str, str | None]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "script":
            self.scripts.append(dict(attrs))


@pytest.mark.usefixtures("quick", "drawn")
def test_a_run_writes_everything_and_hostile_names_do_nothing_there(tmp_path, capsys):
    folder = write_block(tmp_path / "block", NAMED)
    drawing = (folder / "geometry.dxf").read_text(encoding="utf-8")
    (folder / "geometry.dxf").write_text(drawing.replace("BLOCCO", "_$x^{$ \\frac|@"), encoding="utf-8")
    assert main(["run", str(folder), "--jobs", "1"]) == 0
    out, err = capsys.readouterr()
    output = folder / "output"
    assert STATE in out and str(output) in out and err == ""  # silent: no terminal
    found = {path.name for path in output.iterdir() if path.name not in {FOLDER, JOURNAL}}
    reports = {f"report.{kind}" for kind in ("html", "pdf", "docx")}
    assert found == {"tables", "figures", "judgement.md", "results.json", *reports}
    assert {path.suffix for path in (output / "figures").iterdir()} == {".svg", ".png", ".dxf"}
    for picture in (output / "figures").glob("*.svg"):
        ElementTree.parse(picture)
    page = (output / "report.html").read_text(encoding="utf-8")
    tags = _Tags()
    tags.feed(page)
    assert len(tags.scripts) == 2 and "<script>alert" not in page and "{{ 7*7 }}" in page
    for table in (output / "tables").iterdir():
        assert table.suffix == ".csv"
        with table.open(encoding="utf-8", newline="") as file:
            cells = {cell for row in csv.reader(file) for cell in row}
        assert not any(cell.startswith(("=", "@", "+")) for cell in cells)


CHECK_BOTH = """
import sys
from assessment.cli.main import main
sys.argv = ["assesto", "check", {!r}]
print(main(), "and the other", file=sys.stderr, flush=True)
sys.argv[2] = {!r}
main()
"""


def test_libraries_say_nothing(tmp_path):
    """Neither what openpyxl warns of nor what ezdxf and matplotlib log, with the user's names, reaches the terminal."""
    folder = write_block(tmp_path / "block")
    drawing = (folder / "geometry.dxf").read_text(encoding="utf-8")
    (folder / "geometry.dxf").write_text(drawing.replace("BLOCCO", "中\x1b[31m"), encoding="utf-8")
    (folder / "project.toml").unlink()
    extension = b'<extLst><ext uri="{CCE6A557-97BC-4b89-ADB6-D9C93CAAB3DF}"/></extLst></worksheet>'
    (folder / "book.xlsx").write_bytes(to_xlsx(SHEETS | {"layers": {"BASE": {"support": "base"}}}))
    with zipfile.ZipFile(folder / "book.xlsx") as good, zipfile.ZipFile(folder / "project.xlsx", "w") as own:
        for name in good.namelist():
            own.writestr(name, good.read(name).replace(b"</worksheet>", extension))
    damaged = shutil.copytree(folder, tmp_path / "damaged")
    (damaged / "geometry.dxf").write_text(drawing.replace("AcDbPolyline", "AcDb\x1b[31m"), encoding="utf-8")
    checked = command(code=CHECK_BOTH.format(str(folder), str(damaged)))
    assert checked.returncode == 0
    good, _, bad = checked.stderr.partition("and the other\n")
    assert good == "0 "
    assert all(line.startswith(("error: ", "drawing with")) for line in bad.splitlines())
    assert "\x1b" not in checked.stdout + checked.stderr
