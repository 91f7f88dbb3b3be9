"""What is said of project files that are wrong: the key, the file and the remedy."""

from pathlib import Path

import pytest

from assessment.project.model import build_model
from assessment.project.project import ProjectError, load_project
from tests.support.contract_project import CONTRACT, HAZARD, MINIMAL, load, message, write_named_files
from tests.support.rows import rows
from tests.support.surveyed_arch import CROWN, PIER, SPRINGING, entry, write_surveyed


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_named_files(tmp_path)


BEFORE_REPORT = "[report]"


MECHANISM = '[[mechanism]]\nname = "pier"\nabout_m = [0, 0]\n'


CAMPAIGN = '[campaign]\nrecords = "records/b.csv"\n'
FLOOR = "[assessment.floor]\nheight_m = 7.0\nbuilding_height_m = 10.0\nstoreys = 3\nperiod_s = 0.4\n"


TOLD = rows(r"""
# unknown keys, with the nearest
max_scale = 5.0 | max_scale = 5.0\nvertical_record = "a" | incremental.vertical_record | a key of [history]
depth_m = 0.10 | depth_m = 0.10\ndepht_m = 1 | geometry.depht_m | unknown key; did you mean "depth_m"?
depth_m = 0.10 | depth = 0.10 | geometry.depth | unknown key; did you mean "depth_m"?
depth_m = 5.5 | deep = 5.5 | layers.PIERS.deep | "depth_m"
directions | direction | pushover.direction | "directions"
confidence_factor | FC | assessment.FC | valid: "limit_states"
[pushover] | [pushdown] | pushdown | "pushover"
# missing keys
unit = "mm" |  | geometry.unit | missing; add it (unit of the drawing: mm, cm or m)
unit_weight_kN_m3 = 11.5 |  | material.unit_weight_kN_m3 | missing; add it (unit weight
records = ["records/*.acc"] |  | incremental.records | missing
# wrong types
depth_m = 0.10 | depth_m = "0,10" | geometry.depth_m | write a number, with a decimal point and without quotes: 0.10
depth_m = 0.10 | depth_m = "0.10" | geometry.depth_m | "0.10" is wrong; write a number, without quotes: 0.10
depth_m = 0.10 | depth_m = 0.10\nsegments_per_joint = 4.5 | geometry.segments_per_joint | a whole number
load_has_mass = true | load_has_mass = "yes" | layers.ROOF.load_has_mass | true or false
point_m = [1, 3] | point_m = 1 | control[2].point_m | 1 is wrong; write a list in brackets
[0.020, -0.020] | [0.020] | settlements[1].displacement_m | [0.02] is wrong; write two numbers
[15.0, 22.0] | "aria" | history[1].window_s | or "arias"
[pushover] | [[pushover]] | pushover | [pushover] with single brackets, once
["records/*.acc"] | "records/*.acc" | incremental.records | a list in brackets: ["records/*.acc"]
unit = "mm" | unit = "in" | geometry.unit | write "mm", "cm" or "m"
["+x", "-x"] | ["+x", "x"] | pushover.directions[2] | write "+x" or "-x"
["+x", "-x"] | [] | pushover.directions | write a list of 1 or more entries
[pushover] | [[region]]\nname = "r"\noutline_m = [[0, 0], [1, 0]]\n[pushover] | region[1].outline_m | 3 or more entries
"implicit-euler" | "newmark" | history[1].integrator | "second-order" or "implicit-euler"
spectrum = "ntc" | spectrum = "ec8" | assessment.spectrum | "ntc" or "record"
soil = "B" | soil = "S1" | assessment.site.soil | "A", "B", "C", "D" or "E"
model = "trilinear" | knowledge = {level = "LC2"} | assessment.confidence_factor | makes 1.2; write 1.2
model = "trilinear" | knowledge = {} | assessment.knowledge | write level, or geometry
# numbers out of range
depth_m = 0.10 | depth_m = 0 | geometry.depth_m | 0 is wrong; write a number greater than 0
depth_m = 0.10 | depth_m = 0.10\nsegments_per_joint = 0 | geometry.segments_per_joint | not less than 1
= 11.5 | = nan | material.unit_weight_kN_m3 | a finite number
friction = 0.6 | friction = -0.1 | material.friction | not less than 0
friction = 0.6 | friction = -inf | material.friction | -inf is wrong; write a number not less than 0
= 11.5 | = 1e-300 | material.unit_weight_kN_m3 | a number not less than 0.001
depth_m = 0.10 | depth_m = 0.10\nsagitta_m = 1e-12 | geometry.sagitta_m | not less than 1e-07
increment_m = 0.001\nto | increment_m = 0.0\nto | settlements[1].increment_m | greater than 0
time_step_s = 0.005 | time_step_s = 0 | history[1].time_step_s | greater than 0
time_step_s = 0.005 | damping_ratio = 0.5 | history[1].damping_ratio | not greater than 0.3
[incremental] | [campaign]\nrecords = "a"\nperiod_s = 350\n[incremental] | campaign.period_s | not greater than 10
tolerance_g = 0.01 | tolerance_g = 0 | incremental.tolerance_g | greater than 0
confidence_factor = 1.35 | confidence_factor = 0.9 | assessment.confidence_factor | not less than 1
nominal_life_years = 50 | nominal_life_years = 0 | assessment.site.nominal_life_years | not less than 1
# texts
name = "C2" | name = "" | control[2].name | not empty
name = "C2" | name = "C2 " | control[2].name | blanks at its ends
support = "right"\n[layers.ROOF] | support = "a\tb"\n[layers.ROOF] | layers.BASE_RIGHT.support | control
# files
"geometry.dxf" | "geometri.dxf" | geometry.drawing | did you mean "geometry.dxf"?
"records/aqv_ns.acc" | "records/aqv_n.acc" | history[1].record | mean "records/aqv_ns.acc"?
"records/aqv_up.acc" | "nowhere/a.acc" | history[1].vertical_record | folder; put it there or correct the name
["records/*.acc"] | ["generate:7"] | incremental.records[1] | no file "generate:7"
["records/*.acc"] | ["records/b.csv", "records/*.AT2"] | incremental.records[2] | no file "records/*.AT2"
"allegato_b.txt" | "allegato.txt" | assessment.site.grid | did you mean "allegato_b.txt"?
# names
support = "right"\ndis | support = "rigth"\ndis | settlements[1].support | did you mean "right"?
name = "C2" | name = "C1" | control[2].name | "C1" is the name of an earlier entry
name = "right support 20 mm" | name = "original" | settlements[1].name | write another name
"C1"\n\n[[history]] | {"-x" = "top"}\n[[history]] | pushover.control.-x | valid: "C1", "C2"
max_scale = 5.0 | control = "D1" | incremental.control | "C1"
max_scale = 5.0 | states = ["orginal"] | incremental.states[1] | "original"
# what does not fit together
[0.020, -0.020] | [0, 0.0] | settlements[1].displacement_m | nothing moves
[0.020, -0.020] | [0, 5e-324] | settlements[1].displacement_m | 4.94066e-324 m (or rad) moves nothing
[0.020, -0.020] | [1e-7, 0]\nsteps = 2 | settlements[1].displacement_m | in steps, 5e-08 m (or rad)
increment_m = 0.001\nto | increment_m = 0.05\nto | settlements[1].increment_m | write 0.02 or less
increment_m = 0.001\nto | increment_m = 1e-7\nto | settlements[1].increment_m | 200000 increments
rotation_rad = 0.0\n | increment_rad = 1e-7\nrotation_rad = 0.1\n | settlements[1].increment_rad | 1000000 increments
scale = 1.0 | scale = 0 | history[1].scale | 0 leaves no motion
[15.0, 22.0] | [22.0, 15.0] | history[1].window_s | 0 ≤ first < last
max_scale = 5.0 | window_s = [-1, 5] | incremental.window_s | 0 ≤ first < last
vertical_load_kN = 9.1 | vertical_load_kN = -9.1 | layers.ROOF.vertical_load_kN | load_has_mass = false
[layers.PIERS] | [contacts]\nsliding = "colomb"\n[layers.PIERS] | contacts.sliding | "coulomb" or "associative"
"implicit-euler" | "moreaux-jean" | history[1].integrator | "moreau-jean"
normal_stiffness_kN_m3 = 1.2e5 |  | material.normal_stiffness_kN_m3 | add it, in kN/m³
["rigid", "elastic"] | ["rigid"] | pushover.contacts | write ["rigid", "elastic"]
["rigid", "elastic"] | ["elastic"] | pushover.contacts | rigid missing
longitude = 13.40 |  | assessment.site.longitude | latitude and longitude go together
latitude = 42.35 |  | assessment.site.latitude | go together
spectrum = "ntc" | spectrum = "record"\nmethod = "nearest" | assessment.method | "demand-shape" or "grid"
vertical_load_kN = 9.1 | psi_2 = 0.3 | layers.ROOF.psi_2 | there is no variable load
vertical_load_kN = 9.1 | variable_load_kN = 2 | layers.ROOF.variable_load_kN | add use_category
vertical_load_kN = 9.1 | variable_load_kN = 2\nuse_category = "I" | layers.ROOF.use_category | add psi_2
vertical_load_kN = 9.1 | variable_load_kN = 2\nuse_category = "A"\npsi_2 = 0.5 | layers.ROOF.psi_2 | "A" has 0.3
model = "trilinear" | knowledge = {geometry = 0.05} | assessment.knowledge | construction, mechanical, ground missing
["+x", "-x"] | ["+x", "+x"] | pushover.directions | an entry appears twice
""")

