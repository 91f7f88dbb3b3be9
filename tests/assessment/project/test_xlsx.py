"""The spreadsheet form of the project file: the same content, and messages that name sheet and cell."""

import math
import tempfile
import tomllib
from io import BytesIO
from pathlib import Path
from zipfile import ZipFile

import pytest
from hypothesis import Phase, example, given, settings
from openpyxl import load_workbook

from assessment.project.project import ProjectError, load_project
from assessment.project.schema import ProjectContent
from assessment.project.toml import commented_toml
from assessment.project.xlsx import ACTIVE, read_xlsx, to_xlsx
from tests.support.project_strategy import project_contents

HAZARD = {"ag_g": 0.26, "F0": 2.4, "Tc_star_s": 0.35}
CONTENT = {
    "title": "Arch; settled",
    "geometry": {"drawing": "geometry.dxf", "unit": "mm", "depth_m": 0.1},
    "material": {"unit_weight_kN_m3": 11.5, "friction": 0.6, "normal_stiffness_kN_m3": 1.2e5},
    "layers": {"0": {"depth_m": 5.5}, "BASE": {"support": "right"}, "ROOF": {}},
    "control": [{"name": "C1", "point_m": [0.0, 3.2]}, {"name": "C2", "point_m": [1, 3]}],
    "settlements": [{"name": "down", "support": "right", "displacement_m": [0.02, -0.02]}],
    "pushover": {"contacts": ["rigid", "elastic"], "control": {"+x": "C1", "-x": "C2"}},
    "history": [{"record": "a.acc", "window_s": "arias"}, {"record": "a.acc", "window_s": [1.5, 3]}],
    "incremental": {"records": ["*.acc", '"b"; c.acc'], "max_scale": 2},
    "assessment": {"circular": 2009, "site": {"soil": "B", "SLD": HAZARD, "SLV": HAZARD, "SLC": HAZARD}},
    "report": {"client": "=not a formula", "location": "C:\\temp"},
}


FILES = ["geometry.dxf", "a.acc", '"b"; c.acc']


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in FILES:
        (tmp_path / name).touch()
    return tmp_path


BOOK = to_xlsx(CONTENT)


def changed(folder: Path, *cells: tuple[str, str, object]):
    """The project of CONTENT with some cells of its spreadsheet overwritten."""
    file = folder / "project.xlsx"
    file.write_bytes(BOOK)
    book = load_workbook(file)
    for sheet, cell, value in cells:
        book[sheet][cell] = value
    book.save(file)
    return load_project(folder)


def test_a_workbook_whose_part_has_another_name(folder):
    """As some programs write it: the part is found by its content type."""
    with ZipFile(BytesIO(BOOK)) as book, ZipFile(folder / "project.xlsx", "w") as other:
        for name in book.namelist():
            own = book.read(name).replace(b"workbook.xml", b"workbook22.xml")
            other.writestr(name.replace("workbook.xml", "workbook22.xml"), own)
    assert load_project(folder).title == CONTENT["title"]


def message(folder: Path, *cells: tuple[str, str, object]) -> str:
    with pytest.raises(ProjectError) as caught:
        changed(folder, *cells)
    return str(caught.value)


def test_a_sheet_explains_its_keys(folder):
    for language, heads, meaning in (
        ("en", ["key", "value", "comment"], "out-of-plane depth, m"),
        ("it", ["chiave", "valore", "nota"], "spessore fuori piano"),
    ):
        (folder / "project.xlsx").write_bytes(to_xlsx(CONTENT | {"report": {"language": language}}))
        sheet = load_workbook(folder / "project.xlsx")["geometry"]
        assert [cell.value for cell in sheet[1]] == heads
        assert meaning in sheet["C4"].value
        assert load_project(folder).report.language == language


def test_every_table_has_a_sheet_and_those_out_of_use_say_no(folder):
    assert changed(folder).campaign is None
    book = load_workbook(folder / "project.xlsx")
    assert set(ProjectContent.model_fields) - set(book.sheetnames) <= {"title", "accuracy", "scatter"}
    last = book["campaign"].max_row
    assert [cell.value for cell in book["campaign"][last]][:2] == ["active", "no"]
    assert [row[0].value for row in book["floor"].iter_rows()].count("height_m") == 1
    used = changed(folder, ("campaign", f"B{last}", "sì"), ("campaign", "B2", "a.acc"))
    assert used.campaign.records == ("a.acc",)
    last = book["incremental"].max_row
    assert changed(folder, ("incremental", f"B{last}", "no")).incremental is None, "what is typed there stays"
    last = book["assessment"].max_row
    assert changed(folder, ("assessment", f"B{last}", "no")).assessment is None, "and its site with it"


def test_all_faults_are_told_in_one_pass(folder):
    said = message(
        folder, ("geometry", "B3", "ft"), ("geometry", "A4", None), ("material", "B2", "heavy"),
        ("material", "B3", "=1/2"), ("layers", "A3", "ROOF"), ("control", "B2", "1"),
    ).splitlines()  # fmt: skip
    for place in (
        "geometry.unit",
        "cell B4: has no key",
        "material.unit_weight_kN_m3",
        "formula",
        "twice",
        "control[1]",
    ):
        assert sum(place in line for line in said) == 1, place


