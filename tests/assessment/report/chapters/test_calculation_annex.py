"""Every number of the annex, of whole projects: recomputed from what tables/trace.csv and the report print."""

import json

import ezdxf
import numpy as np
import pytest
from ezdxf.math import Matrix44

from assessment.analyses.capacity import assess, capacities, told
from assessment.analyses.chosen_mechanism import assess_chosen
from assessment.analyses.demand import demand_parts, demand_spectra
from assessment.cli.main import main
from assessment.ntc.hazard import RETURN_PERIODS
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.report.chapters.grids import traces, typeset
from assessment.report.language import Words, words_of
from assessment.report.tables.capacity import trace, verification
from assessment.results.schema import as_bytes
from assessment.results.summary import summary_of
from assessment.workflow.checking import read_motions
from tests.support.block_project import HAZARD, TURNED, block, outcome_of, results_of
from tests.support.trace_check import from_csv, from_report, printed, recomputed
from tests.support.typed import typed

PUSHED = """[pushover]
contacts = ["rigid", "elastic"]
increment_m = 0.05
control = {"+x" = "right", "-x" = "left"}
[report]
language = "en"
annexes = "full"
"""
PROJECT = block(stiffness="1e5") + TURNED + PUSHED
TYPED = f"""[assessment.site]
soil = "C"
topography = "T2"
{HAZARD}"""
SITE = '[assessment.site]\nsoil = "D"\nuse_class = "III"\ngrid = "site.csv"\n'
GRID = SITE.replace("site.csv", "grid.txt") + "latitude = 42.01\nlongitude = 13.02\n"
FLOOR = """[assessment.floor]
height_m = 7.0
building_height_m = 10.0
storeys = 3
period_s = 0.4
higher_periods_s = [0.13]
higher_participations = [-0.24]
"""
KNOWLEDGE = "[assessment.knowledge]\ngeometry = 0.05\nconstruction = 0.12\nmechanical = 0.06\nground = 0.03\n"
RECORD = (
    '[[history]]\nrecord = "wave.csv"\nwindow_s = [0.0, 0.02]\ncontacts = "rigid"\nstates = ["original"]\n'
)
MECHANISM = '[[mechanism]]\nname = "corner"\nabout_m = [0.3, 0.0]\nblocks = [1]\n'
VARIANTS = {
    "typed hazard, trilinear, local limit": "[assessment]\nlocal_displacement_limit_m = 0.15\n"
    'local_displacement_reason = "the beam unseats"\n' + TYPED + MECHANISM,
    "site table, bilinear": '[assessment]\nmodel = "bilinear"\n' + SITE,
    "grid, rigid, along the return period": '[assessment]\nmodel = "none"\nmethod = "grid"\n' + GRID,
    "floor": "[assessment]\n" + TYPED + FLOOR,
    "components of F_C": "[assessment]\nconfidence_factor = 1.26\n" + TYPED + KNOWLEDGE + MECHANISM,
    "level of knowledge": "[assessment]\nconfidence_factor = 1.2\n" + TYPED + '[assessment.knowledge]\nlevel = "LC2"\n',
    "2009": "[assessment]\ncircular = 2009\n" + TYPED,
    "floor, 2009": "[assessment]\ncircular = 2009\n" + TYPED + FLOOR.partition("higher")[0],
    "record": '[assessment]\nspectrum = "record"\n' + RECORD,
    "record, maximum, site": '[assessment]\nspectrum = "record"\nrecord_demand = "maximum"\n' + TYPED + RECORD,
}  # fmt: skip


def hazard_files(folder):
    """A site's nine lines, a grid of 3 × 3 nodes at 0.05° about (42, 13), a record of two pulses."""
    rows = [(T_R, 0.05 * (k + 1), 2.4 + 0.01 * k, 0.28 + 0.01 * k) for k, T_R in enumerate(RETURN_PERIODS)]
    lines = ["T_R;a_g [g];F0;T_C*", *(";".join(f"{v:.6g}" for v in row) for row in rows)]
    (folder / "site.csv").write_text("\n".join(lines))
    nodes = []
    for i in range(3):
        for j in range(3):
            values = [v for _, a, F, T in rows for v in (10.0 * a * (1.0 + 0.05 * i + 0.02 * j), F, T)]
            nodes.append("\t".join(f"{v:.6f}" for v in (13.0 + 0.067 * i, 42.0 + 0.05 * j, *values)))
    (folder / "grid.txt").write_text("% header\n" + "\n".join(nodes))
    t = np.arange(0.0, 8.0, 0.02)
    wave = 0.02 * np.sin(2.2 * t) * np.exp(-0.2 * t) + 0.3 * np.sin(9.0 * t) * np.exp(-0.5 * t)
    np.savetxt(folder / "wave.csv", np.column_stack([t, wave]), delimiter=",", header="s,g", comments="")


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory):
    """The results of every variant: both states, both directions. The pushovers are the same for all."""
    folder = tmp_path_factory.mktemp("annex") / "block"
    assert main(["new", str(folder), "--template", "block"]) == 0
    hazard_files(folder)
    (folder / "project.toml").write_text(PROJECT, encoding="utf-8")
    project = load_project(folder)
    pushed = outcome_of(project).results
    found = {}
    for name, text in VARIANTS.items():
        (folder / "project.toml").write_text(PROJECT + text, encoding="utf-8")
        found[name] = assessed(load_project(folder), pushed)
    return found


