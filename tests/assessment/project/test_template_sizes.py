"""A template whose sizes are set is not called the model that it is without them."""

import pytest

from assessment.project.catalogue.new_project import new_project
from assessment.project.project import load_project


@pytest.mark.parametrize(
    ("options", "title", "depth", "movement"),
    [
        ({}, "Arco su piedritti, modello 1:10", 0.1, "appoggio destro 20 mm"),
        ({"voussoirs": 15}, "Arco su piedritti, modello 1:10", 0.1, "appoggio destro 20 mm"),
        ({"span_m": 4.0, "rise_m": 1.8}, "Arco su piedritti", 0.74, "appoggio destro 148 mm"),
        ({"pier_height_m": 0.6}, "Arco su piedritti", 0.1, "appoggio destro 20 mm"),
    ],
)
def test_title_depth_and_movement_go_with_the_size(tmp_path, options, title, depth, movement):
    new_project(tmp_path / "arch", "buttressed-arch", options)
    project = load_project(tmp_path / "arch")
    assert (project.title, project.geometry.depth_m) == (title, depth)
    [settlement] = project.settlements
    assert settlement.name == movement
