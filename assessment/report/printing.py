"""What prints the report: DejaVu, as matplotlib ships it; WeasyPrint, which needs Pango, which pip does not bring."""

import io
import platform
from contextlib import redirect_stdout
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


def faces() -> str:
    """Return the @font-face rules of all faces with the addresses of their files."""
    return "".join(
        f'@font-face{{font-family:"{face[0]}";font-style:{face[1]};font-weight:{face[2]};'
        f'src:url("{file(face).as_uri()}") format("truetype")}}'
        for face in FACES
    )


def file(face: Face) -> Path:
    """Return the file of a face."""
    import matplotlib as mpl

    return Path(mpl.get_data_path()) / "fonts" / "ttf" / f"{FACES[face]}.ttf"


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
