"""What the terminal tells, and the judgement drafted from it (NTC 2018, §10.2), in a file that the engineer edits."""

import codecs
import hashlib
import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path

import numpy as np
from markupsafe import Markup

from assessment.report.chapters.remarks import SCHOOL, agreement, used_as
from assessment.report.chapters.synthesis import lead, of_one_sign, synthesis_grid
from assessment.report.language import Words, check_name, plain_text
from assessment.report.tables import capacities, moves
from assessment.report.tables.dynamic import shaken
from assessment.report.tables.mechanisms import balance
from assessment.report.tables.structure import tensions
from assessment.report.tables.studies import bars
from assessment.results.hand_check import hand_checks
from assessment.results.schema import Results, known, present
from assessment.results.summary import best_of, determined_indices, fits, movement_text, settlement_lines
from assessment.results.table import among_known, compared, reference_of
from assessment.runtime.errors import ProjectError

# of the solutions, relative to the weight: what needs no word
RESIDUALS = {"equilibrium_residual": 1e-6, "cone_violation": 1e-6, "complementarity": 1e-3}
BALANCED = 1e-3  # reactions less loads, relative to the weight
AGREEMENT = 0.01  # of the virtual-work multiplier, as in the paper
ONE_PER_CENT = 0.01  # losses no larger have no sign worth a remark


def draft_judgement(results: Results, words: Words) -> Iterator[Markup]:
    """Yield sentences: acceptability, comparison with simplified assessments, margins, limits, trust in the numbers.

    All that a printed table has of a quantity is compared: no sentence may claim what a table contradicts.
    """
    yield from findings(results, words)
    if results.model.self_weight_stable:
        yield from _trust(results, words)
        yield words("judgement.limits")


def findings(results: Results, words: Words) -> Iterator[Markup]:
    """Yield what was found: the answer, other checks, motions, campaigns, studies, margins, ties.

    Of a structure that does not stand, that it does not.
    """
    yield from lead(results, words)
    if not results.model.self_weight_stable:
        return
    # which interventions of NTC 2018, §8.4, each strengthening amounts to
    for state, found in determined_indices(results).items():
        told = []
        for kind, reached in (found.attained or {}).items():
            if kind != "improvement_school" or used_as(results, SCHOOL):
                key = f"judgement.{'attained' if reached else 'not_attained'}"
                least = found.required_zeta[kind]
                told.append(words(key, kind=words(f"judgement.of_{kind}"), least=least))
        if told:
            zetas = {"zeta": found.zeta_SLV, "before": found.zeta_before}
            yield words("judgement.interventions", state=state, told=Markup("; ").join(told), **zetas)
    # the least ratio of the mechanisms that the engineer chose
    made = [
        (check.zeta_E, given, limit)
        for given in results.mechanisms or []
        for limit, check in given.checks.items()
        if check.zeta_E is not None
    ]
    if made:
        ratio, given, limit = min(made, key=itemgetter(0))
        place = {"mechanism": given.name, "state": given.state, "limit": check_name(limit, words)}
        yield words("judgement.chosen", **place, ratio=ratio)
    # the linear check of the weakest state beside the nonlinear one: the simplified assessment of §10.2
    ratios_of = [(each.ratios, name, direction) for name, direction, each in capacities(results)]
    pair = {"SLV", "SLV linear"}
    both = [(r["SLV"], r["SLV linear"], name, way) for r, name, way in ratios_of if pair <= r.keys()]
    if both:
        full, linear, name, direction = min(both)
        yield words("judgement.linear", state=name, direction=direction, linear=linear, full=full)
    # in which states each record ends in collapse; of one without collapse the largest peak
    entries = [(name, entry) for name, state in results.states.items() for entry in state.history]
    for record in dict.fromkeys(entry.record for _, entry in entries):
        own = [(name, entry) for name, entry in entries if entry.record == record]
        fallen = [name for name, entry in own if entry.collapsed]
        motion = {"record": record, "pga": own[0][1].pga_g}
        if fallen:
            states = ", ".join(f"“{words.state(name)}”" for name in fallen)
            yield words("judgement.history_collapse", **motion, states=states)
        stood = [(entry.peak_displacement_m, name) for name, entry in own if not entry.collapsed]
        if peaks := [(peak, name) for peak, name in stood if peak is not None]:
            peak, name = max(peaks)
            text = "judgement.history_stands" if fallen else "judgement.history_peak"
            yield words(text, **motion, peak=peak, state=name)
    yield from _campaign(results, words)
    yield from worst_scenario(results, words)
    yield from _sensitive(results, words)
    # how far each movement is from the one at which the structure falls, and what is lost on the way
    for where, path in moves(results):
        ultimate, applied = path.ultimate_movement_m, path.applied_movement_m
        if ultimate:
            key = "judgement.margin" if applied <= ultimate * (1.0 + 1e-9) else "judgement.no_margin"
            yield words(key, **where, applied=applied, ultimate=ultimate, share=applied / ultimate)
        if loss := path.local_loss:
            yield words(f"judgement.loses_{'tie' if loss.tie else 'joint'}", **where, at=loss.displacement_m)
    if yielding := [each.tie for where, each in tensions(results) if each.yields and "direction" in where]:
        yield words("judgement.ties_yield", ties=", ".join(dict.fromkeys(yielding)))


