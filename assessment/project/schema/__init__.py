"""The tables of a project file: every key with its type, unit (kN, m, s, Mg, g), default and meaning for the user."""

import math
from collections.abc import Iterator
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Self, Union, get_args, get_origin

from pydantic import Field

from assessment.project.schema import values as kinds
from assessment.project.schema.assessment import *
from assessment.project.schema.motions import *
from assessment.project.schema.structure import *
from assessment.project.schema.values import *
from assessment.project.schema.values import ORIGINAL, Contradiction, FileName, NameOf, absent, entry, key_of
from assessment.runtime.files import template_table

Form = Literal["single", "list", "named"]
"""Of a table in the file: [name], [[name]] for each entry of a list, or [name.NAME] for each named entry."""


class ReportTable(ProjectTable):
    """[report]: language and the free text of the title page."""

    language: Literal["it", "en"] = entry("language of the report: it or en", "it")
    client: kinds.Text = entry("client, free text of the title page", "")
    engineer: kinds.Text = entry("engineer, free text of the title page", "")
    location: kinds.Text = entry("location, free text of the title page", "")
    municipality: kinds.Text = entry("municipality, free text of the title page", "")
    cadastre: kinds.Text = entry("land register, free text of the title page", "")
    protection: kinds.Text = entry("decree that lists the building (D.Lgs. 42/2004; NTC 2018, §8.4)", "")
    use: kinds.Text = entry("use of the building; schools have a threshold, dwellings classes", "")
    revision: kinds.Text = entry("revision, free text of the title page", "")
    date: kinds.Text = entry("date, free text of the title page; empty: a line to write on", "")
    annexes: Literal["short", "full"] = entry(
        "short: the governing checks; full: every step and figure; long lists are in tables/", "short"
    )
    attachments: Annotated[
        tuple[kinds.Name, ...], Field(strict=False, max_length=MOST_ENTRIES), FileName("picture")
    ] = entry(
        "photographs and survey drawings (PNG or JPEG files) that end the report; their names are captions",
        (),
    )


