"""The records of a campaign: read or made, scaled to the target spectrum if asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from assessment.analyses.dynamic.record_set import Target, compatibility, made_record, ordinate, scaled_to
from assessment.project.motions import motion_of
from assessment.results.schema.campaign import CampaignRecord, CampaignSpectrum

if TYPE_CHECKING:
    from assessment.analyses.checks.demand import Demands
    from assessment.project.motions import BaseMotion
    from assessment.project.project import Project
    from assessment.project.schema import CampaignTable
    from assessment.runtime.tasks import Workers


@dataclass(frozen=True, eq=False)
class RecordSet:
    """The motions of a campaign; `ratios`: intensity measure of each motion over its PGA.

    `spectrum`: mean spectrum and target, None if no record is made or scaled to a target.
    """

    motions: Sequence[BaseMotion]
    ratios: Sequence[float]
    spectrum: CampaignSpectrum | None

    def rows(self, table: CampaignTable) -> list[CampaignRecord]:
        """Return a row of results for each motion."""
        return [_row(motion, ratio, table) for motion, ratio in zip(self.motions, self.ratios, strict=True)]


def record_set(
    project: Project,
    table: CampaignTable,
    motions: Sequence[BaseMotion],
    demands: Demands,
    workers: Workers,
) -> RecordSet:
    """Return the `motions` of the files, or records made to the target spectrum, scaled to it if asked for.

    Raises KilledError where a process was ended from outside.
    """
    found, spectrum = list(motions), None
    if table.generated or table.spectrum_compatible:
        target = Target.of(demands.spectra)
        if table.generated:
            found = _made(project, table, target, workers)
        if table.spectrum_compatible:
            found = scaled_to(target, found, table)
        spectrum = compatibility(target, found, table)
    ratios = [ordinate(each, table.period_s) / each.pga if table.period_s else 1.0 for each in found]
    return RecordSet(found, ratios, spectrum)


def _made(project: Project, table: CampaignTable, target: Target, workers: Workers) -> list[BaseMotion]:
    """Make as many records as are asked for; their seeds count from 1."""
    assert table.generated
    seeds = range(1, table.generated + 1)
    made = workers.each(
        "campaign: records",
        made_record,
        [(target.spectrum, seed) for seed in seeds],
        [f"record {seed}" for seed in seeds],
        table.generated > 1,
    )
    return [motion_of(project, "campaign", table, record) for record in made]


def _row(motion: BaseMotion, ratio: float, table: CampaignTable) -> CampaignRecord:
    row = CampaignRecord(
        record=motion.name,
        record_pga_g=motion.pga,
        scale=motion.scale,
        duration_s=motion.record.duration,
        time_step_s=motion.record.time_step,
    )
    return row.replace(sa_g=ratio * motion.pga) if table.period_s else row