# old text, new text, key, what the message must hold
WRONG = [
    *TOLD,
    (
        "friction = 0.6", "tangential_stiffness_kN_m3 = 1e300", "material.tangential_stiffness_kN_m3",
        "1e+300 is more than 1e+11; write inf for a joint that is rigid in shear",
    ),
    ("= 1.2e5", f"= {'[' * 90}{']' * 90}", "material.normal_stiffness_kN_m3", '[[["…"]]] is wrong; write a number'),
    ("= 1.2e5", f"= 0x{'f' * 5000}", "material.normal_stiffness_kN_m3", "some 6021 digits"),
    ("[layers.ROOF]", '[layers."ROOF\\n"]', 'layers."ROOF\\n"', "control characters"),
    (
        'model = "trilinear"', "knowledge = {geometry = 0.04, construction = 0, mechanical = 0, ground = 0}",
        "assessment.knowledge.geometry", "0.04 is none of 0.05, 0",
    ),
    (BEFORE_REPORT, '[campaign]\nrecords = ["generate:7", "records/b.csv"]\n', "campaign.records", "stands alone"),
    (BEFORE_REPORT, CAMPAIGN + "period_s = 0.5\n", "campaign.period_s", "the PGA has no period"),
    (BEFORE_REPORT, CAMPAIGN + "levels_g = [0.1]\n", "campaign.levels_g", "finds its own levels"),
    (BEFORE_REPORT, MECHANISM, "mechanism[1]", "no block is chosen"),
    (
        BEFORE_REPORT, MECHANISM + "region_m = [[0, 0], [1, 1]]\n", "mechanism[1].region_m",
        "write one flat list: [x1, z1, x2, z2, …]",
    ),
    (BEFORE_REPORT, MECHANISM + "region_m = [0, 0]\n", "mechanism[1].region_m", "no corners"),
    (
        BEFORE_REPORT, f"{MECHANISM}blocks = [1]\n{MECHANISM}blocks = [2]\nstate = \"right support 20 mm\"\n",
        "mechanism[2].state", "macro-blocks in another state",
    ),
    (BEFORE_REPORT, MECHANISM + "blocks = [1]\nrotation = 0\n", "mechanism[1].rotation", "does not move"),
    (BEFORE_REPORT, MECHANISM + 'blocks = [1]\nstate = "settled"\n', "mechanism[1].state", '"original"'),
    (
        'spectrum = "ntc"',
        'spectrum = "ntc"\ncircular = 2009\nfloor = {height_m = 1, building_height_m = 2, storeys = 1, period_s = 0.2, '
        "higher_periods_s = [0.1], higher_participations = [0.2]}",
        "assessment.floor.higher_periods_s",
        "first mode alone",
    ),
    (BEFORE_REPORT, FLOOR.replace("7.0", "12.0"), "assessment.floor.height_m", "above building_height_m"),
    (
        BEFORE_REPORT, FLOOR.replace("10.0", "41.0").replace("period_s = 0.4\n", ""), "assessment.floor.period_s",
        "holds up to a building_height_m of 40",
    ),
    ('spectrum = "ntc"', f'spectrum = "record"\n{FLOOR}', "assessment.floor", "taken as that of the ground"),
    (BEFORE_REPORT, FLOOR + "higher_periods_s = [0.1]\n", "assessment.floor.higher_participations", "one γ_k"),
    ('soil = "B"', f'soil = "B"\nSLV = {HAZARD}', "assessment.site", "keep one of the two"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "key", "said"), WRONG, ids=[f"{w[2]}: {w[3]}" for w in WRONG])
