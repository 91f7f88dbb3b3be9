"""Motions, studies, identification: [[history]], [incremental], [campaign], [sensitivity], [[measurement]]."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import AfterValidator, Field

from assessment.project.schema import values as kinds
from assessment.project.schema.structure import LEAST_MOVEMENT
from assessment.project.schema.values import Contradiction, FileName, NameOf, ProjectTable, absent, entry

if TYPE_CHECKING:
    from assessment.project.schema import ProjectContent


GENERATED = "generate:"
"""In the place of record files, with a number behind it: so many records are made."""
GENERATED_STEP = 0.01  # s: their time step

VARIED = ("friction", "stiffness", "unit_weight", "depth")
"""The properties that [sensitivity] can vary."""


class MotionTable(ProjectTable):
    """What [[history]], [incremental] and [campaign] have in common: how a motion is integrated."""

    time_step_s: kinds.Seconds | None = absent(
        "time step, s; default the record's; also the sampling step of a one-column record"
    )
    window_s: kinds.Window | Literal["arias"] | None = absent(
        'first and last second of the record to use, or "arias": from 0.1 % of its Arias intensity, '
        "or 5 % of its peak if that is earlier, to 95 %"
    )
    contacts: kinds.Behaviour = entry("contact model: rigid or elastic", "elastic")
    integrator: Literal["auto", "moreau-jean", "second-order", "implicit-euler"] = entry(
        "time integration: auto (the results say which it took), moreau-jean (many "
        "impacts), second-order, or implicit-euler (the paper's)",
        "auto",
    )
    damping_ratio: kinds.Damping | None = absent("viscous damping ratio of the contacts")
    control: Annotated[kinds.Name | None, NameOf("control point")] = absent("control point; default: first")

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield a window that is no stretch of time."""
        if isinstance(self.window_s, tuple) and not 0.0 <= self.window_s[0] < self.window_s[1]:
            yield "window_s", "not a stretch of time; write first and last second, 0 ≤ first < last"


class StatesTable(MotionTable):
    """What [[history]] and [incremental] have in common: motions from states of the project."""

    states: Annotated[kinds.Names | None, NameOf("state")] = absent(
        'states to analyse: "original", names of settlements and strengthenings; default all'
    )


class SetTable(MotionTable):
    """What [incremental] and [campaign] have in common: sets of records, each scaled until the structure falls."""

    vertical_records: Annotated[kinds.Series | None, FileName("pattern")] = absent(
        "files of their vertical ground accelerations, in the same order, scaled by the same factors"
    )
    max_scale: kinds.Factor = entry("largest factor on a record that is tried", 5.0)


