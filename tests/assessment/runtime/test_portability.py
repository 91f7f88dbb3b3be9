"""Nothing that only Linux has: a whole run where processes are spawned and what Windows lacks is taken away."""

from __future__ import annotations

import os

import pytest

from assessment.project.catalogue.new_project import new_project
from assessment.runtime.cache import FOLDER
from tests.stress.harness import HUNG
from tests.support.block_project import (
    PUSHED,
    ROOT,
    block,
    command,
    contents,
    read_results,
    run,
    timeless,
    write_block,
)

ELSEWHERE = """
import ctypes, multiprocessing, os, signal, subprocess, sys, types

multiprocessing.set_start_method("spawn")
sys.modules |= {"fcntl": None, "resource": None, "pwd": None, "grp": None}
sys.modules["msvcrt"] = types.SimpleNamespace(LK_NBLCK=2, locking=lambda *_: None)
for name in ("fork", "set_blocking", "sched_getaffinity", "getloadavg", "sysconf", "killpg", "geteuid"):
    delattr(os, name)
for name in ("setsid", "getpgid", "mkfifo", "pread", "chown", "getuid", "nice", "forkpty"):
    delattr(os, name)
for name in ("SIGHUP", "SIGQUIT", "SIGALRM", "SIGUSR1", "SIGCHLD", "SIGXCPU", "SIGPROF", "SIGPIPE", "SIGKILL"):
    delattr(signal, name)
for name in ("alarm", "pause", "setitimer", "sigwait", "pthread_kill"):
    delattr(signal, name)

class CDLL(ctypes.CDLL):
    def __init__(self, name, *rest, **more):
        if name is None:
            raise TypeError("bad argument type for built-in operation")
        super().__init__(name, *rest, **more)

ctypes.CDLL = CDLL
"""


@pytest.fixture
def elsewhere(tmp_path):
    """The environment of a Python that is much like one on Windows, that of its child processes too."""
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "sitecustomize.py").write_text(ELSEWHERE, encoding="utf-8")
    paths = os.pathsep.join([str(tmp_path / "site"), str(ROOT)])
    return os.environ | {"PYTHONPATH": paths, "PYTHONIOENCODING": "cp1252"}


def test_a_run_gives_what_it_gives_on_linux(tmp_path, elsewhere):
    """In two processes."""
    folder = write_block(tmp_path / "block", block() + PUSHED)
    done = command("run", str(folder), "--no-report", "--jobs", "2", env=elsewhere, encoding="cp1252")
    assert (done.returncode, done.stderr) == (0, "")
    assert "alpha_0" in done.stdout
    assert run(folder, "--jobs", "1", "--out", str(tmp_path / "here")) == 0
    found, expected = read_results(folder / "output"), read_results(tmp_path / "here")
    assert timeless(found) == timeless(expected)
    assert contents(folder / "output").keys() == contents(tmp_path / "here").keys()
    assert {path.name for path in (folder / "output").iterdir()} >= {FOLDER, "results.json"}


def test_every_module_can_be_imported_a_template_checked_and_what_hangs_ended(tmp_path, elsewhere):
    """That of the stress tests too, which could not; nothing there limits the time of a process."""
    new_project(tmp_path / "wall", "wall", {})
    code = (
        "import importlib, pkgutil, assessment, mechanics\n"
        "for package in (assessment, mechanics):\n"
        "    for module in pkgutil.walk_packages(package.__path__, package.__name__ + '.'):\n"
        "        importlib.import_module(module.name)\n"
        "from assessment.benchmark.measure import machine, peak_memory\n"
        "print(ascii(machine()), peak_memory())\n"
        "from assessment.cli.main import main\n"
        f"print('checked:', main(['check', {str(tmp_path / 'wall')!r}]), flush=True)\n"
        "from tests.stress import harness\n"
        "assert harness.resource is None\n"
        "harness._limit(1)\n"
        "while True:\n"
        "    pass"
    )
    done = command(code=code, env=elsewhere, encoding="cp1252")
    assert (done.returncode, done.stderr) == (HUNG, "")
    assert "load unknown at the start" in done.stdout
    assert done.stdout.splitlines()[-1] == "checked: 0"
    assert (tmp_path / "wall" / "output" / "model.svg").is_file()
