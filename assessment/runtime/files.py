"""Files that appear whole or not at all, one by one or all of a run; those that come with it; pictures of a user."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import time
import tomllib
import warnings
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assessment.runtime.errors import ProjectError

if TYPE_CHECKING:
    from PIL import Image

SCRATCH = ".assesto-"  # prefix of the folders where files are made before they are put in place
LAST = "results.json"  # of a run: if it is there, all files are
WRITTEN = 1.0  # s, of the only file that is written in a locked folder beside a run: model.svg
MOST_BYTES = 250_000_000  # of a file whose content is digested: more than of any input that is not refused


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Raise every OSError of the block with the name of the file; for a full disk the system gives none."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error


def write_atomically(path: Path, content: bytes) -> None:
    """Write to a temporary file beside `path`, then rename it. Raises OSError that names `path`."""
    temporary = temporary_of(path)
    try:
        with naming(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            temporary.write_bytes(content)
            temporary.replace(path)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def temporary_of(path: Path) -> Path:
    """Return where this process writes what is then renamed to `path`."""
    return path.with_name(f".{path.name}.{os.getpid()}.tmp")


def clear(folder: Path) -> None:
    """Remove unfinished files of runs that were killed; the folder has to be locked."""
    for left in folder.glob(f"{SCRATCH}*"):
        shutil.rmtree(left, ignore_errors=True)
    written = time.time() - WRITTEN
    for left in folder.glob(".*.tmp"):
        with suppress(OSError):  # its process may be at work
            if re.fullmatch(r".+\.\d+\.tmp", left.name) and left.stat().st_mtime <= written:
                left.unlink()


def put_in_place(new: Path, folder: Path, made: Collection[str], gone: Collection[str]) -> None:
    """Put files `made` in `new`, a folder within `folder`, in the place of those `gone`; all names are relative.

    LAST goes first and comes last: after a kill in between there are no results, and the next run writes them. Raises
    ProjectError for a file that cannot be replaced (on Windows one that is open), else OSError; all is then as before.
    """
    for name in made:
        with (new / name).open("rb+") as file:
            os.fsync(file.fileno())
    old = [name for name in {*gone, *made} if (folder / name).exists()]
    moves = [(folder / name, new / ".old" / name) for name in sorted(old, key=LAST.__ne__)]
    moves += [(new / name, folder / name) for name in sorted(made, key=LAST.__eq__)]
    done: list[tuple[Path, Path]] = []
    try:
        for source, target in moves:
            target.parent.mkdir(parents=True, exist_ok=True)
            source.replace(target)
            done.append((source, target))
    except BaseException as error:  # Ctrl-C too: all goes back
        for source, target in reversed(done):
            target.replace(source)
        if isinstance(error, PermissionError):
            raise ProjectError(
                f"{error.filename}: cannot be replaced ({error.strerror}); close it where it is open and run again: "
                "nothing of the earlier result was changed, finished analyses are kept"
            ) from error
        raise


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file (hexadecimal); of one larger than MOST_BYTES that of its size and date."""
    with path.open("rb") as file:
        status = os.fstat(file.fileno())
        if status.st_size > MOST_BYTES:
            return hashlib.sha256(f"{status.st_size} {status.st_mtime_ns}".encode()).hexdigest()
        return hashlib.file_digest(file, "sha256").hexdigest()


def template(name: str) -> str:
    """Return the text of a file of `templates`."""
    return (files("templates") / name).read_text(encoding="utf-8")


def template_table(name: str) -> dict[str, Any]:
    """Return the content of a TOML file of `templates`."""
    return tomllib.loads(template(name))


SUFFIXES = (".png", ".jpg", ".jpeg")


def read_picture(path: Path) -> Image.Image:
    """Return a whole PNG or JPEG. Raises ValueError that says why it is none.

    Pillow by itself guesses the format, runs Ghostscript on PostScript, and takes truncated pictures beside WeasyPrint.
    """
    from PIL import Image, ImageFile, UnidentifiedImageError

    before = ImageFile.LOAD_TRUNCATED_IMAGES
    ImageFile.LOAD_TRUNCATED_IMAGES = False
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # from twice its size an error
            with Image.open(path, formats=("PNG", "JPEG")) as picture:
                picture.load()
                return picture
    except UnidentifiedImageError:
        raise ValueError("its content is neither PNG nor JPEG") from None
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise ValueError(str(error)) from None
    finally:
        ImageFile.LOAD_TRUNCATED_IMAGES = before
