"""The tables of a campaign: its records, every combination and run, fragility and loss by movement."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from xml.sax.saxutils import escape

from assessment.report.tables.dynamic import bands
from assessment.results.schema import Results
from assessment.results.schema.campaign import CampaignCombination
from assessment.results.schema.dynamic import MeasureFit
from assessment.results.table import Row, Table, cells

PLACE = ("settlement", "share", "movement_m")
RECORDS = ("record", "record_pga_g", "sa_g", "scale", "duration_s", "time_step_s")
COMBINATIONS = (
    "settlement", "share", "record", "sign", "pga_safe_g", "lowest_collapse_g", "pga_collapse_g", "level_50_g",
    "level_84_g", "pga_all_collapse_g", "resurrections", "widest_gap", "sa_collapse_g", "time_step_s", "runs", "reason",
)  # fmt: skip
POINTS = (
    "pga_g", "peak_displacement_m", "residual_displacement_m", "members", "members_collapsed", "time_of_collapse_s",
)  # fmt: skip
FRAGILITY = (
    *PLACE, "combinations", "withstood", "failed", "median_g", "median_low_g", "median_high_g", "beta", "beta_low",
    "beta_high", "beta_record", "beta_ensemble",
)  # fmt: skip
LOSS = (
    *PLACE, "rule", "pga_collapse_g", "dynamic_loss", "dynamic_loss_low", "dynamic_loss_high",
    "distinguishable", "left_out", "static_loss",
)  # fmt: skip
MODEL = """<?xml version="1.0" encoding="utf-8"?>
<nrml xmlns="http://openquake.org/xmlns/nrml/0.5">
  <fragilityModel id="collapse" assetCategory="buildings" lossCategory="structural">
    <description>{title}</description>
    <limitStates>collapse</limitStates>
{functions}  </fragilityModel>
</nrml>
"""
FUNCTION = """    <fragilityFunction id="{id}" format="continuous" shape="logncdf">
      <imls imt="{imt}" noDamageLimit="0.0" minIML="0.0" maxIML="{most:.6g}"/>
      <params ls="collapse" mean="{mean:.6g}" stddev="{stddev:.6g}"/>
    </fragilityFunction>
