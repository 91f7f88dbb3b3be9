"""Checks against the standard: [assessment] with its site, floor and knowledge, [[mechanism]]."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from assessment.project.schema.values import (
    MOST_ENTRIES,
    MOST_LAYERS,
    ORIGINAL,
    Acceleration,
    BlockNumber,
    Coordinate,
    Length,
    LimitStates,
    Name,
    Names,
    Pair,
    Ratio,
    Seconds,
    Table,
    Text,
)


class HazardTable(Table):
    """[assessment.site.SLV] and so on: the hazard of one limit state, typed in."""

    ag_g: Acceleration = Field(description="peak ground acceleration on rigid level ground, g")
    F0: Annotated[float, Field(ge=1, le=100)] = Field(description="largest amplification of the spectrum")
    Tc_star_s: Seconds = Field(description="T_C*, s: reference for the end of the constant branch")
    return_period_years: Annotated[float, Field(ge=1, le=1e5)] | None = Field(
        default=None,
        description="return period of this hazard, years; it must be that of nominal life and use class",
    )


class SiteTable(Table):
    """[assessment.site]: hazard by coordinates, by a file, or typed in per limit state; ground and use."""

    latitude: Annotated[float, Field(ge=-90, le=90)] | None = Field(
        default=None, description="latitude, degrees north"
    )
    longitude: Annotated[float, Field(ge=-180, le=180)] | None = Field(
        default=None, description="longitude, degrees east"
    )
    grid: Name | None = Field(
        default=None,
        description="file of another hazard grid in the form of Allegato B, or of the nine lines of the site itself; "
        "absent: Allegato B of D.M. 14/01/2008, which comes with the program",
    )
    SLD: HazardTable | None = Field(default=None, description="hazard at SLD, instead of coordinates")
    SLV: HazardTable | None = Field(default=None, description="hazard at SLV, instead of coordinates")
    SLC: HazardTable | None = Field(default=None, description="hazard at SLC, instead of coordinates")
    soil: Literal["A", "B", "C", "D", "E"] = Field(description="ground type A to E, NTC 2018 Tab. 3.2.II")
    topography: Literal["T1", "T2", "T3", "T4"] = Field(
        default="T1", description="topographic class T1 to T4, NTC 2018 Tab. 3.2.III"
    )
    nominal_life_years: Annotated[float, Field(ge=1, le=1e4)] = Field(
        default=50.0, description="nominal life V_N, years"
    )
    use_class: Literal["I", "II", "III", "IV"] = Field(
        default="II", description="use class I to IV, NTC 2018 §2.4.2"
    )

    @property
    def typed(self) -> dict[str, HazardTable]:
        """The hazards that are typed in, by limit state; none where coordinates or a file give them."""
        return {key: table for key in ("SLD", "SLV", "SLC") if (table := getattr(self, key)) is not None}


class FloorTable(Table):
    """[assessment.floor]: the building that carries a mechanism at height, for the floor spectrum."""

    height_m: Annotated[float, Field(ge=0, le=1e4)] = Field(
        description="height z, m, of the restraints of the mechanism above the foundation; 0: on the ground"
    )
    building_height_m: Length = Field(description="height H of the building, m")
    storeys: Annotated[int, Field(ge=1, le=1000)] = Field(description="number of storeys n")
    period_s: Seconds | None = Field(
        default=None,
        description="period T_1 of the building's first mode, s; default 0.05 H^(3/4), C7.3.3.2, H up to 40 m",
    )
    damping_ratio: Annotated[float, Field(ge=1e-3, lt=1)] = Field(
        default=0.05, description="viscous damping ratio of the building's modes"
    )
    higher_periods_s: Annotated[tuple[Seconds, ...], Field(strict=False, max_length=100)] = Field(
        default=(), description="periods T_k of further modes, s"
    )
    higher_participations: Annotated[tuple[Ratio, ...], Field(strict=False, max_length=100)] = Field(
        default=(), description="their products γ_k ψ_k(z), participation times shape at the height z"
    )


class KnowledgeTable(Table):
    """[assessment.knowledge]: what the confidence factor follows from: a level, or four components 1 + ΣF_Ck."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1})

    level: Literal["LC1", "LC2", "LC3"] | None = Field(
        default=None, description="level of knowledge, Circolare 7/2019, C8.5.4: F_C 1.35, 1.20 or 1.00"
    )
    geometry: Annotated[float, Field(ge=0, le=0.2)] | None = Field(
        default=None, description="F_C1 of DPCM 9/2/2011: geometrical survey, 0.05 or 0.0"
    )
    construction: Annotated[float, Field(ge=0, le=0.2)] | None = Field(
        default=None, description="F_C2: survey of materials and details, 0.12, 0.06 or 0.0"
    )
    mechanical: Annotated[float, Field(ge=0, le=0.2)] | None = Field(
        default=None, description="F_C3: mechanical properties, 0.12, 0.06 or 0.0"
    )
    ground: Annotated[float, Field(ge=0, le=0.2)] | None = Field(
        default=None, description="F_C4: ground and foundations, 0.06, 0.03 or 0.0"
    )
    evaluation: Literal["LV1", "LV2", "LV3"] | None = Field(
        default=None, description="level of evaluation of DPCM 9/2/2011: LV1, LV2 or LV3"
    )
    investigations: Text = Field(default="", description="investigations carried out, printed in the report")
    geometry_origin: Text = Field(default="", description="survey of the geometry: by whom, when, how")
    construction_origin: Text = Field(
        default="", description="survey of materials and details of construction"
    )
    ground_origin: Text = Field(default="", description="ground and foundations: investigations and report")
    unit_weight_origin: Text = Field(default="", description="origin of the unit weights")
    friction_origin: Text = Field(default="", description="origin of the coefficients of friction")
    normal_stiffness_origin: Text = Field(default="", description="origin of the stiffness of the joints")
    compressive_strength_origin: Text = Field(default="", description="origin of the compressive strength")
    loads_origin: Text = Field(default="", description="origin of the loads")

    @property
    def origins(self) -> dict[str, str]:
        """The origin of each parameter by its name; parameters without a text are left out."""
        named = {key.removesuffix("_origin"): getattr(self, key) for key in type(self).model_fields}
        return {
            key: text for key, text in named.items() if f"{key}_origin" in type(self).model_fields and text
        }

    @property
    def components(self) -> dict[str, float]:
        """The components F_Ck that are given, by name."""
        named = {key: getattr(self, key) for key in ("geometry", "construction", "mechanical", "ground")}
        return {key: value for key, value in named.items() if value is not None}


