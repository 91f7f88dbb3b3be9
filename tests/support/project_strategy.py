"""Any content that the schema of the project file allows, as a hypothesis strategy made from that schema.

A key that is added to the schema is drawn without a change here.
"""

import math
from typing import Any

from hypothesis import strategies as st

from assessment.project.project import json_schema

# Texts that a spreadsheet could take for something else.
TRICKY = ("=1+1", "0", "a; b", '"', "_x0041_", "#N/A", "TRUE", "1e5", "key", "-x", "1,5", "a.b", "inf", "[x]")
LARGEST, SMALLEST = 1e9, 1e-6
LETTERS = st.characters(codec="utf-8")


def project_contents() -> st.SearchStrategy[dict[str, Any]]:
    """Contents of project files: valid table by table; names and files need not exist."""
    schema = json_schema()
    return _strategy(schema, schema["$defs"])


def _strategy(schema: dict[str, Any], tables: dict[str, Any]) -> st.SearchStrategy[Any]:
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        return st.deferred(lambda: _strategy(tables[name], tables))
    if "anyOf" in schema:
        kinds = [each for each in schema["anyOf"] if each.get("type") != "null"]
        return st.one_of([_strategy(each, tables) for each in kinds])
    if "enum" in schema:
        return st.sampled_from(schema["enum"])
    if "const" in schema:
        return st.just(schema["const"])
    make = {"object": _object, "array": _array, "string": _text, "number": _number, "integer": _whole}
    return st.booleans() if schema["type"] == "boolean" else make[schema["type"]](schema, tables)


def _object(schema: dict[str, Any], tables: dict[str, Any]) -> st.SearchStrategy[dict[str, Any]]:
    if "properties" not in schema:  # free keys
        (pattern, entry), *_ = schema.get(
            "patternProperties", {".*": schema.get("additionalProperties")}
        ).items()
        keys = _strategy({"type": "string", "pattern": pattern} | schema["propertyNames"], tables)
        values = _strategy(entry, tables)
        return st.dictionaries(keys, values, min_size=schema.get("minProperties", 0), max_size=3)
    keys = {key: _strategy(each, tables) for key, each in schema["properties"].items()}
    required = {key: keys.pop(key) for key in schema.get("required", ())}
    drawn = st.fixed_dictionaries(required, optional=keys)
    return drawn.filter(bool) if schema.get("minProperties") else drawn


def _array(schema: dict[str, Any], tables: dict[str, Any]) -> st.SearchStrategy[list[Any]]:
    if "prefixItems" in schema:
        return st.tuples(*(_strategy(each, tables) for each in schema["prefixItems"])).map(list)
    items = _strategy(schema["items"], tables)
    unique = schema.get("uniqueItems", False)
    return st.lists(items, min_size=schema.get("minItems", 0), max_size=3, unique=unique)


def _text(schema: dict[str, Any], _: dict[str, Any]) -> st.SearchStrategy[str]:
    longest = min(schema.get("maxLength", 20), 20)
    drawn = st.from_regex(schema.get("pattern", ".*"), fullmatch=True, alphabet=LETTERS)
    return st.sampled_from(TRICKY) | drawn.map(lambda text: text[:longest].strip() or "x")


def _number(schema: dict[str, Any], _: dict[str, Any]) -> st.SearchStrategy[float]:
    low = max(schema.get("minimum", -LARGEST), schema.get("exclusiveMinimum", -LARGEST) + SMALLEST)
    high = min(schema.get("maximum", LARGEST), schema.get("exclusiveMaximum", LARGEST) - SMALLEST)
    whole = st.integers(math.ceil(low), math.floor(high))
    return st.floats(low, high) | whole if math.ceil(low) <= high else st.floats(low, high)


def _whole(schema: dict[str, Any], _: dict[str, Any]) -> st.SearchStrategy[int]:
    return st.integers(schema.get("minimum", -1000), schema.get("maximum", 1000))
