"""The ground motions of a run: every record that its project names, read before anything is analysed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from assessment.project.motions import (
    BaseMotion,
    campaign_motions,
    history_motions,
    incremental_motions,
    records_of,
)
from assessment.project.record_set import check_record_set, doubtful_records, doubtful_units
from mechanics.messages import Message

if TYPE_CHECKING:
    from assessment.project.project import Project
    from mechanics.records import Record


@dataclass(frozen=True)
class Motions:
    """The base motions of [[history]], [incremental] and the files of [campaign], read before anything is analysed.

    `records`: every file that was read, once and as it is.
    """

    history: list[BaseMotion]
    incremental: list[BaseMotion]
    campaign: list[BaseMotion]
    records: list[Record]

    @property
    def notes(self) -> list[Message]:
        """What the user should know about the records."""
        every = (*self.history, *self.incremental, *self.campaign)
        told = {motion.name for motion in self.campaign}
        others = [record for record in self.records if record.name not in told]
        return [
            *(note for motion in every for note in motion.notes),
            *doubtful_records(self.campaign),
            *doubtful_units(others),
        ]


def read_motions(project: Project) -> Motions:
    """Read every record that the project names.

    Raises ProjectError or ValueError naming file, line or key.
    """
    found = Motions(
        history_motions(project), incremental_motions(project), campaign_motions(project), records_of(project)
    )
    check_record_set(project, found.campaign)
    return found
