"""Mirror symmetry: a push of a symmetric structure towards −x is the mirror image of that towards +x."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from mechanics.messages import Field, Message
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.procedures.pushover import Pushover
from mechanics.steps.static_step import Equilibrium
from mechanics.types import Array, Index

EXACT = 1e-9  # of the model's extent, and of its loads and stiffnesses: a difference that is rounding
TURNED = np.array([-1.0, 1.0, -1.0])  # factors on x, z and ω in the image


@dataclass(frozen=True, eq=False)
class Mirror:
    """The reflection in the plane x = `axis` (m) that maps a drawn model onto itself.

    `block` (b,), `joint` (j,): index of the block, and of the drawn joint or tie, that is the image of each; `moment`
    (j,): factor on P, −1, or 1 where the joint's two blocks are exchanged.
    """

    model: Assembly
    axis: float
    block: Index
    joint: Index
    moment: Array

    @classmethod
    def of(cls, model: Assembly, behaviour: Behaviour) -> Mirror | None:
        """Return the mirror of a model; None if the image of a block, load, joint or tie is not exactly one of it."""
        corner = model.from_origin(np.concatenate([block.polygon for block in model.blocks]))
        x = corner[:, 0]
        axis, extent = 0.5 * float(x.min() + x.max()), float(np.ptp(x))
        centre = model.initial.positions[:, :2]
        block = _matched(centre, [2.0 * axis, 0.0] + centre * [-1.0, 1.0], EXACT * extent)
        if block is None or (model.movable[block] != model.movable).any():
            return None
        if not _same(model.dead_load[block], model.dead_load * TURNED):
            return None
        if not _same(model.mass[block], model.mass):
            return None
        if not _same(model.lateral_load("+x")[block], model.lateral_load("-x") * TURNED):
            return None
        contacts = model.contacts
        # corners and joints are shifted by their blocks: only those of the same blocks can match
        apart = 10.0 * extent
        of = np.repeat(np.arange(len(model.blocks)), [len(block.polygon) for block in model.blocks])
        flipped = [2.0 * axis, 0.0] + corner * [-1.0, 1.0]
        shapes = _matched(
            np.column_stack([apart * of, corner]),
            np.column_stack([apart * block[of], flipped]),
            EXACT * apart,
        )
        ties = np.array([tie.points for tie in model.ties]).reshape(-1, 2, 2)
        ends = model.from_origin(np.concatenate([model.joints.ends, ties]))
        owner = np.sort(np.stack([contacts.a, contacts.b], axis=1), axis=1)
        middle, along = ends.mean(axis=1), _along(ends)
        joint = _matched(
            np.column_stack([apart * owner, middle, along, apart * contacts.ties]),
            np.column_stack(
                [
                    apart * np.sort(block[owner], axis=1),
                    [2.0 * axis, 0.0] + middle * [-1.0, 1.0],
                    along * [1.0, 1.0, -1.0],
                    apart * contacts.ties,
                ]
            ),
            EXACT * apart,
        )
        if shapes is None:
            return None
        if joint is None or not _same(contacts.friction[joint], contacts.friction):
            return None
        if not _same(contacts.strength[joint], contacts.strength):
            return None
        if behaviour == "elastic" and not (
            _same(contacts.bed[joint], contacts.bed) and _same(contacts.shear[joint], contacts.shear)
        ):
            return None
        held = np.zeros((len(contacts), 2))
        held[contacts.ties] = [(tie.taut_length, tie.pretension) for tie in model.ties] or 0.0
        if not _same(held[joint], held):
            return None
        moment = np.where(contacts.a[joint] == block[contacts.a], -1.0, 1.0)
        return cls(model, axis, block, joint, moment)

    def swaps(self, one: ArrayLike, other: ArrayLike) -> bool:
        """Whether two control points (2,) m, and the blocks that they are fixed to, are each other's image."""
        image = self.model.from_origin(one) * [-1.0, 1.0] + [2.0 * self.axis, 0.0]
        if abs(image - self.model.from_origin(other)).max() > EXACT * self.model.size:
            return False
        return bool(self.block[self.model.block_at(one)] == self.model.block_at(other))

    def pushover(self, path: Pushover) -> Pushover | None:
        """Return the image of a path from the state as drawn, which is the path of the push the other way.

        None if blocks came into contact on the way that do not touch as drawn.
        """
        drawn = len(self.model.contacts)
        met = [step.forces[drawn:, 0].max(initial=0.0) for step in path.steps]
        if max([*met, path.forces[drawn:, 0].max(initial=0.0)]) > 0.0:
            return None
        control = self.model.from_origin(path.control) * [-1.0, 1.0] + [2.0 * self.axis, 0.0]
        return replace(
            path,
            control=self.model.as_drawn(control),
            block=int(self.block[path.block]),
            end=self._mirrored(path.end),
            states=tuple(map(self._state, path.states)),
            steps=tuple(map(self._step, path.steps)),
            mechanism=self._motion(path.mechanism),
            forces=self._forces(path.forces[:drawn]),
            contacts=self.model.contacts,
            direction="-x" if path.direction == "+x" else "+x",
        )

    def _mirrored(self, text: Message) -> Message:
        """Return the image of a message: its block and its direction, and those of messages within, are exchanged."""
        return Message(text.template, {name: self._field(name, value) for name, value in text.fields.items()})

    def _field(self, name: str, value: Field) -> Field:
        if isinstance(value, Message):
            return self._mirrored(value)
        if name == "block" and isinstance(value, int):
            return int(self.block[value])
        return {"+x": "-x", "-x": "+x"}.get(str(value), value) if name == "direction" else value

    def _motion(self, motion: Array) -> Array:
        """Return the image of displacements or loads (b, 3) of the blocks."""
        image = np.empty_like(motion)
        image[self.block] = motion * TURNED
        return image

    def _positions(self, positions: Array) -> Array:
        return self._motion(positions) + np.array([2.0 * self.axis, 0.0, 0.0])

    def _forces(self, forces: Array) -> Array:
        """Return the image of N, P and T (j, 3) of the drawn joints."""
        image = np.empty_like(forces)
        image[self.joint] = forces * np.column_stack(
            [np.ones(len(forces)), self.moment, -np.ones(len(forces))]
        )
        return image

    def _state(self, state: State) -> State:
        shear = carrying = None
        if state.shear is not None:
            shear = np.empty_like(state.shear)
            shear[self.joint] = -state.shear
        if state.carrying is not None:
            carrying = np.empty_like(state.carrying)
            carrying[self.joint] = state.carrying
        lengthened = None
        if state.lengthened is not None:
            ties = self.model.contacts.ties
            lengthened = np.zeros(len(ties))
            lengthened[self.joint[ties]] = state.lengthened
            lengthened = lengthened[ties]
        return State(
            self._positions(state.positions),
            self._motion(state.velocities),
            shear,
            None,
            carrying,
            lengthened,
        )

    def _step(self, step: Equilibrium) -> Equilibrium:
        state, contacts = self._state(step.state), self.model.contacts
        system = replace(step.system, contacts=contacts, seen=None)
        places = system.places(state.positions, state)
        forces = self._forces(step.forces[: len(contacts)])
        return replace(step, state=state, system=system, places=places, forces=forces, iterate=None)


def _along(ends: Array) -> Array:
    """Return dx²/l, dz²/l and dx dz/l (k, 3), m, of lines between two points (k, 2, 2): the same from either end."""
    d = ends[:, 1] - ends[:, 0]
    length = np.hypot(*d.T)
    return np.asarray(np.column_stack([d * d, d[:, 0] * d[:, 1]]) / length[:, None])


def _matched(points: Array, images: Array, tolerance: float) -> Index | None:
    """Return the index (k,) of the point at each image; None if an image lies at no point or two lie at the same."""
    from scipy.spatial import KDTree

    distance, found = KDTree(points).query(images)
    if distance.max(initial=0.0) > tolerance or len(np.unique(found)) < len(found):
        return None
    return np.asarray(found, dtype=np.intp)


def _same(one: Array, other: Array) -> bool:
    small = EXACT * abs(other[np.isfinite(other)]).max(initial=0.0)
    return bool(np.allclose(one, other, rtol=EXACT, atol=small, equal_nan=True))
