"""Capacities of a state: on one reference, ended by the elastic curve, and e* and Γ* of a tower by closed forms.

The tower is B wide, H high, of n equal dry courses, and overturns as one about a toe. With the base turned by φ
(anticlockwise) the course at the height z lies s = z cos φ + c sin φ above the toe it turns about, c = −B/2 for a
push towards +x, B/2 towards −x, and moves horizontally in proportion to s. Over equal weights, with the mean of s,
m = (H/2) cos φ + c sin φ, and its variance v = (H cos φ)² (n² − 1)/(12 n²) (Circolare 7/2019, C8.7.1.2):

    e* = (Σδ)²/(n Σδ²) = m²/(m² + v),   Γ* = Σδ²/(δ_C Σδ) = (m² + v)/(m s_C),

3/4 and 2/3 for φ = 0 and many courses. A translation of the base changes neither. α0 = tan(arctan(B/H) ± φ).
"""

from itertools import pairwise
from math import atan, cos, sin, tan
from pathlib import Path

import numpy as np
import pytest

from assessment.analyses import capacity
from assessment.analyses.capacity import _apart, _elastic_end, assess, nominal_check, told
from assessment.analyses.demand import Demands
from assessment.ntc.capacity_curve import capacity_curve, fit_rigid
from assessment.ntc.spectrum import ElasticSpectrum
from assessment.ntc.verification import Method, verify
from assessment.project.catalogue.geometry import rectangle
from assessment.project.catalogue.new_project import write_drawing
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.results.schema import ElasticPush, plain, static
from tests.support.analysed import analysed, arch
from tests.support.block_project import ASSESSMENT, PUSHED, block, outcome_of, read_results, run, write_block
from tests.support.typed import made, typed
from tests.support.wording import in_italian

B, H, N = 0.6, 3.0, 6
PHI = 0.05
MOVED = {"original": 0.0, "turned": PHI, "moved": 0.0}
PROJECT = (
    block().replace("4.2]", f"{H}]")
    + f"""[[settlements]]
name = "turned"
support = "base"
rotation_rad = {PHI}
increment_rad = 0.01
[[settlements]]
name = "moved"
support = "base"
displacement_m = [0.1, -0.15]
increment_m = 0.05
{PUSHED.replace('"+x"', '"+x", "-x"').replace("0.2", "0.1")}"""
)


