"""Newton's method for steps of elastic joints: forces and stiffness of a joint, and the interior point's solution."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanics.kernels.bed import points, points_stored
from mechanics.kernels.dynamics import newton as loops
from mechanics.kernels.joint import H
from mechanics.kernels.law import BED, DILATION, FRICTION, LAW, LEFT, SEGMENTS, SHEAR, STRENGTH, bed_forces
from mechanics.program import certify
from mechanics.solvers import interior, solve
from tests.support.reference_loops import bed_of_points
from tests.support.steps import euler_step, shaken
from tests.support.structures import arch_on_piers, running_bond

HALF = 0.3
KINDS = {"exact": {}, "points": {SEGMENTS: 5.0}, "crushing": {STRENGTH: 30.0}}


@settings(max_examples=30)
@given(u=st.floats(-1e-3, 5e-4), phi=st.floats(-4e-3, 4e-3), segments=st.integers(1, 20))
def test_a_bed_of_points_is_its_springs(u, phi, segments):
    n, m, *_ = points(u, phi, HALF, 1e5, segments)
    found = points_stored(u, phi, HALF, 1e5, segments), n, m
    assert found == pytest.approx(bed_of_points(u, phi, HALF, 1e5, segments), rel=1e-9, abs=1e-9)


@settings(max_examples=30)
@given(
    kind=st.sampled_from(sorted(KINDS)),
    motion=st.tuples(st.floats(-8e-4, -2e-4), st.floats(-6e-4, 6e-4), st.floats(-1e-4, 1e-4)),
    sign=st.sampled_from([-1.0, 1.0]),
    shear=st.sampled_from([0.0, 1e-6]),
    psi=st.sampled_from([0.0, 0.5, 1.0]),
)
def test_stiffness_of_a_joint_that_slides_is_how_its_forces_change(kind, motion, sign, shear, psi):
    """−∂(N, P, T)/∂(u, φ, v), with the slide's lift; and the law of the slide holds."""
    law = np.zeros(LAW)
    law[FRICTION], law[DILATION], law[BED], law[STRENGTH], law[SHEAR] = 0.7, psi, 1e5, np.inf, shear
    for column, value in KINDS[kind].items():
        law[column] = value
    u, phi, v = motion

    def found(*moved: float) -> np.ndarray:
        s = np.zeros(loops.KNOWN)
        loops._slide(law, HALF, *moved, sign, s)
        return s

    s = found(u, phi, v)
    n, m, t, slip = s[[loops.N, loops.P, loops.T, loops.SLIP]]
    assert t == pytest.approx(-sign * 0.7 * n)
    assert slip == pytest.approx(v + shear * t, abs=1e-15)
    under = bed_forces(law, law[STRENGTH], law[LEFT:], HALF, u - psi * 0.7 * sign * slip, phi)
    assert (n, m) == pytest.approx(under[:2], rel=1e-10, abs=1e-10)
    if kind == "points":
        return  # its stiffness jumps where a point opens
    entries = [
        (loops.DUU, loops.DUP, loops.DUV),
        (loops.DUP, loops.DPP, loops.DPV),
        (loops.DVU, loops.DVP, loops.DVV),
    ]
    full = s[np.array(entries)]
    step, forces = 1e-9, [loops.N, loops.P, loops.T]
    for column in range(3):
        by = step * np.eye(3)[column]
        change = (found(*(motion + by))[forces] - found(*(motion - by))[forces]) / (2.0 * step)
        assert -change == pytest.approx(full[:, column], rel=1e-3, abs=1e-3 * 2.0 * HALF * law[BED])


@pytest.mark.parametrize("acceleration", [0.05, 0.6])
@pytest.mark.parametrize("bed", ["exact", "points", "on springs in shear"])
@pytest.mark.parametrize("psi", [0.0, 1.0])
@pytest.mark.parametrize("model", [running_bond(3, 4, stiffness=1e6), arch_on_piers(voussoirs=7, courses=3)])
def test_where_it_converges_it_finds_the_solution_of_the_interior_point(model, bed, acceleration, psi):
    """Begun with the joints that slide there, it converges."""
    program, layout = euler_step(model, "elastic", shaken(model, 1), acceleration)
    law = program.law.copy()
    law[:, DILATION] = psi
    law[:, SEGMENTS] = 4.0 if bed == "points" else 0.0
    law[:, SHEAR] = 1e-6 if bed == "on springs in shear" else 0.0
    program = replace(program, law=law)
    solution, iterate = solve(program, layout)
    assert iterate is not None and program.mass is not None
    x, f, y = solution.displacement[layout.order], iterate.forces.copy(), iterate.gaps.copy()
    _, force, _ = loops.newton(interior.ordered(program, layout), x, x, f, y, 1e-7)
    assert force <= 1e-7
    moved = x[layout.back]
    forces = np.column_stack([f[:, 0] + f[:, 1], program.places[:, H] * (f[:, 1] - f[:, 0]), f[:, 2]])
    assert certify(program, forces, 0.0, moved).worst(program.step) < 1e-6
    assert moved == pytest.approx(solution.displacement, abs=1e-5 * program.step)
