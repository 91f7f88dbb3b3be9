"""The increments of settlements and pushover: halved to converge, and varied as another user might have chosen them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.schema import SettlementTable


def in_increments(project: Project, factor: float) -> Project:
    """Return the project with increments `factor` times as large: a settlement has a whole number of equal ones."""
    pushover = project.pushover
    larger = pushover and pushover.model_copy(update={"increment_m": factor * pushover.increment_m})
    settlements = tuple(_in_increments(each, factor) for each in project.settlements)
    return project.model_copy(update={"settlements": settlements, "pushover": larger})


def refined(project: Project, halvings: int) -> Project:
    """Return the project with the increments halved `halvings` times: exactly so many times as many."""
    return in_increments(project, 0.5**halvings) if halvings else project


def finest(project: Project, halvings: Mapping[str, int]) -> list[tuple[Project, SettlementTable]]:
    """Return each settlement in the increments at which its state converged, with the project in those increments.

    `halvings`: how often the increments of each state, by name, were halved; 0 for a state that is not there.
    """
    projects = [refined(project, halvings.get(each.name, 0)) for each in project.settlements]
    return [(each, each.settlements[number]) for number, each in enumerate(projects)]


def _in_increments(settlement: SettlementTable, factor: float) -> SettlementTable:
    count = max(1, round(settlement.increments / factor))
    movement, rotation = max(map(abs, settlement.displacement_m)), abs(settlement.rotation_rad)
    shares = {"increment_m": movement / count, "increment_rad": rotation / count}
    return settlement.model_copy(update={key: share for key, share in shares.items() if share > 0.0})
