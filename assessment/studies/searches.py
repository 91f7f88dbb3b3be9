"""What scans of [incremental] and [campaign] come to: rows, fragility, §7.3.5, loss; the incremental analysis."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self, TypeVar

import numpy as np

from assessment.analyses import fragility
from assessment.analyses.found import accuracy_of, as_part
from assessment.analyses.scan import Reach
from assessment.analyses.time_history import MotionInputs, least_d_0, ultimate_of
from assessment.ntc.tables import ENOUGH, MEAN_FROM
from assessment.project.motions import BaseMotion
from assessment.project.project import Project
from assessment.project.schema import ORIGINAL, CampaignTable, IncrementalTable
from assessment.results.schema import ConvergenceRow, dynamic, known
from assessment.studies.scans import Asked, Place, Scans, asked_for, reach_of
from assessment.studies.variants import Study
from mechanics import Assembly
from mechanics.messages import Message, headed, message
from mechanics.records import response_spectrum
from mechanics.types import GRAVITY, Array

DAMPING = 0.05  # of spectra and of Sa(T)
COMPARED = 60  # periods at which spectra are compared
PERIOD, FIRST, LAST = 1.0, 0.15, 2.0  # s: of Sa(T) and AvgSa where the project names none
UNITS = {"PGA": "g", "PGV": "m/s", "Sa(T)": "g", "AvgSa": "g"}
RESAMPLED = 7  # seed of what levels of a record are known to, in the bootstrap of a loss
PARTS = ("beta_record", "beta_ensemble")  # null for stripes
COUNTED = ("rule", "pga_collapse_g", "pga_collapse_g_range")  # null for stripes
DIRECTIONS = {1: "+x", -1: "-x"}  # of the load by the sign of the record
UNKNOWN = dynamic.Loss(dynamic=None, dynamic_range=[None, None], distinguishable=None, left_out=0)
Row = TypeVar("Row", bound=dynamic.Scanned)
Fit = TypeVar("Fit", bound=dynamic.Fragility)


def spectrum_of(motion: BaseMotion, periods: Array) -> Array:
    """Return Sa(T) (k,) of a base motion, g: 5 % damping, at periods (k,) in s."""
    return response_spectrum(motion.record.acceleration, motion.record.time_step, periods, DAMPING)[0]


@dataclass(frozen=True)
class Measures:
    """The measures of intensity over which fragilities are given: PGA, PGV, Sa(T), and AvgSa between two periods (s).

    AvgSa is the geometric mean of Sa, evenly over ln T; PGV is that of the record without its mean acceleration.
    `period` (s): T of Sa(T); `over_pga`: of each record by their names, over its PGA; PGV in m/s per g.
    """

    period: float
    over_pga: Mapping[str, Mapping[str, float]]

    @classmethod
    def of(cls, project: Project, motions: Sequence[BaseMotion]) -> Self:
        """Return the measures of some records, at the periods of the project's campaign."""
        campaign, found = project.campaign, {}
        period = (campaign.period_s if campaign else None) or PERIOD
        periods = np.geomspace(*(campaign.periods_s if campaign else (FIRST, LAST)), COMPARED)
        for motion in motions:
            a = motion.record.acceleration - motion.record.acceleration.mean()
            velocity = GRAVITY * motion.record.time_step * np.cumsum(0.5 * (a[1:] + a[:-1]))
            values = {
                "PGA": motion.pga,
                "PGV": float(abs(velocity).max()),
                "Sa(T)": float(spectrum_of(motion, np.array([period]))[0]),
                "AvgSa": float(np.exp(np.mean(np.log(spectrum_of(motion, periods))))),
            }
            found[motion.name] = {name: value / motion.pga for name, value in values.items()}
        return cls(period, found)

    def fits(self, levels: Sequence[fragility.RecordLevel]) -> list[dynamic.MeasureFit]:
        """Return median and β of the same levels by each measure."""
        found = []
        for name, unit in UNITS.items():
            by = [replace(each, level=each.level * self.over_pga[each.record][name]) for each in levels]
            fit, period = fragility.over_records(by), self.period if name == "Sa(T)" else None
            median, beta = (fit.median, fit.beta) if fit else (None, None)
            told = {"period_s": period, "median": median, "beta": beta}
            found.append(dynamic.MeasureFit(measure=name, unit=unit, **told))
        return found


