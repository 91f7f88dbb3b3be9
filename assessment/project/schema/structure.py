"""The structure and its static analyses: geometry, material, layers, contacts, control points, settlements, ties."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import ConfigDict, Field

from assessment.ntc.tables import OWN_PSI_2, PSI_2
from assessment.project.schema import values as kinds
from assessment.project.schema.values import Contradiction, FileName, NameOf, ProjectTable, absent, entry
from assessment.runtime.errors import nearest

if TYPE_CHECKING:
    from assessment.project.schema import ProjectContent

MOST_INCREMENTS = 100_000
LEAST_MOVEMENT = 1e-7  # m and rad: less is a slip of the unit, and no longer told from rounding
SHORTEST_TIE = 1e-6  # m
ELONGATION = 0.025  # (A_gt)k of B450A: the least of a steel of NTC 2018, §11.3.2.2


class GeometryTable(ProjectTable):
    """[geometry]: the drawing and how it becomes blocks and joints."""

    drawing: Annotated[kinds.Name, FileName()] = entry("DXF file with one closed polyline per block")
    unit: Literal["mm", "cm", "m"] = entry("unit of the drawing: mm, cm or m")
    depth_m: kinds.Length = entry("out-of-plane depth, m; default of every layer")
    segments_per_joint: kinds.Segments | None = absent(
        "absent: elastic joints are exact; a number: the contact points of the paper at the ends of so "
        "many segments of each joint, for comparison"
    )
    tolerance_m: kinds.Drawn | None = absent("edges closer than this, m, form a joint; default from the size")
    sagitta_m: kinds.Drawn | None = absent("largest distance, m, of an arc from its chords; default by size")


class MaterialTable(ProjectTable):
    """[material]: stone and joints, default of every layer."""

    unit_weight_kN_m3: kinds.UnitWeight = entry("unit weight of the stone, kN/m³")
    friction: kinds.Friction = entry("tangent of the friction angle of a joint; inf: no sliding", 0.6)
    normal_stiffness_kN_m3: kinds.Stiffness | None = absent(
        "normal stiffness of a joint per unit area, kN/m³; needed by elastic analyses only"
    )
    tangential_stiffness_kN_m3: kinds.Rigidity = entry(
        "tangential stiffness of a joint per unit area, kN/m³; inf (default): rigid in shear", math.inf
    )
    compressive_strength_kN_m2: kinds.Strength = entry(
        "compressive strength of a joint, kN/m²; inf (default): no crushing", math.inf
    )


class BondTable(ProjectTable):
    """bond = {…} of a layer or region: a closed outline is cut into blocks, but for the outlines within it."""

    pattern: Literal["running"] = entry("running: courses, each shifted by half a block", "running")
    # bounds of masonry in m: written in cm or mm a wall would be one block
    course_m: Annotated[float, Field(ge=1e-6, le=3)] = entry("height of a course, m, adapted to the wall")
    block_m: Annotated[float, Field(ge=1e-6, le=5)] = entry("length of a block, m, adapted likewise")


class LayerTable(ProjectTable):
    """[layers.NAME]: what the blocks on one layer of the drawing have of their own."""

    ignore: bool = entry("the layer is no masonry (frame, axes, notes): nothing on it is read", False)
    bond: BondTable | None = absent(
        "closed outlines are cut into blocks; outlines of the layer within them are openings, with a "
        "lintel of one course above, those of other layers blocks that take their place"
    )
    unit_weight_kN_m3: kinds.UnitWeight | None = absent("unit weight, kN/m³, instead of [material]'s")
    friction: kinds.Friction | None = absent("tangent of friction angle, instead of [material]'s")
    normal_stiffness_kN_m3: kinds.Stiffness | None = absent("normal stiffness, kN/m³, not [material]'s")
    tangential_stiffness_kN_m3: kinds.Rigidity | None = absent("shear stiffness, kN/m³, not [material]'s")
    compressive_strength_kN_m2: kinds.Strength | None = absent("strength, kN/m², not [material]'s")
    depth_m: kinds.Length | None = absent("out-of-plane depth, m, instead of [geometry]'s")
    segments_per_joint: kinds.Segments | None = absent("segments of each joint, instead of [geometry]'s")
    support: kinds.Name | None = absent("the blocks of this layer are a support of this name")
    vertical_load_kN: kinds.Load = entry("permanent load G on each block, kN, downward, at its centroid", 0.0)
    variable_load_kN: Annotated[float, Field(ge=0, le=1e9)] = entry(
        "characteristic variable load Q on each block, kN; ψ₂ Q acts with the permanent one", 0.0
    )
    use_category: kinds.UseCategory | None = absent(
        'category of the variable load, NTC 2018 Tab. 2.5.I: A to H, "snow", "snow above 1000 m", "wind"; '
        "I and K with psi_2"
    )
    psi_2: kinds.Share | None = absent("ψ₂, instead of that of use_category")
    load_has_mass: bool = entry("the loads also count as seismic mass", True)

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield upward loads with mass, and variable loads without ψ₂ (NTC 2018, §2.5.3, Tab. 2.5.I)."""
        if self.ignore and len(self.model_fields_set - {"name", "outline_m"}) > 1:
            yield "ignore", "what is ignored has no other keys; leave them out, or ignore = true"
        if self.vertical_load_kN < 0.0 and self.load_has_mass:
            text = f"{self.vertical_load_kN:g} acts upward and has no mass; add load_has_mass = false"
            yield "vertical_load_kN", text
        category, psi_2 = self.use_category, self.psi_2
        if self.variable_load_kN == 0.0:
            for key in ("use_category", "psi_2"):
                if getattr(self, key) is not None:
                    yield key, "there is no variable load; add variable_load_kN or leave it out"
        elif psi_2 is None and category is None:
            yield "variable_load_kN", "ψ₂ is not known; add use_category (NTC 2018, Tab. 2.5.I), or psi_2"
        elif psi_2 is None and category in OWN_PSI_2:
            text = f"{category} has no ψ₂ in NTC 2018, Tab. 2.5.I, it is to be judged case by case; add psi_2"
            yield "use_category", text
        elif psi_2 is not None and PSI_2.get(category or "", psi_2) != psi_2:
            own = PSI_2[category or ""]
            yield "psi_2", f'{psi_2:g}, but use_category = "{category}" has {own:g}; leave one of them out'