@pytest.fixture(scope="module")
def states(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tower")
    edges = np.linspace(0.0, H, N + 1)
    courses = [rectangle(-B / 2, low, B / 2, high) for low, high in pairwise(edges)]
    write_drawing(folder / "geometry.dxf", {"BASE": [rectangle(-1.0, -0.3, 1.0, 0.0)], "TOWER": courses})
    (folder / "project.toml").write_text(PROJECT, encoding="utf-8")
    project = load_project(folder)
    return outcome_of(project).results.states


@pytest.mark.parametrize("direction", ["+x", "-x"])
@pytest.mark.parametrize("state", MOVED)
def test_the_shape_is_that_of_the_state_as_it_stands(states, state, direction):
    """The control point, the upper right corner, lies over the right toe and B beside the left one."""
    phi, c, beside = MOVED[state], -B / 2 if direction == "+x" else B / 2, 0.0 if direction == "+x" else B
    mean = H / 2 * cos(phi) + c * sin(phi)
    variance = (H * cos(phi)) ** 2 * (N**2 - 1) / (12 * N**2)
    control = H * cos(phi) + beside * sin(phi)
    found = states[state].pushover[direction].rigid
    lean = phi if direction == "+x" else -phi
    assert found.alpha_0 == pytest.approx(tan(atan(B / H) + lean), rel=1e-6)
    assert found.mechanism.e_star == pytest.approx(mean**2 / (mean**2 + variance), rel=1e-6)
    assert found.mechanism.gamma_star == pytest.approx((mean**2 + variance) / (mean * control), rel=1e-6)


def test_static_capacity_is_brought_to_the_reference_of_the_dynamic_one():
    """Block of α0 = 1/7, d_0* = 0.3 m on a ridge (S = 1.2): with F_C = 1 the PGA of SLC is 0.474080 g at the surface.

    A dynamic PGA at collapse of 0.6 g is 0.6/0.474080 = 1.265609 times that, not 0.6/0.395067 of a_g on rock.
    At SLV, T = 1.994 s < T_D, F_C = 1 gives 0.383616 g at the surface.
    """
    d = np.linspace(0.0, 0.6, 21)
    capacity = capacity_curve(fit_rigid((d, (1.0 - d / 0.6) / 7.0)), 1.0, 0.5, 1.35)
    demands = dict.fromkeys(("SLV", "SLC"), ElasticSpectrum(0.25, 2.4, 0.30, "A", "T2"))
    nominal = nominal_check(capacity, demands, Method())
    assert nominal.limit_state == "SLC"
    assert nominal.pga_g == pytest.approx(0.474080, rel=2e-6)
    shaken = {"records": [], "fragility": {"pga_collapse_g": 0.6}}
    capacities = {"+x": {"nominal": plain(nominal)}, "-x": {}}
    state = {"pushover": {"+x": {}, "-x": {}}, "incremental": shaken}
    settled = state | {"capacity": capacities}
    *_, found, without = typed({"states": {"original": state, "settled": settled}}).summary.rows
    assert found.dynamic_to_static == pytest.approx(1.265609, rel=2e-6)
    assert found.static_nominal_pga_g == nominal.pga_g
    life = nominal_check(capacity, {"SLV": demands["SLV"]}, Method())
    assert life.pga_g == pytest.approx(0.383616, rel=2e-6)
    assert verify(capacity, demands)["SLV"].pga_g < life.pga_g
    assert without.static_nominal_pga_g is without.dynamic_to_static is None


def curve(last: float, lost: bool = False, reached_zero: bool = False):
    points = {"displacement_m": [0.0, -0.01, -0.02], "multiplier": [0.0, 0.1, last]}
    return made(ElasticPush, {"curve": points, "alpha_u": 0.1, "lost": lost, "reached_zero": reached_zero})


@pytest.mark.parametrize(
    ("elastic", "end"),
    [
        (curve(0.02), None),  # cut below a quarter of the peak, on purpose
        (curve(0.02, lost=True), 0.02),
        (curve(0.0, reached_zero=True), 0.02),
        (curve(0.05, lost=True), 0.02),
        (curve(0.05), 0.02),  # undecided: no equilibrium is known beyond it
        (None, None),
    ],
)
def test_an_elastic_curve_limits_where_nothing_is_known_beyond_it(elastic, end):
    assert _elastic_end(elastic) == end


pytestmark = pytest.mark.usefixtures("no_figures")


@pytest.fixture(scope="module")
def capacities(tmp_path_factory):
    """What the assessment makes of the small arch pushed towards +x, its curves changed by a function."""
    folder: Path = arch(tmp_path_factory.mktemp("refused") / "arch")
    project = load_project(folder)
    model, demands = build_model(project).assembly, Demands()

    def of(change):
        pushovers = dict(typed(analysed()).states["original"].pushover)
        pushovers["+x"] = change(pushovers["+x"])
        found = assess(project, model, pushovers, demands)
        return capacity.capacities(found), told(found)

    return of


@pytest.mark.parametrize(("share", "refused"), [(0.9, False), (1.1, True)])
def test_a_mechanism_that_virtual_work_contradicts_has_no_capacity(capacities, share, refused):
    def contradict(curves):
        alpha = (1.0 + share * 0.5) * curves.rigid.mechanism.alpha
        return curves.replace(rigid=curves.rigid.replace(virtual_work_alpha=alpha))

    found, warnings = capacities(contradict)
    assert ("+x" in found) is not refused
    assert "-x" in found
    assert (
        any("+x: no capacity: virtual work on the mechanism gives α" in text for text in warnings) is refused
    )


def rocking(curves):
    """Its mechanism with every second block turned back."""
    moved = np.array(curves.rigid.mechanism.displacements)
    moved[::2] *= -1.0
    return curves.rigid.mechanism.replace(displacements=moved.tolist(), e_star=None, gamma_star=None)


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        (lambda _: {"virtual_work_alpha": None}, "virtual work on the mechanism gives α = inf"),
        (
            lambda curves: {"onset": rocking(curves), "alpha_onset": 0.1},
            "the first mechanism, at α = 0.1: e*, Γ*: ",
        ),
    ],
)
def test_a_mechanism_on_which_the_load_does_no_work_or_a_first_one_that_rocks_has_no_capacity(
    capacities, changed, says
):
    """Virtual work is infinite, or 0/0: null in the results. Linear checks are of the first: it has no a_0*."""
    found, warnings = capacities(lambda curves: curves.replace(rigid=curves.rigid.replace(**changed(curves))))
    assert "+x" not in found and "-x" in found
    assert any(f"+x: no capacity: {says}" in text for text in warnings)


