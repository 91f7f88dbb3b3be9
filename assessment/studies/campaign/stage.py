"""A campaign: what is run, each combination once and the long ones first, and its results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from assessment.analyses.dynamic.ensemble import Scatter, scatter_of
from assessment.analyses.dynamic.incremental import ENOUGH
from assessment.analyses.dynamic.inputs import WORTHWHILE
from assessment.analyses.dynamic.record_set import (
    HIGH,
    LOW,
    Target,
    compatibility,
    made_record,
    ordinate,
    scaled_to,
)
from assessment.analyses.dynamic.response import Setting
from assessment.analyses.dynamic.time_history import quality_row
from assessment.project.motions import motion_of
from assessment.project.schema import MotionTable
from assessment.runtime.fingerprint import fingerprint
from assessment.studies.campaign.movements import Moved, moved_states
from assessment.studies.campaign.search import Combination, open_numbers, run_stripes, search_collapse
from assessment.studies.campaign.summary import Observed, fragility, loss
from assessment.studies.variants import Demands, Numbers, Study, quantity
from mechanics.procedures import Mirror

if TYPE_CHECKING:
    from assessment.analyses.static.states import StateResult
    from assessment.project.motions import BaseMotion
    from assessment.project.project import Project
    from assessment.project.schema import CampaignTable
    from assessment.runtime.tasks import Workers
    from mechanics import Assembly

RUNS = 30  # motions of a combination, about


@dataclass(frozen=True, eq=False)
class Asked:
    """A combination: a record of one sign from a state at rest; `ratio`: of the measure to the PGA of its record.

    `run_sign`: the sign that is run; where the structure is its own mirror image, both signs are the same run.
    """

    moved: Moved
    motion: BaseMotion
    sign: int
    ratio: float
    run_sign: int

    @property
    def title(self) -> str:
        """What is run, for people."""
        return f"{self.moved.title}, {self.motion.name}, {'+' if self.sign > 0 else '−'}"

    @property
    def key(self) -> tuple[str, str, int]:
        """What combinations that are one have in common."""
        start = fingerprint(search_collapse, (self.moved.start, self.moved.ultimate))
        return start, self.motion.name, self.run_sign

    @property
    def signed(self) -> BaseMotion:
        """The motion that shakes the base."""
        return replace(self.motion, record=self.motion.record.scaled(float(self.run_sign)))


def campaign(
    project: Project,
    model: Assembly,
    motions: Sequence[BaseMotion],
    states: Mapping[str, Any],
    stages: Sequence[StateResult],
    halvings: Mapping[str, int],
    demands: Demands,
    workers: Workers,
    study: Study,
) -> Numbers:
    """Run every combination that [campaign] asks for and return its results; `motions`: of the files it names.

    What could not be completed is in study.failures, and in the results with its reason.
    """
    table = project.campaign
    assert table is not None
    records, spectrum = _record_set(project, table, motions, demands, workers)
    told = {note for motion in motions for note in motion.notes}
    study.warnings += [note for motion in records for note in motion.notes if note not in told]
    moved = moved_states(project, model, states, stages, halvings, demands, workers, study)
    ratios = [ordinate(each, table.period_s) / each.pga if table.period_s else 1.0 for each in records]
    mirrored = _mirrored(project, model, table)
    asked = [
        Asked(
            state, motion, sign, ratio, table.signs[0] if mirrored and state.start is model.initial else sign
        )
        for state in moved
        for motion, ratio in zip(records, ratios, strict=True)
        for sign in table.signs
    ]
    scatter = scatter_of(project)
    done = _run(project, model, table, scatter, asked, workers)
    combinations: list[Numbers] = []
    first: dict[tuple[str, str, int], Asked] = {}
    for each in asked:
        numbers = open_numbers(each.moved.start) if isinstance(each.moved.start, str) else None
        if numbers is None:
            origin = first.setdefault(each.key, each)
            result = done[each.key]
            numbers = dict(result.numbers)
            if origin is not each:
                place = {"settlement": origin.moved.settlement, "share": origin.moved.share}
                numbers |= {"same_as": place | {"sign": origin.sign}, "runs": 0, "points": []}
            else:
                study.quality.append(quality_row(each.moved.title, "campaign", result.programs, result.worst))
                study.seconds += result.seconds
                study.failures += [f"campaign: {each.title}: {text}" for text in result.failures]
        combinations.append(_row(each, numbers, table))
    observed = {
        id(state): [
            _observed(each, row) for each, row in zip(asked, combinations, strict=True) if each.moved is state
        ]
        for state in moved
    }
    found: Numbers = {
        "measure": table.measure,
        "period_s": table.period_s,
        "method": table.method,
        "levels_g": list(table.levels_g or ()),
        "tolerance": table.tolerance,
        "contacts": table.contacts,
        "members": scatter.members,
        "static_quantity": quantity(project) if project.pushover else None,
        "records": [_record(each, ratio, table) for each, ratio in zip(records, ratios, strict=True)],
        "spectrum": spectrum,
        "combinations": combinations,
        "computed": len(done),
        "failures": study.failures.copy(),
    }
    for state in moved:
        of_state = observed[id(state)]
        base = next(
            (other for other in moved if other.settlement == state.settlement and other.share == 0.0), None
        )
        place = {"settlement": state.settlement, "share": state.share, "movement_m": state.movement}
        row = fragility(of_state, table.levels_g, scatter.members)
        found.setdefault("fragility", []).append(place | row)
        before = observed[id(base)] if base else []
        lost = loss(before, of_state, base.static if base else None, state.static, table.levels_g)
        found.setdefault("loss", []).append(place | lost)
    study.findings += _findings(found, table)
    return found


def _mirrored(project: Project, model: Assembly, table: CampaignTable) -> bool:
    """Whether the structure as drawn collapses under a record as under its negative: as the mirror image of itself.

    The control point decides where its displacement beyond which the static capacity is none is known: it has to be
    its own image then.
    """
    mirror = Mirror.of(model, table.contacts)
    point = project.control_point(table.control).point_m
    return mirror is not None and mirror.swaps(point, point)


def _record_set(
    project: Project,
    table: CampaignTable,
    motions: Sequence[BaseMotion],
    demands: Demands,
    workers: Workers,
) -> tuple[list[BaseMotion], Numbers | None]:
    """Return the records of the files, or those made; scaled where asked for; their mean spectrum with the target."""
    found = list(motions)
    if not (table.generated or table.spectrum_compatible):
        return found, None
    target = Target.of(demands.spectra)
    if table.generated:
        seeds = range(1, table.generated + 1)
        made = workers.each(
            "campaign: records",
            made_record,
            [(target.spectrum, seed) for seed in seeds],
            [f"record {seed}" for seed in seeds],
            table.generated > 1,
        )
        found = [motion_of(project, "campaign", table, record) for record in made]
    if table.spectrum_compatible:
        found = scaled_to(target, found, table)
    return found, compatibility(target, found, table)


def _run(
    project: Project,
    model: Assembly,
    table: CampaignTable,
    scatter: Scatter,
    asked: Sequence[Asked],
    workers: Workers,
) -> dict[tuple[str, str, int], Combination]:
    """Run each combination once, those of most samples first: what is long must not begin last."""
    own = MotionTable(**{key: getattr(table, key) for key in MotionTable.model_fields})
    point = project.control_point(table.control)
    distinct = {each.key: each for each in reversed(asked) if not isinstance(each.moved.start, str)}
    order = sorted(distinct, key=lambda key: -distinct[key].motion.record.acceleration.size)
    tasks: list[tuple[Any, ...]] = []
    for each in (distinct[key] for key in order):
        common = (model, each.signed, Setting(own, point, each.moved.ultimate), each.moved.start, scatter)
        if table.levels_g:
            tasks.append((*common, tuple(level / each.ratio for level in table.levels_g)))
        else:
            tasks.append((*common, table.max_scale, table.tolerance))
    samples = sum(distinct[key].motion.record.acceleration.size for key in order)
    found: list[Combination] = workers.each(
        "campaign",
        run_stripes if table.levels_g else search_collapse,
        tasks,
        [distinct[key].title for key in order],
        RUNS * len(model.contacts) * samples > WORTHWHILE,
    )
    return dict(zip(order, found, strict=True))


def _row(each: Asked, numbers: Numbers, table: CampaignTable) -> Numbers:
    row: Numbers = {
        "record": each.motion.name,
        "settlement": each.moved.settlement,
        "share": each.moved.share,
        "sign": each.sign,
    } | numbers
    if table.period_s:
        collapse, span = row["pga_collapse_g"], row["pga_collapse_range"]
        row["sa_collapse_g"] = None if collapse is None else each.ratio * collapse
        row["sa_collapse_g_range"] = span and [None if end is None else each.ratio * end for end in span]
    return row


def _observed(each: Asked, row: Numbers) -> Observed:
    span = row["pga_collapse_range"]
    return Observed(
        record=each.motion.name,
        sign=each.sign,
        ratio=each.ratio,
        collapse=row["pga_collapse_g"],
        safe=row["pga_safe_g"],
        certain=span[1] if span else None,
        fallen=tuple(row.get("collapsed") or ()),
        all_fallen=tuple(row.get("all_collapsed") or ()),
    )


def _record(motion: BaseMotion, ratio: float, table: CampaignTable) -> Numbers:
    numbers: Numbers = {
        "record": motion.name,
        "record_pga_g": motion.pga,
        "scale": motion.scale,
        "duration_s": motion.record.duration,
        "time_step_s": motion.record.time_step,
    }
    return numbers | ({"sa_g": ratio * motion.pga} if table.period_s else {})


def _findings(found: Numbers, table: CampaignTable) -> list[str]:
    """Return what the user should know of the campaign as a whole."""
    findings = []
    records = len(found["records"])
    if records < ENOUGH:
        findings.append(f"campaign: records: {records}; NTC 2018 §7.3.5 asks for at least {ENOUGH}")
    equal = sum("same_as" in row for row in found["combinations"])
    if equal:
        findings.append(
            f"campaign: {equal} of {len(found['combinations'])} combinations are the same as another one, or its "
            "mirror image, and were computed once"
        )
    for row in found["fragility"]:
        if row["failed"]:
            where = f"{row['settlement']} × {row['share']:g}"
            findings.append(
                f"campaign: {where}: {row['failed']} of {row['combinations']} combinations could not be completed; "
                "median, dispersion and loss are those of the others"
            )
    spectrum = found["spectrum"]
    if spectrum and not spectrum["within"]:
        low, high = spectrum["lowest_deviation"], spectrum["highest_deviation"]
        findings.append(
            f"campaign: the mean spectrum of the records deviates from that of the site by {low:.0%} to {high:.0%}; "
            f"{LOW:.0%} to {HIGH:.0%} is usual"
        )
    return findings
