"""The array loops of the Newton solver: geometry, contact law with its stiffness, certificate.

Rows of blocks: `row` (c, 2) is the first of the three rows of block a and of block b of each contact point, −1 for a
support. Matrices are banded: entry (i, j), i ≥ j, of a symmetric matrix stands at j places + i − j (see elimination).
These are the plain NumPy loops; `compiled` has the same ones for numba, used where it is installed.
"""

from __future__ import annotations

import importlib
import sys
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from mechanics.block import Array
from mechanics.contacts import Contacts, kinematics
from mechanics.joints import Index
from mechanics.program import Certificate, Program

if TYPE_CHECKING:
    from mechanics.solvers.elimination import Pattern

NAME = "numpy"
OPEN, STICKING, SLIDING_ON, SLIDING_BACK = 0, 1, 2, 3  # the slip of a sliding contact: w_t < 0, w_t > 0
SEARCHES = 12  # slopes that a line search looks at, at most
Residuals = tuple[float, float, float, float]
FLAT = 0.1  # of the slope at its start: one that is none


def fastest() -> ModuleType:
    """The compiled loops where numba is installed, else these."""
    try:
        return importlib.import_module("mechanics.solvers.compiled")
    except ImportError:
        return sys.modules[__name__]


def certificate(residuals: Residuals, program: Program, work: float = 0.0) -> Certificate:
    """The certificate of a solution with these residuals (see residuals); `work`: as in Certificate."""
    unbalanced, cone, power, penetration = residuals
    weight = program.weight
    return Certificate(unbalanced / weight, cone / weight, power / (weight * program.step), penetration, work)


def geometry(
    a: Index,
    b: Index,
    p: Array,
    q: Array,
    n: Array,
    positions: Array,
    gap: Array,
    normal: Array,
    tangent: Array,
) -> None:
    """Gap and slide (c, 2) and the rows of A₀ᵀ in a configuration, into the last three arguments (see contacts)."""
    nothing = np.zeros(0)
    rows = kinematics(Contacts(a, b, p, q, n, nothing, nothing, b, nothing), positions)
    gap[:, 0], gap[:, 1], normal[:], tangent[:] = rows.gap, rows.slide, rows.normal, rows.tangent


def repeat_matrix(
    row: Index,
    normal: Array,
    tangent: Array,
    friction: Array,
    compliance: Array,
    mass: Array,
    state: Index,
    stored: Array,
    pattern: Pattern,
) -> None:
    """M̄ + A₀KA₀ᵀ into `stored`, K the stiffness of contacts that keep their `state`."""
    stick = np.where((state == STICKING)[:, None], 1.0 / compliance, 0.0)
    mu, ray = _ray(friction, compliance, state)
    _assemble(
        row, normal, tangent, stick[:, 0] + ray, mu * ray, stick[:, 1] + mu * mu * ray, mass, stored, pattern
    )


def repeat_forces(
    row: Index,
    normal: Array,
    tangent: Array,
    gap: Array,
    friction: Array,
    compliance: Array,
    x: Array,
    state: Index,
    forces: Array,
    total: Array,
) -> None:
    """Contact forces c = −K(A₀ᵀx + g) of contacts that keep their `state`, into `forces`; A₀c into `total`."""
    u = _opening(row, x, normal, tangent, gap)
    mu, ray = _ray(friction, compliance, state)
    along = ray * (u[:, 0] + mu * u[:, 1])
    forces[:] = np.where((state == STICKING)[:, None], -u / compliance, 0.0)
    forces[:, 0] -= along
    forces[:, 1] -= mu * along
    total[:] = _resultant(row, normal, tangent, forces, len(x))


def contact_law(
    row: Index,
    normal: Array,
    tangent: Array,
    gap: Array,
    friction: Array,
    compliance: Array,
    x: Array,
    state: Index,
    forces: Array,
    total: Array,
) -> int:
    """Forces that minimise ½cᵀCc + cᵀ(A₀ᵀx + g) in the friction cone, their states and A₀c; how many states changed."""
    u = _opening(row, x, normal, tangent, gap)
    forces[:], found = _law(u, compliance, friction)
    changes = int((found != state).sum())
    state[:] = found
    total[:] = _resultant(row, normal, tangent, forces, len(x))
    return changes


