"""A campaign on a Dask cluster whose worker process is killed: the results of local processes."""

import os
import signal
import socket
import time

import pytest

from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.results.schema.part import plain
from assessment.runtime import pool as cluster
from assessment.runtime.cache import FOLDER, Store
from assessment.runtime.errors import ProjectError
from assessment.runtime.pool import Cluster, KilledError
from assessment.runtime.progress import Show
from assessment.runtime.tasks import Workers
from assessment.workflow.stages import run
from tests.support.block_project import edit, timeless
from tests.support.campaign_project import STRIPES, write_campaign

distributed = pytest.importorskip("distributed")
LONG = 600  # s: what hangs fails, a busy machine does not


@pytest.fixture(scope="module")
def local():
    """A scheduler and a worker of one thread, as `dask scheduler` and `dask worker` start them; another follows it."""
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as found:
        yield found


class Murder(Show):
    """Kills a worker as soon as the first combination of the campaign is finished."""

    def __init__(self, local):
        super().__init__()
        self.local, self.killed = local, 0

    def changed(self, stage, title=None):
        if stage.done and stage.name == "campaign" and not self.killed:
            self.killed = next(iter(self.local.workers.values())).pid
            os.kill(self.killed, signal.SIGKILL)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no such signal")
def test_a_worker_that_is_killed_costs_what_it_was_at_and_no_result(local, tmp_path):
    folder = write_campaign(tmp_path / "block", STRIPES, 2)
    edit(folder, "scatter = 2\n", 'scatter = 1\naccuracy = "fast"\n')
    project = load_project(folder)
    model, store, murder = build_model(project), Store(tmp_path / FOLDER), Murder(local)
    away = run(project, model, store=store, show=murder, scheduler=local.scheduler_address)
    assert murder.killed and away.complete and away.taken == 0
    assert timeless(plain(away.results)) == timeless(plain(run(project, model, jobs=1).results))
    again = run(project, model, store=store, scheduler=local.scheduler_address)
    assert (again.computed, again.taken) == (0, away.computed)  # kept by the machine that asked for them


def test_an_error_on_the_cluster_is_the_error(local):
    engine = Cluster(local.scheduler_address)
    with pytest.raises(ZeroDivisionError):
        engine.submit(divmod, 1, 0).result(timeout=LONG)
    engine.close(at_once=False)


def test_a_worker_of_another_version_is_refused(local, monkeypatch):
    monkeypatch.setattr(cluster, "program", lambda: "another")
    engine = Cluster(local.scheduler_address)
    with pytest.raises(ProjectError, match="another version of the program"):
        engine.submit(divmod, 3, 2).result(timeout=LONG)
    engine.close(at_once=False)


def test_what_is_asked_of_a_scheduler_that_is_lost_fails():
    with distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=":0") as found:
        engine = Cluster(found.scheduler_address)
        waiting = engine.submit(time.sleep, 30)
    for ask in (lambda: waiting, lambda: engine.submit(pow, 2, 3)):
        with pytest.raises(KilledError, match="the Dask scheduler or its workers were lost"):
            cluster.result_of(ask())
    engine.close(at_once=True)


def test_no_scheduler_at_the_address_is_told(monkeypatch):
    monkeypatch.setattr(cluster, "ANSWER", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        mute = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        for address, error in (
            ("tcp://127.0.0.1:1", ProjectError),
            (mute, KilledError),
        ):
            with pytest.raises(error, match=f"--scheduler: {address}: no Dask scheduler answers"):
                Cluster(address)


@pytest.mark.parametrize("address", ["nowhere", "http://nowhere:1", "tcp://nowhere"])
def test_of_what_is_no_address_of_a_scheduler_no_client_is_made(address, monkeypatch):
    """It ended with a traceback of its own, 20 s later."""
    made = []
    monkeypatch.setattr("distributed.Client", lambda *_, **__: made.append(1))
    with pytest.raises(ProjectError, match=f"--scheduler: {address}: no Dask scheduler answers"):
        Cluster(address)
    assert not made


def test_a_single_analysis_is_given_to_the_scheduler_too():
    def doubled(number: int) -> int:
        return 2 * number

    with pytest.raises(ProjectError, match="--scheduler: nowhere: "):
        Workers(jobs=1, scheduler="nowhere").each("pushover", doubled, [(2,)], ["one"], worthwhile=False)