class RegionTable(LayerTable):
    """[[region]]: blocks whose centroid lies in an outline, with keys over those of their layer."""

    name: kinds.Name = entry("name of the region")
    outline_m: Annotated[
        tuple[kinds.Pair, ...], Field(strict=False, min_length=3, max_length=kinds.MOST_ENTRIES)
    ] = entry("x and z, m, of each corner of the outline; of a block in several regions the last one counts")


class ContactsTable(ProjectTable):
    """[contacts]: how joints slide, and whether blocks that are apart may come to touch."""

    sliding: Literal["coulomb", "associative"] = entry(
        "coulomb: a joint that slides does not open; associative: it opens, as in the paper", "coulomb"
    )
    collisions: bool = entry("blocks that are apart in the drawing may come to touch as they move", True)


class ControlTable(ProjectTable):
    """[[control]]: a point whose displacement is followed; the first one is the default."""

    name: kinds.Name = entry("name of the control point")
    point_m: kinds.Pair = entry("x and z, m, in or on a block; the point moves with it")


class SettlementTable(ProjectTable):
    """[[settlements]]: a support movement, and with it a state beside the state "original"."""

    name: kinds.Name = entry("name of the settled state")
    support: Annotated[kinds.Name, NameOf("support")] = entry("the support that moves, as named in [layers]")
    displacement_m: kinds.Movement = entry("movement along x and z, m", (0.0, 0.0))
    rotation_rad: kinds.Angle = entry("rotation about the support's centroid, anticlockwise, rad", 0.0)
    increment_m: kinds.Step = entry("step of the largest component of the movement, m", 0.001)
    increment_rad: kinds.AngleStep = entry("largest step of the rotation, rad", 0.001)
    to_collapse: bool = entry("also look for the ultimate movement along the same direction", False)
    after: Annotated[kinds.Name | None, NameOf("settlement")] = absent(
        "name of the settlement in whose state this movement begins, and from which it counts; default as drawn"
    )
    steps: Annotated[int, Field(ge=2, le=100)] | None = absent(
        "review the capacity after each of so many equal parts of the movement too"
    )

    @property
    def increments(self) -> int:
        """Number of equal increments that keep within both limits, at least one."""
        movement = max(map(abs, self.displacement_m)) / self.increment_m
        return max(1, math.ceil(max(movement, abs(self.rotation_rad) / self.increment_rad) - 1e-9))

    @property
    def largest(self) -> float:
        """The largest of the components of the movement (m) and its rotation (rad)."""
        return max(*map(abs, self.displacement_m), abs(self.rotation_rad))

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield movements of nothing, increments too long or too short, and what a movement cannot begin after."""
        if self.name == kinds.ORIGINAL:
            yield "name", f'"{kinds.ORIGINAL}" is the state before any settlement; write another name'
        shift = max(map(abs, self.displacement_m))
        least = self.largest / (self.steps or 1)
        if self.largest == 0.0:
            yield "displacement_m", "nothing moves; write a displacement or a rotation_rad"
        elif least < LEAST_MOVEMENT:
            text = f"{least:g} m (or rad) moves nothing; write {LEAST_MOVEMENT:g} or more"
            yield "displacement_m", text if self.steps is None else f"in steps, {text}"
        elif "increment_m" in self.model_fields_set and self.increment_m > shift > 0.0:
            yield "increment_m", f"{self.increment_m:g} is larger than the movement; write {shift:g} or less"
        if self.increments > MOST_INCREMENTS:
            text = f"the movement takes {self.increments} increments; write longer ones, for {MOST_INCREMENTS} or fewer"
            turns = abs(self.rotation_rad) / self.increment_rad > shift / self.increment_m
            yield "increment_rad" if turns else "increment_m", text
        if self.steps and not project.pushover:
            text = "there is no pushover whose capacity could be reviewed"
            yield "steps", f"{text}; add [pushover] or leave steps out"
        if self.after is not None:
            yield from self._after(self.after, project)

    def _after(self, before: str, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield why the movement cannot begin in the state `before`, or is asked for what begins as drawn."""
        settlements = project.unstrengthened[1:]
        if before in settlements and project.movements_to(self.name)[0].after is not None:
            yield "after", "the movements begin in each other's states; let one of them begin as drawn"
            return
        if before in settlements:
            there, earlier = (project.ties_of(name)[0] for name in (self.name, before))
            for tie in (each for each in project.tie if (each in there) != (each in earlier)):
                text = f'the tie "{tie.name}" is there in one of "{before}" and "{self.name}" alone'
                yield "after", f"{text}; write both in its states, or none"
        if self.steps:
            text = "capacities after parts of a movement are those of one that begins as drawn; leave it out"
            yield "steps", text
        campaign = project.campaign
        if campaign and self.name in (campaign.settlements or settlements):
            text = f'shares of a movement begin as drawn, "{self.name}" does not; write the names of others'
            yield kinds.Problem(("campaign", "settlements"), text)


