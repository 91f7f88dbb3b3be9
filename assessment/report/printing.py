"""What prints the report: its fonts, and WeasyPrint, which needs Pango, a library that pip does not bring.

The fonts are DejaVu as matplotlib ships it, so that no layout hangs on the fonts of a machine. The PDF takes the files;
the page and each figure carry the letters that they use.
"""

import base64
import html
import io
import platform
import re
from contextlib import redirect_stdout
from functools import cache
from pathlib import Path
from types import ModuleType

FAMILY, MONOSPACE = "Report Sans", "Report Mono"
FACES = {  # family, style and weight of a face: file of matplotlib
    (FAMILY, "normal", 400): "DejaVuSans",
    (FAMILY, "normal", 700): "DejaVuSans-Bold",
    (FAMILY, "italic", 400): "DejaVuSans-Oblique",
    (FAMILY, "italic", 700): "DejaVuSans-BoldOblique",
    (MONOSPACE, "normal", 400): "DejaVuSansMono",
}
Face = tuple[str, str, int]
USUAL = "".join(map(chr, [*range(0x20, 0x180), *range(0x370, 0x400), *range(0x2000, 0x2300), 0x25B6, 0x275A]))
"""Letters of most reports: a first subset, from which further ones are made fast."""


def file_faces() -> str:
    """Return the @font-face rules of all faces with the addresses of their files."""
    return "".join(_rule(face, file(face).as_uri(), "truetype") for face in FACES)


def embedded_faces(letters: str, *faces: Face) -> str:
    """Return the @font-face rules of some faces, default all, with the glyphs of some letters as data addresses."""
    return "".join(_embedded(face, "".join(sorted(set(letters)))) for face in faces or FACES)


def with_fonts(svg: str) -> str:
    """Return a figure as matplotlib writes it, in DejaVu Sans, with the faces and glyphs that its texts use."""
    letters = html.unescape("".join(re.findall(r">([^<>\n]+)</t", svg)))
    faces: list[Face] = [(FAMILY, "normal", 400)]
    faces += [(FAMILY, "italic", 400)] * ("font-style: oblique" in svg or "font-style: italic" in svg)
    faces += [(FAMILY, "normal", 700)] * bool(re.search(r"font-weight: (bold|700)|font: (bold|700)", svg))
    named = svg.replace("DejaVu Sans", FAMILY)
    return named.replace(
        '<style type="text/css">', f'<style type="text/css">{embedded_faces(letters, *faces)}', 1
    )


def file(face: Face) -> Path:
    """Return the file of a face."""
    import matplotlib as mpl

    return Path(mpl.get_data_path()) / "fonts" / "ttf" / f"{FACES[face]}.ttf"


@cache
def _embedded(face: Face, letters: str) -> str:
    small = {*letters} <= {*USUAL}
    data = _subset(_usual(face) if small else file(face).read_bytes(), letters, "woff")
    return _rule(face, f"data:font/woff;base64,{base64.b64encode(data).decode()}", "woff")


@cache
def _usual(face: Face) -> bytes:
    return _subset(file(face).read_bytes(), USUAL, None)


def _subset(font: bytes, letters: str, flavour: str | None) -> bytes:
    """Return a font with some of its glyphs; the same bytes for the same letters."""
    from fontTools import subset  # late: only what is looked at on a screen carries fonts

    options = subset.Options(flavor=flavour, hinting=False, notdef_outline=True, recalc_timestamp=False)
    options.drop_tables += ["FFTM", "GDEF", "GPOS", "GSUB"]
    loaded = subset.load_font(io.BytesIO(font), options)
    subsetter = subset.Subsetter(options)
    subsetter.populate(text=letters)
    subsetter.subset(loaded)
    made = io.BytesIO()
    subset.save_font(loaded, made, options)
    return made.getvalue()


def _rule(face: Face, address: str, kind: str) -> str:
    family, style, weight = face
    return (
        f'@font-face{{font-family:"{family}";font-style:{style};font-weight:{weight};'
        f'src:url("{address}") format("{kind}")}}'
    )


APT_COMMAND = "sudo apt-get install libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0 fonts-dejavu-core"
COMMANDS = {  # that install Pango, by system
    "Windows": "pacman -S mingw-w64-ucrt-x86_64-pango (in MSYS2, from msys2.org)",
    "Darwin": "brew install pango",
}


def load_weasyprint() -> ModuleType:
    """Import WeasyPrint; OSError that names the library which it does not find (it also prints that: in vain)."""
    with redirect_stdout(io.StringIO()):
        import weasyprint
    return weasyprint


def printable() -> bool:
    """Return whether a PDF can be made here."""
    try:
        load_weasyprint()
    except OSError:
        return False
    return True


def command() -> str:
    """Return what installs the libraries on this system."""
    return COMMANDS.get(platform.system(), APT_COMMAND)
