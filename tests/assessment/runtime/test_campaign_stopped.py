"""A campaign that is killed, interrupted, or loses its scheduler: nothing finished is computed again.

With ASSESTO_STRESS=long alone: test_interruption and test_cluster have each of these by itself. What is stopped is a
process of its own. Nothing is waited for longer than LONG, nor once a process has ended that it depends on.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from assessment.cli.main import main
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.results.schema.part import plain
from assessment.runtime.cache import FOLDER, Store
from assessment.runtime.journal import read_journal
from assessment.runtime.progress import Stage
from assessment.workflow.stages import run
from tests import ROOT
from tests.stress.test_stress import LONG as SWEEPS
from tests.support.block_project import read_results, timeless
from tests.support.campaign_project import STRIPES, write_campaign
from tests.support.every_stage import planned
from tests.support.scheduler import LONG, scheduler, wait_for

pytestmark = [
    pytest.mark.skipif(os.name != "posix" or not SWEEPS, reason="ASSESTO_STRESS=long, and signals"),
    pytest.mark.usefixtures("no_figures"),
]
COMBINATIONS = 8  # two records, both signs, two shares


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    return write_campaign(tmp_path_factory.mktemp("drawn") / "block", STRIPES, 2)


@pytest.fixture(scope="module")
def whole(drawn):
    """Results of a run that nothing disturbs, in one process, without a store."""
    project = load_project(drawn)
    return timeless(plain(run(project, build_model(project), jobs=1).results))["campaign"]


@pytest.fixture
def project(drawn, tmp_path):
    return Path(shutil.copytree(drawn, tmp_path / "block"))


def begin(folder: Path, *options: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "assessment.cli", "run", str(folder), "--no-report", "--json", *options],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip


def of_campaign(folder: Path) -> Stage | None:
    stages = [stage for stage in read_journal(folder / "output").stages if stage.name == "campaign"]
    return stages[0] if stages else None


def wait_for_one(folder: Path, *alive: subprocess.Popen[bytes] | subprocess.Popen[str]) -> None:
    """Wait until a combination is finished."""
    wait_for(lambda: bool((stage := of_campaign(folder)) and stage.done), *alive)


def exit_code(child: int) -> int:
    """Wait for a forked process."""
    found: list[int] = []

    def ended() -> bool:
        number, status = os.waitpid(child, os.WNOHANG)
        if number:
            found.append(os.waitstatus_to_exitcode(status))
        return bool(found)

    try:
        wait_for(ended)
    finally:
        if not found:
            os.kill(child, signal.SIGKILL)
    return found[0]


def end_of(started: subprocess.Popen[str]) -> str:
    """Wait for the end of a run that was stopped; return the last line that it prints, no traceback among them."""
    try:
        _, err = started.communicate(timeout=LONG)
    finally:
        started.kill()
    assert started.returncode == 3 and "Traceback" not in err
    return err.splitlines()[-1]


def entries(output: Path) -> set[str]:
    """Return the analyses kept in an output folder, whole ones."""
    store = Store(output / FOLDER)
    names = {path.name for path in store.folder.iterdir()} if store.folder.exists() else set()
    return {name for name in names if store.read(name) is not None}


def check_kept(folder: Path, capsys) -> int:
    """Check journal, status and store of a run that was stopped in the campaign; return the number of entries."""
    stage, kept = of_campaign(folder), len(entries(folder / "output"))
    assert stage is not None and stage.total == COMBINATIONS and not stage.ended
    static = sum(planned(folder).values()) - COMBINATIONS
    assert static + stage.done <= kept <= static + stage.done + 1  # one may be kept and not yet told
    assert stage.done + 1 < COMBINATIONS
    assert not (folder / "output" / "results.json").exists()
    capsys.readouterr()
    assert main(["status", str(folder)]) == 0
    told = capsys.readouterr().out.splitlines()
    assert told[0] == "not at work: the run was interrupted or killed"
    assert f"campaign: {stage.done} of {COMBINATIONS} done" in told
    assert told[-1] == "finished analyses are kept: run again to go on"
    return kept


def check_rest(folder: Path, kept: int, whole, capsys, *options: str) -> None:
    """Run again, to the end: only what is left is computed, and the results are those of an undisturbed run."""
    capsys.readouterr()
    assert main(["run", str(folder), "--no-report", "--json", *options]) == 0
    every = sum(planned(folder).values())
    assert json.loads(capsys.readouterr().out)["analyses"] == {"computed": every - kept, "taken_over": kept}
    assert timeless(read_results(folder / "output"))["campaign"] == whole
    assert read_journal(folder / "output").exit_code == 0


@contextmanager
def cluster(port: int = 0) -> Iterator[str]:
    """Start a scheduler and a worker that are threads here, where all is imported; yield the address."""
    distributed = pytest.importorskip("distributed")
    options = {"processes": False, "protocol": "tcp", "scheduler_port": port, "dashboard_address": ":0"}
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, silence_logs=50, **options) as found:
        yield found.scheduler_address


def test_ctrl_c_leaves_a_cluster_at_work_and_a_scheduler_that_is_started_again_goes_on_with_what_is_left(
    project, capsys, whole, tmp_path
):
    pytest.importorskip("distributed")
    with scheduler(tmp_path) as (address, lost, worker):
        started = begin(project, "--scheduler", address)
        wait_for_one(project, started, lost, worker)
        os.killpg(started.pid, signal.SIGINT)
        assert end_of(started).endswith("run again to go on")
        kept = check_kept(project, capsys)
        started = begin(project, "--scheduler", address)
        wait_for(lambda: len(entries(project / "output")) > kept, started, lost, worker)
        lost.kill()
        assert "the Dask scheduler or its workers were lost" in end_of(started)
    kept = len(entries(project / "output"))
    with cluster(int(address.rpartition(":")[2])) as same:
        assert same == address
        check_rest(project, kept, whole, capsys, "--scheduler", address)
