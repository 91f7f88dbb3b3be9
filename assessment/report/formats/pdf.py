"""WeasyPrint, which makes the PDF: it needs Pango, a library of the system that pip does not bring."""

import io
import platform
from contextlib import redirect_stdout
from types import ModuleType

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
