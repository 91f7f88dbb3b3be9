"""Mechanisms of macro-blocks that turn about their own hinges (C8.7.1.2.1.2): virtual work, α0, e*, finite motion."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from assessment.ntc.capacity_curve import Participation
from assessment.ntc.tables import Trace, datum, step, worked
from assessment.project.masonry import Chosen, RotatingBlocks
from assessment.results.frames import lengthenings
from assessment.results.schema import Line
from mechanics import Assembly, Tie
from mechanics.messages import SaidError, message
from mechanics.types import GRAVITY, Array, turned

_WORK = "virtual work; Circolare 7/2019, C8.7.1.2"
_TIE = "[[tie]]: yield force"
_SUMS = (  # symbol, unit, term of a macro-block
    ("L_W", "kN·m", "W_{k}*delta_z_{k}"),
    ("L_P", "kN·m", "P_{k}*delta_x_{k}"),
    ("Sigma_P", "kN", "P_{k}"),
    ("Sigma_P_delta_2", "kN·m²", "P_{k}*delta_x_{k}**2 + theta_{k}**2*J_{k}"),
)


@dataclass(frozen=True)
class VirtualWork:
    """Works (kN·m) of the weights `dead`, of them laid over towards +x `lateral`, of ties that yield; their steps.

    `moving`: seismic weight that moves, kN; `second`: Σ P δ_x², kN·m².
    """

    dead: float
    lateral: float
    moving: float
    second: float
    steps: Trace
    ties: float = 0.0

    @property
    def alpha_0(self) -> float:
        """α0 = (Σ W δ_z + Σ F e)/|Σ P δ_x|: what weights gain in height, and ties take, against the lateral load."""
        return (self.dead + self.ties) / abs(self.lateral)

    @property
    def e_star(self) -> float:
        """e* of the sums over the macro-blocks."""
        return Participation.of(self.moving, self.lateral, self.second).e_star

    def by_hand(self, delta_C: float) -> Trace:
        """Return the steps to α0, e* and last Γ*, of a control point that moves by δ_C along x."""
        resists, law = "(L_W + L_F)" if self.ties else "L_W", "Circolare 7/2019, C8.7.1.2"
        Gamma_star = self.second / (delta_C * self.lateral)
        return worked(
            *self.steps,
            step("alpha_0", f"{resists}/abs(L_P)", self.alpha_0, "", _WORK),
            step("e_star", "L_P**2/(Sigma_P*Sigma_P_delta_2)", self.e_star, "", law),
            datum("delta_C", delta_C, "m", "control point: virtual displacement"),
            step("Gamma_star", "Sigma_P_delta_2/(delta_C*L_P)", Gamma_star, "", law),
        )


def virtual_displacements(model: Assembly, positions: Array, chosen: Chosen) -> Array:
    """Return δ (b, 3): δ_x = −θ (z − z_C), δ_z = θ (x − x_C) of the centroids and θ; other blocks stay still."""
    delta = np.zeros((len(model.blocks), 3))
    for part in chosen.parts:
        x, z = (positions[part.blocks, :2] - part.about).T
        delta[part.blocks] = part.rotation * np.stack([-z, x, np.ones_like(x)], axis=1)
    return delta


def works(model: Assembly, positions: Array, delta: Array) -> tuple[float, float, list[tuple[Tie, float]]]:
    """Return Σ W δ_z and Σ P δ_x, kN·m, of virtual displacements δ (b, 3), and the ties that lengthen, by e (m)."""
    weight, seismic = _weights(model)
    longer = zip(model.ties, lengthenings(model, positions, delta).tolist(), strict=True)
    return (
        float(weight @ delta[:, 1]), float(seismic @ delta[:, 0]), [(tie, e) for tie, e in longer if e > 0.0],
    )  # fmt: skip


def virtual_work(model: Assembly, positions: Array, chosen: Chosen) -> VirtualWork:
    """Return the works of a chosen mechanism at `positions` (b, 3), and how they add up over the macro-blocks."""
    delta = virtual_displacements(model, positions, chosen)
    dead, lateral, stretched = works(model, positions, delta)
    _, seismic = _weights(model)
    moving = np.concatenate([part.blocks for part in chosen.parts])
    total, second = float(seismic[moving].sum()), float(seismic @ delta[:, 0] ** 2)
    numbered = list(enumerate(chosen.parts, 1))
    lines = [line for k, part in numbered for line in _macro_block(k, part, model, positions)]
    for (symbol, unit, term), value in zip(_SUMS, (dead, lateral, total, second), strict=True):
        lines.append(step(symbol, " + ".join(term.format(k=k) for k, _ in numbered), value, unit, _WORK))
    for k, (tie, more) in enumerate(stretched, 1):
        lines.append(datum(f"F_{k}", tie.yield_force, "kN", _TIE))
        lines.append(datum(f"e_{k}", more, "m", "virtual lengthening of the tie"))
    by_ties = sum(tie.yield_force * more for tie, more in stretched)
    if stretched:
        formula = " + ".join(f"F_{k}*e_{k}" for k in range(1, len(stretched) + 1))
        lines.append(step("L_F", formula, by_ties, "kN·m", _WORK))
    return VirtualWork(dead, lateral, total, second, worked(*lines), by_ties)


def _macro_block(k: int, part: RotatingBlocks, model: Assembly, positions: Array) -> list[Line]:
    """Return weights, centres and virtual displacements of the k-th macro-block."""
    weight, seismic = (each[part.blocks] for each in _weights(model))
    x, z = positions[part.blocks, :2].T
    W, P, (x_C, z_C), theta = float(weight.sum()), float(seismic.sum()), part.about.tolist(), part.rotation
    x_G, z_G = float(weight @ x / W), float(seismic @ z / P)
    J = float(seismic @ (z - z_G) ** 2)
    return [
        datum(f"W_{k}", W, "kN", "macro-block: weights and vertical loads"),
        datum(f"x_G_{k}", x_G, "m", "macro-block: where W acts"),
        datum(f"P_{k}", P, "kN", "macro-block: weights that are seismic mass"),
        datum(f"z_G_{k}", z_G, "m", "macro-block: where P acts"),
        datum(f"J_{k}", J, "kN·m²", "macro-block: sum of P (z - z_G)² over centroids"),
        datum(f"x_C_{k}", x_C, "m", "given: centre of rotation"),
        datum(f"z_C_{k}", z_C, "m", "given: centre of rotation"),
        datum(f"theta_{k}", theta, "", "given: virtual rotation, anticlockwise positive"),
        step(f"delta_x_{k}", f"-theta_{k}*(z_G_{k} - z_C_{k})", -theta * (z_G - z_C), "m", _WORK),
        step(f"delta_z_{k}", f"theta_{k}*(x_G_{k} - x_C_{k})", theta * (x_G - x_C), "m", _WORK),
    ]


def _weights(model: Assembly) -> tuple[Array, Array]:
    """Return the vertical forces and the seismic weights (b,) of the blocks, kN."""
    weight = np.array([block.weight for block in model.blocks])
    return weight, GRAVITY * np.array([block.mass for block in model.blocks])


Closed = tuple[NDArray[np.intp], NDArray[np.intp], Array]
"""Closed joints: blocks a and b (j,), ends (j, 2, 2) m of where they overlap."""


@dataclass(frozen=True, slots=True)
class KinematicsTolerances:
    """Tolerances of the finite motion of a mechanism."""

    # distance of a centre of rotation from a joint, over its length, up to which it is a hinge of it, set back or not
    hinge: float = 0.02
    # difference of the rotations of two macro-blocks, over the largest, up to which they have no relative centre
    alike: float = 1e-9
    step: float = 0.002  # rad, of the macro-block that turns fastest
    farthest: float = 1.0  # rad: by then α has vanished in every mechanism
    open: float = 1e-6  # largest gap of a hinge from the integration, over the model's size
    overlap: float = 1e-3  # of two blocks that does not stop the motion, over the smallest block's area
    grid: float = 1e-9  # step of the grid on which they are laid over each other, over the model's size


MOTION = KinematicsTolerances()


class KinematicsError(SaidError, ValueError):
    """A mechanism whose hinges do not determine its motion, or whose motion is stopped before α = 0."""


class Hinge(NamedTuple):
    """A point (x, z), m, that two macro-blocks share; they are given by number, None: the blocks that do not move."""

    first: int
    second: int | None
    point: tuple[float, float]


def hinges_of(chosen: Chosen, closed: Closed) -> list[Hinge]:
    """Return the centres of relative rotation that lie on a closed joint between the two macro-blocks."""
    owner = {int(block): k for k, part in enumerate(chosen.parts) for block in part.blocks}
    joints = defaultdict[tuple[int, ...], list[Array]](list)  # their ends by macro-blocks, still: −1
    for a, b, ends in zip(*closed, strict=True):
        joints[tuple(sorted({owner.get(int(a), -1), owner.get(int(b), -1)}))].append(ends)
    largest = max(abs(part.rotation) for part in chosen.parts)
    found = []
    for pair in sorted(pair for pair in joints if len(pair) == 2):
        still, moving = pair[0] < 0, chosen.parts[pair[1]]
        other, turns = (None, 0.0) if still else (chosen.parts[pair[0]], chosen.parts[pair[0]].rotation)
        if abs(moving.rotation - turns) <= MOTION.alike * largest:
            continue
        centre = moving.rotation * moving.about - (0.0 if other is None else turns * other.about)
        point = np.asarray(centre / (moving.rotation - turns))
        lines, at = shapely.linestrings(joints[pair]), shapely.Point(point)
        if (shapely.distance(lines, at) <= MOTION.hinge * shapely.length(lines)).any():
            found.append(Hinge(pair[1], None if still else pair[0], (float(point[0]), float(point[1]))))
    return found


def finite_motion(model: Assembly, start: Array, chosen: Chosen, hinges: list[Hinge]) -> tuple[Array, Array]:
    """Return positions (k, b, 3) and multipliers (k,) of a mechanism until α = 0. Raises KinematicsError."""
    origin = np.array([start[part.blocks, :2].mean(axis=0) for part in chosen.parts])
    parts = _Parts([part.blocks for part in chosen.parts], origin, hinges)
    q = np.zeros((len(chosen.parts), 3))
    rate = parts.rate(q, np.array([part.rotation for part in chosen.parts]))
    at, alpha = [start], [_multiplier(model, start, parts.motion(start, q, rate))]
    rotation = 0.0
    while alpha[-1] > 0.0:
        if rotation > MOTION.farthest:
            raise KinematicsError(message("α is still {alpha:.3g} after a rotation of {turned:.3g} rad",
                                          alpha=alpha[-1], turned=rotation))  # fmt: skip
        q = parts.step(q, rate)
        rate = parts.rate(q, rate[:, 2])
        rotation += MOTION.step
        at.append(parts.placed(start, q))
        alpha.append(_multiplier(model, at[-1], parts.motion(at[-1], q, rate)))
    if parts.drift(q) > MOTION.open * model.size:
        opened = message("its hinges do not stay closed as it moves: there are more of them than it can keep")
        raise KinematicsError(opened)
    _unhindered(model, at, parts.blocks)
    return np.array(at), np.array(alpha)


@dataclass(frozen=True, eq=False)
class _Parts:
    """Macro-blocks and their hinges; q (n, 3): translation of the origin of each part and its rotation."""

    blocks: list[NDArray[np.intp]]
    origin: Array
    hinges: list[Hinge]

    def arm(self, q: Array, part: int, point: Array) -> Array:
        """Return the vector (m) from a part's origin to its material point (2,), or points (m, 2)."""
        return turned(point - self.origin[part], q[part, 2])

    def rate(self, q: Array, rotations: Array) -> Array:
        """Return rates (n, 3), fastest 1, of closed hinges that turn like `rotations`. Raises KinematicsError."""
        rows = np.zeros((2 * len(self.hinges), 3 * len(q)))
        for k, hinge in enumerate(self.hinges):
            for part, sign in ((hinge.first, 1.0), (hinge.second, -1.0)):
                if part is not None:
                    x, z = self.arm(q, part, np.array(hinge.point))
                    rows[2 * k, [3 * part, 3 * part + 2]] = sign, -sign * z
                    rows[2 * k + 1, [3 * part + 1, 3 * part + 2]] = sign, sign * x
        size = max(1.0, float(abs(rows).max(initial=0.0)))
        _, values, right = np.linalg.svd(rows, full_matrices=True)
        free = rows.shape[1] - int((values > 1e-7 * size).sum())
        if free != 1:
            raise KinematicsError(message(
                "the hinges between its macro-blocks, points of joints that are closed, leave it "
                "{count} independent motions, not one: it slides, or a centre lies on no joint", count=free,
            ))  # fmt: skip
        found = right[-1].reshape(-1, 3)
        found = found / abs(found[:, 2]).max()
        return found if found[:, 2] @ rotations > 0.0 else -found

    def step(self, q: Array, rate: Array) -> Array:
        """Return q (n, 3) after a step of the fastest rotation (Runge-Kutta, fourth order)."""
        turns = rate[:, 2]
        k2 = self.rate(q + 0.5 * MOTION.step * rate, turns)
        k3 = self.rate(q + 0.5 * MOTION.step * k2, turns)
        k4 = self.rate(q + MOTION.step * k3, turns)
        return np.asarray(q + MOTION.step / 6.0 * (rate + 2.0 * k2 + 2.0 * k3 + k4))

    def placed(self, positions: Array, q: Array) -> Array:
        """Return the positions (b, 3) of all blocks."""
        moved = positions.copy()
        for k, blocks in enumerate(self.blocks):
            moved[blocks, :2] = self.origin[k] + q[k, :2] + self.arm(q, k, positions[blocks, :2])
            moved[blocks, 2] += q[k, 2]
        return moved

    def motion(self, at: Array, q: Array, rate: Array) -> Array:
        """Return the rates (b, 3) of all blocks at `at` (b, 3)."""
        delta = np.zeros_like(at)
        for k, blocks in enumerate(self.blocks):
            x, z = (at[blocks, :2] - self.origin[k] - q[k, :2]).T
            turn = np.full_like(x, rate[k, 2])
            delta[blocks] = np.stack([rate[k, 0] - turn * z, rate[k, 1] + turn * x, turn], axis=1)
        return delta

    def drift(self, q: Array) -> float:
        """Return the largest gap (m) between the two sides of a hinge, at the parts' q (n, 3)."""
        apart = [0.0]
        for hinge in self.hinges:
            point = np.array(hinge.point)
            sides = [
                point if part is None else self.origin[part] + q[part, :2] + self.arm(q, part, point)
                for part in (hinge.first, hinge.second)
            ]
            apart.append(float(np.hypot(*(sides[0] - sides[1]))))
        return max(apart)


