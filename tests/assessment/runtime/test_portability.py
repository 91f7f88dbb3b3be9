"""Nothing that only Linux has: a whole run where processes are spawned and what Windows lacks is taken away."""

import os

import pytest

from assessment.runtime.cache import FOLDER
from tests.support.block_project import PUSHED, ROOT, block, command, read_results, run, timeless, write_block

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


@pytest.mark.usefixtures("no_figures")
def test_a_run_gives_what_it_gives_on_linux_and_every_module_is_imported(tmp_path, elsewhere):
    """In two processes; figures are drawn in this one, as those of other processes are by test_pool."""
    folder = write_block(tmp_path / "block", block() + PUSHED)
    code = (
        "import importlib, pkgutil, sys, assessment, mechanics\n"
        "from assessment.cli.main import main\n"
        "if __name__ == '__main__':\n"
        "    for package in (assessment, mechanics):\n"
        "        for module in pkgutil.walk_packages(package.__path__, package.__name__ + '.'):\n"
        "            importlib.import_module(module.name)\n"
        "    from assessment.benchmark.measure import machine, peak_memory\n"
        "    print(ascii(machine()), peak_memory())\n"
        "    sys.modules['assessment.workflow.run'].processes = lambda _: 0\n"
        f"    sys.argv = ['assesto', 'check', {str(folder)!r}]\n"
        "    assert main() == 0\n"
        f"    sys.argv = ['assesto', 'run', {str(folder)!r}, '--no-report', '--jobs', '2']\n"
        "    print('ran:', main(), flush=True)\n"
    )
    done = command(code=code, env=elsewhere, encoding="utf-8")
    assert (done.returncode, done.stderr) == (0, "")
    assert "load unknown at the start" in done.stdout and "α_0" in done.stdout
    assert done.stdout.splitlines()[-1] == "ran: 0"
    assert (folder / "output" / "model.svg").is_file()
    assert run(folder, "--jobs", "1", "--out", str(tmp_path / "here")) == 0
    found, expected = read_results(folder / "output"), read_results(tmp_path / "here")
    assert timeless(found) == timeless(expected)
    assert {path.suffix for path in (folder / "output" / "figures").iterdir()} >= {".svg", ".png"}
    assert {path.name for path in (folder / "output").iterdir()} >= {FOLDER, "results.json"}
