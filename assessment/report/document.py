"""The calculation report, as NTC 2018 ch. 10 asks: one template to HTML and PDF, from results alone."""

from __future__ import annotations

import base64
import tomllib
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from assessment.report.chapters.calculation_annex import traces
from assessment.report.chapters.curve_remarks import fitted_above, onsets
from assessment.report.chapters.grid import summary_grids
from assessment.report.chapters.identification import identification_sentences, ready_lines
from assessment.report.chapters.joints import assumptions, pressure_sentences
from assessment.report.chapters.judgement import all_warnings, draft_judgement, worst_scenario
from assessment.report.chapters.overlaps import overlap_sentences
from assessment.report.chapters.printed_tables import macro_block_grids, printed_tables
from assessment.report.chapters.remarks import (
    contacts_of,
    crack_sentences,
    damping_sentence,
    displacement_limits,
    farthest_limit_state,
    few_records,
    headlines,
    index_sentences,
    members,
    missing_pushovers,
    too_many,
)
from assessment.report.chapters.second_solver import comparison
from assessment.report.chapters.ties import (
    nearly_yielding,
    pretension_sentence,
    strengthening_sentences,
    yielding_sentence,
)
from assessment.report.figures.index import pictures
from assessment.report.formats.attachments import caption, stored
from assessment.report.formats.pdf import command, load_weasyprint
from assessment.report.formats.viewer import Viewer, viewer
from assessment.report.tables.structure.loads import vertical_sentences
from assessment.report.text.fonts import embedded_faces, file_faces
from assessment.report.text.language import Words, joined, words_of
from assessment.report.text.messages import sentence, translated
from assessment.results.echo import coulomb
from assessment.results.schema import Results
from assessment.runtime.files.atomic_files import write_atomically

CHAPTERS = (
    "units",
    "analysis",
    "software",
    "model",
    "settlements",
    "pushdown",
    "mechanisms",
    "pushover",
    "action",
    "capacity",
    "comparison",
    "convergence",
    "quality",
    "hand_check",
    "judgement",
    "references",
)
DYNAMIC = ("history", "incremental")  # chapters before the comparison, where the project has their stages
STUDIES = ("scenarios", "sensitivity")  # likewise
CAMPAIGN = "campaign"  # likewise, behind them
FACES = "/* faces */"  # of the style: where the fonts of the page, or of the PDF, are put in
IDENTIFICATION = "identification"  # before the settlements, likewise


def write_page(results: Results, folder: Path, edited: Markup | None = None) -> None:
    """Write report.html into `folder` from results and the SVG files in folder/figures.

    `edited`: the judgement in the engineer's own words, in place of the draft. The file depends on nothing but the
    arguments: no date is printed.
    """
    words = words_of(results)
    page = render_html(results, folder / "figures", words, edited, viewer(results, words))
    write_atomically(folder / "report.html", page.replace(FACES, embedded_faces(page)).encode())


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
    page = render_html(results, folder / "figures", words, edited)
    write_atomically(
        folder / "report.pdf", weasyprint.HTML(string=page.replace(FACES, file_faces())).write_pdf()
    )
    return []


def write_docx(results: Results, folder: Path, edited: Markup | None = None) -> None:
    """Write report.docx into `folder` as `write_page` does report.html; its figures are the PNG files."""
    from assessment.report.formats.docx import to_docx  # late: only reports need it

    page = render_html(results, folder / "figures", words_of(results), edited)
    write_atomically(folder / "report.docx", to_docx(page, folder))


def render_html(
    results: Results,
    figures: Path,
    words: Words,
    edited: Markup | None = None,
    interactive: Viewer | None = None,
) -> str:
    """Return the report as one self-contained page, with or without the part to step through on the screen."""
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(lambda name: (files("templates") / name).read_text(encoding="utf-8")),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: joined(value) if type(value) in {str, Markup} else value,
    )
    environment.filters["unit_kept"] = _unit_kept
    attached = _attached(results, figures.parent)
    annexes = [
        "echo",
        *(["trace"] if any(traces(results, words)) else []),
        *(["attachments"] if attached else []),
    ]
    return environment.get_template("report.html.j2").render(
        w=words,
        results=results,
        style=Markup((files("templates") / "report.css").read_text(encoding="utf-8")),
        chapters=_chapters(results),
        annexes=annexes,
        attached=attached,
        count=Counter(),
        viewer=interactive,
        figures=_embedded(results, figures, words),
        grids=printed_tables(results, words),
        summaries=list(summary_grids(results, words)),
        traces=list(traces(results, words)),
        contacts=contacts_of(results),
        assumptions=list(assumptions(results, words, contacts_of(results))),
        software="software_coulomb" if coulomb(results.echo) else "software",
        references=references(),
        identified=list(identification_sentences(results, words)),
        ready=ready_lines(results, words),
        pressures=pressure_sentences(results, words),
        cracks=list(crack_sentences(results, words)),
        damping=damping_sentence(results, words),
        **_conditional(results, words),
        judgement=draft_judgement(results, words),
        farthest=farthest_limit_state(results),
        worst=list(worst_scenario(results, words)),
        edited=edited,
        macro_blocks=list(macro_block_grids(results, words)),
        too_many=list(too_many(results, words)),
        warnings=[sentence(warning, words) for warning in all_warnings(results)],
        limits=list(displacement_limits(results, words)),
        fitted=list(fitted_above(results, words)),
        second_solver=list(comparison(results, words)),
        overlaps=list(overlap_sentences(results, words)),
        vertical=list(vertical_sentences(results, words)),
        refused=_refused(results, words),
    )


