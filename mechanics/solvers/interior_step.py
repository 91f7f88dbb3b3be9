"""An iteration of the static interior-point method in plain NumPy: what an iterate lacks, and the step from it.

The unknowns are Δx, α, the forces s ≥ 0 along the rays of the friction cones and their gaps z ≥ 0; s and z are
eliminated, which leaves three rows a block in a sparse matrix, bordered by α. Proximal terms, whose centre is the
iterate itself, bound the stiffness of closed contacts and hold blocks that nothing holds, without a trace in the
solution. `compiled_interior_step` has the same functions for numba. `posed`: row, normal, tangent, gap, friction and
compliance of the contact points, as in kernels, and their runs (see runs); `scale`: weight, size and step of the
program; `stored`: work space for a matrix of that `pattern` (see elimination).
"""

from __future__ import annotations

import numpy as np

from mechanics.block import Array
from mechanics.joints import Index
from mechanics.solvers import kernels
from mechanics.solvers.elimination import Pattern
from mechanics.solvers.iterations import factorise, handed, substitute
from mechanics.solvers.kernels import Residuals
from mechanics.solvers.runs import Runs

STIFFEST = 1e12  # of closed contacts, per weight and step
HOLDING, FIRMER, FIRM = (
    1e-9,
    10.0,
    1.0,
)  # stiffness that holds blocks, per weight and step; its growth, and its most
OUTLIERS = 0.1, 10.0  # products s z outside this range about their target are corrected once
TO_THE_BOUND = 0.995  # share of the way to the bounds that an iteration goes
TO_AND_FRO = -0.3  # of a step: its return that asks for a shorter one
TINY = 1e-300
RESTORATIONS = 2
LEAST = 0.5  # share of a force that a restoration leaves

Posed = tuple[Index, Array, Array, Array, Array, Array, Runs]
Lack = tuple[Array, Array]
Direction = tuple[Array, float, Array, Array, float, float]

__all__ = ["advance", "handed", "measured", "restore"]


def measured(posed: Posed, load: Array, x: Array, s: Array, z: Array, size: float) -> tuple[Residuals, Lack]:
    """What an iterate lacks: unbalanced force, |cᵀw|, penetration and the mean of s z; and what `advance` needs of it.

    The latter: of the gaps along the rays, z − Rᵀw (c, 2), and of equilibrium (m,).
    """
    row, normal, tangent, gap, friction, compliance, _ = posed
    forces = _forces(friction, s)
    apart = _gaps(friction, kernels._opening(row, x, normal, tangent, gap) + compliance * forces)
    short = load + kernels._resultant(row, normal, tangent, forces, len(load))
    unbalanced = abs(short)
    unbalanced[2::3] /= size
    residuals = (
        float(unbalanced.max(initial=0.0)),
        float(abs((s * apart).sum(axis=1)).sum()),
        float((-apart * np.hypot(1.0, friction)[:, None]).max(initial=0.0)),
        float((s * z).mean()),
    )
    return residuals, (z - apart, short)