class PushoverTable(ProjectTable):
    """[pushover]: lateral loads proportional to weight, from every state."""

    contacts: kinds.ContactsList = entry("contact models: rigid, elastic or both", ("rigid",))
    directions: kinds.Directions = entry("directions of the lateral loads", ("+x", "-x"))
    increment_m: kinds.Step = entry("step of the control point's displacement, m", 0.001)
    control: Annotated[
        kinds.Name | Annotated[dict[kinds.Direction, kinds.Name], Field(min_length=1)] | None,
        NameOf("control point"),
    ] = absent('control point, or one per direction: {"+x" = "C1", "-x" = "C2"}; default the first')


class TieTable(ProjectTable):
    """[[tie]]: a tie rod (catena) between two points of blocks or supports; it pulls and never pushes."""

    name: kinds.Name = entry("name of the tie")
    from_m: kinds.Pair = entry("x and z, m, of one end as drawn, in or on a block")
    to_m: kinds.Pair = entry("x and z, m, of the other end, in or on another block")
    yield_force_kN: kinds.Yield = entry(
        "force, kN, at which it lengthens without bearing more: of bar, anchorage or masonry under the "
        "plate, the least; inf (default): none",
        math.inf,
    )
    stiffness_kN_m: kinds.BarStiffness | None = absent("E A/L of the whole tie, kN/m; absent: rigid")
    pretension_kN: kinds.Tension = entry("tension, kN, when it is set; counts in elastic analyses only", 0.0)
    ultimate_elongation: kinds.Elongation = entry(
        "share of its length by which it yields before it breaks: the capacity ends there; inf: it does not break",
        ELONGATION,
    )
    states: Annotated[kinds.Names | None, NameOf("state")] = absent(
        "states in which it is there; default every state, from the beginning"
    )

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield a tie that joins nothing, is set beyond its yield force, or is there before it is set."""
        if max(abs(one - other) for one, other in zip(self.from_m, self.to_m, strict=True)) < SHORTEST_TIE:
            yield "to_m", "the same point as from_m; write the point of another block"
        if self.pretension_kN >= self.yield_force_kN:
            text = f"{self.pretension_kN:g} kN is not below yield_force_kN = {self.yield_force_kN:g}"
            yield "pretension_kN", f"{text}, and the tie would yield as it is set; write less"
        for place, name in enumerate(self.states or ()):
            made = project.strengthening_of(name)
            if made and made.of in (self.states or ()):
                text = f'the tie is in "{made.of}" already, which "{name}" strengthens; name one of the two'
                yield ("states", place), text


class ChangedLayerTable(ProjectTable):
    """[strengthening.layers.NAME]: what repointing or injection makes of the joints of a layer."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1})

    friction: kinds.Friction | None = absent("tangent of the friction angle from then on")
    normal_stiffness_kN_m3: kinds.Stiffness | None = absent("normal stiffness from then on, kN/m³")
    tangential_stiffness_kN_m3: kinds.Rigidity | None = absent("tangential stiffness from then on, kN/m³")
    compressive_strength_kN_m2: kinds.Strength | None = absent("compressive strength from then on, kN/m²")

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield a change of nothing."""
        if all(getattr(self, key) is None for key in type(self).model_fields):
            yield (), "changes nothing; write what it makes of the joints, or leave it out"


class StrengtheningTable(ProjectTable):
    """[[strengthening]]: a state beside the one that it strengthens: its movement first, then ties and layers."""

    name: kinds.Name = entry("name of the strengthened state, for `states` of its ties")
    of: kinds.Name = entry('state that it strengthens: "original" or the name of a settlement')
    layers: Annotated[
        dict[kinds.Name, ChangedLayerTable], Field(max_length=kinds.MOST_LAYERS), kinds.DISTINCT
    ] = entry("layers whose joints it changes", {})

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield a name that another state has, a strengthening of none, or one that changes nothing."""
        if self.name in project.unstrengthened:
            yield "name", f'"{self.name}" is the name of another state; write another'
            return
        if project.strengthening_of(self.of):
            text = f'"{self.of}" is a strengthening itself; write the state that it is of, and name its ties here too'
            yield "of", text
        elif self.of not in project.unstrengthened:
            yield "of", f'no state to strengthen "{self.of}"; {nearest(self.of, project.unstrengthened)}'
        if not self.layers and not project.ties_of(self.name)[1]:
            text = f'changes nothing; add a [[tie]] with states = ["{self.name}"], or [strengthening.layers.NAME]'
            yield (), text
