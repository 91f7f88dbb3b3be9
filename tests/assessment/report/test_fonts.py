"""No PDF hangs on the machine's fonts: they come with the program."""

import os
import re
import shutil
import subprocess
import sys
from importlib.resources import files

import pytest
from matplotlib.figure import Figure

from assessment.report.document import FACES
from assessment.report.figures.drawing import save_svg
from assessment.report.printing import FAMILY, faces, file, printable

PRINT = "import sys, weasyprint; weasyprint.HTML(sys.argv[1]).write_pdf(sys.argv[2])"


def figure():
    drawn = Figure(figsize=(3, 2))
    axes = drawn.subplots()
    axes.set(title="α = 0,25 & à", xlabel="a_g [g]")
    axes.text(0.5, 0.5, "8 mm", fontweight="bold")
    return drawn


@pytest.mark.skipif(not printable(), reason="no Pango")
def test_the_pdf_is_the_same_with_other_fonts_on_the_machine(tmp_path):
    """The machine's own fonts, and a folder that holds nothing but a serif of another width."""
    style = (files("templates") / "report.css").read_text(encoding="utf-8").replace(FACES, faces())
    save_svg(figure, tmp_path / "figure.svg")
    words = "Nello stato attuale <b>ζ<sub>E</sub></b> = 0,39 <i>non verificata</i> <code>α = 1·10⁻⁶</code> "
    (tmp_path / "page.html").write_text(
        f"<style>{style}</style><table><tr><td>{words}</td><td>1</td></tr></table>"
        f"<p>{40 * words}</p><figure><img src='figure.svg'></figure>",
        encoding="utf-8",
    )
    (tmp_path / "fonts").mkdir()
    shutil.copy(file((FAMILY, "normal", 400)).with_name("STIXGeneral.ttf"), tmp_path / "fonts")
    (tmp_path / "fonts.conf").write_text(
        '<?xml version="1.0"?><!DOCTYPE fontconfig SYSTEM "urn:fontconfig:fonts.dtd">'
        f"<fontconfig><dir>{tmp_path}/fonts</dir><cachedir>{tmp_path}/cache</cachedir></fontconfig>"
    )
    pages = []
    for name, environment in (("one", {}), ("other", {"FONTCONFIG_FILE": str(tmp_path / "fonts.conf")})):
        made = tmp_path / f"{name}.pdf"
        command = [sys.executable, "-c", PRINT, str(tmp_path / "page.html"), str(made)]
        subprocess.run(command, env=os.environ | environment, check=True)
        pages.append(made.read_bytes())
    assert pages[0] == pages[1]
    assert {name.split(b"+")[1] for name in re.findall(rb"/BaseFont /([\w+-]+)", pages[0])} <= {
        b"Report-Sans", b"Report-Sans-Bold", b"Report-Sans-Italic", b"Report-Mono",
    }  # fmt: skip
