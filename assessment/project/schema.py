"""The tables of a project file: every key with its type, unit, default and meaning.

Units as everywhere: kN, m, s, Mg, accelerations in g. The descriptions are written for the user: they
become the comments of a new project file and the texts of the JSON schema.
"""

# ruff: noqa: N815 - the fields are the keys of the file, units in their names

from __future__ import annotations

import math
import re
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, StringConstraints

KeyPath = tuple[str | int, ...]
"""Where a value stands in the project's content, list entries counted from 0."""

VARIED = ("friction", "stiffness", "unit_weight", "depth")
"""The properties that [sensitivity] can vary."""

ORIGINAL = "original"
"""Name of the state before any settlement."""

GENERATE = re.compile(r"generate:([1-9]\d{0,2})")
"""In the place of record files: so many records are made."""

Entry = TypeVar("Entry", str, float, int)

# Nothing invisible: what cannot be seen in an editor or held by a spreadsheet cell is a typing slip.
_UNSEEN = r"\x00-\x08\x0b-\x1f\x7f-\x9f\u200b\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ufffe\uffff"

_MOST_STIFFNESS = 1e11  # kN/m³
MOST_ENTRIES = 1000
"""Of a list of tables or of names."""
MOST_LAYERS = 10_000
"""Of tables [layers.NAME]."""


def _unique(items: tuple[Entry, ...]) -> tuple[Entry, ...]:
    if len(set(items)) < len(items):
        raise ValueError("an entry appears twice; write each entry once")
    return items


def _stiff_or_rigid(stiffness: float) -> float:
    if _MOST_STIFFNESS < stiffness < math.inf:
        raise ValueError(
            f"{stiffness:g} is more than {_MOST_STIFFNESS:g}; write inf for a joint that is rigid in shear"
        )
    return stiffness


def _without_default(schema: dict[str, Any]) -> None:
    """Leave an infinite default out of the JSON schema: JSON has no infinity."""
    if schema.get("default") == math.inf:
        del schema["default"]


# Bounds so wide that only a slip lies outside, so narrow that no arithmetic overflows.
Length = Annotated[float, Field(ge=1e-6, le=1e5)]  # m
Step = Annotated[float, Field(ge=1e-7, le=1e3)]  # m, of a movement
Drawn = Annotated[float, Field(ge=1e-7, le=1e2)]  # m, a tolerance of the drawing
Coordinate = Annotated[float, Field(ge=-1e7, le=1e7)]  # m
Shift = Annotated[float, Field(ge=-1e5, le=1e5)]  # m
Angle = Annotated[float, Field(ge=-6.3, le=6.3)]  # rad
AngleStep = Annotated[float, Field(ge=1e-7, le=1)]  # rad
UnitWeight = Annotated[float, Field(ge=1e-3, le=1e6)]  # kN/m³
Stiffness = Annotated[float, Field(ge=1e-3, le=_MOST_STIFFNESS)]  # kN/m³
Rigidity = Annotated[float, Field(ge=1e-3, allow_inf_nan=True), AfterValidator(_stiff_or_rigid)]  # kN/m³
Friction = Annotated[float, Field(ge=0, allow_inf_nan=True)]  # inf: no sliding
Load = Annotated[float, Field(ge=-1e9, le=1e9)]  # kN
Seconds = Annotated[float, Field(ge=1e-6, le=1e3)]
Instant = Annotated[float, Field(ge=-1e6, le=1e6)]  # s
Acceleration = Annotated[float, Field(ge=1e-6, le=1e3)]  # g
Factor = Annotated[float, Field(ge=1e-4, le=1e4)]
Ratio = Annotated[float, Field(ge=-1e4, le=1e4)]
Damping = Annotated[float, Field(ge=0, lt=1)]
BlockNumber = Annotated[int, Field(ge=0, le=10**9)]
Strength = Annotated[float, Field(ge=1, allow_inf_nan=True)]  # kN/m²; inf: no limit
Segments = Annotated[int, Field(ge=1, le=64)]
Members = Annotated[int, Field(ge=1, le=100)]
Pair = Annotated[tuple[Coordinate, Coordinate], Field(strict=False)]
Movement = Annotated[tuple[Shift, Shift], Field(strict=False)]
Window = Annotated[tuple[Instant, Instant], Field(strict=False)]
Varied = Annotated[float, Field(ge=1e-2, le=1e2)]
Factors = Annotated[tuple[Varied, Varied], Field(strict=False)]
Tolerance = Annotated[float, Field(ge=1e-6, lt=1)]
Share = Annotated[float, Field(ge=0, le=1)]
Name = Annotated[str, Field(max_length=200, pattern=rf"^[^\s{_UNSEEN}]([^\t\n{_UNSEEN}]*[^\s{_UNSEEN}])?$")]
Text = Annotated[str, StringConstraints(strip_whitespace=True, max_length=2000, pattern=rf"^[^{_UNSEEN}]*$")]
_ENTRIES = Field(strict=False, min_length=1, max_length=MOST_ENTRIES, json_schema_extra={"uniqueItems": True})
_TABLES = Field(strict=False, max_length=MOST_ENTRIES)
Names = Annotated[tuple[Name, ...], _ENTRIES, AfterValidator(_unique)]
Contacts = Literal["rigid", "elastic"]
Direction = Literal["+x", "-x"]
LimitState = Literal["SLD", "SLV", "SLC"]
UseCategory = Literal["A", "B", "C", "D", "E", "F", "G", "H", "I", "K", "snow", "snow above 1000 m", "wind"]
ContactsList = Annotated[tuple[Contacts, ...], _ENTRIES, AfterValidator(_unique)]
Directions = Annotated[tuple[Direction, ...], _ENTRIES, AfterValidator(_unique)]
LimitStates = Annotated[tuple[LimitState, ...], _ENTRIES, AfterValidator(_unique)]


