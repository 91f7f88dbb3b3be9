"""Convergence, scenarios and sensitivity; identification of the support movement that explains what was measured."""

from assessment.results.schema.checks import Direction, Multipliers
from assessment.results.schema.part import Configuration, Part, Point, Sentence, key, optional
from assessment.results.schema.static import RigidMovement


class ConvergenceRow(Part):
    """`convergence.rows[]` and `.incremental[]`: estimated errors of one state's results.

    Errors are of the finest level, in the unit of the quantity; null: not known, as not every level reaches it.
    """

    state: str = key("state")
    direction: str | None = optional("of a pushover")
    record: str | None = optional("of a motion")
    halvings: int | None = optional("of increments or time step behind the result", "Dimezzamenti|Halvings")
    alpha_0_error: float | None = optional("of α_0", "Errore di α_0|Error of α_0", null="not_known")
    d_0_error_m: float | None = optional("of d_0", "Errore di d_0|Error of d_0", shown="mm", null="not_known")
    alpha_u_error: float | None = optional("of α_u", "Errore di α_u|Error of α_u", null="not_known")
    a_g_error_g: float | None = optional(
        "of a_g at the farthest limit state", "Errore di a_g|Error of a_g", ground="rock", null="not_known"
    )
    peak_displacement_error_m: float | None = optional(
        "of the peak", "Errore del massimo|Error of the peak", shown="mm", null="not_known"
    )
    peak_displacement_scatter_m: float | None = optional(
        "how far the peaks of a pair are apart, where that is more than time steps differ",
        "Dispersione del massimo|Scatter of the peak", shown="mm", null="not_known",
    )  # fmt: skip
    pga_collapse_error_g: float | None = optional(
        "estimated error of the PGA at collapse",
        "Errore della PGA al collasso|Error of the PGA at collapse", ground="surface", null="not_known",
    )  # fmt: skip
    order: float | None = optional("that the last levels show; null: none", "Ordine|Order", null="not_known")
    relative_error: float | None = optional(
        "the largest, relative", "Errore massimo|Largest error", shown="%", digits=2, null="not_known"
    )
    relative_scatter: float | None = optional("relative", "Dispersione|Scatter", shown="%", null="not_known")
    met: bool = key("whether the tolerance is met", "Entro la tolleranza|Within tolerance")
    levels: dict[str, list[float | None]] = key("what each level gave, by quantity; null: not reached")


class Convergence(Part):
    """`convergence`: how far the results are from converged."""

    tolerance: float | None = key("relative; null: no error was estimated")
    rows: list[ConvergenceRow] = key("pushovers and histories")
    incremental: list[ConvergenceRow] | None = optional("PGA at collapse")


class Capacities(Multipliers):
    """What a study keeps of one state in one direction."""

    a_g_g: float | None = optional("capacity a_g at `limit_state`; null: not defined")
    zeta_E: float | None = optional("ratio to the demand")
    collapses: bool = key("whether the structure falls before the whole movement", "Collasso|Collapse")


class ScenarioPoint(Capacities):
    """`scenarios.points[]`: a part of a movement."""

    state: str = key("settlement that it is a part of")
    share: float = key("of the whole movement", "Frazione del cedimento|Part of the movement")
    movement_m: float = key("largest component", "Movimento|Movement", shown="mm")
    direction: Direction = key("direction of the push")
    reduction: float | None = key(
        "of `quantity` from the original state in the same direction", "Riduzione|Reduction", change=True
    )


class Studied(Part):
    """What scenarios and sensitivity have."""

    limit_state: str | None = key("limit state of a_g and ζ_E; null: no assessment")
    warnings: list[Sentence] = key("of the single runs")


class Scenarios(Studied):
    """`scenarios`: all movements side by side."""

    quantity: str = key("key that they are compared by", "Grandezza|Quantity")
    points: list[ScenarioPoint] = key("every part of every movement")
    worst: ScenarioPoint | None = key("the worst of them; null: none is known")


class SensitivityRun(Capacities):
    """`sensitivity.runs[]`: a state with one property multiplied."""

    state: str = key("state")
    property: str = key("friction, stiffness, unit_weight or depth", "Proprietà|Property")
    factor: float = key("factor on it")
    direction: Direction = key("direction of the push")


class Sensitivity(Studied):
    """`sensitivity`: every state with each property lower and higher."""

    runs: list[SensitivityRun] = key("two to a property, state and direction")


class FittedMovement(Part):
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
    movement: list[FittedMovement] = key("the best movement; empty: none could be followed")
    chi_squared: float | None = key("sum of squared residuals over sigma; null: none could be followed", "χ²")
    degrees_of_freedom: int = key("measurements less unknowns", "Gradi di libertà|Degrees of freedom")
    probability: float | None = key("of a χ² as large, were the hypothesis true; null: no degree of freedom")
    aic: float | None = key("Akaike's criterion, χ² plus twice the number of unknowns", "AIC")
    distinguished: bool = key("whether its AIC is more than 2 above the best one")
    undetermined: list[Sentence] = key("movements that the measurements do not determine")
    kinked: list[Sentence] = key("components within whose error hinges move to other joints, on which side")
    contradicting: list[str] = key("measurements more than 3 sigma from what is predicted")
    at_collapse: bool = key("whether the fit would improve beyond what the structure survives")
    fit: list[Fitted] = key("the measurements, each beside its prediction")
    configuration: Configuration | None = key("of the blocks after the movement; null: none")


class ReadySettlement(RigidMovement):
    """`settlements[]`: a support's movement as [[settlements]] of the project file has it."""

    name: str = key("name of the state")


class MeasuredPoint(Part):
    """`sites[]`: where a measurement was made, as drawn."""

    measurement: str = key("name of the measurement")
    point_m: Point = key("x and z of the point")
    from_m: Point | None = optional("point that a relative displacement counts from; null: the benchmark")
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
