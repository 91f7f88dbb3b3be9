"""Capacities that are refused, and what is said of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from assessment.analyses.checks.capacity import CONTRADICTION, assess
from assessment.analyses.checks.demand import Demands
from assessment.analyses.static.paths import crossings
from assessment.project.project import load_project
from assessment.project.structure.model import build_model
from tests.support.analysed import analysed, arch
from tests.support.typed import typed
from tests.support.wording import in_italian


@pytest.fixture(scope="module")
def capacities(tmp_path_factory):
    """What the assessment makes of the small arch pushed towards +x, its curves changed by a function."""
    folder: Path = arch(tmp_path_factory.mktemp("refused") / "arch")
    project = load_project(folder)
    model, demands = build_model(project).assembly, Demands()

    def of(change):
        pushovers, warnings = dict(typed(analysed()).states["original"].pushover), []
        pushovers["+x"] = change(pushovers["+x"])
        return assess(project, model, pushovers, demands, warnings), warnings

    return of


@pytest.mark.parametrize(("share", "refused"), [(0.9, False), (1.1, True), (-1.1, True)])
def test_a_mechanism_that_virtual_work_contradicts_has_no_capacity(capacities, share, refused):
    def contradict(curves):
        alpha = (1.0 + share * CONTRADICTION) * curves.rigid.mechanism.alpha
        return curves.replace(rigid=curves.rigid.replace(virtual_work_alpha=alpha))

    found, warnings = capacities(contradict)
    assert ("+x" in found) is not refused
    assert "-x" in found
    assert (
        any("+x: no capacity: virtual work on the mechanism gives α" in text for text in warnings) is refused
    )


def test_a_mechanism_on_which_the_horizontal_load_does_no_work_has_no_capacity(capacities):
    """Virtual work is then infinite, or 0/0: null in the results, and it contradicts every curve."""
    found, warnings = capacities(
        lambda curves: curves.replace(rigid=curves.rigid.replace(virtual_work_alpha=None))
    )
    assert "+x" not in found and "-x" in found
    assert any("+x: no capacity: virtual work on the mechanism gives α = inf" in text for text in warnings)


def test_an_elastic_pushover_that_failed_is_not_asked_for_again(capacities):
    found, warnings = capacities(lambda curves: curves.replace(elastic=None))
    assert "+x" not in found and "-x" in found
    [said] = [text for text in warnings if text.startswith("+x: no capacity")]
    assert "was asked for and gave no curve" in said and "ask for contacts" not in said
    assert "è stato richiesto" in in_italian(said)


def test_jumps_below_the_accuracy_of_the_path_are_left_out():
    """Increments of 0.5 mm, located to 1/32: the first jump is rounding, told twice; the next two are one."""
    jumps = [[7.757e-12, 7.272e-12], [7.757e-12, 7.272e-12], [0.002, 0.003], [0.003, 0.0035]]
    [said] = crossings("a wall", jumps, 0.0005)
    assert said.startswith("a wall: between d = 0.002 and 0.0035 m")