def line_search(
    row: Index,
    normal: Array,
    tangent: Array,
    gap: Array,
    friction: Array,
    compliance: Array,
    mass: Array,
    load: Array,
    x: Array,
    dx: Array,
) -> float:
    """The share of `dx` to go: where ½xᵀM̄x − f̄ᵀx + Σφ(A₀ᵀx + g), −∇φ the contact law, is least along it (Illinois).

    The slope is exact and never falls; the full step is taken where it has not turned by then.
    """
    u, du = _opening(row, x, normal, tangent, gap), _change(row, dx, normal, tangent)
    constant, linear = float(dx @ (mass * x - load)), float(dx @ (mass * dx))

    def slope(share: float) -> float:
        forces, _ = _law(u + share * du, compliance, friction)
        return constant + share * linear - float((forces * du).sum())

    low, high, share = 0.0, 1.0, 1.0
    at_low, at_high = slope(0.0), 0.0
    steep = abs(at_low)
    for trial in range(1, SEARCHES):
        here = slope(share)
        if abs(here) <= FLAT * steep or (trial == 1 and here < 0.0):
            break
        if here > 0.0:
            if trial > 1 and high < 1.0:
                at_low *= 0.5
            high, at_high = share, here
        else:
            low, at_low = share, here
            at_high *= 0.5
        share = low - at_low * (high - low) / (at_high - at_low)
    return share


def relative(a: Index, b: Index, rows: Array, moved: Array, change: Array) -> None:
    """Change of gaps or slides that displacements (b, 3) cause, `rows` (c, 6) times those of blocks a and b."""
    change[:] = np.einsum("ij,ij->i", rows, np.concatenate([moved[a], moved[b]], axis=1))


def at_start(start: Array, shear: Array, compliance: Array, stretch: float, gap: Array, soft: Array) -> None:
    """What counts as gap and slide (c, 2) at the start of a step, and the compliances (c, 2), into the last arguments.

    From the gaps (c, 2) and the shear (c,) of the springs there, with `stretch` as in integrators.
    """
    soft[:] = compliance / stretch
    gap[:, 0] = np.where(start[:, 0] > 0.0, start[:, 0], start[:, 0] / stretch)
    gap[:, 1] = -soft[:, 1] * shear


def strain_energy(gap: Array, stiffness: Array, compliance: Array, shear: Array) -> float:
    """Energy (kNm) of springs of normal `stiffness` (c,), tangential `compliance` (c, 2), `shear` (c,), gaps (c, 2)."""
    return 0.5 * float(stiffness @ np.minimum(gap[:, 0], 0.0) ** 2 + compliance[:, 1] @ shear**2)


def springs(
    a: Index,
    b: Index,
    normal: Array,
    tangent: Array,
    moved: Array,
    forces: Array,
    start: Array,
    gap: Array,
    compliance: Array,
    stiffness: Array,
    friction: Array,
    before: Array,
    shear: Array,
    stretch: float,
    dashpot: float,
) -> tuple[float, float, float]:
    """Shear of the springs at the end, into `shear` (c,); what friction and dashpots took, and what the stepping did.

    For a step with displacements (b, 3): from contact forces (c, 2), the gaps at its start (c,), what counted as slide
    then (c,), compliances (c, 2) and stiffness (c,), and the shear `before`; `stretch` and `dashpot` as in integrators.
    What the stepping did is the work of the contact forces, less that of friction and dashpots, less what the springs
    store. Where sliding dilates, that work comes back when the gap closes. Of rigid contacts `stiffness` is infinite.
    """
    moves = np.concatenate([moved[a], moved[b]], axis=1)
    opening, slide = (np.einsum("ij,ij->i", rows, moves) for rows in (normal, tangent))
    n, t = forces.T
    slip = compliance[:, 1] * t + gap + slide
    rubbed = -float(t @ slip)
    work = -float(n @ opening) - float(t @ (slide - slip))
    if np.isinf(stiffness).all():
        shear[:] = before
        return rubbed, 0.0, work
    flexible = compliance[:, 1] * stretch
    pressed, after = stiffness * np.maximum(-start, 0.0), stiffness * np.maximum(-start - opening, 0.0)
    limit = friction * np.where(n > 0.0, np.maximum(n, after), 0.0)
    shear[:] = np.clip(before + (t - before) / stretch, -limit, limit)
    grown = np.where(n > 0.0, n - pressed, 0.0), t - before
    viscous = dashpot / stretch * float((grown[0] ** 2 / stiffness).sum() + flexible @ grown[1] ** 2)
    stored = 0.5 * float(((after**2 - pressed**2) / stiffness).sum() + flexible @ (shear**2 - before**2))
    return rubbed, viscous, work - viscous - stored


def opening(row: Index, normal: Array, tangent: Array, gap: Array, x: Array, u: Array) -> None:
    """Gaps and slides after displacements, g + A₀ᵀx, into `u` (c, 2)."""
    u[:] = gap + _change(row, x, normal, tangent)