def _multiplier(model: Assembly, at: Array, delta: Array) -> float:
    """Return α = (Σ W δ_z + Σ F e)/|Σ P δ_x| at `at` (b, 3). Raises KinematicsError where a tie stops the motion."""
    dead, lateral, stretched = works(model, at, delta)
    for tie, _ in stretched:
        if np.isinf(tie.yield_force):
            raise KinematicsError(message('tie "{name}" stops it before α = 0', name=tie.name))
    return (dead + sum(tie.yield_force * more for tie, more in stretched)) / abs(lateral)


def _unhindered(model: Assembly, at: list[Array], parts: Sequence[NDArray[np.intp]]) -> None:
    """Raise KinematicsError if blocks of different macro-blocks overlap in a motion that do not at its start."""
    owner = np.full(len(model.blocks), -1)
    for k, blocks in enumerate(parts):
        owner[blocks] = k
    least = MOTION.overlap * min(block.area for block in model.blocks)
    for positions in [*at[1 : -1 : max(1, len(at) // 20)], at[-1]]:
        placed = zip(model.blocks, positions, strict=True)
        outlines = [_outline(block.polygon - block.centroid, *place) for block, place in placed]
        pairs = shapely.STRtree(outlines).query(outlines, predicate="intersects").T
        for i, j in pairs[owner[pairs[:, 0]] < owner[pairs[:, 1]]].tolist():
            if _shared(model, positions, i, j) > least + _shared(model, at[0], i, j):
                first, second = sorted((i, j))
                met = message("block {block} runs into block {other} before α = 0", block=first, other=second)
                raise KinematicsError(met)


def _shared(model: Assembly, positions: Array, i: int, j: int) -> float:
    """Return the area (m²) that two blocks share, on a grid about the first: plain overlays may give a whole block."""
    near = positions - np.append(positions[i, :2], 0.0)
    one, other = (_outline(model.blocks[k].polygon - model.blocks[k].centroid, *near[k]) for k in (i, j))
    return float(shapely.intersection(one, other, grid_size=MOTION.grid * model.size).area)


def _outline(corners: Array, x: float, z: float, rotation: float) -> shapely.Polygon:
    return shapely.Polygon(np.array([x, z]) + turned(corners, rotation))