@pytest.fixture(scope="module")
def results(outcomes):
    """The same by type."""
    return {name: typed(content) for name, content in outcomes.items()}


def assessed(project, results):
    """Add to pushovers what the assessment of the project makes of them."""
    models, notes = build_model(project).states, []
    demands, states = demand_spectra(project, read_motions(project).history), {}
    for name, state in results.states.items():
        found = assess(project, models[name].assembly, state.pushover, demands)
        notes += told(found)
        curves = {way: each.value.curves for way, each in found.items() if each.value}
        capacity = capacities(found)
        states[name] = state.replace(pushover=state.pushover | curves, capacity=capacity)
    found = results.replace(
        echo=results.echo.replace(assessment=project.content().get("assessment")),
        states=states,
        quality=results.quality.replace(warnings=[*results.quality.warnings, *notes]),
        spectra=demand_parts(project, demands),
        mechanisms=assess_chosen(project, models, states, demands, notes),
    )
    return json.loads(as_bytes(found))


@pytest.mark.parametrize("name", VARIANTS)
def test_every_line_of_the_trace_table_follows_from_its_inputs(results, name):
    lines = trace(results[name]).rows
    parts = {(row["state"], row["direction"], row["part"]) for row in lines}
    checks = verification(results[name]).rows
    numbered = [row for row in checks if row["a_g_g"] is not None]
    assert len({(row["state"], row["direction"]) for row in numbered}) == 4
    assert {"SLD", "SLV linear", "SLV"} <= {row["limit_state"] for row in numbered}
    for row in numbered:
        assert (row["state"], row["direction"], row["limit_state"]) in parts
        assert (row["state"], row["direction"], "capacity") in parts
    computed = [row for row in lines if row["formula"]]
    assert len(computed) > 100
    for row in computed:
        value = recomputed(row["formula"], from_csv(row["inputs"]))
        assert value == pytest.approx(row["result"], rel=1e-9, abs=1e-12), row
        assert row["paragraph"]


@pytest.mark.parametrize("name", VARIANTS)
def test_every_line_of_the_printed_annex_follows_from_its_printed_inputs(results, name):
    computed = 0
    for grid in traces(results[name], words_of(results[name])):
        for _, formula, inputs, result, paragraph in (map(str, row) for row in grid.rows):
            assert paragraph
            if formula != "given":
                computed += 1
                pairs = (pair.rpartition(" = ") for pair in inputs.split("; ")) if inputs else ()
                values = {symbol: printed(value) for symbol, _, value in pairs}
                value = printed(result)
                assert from_report(formula, values) == pytest.approx(value, rel=1e-3, abs=1e-9), formula
    assert computed > 60


def test_a_short_annex_has_the_calculation_of_the_governing_check_alone(results):
    """Up to its ζ_E, in four digits; without the interpolation between the nodes of the grid."""
    whole = results["grid, rigid, along the return period"]
    summed = whole.replace(summary=summary_of(whole))
    least = summed.summary.governing
    short = summed.replace(echo=summed.echo.replace(report=summed.echo.report | {"annexes": "short"}))
    words = words_of(short)
    shown = list(traces(short, words))
    assert [str(grid.caption) for grid in shown][-1].startswith(f"Steps: {least.limit_state}")
    [zeta] = [row for row in shown[-1].rows if row[0] == "ζ<sub>E</sub>"]
    assert str(zeta[3]) == words.number(least.zeta_E, 4)
    assert not any("Allegato A, eq." in row[-1] for row in shown[0].rows)


@pytest.mark.parametrize(
    ("name", "source"),
    [
        ("floor", "Circolare 7/2019, C8.5.4"),
        ("components of F_C", "D.P.C.M. 9/2/2011, §4.2"),
        ("level of knowledge", "Circolare 7/2019, C8.5.4, LC2"),
    ],
)
def test_the_source_of_the_confidence_factor_is_what_it_follows_from(results, name, source):
    """Of each check and of a chosen mechanism; C8.5.4 was printed where 1 + Σ F_Ck of the D.P.C.M. gives it."""
    told = {row["paragraph"] for row in trace(results[name]).rows if row["symbol"] == "F_C"}
    assert told == {source}
    shown = {
        str(row[-1])
        for grid in traces(results[name], Words.of("en"))
        for row in grid.rows
        if row[0] == "F<sub>C</sub>"
    }
    assert shown == {source}


