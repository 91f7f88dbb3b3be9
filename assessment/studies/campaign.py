"""A campaign: every record of every sign from every share of a movement at rest, and what it sums up to."""

from collections.abc import Iterator, Mapping, Sequence

from assessment.analyses import demand
from assessment.analyses.capacity import assess, capacities, told
from assessment.analyses.demand import Demands
from assessment.analyses.found import as_part, finest
from assessment.analyses.fragility import ENOUGH, Measures, ordinate
from assessment.analyses.scan import Reach
from assessment.analyses.states import Request, StateResult, analyse_states, curves
from assessment.analyses.time_history import Setting, Shaking, Start, ultimates, why_not_reached
from assessment.ntc.tables import farthest
from assessment.project.motions import BaseMotion, motion_of
from assessment.project.project import Project
from assessment.project.schema import ORIGINAL, CampaignTable
from assessment.results.schema import Direction, Pushovers, dynamic, known
from assessment.results.table import compared, weaker
from assessment.studies import variants
from assessment.studies.scans import (
    Asked,
    Scans,
    asked_for,
    mirror_image,
    numbers,
    observed_in,
    own_setting,
    reach_of,
)
from assessment.studies.searches import Moved, fragility_of, loss_of, moved_title
from mechanics import Assembly
from mechanics.messages import Message, headed, message
from mechanics.procedures import whole_movement


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
            place, warnings = (whole.name, share), []  # of the whole and of none: told with their states
            stages, pushed = statics.stages_of(name), statics.states[name].pushover
            if 0.0 < share < 1.0:
                stages, warnings = parts[place], study.warnings
                pushed = curves(stages)
                for stage in stages:
                    study.quality += stage.quality
                    study.seconds += sum(stage.seconds.values())
                    study.warnings += [headed(moved_title(*place), text) for text in stage.failures]
            start: Start = drawn.initial
            if share:  # at rest under the contacts of the campaign, or why that was not reached
                [own] = [stage for stage in stages if stage.behaviour == table.contacts]
                start = own.reached if own.reached is not None else why_not_reached(own)
            on = model if share else drawn
            static = _static(beside, on, stages if share else [], pushed, statics.demands, warnings)
            # of the control point, m: where the static capacity vanishes
            ultimate = ultimates({ORIGINAL: pushed}).get((ORIGINAL, point))
            rigid = [each.rigid for each in pushed.values() if each.control == point and each.rigid]
            d_0 = min((each.d_0_m for each in rigid if each.d_0_m), default=None)
            found.append(Moved(*place, share * length, on, start, static, ultimate, d_0))
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
        made = statics.workers.each("campaign: records", demand.made_record, tasks, titles, len(tasks) > 1)
        found = [motion_of(statics.project, "campaign", table, record) for record in made]
    if table.spectrum_compatible:
        found = demand.scaled_to(target, found, table)
    return found, demand.compatibility(limit_state, target, found, table)


def campaign(
    statics: variants.Statics, motions: Sequence[BaseMotion], scans: Scans, study: variants.Study
) -> dynamic.Campaign:
    """Run every combination that [campaign] asks for and return the results; `motions`: of the files that it names."""
    project, table = statics.project, known(statics.project.campaign)
    records, spectrum = record_set(statics, table, motions)
    ratio = [ordinate(each, table.period_s) / each.pga if table.period_s else 1.0 for each in records]
    reported = {note for motion in motions for note in motion.notes}
    study.warnings += [note for motion in records for note in motion.notes if note not in reported]
    moved = moved_states(statics, study)
    reach = Reach(table.max_scale, stripes=tuple(table.levels_g)) if table.levels_g else reach_of(project)
    image = mirror_image(project, statics.models[ORIGINAL].assembly, table)
    point, sliding = project.control_point(table.control), project.contacts.sliding
    shakings = []
    for state in moved:
        setting = Setting(own_setting(table), point, state.ultimate, sliding)
        for motion, each in zip(records, ratio, strict=True):
            shaking = Shaking(state.model, motion, setting, state.start, str(state.title))
            shakings.append((state.settlement, shaking, each, state))
    asked = asked_for(shakings, table.signs, reach, image)
    scans.settle("campaign", asked, not table.levels_g, study)
    rows = _rows(asked, scans, table, study)
    measures = Measures.of(project, records)
    by_state = {
        state: [(each, row) for each, row in zip(asked, rows, strict=True) if each.state is state]
        for state in moved
    }
    fits = {state: fragility_of(state, own, scans, table, measures) for state, own in by_state.items()}
    unmoved = {state.settlement: state for state in reversed(moved) if state.share == 0.0}
    found = as_part(
        dynamic.Campaign, table, levels_g=list(table.levels_g or ()), members=project.scatter,
        symmetric=any(each.run_sign != each.sign for each in asked),
        static_quantity=variants.quantity(project) if project.pushover else None,
        records=[
            dynamic.CampaignRecord(
                record=motion.name, record_pga_g=motion.pga, scale=motion.scale,
                pgv_m_s=motion.pga * measures.over_pga[motion.name]["PGV"],
                duration_s=motion.record.duration, time_step_s=motion.record.time_step,
                **motion.told_vertical | ({"sa_g": each * motion.pga} if table.period_s else {}),
            )
            for motion, each in zip(records, ratio, strict=True)
        ],
        spectrum=spectrum, combinations=rows, computed=len({each.key for each in asked if each.starts}),
        fragility=list(fits.values()),
        loss=[loss_of(state, unmoved.get(state.settlement), asked, scans, table.levels_g) for state in moved],
        failures=list(study.failures), warnings=list(study.warnings),
    )  # fmt: skip
    study.findings += [message("campaign: {text}", text=text) for text in _findings(found)]
    return found


