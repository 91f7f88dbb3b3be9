"""results.json: every key with its type, unit and meaning; written and read here, and held against it each time."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final, Literal

from pydantic import BaseModel, ValidationError

from assessment.results.schema.checks import *
from assessment.results.schema.checks import Count, Direction, Multipliers
from assessment.results.schema.dynamic import *
from assessment.results.schema.model import *
from assessment.results.schema.part import *
from assessment.results.schema.part import Part, key, optional
from assessment.results.schema.static import *
from assessment.results.schema.static import OtherLaw, Run
from assessment.results.schema.studies import *
from mechanics.messages import Message, put_together, taken_apart

FORMAT: Final = 6
"""Of the file: it changes where a key goes, or gets another meaning."""


class SummaryCheck(Part):
    """`summary.rows[].checks.SLV`, …: the check that counts at a limit state."""

    check: str = key("its name: the least at SLO and SLD; `SLV linear` where the nonlinear one has no number")
    zeta_E: float | None = key("ζ_E at SLV and SLC, the ratio at SLO and SLD; null: not determined")
    zeta_E_range: list[float | None] | None = optional("least and largest of an ensemble")
    verified: bool | None = key("whether it is 1 or more; null: not determined, or below 1 within its range")
    loss: float | None = optional("of a settled state: 1 − ζ_E/ζ_E(original), both by this check")
    gain: float | None = optional("strengthened: ζ_E/ζ_E(before) − 1", "Incremento|Increase", change=True)
    distinguishable: bool | None = optional("whether the ranges of ζ_E before and after `loss` are apart")


class SummaryMechanism(Count):
    """`summary.rows[].mechanism`: what moves where α_0 is reached with rigid joints."""

    kind: Literal["overturning", "hinges", "sliding", "mixed"] = key("one hinge; several; slides alone; both")
    moving_weight_kN: float = key("weight of the blocks that move")


class SummaryRow(Multipliers):
    """`summary.rows[]`: a state in a direction; every static number is of one run."""

    state: str = key("state")
    direction: Direction | None = key("direction of the push; null: motions alone")
    reached: bool = key("whether the structure stands after the movement of the state")
    run: Run | None = optional("of the static numbers")
    control: str | None = optional("control point of the push")
    alpha_loss: float | None = optional("1 − α/α(original), of α_0, with elastic joints alone of α_u")
    alpha_distinguishable: bool | None = optional("whether the ranges of these α do not overlap")
    checks: dict[str, SummaryCheck] = key("by limit state; empty: no assessment")
    governing: str | None = key("limit state of the least ratio; null: none is determined")
    verified: bool | None = key(
        "whether SLV and SLC are verified, of those checked, or else the limit states that are; null: not determined"
    )
    mechanism: SummaryMechanism | None = optional("mechanism with rigid joints")
    other_law: OtherLaw | None = optional("by the other law of friction, where it differs")
    limit_state: str | None = key("the farthest one checked, of which the static capacity is; null: none")
    static_pga_g: float | None = key("PGA borne at that limit state, S a_g, with F_C; null: not determined")
    static_nominal_pga_g: float | None = optional("the same with F_C = 1, as `dynamic_pga_g` has none")
    dynamic_pga_g: float | None = optional("PGA at collapse by [incremental]; null: none found")
    dynamic_loss: float | None = optional(
        "`incremental.loss.dynamic`, of the levels of 50 %; null: not determined",
        "Perdita dinamica, mediana|Dynamic loss, median", change=True,
    )  # fmt: skip
    dynamic_to_static: float | None = optional("`dynamic_pga_g` over `static_nominal_pga_g`")


class SummaryGoverning(Part):
    """`summary.governing`: where ζ_E is least, at SLV where it was checked (NTC 2018, §8.3)."""

    direction: Direction = key("direction of the push")
    limit_state: str = key("which check")
    zeta_E: float = key("the index, or the ratio where neither SLV nor SLC was checked")
    state: str = key("state")


class Summary(Part):
    """`summary`: every state and direction that was asked for, in the order of the project."""

    reference: Literal["surface"] = key("where every PGA of the summary is, static and dynamic: S a_g")
    governing: SummaryGoverning | None = key("the least index; null: none is determined")
    verified: bool | None = key("whether all rows are; null: not determined")
    rows: list[SummaryRow] = key("states and directions")


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
    indices: Indices | None = optional("indices of safety and risk; null: no check at SLV")


class Results(Part):
    """The whole file."""

    format: Literal[6] = key("format of the file; a file of another one is refused")
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
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return head | Results.model_json_schema(mode="serialization") | {"title": "results.json of assesto"}


AGAIN = "run the project again"
# of a file: a campaign of ten thousand combinations with all its curves has a fifteenth
MOST_BYTES = 1_000_000_000


def as_bytes(results: Results) -> bytes:
    """Return results as they are written, in the order of their schema, with what their sentences are made of."""
    if table := {str(text): Worded(**taken_apart(text)) for text in _messages(results)}:
        results = results.replace(messages=table)
    return json.dumps(plain(results), ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()


def read_results(path: Path) -> Results:
    """Return results from their file.

    Raises ValueError naming file and key for a file that holds none, that is of another version, or damaged.
    """
    if path.stat().st_size > MOST_BYTES:
        raise ValueError(f"{path}: more than {MOST_BYTES} bytes: not readable as results; {AGAIN}")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        found = content.get("format") if "assesto" in content else None
    except (ValueError, TypeError, AttributeError, RecursionError):
        content = None
    if content is None or "assesto" not in content:
        raise ValueError(f"{path}: not readable as results; {AGAIN}")
    if found != FORMAT:
        written = "no format" if found is None else f"format {found!r}"
        raise ValueError(
            f"{path}: format: {written}, this version reads {FORMAT}: written by another version of assesto; {AGAIN}"
        )
    try:
        return Results.model_validate(with_messages(content))
    except ValidationError as error:
        wrong = first_error(error)
    except (AttributeError, KeyError, TypeError, ValueError):  # of a table of messages
        wrong = "messages: not as they are written"
    raise ValueError(f"{path}: {wrong}: damaged, or written by another version; {AGAIN}")


def with_messages(content: dict[str, Any]) -> dict[str, Any]:
    """Return the content of a file of results whose sentences are the messages that its table has.

    Raises KeyError, TypeError or ValueError for a table that is damaged.
    """
    table = json.loads(json.dumps(content.get("messages") or {}), object_hook=put_together)
    return {name: value if name == "messages" else _said(value, table) for name, value in content.items()}


def _said(value: Any, table: Mapping[str, Message]) -> Any:
    """Return a part of the content with its messages; lists of numbers are left out by their first item."""
    if isinstance(value, str):
        return table.get(value, value)
    if isinstance(value, dict):
        return {name: _said(inner, table) for name, inner in value.items()}
    if isinstance(value, list) and value and not isinstance(value[0], int | float):
        return [_said(inner, table) for inner in value]
    return value


def _messages(value: Any) -> Iterator[Message]:
    """Yield the messages in a part of the results; lists of numbers are left out by their first item."""
    if isinstance(value, Message):
        yield value
    elif isinstance(value, BaseModel):
        for name in type(value).model_fields:  # in their order: the same bytes at every run
            yield from _messages(getattr(value, name))
    elif isinstance(value, Mapping):
        for inner in value.values():
            yield from _messages(inner)
    elif isinstance(value, list) and value and not isinstance(value[0], int | float):
        for inner in value:
            yield from _messages(inner)
