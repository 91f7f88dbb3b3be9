"""The input of a run as a table that is read without knowing the project file: names of quantities, units, values."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from markupsafe import Markup

from assessment.report.text.language import Words, direction_name
from assessment.results.table import Row

Path = tuple[str, ...]
# keys whose values are words of the program; others are the user's own
CHOICES = {"accuracy", "sliding", "contacts", "model", "spectrum", "method", "record_demand", "language"}
CHOICES |= {"kind", "from_m", "component", "annexes"}
CHOICES |= {"state", "states", "of", "use_category", "directions", "integrator"}
GENERATED = re.compile(r"generate:(\d+)")
LOADS = ("vertical_load_kN", "variable_load_kN")


def echoed(echo: Mapping[str, Any], words: Words) -> Iterator[Row]:
    """Yield group, quantity and value of every setting that is not empty; a group is named in its first row."""
    last: Path | None = None
    for path, key, value in _flat(echo):
        if value in ("", []):
            continue
        yield {
            "table": _group(path, words) if path != last else Markup(""),
            "setting": _setting(path, key, words),
            "value": Markup.escape(_value(value, words, key in CHOICES or "hypotheses" in path)),
        }
        last = path


def _flat(value: Mapping[str, Any], path: Path = ()) -> Iterator[tuple[Path, str, Any]]:
    """Yield path of the table, key and value, the tables within after; arrays of tables are numbered from 1.

    Of a layer without loads the keys of loads are left out.
    """
    inner: list[tuple[Path, Mapping[str, Any]]] = []
    unloaded = not any(value.get(key) for key in LOADS)
    for key, item in value.items():
        if unloaded and key in (*LOADS, "load_has_mass"):
            continue
        if isinstance(item, Mapping):
            inner.append(((*path, key), item))
        elif isinstance(item, list) and any(isinstance(entry, Mapping) for entry in item):
            inner += [((*path, key, str(number)), entry) for number, entry in enumerate(item, 1)]
        else:
            yield path, key, item
    for name, item in inner:
        yield from _flat(item, name)


def _group(path: Path, words: Words) -> Markup:
    """Name a table: "Verifica, sito"; what the user named stays as it is, behind the kind of thing that it is."""
    first, *rest = path or ("project",)
    name = _name(first, words)
    for before, part in zip((first, *rest), rest, strict=False):
        plain = part.isdigit() or before == "layers"  # the second cedimento, the layer PIERS
        name += Markup(" ") + Markup.escape(part) if plain else Markup(", ") + _inner(_name(part, words))
    return name


def _inner(name: Markup) -> Markup:
    """Return a name as it is written behind a comma: "punto di controllo", but SLV."""
    return name[:1].lower() + name[1:] if name[1:2].islower() else name


def _setting(path: Path, key: str, words: Words) -> Markup:
    """Name a key: where it means something else in this table than in others, by table and key."""
    own = "_".join((*path[:1], key))
    return _name(own if own in words.strings["input"] else key, words)


def _name(key: str, words: Words) -> Markup:
    """Return the name of a key or of a table; of what has none, as a direction, the key."""
    return words(f"input.{key}") if key in words.strings["input"] else Markup.escape(direction_name(key))


def _value(value: Any, words: Words, choice: bool) -> str:
    """Write an input as it was given, in the words and with the decimal mark of the language."""
    if value is None:
        return words.plain("value.none")
    if value == "inf":
        return "∞"
    if isinstance(value, float) or type(value) is int:
        return words.comma(f"{value:.12g}").replace("inf", "∞").replace("-", "−")
    if isinstance(value, list):
        return "; ".join(_value(item, words, choice) for item in value)
    if isinstance(value, str) and choice:
        return words.name("setting", value, direction_name(value))
    if isinstance(value, str) and (count := GENERATED.fullmatch(value)):
        return words.plain("value.generate", number=count[1])
    return words.show(value)
