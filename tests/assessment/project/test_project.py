"""The project file: what is read, of the hazard too; both of its forms explain themselves and follow one schema."""

import json
import math
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from assessment.analyses.demand import demand_return_periods
from assessment.cli.main import main
from assessment.project.catalogue.new_project import TEMPLATES, new_project
from assessment.project.problems import matches
from assessment.project.project import json_schema, load_project
from assessment.project.schema import ProjectContent, entries_of, keys_at, table_at, tables_of
from assessment.results.summary import printed
from assessment.runtime.errors import ProjectError
from tests.support.block_project import PROJECT, outcome_of, write_block
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
        "friction", "tangential_stiffness_kN_m3", "compressive_strength_kN_m2", "yield_force_kN",
            "ultimate_elongation",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("pattern", "found"),
    [
        ("records/*.acc", ["aqv_ns.acc", "aqv_up.acc"]), ("rec*/aqv_[nu]?.acc", ["aqv_ns.acc", "aqv_up.acc"]),
        ("./records/../records/*.csv", ["b.csv"]), ("*/b.csv", ["b.csv"]),
        ("*/*", ["aqv_ns.acc", "aqv_up.acc", "b.csv"]), ("*/.*", [".hidden.acc"]), ("records/*/*", []),
        ("nowhere/*", []), ("records/b.csv/*", []),
    ],
)  # fmt: skip
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
        "numpy", "scipy", "numba", "shapely", "ezdxf", "matplotlib", "pandas", "openpyxl", "mechanics.model",
    }  # fmt: skip
    assert not heavy & set(done.stdout.split())


def project(folder, period="", use_class="II"):
    """The block, SLV typed in with a return period or without; nominal life 50 years."""
    hazard = f"SLV = {{ag_g = 0.261, F0 = 2.36, Tc_star_s = 0.35{period}}}\n"
    site = f'[assessment.site]\nsoil = "B"\nnominal_life_years = 50\nuse_class = "{use_class}"\n{hazard}'
    assessment = '[assessment]\nlimit_states = ["SLV"]\nmodel = "none"\n'
    return load_project(write_block(folder, PROJECT + assessment + site))


def test_the_return_period_is_that_of_nominal_life_and_use_class(tmp_path):
    """−50/ln 0.9 = 474.56 years, rounded 475; of class III −75/ln 0.9 = 711.8."""
    assert demand_return_periods(project(tmp_path, ", return_period_years = 475")) == {"SLV": 475.0}
    assert demand_return_periods(project(tmp_path, ", return_period_years = 712", "III")) == {"SLV": 712.0}


def test_one_that_contradicts_them_is_refused(tmp_path):
    with pytest.raises(ProjectError, match=r'SLV\.return_period_years: 475 years.*"III" make 711\.8 at SLV'):
        project(tmp_path, ", return_period_years = 475", "III")


@pytest.mark.parametrize(("period", "known"), [("", False), (", return_period_years = 475", True)])
def test_without_one_they_are_not_printed_and_no_index_rests_on_them(tmp_path, period, known):
    content = project(tmp_path, period)
    results = outcome_of(content).results
    site = printed(results.echo)["assessment"]["site"]
    assert {"nominal_life_years", "use_class"} <= site.keys() if known else "use_class" not in site
    indices = results.states["original"].indices
    assert (indices.I_S is not None) == (indices.acceptable_nominal_life_years is not None) == known


def tables(path=()):
    """Every table of the schema as its path in a content, entries of lists numbered 0."""
    yield path
    for entry in entries_of(table_at(path)):
        yield from tables((*path, *entry))


def made(folder: Path, *options: str) -> Path:
    assert main(["new", str(folder), "--template", "block", *options]) == 0
    return folder


def test_a_new_project_shows_every_key_there_is(tmp_path):
    lines = (made(tmp_path / "p") / "project.toml").read_text(encoding="utf-8").splitlines()
    shown = {}
    for line in (line.removeprefix("# ") for line in lines):
        key, _, rest = line.partition(" = ")
        shown.setdefault(key, set()).add(rest.rpartition(" # ")[2])
    for path in tables():
        for key, meaning in keys_at(path).items():
            if key not in tables_of(table_at(path)) and (path, key) != (("pushover",), "control"):
                assert meaning in shown[key], (path, key)
            else:
                assert any(meaning in line for line in lines)


# the first tables left out that have keys without a default, or say something by being there
NEEDY = ("[[history]]", "[assessment.knowledge]", "[assessment.site.SLD]")


def test_what_is_commented_out_are_the_defaults(tmp_path):
    """Without the marks, and without the keys that have no default, the file says the same."""
    text = (made(tmp_path / "p") / "project.toml").read_text(encoding="utf-8")
    lines = [line.removeprefix("# ") for line in text.splitlines() if " = …" not in line]
    absent = next(number for number, line in enumerate(lines) if line.startswith(NEEDY))
    opened = ProjectContent.model_validate(tomllib.loads("\n".join(lines[:absent])))
    assert opened == ProjectContent.model_validate(tomllib.loads(text))


@pytest.mark.parametrize("template", ["facade", "triumphal-arch"])
def test_a_new_spreadsheet_says_what_the_toml_says(template, tmp_path):
    for folder, options in (("toml", ()), ("xlsx", ("--excel",))):
        assert main(["new", str(tmp_path / folder), "--template", template, *options]) == 0
    assert {file.name for file in (tmp_path / "xlsx").iterdir()} == {
        "geometry.dxf",
        "project.xlsx",
        "records",
    }
    assert load_project(tmp_path / "xlsx").content() == load_project(tmp_path / "toml").content()


def test_conversion_either_way(tmp_path, capsys):
    folder = made(tmp_path / "p")
    before, text = load_project(folder).content(), (folder / "project.toml").read_bytes()
    assert main(["convert", str(folder)]) == 0
    assert "project.xlsx; the earlier file is kept as project.toml.old" in capsys.readouterr().out
    assert load_project(folder).source == "project.xlsx" and load_project(folder).content() == before
    assert (folder / "project.toml.old").read_bytes() == text
    assert main(["convert", str(folder)]) == 0
    assert load_project(folder).source == "project.toml" and load_project(folder).content() == before
    assert "# DXF file with one closed" in (folder / "project.toml").read_text(encoding="utf-8")
    (folder / "project.toml").write_bytes(text + b"# edited")
    capsys.readouterr()
    assert main(["convert", str(folder)]) == 2
    assert "project.toml.old: file: exists" in capsys.readouterr().err
    assert {file.name for file in folder.iterdir()} == {
        "geometry.dxf", "records", "project.toml", "project.toml.old", "project.xlsx.old",
    }  # fmt: skip