@dataclass(frozen=True, eq=False)
class Searches:
    """The scans of a study: every record with every sign from every state; `levels` (g): of stripes."""

    stage: str
    asked: Sequence[Asked]
    scans: Scans
    study: Study
    measures: Measures
    levels: Sequence[float] = ()

    @classmethod
    def made(
        cls, table: IncrementalTable | CampaignTable, places: Iterable[Place], motions: Sequence[BaseMotion],
        drawn: Assembly, scans: Scans, study: Study,
    ) -> Self:  # fmt: skip
        """Scan the records of a table from the places, at the time step that they need; see Scans.settle."""
        project, measures = scans.project, Measures.of(scans.project, motions)
        campaign = table if isinstance(table, CampaignTable) else None
        stage, signs = ("campaign", campaign.signs) if campaign else ("incremental", tuple(DIRECTIONS))
        by, levels = campaign.measure if campaign else "PGA", (campaign and campaign.levels_g) or ()
        reach = Reach(table.max_scale, stripes=levels) if levels else reach_of(project)
        ratio = {name: each[by] for name, each in measures.over_pga.items()}
        asked = asked_for(project, table, drawn, places, motions, signs, reach, ratio)
        looks = not levels and (campaign is not None or accuracy_of(project).tolerance is None)
        scans.settle(stage, asked, looks, study)
        return cls(stage, asked, scans, study, measures, levels)

    def of(self, state: Place | None) -> list[Asked]:
        """Return every record and sign from a state."""
        return [each for each in self.asked if each.state is state]

    def rows(self, kind: type[Row], asked: Sequence[Asked]) -> list[Row]:
        """Return a row of each record and sign; if several are one run, the later ones name the first."""
        rows: list[Row] = []
        first: dict[str, Asked] = {}
        for each in asked:
            row = as_part(kind, each, each.state, **self.scans.of(each).numbers)
            origin = first.setdefault(each.key, each)
            if origin is each:
                self.scans.tell(each, self.stage, self.study)
            elif each.shaking.starts:
                same = as_part(dynamic.SameAs, origin, origin.state)
                row = row.replace(same_as=same, runs=0, points=[], counts=None)
            rows.append(row)
        return rows

    def fragility(self, kind: type[Fit], state: Place, rows: Sequence[dynamic.Scanned]) -> Fit:
        """Return the fragility of a state from its `rows`, of the measure, and what NTC 2018 §7.3.5 takes of them.

        Of one record that collapses there is a level of 50 % and no scatter; of few records no ranges and no rule.
        """
        done = [(each, row) for each, row in zip(self.of(state), rows, strict=True) if row.reason is None]
        levels = [  # of 50 %; lower bounds where none collapses
            fragility.RecordLevel(row.record, level, row.level_50_g is None, row.beta or 0.0)
            for _, row in done
            if (level := row.level_50_g or row.pga_safe_g)
        ]
        fit = spread = None
        if self.levels:
            shares, names = self._shares([each for each, _ in done]), [row.record for _, row in done]
            spread = fit = fragility.over_stripes(self.levels, shares, names)
        elif done and len(levels) == len(done):
            own = zip(done, levels, strict=True)
            fit = fragility.over_records([replace(x, level=x.level * e.ratio) for (e, _), x in own])
            spread = fit if len({each.record for each in levels if not each.withstood}) > 1 else None
        low, high = spread.probable if spread else (None, None)
        found = {name: getattr(spread, name, None) for name in ("median_range", "beta", "beta_range", *PARTS)}
        found |= dict.fromkeys((*PARTS, *COUNTED)) | {"directions": {}} if self.levels else counted(rows)
        return as_part(
            kind, state, combinations=len(rows), failed=len(rows) - len(done), median_g=fit.median if fit else None,
            withstood=sum(row.lowest_collapse_g is None for _, row in done), level_16_g=low, level_84_g=high,
            band=[list(each) for each in spread.band] if spread else [],
            measures=self.measures.fits(levels) if spread and not self.levels else [], **found,
        )  # fmt: skip

    def loss(self, state: Place, base: Place | None) -> dynamic.Loss:
        """Return the loss of capacity 1 − after/before of a state against its `base`, if there is one.

        Of both signs of the records together; where one loses and the other gains by their ranges, that of the former.
        """
        pairs = list(zip(self.of(base), self.of(state), strict=True)) if base else []
        loss = self._loss_of(pairs)
        if state is base:
            return loss.replace(dynamic_range=[0.0, 0.0]) if loss.dynamic is not None else loss
        own = {way: [both for both in pairs if both[0].sign == sign] for sign, way in DIRECTIONS.items()}
        signs = {way: self._loss_of(of_sign) for way, of_sign in own.items()}
        losing = next((way for way, each in signs.items() if (each.dynamic_range[0] or 0.0) > 0.0), None)
        gains = (  # without bound where nothing collapses any more
            (each.dynamic_range[1] or 0.0) < 0.0 or (each.dynamic is None and each.records)
            for each in signs.values()
        )
        if losing is None or not any(gains):
            return loss
        both = {way: each.dynamic for way, each in signs.items()}
        return signs[losing].replace(left_out=loss.left_out, directions=both)

    def _loss_of(self, pairs: Sequence[tuple[Asked, Asked]]) -> dynamic.Loss:
        return self._loss_of_stripes(pairs) if self.levels else paired_loss(pairs, self.scans)

    def _loss_of_stripes(self, pairs: Sequence[tuple[Asked, Asked]]) -> dynamic.Loss:
        """Return the loss of the median over `pairs`; its range is that of the bootstrap over records."""
        done = [
            both for both in pairs if all(e.shaking.starts and self.scans.of(e).reason is None for e in both)
        ]
        loss = UNKNOWN.replace(left_out=len(pairs) - len(done))
        if not done:
            return loss
        samples = fragility.samples_of_records([one.record for one, _ in done])
        weights = np.vstack([np.ones(len(done)), *([] if samples is None else samples)])
        shares = (self._shares(own) for own in zip(*done, strict=True))
        medians = (fragility.fit_stripes(np.array(self.levels), each, weights).median for each in shares)
        # no level collapses: ∞, or all do: 0: only a bound is known
        before, after = (np.where((each > 0.0) & (each < math.inf), each, math.nan) for each in medians)
        lost = 1.0 - after / before
        if not math.isfinite(lost[0]):
            return loss
        ends: list[float | None] = [None, None]
        if len(lost) > 1 and np.isfinite(lost).all():
            ends = fragility.confidence(lost[1:])
        return _loss(float(lost[0]), ends, pairs, [one.record for one, _ in done])

    def _shares(self, own: Sequence[Asked]) -> Array:
        """Return the shares (n, k) of motions that collapse at each level of the stripes."""
        points = (self.scans.of(each).points for each in own)
        return np.array([[point.members_collapsed / point.members for point in each] for each in points])


