"""Values of contacts (forces, gaps, springs), transferred to other sets of contacts and to states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechanics.kernels.law import SHEAR
from mechanics.model.assembly import State
from mechanics.model.contacts import Contacts
from mechanics.solvers.interior import Iterate
from mechanics.steps.static_system import StaticSystem
from mechanics.types import Array, Index, Mask


def spread(values: Array, index: Index, count: int) -> Array:
    """Return values (k, n) of the joints `index` (k,) as values of all (count, n), 0 for the others."""
    out = np.zeros((count, values.shape[1]))
    out[index] = values
    return out


def moved_over(values: Array, before: Contacts, now: Contacts) -> Array:
    """Return the values of the contacts `now` from those (j, k) of the contacts `before`, 0 for new contacts."""
    if before is now:
        return values
    found = np.zeros((len(now), values.shape[1]))
    place = {tuple(e): k for k, e in enumerate(before.edges.tolist())}
    for k, e in enumerate(now.edges.tolist()):
        old = place.get(tuple(e))
        if old is not None:
            found[k] = values[old]
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


def spring_forces(contacts: Contacts, state: State) -> Array:
    """Return the tangential forces (j,) kN in the springs of contacts in a state."""
    forces = np.zeros(len(contacts))
    if state.shear is not None:
        forces[: len(state.shear)] = state.shear
    if state.met is not None:
        known = {(int(e), int(f)): t for e, f, t in state.met}
        for k in range(0 if state.shear is None else len(state.shear), len(contacts)):
            forces[k] = known.get((int(contacts.edges[k, 0]), int(contacts.edges[k, 1])), 0.0)
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
        known = {(int(e), int(f)) for e, f, _ in state.met}
        found |= np.array([tuple(pair) in known for pair in contacts.edges.tolist()], dtype=bool)
    return found


def state_at_rest(system: StaticSystem, at: Array, forces: Array, before: State) -> State:
    """Return the state at rest at positions (b, 3) under forces N, P and T (j, 3), kN and kNm, after `before`."""
    carrying = forces[:, 0] > system.least_force
    drawn = len(system.model.contacts)
    met = np.column_stack([system.contacts.edges, forces[:, 2]])[drawn:][carrying[drawn:]]
    shear = forces[:drawn, 2].copy() if system.law[:, SHEAR].any() else None
    lengthened = system.lengthened(at, forces, before)
    return State(at, np.zeros_like(at), shear, met if len(met) else None, carrying[:drawn], lengthened)
