"""The program as users run it: commands, what they say and what they write."""

import hashlib
import re

import pytest
from ezdxf.filemanagement import readfile

from assessment.cli import main as cli
from assessment.cli.commands import WRONG_INPUT
from assessment.cli.main import main
from assessment.project.catalogue.new_project import examples
from assessment.project.project import load_project
from tests.support.block_project import ASSESSMENT, PROJECT, edit, read_results, run

pytestmark = pytest.mark.usefixtures("quick")


CONTRACT = {  # keys, of what stands where in results.json
    "": "assesto title inputs model states comparison quality timing_s",
    "model": "blocks movable_blocks joints unknowns contact_points weight_kN self_weight_stable warnings",
    "quality": "solves worst_equilibrium_residual worst_penetration_m worst_complementarity warnings",
    "timing_s": "pushdown pushover",
    "comparison 0": "state direction static_pga_g static_reduction dynamic_pga_g dynamic_reduction",
    "states S": "pushover capacity history incremental",
    "states S pushover +x rigid": "alpha_0 d_0_m curve mechanism",
    "states S pushover +x rigid mechanism": "hinges e_star gamma_star",
    "states S pushover +x elastic": "alpha_u alpha_y d_y_m curve",
    "states S capacity +x": "e_star gamma_star T_0_s SLV",
    "states S capacity +x SLV": "d_star_m a_star_g T_s a_g_g demand_a_g_g zeta_E verified",
    "states T pushdown rigid": "movement_m reaction_x_kN reaction_z_kN ultimate_movement_m",
}


def test_results_have_the_keys_of_the_contract(project):
    edit(project, "increment_m = 0.2\n", "increment_m = 0.2\n" + ASSESSMENT)
    edit(project, 'contacts = ["rigid"]', 'contacts = ["rigid", "elastic"]')
    assert run(project) == 0
    found = read_results(project / "output")
    assert list(found["states"]) == ["original", "base turned"]
    for where, keys in CONTRACT.items():
        for state in found["states"] if " S" in where else ["base turned"]:
            at = found
            for part in where.split():
                at = at[state if part in "ST" else int(part) if part == "0" else part]
            assert at.keys() >= set(keys.split()), where
    drawing = (project / "geometry.dxf").read_bytes()
    assert found["inputs"]["geometry.dxf"] == hashlib.sha256(drawing).hexdigest()
    assert found["inputs"].keys() == {"project.toml", "geometry.dxf"}
    model = found["model"]
    counts = ("blocks", "movable_blocks", "joints", "unknowns", "contact_points")
    assert [model[key] for key in counts] == [2, 1, 1, 3, 4]
    assert model["weight_kN"] == pytest.approx(0.6 * 4.2 * 18.0) and model["self_weight_stable"] is True
    for name, state in found["states"].items():
        assert state["history"] == [] and state["capacity"]["+x"]["SLV"]["a_g_g"] is not None, name
        for contacts in ("rigid", "elastic"):
            curve = state["pushover"]["+x"][contacts]["curve"]
            assert curve["displacement_m"][0] == 0.0
            assert len(curve["displacement_m"]) == len(curve["multiplier"]) > 2
    path = found["states"]["base turned"]["pushdown"]["rigid"]
    assert path["movement_m"][0] == 0.0 and path["ultimate_movement_m"] is None  # not sought
    assert found["comparison"][0]["static_reduction"] > 0.0
    assert 0.0 <= found["quality"]["worst_equilibrium_residual"] < 1e-8 and found["quality"]["solves"] > 10


def test_only_the_stages_asked_for(project):
    edit(project, "increment_m = 0.2\n", "increment_m = 0.2\n" + ASSESSMENT)
    assert run(project, "--only", "pushover") == 0
    state = read_results(project / "output")["states"]["base turned"]
    assert state["capacity"] == {}
    assert set(state["pushover"]) == {"+x"}
    assert run(project, "--only", "pushdown") == 0
    states = read_results(project / "output")["states"]
    assert "rigid" in states["base turned"]["pushdown"]
    assert all(state["pushover"] == {} for state in states.values())


def test_a_table_that_is_absent_switches_its_stage_off(project):
    (project / "project.toml").write_text(PROJECT.partition("[pushover]")[0], encoding="utf-8")
    assert run(project) == 0
    found = read_results(project / "output")
    assert list(found["states"]) == ["base turned"]
    assert found["states"]["base turned"]["pushover"] == {}
    assert found["comparison"] == []


def test_check_draws_the_model_and_runs_nothing(project, capsys):
    assert main(["check", str(project)]) == 0
    out = capsys.readouterr().out
    assert "blocks 2 (1 movable)" in out
    assert "own weight: yes" in out
    assert (project / "output" / "model.svg").read_text(encoding="utf-8").lstrip().startswith("<?xml")
    assert not (project / "output" / "results.json").exists()


