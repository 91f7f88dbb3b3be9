"""The static program by a primal-dual interior-point method on banded matrices, begun near an earlier solution.

The unknowns are Δx, α, the forces s ≥ 0 along the rays of the friction cones and their gaps z ≥ 0; s and z are
eliminated, which leaves three rows a block in a narrow band, bordered by α. Proximal terms, whose centre is the
iterate itself, bound the stiffness of closed contacts and hold blocks that nothing holds, without a trace in the
solution. Two things make it quicker than a method for one program after another: it begins at the last solution of a
path, a little off the bounds, and it follows the geometry while it converges, so that a step, which takes PIQP four
or five programs of a score of iterations each, is one run of a score.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import lapack

from mechanics.block import Array
from mechanics.program import LARGEST_MULTIPLIER, Certificate, Neighbour, Program, Solution, certify
from mechanics.solvers import GOOD
from mechanics.solvers.band import Band
from mechanics.solvers.kernels import fastest
from mechanics.solvers.threads import one_thread

STIFFEST = 1e8  # of closed contacts, per weight and step
HOLDING = 1e-9  # stiffness that holds blocks, per weight and step
FIRMEST = 1.0  # and where the geometry makes them flap between its contacts
MOST_ITERATIONS = 100
TO_THE_BOUND = 0.995  # share of the way to the bounds that an iteration goes
OUTLIERS = 0.1, 10.0  # products s z outside this range about their target are corrected once
STALLED = 3  # iterations without progress after which the blocks are held back more and more
IDLE = 8  # and after which the method ends
TO_AND_FRO = -0.3  # of a step: its return that asks for a shorter one
TINY = 1e-300
NEARLY = 1e-5  # unbalanced force, per weight, from which equilibrium is restored by itself
FOLLOWED = 1e-9  # certificate that ends the path, per block; its equilibrium is restored to rounding
RESTORATIONS = 2
FROZEN = 3e-4  # of the step: displacements that do not change the geometry
DISTANCE = 0.03  # from the bounds, per weight and step, at which the method begins


@dataclass(frozen=True, eq=False)
class Point:
    """An iterate: displacements (m,) in the order of the band, multiplier, ray forces (c, 2) kN, ray gaps (c, 2) m."""

    x: Array
    alpha: float
    s: Array
    z: Array


@dataclass(frozen=True, eq=False)
class Direction:
    """A change of all unknowns, and how far it can be gone in the forces (with α) and in the gaps (with x)."""

    dx: Array
    dalpha: float
    ds: Array
    dz: Array
    to_force: float
    to_gap: float

    def products(self, at: Point, force: float, gap: float) -> Array:
        """The products s z (c, 2) after a step."""
        ahead: Array = (at.s + force * self.ds) * (at.z + gap * self.dz)
        return ahead


def follow(
    pose: Callable[[Array], Program], layout: Band, x: Array, near: Neighbour, farthest: float
) -> tuple[Array, Solution] | None:
    """Displacements (m,) at which the program posed there needs no further ones, and its certified solution.

    `pose` gives the program at displacements, counted from them, `layout` its band: every iteration, beginning at `x`,
    goes on in the geometry to which it has led. None where that leads to no certified solution nearer than
    `farthest` (m).
    """
    with one_thread():
        return _follow(pose, layout, x, near, farthest)


def _follow(
    pose: Callable[[Array], Program], layout: Band, x: Array, near: Neighbour, farthest: float
) -> tuple[Array, Solution] | None:
    program = pose(x)
    rays = Rays.of(program.friction)
    at = _begin(program, near, rays)
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
        if min(progress[-IDLE:]) > 0.5 * min(progress[:-IDLE], default=np.inf):
            return None
        if min(progress[-STALLED:]) > 0.5 * min(progress[:-STALLED], default=np.inf):
            holding = min(10.0 * max(holding, 1e-4 * FIRMEST), FIRMEST)
        else:
            holding = max(0.3 * holding, HOLDING)
        change = _newton(program, layout, at, rays, holding)
        if change is None or abs(at.alpha) > LARGEST_MULTIPLIER:
            return None
        step = _corrected(change, at, product)
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
            if float(abs(x).max()) > farthest:
                return None
            program, at = pose(x), replace(at, x=np.zeros_like(at.x))
    return None


def _quality(program: Program, layout: Band, at: Point, forces: Array) -> Certificate:
    """The certificate of an iterate, by compiled loops."""
    load, work = program.load[layout.order], 0.0
    if program.lateral is not None:
        lateral = program.lateral[layout.order]
        load = load + at.alpha * lateral
        work = abs(float(lateral @ at.x) - program.work) / (program.weight * program.step)
    unbalanced, cone, power, penetration = fastest().residuals(
        layout.row, program.normal, program.tangent, program.gap, program.friction, program.compliance,
        np.zeros_like(load), load, at.x, forces, program.size,
    )  # fmt: skip
    return Certificate(
        unbalanced / program.weight,
        cone / program.weight,
        power / (program.weight * program.step),
        penetration,
        work,
    )


def _restored(program: Program, layout: Band, at: Point, rays: Rays) -> Solution:
    """The iterate with forces changed by the least shares of themselves that restore equilibrium."""
    kernels = fastest()
    rows = (layout.row, program.normal, program.tangent)
    s, alpha, order, m = at.s / program.weight, at.alpha, layout.order, len(program.load)
    matrix, free = np.zeros((m, layout.width)), np.zeros_like(program.gap)
    held = np.full(m, HOLDING)
    held[2::3] *= program.size**2
    kernels.interior_matrix(*rows, rays.components, free, held, s, 1.0 / s, np.empty((len(s), 3)), matrix)
    factor, failed = lapack.dpbtrf(matrix.T, lower=1, overwrite_ab=1)
    for _ in range(0 if failed else RESTORATIONS):
        load = program.load if program.lateral is None else program.load + alpha * program.lateral
        missing = (program.resultant(program.weight * rays.forces(s)) + load)[order] / program.weight
        y = lapack.dpbtrs(factor, missing, lower=1)[0]
        if program.lateral is not None:
            lateral = program.lateral[order] / program.weight
            swayed = lapack.dpbtrs(factor, lateral, lower=1)[0]
            change = -float(lateral @ y) / float(lateral @ swayed)
            alpha, y = alpha + change, y + change * swayed
        s = s * np.maximum(1.0 - s * rays.gaps(program.relative(y[layout.back])), 0.5)
    forces, displacement = program.weight * rays.forces(s), at.x[layout.back]
    return Solution(forces, alpha, displacement, certify(program, forces, alpha, displacement))


@dataclass(frozen=True, eq=False)
class Rays:
    """Normal and tangential components `n`, `t` (c, 1) of the unit rays (1, ±μ) that span the friction cones."""

    n: Array
    t: Array

    @classmethod
    def of(cls, friction: Array) -> Rays:
        """The rays of contact points of a friction (c,)."""
        n = 1.0 / np.hypot(1.0, friction)[:, None]
        return cls(n, friction[:, None] * n)

    @property
    def components(self) -> Array:
        """Both components side by side (c, 2)."""
        return np.concatenate([self.n, self.t], axis=1)

    def forces(self, s: Array) -> Array:
        """Contact forces (c, 2) of forces (c, 2) along the rays."""
        return np.concatenate([self.n * (s[:, :1] + s[:, 1:]), self.t * (s[:, :1] - s[:, 1:])], axis=1)

    def along(self, forces: Array) -> Array:
        """The forces (c, 2) along the rays that make contact forces."""
        half_n = 0.5 * forces[:, :1] / self.n
        half_t = np.divide(0.5 * forces[:, 1:], self.t, out=np.zeros_like(half_n), where=self.t > 0.0)
        return np.concatenate([half_n + half_t, half_n - half_t], axis=1)

    def gaps(self, opening: Array) -> Array:
        """Gaps (c, 2) along the rays of gaps and slips."""
        across = self.t * opening[:, 1:]
        return np.concatenate([self.n * opening[:, :1] + across, self.n * opening[:, :1] - across], axis=1)


def _begin(program: Program, near: Neighbour, rays: Rays) -> Point:
    """The earlier solution, moved off the bounds."""
    s, z = rays.along(near.forces), rays.gaps(near.opening)
    return Point(
        np.zeros(len(program.load)),
        near.alpha,
        np.maximum(s, DISTANCE * program.weight),
        np.maximum(z, DISTANCE * program.step),
    )


def _corrected(change: Callable[[Array], Direction], at: Point, product: float) -> Direction:
    """Predictor and corrector (Mehrotra), and once more for the products that would stray (Gondzio)."""
    towards = at.s * at.z
    ahead = change(towards)
    left = float(ahead.products(at, ahead.to_force, ahead.to_gap).mean())
    target = (left / product) ** 3 * product
    towards = towards + ahead.ds * ahead.dz - target
    step = change(towards)
    reach = [min(1.0, 1.5 * r + 0.1) for r in (step.to_force, step.to_gap)]
    strayed = step.products(at, *reach)
    low, high = (o * target for o in OUTLIERS)
    again = change(towards - np.maximum(np.clip(strayed, low, high) - strayed, -high))
    return again if min(again.to_force, again.to_gap) > min(step.to_force, step.to_gap) else step


def _newton(
    program: Program, layout: Band, at: Point, rays: Rays, holding: float
) -> Callable[[Array], Direction] | None:
    """The step from an iterate that decreases the products s z as told; None where the matrix is not definite."""
    kernels = fastest()
    m = len(program.load)
    unit = program.step / program.weight
    held = np.full(m, holding / unit)
    held[2::3] *= program.size**2
    soft = unit / STIFFEST
    law = (rays.components, program.compliance + soft)
    rows = (layout.row, program.normal, program.tangent)
    matrix, inverse = np.zeros((m, layout.width)), np.empty((len(at.s), 3))
    kernels.interior_matrix(*rows, *law, held, at.s, at.z, inverse, matrix)
    factor, failed = lapack.dpbtrf(matrix.T, lower=1, overwrite_ab=1)
    if failed:
        return None
    opening = np.empty_like(program.gap)
    # the proximal terms vanish at the iterate
    kernels.opening(*rows, program.gap - soft * rays.forces(at.s), at.x, opening)
    load, still = program.load[layout.order], np.zeros(m)
    together = program.compliance.any()
    if program.lateral is not None:
        lateral = program.lateral[layout.order]
        load = load + at.alpha * lateral
        swayed = lapack.dpbtrs(factor, lateral, lower=1)[0]

    def direction(decrease: Array) -> Direction:
        rhs, du, ds, dz = np.empty(m), np.empty_like(at.s), np.empty_like(at.s), np.empty_like(at.z)
        point = (opening, at.s, at.z, decrease, inverse)
        kernels.interior_rhs(*rows, *law, still, load, at.x, *point, rhs)
        dx, dalpha = lapack.dpbtrs(factor, rhs, lower=1)[0], 0.0
        if program.lateral is not None:
            dalpha = float((program.work - lateral @ (at.x + dx)) / (lateral @ swayed))
            dx = dx + dalpha * swayed
        force, gap = kernels.interior_step(*rows, *law, *point, dx, du, ds, dz)
        if together:  # compliance ties gaps to forces
            force = gap = min(force, gap)
        return Direction(dx, dalpha, ds, dz, force, gap)

    return direction
