"""Photographs and survey drawings at the end of the report: small enough to print, upright, without hidden data."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

from PIL import ImageOps

from assessment.runtime.files.atomic_files import write_atomically
from assessment.runtime.files.pictures import read_picture

FOLDER = "attachments"
LONGEST = 1800  # pixels: 200 per inch on the longer side of a page
QUALITY = 85  # of JPEG


def write_attachments(pictures: Sequence[Path], folder: Path) -> None:
    """Write the pictures into `folder`/attachments, turned upright; place and device of a photograph are left out."""
    for number, path in enumerate(pictures, 1):
        buffer = io.BytesIO()
        upright = ImageOps.exif_transpose(read_picture(path))
        upright.thumbnail((LONGEST, LONGEST))
        if (kind := _kind(path.name)) == "jpg":
            upright.convert("RGB").save(buffer, "jpeg", quality=QUALITY)
        else:
            upright.convert("RGBA" if "A" in upright.getbands() else "RGB").save(buffer, "png", optimize=True)
        write_atomically(folder / FOLDER / f"{number:02d}.{kind}", buffer.getvalue())


def stored(number: int, name: str) -> str:
    """Return where in the output folder the picture of that number (from 1) stands."""
    return f"{FOLDER}/{number:02d}.{_kind(name)}"


def caption(name: str) -> str:
    """Return what a picture shows: the name of its file, in words."""
    return Path(name).stem.replace("_", " ")


def _kind(name: str) -> str:
    return "png" if name.lower().endswith(".png") else "jpg"