def paired_loss(pairs: Sequence[tuple[Asked, Asked]], scans: Scans) -> dynamic.Loss:
    """Return the median over `pairs`, before and after, of the losses of 50 % levels, at one time step.

    Its range is that of the bootstrap over records, with what each level is known to where collapse scatters by the
    root of the mean square of the β of all these levels; of fewer than ENOUGH records that of the latter alone. Pairs
    with a value missing are counted in `left_out`.
    """
    names, changes, errors = [], [], []
    seen = [tuple(scan.seen for scan in scans.paired(*both)) for both in pairs]
    betas = [each.beta for both in seen for each in both if each.lowest is not None]
    beta = math.sqrt(sum(each**2 for each in betas) / max(len(betas), 1))
    for (one, _), (before, after) in zip(pairs, seen, strict=True):
        if before.middle is None or not (after.middle or after.safe):
            continue
        names.append(one.record)
        changes.append(math.log(after.middle / before.middle) if after.middle else math.inf)
        errors.append(math.hypot(before.known_to(beta), after.known_to(beta)))
    if not names:
        return UNKNOWN.replace(left_out=len(pairs))
    samples = fragility.samples_of_records(names)
    weights = (np.ones((1, len(names))) if samples is None else samples).astype(int)
    random = np.random.default_rng(RESAMPLED)
    noise = random.standard_normal((fragility.SAMPLES, len(names))) * errors + changes
    medians = [float(np.median(np.repeat(each, weights[k % len(weights)]))) for k, each in enumerate(noise)]
    ends = [_lost(value) for value in np.quantile(medians, [0.975, 0.025], method="nearest")]
    return _loss(_lost(float(np.median(changes))), ends, pairs, names)