def _campaign(results: Results, words: Words) -> Iterator[Markup]:
    """Yield of each movement in full the medians before and after, and its loss beside the static one."""
    found = shaken(results, "campaign")  # shares in their order
    before = {each.state: each.fit.median_g for each in found if each.share == 0.0}
    for settlement, each in {each.state: each for each in found}.items():
        after, loss, was = each.fit.median_g, known(each.loss), before.get(settlement)
        static = getattr(loss, "static", None)
        if not each.share or was is None or after is None or loss.dynamic is None:
            continue
        indistinct, pair = loss.distinguishable is False, (loss.dynamic, static or 0.0)
        # one a gain, both of them more than nothing as they are printed; not where motions do both
        opposed = pair[0] * pair[1] < 0.0 and min(map(abs, pair)) >= ONE_PER_CENT
        opposed = opposed and loss.distinguishable is True and not loss.directions
        kind = "alone" if static is None else "opposed" if opposed else "beside"
        measure = "PGA" if each.by_pga else words.plain("judgement.campaign_sa")
        what = {"settlement": settlement, "share": words.comma(f"{100.0 * each.share:g}"), "measure": measure}
        numbers = {"before": was, "after": after, "dynamic": pair[0], "static": pair[1]}
        yield words(f"judgement.campaign_{kind}", **what, **numbers)
        yield from of_one_sign(settlement, loss, words)
        if indistinct:
            low, high = loss.dynamic_range
            yield words("judgement.campaign_indistinct", settlement=settlement, low=low, high=high)


def worst_scenario(results: Results, words: Words) -> Iterator[Markup]:
    """Yield a sentence that names the worst of the scenarios, where several were set side by side."""
    found = results.scenarios
    if found and (worst := found.worst):
        counts = None if worst.collapses else among_known(found)
        among = words("judgement.worst_among", known=counts[0], total=counts[1]) if counts else ""
        where = {"state": worst.state, "movement": worst.movement_m, "direction": worst.direction}
        what = {"capacity": compared(worst, found.quantity), "limit": found.limit_state, "among": among}
        key = f"judgement.worst_{'collapses' if worst.collapses else found.quantity}"
        sentence = words(key, **where, **what, reference=words.plain(f"value.stated_on_{words.reference}"))
        if not worst.collapses and worst.reduction is not None:
            sentence += Markup(" ") + words("judgement.worst_reduction", reduction=worst.reduction)
        yield sentence


