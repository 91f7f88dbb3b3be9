"""Pushdown and pushover of a state."""

from typing import Literal

from assessment.results.schema.model import Face
from assessment.results.schema.part import Configuration, Part, Point, Sentence, key, optional, present

Behaviour = Literal["rigid", "elastic"]
Sliding = Literal["associative", "coulomb"]


class Run(Part):
    """`run`: which run of an ensemble everything printed of a state and direction comes from, the governing one."""

    increment_m: float = key("increment of the control point's displacement, or of a movement")
    member: int = key("1: the run; more: one with other increments and corners moved by 1e-7 of a block")


class TiePull(Part):
    """The tension of a tie, along a path or while the base moves."""

    tie: str = key("name of the tie", "Catena|Tie")
    greatest_kN: float | None = key("null: rigid joints do not determine it", "Massimo|Greatest", null="none")
    yields: bool = key("whether it reaches the yield force", "Snervata|Yields")
    lengthening_m: float = key("by how much it yields", "Allungamento|Lengthening", shown="mm")


class TieTension(TiePull):
    """`ties[]`: the tension of a tie along a path; rigid joints determine it where its blocks move apart or turn."""

    rest_kN: float | None = key("where the path starts; null: likewise", "In quiete|At rest", null="none")
    peak_kN: float | None = key(
        "at α_0 or α_u, or where the movement ends; null: likewise", "A α_0, α_u|At α_0, α_u", null="none"
    )


class Pictured(Part):
    """Where the blocks are at some points of a path, and what the joints carry there; for pictures."""

    configuration: list[Configuration] = key("x, z, ω of each block against the drawing")
    force_kN: list[list[Point] | None] = key("N and T of each joint, drawn ones, then `met`; null: not known")
    centre: list[list[float | None] | None] = key("where N presses, as a share of the joint; null: idle")
    met: list[Face] = key("pairs of faces that touch on the path and not as drawn; of motions none")
    tie_kN: list[list[float] | None] | None = optional(
        "tension of each tie of the state, those that are set there last; null: not known; missing: no tie. "
        "With rigid joints one of those that are possible, where `ties` has none"
    )


class Frames(Pictured):
    """`frames` of a static path."""

    index: list[int] = key("which points of the path")


class LocalLoss(Part):
    """`local_loss`: the first joint that bears and whose faces come to slide off each other, or tie that breaks."""

    displacement_m: float = key("of the control point along the push, or of the movement of a support")
    joint: int | None = key("number of the joint; null: a tie breaks", "Giunto|Joint")
    blocks: list[int] = key("numbers of its two blocks, or of those that the tie joins")
    overlap_m: float | None = key("how far its faces overlap where the path starts; null: a tie breaks")
    tie: str | None = optional("name of the tie that breaks")
    longest_m: float | None = optional("by how much it has yielded then")


class StaticPath(Part):
    """What every static path has."""

    sliding: Sliding = key("whether what slides lifts (associative) or not (coulomb)")
    end: Sentence = key("why the path ends")
    frames: Frames = key("some of its configurations")
    ties: list[TieTension] | None = optional("tension of the ties of the state; missing: no tie")


class PushdownPath(StaticPath):
    """`pushdown.rigid`, `.elastic`: a support moves as the settlement asks, and on to collapse where asked for."""

    movement_m: list[float] = key("largest component of the movement along the path")
    reaction_x_kN: list[float] = key("force of the moved support on the structure", "R_x")
    reaction_z_kN: list[float] = key("the same, vertical", "R_z")
    ultimate_movement_m: float | None = key(
        "largest component of the last movement at which the structure stands; null: not reached or not looked for",
        "Spostamento ultimo impresso|Ultimate movement", shown="mm",
    )  # fmt: skip
    ultimate_movement_m_range: list[float | None] | None = optional("of an ensemble; null: none in some")
    run: Run | None = optional("which run it is; missing: not told")
    local_loss: LocalLoss | None = optional("the first joint or tie that is lost; null: none")
    applied_movement_m: float = key("largest component of the movement that the settlement asks for")
    configuration: Configuration = key("after the whole movement, or where the structure falls")
    ultimate_configuration: Configuration | None = key("just before collapse; null: not reached")
    control_displacement_m: list[Point] | None = key("x, z of the first control point along the path")


