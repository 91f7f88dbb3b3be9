"""The increments of settlements and pushover, halved."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from assessment.project.project import Project
    from assessment.project.schema import SettlementTable


def refined(project: Project, halvings: int) -> Project:
    """Return the project with twice as many increments of settlements and pushover, so many times over."""
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


def finest_settlements(project: Project, halvings: Mapping[str, int]) -> list[SettlementTable]:
    """Return the settlements in the increments at which their states ended, `halvings` of those given."""
    return [
        refined(project, halvings.get(each.name, 0)).settlements[number]
        for number, each in enumerate(project.settlements)
    ]


def _refined(settlement: SettlementTable, times: int) -> SettlementTable:
    """Return the settlement in exactly `times` as many increments, whole ones of its movement."""
    count = times * settlement.increments
    movement, rotation = max(map(abs, settlement.displacement_m)), abs(settlement.rotation_rad)
    shares = {"increment_m": movement / count, "increment_rad": rotation / count}
    return settlement.model_copy(update={key: share for key, share in shares.items() if share > 0.0})