def test_a_wrong_key_is_named_with_its_file_and_remedy(folder, old, new, key, said):
    assert old in CONTRACT
    first, *_ = message(folder, CONTRACT.replace(old, new + old * (old == BEFORE_REPORT), 1)).splitlines()
    assert first.startswith(f"project.toml: {key}: ")
    assert said in first


def test_a_key_that_is_spelt_otherwise_is_not_missing_too(folder):
    assert message(folder, CONTRACT.replace("depth_m = 0.10", "depth = 0.10")).count("\n") == 0


CONTROL = '[[control]]\nname = "C"\npoint_m = [0, 0]\n'


SETTLEMENT = '[[settlements]]\nname = "down"\nsupport = "right"\ndisplacement_m = [0, -0.1]\n'


SITE = 'latitude = 42.35\nlongitude = 13.40\ngrid = "allegato_b.txt"\n'


@pytest.mark.parametrize(
    ("text", "key", "said"),
    [
        (MINIMAL + '[assessment]\nmodel = "none"\nspectrum = "record"\n', "assessment", "add [pushover]"),
        (CONTRACT.replace(SITE, ""), "assessment.site", "add latitude and longitude"),
        (
            CONTRACT.replace(SITE, "".join(f"{s} = {HAZARD}\n" for s in ("SLD", "SLV", "SLC"))).replace(
                'spectrum = "ntc"', 'method = "grid"'
            ),
            "assessment.method",
            "there is no grid",
        ),
        (CONTRACT.replace("[[history]]", "[[unused]]").split("[[unused]]")[0] + '[assessment]\nspectrum = "record"\n',
         "assessment.spectrum", "add [[history]]"),
        (MINIMAL + CONTROL + '[[history]]\nrecord = "records/b.csv"\n', "material.normal_stiffness_kN_m3",
         "history[1].contacts"),
        (
            MINIMAL.replace("[material]", "[material]\ncompressive_strength_kN_m2 = 900.0")
            + CONTROL
            + '[[history]]\nrecord = "records/b.csv"\ncontacts = "rigid"\n',
            "history[1].contacts",
            "compressive_strength_kN_m2",
        ),
        (MINIMAL + '[layers.R]\nsupport = "right"\n' + SETTLEMENT + "steps = 2\n", "settlements[1].steps",
         "add [pushover]"),
        (MINIMAL + "[sensitivity]\nfriction = [0.8, 1.2]\n", "sensitivity", "there is no capacity to vary"),
        (MINIMAL + entry("pier", "lean", PIER, 1.0), "measurement",
         "nothing uses the measurements; add [identification]"),
        (CONTRACT.replace("[assessment.site]\n" + SITE, "[unused]\n").partition("[unused]")[0], "assessment.site",
         "add [assessment.site]"),
        (CONTRACT + "[sensitivity]\n", "sensitivity", "write low and high factors of friction, stiffness"),
        (CONTRACT + "[sensitivity]\ndepth = [1.2, 0.8]\n", "sensitivity.depth",
         "[1.2, 0.8] is no range; write the low factor, then the high one"),
        (CONTRACT + '[sensitivity]\ndepth = [0.8, 1.2]\nstates = ["right"]\n', "sensitivity.states[1]",
         'no state "right"; valid: "original", "right support 20 mm"'),
        (CONTRACT.replace("trilinear", "none") + "[sensitivity]\nstiffness = [0.5, 2]\n", "sensitivity.stiffness",
         "uses no stiffness"),
    ],
)  # fmt: skip
def test_tables_that_need_each_other(folder, text, key, said):
    first, *_ = message(folder, text).splitlines()
    assert first.startswith(f"project.toml: {key}: ") and said in first


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("title = Arch\n", "line 1, column 9"), ('title = "A"\n[geometry]\ndepth_m = 0,10\n', "line 3"),
        ('title = "A"\ntitle = "B"', "line 2, column"), ('title = "A', "line 1, column 11"),
        ("[geometry]\n[geometry]\n", "line 2, column"), (f"title = {'1' * 5000}", "line 1"),
        ('title = "C:\\quiet"', "line 1, column"),
    ],
)  # fmt: skip
def test_syntax_errors_are_placed(folder, text, place):
    said = message(folder, text)
    assert said.startswith(f"project.toml: {place}") and "\n" not in said
    assert ("write a decimal point" if "0,10" in text else "texts stand in quotes") in said


