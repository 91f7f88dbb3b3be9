"""Capacities by both laws of friction: Coulomb's counts where none is asked for, and both ζ_E are told."""

from __future__ import annotations

import pytest

from assessment.cli.main import main
from assessment.project.catalogue.geometry import rectangle
from assessment.project.catalogue.new_project import write_drawing
from tests.support.block_project import ASSESSMENT, PUSHED, block, read_results

LAYERS = {
    "BASE": [rectangle(-1.0, 1.0, -0.3, 0.0)],
    "SIDE": [rectangle(-1.0, -0.25, 0.0, 3.0)],
    "WALL": [rectangle(-0.25, 0.25, 0.0, 3.0)],
}


def rubbing(folder, sliding: str) -> dict:
    """A wall 0.5 × 3 m that is pushed away from a fixed one, with which it has a joint."""
    folder.mkdir()
    write_drawing(folder / "geometry.dxf", LAYERS)
    text = block().replace("point_m = [0.3, 4.2]", "point_m = [0.25, 3.0]")
    text = (
        text.replace('[[control]]\nname = "left"\npoint_m = [-0.3, 4.2]\n', "")
        + '[layers.SIDE]\nsupport = "side"\n'
    )
    text += sliding + PUSHED + ASSESSMENT
    (folder / "project.toml").write_text(text, encoding="utf-8")
    assert main(["run", str(folder), "--no-report"]) == 0
    return read_results(folder / "output")


@pytest.mark.usefixtures("no_figures")
def test_coulombs_law_counts_where_none_is_asked_for_and_both_indices_are_told(tmp_path):
    """What turns away leaves the other wall: by Coulomb's law nothing rubs, α0 = t/h = 1/6.

    By the associative law its foot, which rises faster than it leaves, rubs on, and α0 is more: the wall is safer the
    rougher a joint that opens.
    """
    found = {name: rubbing(tmp_path / name, text) for name, text in (
        ("none", ""),
        ("associative", '[contacts]\nsliding = "associative"\n'),
    )}  # fmt: skip
    rigid = {name: each["states"]["original"]["pushover"]["+x"]["rigid"] for name, each in found.items()}
    capacity = {name: each["states"]["original"]["capacity"]["+x"] for name, each in found.items()}
    told = {
        name: [w for w in each["quality"]["warnings"] if "has the ratio" in w] for name, each in found.items()
    }

    assert rigid["associative"]["sliding"] == "associative" and rigid["associative"]["alpha_0"] > 1.01 / 6.0
    other = rigid["associative"]["other_law"]
    assert (other["sliding"], other["alpha_0"]) == ("coulomb", pytest.approx(1.0 / 6.0, rel=1e-5))
    by_name = capacity["associative"]
    assert (by_name["sliding"], by_name["alpha_0"]) == ("associative", rigid["associative"]["alpha_0"])
    assert by_name["other_law"]["zeta_E"]["SLV linear"] < by_name["SLV linear"]["zeta_E"]
    assert told["associative"]

    assert capacity["none"]["sliding"] == "coulomb"
    linear = by_name["other_law"]["zeta_E"]["SLV linear"]
    assert capacity["none"]["SLV linear"]["zeta_E"] == pytest.approx(linear, rel=1e-4)
    assert capacity["none"]["SLV"]["zeta_E"] < by_name["SLV"]["zeta_E"]
    assert capacity["none"]["alpha_0"] == pytest.approx(1.0 / 6.0, rel=1e-5)
    assert capacity["none"]["other_law"]["sliding"] == "associative"
    assert told["none"]
    for row in found["none"]["summary"]["rows"]:
        assert row["alpha_0"] == capacity["none"]["alpha_0"]
        assert row.get("other_law") == capacity["none"].get("other_law")
