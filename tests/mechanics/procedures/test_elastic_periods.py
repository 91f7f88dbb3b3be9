"""The frequency that damping refers to, against the dense eigenvalue problem of the same springs."""

import numpy as np
import pytest
from scipy.linalg import eigh

from mechanics import Assembly, Material, time_history
from mechanics.kernels.joint import H
from mechanics.kernels.law import BED, SEGMENTS, SHEAR
from mechanics.model.contacts import rows
from mechanics.procedures.motion_start import RIGID_SHEAR, first_frequency
from mechanics.steps.static_system import static_system
from tests.support.structures import (
    arch_on_piers,
    block_on_base,
    column,
    on_base,
    rectangle,
    running_bond,
    semicircular_arch,
)

STONE = Material(20.0, 0.6, 1e5)


def towers(*, above: float = 0.0, turned: float = 0.0) -> Assembly:
    """Two equal towers of two blocks, the second one 4 m aside, `above` the base or `turned` in the air."""
    cos, sin = np.cos(turned), np.sin(turned)
    second = np.array([rectangle(0.0, i, 1.0, i + 1.0) for i in range(2)]) @ [[cos, sin], [-sin, cos]]
    first = [rectangle(0.0, i, 1.0, i + 1.0) for i in range(2)]
    return on_base(STONE, (-1.0, -1.0, 6.0), *first, *(second + np.array([4.0, above])))


def dense(model: Assembly) -> float:
    """√ of the lowest eigenvalue of BᵀDB against the masses."""
    system = static_system(model, "elastic")
    places, mass = system.contacts.places(model.initial.positions), model.mass[model.movable].ravel()
    length = 2.0 * places[:, H]
    normal = system.law[:, BED] * length
    with np.errstate(divide="ignore"):
        shear = np.minimum(1.0 / system.law[:, SHEAR], RIGID_SHEAR * normal)
    segments = system.law[:, SEGMENTS]
    with np.errstate(divide="ignore"):
        turning = normal * length**2 / 12.0 * np.where(segments > 0, 1.0 + 2.0 / segments**2, 1.0)
    matrix = np.zeros((len(mass) + 1,) * 2)  # supports have the last row
    for row, k in zip(rows(places).transpose(1, 0, 2), (normal, turning, shear), strict=True):
        np.add.at(
            matrix,
            (system.dof[:, :, None], system.dof[:, None, :]),
            k[:, None, None] * row[:, :, None] * row[:, None, :],
        )
    lowest = eigh(matrix[:-1, :-1], np.diag(mass), eigvals_only=True, subset_by_index=[0, 0])
    return float(np.sqrt(lowest[0]))


@pytest.mark.parametrize(
    "model",
    [
        block_on_base(0.6, 4.2, stiffness=1e5),  # the three rows of one block
        block_on_base(4.0, 0.5, stiffness=1e5),
        towers(),  # two equal frequencies
        semicircular_arch(20, 0.15),
        arch_on_piers(),
        running_bond(6, 8, stiffness=1e6),
        column(0.4, 1.6, 3, stiffness=2e5, segments=1),
        semicircular_arch(20, 0.15, segments=2),
        arch_on_piers(segments=4),
    ],
)
def test_first_frequency_is_that_of_the_dense_problem(model: Assembly) -> None:
    assert first_frequency(model) == pytest.approx(dense(model), rel=1e-8)


def test_first_frequency_is_repeatable_where_few_modes_differ() -> None:
    model = towers()
    assert len({first_frequency(model) for _ in range(20)}) == 1


@pytest.mark.parametrize("turned", [0.0, 1.1])
def test_damping_that_has_no_frequency_to_refer_to_is_refused(turned: float) -> None:
    model = towers(above=3.0, turned=turned)
    assert first_frequency(model) == 0.0
    with pytest.raises(ValueError, match=r"damping_ratio = 0\.05: must be 0 where nothing holds some block"):
        time_history(model, np.zeros(3), 0.005, "elastic", damping_ratio=0.05)
