"""README and docs against what they are about: schema, command line, dependencies, links; no text is a placeholder."""

import re
import tomllib
from typing import get_args

import pytest

from assessment.analyses.found import MOST_HALVINGS, PRESETS
from assessment.benchmark.command import BENCHMARKS
from assessment.cli import commands
from assessment.cli import main as arguments
from assessment.project.catalogue import NAMES
from assessment.project.schema import MotionTable
from assessment.report.printing import APT_COMMAND, COMMANDS
from tests import ROOT

FILES = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]
PAGES = {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in FILES}
RUN = "docs/howto/run.md"


def rows(heading: str, page: str = "README.md") -> list[list[str]]:
    """The cells of the table of a page whose heading begins so."""
    lines = iter(PAGES[page].splitlines())
    next(line for line in lines if line.startswith(f"| {heading}"))
    next(lines)
    found = []
    for line in lines:
        if not line.startswith("|"):
            return found
        found.append([cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]])
    return found


def parsers() -> dict[str, set[str]]:
    """The commands and their options."""
    usages = {
        name: arguments.options_of([name, *["x"] * (name not in {"schema"})]) for name in arguments.COMMANDS
    }
    return {
        name: set(re.findall(r"--[a-z-]+", found.parser.format_usage())) for name, found in usages.items()
    }


def test_the_commands_and_the_options_that_are_named_exist():
    listed = {re.search(r"assesto (\w+)", cells[0])[1]: cells for cells in rows("command | does", RUN)}
    found = parsers()
    assert listed.keys() == found.keys()
    for name, cells in listed.items():
        assert set(re.findall(r"--[a-z-]+", " ".join(cells))) <= found[name]


def test_the_templates_and_benchmarks_that_are_named_exist():
    new, *_ = [cells[1] for cells in rows("command | does", RUN) if cells[0].startswith("`assesto new")]
    assert re.findall(r"`([a-z-]+)`", new)[:12] == [*NAMES]


def test_what_installs_pango_is_what_the_warning_says():
    told = {"Debian, Ubuntu": APT_COMMAND, "Windows": COMMANDS["Windows"], "macOS": COMMANDS["Darwin"]}
    for system, text in rows("system"):
        assert f"`{told.pop(system).partition(' (')[0]}`" in text
    assert not told


def test_the_exit_codes_are_those_of_the_command_line():
    codes = [int(cells[0]) for cells in rows("code | meaning", RUN)]
    assert codes == [commands.DONE, commands.WRONG_INPUT, commands.INCOMPLETE]


def test_the_dependencies_are_those_of_the_package():
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    names = {re.match(r"[\w-]+", text)[0] for text in declared}
    assert {cells[0].strip("`") for cells in rows("package | for")} == names


def test_the_accuracies_are_those_of_the_program():
    written = {cells[0]: cells[1:] for cells in rows("value | tolerance", "docs/accuracy.md")}
    assert written.pop("a number") == ["that", str(MOST_HALVINGS)]
    assert written.keys() == {f'`"{name}"`' for name in PRESETS}
    for name, accuracy in PRESETS.items():
        tolerance, halvings = written[f'`"{name}"`']
        if accuracy.tolerance is None:
            assert tolerance.startswith("none")
        else:
            assert (tolerance, halvings) == (
                f"{accuracy.tolerance:.0%}".replace("%", " %"),
                str(accuracy.halvings),
            )


def test_the_integrators_and_benchmarks_that_are_told_are_all():
    integrators = [re.sub(r'[`"]', "", cells[0]) for cells in rows("`integrator`", "docs/theory.md")]
    assert sorted(integrators) == sorted(get_args(MotionTable.model_fields["integrator"].annotation))
    named = [
        name
        for cells in rows("NAME | what", "docs/benchmarks.md")
        for name in re.findall(r"`(\w+)`", cells[0])
    ]
    assert sorted(named) == sorted(BENCHMARKS)


def anchors(page: str) -> set[str]:
    """What the headings of a page are called in links."""
    headings = re.findall(
        r"^#+ (.+)$", re.sub(r"^```.*?^```", "", page, flags=re.MULTILINE | re.DOTALL), re.MULTILINE
    )
    return {re.sub(r"[^\w -]", "", heading).lower().replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("name", PAGES)
def test_links_lead_somewhere(name):
    folder = (ROOT / name).parent
    for target in re.findall(r"\]\((?!https?:)([^)\s]+)\)", PAGES[name]):
        file, _, anchor = target.partition("#")
        assert not file or (folder / file).exists(), target
        if anchor:
            page = (folder / file).resolve().relative_to(ROOT).as_posix() if file else name
            assert anchor in anchors(PAGES[page]), target


def test_no_placeholder_is_left_in_the_sources():
    """The docstring of demand_spectra said "XX" in the place of what its argument is."""
    for folder in ("assessment", "mechanics", "templates"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in {".py", ".toml", ".j2", ".js", ".css"}:
                text = path.read_text(encoding="utf-8")
                assert not re.search(r"\b(XX+|TODO|FIXME|TBD)\b", text), path
