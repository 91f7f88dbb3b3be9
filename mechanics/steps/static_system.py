"""The system of a static path: assembly, joint behaviour and contacts, which do not change from step to step.

And values of contacts (forces, gaps, springs), transferred to other sets of contacts and to states.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Literal, get_args

import numpy as np

from mechanics.errors import require
from mechanics.kernels.dynamics.motion import GONE
from mechanics.kernels.joint import LEAST, H, U
from mechanics.kernels.law import BED, CRUSHED, DILATION, FRICTION, LAW, SEGMENTS, SHEAR, STRENGTH
from mechanics.model.assembly import Assembly, Behaviour, State
from mechanics.model.contacts import Contacts, end_gaps, near
from mechanics.solvers.elimination import BANDED, CHEAPER, Elimination
from mechanics.solvers.interior import Iterate
from mechanics.steps.tolerances import STEP
from mechanics.types import GRAVITY, Array, Index, Mask

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
        new = np.flatnonzero(places_among(self.contacts.edges, before.contacts.edges) < 0)
        places = self.contacts.take(new).places(positions)
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
        return np.array([tie.pretension for tie in self.model.ties]) / self.law[self.ties, BED]

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
    return _as_drawn(model, behaviour, sliding)


@lru_cache(maxsize=4)  # with what it knows of its joints: paths of a model begin with them as drawn
def _as_drawn(model: Assembly, behaviour: Behaviour, sliding: Sliding) -> StaticSystem:
    return StaticSystem(model, behaviour, sliding, model.contacts)


def spread(values: Array, index: Index, count: int) -> Array:
    """Return values (k, n) of the joints `index` (k,) as values of all (count, n), 0 for the others."""
    out = np.zeros((count, values.shape[1]))
    out[index] = values
    return out


def places_among(edges: Index, others: Array | Index) -> Index:
    """Return the place (k,) of each pair of edges (k, 2), which is one contact, among others (n, 2); −1: at none."""
    place = {tuple(pair): k for k, pair in enumerate(others.tolist())}
    return np.array([place.get(tuple(pair), -1) for pair in edges.tolist()], dtype=np.intp)


def moved_over(values: Array, before: Contacts, now: Contacts) -> Array:
    """Return the values of the contacts `now` from those (j, k) of the contacts `before`, 0 for new contacts."""
    if before is now:
        return values
    found = np.zeros((len(now), values.shape[1]))
    old = places_among(now.edges, before.edges)
    found[old >= 0] = values[old[old >= 0]]
    return found


def iterate_over(iterate: Iterate, before: Contacts, now: Contacts) -> Iterate:
    """Return the iterate of the contacts `now` from that of the contacts `before`."""
    if before is now:
        return iterate
    forces, gaps = (moved_over(v, before, now) for v in (iterate.forces, iterate.gaps))
    return replace(iterate, forces=forces, gaps=gaps)


def taken(iterate: Iterate, index: Index) -> Iterate:
    """Return the iterate of the joints `index` (k,)."""
    return replace(iterate, forces=iterate.forces[index], gaps=iterate.gaps[index])


def over_all(found: Iterate, index: Index, count: int) -> Iterate:
    """Return an iterate of all `count` joints from that of the joints `index` (k,); the others carry nothing."""
    return replace(found, forces=spread(found.forces, index, count), gaps=spread(found.gaps, index, count))


def sliding_joints(iterate: Iterate, size: float) -> Mask:
    """Return which joints (j,) slide in an iterate by more than a share of its step's `size` (m)."""
    slip: Array = abs(iterate.gaps[:, 2] - iterate.gaps[:, 3])
    return slip > STEP.slides * size


def spring_forces(contacts: Contacts, state: State) -> Array:
    """Return the tangential forces (j,) kN in the springs of contacts in a state."""
    forces = np.zeros(len(contacts))
    if state.met is not None:
        met = places_among(contacts.edges, state.met[:, :2])
        forces = np.where(met >= 0, state.met[met, 2], 0.0)
    if state.shear is not None:
        forces[: len(state.shear)] = state.shear
    return forces


def with_springs(contacts: Contacts, state: State, drawn: int, forces: Array) -> State:
    """Return a state with the tangential forces (j,) kN of its contacts' springs."""
    met = np.column_stack([contacts.edges[drawn:], forces[drawn:]])
    met = met[met[:, 2] != 0.0]
    return replace(state, shear=forces[:drawn].copy(), met=met if len(met) else None)


def carried(contacts: Contacts, state: State) -> Mask:
    """Return which contacts (j,) carry in the equilibrium that led to a state, as far as the state knows."""
    found = np.zeros(len(contacts), dtype=bool)
    if state.carrying is not None:
        found[: len(state.carrying)] = state.carrying
    if state.carrying is not None and state.met is not None:
        found |= places_among(contacts.edges, state.met[:, :2]) >= 0
    return found


def state_at_rest(system: StaticSystem, at: Array, forces: Array, before: State) -> State:
    """Return the state at rest at positions (b, 3) under forces N, P and T (j, 3), kN and kNm, after `before`."""
    carrying = forces[:, 0] > system.least_force
    drawn = len(system.model.contacts)
    met = np.column_stack([system.contacts.edges, forces[:, 2]])[drawn:][carrying[drawn:]]
    shear = forces[:drawn, 2].copy() if system.law[:, SHEAR].any() else None
    lengthened = system.lengthened(at, forces, before)
    return State(at, np.zeros_like(at), shear, met if len(met) else None, carrying[:drawn], lengthened)
