"""Work on results side by side: the same answers as alone, errors come through, no process stays behind."""

import multiprocessing
import os

import pytest

from assessment.crew import Crew

RESULTS = {"states": {"original": 4, "settled": 2}}


def halved(results, state, by):
    return results["states"][state] / by, os.getpid()


@pytest.mark.parametrize("jobs", [1, 2])
def test_answers_are_those_of_the_function(jobs):
    with Crew(RESULTS, jobs) as crew:
        begun = [crew.do(halved, state, 2) for state in RESULTS["states"]]
        found = [work.result() for work in begun]
    assert [value for value, _ in found] == [2.0, 1.0]
    assert all((process == os.getpid()) == (jobs == 1) for _, process in found)
    assert not multiprocessing.active_children()


@pytest.mark.parametrize("jobs", [1, 2])
def test_errors_come_through_and_end_the_crew(jobs):
    with pytest.raises(ZeroDivisionError), Crew(RESULTS, jobs) as crew:
        crew.do(halved, "original", 0).result()
    assert not multiprocessing.active_children()
