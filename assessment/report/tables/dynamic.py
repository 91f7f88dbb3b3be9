"""The tables of motions: time histories, the incremental analysis, campaigns; fragilities as OpenQuake reads them."""

import math
import re
from collections.abc import Iterator, Sequence
from importlib.resources import files

import jinja2

from assessment.ntc.tables import farthest
from assessment.report.tables import Curves, Found, curves, table, without
from assessment.results.schema import Results, present
from assessment.results.schema import dynamic as parts
from assessment.results.table import Row, Table, cells, reduction

VERTICAL = "vertical_record vertical_pga_g"
HISTORY = f"""state record pga_g {VERTICAL} contacts control peak_displacement_m residual_displacement_m farthest_m
farthest_left_m collapsed time_of_collapse_s"""
ENERGY = "input kinetic potential elastic friction impact viscous integrator residual"
LEVELS = "pga_safe_g lowest_collapse_g pga_collapse_g level_50_g level_84_g"
MOVED = "settlement share movement_m"
LOSS = f"""{MOVED} rule pga_collapse_g dynamic_loss dynamic_loss_low dynamic_loss_high distinguishable left_out
static_loss"""
OF_LOSS = ("capacity_loss", "dynamic_loss_low", "dynamic_loss_high", "distinguishable")
COUNTS = ("withstood", "failed", "left_out")  # printed where they are not all zero
OF_ENSEMBLES = ("beta_record", "beta_ensemble")  # of stripes there are none


@table("history", HISTORY)
def histories(results: Results) -> Found:
    """List what every time history came to."""
    for state, entry in _histories(results):
        at_end = ("residual_displacement_m", "farthest_left_m")
        unasked = {None: (), True: at_end, False: ("time_of_collapse_s",)}[entry.collapsed]
        yield {"state": state} | cells(entry, [key for key in HISTORY.split() if key not in unasked])


@table(
    "history_ranges",
    "state record integrator integrator_share members members_collapsed lowest_peak_m median_peak_m highest_peak_m",
)
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


@table("incremental", f"state record record_pga_g {VERTICAL} {LEVELS} resurrections widest_gap runs")
def incremental(results: Results) -> Found:
    """List the bracket of the PGA at collapse of every record and state."""
    for state, found in _incrementals(results):
        for record in found.records or []:
            yield {"state": state} | bands(record, record.pga_collapse_g_range), record


@table(
    "incremental_states",
    "state records mean_pga_collapse_g lowest_pga_collapse_g pga_collapse_g pga_all_collapse_g median_g dispersion",
)
def incremental_states(results: Results) -> Found:
    """List mean, lowest and, of enough records, the standard's PGA at collapse, and the fragility of every state."""
    for state, found in _incrementals(results):
        row: Row = {"state": state, "records": len(found.records or [])}
        row |= cells(found, ("mean_pga_collapse_g", "lowest_pga_collapse_g"))
        if found.pga_collapse_g_range:
            row["pga_all_collapse_g"] = found.pga_collapse_g_range[1]
        if found.rule:
            row |= cells(found, ["pga_collapse_g"])
        yield row | (cells(found.fragility, ("median_g", "dispersion")) if found.fragility else {})


@table(
    "incremental_curves",
    "state record pga_g peak_displacement_m members members_collapsed collapsed time_of_collapse_s",
)
def incremental_curves(results: Results) -> Found:
    """List every run of the incremental analysis."""
    for state, found in _incrementals(results):
        for record in found.records or []:
            for point in record.points:
                yield {"state": state, "record": record.record}, point