class ProjectContent(ProjectTable):
    """The content of a project file. A table that is absent switches its stage off."""

    title: kinds.Name = entry("title of the project")
    accuracy: Literal["fast", "standard", "fine"] | kinds.Tolerance = entry(
        "fast: increments and time steps as given, no error estimated; else they are halved until the "
        "estimated relative error is below standard (0.05), fine (0.01) or a number",
        "fast",
    )
    scatter: kinds.Members = entry(
        "members of the small ensemble run where a path slides or a motion has many impacts; 1: none", 5
    )
    geometry: GeometryTable = entry("the drawing and how it becomes blocks and joints")
    material: MaterialTable = entry("stone and joints, default of every layer")
    layers: Annotated[dict[kinds.Name, LayerTable], Field(max_length=MOST_LAYERS), DISTINCT] = entry(
        "what the blocks of a layer have of their own", {}
    )
    region: Named[RegionTable] = entry("parts of the drawing whose blocks have something of their own", ())
    contacts: ContactsTable = entry("how joints slide, and which blocks may touch", ContactsTable())
    control: Named[ControlTable] = entry("control points; the first one is the default", ())
    settlements: Named[SettlementTable] = entry("support movements to review, each one a state", ())
    tie: Named[TieTable] = entry("tie rods between two points of blocks or supports", ())
    strengthening: Named[StrengtheningTable] = entry(
        "strengthened states: ties that are set, and layers changed, after a movement", ()
    )
    pushover: PushoverTable | None = absent("pushover analysis")
    history: Named[HistoryTable] = entry("time histories, one per record and state", ())
    incremental: IncrementalTable | None = absent("incremental dynamic analysis")
    campaign: CampaignTable | None = absent("fragility and loss of capacity against movement")
    assessment: AssessmentTable | None = absent("check against the standard")
    mechanism: Annotated[tuple[MechanismTable, ...], TABLES] = entry(
        "mechanisms chosen by the user, one entry per macro-block", ()
    )
    sensitivity: SensitivityTable | None = absent("capacity with properties lower and higher, one at a time")
    identification: IdentificationTable | None = absent("support movement that explains what was measured")
    measurement: Named[MeasurementTable] = entry("what was measured: cracks, slips, leans, displacements", ())
    report: ReportTable = entry("language and title page of the report", ReportTable())

    @property
    def supports(self) -> tuple[str, ...]:
        """Names of the supports, in the order of the layers and regions."""
        return tuple(dict.fromkeys(each.support for each in self.parts.values() if each.support))

    @property
    def parts(self) -> dict[str, LayerTable]:
        """What layers and regions say of their blocks, by the name of the table."""
        regions = {f"region[{k}]": each for k, each in enumerate(self.region, 1)}
        return {f"layers.{name}": each for name, each in self.layers.items()} | regions

    @property
    def unstrengthened(self) -> tuple[str, ...]:
        """Names of the states that are no strengthening: the original one, then one per settlement."""
        return (ORIGINAL, *(settlement.name for settlement in self.settlements))

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states: the original one, one per settlement, one per strengthening."""
        return (*self.unstrengthened, *(each.name for each in self.strengthening))

    def strengthening_of(self, state: str) -> StrengtheningTable | None:
        """Return the strengthening that makes a state; None: the state is none."""
        return next((each for each in self.strengthening if each.name == state), None)

    def settlement_of(self, state: str) -> SettlementTable | None:
        """Return the movement that leads to a state, strengthened afterwards or not; None: none does."""
        made = self.strengthening_of(state)
        moved = made.of if made else state
        return next((each for each in self.settlements if each.name == moved), None)

    def movements_to(self, state: str) -> tuple[SettlementTable, ...]:
        """Return the movements that lead to a state, in their order, each begun in the state of the one before."""
        found: list[SettlementTable] = []
        last = self.settlement_of(state)
        while last is not None and last not in found:  # a circle is refused
            found.insert(0, last)
            last = next((each for each in self.settlements if each.name == found[0].after), None)
        return tuple(found)

    def ties_of(self, state: str) -> tuple[tuple[TieTable, ...], tuple[TieTable, ...]]:
        """Return the ties that are there as the support of a state moves, and those that its strengthening sets."""
        made = self.strengthening_of(state)
        moved = made.of if made else state
        there = tuple(each for each in self.tie if each.states is None or moved in each.states)
        later = (each for each in self.tie if made and each not in there and made.name in (each.states or ()))
        return there, tuple(later)

    def contradictions(self, project: Self) -> Iterator[Contradiction]:
        """Yield stiffnesses that elastic analyses lack, strengths that rigid motions forget, and what nothing uses."""
        motions: dict[KeyPath, MotionTable] = {("history", k): each for k, each in enumerate(self.history)}
        single = (("incremental", self.incremental), ("campaign", self.campaign))
        motions |= {(name,): table for name, table in single if table}
        elastic = [f"{key_of(path)}.contacts" for path, each in motions.items() if each.contacts == "elastic"]
        elastic += ["pushover.contacts"] * bool(self.pushover and "elastic" in self.pushover.contacts)
        elastic += ["assessment.model"] * bool(self.assessment and self.assessment.model != "none")
        tables: list[MaterialTable | LayerTable] = [self.material, *self.parts.values()]
        # where only some blocks lack a stiffness the model tells
        if elastic and not any(each.normal_stiffness_kN_m3 for each in tables):
            text = f"missing, but {', '.join(elastic)} ask for elastic contacts; add it, in kN/m³ "
            text += '(or write contacts "rigid", model "none")'
            yield ("material", "normal_stiffness_kN_m3"), text
        changed = (each for made in self.strengthening for each in made.layers.values())
        strengths = [each.compressive_strength_kN_m2 for each in (*tables, *changed)]
        rigid = [path for path, each in motions.items() if each.contacts == "rigid"]
        if rigid and min(each or math.inf for each in strengths) < math.inf:
            others = ", ".join(f"{key_of(path)}.contacts" for path in rigid[1:])
            text = '"rigid" joints do not remember in a motion what was crushed'
            text += f' (also {others}); write "elastic", with ' if others else '; write "elastic", with '
            text += "normal_stiffness_kN_m3, or leave compressive_strength_kN_m2 out, with confidence_factor = 1.35"
            yield (*rigid[0], "contacts"), text
        if self.strengthening and not (self.pushover or self.history or self.incremental):
            text = "nothing pushes or shakes the strengthened state; add [pushover], [[history]] or [incremental]"
            yield "strengthening", text
        told = self.settlements and all(each.kind in ("crack", "slip") for each in self.measurement)
        if self.measurement and self.identification is None and not told:
            yield "measurement", "nothing uses the measurements; add [identification]"


def alternatives(annotation: Any) -> tuple[Any, ...]:
    """Return the plain types behind an annotation: Annotated stripped, unions opened, None left out."""
    origin = get_origin(annotation)
    if origin is Annotated:
        return alternatives(get_args(annotation)[0])
    if origin in (Union, UnionType):
        return tuple(plain for member in get_args(annotation) for plain in alternatives(member))
    return () if annotation is NoneType else (annotation,)


def annotation_at(path: KeyPath) -> Any:
    """Return the annotation of the value at `path` of the content, or None where no such key is."""
    annotation: Any = ProjectContent
    for part in path:
        annotation = _inside(annotation, part)
    return annotation


def table_at(path: KeyPath) -> type[ProjectTable] | None:
    """Return the table at `path` of the content, of each entry where it is a list; None where none is."""
    return _table_of(annotation_at(path))


def keys_at(path: KeyPath, language: str = "en") -> dict[str, str]:
    """Return the keys of the table at `path` with what they mean, required ones first; none where keys are free."""
    for plain in alternatives(annotation_at(path)):
        if isinstance(plain, type) and issubclass(plain, ProjectTable):
            fields = sorted(plain.model_fields.items(), key=lambda item: not item[1].is_required())
            if language != "it":
                return {key: field.description or "" for key, field in fields}
            words, name = _italian(), plain.__name__
            return {key: words.get(f"{name}.{key}", words.get(key, "")) for key, _ in fields}
    return {}


@cache
def _italian() -> dict[str, str]:
    """Return the meaning of every key in Italian, by KEY or TABLE.KEY; in front of it there may be a label."""
    keys = template_table("app_it.toml")["keys"]
    return {key: told if isinstance(told, str) else told[1] for key, told in keys.items()}


def named_at(path: KeyPath) -> str | None:
    """Return of what in the project the value at `path` is a name, None where it is none."""
    table = table_at(path[:-1]) if path else None
    field = table.model_fields.get(str(path[-1])) if table else None
    return next((mark.what for mark in field.metadata if isinstance(mark, NameOf)), None) if field else None


def tables_of(table: type[ProjectTable]) -> dict[str, Form]:
    """Return the keys of a table that are tables themselves, and in which form each stands in the file."""
    found: dict[str, Form] = {}
    for key, field in table.model_fields.items():
        if _table_of(field.annotation):
            kinds = {get_origin(plain) for plain in alternatives(field.annotation)}
            found[key] = "list" if tuple in kinds else "named" if dict in kinds else "single"
    return found


def entries_of(table: type[ProjectTable]) -> list[KeyPath]:
    """Return the tables in a table by their paths below it, of several that of the first entry."""
    ends: dict[Form, KeyPath] = {"single": (), "list": (0,), "named": ("NAME",)}
    return [(name, *ends[form]) for name, form in tables_of(table).items()]


def _table_of(annotation: Any) -> type[ProjectTable] | None:
    for plain in alternatives(annotation):
        if isinstance(plain, type) and issubclass(plain, ProjectTable):
            return plain
        if get_origin(plain) in (tuple, dict):
            return _table_of(get_args(plain)[0 if get_origin(plain) is tuple else 1])
    return None


def _inside(annotation: Any, part: str | int) -> Any:
    for plain in alternatives(annotation):
        origin, args = get_origin(plain), get_args(plain)
        if origin is tuple and isinstance(part, int):
            return args[0]
        if origin is dict:
            return args[1]
        if isinstance(plain, type) and issubclass(plain, ProjectTable) and part in plain.model_fields:
            return plain.model_fields[str(part)].annotation
    return None
