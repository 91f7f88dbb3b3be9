"""Pictures that a user attaches: read as PNG or JPEG, whatever else their content may say."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from PIL import Image

SUFFIXES = (".png", ".jpg", ".jpeg")


def read_picture(path: Path) -> Image.Image:
    """Return a picture, whole.

    By itself Pillow guesses a format from the content, and runs Ghostscript on PostScript that is called photo.png; and
    once WeasyPrint is imported it takes truncated pictures. Raises ValueError, saying why, for what is no whole picture
    of these formats.
    """
    from PIL import Image, ImageFile, UnidentifiedImageError

    before = ImageFile.LOAD_TRUNCATED_IMAGES
    ImageFile.LOAD_TRUNCATED_IMAGES = False
    try:
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore", Image.DecompressionBombWarning
            )  # an error from twice that size on
            with Image.open(path, formats=("PNG", "JPEG")) as picture:
                picture.load()
                return picture
    except UnidentifiedImageError:
        raise ValueError("its content is neither PNG nor JPEG") from None
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise ValueError(str(error)) from None
    finally:
        ImageFile.LOAD_TRUNCATED_IMAGES = before
