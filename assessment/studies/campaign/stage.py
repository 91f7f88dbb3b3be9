"""A campaign: every record of every sign from every share of a movement, and what it sums up to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from assessment.analyses.dynamic.ensemble import scatter_of
from assessment.analyses.dynamic.fragility import ENOUGH
from assessment.analyses.dynamic.record_set import HIGH, LOW, Measures
from assessment.analyses.dynamic.response import Setting
from assessment.analyses.dynamic.scan import Reach
from assessment.analyses.dynamic.time_history import Shaking
from assessment.project.schema import ORIGINAL
from assessment.results.schema.campaign import (
    Campaign,
    CampaignCombination,
    CampaignFragility,
    SameAs,
)
from assessment.studies.campaign.movements import Moved, moved_states, moved_title
from assessment.studies.campaign.records import RecordSet, record_set
from assessment.studies.campaign.scans import (
    Asked,
    Scans,
    asked_of,
    mirrored,
    numbers,
    observed_in,
    own_setting,
    reach_of,
)
from assessment.studies.campaign.summary import Combination, fragility_of, loss_of, within_records
from assessment.studies.variants import Statics, Study, quantity
from mechanics.messages import Message, headed, message

if TYPE_CHECKING:
    from assessment.analyses.checks.demand import Demands
    from assessment.project.motions import BaseMotion
    from assessment.project.project import Project
    from assessment.project.schema import CampaignTable
    from assessment.project.structure.state_models import StateModel
    from mechanics import Assembly


def campaign(
    project: Project,
    models: Mapping[str, StateModel],
    motions: Sequence[BaseMotion],
    statics: Statics,
    demands: Demands,
    scans: Scans,
    study: Study,
) -> Campaign:
    """Run every combination that [campaign] asks for and return the results; `motions`: of the files that it names.

    Combinations that could not be completed are in study.failures, and in the results with their reason. Raises
    KilledError where a process was ended from outside.
    """
    table = project.campaign
    assert table is not None
    records = record_set(project, table, motions, demands, scans.workers)
    reported = {note for motion in motions for note in motion.notes}
    study.warnings += [note for motion in records.motions for note in motion.notes if note not in reported]
    moved = moved_states(project, models, statics, demands, scans.workers, study)
    combinations = _combinations(project, models[ORIGINAL].assembly, table, records, moved)
    asked = [each.asked for each in combinations]
    scans.settle("campaign", asked, 0 if table.levels_g else len(table.signs), study)
    rows = _rows(combinations, scans, table, study)
    measures = Measures(project)
    ratios = measures.of(records.motions)
    fits = [fragility_of(state, combinations, rows, scans, table, measures, ratios) for state in moved]
    unmoved = {state.settlement: state for state in reversed(moved) if state.share == 0.0}
    beta = within_records(fit.beta_ensemble for fit in fits)
    found = Campaign(
        measure=table.measure,
        period_s=table.period_s,
        method=table.method,
        levels_g=list(table.levels_g or ()),
        tolerance=table.tolerance,
        contacts=table.contacts,
        members=scatter_of(project).members,
        symmetric=any(each.asked.run_sign != each.asked.sign for each in combinations),
        static_quantity=quantity(project) if project.pushover else None,
        records=records.rows(table),
        spectrum=records.spectrum,
        combinations=rows,
        computed=len(
            {each.asked.key for each in combinations if not isinstance(each.asked.shaking.start, str)}
        ),
        failures=list(study.failures),
        fragility=fits,
        loss=[
            loss_of(
                state,
                base := unmoved.get(state.settlement),
                combinations,
                scans,
                beta,
                fit,
                fits[moved.index(base)] if base else None,
            )
            for state, fit in zip(moved, fits, strict=True)
        ],
        warnings=list(study.warnings),
    )
    study.findings += [_of_campaign(text) for text in _findings(found)]
    return found


def _combinations(
    project: Project, drawn: Assembly, table: CampaignTable, records: RecordSet, moved: Sequence[Moved]
) -> list[Combination]:
    """Return every state under every record with every sign; a symmetric structure as drawn runs one sign only.

    A scan begins at the level found for the same record and sign at the share before, at the first share at that of the
    record's other sign, of a record's first sign at that of the first record. It is given by what is asked for alone,
    not by what is finished: levels are the same however they are computed.
    """
    symmetric = mirrored(project, drawn, table)
    reach, point = reach_of(project), project.control_point(table.control)
    found: list[Combination] = []
    before: dict[object, Asked] = {}
    for state in moved:
        for motion, ratio in zip(records.motions, records.ratios, strict=True):
            for sign in table.signs:
                run_sign = table.signs[0] if symmetric and state.start is drawn.initial else sign
                place = (state.settlement, motion.name, sign)
                after = before.get(place) or before.get(motion.name) or (found[0].asked if found else None)
                setting = Setting(own_setting(table), point, state.ultimate, project.contacts.sliding)
                shaking = Shaking(state.model, motion, setting, str(state.title), state.start)
                stripes = tuple(level / ratio for level in table.levels_g or ())
                levels = Reach(table.max_scale, stripes=stripes) if stripes else reach
                asked = asked_of(shaking, sign, run_sign, levels, after)
                before[place] = asked
                before.setdefault(motion.name, asked)
                found.append(Combination(state, motion.name, ratio, asked))
    return found


def _rows(
    combinations: Sequence[Combination], scans: Scans, table: CampaignTable, study: Study
) -> list[CampaignCombination]:
    """Return the row of each combination; if several are one run, the later ones name the first."""
    rows: list[CampaignCombination] = []
    first: dict[str, Combination] = {}
    for each in combinations:
        scan, seen = scans.of(each.asked), observed_in(scans.of(each.asked))
        origin = first.setdefault(each.asked.key, each)
        row = CampaignCombination(
            record=each.record,
            settlement=each.moved.settlement,
            share=each.moved.share,
            sign=each.asked.sign,
            pga_collapse_range=None if seen.lowest is None else [seen.capacity, seen.certain],
            **numbers(scan),
        )
        if table.period_s:
            row = row.replace(sa_collapse_g=None if seen.capacity is None else each.ratio * seen.capacity)
        if scan.stripes and scan.reason is None:
            row = row.replace(
                collapsed=[point.collapsed for point in scan.points],
                all_collapsed=[point.members_collapsed == point.members for point in scan.points],
            )
        if origin is not each and not isinstance(each.asked.shaking.start, str):
            same = SameAs(
                settlement=origin.moved.settlement, share=origin.moved.share, sign=origin.asked.sign
            )
            row = row.replace(same_as=same, runs=0, points=[], counts=None)
        elif not isinstance(each.asked.shaking.start, str):
            scans.tell(each.asked, "campaign", study)
        rows.append(row)
    return rows


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
    findings += [
        headed(
            moved_title(row.settlement, row.share),
            message(
                "a loss of {loss:.0%} is not distinguishable from none: its range is from {low:.0%} to {high:.0%}",
                loss=row.dynamic or 0.0,
                low=row.dynamic_range[0] or 0.0,
                high=row.dynamic_range[1] or 0.0,
            ),
        )
        for row in found.loss
        if row.distinguishable is False
    ]
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