def interior_matrix(
    row: Index,
    normal: Array,
    tangent: Array,
    ray: Array,
    compliance: Array,
    mass: Array,
    s: Array,
    z: Array,
    inverse: Array,
    stored: Array,
    pattern: Pattern,
) -> None:
    """M̄ + B(RᵀCR + Z/S)⁻¹Bᵀ into `stored`, the inverse (first, second, off the diagonal) into `inverse` (c, 3).

    R holds the unit rays of the cones, `ray` (c, 2) their normal and tangential components ∝ (1, ±μ); B = A₀R;
    s (c, 2) > 0 are the forces along them, z > 0 their gaps.
    """
    n, t = ray.T
    cn, ct = n * n * compliance[:, 0], t * t * compliance[:, 1]
    first, second = z[:, 0] / s[:, 0], z[:, 1] / s[:, 1]
    # the determinant without cancellation
    det = 4.0 * cn * ct + (cn + ct) * (first + second) + first * second
    a, b, c = (cn + ct + second) / det, (cn + ct + first) / det, (ct - cn) / det
    inverse[:] = np.stack([a, b, c], axis=1)
    knn, knt, ktt = n * n * (a + b + 2.0 * c), n * t * (a - b), t * t * (a + b - 2.0 * c)
    _assemble(row, normal, tangent, knn, knt, ktt, mass, stored, pattern)


def interior_rhs(
    row: Index,
    normal: Array,
    tangent: Array,
    ray: Array,
    compliance: Array,
    mass: Array,
    load: Array,
    x: Array,
    u: Array,
    s: Array,
    z: Array,
    product: Array,
    inverse: Array,
    rhs: Array,
) -> None:
    """The right-hand side, into `rhs`, of the step from x, where openings are u, that takes s·z to s·z − `product`."""
    p, q = (s + _apply(inverse, _missing(ray, compliance, u, s, z, product))).T
    forces = np.stack([ray[:, 0] * (p + q), ray[:, 1] * (p - q)], axis=1)
    rhs[:] = load - mass * x + _resultant(row, normal, tangent, forces, len(x))


def interior_step(
    row: Index,
    normal: Array,
    tangent: Array,
    ray: Array,
    compliance: Array,
    u: Array,
    s: Array,
    z: Array,
    product: Array,
    inverse: Array,
    dx: Array,
    du: Array,
    ds: Array,
    dz: Array,
) -> tuple[float, float]:
    """The steps in u, s and z that go with `dx`, into `du`, `ds`, `dz`; how far s and z can be gone, at most 1."""
    du[:] = _change(row, dx, normal, tangent)
    along, across = (ray * du).T
    missing = _missing(ray, compliance, u, s, z, product)
    ds[:] = _apply(inverse, missing - np.stack([along + across, along - across], axis=1))
    dz[:] = -(product + z * ds) / s

    def reach(value: Array, change: Array) -> float:
        falls = change < 0.0
        return float((-value[falls] / change[falls]).min(initial=1.0))

    return reach(s, ds), reach(z, dz)


def interior_centre(
    s: Array, z: Array, ds: Array, dz: Array, to_force: float, to_gap: float, product: Array
) -> float:
    """What the corrector takes from s·z, into `product`, after a predictor (Mehrotra); the s·z it leaves."""
    now, ahead = float((s * z).sum()), float(((s + to_force * ds) * (z + to_gap * dz)).sum())
    centre = (ahead / now) ** 3 * now / max(2 * len(s), 1) if now > 0.0 else 0.0
    product[:] = s * z + ds * dz - centre
    return centre


def interior_advance(
    share: float,
    ray: Array,
    u: Array,
    s: Array,
    z: Array,
    du: Array,
    ds: Array,
    dz: Array,
    product: Array,
    forces: Array,
) -> None:
    """A share of the step is gone: u, s, z, s·z and the contact forces (c, 2) after it, written."""
    u += share * du
    s += share * ds
    z += share * dz
    product[:] = s * z
    forces[:, 0] = ray[:, 0] * (s[:, 0] + s[:, 1])
    forces[:, 1] = ray[:, 1] * (s[:, 0] - s[:, 1])


def changed(
    s: Array, z: Array, before: Array, apart: Array, weight: float, step: float
) -> tuple[float, float, float]:
    """From forces and gaps (c, 2) along the rays, `before` and `apart`, to s and z: how much.

    The share of the rays that bear and did not, or the other way round, and the root mean squares of the changes of
    forces, per weight, and of gaps, per step.
    """
    sides = np.mean((s * step > z * weight) != (before * step > apart * weight))
    forces, gaps = (s - before) / weight, (z - apart) / step
    return float(sides), float(np.sqrt(np.mean(forces**2))), float(np.sqrt(np.mean(gaps**2)))


