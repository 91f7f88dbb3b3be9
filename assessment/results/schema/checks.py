"""Capacity and checks to NTC 2018, indices of safety and risk, and the level of knowledge behind F_C."""

from collections.abc import Mapping
from typing import Literal, Self

from assessment.results.schema.model import Face, Line
from assessment.results.schema.part import Configuration, Part, Point, Sentence, key, optional, present
from assessment.results.schema.static import MassShares, OtherLaw, Run, Sliding

Direction = Literal["+x", "-x"]
CheckMethod = Literal["linear", "elastic", "nonlinear"]
# SLO, SLD and "SLV linear" are the linear kinematic check (a_0* of the rigid multiplier); "elastic" is the end of the
# elastic branch of a curve that has one; SLV and SLC are the nonlinear check
CHECKS = ("SLO", "SLO elastic", "SLD", "SLD elastic", "SLV linear", "SLV", "SLC")


class OscillatorCurve(Part):
    """`capacity.+x.curve`: capacity of the equivalent oscillator."""

    d_star_m: list[float] = key("displacement d*")
    a_star_g: list[float] = key("acceleration a*, divided by the confidence factor")


class Check(MassShares):
    """A check of a limit state."""

    method: CheckMethod = key("which check")
    d_star_m: float | None = key("displacement that counts; null: none", "d*", shown="mm", null="none")
    a_star_g: float | None = key("acceleration that counts; null: not defined", "a*", null="not_determined")
    T_s: float | None = key("period that counts; null: not defined", "T", null="not_determined")
    a_g_g: float | None = key("capacity a_g; null: not defined, `notes` say why", "a_g", ground="rock")
    demand_a_g_g: float = key("demand a_g", "a_g di domanda|a_g demanded", ground="rock")
    demand_a_star_g: float | None = optional("a_g S/q, at height a_Z/q", "a_D di domanda|a_D demanded")
    alpha_0: float | None = optional("of a linear check: multiplier that activates the first mechanism")
    pga_g: float | None = optional("capacity, S a_g", "PGA", null="not_determined", ground="surface")
    demand_pga_g: float | None = optional(
        "demand at the surface, S a_g", "PGA di domanda|PGA demanded", null="not_determined", ground="surface"
    )
    S: float | None = optional("from `reference` to the surface, of the capacity", "S")
    demand_S: float | None = optional("the same, of the demand")
    reference: str | None = optional("of a_g: rock (category A, without S), or surface for a record")
    zeta_E: float | None = key(
        "a_g S borne over that demanded: ζ_E at SLV and SLC, a ratio at SLO and SLD", "ζ_E", ratio=True
    )
    verified: bool | None = key(
        "whether the ratio is 1 or more; null: not determined, or below 1 within its range",
        "Esito|Outcome", null="not_determined",
    )  # fmt: skip
    damping: float | None = key("damping ratio of the demand")
    return_period_years: float | None = key(
        "of the capacity; null: the hazard of the site is not known", "T_R", null="not_determined"
    )
    return_period_stated: str | None = optional('"> 2475" or "< 30" beyond the hazard')
    governing: str = key("what gave a_g", "Condizione determinante|Governing condition")
    notes: list[Sentence] = key("what to know about it")
    trace: list[Line] = key("its calculation")
    a_g_g_range: list[float | None] | None = optional("least and largest of an ensemble")
    zeta_E_range: list[float | None] | None = optional("least and largest of an ensemble")


class NominalCheck(Check):
    """`capacity.+x.nominal`: the check with F_C = 1 that is compared with a dynamic capacity."""

    limit_state: str = key("the farthest one checked")


class _Checked(Part):
    """What has checks of limit states, each a key of its name."""

    SLO: Check | None = optional("check at SLO, in Python alone: `limit_states` of a project lack it")
    SLO_elastic: Check | None = optional("end of the elastic branch at SLO", alias="SLO elastic")
    SLD: Check | None = optional("linear check at SLD: a_0* of the rigid multiplier")
    SLD_elastic: Check | None = optional("end of the elastic branch at SLD", alias="SLD elastic")
    SLV: Check | None = optional("nonlinear check at SLV")
    SLV_linear: Check | None = optional("linear check at SLV, with the behaviour factor", alias="SLV linear")
    SLC: Check | None = optional("nonlinear check at SLC")

    @property
    def checks(self) -> dict[str, Check]:
        made: dict[str, Check | None] = {name: getattr(self, _attribute(name), None) for name in CHECKS}
        return present(made)

    def with_checks(self, checks: Mapping[str, Check]) -> Self:
        return self.replace(**{_attribute(name): check for name, check in checks.items()})


def _attribute(name: str) -> str:
    return name.replace(" ", "_")


class Count(Part):
    """`capacity.+x.mechanism`: the mechanism that the capacity is of."""

    hinges: int = key("joints that turn")
    sliding_joints: int = key("joints that slide", "Giunti in scorrimento|Sliding joints")


