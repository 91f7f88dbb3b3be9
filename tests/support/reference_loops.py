"""Compiled loops once more in plain NumPy, from the definitions: what the tests compare them with."""

from collections.abc import Callable

import numpy as np

from mechanics.kernels.joint import A1, A2, B1, B2, PX, PZ, QX, QZ, TAX, TAZ, TBX, TBZ
from mechanics.kernels.law import DILATION, FRICTION, SHEAR
from mechanics.model.assembly import Assembly
from mechanics.types import Array


def turned(v: Array, angle: float) -> Array:
    """Vectors (..., 2) turned by an angle (rad)."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.asarray(v) @ np.array([[cos, sin], [-sin, cos]])


def scattered(model: Assembly, seed: int, amount: float) -> Array:
    """Positions about the drawn ones: every block moved, per block size, and turned by its own random amount."""
    off = np.random.default_rng(seed).uniform(-amount, amount, model.initial.positions.shape)
    return model.initial.positions + off * (model.size, model.size, 1.0)


def derivative(function: Callable[[Array], Array], size: float = 1e-5, at: Array | float = 0.0) -> Array:
    """Central differences along each of six displacements, first index."""
    steps = size * np.eye(6)
    return np.array([(function(at + step) - function(at - step)) / (2.0 * size) for step in steps])


class Pair:
    """Two faces in the configuration xa, xb (3,): the overlap, and u, φ, v of any share β of the two frames."""

    def __init__(self, face: Array, xa: Array, xb: Array) -> None:
        self.face, self.xa, self.xb = face, xa, xb
        self.ta, self.tb = turned(face[[TAX, TAZ]], xa[2]), turned(face[[TBX, TBZ]], xb[2])
        self.p, self.q = xa[:2] + turned(face[[PX, PZ]], xa[2]), xb[:2] + turned(face[[QX, QZ]], xb[2])
        cross = self.tb[0] * self.ta[1] - self.tb[1] * self.ta[0]
        self.delta = float(np.arctan2(cross, self.tb @ self.ta))
        middle = (self.ta + self.tb) / np.linalg.norm(self.ta + self.tb)
        self.slid = float(middle @ (self.p - self.q))

    @property
    def overlap(self) -> tuple[float, float]:
        """Where both faces are, along a's from its reference point."""
        f = self.face
        return max(f[A1], f[B1] - self.slid), min(f[A2], f[B2] - self.slid)

    @property
    def upper(self) -> bool:
        """Whether the more closed end is the upper one."""
        return self.delta <= 0.0

    @property
    def beyond(self) -> float:
        """How far b's face goes on past a's there; negative: a's past b's."""
        f = self.face
        return float(f[B2] - self.slid - f[A2] if self.upper else f[A1] - f[B1] + self.slid)

    def beta(self) -> float:
        """0 where a corner of a ends the overlap there, 1 where one of b does, linear within 1/100 of the face."""
        f = self.face
        meet = 0.003 * min(f[A2] - f[A1], f[B2] - f[B1])
        return float(np.clip(0.5 - 0.5 * self.beyond / meet, 0.0, 1.0))

    def arm(self) -> float:
        """From the end, which lies between the two corners as the share β has it, to the middle of the overlap."""
        end = (
            self.face[A2] + self.beta() * self.beyond
            if self.upper
            else self.face[A1] - self.beta() * self.beyond
        )
        return float(0.5 * sum(self.overlap) - end)

    def measures(self, beta: float, arm: float, upper: bool) -> Array:
        """u, φ and v (3,): gap at the distance `arm` from the closed end, in the frame of a share β."""
        f = self.face
        a, b = (f[A2], f[B2]) if upper else (f[A1], f[B1])
        t = turned(self.tb, beta * self.delta)
        n = np.array([-t[1], t[0]])
        e = self.p + a * self.ta - self.q - b * self.tb
        phi = np.sin((1.0 - beta) * self.delta) + np.sin(beta * self.delta)
        return np.array([n @ e + arm * phi, phi, t @ e + b - a])


def joint_newton(
    h: float, law: Array, know: Array, columns: dict[str, int], target: float
) -> tuple[Array, Array]:
    """The linearised laws of a joint, solved for its unknowns: changes at rest, (7,), and per unit u, φ, v, (7, 3).

    Unknown: N₁, N₂, T, y₁, y₂, λ₊, λ₋. `know`: the iterate and what it misses, in its `columns`.
    """
    s = {name: float(know[at]) for name, at in columns.items()}
    mu, shear = law[FRICTION], law[SHEAR]
    kappa2 = s["BETA"] / (s["N1"] + s["N2"])  # 2κ
    both, beta = s["Y1"] + s["Y2"], s["BETA"]
    a, b, c = np.zeros((7, 7)), np.zeros(7), np.zeros((7, 3))
    compliance = [(-s["S11"], s["S12"]), (s["S12"], -s["S22"])]
    for end in range(2):
        # w(N) + y − 2κN(y₁ + y₂) + ψμ(λ₊ + λ₋) = u ∓ hφ
        a[end, :2] = np.array(compliance[end]) - kappa2 * both
        a[end, 3:5] = -beta
        a[end, 3 + end] += 1.0
        a[end, 5:] = law[DILATION] * mu
        b[end] = -s[f"E{end + 1}"]
        c[end] = 1.0, (-h, h)[end], 0.0
        # (N − κN²) y = τ
        a[3 + end, :2] = -beta * s[f"Y{end + 1}"]
        a[3 + end, end] += s[f"Y{end + 1}"]
        a[3 + end, 3 + end] = s[f"G{end + 1}"]
        b[3 + end] = target - s[f"G{end + 1}"] * s[f"Y{end + 1}"]
    a[2, 2], a[2, 5], a[2, 6] = -shear, 1.0, -1.0
    b[2], c[2] = -s["SLIP"], (0.0, 0.0, 1.0)
    for side, sign, slip, room in ((5, 1.0, "LP", "ZP"), (6, -1.0, "LM", "ZM")):
        a[side, :2] = mu * s[slip]
        a[side, 2] = sign * s[slip]
        a[side, side] = s[room]
        b[side] = target - s[slip] * s[room]
    return np.linalg.solve(a, b), np.linalg.solve(a, c)


def bed_resultants(u: float, phi: float, half: float, stiffness: float) -> Array:
    """Energy, N and P (3,) of a bed by the trapezoidal rule."""
    s = np.linspace(-half, half, 20_001)
    closed = np.maximum(-(u + phi * s), 0.0)
    each = 0.5 * stiffness * closed**2, stiffness * closed, stiffness * closed * s
    return np.array([np.trapezoid(values, s) for values in each])


def bed_of_points(u: float, phi: float, half: float, stiffness: float, segments: int) -> Array:
    """Energy, N and P (3,) of springs at the ends of equal segments, each half a segment of the bed."""
    s = np.linspace(-half, half, segments + 1)
    k = np.full(segments + 1, 2.0 * half * stiffness / segments)
    k[[0, -1]] *= 0.5
    closed = np.maximum(-(u + phi * s), 0.0)
    return np.array([0.5 * k @ closed**2, k @ closed, k @ (closed * s)])