class HistoryTable(StatesTable):
    """[[history]]: a time history of one record, from every state."""

    record: Annotated[kinds.Name, FileName()] = entry(
        "file of the horizontal ground acceleration; records/artificial.csv comes with a new project"
    )
    name: kinds.Name | None = absent("name in tables and figures; default the record's file name")
    scale: kinds.Ratio = entry("factor on the accelerations, vertical too; not zero; negative: reversed", 1.0)
    vertical_record: Annotated[kinds.Name | None, FileName()] = absent("file of the vertical acceleration")

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield a scale that leaves no motion."""
        if self.scale == 0.0:
            yield "scale", "0 leaves no motion; write 1.0 for the record as it is"
        yield from super().contradictions(project)


class IncrementalTable(StatesTable, SetTable):
    """[incremental]: incremental dynamic analysis, PGA at incipient collapse per record and state."""

    records: Annotated[kinds.Names, FileName("pattern")] = entry(
        'list of record files; patterns such as "records/*.acc" are expanded'
    )
    tolerance_g: kinds.Acceleration = entry("tolerance of the PGA at collapse, g", 0.01)


class CampaignTable(SetTable):
    """[campaign]: records x movements x shares of them x signs; fragility and loss of capacity against movement."""

    records: Annotated[kinds.RecordSet, FileName("records")] = entry(
        'record files, patterns such as "records/*.acc" are expanded; or "generate:7": so many records '
        "made to the spectrum of the site"
    )
    settlements: Annotated[kinds.Names | None, NameOf("settlement")] = absent("settlements; default all")
    shares: kinds.Shares = entry("parts of each movement, 0 to 1", (0.0, 0.25, 0.5, 0.75, 1.0))
    signs: kinds.Signs = entry("factors on each record: 1, -1 or both", (1, -1))
    measure: Literal["PGA", "Sa(T)"] = entry(
        "intensity: PGA, or Sa(T), the spectral acceleration at period_s, 5 % damping", "PGA"
    )
    period_s: kinds.Period | None = absent("period T of Sa(T), s")
    method: Literal["incremental", "stripes"] = entry(
        "incremental: the level at collapse of each combination is searched; stripes: all at levels_g",
        "incremental",
    )
    levels_g: kinds.Levels | None = absent("levels of the stripes, g, of the measure")
    tolerance: Annotated[float, Field(ge=1e-3, le=0.5)] = entry("of the level at collapse, relative", 0.05)
    spectrum_compatible: bool = entry("scale records to the spectrum of the site between periods_s", False)
    periods_s: kinds.Periods = entry("first and last period of that spectrum, s", (0.15, 2.0))
    scale_limits: kinds.Factors = entry("least and largest factor of that scaling", (0.5, 2.0))
    curve_members: kinds.MemberNumbers | None = absent(
        "members of the ensembles whose displacement over time is kept, 1: the record itself; default none"
    )

    @property
    def generated(self) -> int:
        """Number of records to generate, 0 where files are named."""
        found = re.fullmatch(rf"{GENERATED}([1-9]\d{{0,2}})", self.records[0])
        return int(found[1]) if found else 0

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield keys that do not go together, lists that are no ranges or not in order, and what is missing beside."""
        generated = [name for name in self.records if name.startswith(GENERATED)]
        if generated and not self.generated:
            text = f'"{generated[0]}" is no number of records; write "generate:7" or another number from 1 to 999'
            yield "records", text
        elif generated and len(self.records) > 1:
            yield "records", f'"{generated[0]}" stands alone; write it, or files'
        if generated and self.vertical_records:
            yield "vertical_records", "generated records have none; leave it out, or name files in records"
        if self.generated and (self.time_step_s or 0.0) > GENERATED_STEP:
            yield "time_step_s", f"records are made at {GENERATED_STEP:g} s; write that, or leave it out"
        yield from super().contradictions(project)
        if not project.settlements:
            yield "settlements", "no movement; add [[settlements]] with name and support"
        if self.measure == "Sa(T)" and self.period_s is None:
            yield "period_s", 'missing, but measure = "Sa(T)" asks for it; add the period T, in s'
        if self.measure == "PGA" and self.period_s is not None:
            yield "period_s", 'the PGA has no period; leave it out or write measure = "Sa(T)"'
        if self.method == "stripes" and self.levels_g is None:
            yield "levels_g", 'missing, but method = "stripes" asks for it; add levels in g'
        if self.method == "incremental" and self.levels_g is not None:
            text = 'the incremental search finds its own levels; leave it out or write method = "stripes"'
            yield "levels_g", text
        for key in ("shares", "levels_g"):
            values = getattr(self, key) or ()
            if list(values) != sorted(values):
                yield key, "not in order; write the smallest first"
        names = self.settlements or [each.name for each in project.settlements]
        chosen = [each for each in project.settlements if each.name in names]
        smallest = max(min((each.largest for each in chosen), default=1.0), LEAST_MOVEMENT)
        for index, share in enumerate(self.shares):
            if 0.0 < share * smallest < LEAST_MOVEMENT:
                text = f"{share:g} of the movement moves nothing; write 0 for the structure as drawn, or more"
                yield ("shares", index), text
        for key in ("periods_s", "scale_limits"):
            low, high = getattr(self, key)
            if not low < high:
                yield key, f"[{low:g}, {high:g}] is no range; write the lower one, then the higher one"
        for index, number in enumerate(self.curve_members or ()):
            if number > project.scatter:
                text = f"{number}: scatter = {project.scatter} runs no such member; write {project.scatter} or less"
                yield ("curve_members", index), text
        by_site = project.assessment and project.assessment.site and project.assessment.spectrum == "ntc"
        if (self.generated or self.spectrum_compatible) and not by_site:
            text = 'the spectrum of the site is asked for; add [assessment.site], with spectrum = "ntc"'
            yield "records" if self.generated else "spectrum_compatible", text


