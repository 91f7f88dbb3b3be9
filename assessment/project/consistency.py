"""What in a project does not fit together: names, files, and stages that need each other."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from fnmatch import fnmatch
from itertools import islice
from pathlib import Path

from assessment.ntc.load_factors import OWN_PSI_2, PSI_2
from assessment.project.errors import Problem
from assessment.project.schema import (
    MOST_ENTRIES,
    ORIGINAL,
    VARIED,
    AssessmentTable,
    CampaignTable,
    FloorTable,
    KeyPath,
    KnowledgeTable,
    LayerTable,
    LimitState,
    MotionTable,
    ProjectContent,
    SensitivityTable,
    SettlementTable,
    SiteTable,
    StatesTable,
)
from assessment.runtime.errors import nearest

_MOST_INCREMENTS = 100_000
HIGHEST = 40.0  # m: of a building whose period the standard's formula gives
RETURN_PERIOD_TOL = 0.02  # relative: 50, 475 and 975 years stand for 50.3, 474.6 and 974.8
MOST_LOOKED_AT = 20_000  # names in folders, to find the files that a pattern means
PICTURES = (".png", ".jpg", ".jpeg")  # that a report can hold
LEAST_ROTATION = 1e-6  # of a macro-block, relative to the others'
_WILD = re.compile(r"[*?[]")


def content_problems(project: ProjectContent, folder: Path) -> Iterator[Problem]:
    """Every problem between tables and with the files they name, in the order of the tables."""
    yield from _file(folder, ("geometry", "drawing"), project.geometry.drawing)
    yield from _stiffness(project)
    for name, layer in project.layers.items():
        yield from _loads(("layers", name), layer)
    yield from _doubles("control", [point.name for point in project.control])
    yield from _control(project)
    yield from _doubles("settlements", list(project.states[1:]))
    for index, settlement in enumerate(project.settlements):
        yield from _settlement(project, ("settlements", index), settlement)
    yield from _motions(project, folder)
    for index, name in enumerate(project.report.attachments):
        yield from _attachment(folder, ("report", "attachments", index), name)
    yield from _mechanisms(project)
    if project.assessment:
        yield from _assessment(project, project.assessment)
        if project.assessment.knowledge:
            yield from _knowledge(project.assessment.knowledge, project.assessment.confidence_factor)
        if project.assessment.floor:
            yield from _floor(project.assessment.floor, project.assessment)
        if project.assessment.site:
            yield from _site(project.assessment.site, project.assessment.limit_states, folder)
    if project.sensitivity:
        yield from _sensitivity(project, project.sensitivity)


def _loads(path: KeyPath, layer: LayerTable) -> Iterator[Problem]:
    if layer.vertical_load_kN < 0.0 and layer.load_has_mass:
        text = f"{layer.vertical_load_kN:g} acts upward and has no mass; add load_has_mass = false"
        yield Problem((*path, "vertical_load_kN"), text)
    category, psi_2 = layer.use_category, layer.psi_2
    if layer.variable_load_kN == 0.0:
        for key in ("use_category", "psi_2"):
            if getattr(layer, key) is not None:
                yield Problem((*path, key), "there is no variable load; add variable_load_kN or leave it out")
    elif psi_2 is None and category is None:
        text = "ψ₂ is not known; add use_category (NTC 2018, Tab. 2.5.I), or psi_2"
        yield Problem((*path, "variable_load_kN"), text)
    elif psi_2 is None and category in OWN_PSI_2:
        text = f"{category} has no ψ₂ in NTC 2018, Tab. 2.5.I, it is to be judged case by case; add psi_2"
        yield Problem((*path, "use_category"), text)
    elif psi_2 is not None and PSI_2.get(category or "", psi_2) != psi_2:
        text = (
            f'{psi_2:g}, but use_category = "{category}" has {PSI_2[category or ""]:g}; leave one of them out'
        )
        yield Problem((*path, "psi_2"), text)


def matches(folder: Path, pattern: str) -> list[Path]:
    """Return the files in `folder` that a name or a pattern such as "records/*.acc" means, sorted.

    Raises ValueError where more than MOST_LOOKED_AT names would have to be looked at, or there are too many files.
    """
    if _is_file(folder / pattern):
        return [folder / pattern]
    if "**" in pattern:
        raise ValueError("** is not understood; name the folders, * for each")
    found, looked_at = [folder], 0
    for part in Path(pattern).parts:
        if not _WILD.search(part):
            found = [path / part for path in found]
            continue
        within: list[Path] = []
        for path in found:
            for name in _names(path):
                looked_at += 1
                if looked_at > MOST_LOOKED_AT:
                    raise ValueError(f"more than {MOST_LOOKED_AT} names to look at; name the folders")
                if fnmatch(name, part) and (part.startswith(".") or not name.startswith(".")):
                    within.append(path / name)
        found = within
    files = sorted(path for path in found if _is_file(path))
    if len(files) > MOST_ENTRIES:
        raise ValueError(f"{len(files)} files, at most {MOST_ENTRIES}; choose among them")
    return files


def _names(folder: Path) -> Iterator[str]:
    """Yield the names in a folder; none where there is no such folder, or it may not be read."""
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            yield entry.name


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name that is too long or no name, a folder that may not be searched
        return False


def _attachment(folder: Path, path: KeyPath, name: str) -> Iterator[Problem]:
    """Open a picture of the report as a run opens it."""
    from PIL import Image  # late: few projects have any

    if missing := list(_file(folder, path, name)):
        yield from missing
    elif Path(name).suffix.lower() not in PICTURES:
        yield Problem(
            path, f'"{name}" is no {" or ".join(PICTURES)} file; export it, a PDF page by page, as one'
        )
    else:
        try:
            with Image.open(folder / name) as picture:
                picture.load()
        except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
            yield Problem(path, f'"{name}" cannot be read as a picture ({error}); export it again')


def _file(folder: Path, path: KeyPath, name: str | None) -> Iterator[Problem]:
    if name is not None and not _is_file(folder / name):
        parent = Path(name).parent
        names = islice(_names(folder / parent), MOST_ENTRIES)
        files = sorted(str(parent / each) for each in names if _is_file(folder / parent / each))
        remedy = nearest(name, files) if files else "put it there or correct the name"
        yield Problem(path, f'no file "{name}" in the project folder; {remedy}')


def _doubles(table: str, names: list[str | None]) -> Iterator[Problem]:
    earlier: set[str] = set()
    for index, name in enumerate(names):
        if name is None:
            continue
        if name in earlier:
            yield Problem((table, index, "name"), f'"{name}" is the name of an earlier entry; write another')
        earlier.add(name)


def _known(path: KeyPath, name: str, valid: Iterable[str], what: str) -> Iterator[Problem]:
    names = list(valid)
    if name not in names:
        yield Problem(path, f'no {what} "{name}"; {nearest(name, names) if names else f"add a {what}"}')


def _stiffness(project: ProjectContent) -> Iterator[Problem]:
    """Ask for a stiffness somewhere if an analysis is elastic; which blocks lack it, the drawing tells."""
    layers = project.layers.values()
    if project.material.normal_stiffness_kN_m3 or any(layer.normal_stiffness_kN_m3 for layer in layers):
        return
    pushover, incremental, assessment = project.pushover, project.incremental, project.assessment
    needed_by = [
        f"history[{n}].contacts" for n, each in enumerate(project.history, 1) if each.contacts == "elastic"
    ]
    if pushover and "elastic" in pushover.contacts:
        needed_by.append("pushover.contacts")
    if incremental and incremental.contacts == "elastic":
        needed_by.append("incremental.contacts")
    if project.campaign and project.campaign.contacts == "elastic":
        needed_by.append("campaign.contacts")
    if assessment and assessment.model != "none":
        needed_by.append("assessment.model")
    if needed_by:
        text = (
            f"missing, but {', '.join(needed_by)} ask for elastic contacts; add it, in kN/m³ "
            '(or write contacts "rigid", model "none")'
        )
        yield Problem(("material", "normal_stiffness_kN_m3"), text)


def _control(project: ProjectContent) -> Iterator[Problem]:
    moved = project.pushover or project.history or project.incremental or project.campaign
    if not project.control and moved:
        yield Problem(("control",), "no control point; add [[control]] with name and point_m")
        return
    references: list[tuple[KeyPath, str | None]] = [
        (("history", index, "control"), motion.control) for index, motion in enumerate(project.history)
    ]
    if project.pushover:
        control = project.pushover.control
        by_key = control.items() if isinstance(control, dict) else ()
        references += [(("pushover", "control", direction), name) for direction, name in by_key]
        references += [(("pushover", "control"), control)] if isinstance(control, str) else []
    if project.incremental:
        references.append((("incremental", "control"), project.incremental.control))
    if project.campaign:
        references.append((("campaign", "control"), project.campaign.control))
    for path, name in references:
        if name is not None:
            yield from _known(path, name, [point.name for point in project.control], "control point")


def _settlement(project: ProjectContent, path: KeyPath, settlement: SettlementTable) -> Iterator[Problem]:
    if settlement.name == ORIGINAL:
        yield Problem((*path, "name"), f'"{ORIGINAL}" is the state before any settlement; write another name')
    yield from _known((*path, "support"), settlement.support, project.supports, "support")
    largest = max(map(abs, settlement.displacement_m))
    if largest == 0.0 and settlement.rotation_rad == 0.0:
        yield Problem((*path, "displacement_m"), "nothing moves; write a displacement or a rotation_rad")
    elif "increment_m" in settlement.model_fields_set and settlement.increment_m > largest > 0.0:
        text = f"{settlement.increment_m:g} is larger than the movement; write {largest:g} or less"
        yield Problem((*path, "increment_m"), text)
    if settlement.increments > _MOST_INCREMENTS:
        text = (
            f"the movement takes {settlement.increments} increments; "
            f"write longer ones, for {_MOST_INCREMENTS} or fewer"
        )
        yield Problem((*path, "increment_m"), text)
    if settlement.steps and not project.pushover:
        text = "there is no pushover whose capacity could be reviewed; add [pushover] or leave steps out"
        yield Problem((*path, "steps"), text)


def _motions(project: ProjectContent, folder: Path) -> Iterator[Problem]:
    yield from _doubles("history", [history.name for history in project.history])
    for index, history in enumerate(project.history):
        path: KeyPath = ("history", index)
        yield from _file(folder, (*path, "record"), history.record)
        yield from _file(folder, (*path, "vertical_record"), history.vertical_record)
        if history.scale == 0.0:
            yield Problem((*path, "scale"), "0 leaves no motion; write 1.0 for the record as it is")
        yield from _motion(project, path, history)
        yield from _states(project, path, history)
    if project.incremental:
        yield from _records(folder, ("incremental", "records"), project.incremental.records)
        yield from _motion(project, ("incremental",), project.incremental)
        yield from _states(project, ("incremental",), project.incremental)
    if project.campaign:
        yield from _campaign(project, project.campaign, folder)


def _records(folder: Path, path: KeyPath, patterns: Iterable[str]) -> Iterator[Problem]:
    for index, pattern in enumerate(patterns):
        try:
            found = matches(folder, pattern)
        except ValueError as error:
            yield Problem((*path, index), f'"{pattern}": {error}')
            continue
        if not found:
            yield from _file(folder, (*path, index), pattern)


def _campaign(project: ProjectContent, campaign: CampaignTable, folder: Path) -> Iterator[Problem]:
    path: KeyPath = ("campaign",)
    generated = [name for name in campaign.records if name.startswith("generate:")]
    if generated and not campaign.generated:
        text = f'"{generated[0]}" is no number of records; write "generate:7" or another number from 1 to 999'
        yield Problem((*path, "records"), text)
    elif generated and len(campaign.records) > 1:
        yield Problem((*path, "records"), f'"{generated[0]}" stands alone; write it, or files')
    elif not generated:
        yield from _records(folder, (*path, "records"), campaign.records)
    yield from _motion(project, path, campaign)
    if not project.settlements:
        yield Problem((*path, "settlements"), "no movement; add [[settlements]] with name and support")
    for index, name in enumerate(campaign.settlements or ()):
        yield from _known((*path, "settlements", index), name, project.states[1:], "settlement")
    if campaign.measure == "Sa(T)" and campaign.period_s is None:
        yield Problem(
            (*path, "period_s"), 'missing, but measure = "Sa(T)" asks for it; add the period T, in s'
        )
    if campaign.measure == "PGA" and campaign.period_s is not None:
        yield Problem((*path, "period_s"), 'the PGA has no period; leave it out or write measure = "Sa(T)"')
    if campaign.method == "stripes" and campaign.levels_g is None:
        yield Problem((*path, "levels_g"), 'missing, but method = "stripes" asks for it; add levels in g')
    if campaign.method == "incremental" and campaign.levels_g is not None:
        text = 'the incremental search finds its own levels; leave it out or write method = "stripes"'
        yield Problem((*path, "levels_g"), text)
    for key in ("shares", "levels_g"):
        values = getattr(campaign, key) or ()
        if list(values) != sorted(values):
            yield Problem((*path, key), "not in order; write the smallest first")
    for key in ("periods_s", "scale_limits"):
        low, high = getattr(campaign, key)
        if not low < high:
            yield Problem((*path, key), f"[{low:g}, {high:g}]: write the lower one, then the higher one")
    by_site = project.assessment and project.assessment.site and project.assessment.spectrum == "ntc"
    if (campaign.generated or campaign.spectrum_compatible) and not by_site:
        text = 'the spectrum of the site is asked for; add [assessment.site], with spectrum = "ntc"'
        yield Problem((*path, "records" if campaign.generated else "spectrum_compatible"), text)


def _states(project: ProjectContent, path: KeyPath, motion: StatesTable) -> Iterator[Problem]:
    for index, name in enumerate(motion.states or ()):
        yield from _known((*path, "states", index), name, project.states, "state")


def _motion(project: ProjectContent, path: KeyPath, motion: MotionTable) -> Iterator[Problem]:
    if isinstance(motion.window_s, tuple) and not 0.0 <= motion.window_s[0] < motion.window_s[1]:
        yield Problem(
            (*path, "window_s"), "not a stretch of time; write first and last second, 0 ≤ first < last"
        )
    if motion.integrator == "moreau-jean" and motion.contacts == "elastic":
        text = 'moreau-jean is for rigid contacts; write "auto", "second-order" or "implicit-euler"'
        yield Problem((*path, "integrator"), text)


def _assessment(project: ProjectContent, assessment: AssessmentTable) -> Iterator[Problem]:
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
    if assessment.method == "grid" and (assessment.site is None or assessment.site.grid is None):
        text = (
            'there is no grid; add latitude, longitude and grid to [assessment.site] or write "demand-shape"'
        )
        yield Problem(("assessment", "method"), text)


def _knowledge(knowledge: KnowledgeTable, factor: float) -> Iterator[Problem]:
    """Compare confidence_factor with the level of knowledge or the components that it follows from."""
    from assessment.ntc.indices import (  # late: a run without changes loads no numpy
        COMPONENTS,
        confidence_factor,
    )

    path: KeyPath = ("assessment", "knowledge")
    given = knowledge.components
    if (knowledge.level is None) == (not given):
        yield Problem(path, f"write level, or {', '.join(COMPONENTS)}, not both")
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


def _floor(floor: FloorTable, assessment: AssessmentTable) -> Iterator[Problem]:
    path: KeyPath = ("assessment", "floor")
    if floor.height_m > floor.building_height_m:
        text = f"{floor.height_m:g} is above building_height_m ({floor.building_height_m:g}); correct one of them"
        yield Problem((*path, "height_m"), text)
    if floor.period_s is None and floor.building_height_m > HIGHEST:
        text = f"missing; T_1 = 0.05 H^(3/4) holds up to a building_height_m of {HIGHEST:g}"
        yield Problem((*path, "period_s"), f"{text}; write the period, in s")
    if len(floor.higher_periods_s) != len(floor.higher_participations):
        text = "write one γ_k ψ_k for each of higher_periods_s, in the same order"
        yield Problem((*path, "higher_participations"), text)
    if floor.higher_periods_s and assessment.circular == 2009:
        text = "the circular of 2009 knows the first mode alone; leave it out or write circular = 2019"
        yield Problem((*path, "higher_periods_s"), text)
    if assessment.spectrum == "record":
        yield Problem(path, 'a record is taken as that of the ground; write spectrum = "ntc" or leave it out')


def _mechanisms(project: ProjectContent) -> Iterator[Problem]:
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
        yield from _known((*path, "state"), part.state, project.states, "state")
        if part.state != states.setdefault(part.name, part.state):
            yield Problem(
                (*path, "state"), f'"{part.name}" has macro-blocks in another state; write one state'
            )


def _sensitivity(project: ProjectContent, sensitivity: SensitivityTable) -> Iterator[Problem]:
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
            yield Problem((*path, key), f"[{low:g}, {high:g}]: write the low factor, then the high one")
    for index, name in enumerate(sensitivity.states or ()):
        yield from _known((*path, "states", index), name, project.states, "state")


def _site(site: SiteTable, limit_states: Iterable[LimitState], folder: Path) -> Iterator[Problem]:
    path: KeyPath = ("assessment", "site")
    yield from _file(folder, (*path, "grid"), site.grid)
    by_place = {key: getattr(site, key) for key in ("latitude", "longitude", "grid")}
    by_state = {key: getattr(site, key) for key in ("SLD", "SLV", "SLC")}
    placed = [key for key, value in by_place.items() if value is not None]
    typed = [key for key, value in by_state.items() if value is not None]
    if placed and typed:
        text = f"given twice, by {', '.join(placed)} and by {', '.join(typed)}; keep one of the two"
        yield Problem(path, text)
    elif placed and placed != ["grid"]:  # alone, it may be the table of the site; else the file tells
        for key in sorted(by_place.keys() - placed):
            yield Problem((*path, key), "missing; latitude, longitude and grid go together")
    elif placed:
        return
    elif typed:
        for key, table in by_state.items():
            if table is not None and table.return_period_years is not None:
                yield from _return_period(
                    (*path, key, "return_period_years"), key, table.return_period_years, site
                )
        for key in limit_states:
            if key not in typed:
                text = "missing, but assessment.limit_states asks for it; add its ag_g, F0 and Tc_star_s"
                yield Problem((*path, key), text)
    else:
        text = "no hazard; add latitude, longitude and grid, or ag_g, F0 and Tc_star_s per limit state"
        yield Problem(path, text)


def _return_period(path: KeyPath, limit_state: str, given: float, site: SiteTable) -> Iterator[Problem]:
    """Compare the return period of a typed hazard with that of nominal life and use class; both are rounded."""
    from assessment.ntc.hazard import return_period  # late, as above

    by_life = return_period(limit_state, site.nominal_life_years, site.use_class)
    if abs(given / by_life - 1.0) > RETURN_PERIOD_TOL:
        text = (
            f"{given:g} years, but nominal_life_years = {site.nominal_life_years:g} and use_class = "
            f'"{site.use_class}" make {by_life:.4g} at {limit_state}; correct one of them'
        )
        yield Problem(path, text)
