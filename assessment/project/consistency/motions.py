"""Contradictions in [[history]], [incremental] and [campaign]: records, motions, states."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from assessment.project.consistency.files import matches, missing_file
from assessment.project.consistency.names import repeated_names, unknown_name
from assessment.project.consistency.structure import LEAST_MOVEMENT, movement
from assessment.project.errors import Problem
from assessment.project.schema import CampaignTable, KeyPath, MotionTable, ProjectContent, StatesTable


def motion_problems(project: ProjectContent, folder: Path) -> Iterator[Problem]:
    """Yield a problem for each record, motion and state of [[history]], [incremental] and [campaign] that is wrong.

    `folder`: of the project, in which records are looked for.
    """
    yield from repeated_names("history", [history.name for history in project.history])
    for index, history in enumerate(project.history):
        path: KeyPath = ("history", index)
        yield from missing_file(folder, (*path, "record"), history.record)
        yield from missing_file(folder, (*path, "vertical_record"), history.vertical_record)
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
            yield from missing_file(folder, (*path, index), pattern)


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
        yield from unknown_name((*path, "settlements", index), name, project.unstrengthened[1:], "settlement")
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
    yield from _shares(project, campaign, (*path, "shares"))
    for key in ("periods_s", "scale_limits"):
        low, high = getattr(campaign, key)
        if not low < high:
            text = f"[{low:g}, {high:g}] is no range; write the lower one, then the higher one"
            yield Problem((*path, key), text)
    for index, number in enumerate(campaign.curve_members or ()):
        if number > project.scatter:
            text = (
                f"{number}: scatter = {project.scatter} runs no such member; write {project.scatter} or less"
            )
            yield Problem((*path, "curve_members", index), text)
    by_site = project.assessment and project.assessment.site and project.assessment.spectrum == "ntc"
    if (campaign.generated or campaign.spectrum_compatible) and not by_site:
        text = 'the spectrum of the site is asked for; add [assessment.site], with spectrum = "ntc"'
        yield Problem((*path, "records" if campaign.generated else "spectrum_compatible"), text)


def _shares(project: ProjectContent, campaign: CampaignTable, path: KeyPath) -> Iterator[Problem]:
    """Yield a problem for each share of a movement, other than none of it, that moves nothing."""
    chosen = [
        each for each in project.settlements if each.name in (campaign.settlements or project.unstrengthened)
    ]
    smallest = min(map(movement, chosen), default=1.0)
    for index, share in enumerate(campaign.shares):
        if 0.0 < share * max(smallest, LEAST_MOVEMENT) < LEAST_MOVEMENT:
            text = f"{share:g} of the movement moves nothing; write 0 for the structure as drawn, or more"
            yield Problem((*path, index), text)


def _states(project: ProjectContent, path: KeyPath, motion: StatesTable) -> Iterator[Problem]:
    for index, name in enumerate(motion.states or ()):
        yield from unknown_name((*path, "states", index), name, project.states, "state")


def _motion(project: ProjectContent, path: KeyPath, motion: MotionTable) -> Iterator[Problem]:
    if isinstance(motion.window_s, tuple) and not 0.0 <= motion.window_s[0] < motion.window_s[1]:
        yield Problem(
            (*path, "window_s"), "not a stretch of time; write first and last second, 0 ≤ first < last"
        )
