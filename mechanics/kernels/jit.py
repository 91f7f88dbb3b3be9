"""numba's compiler, with a cache on disk that follows the sources; where none can be written there is none."""

from __future__ import annotations

import os
import stat
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import numba
from llvmlite import ir
from numba.core.types import float64

from mechanics.progress import compiles

SOURCES = sorted(Path(__file__).parent.rglob("*.py"))  # whichever of them compiled code may use
_numba: Any = numba  # its type hints lack what is asked of it here


def compiler(
    *fastmath: str, allocates: bool = True, inline: bool = False
) -> Callable[[Callable[..., Any]], Any]:
    """A decorator that compiles with those liberties in arithmetic, none by default.

    Functions that make no arrays but views (`allocates` is False) do not count references to them: these counts,
    atomic, take half the time of loops over joints. What is called in a loop that is to become vector instructions is
    put in its place (`inline`).

    Compiled code is kept on disk, see cache_folder.
    """

    def compile_(function: Callable[..., Any]) -> Any:
        options = {"error_model": "numpy", "_nrt": allocates, "forceinline": inline}
        loop = _numba.njit(fastmath=set(fastmath), **options)(function)
        if cache_folder() is not None:
            loop._cache = _Cache(function)
        return loop

    return compile_


compiled = compiler("contract", "reassoc")
looped = compiler("contract", "reassoc", allocates=False)
inlined = compiler("contract", "reassoc", allocates=False, inline=True)


class _Locator(_numba.core.caching._CacheLocator):  # type: ignore[misc]
    """Tells numba that code is in cache_folder, wherever the sources are."""

    def __init__(self, function: Callable[..., Any], path: str) -> None:
        self._py_file, self._lineno = path, function.__code__.co_firstlineno

    @classmethod
    def from_function(cls, function: Callable[..., Any], path: str) -> Any:
        return cls(function, path)

    def get_cache_path(self) -> str:
        return str(cache_folder())

    def get_source_stamp(self) -> str:
        return digest([Path(self._py_file)])

    def get_disambiguator(self) -> str:
        return str(self._lineno)


class _Kept(_numba.core.caching.CompileResultCacheImpl):  # type: ignore[misc]
    _locator_classes = (_Locator,)


class _Cache(_numba.core.caching.FunctionCache):  # type: ignore[misc]
    """Code that cannot be read, from a damaged file, is compiled again; code that cannot be written is not kept."""

    _impl_class = _Kept

    def load_overload(self, signature: Any, context: Any) -> Any:
        found = None
        try:
            found = super().load_overload(signature, context)
        except Exception:  # whatever a damaged pickle raises
            with suppress(OSError):
                self.flush()
        if found is None:
            compiles()
        return found

    def save_overload(self, signature: Any, code: Any) -> None:
        with suppress(OSError):
            super().save_overload(signature, code)


@cache
def cache_folder() -> Path | None:
    """Where compiled code is kept: in the first of these folders in which files can be made; None if there is none.

    NUMBA_CACHE_DIR; __pycache__ beside the sources; the user's folder for caches; a folder of the user's own among the
    temporary files. The folder is named after what is in SOURCES: a function's code is out of date, too, when a
    function or a constant that it uses has changed in another file.
    """
    sources = digest(SOURCES)
    return next((folder / sources for folder in _folders() if _takes_files(folder / sources)), None)


def _folders() -> Iterator[Path]:
    if _numba.config.CACHE_DIR:
        yield Path(_numba.config.CACHE_DIR)
    yield Path(__file__).with_name("__pycache__")
    with suppress(RuntimeError):
        yield _users_caches() / "assesto"
    with suppress(OSError):
        folder = Path(tempfile.gettempdir()) / f"assesto-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"
        folder.mkdir(mode=0o700, exist_ok=True)
        if _is_ours_alone(folder):
            yield folder


def _users_caches() -> Path:
    """The user's folder for caches. Raises RuntimeError where the user has no home."""
    if sys.platform == "win32" and "LOCALAPPDATA" in os.environ:
        return Path(os.environ["LOCALAPPDATA"])
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    given = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return given if given.is_absolute() else Path.home() / ".cache"


def _is_ours_alone(folder: Path) -> bool:
    """Whether nobody else can put code there, which would be run: temporary files are everybody's."""
    status = folder.lstat()
    if not hasattr(os, "getuid"):
        return stat.S_ISDIR(status.st_mode)  # Windows: every user's temporary files are their own
    return stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and not status.st_mode & 0o022


def _takes_files(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


@_numba.extending.intrinsic
def larger(typing_context: Any, a: Any, b: Any) -> Any:
    """The larger of two numbers, which both are numbers: unlike `max` it leaves a loop to vector instructions."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number = ir.DoubleType()
        function = builder.module.declare_intrinsic(
            "llvm.maxnum", [number], ir.FunctionType(number, [number, number])
        )
        return builder.call(function, arguments, fastmath=("nnan", "nsz"))

    return float64(float64, float64), generate


def digest(paths: Iterable[Path]) -> str:
    """A short name for what is in files."""
    return sha256(b"\0".join(path.read_bytes() for path in paths)).hexdigest()[:16]
