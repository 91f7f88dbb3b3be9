"""The project file: what is read."""

import json
import math
import subprocess
import sys
from pathlib import Path

import pytest

from assessment.project.catalogue.new_project import TEMPLATES, new_project
from assessment.project.problems import matches
from assessment.project.project import json_schema
from tests.support.contract_project import CONTRACT, MINIMAL, load, write_named_files


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_named_files(tmp_path)


def test_the_contract_s_own_example_is_read(folder):
    project = load(folder, CONTRACT)
    assert (project.folder, project.source, project.title) == (folder, "project.toml", "Buttressed arch")
    assert project.geometry.depth_m == 0.1 and project.geometry.unit == "mm"
    assert project.material.normal_stiffness_kN_m3 == 1.2e5
    assert project.material.tangential_stiffness_kN_m3 == math.inf
    assert project.layers["PIERS"].depth_m == 5.5 and project.layers["ROOF"].vertical_load_kN == 9.1
    assert project.supports == ("right",)
    assert project.states == ("original", "right support 20 mm")
    assert project.control[1].point_m == (1.0, 3.0)
    assert project.settlements[0].displacement_m == (0.02, -0.02) and project.settlements[0].increments == 20
    assert project.pushover.contacts == ("rigid", "elastic") and project.pushover.directions == ("+x", "-x")
    assert project.history[0].window_s == (15.0, 22.0) and project.incremental.max_scale == 5.0
    assert [file.name for file in project.record_files(project.incremental)] == ["aqv_ns.acc", "aqv_up.acc"]
    assert project.assessment.site.latitude == 42.35 and project.report.engineer == "Ing. Rossi"
    assert project.path("records/b.csv").is_file()


def test_absent_tables_switch_their_stage_off(folder):
    project = load(folder, MINIMAL)
    assert project.pushover is project.incremental is project.assessment is None
    assert project.history == project.settlements == project.control == ()
    assert project.report.language == "it" and project.material.friction == 0.6


def test_control_points_by_default_name_and_direction(folder):
    project = load(folder, CONTRACT.replace('control = "C1"', 'control = {"-x" = "C2"}', 1))
    assert project.control_point().name == "C1" and project.control_point("C2").name == "C2"
    assert project.pushover_control("-x").name == "C2" and project.pushover_control("+x").name == "C1"


def test_steps_keep_within_both_increments(folder):
    text = CONTRACT.replace("rotation_rad = 0.0", "rotation_rad = -0.05\nincrement_rad = 0.002")
    assert load(folder, text).settlements[0].increments == 25
    turned = load(
        folder, text.replace("displacement_m = [0.020, -0.020]", "").replace("increment_m = 0.001\nto", "to")
    )
    assert turned.settlements[0].displacement_m == (0.0, 0.0)


def test_json_schema_describes_every_key():
    schema = json_schema()
    json.dumps(schema, allow_nan=False)
    tables = [schema, *schema["$defs"].values()]
    for table in tables:
        assert table["additionalProperties"] is False
        assert all(key["description"] for key in table["properties"].values())
    assert set(schema["required"]) == {"title", "geometry", "material"}
    assert schema["$defs"]["GeometryTable"]["properties"]["unit"]["enum"] == ["mm", "cm", "m"]


def test_every_number_has_bounds():
    """Only friction and stiffness may be infinite; nothing else is so large or small that arithmetic fails."""
    unbounded = set()

    def look(node, key):
        if isinstance(node, dict):
            if node.get("type") in {"number", "integer"} and "enum" not in node:
                low, high = (
                    node.keys() & {f"{end}imum", f"exclusive{end.title()}imum"} for end in ("min", "max")
                )
                if not (low and high):
                    unbounded.add(key)
            if node.get("type") == "array" and "prefixItems" not in node and "uniqueItems" not in node:
                assert node["maxItems"] <= 10_000, key
            for name, each in node.items():
                look(each, key if name in {"anyOf", "items", "prefixItems"} else name)
        elif isinstance(node, list):
            for each in node:
                look(each, key)

    look(json_schema(), "")
    assert unbounded == {
        "friction",
        "tangential_stiffness_kN_m3",
        "compressive_strength_kN_m2",
        "yield_force_kN",
    }


@pytest.mark.parametrize(
    ("pattern", "found"),
    [
        ("records/*.acc", ["aqv_ns.acc", "aqv_up.acc"]),
        ("rec*/aqv_[nu]?.acc", ["aqv_ns.acc", "aqv_up.acc"]),
        ("./records/../records/*.csv", ["b.csv"]),
        ("*/b.csv", ["b.csv"]),
        ("*/*", ["aqv_ns.acc", "aqv_up.acc", "b.csv"]),
        ("*/.*", [".hidden.acc"]),
        ("records/*/*", []),
        ("nowhere/*", []),
        ("records/b.csv/*", []),
    ],
)
def test_patterns_of_records(folder, pattern, found):
    (folder / "records" / ".hidden.acc").touch()
    (folder / "records" / "deep").mkdir()
    for each in (pattern, str(folder / pattern)):
        assert [file.name for file in matches(folder, each)] == found


KNOWN = """[assessment.knowledge]
level = "LC1"
"""


def test_a_project_is_read_without_what_computes_or_draws(tmp_path):
    """All that a run in which nothing has changed does at first; return periods and knowledge took 1 to 2 s more."""
    for name in TEMPLATES:
        new_project(tmp_path / name, name, {})
    block = tmp_path / "block" / "project.toml"
    block.write_text(block.read_text(encoding="utf-8").replace("[report]", KNOWN + "[report]"), "utf-8")
    code = (
        "import sys\nfrom pathlib import Path\nfrom assessment.project.project import load_project\n"
        f"for folder in Path({str(tmp_path)!r}).iterdir():\n"
        "    load_project(folder)\n"
        "print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    heavy = {
        "numpy",
        "scipy",
        "numba",
        "shapely",
        "ezdxf",
        "matplotlib",
        "pandas",
        "openpyxl",
        "mechanics.model",
    }
    assert not heavy & set(done.stdout.split())