def test_the_project_s_place(folder, tmp_path, monkeypatch):
    load(folder, MINIMAL)
    assert load_project(folder / "project.toml") == load_project(str(folder)) == load_project(folder)
    monkeypatch.chdir(folder)
    assert load_project(Path()).folder == folder
    with pytest.raises(ProjectError, match=r"nowhere: project: no such folder; give the folder"):
        load_project(tmp_path / "nowhere")
    with pytest.raises(ProjectError, match=r"geometry.dxf: project: a file; give the folder that holds"):
        load_project(folder / "geometry.dxf")
    with pytest.raises(ProjectError, match=r"records: project: holds no project.toml or project.xlsx"):
        load_project(folder / "records")
    (folder / "project.xlsx").touch()
    with pytest.raises(ProjectError, match=r"holds project.toml and project.xlsx; keep one of them"):
        load_project(folder)
    with pytest.raises(ProjectError, match="project: File name too long"):
        load_project("x" * 5000)


GOOD = '[{ destro = ["x"] }]'
CRACK, LEAN, SPAN = (
    entry("crown", "crack", CROWN, 2.0),
    entry("pier", "lean", PIER, 1.0),
    entry("span", "span", SPRINGING, 9.0),
)


def said(folder, hypotheses, *entries):
    with pytest.raises(ProjectError) as error:
        build_model(load_project(write_surveyed(folder, hypotheses, *entries)))
    return str(error.value)


