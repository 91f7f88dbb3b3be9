"""The records of a campaign, made to the spectrum of the site or scaled to it, and their measures of intensity."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from assessment.analyses.fragility import RecordLevel, over_records
from assessment.ntc.floor_spectrum import Spectrum
from assessment.project.motions import BaseMotion
from assessment.project.project import Project
from assessment.project.schema.motions import GENERATED_STEP, CampaignTable
from assessment.results.schema.dynamic import CampaignSpectrum, MeasureFit
from mechanics.messages import message
from mechanics.records import Record, compatible_record, response_spectrum
from mechanics.types import GRAVITY, Array

DURATION, PLATEAU = 25.0, 10.0  # s: NTC 2018 §3.2.3.6 [k]
DAMPING = 0.05  # of spectra and of Sa(T)
LOW, HIGH = -0.10, 0.30  # of the target: least and largest deviation of the mean spectrum
PERIODS = 60  # at which spectra are compared
PERIOD, FIRST, LAST = 1.0, 0.15, 2.0  # s: of Sa(T) and AvgSa where the project names none
UNITS = {"PGA": "g", "PGV": "m/s", "Sa(T)": "g", "AvgSa": "g"}


def made_record(spectrum: Spectrum, seed: int) -> Record:
    """Return a record whose spectrum is within 10 % of a given one; the same seed gives the same record."""
    made = compatible_record(spectrum.acceleration, DURATION, GENERATED_STEP, seed, plateau=PLATEAU)
    return replace(made, name=f"generated {seed}")


def spectrum_of(motion: BaseMotion, periods: Array) -> Array:
    """Return Sa(T) (k,) of a base motion, g: 5 % damping, at periods (k,) in s."""
    return response_spectrum(motion.record.acceleration, motion.record.time_step, periods, DAMPING)[0]


def ordinate(motion: BaseMotion, period: float) -> float:
    """Return Sa(T) of a base motion, g, at a period T in s."""
    return float(spectrum_of(motion, np.array([period]))[0])


def scaled_to(target: Spectrum, motions: Sequence[BaseMotion], table: CampaignTable) -> list[BaseMotion]:
    """Scale each record, within the limits, so that the mean of ln(S_a/target) over ln T vanishes."""
    periods, (low, high) = np.geomspace(*table.periods_s, PERIODS), table.scale_limits
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
    periods = np.geomspace(*table.periods_s, PERIODS)
    wanted = target.acceleration(periods)
    mean = np.mean([spectrum_of(each, periods) for each in motions], axis=0)
    deviation = mean / wanted - 1.0
    return CampaignSpectrum(
        limit_state=limit_state,
        periods_s=list(table.periods_s),
        T_s=periods.tolist(),
        target_g=wanted.tolist(),
        mean_g=mean.tolist(),
        lowest_deviation=float(deviation.min()),
        highest_deviation=float(deviation.max()),
        within=bool(deviation.min() >= LOW and deviation.max() <= HIGH),
    )


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
        periods = np.geomspace(*(campaign.periods_s if campaign else (FIRST, LAST)), PERIODS)
        for motion in motions:
            a = motion.record.acceleration - motion.record.acceleration.mean()
            velocity = GRAVITY * motion.record.time_step * np.cumsum(0.5 * (a[1:] + a[:-1]))
            values = {
                "PGA": motion.pga,
                "PGV": float(abs(velocity).max()),
                "Sa(T)": ordinate(motion, period),
                "AvgSa": float(np.exp(np.mean(np.log(spectrum_of(motion, periods))))),
            }
            found[motion.name] = {name: value / motion.pga for name, value in values.items()}
        return cls(period, found)

    def fits(self, levels: Sequence[RecordLevel]) -> list[MeasureFit]:
        """Return median and β of the same levels by each measure."""
        found = []
        for name, unit in UNITS.items():
            by = [replace(each, level=each.level * self.over_pga[each.record][name]) for each in levels]
            fit, period = over_records(by), self.period if name == "Sa(T)" else None
            median, beta = (fit.median, fit.beta) if fit else (None, None)
            found.append(MeasureFit(measure=name, unit=unit, period_s=period, median=median, beta=beta))
        return found
