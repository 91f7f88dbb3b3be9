"""Checks against the standard: [assessment] with its site, floor and knowledge, [[mechanism]]."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import ConfigDict, Field

from assessment.ntc.tables import COMPONENTS, confidence_factor, return_period
from assessment.project.schema import values as kinds
from assessment.project.schema.values import Contradiction, FileName, NameOf, ProjectTable, absent, entry

if TYPE_CHECKING:
    from assessment.project.schema import ProjectContent

HIGHEST = 40.0  # m: of a building whose period T_1 = 0.05 H^(3/4) gives (Circolare 7/2019, C7.3.3.2)
RETURN_PERIOD_TOL = 0.02  # relative: typed values are rounded, 475 years for 474.6
LEAST_ROTATION = 1e-6  # of a macro-block, relative to those of the others; below it the block does not turn


Component = Annotated[float, Field(ge=0, le=0.2)]  # F_Ck
Corners = Annotated[
    tuple[kinds.Coordinate, ...], Field(strict=False, min_length=1, max_length=kinds.MOST_ENTRIES)
]
Numbers = Annotated[
    tuple[kinds.BlockNumber, ...], Field(strict=False, min_length=1, max_length=kinds.MOST_LAYERS)
]


class HazardTable(ProjectTable):
    """[assessment.site.SLV] and so on: the hazard of one limit state, typed in."""

    ag_g: kinds.Acceleration = entry("peak ground acceleration on rigid level ground, g")
    F0: Annotated[float, Field(ge=1, le=100)] = entry("largest amplification of the spectrum")
    Tc_star_s: kinds.Seconds = entry("T_C*, s: reference for the end of the constant branch")
    return_period_years: Annotated[float, Field(ge=1, le=1e5)] | None = absent(
        "return period of this hazard, years; it must be that of nominal life and use class"
    )


class SiteTable(ProjectTable):
    """[assessment.site]: hazard by coordinates, by a file, or typed in per limit state; ground and use."""

    latitude: Annotated[float, Field(ge=-90, le=90)] | None = absent("latitude, degrees north")
    longitude: Annotated[float, Field(ge=-180, le=180)] | None = absent("longitude, degrees east")
    grid: Annotated[kinds.Name | None, FileName()] = absent(
        "file of another hazard grid in the form of Allegato B, or of the nine lines of the site itself; "
        "absent: Allegato B of D.M. 14/01/2008, which comes with the program"
    )
    SLD: HazardTable | None = absent("hazard at SLD, instead of coordinates")
    SLV: HazardTable | None = absent("hazard at SLV, instead of coordinates")
    SLC: HazardTable | None = absent("hazard at SLC, instead of coordinates")
    soil: Literal["A", "B", "C", "D", "E"] = entry("ground type A to E, NTC 2018 Tab. 3.2.II")
    topography: Literal["T1", "T2", "T3", "T4"] = entry("topography T1 to T4, NTC 2018 Tab. 3.2.III", "T1")
    nominal_life_years: Annotated[float, Field(ge=1, le=1e4)] = entry("nominal life V_N, years", 50.0)
    use_class: Literal["I", "II", "III", "IV"] = entry("use class I to IV, NTC 2018 §2.4.2", "II")

    @property
    def typed(self) -> dict[str, HazardTable]:
        """The hazards that are typed in, by limit state; none where coordinates or a file give them."""
        return {key: table for key in ("SLD", "SLV", "SLC") if (table := getattr(self, key)) is not None}

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield a hazard that is missing, incomplete or given twice, and return periods of another life or class."""
        placed = [key for key in ("latitude", "longitude", "grid") if getattr(self, key) is not None]
        typed = self.typed
        if placed and typed:
            yield (), f"given twice, by {', '.join(placed)} and by {', '.join(typed)}; keep one of the two"
        elif placed:  # a file alone may be the hazard of the site itself; its reader checks that
            for key in {"latitude", "longitude"}.difference(placed) if placed != ["grid"] else ():
                yield key, "missing; latitude and longitude go together"
        elif not typed:
            yield (), "no hazard; add latitude and longitude, or ag_g, F0 and Tc_star_s per limit state"
        elif project.assessment:
            # what nominal life and use class make, but for rounding (§3.2.1)
            for key, table in typed.items():
                by_life = return_period(key, self.nominal_life_years, self.use_class)
                given = table.return_period_years
                if given is not None and abs(given / by_life - 1.0) > RETURN_PERIOD_TOL:
                    text = f"{given:g} years, but nominal_life_years = {self.nominal_life_years:g} and use_class = "
                    text += f'"{self.use_class}" make {by_life:.4g} at {key}; correct one of them'
                    yield (key, "return_period_years"), text
            for key in (each for each in project.assessment.limit_states if each not in typed):
                yield key, "missing, but assessment.limit_states asks for it; add its ag_g, F0 and Tc_star_s"