def test_the_demand_is_that_of_the_project(outcomes):
    """T_R of class III: V_R = 75 years; floor and record stand in the place of the ground's spectrum."""
    table = outcomes["site table, bilinear"]["spectra"]["SLV"]
    assert table["return_period_years"] == pytest.approx(711.842, rel=1e-5)
    assert table["pga_g"] == pytest.approx(table["S"] * table["a_g_g"]) and table["S"] > 1.0
    assert [outcomes[name]["spectra"]["SLC"]["kind"] for name in ("floor", "record", "2009")] == [
        "floor",
        "record",
        "ground",
    ]
    at_ground, at_height = (
        outcomes[name]["states"]["original"]["capacity"]["+x"] for name in ("2009", "floor, 2009")
    )
    assert at_height["SLD"]["a_g_g"] < at_ground["SLD"]["a_g_g"]
    whole, at_period = (
        outcomes[name]["states"]["original"]["capacity"]["+x"]["SLC"]
        for name in ("record, maximum, site", "record")
    )
    assert whole["a_g_g"] <= at_period["a_g_g"]
    assert whole["demand_a_g_g"] == pytest.approx(0.334 * 1.2 * (1.7 - 0.6 * 2.40 * 0.334))


def test_the_return_period_of_the_capacity_is_on_the_hazard_curve(results):
    """a_g of a whole column of the table gives its return period: here between two columns, log-log."""
    rows = verification(results["site table, bilinear"]).rows
    periods = np.log(RETURN_PERIODS)
    for row in rows:
        expected = np.exp(np.interp(np.log(row["a_g_g"]), np.log(0.05 * np.arange(1, 10)), periods))
        if 0.05 <= row["a_g_g"] <= 0.45:
            assert row["return_period_years"] == pytest.approx(expected)
        else:  # beyond the curve by the law of the demand's own return period
            assert not 30.0 < row["return_period_years"] < 2475.0


def test_zeta_does_not_know_the_unit_of_the_drawing(tmp_path):
    """The same block drawn in m and in mm: displacements, capacities and indices agree."""
    found = {}
    for unit, factor in (("m", 1.0), ("mm", 1000.0)):
        folder = tmp_path / unit
        assert main(["new", str(folder), "--template", "block"]) == 0
        drawing = ezdxf.readfile(folder / "geometry.dxf")
        for outline in drawing.modelspace():
            outline.transform(Matrix44.scale(factor))
        drawing.header["$INSUNITS"] = {"m": 6, "mm": 4}[unit]
        drawing.saveas(folder / "geometry.dxf")
        text = PROJECT.replace('unit = "m"', f'unit = "{unit}"').replace('["rigid", "elastic"]', '["rigid"]')
        (folder / "project.toml").write_text(
            text + '[assessment]\nmodel = "none"\n' + TYPED, encoding="utf-8"
        )
        project = load_project(folder)
        found[unit] = results_of(project)
    rows = [verification(typed(found[unit])).rows for unit in ("m", "mm")]
    assert len(rows[0]) == 16
    for one, other in zip(*rows, strict=True):
        numbers = [
            [row[key] or 0.0 for key in ("d_star_m", "a_star_g", "a_g_g", "zeta_E")] for row in (one, other)
        ]
        assert numbers[0] == pytest.approx(numbers[1], rel=1e-6)


ENGLISH, ITALIAN = Words.of("en"), Words.of("it")


@pytest.mark.parametrize(
    ("formula", "printed"),
    [
        ("a_0_star", "a<sub>0</sub>*"),
        ("T_C_star", "T<sub>C</sub>*"),
        ("a_0_star_v", "a<sub>0,v</sub>*"),
        ("Gamma_star", "Γ*"),
        ("IS_V", "IS-V"),
        ("Sigma_P_delta_2", "ΣPδ<sub>x</sub>²"),
        ("Sigma_P_delta**2/(Sigma_P*Sigma_P_delta_2)", "(ΣPδ<sub>x</sub>)<sup>2</sup>/(ΣP·ΣPδ<sub>x</sub>²)"),
        ("1.56*pi*sqrt(d/(a*g))", "1.56·π·√(d/(a·g))"),
        ("-T_SLV*log(1 - P_VR)/C_U", "−T<sub>SLV</sub>·ln(1 − P<sub>VR</sub>)/C<sub>U</sub>"),
        ("abs(gamma*psi)", "|γ·ψ|"),
        ("<b>*d_0", "&lt;b&gt;·d<sub>0</sub>"),
        (
            "T_R_demand*(PGA_capacity/PGA_demand)**(1/0.41)",
            "T<sub>R,D</sub>·(PGA<sub>C</sub>/PGA<sub>D</sub>)<sup>1/0.41</sup>",
        ),
        ("x**(2 - (1)**3)*y", "x<sup>2 − (1)<sup>3</sup></sup>·y"),
    ],
)
def test_signs_subscripts_and_superscripts(formula, printed):
    assert typeset(formula, ENGLISH) == printed


def test_decimal_comma_parts_arguments_by_a_semicolon():
    assert typeset("max(0.55, sqrt(10/(5 + 100*xi)))", ITALIAN) == "max(0,55; √(10/(5 + 100·ξ)))"
    assert typeset("1.1*T_C_star**(-0.2)", ITALIAN) == "1,1·T<sub>C</sub>*<sup>−0,2</sup>"
