"""The tables of a project file: every key with its type, unit, default and meaning.

Units as everywhere: kN, m, s, Mg, accelerations in g. The descriptions are written for the user: they
become the comments of a new project file and the texts of the JSON schema.
"""

from assessment.project.schema.assessment import (
    AssessmentTable,
    FloorTable,
    HazardTable,
    KnowledgeTable,
    MechanismTable,
    SiteTable,
)
from assessment.project.schema.content import ProjectContent, ReportTable
from assessment.project.schema.motions import (
    VARIED,
    CampaignTable,
    HistoryTable,
    IdentificationTable,
    IncrementalTable,
    MeasurementTable,
    MotionTable,
    SensitivityTable,
    StatesTable,
)
from assessment.project.schema.structure import (
    BondTable,
    ChangedLayerTable,
    ContactsTable,
    ControlTable,
    GeometryTable,
    LayerTable,
    MaterialTable,
    PushoverTable,
    RegionTable,
    SettlementTable,
    StrengtheningTable,
    TieTable,
)
from assessment.project.schema.values import (
    MOST_ENTRIES,
    ORIGINAL,
    Contacts,
    Direction,
    KeyPath,
    LimitState,
    Table,
)

__all__ = [
    "MOST_ENTRIES", "ORIGINAL", "VARIED", "AssessmentTable", "BondTable", "CampaignTable",
    "ChangedLayerTable", "Contacts", "ContactsTable", "ControlTable", "Direction", "FloorTable",
    "GeometryTable", "HazardTable", "HistoryTable", "IdentificationTable", "IncrementalTable", "KeyPath",
    "KnowledgeTable", "LayerTable", "LimitState", "MaterialTable", "MeasurementTable", "MechanismTable",
    "MotionTable", "ProjectContent", "PushoverTable", "RegionTable", "ReportTable", "SensitivityTable",
    "SettlementTable", "SiteTable", "StatesTable", "StrengtheningTable", "Table", "TieTable",
]  # fmt: skip