def residuals(
    row: Index,
    normal: Array,
    tangent: Array,
    gap: Array,
    friction: Array,
    compliance: Array,
    mass: Array,
    load: Array,
    x: Array,
    forces: Array,
    size: float,
) -> Residuals:
    """The definitions of program.Certificate, with their units: unbalanced force, cone, |cᵀw|, penetration."""
    w = compliance * forces + _opening(row, x, normal, tangent, gap)
    residual = load - mass * x + _resultant(row, normal, tangent, forces, len(x))
    residual[2::3] /= size
    n, t = forces.T
    return (
        float(abs(residual).max(initial=0.0)),
        float(max((abs(t) - friction * n).max(initial=0.0), (-n).max(initial=0.0))),
        float(abs((forces * w).sum(axis=1)).sum()),
        float((friction * abs(w[:, 1]) - w[:, 0]).max(initial=0.0)),
    )


def _rows(row: Index) -> Index:
    rows: Index = np.where(row[:, :, None] >= 0, row[:, :, None] + np.arange(3), -1).reshape(-1, 6)
    return rows


def _opening(row: Index, x: Array, normal: Array, tangent: Array, gap: Array) -> Array:
    return gap + _change(row, x, normal, tangent)


def _change(row: Index, x: Array, normal: Array, tangent: Array) -> Array:
    rows = _rows(row)
    local = np.where(rows >= 0, x[rows], 0.0)
    return np.stack([(normal * local).sum(axis=1), (tangent * local).sum(axis=1)], axis=1)


def _law(u: Array, compliance: Array, friction: Array) -> tuple[Array, Index]:
    n, t = u.T
    slope = np.where(t < 0.0, friction, -friction)
    along = -(n + slope * t) / (compliance[:, 0] + friction**2 * compliance[:, 1])
    is_open = n >= friction * abs(t)
    sticks = ~is_open & (n <= 0.0) & (abs(t) * compliance[:, 0] <= -friction * n * compliance[:, 1])
    forces = np.where(sticks[:, None], -u / compliance, np.stack([along, slope * along], axis=1))
    forces[is_open] = 0.0
    state = np.where(is_open, OPEN, np.where(sticks, STICKING, np.where(t < 0.0, SLIDING_ON, SLIDING_BACK)))
    return forces, state.astype(np.intp)


def _ray(friction: Array, compliance: Array, state: Index) -> tuple[Array, Array]:
    """Slope of the ray that sliding contacts are on, and the stiffness along it (zero for the others)."""
    mu = np.where(state == SLIDING_ON, friction, -friction)
    stiffness = 1.0 / (compliance[:, 0] + friction**2 * compliance[:, 1])
    return mu, np.where((state == SLIDING_ON) | (state == SLIDING_BACK), stiffness, 0.0)


def _missing(ray: Array, compliance: Array, u: Array, s: Array, z: Array, product: Array) -> Array:
    """What z and s·z lack: z − Rᵀ(u + CRs) − product/s."""
    n, t = ray.T
    along = n * (u[:, 0] + compliance[:, 0] * n * (s[:, 0] + s[:, 1]))
    across = t * (u[:, 1] + compliance[:, 1] * t * (s[:, 0] - s[:, 1]))
    missing: Array = z - np.stack([along + across, along - across], axis=1) - product / s
    return missing


def _apply(inverse: Array, v: Array) -> Array:
    """Symmetric 2 × 2 matrices (first, second, off the diagonal) times vectors, (c, 2)."""
    return np.stack(
        [
            inverse[:, 0] * v[:, 0] + inverse[:, 2] * v[:, 1],
            inverse[:, 2] * v[:, 0] + inverse[:, 1] * v[:, 1],
        ],
        axis=1,
    )


def _assemble(
    row: Index,
    normal: Array,
    tangent: Array,
    knn: Array,
    knt: Array,
    ktt: Array,
    mass: Array,
    stored: Array,
    pattern: Pattern,
) -> None:
    first = knn[:, None] * normal + knt[:, None] * tangent
    second = knt[:, None] * normal + ktt[:, None] * tangent
    stiffness = normal[:, :, None] * first[:, None, :] + tangent[:, :, None] * second[:, None, :]
    rows = _rows(row)
    i = np.broadcast_to(rows[:, :, None], stiffness.shape)
    j = np.broadcast_to(rows[:, None, :], stiffness.shape)
    lower = (i >= j) & (j >= 0)
    flat = np.bincount(
        j[lower] * pattern.places + i[lower] - j[lower], stiffness[lower], minlength=len(stored)
    )
    stored[:] = flat
    stored[:: pattern.places] += mass


def _resultant(row: Index, normal: Array, tangent: Array, forces: Array, size: int) -> Array:
    rows = _rows(row)
    entries = forces[:, :1] * normal + forces[:, 1:] * tangent
    moving = rows >= 0
    total: Array = np.bincount(rows[moving], entries[moving], minlength=size).astype(float)
    return total
