"""The increments of settlements and pushover, halved."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.schema import SettlementTable


def refined(project: Project, halvings: int) -> Project:
    """Return the project with the increments of settlements and pushover halved `halvings` times."""
    if halvings == 0:
        return project
    pushover = project.pushover
    return project.model_copy(
        update={
            "settlements": tuple(_refined(each, 2**halvings) for each in project.settlements),
            "pushover": pushover
            and pushover.model_copy(update={"increment_m": pushover.increment_m / 2**halvings}),
        }
    )


def finest(project: Project, halvings: Mapping[str, int]) -> list[tuple[Project, SettlementTable]]:
    """Return each settlement in the increments at which its state converged, with the project in those increments.

    `halvings`: how often the increments of each state, by name, were halved; 0 for a state that is not there.
    """
    projects = [refined(project, halvings.get(each.name, 0)) for each in project.settlements]
    return [(each, each.settlements[number]) for number, each in enumerate(projects)]


def _refined(settlement: SettlementTable, times: int) -> SettlementTable:
    """Return the settlement in exactly `times` as many equal increments."""
    count = times * settlement.increments
    movement, rotation = max(map(abs, settlement.displacement_m)), abs(settlement.rotation_rad)
    shares = {"increment_m": movement / count, "increment_rad": rotation / count}
    return settlement.model_copy(update={key: share for key, share in shares.items() if share > 0.0})