class SensitivityTable(ProjectTable):
    """[sensitivity]: the capacity a_g again, with one property of the masonry lower and higher at a time."""

    friction: kinds.Factors | None = absent("low and high factor on every friction, such as [0.8, 1.2]")
    stiffness: kinds.Factors | None = absent("low and high factor on every stiffness, normal and tangential")
    unit_weight: kinds.Factors | None = absent("low and high factor on every unit weight")
    depth: kinds.Factors | None = absent("low and high factor on every out-of-plane depth")
    states: Annotated[kinds.Names | None, NameOf("state")] = absent(
        'states to vary: "original", names of settlements and strengthenings; default all'
    )

    @property
    def factors(self) -> dict[str, tuple[float, float]]:
        """The properties to vary and their low and high factors."""
        return {key: getattr(self, key) for key in VARIED if getattr(self, key) is not None}

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield properties that are varied without an effect."""
        if project.assessment is None:
            yield (), "there is no capacity to vary; add [assessment] or leave [sensitivity] out"
        elif project.assessment.model == "none" and self.stiffness:
            yield "stiffness", 'model = "none" uses no stiffness; leave it out or write another model'
        if not self.factors:
            yield (), f"nothing varies; write low and high factors of {', '.join(VARIED)}"
        for key, (low, high) in self.factors.items():
            if not low < high:
                yield key, f"[{low:g}, {high:g}] is no range; write the low factor, then the high one"


Unknown = Literal["x", "z", "rotation"]
Unknowns = Annotated[tuple[Unknown, ...], kinds.ENTRIES, AfterValidator(kinds.unique)]
Hypothesis = Annotated[dict[kinds.Name, Unknowns], Field(min_length=1, max_length=20)]
MeasuredKind = Literal["crack", "slip", "lean", "relative"]
Millimetres = Annotated[float, Field(ge=-1e6, le=1e6)]
Milliradians = Annotated[float, Field(ge=-1e3, le=1e3)]
Deviation = Annotated[float, Field(ge=1e-6, le=1e6)]  # mm or mrad

VALUE_KEYS = {"crack": "opening_mm", "slip": "slip_mm", "lean": "rotation_mrad", "relative": "value_mm"}
"""The key of the measured value, by kind."""
PLACING = ("component", "from_m")  # keys of relative measurements alone
SIGMA_KEYS = {kind: f"sigma_{key.rpartition('_')[2]}" for kind, key in VALUE_KEYS.items()}
"""The key of its standard deviation, by kind."""


class IdentificationTable(ProjectTable):
    """[identification]: the movements of supports that may explain the measurements; each hypothesis is fitted."""

    hypotheses: Annotated[
        tuple[Hypothesis, ...], Field(strict=False, min_length=1, max_length=20), NameOf("support")
    ] = entry('supports that may have moved, each with its unknowns: [{ right = ["x", "z", "rotation"] }]')
    downward_only: bool = entry("supports do not rise", True)

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield hypotheses that name no support, ask too much, or are there twice; and that nothing is measured."""
        given = len(project.measurement)
        if not given:
            yield (), "there is nothing to explain; add [[measurement]]"
        for index, hypothesis in enumerate(self.hypotheses):
            if hypothesis in self.hypotheses[:index]:
                yield ("hypotheses", index), "the same as an earlier hypothesis; leave it out"
            unknowns = sum(map(len, hypothesis.values()))
            if 0 < given < unknowns:
                text = f"{unknowns} unknowns from {given} measurements: many movements fit exactly"
                yield ("hypotheses", index), f"{text}; measure more, or leave unknowns out"


class MeasurementTable(ProjectTable):
    """[[measurement]]: what was measured on the structure as it is, against how it was built."""

    name: kinds.Name = entry("name of the measurement")
    kind: MeasuredKind = entry(
        "crack: opening of a joint; slip: of a joint, without sign; lean: rotation of a block; relative: "
        "displacement of a point less that of another one"
    )
    point_m: kinds.Pair = entry("x and z, m, as drawn: at the edge of the measured joint, or in the block")
    from_m: kinds.Pair | Literal["benchmark"] | None = absent(
        'of relative: the other point, in a block, or "benchmark": ground that does not move'
    )
    component: Literal["x", "z"] | None = absent("of relative: x or z")
    opening_mm: Millimetres | None = absent("of a crack, mm; 0: there is none")
    slip_mm: Millimetres | None = absent("of slip, mm, without sign")
    rotation_mrad: Milliradians | None = absent("of lean, mrad, anticlockwise, from vertical as built")
    value_mm: Millimetres | None = absent("of relative, mm, along x or z")
    sigma_mm: Deviation | None = absent("standard deviation of opening, slip or value, mm")
    sigma_mrad: Deviation | None = absent("standard deviation of a rotation, mrad")

    @property
    def value(self) -> float:
        """The measured value, mm or mrad."""
        return getattr(self, VALUE_KEYS[self.kind])

    @property
    def sigma(self) -> float:
        """Its standard deviation, in the same unit."""
        return getattr(self, SIGMA_KEYS[self.kind])

    @property
    def unit(self) -> str:
        """The unit, mm or mrad."""
        return VALUE_KEYS[self.kind].rpartition("_")[2]

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield keys that a measurement of its kind lacks, or does not have."""
        own = {VALUE_KEYS[self.kind], SIGMA_KEYS[self.kind]}
        own |= set(PLACING) if self.kind == "relative" else set()
        needed = own - ({SIGMA_KEYS[self.kind]} if project.identification is None else set())
        for key in sorted({*VALUE_KEYS.values(), *SIGMA_KEYS.values(), *PLACING}):
            if key in needed and getattr(self, key) is None:
                yield key, f'missing; a measurement of kind "{self.kind}" needs it'
            elif key not in own and getattr(self, key) is not None:
                has = ", ".join(sorted(own))
                yield key, f'does not go with kind = "{self.kind}", which has {has}; leave it out'
        value = getattr(self, VALUE_KEYS[self.kind])
        if self.kind in ("crack", "slip") and value is not None and value < 0.0:
            yield VALUE_KEYS[self.kind], f"{value:g} is negative; it has no sign, write 0 or more"
        if self.kind == "relative" and self.from_m == self.point_m:
            yield "from_m", 'the same point as point_m; write another point, or "benchmark"'
