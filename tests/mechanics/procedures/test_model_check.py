"""The check of configurations against the model, beside the programs that found them."""

from dataclasses import replace

import numpy as np
import pytest

from mechanics import Assembly, ConvergenceError, pushdown, pushover, time_history
from mechanics.kernels.dynamics.program import RIGHT
from mechanics.messages import message
from mechanics.procedures import time_history as histories
from mechanics.procedures.model_check import check_path, departure, departure_in_motion
from mechanics.procedures.motion_start import HISTORY
from mechanics.steps.static_step import Equilibrium
from mechanics.steps.static_system import Behaviour, static_system
from tests.support.random_masonry import random_masonry, small_wall
from tests.support.structures import block_on_base, running_bond

SHAKEN = 0.5 * np.sin(0.1 * np.arange(60))


def placed(step: Equilibrium, moved: np.ndarray, forces: np.ndarray | None = None) -> Equilibrium:
    """The equilibrium with blocks moved (b, 3) and other forces, as if a solver had found it."""
    state = replace(step.state, positions=step.state.positions + moved)
    places = step.system.places(state.positions, state)
    return replace(step, state=state, places=places, forces=step.forces if forces is None else forces)


@pytest.fixture(scope="module", params=["rigid", "elastic"])
def point(request: pytest.FixtureRequest) -> Equilibrium:
    """A point of a curve of a wall that slides."""
    wall = running_bond(2, 5, 0.341, 0.15, 0.78, full_on_top=False)
    curve = pushover(wall, None, "+x", request.param, 0.01, until=0.9)
    return curve.steps[-1]


@pytest.mark.parametrize(
    ("lift", "wrong"), [(0.02, "press on each other across a gap of"), (-0.02, "lie in each other by")]
)
def test_blocks_moved_off_or_into_each_other_are_told(point: Equilibrium, lift: float, wrong: str) -> None:
    model = point.system.model
    moved = np.zeros_like(point.state.positions)
    moved[model.movable, 1] = lift * model.size
    assert wrong in str(departure(placed(point, moved)))


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_force_at_the_end_that_has_opened_is_told(contacts: Behaviour) -> None:
    """A block that has turned on one edge, and is said to press on the other: its nearer end does touch."""
    step = pushover(block_on_base(), None, "+x", contacts, 0.02).steps[-1]
    assert departure(step) is None
    forces = step.forces * [1.0, -1.0, 1.0]
    assert "across a gap" in str(departure(replace(step, forces=forces)))


def test_no_shear_without_a_force_that_presses() -> None:
    """Infinite friction bears any T under N > 0, and none in a joint that bears nothing."""
    step = pushover(block_on_base(friction=np.inf), None, "+x", "rigid", 0.02).steps[1]
    shear = np.array([0.0, 0.0, 5.0 * step.system.model.weight])
    assert departure(replace(step, forces=step.forces + shear)) is None
    told = departure(replace(step, forces=np.array([[0.0, 0.0, 0.1]])))
    assert "exceeds μN" in str(told)


def test_friction_beyond_its_bound_is_told(point: Equilibrium) -> None:
    forces = point.forces.copy()
    forces[:, 2] = 1.01 * point.contacts.friction * forces[:, 0]
    told = departure(placed(point, np.zeros_like(point.state.positions), forces))
    assert "exceeds μN" in str(told)
    with pytest.raises(ConvergenceError, match=r"point 1 of the path is not valid: friction between blocks"):
        check_path([point, replace(point, forces=forces)])


def test_a_point_that_lifts_by_another_law_may_press_across_a_gap(point: Equilibrium) -> None:
    moved = np.zeros_like(point.state.positions)
    moved[point.system.model.movable, 1] = 0.02 * point.system.model.size
    above = placed(point, moved)
    assert departure(above) is not None and departure(replace(above, lifting=True)) is None


@pytest.mark.parametrize("name", ["pushover", "pushdown"])
def test_every_path_is_checked(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Equilibrium] = []
    monkeypatch.setattr(f"mechanics.procedures.{name}.check_path", seen.extend)
    model = block_on_base()
    path = pushover(model) if name == "pushover" else pushdown(model, "base", rotation=0.01)
    assert seen and all(one is other for one, other in zip(seen, path.steps, strict=True))


