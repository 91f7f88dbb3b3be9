"""Time histories, incremental dynamic analysis and the motions behind them; campaigns by movement of a support."""

from assessment.results.schema.part import Configuration, Part, Point, Sentence, key, optional
from assessment.results.schema.static import Pictured, TiePull

Range = list[float | None]
"""Least and largest of the members of an ensemble; null: a collapse, beyond any value."""


class AppliedRecord(Part):
    """`motions[]`: a record as it shakes the base, thinned for figures."""

    name: str = key("name of the record")
    pga_g: float = key("largest acceleration in the window, scale included")
    scale: float = key("factor on the record")
    window_s: Point = key("start and end in the file")
    time_s: list[float] = key("times in the file", "Tempo|Time")
    acceleration_g: list[float] = key("positive along x", "Accelerazione|Acceleration", ground="surface")
    T_s: list[float] = key("periods of the spectrum")
    S_a_g: list[float] = key("accelerations at 5 % damping", "S_a", ground="surface")
    S_d_m: list[float] = key("displacements at 5 % damping")


class Course(Part):
    """`curve`: horizontal displacement of the control point from the state's own rest, thinned."""

    time_s: list[float] = key("times in the record's file")
    displacement_m: list[float] = key("displacement along x")


class Band(Part):
    """`band`: between what displacements all members of an ensemble are, at the times of `curve`."""

    low_m: list[float] = key("least displacement")
    high_m: list[float] = key("largest displacement")


class Snapshots(Pictured):
    """`snapshots` of a motion; of joints those of the drawing."""

    time_s: list[float] = key("times in the record's file")
    displacement_m: list[float] = key("of the control point along x")


class ShakenTie(TiePull):
    """`ties[]` of a history: the tension of a tie while the base moves."""

    time_s: float | None = key("when it is greatest, in the record's file; null: likewise")


class EnergyBalance(Part):
    """`energy`: the balance of a motion from its beginning to its end."""

    kinetic_kNm: float = key("change of the kinetic energy", "Cinetica|Kinetic")
    potential_kNm: float = key("change of the potential energy of the weights", "Potenz.|Potential")
    elastic_kNm: float = key("change of what the joints store", "Elastica|Elastic")
    input_kNm: float = key("work of the base's motion", "Immessa|Input")
    friction_kNm: float = key("dissipated by friction, crushing and ties that yield", "Attrito|Friction")
    impact_kNm: float = key("dissipated at impacts", "Urti|Impacts")
    viscous_kNm: float = key("dissipated by viscous damping", "Viscosa|Viscous")
    integrator_kNm: float = key("taken by the integrator itself", "Integraz.|Integration")
    residual_kNm: float = key("what does not balance", "Residuo|Open")


class Peaks(Part):
    """How far the control point goes, either way, and how it ends: of a motion, or the worst of several."""

    peak_displacement_m: float | None = key("largest one; null: a collapse", "Picco|Peak", shown="mm")
    residual_displacement_m: float | None = key("null: a collapse", "Alla fine|At the end", shown="mm")
    time_of_collapse_s: float | None = key(
        "in the record, of the first to collapse; null: it stands", "t di collasso|t of collapse"
    )
    reason: Sentence | None = key("of the collapse, or why it was not computed")


class OfRecord(Part):
    """What is of one record."""

    record: str = key("name of the record", "Accelerogramma|Record")


class OfBaseMotion(OfRecord):
    """What is of one record that shakes the base."""

    vertical_record: str | None = optional("its vertical record; missing: none", "Verticale|Vertical record")
    vertical_pga_g: float | None = optional(
        "PGA of its vertical record, scaled; missing: none", "PGA verticale|Vertical PGA", ground="surface"
    )


