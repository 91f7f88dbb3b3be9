"""What the joints of a state carry, and how: resultants, where they cross, opening and slip."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from assessment.outlines import Array, outlines, place
from assessment.table import Results

IDLE = 1e-6  # of the model's weight: a joint that carries less carries nothing
EDGE = 0.02  # of the joint's length: a resultant so near its end makes a hinge
FRICTION = 0.99  # of μN: a joint about to slide
CONDITIONS = ("whole", "partial", "edge", "sliding", "idle")


@dataclass(frozen=True)
class Situation:
    """A state in equilibrium whose joint forces are known: at rest, or at the onset of a mechanism.

    `configuration` (b, 3), `force` (j, 2) kN on the first block of each joint, `centre` (j,) as a share of its length.
    `direction` is None at rest; `alpha` the multiplier there; `contacts`: the behaviour behind the forces.
    """

    state: str
    direction: str | None
    contacts: str
    alpha: float
    configuration: Array
    force: Array
    centre: Array


@dataclass(frozen=True)
class JointStates:
    """The joints in a situation.

    `ends` (j, 2, 2) m, moved with the first block; `point` (j, 2) where the resultant crosses; `normal`, `shear` (j,)
    kN, compression positive; `opening` (j, 2) m at the two ends; `slip` (j,) m; `condition` (j,) of CONDITIONS: the
    resultant within the middle third (the whole joint presses), outside it, at an edge, on the cone of friction; idle.
    """

    ends: Array
    point: Array
    normal: Array
    shear: Array
    opening: Array
    slip: Array
    condition: list[str]


def situations(results: Results) -> Iterator[Situation]:
    """Yield the rest of every state and the onset of every mechanism, where the forces were kept."""
    for name, content in results["states"].items():
        yield from _rest(name, content)
        for direction, pushover in (content.get("pushover") or {}).items():
            rigid = (pushover or {}).get("rigid") or {}
            point = (rigid.get("mechanism") or {}).get("point")
            if point is not None and "frames" in rigid:
                alpha = rigid["curve"]["multiplier"][point]
                yield from _at(name, direction, "rigid", alpha, rigid["frames"], point)


def _rest(name: str, content: Mapping[str, Any]) -> Iterator[Situation]:
    """Yield the rest under gravity: with elastic joints if it can be, where forces are determined."""
    for pushover in (content.get("pushover") or {}).values():
        elastic = (pushover or {}).get("elastic") or {}
        if "frames" in elastic:
            yield from _at(name, None, "elastic", 0.0, elastic["frames"], 0)
            return
    for contacts in ("elastic", "rigid"):
        stage = (content.get("pushdown") or {}).get(contacts) or {}
        if "frames" in stage:
            movement = np.asarray(stage["movement_m"])
            asked = int(np.argmin(abs(movement - stage["applied_movement_m"])))
            yield from _at(name, None, contacts, 0.0, stage["frames"], asked)
            return


def _at(
    name: str, direction: str | None, contacts: str, alpha: float, frames: Mapping[str, Any], point: int
) -> Iterator[Situation]:
    kept = frames["index"].index(point)
    if frames["force_kN"][kept] is not None:
        yield Situation(
            name,
            direction,
            contacts,
            alpha,
            np.asarray(frames["configuration"][kept], dtype=float),
            np.asarray(frames["force_kN"][kept], dtype=float),
            np.asarray(frames["centre"][kept], dtype=float),
        )


def joint_states(results: Results, situation: Situation) -> JointStates:
    """Derive what the joints do from the forces and the configuration of a situation."""
    joints, centroids = results["geometry"]["joints"], outlines(results).centroids
    first, second = np.array([joint["blocks"] for joint in joints], dtype=np.intp).T
    drawn = np.array([joint["ends_m"] for joint in joints], dtype=float)

    def moved(owner: Any) -> Array:
        return np.stack(
            [place(drawn[:, end], owner, centroids, situation.configuration) for end in (0, 1)], axis=1
        )

    ends, facing = moved(first), moved(second)
    along = facing[:, 1] - facing[:, 0]
    tangent = along / np.hypot(*along.T)[:, None]
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)  # out of the second block, into the first
    gap = ends - facing
    N, T = (situation.force * normal).sum(axis=1), (situation.force * tangent).sum(axis=1)
    share = np.where(np.isfinite(situation.centre), situation.centre, 0.5)
    opening = np.einsum("jei,ji->je", gap, normal)
    nearer = opening.argmin(axis=1)  # the end in contact: a joint that gapes slips there
    # null is infinite: JSON has no infinity
    friction = np.array([np.inf if joint["friction"] is None else joint["friction"] for joint in joints])
    idle = IDLE * results["model"]["weight_kN"] > N
    condition = np.select(
        [
            idle,
            abs(T) > friction * np.maximum(FRICTION * N, 1e-99),
            abs(share - 0.5) > 0.5 - EDGE,
            abs(share - 0.5) > 1.0 / 6.0,
        ],
        ["idle", "sliding", "edge", "partial"],
        "whole",
    )
    return JointStates(
        ends,
        ends[:, 0] + share[:, None] * (ends[:, 1] - ends[:, 0]),
        N,
        T,
        opening,
        (np.take_along_axis(gap, nearer[:, None, None], axis=1)[:, 0] * tangent).sum(axis=1),
        condition.tolist(),
    )


def thrust_lines(results: Results, states: JointStates) -> list[Array]:
    """Return a line (2, 2) m through each block that exactly two joints load: there the line of thrust is one."""
    loaded: dict[int, list[int]] = {}
    for number, joint in enumerate(results["geometry"]["joints"]):
        if states.condition[number] != "idle":
            for block in joint["blocks"]:
                loaded.setdefault(block, []).append(number)
    return [states.point[pair] for pair in loaded.values() if len(pair) == 2]