def test_check_repairs_a_drawing_beside_the_original_and_tells_every_change(project, capsys):
    """Two outlines, one raised by 2 mm and one drawn twice: the model of the repaired drawing is the intended one."""
    drawn = project / "geometry.dxf"
    document = readfile(drawn)
    stone = document.modelspace().query('LWPOLYLINE[layer!="BASE"]')[0]
    stone.set_points([(x, y + 0.002, *rest) for x, y, *rest in stone.get_points("xyseb")], "xyseb")
    document.modelspace().add_lwpolyline(
        stone.get_points(), close=True, dxfattribs={"layer": stone.dxf.layer}
    )
    document.saveas(drawn)
    original = drawn.read_bytes()
    assert main(["check", str(project)]) == 2
    capsys.readouterr()
    assert main(["check", str(project), "--repair"]) == 0
    out = capsys.readouterr().out
    assert drawn.read_bytes() == original
    assert "deleted, the same outline as" in out and out.count("moved by 2 mm") == 2
    assert f"3 changes: {project / 'geometry-repaired.dxf'}; to use it write" in out
    repaired = (project / "geometry-repaired.dxf").read_bytes()
    assert main(["check", str(project), "--repair"]) == 0
    assert not (project / "geometry-repaired-2.dxf").exists()
    (project / "geometry-repaired.dxf").write_bytes(b"changed by hand")
    assert main(["check", str(project), "--repair"]) == 0
    assert f"3 changes: {project / 'geometry-repaired-2.dxf'}; to use it" in capsys.readouterr().out
    assert (project / "geometry-repaired.dxf").read_bytes() == b"changed by hand"
    (project / "geometry-repaired.dxf").write_bytes(repaired)
    edit(project, 'drawing = "geometry.dxf"', 'drawing = "geometry-repaired.dxf"')
    assert main(["check", str(project), "--repair"]) == 0
    assert "geometry-repaired.dxf: nothing that can be repaired" in capsys.readouterr().out
    assert not (project / "geometry-repaired-repaired.dxf").exists()


@pytest.mark.parametrize("name", examples())
def test_an_example_is_a_project_of_ones_own(tmp_path, capsys, name):
    folder = tmp_path / name
    assert main(["new", str(folder), "--example", name.replace("_", "-")]) == 0
    assert load_project(folder).content() == load_project(examples()[name]).content()
    assert {path.name for path in folder.iterdir()} >= {"project.toml", "geometry.dxf", "README.md"}
    assert not (folder / "output").exists()
    capsys.readouterr()
    assert main(["new", str(folder), "--example", name]) == 2
    assert "exists and is not empty" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["chek", "arch"], 'error: assesto chek: no such command; did you mean "check"?'),
        (["rum", "arch"], 'error: assesto rum: no such command; did you mean "run"?'),
        (["--quiet", "reprot"], 'error: assesto reprot: no such command; did you mean "report"?'),
        (["zzz"], 'error: assesto zzz: no such command; valid: "run", "check", "status"'),
        (["run", "arch", "--onyl", "pushover"], 'assesto run: --onyl: no such option; did you mean "--only"?'),
        (["run", "arch", "--no-reprot"], 'assesto run: --no-reprot: no such option; did you mean "--no-report"?'),
        (["new", "a", "--tempalte=arch"], '--tempalte: no such option; did you mean "--template"?'),
        (["check", "a", "b"], "assesto check: b: one argument too many; see assesto check --help"),
        (["ru\x1b[31m\nn"], r"error: assesto ru\x1b[31m\nn: no such command"),
        (["run", "arch", "--fr\x1b[31m"], r"assesto run: --fr\x1b[31m: no such option"),
    ],
)  # fmt: skip
def test_what_is_misspelt_is_told_with_the_nearest_name(capsys, arguments, says):
    assert main(arguments) == WRONG_INPUT
    out, err = capsys.readouterr()
    assert out == ""
    assert says in err and err.startswith("error: ") and err.count("\n") == 1


@pytest.mark.parametrize("command", ["", *cli.COMMANDS])
def test_help_ends_with_examples_and_the_exit_codes(capsys, command):
    with pytest.raises(SystemExit) as stop:
        main([*command.split(), "--help"])
    assert stop.value.code == 0
    text = capsys.readouterr().out
    examples, codes = text[text.index("examples:") :].split("exit codes:")
    shown = [line.strip() for line in examples.splitlines()[1:] if line.strip()]
    assert 2 <= len(shown) <= 4 and all(line.startswith(f"assesto {command}".strip()) for line in shown)
    assert re.findall(r"^  (\d)  ", codes, re.MULTILINE) == ["0", "2", "3"]


@pytest.mark.parametrize("command", ["", *cli.COMMANDS])
def test_the_examples_of_the_help_can_be_typed(command):
    for example in cli.COMMANDS[command].examples if command else cli.EXAMPLES:
        words = example.partition(" > ")[0].split()
        assert words[0] == "assesto" and callable(cli.options_of(words[1:]).command)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("friction = 0.7", "friction = 0,7", "friction = 0,7; write a decimal point, not a comma: 0.7"),
        ("depth_m = 1.0", "depth_m = 1,5e0 # 1,2", "write a decimal point, not a comma: 1.5e0"),
        (
            "[0.3, 4.2]",
            "[0,3, 4,2]",
            "control[1].point_m: [0, 3, 4, 2] is wrong; write two numbers, with decimal points",
        ),
        ("[0.3, 4.2]", "[0,03, 4,2]", "[0,03, 4,2]; write a decimal point, not a comma: 0.03"),
        ("friction = 0.7", 'friction = "0,7"', "a number, with a decimal point and without quotes: 0.7"),
        ("friction = 0.7", f'friction = "0,{"7" * 5000}"', f"and without quotes: 0.{'7' * 37}…\n"),
        ("friction = 0.7", f"friction = 0,{'7' * 4000}", f"not a comma: 0.{'7' * 117}…\n"),
    ],
)
def test_a_decimal_comma_is_told_as_such(project, capsys, old, new, says):
    edit(project, old, new)
    assert main(["check", str(project)]) == 2
    err = capsys.readouterr().err
    assert says in err and err.startswith("error: project.toml: ")