def test_lists_and_decimal_commas(folder):
    project = changed(
        folder, ("settlements", "C2", "0,020; -0,035"), ("geometry", "B4", "0,25"),
        ("pushover", "B2", "elastic ;rigid;"), ("incremental", "B2", "a.acc\n*.acc"),
        ("material", "A5", "tangential_stiffness_kN_m3"), ("material", "B5", "inf"),
    )  # fmt: skip
    assert project.settlements[0].displacement_m == (0.02, -0.035)
    assert project.geometry.depth_m == 0.25
    assert project.pushover.contacts == ("elastic", "rigid")
    assert project.incremental.records == ("a.acc", "*.acc")
    assert project.material.tangential_stiffness_kN_m3 == math.inf


@pytest.mark.parametrize(
    "text", ["0.02; -0.035", "0,02; -0,035", "0.02, -0.035", "0,02 -0,035", "[0.02, -0.035]"]
)
def test_numbers_of_a_list_are_told_apart_however_they_are_written(folder, text):
    assert changed(folder, ("settlements", "C2", text)).settlements[0].displacement_m == (0.02, -0.035)


def test_cells_are_read_as_their_keys_ask(folder):
    project = changed(
        folder, ("layers", "A2", 0), ("project", "B2", 1854), ("geometry", "A5", "segments_per_joint"),
        ("geometry", "B5", "2"), ("assessment", "B2", 2019.0), ("settlements", "D1", "to_collapse"),
        ("settlements", "D2", "TRUE"), ("incremental", "B2", "a.acc"),
    )  # fmt: skip
    assert "0" in project.layers and project.title == "1854"
    assert project.geometry.segments_per_joint == 2 and project.assessment.circular == 2019
    assert project.settlements[0].to_collapse is True


def test_blank_rows_comments_and_a_blank_sheet_are_no_content(folder):
    (folder / "project.xlsx").write_bytes(to_xlsx(CONTENT))
    before = load_project(folder).content()
    book = load_workbook(folder / "project.xlsx")
    book.create_sheet("Sheet1")
    book["geometry"].insert_rows(3, 2)
    book["material"].insert_rows(1, 2)
    book["geometry"]["C3"] = "a comment"
    book["settlements"].insert_rows(2)
    book["settlements"]["A9"] = "  "
    book.save(folder / "project.xlsx")
    assert load_project(folder).content() == before
    book.create_sheet("pushovr")
    book.save(folder / "project.xlsx")
    with pytest.raises(ProjectError, match='sheet "pushovr": unknown sheet; did you mean "pushover"'):
        load_project(folder)


@pytest.mark.parametrize(
    ("sheet", "cell", "value", "key", "said"),
    [
        ("geometry", "B3", "ft", "geometry.unit", '"ft" is wrong; write "mm", "cm" or "m"'),
        ("report", "A2", "clint", "report.clint", 'unknown key; did you mean "client"?'),
        ("settlements", "B2", "rigth", "settlements[1].support", 'no support "rigth"; did you mean "right"?'),
        ("settlements", "C2", "0;x", "settlements[1].displacement_m[2]", '"x" is wrong; write a number'),
        ("layers", "I2", 0, "layers.0.depth_m", "0 is wrong; write a number greater than 0"),
        ("pushover", "B3", '{"+x" = "C7"}', "pushover.control.+x", 'no control point "C7"; did you mean'),
        ("site", "B2", "S", "assessment.site.soil", '"S" is wrong; write "A", "B"'),
        ("incremental", "B2", "a.acc; *.AT2", "incremental.records[2]", 'no file "*.AT2"'),
    ],
)
def test_messages_name_sheet_and_cell(folder, sheet, cell, value, key, said):
    first, *_ = message(folder, (sheet, cell, value)).splitlines()
    place = cell.replace("A2", "B2")  # of the value where the key is wrong
    assert first.startswith(f'project.xlsx: {key} (sheet "{sheet}", cell {place}): {said}')


# Any valid project ------------------------------------------------------------------------------------


@settings(max_examples=5, phases=[Phase.explicit, Phase.generate])
@given(project_contents())
@example(CONTENT)
def test_any_project_survives_toml_to_xlsx_to_toml(content):
    first = ProjectContent.model_validate(tomllib.loads(commented_toml(content)))
    said = first.model_dump(mode="json", exclude_none=True, exclude_unset=True)
    with tempfile.TemporaryDirectory() as name:
        file = Path(name) / "project.xlsx"
        file.write_bytes(to_xlsx(said))
        sheets, _, _ = read_xlsx(file)
    second = ProjectContent.model_validate(tomllib.loads(commented_toml(sheets)))
    assert second.model_dump() == first.model_dump() == ProjectContent.model_validate(content).model_dump()


@pytest.mark.parametrize("sheet", ["pushover", "assessment"])
def test_a_sheet_that_is_neither_in_use_nor_left_out_is_told(folder, sheet):
    (folder / "project.xlsx").write_bytes(to_xlsx(CONTENT))
    book = load_workbook(folder / "project.xlsx")
    [cell] = [row[1] for row in book[sheet].iter_rows() if row[0].value == ACTIVE]
    cell.value = "forse"
    book.save(folder / "project.xlsx")
    with pytest.raises(
        ProjectError, match=f'sheet "{sheet}", row "active": \'forse\' is neither sì nor no; write one'
    ):
        load_project(folder)
