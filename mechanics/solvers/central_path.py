"""The static program by a primal-dual interior-point method, begun near an earlier solution.

Two things make it quicker than a method for one program after another: it begins at the last solution of a path, a
little off the bounds, and it follows the geometry while it converges, so that a step, which takes PIQP four or five
programs of a score of iterations each, is one run of a score. The change of arms within an iteration is left out: with
it (Newton's method, from the start or near the end only) the paths of the triumphal arch took as many iterations and
led nowhere as often.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mechanics.block import Array
from mechanics.program import LARGEST_MULTIPLIER, Certificate, Neighbour, Program, Solution, certify
from mechanics.solvers import GOOD
from mechanics.solvers.band import Band
from mechanics.solvers.factor import Factor, blank
from mechanics.solvers.interior_step import Point, Rays, begin, corrected, linearised
from mechanics.solvers.kernels import certificate, fastest
from mechanics.solvers.threads import one_thread

HOLDING = 1e-9  # stiffness that holds blocks, per weight and step
HELD_BACK, FIRMER, FIRM, LET_GO = 1e-4, 10.0, 1.0, 0.3  # its growth where nothing gets better, and its fall
MOST_ITERATIONS = 100
TO_THE_BOUND = 0.995  # share of the way to the bounds that an iteration goes
STALLED = 3  # iterations without progress after which the blocks are held back more and more
IDLE = 8  # and after which the method ends
TO_AND_FRO = -0.3  # of a step: its return that asks for a shorter one
TINY = 1e-300
NEARLY = 1e-5  # unbalanced force, per weight, from which equilibrium is restored by itself
FOLLOWED = 1e-9  # certificate that ends the path, per block; its equilibrium is restored to rounding
RESTORATIONS = 2
FROZEN = 3e-4  # of the step: displacements that do not change the geometry


def follow(
    pose: Callable[[Array], Program], layout: Band, x: Array, near: Neighbour
) -> tuple[Array, Solution] | None:
    """Displacements (m,) at which the program posed there needs no further ones, and its certified solution.

    `pose` gives the program at displacements, counted from them, `layout` its band: every iteration, beginning at `x`,
    goes on in the geometry to which it has led. None where that leads to no
    certified solution.
    """
    with one_thread():
        return _follow(pose, layout, x, near)


def _follow(
    pose: Callable[[Array], Program], layout: Band, x: Array, near: Neighbour
) -> tuple[Array, Solution] | None:
    program = pose(x)
    rays = Rays.of(program.friction)
    at = begin(program, near, rays)
    accepted = FOLLOWED * len(x) / 3
    progress: list[float] = []
    holding = HOLDING
    last = np.zeros_like(x)
    for _ in range(MOST_ITERATIONS):
        quality = _quality(program, layout, at, rays.forces(at.s))
        worst = quality.worst(program.step)
        if (
            quality.equilibrium <= NEARLY
            and replace(quality, equilibrium=0.0).worst(program.step) <= accepted
        ):
            restored = _restored(program, layout, at, rays)
            quality = restored.certificate
            if quality.equilibrium <= GOOD and quality.worst(program.step) <= accepted:
                return x, restored
        product = float((at.s * at.z).mean())
        progress.append(worst * product)
        if _idle(progress, IDLE):
            return None
        if _idle(progress, STALLED):
            holding = min(FIRMER * max(holding, HELD_BACK), FIRM)
        else:
            holding = max(LET_GO * holding, HOLDING)
        change = linearised(program, layout, at, rays, holding)
        while change is None and holding < FIRM:  # near the bounds rounding may outweigh what holds
            holding *= FIRMER
            change = linearised(program, layout, at, rays, holding)
        if change is None or abs(at.alpha) > LARGEST_MULTIPLIER:
            return None
        step = corrected(change, at, product)
        force, gap = (min(1.0, TO_THE_BOUND * reach) for reach in (step.to_force, step.to_gap))
        # where the geometry of one iteration and the next send the blocks to and fro, they meet in between
        returns = float(step.dx @ last) / max(float(last @ last), TINY)
        if returns < TO_AND_FRO:
            gap /= 1.0 - max(returns, -1.0)
        last = gap * step.dx
        at = Point(
            at.x + gap * step.dx,
            at.alpha + force * step.dalpha,
            at.s + force * step.ds,
            at.z + gap * step.dz,
        )
        if float(abs(at.x).max()) > FROZEN * program.step:
            x = x + at.x[layout.back]
            program, at = pose(x), replace(at, x=np.zeros_like(at.x))
    return None


def _idle(progress: list[float], iterations: int) -> bool:
    """Whether the last iterations have not halved what is left."""
    return min(progress[-iterations:]) > 0.5 * min(progress[:-iterations], default=np.inf)


def _quality(program: Program, layout: Band, at: Point, forces: Array) -> Certificate:
    """The certificate of an iterate, by compiled loops."""
    load, work = program.load[layout.order], 0.0
    if program.lateral is not None:
        lateral = program.lateral[layout.order]
        load = load + at.alpha * lateral
        work = abs(float(lateral @ at.x) - program.work) / (program.weight * program.step)
    residuals = fastest().residuals(
        layout.row, program.normal, program.tangent, program.gap, program.friction, program.compliance,
        np.zeros_like(load), load, at.x, forces, program.size,
    )  # fmt: skip
    return certificate(residuals, program, work)


def _restored(program: Program, layout: Band, at: Point, rays: Rays) -> Solution:
    """The iterate with forces changed by the least shares of themselves that restore equilibrium."""
    kernels = fastest()
    rows = (layout.row, program.normal, program.tangent)
    s, alpha, order, m = at.s / program.weight, at.alpha, layout.order, len(program.load)
    matrix, free = blank(layout), np.zeros_like(program.gap)
    held = np.full(m, HOLDING)
    held[2::3] *= program.size**2
    kernels.interior_matrix(*rows, rays.components, free, held, s, 1.0 / s, np.empty((len(s), 3)), matrix)
    factor = Factor.of(matrix, layout)
    for _ in range(RESTORATIONS if factor else 0):
        assert factor is not None
        carried = (program.resultant(program.weight * rays.forces(s)) + program.load)[order] / program.weight
        if program.lateral is None:
            y = factor.solve(carried)
        else:
            lateral = program.lateral[order] / program.weight
            y, swayed = factor.solve(carried + alpha * lateral), factor.solve(lateral)
            change = -float(lateral @ y) / float(lateral @ swayed)
            alpha, y = alpha + change, y + change * swayed
        s = s * np.maximum(1.0 - s * rays.gaps(program.relative(y[layout.back])), 0.5)
    forces, displacement = program.weight * rays.forces(s), at.x[layout.back]
    return Solution(forces, alpha, displacement, certify(program, forces, alpha, displacement))
