"""Mechanisms chosen by the user: α0 by virtual work, beside that of limit analysis (Circolare 7/2019, C8.7.1.2).

Macro-blocks rotate about given points: δ_x = −θ (z − z_C), δ_z = θ (x − x_C). Contact forces do no work where no
joint that is closed penetrates and none rubs, so that α0 = Σ W δ_z/Σ P δ_x is then an upper bound of the true one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from assessment.analyses.checks.virtual_work import virtual_displacements, virtual_work
from assessment.ntc.calculation import numbers, step
from assessment.ntc.capacity import CapacityCurve, capacity_curve
from assessment.ntc.capacity_return_period import stated
from assessment.ntc.curve_fit import fit_rigid
from assessment.ntc.verification import Method, check_linear
from assessment.results.faces import Met
from mechanics.model import Contacts, H, end_gaps, rows
from mechanics.steps import LIMIT, static_system
from mechanics.types import Index, Mask

if TYPE_CHECKING:
    from assessment.ntc.spectrum import Spectrum
    from assessment.project.mechanisms import Chosen
    from mechanics import Assembly

Array = NDArray[np.float64]
Numbers = dict[str, Any]

SLIGHT = 0.02  # of the largest displacement: penetration that a hinge set back from the edge may leave
ROUNDING = 1e-4  # of the largest displacement: what the digits of typed coordinates leave
BELOW = 1e-3  # how far an upper bound may fall below the multiplier of limit analysis
_LAW = "Circolare 7/2019, C8.7.1.2"


class MechanismError(ValueError):
    """A mechanism that cannot move as it was given, or that no horizontal load can start."""


@dataclass(frozen=True, eq=False)
class JointMotion:
    """What a mechanism does in the joints of a configuration.

    `penetration`: the deepest as a share of the largest displacement, between the blocks `pair`; `rubs` (j,): which of
    the `contacts` slide against friction.
    """

    penetration: float
    pair: tuple[int, int]
    contacts: Contacts
    rubs: Mask

    @property
    def rubbing(self) -> Index:
        """The contacts that rub."""
        return np.flatnonzero(self.rubs)


def joint_motion(model: Assembly, positions: Array, delta: Array) -> JointMotion:
    """Return what virtual displacements (b, 3) do in the joints closed at `positions` (b, 3).

    Only ends of faces that overlap and are closed count. A joint rubs where its slip exceeds what associative friction
    allows for the opening of a closed end, u_t > u_n/μ: friction there would do work.
    """
    contacts = static_system(model, "rigid").around(positions, LIMIT.onset * model.size).contacts
    places = contacts.places(positions)
    closed = (end_gaps(places) <= LIMIT.closed * model.size) & (places[:, H] > 0.0)[:, None]
    relative = np.concatenate([delta[contacts.a], delta[contacts.b]], axis=1)
    u, phi, v = np.einsum("jrc,jc->rj", rows(places), relative)
    half = places[:, H] * phi
    opening = np.where(closed, np.stack([u - half, u + half], axis=1), np.inf).min(axis=1)
    largest = float(abs(delta[:, :2]).max())
    worst = int(np.argmin(opening))
    least = np.maximum(contacts.friction, 1e-99)  # without friction nothing rubs
    rubs = closed.any(axis=1) & (
        abs(v) > np.maximum(opening, 0.0) / least + ROUNDING * largest / np.minimum(least, 1.0)
    )
    pair = (int(contacts.a[worst]), int(contacts.b[worst]))
    return JointMotion(max(0.0, -float(opening[worst]) / largest), pair, contacts, rubs)


def evaluate(
    model: Assembly,
    positions: Array,
    chosen: Chosen,
    confidence_factor: float,
    demands: Mapping[str, Spectrum],
    method: Method,
) -> Numbers:
    """Return α0 of a chosen mechanism at `positions` (b, 3), its direction, its linear checks and their steps.

    Raises MechanismError where blocks penetrate, where no weight moves horizontally, or where the weights drive the
    motion by themselves.
    """
    delta = virtual_displacements(model, positions, chosen)
    motion = joint_motion(model, positions, delta)
    penetration, pair = motion.penetration, motion.pair
    if penetration > SLIGHT:
        raise MechanismError(
            f"block {pair[0]} penetrates block {pair[1]} by {100.0 * penetration:.3g} % of the largest displacement; "
            "correct centres, rotations (anticlockwise positive) or the choice of blocks"
        )
    work = virtual_work(model, positions, chosen)
    if abs(work.lateral) <= 1e-9 * work.moving * float(abs(delta[:, :2]).max()):
        raise MechanismError("the weights do no horizontal work: no horizontal load starts it")
    alpha_0, e_star = work.alpha_0, work.e_star
    if alpha_0 <= 0.0:
        raise MechanismError(
            f"alpha_0 = {alpha_0:.4g}: the weights drive it without any horizontal load; change the sense of rotation"
        )
    capacity = capacity_curve(fit_rigid(([0.0, 1.0], [alpha_0, alpha_0])), e_star, 1.0, confidence_factor)
    last = step("a_0_star", "alpha_0/(e_star*F_C)", capacity.a_0_star, "g", _LAW, alpha_0=alpha_0, e_star=e_star,
                F_C=confidence_factor)  # fmt: skip
    met = Met(model)
    rubbing = met.numbers(motion.contacts, motion.rubs)[motion.rubbing].tolist()
    return {
        "direction": "+x" if work.lateral > 0.0 else "-x",
        "alpha_0": alpha_0,
        "e_star": e_star,
        "a_0_star_g": capacity.a_0_star,
        "moving_weight_kN": work.moving,
        "macro_blocks": [
            {"about_m": part.about.tolist(), "rotation": part.rotation, "blocks": part.blocks.tolist()}
            for part in chosen.parts
        ],
        "displacements": (delta / abs(delta[:, :2]).max()).tolist(),
        "penetration": penetration,
        "sliding_joints": rubbing,
        "met": met.joints,
        "notes": list(_notes(penetration, pair, rubbing)),
        "trace": numbers((*work.steps, *work.result_steps(), last)),
        **_checks(capacity, demands, method),
    }


def _checks(capacity: CapacityCurve, demands: Mapping[str, Spectrum], method: Method) -> Numbers:
    """Return the linear checks of the limit states up to SLV (C8.7.1.2)."""
    answers = {}
    for limit_state, spectrum in demands.items():
        if limit_state != "SLC":
            name = "SLV linear" if limit_state == "SLV" else limit_state
            answers[name] = check_linear(capacity, limit_state, spectrum, method)
    common = len(capacity.steps())
    return {
        name: {
            "a_star_g": check.a_star,
            "a_g_g": check.a_g,
            "demand_a_g_g": check.demand_a_g,
            "demand_a_star_g": check.demand_a_star,
            "zeta_E": check.zeta_E,
            "verified": check.verified,
            "return_period_years": check.return_period,
            "return_period_stated": stated(check.return_period),
            "trace": numbers(check.trace[common:]),
        }
        for name, check in answers.items()
    }


def compared(found: Numbers, alpha_0: float | None, alpha_onset: float | None) -> Numbers:
    """Return the mechanism with the α0 of its state in its direction, and a note where it lies below.

    In a settled state a hinge of the settlement may close at `alpha_onset` < α0: that is the limit analysis in the
    configuration of the state, of which a mechanism without sliding and penetration is an upper bound.
    """
    notes = list(found["notes"])
    if alpha_onset is not None and found["alpha_0"] < (1.0 - BELOW) * alpha_onset:
        notes.append(
            "alpha_0 is below that of limit analysis, which no mechanism without sliding and penetration can be: the "
            "friction of the sliding joints, or the penetration, is what it leaves out"
        )
    elif alpha_0 is not None and found["alpha_0"] < (1.0 - BELOW) * alpha_0:
        notes.append(
            f"alpha_0 is below that of the state, {alpha_0:.4g}: a hinge of the settlement closes from α = "
            f"{alpha_onset:.4g} on, before the structure moves as a whole"
        )
    return found | {"alpha_0_limit": alpha_0, "notes": notes}


def _notes(penetration: float, pair: tuple[int, int], rubbing: list[int]) -> list[str]:
    notes = []
    if penetration > ROUNDING:
        notes.append(
            f"block {pair[0]} penetrates block {pair[1]} by {100.0 * penetration:.2g} % of the largest displacement, "
            "as with a hinge set back from the edge"
        )
    if rubbing:
        notes.append(
            f"joints that slide as the mechanism moves: {len(rubbing)}; their friction is left out, so that alpha_0 is "
            "lower than with it"
        )
    return notes