class History(OfBaseMotion, Peaks):
    """`history[]`: one record from the state at rest; without a start only the reason is there."""

    pga_g: float = key("its largest acceleration in the window, scale included")
    scale: float = key("factor on the record")
    time_step_s: float = key("time step")
    contacts: str = key("rigid or elastic", "Giunti|Contacts")
    integrator: str | None = key("integrator used", "Integrazione|Integration")
    amplitude: float = key("factor of the member that the numbers are of: 1, or within 1 % of it")
    control: str = key("control point", "Controllo|Control")
    collapsed: bool | None = key("whether it ends in collapse; null: not computed", "Collasso|Collapse")
    sustained_displacement_m: float | None = optional("largest one from which the structure came back")
    time_of_peak_s: float | None = optional("when that is")
    farthest_m: float | None = optional(
        "largest displacement of any corner of a block", "Picco, ogni vertice|Peak, any corner", shown="mm"
    )
    farthest_left_m: float | None = optional(
        "the same at the end; null: a collapse", "Alla fine, ogni vertice|At the end, any corner", shown="mm"
    )
    free_motion_from_s: float | None = optional("end of the record, where motion goes on; null: it does not")
    curve: Course | None = optional("displacement in time")
    snapshots: Snapshots | None = optional("some of its configurations")
    peak_configuration: Configuration | None = optional("at `time_of_peak_s`")
    final_configuration: Configuration | None = optional("at the end")
    energy: EnergyBalance | None = optional("its energies")
    integrator_chosen: str | None = optional("why that integrator")
    integrator_share: float | None = optional(
        "what the integrator took of the energy turned over", "Quota integraz.|Integrator’s share", shown="%"
    )
    steps: int | None = optional("time steps")
    skipped: int | None = optional("of these, at rest and not computed")
    lifting: int | None = optional("steps in which what slides lifts: Coulomb's law was not solved")
    programs: int | None = optional("programs solved")
    iterations: int | None = optional("their iterations")
    halvings: int | None = optional("halvings of the time step where a step was not solved")
    notes: list[Sentence] | None = optional("what to know about it")
    seconds: float | None = optional("computing time", unit="s")
    ties: list[ShakenTie] | None = optional("tension of the ties of the state; missing: no tie")
    members: int | None = optional("members of the ensemble that were run", "Membri|Members")
    members_collapsed: int | None = optional("members that collapse", "Di cui collassano|Of which collapse")
    peak_displacement_m_range: Range | None = optional("of the members' peaks; null: a collapse")
    peak_displacement_median_m: float | None = optional("median of the members; null: a collapse")
    band: Band | None = optional("where all members are")


class MemberCurve(Course):
    """`curves[]`: horizontal displacement of the control point in a motion, from rest, thinned."""

    member: int = key("its number, 1: the record itself")
    factor: float = key("on the level, 1 of the record itself")


class Level(Peaks):
    """`points[]` of a record: what its motions come to at one PGA; of no motion that was completed: null."""

    pga_g: float = key("level")
    peak_displacement_m_range: Range = key("least and largest peak; null: a collapse")
    members: int = key("motions that were run: one, of stripes up to `scatter`")
    members_collapsed: int = key("motions that collapse, or cannot be completed")
    collapsed: bool = key("whether any collapses, or cannot be completed")
    integrator_share: float | None = key("what the integrator took of the energy turned over: the largest")
    broken_tie: str | None = optional("the tie whose breaking is the collapse")
    curves: list[MemberCurve] | None = optional("of the motions asked for that were run")


class Counts(Part):
    """`counts`: what motions cost."""

    motions: int = key("motions computed")
    steps: int = key("time steps")
    skipped: int = key("of these, at rest and not computed")
    lifting: int = key("steps in which what slides lifts: Coulomb's law was not solved")
    programs: int = key("programs solved")
    iterations: int = key("their iterations")
    halvings: int = key("halvings of steps")


class SameAs(Part):
    """`same_as`: the row that begins in the same state, and was run."""

    sign: int = key("factor on the record; the other one: its mirror image", unit="–")
    settlement: str | None = optional("of a campaign its movement")
    share: float | None = optional("of it")


