"""Every word of the page, and every key of the project file, has its Italian: who adds a key adds it there."""

from __future__ import annotations

import re
import tomllib
from importlib.resources import files

from assessment.app.answers import page_words
from assessment.project.catalogue.new_project import TEMPLATES
from assessment.project.project import json_schema


def words(language):
    return tomllib.loads((files("templates") / f"app_{language}.toml").read_text(encoding="utf-8"))


def test_both_languages_have_the_same_words():
    it, en = words("it"), words("en")
    assert it["page"].keys() == en["page"].keys()
    assert [*it["templates"]] == [*en["templates"]] == [*TEMPLATES]
    for key, text in en["page"].items():
        assert [part.partition("}")[0] for part in text.split("{")[1:]] == [
            part.partition("}")[0] for part in it["page"][key].split("{")[1:]
        ]


def test_every_word_that_the_page_says_is_there():
    said = set()
    for script in (files("templates") / "app").iterdir():
        if script.name.endswith(".js"):
            said |= set(re.findall(r"\bw\(\"(\w+)\"", script.read_text(encoding="utf-8")))
    assert said - words("en")["page"].keys() == set()


def test_every_key_of_the_project_file_has_its_italian():
    keys, schema = words("it")["keys"], json_schema()
    tables = {"ProjectContent": schema, **schema["$defs"]}
    named = [(table, key) for table, each in tables.items() for key in each["properties"]]
    assert [pair for pair in named if ".".join(pair) not in keys and pair[1] not in keys] == []
    assert {key for key in keys if key.partition(".")[2]} <= {".".join(pair) for pair in named}
    assert all(isinstance(each, str) or (len(each) == 2 and all(each)) for each in keys.values())


def test_keys_are_called_as_in_the_report():
    italian, english = page_words("it")["keys"], page_words("en")["keys"]
    assert italian["depth_m"][0] == "Spessore fuori piano [m]"
    assert english["depth_m"][0] == "Out-of-plane depth [m]"
    assert italian["FloorTable.period_s"][0] == "Periodo T_1 [s]"
