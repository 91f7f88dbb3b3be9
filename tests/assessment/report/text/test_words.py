"""Words of the Italian report: those of the trade, one for each thing, in the examples as in the texts."""

import tomllib
from importlib.resources import files
from pathlib import Path

import pytest

from assessment.project.catalogue.new_project import TEMPLATES as CATALOGUE
from assessment.project.catalogue.new_project import made
from assessment.report.text.language import Words

TEMPLATES = files("templates")
PROJECTS = Path(__file__).parents[4] / "projects"
TEXT = (
    "".join(
        (TEMPLATES / name).read_text(encoding="utf-8").lower()
        for name in ("messages_it.toml", "validation.toml")
    )
    + repr(Words.of("it").strings).lower()
)
ENGLISH = {"left", "right", "support", "settled", "crown", "original", "turned", "down", "outward"}


@pytest.mark.parametrize(
    "word",
    [
        "stato di progetto",  # the design state: "stato con cedimento"
        "movimento di progetto",  # "cedimento assegnato"
        "progettista",  # of a new building: "tecnico incaricato"
        "calcolatrice",
        "tascabile",
        "metterebbe in moto",
        "non hanno fine",
        "profondità",  # "spessore"
        "perdita locale",  # "incompatibilità locale"
        "a grandezza naturale",  # "spostamenti non amplificati"
    ],
)
def test_words_that_an_italian_report_does_not_have(word):
    assert word not in TEXT


@pytest.mark.parametrize(
    "word",
    [
        "stato con cedimento",
        "cedimento assegnato",
        "tecnico incaricato",
        "su suolo rigido (cat. a), senza s",
        "condizione determinante",
        "di domanda",
        "incompatibilità locale",
        "spostamenti non amplificati",
        "spessore",
    ],
)
def test_words_that_it_has(word):
    assert word in TEXT


def names_of(project):
    """The names of supports, states and mechanisms of a project file."""
    layers = (layer.get("support", "") for layer in project.get("layers", {}).values())
    tables = (entry["name"] for key in ("settlements", "mechanism") for entry in project.get(key, []))
    return " ".join([project["title"], *layers, *tables]).lower().split()


def english_names(project):
    assert project["report"]["language"] == "it"
    return ENGLISH & set(names_of(project))


@pytest.mark.parametrize("path", sorted(PROJECTS.glob("*/project.toml")), ids=lambda path: path.parent.name)
def test_italian_examples_have_italian_names(path):
    assert not english_names(tomllib.loads(path.read_text(encoding="utf-8")))


@pytest.mark.parametrize("name", CATALOGUE)
def test_italian_templates_have_italian_names(name):
    _, content = made(name, {})
    assert not english_names(content)