def _loss(
    lost: float | None, ends: list[float | None], pairs: Sequence[tuple[Asked, Asked]], names: Sequence[str]
) -> dynamic.Loss:
    """Return the loss of some `pairs`, known for records of these `names`."""
    (low, high), records = ends, len(set(names))
    unmoved = all(one is other for one, other in pairs)
    distinct = None if unmoved or low is None or high is None else not low <= 0.0 <= high
    return dynamic.Loss(
        dynamic=lost, dynamic_range=ends, left_out=len(pairs) - len(names), records=records,
        distinguishable=None if distinct and records < ENOUGH else distinct,
    )  # fmt: skip


def _lost(change: float) -> float | None:
    """Return the loss of a change of ln level; None where only an upper bound of it is known."""
    return None if math.isinf(change) else 1.0 - math.exp(change)


def worse_signs(rows: Iterable[dynamic.Scanned]) -> dict[str, dynamic.Scanned]:
    """Return by record the sign that counts: one that was not completed, else that of the lowest level."""

    def worse(row: dynamic.Scanned) -> tuple[bool, float, float]:
        collapse = math.inf if row.pga_collapse_g is None else row.pga_collapse_g
        return row.reason is None, collapse, row.pga_safe_g or 0.0

    found: dict[str, dynamic.Scanned] = {}
    for row in rows:
        found[row.record] = min(found.get(row.record, row), row, key=worse)
    return found


def standard_of(rows: Iterable[dynamic.Scanned]) -> fragility.Standard:
    """Return the PGA at collapse by NTC 2018 §7.3.5, of each record with its worse sign.

    §7.3.5 [k]: with seven records or more the mean of the effects counts, with three to six the most unfavourable: the
    lowest PGA at collapse. With fewer there is no rule. A mean or lowest that a record without collapse leaves
    undecided is None; one of which a sign was not completed decides nothing.
    """
    worse = worse_signs(rows).values()
    found = [row.pga_collapse_g for row in worse if row.pga_collapse_g is not None]
    withstood = [row.pga_safe_g for row in worse if row.pga_collapse_g is None]
    mean = float(np.mean(found)) if found and not withstood else None
    lowest = min(found, default=None)
    if any(safe is None or safe < (lowest or 0.0) for safe in withstood):
        lowest = None
    rule = None if len(worse) < ENOUGH else "mean" if len(worse) >= MEAN_FROM else "lowest"
    return fragility.Standard(mean, lowest, rule)


def counted(rows: Sequence[dynamic.Scanned]) -> dict[str, Any]:
    """Return what §7.3.5 takes of all rows and of those of each sign, and from where all levels run collapse."""
    standard, ends = standard_of(rows), [each.pga_collapse_range for each in worse_signs(rows).values()]
    reached = [end for end in (each[1] if each else None for each in ends) if end is not None]
    mean = sum(reached) / len(reached) if reached and len(reached) == len(ends) else None
    upper = mean if standard.rule == "mean" else min(reached, default=None)
    of_sign = {sign: [row for row in rows if row.sign == sign] for sign in DIRECTIONS}
    directions = {DIRECTIONS[sign]: standard_of(own).pga for sign, own in of_sign.items() if own}
    found = standard.rule, standard.pga, [standard.pga, upper] if any(ends) else None
    return dict(zip(COUNTED, found, strict=True)) | {"directions": directions}


def findings(
    searches: Searches, records: int, found: Iterable[tuple[Place, dynamic.Fragility, dynamic.Loss | None]]
) -> Iterator[Message]:
    """Yield what to know of a study as a whole, and of the fragility and the loss of each of its states."""
    if records < ENOUGH:
        yield message(
            "records: {count}; NTC 2018 §7.3.5 asks for at least {least}; the scatter from record to record is not "
            "known", count=records, least=ENOUGH,
        )  # fmt: skip
    if any(each.run_sign != each.sign for each in searches.asked):
        yield message(
            "a symmetric structure: one sign of each record was run, the other is its mirror image; "
            "motions that turn on their last digits would differ by a few percent"
        )
    for state, fit, loss in found:
        for text in doubts(fit, bool(searches.levels)):
            yield headed(state.title, text)
        if loss is not None and loss.directions:
            [way] = [way for way, lost in loss.directions.items() if lost == loss.dynamic]
            text = message(
                "the two signs of the records go opposite ways: the loss is that of {direction}, {loss:.0%}; with the "
                "other sign there is a gain", direction=way, loss=known(loss.dynamic),
            )  # fmt: skip
            yield headed(state.title, text)
        if loss is not None and loss.distinguishable is False:
            lost, low, high = (round(x or 0.0, 2) + 0.0 for x in (loss.dynamic, *loss.dynamic_range))
            text = message("a loss of {loss:.0%} is not distinguishable from none: its range is from {low:.0%} to "
                           "{high:.0%}", loss=lost, low=low, high=high)  # fmt: skip
            yield headed(state.title, text)


