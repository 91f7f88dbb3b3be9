"""results.json: every key with its type, unit and meaning; held against it where made, and when read."""

from __future__ import annotations

from typing import Any, Final, Literal

from assessment.results.schema.checks import *
from assessment.results.schema.dynamic import *
from assessment.results.schema.model import *
from assessment.results.schema.part import *
from assessment.results.schema.static import *
from assessment.results.schema.studies import *
from assessment.results.schema.summary import *

FORMAT: Final = 3
"""Of the file: it changes where a key goes, or gets another meaning."""


class StateResults(Part):
    """`states.NAME`: the structure as drawn ("original"), or after a settlement or a strengthening of that name."""

    configuration: Configuration = key("x, z, ω of each block against the drawing; zeros: not reached")
    settlement: Settlement | None = key("the movement that leads to it; null: as drawn, or strengthened")
    strengthening: Strengthening | None = optional("what strengthens it after a movement; missing: nothing")
    pushdown: dict[Behaviour, PushdownPath] = key("the movement, by behaviour of the joints")
    pushover: dict[Direction, Pushovers] = key("horizontal loads, by direction")
    capacity: dict[Direction, Capacity] = key("capacity and checks, by direction")
    history: list[History] = key("time histories")
    incremental: Incremental = key("incremental dynamic analysis")
    governing: Governing | None = optional("the least ratio of all checks; null: none has a number")
    indices: Indices | None = optional("indices of safety and risk; null: no check at SLV")
    safety_index: SafetyIndex | None = optional("the least ζ_E at SLV and SLC; null: none has a number")


class Results(Part):
    """The whole file."""

    format: Literal[3] = key("format of the file; a file of another one is refused")
    assesto: str = key("version of the program")
    title: str = key("title of the project")
    summary: Summary = key("what the first page of a report prints")
    inputs: dict[str, str] = key("SHA-256 of each file that was read, by name")
    model: ModelSummary = key("what was read from the drawing")
    geometry: Geometry = key("blocks, joints, control points")
    loads: list[LayerLoads] | None = optional("vertical loads by layer, as combined")
    echo: Echo = key("the project file")
    states: dict[str, StateResults] = key("every state, by name")
    spectra: dict[str, DemandSpectrum] | None = optional("the demand, by limit state")
    knowledge: Knowledge | None = optional("what the confidence factor follows from")
    mechanisms: list[GivenMechanism] | None = optional("the mechanisms of the project file")
    motions: list[AppliedRecord] | None = optional("the records of [[history]]")
    comparison: list[ComparisonRow] = key("settled states beside the original one")
    strengthening: list[StrengtheningRow] | None = optional("strengthened states beside what they strengthen")
    scenarios: Scenarios | None = optional("all movements side by side")
    sensitivity: Sensitivity | None = optional("every state with each property lower and higher")
    identification: Identification | None = optional("the support movement that explains what was measured")
    campaign: Campaign | None = optional("fragility and loss of capacity against movement")
    convergence: Convergence = key("estimated errors")
    quality: Quality = key("certificates and warnings")
    messages: dict[str, Worded] | None = optional("what its sentences are made of, by sentence")
    timing_s: dict[str, float] = key("computing time by analysis")
    software: Software = key("versions")


def json_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of results.json."""
    schema = Results.model_json_schema(mode="serialization")
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "title": "results.json of assesto",
    }
