"""Identification of the support movement that explains what was measured: [identification], [[measurement]]."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from assessment.project.schema.values import ENTRIES, Name, Pair, Table, unique

Unknown = Literal["x", "z", "rotation"]
Unknowns = Annotated[tuple[Unknown, ...], ENTRIES, AfterValidator(unique)]
Hypothesis = Annotated[dict[Name, Unknowns], Field(min_length=1, max_length=20)]
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

SIGMA_KEYS: dict[str, str] = {kind: f"sigma_{key.rpartition('_')[2]}" for kind, key in VALUE_KEYS.items()}
"""The key of its standard deviation, by kind."""


class IdentificationTable(Table):
    """[identification]: the movements of supports that may explain the measurements; each hypothesis is fitted."""

    hypotheses: Annotated[tuple[Hypothesis, ...], Field(strict=False, min_length=1, max_length=20)] = Field(
        description='supports that may have moved, each with its unknowns: [{ right = ["x", "z", "rotation"] }]'
    )
    downward_only: bool = Field(default=True, description="supports do not rise")


class MeasurementTable(Table):
    """[[measurement]]: what was measured on the structure as it is, against how it was built."""

    name: Name = Field(description="name of the measurement")
    kind: MeasuredKind = Field(
        description="crack: opening of a joint; slip: of a joint, without sign; lean: rotation of a block; relative: "
        "displacement of a point less that of another one"
    )
    point_m: Pair = Field(
        description="x and z, m, as drawn: at the edge of the joint where it was measured, or in the block"
    )
    from_m: Pair | Literal["benchmark"] | None = Field(
        default=None,
        description='of relative: the other point, in a block, or "benchmark": ground that does not move',
    )
    component: Literal["x", "z"] | None = Field(default=None, description="of relative: x or z")
    opening_mm: Millimetres | None = Field(default=None, description="of a crack, mm; 0: there is none")
    slip_mm: Millimetres | None = Field(default=None, description="of slip, mm, without sign")
    rotation_mrad: Milliradians | None = Field(
        default=None, description="of lean, mrad, anticlockwise, from vertical as built"
    )
    value_mm: Millimetres | None = Field(default=None, description="of relative, mm, along x or z")
    sigma_mm: Deviation | None = Field(
        default=None, description="standard deviation of opening, slip or value, mm"
    )
    sigma_mrad: Deviation | None = Field(default=None, description="standard deviation of a rotation, mrad")

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