class VerticalCheck(Part):
    """`capacity.+x.vertical`: the linear check at SLV with 0.3 of the vertical component (NTC 2018, §7.2.2)."""

    a_v_g: float = key("vertical acceleration S_ve(0)", "a_v")
    alpha_0: float = key("multiplier that activates the first mechanism under the lighter weights")
    a_0_star_g: float = key("a_0* of it", "a_0*")
    demand_a_star_g: float = key("what it is compared with")
    ratio: float = key("their ratio", "Rapporto|Ratio", ratio=True)
    verified: bool = key("whether it is 1 or more")
    trace: list[Line] = key("its calculation")


class Capacity(_Checked, MassShares):
    """`capacity.+x`, `.-x`: the capacity in a direction and its checks, each where its limit state was asked for."""

    run: Run | None = optional("which run it is of; missing: not told")
    sliding: Sliding | None = optional(
        "law of friction of its α_0: that of the curve, or the other one where its α_0 is lower and none was asked for"
    )
    other_law: OtherLaw | None = optional("by the other law of friction, where α_0 differs by 1 % or more")
    mechanism: Count = key("the mechanism", "Meccanismo|Mechanism")
    alpha_0: float | None = optional("multiplier of the rigid mechanism")
    T_0_s: float | None = key("period of the elastic branch; null: the curve is rigid", "T_0")
    model: str = key("fitted curve: trilinear, bilinear, none")
    d_0_star_m: float | None = key("displacement where the capacity vanishes, d_0*", "d_0*", shown="mm")
    notes: list[Sentence] = key("what to know about the fitted curve")
    curve: OscillatorCurve = key("capacity curve")
    trace: list[Line] = key("calculation of the curve")
    vertical: VerticalCheck | None = optional("linear check with the vertical component, where asked for")
    nominal: NominalCheck | None = optional("check with F_C = 1, where there is an incremental analysis")

    @property
    def ratios(self) -> dict[str, float]:
        """Of a_g borne to a_g demanded, of every check that has one."""
        return present({name: check.zeta_E for name, check in self.checks.items()})


class DemandSpectrum(Part):
    """`spectra.SLV`, …: the demand at a limit state."""

    kind: Literal["ground", "floor", "record"] = key("whose spectrum", "Spettro|Spectrum")
    a_g_g: float = key("a_g, or the peak of a record")
    S: float = key("S = S_S S_T; 1 for a record")
    pga_g: float | None = optional("S a_g, at the surface")
    reference: str | None = optional("of a_g: rock, or surface for a record")
    T_s: list[float] = key("periods")
    S_e_g: list[float] = key("accelerations at 5 % damping", "S_e")
    S_De_m: list[float] = key("displacements at 5 % damping", "S_De", shown="mm")
    damping: float = key("damping ratio of the check")
    damped_S_e_g: list[float] = key("accelerations at that damping")
    damped_S_De_m: list[float] = key("displacements at that damping")
    F0: float | None = optional("F_0 of the site", "F_0")
    Tc_star_s: float | None = optional("T_C* of the site", "T_C*")
    soil: str | None = optional("soil category", "Suolo|Ground")
    topography: str | None = optional("topographic category", "Topografia|Topography")
    T_B_s: float | None = optional("start of the plateau", "T_B")
    T_C_s: float | None = optional("end of the plateau", "T_C")
    T_D_s: float | None = optional("start of constant displacement", "T_D")
    return_period_years: float | None = optional("return period of the demand, where a grid gives the hazard")
    trace: list[Line] | None = optional("its calculation")


class GivenMacroBlock(Part):
    """`mechanisms[].macro_blocks[]`: a macro-block of a mechanism of the user's."""

    about_m: Point = key("centre of rotation: x, z")
    rotation: float = key("virtual rotation, anticlockwise", unit="rad")
    blocks: list[int] = key("numbers of its blocks")


class GivenMechanism(_Checked, MassShares):
    """`mechanisms[]`: a mechanism of the project file; one that is refused has nothing but the reason."""

    name: str = key("name in the project file")
    state: str = key("state that it starts from")
    refused: Sentence | None = optional("why it cannot move as given", "Rifiutato perché|Refused because")
    direction: Direction | None = optional("direction of the loads that start it")
    alpha_0: float | None = optional("multiplier by virtual work")
    alpha_0_limit: float | None = optional(
        "α_0 of its state in that direction; null: not known", "α_0 analisi limite|α_0 limit analysis"
    )
    control_m: Point | None = optional("the point whose displacement is followed, in its state: x, z")
    a_0_star_g: float | None = optional("acceleration that starts it, divided by the confidence factor")
    d_0_m: float | None = optional("displacement of that point where α = 0; null: not found, `notes` say why")
    d_0_star_m: float | None = optional("the same of the equivalent oscillator")
    curve: OscillatorCurve | None = optional("capacity curve of its finite motion; null: not found")
    moving_weight_kN: float | None = optional("seismic weight that moves")
    macro_blocks: list[GivenMacroBlock] | None = optional("its macro-blocks")
    displacements: Configuration | None = optional("x, z, ω of each block, the largest being 1 m")
    penetration: float | None = optional("deepest penetration per largest displacement")
    sliding_joints: list[int] | None = optional("numbers of the joints that slide")
    met: list[Face] | None = optional("pairs of faces that touch in its state and not as drawn")
    notes: list[Sentence] | None = optional("what to know about it")
    trace: list[Line] | None = optional("its calculation")


