"""The records of a campaign: files, made to the spectrum of the site or scaled to it; measures of intensity."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from assessment.analyses import fragility
from assessment.ntc.floor_spectrum import Spectrum
from assessment.ntc.tables import farthest
from assessment.project.motions import BaseMotion, motion_of
from assessment.project.project import Project
from assessment.project.schema import CampaignTable
from assessment.project.schema.motions import GENERATED_STEP
from assessment.results.schema.dynamic import CampaignSpectrum, MeasureFit
from assessment.studies.variants import Statics
from mechanics.messages import message
from mechanics.records import Record, compatible_record, response_spectrum
from mechanics.types import GRAVITY, Array

DAMPING = 0.05  # of spectra and of Sa(T)
COMPARED = 60  # periods at which spectra are compared
PERIOD, FIRST, LAST = 1.0, 0.15, 2.0  # s: of Sa(T) and AvgSa where the project names none
UNITS = {"PGA": "g", "PGV": "m/s", "Sa(T)": "g", "AvgSa": "g"}
DURATION, PLATEAU = 25.0, 10.0  # s, of a record that is made: NTC 2018 §3.2.3.6 [k]
LOW, HIGH = -0.10, 0.30  # of the target: least and largest deviation of the mean spectrum


def record_set(
    statics: Statics, table: CampaignTable, motions: Sequence[BaseMotion]
) -> tuple[list[BaseMotion], CampaignSpectrum | None]:
    """Return the motions of files, or made to the site's spectrum or scaled to it, with their mean spectrum."""
    if not (table.generated or table.spectrum_compatible):
        return list(motions), None
    found, spectra = list(motions), statics.demands.spectra
    limit_state = farthest(spectra) or next(iter(spectra))
    target = spectra[limit_state]
    if table.generated:
        seeds = range(1, table.generated + 1)
        tasks, titles = [(target, seed) for seed in seeds], [f"record {seed}" for seed in seeds]
        made = statics.workers.each("campaign: records", made_record, tasks, titles, len(tasks) > 1)
        found = [motion_of(statics.project, "campaign", table, record) for record in made]
    if table.spectrum_compatible:
        found = scaled_to(target, found, table)
    return found, compatibility(limit_state, target, found, table)


def made_record(spectrum: Spectrum, seed: int) -> Record:
    """Return a record whose spectrum is within 10 % of a given one; the same seed gives the same record."""
    made = compatible_record(spectrum.acceleration, DURATION, GENERATED_STEP, seed, plateau=PLATEAU)
    return replace(made, name=f"generated {seed}")


def scaled_to(target: Spectrum, motions: Sequence[BaseMotion], table: CampaignTable) -> list[BaseMotion]:
    """Scale each record, within the limits, so that the mean of ln(S_a/target) over ln T vanishes."""
    periods, (low, high) = np.geomspace(*table.periods_s, COMPARED), table.scale_limits
    wanted, found = np.log(target.acceleration(periods)), []
    for motion in motions:
        best = float(np.exp(np.mean(wanted - np.log(spectrum_of(motion, periods)))))
        factor, notes = float(np.clip(best, low, high)), motion.notes
        if factor != best:
            limited = message(
                "campaign, {record}: the spectrum of the site asks for a factor of {wanted:.3g}; "
                "{taken:.3g} is taken, the limit (scale_limits = [{low:g}, {high:g}])",
                record=motion.name, wanted=best, taken=factor, low=low, high=high,
            )  # fmt: skip
            notes += (limited,)
        scaled, original = motion.at_amplitude(factor), motion.original.scaled(factor)
        pga, scale, own = factor * motion.pga, factor * motion.scale, motion.amplitude
        found.append(replace(scaled, original=original, pga=pga, scale=scale, amplitude=own, notes=notes))
    return found


def compatibility(
    limit_state: str, target: Spectrum, motions: Sequence[BaseMotion], table: CampaignTable
) -> CampaignSpectrum:
    """Return the mean spectrum of a set of records with the target: relative deviations and their periods (s)."""
    periods = np.geomspace(*table.periods_s, COMPARED)
    wanted = target.acceleration(periods)
    mean = np.mean([spectrum_of(each, periods) for each in motions], axis=0)
    deviation = mean / wanted - 1.0
    low, high = float(deviation.min()), float(deviation.max())
    return CampaignSpectrum(
        limit_state=limit_state, periods_s=list(table.periods_s), T_s=periods.tolist(), target_g=wanted.tolist(),
        mean_g=mean.tolist(), lowest_deviation=low, highest_deviation=high, within=low >= LOW and high <= HIGH,
    )  # fmt: skip


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

    def fits(self, levels: Sequence[fragility.RecordLevel]) -> list[MeasureFit]:
        """Return median and β of the same levels by each measure."""
        found = []
        for name, unit in UNITS.items():
            by = [replace(each, level=each.level * self.over_pga[each.record][name]) for each in levels]
            fit, period = fragility.over_records(by), self.period if name == "Sa(T)" else None
            median, beta = (fit.median, fit.beta) if fit else (None, None)
            found.append(MeasureFit(measure=name, unit=unit, period_s=period, median=median, beta=beta))
        return found
