"""Motions and studies: [[history]], [incremental], [campaign], [sensitivity]."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from assessment.project.schema import values as kinds
from assessment.project.schema.structure import LEAST_MOVEMENT
from assessment.project.schema.values import Contradiction, FileName, NameOf, Table, absent, entry

if TYPE_CHECKING:
    from assessment.project.schema.content import ProjectContent

GENERATE = re.compile(r"generate:([1-9]\d{0,2})")
"""In the place of record files: so many records are made."""

VARIED = ("friction", "stiffness", "unit_weight", "depth")
"""The properties that [sensitivity] can vary."""


class MotionTable(Table):
    """What [[history]], [incremental] and [campaign] have in common: how a motion is integrated."""

    time_step_s: kinds.Seconds | None = absent(
        "time step, s; default the record's; also the sampling step of a one-column record"
    )
    window_s: kinds.Window | Literal["arias"] | None = absent(
        'first and last second of the record to use, or "arias": from 0.1 % of its Arias intensity, '
        "or 5 % of its peak if that is earlier, to 95 %"
    )
    contacts: kinds.Contacts = entry("contact model: rigid or elastic", "elastic")
    integrator: Literal["auto", "moreau-jean", "second-order", "implicit-euler"] = entry(
        "time integration: auto (the results say which it took), moreau-jean (many "
        "impacts), second-order, or implicit-euler (the paper's)",
        "auto",
    )
    damping_ratio: kinds.Damping | None = absent("viscous damping ratio of the contacts")
    control: Annotated[kinds.Name | None, NameOf("control point")] = absent(
        "control point; default the first"
    )

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield a window that is no stretch of time."""
        if isinstance(self.window_s, tuple) and not 0.0 <= self.window_s[0] < self.window_s[1]:
            yield "window_s", "not a stretch of time; write first and last second, 0 ≤ first < last"


class StatesTable(MotionTable):
    """What [[history]] and [incremental] have in common: motions from states of the project."""

    states: Annotated[kinds.Names | None, NameOf("state")] = absent(
        'states to analyse: "original", names of settlements and strengthenings; default all'
    )


class HistoryTable(StatesTable):
    """[[history]]: a time history of one record, from every state."""

    record: Annotated[kinds.Name, FileName()] = entry(
        "file of the horizontal ground acceleration; records/artificial.csv comes with a new project"
    )
    name: kinds.Name | None = absent("name in tables and figures; default the record's file name")
    scale: kinds.Ratio = entry("factor on the accelerations of the record; not zero", 1.0)
    vertical_record: Annotated[kinds.Name | None, FileName()] = absent(
        "file of the vertical ground acceleration"
    )
    animation: bool = entry("also write the motion from every state as a GIF", False)

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield a scale that leaves no motion."""
        if self.scale == 0.0:
            yield "scale", "0 leaves no motion; write 1.0 for the record as it is"
        yield from super().contradictions(project)


class IncrementalTable(StatesTable):
    """[incremental]: incremental dynamic analysis, PGA at incipient collapse per record and state."""

    records: Annotated[kinds.Names, FileName("pattern")] = entry(
        'record files; patterns such as "records/*.acc" are expanded'
    )
    tolerance_g: kinds.Acceleration = entry("tolerance of the PGA at collapse, g", 0.01)
    max_scale: kinds.Factor = entry("largest factor on a record that is tried", 5.0)


class CampaignTable(MotionTable):
    """[campaign]: records x movements x shares of them x signs; fragility and loss of capacity against movement."""

    records: Annotated[kinds.RecordSet, FileName("pattern")] = entry(
        'record files, patterns such as "records/*.acc" are expanded; or "generate:7": so many records '
        "made to the spectrum of the site"
    )
    settlements: Annotated[kinds.Names | None, NameOf("settlement")] = absent(
        "names of settlements; default all"
    )
    shares: kinds.Shares = entry("parts of each movement, 0 to 1", (0.0, 0.25, 0.5, 0.75, 1.0))
    signs: kinds.Signs = entry("factors on each record: 1, -1 or both", (1, -1))
    measure: Literal["PGA", "Sa(T)"] = entry(
        "intensity: PGA, or Sa(T), the spectral acceleration at period_s, 5 % damping", "PGA"
    )
    period_s: kinds.Seconds | None = absent("period T of Sa(T), s")
    method: Literal["incremental", "stripes"] = entry(
        "incremental: the level at collapse of each combination is searched; stripes: all at levels_g",
        "incremental",
    )
    levels_g: kinds.Levels | None = absent("levels of the stripes, g, of the measure")
    tolerance: Annotated[float, Field(ge=1e-3, le=0.5)] = entry(
        "tolerance of the level at collapse, relative to it", 0.05
    )
    max_scale: kinds.Factor = entry("largest factor on a record that is tried", 5.0)
    spectrum_compatible: bool = entry(
        "scale each record to the spectrum of the site between periods_s", False
    )
    periods_s: kinds.Periods = entry("first and last period of that spectrum, s", (0.15, 2.0))
    scale_limits: kinds.Factors = entry("least and largest factor of that scaling", (0.5, 2.0))

    curve_members: kinds.MemberNumbers | None = absent(
        "members of the ensembles whose displacement over time is kept, 1: the record itself; default none"
    )

    @property
    def generated(self) -> int:
        """Number of records to generate, 0 where files are named."""
        found = GENERATE.fullmatch(self.records[0])
        return int(found[1]) if found else 0

    def contradictions(self, project: ProjectContent) -> Iterator[Contradiction]:
        """Yield keys that do not go together, lists that are no ranges or not in order, and what is missing beside."""
        generated = [name for name in self.records if name.startswith("generate:")]
        if generated and not self.generated:
            text = f'"{generated[0]}" is no number of records; write "generate:7" or another number from 1 to 999'
            yield "records", text
        elif generated and len(self.records) > 1:
            yield "records", f'"{generated[0]}" stands alone; write it, or files'
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
        chosen = [
            each for each in project.settlements if self.settlements is None or each.name in self.settlements
        ]
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


class SensitivityTable(Table):
    """[sensitivity]: the capacity a_g again, with one property of the masonry lower and higher at a time."""

    friction: kinds.Factors | None = absent("low and high factor on every friction, such as [0.8, 1.2]")
    stiffness: kinds.Factors | None = absent(
        "low and high factor on every joint stiffness, normal and tangential"
    )
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
            text = 'assessment.model = "none" uses no stiffness; leave it out or write another model'
            yield "stiffness", text
        if not self.factors:
            yield (), f"nothing varies; write low and high factors of {', '.join(VARIED)}"
        for key, (low, high) in self.factors.items():
            if not low < high:
                yield key, f"[{low:g}, {high:g}] is no range; write the low factor, then the high one"
