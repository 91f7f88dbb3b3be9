"""A template whose sizes are set is not called the model that it is without them."""

from typing import Annotated

import pytest

from assessment.cli.main import main
from assessment.project.catalogue import walls
from assessment.project.catalogue.new_project import TEMPLATES, new_project
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


def test_wide_piers_have_bases_that_do_not_meet(tmp_path, capsys):
    """Bases a quarter of the pier wider on either side overlapped below a narrow span: `check` refused them."""
    arguments = ["--template", "buttressed-arch", "--set", "pier_width_m=2"]
    assert main(["new", str(tmp_path / "arch"), *arguments]) == 0
    assert main(["check", str(tmp_path / "arch")]) == 0
    assert "stands under its own weight: yes" in capsys.readouterr().out


def test_dimensions_that_give_no_structure_are_refused_before_anything_is_written(
    tmp_path, capsys, monkeypatch
):
    def overlapping(width_m: Annotated[float, "width"] = 1.0):
        layout, content = walls.block(width_m, 1.0)
        return layout | {"BLOCCO": 2 * layout["BLOCCO"]}, content

    monkeypatch.setitem(TEMPLATES, "block", overlapping)
    assert main(["new", str(tmp_path / "arch"), "--template", "block", "--set", "width_m=2"]) == 2
    assert "--set: the dimensions give no structure: " in (said := capsys.readouterr().err)
    assert "drawn twice" in said and said.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_name_that_no_other_command_takes_is_refused(tmp_path, capsys):
    assert main(["new", str(tmp_path / "a\nb"), "--template", "wall"]) == 2
    assert "control characters in the name; give another one" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