def advance(
    posed: Posed, lack: Lack, lateral: Array, work: float, scale: tuple[float, float, float], holding: float,
    x: Array, alpha: float, s: Array, z: Array, last: Array, stored: Array, pattern: Pattern,
) -> tuple[bool, float, float]:  # fmt: skip
    """One step of the iterate, x, s, z and `last`, the step in x (m,), in place; whether there is one, α and holding.

    `lateral` (m,): none where it is empty; `work`: what it has to do. Predictor and corrector (Mehrotra), and once more
    for the products that would stray (Gondzio). There is no step where rounding outweighs even a firm hold.
    """
    row, normal, tangent, _, friction, compliance, _ = posed
    lacking, short = lack
    weight, size, step = scale
    unit = step / weight
    n = 1.0 / np.hypot(1.0, friction)
    rays, soft = np.stack([n, friction * n], axis=1), compliance + unit / STIFFEST
    inverse = np.empty((len(s), 3))
    while True:
        held = np.full(len(x), holding / unit)
        held[2::3] *= size**2
        kernels.interior_matrix(row, normal, tangent, rays, soft, held, s, z, inverse, stored, pattern)
        if factorise(stored, pattern):
            break
        if holding >= FIRM:
            return False, alpha, holding
        holding *= FIRMER
    swayed = lateral.copy()
    substitute(stored, pattern, swayed)
    elastic = compliance.any()

    def change(decrease: Array) -> Direction:
        v = lacking - decrease / s
        carried = _forces(friction, kernels._apply(inverse, v))
        dx, dalpha = short + kernels._resultant(row, normal, tangent, carried, len(x)), 0.0
        substitute(stored, pattern, dx)
        if len(lateral):
            dalpha = float((work - lateral @ (x + dx)) / (lateral @ swayed))
            dx = dx + dalpha * swayed
        ds = kernels._apply(inverse, v - _gaps(friction, kernels._change(row, dx, normal, tangent)))
        dz = -(decrease + z * ds) / s
        force, gap = _reach(s, ds), _reach(z, dz)
        if elastic:  # compliance ties gaps to forces
            force = gap = min(force, gap)
        return dx, dalpha, ds, dz, force, gap

    products = s * z
    _, _, ds, dz, force, gap = change(products)
    left = float(((s + force * ds) * (z + gap * dz)).mean())
    target = (left / float(products.mean())) ** 3 * float(products.mean())
    products = products + ds * dz - target
    chosen = change(products)
    *_, ds, dz, force, gap = chosen
    if min(force, gap) < 1.0:
        force, gap = (min(1.0, 1.5 * reach + 0.1) for reach in (force, gap))
        strayed = (s + force * ds) * (z + gap * dz)
        low, high = (o * target for o in OUTLIERS)
        again = change(products - np.maximum(np.clip(strayed, low, high) - strayed, -high))
        chosen = again if min(again[4:]) > min(chosen[4:]) else chosen
    dx, dalpha, ds, dz, force, gap = chosen
    force, gap = min(1.0, TO_THE_BOUND * force), min(1.0, TO_THE_BOUND * gap)
    # where the geometry of one iteration and the next send the blocks to and fro, they meet in between
    returns = float(dx @ last) / max(float(last @ last), TINY)
    if returns < TO_AND_FRO:
        gap /= 1.0 - max(returns, -1.0)
    last[:] = gap * dx
    x += last
    s += force * ds
    z += gap * dz
    return True, alpha + force * dalpha, holding


def restore(
    posed: Posed, load: Array, lateral: Array, scale: tuple[float, float, float], s: Array, alpha: float,
    stored: Array, pattern: Pattern,
) -> float:  # fmt: skip
    """Change forces s in place, and the multiplier returned, by the least shares of themselves into equilibrium."""
    row, normal, tangent, _, friction, compliance, _ = posed
    weight, size, _ = scale
    n = 1.0 / np.hypot(1.0, friction)
    rays = np.stack([n, friction * n], axis=1)
    held = np.full(len(load), HOLDING * weight)
    held[2::3] *= size**2
    free, inverse = np.zeros_like(compliance), np.empty((len(s), 3))
    kernels.interior_matrix(row, normal, tangent, rays, free, held, s, weight / s, inverse, stored, pattern)
    if not factorise(stored, pattern):
        return alpha
    swayed = lateral.copy()
    substitute(stored, pattern, swayed)
    for _ in range(RESTORATIONS):
        y = load + kernels._resultant(row, normal, tangent, _forces(friction, s), len(load))
        if len(lateral):
            y += alpha * lateral
        substitute(stored, pattern, y)
        if len(lateral):
            more = -float(lateral @ y) / float(lateral @ swayed)
            alpha, y = alpha + more, y + more * swayed
        share = s / weight * _gaps(friction, kernels._change(row, y, normal, tangent))
        s *= np.maximum(1.0 - share, LEAST)
    return alpha


def _forces(friction: Array, s: Array) -> Array:
    """Contact forces (c, 2) of forces along the rays."""
    n = 1.0 / np.hypot(1.0, friction)
    return np.stack([n * (s[:, 0] + s[:, 1]), friction * n * (s[:, 0] - s[:, 1])], axis=1)


def _gaps(friction: Array, opening: Array) -> Array:
    """Gaps (c, 2) along the rays of gaps and slips."""
    n = 1.0 / np.hypot(1.0, friction)
    along, across = n * opening[:, 0], friction * n * opening[:, 1]
    return np.stack([along + across, along - across], axis=1)


def _reach(value: Array, change: Array) -> float:
    falls = change < 0.0
    return float((-value[falls] / change[falls]).min(initial=1.0))
