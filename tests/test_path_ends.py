"""How paths end, and what the contacts as drawn cannot show."""

from __future__ import annotations

import numpy as np
import pytest

from assessment.benchmark.structures import assembly, template
from mechanics import Assembly, Block, Material, UnstableError, limit_analysis, pushdown, pushover
from mechanics.errors import CollapseError, NoEquilibriumError
from tests.structures import arch_on_piers, block_on_base, rectangle

STONE = Material(20.0, 0.6, 1e6)


def test_a_structure_that_rides_with_its_support_has_no_ultimate_movement():
    path = pushdown(block_on_base(), "base", (0.02, -0.02), increment=0.01, to_collapse=True)
    assert path.ultimate is None
    assert path.end == "the structure moves with its support as a whole"
    assert len(path.movement) < 20


def test_a_turn_with_a_small_translation_is_as_good_as_one_without():
    model = block_on_base()
    pure = pushdown(model, "base", rotation=-0.05, increment=0.005).final
    mixed = pushdown(model, "base", (0.0005, 0.0), rotation=-0.05, increment=0.0005 / 10).final
    np.testing.assert_allclose(mixed.positions[1] - pure.positions[1], [0.0005, 0.0, 0.0], atol=1e-5)


def test_the_arc_of_a_turn_does_not_depend_on_vertices_in_the_middle_of_an_edge():
    plain = [[-1.0, -0.2], [1.0, -0.2], [1.0, 0.0], [-1.0, 0.0]]
    dotted = [*plain[:1], *([x, -0.2] for x in (-0.9, -0.8, -0.7)), *plain[1:]]
    wall = Block(rectangle(-0.1, 0.0, 0.1, 1.0), 1.0, STONE)
    arcs = [
        pushdown(Assembly([Block(base, 1.0, STONE, support="base"), wall]), "base", rotation=0.01).movement[
            -1
        ]
        for base in (plain, dotted)
    ]
    assert arcs[0] == pytest.approx(arcs[1], rel=1e-12)


def test_a_repeated_vertex_makes_no_difference():
    def wall_and_buttress(repeat: bool) -> Assembly:
        buttress = [[0.3, 0.0], [0.8, 0.0], [0.3, 1.5]]
        return Assembly(
            [
                Block(rectangle(-1.0, -0.2, 2.0, 0.0), 1.0, STONE, support="base"),
                Block(rectangle(0.0, 0.0, 0.3, 2.0), 1.0, STONE),
                Block([*buttress, buttress[0]] if repeat else buttress, 1.0, STONE),
            ]
        )

    plain, repeated = wall_and_buttress(False), wall_and_buttress(True)
    assert len(repeated.joints.a) == len(plain.joints.a) == 3
    assert limit_analysis(repeated).alpha == pytest.approx(limit_analysis(plain).alpha, abs=1e-9)


def test_fewer_than_three_distinct_vertices_are_refused():
    with pytest.raises(ValueError, match="vertices"):
        Block([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 0.0]], 1.0, STONE)


def test_a_loss_of_equilibrium_is_told_from_a_path_followed_to_zero():
    followed = pushover(block_on_base(), (0.2, 1.0), increment=0.02)
    assert followed.reached_zero
    assert not followed.lost
    ended = pushover(arch_on_piers(), (0.85, 0.8), increment=0.001)
    assert ended.lost
    assert not ended.reached_zero
    assert ended.multiplier[-1] > 0.1


def test_a_path_cut_short_is_neither(monkeypatch):
    import importlib

    procedure = importlib.import_module("mechanics.pushover")
    monkeypatch.setattr(procedure, "MOST_STEPS", 5)
    cut = pushover(block_on_base(friction=0.1), (0.2, 1.0), increment=0.001)
    assert not cut.reached_zero
    assert not cut.lost


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_an_increment_wider_than_the_settlement_is_no_reason_to_give_up(contacts):
    """A base turned by θ leaves d_0 = H sin(arctan(B/H) − θ), found whatever the increment."""
    model = block_on_base(stiffness=1e6)
    moved = pushdown(model, "base", rotation=-0.002, increment=0.01).final
    for increment in (0.01, 0.05, 0.1):
        path = pushover(model, (0.2, 1.0), "+x", contacts, increment, moved)
        assert path.reached_zero
        expected = np.hypot(0.2, 1.0) * np.sin(np.arctan(0.2) - 0.002)
        assert path.displacement[-1] == pytest.approx(expected, rel=2e-2)


@pytest.mark.parametrize("contacts", ["rigid", "elastic"])
def test_a_block_that_only_slides_is_not_followed_for_ever(contacts):
    model = block_on_base(friction=0.1, stiffness=1e6)
    path = pushover(model, (0.2, 1.0), "+x", contacts, 0.02)
    assert "slides: α stays 0.1 over" in path.end
    assert not path.reached_zero and not path.lost
    assert path.displacement[-1] == pytest.approx(model.size, abs=0.05)


