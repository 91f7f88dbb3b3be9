"""A campaign: every record (of files, made or scaled to the spectrum) of every sign from every share of a movement."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from assessment.analyses.capacity import assess, capacities, told
from assessment.analyses.demand import Demands
from assessment.analyses.found import as_part, finest
from assessment.analyses.states import Request, StateResult, analyse_states, curves
from assessment.analyses.time_history import Start, least_d_0, ultimate_of, why_not_reached
from assessment.ntc.floor_spectrum import Spectrum
from assessment.ntc.tables import farthest
from assessment.project.motions import BaseMotion, motion_of
from assessment.project.project import Project
from assessment.project.schema import GENERATED_STEP, ORIGINAL, CampaignTable
from assessment.results.schema import Direction, Pushovers, dynamic, known
from assessment.results.table import cells, compared, reduction, weaker
from assessment.studies import variants
from assessment.studies.scans import Place, Scans
from assessment.studies.searches import COMPARED, Searches, findings, spectrum_of
from mechanics import Assembly
from mechanics.messages import Message, headed, message
from mechanics.procedures import whole_movement
from mechanics.records import Record, compatible_record

DURATION, PLATEAU = 25.0, 10.0  # s, of a record that is made: NTC 2018 §3.2.3.6 [k]
LOW, HIGH = -0.10, 0.30  # of the target: least and largest deviation of the mean spectrum


def record_set(
    statics: variants.Statics, table: CampaignTable, motions: Sequence[BaseMotion]
) -> tuple[list[BaseMotion], dynamic.CampaignSpectrum | None]:
    """Return the motions of files, or made to the site's spectrum or scaled to it, with their mean spectrum."""
    if not (table.generated or table.spectrum_compatible):
        return list(motions), None
    found, spectra = list(motions), statics.demands.spectra
    limit_state = farthest(spectra) or next(iter(spectra))
    target = spectra[limit_state]
    if table.generated:
        seeds = range(1, table.generated + 1)
        tasks, titles = [(target, seed) for seed in seeds], [f"record {seed}" for seed in seeds]
        made = statics.workers.each("campaign: records", made_record, tasks, titles, len(tasks) > 1)
        found = [motion_of(statics.project, "campaign", table, record) for record in made]
    if table.spectrum_compatible:
        found = scaled_to(target, found, table)
    return found, compatibility(limit_state, target, found, table)


def made_record(spectrum: Spectrum, seed: int) -> Record:
    """Return a record whose spectrum is within 10 % of a given one; the same seed gives the same record."""
    made = compatible_record(spectrum.acceleration, DURATION, GENERATED_STEP, seed, plateau=PLATEAU)
    return replace(made, name=f"generated {seed}")


def scaled_to(target: Spectrum, motions: Sequence[BaseMotion], table: CampaignTable) -> list[BaseMotion]:
    """Scale each record, within the limits, so that the mean of ln(S_a/target) over ln T vanishes."""
    periods, (low, high) = np.geomspace(*table.periods_s, COMPARED), table.scale_limits
    wanted, found = np.log(target.acceleration(periods)), []
    for motion in motions:
        best = float(np.exp(np.mean(wanted - np.log(spectrum_of(motion, periods)))))
        factor, notes = float(np.clip(best, low, high)), motion.notes
        if factor != best:
            notes += (message(
                "campaign, {record}: the spectrum of the site asks for a factor of {wanted:.3g}; "
                "{taken:.3g} is taken, the limit (scale_limits = [{low:g}, {high:g}])",
                record=motion.name, wanted=best, taken=factor, low=low, high=high,
            ),)  # fmt: skip
        scaled, original = motion.at_amplitude(factor), motion.original.scaled(factor)
        pga, scale, own = factor * motion.pga, factor * motion.scale, motion.amplitude
        found.append(replace(scaled, original=original, pga=pga, scale=scale, amplitude=own, notes=notes))
    return found


def compatibility(
    limit_state: str, target: Spectrum, motions: Sequence[BaseMotion], table: CampaignTable
) -> dynamic.CampaignSpectrum:
    """Return the mean spectrum of a set of records with the target: relative deviations and their periods (s)."""
    periods = np.geomspace(*table.periods_s, COMPARED)
    wanted = target.acceleration(periods)
    mean = np.mean([spectrum_of(each, periods) for each in motions], axis=0)
    deviation = mean / wanted - 1.0
    low, high = float(deviation.min()), float(deviation.max())
    return dynamic.CampaignSpectrum(
        limit_state=limit_state, periods_s=list(table.periods_s), T_s=periods.tolist(), target_g=wanted.tolist(),
        mean_g=mean.tolist(), lowest_deviation=low, highest_deviation=high, within=low >= LOW and high <= HIGH,
    )  # fmt: skip


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
            name, far = whole.name, share * length
            found.append(Moved(title, name, on, start, *ends, name, share, far, static))
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
    project: Project, model: Assembly, stages: Sequence[StateResult], pushed: Mapping[Direction, Pushovers],
    demands: Demands, warnings: list[Message],
) -> float | None:  # fmt: skip
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
    searches = Searches.made(table, moved, records, statics.models[ORIGINAL].assembly, scans, study)
    asked, over_pga = searches.asked, searches.measures.over_pga
    rows = searches.rows(dynamic.CampaignCombination, asked)
    fits, losses = [], []
    for state in moved:
        own = [row for each, row in zip(asked, rows, strict=True) if each.state is state]
        fits.append(searches.fragility(dynamic.CampaignFragility, state, own))
        base = next((e for e in moved if e.settlement == state.settlement and e.share == 0.0), None)
        static = reduction(base.static_capacity, state.static_capacity) if base else None
        lost = cells(searches.loss(state, base), dynamic.Loss.model_fields)
        losses.append(as_part(dynamic.CampaignLoss, state, static=static, **lost))
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
                | ({"sa_g": over_pga[motion.name][table.measure] * motion.pga} if table.period_s else {}),
            )
            for motion in records
        ],
        spectrum=spectrum, combinations=rows, computed=len({each.key for each in asked if each.shaking.starts}),
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