def test_a_first_mechanism_that_rocks_by_the_other_law_leaves_that_law_out(capacities):
    def other(curves):
        law = static.OtherLaw(sliding="associative", alpha_0=0.2, mechanism=curves.rigid.mechanism)
        law = law.replace(alpha_onset=0.1, onset=rocking(curves))
        return curves.replace(rigid=curves.rigid.replace(other_law=law))

    found, _ = capacities(other)
    assert found["+x"].other_law is None


@pytest.mark.parametrize(("other", "said"), [(0.985, 0), (1.015, 0), (0.975, 1), (1.025, 1)])
def test_ratios_by_two_laws_are_told_apart_from_two_per_cent_on(other, said):
    assert len(_apart({"SLV": 1.0, "SLC": 1.0}, {"SLV": other})) == said


def test_an_elastic_pushover_that_failed_is_not_asked_for_again(capacities):
    found, warnings = capacities(lambda curves: curves.replace(elastic=None))
    assert "+x" not in found and "-x" in found
    [said] = [text for text in warnings if text.startswith("+x: no capacity")]
    assert "was asked for and gave no curve" in said and "ask for contacts" not in said
    assert "è stato richiesto" in in_italian(said)


@pytest.mark.parametrize("height", [4.2, 0.02])
def test_the_capacity_is_that_of_the_blocks_whatever_point_is_followed(height, tmp_path):
    """A panel turns about its toe: d* = ΣPδu/ΣPδ = 2.1 sin θ + 0.3 (1 − cos θ), which its centroid goes.

    A point at its other face, z high, goes by z sin θ + 0.6 (1 − cos θ), and Γ* = 2.1/z times that told up to forty
    times the way: from 0.02 m the panel bore several times the acceleration, or was refused, by a threshold of 80 %.
    """
    text = block().replace("point_m = [0.3, 4.2]", f"point_m = [-0.3, {height}]")
    folder = write_block(tmp_path, text + PUSHED.replace("0.2\n", "0.01\n") + ASSESSMENT)
    run(folder)
    state = read_results(folder / "output")["states"]["original"]
    rigid, capacity = state["pushover"]["+x"]["rigid"], state["capacity"]["+x"]
    lean = np.arctan(0.6 / 4.2)
    own = 2.1 * np.sin(lean) + 0.3 * (1.0 - np.cos(lean))
    assert rigid["d_0_m"] == pytest.approx(height * np.sin(lean) + 0.6 * (1.0 - np.cos(lean)), rel=1e-4)
    assert rigid["d_star_m"][-1] == pytest.approx(own, rel=1e-4)
    assert capacity["d_0_star_m"] == pytest.approx(own, rel=1e-4)
    assert capacity["gamma_star"] == pytest.approx(2.1 / height, rel=1e-4)
    assert capacity["SLV"]["d_star_m"] == pytest.approx(0.4 * own, rel=1e-4)


def test_the_elastic_curve_is_over_the_way_of_the_blocks_too(tmp_path):
    """Followed at the foot of the other face or at the top: the same capacity, T_0 and end of the elastic branch."""
    found = []
    for height in (4.2, 0.3):
        text = block().replace("point_m = [0.3, 4.2]", f"point_m = [-0.3, {height}]")
        pushed = PUSHED.replace('"rigid"', '"rigid", "elastic"').replace("0.2\n", f"{0.004 * height}\n")
        folder = write_block(
            tmp_path / str(height), text + pushed + ASSESSMENT.replace('"none"', '"trilinear"')
        )
        run(folder)
        found.append(read_results(folder / "output")["states"]["original"]["capacity"]["+x"])
    top, foot = found
    assert foot["SLV"]["a_g_g"] == pytest.approx(top["SLV"]["a_g_g"], rel=1e-3)
    assert foot["d_0_star_m"] == pytest.approx(top["d_0_star_m"], rel=1e-4)
