"""results.json and its schema: what is written is described, and what is not as described is refused."""

import copy
import json
from collections.abc import Iterator
from types import UnionType
from typing import Any, Union, get_args, get_origin

import pytest
from pydantic import ValidationError

from assessment.results.schema import FORMAT, Results, as_bytes, json_schema, read_results
from assessment.results.schema.checks import CHECKS, Capacity, Check
from assessment.results.schema.dynamic import Search
from assessment.results.schema.part import first_error
from assessment.results.table import cells
from tests.support.analysed import analysed
from tests.support.results_example import results_example
from tests.support.typed import filled
from tools.docs_pages import tables

UNITS = {"m": "m", "kN": "kN", "kNm": "kNm", "g": "g", "s": "s", "rad": "rad", "m2": "kN/m²", "s2": "m/s²"}
UNITS |= {"kN_m": "kN/m", "m_s": "m/s"}


TABLES = sorted(set(tables(Results)), key=lambda table: table.__name__)


def plain(annotation: Any) -> set[Any]:
    """What a value is made of in the end."""
    if get_origin(annotation) in (Union, UnionType, list):
        return {each for inner in get_args(annotation) for each in plain(inner)}
    return {annotation}


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.__name__)
def test_every_key_has_a_meaning_and_every_number_a_unit(table):
    assert table.__doc__
    for name, field in table.model_fields.items():
        assert field.description, name
        unit = (field.json_schema_extra or {}).get("unit")
        if float in plain(field.annotation):
            assert unit, name
        suffix = next((end for end in ("kN_m", "m_s") if name.endswith(f"_{end}")), name.rpartition("_")[2])
        if suffix in UNITS and unit and unit != "m, rad":
            assert unit == UNITS[suffix], name


@pytest.fixture(scope="module")
def results() -> dict[str, Any]:
    return analysed()


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The path of every table of results, one of each list."""
    if isinstance(value, dict):
        yield path
        for key, inner in value.items():
            yield from places(inner, (*path, key))
    elif isinstance(value, list) and value:
        yield from places(value[0], (*path, 0))


def at(value: Any, path: tuple[Any, ...]) -> Any:
    for part in path:
        value = value[part]
    return value


def refusal(content: Any) -> str:
    """What is said of results that are not as the schema says."""
    with pytest.raises(ValidationError) as refused:
        Results.model_validate(content)
    return first_error(refused.value)


FREE = {
    "echo", "inputs", "packages", "timing_s", "levels", "required_zeta", "components", "origins", "fields",
}  # fmt: skip
"""Tables whose keys are names."""


def described(results: dict[str, Any]) -> list[tuple[Any, ...]]:
    """Tables of results whose keys the schema knows, one of each kind."""
    # one level of names
    named = {"states", "spectra", "pushdown", "pushover", "capacity", "messages", "checks"}
    found: dict[tuple[Any, ...], tuple[Any, ...]] = {}
    for path in places(results):
        if not FREE & {*path} and not (path and path[-1] in named):
            kind = tuple(part for part, above in zip(path, (None, *path), strict=False) if above not in named)
            found.setdefault(kind, path)
    return list(found.values())


def test_an_undocumented_key_is_refused_in_every_table(results):
    for path in described(results):
        at(results, path)["undocumented"] = 1.0
        assert refusal(results).endswith("undocumented: unknown key")
        del at(results, path)["undocumented"]
    Results.model_validate(results)


def test_a_missing_key_is_refused(results):
    """The schema knows which ones a table has always: those named as required in the JSON schema."""
    required = {
        name: set(table["required"]) for name, table in json_schema()["$defs"].items() if "required" in table
    }
    wanted = {
        "ModelSummary": ("model",),
        "DrawnBlock": ("geometry", "blocks", 0),
        "History": ("states", "original", "history", 0),
        "RigidPush": ("states", "original", "pushover", "+x", "rigid"),
    }
    for name, path in wanted.items():
        table = at(results, path)
        assert required[name] <= table.keys()
        for key in required[name]:
            value = table.pop(key)
            assert refusal(results).endswith(f".{key}: missing")
            table[key] = value


@pytest.mark.parametrize("value", [float("nan"), "0.1", True])
def test_a_number_is_a_number(results, value):
    changed = copy.deepcopy(results)
    changed["model"]["weight_kN"] = value
    assert refusal(changed).startswith("model.weight_kN: ")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda c: c.pop("format"), f"format: no format, this version reads {FORMAT}: written by another version"),
        (lambda c: c.update(format=FORMAT + 1), f"format: format {FORMAT + 1}, this version reads {FORMAT}"),
        (lambda c: c["model"].pop("weight_kN"), "model.weight_kN: missing: damaged, or written by another"),
        (lambda c: c["geometry"]["blocks"][1].update(depth_m=None), "geometry.blocks[1].depth_m: Input should be"),
        (lambda c: c["quality"].update(a=1, b=2), "quality.a: unknown key (and 1 more): damaged"),
        (lambda c: c.pop("geometry"), "geometry: missing: damaged"),
    ],
    ids=["no format", "newer", "missing", "null", "unknown", "cut short"],
)  # fmt: skip
def test_what_is_read_is_held_against_the_schema(results, tmp_path, change, said):
    """One message that names file and key."""
    content = copy.deepcopy(results)
    change(content)
    path = tmp_path / "results.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(ValueError) as caught:
        read_results(path)
    assert str(caught.value).startswith(f"{path}: {said}")
    assert str(caught.value).endswith("; run the project again")


def test_the_example_of_other_tests_is_results():
    Results.model_validate(results_example())


def test_results_are_read_as_they_were_written(tmp_path):
    """Key by key in the same order, every bit of a number: printing a report again does not change the file."""
    results = analysed()
    written = as_bytes(Results.model_validate(results))
    assert written == json.dumps(results, ensure_ascii=False, separators=(",", ":")).encode()
    (tmp_path / "results.json").write_bytes(written)
    assert as_bytes(read_results(tmp_path / "results.json")) == written


def test_checks_are_met_by_name_in_the_order_of_the_limit_states():
    check = filled(Check)
    capacity = Capacity.model_validate(filled(Capacity, dict.fromkeys(CHECKS, check)))
    assert list(capacity.checks) == list(CHECKS)
    assert Capacity.model_validate(filled(Capacity, {"SLV linear": check})).checks.keys() == {"SLV linear"}


def test_a_missing_key_of_a_row_is_another_thing_than_null():
    search = Search.model_validate(filled(Search, {"pga_collapse_g": None}))
    assert cells(search, ("record", "pga_collapse_g", "seconds", "state")) == {
        "record": "",
        "pga_collapse_g": None,
    }