def doubts(fit: dynamic.Fragility, stripes: bool) -> Iterator[Message]:
    """Yield what to know of a fragility: combinations left open, lower bounds, no median, stripes without scatter."""
    if fit.failed:
        yield message("{failed} of {count} combinations could not be completed; median, dispersion and loss are those "
                      "of the others", failed=fit.failed, count=fit.combinations)  # fmt: skip
    if fit.withstood:
        yield message(
            "{withstood} of {count} combinations do not collapse up to the largest level tried and count as lower "
            "bounds; raise max_scale, or levels_g, to find their collapse", withstood=fit.withstood,
            count=fit.combinations,
        )  # fmt: skip
    if stripes and fit.median_g is None and fit.failed < fit.combinations:
        yield message(
            "no median of collapse is found; some levels have to be withstood, and others not, and more "
            "combinations collapse as levels grow"
        )
    if stripes and fit.median_g is not None and fit.beta == 0.0:
        yield message(
            "no level with a collapse lies below one that is withstood, and the dispersion cannot be told: β = 0 and "
            "a median acceleration of {median:.3g} g are the limit of ever more likely distributions; "
            "add levels_g about it", median=fit.median_g,
        )  # fmt: skip


def incremental(
    inputs: MotionInputs, motions: Sequence[BaseMotion], scans: Scans, study: Study
) -> tuple[dict[str, dynamic.Incremental], list[ConvergenceRow]]:
    """Scan every record, of both signs, from every state; return each state's part, and errors of the time step."""
    project, table = inputs.project, known(inputs.project.incremental)
    control, states = project.control_point(table.control).name, {}
    for name in project.states:
        if table.states is None or name in table.states:
            pushed, start = inputs.pushovers.get(name, {}), inputs.starts[name, table.contacts]
            ends = ultimate_of(pushed, control), least_d_0(pushed, control)
            states[name] = Place(message("{state}", state=name), "", *start, *ends)
    drawn = inputs.starts[ORIGINAL, table.contacts][0]
    searches = Searches.made(table, states.values(), motions, drawn, scans, study)
    errors = scans.refine(searches.asked, study)
    found = {}
    for name, state in states.items():
        rows = searches.rows(dynamic.Scanned, searches.of(state))
        fit, standard = searches.fragility(dynamic.Fragility, state, rows), standard_of(rows)
        part = dynamic.Incremental(
            records=[_search(motion, rows) for motion in motions], mean_pga_collapse_g=standard.mean,
            lowest_pga_collapse_g=standard.lowest, fragility=fit,
        )  # fmt: skip
        if name != ORIGINAL and (original := states.get(ORIGINAL)):
            part = part.replace(loss=searches.loss(state, original))
        found[name] = part
    told = [(states[name], known(part.fragility), part.loss) for name, part in found.items()]
    study.warnings += [message("incremental: {text}", text=t) for t in findings(searches, len(motions), told)]
    return found, errors


def _search(motion: BaseMotion, rows: Iterable[dynamic.Scanned]) -> dynamic.Search:
    """Return the row of a record: what its worse sign comes to, and both signs."""
    signs = [row for row in rows if row.record == motion.name]
    worse = worse_signs(signs)[motion.name]
    return as_part(
        dynamic.Search, worse, record_pga_g=motion.pga, signs=signs, runs=sum(each.runs for each in signs),
        sign=None if worse.reason is not None else worse.sign, pga_collapse_g_range=worse.pga_collapse_range,
        **motion.told_vertical,
    )  # fmt: skip