class AssessmentTable(Table):
    """[assessment]: the displacement-based check of every pushover curve."""

    limit_states: LimitStates = Field(default=("SLD", "SLV", "SLC"), description="limit states to check")
    confidence_factor: Annotated[float, Field(ge=1, le=10)] = Field(
        default=1.35, description="confidence factor F_C"
    )
    behaviour_factor: Annotated[float, Field(ge=1, le=100)] = Field(
        default=2.0, description="behaviour factor q of the linear check"
    )
    model: Literal["trilinear", "bilinear", "none"] = Field(
        default="trilinear",
        description="capacity curve: trilinear (as in the paper), bilinear or none (rigid branch)",
    )
    spectrum: Literal["ntc", "record"] = Field(
        default="ntc", description="demand: ntc, or record (the [[history]] record's own spectrum)"
    )
    method: Literal["demand-shape", "grid"] = Field(
        default="demand-shape",
        description="capacity a_g by scaling the demand spectrum, or by return period iterated on the grid",
    )
    circular: Literal[2019, 2009] = Field(
        default=2019, description="circular whose rules apply: 2019 or 2009"
    )
    record_demand: Literal["at_period", "maximum"] = Field(
        default="at_period",
        description="displacement demand of a record: at_period T, as in the paper, or maximum over [T_0, T]",
    )
    local_displacement_limit_m: Length | None = Field(
        default=None,
        description="displacement of the control point, m, at a local loss such as a beam unseating",
    )
    local_displacement_reason: Text = Field(
        default="", description="what is lost there and how it was found, printed with the limit"
    )
    knowledge: KnowledgeTable | None = Field(
        default=None, description="what confidence_factor follows from, printed with its origins"
    )
    floor: FloorTable | None = Field(
        default=None, description="building below a mechanism at height; absent: at the ground"
    )
    site: SiteTable | None = Field(
        default=None, description="site, ground and use; needed by the ntc spectrum"
    )


class MechanismTable(Table):
    """[[mechanism]]: a macro-block of a mechanism chosen by the user; entries of one name form one mechanism."""

    name: Name = Field(
        description="name of the mechanism; each of its macro-blocks is an entry with this name"
    )
    about_m: Pair = Field(description="x and z, m, of the point about which the macro-block rotates")
    rotation: Ratio = Field(
        default=-1.0,
        description="virtual rotation, anticlockwise positive, relative to the other macro-blocks",
    )
    layers: Names | None = Field(
        default=None, description="layers of the macro-block; default all, where a region is given"
    )
    region_m: (
        Annotated[tuple[Coordinate, ...], Field(strict=False, min_length=1, max_length=MOST_ENTRIES)] | None
    ) = Field(
        default=None,
        description="x and z, m, of two opposite corners of a box, or of the corners of a polygon: the movable "
        "blocks of the layers whose centroid lies in it",
    )
    blocks: (
        Annotated[tuple[BlockNumber, ...], Field(strict=False, min_length=1, max_length=MOST_LAYERS)] | None
    ) = Field(default=None, description="numbers of further blocks, as in tables/blocks.csv")
    state: Name = Field(
        default=ORIGINAL, description="state in whose configuration the mechanism and its points are taken"
    )
