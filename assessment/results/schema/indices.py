"""Indices of safety and risk of a state, and the level of knowledge behind the confidence factor."""

from __future__ import annotations

from assessment.results.schema.checks import Direction
from assessment.results.schema.model import Line
from assessment.results.schema.part import Part, key, optional


class Indices(Part):
    """`states.NAME.indices`: of the direction with the least ratio at SLV."""

    direction: Direction = key("direction of the push")
    check: str = key("which check at SLV: the linear one where the nonlinear one has no number")
    zeta_SLV: float = key("ζ_E at SLV (NTC 2018, §8.3): the headline", "ζ_E SLV", ratio=True)
    zeta_SLC: float | None = key(
        "least ratio at SLC; null: not checked", "Rapporto SLC|Ratio SLC", ratio=True
    )
    ratio_SLD: float | None = key(
        "least ratio at SLD; null: not checked", "Rapporto SLD|Ratio SLD", ratio=True
    )
    T_SLV_years: float | None = key(
        "return period of the capacity at SLV; null: not known", "T_SLV", null="not_determined"
    )
    T_SLV_stated: str | None = key('"> 2475" or "< 30" beyond the hazard')
    T_R_SLV_years: float | None = key("return period of the demand at SLV; null: not known", "T_R,SLV")
    I_S: float | None = key("T_SLV/T_R,SLV (DPCM 9/2/2011); null: not known", "I_S", digits=2)
    f_a: float = key("a_SLV/a_g,SLV on rock (DPCM 9/2/2011)", "f_a", null="not_determined")
    acceptable_nominal_life_years: float | None = key(
        "V_N = −T_SLV ln(0.9)/C_U; null: not known", "V_N accettabile|V_N acceptable", digits=2
    )
    IS_V: float = key("ratio of PGA at SLV (DM 58/2017)", "IS-V", change=True)
    IS_V_class: str = key("its class, A+ to F", "Classe IS-V|IS-V class")
    PAM: float | None = key(
        "expected annual loss as a share (DM 58/2017); null: not known", "PAM", change=True
    )
    PAM_class: str | None = key("its class, A+ to G", "Classe PAM|PAM class")
    risk_class: str | None = key(
        "the worse of the two classes; null: PAM is not known",
        "Classe di rischio|Risk class",
        null="not_determined",
    )
    use_class: str = key("use class of the project file", "Classe d’uso|Use class")
    required_zeta: dict[str, float | None] = key(
        "ζ_E that each kind of intervention must reach (NTC 2018, §8.4), of a strengthened state from the ζ_E "
        "of the state that it strengthens; null: no such threshold, or that ζ_E is not known",
        unit="–",
    )
    zeta_before: float | None = optional(
        "of a strengthened state: ζ_E at SLV of the state that it strengthens; null: not known",
        "ζ_E prima|ζ_E before",
        ratio=True,
    )
    attained: dict[str, bool] | None = optional(
        "of a strengthened state: whether ζ_E at SLV reaches each of them"
    )
    trace: list[Line] = key("their calculation")


class Knowledge(Part):
    """`knowledge`: what the confidence factor follows from."""

    F_C: float = key("confidence factor")
    level: str | None = key("level of knowledge; null: from components")
    components: dict[str, float] = key("components F_Ck by name", unit="–")
    origins: dict[str, str] = key("where each parameter comes from")
    trace: list[Line] = key("its calculation")