class Scanned(OfRecord):
    """`incremental.records[].signs[]`: what levels of a record of one sign show of a state: P(collapse | level).

    Of the lowest bracket, from `pga_safe_g` to `lowest_collapse_g`, P grows from 0 to 1; where the structure stands at
    a higher level again, P is the probit in ln level that is most likely.
    """

    sign: int = key("factor on the record, 1 or −1", "Segno|Sign")
    pga_collapse_g: float | None = key(
        "what counts: P = 16 % in the lowest bracket, or of the probit where that is lower; null: no collapse",
        "PGA al collasso|PGA at collapse", ground="surface",
    )  # fmt: skip
    pga_safe_g: float | None = key(
        "largest level below that stands; null: not completed", "PGA sopportata|Withstood", ground="surface"
    )
    lowest_collapse_g: float | None = key(
        "lowest level run that collapses; null: none", "Collasso più basso|Lowest collapse", ground="surface"
    )
    level_16_g: float | None = key("P = 16 %", "Livello 16 %|Level of 16 %", ground="surface")
    level_50_g: float | None = key("P = 50 %", "Livello 50 %|Level of 50 %", ground="surface")
    level_84_g: float | None = key("P = 84 %", "Livello 84 %|Level of 84 %", ground="surface")
    beta: float | None = key("of the probit; 0: no level above a collapse stands")
    widest_gap_g: Range | None = key("of the levels run the two widest apart, up to where all collapse")
    time_step_s: float | None = key("time step of the levels; null: not completed")
    resurrections_g: list[float] = key("levels above the lowest collapse at which the structure stands")
    runs: int = key("motions computed", "Analisi|Runs")
    points: list[Level] = key("every level that was run")
    reason: Sentence | None = key("why there is no answer", "Motivo|Reason")
    notes: list[Sentence] = key("warnings of the motions, each with how many of them have it")
    counts: Counts | None = key("what the motions cost; null: none was run")
    pga_collapse_range: Range | None = key(
        "from `pga_collapse_g` to the level from which all levels run collapse; null: not reached", unit="g"
    )
    collapsed: list[bool] | None = optional("of stripes: whether a motion collapses, by level")
    broken_tie: str | None = optional("that breaks at the lowest", "Catena che si rompe|Tie that breaks")
    same_as: SameAs | None = optional("where another row has the motions")


class Search(OfBaseMotion):
    """`incremental.records[]`: the PGA at collapse of one record; the numbers are those of the worse sign."""

    record_pga_g: float = key("its own PGA", "PGA dell’accelerogramma|PGA of the record", ground="surface")
    sign: int | None = key("the sign that counts: 1, as in the file, or −1; null: not known")
    pga_collapse_g: float | None = key("what counts; null: no collapse")
    pga_collapse_g_range: Range | None = key("as `pga_collapse_range` of the sign")
    pga_safe_g: float | None = key("largest level run below at which it stands; null: not completed")
    runs: int = key("motions computed, of both signs")
    reason: Sentence | None = key("why there is no answer")
    signs: list[Scanned] = key("both signs of the record")


class MeasureFit(Part):
    """`measures[]`: the level at collapse by a measure of intensity; the smaller β, the more efficient the measure."""

    measure: str = key("PGA, PGV, Sa(T) or AvgSa", "Misura|Measure")
    unit: str = key("g or m/s")
    period_s: float | None = key("T of Sa(T); null: none")
    median: float | None = key("median, in `unit`", unit="g or m/s")
    beta: float | None = key("standard deviation of its logarithm")


