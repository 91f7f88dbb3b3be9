"""Dynamic analyses: [[history]], [incremental], and what all motions have in common."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from assessment.project.schema.values import (
    Acceleration,
    Contacts,
    Damping,
    Factor,
    Name,
    Names,
    Ratio,
    Seconds,
    Table,
    Window,
)


class MotionTable(Table):
    """What [[history]], [incremental] and [campaign] have in common: how a motion is integrated."""

    time_step_s: Seconds | None = Field(
        default=None,
        description="time step, s; default the record's; also the sampling step of a one-column record",
    )
    window_s: Window | Literal["arias"] | None = Field(
        default=None,
        description='first and last second of the record to use, or "arias": from 0.1 % of its Arias intensity, '
        "or 5 % of its peak if that is earlier, to 95 %",
    )
    contacts: Contacts = Field(default="elastic", description="contact model: rigid or elastic")
    integrator: Literal["auto", "moreau-jean", "second-order", "implicit-euler"] = Field(
        default="auto",
        description="time integration: auto (the results say which it took), moreau-jean (many "
        "impacts), second-order, or implicit-euler (the paper's)",
    )
    damping_ratio: Damping | None = Field(default=None, description="viscous damping ratio of the contacts")
    control: Name | None = Field(default=None, description="control point; default the first")


class StatesTable(MotionTable):
    """What [[history]] and [incremental] have in common: motions from states of the project."""

    states: Names | None = Field(
        default=None,
        description='states to analyse: "original", names of settlements and strengthenings; default all',
    )


class HistoryTable(StatesTable):
    """[[history]]: a time history of one record, from every state."""

    record: Name = Field(
        description="file of the horizontal ground acceleration; records/artificial.csv comes with a new project"
    )
    name: Name | None = Field(
        default=None, description="name in tables and figures; default the record's file name"
    )
    scale: Ratio = Field(default=1.0, description="factor on the accelerations of the record; not zero")
    vertical_record: Name | None = Field(default=None, description="file of the vertical ground acceleration")
    animation: bool = Field(default=False, description="also write the motion from every state as a GIF")


class IncrementalTable(StatesTable):
    """[incremental]: incremental dynamic analysis, PGA at incipient collapse per record and state."""

    records: Names = Field(description='record files; patterns such as "records/*.acc" are expanded')
    tolerance_g: Acceleration = Field(default=0.01, description="tolerance of the PGA at collapse, g")
    max_scale: Factor = Field(default=5.0, description="largest factor on a record that is tried")
