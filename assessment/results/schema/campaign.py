"""Campaigns: combinations, fragility and loss of capacity by movement."""

from __future__ import annotations

from assessment.results.schema.dynamic import Bound, Loss, MeasureFit, Range, Scanned
from assessment.results.schema.part import Part, Sentence, key, optional


class CampaignRecord(Part):
    """`campaign.records[]`: a record as applied."""

    record: str = key("name of the record")
    record_pga_g: float = key("its PGA, the factor included")
    sa_g: float | None = optional("its S_a(T), where that is the measure", "S_a(T)")
    scale: float = key("factor on the file", "Fattore|Factor")
    duration_s: float = key("duration", "Durata|Duration")
    time_step_s: float = key("time step", "Passo|Step")


class CampaignSpectrum(Part):
    """`campaign.spectrum`: the mean spectrum of the records beside that of the site."""

    limit_state: str = key("limit state of the target")
    periods_s: list[float] = key("first and last period compared")
    T_s: list[float] = key("periods")
    target_g: list[float] = key("spectrum of the site")
    mean_g: list[float] = key("mean of the records")
    lowest_deviation: float = key("relative")
    highest_deviation: float = key("relative")
    within: bool = key("whether both are usual")


class SameAs(Part):
    """`same_as`: the combination that has the same state, and was run."""

    settlement: str = key("name of the movement")
    share: float = key("of the movement")
    sign: int = key("factor on the record; the other one: its mirror image", unit="–")


class CampaignCombination(Scanned):
    """`campaign.combinations[]`: a record of one sign from one settled state."""

    record: str = key("name of the record")
    settlement: str = key("name of the movement")
    share: float = key("of the movement")
    sign: int = key("factor on the record, 1 or −1", "Segno|Sign")
    pga_collapse_range: Range | None = key(
        "from `pga_collapse_g` to the level from which all levels run collapse; null: not reached", unit="g"
    )
    sa_collapse_g: float | None = optional(
        "S_a(T) at collapse, where that is the measure", "S_a(T) al collasso|S_a(T) at collapse"
    )
    collapsed: list[bool] | None = optional("of stripes: whether a motion collapses, by level")
    all_collapsed: list[bool] | None = optional("of stripes: whether all collapse, by level")
    same_as: SameAs | None = optional("where another combination has the numbers")


class CampaignFragility(Part):
    """`campaign.fragility[]`: lognormal distribution of the level at collapse after a movement."""

    settlement: str = key("name of the movement", "Cedimento|Movement")
    share: float = key("of the movement")
    movement_m: float = key("largest component")
    combinations: int = key("combinations", "Combin.")
    failed: int = key("of these, not completed, in no median", "Non completate|Not completed")
    withstood: int = key("of these, without collapse: lower bounds", "Sopportate|Withstood")
    median_g: float | None = key("median of the measure; null: not known", "Mediana|Median", ground="surface")
    median_range: Range | None = key("95 % of the bootstrap; null: fewer than three records", unit="g")
    beta: float | None = key(
        "standard deviation of ln of the measure: of records and within them", "β", digits=2
    )
    beta_range: Range | None = key("95 % of the bootstrap")
    beta_record: float | None = key(
        "β of the 50 % levels of the records", "β accelerogr.|β records", digits=2
    )
    beta_ensemble: float | None = key(
        "β of the levels of one record, the root of the mean square", "β insieme|β ensemble", digits=2
    )
    level_16_g: float | None = key("level of which 16 % collapse")
    level_84_g: float | None = key("level of which 84 % collapse")
    band: list[Bound] | None = optional("as of `incremental.fragility`, of the measure", unit="–, g")
    measures: list[MeasureFit] = key("the same levels by other measures of the records; of stripes none")
    rule: str | None = key(
        "NTC 2018, §7.3.5: the mean of seven records or more, the lowest of three to six; null: fewer, or "
        "stripes",
        "Regola, §7.3.5|Rule, §7.3.5",
    )
    pga_collapse_g: float | None = key(
        "what counts by it, of each record the worse sign; null: open, or no rule"
    )


class CampaignLoss(Loss):
    """`campaign.loss[]`: 1 − capacity after a movement / capacity before."""

    settlement: str = key("name of the movement")
    share: float = key("of the movement")
    movement_m: float = key("largest component")
    static: float | None = key("of the static check, weaker direction")
    static_capacity: float | None = key("of `static_quantity`; a_g as a_g S, at the surface", unit="g or –")


class Campaign(Part):
    """`campaign`: records x movements x shares x signs."""

    measure: str = key("PGA or Sa(T)")
    period_s: float | None = key("T")
    method: str = key("incremental or stripes")
    levels_g: list[float] = key("of stripes")
    tolerance: float = key("of the level at collapse, relative")
    contacts: str = key("rigid or elastic")
    members: int = key("of stripes, motions of each level at most")
    symmetric: bool = key("whether one sign stands for both of the structure as drawn")
    static_quantity: str | None = key("key that the static loss is of; null: no pushover")
    records: list[CampaignRecord] = key("the records")
    spectrum: CampaignSpectrum | None = key("their mean spectrum; null: no spectrum was asked for")
    combinations: list[CampaignCombination] = key("every combination")
    computed: int = key("distinct combinations", "Questa versione|This version")
    failures: list[Sentence] = key("what could not be completed, and why")
    fragility: list[CampaignFragility] = key("by movement and share")
    loss: list[CampaignLoss] = key("by movement and share")
    warnings: list[Sentence] = key("of the single runs")
