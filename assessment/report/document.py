"""The calculation report, as NTC 2018 ch. 10 asks: one template to HTML and PDF, from results alone."""

from __future__ import annotations

import base64
import tomllib
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

import jinja2
from markupsafe import Markup

from assessment.ntc.limit_states import QUOTED
from assessment.report.chapters.calculation_annex import traces
from assessment.report.chapters.joints import assumptions, pressures_told, reported_pressures
from assessment.report.chapters.judgement import all_warnings, draft_judgement, worst_scenario
from assessment.report.chapters.second_solver import reported_second_solver, told
from assessment.report.figures.index import pictures
from assessment.report.formats.attachments import caption, stored
from assessment.report.formats.page_fill import pdf_of
from assessment.report.formats.pdf import command, load_weasyprint
from assessment.report.formats.viewer import Viewer, viewer
from assessment.report.tables import capacity as capacity_tables
from assessment.report.tables import index as tables
from assessment.report.tables.campaign import reported_campaign
from assessment.report.tables.convergence import convergence_tables, reported
from assessment.report.tables.cracks import PRINTED as CRACKS_PRINTED
from assessment.report.tables.cracks import SEEN, reported_cracks
from assessment.report.tables.dynamic import (
    energy,
    histories,
    incremental,
    incremental_states,
    ranges,
    static_dynamic,
)
from assessment.report.tables.indices import index_tables
from assessment.report.tables.loads import reported_loads, vertical, vertical_told
from assessment.report.tables.mechanisms import all_mechanisms
from assessment.report.tables.studies import reported_studies
from assessment.report.text.input_table import echoed
from assessment.report.text.language import Words, direction_name, words_of
from assessment.report.text.messages import sentence, translated
from assessment.report.text.table_format import Grid, grid, ranges_grid, summary_grids
from assessment.results.echo import local_limit, printed
from assessment.results.hand_check import BY_HAND, figures_of, governing_mechanisms, hand_check, mechanisms
from assessment.results.reactions import balance, reactions
from assessment.results.schema import Results
from assessment.results.table import Row, Table, cells, reference_of
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
DYNAMIC = ("history", "incremental")  # chapters before the comparison, where their stages were asked for
STUDIES = ("scenarios", "sensitivity")  # likewise
CAMPAIGN = "campaign"  # likewise, behind them
SIGNIFICANT = {"hand_check": 4, "second_solver": 8}  # digits of tables that show how near two values are
PLACES = 3  # of a displacement in mm: what is less is rounding
ONSET = 0.01  # of α_0: an onset below it by more closes hinges first


def write_page(results: Results, folder: Path, edited: Markup | None = None) -> None:
    """Write report.html into `folder` from results and the SVG files in folder/figures.

    `edited`: the judgement in the engineer's own words, in place of the draft. The file depends on nothing but the
    arguments: no date is printed.
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
    page = render_html(results, folder / "figures", words, edited)
    write_atomically(folder / "report.pdf", pdf_of(page, weasyprint))
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
        grids=_grids(results, words),
        summaries=list(summary_grids(capacity_tables.summary(results), results, words)),
        traces=list(traces(results, words)),
        contacts=_contacts(results),
        assumptions=list(assumptions(results, words, "elastic" in _contacts(results))),
        references=references(),
        pressures=pressures_told(results, words),
        cracks_shown={"seen": words.comma(f"{1000.0 * SEEN:g}"), "printed": CRACKS_PRINTED},
        missing=list(_missing(results, words)),
        onsets=list(_onsets(results, words)),
        judgement=draft_judgement(results, words),
        farthest=_farthest(results),
        worst=list(worst_scenario(results, words)),
        edited=edited,
        macro_blocks=list(_macro_blocks(results, words)),
        too_many=list(_too_many(results, words)),
        warnings=[sentence(warning, words) for warning in all_warnings(results)],
        local=_local_limit(results, words),
        second_solver=list(told(results, words)),
        vertical=list(vertical_told(results, words)),
        refused=[
            {"name": given.name, "reason": translated(given.refused, words)}
            for given in results.mechanisms or []
            if given.refused
        ],
    )


def _chapters(results: Results) -> list[str]:
    """Return the chapters of the report: those of studies and dynamic stages only where they were asked for."""
    states = results.states.values()
    there = {
        "scenarios": results.scenarios is not None,
        "sensitivity": results.sensitivity is not None,
        "history": any(state.history for state in states),
        "incremental": any(state.incremental.records is not None for state in states),
        CAMPAIGN: results.campaign is not None,
    }
    asked = [name for name in (*STUDIES, *DYNAMIC, CAMPAIGN) if there[name]]
    place = CHAPTERS.index("comparison")
    return [*CHAPTERS[:place], *asked, *CHAPTERS[place:]]


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


def _embedded(results: Results, folder: Path, words: Words) -> dict[str, list[dict[str, object]]]:
    """Return PNG file, caption and data address of each figure, by chapter, cracks apart; images' ids cannot clash."""
    found: dict[str, list[dict[str, object]]] = {
        section: [] for section in (*CHAPTERS, *STUDIES, *DYNAMIC, CAMPAIGN, "cracks")
    }
    for picture in pictures(results):
        svg = base64.b64encode((folder / f"{picture.name}.svg").read_bytes()).decode()
        what = words(f"caption.{picture.caption}", **picture.fields)
        address = f"data:image/svg+xml;base64,{svg}"
        file = f"figures/{picture.name}.png"
        found[picture.section].append({"file": file, "caption": what, "address": address})
    return found


