"""Files of several gigabytes: refused by their size, before they are read."""

import os
from pathlib import Path

import pytest

from assessment.cli.main import main
from assessment.runtime.files import MOST_BYTES, file_digest
from tests.support.block_project import HAZARD, edit
from tests.support.campaign_project import STRIPES, write_campaign

COUNTED = Path("/proc/self/io")  # what this process has read, among others
pytestmark = [
    pytest.mark.usefixtures("quick"),
    pytest.mark.skipif(not COUNTED.exists(), reason="files without content cost no room on Linux"),
]
SIZE = 5 * 2**30
MOST_READ = 500_000_000  # bytes, by a command as a whole


@pytest.fixture(autouse=True)
def _little_is_read():
    def read() -> int:
        return int(COUNTED.read_text().split()[1])

    before = read()
    yield
    assert read() - before < MOST_READ


def swell(path: Path) -> None:
    """Make a file several gigabytes long; nothing of it is on the disk."""
    path.parent.mkdir(exist_ok=True)
    path.touch()
    os.truncate(path, SIZE)


GRID = """latitude = 42.0
longitude = 13.0
grid = "grid.csv"
nominal_life_years = 50.0
use_class = "II"
"""


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("project.toml", "project.toml: file: more than 2000000 bytes; keep what describes the project"),
        ("project.xlsx", "project.xlsx: file: not an XLSX workbook, or a damaged one; save it as .xlsx"),
        ("geometry.dxf", "geometry.dxf: 5.37e+09 bytes, at most 2e+08; keep only what is to be analysed"),
        ("wave1.csv", "wave1.csv: more than 100000000 bytes; give one record, of one component"),
        ("grid.csv", "grid.csv: more than 50000000 bytes; give the grid of Allegato B"),
        ("photo.png", "photo.png"),
    ],
)
def test_inputs(tmp_path, capsys, name, told):
    folder = write_campaign(tmp_path / "block", STRIPES, 1)
    if name == "grid.csv":
        edit(folder, HAZARD, GRID)
    if name == "photo.png":
        with (folder / "project.toml").open("a") as file:
            file.write('[report]\nattachments = ["photo.png"]\n')
    if name == "project.xlsx":
        (folder / "project.toml").unlink()
    swell(folder / name)
    assert main(["check", str(folder)]) == 2
    err = capsys.readouterr().err
    assert err.count("error: ") == 1 and told in err


def test_a_digest_of_what_nothing_reads_changes_with_its_size_and_date(tmp_path):
    path = tmp_path / "large"
    found = set()
    for size, date in ((SIZE, 1), (SIZE, 2), (SIZE + 1, 2), (MOST_BYTES + 1, 2)):
        swell(path)
        os.truncate(path, size)
        os.utime(path, (date, date))
        found.add(file_digest(path))
    assert len(found) == 4
