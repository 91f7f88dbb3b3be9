"""The virtual work of the weights, and of ties that yield, on a mechanism of macro-blocks, by hand: α0 and e*."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from assessment.ntc.calculation import Step, Trace, datum, names, step
from assessment.results.configurations.ties import lengthenings
from mechanics.types import GRAVITY

if TYPE_CHECKING:
    from assessment.project.structure.places import Chosen, MacroBlock
    from mechanics import Assembly

Array = NDArray[np.float64]

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
    """Works of the weights `dead` and of the same weights laid over towards +x `lateral` (kN·m); their steps.

    `moving`: seismic weight that moves, kN; `second`: Σ P δ_x², kN·m²; `ties`: Σ F e of the ties that yield, kN·m.
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
        """e* = (Σ P δ_x)²/(Σ P Σ P δ_x²)."""
        return self.lateral**2 / (self.moving * self.second)

    def result_steps(self) -> Trace:
        """Return α0 and e* by hand, where the lateral load does work."""
        by_weights = step("alpha_0", "L_W/abs(L_P)", self.alpha_0, "", _WORK, L_W=self.dead, L_P=self.lateral)
        with_ties = step("alpha_0", "(L_W + L_F)/abs(L_P)", self.alpha_0, "", _WORK, L_W=self.dead,
                         L_F=self.ties, L_P=self.lateral)  # fmt: skip
        return (
            with_ties if self.ties else by_weights,
            step("e_star", "L_P**2/(Sigma_P*Sigma_P_delta_2)", self.e_star, "", "Circolare 7/2019, C8.7.1.2",
                 L_P=self.lateral, Sigma_P=self.moving, Sigma_P_delta_2=self.second),
        )  # fmt: skip

    def participation_steps(self, delta_C: float) -> tuple[Step, ...]:
        """Return Γ* by hand, of a control point that moves by δ_C along x."""
        return (
            datum("delta_C", delta_C, "m", "control point: virtual displacement"),
            step("Gamma_star", "Sigma_P_delta_2/(delta_C*L_P)", self.second / (delta_C * self.lateral), "",
                 "Circolare 7/2019, C8.7.1.2", Sigma_P_delta_2=self.second, delta_C=delta_C, L_P=self.lateral),
        )  # fmt: skip


def virtual_displacements(model: Assembly, positions: Array, chosen: Chosen) -> Array:
    """Return δ (b, 3): δ_x = −θ (z − z_C), δ_z = θ (x − x_C) of the centroids and θ; other blocks stay still."""
    delta = np.zeros((len(model.blocks), 3))
    for part in chosen.parts:
        x, z = (positions[part.blocks, :2] - part.about).T
        delta[part.blocks] = part.rotation * np.stack([-z, x, np.ones_like(x)], axis=1)
    return delta


def works(model: Assembly, positions: Array, delta: Array) -> tuple[float, float, list[float]]:
    """Return Σ W δ_z, Σ P δ_x and the work F e of each tie that lengthens, kN·m, of virtual displacements δ (b, 3).

    That of a tie that never yields is infinite.
    """
    weight, seismic = _weights(model)
    longer = lengthenings(model, positions, delta)
    ties = [tie.yield_force * float(e) if e > 0.0 else 0.0 for tie, e in zip(model.ties, longer, strict=True)]
    return float(weight @ delta[:, 1]), float(seismic @ delta[:, 0]), ties


def virtual_work(model: Assembly, positions: Array, chosen: Chosen) -> VirtualWork:
    """Return the works of a chosen mechanism at `positions` (b, 3), and how they add up over the macro-blocks."""
    delta = virtual_displacements(model, positions, chosen)
    dead, lateral, ties = works(model, positions, delta)
    _, seismic = _weights(model)
    moving = np.concatenate([part.blocks for part in chosen.parts])
    total, second = float(seismic[moving].sum()), float(seismic @ delta[:, 0] ** 2)
    lines: list[Step] = []
    for k, part in enumerate(chosen.parts, 1):
        lines += _macro_block(k, part, model, positions)
    known = {line.symbol: line.result for line in lines}
    for (symbol, unit, term), value in zip(_SUMS, (dead, lateral, total, second), strict=True):
        formula = " + ".join(term.format(k=k) for k in range(1, len(chosen.parts) + 1))
        lines.append(step(symbol, formula, value, unit, _WORK, **{n: known[n] for n in names(formula)}))
    stretched = lengthenings(model, positions, delta)
    yielding = [(tie.yield_force, float(e)) for tie, e in zip(model.ties, stretched, strict=True) if e > 0.0]
    lines += _tie_lines(yielding)
    return VirtualWork(dead, lateral, total, second, tuple(lines), sum(ties))


def _tie_lines(yielding: list[tuple[float, float]]) -> list[Step]:
    """Return the work of ties from their yield forces (kN) and virtual lengthenings (m)."""
    lines: list[Step] = []
    for k, (force, more) in enumerate(yielding, 1):
        lines.append(datum(f"F_{k}", force, "kN", _TIE))
        lines.append(datum(f"e_{k}", more, "m", "virtual lengthening of the tie"))
    if yielding:
        formula = " + ".join(f"F_{k}*e_{k}" for k in range(1, len(yielding) + 1))
        known = {line.symbol: line.result for line in lines}
        total = sum(force * more for force, more in yielding)
        lines.append(step("L_F", formula, total, "kN·m", _WORK, **{n: known[n] for n in names(formula)}))
    return lines


def _macro_block(k: int, part: MacroBlock, model: Assembly, positions: Array) -> list[Step]:
    """Return weights, centres and virtual displacements of the k-th macro-block."""
    weight, seismic = (each[part.blocks] for each in _weights(model))
    x, z = positions[part.blocks, :2].T
    W, P, (x_C, z_C), theta = float(weight.sum()), float(seismic.sum()), part.about.tolist(), part.rotation
    x_G, z_G = float(weight @ x / W), float(seismic @ z / P)
    return [
        datum(f"W_{k}", W, "kN", "macro-block: weights and vertical loads"),
        datum(f"x_G_{k}", x_G, "m", "macro-block: where W acts"),
        datum(f"P_{k}", P, "kN", "macro-block: weights that are seismic mass"),
        datum(f"z_G_{k}", z_G, "m", "macro-block: where P acts"),
        datum(f"J_{k}", float(seismic @ (z - z_G) ** 2), "kN·m²", "macro-block: sum of P (z - z_G)² over centroids"),
        datum(f"x_C_{k}", x_C, "m", "given: centre of rotation"),
        datum(f"z_C_{k}", z_C, "m", "given: centre of rotation"),
        datum(f"theta_{k}", theta, "", "given: virtual rotation, anticlockwise positive"),
        step(f"delta_x_{k}", f"-theta_{k}*(z_G_{k} - z_C_{k})", -theta * (z_G - z_C), "m", _WORK,
             **{f"theta_{k}": theta, f"z_G_{k}": z_G, f"z_C_{k}": z_C}),
        step(f"delta_z_{k}", f"theta_{k}*(x_G_{k} - x_C_{k})", theta * (x_G - x_C), "m", _WORK,
             **{f"theta_{k}": theta, f"x_G_{k}": x_G, f"x_C_{k}": x_C}),
    ]  # fmt: skip


def _weights(model: Assembly) -> tuple[Array, Array]:
    """Return the vertical forces and the seismic weights (b,) of the blocks, kN."""
    weight = np.array([block.weight for block in model.blocks])
    return weight, GRAVITY * np.array([block.mass for block in model.blocks])
