"""Campaigns: combinations, fragility and loss of capacity by movement."""

from __future__ import annotations

from assessment.results.schema.dynamic import Course, Level, Range
from assessment.results.schema.part import Part, Sentence, key, optional


class CampaignRecord(Part):
    """`campaign.records[]`: a record as applied."""

    record: str = key("name of the record")
    record_pga_g: float = key("its PGA, the factor included", "g")
    sa_g: float | None = optional("its S_a(T), where that is the measure", "g", "S_a(T)")
    scale: float = key("factor on the file", "–", ("Fattore", "Factor"))
    duration_s: float = key("duration", "s", ("Durata", "Duration"))
    time_step_s: float = key("time step", "s", ("Passo", "Step"))


class CampaignSpectrum(Part):
    """`campaign.spectrum`: the mean spectrum of the records beside that of the site."""

    limit_state: str = key("limit state of the target")
    periods_s: list[float] = key("first and last period compared", "s")
    T_s: list[float] = key("periods", "s")
    target_g: list[float] = key("spectrum of the site", "g")
    mean_g: list[float] = key("mean of the records", "g")
    lowest_deviation: float = key("relative", "–")
    highest_deviation: float = key("relative", "–")
    within: bool = key("whether both are usual")


class CampaignCurve(Course):
    """`curves[]`: horizontal displacement of the control point in a member's motion, from rest, thinned."""

    member: int = key("its number, 1: the record itself")
    factor: float = key("on the level, 1 of the record itself", "–")


class CampaignLevel(Level):
    """`points[]` of a combination: what its members come to at one PGA."""

    residual_displacement_m: float | None = key("largest at the end; null: a collapse", "m")
    curves: list[CampaignCurve] | None = optional("of the members asked for that were run")


class SameAs(Part):
    """`same_as`: the combination that has the same state, and was run."""

    settlement: str = key("name of the movement")
    share: float = key("of the movement", "–")
    sign: int = key("factor on the record; the other one: its mirror image", "–")


class CampaignCombination(Part):
    """`campaign.combinations[]`: a record of one sign from one settled state."""

    record: str = key("name of the record")
    settlement: str = key("name of the movement")
    share: float = key("of the movement", "–")
    sign: int = key("factor on the record, 1 or −1", label=("Segno", "Sign"))
    pga_collapse_g: float | None = key("least PGA at which a member collapses; null: none found", "g")
    pga_collapse_range: Range | None = key("from there to where all collapse; null: not reached", "g")
    pga_safe_g: float | None = key("largest PGA below at which all stand; null: not completed", "g")
    sa_collapse_g: float | None = optional(
        "S_a(T) at collapse, where that is the measure", "g", ("S_a(T) al collasso", "S_a(T) at collapse")
    )
    sa_collapse_g_range: Range | None = optional("from there to where all collapse", "g")
    resurrections_g: list[float] = key("levels above at which the structure stands again, PGA", "g")
    collapsed: list[bool] | None = optional("of stripes: whether a member collapses, by level")
    all_collapsed: list[bool] | None = optional("of stripes: whether all collapse, by level")
    runs: int = key("motions computed")
    points: list[CampaignLevel] = key("every level that was run")
    reason: Sentence | None = key("why there is no answer", label=("Motivo", "Reason"))
    same_as: SameAs | None = optional("where another combination has the numbers")


class CampaignFragility(Part):
    """`campaign.fragility[]`: lognormal distribution of the level at collapse after a movement."""

    settlement: str = key("name of the movement", label=("Cedimento", "Movement"))
    share: float = key("of the movement", "–")
    movement_m: float = key("largest component", "m")
    combinations: int = key("combinations", label="Combin.")
    failed: int = key("of these, not completed, in no median", label=("Non completate", "Not completed"))
    withstood: int = key("of these, without collapse: lower bounds", label=("Sopportate", "Withstood"))
    median_g: float | None = key(
        "median of the measure; null: not known", "g", ("Mediana", "Median"), ground="surface"
    )
    median_range: Range | None = key("95 % of the bootstrap; null: fewer than three records", "g")
    beta: float | None = key("standard deviation of ln of the measure", "–", "β", digits=2)
    beta_range: Range | None = key("95 % of the bootstrap", "–")
    median_all_collapse_g: float | None = key(
        "median of the level at which all members collapse",
        "g",
        ("Tutti collassano", "All collapse"),
        ground="surface",
    )
    beta_record: float | None = key(
        "what remains without the scatter of the ensembles", "–", ("β accelerogr.", "β records"), digits=2
    )
    beta_ensemble: float | None = key(
        "scatter within one combination", "–", ("β insieme", "β ensemble"), digits=2
    )
    rule: str | None = key(
        "NTC 2018, §7.3.5: the mean of seven records or more, the lowest of three to six; null: fewer, or stripes",
        label=("Regola, §7.3.5", "Rule, §7.3.5"),
    )
    pga_collapse_g: float | None = key(
        "what counts by it, of each record the worse sign; null: open, or no rule", "g"
    )


class CampaignLoss(Part):
    """`campaign.loss[]`: 1 − capacity after a movement / capacity before."""

    settlement: str = key("name of the movement")
    share: float = key("of the movement", "–")
    movement_m: float = key("largest component", "m")
    dynamic: float | None = key("median of the records; null: not known", "–")
    dynamic_range: Range = key("16-84 % of the records", "–")
    left_out: int = key("combinations that are not known on both sides", label=("Escluse", "Left out"))
    static: float | None = key("of the static check, weaker direction", "–")
    static_capacity: float | None = key("of `static_quantity`; a_g as a_g S, at the surface", "g or –")


class Campaign(Part):
    """`campaign`: records x movements x shares x signs."""

    measure: str = key("PGA or Sa(T)")
    period_s: float | None = key("T", "s")
    method: str = key("incremental or stripes")
    levels_g: list[float] = key("of stripes", "g")
    tolerance: float = key("of the level at collapse, relative", "–")
    contacts: str = key("rigid or elastic")
    members: int = key("of each ensemble, at most")
    static_quantity: str | None = key("key that the static loss is of; null: no pushover")
    records: list[CampaignRecord] = key("the records")
    spectrum: CampaignSpectrum | None = key("their mean spectrum; null: no spectrum was asked for")
    combinations: list[CampaignCombination] = key("every combination")
    computed: int = key("distinct combinations", label=("Questa versione", "This version"))
    failures: list[Sentence] = key("what could not be completed, and why")
    fragility: list[CampaignFragility] = key("by movement and share")
    loss: list[CampaignLoss] = key("by movement and share")
    warnings: list[Sentence] = key("of the single runs")
