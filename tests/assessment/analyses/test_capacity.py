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

import numpy as np
import pytest

from assessment.analyses.capacity import _elastic_end, nominal_check
from assessment.ntc.capacity_curve import capacity_curve
from assessment.ntc.curve_fit import fit_rigid
from assessment.ntc.spectrum import ElasticSpectrum
from assessment.ntc.verification import Method, verify
from assessment.project.catalogue.geometry import rectangle
from assessment.project.catalogue.new_project import write_drawing
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.results.schema.static import ElasticPush
from assessment.results.table import brought_together
from assessment.workflow.stages import run
from tests.support.block_project import block
from tests.support.typed import made

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
[pushover]
contacts = ["rigid"]
directions = ["+x", "-x"]
increment_m = 0.1
"""
)


@pytest.fixture(scope="module")
def states(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tower")
    edges = np.linspace(0.0, H, N + 1)
    courses = [rectangle(-B / 2, B / 2, low, high) for low, high in pairwise(edges)]
    write_drawing(folder / "geometry.dxf", {"BASE": [rectangle(-1.0, 1.0, -0.3, 0.0)], "TOWER": courses})
    (folder / "project.toml").write_text(PROJECT, encoding="utf-8")
    project = load_project(folder)
    return run(project, build_model(project), jobs=1).results.states


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
    found = brought_together(nominal.pga_g, 0.6)
    assert found["dynamic_to_static"] == pytest.approx(1.265609, rel=2e-6)
    life = nominal_check(capacity, {"SLV": demands["SLV"]}, Method())
    assert life.pga_g == pytest.approx(0.383616, rel=2e-6)
    assert verify(capacity, demands)["SLV"].pga_g < life.pga_g
    assert brought_together(None, 0.6) == {"static_surface_pga_g": None, "dynamic_to_static": None}


def curve(last: float, lost: bool = False, reached_zero: bool = False):
    points = {"displacement_m": [0.0, -0.01, -0.02], "multiplier": [0.0, 0.1, last]}
    return made(ElasticPush, {"curve": points, "lost": lost, "reached_zero": reached_zero})


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