class Curve(Part):
    """`curve`: multiplier over displacement of the control point, from the state's own rest."""

    displacement_m: list[float] = key(
        "along x: negative in a push towards −x",
        "Spostamento del punto di controllo|Displacement of the control point", shown="mm",
    )  # fmt: skip
    multiplier: list[float] = key("horizontal forces per seismic weight, α", "Moltiplicatore α|Multiplier α")


class Push(StaticPath):
    """What a pushover has with joints of either behaviour."""

    reached_zero: bool = key("whether the curve falls to α = 0")
    curve: Curve = key("the curve")
    members: list[Curve] | None = optional("curves of the other members of the ensemble")


class MassShares(Part):
    """Shares of a mechanism in the motion; missing or null: not defined."""

    e_star: float | None = optional("share of the mass that takes part, e*", "e*")
    gamma_star: float | None = optional("participation factor Γ* of the control point", "Γ*")


class Mechanism(MassShares):
    """`mechanism`: virtual displacements at the activation (where α_0 is reached)."""

    point: int = key("which point of the curve")
    alpha: float = key("multiplier there", "α")
    hinges: int = key("joints that turn", "Cerniere|Hinges")
    displacements: Configuration = key("x, z, ω of each block; the control point moves by 1 m along x")
    control_displacement_x: float = key("of the control point: 1, −1, less where it hardly moves", unit="m")
    hinge_points_m: list[Point] = key("x, z of each hinge in its configuration")
    sliding_joints: list[int] = key("numbers of the joints that slide")
    moving_weight_kN: float = key("weight of the blocks that move", "Peso in moto|Moving weight")
    friction_work_kNm: float | None = key("work of friction in joints that slide; null: they lift")


class OtherLaw(Part):
    """`other_law`: limit analysis where α_0 is reached by the other law of friction, where the two differ."""

    sliding: Sliding = key("whether what slides lifts (associative) or not (coulomb)")
    alpha_0: float = key("multiplier of the rigid mechanism by that law")
    alpha_onset: float | None = optional("what sets the first mechanism in motion by it; missing: the same")
    mechanism: Mechanism | None = optional("its mechanism; of a capacity: that of its curve")
    onset: Mechanism | None = optional("the first mechanism by it; missing: the same")
    zeta_E: dict[str, float] | None = optional(
        "of a capacity: ratio of each check by that law, where one differs by more than 2 %", unit="–"
    )


class SecondSolver(Part):
    """`second_solver`: α of limit analysis with associative friction where α_0 is reached, by two programs."""

    alpha_0: float = key("α_0 of the curve, with its law of friction")
    alpha_program: float | None = key("of this program; null: none", "α di questo programma|α this program")
    alpha_linear_program: float | None = key(
        "by a linear program written apart (static theorem, HiGHS); null: no optimum was found",
        "α del programma lineare|α linear program",
    )
    relative_difference: float | None = key(
        "of the second from the first; null: one is missing", "Scarto relativo|Relative difference", digits=2
    )