"""
MEASURES = (
    "analysis", "state", "share", "measure", "unit", "median_of_measure", "beta_of_measure", "efficient"
)  # fmt: skip
COUNTS = ("withstood", "failed", "left_out")  # printed where they are not all zero
OF_ENSEMBLES = ("beta_record", "beta_ensemble")  # of a single member there are none


def campaign_tables(results: Results) -> list[Table]:
    """List all tables of the campaign, long ones included; without rows where there is none."""
    return [
        records(results),
        combinations(results),
        points(results),
        fragilities(results),
        losses(results),
        measures(results),
    ]


def reported_campaign(results: Results) -> list[Table]:
    """Return the tables of the report."""
    single = not results.campaign or results.campaign.members == 1
    gone = OF_ENSEMBLES if single else ()
    return [records(results), _short(fragilities(results), gone), _short(losses(results), ["share"])]


def records(results: Results) -> Table:
    """List the records, read or made, and scaled."""
    found = results.campaign.records if results.campaign else []
    return Table("campaign_records", [cells(each, RECORDS) for each in found], RECORDS)


def combinations(results: Results) -> Table:
    """List the levels at which each combination collapses, and why where it was not completed."""
    rows = [
        cells(each, COMBINATIONS) | bands(each, each.pga_collapse_range) for each in _combinations(results)
    ]
    return Table("campaign", rows, COMBINATIONS)


def points(results: Results) -> Table:
    """List every level that was run."""
    of = ("settlement", "share", "record", "sign")
    rows = [
        cells(each, of) | cells(point, POINTS) for each in _combinations(results) for point in each.points
    ]
    return Table("campaign_curves", rows, (*of, *POINTS))


def fragilities(results: Results) -> Table:
    """List the fragility of every movement; the bounds are those of the bootstrap."""
    rows = []
    for each in results.campaign.fragility if results.campaign else []:
        found = cells(each, FRAGILITY)
        found["median_low_g"], found["median_high_g"] = each.median_range or (None, None)
        found["beta_low"], found["beta_high"] = each.beta_range or (None, None)
        rows.append(found)
    return Table("campaign_fragility", rows, FRAGILITY)


def measures(results: Results) -> Table:
    """List the fragilities by every measure of intensity; the most efficient one has the least β."""
    fits: list[tuple[Row, Sequence[MeasureFit]]] = [
        ({"analysis": "incremental", "state": name}, fit.measures)
        for name, state in results.states.items()
        if (fit := state.incremental.fragility)
    ]
    fits += [
        ({"analysis": "campaign", "state": row.settlement, "share": row.share}, row.measures)
        for number, row in enumerate(results.campaign.fragility if results.campaign else [])
        if row.share > 0.0 or number == 0
    ]
    rows = []
    for place, own in fits:
        least = min((each.beta for each in own if each.beta is not None), default=None)
        for each in own:
            found = place | cells(each, ("measure", "unit")) | {"efficient": each.beta == least}
            rows.append(found | {"median_of_measure": each.median, "beta_of_measure": each.beta})
    return Table("fragility_measures", rows, MEASURES)


def fragility_model(results: Results) -> str | None:
    """Return the fragilities as a fragility model of OpenQuake (NRML 0.5), None if there are none.

    Mean and standard deviation are those of the measure (g), not of its logarithm, as OpenQuake takes them.
    """
    of_states = [(name, state.incremental.fragility) for name, state in results.states.items()]
    found: list[tuple[str, str, float | None, float | None]] = [
        (name, "PGA", fit.median_g, fit.dispersion) for name, fit in of_states if fit
    ]
    if campaign := results.campaign:
        imt = "PGA" if campaign.measure == "PGA" else f"SA({campaign.period_s:g})"
        found += [
            (f"{row.settlement} {row.share:g}", imt, row.median_g, row.beta) for row in campaign.fragility
        ]
    functions = ""
    for name, imt, median, beta in found:
        if median and beta:
            mean, most = median * math.exp(0.5 * beta**2), median * math.exp(5.0 * beta)
            stddev, word = mean * math.sqrt(math.expm1(beta**2)), re.sub(r"\W+", "_", name)
            functions += FUNCTION.format(id=word, imt=imt, most=most, mean=mean, stddev=stddev)
    return MODEL.format(title=escape(results.title), functions=functions) if functions else None


def losses(results: Results) -> Table:
    """List what each movement costs, dynamic beside static, and the PGA that the standard takes."""
    rows: list[Row] = []
    campaign = results.campaign
    for each, fit in zip(campaign.loss, campaign.fragility, strict=True) if campaign else ():
        low, high = each.dynamic_range
        found = cells(each, (*PLACE, "left_out"))
        found |= {"dynamic_loss": each.dynamic, "dynamic_loss_low": low, "dynamic_loss_high": high}
        found |= cells(each, ["distinguishable"]) if each.distinguishable is not None else {}
        found |= {"static_loss": each.static}
        if fit.rule:
            found |= cells(fit, ("rule", "pga_collapse_g"))
        rows.append(found)
    return Table("campaign_loss", rows, LOSS)


def _combinations(results: Results) -> list[CampaignCombination]:
    return results.campaign.combinations if results.campaign else []


def _short(table: Table, without: Sequence[str] = ()) -> Table:
    """Return the table without counts that are all zero, the bounds of β, and the columns that are named."""
    empty = {key for key in COUNTS if not any(each.get(key) for each in table.rows)}
    gone = empty | {"beta_low", "beta_high", "combinations", *without}
    return Table(
        table.name,
        [{key: value for key, value in each.items() if key not in gone} for each in table.rows],
        tuple(column for column in table.columns if column not in gone),
    )