RecordSet = Annotated[
    tuple[Name, ...], _ENTRIES, AfterValidator(_unique),
    BeforeValidator(lambda given: (given,) if isinstance(given, str) else given),
]  # fmt: skip
Shares = Annotated[tuple[Share, ...], _ENTRIES, AfterValidator(_unique)]
Signs = Annotated[tuple[Literal[1, -1], ...], _ENTRIES, AfterValidator(_unique)]
Levels = Annotated[tuple[Acceleration, ...], _ENTRIES, AfterValidator(_unique)]
Periods = Annotated[tuple[Seconds, Seconds], Field(strict=False)]


class Table(BaseModel):
    """A table of the project file: exact types, finite numbers, no other keys, not to be changed."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


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
        json_schema_extra=_without_default,
    )
    compressive_strength_kN_m2: Strength = Field(
        default=math.inf,
        description="compressive strength of a joint, kN/m²; inf (default): no crushing",
        json_schema_extra=_without_default,
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


class MotionTable(Table):
    """What [[history]], [incremental] and [campaign] have in common: how a motion is integrated."""

    time_step_s: Seconds | None = Field(
        default=None,
        description="time step, s; default the record's; also the sampling step of a one-column record",
    )
    window_s: Window | Literal["arias"] | None = Field(
        default=None, description='first and last second of the record to use, or "arias": its 5–95 % window'
    )
    contacts: Contacts = Field(default="elastic", description="contact model: rigid or elastic")
    integrator: Literal["auto", "moreau-jean", "second-order", "implicit-euler"] = Field(
        default="auto",
        description="time integration: auto (the results say which it took), moreau-jean (rigid contacts, many "
        "impacts), second-order, or implicit-euler (the paper's)",
    )
    damping_ratio: Damping | None = Field(default=None, description="viscous damping ratio of the contacts")
    control: Name | None = Field(default=None, description="control point; default the first")


class StatesTable(MotionTable):
    """What [[history]] and [incremental] have in common: motions from states of the project."""

    states: Names | None = Field(
        default=None, description='states to analyse: "original" and names of settlements; default all'
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

    @property
    def generated(self) -> int:
        """Number of records to generate, 0 where files are named."""
        found = GENERATE.fullmatch(self.records[0])
        return int(found[1]) if found else 0


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
    """[assessment.site]: hazard by coordinates and grid, or typed in per limit state; ground and use."""

    latitude: Annotated[float, Field(ge=-90, le=90)] | None = Field(
        default=None, description="latitude, degrees north"
    )
    longitude: Annotated[float, Field(ge=-180, le=180)] | None = Field(
        default=None, description="longitude, degrees east"
    )
    grid: Name | None = Field(default=None, description="file of the reference hazard grid (Allegato B)")
    SLD: HazardTable | None = Field(
        default=None, description="hazard at SLD, instead of coordinates and grid"
    )
    SLV: HazardTable | None = Field(
        default=None, description="hazard at SLV, instead of coordinates and grid"
    )
    SLC: HazardTable | None = Field(
        default=None, description="hazard at SLC, instead of coordinates and grid"
    )
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
        """Where each parameter comes from, by its name, those that are told."""
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
        default=None, description='states to vary: "original" and names of settlements; default all'
    )

    @property
    def factors(self) -> dict[str, tuple[float, float]]:
        """The properties to vary and their low and high factors."""
        return {key: getattr(self, key) for key in VARIED if getattr(self, key) is not None}


class ReportTable(Table):
    """[report]: language and the free text of the title page."""

    language: Literal["it", "en"] = Field(default="it", description="language of the report: it or en")
    client: Text = Field(default="", description="client, free text of the title page")
    engineer: Text = Field(default="", description="engineer, free text of the title page")
    location: Text = Field(default="", description="location, free text of the title page")
    attachments: Annotated[tuple[Name, ...], Field(strict=False, max_length=MOST_ENTRIES)] = Field(
        default=(),
        description="photographs and survey drawings (PNG or JPEG files) that end the report; their names are captions",
    )


class ProjectContent(Table):
    """All that a project file says. A table that is absent switches its stage off."""

    title: Name = Field(description="title of the project")
    accuracy: Literal["fast", "standard", "fine"] | Tolerance = Field(
        default="fast",
        description="fast: increments and time steps as given, no error estimated; else they are halved until the "
        "estimated relative error is below standard (0.05), fine (0.01) or a number",
    )
    scatter: Members = Field(
        default=5,
        description="members of the small ensemble run where a path slides or a motion has many impacts; 1: none",
    )
    geometry: GeometryTable = Field(description="the drawing and how it becomes blocks and joints")
    material: MaterialTable = Field(description="stone and joints, default of every layer")
    layers: Annotated[dict[Name, LayerTable], Field(max_length=MOST_LAYERS)] = Field(
        default={}, description="what the blocks of a layer have of their own"
    )
    contacts: ContactsTable = Field(
        default=ContactsTable(), description="how joints slide, and which blocks may touch"
    )
    control: Annotated[tuple[ControlTable, ...], _TABLES] = Field(
        default=(), description="control points; the first one is the default"
    )
    settlements: Annotated[tuple[SettlementTable, ...], _TABLES] = Field(
        default=(), description="support movements to review, each one a state"
    )
    pushover: PushoverTable | None = Field(default=None, description="pushover analysis")
    history: Annotated[tuple[HistoryTable, ...], _TABLES] = Field(
        default=(), description="time histories, one per record and state"
    )
    incremental: IncrementalTable | None = Field(default=None, description="incremental dynamic analysis")
    campaign: CampaignTable | None = Field(
        default=None, description="fragility and loss of capacity against movement"
    )
    assessment: AssessmentTable | None = Field(default=None, description="check against the standard")
    mechanism: Annotated[tuple[MechanismTable, ...], _TABLES] = Field(
        default=(), description="mechanisms chosen by the user, one entry per macro-block"
    )
    sensitivity: SensitivityTable | None = Field(
        default=None, description="capacity with properties of the masonry lower and higher, one at a time"
    )
    report: ReportTable = Field(default=ReportTable(), description="language and title page of the report")

    @property
    def supports(self) -> tuple[str, ...]:
        """Names of the supports, in the order of the layers."""
        return tuple(dict.fromkeys(layer.support for layer in self.layers.values() if layer.support))

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states: the original one, then one per settlement."""
        return (ORIGINAL, *(settlement.name for settlement in self.settlements))