class Fragility(Part):
    """`incremental.fragility`: how the levels at collapse of a state scatter, a lognormal distribution.

    With it what NTC 2018 §7.3.5 takes of the records, each with its worse sign.
    """

    combinations: int = key("records and signs", "Combin.")
    failed: int = key("of these, not completed, in no median", "Non completate|Not completed")
    withstood: int = key("of these, without collapse: lower bounds", "Sopportate|Withstood")
    median_g: float | None = key("median of the measure; null: not known", "Mediana|Median", ground="surface")
    beta: float | None = key(
        "standard deviation of ln measure: of records and within them; null: fewer than two records collapse",
        "β", digits=2,
    )  # fmt: skip
    beta_record: float | None = key("β of 50 % levels of the records", "β accelerogr.|β records", digits=2)
    beta_ensemble: float | None = key(
        "β of the levels of one record, the root of the mean square", "β insieme|β ensemble", digits=2
    )
    level_16_g: float | None = key("level of which 16 % collapse")
    level_84_g: float | None = key("level of which 84 % collapse")
    median_range: Range | None = key("95 % of the bootstrap; null: fewer than three records", unit="g")
    beta_range: Range | None = key("95 % of the bootstrap; null: fewer than three records")
    band: list[list[float]] = key("probability, 95 % bounds of its level; empty: few records", unit="–, g")
    measures: list[MeasureFit] = key("the same levels by other measures of the records; of stripes none")
    rule: str | None = key(
        "NTC 2018, §7.3.5: the mean of seven records or more, the lowest of three to six; null: fewer, or stripes",
        "Regola, §7.3.5|Rule, §7.3.5",
    )
    pga_collapse_g: float | None = key("what counts by it, without a rule the lowest; null: open, or stripes")
    pga_collapse_g_range: Range | None = key("from it to where all levels run collapse; null: no collapse")
    directions: dict[str, float | None] = key(
        "the same of one sign of the records: +x as in the file, −x the other; null: open", unit="g"
    )
    d_0_m: float | None = key("least d_0 of the rigid curves of the motions' control point; null: none")


class Loss(Part):
    """1 − level at collapse after / before: the median over records and signs, of the 50 % level of each."""

    dynamic: float | None = key(
        "of the 50 % levels, median of both signs or of the losing one; null: not known"
    )
    dynamic_range: Range = key("95 % of the bootstrap, and of what levels are known to; this alone of few")
    distinguishable: bool | None = key(
        "whether zero lies outside; null: no range, or few records", "Da una perdita nulla|From no loss"
    )
    left_out: int = key("combinations that are not known on both sides", "Escluse|Left out")
    records: int | None = optional("records that it is known of")
    directions: dict[str, float | None] | None = optional("of each sign, where one gains", unit="–")


class Incremental(Part):
    """`incremental`: the levels of all records from a state, and what they come to; empty: not asked for."""

    records: list[Search] | None = optional("the records")
    mean_pga_collapse_g: float | None = optional("mean; null: one is open", "Media|Mean", ground="surface")
    lowest_pga_collapse_g: float | None = optional(
        "lowest of the records; null: an open one may be lower", "Minima|Lowest", ground="surface"
    )
    fragility: Fragility | None = optional("distribution, and what counts")
    loss: Loss | None = optional("against the original state, of a settled one as in `campaign.loss`")


class CampaignRecord(OfBaseMotion):
    """`campaign.records[]`: a record as applied."""

    record_pga_g: float = key("its PGA, the factor included")
    pgv_m_s: float | None = optional("its PGV, the factor included", "PGV")
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


class OfMovement(Part):
    """What is of a part of a movement."""

    settlement: str = key("name of the movement", "Cedimento|Movement")
    share: float = key("of the movement")


class CampaignCombination(OfMovement, Scanned):
    """`campaign.combinations[]`: a record of one sign from one settled state."""

    sa_collapse_g: float | None = optional(
        "S_a(T) at collapse, where that is the measure", "S_a(T) al collasso|S_a(T) at collapse"
    )


class CampaignFragility(OfMovement, Fragility):
    """`campaign.fragility[]`: the fragility after a movement."""

    movement_m: float = key("largest component")


class CampaignLoss(OfMovement, Loss):
    """`campaign.loss[]`: 1 − capacity after a movement / capacity before."""

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
    static_quantity: str | None = key("key that the static loss is of; null: no pushover")
    records: list[CampaignRecord] = key("the records")
    spectrum: CampaignSpectrum | None = key("their mean spectrum; null: no spectrum was asked for")
    combinations: list[CampaignCombination] = key("every combination")
    computed: int = key("distinct combinations", "Questa versione|This version")
    failures: list[Sentence] = key("what could not be completed, and why")
    fragility: list[CampaignFragility] = key("by movement and share")
    loss: list[CampaignLoss] = key("by movement and share")
    warnings: list[Sentence] = key("of the single runs")
