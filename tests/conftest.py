"""Fixtures of the tests that run the program: a small project, and products that take no time."""

import gc
import multiprocessing
import os
import signal
import sys

# before NumPy is loaded, also by processes begun here: two tests at a time fill two cores, and threads of the BLAS that
# wait for each other took a twentieth of the processor time
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import HealthCheck, settings

from assessment.report.figures import index as figures
from assessment.runtime import pool, tasks
from tests.support.block_project import write_block
from tests.support.products import draw_nothing, print_nothing

# hundreds of processes begin here: what they import is compiled once, also where the environment keeps no byte code
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# thousands of tests are a large heap: at the usual thresholds to look through it took a twelfth of the processor time
gc.set_threshold(50_000, 20, 100)

# no example is too slow: how long one takes is the machine's affair, and that of what else it is doing
settings.register_profile(
    "assesto", max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("assesto")


def pytest_addoption(parser):
    starts = multiprocessing.get_all_start_methods()
    text = "how processes begin in every test: spawn is what Windows and macOS do (default: the system's)"
    parser.addoption("--start", choices=starts, help=text)


def pytest_configure(config):
    if start := config.getoption("--start"):
        multiprocessing.set_start_method(start, force=True)
    # in the background of a script SIGINT is ignored, and processes hand that on to those that tests interrupt
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_sessionfinish():
    gc.freeze()  # what is left is thrown away: to look through it took seconds


@pytest.fixture(scope="session", autouse=True)
def one_core():
    """No other process unless --jobs asks for several: to fork all that tests have loaded takes longer than work."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pool, "cores", lambda: 1)
        patch.setattr(tasks, "processes", lambda jobs: pool.processes(jobs) if jobs > 1 else 0)
        yield


@pytest.fixture
def project(tmp_path):
    """A project folder whose run takes a tenth of a second."""
    return write_block(tmp_path / "block")


@pytest.fixture
def drawn():
    """For tests that want the figures all the same."""


@pytest.fixture
def no_figures(monkeypatch):
    """No picture is drawn, and there is no drawing of shapes: they take longer than the analyses of a block."""
    monkeypatch.setattr(figures, "write_figures", lambda _, folder: folder.mkdir())
    monkeypatch.setattr(figures, "write_images", lambda *_: [])


@pytest.fixture
def quick(monkeypatch, request):
    """One empty figure, and a PDF that only looks like one (the real ones: see test_figures, test_report)."""
    print_nothing(monkeypatch)
    if "drawn" not in request.fixturenames:
        draw_nothing(monkeypatch)
