"""Identification of the support movement that explains what was measured: [identification], [[measurement]]."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import AfterValidator, Field

from assessment.project.schema import values as kinds
from assessment.project.schema.values import ENTRIES, Contradiction, NameOf, Table, absent, entry, unique

if TYPE_CHECKING:
    from assessment.project.schema.content import ProjectContent

Unknown = Literal["x", "z", "rotation"]
Unknowns = Annotated[tuple[Unknown, ...], ENTRIES, AfterValidator(unique)]
Hypothesis = Annotated[dict[kinds.Name, Unknowns], Field(min_length=1, max_length=20)]
MeasuredKind = Literal["crack", "slip", "lean", "relative"]
Millimetres = Annotated[float, Field(ge=-1e6, le=1e6)]
Milliradians = Annotated[float, Field(ge=-1e3, le=1e3)]
Deviation = Annotated[float, Field(ge=1e-6, le=1e6)]  # mm or mrad

VALUE_KEYS: dict[str, str] = {
    "crack": "opening_mm",
    "slip": "slip_mm",
    "lean": "rotation_mrad",
    "relative": "value_mm",
}
"""The key of the measured value, by kind."""

PLACING = ("component", "from_m")  # keys of relative measurements alone
SIGMA_KEYS: dict[str, str] = {kind: f"sigma_{key.rpartition('_')[2]}" for kind, key in VALUE_KEYS.items()}
"""The key of its standard deviation, by kind."""


class IdentificationTable(Table):
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


class MeasurementTable(Table):
    """[[measurement]]: what was measured on the structure as it is, against how it was built."""

    name: kinds.Name = entry("name of the measurement")
    kind: MeasuredKind = entry(
        "crack: opening of a joint; slip: of a joint, without sign; lean: rotation of a block; relative: "
        "displacement of a point less that of another one"
    )
    point_m: kinds.Pair = entry(
        "x and z, m, as drawn: at the edge of the joint where it was measured, or in the block"
    )
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
        found: float = getattr(self, VALUE_KEYS[self.kind])
        return found

    @property
    def sigma(self) -> float:
        """Its standard deviation, in the same unit."""
        found: float = getattr(self, SIGMA_KEYS[self.kind])
        return found

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
                text = (
                    f'does not go with kind = "{self.kind}", which has {", ".join(sorted(own))}; leave it out'
                )
                yield key, text
        value = getattr(self, VALUE_KEYS[self.kind])
        if self.kind in ("crack", "slip") and value is not None and value < 0.0:
            yield VALUE_KEYS[self.kind], f"{value:g} is negative; it has no sign, write 0 or more"
        if self.kind == "relative" and self.from_m == self.point_m:
            yield "from_m", 'the same point as point_m; write another point, or "benchmark"'
