"""The wheel works away from the checkout; no file names a machine; the README lists the dependencies there are."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pytest

from mechanics.kernels.jit import cache_folder
from tests import ROOT

PACKAGES = ("assessment", "mechanics", "templates")
COMPILED = {"NUMBA_CACHE_DIR": str(folder.parent)} if (folder := cache_folder()) else {}  # not once more
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def backend_is_here() -> bool:
    """Whether the setuptools that pyproject.toml asks for, and a pip, can build without a download."""
    (needed,) = PYPROJECT["build-system"]["requires"]
    try:
        version("pip")
        return int(version("setuptools").split(".")[0]) >= int(needed.removeprefix("setuptools>="))
    except PackageNotFoundError:
        return False


def execute(*command: str | Path, cwd: Path, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, *command],
        cwd=cwd,
        env=os.environ | COMPILED | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def installed(tmp_path_factory) -> Path:
    """A folder into which a wheel of the checkout is installed, dependencies left out."""
    if not backend_is_here():
        pytest.skip(f"needs pip and {PYPROJECT['build-system']['requires'][0]}")
    scratch = tmp_path_factory.mktemp("packaging")
    source, target = scratch / "source", scratch / "installed"
    source.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    for name in PACKAGES:
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    pip = ("-m", "pip", "--quiet", "--disable-pip-version-check")
    execute(*pip, "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", scratch, source, cwd=scratch)
    (wheel,) = scratch.glob("*.whl")
    execute(*pip, "install", "--no-deps", "--no-compile", "--target", target, wheel, cwd=scratch)
    return target


def test_every_file_of_the_packages_is_installed(installed):
    for package in PACKAGES:
        ours, theirs = (
            {
                path.relative_to(place)
                for path in (place / package).rglob("*")
                if "__pycache__" not in path.parts
            }
            for place in (ROOT, installed)
        )
        assert ours == theirs


def test_templates_load_from_the_wheel(installed, tmp_path):
    code = (
        "import templates, tomllib\n"
        "from importlib.resources import files\n"
        "print(templates.__file__)\n"
        "texts = {f.name: f.read_text('utf-8') for f in files('templates').iterdir() if f.is_file()}\n"
        "[tomllib.loads(text) for name, text in texts.items() if name.endswith('.toml')]\n"
        "print(*(name for name, text in texts.items() if text))\n"
    )
    place, names = execute("-c", code, cwd=tmp_path, PYTHONPATH=str(installed)).splitlines()
    assert Path(place).is_relative_to(installed)
    assert {Path(name).suffix for name in names.split()} >= {".j2", ".css", ".toml"}


def test_the_command_runs_from_the_wheel(installed, tmp_path):
    def assesto(*arguments):
        return execute("-m", "assessment.cli", *arguments, cwd=tmp_path, PYTHONPATH=str(installed))

    assert "run" in assesto("--help")
    assert assesto("--version").split()[-1] == PYPROJECT["project"]["version"]
    assesto("new", "wall", "--template", "wall")
    assert "stands under its own weight: yes" in assesto("check", "wall")


def test_the_benchmark_runs_from_the_wheel(installed, tmp_path):
    wall = execute(
        "-m", "assessment.benchmark.cases.walls", "3", "3", cwd=tmp_path, PYTHONPATH=str(installed)
    )
    assert '"blocks": 10' in wall


def test_help_imports_no_package():
    """What keeps `assesto --help` quick: none of the dependencies, nor the lookup of a version."""
    code = (
        "import sys\nfrom assessment.cli.main import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit:\n    print(*sys.modules)\n"
    )
    imported = set(execute("-c", code, cwd=ROOT).splitlines()[-1].split())
    assert "argparse" in imported
    assert not imported & {"importlib.metadata", *dependencies()}


def test_no_committed_file_names_a_machine():
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("needs the checkout's git")
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True).stdout
    place = re.compile(rb"(?<![\w.*-])/(work|root)/")
    paths = [ROOT / os.fsdecode(name) for name in listed.split(b"\0") if name]
    assert [str(path) for path in paths if path.is_file() and place.search(path.read_bytes())] == []


def test_readme_lists_exactly_the_dependencies():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    section = re.search(r"^## Dependencies$(.*?)^## ", readme, re.MULTILINE | re.DOTALL)
    assert section is not None
    rows = re.findall(r"^\| `([^`]+)` \|", section[1], re.MULTILINE)
    assert sorted(rows) == sorted(dependencies())


def dependencies() -> list[str]:
    return [re.split(r"[<>=!~; ]", text)[0] for text in PYPROJECT["project"]["dependencies"]]
