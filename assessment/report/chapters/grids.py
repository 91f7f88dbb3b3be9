"""The tables that the report prints, as cells of text in its language and units; the annex of calculations."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from markupsafe import Markup

from assessment.report import language
from assessment.report.chapters.remarks import worked_by_hand
from assessment.report.tables import TABLES, dynamic, mechanisms, structure, studies, without
from assessment.report.tables import capacity as checked
from assessment.report.tables.structure import reported_cracks, survey_table
from assessment.results import hand_check
from assessment.results.schema import QUANTITIES, Line, Results, present
from assessment.results.summary import index_limit, index_of, least_row, printed, undetermined
from assessment.results.table import Row, Table, cells
from assessment.runtime.files import template_table

# tables that the report prints as the CSV files have them
AS_THEY_ARE = """ties settlements tie_tensions knowledge action indices risk interventions all_mechanisms linear_checks
history history_ranges history_energy shaken_ties incremental fragility_measures
static_dynamic convergence history_convergence incremental_convergence quality"""
SIGNIFICANT = {"hand_check": 4, "second_solver": 5}  # digits of tables that show how near two values are
CHECKED = "d_star_m a_star_g T_s pga_g demand_pga_g zeta_E return_period_years verified governing"


@dataclass(frozen=True)
class Grid:
    """A table of the report: headings (HTML) and rows of cells; `text` marks the columns of words."""

    caption: Markup
    head: list[Markup]
    rows: list[list[Markup]]
    text: list[bool]


def grid(
    table: Table, words: language.Words, caption: Markup, significant: int = 3,
    heads: Mapping[str, Markup] = MappingProxyType({}),
) -> Grid:  # fmt: skip
    """Write a table for the report, without the columns that no row has.

    `heads`: headings of columns that are called otherwise in this table.
    """
    columns = [column for column in table.columns if any(column in row for row in table.rows)]
    return Grid(
        caption,
        [heads.get(column) or language.heading(column, words) for column in columns],
        [[language.cell(column, row, words, significant) for column in columns] for row in table.rows],
        [column in QUANTITIES and QUANTITIES[column].words for column in columns],
    )


def printed_tables(results: Results, words: language.Words) -> dict[str, Grid]:
    """Return the tables of the report that have rows, by name."""
    chosen = checked.chosen_mechanisms(results)
    validation = [  # of this version; tests compute every row again
        {name: Markup(text) for name, text in case[words.language].items()}
        | {name: words.comma(case[name]) for name in ("expected", "computed")}
        for case in template_table("validation.toml")["case"]
    ]
    found = [
        Table("validation", validation, ("case", "source", "expected", "computed")),
        # loads have their own table
        without(structure.layers(results), *["vertical_load_kN"] * bool(results.loads)),
        structure.reported_loads(results, words),
        *studies.reported_identification(results),
        reported_cracks(results),
        survey_table(results),
        _mechanisms(results, words),
        structure.tie_demands(results),
        mechanisms.reactions(results),
        mechanisms.balance(results),
        structure.reported_pressures(results),
        _interventions(results),
        replace(chosen, rows=[row for row in chosen.rows if "refused" not in row]),
        _checked(checked.chosen_checks(results), "mechanism state limit_state"),
        *studies.reported_studies(results),
        *dynamic.reported_searches(results),
        mechanisms.hand_check(results),
        without(mechanisms.second_solver(results), "sliding"),
        Table("echo", list(echoed(printed(results.echo), words)), ("table", "setting", "value")),
        ranges_table(studies.static_ranges(results).rows, words),
        *(TABLES[name](results) for name in AS_THEY_ARE.split()),
    ]
    grids = {}
    for table in (each for each in found if each.rows):
        caption = words(f"caption.{table.name}")
        grids[table.name] = grid(table, words, caption, SIGNIFICANT.get(table.name, 3))
    return grids


def check_grids(results: Results, words: language.Words) -> Iterator[Grid]:
    """Yield the checks of each state: every direction and limit state, the vertical component with them."""
    whole = _checked(checked.verification(results), "direction limit_state")
    factor = words.number((results.echo.assessment or {}).get("confidence_factor", 1.0))
    for name, state in results.states.items():
        own = [row for row in whole.rows if row["state"] == name]
        rows: list[Row] = []
        for direction, capacity in state.capacity.items():
            made = [row for row in own if row["direction"] == direction]
            rows += [{key: row[key] for key in whole.columns if key in row} for row in made]
            if lifted := capacity.vertical:
                row: Row = {"direction": direction, "limit_state": words("value.vertical_check")}
                row |= {"a_star_g": lifted.a_0_star_g, "zeta_E": lifted.ratio, "verified": lifted.verified}
                rows.append(row)
        names = dict.fromkeys(language.check_name(row["limit_state"], words) for row in own)
        limits = Markup("; ").join(names)
        missing = dict.fromkeys(row["direction"] for row in own if row["direction"] not in state.capacity)
        open_: Row = {"limit_state": limits, "zeta_E": None, "verified": None}
        rows += [open_ | {"direction": way} for way in missing]
        if rows:
            caption = words("caption.checks", state=name, factor=factor)
            yield grid(replace(whole, rows=rows), words, caption)


def _checked(table: Table, place: str) -> Table:
    """Return checks with capacity and demand at the surface, on rock where a PGA is not known of all."""
    surface = all(row.get("pga_g") is not None for row in table.rows if row.get("a_g_g") is not None)
    columns = [name if surface else name.replace("pga", "a_g") for name in CHECKED.split()]
    there = [name for name in columns if any(row.get(name) is not None for row in table.rows)]
    return replace(table, columns=(*place.split(), *there))


def macro_block_grids(
    results: Results, words: language.Words, most: int = hand_check.BY_HAND
) -> Iterator[Grid]:
    """Yield the macro-blocks of `worked_by_hand`, `most` or fewer, with the sums of the virtual work."""
    for name, direction in worked_by_hand(results):
        figures = hand_check.macro_blocks(results, name, direction)
        if len(figures) <= most:
            table = hand_check.virtual_work_table(figures, hand_check.takers(results, name, direction))
            yield grid(table, words, words("caption.macro_blocks", state=name, direction=direction), 4)


def _mechanisms(results: Results, words: language.Words) -> Table:
    """Return the mechanisms by name, with the multiplier of the first motion beside the largest."""
    table = without(mechanisms.mechanisms(results), "hinges", "sliding_joints", "sliding_residual")
    rows = []
    for row in table.rows:
        where = row["state"], row["direction"]
        named = Markup.escape(mechanisms.mechanism_name(results, *where, words))
        onset = cells(hand_check.rigid_push(results, *where), ["alpha_onset"])
        rows.append(row | {"mechanism": named} | onset)
    return Table("mechanisms", rows, (*table.columns[:2], "mechanism", "alpha_onset", *table.columns[2:]))


def _interventions(results: Results) -> Table:
    """Return all states beside one another, each in its weakest direction and in those whose index is not known."""
    rows: list[Row] = []
    strengthened = any(state.strengthening for state in results.states.values())
    for name in results.states if strengthened else ():
        row: Row = {"state": name}
        if least := least_row(results, name):
            row |= {"direction": least.direction, "alpha_0": least.alpha_0, "d_0_m": least.d_0_m}
            if check := index_of(least, index_limit(results)):
                row |= {"zeta_E": check.zeta_E, "reduction": check.loss, "gain": check.gain}
                row["verified"] = check.verified
            pushed = (found for found in structure.tensions(results) if "direction" in found[0])
            own = (each for where, each in pushed if where["state"] == name)
            if pulled := [(each.greatest_kN, each.tie) for each in own if each.greatest_kN is not None]:
                force, tie = max(pulled)
                limit = structure.tie_strength(results)[tie]
                row |= {"greatest_kN": force, "share_used": force / limit if limit else None}
        ways = [way for way in undetermined(results).get(name, ()) if way != row.get("direction")]
        rows += [present(row), *({"state": name, "direction": way, "zeta_E": None} for way in ways)]
    columns = "state direction zeta_E reduction gain alpha_0 d_0_m greatest_kN share_used verified"
    return Table("compared", rows, tuple(columns.split()))


def ranges_table(found: Iterable[Row], words: language.Words) -> Table:
    """Return the ranges of paths that scatter: a row a quantity, under the contacts or the check that it is of.

    Ratios are left out: they are those of the a_g above them.
    """
    rows = []
    for each in (row for row in found if row["quantity"] != "zeta_E"):
        name, limit = each["quantity"], each.get("limit_state")
        ends = {"used": each["value"], "lowest": each["lowest"], "highest": each["highest"]}
        row: Row = {key: each[key] for key in ("state", "direction", "contacts") if key in each}
        checked_at = f" {language.check_name(limit, words)}" if limit else ""
        row["quantity"] = language.heading(name, words) + checked_at
        rows.append(row | {key: language.written(name, end, words) for key, end in ends.items()})
    columns = ("state", "direction", "contacts", "quantity", "used", "lowest", "highest")
    return Table("static_ranges", rows, columns)


Path = tuple[str, ...]
# keys whose values are words of the program; others are the user's own
CHOICES = {"accuracy", "sliding", "contacts", "model", "spectrum", "method", "record_demand", "language"}
CHOICES |= {"kind", "from_m", "component", "annexes"}
CHOICES |= {"state", "states", "of", "use_category", "directions", "integrator"}
GENERATED = re.compile(r"generate:(\d+)")
LOADS = ("vertical_load_kN", "variable_load_kN")


def echoed(echo: Mapping[str, Any], words: language.Words) -> Iterator[Row]:
    """Yield group, quantity and value of every setting that is not empty; a group is named in its first row."""
    last: Path | None = None
    for path, key, value in _flat(echo):
        if value in ("", []):
            continue
        own = "_".join((*path[:1], key))  # by which a table calls it otherwise
        name = words(f"input.{own}") if own in words.strings["input"] else ""
        yield {
            "table": _group(path, words) if path != last else Markup(""),
            "setting": language.key_name(key, words, name),
            "value": Markup.escape(_value(value, words, key in CHOICES or "hypotheses" in path)),
        }
        last = path


def _flat(value: Mapping[str, Any], path: Path = ()) -> Iterator[tuple[Path, str, Any]]:
    """Yield path of the table, key and value, the tables within after; arrays of tables are numbered from 1.

    Of a layer without loads the keys of loads are left out.
    """
    inner: list[tuple[Path, Mapping[str, Any]]] = []
    unloaded = not any(value.get(key) for key in LOADS)
    for key, item in value.items():
        if unloaded and key in (*LOADS, "load_has_mass"):
            continue
        if isinstance(item, Mapping):
            inner.append(((*path, key), item))
        elif isinstance(item, list) and any(isinstance(entry, Mapping) for entry in item):
            inner += [((*path, key, str(number)), entry) for number, entry in enumerate(item, 1)]
        else:
            yield path, key, item
    for name, item in inner:
        yield from _flat(item, name)


def _group(path: Path, words: language.Words) -> Markup:
    """Name a table: "Verifica, sito"; what the user named stays as it is, behind the kind of thing that it is."""
    first, *rest = path or ("project",)
    name = language.key_name(first, words)
    for before, part in zip((first, *rest), rest, strict=False):
        if part.isdigit() or before == "layers":  # the second cedimento, the layer PIERS
            name += Markup(" ") + Markup.escape(part)
        else:  # "punto di controllo", but SLV
            inner = language.key_name(part, words)
            name += Markup(", ") + (inner[:1].lower() + inner[1:] if inner[1:2].islower() else inner)
    return name


def _value(value: Any, words: language.Words, choice: bool) -> str:
    """Write an input as it was given, in the words and with the decimal mark of the language."""
    if value is None:
        return words.plain("value.none")
    if value == "inf":
        return "∞"
    if isinstance(value, float) or type(value) is int:
        return words.comma(f"{value:.12g}").replace("inf", "∞").replace("-", "−")
    if isinstance(value, list):
        return "; ".join(_value(item, words, choice) for item in value)
    if isinstance(value, str) and choice:
        return words.name("setting", value, language.direction_name(value))
    if isinstance(value, str) and (count := GENERATED.fullmatch(value)):
        return words.plain("value.generate", number=count[1])
    return words.show(value)


BETWEEN_NODES = "D.M. 14/01/2008, Allegato A, eq."  # of the hazard, in full annexes
STEPS = ("symbol", "formula", "inputs", "result", "paragraph")


def traces(results: Results, words: language.Words) -> Iterator[Grid]:
    """Yield the calculation of the governing check, in full annexes of everything: action, curve, checks, indices.

    Lines that a check shares with the seismic action of its limit state are printed there alone.
    """
    full, least, wanted = results.echo.report.get("annexes") == "full", results.summary.governing, []
    if least is not None:
        place = least.state, least.direction
        row = next(row for row in results.summary.rows if (row.state, row.direction) == place)
        wanted = [("", "", f"spectrum {least.limit_state}"), (*place, "capacity")]
        wanted += [(*place, row.checks[least.limit_state].check)]
    action: dict[str, list[Line]] = {}
    for state, direction, part, steps in checked.calculations(results):
        if not full and (state, direction, part) not in wanted:
            continue
        mechanism, _, check = part.rpartition(": ")
        kind, _, limit = check.partition(" ")
        if kind == "spectrum":
            before, action[limit] = [], steps
        else:
            before = action.get(kind, [])
        own = [line for line in steps if line not in before]
        if not full:
            own = [line for line in own if not line.paragraph.startswith(BETWEEN_NODES)]
        rows = [_row(line, words, 6 if full else 4) for line in own]
        if not rows:
            continue
        named = kind in words.strings["calculation"]
        title = words(f"calculation.{kind}", limit=limit) if named else language.check_name(check, words)
        where = filter(None, [mechanism, title, words.at(state, direction)])
        caption = words("caption.trace", title=Markup(", ").join(where))
        yield grid(Table("trace", rows, STEPS), words, caption)


def _row(line: Line, words: language.Words, digits: int) -> Row:
    """Write a line, numbers with so many digits; where it comes from in the language of the report."""
    unit, mark = words.name("unit", line.unit), words.plain("value.decimal_mark")

    def number(value: float) -> str:
        text = words.number(round(value, 12), digits)
        return text.rstrip("0").rstrip(mark) if mark in text and "·" not in text else text

    source = language.translated(line.paragraph, words)
    if source == line.paragraph:  # paragraphs of standards stay as they are
        phrases = (phrase.split(": ") for phrase in source.split("; "))
        source = "; ".join(": ".join(words.name("source", part) for part in phrase) for phrase in phrases)
    source = re.sub(r"\b([A-Za-zα-ω])_(\w+)", r"\1<sub>\2</sub>", str(Markup.escape(source)))
    inputs = (typeset(name, words) + f" = {number(value)}" for name, value in line.inputs.items())
    return {
        "symbol": typeset(line.symbol, words) + (f" [{unit}]" if unit else ""),
        "formula": typeset(line.formula, words) or words("value.datum"),
        "inputs": Markup("; ").join(inputs),
        "result": Markup.escape(number(line.result)),
        "paragraph": Markup(source),
    }


_NAME = re.compile(r"[A-Za-z_]\w*")
_SIGNS = {
    "sqrt": "√", "log": "ln", "pi": "π", "eta": "η", "alpha": "α", "Gamma": "Γ", "gamma": "γ", "psi": "ψ", "xi": "ξ",
    "Sigma": "Σ", "delta": "δ", "zeta": "ζ", "theta": "θ", "lambda": "λ",
}  # fmt: skip
# names whose parts are no subscripts: sums over the weights that move, and an index of D.M. 58/2017
_WHOLE = {
    "Sigma_P": "ΣP", "Sigma_P_delta": "ΣPδ<sub>x</sub>", "Sigma_P_delta_2": "ΣPδ<sub>x</sub>²", "IS_V": "IS-V",
}  # fmt: skip
_SUM = re.compile(r"(Sigma_\w+)(?=\*\*)")
_POWER = re.compile(r"\*\*(?:\(((?:[^()]|\([^()]*\))*)\)|([\w.]+))")


def typeset(formula: str, words: language.Words) -> Markup:
    """Write a symbol or a formula; where the decimal mark is a comma, arguments are parted by a semicolon."""
    text = _SUM.sub(r"(\1)", str(Markup.escape(formula)))  # (Σ…)², beside a sum of squares
    while (raised := _POWER.sub(lambda it: f"<sup>{it[1] or it[2]}</sup>", text)) != text:
        text = raised
    text = re.sub(r"abs\(([^()]*)\)", r"|\1|", text).replace("*", "·").replace("-", "−")
    text = _NAME.sub(lambda it: _symbol(it[0], words), text)
    mark = words.plain("value.decimal_mark")
    return Markup(text if mark == "." else re.sub(r"(\d)\.(\d)", rf"\1{mark}\2", text.replace(", ", "; ")))


def _symbol(name: str, words: language.Words) -> str:
    if name in _WHOLE:
        return _WHOLE[name]
    head, *rest = name.split("_")
    known = words.strings["subscript"]
    parts = [_SIGNS.get(part, known.get(part, part)) for part in rest if part != "star"]
    subscript = f"<sub>{','.join(parts)}</sub>" if parts else ""
    return _SIGNS.get(head, head) + subscript + ("*" if "star" in rest else "")
