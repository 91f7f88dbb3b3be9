"""Static analyses: [[settlements]], [pushover]."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field

from assessment.project.schema.values import (
    Angle,
    AngleStep,
    ContactsList,
    Direction,
    Directions,
    Movement,
    Name,
    Step,
    Table,
)


class SettlementTable(Table):
    """[[settlements]]: a support movement, and with it a state beside the state "original"."""

    name: Name = Field(description="name of the settled state")
    support: Name = Field(description="the support that moves, as named in [layers]")
    displacement_m: Movement = Field(default=(0.0, 0.0), description="movement along x and z, m")
    rotation_rad: Angle = Field(
        default=0.0, description="rotation about the support's centroid, anticlockwise, rad"
    )
    increment_m: Step = Field(default=0.001, description="step of the largest component of the movement, m")
    increment_rad: AngleStep = Field(default=0.001, description="largest step of the rotation, rad")
    to_collapse: bool = Field(
        default=False, description="also look for the ultimate movement along the same direction"
    )
    after: Name | None = Field(
        default=None,
        description="name of the settlement in whose state this movement begins, and from which it counts; default as "
        "drawn",
    )
    steps: Annotated[int, Field(ge=2, le=100)] | None = Field(
        default=None, description="review the capacity after each of so many equal parts of the movement too"
    )

    @property
    def increments(self) -> int:
        """Number of equal increments that keep within both limits, at least one."""
        movement = max(map(abs, self.displacement_m)) / self.increment_m
        return max(1, math.ceil(max(movement, abs(self.rotation_rad) / self.increment_rad) - 1e-9))


class PushoverTable(Table):
    """[pushover]: lateral loads proportional to weight, from every state."""

    contacts: ContactsList = Field(default=("rigid",), description="contact models: rigid, elastic or both")
    directions: Directions = Field(default=("+x", "-x"), description="directions of the lateral loads")
    increment_m: Step = Field(default=0.001, description="step of the control point's displacement, m")
    control: Name | Annotated[dict[Direction, Name], Field(min_length=1)] | None = Field(
        default=None,
        description='control point, or one per direction: {"+x" = "C1", "-x" = "C2"}; default the first',
    )