@pytest.mark.parametrize(
    ("hypotheses", "entries", "expected"),
    [
        ('[{ dstro = ["x"] }]', [CRACK], 'identification.hypotheses[1].dstro: no support "dstro"'),
        (f"{GOOD[:-1]}, {GOOD[1:]}", [CRACK], "identification.hypotheses[2]: the same as an earlier hypothesis"),
        ('[{ destro = ["x", "z"] }]', [CRACK], "identification.hypotheses[1]: 2 unknowns from 1 measurements"),
        (GOOD, [], "identification: there is nothing to explain; add [[measurement]]"),
        (GOOD, [CRACK.replace('"crack"', '"crak"')], 'measurement[1].kind: "crak" is wrong; write "crack"'),
        (GOOD, [CRACK.replace("sigma_mm = 0.2", "")], "measurement[1].sigma_mm: missing; a measurement of kind"),
        (GOOD, [CRACK.replace("2.0", "-2.0")], "measurement[1].opening_mm: -2 is negative"),
        (GOOD, [LEAN.replace("sigma_mrad", "sigma_mm")], 'measurement[1].sigma_mm: does not go with kind = "lean"'),
        (GOOD, [SPAN.replace("[-0.27, 0.5]", "[0.28, 0.5]")], "measurement.span.from_m: in the same block as point_m"),
        (GOOD, [SPAN.replace("[0.27, 0.5]", "[0.0, 0.5]", 1)], "span.point_m: [0.0, 0.5] must be in or on a block"),
        (GOOD, [entry("air", "crack", (0.0, 0.5), 1.0)], "measurement.air.point_m: [0.0, 0.5] is at no joint"),
    ],
)  # fmt: skip
def test_one_message_for_each_slip(tmp_path, hypotheses, entries, expected):
    found = said(tmp_path, hypotheses, *entries)
    assert expected in found and len(found.splitlines()) <= 2
