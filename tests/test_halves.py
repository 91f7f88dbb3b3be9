"""Two threads at the halves of a model: what one thread finds, whatever becomes of either."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from mechanics import Assembly, State, time_history
from mechanics.block import Array
from mechanics.program import Program, Solution
from mechanics.solvers import threads
from mechanics.solvers.elimination import Elimination
from mechanics.solvers.newton import Newton
from tests.steps import euler_step
from tests.structures import arch_on_piers, running_bond
from tests.test_dissection import in_fronts, laid_out
from tests.test_newton import shaken

compiled = pytest.importorskip("mechanics.solvers.compiled")
halves: Any = pytest.importorskip("mechanics.solvers.halves")
meeting: Any = pytest.importorskip("mechanics.solvers.meeting")

BEHAVIOURS = ["rigid", "elastic"]


@pytest.fixture
def wall(monkeypatch: pytest.MonkeyPatch) -> Assembly:
    """In fronts, small as it is, and with two cores, whatever there are."""
    in_fronts(monkeypatch)
    monkeypatch.setattr(threads, "cores", lambda: 2)
    return running_bond(7, 9, stiffness=1e6)


def newton_for(model: Assembly, program: Program, at_once: int) -> Newton:
    with threads.at_most(at_once):
        newton = Newton(program.dof, model.initial.positions[model.movable, :2], compiled)
    assert newton.threads == at_once, "two halves, if two threads are at hand"
    return newton


@pytest.mark.parametrize(("blocks", "share"), [(60, 1.0), (60, 0.7), (400, 1.0)])
def test_halves_share_the_line_alone(blocks: int, share: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every block, its contact points and the numbers of its matrix are those of one half; the line's of both."""
    in_fronts(monkeypatch)
    layout = laid_out(blocks, share)
    two = halves.Halves.of(layout)
    line = layout.fronts.first[-2]
    assert two.common == len(layout.order) - line
    counted, met = np.zeros(len(layout.order)), np.zeros(len(layout.row), int)
    for half in two.halves:
        assert (half.rows[-two.common :] == np.arange(line, len(layout.order))).all()
        counted[half.rows] += half.counted
        met[half.points] += 1
        of_half = np.where(half.layout.row >= 0, half.rows[half.layout.row], -1)
        assert (of_half == layout.row[half.points]).all()
    assert (counted == 1.0).all() and (met == 1).all()


@pytest.mark.parametrize("behaviour", BEHAVIOURS)
@pytest.mark.parametrize("seed", range(3))
def test_two_threads_find_what_one_finds(wall: Assembly, behaviour: str, seed: int) -> None:
    """To rounding, with as many factorisations."""
    program = euler_step(wall, behaviour, shaken(wall, seed), 0.3)
    newtons = [newton_for(wall, program, at_once) for at_once in (1, 2)]
    agree(program, newtons, np.zeros(len(program.load)), np.zeros_like(program.gap))


@pytest.mark.parametrize("behaviour", BEHAVIOURS)
def test_two_threads_repeat_contact_states_as_one_does(wall: Assembly, behaviour: str) -> None:
    """Pushed a little more than before; with elastic joints contacts change, and the states are corrected."""
    at_rest = State(wall.initial.positions, np.zeros_like(wall.initial.positions))
    before, program = (euler_step(wall, behaviour, at_rest, push) for push in (0.05, 0.052))
    newtons = [newton_for(wall, before, at_once) for at_once in (1, 2)]
    found = agree(before, newtons, np.zeros(len(program.load)), np.zeros_like(program.gap))
    agree(program, newtons, found.displacement, found.forces)
    assert newtons[0].repeated == newtons[1].repeated == 1


def agree(program: Program, newtons: list[Newton], x: Array, forces: Array) -> Solution:
    one, two = (newton.solve(program, x, forces) for newton in newtons)
    assert one is not None and two is not None
    assert two.displacement == pytest.approx(one.displacement, rel=0, abs=1e-8 * program.step)
    assert two.forces == pytest.approx(one.forces, rel=0, abs=1e-6 * program.weight)
    assert two.certificate.worst(program.step) <= 1e-6
    assert newtons[0].factorisations == newtons[1].factorisations
    assert (newtons[0].state == newtons[1].state).all()
    return one


