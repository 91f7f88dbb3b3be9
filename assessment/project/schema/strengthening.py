"""Ties and strengthening: [[tie]], [[strengthening]]."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import ConfigDict, Field

from assessment.project.schema.values import (
    MOST_LAYERS,
    BarStiffness,
    Friction,
    Name,
    Names,
    Pair,
    Rigidity,
    Stiffness,
    Strength,
    Table,
    Tension,
    Yield,
    without_default,
)


class TieTable(Table):
    """[[tie]]: a tie rod (catena) between two points of blocks or supports; it pulls and never pushes."""

    name: Name = Field(description="name of the tie")
    from_m: Pair = Field(description="x and z, m, of one end as drawn, in or on a block")
    to_m: Pair = Field(description="x and z, m, of the other end, in or on another block")
    yield_force_kN: Yield = Field(
        default=math.inf,
        description="force, kN, at which it lengthens without bearing more: of bar, anchorage or masonry under the "
        "plate, the least; inf (default): none",
        json_schema_extra=without_default,
    )
    stiffness_kN_m: BarStiffness | None = Field(
        default=None, description="stiffness E A / L of the whole tie, kN/m; absent: rigid"
    )
    pretension_kN: Tension = Field(
        default=0.0, description="tension, kN, when it is set; counts in elastic analyses only"
    )
    states: Names | None = Field(
        default=None, description="states in which it is there; default every state, from the beginning"
    )


class ChangedLayerTable(Table):
    """[strengthening.layers.NAME]: what repointing or injection makes of the joints of a layer."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1})

    friction: Friction | None = Field(default=None, description="tangent of the friction angle from then on")
    normal_stiffness_kN_m3: Stiffness | None = Field(
        default=None, description="normal stiffness from then on, kN/m³"
    )
    tangential_stiffness_kN_m3: Rigidity | None = Field(
        default=None, description="tangential stiffness from then on, kN/m³"
    )
    compressive_strength_kN_m2: Strength | None = Field(
        default=None, description="compressive strength from then on, kN/m²"
    )


class StrengtheningTable(Table):
    """[[strengthening]]: a state beside the one that it strengthens: its movement first, then ties and layers."""

    name: Name = Field(description="name of the strengthened state, for `states` of its ties")
    of: Name = Field(description='state that it strengthens: "original" or the name of a settlement')
    layers: Annotated[dict[Name, ChangedLayerTable], Field(max_length=MOST_LAYERS)] = Field(
        default={}, description="layers whose joints it changes"
    )
