"""The tables of motions: time histories, the incremental analysis, campaigns; fragilities as OpenQuake reads them."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import jinja2

from assessment.ntc.tables import farthest
from assessment.report.tables import Curves, Found, curves, table, without
from assessment.results.schema import Results, known, present
from assessment.results.schema import dynamic as parts
from assessment.results.table import Row, Table, cells, reduction
from assessment.runtime.files import template

VERTICAL = "vertical_record vertical_pga_g"
HISTORY = f"""state record pga_g {VERTICAL} contacts control peak_displacement_m residual_displacement_m farthest_m
farthest_left_m collapsed time_of_collapse_s"""
RANGES = """state record integrator integrator_share members members_collapsed
lowest_peak_m median_peak_m highest_peak_m"""
ENERGY = "input kinetic potential elastic friction impact viscous integrator residual"
LEVELS = "pga_safe_g lowest_collapse_g pga_collapse_g level_50_g level_84_g"
BANDS = "resurrections widest_gap ?broken_tie"
POINTS = """record sign pga_g peak_displacement_m residual_displacement_m members members_collapsed collapsed
time_of_collapse_s"""
FRAGILITY = """combinations withstood failed median_g median_low_g median_high_g beta beta_low beta_high beta_record
beta_ensemble"""
CAMPAIGN = f"""settlement share record sign {LEVELS} pga_all_collapse_g {BANDS} sa_collapse_g time_step_s
runs reason"""
MOVED = "settlement share movement_m"
LOST = "dynamic_loss_low dynamic_loss_high distinguishable"
BESIDE = f"state analysis direction limit_state pga_surface_g over_static level_50_g capacity_loss {LOST}"
COUNTED = "rule pga_collapse_g pga_all_collapse_g"
COUNTS = ("withstood", "failed", "left_out")  # printed where they are not all zero


@table("history", HISTORY)
def histories(results: Results) -> Found:
    """List what every time history came to."""
    for state, entry in _histories(results):
        at_end = ("residual_displacement_m", "farthest_left_m")
        unasked = {None: (), True: at_end, False: ("time_of_collapse_s",)}[entry.collapsed]
        yield {"state": state} | cells(entry, [key for key in HISTORY.split() if key not in unasked])


@table("history_ranges", RANGES)
def ranges(results: Results) -> Found:
    """List how every time history was integrated, by how many members, and the range of their peaks."""
    for state, entry in _histories(results):
        row: Row = {"state": state}
        if entry.peak_displacement_m_range:
            row["lowest_peak_m"], row["highest_peak_m"] = entry.peak_displacement_m_range
            row["median_peak_m"] = entry.peak_displacement_median_m
        if entry.curve:
            yield row, entry


@table("history_energy", f"state record {' '.join(f'{name}_kNm' for name in ENERGY.split())}")
def energy(results: Results) -> Found:
    """List the energy balance of every time history: input is what was stored and dissipated, and a residual, kNm."""
    for state, entry in _histories(results):
        if entry.energy:
            yield {"state": state, "record": entry.record}, entry.energy


@curves("history_curves", "state record time_s displacement_m")
def history_curves(results: Results) -> Curves:
    """List the points of every control displacement history."""
    for state, entry in _histories(results):
        if entry.curve:
            yield (state, entry.record), (entry.curve.time_s, entry.curve.displacement_m)


@curves("record_spectra", "record T_s S_a_g S_d_m")
def motions(results: Results) -> Curves:
    """List the spectral ordinates (5 % damping) of the records of the time histories."""
    for motion in results.motions or []:
        yield (motion.name,), (motion.T_s, motion.S_a_g, motion.S_d_m)


@dataclass(frozen=True)
class Shaken:
    """A state that was shaken: its fragility and loss, and every record and sign.

    Of a `campaign` `state` names the movement, of which it is a `share`; else it is one of [incremental].
    """

    state: str
    fit: parts.Fragility
    loss: parts.Loss | None
    rows: Sequence[parts.Scanned]
    share: float | None = None
    campaign: parts.Campaign | None = None

    @property
    def analysis(self) -> str:
        """Which analysis has shaken it."""
        return "campaign" if self.campaign else "incremental"

    @property
    def by_pga(self) -> bool:
        """Whether its fragility is of the PGA, else of S_a(T)."""
        return self.campaign is None or self.campaign.measure == "PGA"

    @property
    def place(self) -> Row:
        """The state in a table of its analysis."""
        return cells(self.fit, MOVED.split()) if self.campaign else {"state": self.state}


def shaken(results: Results, analysis: str = "") -> list[Shaken]:
    """Return every state that was shaken, of one analysis or of both."""
    found = [
        Shaken(name, fit, own.loss, [row for record in own.records or [] for row in record.signs])
        for name, state in results.states.items()
        if (fit := (own := state.incremental).fragility)
    ]
    if campaign := results.campaign:
        of: dict[tuple[str, float], list[parts.Scanned]] = {}
        for row in campaign.combinations:
            of.setdefault((row.settlement, row.share), []).append(row)
        for fit, loss in zip(campaign.fragility, campaign.loss, strict=True):
            rows = of.get((fit.settlement, fit.share), [])
            found.append(Shaken(fit.settlement, fit, loss, rows, fit.share, campaign))
    return [each for each in found if analysis in ("", each.analysis)]


@table("incremental", f"state record record_pga_g {VERTICAL} {LEVELS} {BANDS} runs ?reason")
def incremental(results: Results) -> Found:
    """List what every record comes to from every state: the levels of its worse sign, none where that is not known."""
    for name, state in results.states.items():
        for record in state.incremental.records or []:
            worse = next((each for each in record.signs if each.sign == record.sign), None)
            yield {"state": name} | (cells(worse, LEVELS.split()) | bands(worse) if worse else {}), record


@table("campaign", CAMPAIGN)
def combinations(results: Results) -> Found:
    """List the levels at which each combination collapses, and why where it was not completed."""
    return ((bands(row), row) for each in shaken(results, "campaign") for row in each.rows)


def _points(results: Results, analysis: str) -> Found:
    for each in shaken(results, analysis):
        for row in each.rows:
            yield from ((each.place | cells(row, ("record", "sign")), point) for point in row.points)


def _fragilities(results: Results, analysis: str) -> Iterator[Row]:
    """List the fragility of every state; the bounds are those of the bootstrap."""
    for each in shaken(results, analysis):
        low, high = each.fit.median_range or (None, None)
        least, most = each.fit.beta_range or (None, None)
        bounds = {"median_low_g": low, "median_high_g": high, "beta_low": least, "beta_high": most}
        known = present(cells(each.fit, FRAGILITY.split())) | cells(each.fit, ["median_g"])
        yield each.place | known | bounds | counted(each.fit)


for _analysis, _place in (("incremental", "state"), ("campaign", "settlement share")):
    table(f"{_analysis}_curves", f"{_place} {POINTS}")(partial(_points, analysis=_analysis))
fragilities = table("campaign_fragility", f"{MOVED} {FRAGILITY}")(lambda made: _fragilities(made, "campaign"))
records = table("campaign_records", parts.CampaignRecord)(
    lambda results: results.campaign.records if results.campaign else []
)


@table("incremental_states", f"state {FRAGILITY} mean_pga_collapse_g lowest_pga_collapse_g {COUNTED}")
def incremental_states(results: Results) -> Found:
    """List the fragility of every state, mean and lowest PGA at collapse, and what the standard takes."""
    for row in _fragilities(results, "incremental"):
        yield row, results.states[row["state"]].incremental


@table("campaign_loss", f"{MOVED} {COUNTED} dynamic_loss {LOST} left_out static_loss")
def losses(results: Results) -> Found:
    """List what each movement costs, dynamic beside static, and the PGA that the standard takes."""
    for each in shaken(results, "campaign"):
        row = each.place | counted(each.fit) | {"static_loss": getattr(each.loss, "static", None)}
        yield row | lost(known(each.loss), "dynamic_loss"), each.loss


@table("static_dynamic", BESIDE)
def static_dynamic(results: Results) -> Found:
    """Set static check, incremental analysis and campaign of each state on one reference: PGA at the surface, F_C = 1.

    The level of 50 % is the median of the fragility, and the loss of motions that of these levels, of each record by
    itself. `over_static` is over the least static capacity of the state.
    """
    original = results.states.get("original")
    for name, state in results.states.items():
        moving: dict[str, Row] = {}  # of one state, the whole movement or none of it
        for each in shaken(results):
            same = each.state == name and each.share in (None, 1.0)
            if each.analysis not in moving and (same or (name, each.share) == ("original", 0.0)):
                row: Row = {"analysis": each.analysis, "pga_surface_g": each.fit.pga_collapse_g}
                row |= {"level_50_g": each.fit.median_g} if each.by_pga else {}
                if each.loss is not None and each.loss.dynamic is not None and name != "original":
                    row |= lost(each.loss, "capacity_loss")  # of 50 % levels, record by record
                moving[each.analysis] = row
        static: list[Row] = []
        for direction, capacity in state.capacity.items() if moving else ():
            before = original.capacity.get(direction) if original else None
            was, now = (each.nominal.pga_g if each and each.nominal else None for each in (before, capacity))
            row = {"analysis": "static_check", "direction": direction, "pga_surface_g": now}
            row["limit_state"] = farthest(capacity.checks)
            if not state.strengthening and name != "original":  # whose reduction is not that of a settlement
                row["capacity_loss"] = reduction(was, now)
            static.append(row)
        known = [row["pga_surface_g"] for row in static if row["pga_surface_g"] is not None]
        for row in (*static, *moving.values()):
            if known and row.get("pga_surface_g") is not None:
                row["over_static"] = row["pga_surface_g"] / min(known)  # over the least static capacity
            yield {"state": name} | row


def lost(loss: parts.Loss, name: str) -> Row:
    """Return the loss of motions, called by that name, its bounds, and whether it is distinguishable from none."""
    low, high = loss.dynamic_range
    row: Row = {name: loss.dynamic, "dynamic_loss_low": low, "dynamic_loss_high": high}
    return row | present({"distinguishable": loss.distinguishable})


def counted(fit: parts.Fragility) -> Row:
    """Return the PGA that the standard takes, where it does, and from where all levels run collapse."""
    certain = {"pga_all_collapse_g": range_[1]} if (range_ := fit.pga_collapse_g_range) else {}
    return (cells(fit, ("rule", "pga_collapse_g")) if fit.rule else {}) | certain


def bands(found: parts.Scanned) -> Row:
    """Return levels above the lowest collapse that stand, the widest gap, and from where all levels run collapse."""
    gap = "–".join(f"{level:.3f}" for level in found.widest_gap_g or [] if level is not None)
    stands = "; ".join(f"{level:.3f}" for level in found.resurrections_g)
    all_collapse = {"pga_all_collapse_g": range_[1]} if (range_ := found.pga_collapse_range) else {}
    more = present({"broken_tie": found.broken_tie}) | all_collapse
    return {"resurrections": stands, "widest_gap": gap} | more


def _histories(results: Results) -> Iterator[tuple[str, parts.History]]:
    return ((name, entry) for name, state in results.states.items() for entry in state.history)


def reported_searches(results: Results) -> list[Table]:
    """Return the tables of the report: without counts that are all zero, and the bounds of β."""
    found = [incremental_states(results), fragilities(results), losses(results)]
    gone = [key for key in COUNTS if not any(row.get(key) for each in found for row in each.rows)]
    gone += ["beta_low", "beta_high", "combinations"]
    *spread, lost_ones = (without(each, *gone) for each in found)
    return [records(results), *spread, without(lost_ones, "share")]


@table("fragility_measures", "analysis state share measure unit median_of_measure beta_of_measure efficient")
def measures(results: Results) -> Found:
    """List the fragilities by every measure of intensity; the most efficient one has the least β."""
    found = shaken(results)
    drawn = next((each for each in found if each.share == 0.0), None)  # of all movements one
    for each in (each for each in found if each.share != 0.0 or each is drawn):
        place: Row = {"analysis": each.analysis, "state": each.state} | present({"share": each.share})
        least = min((own.beta for own in each.fit.measures if own.beta is not None), default=None)
        for own in each.fit.measures:
            row = place | cells(own, ("measure", "unit")) | {"efficient": own.beta == least}
            yield row | {"median_of_measure": own.median, "beta_of_measure": own.beta}


FARTHEST = 5.0  # β above the median: the largest level
WIDEST = 5.0  # β; beyond, mean and deviation soon pass all floats
LONGEST = 60  # characters of an identifier; they are letters and digits of ASCII, and _


def fragility_model(results: Results) -> bytes | None:
    """Return a fragility model (NRML 0.5) of the states of [incremental] and the movements of the campaign, if any.

    Mean and standard deviation are those of the measure (g), median · exp(β²/2) and mean · √(exp β² − 1), as OpenQuake
    takes them. A fragility without β, or with one above WIDEST, is left out.
    """
    functions = []
    for number, each in enumerate(shaken(results), 1):
        median, beta = each.fit.median_g, each.fit.beta
        if median and beta and beta <= WIDEST:
            name = each.state if each.share is None else f"{each.state} {each.share:g}"
            own = re.sub(r"\W+", "_", f"{number} {name}", flags=re.ASCII)[:LONGEST]
            measure = f"SA({each.campaign.period_s:g})" if each.campaign and not each.by_pga else "PGA"
            mean, largest = median * math.exp(0.5 * beta**2), median * math.exp(FARTHEST * beta)
            # of the measure (g), as OpenQuake has them
            numbers = {"largest": largest, "mean": mean, "deviation": mean * math.sqrt(math.expm1(beta**2))}
            functions.append({"id": own, "measure": measure} | numbers)
    made = jinja2.Template(template("fragility.xml.j2"), autoescape=True, trim_blocks=True)
    return made.render(title=results.title, functions=functions).encode() if functions else None
