"""Structures that are their own mirror image: pushed one way, they do what they do pushed the other way."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from mechanics.assembly import Assembly, Behaviour, State
from mechanics.program import Neighbour, Program
from mechanics.pushover import Pushover
from mechanics.static_step import Step
from mechanics.types import Array, Index

EXACT = 1e-9  # of the model's extent, and of its loads and stiffnesses: a difference that is rounding
TURNED = np.array([-1.0, 1.0, -1.0])  # what the image of x, z, ω is multiplied by


@dataclass(frozen=True, eq=False)
class Mirror:
    """The reflection in the plane x = `axis` (m) that leaves a model as drawn as it is.

    `block` (b,), `contact` (c,): the block and the contact point at which each one's image lies; `behaviour`: whose
    contact points they are.
    """

    model: Assembly
    behaviour: Behaviour
    axis: float
    block: Index
    contact: Index

    @classmethod
    def of(cls, model: Assembly, behaviour: Behaviour) -> Mirror | None:
        """The mirror of a model; None where the image of a block, a load or a contact point is not another, exactly."""
        x = np.concatenate([block.polygon[:, 0] for block in model.blocks])
        axis, extent = 0.5 * float(x.min() + x.max()), float(np.ptp(x))
        centre = model.initial.positions[:, :2]
        block = _matched(centre, [2.0 * axis, 0.0] + centre * [-1.0, 1.0], EXACT * extent)
        if block is None or (model.movable[block] != model.movable).any():
            return None
        if not _same(model.dead_load[block], model.dead_load * TURNED):
            return None
        if not _same(model.lateral_load("+x")[block], model.lateral_load("-x") * TURNED):
            return None
        contacts = model.contacts(behaviour)
        apart = 10.0 * extent  # points of other blocks are none that lie near
        owner = np.stack([contacts.a, contacts.b], axis=1)
        here = np.column_stack([apart * owner, contacts.p, contacts.q, contacts.n])
        image = np.column_stack(
            [apart * block[owner], *(v * [-1.0, 1.0] for v in (contacts.p, contacts.q, contacts.n))]
        )
        contact = _matched(here, image, EXACT * apart)
        if contact is None or not _same(contacts.friction[contact], contacts.friction):
            return None
        if behaviour == "elastic" and not _same(contacts.stiffness[contact], contacts.stiffness):
            return None
        return cls(model, behaviour, axis, block, contact)

    def swaps(self, one: ArrayLike, other: ArrayLike) -> bool:
        """Whether control points (m) are each other's image, and so are the blocks that they are fixed to."""
        image = np.asarray(one, dtype=float) * [-1.0, 1.0] + [2.0 * self.axis, 0.0]
        if abs(image - np.asarray(other, dtype=float)).max() > EXACT * self.model.size:
            return False
        return bool(self.block[self.model.block_at(one)] == self.model.block_at(other))

    def pushover(self, path: Pushover) -> Pushover:
        """The image of a path from the state as drawn: that of the push the other way."""
        return replace(
            path,
            end=self._told(path.end),
            states=tuple(map(self._state, path.states)),
            steps=tuple(map(self._step, path.steps)),
            mechanism=self._motion(path.mechanism),
            forces=self._points(path.forces, [1.0, -1.0]),
        )

    def _told(self, text: str) -> str:
        """A message, its blocks and its direction."""
        swapped = {"+x": "-x", "-x": "+x"}
        return re.sub(
            r"block (\d+)|([+-]x)",
            lambda found: f"block {self.block[int(found[1])]}" if found[1] else swapped[found[2]],
            text,
        )

    def _motion(self, motion: Array) -> Array:
        """Displacements or loads (b, 3) of the blocks."""
        image = np.empty_like(motion)
        image[self.block] = motion * TURNED
        return image

    def _rows(self, rows: Array) -> Array:
        """The same of the movable blocks (m,)."""
        motion = np.zeros((len(self.block), 3))
        motion[self.model.movable] = rows.reshape(-1, 3)
        return self._motion(motion)[self.model.movable].ravel()

    def _points(self, values: ArrayLike, signs: ArrayLike) -> Array:
        """What belongs to contact points (c, n), its columns times signs (n,)."""
        signed = np.asarray(values) * np.asarray(signs, dtype=float)
        image = np.empty_like(signed)
        image[self.contact] = signed
        return image

    def _positions(self, positions: Array) -> Array:
        return self._motion(positions) + np.array([2.0 * self.axis, 0.0, 0.0])

    def _state(self, state: State) -> State:
        return State(
            self._positions(state.positions),
            self._motion(state.velocities),
            None if state.shear is None else self._points(state.shear, -1.0),
            None if state.carrying is None else self._points(state.carrying, 1.0) > 0.0,
        )

    def _step(self, step: Step) -> Step:
        solution, near = step.solution, step.neighbour
        normal_and_tangent = [1.0, -1.0]
        return replace(
            step,
            state=self._state(step.state),
            at=self._positions(step.at),
            program=self._program(step.program),
            solution=replace(
                solution,
                forces=self._points(solution.forces, normal_and_tangent),
                displacement=self._rows(solution.displacement),
            ),
            neighbour=Neighbour(
                self._points(near.forces, normal_and_tangent),
                self._points(near.opening, normal_and_tangent),
                near.alpha,
            ),
        )

    def _program(self, program: Program) -> Program:
        # gaps are what they were, slides change their sign
        return replace(
            program,
            normal=self._points(program.normal, np.tile(TURNED, 2)),
            tangent=self._points(program.tangent, -np.tile(TURNED, 2)),
            gap=self._points(program.gap, [1.0, -1.0]),
            load=self._rows(program.load),
            lateral=None if program.lateral is None else self._rows(program.lateral),
        )


def _matched(points: Array, images: Array, tolerance: float) -> Index | None:
    """The point (k,) that each image is; None where one is none, or two are the same."""
    from scipy.spatial import KDTree

    distance, found = KDTree(points).query(images)
    if distance.max(initial=0.0) > tolerance or len(np.unique(found)) < len(found):
        return None
    return np.asarray(found, dtype=np.intp)


def _same(one: Array, other: Array) -> bool:
    small = EXACT * abs(other[np.isfinite(other)]).max(initial=0.0)
    return bool(np.allclose(one, other, rtol=EXACT, atol=small, equal_nan=True))
