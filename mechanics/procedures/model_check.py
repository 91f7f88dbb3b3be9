"""What the model says of every configuration, checked on positions and forces alone, whatever solver found them.

    where a joint presses, its faces touch       N > 0  ⇒  gap ≤ 0 at the centre of pressure
    friction holds no more than it can           |T| ≤ μN
    blocks do not lie in each other              gap ≥ 0

The gap is that beyond what an elastic bed yields under the forces; of motions, whose forces are those of a step, that
of the nearer end. What slides does not lift: a joint that sliding had lifted would press across a gap. Nearer than
LIMIT.closed counts as touching, here as in limit analysis. Ties have no faces, and faces of finite strength are not
where they were drawn once they have crushed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mechanics.errors import ConvergenceError
from mechanics.kernels.dynamics.program import RIGHT
from mechanics.kernels.joint import H
from mechanics.messages import Message, message
from mechanics.model.contacts import Contacts, end_gaps
from mechanics.program import bed_gaps, end_forces
from mechanics.steps.static_step import Equilibrium
from mechanics.steps.static_system import StaticSystem
from mechanics.steps.tolerances import LIMIT
from mechanics.types import Array

# of motions, whose steps hold velocities to the model: gaps of rigid joints may drift by SUNK of a block's size; FELT
# of its weight is a force
SUNK, FELT = 1e-2, 1e-2


def departure(step: Equilibrium) -> Message | None:
    """Return how an equilibrium departs from the model, None where it does not.

    A point that a law with dilation has found lifts where it slides.
    """
    system, half = step.system, abs(step.places[:, H])
    gaps, ends = end_gaps(step.places), end_forces(step.forces, half)
    if not system.rigid:
        gaps = gaps - bed_gaps(ends, half, system.law)
    ends = np.maximum(ends, 0.0)
    centre = (ends * gaps).sum(axis=1) / np.maximum(ends.sum(axis=1), 1e-300)
    overlaps = step.places[:, H] > system.no_overlap
    lifts = step.lifting or system.dilation > 0.0
    apart, inside = np.where(overlaps & (not lifts), centre, 0.0), np.where(overlaps, gaps.min(axis=1), 0.0)
    return _worst(system, step.forces, apart, inside)


def sound(found: Equilibrium) -> Equilibrium:
    """Return an equilibrium; raise ConvergenceError if it departs from the model: it is none."""
    wrong = departure(found)
    if wrong is not None:
        raise ConvergenceError(wrong)
    return found


def check_path(steps: Sequence[Equilibrium]) -> None:
    """Raise ConvergenceError if a point of a path departs from the model."""
    for point, step in enumerate(steps):
        wrong = departure(step)
        if wrong is not None:
            raise ConvergenceError(
                message("point {point} of the path is not valid: {reason}", point=point, reason=wrong)
            )


def departure_in_motion(
    system: StaticSystem, positions: Array, velocities: Array, forces: Array, step: float, unsure: float
) -> Message | None:
    """Return how a step of a motion departs from the model, None where it does not.

    `positions` and `velocities` (2, b, 3) at its beginning and end; `forces` (j, 3): N, P and T in between, kN and kNm;
    `step` in s. Faces may have met in between as far as their blocks go in a step, by the larger of both speeds, and
    rigid ones that slide may lift by RIGHT of the way of the fastest block. A program leaves force times gap of its
    share in what is `unsure` of the kinetic energy (kernels.dynamics.step). How deep elastic joints go is their law.
    """
    contacts = system.contacts
    places = [contacts.places(at) for at in positions]
    nearer = np.array([end_gaps(each).min(axis=1) for each in places])
    overlaps = np.all([each[:, H] > system.no_overlap for each in places], axis=0)
    speed = np.hypot(velocities[..., 0], velocities[..., 1]) + system.model.radius * abs(velocities[..., 2])
    lift = RIGHT * step * speed.max() if system.rigid else 0.0
    way = step * (speed[:, contacts.a] + speed[:, contacts.b]).max(axis=0) + lift
    kinetic = 0.5 * (system.model.mass * velocities**2).sum(axis=(1, 2)).max()
    left = 0.5 * unsure * kinetic / max(int((forces[:, 0] > 0.0).sum()), 1)
    apart = np.where(overlaps & (system.dilation == 0.0), nearer.min(axis=0) - way, 0.0)
    inside = np.where(overlaps & system.rigid, nearer.max(axis=0) + way, 0.0)
    apart[forces[:, 0] * apart <= left] = 0.0
    return _worst(system, forces, apart, inside, SUNK, FELT * system.weight)


def _worst(
    system: StaticSystem,
    forces: Array,
    apart: Array,
    inside: Array,
    deep: float = LIMIT.closed,
    felt: float = 0.0,
) -> Message | None:
    """Return what is wrong under forces (j, 3), kN, None if nothing is.

    `apart` (j,) m: gaps, where they are positive; `inside` (j,) m: the same where negative, allowed down to `deep`, as
    a share of a block's size. Forces up to `felt` (kN) press on nothing.
    """
    contacts, size = system.contacts, system.model.size
    n, _, t = forces.T
    faces = ~contacts.ties & np.isinf(contacts.strength)
    gap = np.where(faces & (n > max(system.least_force, felt)), apart, 0.0)
    depth = np.where(faces, -inside, 0.0)
    steep = np.isinf(contacts.friction)
    bound = np.where(steep, 0.0, contacts.friction) * n
    bound[steep & (n > LIMIT.idle * system.weight)] = np.inf
    beyond = np.where(contacts.ties, 0.0, abs(t) - bound)
    if (most := gap.max(initial=0.0)) > LIMIT.closed * size:
        pair = _blocks(contacts, gap)
        return message("{pair} press on each other across a gap of {size:.2g} m", pair=pair, size=float(most))
    if (most := depth.max(initial=0.0)) > deep * size:
        return message(
            "{pair} lie in each other by {size:.2g} m", pair=_blocks(contacts, depth), size=float(most)
        )
    if (most := beyond.max(initial=0.0)) > system.least_force:
        pair = _blocks(contacts, beyond)
        return message("friction between {pair} exceeds μN by {size:.2g} kN", pair=pair, size=float(most))
    return None


def _blocks(contacts: Contacts, size: Array) -> Message:
    """Return the blocks of the contact with the largest of sizes (j,)."""
    k = int(np.argmax(size))
    return message("blocks {first} and {second}", first=int(contacts.a[k]), second=int(contacts.b[k]))