def _attached(results: Results, folder: Path) -> list[dict[str, str]]:
    """Return file, caption and data address of each picture that the project attaches."""
    found = []
    for number, name in enumerate(results.echo.report.attachments, 1):
        file = stored(number, name)
        kind = "png" if file.endswith("png") else "jpeg"
        content = base64.b64encode((folder / file).read_bytes()).decode()
        found.append(
            {"file": file, "caption": caption(name), "address": f"data:image/{kind};base64,{content}"}
        )
    return found


def _grids(results: Results, words: Words) -> dict[str, Grid]:
    """Return the tables of the report that have rows, by name."""
    made = [
        _validation(words),
        _without(tables.layers(results), *(["vertical_load_kN"] if results.loads else [])),
        reported_loads(results, words),
        tables.settlements(results),
        reported_cracks(results),
        tables.mechanisms(results),
        reactions(results),
        balance(results),
        reported_pressures(results),
        _without(capacity_tables.verification(results), *capacity_tables.BEHIND),
        capacity_tables.verification_surface(results),
        capacity_tables.action(results),
        *index_tables(results),
        _without(capacity_tables.chosen_mechanisms(results), "refused"),
        capacity_tables.chosen_checks(results),
        all_mechanisms(results),
        capacity_tables.linear_checks(results),
        vertical(results),
        capacity_tables.scalings(results),
        Table("comparison", _compared(results), tables.COMPARISON),
        *reported_studies(results),
        histories(results),
        ranges(results),
        energy(results),
        incremental(results),
        incremental_states(results),
        *reported_campaign(results),
        static_dynamic(results),
        *(reported(table, words) for table in convergence_tables(results)),
        tables.quality(results),
        hand_check(results),
        reported_second_solver(results, words),
        Table("echo", list(echoed(printed(results.echo), words)), ("table", "setting", "value")),
    ]
    found = {
        table.name: grid(
            table,
            words,
            words(f"caption.{table.name}"),
            SIGNIFICANT.get(table.name, 3),
            reference_of(results),
        )
        for table in made
        if table.rows
    }
    scattering = tables.static_ranges(results)
    if scattering.rows:
        found[scattering.name] = ranges_grid(scattering, words, reference_of(results))
    return found


def _validation(words: Words) -> Table:
    """Return the validation table of this version; tests compute every row again."""
    cases = tomllib.loads((files("templates") / "validation.toml").read_text(encoding="utf-8"))["case"]
    rows = [
        {
            **{name: Markup(text) for name, text in case[words.language].items()},
            "expected": words.comma(case["expected"]),
            "computed": words.comma(case["computed"]),
        }
        for case in cases
    ]
    return Table("validation", rows, ("case", "source", "expected", "computed"))


def references() -> list[str]:
    """Return the standards and the literature that the report rests on, each in full."""
    text = (files("templates") / "references.toml").read_text(encoding="utf-8")
    return list(tomllib.loads(text)["references"])


