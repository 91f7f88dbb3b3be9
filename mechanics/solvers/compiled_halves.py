"""The iterations at one half of a model (see halves), compiled by numba."""

from __future__ import annotations

from typing import Any

import numpy as np

from mechanics.block import Array
from mechanics.solvers.compiled_iterations import interior, semismooth
from mechanics.solvers.compiler import compiler
from mechanics.solvers.kernels import Residuals

compiled = compiler()


@compiled
def semismooth_of_half(
    half: Any, posed: Any, x: Array, forces: Array, state: Any, stored: Array, packed: Any, scale: Any, many: int,
    shared: Any,
) -> tuple[int, Residuals]:  # fmt: skip
    """As iterations.semismooth of the whole, of which only what is the half's is read and written."""
    row, rows, points = half[:3]
    x_here, forces_here, state_here = x[rows], _of(forces, points), state[points]
    normal, tangent, gap, friction, compliance, mass, load = _posed(half, posed)
    found = semismooth(
        row, normal, tangent, gap, friction, compliance, mass, load, x_here, forces_here, state_here,
        stored, packed, scale, many, shared,
    )  # fmt: skip
    x[rows], state[points] = x_here, state_here
    _back(forces_here, points, forces)
    return found


@compiled
def interior_of_half(
    half: Any, posed: Any, x: Array, forces: Array, s: Array, z: Array, state: Any, runs: Any, stored: Array,
    packed: Any, scale: Any, shared: Any,
) -> tuple[int, Residuals]:  # fmt: skip
    """As iterations.interior of the whole, of which only what is the half's is read and written."""
    row, rows, points = half[:3]
    x_here, state_here = x[rows], state[points]
    forces_here, s_here, z_here = _of(forces, points), _of(s, points), _of(z, points)
    normal, tangent, gap, friction, compliance, mass, load = _posed(half, posed)
    found = interior(
        row, normal, tangent, gap, friction, compliance, mass, load, x_here, forces_here, s_here, z_here, state_here,
        runs, stored, packed, scale, shared,
    )  # fmt: skip
    x[rows], state[points] = x_here, state_here
    _back(forces_here, points, forces)
    _back(s_here, points, s)
    _back(z_here, points, z)
    return found


@compiled
def _posed(half: Any, posed: Any) -> Any:
    """What a program says of the half's contact points and rows."""
    normal, tangent, gap, friction, compliance, mass, load = posed
    _, rows, points, counted = half
    return (
        _of(normal, points), _of(tangent, points), _of(gap, points), friction[points], _of(compliance, points),
        counted * mass[rows], counted * load[rows],
    )  # fmt: skip


@compiled
def _of(whole: Array, points: Any) -> Array:
    """The rows of some points."""
    found = np.empty((len(points), whole.shape[1]))
    for k in range(len(points)):
        for e in range(whole.shape[1]):
            found[k, e] = whole[points[k], e]
    return found


@compiled
def _back(found: Array, points: Any, whole: Array) -> None:
    """The rows of some points to where they came from."""
    for k in range(len(points)):
        for e in range(whole.shape[1]):
            whole[points[k], e] = found[k, e]
