"""Figures of a campaign: runs of every record, fragility and loss of capacity by movement."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from assessment.report.figures.dynamic import FAINT as SHADE
from assessment.report.figures.dynamic import draw_band
from assessment.report.figures.style import DASHES, chart
from assessment.report.text.language import Words
from assessment.report.text.quantities import COARSE, label
from assessment.results.schema import Results
from assessment.results.schema.campaign import Campaign, CampaignCombination, CampaignFragility
from assessment.results.schema.dynamic import Level
from assessment.results.schema.part import known

Run = tuple[str, float, str, int]
BAND, FAINT = "0.85", "0.55"
STEEP = 0.1  # ln of the measure shown beyond the median of equal levels, which has no dispersion


def moved(results: Results) -> list[str]:
    """Return the settlements of the campaign."""
    return list(dict.fromkeys(row.settlement for row in known(results.campaign).loss))


def fragile_shares(results: Results, settlement: str) -> list[CampaignFragility]:
    """Return the shares of a settlement whose fragility is known."""
    found = known(results.campaign).fragility
    return [row for row in found if row.settlement == settlement and row.median_g is not None]


def draw_campaign_curves(results: Results, words: Words, settlement: str) -> Figure:
    """Draw PGA over peak displacement of every combination that was run, a panel per share; crosses: collapse.

    A collapse has no displacement: its cross stands at the right edge. A combination that another one's run stands for
    has the curve of that one, as its mirror image none.
    """
    combinations = known(results.campaign).combinations
    runs = {(row.settlement, row.share, row.record, row.sign): row.points for row in combinations}
    rows = [row for row in combinations if row.settlement == settlement]
    shares = list(dict.fromkeys(row.share for row in rows))
    columns = min(2, len(shares))
    figure, panels = chart(words, columns=columns, rows=-(-len(shares) // columns), height_mm=54.0)
    points = [point for row in rows for point in _points(row, runs)]
    bounds = [bound for row in rows for bound in (row.lowest_collapse_g, row.pga_safe_g)]
    peaks = [1000.0 * p.peak_displacement_m for p in points if p.peak_displacement_m is not None]
    reach, top = 1.1 * max(peaks, default=1.0) or 1.0, 1.15 * max(filter(None, bounds), default=1.0)
    for axes, share in zip(panels, shares, strict=False):
        for row in (each for each in rows if each.share == share):
            lowest = row.lowest_collapse_g
            found = [p for p in _points(row, runs) if not p.collapsed]
            stood = [p for p in found if not (lowest and p.pga_g > lowest)]
            if stood:
                axes.plot(
                    [0.0, *(1000.0 * known(p.peak_displacement_m) for p in stood)],
                    [0.0, *(p.pga_g for p in stood)],
                    color=FAINT, linewidth=0.6, marker="o", markersize=1.5,
                )  # fmt: skip
            if lowest is not None:
                axes.plot(reach, lowest, marker="x", color="0.0", markersize=3.5, clip_on=False)
        axes.set(xlim=(0.0, reach), ylim=(0.0, top), title=_share(share, words))
        axes.set(xlabel=label("peak_displacement_m", words), ylabel=label("pga_g", words))
    for axes in panels[len(shares) :]:
        axes.set_axis_off()
    handles = [
        Line2D([], [], color=FAINT, linewidth=0.6, marker="o", markersize=1.5, label=words.plain("figure.combination")),
        Line2D([], [], color="0.0", marker="x", linestyle="none", markersize=3.5, label=words.plain("figure.collapse")),
    ]  # fmt: skip
    figure.legend(handles=handles, loc="lower center", ncols=2)
    return figure


def _points(row: CampaignCombination, runs: Mapping[Run, list[Level]]) -> list[Level]:
    """Return the levels that were run of a combination, by itself or by the one that is the same."""
    same = row.same_as
    if same is None or same.sign != row.sign:
        return row.points
    return runs[same.settlement, same.share, row.record, row.sign]


def draw_campaign_fragility(results: Results, words: Words, settlement: str) -> Figure:
    """Draw the probability of collapse over the measure, a curve per share; circles: the combinations, or stripes."""
    from scipy.special import ndtr  # late: few reports need it, and it takes long to import

    found, campaign = fragile_shares(results, settlement), known(results.campaign)
    figure, (axes,) = chart(words, height_mm=75.0, foot_mm=8.0 + 4.0 * len(found))
    seen = {row.share: _seen(campaign, settlement, row.share) for row in found}
    top = max(known(row.median_g) * np.exp(max(2.0 * known(row.beta), STEEP)) for row in found)
    low = min(known(row.median_g) * np.exp(-3.0 * known(row.beta)) for row in found)
    low = min([low, *(level for levels, _ in seen.values() for level in levels)])
    start = 0.1 * math.floor(9.5 * low)  # below it nothing collapses
    level = np.linspace(max(start, 1e-3 * top), top, 300)
    handles: list[Line2D] = []
    for dashes, row, shade in zip(cycle(DASHES), found, np.linspace(1.0, 0.0, len(found)), strict=False):
        curve = ndtr(np.log(level / known(row.median_g)) / max(known(row.beta), 1e-3 * STEEP))
        mark: dict[str, Any] = {"marker": "o", "markersize": 3.0, "markeredgewidth": 0.5, "color": "0.0"}
        mark["markerfacecolor"] = str(shade)
        draw_band(axes, row.band or (), "0.0")
        axes.plot(level, curve, color="0.0", linestyle=dashes)
        axes.plot(*seen[row.share], linestyle="none", **mark)
        handles.append(Line2D([], [], linestyle=dashes, label=_curve_label(row, words), **mark))
    sa = words.plain("figure.sa", period=campaign.period_s)
    axes.set(xlabel=label("pga_g", words) if campaign.measure == "PGA" else sa, xlim=(start, top))
    axes.set(ylabel=words.plain("figure.probability"), ylim=(0.0, 1.0))
    shaded = [Patch(color="0.0", alpha=SHADE, linewidth=0.0, label=words.plain("figure.fragility_band"))]
    told: list[Artist] = [*handles, *(shaded if any(row.band for row in found) else [])]
    figure.legend(handles=told, loc="lower center", ncols=1, handlelength=4.0)
    return figure


def draw_campaign_loss(results: Results, words: Words) -> Figure:
    """Draw the loss of capacity over the movement, a panel per settlement: dynamic with 95 % bounds, static beside."""
    names, campaign = moved(results), known(results.campaign)
    columns = min(2, len(names))
    figure, panels = chart(words, columns=columns, rows=-(-len(names) // columns), height_mm=70.0)
    told = [loss for row in campaign.loss for loss in (row.dynamic, row.static, *row.dynamic_range)]
    drawn = [loss for loss in told if loss is not None]
    least, most = min([0.0, *drawn]), max([0.01, *drawn])
    room = 5.0 * (most - least)  # per cent
    for axes, name in zip(panels, names, strict=False):
        own = [row for row in campaign.loss if row.settlement == name]
        band = [row for row in own if None not in row.dynamic_range]
        axes.fill_between(
            [1000.0 * row.movement_m for row in band],
            [100.0 * known(row.dynamic_range[0]) for row in band],
            [100.0 * known(row.dynamic_range[1]) for row in band],
            color=BAND, linewidth=0.0,
        )  # fmt: skip
        dynamic = [(row.movement_m, row.dynamic) for row in own if row.dynamic is not None]
        static = [(row.movement_m, row.static) for row in own if row.static is not None]
        for losses, dashes, face in ((dynamic, "-", "0.0"), (static, DASHES[1], "1.0")):
            axes.plot(
                [1000.0 * movement for movement, _ in losses],
                [100.0 * loss for _, loss in losses],
                color="0.0", linestyle=dashes, marker="o", markersize=3.5, markerfacecolor=face,
            )  # fmt: skip
        axes.set(xlabel=label("movement_m", words), ylabel=words.plain("figure.loss"), title=name)
        axes.set_xlim(left=0.0)
        axes.set_ylim(100.0 * least - room, 100.0 * most + room)  # the same in all: movements are compared
    for axes in panels[len(names) :]:
        axes.set_axis_off()
    line: dict[str, Any] = {"color": "0.0", "marker": "o", "markersize": 3.5}
    handles: list[Artist] = [
        Line2D([], [], label=words.plain("figure.dynamic_loss"), **line),
        Patch(color=BAND, linewidth=0.0, label=words.plain("figure.loss_band")),
        Line2D(
            [],
            [],
            linestyle=DASHES[1],
            markerfacecolor="1.0",
            label=words.plain("figure.static_loss"),
            **line,
        ),
    ]
    if campaign.method == "stripes":
        del handles[1]
    figure.legend(handles=handles, loc="lower center", ncols=3)
    return figure


def _seen(campaign: Campaign, settlement: str, share: float) -> tuple[list[float], list[float]]:
    """Return levels of 50 % or stripes (g, of the measure) and the share of the combinations that collapse there."""
    rows = [
        row
        for row in campaign.combinations
        if row.settlement == settlement and row.share == share and row.pga_safe_g is not None
    ]
    if campaign.method == "stripes":
        fallen = np.array([known(row.collapsed) for row in rows], dtype=float)
        return campaign.levels_g, fallen.mean(axis=0).tolist()
    ratio = {each.record: (each.sa_g or each.record_pga_g) / each.record_pga_g for each in campaign.records}
    levels = sorted(ratio[row.record] * row.level_50_g for row in rows if row.level_50_g is not None)
    return levels, ((np.arange(len(levels)) + 0.5) / len(rows)).tolist()


def _curve_label(row: CampaignFragility, words: Words) -> str:
    return words.plain(
        "figure.fragility",
        state=_share(row.share, words),
        median=row.median_g,
        dispersion=words.number(known(row.beta), COARSE),
    )


def _share(share: float, words: Words) -> str:
    if share == 0.0:
        return words.state("original")
    return words.plain("figure.share", share=f"{100.0 * share:g}")
