"""Where compiled code is kept, and that it is never out of date, never in the way and never anybody else's."""

from __future__ import annotations

import ast
import errno
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from numba.core.caching import IndexDataCacheFile

from mechanics.kernels import jit
from mechanics.progress import before_compiling
from tests import ROOT

KERNELS = Path(jit.__file__).parent
USER = os.getuid() if hasattr(os, "getuid") else "cache"


def test_the_digest_is_that_of_every_source_that_compiled_code_comes_from() -> None:
    """Compiled functions, and the functions and constants that they use, are in these sources; elsewhere types."""
    compiling = [
        path
        for path in (ROOT / "mechanics").rglob("*.py")
        if re.search(r"@compiled|compiler\(|numba", path.read_text(encoding="utf-8"))
    ]
    assert len(compiling) >= 8
    assert all(path.is_relative_to(KERNELS) for path in compiling) and set(compiling) <= set(jit.SOURCES)
    types = {"Array", "Index", "Mask", "compiles"}  # and what is called beside the loops
    for path in jit.SOURCES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and not str(node.module).startswith("mechanics.kernels"):
                ours = str(node.module).split(".")[0] in {"mechanics", "assessment"}
                assert not ours or {name.name for name in node.names} <= types, path


def test_the_digest_changes_with_any_source(tmp_path: Path) -> None:
    files = tmp_path / "a.py", tmp_path / "b.py"
    for file in files:
        file.write_text("x = 1\n")
    before = jit.digest(files)
    files[1].write_text("x = 2\n")
    assert jit.digest(files) != before
    folder = jit.cache_folder()
    assert folder is not None
    assert folder.name == jit.digest(jit.SOURCES)


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A home, a folder for temporary files and nothing told to numba."""
    for name in ("home", "temporary"):
        (tmp_path / name).mkdir()
    monkeypatch.setattr(jit._config, "CACHE_DIR", "")
    monkeypatch.setattr(jit.tempfile, "tempdir", str(tmp_path / "temporary"))
    monkeypatch.setattr(jit.sys, "platform", "linux")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    return tmp_path / "home"


def test_folders_are_tried_in_their_order(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    beside, temporary = KERNELS / "__pycache__", home.parent / "temporary" / f"assesto-{USER}"
    assert list(jit._folders()) == [beside, home / ".cache" / "assesto", temporary]
    monkeypatch.setenv("XDG_CACHE_HOME", "caches")
    assert list(jit._folders())[1] == home / ".cache" / "assesto", "not below wherever one happens to be"
    monkeypatch.setenv("XDG_CACHE_HOME", str(home / "caches"))
    assert list(jit._folders())[1] == home / "caches" / "assesto"
    monkeypatch.setattr(jit._config, "CACHE_DIR", str(home / "told"))
    assert next(jit._folders()) == home / "told"


def test_a_user_without_a_home_has_a_folder_among_the_temporary_files(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", none)
    temporary = home.parent / "temporary" / f"assesto-{USER}"
    assert list(jit._folders()) == [KERNELS / "__pycache__", temporary]


def test_the_first_folder_that_takes_files_is_taken(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files in the way of folders are what stops root as well as anyone."""
    blocked, free = home / "blocked", home / "free"
    blocked.write_text("")
    monkeypatch.setattr(jit, "_folders", lambda: iter([blocked, free, home / "later"]))
    folder = jit.cache_folder.__wrapped__()
    assert folder.parent == free and folder.is_dir() and not list(folder.iterdir())
    monkeypatch.setattr(jit, "_folders", lambda: iter([blocked]))
    assert jit.cache_folder.__wrapped__() is None


@pytest.mark.skipif(os.name != "posix", reason="temporary files are everybody's")
def test_a_temporary_folder_that_others_can_write_to_is_not_used(home: Path) -> None:
    """Whoever puts a file there would have it run."""
    folder = home.parent / "temporary" / f"assesto-{USER}"
    assert list(jit._folders())[-1] == folder
    assert folder.stat().st_mode & 0o777 == 0o700
    folder.chmod(0o777)
    assert folder not in jit._folders()
    folder.rmdir()
    folder.symlink_to(home)
    assert folder not in jit._folders()


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder in which code compiled from now on is kept."""
    monkeypatch.setattr(jit, "cache_folder", lambda: tmp_path)
    return tmp_path


def doubled() -> Any:
    """A compiled function, as a process of its own would have it, that has doubled a number."""

    def double(x: float) -> float:
        return 2.0 * x

    loop = jit.compiler()(double)
    assert loop(1.5) == 3.0
    return loop


def test_code_is_compiled_once(kept: Path) -> None:
    assert [bool(doubled().stats.cache_hits) for _ in range(2)] == [False, True]
    assert list(kept.rglob("*double*"))


@pytest.mark.parametrize("damaged", ["*.nbi", "*.nbc"])
@pytest.mark.parametrize("content", [b"", b"nonsense"])
def test_damaged_code_is_compiled_again_and_kept(kept: Path, damaged: str, content: bytes) -> None:
    doubled()
    (path,) = kept.rglob(damaged)
    path.write_bytes(content)
    assert [bool(doubled().stats.cache_hits) for _ in range(2)] == [False, True]


def test_a_full_disk_stops_no_analysis(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(IndexDataCacheFile, "save", full)
    doubled()
    assert not [path for path in kept.rglob("*") if path.is_file()]


ONE_LOOP = """
from mechanics.kernels import bed
loop = bed.closures
loop(1.0, 1.0, 1.0)
print(bed.__file__, loop.stats.cache_path, len(loop.stats.cache_hits), sep="\\n")
"""


@pytest.mark.skipif(os.name != "posix", reason="a home is told otherwise elsewhere")
def test_code_is_kept_where_the_package_is_read_only_and_there_is_no_home(tmp_path: Path) -> None:
    """As for the user nobody: without a word of numba's on the terminal, nor a file where it runs."""
    site, temporary, here, blocked = (tmp_path / name for name in ("site", "temporary", "here", "blocked"))
    for folder in (temporary, here):
        folder.mkdir()
    shutil.copytree(ROOT / "mechanics", site / "mechanics", ignore=shutil.ignore_patterns("__pycache__"))
    for path in (site / "mechanics" / "kernels" / "__pycache__", blocked):
        path.write_text("in the way, also of root, who may write to folders that are read-only")
    told = {"PYTHONPATH": str(site), "TMPDIR": str(temporary), "HOME": str(blocked / "home")}
    hits = []
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-W", "default", "-c", ONE_LOOP],
            cwd=here, env=told, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        assert "umba" not in done.stderr
        source, folder, count = done.stdout.splitlines()
        assert Path(source).is_relative_to(site) and Path(folder).is_relative_to(temporary)
        hits.append(int(count))
    assert hits == [0, 1]
    assert not list(here.iterdir())


def double(x: float) -> float:
    return x + x


def test_what_is_not_kept_is_told_once_before_it_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit._FunctionCache, "load_overload", lambda *_: None)
    told: list[str] = []
    before_compiling(lambda: told.append("compiling"))
    loop = jit.compiler()(double)
    assert (loop(2.0), loop(2), told) == (4.0, 4, ["compiling"])