@table(
    "static_dynamic",
    f"state analysis direction limit_state pga_surface_g over_static level_50_g {' '.join(OF_LOSS)}",
)
def static_dynamic(results: Results) -> Found:
    """Set static check, incremental analysis and campaign of each state on one reference: PGA at the surface, F_C = 1.

    The level of 50 % is the median of the fragility, and the loss of motions that of these levels, of each record by
    itself. `over_static` is over the least static capacity of the state.
    """
    original, campaign = results.states.get("original"), results.campaign
    for name, state in results.states.items():
        shaken: list[Row] = []
        if (found := state.incremental).records is not None:
            median = found.fragility.median_g if found.fragility else None
            row = {"analysis": "incremental", "pga_surface_g": found.pga_collapse_g, "level_50_g": median}
            shaken.append(row | lost(found.loss))
        for fit, loss in zip(campaign.fragility, campaign.loss, strict=True) if campaign else ():
            if (fit.settlement, fit.share) == (name, 1.0) or (name, fit.share) == ("original", 0.0):
                row = {"analysis": "campaign", "pga_surface_g": fit.pga_collapse_g}
                row |= {"level_50_g": fit.median_g} if campaign and campaign.measure == "PGA" else {}
                shaken.append(row | lost(loss))
                break  # of one state, the whole movement or none of it
        static: list[Row] = []
        for direction, capacity in state.capacity.items() if shaken else ():
            before = original.capacity.get(direction) if original else None
            was, now = (each.nominal.pga_g if each and each.nominal else None for each in (before, capacity))
            row = {"analysis": "static_check", "direction": direction, "pga_surface_g": now}
            row["limit_state"] = farthest(capacity.checks)
            if not state.strengthening:  # whose reduction is not that of a settlement
                row["capacity_loss"] = reduction(was, now)
            static.append(row)
        known = [row["pga_surface_g"] for row in static if row["pga_surface_g"] is not None]
        gone = OF_LOSS if name == "original" else ()
        for row in (*static, *shaken):
            if known and row.get("pga_surface_g") is not None:
                row["over_static"] = row["pga_surface_g"] / min(known)
            yield {"state": name} | {key: value for key, value in row.items() if key not in gone}


def lost(loss: parts.Loss | None) -> Row:
    """Return the loss of motions, its bounds, and whether it is distinguishable from none."""
    if loss is None or loss.dynamic is None:
        return {}
    low, high = loss.dynamic_range
    row: Row = {"capacity_loss": loss.dynamic, "dynamic_loss_low": low, "dynamic_loss_high": high}
    return row | present({"distinguishable": loss.distinguishable})


def bands(found: parts.Scanned, range_: parts.Range | None) -> Row:
    """Return levels above the lowest collapse that stand, the widest gap, and from where all levels run collapse."""
    gap = "–".join(f"{level:.3f}" for level in found.widest_gap_g or [] if level is not None)
    stands = "; ".join(f"{level:.3f}" for level in found.resurrections_g)
    all_collapse = {"pga_all_collapse_g": range_[1]} if range_ else {}
    return {"resurrections": stands, "widest_gap": gap} | all_collapse


def _histories(results: Results) -> Iterator[tuple[str, parts.History]]:
    return ((name, entry) for name, state in results.states.items() for entry in state.history)


def _incrementals(results: Results) -> Iterator[tuple[str, parts.Incremental]]:
    for name, state in results.states.items():
        if state.incremental.records is not None:
            yield name, state.incremental


def reported_campaign(results: Results) -> list[Table]:
    """Return the tables of the report: without counts that are all zero, and the bounds of β."""
    gone = OF_ENSEMBLES if results.campaign and results.campaign.method == "stripes" else ()
    spread, lost = fragilities(results), losses(results)
    rows = [*spread.rows, *lost.rows]
    counted = [key for key in COUNTS if not any(each.get(key) for each in rows)]
    spread = without(spread, "beta_low", "beta_high", "combinations", *gone, *counted)
    return [records(results), spread, without(lost, "share", *counted)]


records = table("campaign_records", parts.CampaignRecord)(
    lambda results: results.campaign.records if results.campaign else []
)


@table(
    "campaign",
    f"settlement share record sign {LEVELS} pga_all_collapse_g resurrections widest_gap sa_collapse_g time_step_s "
    "runs reason",
)
def combinations(results: Results) -> Found:
    """List the levels at which each combination collapses, and why where it was not completed."""
    for each in results.campaign.combinations if results.campaign else []:
        yield bands(each, each.pga_collapse_range), each


@table(
    "campaign_curves",
    "settlement share record sign pga_g peak_displacement_m residual_displacement_m members members_collapsed "
    "time_of_collapse_s",
)
def campaign_points(results: Results) -> Found:
    """List every level that was run."""
    for each in results.campaign.combinations if results.campaign else []:
        where = cells(each, ("settlement", "share", "record", "sign"))
        yield from ((where, point) for point in each.points)


