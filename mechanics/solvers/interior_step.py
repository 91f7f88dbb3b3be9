"""One iteration of the interior-point method: the linear system on banded matrices, and how far its step goes.

The unknowns are Δx, α, the forces s ≥ 0 along the rays of the friction cones and their gaps z ≥ 0; s and z are
eliminated, which leaves three rows a block in a narrow band, bordered by α. Proximal terms, whose centre is the
iterate itself, bound the stiffness of closed contacts and hold blocks that nothing holds, without a trace in the
solution.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mechanics.block import Array
from mechanics.program import Neighbour, Program
from mechanics.solvers.band import Band
from mechanics.solvers.factor import Factor, blank
from mechanics.solvers.kernels import fastest

STIFFEST = 1e8  # of closed contacts, per weight and step
OUTLIERS = 0.1, 10.0  # products s z outside this range about their target are corrected once
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


def begin(program: Program, near: Neighbour, rays: Rays) -> Point:
    """The earlier solution, moved off the bounds."""
    s, z = rays.along(near.forces), rays.gaps(near.opening)
    return Point(
        np.zeros(len(program.load)),
        near.alpha,
        np.maximum(s, DISTANCE * program.weight),
        np.maximum(z, DISTANCE * program.step),
    )


def corrected(change: Callable[[Array], Direction], at: Point, product: float) -> Direction:
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


def linearised(
    program: Program, layout: Band, at: Point, rays: Rays, holding: float
) -> Callable[[Array], Direction] | None:
    """The step from an iterate that decreases the products s z as told; None where the matrix is not definite.

    `holding`: stiffness that holds the blocks, per weight and step.
    """
    kernels = fastest()
    m = len(program.load)
    unit = program.step / program.weight
    soft = unit / STIFFEST
    law = (rays.components, program.compliance + soft)
    rows = (layout.row, program.normal, program.tangent)
    held = np.full(m, holding / unit)
    held[2::3] *= program.size**2
    matrix, inverse = blank(layout), np.empty((len(at.s), 3))
    kernels.interior_matrix(*rows, *law, held, at.s, at.z, inverse, matrix)
    factor = Factor.of(matrix, layout)
    if factor is None:
        return None
    lateral = None if program.lateral is None else program.lateral[layout.order]
    opening = np.empty_like(program.gap)
    # the proximal terms vanish at the iterate
    kernels.opening(*rows, program.gap - soft * rays.forces(at.s), at.x, opening)
    load, still = program.load[layout.order], np.zeros(m)
    together = program.compliance.any()
    if lateral is not None:
        load = load + at.alpha * lateral
        swayed = factor.solve(lateral)

    def direction(decrease: Array) -> Direction:
        rhs, du, ds, dz = np.empty(m), np.empty_like(at.s), np.empty_like(at.s), np.empty_like(at.z)
        point = (opening, at.s, at.z, decrease, inverse)
        kernels.interior_rhs(*rows, *law, still, load, at.x, *point, rhs)
        dx, dalpha = factor.solve(rhs), 0.0
        if lateral is not None:
            dalpha = float((program.work - lateral @ (at.x + dx)) / (lateral @ swayed))
            dx = dx + dalpha * swayed
        force, gap = kernels.interior_step(*rows, *law, *point, dx, du, ds, dz)
        if together:  # compliance ties gaps to forces
            force = gap = min(force, gap)
        return Direction(dx, dalpha, ds, dz, force, gap)

    return direction
