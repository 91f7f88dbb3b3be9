"""A campaign: every combination of record and state is run once, the longest first, and the results are summed up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from assessment.analyses.dynamic.ensemble import Scatter, scatter_of
from assessment.analyses.dynamic.incremental import ENOUGH
from assessment.analyses.dynamic.inputs import WORTHWHILE
from assessment.analyses.dynamic.record_set import HIGH, LOW
from assessment.analyses.dynamic.response import Setting
from assessment.analyses.dynamic.time_history import quality_row
from assessment.project.schema import ORIGINAL, MotionTable
from assessment.results.schema.campaign import (
    Campaign,
    CampaignCombination,
    CampaignFragility,
    CampaignLoss,
    SameAs,
)
from assessment.runtime.fingerprint import fingerprint
from assessment.runtime.tasks import From
from assessment.studies.campaign.movements import Moved, moved_states, moved_title
from assessment.studies.campaign.records import RecordSet, record_set
from assessment.studies.campaign.search import (
    Combination,
    Judged,
    Reach,
    level_found,
    run_stripes,
    search_collapse,
)
from assessment.studies.campaign.summary import Observed, Place, fragility, loss
from assessment.studies.variants import Statics, Study, quantity
from mechanics.messages import Message, headed, message
from mechanics.procedures import Mirror

if TYPE_CHECKING:
    from assessment.analyses.checks.demand import Demands
    from assessment.project.motions import BaseMotion
    from assessment.project.project import Project
    from assessment.project.schema import CampaignTable
    from assessment.project.structure.state_models import StateModel
    from assessment.runtime.tasks import Workers
    from mechanics import Assembly

RUNS = 30  # motions of a combination, about


@dataclass(frozen=True, eq=False)
class Asked:
    """A combination: a record of one sign from a state at rest; `ratio`: intensity measure over the PGA of the record.

    `run_sign`: the sign that is run; both signs of a structure that is its own mirror image are one run.
    """

    moved: Moved
    motion: BaseMotion
    sign: int
    ratio: float
    run_sign: int

    @property
    def title(self) -> Message:
        """Name of the combination for messages."""
        return message(
            "{state}, {record}, {sign}",
            state=self.moved.title,
            record=self.motion.name,
            sign="+" if self.sign > 0 else "−",
        )

    @property
    def key(self) -> tuple[str, str, int]:
        """Key of the run; combinations with the same key are one run."""
        start = fingerprint(search_collapse, (self.moved.model, self.moved.start, self.moved.ultimate))
        return start, self.motion.name, self.run_sign

    @property
    def signed(self) -> BaseMotion:
        """The motion that shakes the base."""
        return replace(self.motion, record=self.motion.record.scaled(float(self.run_sign)))


def campaign(
    project: Project,
    models: Mapping[str, StateModel],
    motions: Sequence[BaseMotion],
    statics: Statics,
    demands: Demands,
    workers: Workers,
    study: Study,
) -> Campaign:
    """Run every combination that [campaign] asks for and return the results; `motions`: of the files that it names.

    Combinations that could not be completed are in study.failures, and in the results with their reason. Raises
    KilledError where a process was ended from outside.
    """
    table = project.campaign
    assert table is not None
    records = record_set(project, table, motions, demands, workers)
    reported = {note for motion in motions for note in motion.notes}
    study.warnings += [note for motion in records.motions for note in motion.notes if note not in reported]
    moved = moved_states(project, models, statics, demands, workers, study)
    asked = _combinations(project, models[ORIGINAL].assembly, table, records, moved)
    scatter = scatter_of(project)
    done = _run(project, table, scatter, asked, workers)
    rows = _rows(asked, done, table, study)
    fits, losses = _by_movement(moved, asked, rows, table, scatter.members)
    found = Campaign(
        measure=table.measure,
        period_s=table.period_s,
        method=table.method,
        levels_g=list(table.levels_g or ()),
        tolerance=table.tolerance,
        contacts=table.contacts,
        members=scatter.members,
        static_quantity=quantity(project) if project.pushover else None,
        records=records.rows(table),
        spectrum=records.spectrum,
        combinations=rows,
        computed=len(done),
        failures=list(study.failures),
        fragility=fits,
        loss=losses,
        warnings=list(study.warnings),
    )
    study.findings += [_of_campaign(text) for text in _findings(found)]
    return found


def _combinations(
    project: Project, drawn: Assembly, table: CampaignTable, records: RecordSet, moved: Sequence[Moved]
) -> list[Asked]:
    """Return every state under every record with every sign; a symmetric structure as drawn runs one sign only."""
    mirrored = _mirrored(project, drawn, table)
    return [
        Asked(
            state, motion, sign, ratio, table.signs[0] if mirrored and state.start is drawn.initial else sign
        )
        for state in moved
        for motion, ratio in zip(records.motions, records.ratios, strict=True)
        for sign in table.signs
    ]


def _mirrored(project: Project, model: Assembly, table: CampaignTable) -> bool:
    """Whether the structure as drawn responds to a record and to its negative with mirror images.

    The control point has to be its own mirror image too: its ultimate displacement may decide about collapse.
    """
    mirror = Mirror.of(model, table.contacts)
    point = project.control_point(table.control).point_m
    return mirror is not None and mirror.swaps(point, point)


def _run(
    project: Project,
    table: CampaignTable,
    scatter: Scatter,
    asked: Sequence[Asked],
    workers: Workers,
) -> dict[tuple[str, str, int], Combination]:
    """Run each combination once, the ones with most samples first: no long one begins last.

    A search begins at the level that is found for its neighbour, which comes before it.
    """
    own = MotionTable(**{key: getattr(table, key) for key in MotionTable.model_fields})
    point = project.control_point(table.control)
    distinct: dict[tuple[str, str, int], Asked] = {}
    for each in asked:
        if not isinstance(each.moved.start, str):
            distinct.setdefault(each.key, each)
    order = sorted(distinct, key=lambda key: -distinct[key].motion.record.acceleration.size)
    numbers = {key: number for number, key in enumerate(order)}
    neighbours = {} if table.levels_g else _neighbours(asked, distinct)
    tasks: list[tuple[Any, ...]] = []
    curves = table.curve_members or ()
    for each in (distinct[key] for key in order):
        setting = Setting(own, point, each.moved.ultimate)
        common = (each.moved.model, each.signed, setting, each.moved.start, scatter)
        if table.levels_g:
            tasks.append((*common, tuple(level / each.ratio for level in table.levels_g), curves))
        else:
            neighbour = neighbours.get(each.key)
            near = None if neighbour is None else From(numbers[neighbour], level_found)
            tasks.append((*common, Reach(table.max_scale, table.tolerance), curves, near))
    samples = [distinct[key].motion.record.acceleration.size for key in order]
    found: list[Combination] = workers.each(
        "campaign",
        run_stripes if table.levels_g else search_collapse,
        tasks,
        [distinct[key].title for key in order],
        RUNS * sum(len(distinct[key].moved.model.contacts) * n for key, n in zip(order, samples, strict=True))
        > WORTHWHILE,
        samples,
    )
    return dict(zip(order, found, strict=True))


def _neighbours(
    asked: Sequence[Asked], distinct: Mapping[tuple[str, str, int], Asked]
) -> dict[tuple[str, str, int], tuple[str, str, int]]:
    """Return the keys of searches that begin near another one's level, with the key of that one.

    That of the same record and sign at the share before, or at the first share that of its other sign. It is given by
    what is asked for alone, not by what is finished: levels are the same however they are computed.
    """
    first: dict[str, tuple[str, str, int]] = {}
    before: dict[tuple[str, str, int], tuple[str, str, int]] = {}
    found: dict[tuple[str, str, int], tuple[str, str, int]] = {}
    for each in asked:
        if each.key not in distinct:
            continue
        place = (each.moved.settlement, each.motion.name, each.run_sign)
        neighbour = before.get(place) or first.get(each.motion.name)
        if neighbour is not None and distinct[each.key] is each:
            found[each.key] = neighbour
        before[place] = each.key
        first.setdefault(each.motion.name, each.key)
    return found


def _rows(
    asked: Sequence[Asked],
    done: Mapping[tuple[str, str, int], Combination],
    table: CampaignTable,
    study: Study,
) -> list[CampaignCombination]:
    """Return the row of each combination; if several are one run, the later ones name the first."""
    rows: list[CampaignCombination] = []
    first: dict[tuple[str, str, int], Asked] = {}
    for each in asked:
        if isinstance(each.moved.start, str):
            rows.append(_row(each, Combination(Judged(), each.moved.start), table))
            continue
        origin = first.setdefault(each.key, each)
        result = done[each.key]
        row = _row(each, result, table)
        if origin is not each:
            same = SameAs(settlement=origin.moved.settlement, share=origin.moved.share, sign=origin.sign)
            row = row.replace(same_as=same, runs=0, points=[])
        else:
            study.quality.append(quality_row(each.moved.title, "campaign", result.programs, result.worst))
            study.seconds += result.seconds
            study.failures += [_of_campaign(headed(each.title, text)) for text in result.failures]
        rows.append(row)
    return rows


def _row(each: Asked, result: Combination, table: CampaignTable) -> CampaignCombination:
    judged = result.judged
    row = CampaignCombination(
        record=each.motion.name,
        settlement=each.moved.settlement,
        share=each.moved.share,
        sign=each.sign,
        pga_collapse_g=judged.collapse,
        pga_collapse_range=judged.span,
        pga_safe_g=judged.safe,
        resurrections_g=judged.resurrections,
        runs=result.runs,
        points=result.points,
        reason=result.reason,
    )
    if judged.fallen is not None:
        row = row.replace(collapsed=judged.fallen, all_collapsed=judged.all_fallen)
    if table.period_s:
        span = judged.span
        row = row.replace(
            sa_collapse_g=None if judged.collapse is None else each.ratio * judged.collapse,
            sa_collapse_g_range=span and [None if end is None else each.ratio * end for end in span],
        )
    return row


def _observed(each: Asked, row: CampaignCombination) -> Observed:
    return Observed(
        record=each.motion.name,
        sign=each.sign,
        ratio=each.ratio,
        collapse=row.pga_collapse_g,
        safe=row.pga_safe_g,
        certain=row.pga_collapse_range[1] if row.pga_collapse_range else None,
        fallen=tuple(row.collapsed or ()),
        all_fallen=tuple(row.all_collapsed or ()),
    )


def _by_movement(
    moved: Sequence[Moved],
    asked: Sequence[Asked],
    rows: Sequence[CampaignCombination],
    table: CampaignTable,
    members: int,
) -> tuple[list[CampaignFragility], list[CampaignLoss]]:
    """Return the fragility of each state, and its loss of capacity against the state before the movement."""
    observed = {
        id(state): [
            _observed(each, row) for each, row in zip(asked, rows, strict=True) if each.moved is state
        ]
        for state in moved
    }
    unmoved = {state.settlement: state for state in reversed(moved) if state.share == 0.0}
    fits, losses = [], []
    for state in moved:
        after, base = observed[id(state)], unmoved.get(state.settlement)
        before = observed[id(base)] if base else []
        place = Place(state.settlement, state.share, state.movement)
        fits.append(fragility(place, after, table.levels_g, members))
        static = base.static if base else None
        losses.append(loss(place, before, after, static, state.static, table.levels_g))
    return fits, losses


def _of_campaign(text: Message) -> Message:
    return message("campaign: {text}", text=text)


def _open_ends(row: CampaignFragility) -> list[Message]:
    """Return warnings of a fragility that rests on lower bounds, or has no median."""
    findings = []
    if row.withstood:
        findings.append(
            message(
                "{withstood} of {count} combinations do not collapse up to the largest level tried and count as lower "
                "bounds; raise max_scale, or levels_g, to find their collapse",
                withstood=row.withstood,
                count=row.combinations,
            )
        )
    if row.median_g is None and row.failed < row.combinations:
        findings.append(
            message(
                "no median of collapse is found; some levels have to be withstood, and others not, and more "
                "combinations collapse as levels grow"
            )
        )
    return findings


def _steep(row: CampaignFragility) -> list[Message]:
    """Return a warning where stripes leave the likelihood without a maximum: the steepest distribution counts."""
    if row.median_g is None or row.beta != 0.0:
        return []
    return [
        message(
            "no level with a collapse lies below one that is withstood, and the dispersion cannot be told: β = 0 and "
            "a median acceleration of {median:.3g} g are the limit of ever more likely distributions; "
            "add levels_g about it",
            median=row.median_g,
        )
    ]


def _no_losses(found: Campaign) -> list[Message]:
    """Return why losses are not told."""
    if not any(row.share == 0.0 for row in found.loss):
        return [
            message(
                "no loss of capacity: it is relative to the structure as drawn; add 0.0 to shares to have it"
            )
        ]
    if found.static_quantity is None and any(row.share > 0.0 for row in found.loss):
        return [message("no static loss: it is that of the pushover; add [pushover] to have it")]
    return []


def _findings(found: Campaign) -> list[Message]:
    """Return warnings about the campaign as a whole."""
    findings = []
    records = len(found.records)
    if records < ENOUGH:
        findings.append(
            message(
                "records: {count}; NTC 2018 §7.3.5 asks for at least {least}", count=records, least=ENOUGH
            )
        )
    equal = sum(row.same_as is not None for row in found.combinations)
    if equal:
        findings.append(
            message(
                "{equal} of {count} combinations are the same as another one, or its mirror image, "
                "and were computed once",
                equal=equal,
                count=len(found.combinations),
            )
        )
    for row in found.fragility:
        title = moved_title(row.settlement, row.share)
        if row.failed:
            failed = message(
                "{failed} of {count} combinations could not be completed; "
                "median, dispersion and loss are those of the others",
                failed=row.failed,
                count=row.combinations,
            )
            findings.append(headed(title, failed))
        texts = [*_open_ends(row), *(_steep(row) if found.method == "stripes" else [])]
        findings += [headed(title, text) for text in texts]
    findings += _no_losses(found)
    spectrum = found.spectrum
    if spectrum and not spectrum.within:
        low, high = spectrum.lowest_deviation, spectrum.highest_deviation
        findings.append(
            message(
                "the mean spectrum of the records deviates from that of the site by {low:.0%} to {high:.0%}; "
                "{usual_low:.0%} to {usual_high:.0%} is usual",
                low=low,
                high=high,
                usual_low=LOW,
                usual_high=HIGH,
            )
        )
    return findings