@table(
    "campaign_fragility",
    f"{MOVED} combinations withstood failed median_g median_low_g median_high_g beta beta_low beta_high "
    "beta_record beta_ensemble",
)
def fragilities(results: Results) -> Found:
    """List the fragility of every movement; the bounds are those of the bootstrap."""
    for each in results.campaign.fragility if results.campaign else []:
        low, high = each.median_range or (None, None)
        least, most = each.beta_range or (None, None)
        yield {"median_low_g": low, "median_high_g": high, "beta_low": least, "beta_high": most}, each


@table("campaign_loss", LOSS)
def losses(results: Results) -> Found:
    """List what each movement costs, dynamic beside static, and the PGA that the standard takes."""
    campaign = results.campaign
    for each, fit in zip(campaign.loss, campaign.fragility, strict=True) if campaign else ():
        low, high = each.dynamic_range
        row: Row = {"dynamic_loss": each.dynamic, "dynamic_loss_low": low, "dynamic_loss_high": high}
        row |= {"static_loss": each.static} | present({"distinguishable": each.distinguishable})
        row |= cells(fit, ("rule", "pga_collapse_g")) if fit.rule else {}
        yield row | cells(each, (*MOVED.split(), "left_out"))


@table("fragility_measures", "analysis state share measure unit median_of_measure beta_of_measure efficient")
def measures(results: Results) -> Found:
    """List the fragilities by every measure of intensity; the most efficient one has the least β."""
    fits: list[tuple[Row, Sequence[parts.MeasureFit]]] = []
    for name, found in _incrementals(results):
        if found.fragility:
            fits.append(({"analysis": "incremental", "state": name}, found.fragility.measures))
    for number, fit in enumerate(results.campaign.fragility if results.campaign else []):
        if fit.share > 0.0 or number == 0:
            place = {"analysis": "campaign", "state": fit.settlement, "share": fit.share}
            fits.append((place, fit.measures))
    for place, own in fits:
        least = min((each.beta for each in own if each.beta is not None), default=None)
        for each in own:
            row = place | cells(each, ("measure", "unit")) | {"efficient": each.beta == least}
            yield row | {"median_of_measure": each.median, "beta_of_measure": each.beta}


FARTHEST = 5.0  # β above the median: the largest level
WIDEST = 5.0  # β; beyond, mean and deviation soon pass all floats
LONGEST = 60  # characters of an identifier; they are letters and digits of ASCII, and _


def fragility_model(results: Results) -> bytes | None:
    """Return a fragility model (NRML 0.5) of the states of [incremental] and the movements of the campaign, if any.

    Mean and standard deviation are those of the measure (g), median · exp(β²/2) and mean · √(exp β² − 1), as OpenQuake
    takes them. A fragility without β, or with one above WIDEST, is left out.
    """
    fits = [
        (name, "PGA", x.fragility.median_g, x.fragility.dispersion)
        for name, x in _incrementals(results)
        if x.fragility
    ]
    moved: list[tuple[str, str, float | None, float | None]] = []
    if campaign := results.campaign:
        measure = "PGA" if campaign.measure == "PGA" else f"SA({campaign.period_s:g})"
        moved = [(f"{x.settlement} {x.share:g}", measure, x.median_g, x.beta) for x in campaign.fragility]
    functions = []
    for number, (name, measure, median, beta) in enumerate([*fits, *moved], 1):
        if median and beta and beta <= WIDEST:
            own = re.sub(r"\W+", "_", f"{number} {name}", flags=re.ASCII)[:LONGEST]
            mean, largest = median * math.exp(0.5 * beta**2), median * math.exp(FARTHEST * beta)
            numbers = {"largest": largest, "mean": mean, "deviation": mean * math.sqrt(math.expm1(beta**2))}
            functions.append({"id": own, "measure": measure} | numbers)
    text = (files("templates") / "fragility.xml.j2").read_text(encoding="utf-8")
    made = jinja2.Template(text, autoescape=True, trim_blocks=True)
    return made.render(title=results.title, functions=functions).encode() if functions else None
