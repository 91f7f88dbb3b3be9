"""The least load multiplier of all flows by Coulomb's law, by mixed-integer programming (HiGHS).

An independent referee of limit analysis: forces, velocities and which of both vanish at each contact are unknowns of
one program, whose optimum is global. Contacts are the corners of the referee of motions (contact_dynamics).
"""

import numpy as np
from scipy import sparse
from scipy.optimize import Bounds, LinearConstraint, milp

from mechanics import Assembly
from mechanics.types import Array
from tests.support.contact_dynamics import Bodies, ends_of_overlap

MOST_FORCE, MOST_SPEED = 60.0, 60.0  # per weight, and per velocity of unit work: bounds of the disjunctions
KINDS = [
    "alpha", "normal", "tangential", "velocity", "gap", "forth", "back", "pressed", "holds_forth",
    "holds_back",
]  # fmt: skip


def least_multiplier(model: Assembly) -> float:
    """Return the least α ≥ 0 of +x with which forces and velocities of unit work obey Coulomb's law."""
    normal, tangential, friction, dead, lateral = _contacts(model)
    c, n = normal.shape
    sizes = [1, c, c, n, *[c] * 6]
    at = dict(zip(KINDS, np.cumsum([0, *sizes[:-1]]), strict=True))
    total, one = sum(sizes), sparse.identity(c)
    rules: list[LinearConstraint] = []

    def rule(low: Array | float, high: Array | float, **parts: object) -> None:
        """Add low ≤ Σ matrix · unknowns ≤ high."""
        matrix = sparse.lil_matrix((parts[next(iter(parts))].shape[0], total))  # type: ignore[attr-defined]
        for kind, part in parts.items():
            matrix[:, at[kind] : at[kind] + part.shape[1]] = part  # type: ignore[attr-defined]
        rules.append(LinearConstraint(matrix.tocsr(), low, high))

    rule(-dead, -dead, alpha=lateral[:, None], normal=normal.T, tangential=tangential.T)
    rule(0.0, 0.0, velocity=normal, gap=-one)
    rule(0.0, 0.0, velocity=tangential, forth=-one, back=one)
    rule(1.0, 1.0, velocity=lateral[None])
    rule(-np.inf, 0.0, gap=one, pressed=-MOST_SPEED * one)
    rule(-np.inf, MOST_FORCE, normal=one, pressed=MOST_FORCE * one)
    for sign, slip in ((1.0, "forth"), (-1.0, "back")):
        bound, chosen = sparse.diags(friction), f"holds_{slip}"
        rule(0.0, np.inf, normal=bound, tangential=sign * one)
        rule(-np.inf, MOST_FORCE, normal=bound, tangential=sign * one, **{chosen: MOST_FORCE * one})
        rule(-np.inf, 0.0, **{slip: one, chosen: -MOST_SPEED * one})
    low, high = np.zeros(total), np.full(total, np.inf)
    low[at["tangential"] : at["gap"]] = -np.inf
    high[0], high[at["normal"] : at["tangential"]] = 10.0, MOST_FORCE
    high[at["gap"] : at["pressed"]], high[at["pressed"] :] = MOST_SPEED, 1.0
    whole = np.arange(total) >= at["pressed"]
    found = milp(
        np.arange(total) == 0, integrality=whole, bounds=Bounds(low, high), constraints=rules,
        options={"mip_rel_gap": 1e-5},
    )  # fmt: skip
    assert found.status == 0, found.message
    return float(found.x[0])


def _contacts(model: Assembly) -> tuple[Array, Array, Array, Array, Array]:
    """Return normal and tangential motion (c, n) of contacts, their friction (c,), and loads (n,) per weight."""
    bodies = Bodies.of(model)
    pairs, count = bodies.pairs, len(bodies.drawn)
    rows, gaps = np.zeros((2 * len(pairs), 2, 2, 3)), np.empty(2 * len(pairs))
    ends_of_overlap(bodies.drawn, bodies.arms, bodies.owner[pairs], pairs, 2e-3 * bodies.size, rows, gaps)
    touching = np.flatnonzero(abs(gaps) < 1e-9 * bodies.size)
    movable = np.flatnonzero(bodies.mass[:, 0] > 0.0)
    motion = np.zeros((2, len(touching), count, 3))
    for i, q in enumerate(touching):
        for side, block in enumerate(bodies.owner[pairs[q // 2]]):
            motion[:, i, block] += rows[q, :, side] / (1.0, 1.0, bodies.size)
    normal, tangential = motion[:, :, movable].reshape(2, len(touching), -1)
    share = bodies.mass[movable, 0] / bodies.mass[movable, 0].sum()
    dead, lateral = np.zeros((len(movable), 3)), np.zeros((len(movable), 3))
    dead[:, 1], lateral[:, 0] = -share, share
    return normal, tangential, bodies.friction[touching // 2], dead.ravel(), lateral.ravel()