def _conditional(results: Results, words: Words) -> dict[str, Any]:
    """Return what chapters have where the results call for it."""
    return {
        "headlines": list(headlines(results, words)),
        "indices": list(index_sentences(results, words)),
        "missing": list(missing_pushovers(results, words)),
        "onsets": list(onsets(results, words)),
        "few": few_records(results),
        "members": members(results),
        "strengthened": list(strengthening_sentences(results, words)),
        "yielding": [*yielding_sentence(results, words), *nearly_yielding(results, words)],
        "slackened": list(pretension_sentence(results, words)),
    }


def _refused(results: Results, words: Words) -> list[dict[str, str]]:
    """Return name and reason of each mechanism of the user's that is refused."""
    return [
        {"name": given.name, "reason": translated(given.refused, words)}
        for given in results.mechanisms or []
        if given.refused
    ]


def _chapters(results: Results) -> list[str]:
    """Return the chapters of the report: those of studies and dynamic stages only where the project has them."""
    states = results.states.values()
    there = {
        "scenarios": results.scenarios is not None,
        "sensitivity": results.sensitivity is not None,
        "history": any(state.history for state in states),
        "incremental": any(state.incremental.records is not None for state in states),
        CAMPAIGN: results.campaign is not None,
    }
    asked = [name for name in (*STUDIES, *DYNAMIC, CAMPAIGN) if there[name]]
    place, first = CHAPTERS.index("comparison"), CHAPTERS.index("settlements")
    identified = [IDENTIFICATION] if results.identification else []
    return [*CHAPTERS[:first], *identified, *CHAPTERS[first:place], *asked, *CHAPTERS[place:]]


def _unit_kept(head: Markup) -> Markup:
    """Keep the unit of a heading on one line: [kN/m³] would break at the slash."""
    return head.replace("[", Markup("<span class='unit'>[")).replace("]", Markup("]</span>"))


class Counter:
    """Numbers of figures and tables, in the order in which they are printed."""

    def __init__(self) -> None:
        self._last: dict[str, int] = {}

    def next(self, kind: str) -> int:
        """Return 1, 2, 3… for each kind."""
        self._last[kind] = self._last.get(kind, 0) + 1
        return self._last[kind]


@dataclass(frozen=True)
class Embedded:
    """A picture of the page: its `file` in the output folder, its caption, and its content as a data address.

    Of a figure the file is the PNG, the content the SVG; as images apart from the page their ids cannot clash.
    """

    file: str
    caption: str
    address: str


def _embedded(results: Results, folder: Path, words: Words) -> dict[str, list[Embedded]]:
    """Return the figures by chapter, cracks apart."""
    found: dict[str, list[Embedded]] = {
        section: [] for section in (*CHAPTERS, *STUDIES, *DYNAMIC, CAMPAIGN, IDENTIFICATION, "cracks")
    }
    for picture in pictures(results):
        svg = base64.b64encode((folder / f"{picture.name}.svg").read_bytes()).decode()
        what = words(f"caption.{picture.caption}", **picture.fields)
        found[picture.section].append(
            Embedded(f"figures/{picture.name}.png", what, f"data:image/svg+xml;base64,{svg}")
        )
    return found


def _attached(results: Results, folder: Path) -> list[Embedded]:
    """Return the pictures that the project attaches."""
    found = []
    for number, name in enumerate(results.echo.report.attachments, 1):
        file = stored(number, name)
        kind = "png" if file.endswith("png") else "jpeg"
        content = base64.b64encode((folder / file).read_bytes()).decode()
        found.append(Embedded(file, caption(name), f"data:image/{kind};base64,{content}"))
    return found


def references() -> list[str]:
    """Return the standards and the literature that the report rests on, each in full."""
    text = (files("templates") / "references.toml").read_text(encoding="utf-8")
    return list(tomllib.loads(text)["references"])
