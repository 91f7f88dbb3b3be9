"""Mirror symmetry: a push of a symmetric structure towards −x is the mirror image of that towards +x."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mechanics.messages import Field, Message
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.procedures.pushover import Pushover
from mechanics.steps.static_step import Equilibrium
from mechanics.types import Array, Index

Number = TypeVar("Number", bound=np.generic)
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
        corner, of = model.from_origin(model.shape.points), model.shape.owner
        axis, extent = 0.5 * float(corner[:, 0].min() + corner[:, 0].max()), float(np.ptp(corner[:, 0]))
        centre = model.initial.positions[:, :2]
        block = _matched(centre, _reflected(centre, axis), EXACT * extent)
        if block is None or (model.movable[block] != model.movable).any():
            return None
        # corners and joints are shifted by their blocks: only those of the same blocks can match
        apart = 10.0 * extent
        shapes = _matched(
            np.column_stack([apart * of, corner]),
            np.column_stack([apart * block[of], _reflected(corner, axis)]),
            EXACT * apart,
        )
        contacts = model.contacts
        ties = np.array([tie.points for tie in model.ties]).reshape(-1, 2, 2)
        ends = model.from_origin(np.concatenate([model.joints.ends, ties]))
        middle, along = ends.mean(axis=1), _along(ends)
        kind = apart * contacts.ties
        joint = _matched(
            np.column_stack([apart * np.sort(contacts.blocks), middle, along, kind]),
            np.column_stack(
                [
                    apart * np.sort(block[contacts.blocks]),
                    _reflected(middle, axis),
                    along * (1.0, 1.0, -1.0),
                    kind,
                ]
            ),
            EXACT * apart,
        )
        if shapes is None or joint is None:
            return None
        held = np.zeros((len(contacts), 3))
        held[contacts.ties] = [
            (tie.taut_length, tie.pretension, 1.0 / tie.ultimate_elongation) for tie in model.ties
        ] or 0.0
        alike = [contacts.friction, contacts.strength, held]
        alike += [contacts.bed, contacts.shear] if behaviour == "elastic" else []
        if not (
            _same(model.dead_load[block], model.dead_load * TURNED)
            and _same(model.mass[block], model.mass)
            and all(_same(each[joint], each) for each in alike)
        ):
            return None
        moment = np.where(contacts.a[joint] == block[contacts.a], -1.0, 1.0)
        return cls(model, axis, block, joint, moment)

    def swaps(self, one: ArrayLike, other: ArrayLike) -> bool:
        """Whether two control points (2,) m, and the blocks that they are fixed to, are each other's image."""
        image = _reflected(self.model.from_origin(one), self.axis)
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
        control = _reflected(self.model.from_origin(path.control), self.axis)
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
        return _sent(motion * TURNED, self.block)

    def _forces(self, forces: Array) -> Array:
        """Return the image of N, P and T (j, 3) of the drawn joints."""
        factors = np.column_stack([np.ones(len(forces)), self.moment, -np.ones(len(forces))])
        return _sent(forces * factors, self.joint)

    def _state(self, state: State) -> State:
        ties = self.model.contacts.ties
        among = np.searchsorted(np.flatnonzero(ties), self.joint[ties])  # the ties
        return State(
            self._motion(state.positions) + np.array([2.0 * self.axis, 0.0, 0.0]),
            self._motion(state.velocities),
            shear=None if state.shear is None else _sent(-state.shear, self.joint),
            carrying=None if state.carrying is None else _sent(state.carrying, self.joint),
            lengthened=None if state.lengthened is None else _sent(state.lengthened, among),
        )

    def _step(self, step: Equilibrium) -> Equilibrium:
        state, contacts = self._state(step.state), self.model.contacts
        system = replace(step.system, contacts=contacts, seen=None)
        places = system.places(state.positions, state)
        forces = self._forces(step.forces[: len(contacts)])
        return replace(step, state=state, system=system, places=places, forces=forces, iterate=None)


def _reflected(points: Array, axis: float) -> Array:
    """Return the images (…, 2) m of points in the plane x = axis."""
    return np.asarray([2.0 * axis, 0.0] + points * [-1.0, 1.0])


def _sent(values: NDArray[Number], index: Index) -> NDArray[Number]:
    """Return values (k, …) where their images are, at `index` (k,)."""
    image = np.empty_like(values)
    image[index] = values
    return image


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
