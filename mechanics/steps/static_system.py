"""The system of a static path: assembly, joint behaviour and contacts, which do not change from step to step."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, get_args

import numpy as np

from mechanics.errors import require
from mechanics.kernels.dynamics.motion import GONE
from mechanics.kernels.joint import LEAST, H, U
from mechanics.kernels.law import BED, CRUSHED, DILATION, FRICTION, LAW, SEGMENTS, SHEAR, STRENGTH
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.model.contacts import Contacts, end_gaps, near
from mechanics.solvers.elimination import BANDED, CHEAPER, Elimination
from mechanics.steps.tolerances import STEP
from mechanics.types import GRAVITY, Array, Index

Sliding = Literal["coulomb", "associative"]


@dataclass(frozen=True, eq=False)
class StaticSystem:
    """An assembly, the behaviour of its joints, and its contacts.

    The contacts are those of all configurations in which no corner is farther than `reach` (m) from its place at the
    positions `seen` (b, 3); None: only the joints as drawn.
    """

    model: Assembly
    behaviour: Behaviour
    sliding: Sliding
    contacts: Contacts
    seen: Array | None = None
    reach: float = np.inf

    def __getstate__(self) -> dict[str, object]:
        """Pickle the system without its cached layouts, which are computed again."""
        return {name: value for name, value in self.__dict__.items() if name not in {"layout", "law", "dof"}}

    def around(self, positions: Array, way: float) -> StaticSystem:
        """Return the system with the contacts of all configurations within a `way` (m) of positions (b, 3)."""
        model = self.model
        if not model.collisions:
            return self
        if self.seen is not None and model.farthest(self.seen, positions) + way <= self.reach:
            return self
        reach = 2.0 * way + STEP.look_ahead * model.size
        contacts = near(model.outlines, model.contacts, self.contacts, positions, 2.0 * reach)
        found = replace(self, contacts=contacts, seen=positions.copy(), reach=reach)
        if np.array_equal(contacts.edges, self.contacts.edges):
            found.__dict__["layout"] = self.layout  # the pairs of blocks are the same
        return found

    def met_inside(self, before: StaticSystem, positions: Array) -> bool:
        """Whether faces that are no contact of the system `before` penetrate at positions (b, 3)."""
        known = set(map(tuple, before.contacts.edges.tolist()))
        new = np.array([tuple(e) not in known for e in self.contacts.edges.tolist()], dtype=bool)
        places = self.contacts.take(np.flatnonzero(new)).places(positions)
        inside = end_gaps(places).min(axis=1) < -STEP.inside * self.model.size
        return bool((inside & (places[:, H] > 0.0)).any())

    def places(self, positions: Array, state: State) -> Array:
        """Return the geometry (j, PLACE) of the contacts at positions (b, 3), ties as much longer as in the state.

        An elastic tie with pretension is shorter, by what that stretches it.
        """
        places = self.contacts.places(positions)
        if self.model.ties:
            if state.lengthened is not None:
                places[self.ties, U] += state.lengthened
            places[self.ties, U] -= self.stretched
        return places

    def resultants(self, positions: Array, ends: Array) -> Array:
        """Return N, P and T (j, 3), kN and kNm, of N₁, N₂ and T (j, 3) where blocks at positions (b, 3) overlap now.

        N₁ and N₂ stay at the corners of blocks, which end the overlap, as its middle moves.
        """
        first, second, shear = ends.T
        half = np.maximum(self.contacts.places(positions)[:, H], 0.0)
        return np.stack([first + second, half * (second - first), shear], axis=1)

    @property
    def stretched(self) -> Array:
        """By how much pretension stretches each tie (t,), m; rigid ones not at all."""
        pull: Array = np.array([tie.pretension for tie in self.model.ties]) / self.law[self.ties, BED]
        return pull

    def lengthened(self, positions: Array, forces: Array, state: State) -> Array | None:
        """Return by how much each tie (t,) has yielded at positions (b, 3) under forces (j, 3), m; in the state before.

        None for a model without ties.
        """
        if not self.model.ties:
            return None
        before = np.zeros(len(self.model.ties)) if state.lengthened is None else state.lengthened
        strength, bed = self.law[self.ties, STRENGTH], self.law[self.ties, BED]
        yields = forces[self.ties, 0] > CRUSHED * strength
        elastic = np.where(yields, strength, 0.0) / bed
        more = np.maximum(-self.places(positions, state)[self.ties, U] - elastic, 0.0)
        return np.where(yields, before + more, before)

    @property
    def ties(self) -> slice:
        """Which contacts are ties."""
        first = len(self.model.joints.a)
        return slice(first, first + len(self.model.ties))

    @property
    def dilation(self) -> float:
        """Share ψ of μ|slip| by which sliding lifts a joint."""
        return 1.0 if self.sliding == "associative" else 0.0

    @property
    def rigid(self) -> bool:
        """Whether joints are rigid."""
        return self.behaviour == "rigid"

    @cached_property
    def law(self) -> Array:
        """The law of each joint (j, LAW), see kernels.law; its slip from which sliding is measured is set later."""
        c = self.contacts
        law = np.zeros((len(c), LAW))
        law[:, FRICTION] = np.maximum(c.friction, LEAST)
        law[:, STRENGTH], law[:, BED], law[:, DILATION] = c.strength, np.inf, self.dilation
        if not self.rigid:
            law[:, BED], law[:, SEGMENTS] = c.bed, c.segments
            with np.errstate(divide="ignore"):
                law[:, SHEAR] = np.where(np.isinf(c.shear), 0.0, 1.0 / c.shear)
        return law

    @cached_property
    def dof(self) -> Index:
        """Degrees of freedom (j, 6) of blocks a and b of each joint."""
        dof = self.model.dof
        return np.concatenate([dof[self.contacts.a], dof[self.contacts.b]], axis=1)

    @cached_property
    def layout(self) -> Elimination:
        """The order of elimination of the matrices; the signed factors of elastic joints are banded."""
        centres = self.model.initial.positions[self.model.movable, :2]
        return Elimination.of(self.dof, centres, CHEAPER if self.rigid else BANDED)

    @property
    def weight(self) -> float:
        """Scale of the forces, kN: the mean weight of the movable blocks."""
        return self.model.weight / float(self.model.movable.sum())

    @cached_property
    def lightest(self) -> float:
        """Weight of the lightest movable block, of `weight`: larger residuals are no approximation for it."""
        return float(self.model.mass[self.model.movable, 0].min()) * GRAVITY / self.weight

    @property
    def no_overlap(self) -> float:
        """Half the overlap (m) up to which faces do not overlap."""
        return GONE * self.model.size

    @property
    def least_force(self) -> float:
        """The least force (kN) of a joint that carries."""
        return STEP.carrying * self.model.weight


def check_sliding(sliding: Sliding) -> None:
    """Raise ArgumentError for an unknown law of sliding."""
    require(
        any(sliding == law for law in get_args(Sliding)), "sliding", sliding, '"coulomb" or "associative"'
    )


def static_system(model: Assembly, behaviour: Behaviour, sliding: Sliding = "associative") -> StaticSystem:
    """Return the system of an assembly with its joints as drawn; ArgumentError for an unknown behaviour or sliding."""
    model.check_behaviour(behaviour)
    check_sliding(sliding)
    return StaticSystem(model, behaviour, sliding, model.contacts)
