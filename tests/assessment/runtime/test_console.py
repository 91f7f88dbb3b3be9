"""Consoles that know few letters, streams that are closed, readers that go away: a finished run ends well."""

import json
import os
import subprocess
import sys

import pytest

from assessment.runtime.console import say, tell
from tests.support.block_project import PUSHED, ROOT, block, run, write_block

TITLE = 'title = "Block"'
GREEK = 'title = "Tuff, −5 µm … Ξ, città"'


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """A project that was run: to run it again takes no time, and says the same."""
    text = (block() + PUSHED).replace(TITLE, GREEK)
    folder = write_block(tmp_path_factory.mktemp("console") / "block", text)
    assert run(folder) == 0
    return folder


def start(*arguments, encoding="utf-8", **streams):
    command = [sys.executable, "-m", "assessment.cli", *map(str, arguments)]
    environment = os.environ | {"PYTHONIOENCODING": encoding}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | streams
    return subprocess.run(command, cwd=ROOT, env=environment, check=False, **pipes)


def test_files_and_pipes_get_every_letter(project):
    """Whatever the system's encoding: a console of Windows hands on cp1252, which has no α."""
    done = start("run", project, "--no-report", encoding="cp1252")
    assert (done.returncode, done.stderr) == (0, b"")
    out = done.stdout.decode("utf-8")
    assert "α_0" in out and "Tuff, −5 µm … Ξ, città" in out


@pytest.mark.skipif(os.name != "posix", reason="closes the numbers of the streams")
def test_a_closed_stream_ends_no_run(tmp_path):
    """And nothing that anybody prints goes into a file that has got its number."""
    folder = write_block(tmp_path / "block", block())
    script = 'exec "$0" -m assessment.cli "$@" 0>&- 1>&- 2>&-'
    command = ["sh", "-c", script, sys.executable, "run", str(folder), "--no-report"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    json.loads((folder / "output" / "results.json").read_text(encoding="utf-8"))


def test_what_a_terminal_would_obey_is_shown(capsys):
    say("a\x1b[31m\tb\nc\x9b2J")
    tell("d\x07\ne")
    assert capsys.readouterr() == ("a\\x1b[31m\\tb\nc\\x9b2J\n", "d\\x07\\ne\n")


def gone() -> int:
    """A pipe whose reader has gone away."""
    reading, writing = os.pipe()
    os.close(reading)
    return writing


def test_a_reader_that_has_seen_enough_is_no_error(project):
    writing = gone()
    done = start("run", project, "--no-report", stdout=writing)
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device of Linux")  # noqa: PTH110
@pytest.mark.parametrize(("option", "unbuffered"), [("--no-report", ""), ("--help", "1")])
def test_a_full_disk_behind_standard_output_is_told(project, option, unbuffered, monkeypatch):
    """A --help that nobody got ended with 0: argparse passes over what it cannot write."""
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    with open("/dev/full", "wb") as full:  # noqa: PTH123
        done = start("run", project, option, stdout=full)
    assert done.returncode == 3
    assert done.stderr.startswith(b"error: standard output: No space left on device")
    assert done.stderr.count(b"\n") == 1
