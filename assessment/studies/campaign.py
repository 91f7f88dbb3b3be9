"""A campaign: every record of every sign from every share of a movement at rest, and what it sums up to."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from assessment.analyses.capacity import assess, capacities, told
from assessment.analyses.demand import Demands
from assessment.analyses.found import as_part, finest
from assessment.analyses.states import Request, StateResult, analyse_states, curves
from assessment.analyses.time_history import Start, least_d_0, ultimate_of, why_not_reached
from assessment.project.motions import BaseMotion
from assessment.project.project import Project
from assessment.project.schema import ORIGINAL, CampaignTable
from assessment.results.schema import Direction, Pushovers, dynamic, known
from assessment.results.table import compared, reduction, weaker
from assessment.studies import variants
from assessment.studies.record_set import HIGH, LOW, record_set
from assessment.studies.scans import Place, Scans
from assessment.studies.searches import Searches, findings
from mechanics import Assembly
from mechanics.messages import Message, headed, message
from mechanics.procedures import whole_movement


@dataclass(frozen=True, eq=False)
class Moved(Place):
    """A share of a movement, and its largest component.

    `static_capacity`: PGA at the surface (g) of the check, or α where there is none, of the weaker direction.
    """

    settlement: str
    share: float
    movement_m: float
    static_capacity: float | None


def moved_states(statics: variants.Statics, study: variants.Study) -> list[Moved]:
    """Return the states after each share of each movement of [campaign]; none and the whole are those of `statics`."""
    project, table = statics.project, known(statics.project.campaign)
    asked, beside = table.settlements or project.unstrengthened[1:], _beside(project, table)
    movements = [each for each in finest(project, statics.halvings) if each[1].name in asked]
    requests = {  # of shares between none and the whole, under every behaviour that is needed
        (whole.name, share, behaviour): Request(
            finer, statics.models[whole.name], variants.part(whole, share), behaviour, f"× {share:g}"
        )
        for finer, whole in movements
        for share in table.shares
        if 0.0 < share < 1.0
        for behaviour in dict.fromkeys([*finer.pushed_contacts, table.contacts])
    }
    parts: dict[tuple[str, float], list[StateResult]] = {}
    results = analyse_states(list(requests.values()), statics.workers, "campaign")
    for (name, share, _), result in zip(requests, results, strict=True):
        parts.setdefault((name, share), []).append(result)
    point, drawn = project.control_point(table.control).name, statics.models[ORIGINAL].assembly
    found = []
    for _, whole in movements:
        model = statics.models[whole.name].assembly
        length = whole_movement(model, whole.support, whole.displacement_m, whole.rotation_rad)
        for share in table.shares:
            name = whole.name if share else ORIGINAL
            title = message("{state} × {share:g}", state=whole.name, share=share)
            warnings: list[Message] = []  # of the whole and of none: told with their states
            stages, pushed = statics.stages_of(name), statics.states[name].pushover
            if 0.0 < share < 1.0:
                stages, warnings = parts[whole.name, share], study.warnings
                pushed = curves(stages)
                for stage in stages:
                    study.quality += stage.quality
                    study.seconds += sum(stage.seconds.values())
                    study.warnings += [headed(title, text) for text in stage.failures]
            start: Start = drawn.initial
            if share:  # at rest under the contacts of the campaign, or why that was not reached
                [own] = [stage for stage in stages if stage.behaviour == table.contacts]
                start = own.reached if own.reached is not None else why_not_reached(own)
            on = model if share else drawn
            static = _static(beside, on, stages if share else [], pushed, statics.demands, warnings)
            ends = ultimate_of(pushed, point), least_d_0(pushed, point)
            found.append(
                Moved(title, whole.name, on, start, *ends, whole.name, share, share * length, static)
            )
    return found


def _beside(project: Project, table: CampaignTable) -> Project:
    """Return the project whose static capacity stands beside the campaign's: of rigid joints without elastic curves.

    Soft joints may lose most of what a movement leaves to rigid ones: the two losses would be of different structures.
    """
    if project.pushover is None or table.contacts != "rigid" or "rigid" not in project.pushover.contacts:
        return project
    changed: dict[str, object] = {"pushover": project.pushover.model_copy(update={"contacts": ("rigid",)})}
    if project.assessment:
        changed["assessment"] = project.assessment.model_copy(update={"model": "none"})  # the rigid branch
    return project.model_copy(update=changed)


def _static(
    project: Project,
    model: Assembly,
    stages: Sequence[StateResult],
    pushed: Mapping[Direction, Pushovers],
    demands: Demands,
    warnings: list[Message],
) -> float | None:
    """Return the static capacity of the weaker direction, of the joints of `project`; None if one is not known."""
    if project.pushover is None:
        return None
    if "elastic" not in project.pushover.contacts:
        pushed = {direction: each.replace(elastic=None) for direction, each in pushed.items()}
    if project.assessment:
        assessed = assess(project, model, pushed, demands)
        warnings += told(assessed)
        checked, limit = capacities(assessed), variants.quoted_limit_state(project) or ""
        checks = [way in checked and checked[way].checks.get(limit) for way in variants.directions(project)]
        values = [check.pga_g if check else None for check in checks]
    else:
        own = [stage for stage in stages if stage.behaviour in project.pushover.contacts]
        borne = variants.capacities_of(project, own, pushed, {}).values()
        values = [compared(each, variants.quantity(project)) for each in borne]
    return weaker(values)


def campaign(
    statics: variants.Statics, motions: Sequence[BaseMotion], scans: Scans, study: variants.Study
) -> dynamic.Campaign:
    """Run every combination that [campaign] asks for and return the results; `motions`: of the files that it names."""
    project, table = statics.project, known(statics.project.campaign)
    records, spectrum = record_set(statics, table, motions)
    reported = {note for motion in motions for note in motion.notes}
    study.warnings += [note for motion in records for note in motion.notes if note not in reported]
    moved = moved_states(statics, study)
    drawn, by = statics.models[ORIGINAL].assembly, "Sa(T)" if table.period_s else "PGA"
    searches = Searches.made(
        "campaign",
        table,
        moved,
        records,
        drawn,
        scans,
        study,
        signs=table.signs,
        by=by,
        levels=table.levels_g or (),
    )
    asked, over_pga = searches.asked, searches.measures.over_pga
    rows = searches.rows(dynamic.CampaignCombination, asked)
    fits, losses = [], []
    for state in moved:
        own = [row for each, row in zip(asked, rows, strict=True) if each.state is state]
        fits.append(searches.fragility(dynamic.CampaignFragility, state, own))
        base = next((e for e in moved if e.settlement == state.settlement and e.share == 0.0), None)
        static = reduction(base.static_capacity, state.static_capacity) if base else None
        losses.append(as_part(dynamic.CampaignLoss, searches.loss(state, base), state, static=static))
    if table.period_s:
        rows = [
            row.replace(sa_collapse_g=row.pga_collapse_g and each.ratio * row.pga_collapse_g)
            for each, row in zip(asked, rows, strict=True)
        ]
    told = [*findings(searches, len(records), zip(moved, fits, losses, strict=True))]
    told += _findings(project, losses, spectrum)
    study.findings += [message("campaign: {text}", text=text) for text in told]
    return as_part(
        dynamic.Campaign, table, levels_g=list(table.levels_g or ()), members=project.scatter,
        static_quantity=variants.quantity(project) if project.pushover else None,
        records=[
            dynamic.CampaignRecord(
                record=motion.name, record_pga_g=motion.pga, scale=motion.scale,
                pgv_m_s=motion.pga * over_pga[motion.name]["PGV"], duration_s=motion.record.duration,
                time_step_s=motion.record.time_step, **motion.told_vertical
                | ({"sa_g": over_pga[motion.name][by] * motion.pga} if table.period_s else {}),
            )
            for motion in records
        ],
        spectrum=spectrum, combinations=rows, computed=len({each.key for each in asked if each.starts}),
        fragility=fits, loss=losses, failures=list(study.failures), warnings=list(study.warnings),
    )  # fmt: skip


def _findings(
    project: Project, losses: Sequence[dynamic.CampaignLoss], spectrum: dynamic.CampaignSpectrum | None
) -> Iterator[Message]:
    """Yield losses that cannot be told, and a mean spectrum that is not that of the site."""
    if not any(row.share == 0.0 for row in losses):
        yield message(
            "no loss of capacity: it is relative to the structure as drawn; add 0.0 to shares to have it"
        )
    elif project.pushover is None and any(row.share > 0.0 for row in losses):
        yield message("no static loss: it is that of the pushover; add [pushover] to have it")
    if spectrum and not spectrum.within:
        yield message(
            "the mean spectrum of the records deviates from that of the site by {low:.0%} to {high:.0%}; "
            "{usual_low:.0%} to {usual_high:.0%} is usual", low=spectrum.lowest_deviation,
            high=spectrum.highest_deviation, usual_low=LOW, usual_high=HIGH,
        )  # fmt: skip