def _sensitive(results: Results, words: Words) -> Iterator[Markup]:
    every, found = bars(results), results.sensitivity
    wide = [(bar.swing_g, bar) for bar in every if bar.swing_g]
    if found and wide:
        _, widest = max(wide, key=itemgetter(0))
        reference = words.plain(f"value.stated_on_{words.reference}")
        what = {"property": words.plain(f"value.{widest.property}"), "reference": reference}
        factors = {"low": widest.low_factor, "high": widest.high_factor}
        ends = {"least": min(widest.capacities()), "most": max(widest.capacities())}
        limit, state = found.limit_state, widest.state
        yield words("judgement.sensitive", limit=limit, state=state, **what, **factors, **ends)
    if without := dict.fromkeys(bar.property for bar in every if bar.swing_g is None):
        names = ", ".join(words.plain(f"value.{name}") for name in without)
        yield words("judgement.sensitive_open", properties=names)


def _trust(results: Results, words: Words) -> Iterator[Markup]:
    residuals = present({name: getattr(results.quality, f"worst_{name}") for name in RESIDUALS})
    shown = {name: words.told(f"worst_{name}", residual) for name, residual in residuals.items()}
    poor = [name for name, residual in residuals.items() if residual > RESIDUALS[name]]
    for name in poor:
        yield words("judgement.poor_certificates", what=words(f"judgement.{name}"), residual=shown[name])
    if len(residuals) == len(RESIDUALS) and not poor:
        yield words("judgement.certificates", **shown)
    convergence = results.convergence
    found_errors = [row.relative_error for row in (*convergence.rows, *(convergence.incremental or ()))]
    errors = [error for error in found_errors if error is not None]
    if not convergence.tolerance:
        yield words("judgement.no_convergence")
    elif errors:
        good = max(errors) <= convergence.tolerance and len(errors) == len(found_errors)
        tolerance = words.comma(f"{100.0 * convergence.tolerance:g}")
        key = f"judgement.{'converged' if good else 'not_converged'}"
        yield words(key, error=max(errors), tolerance=tolerance)
    yield from agreement(results, words)
    checks = [*hand_checks(results)]
    if checks:
        most = max(abs(deviation) for each in checks for deviation in (each.deviation, each.hand_deviation))
        yield words(f"judgement.{'hand_agrees' if most <= AGREEMENT else 'hand_differs'}", deviation=most)
    unbalanced = [row["unbalanced"] for row in balance(results).rows]
    if unbalanced:
        worst = float(np.max(unbalanced))  # NaN if any is
        key = f"judgement.{'balanced' if worst <= BALANCED else 'unbalanced'}"
        yield words(key, unbalanced=worst)
    warnings = all_warnings(results)
    if warnings:
        yield words("judgement.warnings", count=len(warnings))


def all_warnings(results: Results) -> list[str]:
    """Return the warnings of model, run and solves, each once."""
    return list(dict.fromkeys([*results.model.warnings, *results.quality.warnings]))


def told(results: Results) -> str:
    """Return what the terminal tells, in English: findings, model, table of the first page, best movement."""
    words = Words.of("en", reference_of(results))
    lines = [*map(plain_text, findings(results, words)), "", model_summary(results)]
    if grid := synthesis_grid(results, words):
        texts = [[plain_text(cell) for cell in row] for row in (grid.head, *grid.rows)]
        widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
        lines += ["  ".join(map(str.ljust, row, widths)).rstrip() for row in texts]
    identified = results.identification
    if identified and (best := best_of(identified)):  # as the project file has it too
        moved, freedom = "; ".join(map(movement_text, best.movement)), best.degrees_of_freedom
        lines.append(f"best movement: {moved} (χ² {best.chi_squared:.3g}, {freedom} degrees of freedom)")
        if identified.settlements and not fits(best):
            lines.append("  # does not fit the measurements: not to be used")
        lines += [f"  {line}" for ready in identified.settlements for line in settlement_lines(ready)]
    return "\n".join(lines)


