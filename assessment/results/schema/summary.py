"""The summary: what the first page of a report prints, each number once and ready to be printed."""

from __future__ import annotations

from typing import Literal

from assessment.results.schema.checks import Count, Direction, Multipliers, SafetyIndex
from assessment.results.schema.part import Part, key, optional
from assessment.results.schema.static import OtherLaw, Run


class SummaryCheck(Part):
    """`summary.rows[].checks.SLV`, …: the check that counts at a limit state."""

    check: str = key("its name: the least at SLO and SLD; `SLV linear` where the nonlinear one has no number")
    zeta_E: float | None = key("ζ_E at SLV and SLC, the ratio at SLO and SLD; null: not determined")
    zeta_E_range: list[float | None] | None = optional("least and largest of an ensemble")
    verified: bool | None = key("whether it is 1 or more")
    loss: float | None = optional("of a settled state: 1 − ζ_E/ζ_E(original)")
    gain: float | None = optional("of a strengthened state: ζ_E/ζ_E(before) − 1")


class SummaryMechanism(Count):
    """`summary.rows[].mechanism`: what moves where α_0 is reached with rigid joints."""

    kind: Literal["overturning", "hinges", "sliding", "mixed"] = key("one hinge; several; slides alone; both")
    moving_weight_kN: float = key("weight of the blocks that move")


class SummaryRow(Multipliers):
    """`summary.rows[]`: a state in a direction; every static number is of one run."""

    state: str = key("state")
    direction: Direction | None = key("direction of the push; null: motions alone")
    reached: bool = key("whether the structure stands after the movement of the state")
    run: Run | None = optional("of the static numbers")
    control: str | None = optional("control point of the push")
    alpha_loss: float | None = optional("1 − α/α(original), of α_0, with elastic joints alone of α_u")
    checks: dict[str, SummaryCheck] = key("by limit state; empty: no assessment")
    governing: str | None = key("limit state of the least ratio; null: none is determined")
    verified: bool | None = key(
        "whether SLV and SLC are verified, of those checked, or else the limit states that are; null: not determined"
    )
    mechanism: SummaryMechanism | None = optional("mechanism with rigid joints")
    other_law: OtherLaw | None = optional("by the other law of friction, where it differs")
    limit_state: str | None = key("the farthest one checked, of which the static capacity is; null: none")
    static_pga_g: float | None = key("PGA borne at that limit state, S a_g, with F_C; null: not determined")
    static_nominal_pga_g: float | None = optional("the same with F_C = 1, as `dynamic_pga_g` has none")
    dynamic_pga_g: float | None = optional("PGA at collapse by [incremental]; null: none found")
    dynamic_loss: float | None = optional(
        "`incremental.loss.dynamic`, of the levels of 50 %; without one 1 − PGA/PGA(original); null: not "
        "determined",
        "Perdita dinamica, mediana|Dynamic loss, median",
        shown="%",
        digits=2,
    )
    dynamic_to_static: float | None = optional("`dynamic_pga_g` over `static_nominal_pga_g`")


class SummaryGoverning(SafetyIndex):
    """`summary.governing`: where ζ_E is least, at SLV where it was checked (NTC 2018, §8.3)."""

    state: str = key("state")


class Summary(Part):
    """`summary`: every state and direction that was asked for, in the order of the project."""

    reference: Literal["surface"] = key("where every PGA of the summary is, static and dynamic: S a_g")
    governing: SummaryGoverning | None = key("the least index; null: none is determined")
    verified: bool | None = key("whether all rows are; null: not determined")
    rows: list[SummaryRow] = key("states and directions")
