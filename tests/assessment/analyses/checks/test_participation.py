"""e* and Γ* of a tower of dry courses, as drawn and after its base has moved, against closed forms.

The tower is B wide, H high, of n equal courses, and overturns as one about a toe. With the base turned by φ
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

from assessment.project.catalogue.geometry import rectangle
from assessment.project.catalogue.new_project import write_drawing
from assessment.project.project import load_project
from assessment.project.structure.model import build_model
from assessment.workflow.stages import run
from tests.support.block_project import block

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


def test_the_movement_shows_in_the_shape(states):
    """Leaning away from a push the tower stands lower over its toe, and its shape is less even."""
    drawn, turned = (states[name].pushover["+x"].rigid.mechanism for name in ("original", "turned"))
    assert turned.e_star < drawn.e_star - 1e-3
