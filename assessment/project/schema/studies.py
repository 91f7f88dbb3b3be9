"""Studies: [campaign], [sensitivity]."""

from __future__ import annotations

import re
from typing import Annotated, Literal

from pydantic import Field

from assessment.project.schema.dynamic import MotionTable
from assessment.project.schema.values import (
    Factor,
    Factors,
    Levels,
    MemberNumbers,
    Names,
    Periods,
    RecordSet,
    Seconds,
    Shares,
    Signs,
    Table,
)

GENERATE = re.compile(r"generate:([1-9]\d{0,2})")
"""In the place of record files: so many records are made."""

VARIED = ("friction", "stiffness", "unit_weight", "depth")
"""The properties that [sensitivity] can vary."""


class CampaignTable(MotionTable):
    """[campaign]: records x movements x shares of them x signs; fragility and loss of capacity against movement."""

    records: RecordSet = Field(
        description='record files, patterns such as "records/*.acc" are expanded; or "generate:7": so many records '
        "made to the spectrum of the site"
    )
    settlements: Names | None = Field(default=None, description="names of settlements; default all")
    shares: Shares = Field(default=(0.0, 0.25, 0.5, 0.75, 1.0), description="parts of each movement, 0 to 1")
    signs: Signs = Field(default=(1, -1), description="factors on each record: 1, -1 or both")
    measure: Literal["PGA", "Sa(T)"] = Field(
        default="PGA",
        description="intensity: PGA, or Sa(T), the spectral acceleration at period_s, 5 % damping",
    )
    period_s: Seconds | None = Field(default=None, description="period T of Sa(T), s")
    method: Literal["incremental", "stripes"] = Field(
        default="incremental",
        description="incremental: the level at collapse of each combination is searched; stripes: all at levels_g",
    )
    levels_g: Levels | None = Field(default=None, description="levels of the stripes, g, of the measure")
    tolerance: Annotated[float, Field(ge=1e-3, le=0.5)] = Field(
        default=0.05, description="tolerance of the level at collapse, relative to it"
    )
    max_scale: Factor = Field(default=5.0, description="largest factor on a record that is tried")
    spectrum_compatible: bool = Field(
        default=False, description="scale each record to the spectrum of the site between periods_s"
    )
    periods_s: Periods = Field(default=(0.15, 2.0), description="first and last period of that spectrum, s")
    scale_limits: Factors = Field(default=(0.5, 2.0), description="least and largest factor of that scaling")

    curve_members: MemberNumbers | None = Field(
        default=None,
        description="members of the ensembles whose displacement over time is kept, 1: the record itself; default none",
    )

    @property
    def generated(self) -> int:
        """Number of records to generate, 0 where files are named."""
        found = GENERATE.fullmatch(self.records[0])
        return int(found[1]) if found else 0


class SensitivityTable(Table):
    """[sensitivity]: the capacity a_g again, with one property of the masonry lower and higher at a time."""

    friction: Factors | None = Field(
        default=None, description="low and high factor on every friction, such as [0.8, 1.2]"
    )
    stiffness: Factors | None = Field(
        default=None, description="low and high factor on every joint stiffness, normal and tangential"
    )
    unit_weight: Factors | None = Field(default=None, description="low and high factor on every unit weight")
    depth: Factors | None = Field(default=None, description="low and high factor on every out-of-plane depth")
    states: Names | None = Field(
        default=None,
        description='states to vary: "original", names of settlements and strengthenings; default all',
    )

    @property
    def factors(self) -> dict[str, tuple[float, float]]:
        """The properties to vary and their low and high factors."""
        return {key: getattr(self, key) for key in VARIED if getattr(self, key) is not None}