def _rows(
    asked: Sequence[Asked], scans: Scans, table: CampaignTable, study: variants.Study
) -> list[dynamic.CampaignCombination]:
    """Return the row of each combination; if several are one run, the later ones name the first."""
    rows: list[dynamic.CampaignCombination] = []
    first: dict[str, Asked] = {}
    for each in asked:
        scan, seen = scans.of(each), observed_in(scans.of(each))
        span = None if seen.lowest is None else [seen.capacity, seen.certain]
        row = as_part(dynamic.CampaignCombination, each, each.state, pga_collapse_range=span, **numbers(scan))
        if table.period_s:
            row = row.replace(sa_collapse_g=None if seen.capacity is None else each.ratio * seen.capacity)
        if scan.stripes and scan.reason is None:
            row = row.replace(
                collapsed=[point.collapsed for point in scan.points],
                all_collapsed=[point.members_collapsed == point.members for point in scan.points],
            )
        origin = first.setdefault(each.key, each)
        if origin is each:
            scans.tell(each, "campaign", study)
        elif each.starts:
            same = as_part(dynamic.SameAs, origin, origin.state)
            row = row.replace(same_as=same, runs=0, points=[], counts=None)
        rows.append(row)
    return rows


def _findings(found: dynamic.Campaign) -> Iterator[Message]:
    """Yield warnings about the campaign as a whole."""
    records, count = len(found.records), len(found.combinations)
    if records < ENOUGH:
        yield message(
            "records: {count}; NTC 2018 §7.3.5 asks for at least {least}", count=records, least=ENOUGH
        )
    if equal := sum(row.same_as is not None for row in found.combinations):
        yield message("{equal} of {count} combinations are the same as another one, or its mirror image, "
                      "and were computed once", equal=equal, count=count)  # fmt: skip
    for row in found.fragility:
        for text in doubts(row, found.method == "stripes"):
            yield headed(moved_title(row.settlement, row.share), text)
    for lost in found.loss:
        if lost.distinguishable is False:
            low, high = (value or 0.0 for value in lost.dynamic_range)
            text = message("a loss of {loss:.0%} is not distinguishable from none: its range is from {low:.0%} to "
                           "{high:.0%}", loss=round(lost.dynamic or 0.0, 2) + 0.0, low=low, high=high)  # fmt: skip
            yield headed(moved_title(lost.settlement, lost.share), text)
    if not any(row.share == 0.0 for row in found.loss):
        yield message(
            "no loss of capacity: it is relative to the structure as drawn; add 0.0 to shares to have it"
        )
    elif found.static_quantity is None and any(row.share > 0.0 for row in found.loss):
        yield message("no static loss: it is that of the pushover; add [pushover] to have it")
    if found.spectrum and not found.spectrum.within:
        yield message(
            "the mean spectrum of the records deviates from that of the site by {low:.0%} to {high:.0%}; "
            "{usual_low:.0%} to {usual_high:.0%} is usual", low=found.spectrum.lowest_deviation,
            high=found.spectrum.highest_deviation, usual_low=demand.LOW, usual_high=demand.HIGH,
        )  # fmt: skip


def doubts(row: dynamic.CampaignFragility, stripes: bool) -> Iterator[Message]:
    """Yield what to know of a fragility: combinations left open, lower bounds, no median, stripes without scatter."""
    if row.failed:
        yield message("{failed} of {count} combinations could not be completed; median, dispersion and loss are those "
                      "of the others", failed=row.failed, count=row.combinations)  # fmt: skip
    if row.withstood:
        yield message(
            "{withstood} of {count} combinations do not collapse up to the largest level tried and count as lower "
            "bounds; raise max_scale, or levels_g, to find their collapse", withstood=row.withstood,
            count=row.combinations,
        )  # fmt: skip
    if row.median_g is None and row.failed < row.combinations:
        yield message(
            "no median of collapse is found; some levels have to be withstood, and others not, and more "
            "combinations collapse as levels grow"
        )
    if stripes and row.median_g is not None and row.beta == 0.0:
        yield message(
            "no level with a collapse lies below one that is withstood, and the dispersion cannot be told: β = 0 and "
            "a median acceleration of {median:.3g} g are the limit of ever more likely distributions; "
            "add levels_g about it",
            median=row.median_g,
        )
