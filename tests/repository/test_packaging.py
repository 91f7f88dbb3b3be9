"""The wheel works away from the checkout; no file names a machine; the README lists the dependencies there are."""

import os
import re
import shutil
import subprocess
import sys
import tarfile
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
    """Whether the setuptools that pyproject.toml asks for can build without a download."""
    (needed,) = PYPROJECT["build-system"]["requires"]
    try:
        return int(version("setuptools").split(".")[0]) >= int(needed.removeprefix("setuptools>="))
    except PackageNotFoundError:
        return False


def execute(*command: str | Path, cwd: Path, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, *command], cwd=cwd, env=os.environ | COMPILED | environment, capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory) -> tuple[Path, Path]:
    """The sdist of the committed files and those beside them, and a wheel made of that sdist alone."""
    if not backend_is_here():
        pytest.skip(f"needs {PYPROJECT['build-system']['requires'][0]}")
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("needs the checkout's git")
    scratch = tmp_path_factory.mktemp("packaging")
    source = scratch / "source"
    for name in files_of_git("--cached", "--others", "--exclude-standard"):
        if (ROOT / name).is_file():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, source / name)
    (source / "projects" / "tuff_panel" / "output").mkdir()
    (source / "projects" / "tuff_panel" / "output" / "report.html").touch()  # as a run leaves it
    build = (
        f"import sys; from setuptools import build_meta; getattr(build_meta, sys.argv[1])({str(scratch)!r})"
    )
    execute("-c", build, "build_sdist", cwd=source)
    (sdist,) = scratch.glob("*.tar.gz")
    shutil.unpack_archive(sdist, scratch, filter="data")
    execute("-c", build, "build_wheel", cwd=scratch / sdist.name.removesuffix(".tar.gz"))
    return sdist, next(scratch.glob("*.whl"))


@pytest.fixture(scope="module")
def installed(built, tmp_path_factory) -> Path:
    """A folder into which the wheel, of Python alone, is unpacked."""
    target = tmp_path_factory.mktemp("installed")
    shutil.unpack_archive(built[1], target, "zip")
    return target


def files_of_git(*options: str) -> list[str]:
    listed = subprocess.run(["git", "ls-files", "-z", *options], cwd=ROOT, capture_output=True, check=True)
    return [os.fsdecode(name) for name in listed.stdout.split(b"\0") if name]


def test_the_sdist_has_every_committed_file_and_no_output(built):
    with tarfile.open(built[0]) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    committed = {name for name in files_of_git() if not Path(name).parts[0].startswith(".")}
    assert committed - held == set()
    assert not {name for name in held if "output" in Path(name).parts}


def test_every_file_of_the_packages_is_installed(installed):
    """The examples and the documentation within the package."""
    places = {name: name for name in PACKAGES} | {
        "projects": "assessment/examples",
        "docs": "assessment/docs",
    }
    ours = {
        Path(places[top], *rest)
        for top, *rest in (
            Path(name).parts for name in files_of_git("--cached", "--others", "--exclude-standard")
        )
        if top in places and (ROOT / top).joinpath(*rest).is_file()
    }
    theirs = {path.relative_to(installed) for path in installed.rglob("*") if path.is_file()}
    theirs = {path for path in theirs if path.parts[0] in PACKAGES and "__pycache__" not in path.parts}
    assert ours == theirs


def test_the_command_runs_from_the_wheel(installed, tmp_path):
    def assesto(*arguments):
        return execute("-m", "assessment.cli", *arguments, cwd=tmp_path, PYTHONPATH=str(installed))

    assert assesto("--version").split()[-1] == PYPROJECT["project"]["version"]
    assert "tuff_panel" in assesto("new", "--list")
    assesto("new", "block", "--example", "rocking-block")
    assert "stands under its own weight: yes" in assesto("check", "block")
    docs = Path(assesto("--help").rpartition("documentation: ")[2].strip())
    assert docs.is_file() and docs.is_relative_to(installed)


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
    place = re.compile(rb"(?<![\w.*-])/(work|root)/")
    paths = [ROOT / name for name in files_of_git()]
    assert [str(path) for path in paths if path.is_file() and place.search(path.read_bytes())] == []


def test_what_ci_installs_is_pinned_within_the_bounds():
    """`pip list --format=freeze` in the environment gives the lines of constraints.txt."""
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pinned = {
        name.lower(): version
        for name, _, version in (line.partition("==") for line in lines if line[:1] != "#")
    }
    project = PYPROJECT["project"]
    for text in [
        *project["dependencies"],
        *(each for extra in project["optional-dependencies"].values() for each in extra),
    ]:
        name, _, least = text.partition(">=")
        assert least, f"{text}: has no lower bound"
        assert name in pinned, f"{name}: not in constraints.txt"
        assert _numbers(pinned[name]) >= _numbers(least)


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in re.findall(r"\d+", version)[:3])


def dependencies() -> list[str]:
    return [re.split(r"[<>=!~; ]", text)[0] for text in PYPROJECT["project"]["dependencies"]]
