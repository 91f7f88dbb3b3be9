"""The static program by a primal-dual interior-point method on matrices in a band or in fronts.

Two things make it quicker than a method for one program after another: it can begin at the last solution of a path, a
little off the bounds, and it can follow the geometry while it converges, so that a step, which takes PIQP four or five
programs of a score of iterations each, is one run of a score. The change of arms within an iteration is left out: with
it (Newton's method, from the start or near the end only) the paths of the triumphal arch took as many iterations and
led nowhere as often.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mechanics.block import Array
from mechanics.program import LARGEST_MULTIPLIER, Neighbour, Program, Solution, certify
from mechanics.solvers import GOOD
from mechanics.solvers import compiled_interior_step as loops
from mechanics.solvers.compiled_interior_step import HOLDING, Posed
from mechanics.solvers.elimination import Elimination
from mechanics.solvers.kernels import Residuals
from mechanics.solvers.threads import one_thread

LET_GO = 0.3  # of the stiffness that holds blocks in the last iteration
DISTANCE = 0.03  # from the bounds, per weight and step, at which the method begins
NOWHERE = 3.0  # the same where no solution is near, per root of the number of blocks
MOST_ITERATIONS = 100
STALLED = 6  # iterations without progress after which the geometry is followed no longer
IDLE = 8  # and after which the method ends
NEARLY = 1e-5  # unbalanced force, per weight, from which equilibrium is restored by itself
PER_BLOCK, MOST = 1e-12, 1e-9  # certificate that ends the path; its equilibrium is restored to rounding
FROZEN = 3e-4  # of the step: displacements that do not change the geometry


def solve(
    program: Program, layout: Elimination, near: Neighbour | None = None, start: Array | None = None
) -> Solution | None:
    """The certified solution of a static program, sought `near` that of another where there is one; None: not found.

    `layout`: of its matrices; `start` (m,): displacements to begin at.
    """
    found = _run(program, layout, near, start, None)
    return None if found is None else found[1]


def follow(
    pose: Callable[[Array], Program], layout: Elimination, near: Neighbour
) -> tuple[Array, Solution] | None:
    """Displacements (m,) and the certified solution of the program posed there; None where nothing is found.

    `pose` gives the program at displacements, counted from them: every iteration, beginning at none, goes on in the
    geometry to which it has led, from the solution of a program `near` this one. The solution's displacements vanish
    but where that leads no further: the rest of the way is gone in one geometry.
    """
    return _run(pose(np.zeros(len(layout.order))), layout, near, None, pose)


def load() -> None:
    """Load the compiled loops: a process that has solved nothing takes half a second for it."""
    one = np.ones(1)
    block = Program(
        dof=np.array([[-1, -1, -1, 0, 1, 2]]), normal=np.eye(6)[None, 4], tangent=np.eye(6)[None, 3],
        gap=np.zeros((1, 2)), friction=one, compliance=np.zeros((1, 2)), load=np.array([0.0, -1.0, 0.0]),
        lateral=None, work=0.0, mass=None, weight=1.0, size=1.0, step=1.0,
    )  # fmt: skip
    solve(block, Elimination.of(block.dof))


@dataclass(eq=False)
class _Iterate:
    """Displacements (m,) in the order of elimination, multiplier, forces (c, 2) kN and gaps (c, 2) m along the rays.

    `last`: the last step in x.
    """

    x: Array
    alpha: float
    s: Array
    z: Array
    last: Array


@one_thread()
def _run(
    program: Program,
    layout: Elimination,
    near: Neighbour | None,
    start: Array | None,
    pose: Callable[[Array], Program] | None,
) -> tuple[Array, Solution] | None:
    x = np.zeros(len(program.load))
    at = _begin(program, near)
    if start is not None:
        at.x[:] = start[layout.order]
    stored = layout.matrix()
    lateral = np.zeros(0) if program.lateral is None else program.lateral[layout.order]
    scale = program.weight, program.size, program.step
    accepted = min(PER_BLOCK * len(x) / 3, MOST)
    progress: list[float] = []
    holding = HOLDING
    for _ in range(MOST_ITERATIONS):
        posed, load = _posed(program, layout), program.load[layout.order]
        if len(lateral):
            load += at.alpha * lateral
        residuals, lack = loops.measured(posed, load, at.x, at.s, at.z, program.size)
        missing = float(lateral @ at.x) - program.work if len(lateral) else 0.0
        unbalanced, products, lacking = _shares(residuals, program, missing)
        if unbalanced <= NEARLY and max(products, lacking) <= accepted:
            restored = _restored(program, layout, at, posed, lateral, stored)
            quality = restored.certificate
            if quality.equilibrium <= GOOD and quality.worst(program.step) <= accepted:
                return x, restored
        progress.append(max(unbalanced, lacking, NEARLY) * residuals[3])
        if _idle(progress, IDLE):
            return None
        if pose is not None and _idle(progress, STALLED):
            pose = None
            progress.clear()
        holding = max(LET_GO * holding, HOLDING)
        led, at.alpha, holding = loops.advance(
            posed, lack, lateral, program.work, scale, holding, at.x, at.alpha, at.s, at.z, at.last, stored,
            layout.packed,
        )  # fmt: skip
        if not led or abs(at.alpha) > LARGEST_MULTIPLIER:
            return None
        if pose is not None and float(abs(at.x).max()) > FROZEN * program.step:
            x = x + at.x[layout.back]
            at.x[:] = 0.0
            program = pose(x)
    return None


def _begin(program: Program, near: Neighbour | None) -> _Iterate:
    """The earlier solution, moved off the bounds; without one, all contacts bear and open alike."""
    still, weight, step = np.zeros(len(program.load)), program.weight, program.step
    if near is None:
        everywhere = np.full_like(program.gap, NOWHERE * np.sqrt(len(still) / 3))
        return _Iterate(still, 0.0, weight * everywhere, step * everywhere, still.copy())
    n = 1.0 / np.hypot(1.0, program.friction)
    t = program.friction * n
    half_n = 0.5 * near.forces[:, 0] / n
    half_t = np.divide(0.5 * near.forces[:, 1], t, out=np.zeros_like(half_n), where=t > 0.0)
    s = np.stack([half_n + half_t, half_n - half_t], axis=1)
    along, across = n * near.opening[:, 0], t * near.opening[:, 1]
    z = np.stack([along + across, along - across], axis=1)
    s, z = np.maximum(s, DISTANCE * weight), np.maximum(z, DISTANCE * step)
    return _Iterate(still, near.alpha, s, z, still.copy())


def _posed(program: Program, layout: Elimination) -> Posed:
    p = program
    return layout.row, p.normal, p.tangent, p.gap, p.friction, p.compliance, layout.runs


def _shares(residuals: Residuals, program: Program, missing: float) -> tuple[float, float, float]:
    """The certificate of an iterate, whose forces lie within the cones, as Certificate.worst counts it.

    What is unbalanced, what forces and gaps do on each other, and the worst of penetration and of `missing` work, kNm.
    """
    unbalanced, power, penetration, _ = residuals
    weight, step = program.weight, program.step
    lacking = max(penetration / step / 100.0, abs(missing) / (weight * step))
    return unbalanced / weight, power / (weight * step) / 100.0, lacking


def _restored(
    program: Program,
    layout: Elimination,
    at: _Iterate,
    posed: Posed,
    lateral: Array,
    stored: Array,
) -> Solution:
    """The iterate with forces changed by the least shares of themselves that restore equilibrium."""
    s, scale = at.s.copy(), (program.weight, program.size, program.step)
    load = program.load[layout.order]
    alpha = loops.restore(posed, load, lateral, scale, s, at.alpha, stored, layout.packed)
    n = 1.0 / np.hypot(1.0, program.friction)
    forces = np.stack([n * (s[:, 0] + s[:, 1]), program.friction * n * (s[:, 0] - s[:, 1])], axis=1)
    displacement = at.x[layout.back]
    return Solution(forces, alpha, displacement, certify(program, forces, alpha, displacement))


def _idle(progress: list[float], iterations: int) -> bool:
    """Whether the last iterations have not halved what is left."""
    return min(progress[-iterations:]) > 0.5 * min(progress[:-iterations], default=np.inf)