@pytest.mark.parametrize("behaviour", BEHAVIOURS)
def test_a_motion_is_the_same_in_two_threads(wall: Assembly, behaviour: str) -> None:
    shaking = 0.4 * np.sin(np.arange(30))
    motions = []
    for at_once in (1, 2):
        with threads.at_most(at_once):
            motions.append(time_history(wall, shaking, 0.005, behaviour, integrator="implicit-euler"))
    one, two = motions
    assert two.worst <= 1e-6 and two.resolved == one.resolved == 0
    assert two.positions == pytest.approx(one.positions, rel=0, abs=1e-9)


@pytest.mark.parametrize("place", [0, 0.45, 0.55, 1])
@pytest.mark.parametrize("value", [-1e3, np.nan])
def test_both_halves_end_where_the_matrix_of_either_is_not_definite(
    wall: Assembly, place: float, value: float
) -> None:
    """In the first half, in the second and on the line: none waits for the other."""
    program = euler_step(wall, "elastic", shaken(wall, 0), 0.3)
    newtons = [newton_for(wall, program, at_once) for at_once in (1, 2)]
    assert program.mass is not None
    row = newtons[0].order[round(place * (len(program.mass) - 1))]
    program.mass[row] = value * program.mass.max()
    for newton in newtons:
        assert newton.solve(program, np.zeros(len(program.load)), np.zeros_like(program.gap)) is None
        assert newton.factorisations == 2, "once in either attempt, at once"


@pytest.mark.parametrize("member", [0, 1])
def test_a_half_that_fails_ends_the_other(
    wall: Assembly, member: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = euler_step(wall, "elastic", shaken(wall, 0), 0.3)
    newton = newton_for(wall, program, 2)
    iterate = halves.interior_of_half

    def failing(*arguments: Any) -> Any:
        if arguments[-1][2] == member:
            raise MemoryError("no room")
        return iterate(*arguments)

    monkeypatch.setattr(halves, "interior_of_half", failing)
    with pytest.raises(MemoryError, match="no room"):
        newton.solve(program, np.zeros(len(program.load)), np.zeros_like(program.gap))
    monkeypatch.undo()
    assert newton.solve(program, np.zeros(len(program.load)), np.zeros_like(program.gap)) is not None


@pytest.mark.parametrize(
    ("numbers", "expected"), [((1.0, 2.0), 2.0), ((np.nan, 1.0), np.nan), ((1.0, np.nan), np.nan)]
)
def test_both_halves_take_the_same_number_for_the_larger(
    numbers: tuple[float, float], expected: float
) -> None:
    """What is no number among them: otherwise they go different ways from there, and meet no more."""
    gate, board = np.zeros(2, np.int64), np.empty((2, 2, 1))

    def found(member: int) -> float:
        (number,) = meeting.largest((gate, board, member, 0), (numbers[member],))
        return float(number)

    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(found, range(2))) == pytest.approx([expected] * 2, nan_ok=True)


def test_what_falls_into_no_two_halves_is_left_to_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    def layout(model: Assembly) -> Elimination:
        contacts = model.contacts("rigid")
        dof = np.concatenate([model.dof[contacts.a], model.dof[contacts.b]], axis=1)
        return Elimination.of(dof, model.initial.positions[model.movable, :2])

    assert halves.Halves.of(layout(arch_on_piers())) is None, "a band has no halves"
    in_fronts(monkeypatch)
    assert halves.Halves.of(layout(running_bond(7, 9))) is not None
    assert halves.Halves.of(layout(running_bond(2, 2))) is None
    monkeypatch.setattr(halves, "MOST", 0.4)
    assert halves.Halves.of(layout(running_bond(7, 9))) is None, "the larger half has most of the work"


def test_threads_at_hand_are_the_cores_of_the_process_or_fewer(monkeypatch: pytest.MonkeyPatch) -> None:
    if hasattr(os, "sched_getaffinity"):
        assert threads.cores() == len(os.sched_getaffinity(0))
    monkeypatch.setattr(threads, "cores", lambda: 4)
    assert threads.at_hand() == 4
    for told, expected in ((3, 3), (8, 4)):
        with threads.at_most(told):
            assert threads.at_hand() == expected
    monkeypatch.setattr(os, "name", "nt")
    assert threads.at_hand() == 1, "where no thread can sleep while it waits"
