"""Contradictions in [assessment], [[mechanism]] and [sensitivity]."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path

from assessment.ntc.confidence import COMPONENTS, confidence_factor
from assessment.ntc.demand.return_period import return_period
from assessment.project.consistency.files import missing_file
from assessment.project.consistency.names import unknown_name
from assessment.project.errors import Problem
from assessment.project.schema import (
    VARIED,
    AssessmentTable,
    FloorTable,
    KeyPath,
    KnowledgeTable,
    LimitState,
    ProjectContent,
    SensitivityTable,
    SiteTable,
)

HIGHEST = 40.0  # m: of a building whose period T_1 = 0.05 H^(3/4) gives (Circolare 7/2019, C7.3.3.2)
RETURN_PERIOD_TOL = 0.02  # relative: typed values are rounded, 475 years for 474.6
LEAST_ROTATION = 1e-6  # of a macro-block, relative to those of the others; below it the block does not turn


def assessment_problems(project: ProjectContent, assessment: AssessmentTable) -> Iterator[Problem]:
    """Yield a problem for each table or key that [assessment] needs and that is missing."""
    needed = ["rigid"] if assessment.model == "none" else ["rigid", "elastic"]
    if project.pushover is None:
        yield Problem(
            ("assessment",), "there is no pushover to assess; add [pushover] or leave [assessment] out"
        )
    elif missing := [contacts for contacts in needed if contacts not in project.pushover.contacts]:
        text = (
            f"{' and '.join(missing)} missing, but assessment.model asks for it; write {json.dumps(needed)}"
        )
        yield Problem(("pushover", "contacts"), text)
    if assessment.spectrum == "record" and not project.history:
        text = 'there is no record to take the spectrum of; add [[history]] or write spectrum = "ntc"'
        yield Problem(("assessment", "spectrum"), text)
    if assessment.spectrum == "ntc" and assessment.site is None:
        yield Problem(("assessment", "site"), 'missing; add [assessment.site] or write spectrum = "record"')
    if assessment.method == "grid" and (assessment.site is None or assessment.site.typed):
        text = 'the hazard is typed in, there is no grid; write latitude and longitude of the site, or "demand-shape"'
        yield Problem(("assessment", "method"), text)


def knowledge_problems(knowledge: KnowledgeTable, factor: float) -> Iterator[Problem]:
    """Yield a problem where the confidence factor does not follow from the level of knowledge or the components F_Ck.

    `factor`: the confidence factor F_C of [assessment]. Sources: Circolare 7/2019, C8.5.4, for levels; DPCM
    9/2/2011, §4.2, for components.
    """
    path: KeyPath = ("assessment", "knowledge")
    given = knowledge.components
    if (knowledge.level is None) == (not given):
        text = "F_C follows from two things" if given else "F_C follows from nothing"
        yield Problem(path, f"{text}; write level, or {', '.join(COMPONENTS)}")
        return
    if given and len(given) < len(COMPONENTS):
        yield Problem(
            path, f"{', '.join(COMPONENTS.keys() - given.keys())} missing; the four components go together"
        )
        return
    for key, value in given.items():
        if value not in COMPONENTS[key]:
            choices = ", ".join(f"{each:g}" for each in COMPONENTS[key])
            yield Problem((*path, key), f"{value:g} is none of {choices}; write one of these")
            return
    follows = confidence_factor(knowledge.level, given).factor
    if abs(follows - factor) > 1e-9:
        text = (
            f"{factor:g}, but {'.'.join(map(str, path))} makes {follows:g}; write {follows:g}, or correct it"
        )
        yield Problem(("assessment", "confidence_factor"), text)


def floor_problems(floor: FloorTable, assessment: AssessmentTable) -> Iterator[Problem]:
    """Yield a problem for each key of [assessment.floor] that contradicts another one, there or in [assessment]."""
    path: KeyPath = ("assessment", "floor")
    if floor.height_m > floor.building_height_m:
        text = f"{floor.height_m:g} is above building_height_m ({floor.building_height_m:g}); correct one of them"
        yield Problem((*path, "height_m"), text)
    if floor.period_s is None and floor.building_height_m > HIGHEST:
        text = f"missing; T_1 = 0.05 H^(3/4) holds up to a building_height_m of {HIGHEST:g}"
        yield Problem((*path, "period_s"), f"{text}; write the period, in s")
    if len(floor.higher_periods_s) != len(floor.higher_participations):
        text = (
            f"{len(floor.higher_participations)} of {len(floor.higher_periods_s)}; "
            "write one γ_k ψ_k for each of higher_periods_s, in the same order"
        )
        yield Problem((*path, "higher_participations"), text)
    if floor.higher_periods_s and assessment.circular == 2009:
        text = "the circular of 2009 knows the first mode alone; leave it out or write circular = 2019"
        yield Problem((*path, "higher_periods_s"), text)
    if assessment.spectrum == "record":
        yield Problem(path, 'a record is taken as that of the ground; write spectrum = "ntc" or leave it out')


def site_problems(site: SiteTable, limit_states: Iterable[LimitState], folder: Path) -> Iterator[Problem]:
    """Yield a problem where the hazard of the site is missing, incomplete or given twice.

    `limit_states`: those that [assessment] checks, each of which needs its hazard; `folder`: of the project.
    """
    path: KeyPath = ("assessment", "site")
    yield from missing_file(folder, (*path, "grid"), site.grid)
    by_place = {key: getattr(site, key) for key in ("latitude", "longitude", "grid")}
    placed = [key for key, value in by_place.items() if value is not None]
    typed = site.typed
    if placed and typed:
        text = f"given twice, by {', '.join(placed)} and by {', '.join(typed)}; keep one of the two"
        yield Problem(path, text)
    elif placed:  # a file alone may be the hazard of the site itself; its reader checks that
        for key in {"latitude", "longitude"}.difference(placed) if placed != ["grid"] else ():
            yield Problem((*path, key), "missing; latitude and longitude go together")
    elif typed:
        for key, table in typed.items():
            if table.return_period_years is not None:
                yield from _return_period(
                    (*path, key, "return_period_years"), key, table.return_period_years, site
                )
        for key in limit_states:
            if key not in typed:
                text = "missing, but assessment.limit_states asks for it; add its ag_g, F0 and Tc_star_s"
                yield Problem((*path, key), text)
    else:
        text = "no hazard; add latitude and longitude, or ag_g, F0 and Tc_star_s per limit state"
        yield Problem(path, text)


def _return_period(path: KeyPath, limit_state: str, given: float, site: SiteTable) -> Iterator[Problem]:
    """Yield a problem where the return period (years) of a typed hazard is not that of nominal life and use class.

    Within RETURN_PERIOD_TOL, as typed values are rounded (NTC 2018, §3.2.1).
    """
    by_life = return_period(limit_state, site.nominal_life_years, site.use_class)
    if abs(given / by_life - 1.0) > RETURN_PERIOD_TOL:
        text = (
            f"{given:g} years, but nominal_life_years = {site.nominal_life_years:g} and use_class = "
            f'"{site.use_class}" make {by_life:.4g} at {limit_state}; correct one of them'
        )
        yield Problem(path, text)


def mechanism_problems(project: ProjectContent) -> Iterator[Problem]:
    """Yield a problem for each macro-block without blocks or rotation, or in another state than its mechanism."""
    states: dict[str, str] = {}
    for index, part in enumerate(project.mechanism):
        path: KeyPath = ("mechanism", index)
        if not (part.layers or part.region_m or part.blocks):
            yield Problem(path, "no block is chosen; write layers, region_m or blocks")
        if part.region_m is not None and (len(part.region_m) < 4 or len(part.region_m) % 2):
            text = "no corners; write x and z of two corners of a box, or of each corner of a polygon"
            yield Problem((*path, "region_m"), text)
        if abs(part.rotation) < LEAST_ROTATION:
            yield Problem(
                (*path, "rotation"), f"{part.rotation:g} does not move the macro-block; leave the entry out"
            )
        yield from unknown_name((*path, "state"), part.state, project.states, "state")
        if part.state != states.setdefault(part.name, part.state):
            yield Problem(
                (*path, "state"), f'"{part.name}" has macro-blocks in another state; write one state'
            )


def sensitivity_problems(project: ProjectContent, sensitivity: SensitivityTable) -> Iterator[Problem]:
    """Yield a problem for each property that is varied without an effect, and for each state that does not exist."""
    path: KeyPath = ("sensitivity",)
    if project.assessment is None:
        yield Problem(path, "there is no capacity to vary; add [assessment] or leave [sensitivity] out")
    elif project.assessment.model == "none" and sensitivity.stiffness:
        text = 'assessment.model = "none" uses no stiffness; leave it out or write another model'
        yield Problem((*path, "stiffness"), text)
    if not sensitivity.factors:
        yield Problem(path, f"nothing varies; write low and high factors of {', '.join(VARIED)}")
    for key, (low, high) in sensitivity.factors.items():
        if not low < high:
            yield Problem(
                (*path, key), f"[{low:g}, {high:g}] is no range; write the low factor, then the high one"
            )
    for index, name in enumerate(sensitivity.states or ()):
        yield from unknown_name((*path, "states", index), name, project.states, "state")
