"""Where compiled code is kept, and that it is never out of date, never in the way and never anybody else's."""

import ast
import errno
import os
import re
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
    monkeypatch.setattr(jit._numba.config, "CACHE_DIR", "")
    monkeypatch.setattr(jit.tempfile, "tempdir", str(tmp_path / "temporary"))
    monkeypatch.setattr(jit.sys, "platform", "linux")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    return tmp_path / "home"


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


def double(x: float) -> float:
    return x + x


def test_what_is_not_kept_is_told_once_before_it_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit._numba.core.caching.FunctionCache, "load_overload", lambda *_: None)
    told: list[str] = []
    before_compiling(lambda: told.append("compiling"))
    loop = jit.compiler()(double)
    assert (loop(2.0), loop(2), told) == (4.0, 4, ["compiling"])