def model_summary(results: Results) -> str:
    """Return a summary of the model, a few lines."""
    model = results.model
    ties = f", ties {len(model.ties)}" if model.ties else ""
    stands = "yes" if model.self_weight_stable else "NO"
    return (
        f"{results.title}\n"
        f"  blocks {model.blocks} ({model.movable_blocks} movable), joints {model.joints}, unknowns {model.unknowns}"
        f"{ties}\n  weight {model.weight_kN:.4g} kN; stands under its own weight: {stands}"
    )


NAME = "judgement.md"
MOST_BYTES = 1_000_000  # of the file: five hundred pages
MARK = re.compile(r"<!-- draft ([0-9a-f]{16})")
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
TAGS = dict.fromkeys(("h1", "h2", "h4", "h5", "h6"), "h3") | {"strong": "b", "em": "i"}  # those of the report


@dataclass(frozen=True)
class Judgement:
    """`content` of the file; `edited`: the engineer's own words as HTML, None while it is the draft; warnings."""

    content: bytes
    edited: Markup | None
    warnings: tuple[str, ...] = ()


def judgement(results: Results, words: Words, folder: Path) -> Judgement:
    """Return the judgement to write into `folder` beside the results: the draft, or the file there where it was edited.

    The first line of the file holds a digest of the draft that follows: a text that does not match it was edited. Where
    the draft has changed since, a warning says so. Raises ProjectError for a file that cannot be read as text.
    """
    body = "\n".join(f"- {plain_text(sentence)}" for sentence in draft_judgement(results, words)) + "\n"
    mark = f"<!-- draft {_digest(body)}: {words.plain('judgement.file')} -->\n\n"
    path = folder / NAME
    if path.is_file():
        text = read_judgement(path)
        first, _, rest = text.partition("\n")
        found = MARK.match(first)
        written = rest if found else text
        if written.strip() and not (found and found[1] == _digest(written)):
            changed = not found or found[1] != _digest(body)
            notes = (words.plain("warning.judgement", file=NAME),) if changed else ()
            return Judgement(path.read_bytes(), to_html(written), notes)
    return Judgement((mark + body).encode(), None)


def read_judgement(path: Path) -> str:
    """Return the text of the file: UTF-8, or what editors on Windows write, UTF-16 and the code page of the West.

    Raises ProjectError where it is none of them, or longer than anybody writes.
    """
    if path.stat().st_size > MOST_BYTES:
        raise ProjectError(
            f"{path}: more than {MOST_BYTES} bytes; shorten it, or delete it to have a new draft"
        )
    content = path.read_bytes()
    wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    for encoding in ("utf-16",) if wide else ("utf-8-sig", "cp1252"):
        with suppress(UnicodeDecodeError):
            text = content.decode(encoding)
            if "\0" not in text:
                return "\n".join(text.splitlines()) + "\n"
    raise ProjectError(f"{path}: not readable as text; save it as UTF-8, or delete it to have a new draft")


def refuse_unreadable(folder: Path) -> None:
    """Raise ProjectError, before any analysis, where the file of an output folder is there and cannot be read."""
    if (folder / NAME).is_file():
        read_judgement(folder / NAME)


def to_html(markdown: str) -> Markup:
    """Return paragraphs, headings, lists, **bold** and *italic* text as HTML; everything else is plain text."""
    from markdown_it import MarkdownIt

    parser = MarkdownIt("zero").enable(["heading", "list", "emphasis", "escape", "newline"])
    closed = markdown.rfind("-->") + 3  # beyond, each that begins would be sought to the end of the text
    tokens = parser.parse(COMMENT.sub("", markdown[:closed]) + markdown[closed:])
    for block in tokens:
        for token in (block, *(block.children or ())):
            token.tag = TAGS.get(token.tag, token.tag)
    return Markup(parser.renderer.render(tokens, parser.options, {}).rstrip("\n"))


def _digest(body: str) -> str:
    return hashlib.sha256(body.strip().encode()).hexdigest()[:16]