@pytest.mark.parametrize(
    ("height", "stiffness", "says"),
    [(1.0, 1e3, "0.018 m into each other"), (3.0, 1.5e4, "no equilibrium leads away from rest")],
)
def test_a_bed_too_soft_is_named_as_such(height, stiffness, says):
    """It stands where k d l³/12 (1 + 2/m²) exceeds W h/2: for 1 and 3 m above 2.4e3 and 2.2e4 kN/m³, with m = 4."""
    model = block_on_base(height=height, stiffness=stiffness, segments=4)
    with pytest.raises(UnstableError, match=says):
        pushover(model, (0.2, height), contacts="elastic")


def _without_equilibrium(monkeypatch, between: tuple[float, float]) -> None:
    """No step of `block_on_base` ends where the control point has moved by what lies between two displacements."""
    import importlib

    procedure = importlib.import_module("mechanics.pushover")
    find = procedure.find_step

    def find_step(model, *arguments):
        step = find(model, *arguments)
        if between[0] < model.point_displacement(CORNER, 1, step.state.positions)[0] < between[1]:
            raise NoEquilibriumError("a part falls")
        return step

    monkeypatch.setattr(procedure, "find_step", find_step)


CORNER = (0.2, 1.0)


def test_where_a_part_moves_by_itself_the_curve_goes_on_beyond(monkeypatch):
    whole = pushover(block_on_base(), CORNER, increment=0.01)
    _without_equilibrium(monkeypatch, between=(0.055, 0.068))
    curve = pushover(block_on_base(), CORNER, increment=0.01)
    assert curve.reached_zero
    assert curve.displacement[-1] == pytest.approx(whole.displacement[-1], rel=1e-3)
    ((start, end),) = curve.crossed
    assert 0.045 <= start <= 0.055
    assert 0.068 <= end <= 0.088
    assert len(whole.crossed) == 0


def test_where_nothing_stands_beyond_the_last_equilibrium_is_located(monkeypatch):
    _without_equilibrium(monkeypatch, between=(0.055, np.inf))
    curve = pushover(block_on_base(), CORNER, increment=0.01)
    assert curve.lost
    assert curve.end == "a part falls"
    assert 0.055 - 0.01 / 32 <= curve.displacement[-1] <= 0.055


def _arch_without_equilibrium(monkeypatch, increment, between):
    """An arch whose steps fail while its support has moved by so many increments."""
    import importlib

    procedure = importlib.import_module("mechanics.pushdown")
    find, model = procedure.find_step, arch_on_piers()
    index, drawn = model.support("right"), model.initial.positions

    def find_step(model, behaviour, start, guess, *arguments, **options):
        moved = float((guess - drawn)[index, 0].max()) / increment
        if between[0] < moved < between[1]:
            raise NoEquilibriumError("a part falls")
        return find(model, behaviour, start, guess, *arguments, **options)

    monkeypatch.setattr(procedure, "find_step", find_step)
    return pushdown(model, "right", (9.0 * increment, 0.0), increment=increment, to_collapse=True)


INCREMENT = arch_on_piers().size / 50.0


def test_a_movement_goes_on_beyond_a_part_that_moves_by_itself(monkeypatch):
    path = _arch_without_equilibrium(monkeypatch, INCREMENT, between=(5.2, 6.8))
    assert path.crossed / INCREMENT == pytest.approx(np.array([[5.0, 7.0]]))
    assert np.diff(path.movement[path.movement >= 7.0 * INCREMENT])[0] == pytest.approx(INCREMENT)


def test_a_movement_ends_where_nothing_stands_beyond(monkeypatch):
    with pytest.raises(CollapseError, match="a part falls") as collapse:
        _arch_without_equilibrium(monkeypatch, INCREMENT, between=(5.2, np.inf))
    assert 5.2 - 1.0 / 32 <= collapse.value.path.movement[-1] / INCREMENT <= 5.2
    assert len(collapse.value.path.crossed) == 0


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_a_hinge_of_the_settlement_that_snaps_shut_is_no_end_of_the_capacity(direction):
    """The multiplier comes down to zero within 3 mm, and up to ten times the onset's as the hinge has closed."""
    project, model = template("arch"), assembly("arch")
    (table,) = project.settlements
    settled = pushdown(model, table.support, table.displacement_m, 0.0, table.increment_m).final
    control, increment = project.pushover_control(direction).point_m, project.pushover.increment_m
    curves = [pushover(model, control, direction, "rigid", increment / k, settled) for k in (1, 2, 4)]
    for curve in curves:
        assert curve.multiplier[0] < 0.04
        assert curve.multiplier.max() == pytest.approx(0.22, rel=0.05)
        assert curve.displacement[-1] == pytest.approx(0.0455, rel=0.02)