class RigidPush(Push):
    """`pushover.+x.rigid`: the capacity curve with rigid joints."""

    alpha_0: float = key("largest multiplier that, held, does not fell the structure, α_0", "α_0")
    alpha_0_range: list[float | None] | None = optional("least and largest of an ensemble")
    alpha_onset: float = key(
        "its first multiplier, of limit analysis in the state's own configuration; above it blocks meet "
        "others, or a hinge of a settlement closes",
        "α, primo moto|α, first motion",
    )
    d_0_m: float | None = key("displacement capacity; null: the path was cut short", "d_0", shown="mm")
    d_0_m_range: list[float | None] | None = optional("of an ensemble; null: none in some")
    other_law: OtherLaw | None = optional("by the other law of friction, where it differs by 1 % or more")
    d_star_m: list[float] | None = key(
        "d* of the blocks that move, at each point of the curve: ΣPδu/ΣPδ, u how far each has gone since the "
        "mechanism formed; null: Γ* is not defined"
    )
    lost: bool = key("whether equilibrium is lost before, where the capacity ends")
    local_loss: LocalLoss | None = optional("first joint or tie lost: limit of SLV, SLC where none is given")
    mechanism: Mechanism = key("the mechanism at its activation")
    onset: Mechanism | None = optional(
        "the mechanism that `alpha_onset` sets in motion, of which the linear checks are; missing: the same"
    )
    virtual_work_alpha: float | None = key(
        "multiplier by virtual work over all blocks, friction and ties; null: the horizontal load does none",
        "α lavori virtuali|α virtual work",
    )
    second_solver: SecondSolver | None = optional(
        "α of limit analysis by a second program; null: joints crush, the program is not linear"
    )
    mechanism_configuration: Configuration = key("where the mechanism starts")
    final_configuration: Configuration = key("at the end of the curve")

    @property
    def peak(self) -> int:
        """Which point of the curve has α_0: what exceeds it farther on does not count."""
        capped = [min(alpha, self.alpha_0) for alpha in self.curve.multiplier]
        return capped.index(max(capped))


class ElasticPush(Push):
    """`pushover.+x.elastic`: the curve with elastic joints."""

    alpha_u: float = key("largest multiplier that, held, does not fell the structure, α_u", "α_u")
    alpha_u_range: list[float | None] | None = optional("least and largest of an ensemble")
    d_u_m: float = key("displacement where it is reached, along the push")
    peak: int = key("which point of the curve that is")
    alpha_y: float | None = key(
        "plateau of the fitted capacity curve; without a check 0.9 α_u; null: d does not grow with α", "α_y"
    )
    d_y_m: float | None = key(
        "end of its elastic branch, along the push, on the secant at 0.4 α_u; null: as α_y", "d_y", shown="mm"
    )
    d_star_m: list[float] | None = optional(
        "d* of the blocks that move, at each point: those of the rigid mechanism; missing: no check"
    )
    lost: bool | None = optional("whether no equilibrium lies beyond its last point")
    rest_configuration: Configuration = key("at rest, before the push")
    peak_configuration: Configuration = key("at the peak")


class Pushovers(Part):
    """`pushover.+x`, `.-x`: the pushover in a direction; each curve where asked for and found."""

    control: str = key("control point that was followed")
    control_m: Point | None = optional("where it is, as drawn: x, z")
    run: Run | None = optional("which run its curves are of; missing: not told")
    rigid: RigidPush | None = optional("rigid joints")
    elastic: ElasticPush | None = optional("elastic joints")

    @property
    def by_contacts(self) -> dict[Behaviour, RigidPush | ElasticPush]:
        """The curves that are there."""
        return present({"rigid": self.rigid, "elastic": self.elastic})


class Strengthening(Part):
    """`strengthening` of a state: what was done to the state that it strengthens."""

    of: str = key("state whose movement comes first")
    ties: list[str] = key("ties that are set after it")
    layers: list[str] = key("layers whose joints are changed")


class RigidMovement(Part):
    """A rigid movement of a support."""

    support: str = key("name of the support that moves", "Appoggio|Support")
    displacement_m: Point = key("x, z")
    rotation_rad: float = key("about the centroid of the support, anticlockwise", "Rotazione|Rotation")


class Settlement(RigidMovement):
    """`settlement`: the movement that leads to the state."""

    increment_m: float = key("increment of the largest component")
    after: str | None = optional("state in which it begins; missing: as drawn", "Dopo|After")
