"""About how long a run takes: in proportion to what is asked for, and near what the examples take."""

import pytest

from assessment.project.catalogue.new_project import new_project
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.workflow.checking import expected, read_inputs
from tests import ROOT


@pytest.fixture(scope="module")
def arch():
    project = load_project(ROOT / "projects" / "arch_campaign")
    return read_inputs(project, build_model(project))


def changed(read, **tables):
    project = read.project.model_copy(update=tables)
    return expected(type(read)(**{**vars(read), "project": project}))


def test_a_campaign_takes_as_long_as_its_motions(arch):
    study = arch.project.campaign
    as_drawn = changed(arch, campaign=study.model_copy(update={"shares": (0.0,)}))["campaign"]
    # as drawn once, and two movements at two shares each
    assert expected(arch)["campaign"] == pytest.approx(5.0 * as_drawn)
    one_sign = changed(arch, campaign=study.model_copy(update={"signs": (1,)}))["campaign"]
    assert expected(arch)["campaign"] == pytest.approx(2.0 * one_sign)


def test_members_of_an_ensemble_and_smaller_increments_take_longer(arch):
    assert changed(arch, scatter=5)["pushover"] == pytest.approx(4.0 * expected(arch)["pushover"])
    finer = tuple(each.model_copy(update={"increment_m": 0.0015}) for each in arch.project.settlements)
    assert changed(arch, settlements=finer)["pushdown"] == pytest.approx(2.0 * expected(arch)["pushdown"])


@pytest.mark.parametrize(("template", "seconds"), [("arch", 5.8), ("facade", 11.0), ("wall", 85.0)])
def test_templates_take_what_was_measured(tmp_path, template, seconds):
    """Processor time of the static chain, within a factor of two: arches, a stacked wall, walls in bond."""
    new_project(tmp_path / template, template, {})
    project = load_project(tmp_path / template)
    told = expected(read_inputs(project, build_model(project)))
    assert seconds / 2.0 < told.get("pushdown", 0.0) + told["pushover"] < 2.0 * seconds
