"""Geometry and material: [geometry], [material], [layers], [contacts], [[control]]."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from assessment.project.schema.values import (
    Drawn,
    Friction,
    Length,
    Load,
    Name,
    Pair,
    Rigidity,
    Segments,
    Share,
    Stiffness,
    Strength,
    Table,
    UnitWeight,
    UseCategory,
    without_default,
)


class GeometryTable(Table):
    """[geometry]: the drawing and how it becomes blocks and joints."""

    drawing: Name = Field(description="DXF file with one closed polyline per block")
    unit: Literal["mm", "cm", "m"] = Field(description="unit of the drawing: mm, cm or m")
    depth_m: Length = Field(description="out-of-plane depth, m; default of every layer")
    segments_per_joint: Segments | None = Field(
        default=None,
        description="absent: elastic joints are exact; a number: the contact points of the paper at the ends of so "
        "many segments of each joint, for comparison",
    )
    tolerance_m: Drawn | None = Field(
        default=None, description="edges closer than this, m, form a joint; default from the drawing's size"
    )
    sagitta_m: Drawn | None = Field(
        default=None,
        description="largest distance, m, between a drawn arc and its chords; default from its size",
    )


class MaterialTable(Table):
    """[material]: stone and joints, default of every layer."""

    unit_weight_kN_m3: UnitWeight = Field(description="unit weight of the stone, kN/m³")
    friction: Friction = Field(
        default=0.6, description="tangent of the friction angle of a joint; inf: no sliding"
    )
    normal_stiffness_kN_m3: Stiffness | None = Field(
        default=None,
        description="normal stiffness of a joint per unit area, kN/m³; needed by elastic analyses only",
    )
    tangential_stiffness_kN_m3: Rigidity = Field(
        default=math.inf,
        description="tangential stiffness of a joint per unit area, kN/m³; inf (default): rigid in shear",
        json_schema_extra=without_default,
    )
    compressive_strength_kN_m2: Strength = Field(
        default=math.inf,
        description="compressive strength of a joint, kN/m²; inf (default): no crushing",
        json_schema_extra=without_default,
    )


class LayerTable(Table):
    """[layers.NAME]: what the blocks on one layer of the drawing have of their own."""

    unit_weight_kN_m3: UnitWeight | None = Field(
        default=None, description="unit weight, kN/m³, instead of [material]'s"
    )
    friction: Friction | None = Field(
        default=None, description="tangent of friction angle, instead of [material]'s"
    )
    normal_stiffness_kN_m3: Stiffness | None = Field(
        default=None, description="normal stiffness, kN/m³, instead of [material]'s"
    )
    tangential_stiffness_kN_m3: Rigidity | None = Field(
        default=None, description="tangential stiffness, kN/m³, instead of [material]'s"
    )
    compressive_strength_kN_m2: Strength | None = Field(
        default=None, description="compressive strength, kN/m², instead of [material]'s"
    )
    depth_m: Length | None = Field(default=None, description="out-of-plane depth, m, instead of [geometry]'s")
    segments_per_joint: Segments | None = Field(
        default=None, description="segments of each joint with contact points, instead of [geometry]'s"
    )
    support: Name | None = Field(
        default=None, description="the blocks of this layer are a support of this name"
    )
    vertical_load_kN: Load = Field(
        default=0.0,
        description="permanent load G on each block of the layer, kN, downward, at its centroid",
    )
    variable_load_kN: Annotated[float, Field(ge=0, le=1e9)] = Field(
        default=0.0,
        description="characteristic variable load Q on each block, kN; ψ₂ Q acts with the permanent one",
    )
    use_category: UseCategory | None = Field(
        default=None,
        description='category of the variable load, NTC 2018 Tab. 2.5.I: A to H, "snow", "snow above 1000 m", "wind"; '
        "I and K with psi_2",
    )
    psi_2: Share | None = Field(default=None, description="ψ₂, instead of that of use_category")
    load_has_mass: bool = Field(default=True, description="the loads also count as seismic mass")


class ContactsTable(Table):
    """[contacts]: how joints slide, and whether blocks that are apart may come to touch."""

    sliding: Literal["coulomb", "associative"] = Field(
        default="associative",
        description="associative: a joint that slides opens, as in the paper; coulomb: it does not",
    )
    collisions: bool = Field(
        default=True, description="blocks that are apart in the drawing may come to touch as they move"
    )


class ControlTable(Table):
    """[[control]]: a point whose displacement is followed; the first one is the default."""

    name: Name = Field(description="name of the control point")
    point_m: Pair = Field(description="x and z, m, in or on a block; the point moves with it")