@pytest.mark.parametrize(
    ("wall", "most"), [(random_masonry(43), 0.05), (small_wall(50), 0.05), (running_bond(2, 3), 0)]
)
def test_points_found_with_a_dilation_are_counted(wall: Assembly, most: float) -> None:
    """A step divided into short ones had forces across a quarter of a brick."""
    curve = pushover(wall, None, "+x", "rigid", wall.size / 50)
    assert curve.lifting == sum(step.lifting for step in curve.steps)
    assert (curve.lifting > 0) == (most > 0)
    assert curve.lifting <= most * len(curve.steps)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_every_hundredth_step_of_a_motion_is_checked(
    contacts: Behaviour, monkeypatch: pytest.MonkeyPatch
) -> None:
    wall = running_bond(2, 3)
    every = replace(HISTORY, checked=10)
    time_history(wall, SHAKEN, 0.005, contacts, tolerances=every)
    monkeypatch.setattr(histories, "departure_in_motion", lambda *_: message("blocks fly"))
    with pytest.raises(ConvergenceError, match=r"the motion at 0\.05 s is not valid: blocks fly"):
        time_history(wall, SHAKEN, 0.005, contacts, tolerances=every)


def test_a_step_of_a_motion_reaches_as_far_as_its_blocks_go() -> None:
    """A block 1 mm above its bed that presses: not at rest; it may have met it at 1 m/s in a step of 5 ms."""
    wall = running_bond(1, 1)
    system = static_system(wall, "rigid", "coulomb")
    forces = np.zeros((len(system.contacts), 3))
    forces[:, 0] = wall.weight
    above = wall.initial.positions + wall.movable[:, None] * [0.0, 0.001, 0.0]
    still = np.zeros_like(above)
    fast = wall.movable[:, None] * np.array([0.0, -1.0, 0.0])
    both = np.stack([above, above])
    told = departure_in_motion(system, both, np.stack([still, still]), forces, 0.005, 0.0)
    assert "across a gap of 0.001 m" in str(told)
    assert departure_in_motion(system, both, np.stack([still, fast]), forces, 0.005, 0.0) is None


@pytest.mark.parametrize(("share", "valid"), [(0.005, True), (0.02, False)])
def test_what_a_program_of_a_motion_leaves_is_no_force(share: float, valid: bool) -> None:
    """A hundredth of a block's weight across a gap: motions of large arches were refused for a thousandth."""
    wall = running_bond(1, 1)
    system = static_system(wall, "rigid", "coulomb")
    forces = np.zeros((len(system.contacts), 3))
    forces[:, 0] = share * system.weight
    above = wall.initial.positions + wall.movable[:, None] * [0.0, 0.001, 0.0]
    both, still = np.stack([above, above]), np.zeros((2, *above.shape))
    assert (departure_in_motion(system, both, still, forces, 0.005, 0.0) is None) is valid


def test_a_search_leaves_as_much_across_gaps_as_its_programs_may() -> None:
    """A wall of flying bricks was refused: each end had its share of 1 % of the kinetic energy, force by gap."""
    wall = running_bond(1, 1)
    system = static_system(wall, "rigid", "coulomb")
    above = wall.initial.positions + wall.movable[:, None] * [0.0, 0.1, 0.0]
    flying = np.zeros((2, *above.shape))
    flying[:, wall.movable, 0] = 5.0
    kinetic = 0.5 * float((wall.mass * flying[0] ** 2).sum())
    way = 0.005 * 5.0 * (1.0 + RIGHT)
    forces = np.zeros((len(system.contacts), 3))
    for share, valid in ((0.9, True), (1.1, False)):
        forces[0, 0] = share * 0.5 * 1e-2 * kinetic / (0.1 - way)
        assert forces[0, 0] > 0.01 * system.weight
        told = departure_in_motion(system, np.stack([above, above]), flying, forces, 0.005, 1e-2)
        assert (told is None) is valid
