"""Work in other processes: the same answers as alone, errors come through, and no process stays behind."""

import functools
import multiprocessing
import os
import signal
import time
from concurrent.futures import Future, ProcessPoolExecutor, wait

import pytest

from assessment.runtime import pool as pools
from assessment.runtime.pool import KilledError, Pool, finished, processes, result_of

HELD = {"original": 4, "settled": 2}
STARTS = sorted({"fork", "spawn"} & {*multiprocessing.get_all_start_methods()})


@pytest.fixture
def start(request, monkeypatch):
    """Begin processes in the way of the parameter: Linux forks them, Windows and macOS spawn them."""
    context = multiprocessing.get_context(request.param)
    monkeypatch.setattr(
        pools, "ProcessPoolExecutor", functools.partial(ProcessPoolExecutor, mp_context=context)
    )


def halved(held, state, by):
    return held[state] / by, os.getpid()


def slept(seconds):
    time.sleep(seconds)
    return seconds


def killed():
    os.kill(os.getpid(), signal.SIGTERM)  # as from outside
    time.sleep(600)


def of_processes(test):
    return pytest.mark.parametrize("start", STARTS, indirect=True)(pytest.mark.usefixtures("start")(test))


@of_processes
def test_answers_are_those_of_the_function():
    for number in (0, 2):
        with Pool(number, HELD) as pool:
            begun = [pool.apply(halved, state, 2) for state in HELD]
            found = [result_of(work) for work in begun]
        assert [value for value, _ in found] == [2.0, 1.0]
        assert all((process == os.getpid()) == (number == 0) for _, process in found)
    assert not multiprocessing.active_children()


@of_processes
def test_errors_come_through_and_end_the_pool():
    for number in (0, 2):
        with pytest.raises(ZeroDivisionError), Pool(number, HELD) as pool:
            result_of(pool.apply(halved, "original", 0))
    assert not multiprocessing.active_children()


@of_processes
def test_a_killed_process_is_told_and_what_the_others_have_finished_is_kept():
    with pytest.raises(KilledError, match="ended from outside"), Pool(2) as pool:
        done = pool.submit(slept, 0.0)
        result_of(done)
        dead = pool.submit(killed)
        wait([dead])
        seen = []
        for key, _ in finished({dead: "killed", done: "done"}):
            seen.append(key)
    assert seen == ["done"]
    assert not multiprocessing.active_children()


def test_work_that_a_lost_cluster_gives_up_is_told():
    lost: Future[int] = Future()
    lost.cancel()
    lost.set_running_or_notify_cancel()
    with pytest.raises(KilledError, match="were lost"):
        list(finished({lost: "lost"}))


def test_processes_are_bounded(monkeypatch):
    monkeypatch.setattr(pools, "cores", lambda: 3)
    assert [processes(jobs) for jobs in (0, 1, 5, 1_000_000)] == [3, 1, 5, 6]
    monkeypatch.setattr(pools, "cores", lambda: 128)
    assert processes(0) == processes(1_000_000) == 61, "more than Windows waits for"
