"""Kinematics of a joint: gap u, turn φ and slip v of two faces, exact at any rotation.

A joint is where a face of block a and a face of block b look at each other: the interval in which they overlap now. Its
measures are taken at the end that is the more closed, in the frame of the face that a corner touches there (β = 0: b's,
β = 1: a's; where two corners meet, the bisector of both, β = ½, reached linearly as they come within `MEET`):

    E = x_a + r_A − x_b − r_B      from the end B of b's face to the end A of a's
    t, n = frame at the angle β θ_a + (1 − β) θ_b of the faces, n = perp(t) from b into a
    w = n·E      v = t·E + const      φ = sin (1 − β)δ + sin βδ,  δ = θ_a − θ_b

so that the gap is w + φ s at the distance s from that end (between the two corners, by the share β), and u is that at
the middle of the overlap.

A tie between a point of a and one of b is a joint too, of length 1 and without faces: n = −E/|E|, w = ℓ − |E| with its
length ℓ, φ = v = 0. What pulls it closes the joint.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.kernels.jit import compiler
from mechanics.kernels.law import FRICTION, STEEPEST
from mechanics.types import Array

compiled = compiler(allocates=False)

LEAST = 1e-9  # rad: the angle of friction that is left where two corners meet at a wider angle
NEARLY = 1e-3  # rad: by so much a force between two corners may lie outside of the friction of their faces
LEVEL = 1e-11  # rad: faces that rounding turns against each other are level, and keep to one of their ends

# columns of what a joint is (faces, j × 14): reference point and unit tangent of either face, in its block's axes, from
# the centroid; along the tangents, from the reference points: the ends of a's face, then of b's; how
# near two corners meet, m; length of a tie, m, 0: no tie
PX, PZ, TAX, TAZ, QX, QZ, TBX, TBZ, A1, A2, B1, B2, MEET, LENGTH = range(14)
FACE = 14
# columns of where it is (places, j × 19): normal; moments of the rows of u, φ and v about a's centroid; lever from b's
# centroid to a's; half the overlap; u, φ and v; β; from the end to the middle; t·E and d²φ/dδ²; of a tie 1/|E|, else 0;
# what the half-length, the way from the end to the middle and β change per slip
NX, NZ, MU, MPHI, MV, LX, LZ, H, U, PHI, V, BETA, ARM, ALONG, BEND, TIED, HALVED, SHIFTED, BLENDED = range(19)
PLACE = 19
# numbers of a joint's curvature; from SHIFTS on, what N, P and T change per slide, the slide per u, φ and v, and what P
# changes per u and φ
CURVED, SHIFTS, SLIDE, LEVERS = 18, 10, 13, 16


@compiled
def place(a: Any, b: Any, faces: Array, positions: Array, places: Array) -> None:
    """Where the joints (j,) of blocks at `positions` (b, 3) are, into `places` (j, PLACE).

    The half-length is negative where faces do not overlap, or lie deeper in each other than they overlap: a corner is
    held by the face into which it has come the least.
    """
    for k in range(len(a)):
        i, j = a[k], b[k]
        ca, sa, cb, sb = (
            np.cos(positions[i, 2]), np.sin(positions[i, 2]), np.cos(positions[j, 2]), np.sin(positions[j, 2]),
        )  # fmt: skip
        f, out = faces[k], places[k]
        lx, lz = positions[i, 0] - positions[j, 0], positions[i, 1] - positions[j, 1]
        px, pz = ca * f[PX] - sa * f[PZ], sa * f[PX] + ca * f[PZ]
        qx, qz = cb * f[QX] - sb * f[QZ], sb * f[QX] + cb * f[QZ]
        ex, ez = lx + px - qx, lz + pz - qz
        out[LX], out[LZ] = lx, lz
        if f[LENGTH] > 0.0:
            length = np.sqrt(ex * ex + ez * ez)
            nx, nz = -ex / length, -ez / length
            out[NX], out[NZ], out[MU], out[MPHI], out[MV] = nx, nz, px * nz - pz * nx, 0.0, -px * nx - pz * nz
            out[H], out[U], out[PHI], out[V] = 0.5, f[LENGTH] - length, 0.0, 0.0
            out[BETA], out[ARM], out[ALONG], out[BEND], out[TIED] = 0.5, 0.0, 0.0, 0.0, 1.0 / length
            out[HALVED], out[SHIFTED], out[BLENDED] = 0.0, 0.0, 0.0
            continue
        tax, taz = ca * f[TAX] - sa * f[TAZ], sa * f[TAX] + ca * f[TAZ]
        tbx, tbz = cb * f[TBX] - sb * f[TBZ], sb * f[TBX] + cb * f[TBZ]
        delta = np.arctan2(tbx * taz - tbz * tax, tbx * tax + tbz * taz)
        # how far a's face has slid along b's decides where they overlap, and whose corner ends that
        mx, mz = tax + tbx, taz + tbz
        size = np.sqrt(mx * mx + mz * mz)
        slid = (mx * ex + mz * ez) / size
        low, high = max(f[A1], f[B1] - slid), min(f[A2], f[B2] - slid)
        upper = delta <= LEVEL
        beyond = f[B2] - slid - f[A2] if upper else f[A1] - f[B1] + slid
        beta = min(max(0.5 - 0.5 * beyond / f[MEET], 0.0), 1.0)
        at_a, at_b = (f[A2], f[B2]) if upper else (f[A1], f[B1])
        end = at_a + beta * beyond if upper else at_a - beta * beyond
        rax, raz = px + at_a * tax, pz + at_a * taz
        rbx, rbz = qx + at_b * tbx, qz + at_b * tbz
        cos, sin = np.cos(beta * delta), np.sin(beta * delta)
        tx, tz = cos * tbx - sin * tbz, sin * tbx + cos * tbz
        nx, nz = -tz, tx
        ex, ez = lx + rax - rbx, lz + raz - rbz
        w, along = nx * ex + nz * ez, tx * ex + tz * ez
        phi = np.sin((1.0 - beta) * delta) + sin
        turn = (1.0 - beta) * np.cos((1.0 - beta) * delta) + beta * cos
        half = 0.5 * (high - low)
        arm = 0.5 * (high + low) - end  # so that level faces have one middle, whichever end measures it
        if 2.0 * half < -w:
            half = -abs(half)
        out[NX], out[NZ] = nx, nz
        out[MU] = rax * nz - raz * nx - beta * along + arm * turn
        out[MPHI] = turn
        out[MV] = rax * tz - raz * tx + beta * w
        out[H] = half
        out[U], out[PHI], out[V] = w + arm * phi, phi, along + at_b - at_a
        out[BETA], out[ARM], out[ALONG] = beta, arm, along
        out[BEND] = -((1.0 - beta) ** 2) * np.sin((1.0 - beta) * delta) - beta**2 * sin
        out[TIED] = 0.0
        first, second = (-1.0 if f[B1] - slid > f[A1] else 0.0), (-1.0 if f[B2] - slid < f[A2] else 0.0)
        farther = -1.0 if upper else 1.0
        blended = -0.5 * farther / f[MEET] if 0.0 < beta < 1.0 else 0.0
        out[HALVED], out[BLENDED] = 0.5 * (second - first), blended
        out[SHIFTED] = 0.5 * (first + second) + farther * (blended * beyond + beta * farther)


@compiled
def _turned(place: Array) -> float:
    """The angle (rad) between the frame of a joint at a place (PLACE,) and the nearer face."""
    beta, phi = place[BETA], abs(place[PHI])
    # δ of φ = sin (1 − β)δ + sin βδ, to the third order
    turned: float = min(beta, 1.0 - beta) * phi * (1.0 + phi**2 * ((1.0 - beta) ** 3 + beta**3) / 6.0)
    return turned


@compiled
def friction_between(places: Array, law: Array) -> None:
    """Bound the friction in `law` (j, LAW) of joints at `places` (j, PLACE) by the faces that their frame lies between.

    Where two corners nearly meet either may bear on the other's face. The cone about the frame lies within that of the
    nearer face: its half-angle is less by the angle to it. At level faces, and beyond `MEET`, nothing changes.
    """
    for k in range(len(places)):
        turned = _turned(places[k])
        if turned > 0.0:
            friction = np.tan(max(np.arctan(law[k, FRICTION]) - turned, LEAST))
            law[k, FRICTION] = friction if friction < STEEPEST else law[k, FRICTION]


@compiled
def bearing(places: Array, law: Array, least: float, bears: Array) -> None:
    """Whether joints at `places` (j, PLACE) overlap by half of `least` (m) and may bear, into `bears` (j,).

    No force between two corners lies within the friction of both faces where these are apart by more than twice its
    angle. `law` (j, LAW) of the joints, its friction that of their stone.
    """
    for k in range(len(places)):
        admitted = _turned(places[k]) <= np.arctan(law[k, FRICTION]) + NEARLY
        bears[k] = places[k, H] > least and admitted


@compiled
def curvature(p: Array, n: float, m: float, t: float, out: Array) -> None:
    """How forces N, P and T (n, m, t) of a joint at a place p (PLACE,) change as it moves: N∇²u + P∇²φ + T∇²v.

    Into `out` (CURVED,): the entries of x_a, z_a with θ_a and with θ_b (those of b have the opposite sign), then those
    of θ_a with itself, of θ_a with θ_b and of θ_b with itself; of a tie also those of x_a with x_a, x_a with z_a and
    z_a with z_a (those of x_a with x_b have the opposite sign).

    As the faces slide, N₁ and N₂ stay at the ends of their overlap, which moves, and the frame turns between two
    corners: changes of N, P and T per slide, from SHIFTS on. The slide is along the bisector of the faces: SLIDE. T
    acts midway between the faces (`middle`): LEVERS. None of that is symmetric: it is the gradient of no gap and slip.
    """
    if p[TIED] > 0.0:
        _pull(p, n, out)
        return
    beta, rest = p[BETA], 1.0 - p[BETA]
    nx, nz = p[NX], p[NZ]
    tx, tz = nz, -nx
    w = p[U] - p[ARM] * p[PHI]
    turn = m + n * p[ARM]  # φ is seen by the moment about the end
    qx, qz = t * nx - n * tx, t * nz - n * tz
    out[0], out[1] = beta * qx, beta * qz
    out[2], out[3] = rest * qx, rest * qz
    na, ta = beta * w - p[MV], p[MU] + beta * p[ALONG] - p[ARM] * p[MPHI]
    nb, tb = na + nx * p[LX] + nz * p[LZ] - w, ta + tx * p[LX] + tz * p[LZ] - p[ALONG]
    bend = turn * p[BEND]
    skew = rest - beta
    out[4] = n * (-skew * na - beta**2 * w) + t * (-skew * ta - beta**2 * p[ALONG]) + bend
    out[5] = (
        n * (rest * na - beta * nb - beta * rest * w)
        + t * (rest * ta - beta * tb - beta * rest * p[ALONG])
        - bend
    )
    out[6] = n * (-skew * nb - rest**2 * w) + t * (-skew * tb - rest**2 * p[ALONG]) + bend
    out[7], out[8], out[9] = 0.0, 0.0, 0.0
    _, deep, per_u, per_phi = middle(p, n, m)
    out[LEVERS], out[LEVERS + 1] = -t * per_u / p[MPHI], -t * per_phi / p[MPHI]
    frame = p[PHI] * p[BLENDED]
    lever = t * (deep * p[BLENDED] + frame * (per_u * p[ALONG] - p[ARM] * p[MPHI]))
    lever -= n * (p[ALONG] * p[BLENDED] + beta * frame * w)
    out[SHIFTS], out[SHIFTS + 2] = t * frame, -n * frame
    out[SHIFTS + 1] = n * p[SHIFTED] + m * p[HALVED] / p[H] + lever / p[MPHI]
    aside = (0.5 - beta) * p[PHI]  # from the bisector of the faces
    out[SLIDE], out[SLIDE + 2] = np.sin(aside), np.cos(aside)
    apart = 0.25 * p[PHI] * (p[ALONG] - p[V]) - (0.5 - beta) * (p[ALONG] * out[SLIDE] - deep * out[SLIDE + 2])
    out[SLIDE + 1] = apart / p[MPHI] - p[ARM] * out[SLIDE]


@compiled
def middle(p: Array, n: float, m: float) -> tuple[float, float, float, float]:
    """Where T acts in a joint at a place p (PLACE,), under N and P (n, m): at the centre of pressure, midway.

    Otherwise T at a corner (β = 0 or 1) would act along the face that the corner touches, although corner and face are
    pressed into each other. Returns its height, what the gap is less there than at the corner, and what the height
    changes per u and φ; zero where nothing presses.
    """
    if n <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    share, corner = 0.5 - p[BETA], p[U] - p[ARM] * p[PHI]
    if corner > 0.0:
        return -share * corner, 0.0, -share, share * p[ARM]
    e = min(max(m / n, -abs(p[H])), abs(p[H]))
    pressed = p[U] + e * p[PHI]
    if pressed > 0.0:
        return -2.0 * share * corner, -corner, -2.0 * share, 2.0 * share * p[ARM]
    return share * (pressed - 2.0 * corner), pressed - corner, -share, share * (e + 2.0 * p[ARM])


@compiled
def lay_shear(places: Array, forces: Array, turned: Array) -> None:
    """Let T act midway between the faces: `places` (j, PLACE) are changed.

    `forces` (j, 3): N, P and T, kN and kNm; `turned` (j,): rotation (rad) of block a against block b since slips are
    measured.
    """
    for k in range(len(places)):
        height = middle(places[k], forces[k, 0], forces[k, 1])[0]
        places[k, V] -= height * turned[k]
        places[k, MV] -= height


@compiled
def _pull(p: Array, n: float, out: Array) -> None:
    """The curvature of a tie of tension n: −n t tᵀ/|E| across its line, and of the turns of its ends' levers."""
    tx, tz, stiff = p[NZ], -p[NX], n * p[TIED]
    at_a = p[MV]
    at_b = at_a + p[LX] * tz - p[LZ] * tx - 1.0 / p[TIED]  # q × t
    out[0], out[1] = -stiff * at_a * tx, -stiff * at_a * tz
    out[2], out[3] = stiff * at_b * tx, stiff * at_b * tz
    out[4], out[6] = n * at_a - stiff * at_a * at_a, -n * at_b - stiff * at_b * at_b
    out[5] = stiff * at_a * at_b
    out[7], out[8], out[9] = -stiff * tx * tx, -stiff * tx * tz, -stiff * tz * tz
    out[SHIFTS:] = 0.0


@compiled
def curvatures(places: Array, forces: Array, out: Array) -> None:
    """How the forces N, P and T (j, 3) of joints at places (j, PLACE) change as these move, into `out` (j, CURVED)."""
    for k in range(len(places)):
        curvature(places[k], forces[k, 0], forces[k, 1], forces[k, 2], out[k])
