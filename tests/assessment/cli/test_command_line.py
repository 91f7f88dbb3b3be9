"""What the command line says: help, suggestions for what is misspelt, the decimal point."""

from __future__ import annotations

import re

import pytest

from assessment.cli import main as cli
from assessment.cli.commands import WRONG_INPUT
from assessment.cli.main import main
from tests.support.block_project import edit


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["chek", "arch"], 'error: assesto chek: no such command; did you mean "check"?'),
        (["rum", "arch"], 'error: assesto rum: no such command; did you mean "run"?'),
        (["--quiet", "reprot"], 'error: assesto reprot: no such command; did you mean "report"?'),
        (["zzz"], 'error: assesto zzz: no such command; valid: "run", "check", "status"'),
        (
            ["run", "arch", "--onyl", "pushover"],
            'assesto run: --onyl: no such option; did you mean "--only"?',
        ),
        (
            ["run", "arch", "--no-reprot"],
            'assesto run: --no-reprot: no such option; did you mean "--no-report"?',
        ),
        (["new", "a", "--tempalte=arch"], '--tempalte: no such option; did you mean "--template"?'),
        (["check", "a", "b"], "assesto check: b: one argument too many; see assesto check --help"),
        (["ru\x1b[31m\nn"], r"error: assesto ru\x1b[31m\nn: no such command"),
        (["run", "arch", "--fr\x1b[31m"], r"assesto run: --fr\x1b[31m: no such option"),
    ],
)
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