class FloorTable(ProjectTable):
    """[assessment.floor]: the building that carries a mechanism at height, for the floor spectrum."""

    height_m: Annotated[float, Field(ge=0, le=1e4)] = entry(
        "height z, m, of the restraints of the mechanism above the foundation; 0: on the ground"
    )
    building_height_m: kinds.Length = entry("height H of the building, m")
    storeys: Annotated[int, Field(ge=1, le=1000)] = entry("number of storeys n")
    period_s: kinds.Period | None = absent(
        "period T_1 of the building's first mode, s; default 0.05 H^(3/4), C7.3.3.2, H up to 40 m"
    )
    damping_ratio: Annotated[float, Field(ge=1e-3, le=0.3)] = entry("damping of the building's modes", 0.05)
    higher_periods_s: Annotated[tuple[kinds.Period, ...], Field(strict=False, max_length=100)] = entry(
        "periods T_k of further modes, s", ()
    )
    higher_participations: Annotated[tuple[kinds.Ratio, ...], Field(strict=False, max_length=100)] = entry(
        "their products γ_k ψ_k(z), participation times shape at the height z", ()
    )

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield keys that contradict another one, here or in [assessment]."""
        if self.height_m > self.building_height_m:
            text = f"{self.height_m:g} is above building_height_m ({self.building_height_m:g}); correct one of them"
            yield "height_m", text
        if self.period_s is None and self.building_height_m > HIGHEST:
            text = f"missing; T_1 = 0.05 H^(3/4) holds up to a building_height_m of {HIGHEST:g}"
            yield "period_s", f"{text}; write the period, in s"
        if len(self.higher_periods_s) != len(self.higher_participations):
            text = f"{len(self.higher_participations)} of {len(self.higher_periods_s)}; write one γ_k ψ_k for each of "
            yield "higher_participations", f"{text}higher_periods_s, in the same order"
        if project.assessment and self.higher_periods_s and project.assessment.circular == 2009:
            text = "the circular of 2009 knows the first mode alone; leave it out or write circular = 2019"
            yield "higher_periods_s", text
        if project.assessment and project.assessment.spectrum == "record":
            yield (), 'a record is taken as that of the ground; write spectrum = "ntc" or leave it out'


class KnowledgeTable(ProjectTable):
    """[assessment.knowledge]: what the confidence factor follows from: a level, or four components 1 + ΣF_Ck."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1})

    level: Literal["LC1", "LC2", "LC3"] | None = absent("Circolare 7/2019, C8.5.4: F_C 1.35, 1.20, 1.00")
    geometry: Component | None = absent("F_C1 of DPCM 9/2/2011: geometrical survey, 0.05 or 0.0")
    construction: Component | None = absent("F_C2: survey of materials and details, 0.12, 0.06 or 0.0")
    mechanical: Component | None = absent("F_C3: mechanical properties, 0.12, 0.06 or 0.0")
    ground: Component | None = absent("F_C4: ground and foundations, 0.06, 0.03 or 0.0")
    evaluation: Literal["LV1", "LV2", "LV3"] | None = absent("level of evaluation, DPCM 9/2/2011: LV1–3")
    investigations: kinds.Text = entry("investigations carried out, printed in the report", "")
    geometry_origin: kinds.Text = entry("survey of the geometry: by whom, when, how", "")
    construction_origin: kinds.Text = entry("survey of materials and details of construction", "")
    ground_origin: kinds.Text = entry("ground and foundations: investigations and report", "")
    unit_weight_origin: kinds.Text = entry("origin of the unit weights", "")
    friction_origin: kinds.Text = entry("origin of the coefficients of friction", "")
    normal_stiffness_origin: kinds.Text = entry("origin of the stiffness of the joints", "")
    compressive_strength_origin: kinds.Text = entry("origin of the compressive strength", "")
    loads_origin: kinds.Text = entry("origin of the loads", "")

    @property
    def origins(self) -> dict[str, str]:
        """The origin of each parameter by its name; parameters without a text are left out."""
        own = [key for key in type(self).model_fields if key.endswith("_origin") and getattr(self, key)]
        return {key.removesuffix("_origin"): getattr(self, key) for key in own}

    @property
    def components(self) -> dict[str, float]:
        """The components F_Ck that are given, by name."""
        named = {key: getattr(self, key) for key in ("geometry", "construction", "mechanical", "ground")}
        return {key: value for key, value in named.items() if value is not None}

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield what F_C does not follow from: Circolare 7/2019, C8.5.4, for levels; DPCM 9/2/2011, §4.2, for F_Ck."""
        given = self.components
        if (self.level is None) == (not given):
            text = "F_C follows from two things" if given else "F_C follows from nothing"
            yield (), f"{text}; write level, or {', '.join(COMPONENTS)}"
        elif given and len(given) < len(COMPONENTS):
            missing = ", ".join(key for key in COMPONENTS if key not in given)
            yield (), f"{missing} missing; the four components go together"
        elif wrong := [key for key, value in given.items() if value not in COMPONENTS[key]]:
            choices = ", ".join(f"{each:g}" for each in COMPONENTS[wrong[0]])
            yield wrong[0], f"{given[wrong[0]]:g} is none of {choices}; write one of these"
        elif project.assessment:
            factor = project.assessment.confidence_factor
            follows = confidence_factor(self.level, given).result
            if abs(follows - factor) > 1e-9:
                text = f"{factor:g}, but assessment.knowledge makes {follows:g}; write {follows:g}, or correct it"
                yield kinds.Problem(("assessment", "confidence_factor"), text)


class AssessmentTable(ProjectTable):
    """[assessment]: the displacement-based check of every pushover curve."""

    limit_states: kinds.LimitStates = entry("limit states to check", ("SLD", "SLV", "SLC"))
    confidence_factor: Annotated[float, Field(ge=1, le=10)] = entry("confidence factor F_C", 1.35)
    behaviour_factor: Annotated[float, Field(ge=1, le=100)] = entry("factor q of the linear check", 2.0)
    model: Literal["trilinear", "bilinear", "none"] = entry(
        "capacity curve: trilinear (as in the paper), bilinear or none (rigid branch)", "trilinear"
    )
    spectrum: Literal["ntc", "record"] = entry("demand: ntc, or the [[history]] record", "ntc")
    method: Literal["demand-shape", "grid"] = entry(
        "capacity a_g by scaling the demand spectrum, or by return period iterated on the grid",
        "demand-shape",
    )
    circular: Literal[2019, 2009] = entry("circular whose rules apply: 2019 or 2009", 2019)
    record_demand: Literal["at_period", "maximum"] = entry(
        "displacement demand of a record: at_period T, as in the paper, or maximum over [T_0, T] (circular)",
        "at_period",
    )
    local_displacement_limit_m: kinds.Length | None = absent(
        "displacement of the control point, m, at a local loss such as a beam unseating"
    )
    local_displacement_reason: kinds.Text = entry("what is lost there, how it was found; printed", "")
    knowledge: KnowledgeTable | None = absent("what confidence_factor follows from, printed with its origins")
    floor: FloorTable | None = absent("building below a mechanism at height; absent: at the ground")
    site: SiteTable | None = absent("site, ground and use; needed by the ntc spectrum")

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield tables and keys that the check needs and that are missing."""
        needed = ["rigid"] if self.model == "none" else ["rigid", "elastic"]
        if project.pushover is None:
            yield (), "there is no pushover to assess; add [pushover] or leave [assessment] out"
        elif missing := [contacts for contacts in needed if contacts not in project.pushover.contacts]:
            text = f"{' and '.join(missing)} missing, but assessment.model asks for it; write {json.dumps(needed)}"
            yield kinds.Problem(("pushover", "contacts"), text)
        if self.spectrum == "record" and not project.history:
            text = 'there is no record to take the spectrum of; add [[history]] or write spectrum = "ntc"'
            yield "spectrum", text
        if self.spectrum == "ntc" and self.site is None:
            yield "site", 'missing; add [assessment.site] or write spectrum = "record"'
        if self.method == "grid" and (self.site is None or self.site.typed):
            text = "the hazard is typed in, there is no grid"
            yield "method", f'{text}; write latitude and longitude of the site, or "demand-shape"'