class ComparisonRow(Part):
    """`comparison[]`: a settled state beside the original one."""

    state: str = key("the settled state", "Stato|State")
    direction: Direction | None = key("direction of the push; null: no pushover", "Direzione|Direction")
    limit_state: str | None = key("farthest one checked, of the static capacity", "Stato limite|Limit state")
    static_pga_g: float | None = key(
        "capacity of the state as PGA at the surface, S a_g, with F_C", "PGA statica|PGA, static",
        null="not_determined", ground="surface",
    )  # fmt: skip
    static_reduction: float | None = key(
        "1 − PGA(settled)/PGA(original) of it", "Riduzione statica|Reduction, static", change=True
    )
    dynamic_pga_g: float | None = key("PGA at its collapse", "PGA dinamica|PGA, dynamic", ground="surface")
    dynamic_reduction: float | None = key("likewise", "Riduzione dinamica|Reduction, dynamic", change=True)


class Multipliers(Part):
    """What a state bears in a direction; null: not found."""

    alpha_0: float | None = optional("largest multiplier with rigid joints, α_0")
    d_0_m: float | None = optional("displacement capacity d_0")
    alpha_u: float | None = optional("largest multiplier with elastic joints, α_u")


class RiskIndices(Part):
    """What follows from capacity and demand at SLV; null: the return periods that it needs are not known."""

    I_S: float | None = key("T_SLV/T_R,SLV (DPCM 9/2/2011); null: not known", "I_S", digits=2)
    f_a: float = key("a_SLV/a_g,SLV on rock (DPCM 9/2/2011)", "f_a", null="not_determined")
    acceptable_nominal_life_years: float | None = key(
        "V_N = −T_SLV ln(0.9)/C_U; null: not known", "V_N accettabile|V_N acceptable", digits=2
    )
    IS_V: float = key("ratio of PGA at SLV (DM 58/2017)", "IS-V", change=True)
    IS_V_class: str = key("its class, A+ to F", "Classe IS-V|IS-V class")
    PAM: float | None = key("expected annual loss, a share (DM 58/2017); null: not known", "PAM", change=True)
    PAM_class: str | None = key("its class, A+ to G", "Classe PAM|PAM class")
    risk_class: str | None = key(
        "the worse of both; null: PAM not known", "Classe di rischio|Risk class", null="not_determined"
    )
    trace: list[Line] = key("their calculation")


class Indices(RiskIndices):
    """`states.NAME.indices`: of the direction with the least ratio at SLV."""

    direction: Direction = key("direction of the push")
    check: str = key("which check at SLV: the linear one where the nonlinear one has no number")
    zeta_SLV: float = key("ζ_E at SLV (NTC 2018, §8.3): the headline", "ζ_E SLV", ratio=True)
    zeta_SLC: float | None = key("least at SLC; null: not checked", "Rapporto SLC|Ratio SLC", ratio=True)
    ratio_SLD: float | None = key("least at SLD; null: not checked", "Rapporto SLD|Ratio SLD", ratio=True)
    T_SLV_years: float | None = key("return period at SLV; null: not known", "T_SLV", null="not_determined")
    T_SLV_stated: str | None = key('"> 2475" or "< 30" beyond the hazard')
    T_R_SLV_years: float | None = key("return period of the demand at SLV; null: not known", "T_R,SLV")
    use_class: str = key("use class of the project file", "Classe d’uso|Use class")
    required_zeta: dict[str, float | None] = key(
        "ζ_E that each kind of intervention must reach (NTC 2018, §8.4), of a strengthened state from the ζ_E "
        "of the state that it strengthens; null: no such threshold, or that ζ_E is not known",
        "ζ_E da raggiungere|ζ_E required", ratio=True, unit="–",
    )  # fmt: skip
    zeta_before: float | None = optional(
        "of a strengthened state: ζ_E at SLV of the state that it strengthens; null: not known",
        "ζ_E prima|ζ_E before", ratio=True,
    )  # fmt: skip
    attained: dict[str, bool] | None = optional("whether ζ_E at SLV reaches each", "Raggiunto|Attained")


class Knowledge(Part):
    """`knowledge`: what the confidence factor follows from."""

    F_C: float = key("confidence factor")
    level: str | None = key("level of knowledge; null: from components")
    components: dict[str, float] = key("components F_Ck by name", unit="–")
    origins: dict[str, str] = key("where each parameter comes from")
    trace: list[Line] = key("its calculation")
