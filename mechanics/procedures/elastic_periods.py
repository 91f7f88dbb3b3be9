"""Periods of structures on elastic joints, as drawn: of the stiffest contact, and the first of the whole."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from mechanics.kernels.bed_law import bed_forces
from mechanics.kernels.joint import H
from mechanics.kernels.law import BED, LEFT, SHEAR
from mechanics.kernels.linalg.factors import cholesky, substitute
from mechanics.kernels.matrix import diagonal, stiffen
from mechanics.model.assembly import Assembly
from mechanics.solvers.elimination import Elimination
from mechanics.steps.static_system import static_system
from mechanics.types import Array

RIGID_SHEAR = 1e3  # tangential over normal stiffness that replaces an infinite one in the first frequency


def contact_period(model: Assembly) -> float:
    """Return √(m/k), s, of the stiffest joint as drawn, m the reduced mass: a contact lasts π times it."""
    contacts, mass = model.contacts, np.where(model.movable, model.mass[:, 0], np.inf)
    contacts = contacts.take(np.flatnonzero(~contacts.ties))
    stiffness = contacts.bed * 2.0 * contacts.places(model.initial.positions)[:, H]
    with np.errstate(divide="ignore"):
        lightness = 1.0 / mass[contacts.a] + 1.0 / mass[contacts.b]
    return float(1.0 / np.sqrt((stiffness * lightness).max(initial=1e-300)))


def first_frequency(model: Assembly) -> float:
    """Return the lowest circular frequency (rad/s) of the blocks as drawn: all joints closed and sticking, ties taut.

    It is 0 if some blocks are loose.
    """
    from scipy.sparse.linalg import LinearOperator, eigsh

    system = static_system(model, "elastic")
    layout = Elimination.of(system.dof, model.initial.positions[model.movable, :2])
    places = system.contacts.places(model.initial.positions)
    ties, normal = system.contacts.ties, system.law[:, BED] * 2.0 * places[:, H]
    with np.errstate(divide="ignore"):
        shear = np.minimum(1.0 / system.law[:, SHEAR], RIGID_SHEAR * normal)
    mass, stored = model.mass[model.movable].ravel()[layout.order], layout.triangle()
    diagonal(np.zeros(len(mass)), stored, layout.pattern)
    for k, (i, j) in enumerate(layout.row):
        _, _, _, _, turns = bed_forces(
            system.law[k], np.inf, system.law[k, LEFT:], places[k, H], -1.0, 0.0
        )  # all of it pressed, none crushed
        turns, slides = (0.0, 0.0) if ties[k] else (turns, shear[k])
        law = np.diag([normal[k], turns, slides]).ravel()
        stiffen(k, places[k], i, j, law, stored, layout.pattern)
    if _some_are_loose(model) or not cholesky(stored, layout.pattern):
        return 0.0
    root = np.sqrt(mass)

    def flexibility(x: Array) -> Array:
        y: Array = root * x.ravel()
        substitute(stored, stored, layout.pattern, y)
        return root * y

    operator = LinearOperator((len(mass), len(mass)), matvec=flexibility, dtype=float)
    largest = eigsh(operator, k=1, which="LA", v0=root, return_eigenvectors=False)
    # with few distinct modes ARPACK restarts from random vectors, and its last digits are not repeatable
    return float(f"{1.0 / np.sqrt(largest[0]):.10g}")


def _some_are_loose(model: Assembly) -> bool:
    """Whether some block is connected to no support by joints (a frequency of rounding alone might hide it)."""
    joints, count = model.joints, len(model.blocks)
    links = sparse.coo_matrix((np.ones(len(joints.a)), (joints.a, joints.b)), shape=(count, count))
    _, part = connected_components(links, directed=False)
    return not np.isin(part, part[~model.movable]).all()