class MechanismTable(ProjectTable):
    """[[mechanism]]: a macro-block of a mechanism chosen by the user; entries of one name form one mechanism."""

    name: kinds.Name = entry("name of the mechanism; each of its macro-blocks is an entry with this name")
    about_m: kinds.Pair = entry("x and z, m, of the point about which the macro-block rotates")
    rotation: kinds.Ratio = entry("virtual rotation, anticlockwise, relative to the other macro-blocks", -1.0)
    layers: kinds.Names | None = absent("layers of the macro-block; default all, where a region is given")
    region_m: Corners | None = absent(
        "x and z, m, of two opposite corners of a box, or of the corners of a polygon: the movable "
        "blocks of the layers whose centroid lies in it"
    )
    blocks: Numbers | None = absent("numbers of further blocks, as in tables/blocks.csv")
    state: Annotated[kinds.Name, NameOf("state")] = entry(
        "state in whose configuration the mechanism and its points are taken", kinds.ORIGINAL
    )

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield a macro-block without blocks or rotation, or in another state than the first one of its mechanism."""
        if not (self.layers or self.region_m or self.blocks):
            yield (), "no block is chosen; write layers, region_m or blocks"
        if self.region_m is not None and (len(self.region_m) < 4 or len(self.region_m) % 2):
            text = "no corners; write x and z of two corners of a box, or of each corner of a polygon"
            yield "region_m", text
        if abs(self.rotation) < LEAST_ROTATION:
            yield "rotation", f"{self.rotation:g} does not move the macro-block; leave the entry out"
        if self.state != next(each.state for each in project.mechanism if each.name == self.name):
            yield "state", f'"{self.name}" has macro-blocks in another state; write one state'