def _without(table: Table, *columns: str) -> Table:
    """Return the table without some columns, and without the rows that have nothing else but what they are called."""
    kept = tuple(column for column in table.columns if column not in columns)
    rows = [{key: value for key, value in row.items() if key in kept} for row in table.rows]
    return Table(table.name, [row for row in rows if len(row) > 2], kept)


def _compared(results: Results) -> list[Row]:
    """Return the comparison without its dynamic columns where no dynamic analysis was made."""
    static_only = all(each.dynamic_pga_g is None for each in results.comparison)
    kept = [key for key in tables.COMPARISON if not (static_only and key.startswith("dynamic"))]
    return [cells(each, kept) for each in results.comparison]


def _macro_blocks(results: Results, words: Words) -> Iterator[Grid]:
    """Yield the macro-blocks of each state's weakest direction, with the sums of the virtual work."""
    for name, direction in governing_mechanisms(results):
        rows = figures_of(results, name, direction)
        if len(rows) - 1 > BY_HAND:
            continue
        caption = words("caption.macro_blocks", state=words.state(name), direction=direction_name(direction))
        columns = tuple(key for key in rows[0] if key not in {"state", "direction"})
        yield grid(Table("macro_blocks", rows, columns), words, caption, 4)


def _too_many(results: Results, words: Words) -> Iterator[Markup]:
    """Yield a sentence for each mechanism of more macro-blocks than a hand works out."""
    for name, direction in governing_mechanisms(results):
        count = len(figures_of(results, name, direction)) - 1
        if count > BY_HAND:
            where = {"state": words.state(name), "direction": direction_name(direction)}
            yield words("text.many_macro_blocks", count=count, **where)


def _local_limit(results: Results, words: Words) -> Markup:
    """Return where the displacement limits come from: shares of d_0, and the local limit where one is given."""
    limit, reason = local_limit(results.echo)
    if limit is None:
        return Markup(" ").join([words("text.limits"), *_losses(results, words)])
    reason = reason or words.plain("value.no_reason")
    return words("text.limits") + Markup(" ") + words("text.local_limit", limit=1000.0 * limit, reason=reason)


def _losses(results: Results, words: Words) -> Iterator[Markup]:
    """Yield where a path loses a joint that bears: the local limit of its direction, where the project gives none."""
    for name, direction, rigid in mechanisms(results):
        if loss := rigid.local_loss:
            yield words(
                "text.local_loss",
                state=words.state(name),
                direction=direction_name(direction),
                first=loss.blocks[0],
                second=loss.blocks[1],
                overlap=1000.0 * loss.overlap_m,
                limit=1000.0 * loss.displacement_m,
            )


def _farthest(results: Results) -> str:
    """Return the farthest limit state that was asked for, of which losses are told; empty where none was."""
    asked = (results.echo.assessment or {}).get("limit_states", [])
    return next((limit for limit in QUOTED if limit in asked), "")


def _contacts(results: Results) -> list[str]:
    """Return the kinds of contact of which there is any curve."""
    found: set[str] = set()
    for state in results.states.values():
        found.update(state.pushdown, *(pushover.by_contacts for pushover in state.pushover.values()))
    return [contacts for contacts in ("rigid", "elastic") if contacts in found]


def _missing(results: Results, words: Words) -> Iterator[Markup]:
    """Yield a sentence for each state without the pushover that another state has."""
    for direction in capacity_tables.directions(results):
        for name, state in results.states.items():
            if direction not in state.pushover:
                yield words(
                    "text.missing_pushover", state=words.state(name), direction=direction_name(direction)
                )


def _onsets(results: Results, words: Words) -> Iterator[Markup]:
    """Yield a sentence for each curve that begins, at `alpha_onset`, by closing hinges of the settlement."""
    for name, direction, rigid in sorted(mechanisms(results), key=lambda each: each[1]):
        if rigid.alpha_onset < (1.0 - ONSET) * rigid.alpha_0:
            alpha = rigid.curve.multiplier
            peak = alpha.index(max(alpha))
            yield words(
                "text.onset",
                state=words.state(name),
                direction=direction_name(direction),
                onset=words.show(rigid.alpha_onset),
                least=words.show(min(alpha[: peak + 1])),
                alpha_0=words.show(rigid.alpha_0),
                place=words.show(round(1000.0 * abs(rigid.curve.displacement_m[peak]), PLACES)),
            )
