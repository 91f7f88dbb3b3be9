"""`assesto app` as it is started: its first line, a second one on the same folder, and how it ends."""

from __future__ import annotations

import os
import signal
import socket
import stat
import subprocess
import sys
import urllib.request

import pytest

from assessment.app.server import _running
from assessment.cli.main import main
from tests.support.block_project import write_block

COMMAND = [sys.executable, "-m", "assessment.cli", "app"]


def started(*arguments):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    return subprocess.Popen(
        [*COMMAND, *map(str, arguments), "--no-browser"],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def test_it_prints_where_it_is_and_a_second_one_opens_the_first(tmp_path, capsys):
    folder = write_block(tmp_path / "block")
    first = started(folder)
    address = first.stdout.readline().strip()
    assert address.startswith("http://127.0.0.1:")
    assert len(address.partition("token=")[2]) == 32
    assert b"<!doctype html>" in urllib.request.urlopen(address).read()
    place = folder / ".assesto" / "at"
    while not place.is_file() or not place.read_text(encoding="utf-8"):
        pass
    if os.name != "nt":
        assert stat.S_IMODE(place.stat().st_mode) == 0o600
    assert main(["app", str(folder / "project.toml"), "--no-browser"]) == 0
    assert capsys.readouterr().out.strip() == address
    port = address.partition("127.0.0.1:")[2].partition("/")[0]
    other = write_block(tmp_path / "other")
    assert main(["app", str(other), "--port", port, "--no-browser"]) == 2
    assert capsys.readouterr().err.startswith(f"error: --port {port}: ")
    first.send_signal(signal.SIGINT)
    assert first.communicate()[1].splitlines() == ["Ctrl-C ends it; a run that it has started goes on"]
    assert first.returncode == 0
    assert not place.exists()


@pytest.mark.parametrize("path", ["shutdown", "?token=x", "?token=" + "x" * 32 + "&all=1"])
def test_no_other_server_of_this_machine_is_asked(tmp_path, path):
    """A folder of somebody else's may name one."""
    with socket.create_server(("127.0.0.1", 0)) as other:
        other.settimeout(0.0)
        port = other.getsockname()[1]
        (tmp_path / "at").write_text(f"http://127.0.0.1:{port}/{path}", encoding="utf-8")
        assert _running(tmp_path / "at") is None
        with pytest.raises(BlockingIOError):
            other.accept()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere"], "no such folder"),
        (["--port", "70000"], "no port"),
        (["--port", "x"], "no port"),
        (["."], "holds no project.toml"),
    ],
)
def test_what_cannot_be_shown_is_told(tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    try:
        code = main(["app", *arguments, "--no-browser"])
    except SystemExit as ended:
        code = ended.code
    assert code == 2
    assert said in capsys.readouterr().err
