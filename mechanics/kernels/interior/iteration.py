"""The program over joints by a primal-dual interior-point method: static or dynamic, rigid or elastic.

Unknown are the displacements x, the multiplier α and per joint the forces N₁, N₂ > 0 at the ends of the overlap and T,
with |T| < μN, their gaps y₁, y₂ > 0 and the slips λ₊, λ₋ > 0:

    equilibrium    f + αf_L + Bᵀ(N, P, T) + Gx − M̄x = 0
    ends           u ∓ hφ − ψμ(λ₊ + λ₋) = ∂W*/∂N₁,₂ + Σ y ∂g/∂N₁,₂      W* = 0: rigid
    slip           λ₊ − λ₋ = v − v₀ + T/k_t
    products       g₁y₁ = g₂y₂ = (μN + T)λ₊ = (μN − T)λ₋ = τ → 0        g₁,₂ = N₁,₂ − κN², κ = 1/(4hσ)
    work           f_L·x = γ

with σ the strength per length, ψ the share by which sliding lifts (law.DILATION), and G what the forces of an earlier
solution change as the geometry does. Far from the solution the gaps y make joints softer than their beds, and K − G
would not be positive: G counts by the share e/(e + τ) of the beds in that, e the mean of N ∂W*/∂N. With ψ = 1 these are
the conditions of an optimum, with ψ = 0, Coulomb's law, of none: a mixed complementarity problem. All but x and α are
eliminated joint by joint (joint_law), which leaves BᵀDB + M̄ − G, three rows a block, unsymmetric where ψ < 1.
Predictor and corrector after Mehrotra, one more corrector after Gondzio; the forces that follow from stiff joints are
refined until equilibrium holds to rounding.

Infinite friction: a joint that presses does not slide, one that is open bears nothing. That set of forces, N > 0 with
any T and N = T = 0, is not closed, and has no products of its own. By Coulomb's law |T| is held below μN with a μ of
the iterate: it grows wherever T comes near the bound of a joint that presses, so that in the end no joint slides under
N, and an open one, whose N vanishes, has no T. By the associative law, whose cone is closed (N ≥ 0 with any T), a joint
that touches has no slip at all.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np

from mechanics.kernels.interior.joint_law import BM, C1, CHANGES, CN1, KNOWN, LANES

from mechanics.kernels.interior.joints import (  # isort: skip
    TO_THE_BOUND, ProgramJoints, advance, aim_all, assemble, change_all, correct_stray, curve_all,
    dot, evaluate, follow_all, predicted, push_all, unbalanced, within_strength,
)  # fmt: skip
from mechanics.kernels.jit import compiled, looped
from mechanics.kernels.joint import PHI, H, U
from mechanics.kernels.law import BED, DILATION, FRICTION, SEGMENTS, STEEP, STRENGTH
from mechanics.kernels.linalg.factors import cholesky, lu, substitute
from mechanics.types import Array

STIFFEST = 1e-11  # compliance, per step and weight, that bounds the stiffness of closed and of stuck joints
CENTRED = 0.3  # minimum centring parameter while infeasible
BEHIND = 0.01  # of the infeasibility: products below it are not reduced
HOLDING = 1e-8  # stiffness, per weight and step, that holds blocks
FIRMER = 10.0  # by which it grows where there is no factor
FIRM = 1.0  # the most of it
REFINEMENTS = 3  # of the forces of an iteration
ROUNDING = 1e-3  # share of the unbalanced force, or of what is accepted, that a refinement may leave
ROUNDED = 3e-15  # an imbalance, per weight, that is none
WIDE = 1e-4  # gaps count for so much less than forces and products in what is accepted
FARTHER = 1.5  # times as far as a step leads, products are looked at
TOUCHES = 1e-6  # of the step: a gap that is none, where friction is infinite
PRESSES = 0.01  # of what a bed closes: a gap of faces that press there
NEAR, GROWS = 0.5, 10.0  # share of its bound at which T raises it, and by how much
# a program with its rows in the order of elimination: ProgramJoints, `load` (m,), `lateral` and `mass` (m,) or empty,
# the `work` of the lateral load; weight, size of a block and step, by which residuals are measured; room for two
# triangles of the matrix, `stored` in this pattern
OrderedProgram = namedtuple("OrderedProgram", "joints load lateral work mass weight size step stored pattern")
# the linear system of an iteration: what is `known` of joints, displacements `pushed` (m,) under the lateral load, its
# `work` on them; weight per step, `stiff`; the factor
Newton = namedtuple("Newton", "joints known lateral pushed work mass size stiff lower upper pattern")


@looped
def _bound_shear(places: Array, law: Array, f: Array, step: float) -> bool:
    """Bound T in the `law` (j, LAW) of joints of infinite friction under forces f (j, 3): whether any is."""
    bounded = False
    for j in range(len(law)):
        touches = places[j, U] - places[j, H] * abs(places[j, PHI]) <= TOUCHES * step
        if law[j, FRICTION] < np.inf or (law[j, DILATION] == 1.0 and touches):
            continue
        law[j, FRICTION], law[j, DILATION] = max(STEEP, 2.0 * abs(f[j, 2]) / (f[j, 0] + f[j, 1])), 0.0
        bounded = True
    return bounded


@looped
def _raise_bounds(places: Array, law: Array, given: Array, f: Array, y: Array, unit: float) -> None:
    """Raise the bounds near which T is, where the friction that is `given` (j, LAW) has none; products stay.

    `unit`: step per weight. A joint presses whose gap is small beside what N closes its bed by, of rigid ones beside a
    step per weight: of faces that only touch gap and force vanish alike.
    """
    for j in range(len(law)):
        mu, n, t = law[j, FRICTION], f[j, 0] + f[j, 1], f[j, 2]
        give = unit if law[j, BED] == np.inf else 0.5 / (places[j, H] * law[j, BED])
        presses = min(y[j, 0], y[j, 1]) < PRESSES * give * n
        if given[j, FRICTION] < np.inf or mu == np.inf or not presses or abs(t) < NEAR * mu * n:
            continue
        law[j, FRICTION] = GROWS * mu
        y[j, 2] *= (mu * n + t) / (GROWS * mu * n + t)
        y[j, 3] *= (mu * n - t) / (GROWS * mu * n - t)


@compiled
def _residuals(
    joints: Any, x: Array, alpha: float, f: Array, y: Array, load: Array, lateral: Array, mass: Array, curved: Array,
    least: float, known: Array, residual: Array,
) -> tuple[float, float]:  # fmt: skip
    """Forces that are not balanced, into `residual` (m,), and what is known of joints; gaps missed, mean product.

    Of `curved` (j, CURVED) the joints get the share of the beds in what yields.
    """
    residual[:] = load
    if len(lateral):
        residual += alpha * lateral
    if len(mass):
        residual -= mass * x
    gap_off, mean, yielded = evaluate(joints, x, f, y, least, known, residual)
    if len(curved):
        joints.curved[:] = yielded / (yielded + mean) * curved
        curve_all(joints, x, residual)
    return gap_off, mean


@compiled
def _factorised(
    program: OrderedProgram,
    joints: ProgramJoints,
    known: Array,
    skew: bool,
    holding: float,
    two: bool,
    held: Array,
) -> tuple[float, bool]:
    """The factor of the matrix, into `stored`; firmer where rounding outweighs the stiffness that holds blocks.

    Returns the stiffness `holding` that it took, negative if there is no factor, and whether it is of `two` triangles:
    of a `skew` matrix, and beyond the peak of a curve, where the work that is given holds one motion.
    """
    mass, stored, pattern = program.mass, program.stored, program.pattern
    half, stiff = len(stored) // 2, 1.0 / (program.step / program.weight)
    while True:
        held[:] = holding * stiff
        held[2::3] *= program.size**2
        if len(mass):
            held += mass
        lower, upper = stored[:half], stored[half:] if two else stored[:half]
        assemble(joints, known, held, lower, upper, two, pattern)
        if two:
            negative = lu(lower, upper, pattern)
            found = 0 <= negative <= (len(held) if skew else 1)
        else:
            found = bool(cholesky(lower, pattern))
        if found:
            return holding, two
        if not two and len(program.lateral) and len(joints.curved):
            two = True
        elif holding >= FIRM:
            return -1.0, two
        else:
            holding *= FIRMER


@compiled
def _changes(
    newton: Newton, residual: Array, work_residual: float, target: float, enough: float, tied: bool, dx: Array,
    fine: Array,
) -> tuple[float, float, float]:  # fmt: skip
    """Changes dx (m,), Δα and those of joints that cancel the residuals; products become `target` less corrections.

    Refined until `enough` is balanced, unless that is infinite. Returns by what share of themselves forces and gaps
    fall at most, `tied` to each other or not, and Δα.
    """
    joints, known, lateral = newton.joints, newton.known, newton.lateral
    dalpha, refined = 0.0, enough < np.inf
    dx[:] = residual
    aim_all(joints, known, target, dx)
    substitute(newton.lower, newton.upper, newton.pattern, dx)
    if len(lateral):
        dalpha = (work_residual - dot(lateral, dx)) / newton.work
        dx += dalpha * newton.pushed
    follow_all(joints, known, dx, target, newton.stiff, refined)
    if refined:
        dalpha = _refine(newton, residual, target, enough, dalpha, dx, fine)
    most_f, most_g = change_all(joints, known, target, newton.stiff)
    if tied:
        most_f = most_g = max(most_f, most_g)
    return most_f, most_g, dalpha


@looped
def _refine(
    newton: Newton, load: Array, target: float, enough: float, dalpha: float, dx: Array, fine: Array
) -> float:  # fmt: skip
    """Refine displacements dx and changes of forces until they balance the residual `load` (m,); the new Δα.

    Closed and stuck joints are stiff: forces that follow from motions lose their digits there.
    """
    joints, known, lateral, mass = newton.joints, newton.known, newton.lateral, newton.mass
    for _ in range(REFINEMENTS):
        for i in range(len(fine)):
            fine[i] = load[i]
        for i in range(len(lateral)):
            fine[i] += dalpha * lateral[i]
        for i in range(len(mass)):
            fine[i] -= mass[i] * dx[i]
        push_all(joints, known, dx, fine)
        if unbalanced(fine, newton.size) <= enough:
            break
        substitute(newton.lower, newton.upper, newton.pattern, fine)
        if len(lateral):
            more = -dot(lateral, fine) / newton.work
            dalpha += more
            for i in range(len(fine)):
                fine[i] += more * newton.pushed[i]
        follow_all(joints, known, fine, target, newton.stiff, True)
        for i in range(len(fine)):
            dx[i] += fine[i]
    return dalpha


@compiled
def iterate(
    program: OrderedProgram,
    x: Array,
    alpha: float,
    f: Array,
    y: Array,
    accepted: float,
    closed: float,
    limits: Any,
) -> tuple[int, float, float, float, float]:
    """Iterate on x (m,), α, f (j, 3): N₁, N₂, T, and y (j, 4): y₁, y₂, λ₊, λ₋, in one geometry and in place.

    `accepted` of unbalanced forces per weight and of gaps, 1/WIDE times as much, per step; `closed`: accepted of
    products per weight and step. `limits`: most iterations, and most without progress. Returns the number of
    iterations, negative if no iteration leads on (with curvature: if equilibrium is not stable), α, and the residuals
    of forces, gaps and products, scaled likewise.
    """
    given_joints, load, lateral, work, mass, weight, size, step, stored, pattern = program
    row, places, given, curved, which = given_joints
    most, idle = limits
    count, c, unit, law = len(x), len(row), step / weight, given.copy()
    bounded = _bound_shear(places, law, f, step)
    joints = ProgramJoints(row, places, law, np.zeros_like(curved), which)
    known = np.empty(((c + LANES - 1) // LANES, KNOWN))
    tied = len(mass) > 0 or (law[:, BED] < np.inf).any()  # forces and gaps, to each other
    # open ends of exact beds are infeasible for long and carry nothing; gaps of joints that crush are nonlinear
    beds, crushes = (law[:, BED] < np.inf) & (law[:, SEGMENTS] == 0.0), (law[:, STRENGTH] < np.inf).any()
    counted = WIDE if beds.any() and not crushes else 1.0
    pushed, skew = len(lateral) > 0, bool(len(law) > 0 and (law[:, DILATION] < 1.0).any())
    stiff, holding, two, half = 1.0 / unit, HOLDING, skew, len(stored) // 2
    residual, dx, held, fine = np.empty(count), np.empty(count), np.empty(count), np.empty(count)
    lateral_solution, lateral_work = np.empty(count), 1.0
    kept_dx, kept_changes = np.empty(count), np.empty((len(known), KNOWN - CN1))
    kept_f, kept_g, kept_alpha = 0.0, 0.0, 0.0
    best, since, iteration = np.inf, 0, 0
    best_x, best_f, best_y = x.copy(), f.copy(), y.copy()
    best_alpha, best_off = alpha, (np.inf, np.inf, np.inf)
    while True:
        gap_off, mean = _residuals(
            joints, x, alpha, f, y, load, lateral, mass, curved, unit * STIFFEST, known, residual
        )
        force_off = unbalanced(residual, size)
        work_residual = work - dot(lateral, x) if pushed else 0.0
        force, gap, product = (
            max(force_off / weight, abs(work_residual) / (weight * step)), gap_off / step, mean / (weight * step),
        )  # fmt: skip
        missed = max(force, WIDE * gap)
        if not (max(force, gap) < np.inf and product < np.inf):
            return -1, alpha, np.inf, np.inf, np.inf
        if missed <= accepted and product <= closed:
            return iteration, alpha, force, gap, product
        since += 1
        if max(missed, product) < 0.5 * best:
            best, since = max(missed, product), 0
            best_x[:], best_alpha, best_f[:], best_y[:], best_off = x, alpha, f, y, (force, gap, product)
        if iteration == most or since > idle:  # rounding may throw back what is near the end
            x[:], f[:], y[:] = best_x, best_f, best_y
            return iteration, best_alpha, best_off[0], best_off[1], best_off[2]
        iteration += 1

        holding, two = _factorised(program, joints, known, skew, holding, two, held)
        if holding < 0.0:
            return -iteration, alpha, force, gap, product
        lower, upper = stored[:half], stored[half:] if two else stored[:half]
        if pushed:
            lateral_solution[:] = lateral
            substitute(lower, upper, pattern, lateral_solution)
            lateral_work = dot(lateral, lateral_solution)
        newton = Newton(
            joints, known, lateral, lateral_solution, lateral_work, mass, size, stiff, lower, upper, pattern
        )

        known[:, C1 : BM + LANES] = 0.0
        target, enough = 0.0, np.inf
        for correction in range(3):  # predictor, corrector, and one more of products that stray farther on
            most_f, most_g, dalpha = _changes(newton, residual, work_residual, target, enough, tied, dx, fine)
            reach_f, reach_g = 1.0 / max(most_f, 1.0), 1.0 / max(most_g, 1.0)
            if correction == 0:
                ahead = predicted(joints, known, reach_f, reach_g)
                centre = (ahead / (4.0 * c * mean)) ** 3 if mean > 0.0 else 0.0
                infeasible = max(force, counted * gap)
                if infeasible > product:
                    centre = max(centre, CENTRED if product > BEHIND * infeasible else 1.0)
                target = centre * mean
                enough = max(ROUNDING * max(force_off, accepted * weight), ROUNDED * weight)
            elif correction == 1:
                if max(most_f, most_g) <= 1.0:
                    break
                kept_f, kept_g, kept_alpha = most_f, most_g, dalpha
                kept_dx[:], kept_changes[:] = dx, known[:, CHANGES]
                to_f, to_g = min(1.0, FARTHER * reach_f + 0.1), min(1.0, FARTHER * reach_g + 0.1)
                correct_stray(joints, known, to_f, to_g, target)
            elif max(most_f, most_g) > max(kept_f, kept_g):  # the earlier changes lead farther
                most_f, most_g, dalpha = kept_f, kept_g, kept_alpha
                dx[:], known[:, CHANGES] = kept_dx, kept_changes
        reach_f = 1.0 if most_f < TO_THE_BOUND else TO_THE_BOUND / most_f
        reach_g = 1.0 if most_g < TO_THE_BOUND else TO_THE_BOUND / most_g
        reach_f = within_strength(joints, known, reach_f)
        if tied:
            reach_f = reach_g = min(reach_f, reach_g)
        advance(joints, known, reach_f, reach_g, f, y)
        if bounded:
            _raise_bounds(places, law, given, f, y, unit)
        x += reach_g * dx
        alpha += reach_f * dalpha


@compiled
def inertia(program: OrderedProgram, f: Array, y: Array, held: Array, skew: bool) -> tuple[int, float]:
    """Return the number of negative pivots of K − G at a solution, −1 where one vanishes, and f_Lᵀ(K − G)⁻¹f_L.

    Joints that slide by Coulomb's law do so under the friction that they have, and K − G is symmetric, or `skew` under
    one that follows N. Forces f (j, 3) and y (j, 4) as in `iterate`; `held` (m,): stiffness added to the diagonal.
    """
    row, places, law, curved, which = program.joints
    law, least = law.copy(), STIFFEST * program.step / program.weight
    _bound_shear(places, law, f, program.step)
    joints = ProgramJoints(row, places, law, curved, which)
    known = np.empty(((len(row) + LANES - 1) // LANES, KNOWN))
    residual, x = np.zeros(len(held)), np.zeros(len(held))
    evaluate(joints, x, f, y.copy(), least, known, residual)
    half = len(program.stored) // 2
    lower, upper = program.stored[:half], program.stored[half:]
    assemble(joints, known, held, lower, upper, skew, program.pattern)
    if not skew:
        upper[:] = lower
    negative, lateral_solution = lu(lower, upper, program.pattern), program.lateral.copy()
    substitute(lower, upper, program.pattern, lateral_solution)
    return negative, dot(program.lateral, lateral_solution)
