"""The calculation report, as NTC 2018 ch. 10 asks, of results alone: HTML, PDF and Word from one template; tables."""

import base64
import csv
import io
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup
from PIL import ImageOps

from assessment.ntc.tables import farthest
from assessment.report.chapters import grids, judgement, remarks, synthesis
from assessment.report.chapters.judgement import all_warnings
from assessment.report.chapters.remarks import RISK, used_as
from assessment.report.figures.index import pictures
from assessment.report.language import Words, joined, sentence, translated, words_of
from assessment.report.printing import command, faces, load_weasyprint
from assessment.report.tables import TABLES
from assessment.report.tables.dynamic import fragility_model
from assessment.report.viewer import Code, viewer
from assessment.results.hand_check import mechanisms
from assessment.results.schema import Results
from assessment.results.summary import coulomb, limit_states
from assessment.results.table import Table
from assessment.runtime.files import read_picture, template, template_table, write_atomically

CHAPTERS = ("norms", "structure", "movement", "model", "cracks", "capacity", "dynamic", "judgement")
ANNEXES = ("units", "echo", "joints", "quality", "validation", "trace", "attachments")
RUN = ("=", "+", "-", "@", "\t", "\r")  # what a formula begins with in a spreadsheet
FACES = "/* faces */"  # of the style: where the fonts of the PDF are put in


def write_page(results: Results, folder: Path, edited: Markup | None = None) -> None:
    """Write report.html into `folder` from results and folder/figures/*.svg, and nothing else: no date is printed.

    `edited`: the judgement in the engineer's own words, in place of the draft.
    """
    words = words_of(results)
    page = render_html(results, folder / "figures", words, edited, viewer(results, words))
    write_atomically(folder / "report.html", page.encode())


def write_pdf(results: Results, folder: Path, edited: Markup | None = None) -> list[str]:
    """Write report.pdf into `folder` as `write_page` does report.html; return warnings.

    Without WeasyPrint's system libraries nothing is written, and the warning holds the command that installs them.
    """
    words = words_of(results)
    try:
        weasyprint = load_weasyprint()
    except OSError as error:  # a shared library that cannot be loaded
        reason = str(error).partition("\n")[0]
        return [words.plain("warning.no_pdf", reason=reason, command=command())]
    page = render_html(results, folder / "figures", words, edited).replace(FACES, faces())
    write_atomically(folder / "report.pdf", weasyprint.HTML(string=page).write_pdf())
    return []


def write_docx(results: Results, folder: Path, edited: Markup | None = None) -> None:
    """Write report.docx into `folder` as `write_page` does report.html; its figures are the PNG files."""
    from assessment.report.docx import to_docx  # late: only reports need it

    page = render_html(results, folder / "figures", words_of(results), edited)
    write_atomically(folder / "report.docx", to_docx(page, folder))


@cache
def _template() -> jinja2.Template:
    """Return the template of the report, compiled once for page, PDF and Word."""
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(template),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: joined(value) if type(value) in {str, Markup} else value,
    )
    return environment.get_template("report.html.j2")


def render_html(
    results: Results, figures: Path, words: Words, edited: Markup | None = None, interactive: Code | None = None
) -> str:  # fmt: skip
    """Return the report as one self-contained page, with or without the part to step through on the screen."""
    full = results.echo.report.get("annexes") == "full"
    # the figures that are printed, by section: the file is the PNG, the content of the address the SVG; as images apart
    # from the page their ids cannot clash
    drawn: dict[str, list[dict[str, str]]] = {}
    for picture in pictures(results):
        if full or not picture.full:
            what = words(f"caption.{picture.caption}", **picture.fields)
            address = _address((figures / f"{picture.name}.svg").read_bytes(), "svg+xml")
            shown = {"file": f"figures/{picture.name}.png", "caption": what, "address": address}
            drawn.setdefault(picture.section, []).append(shown)
    attached = []  # what each shows is the name of its file, in words
    for number, name in enumerate(results.echo.report.get("attachments", ()), 1):
        file = stored(number, name)
        address = _address((figures.parent / file).read_bytes(), "png" if file.endswith("png") else "jpeg")
        attached.append({"file": file, "caption": Path(name).stem.replace("_", " "), "address": address})
    calculations = list(grids.traces(results, words))
    states = results.states.values()
    there: dict[str, Any] = {
        "dynamic": results.campaign or any(each.history or each.incremental.records for each in states),
        "cracks": any(state.settlement for state in states),
    }
    there |= {"validation": full, "trace": calculations, "attachments": attached}
    return _template().render(
        w=words,
        results=results,
        full=full,
        style=Markup(template("report.css")),
        chapters=[name for name in CHAPTERS if there.get(name, True)],
        annexes=[name for name in ANNEXES if there.get(name, True)],
        attached=attached,
        count={kind: itertools.count(1) for kind in ("figure", "table")},
        viewer=interactive,
        script=Code(template("viewer.js")),
        figures=drawn,
        grids=grids.printed_tables(results, words),
        traces=calculations,
        edited=edited,
        said=Said(results, words),
        translated=translated,
        warnings=[sentence(warning, words) for warning in all_warnings(results)],
        references=references(results),
        risk=used_as(results, RISK),
        contacts=remarks.contacts_of(results),
        software="software_coulomb" if coulomb(results.echo) else "software",
        farthest=farthest(limit_states(results.echo)) or "",
        few=remarks.few_records(results),
        members=remarks.members(results),
    )


