"""Identification of the support movement that explains what was measured."""

from __future__ import annotations

from assessment.results.schema.part import Configuration, Part, Point, Sentence, key, optional


class SupportMovement(Part):
    """`movement[]`: what a support did; standard errors are null where the measurements do not determine them.

    Components that the hypothesis holds at zero have no standard error.
    """

    support: str = key("support")
    x_m: float = key("movement along x", "x", decimals=3)
    z_m: float = key("movement along z, upward", "z", decimals=3)
    rotation_rad: float = key("rotation about the support's centroid, anticlockwise")
    x_standard_error_m: float | None = optional("standard error of x")
    z_standard_error_m: float | None = optional("standard error of z")
    rotation_standard_error_rad: float | None = optional("standard error of the rotation")


class Fitted(Part):
    """`fit[]`: a measurement beside what the movement predicts."""

    measurement: str = key("name of the measurement", "Misura|Measurement")
    kind: str = key("crack, slip, lean or relative")
    unit: str = key("mm or mrad, of the four values", "Unità|Unit")
    predicted: float = key("predicted by the movement", "Previsto|Predicted", unit="mm, mrad")
    measured: float = key("measured", "Misurato|Measured", unit="mm, mrad")
    sigma: float = key("standard deviation of the measured value", "σ", unit="mm, mrad")
    residual: float = key("predicted less measured", "Residuo|Residual", unit="mm, mrad")
    residual_in_sigma: float = key("the same over sigma", "Residuo/σ|Residual/σ")


class Explanation(Part):
    """`hypotheses[]`: the movement of some supports that fits the measurements best."""

    hypothesis: Sentence = key("supports and their unknowns", "Ipotesi|Hypothesis")
    unknowns: int = key("number of unknowns", "Incognite|Unknowns")
    movement: list[SupportMovement] = key("the best movement; empty: none could be followed")
    chi_squared: float | None = key(
        "sum of the squared residuals over sigma; null: none could be followed", "χ²"
    )
    degrees_of_freedom: int = key("measurements less unknowns", "Gradi di libertà|Degrees of freedom")
    probability: float | None = key("of a χ² as large, were the hypothesis true; null: no degree of freedom")
    aic: float | None = key("Akaike's criterion, χ² plus twice the number of unknowns", "AIC")
    distinguished: bool = key("whether its AIC is more than 2 above the best one")
    undetermined: list[Sentence] = key("movements that the measurements do not determine")
    kinked: list[Sentence] = key(
        "components within whose standard error hinges move to other joints, and on which side"
    )
    contradicting: list[str] = key("measurements more than 3 sigma from what is predicted")
    at_collapse: bool = key("whether the fit would improve beyond what the structure survives")
    fit: list[Fitted] = key("the measurements, each beside its prediction")
    configuration: Configuration | None = key("of the blocks after the movement; null: none")


class ReadySettlement(Part):
    """`settlements[]`: a support's movement as [[settlements]] of the project file has it."""

    name: str = key("name of the state")
    support: str = key("support")
    displacement_m: Point = key("along x and z")
    rotation_rad: float = key("about the support's centroid")


class MeasuredPoint(Part):
    """`sites[]`: where a measurement was made, as drawn."""

    measurement: str = key("name of the measurement")
    point_m: Point = key("x and z of the point")
    from_m: Point | None = optional(
        "of the point that a relative displacement counts from; null: the benchmark"
    )
    block: int = key("block that the point moves with")
    from_block: int | None = optional("block of the other point; null: the benchmark")


class Identification(Part):
    """`identification`: movements of supports fitted to the measurements."""

    hypotheses: list[Explanation] = key("every hypothesis, in the order of the project file")
    best: int | None = key("number of the one with the least AIC, from 0; null: none could be followed")
    sites: list[MeasuredPoint] = key("where the measurements were made")
    settlements: list[ReadySettlement] = key(
        "the best movement for the project file; empty: several supports move at once, which is no settlement"
    )