@dataclass(frozen=True)
class Said:
    """What the chapters say of the results, by the names of the functions that word it: of sentences, a list."""

    results: Results
    words: Words

    def __getattr__(self, name: str) -> Any:
        """Return what a function of the chapters has of the results. Raises AttributeError for none of that name."""
        for module in (remarks, synthesis, judgement, grids):
            if made := getattr(module, name, None):
                found = made(self.results, self.words)
                return list(found) if isinstance(found, Iterator) else found
        raise AttributeError(name)


def _address(content: bytes, kind: str) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"


def references(results: Results) -> list[str]:
    """Return the standards and the literature that this report rests on, each in full."""
    assessment = results.echo.assessment or {}
    report, full = results.echo.report, results.echo.report.get("annexes") == "full"
    site = assessment.get("site") or {}
    used = {
        "circular_2019": bool(assessment) and assessment.get("circular", 2019) == 2019,
        "circular_2009": assessment.get("circular") == 2009,
        "hazard": "latitude" in site and site["latitude"] is not None,
        "heritage": bool(report.get("protection") or (results.knowledge and results.knowledge.components)),
        "sismabonus": used_as(results, RISK),
        "coulomb": coulomb(results.echo),
        "history": full,
        "campaign": results.campaign is not None and results.campaign.method == "stripes",
        "solver": any(rigid.second_solver for _, _, rigid in mechanisms(results)),
    }
    listed = template_table("references.toml")["reference"]
    return [each["text"] for each in listed if used.get(each.get("when", ""), True)]


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


def _kind(name: str) -> str:
    return "png" if name.lower().endswith(".png") else "jpg"


def write_tables(results: Results, folder: Path) -> None:
    """Write every table that has rows as CSV (comma, point, UTF-8) into the folder, and fragilities as NRML.

    A text that a spreadsheet would take for a formula, names as well as +x, has an apostrophe in front.
    """
    if model := fragility_model(results):
        write_atomically(folder / "fragility.xml", model)
    for each in tables(results):
        if each.rows:
            columns = [[inert(it), *_of_one_kind([row.get(it) for row in each.rows])] for it in each.columns]
            text = io.StringIO()
            csv.writer(text, lineterminator="\n").writerows(zip(*columns, strict=True))
            write_atomically(folder / f"{each.name}.csv", text.getvalue().encode())


def _of_one_kind(column: Sequence[Any]) -> list[Any]:
    """Return cells that no spreadsheet runs, NaN as gaps, whole numbers beside these or fractions as such."""
    known = [None if isinstance(cell, float) and math.isnan(cell) else cell for cell in column]
    kinds = set(map(type, known))
    as_fractions = kinds - {type(None)} <= {int, float} and kinds != {int}
    return [float(cell) if as_fractions and cell is not None else inert(cell) for cell in known]


def inert(cell: Any) -> Any:
    """Return a cell that no spreadsheet runs: texts that begin like a formula get an apostrophe in front."""
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(RUN) else cell


def tables(results: Results) -> list[Table]:
    """List all tables of the results, long ones included."""
    return [made(results) for made in TABLES.values()]
