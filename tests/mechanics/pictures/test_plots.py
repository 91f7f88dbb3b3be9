"""Models and results show themselves: drawings, curves, films, tables, and a line in place of megabytes."""

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

from mechanics import Assembly, Block, Material, Tie, limit_analysis, pushdown, pushover, time_history

STONE = Material(unit_weight=18.0, friction=0.7, normal_stiffness=5e6)


def box(x0, x1, z0, z1, support=None):
    return Block([[x0, z0], [x1, z0], [x1, z1], [x0, z1]], 1.0, STONE, support)


@pytest.fixture(scope="module")
def model():
    """Three blocks one on the other, 0.6 m by 3 m."""
    return Assembly([box(-1, 1, -0.3, 0, "base"), *(box(-0.3, 0.3, k, k + 1.0) for k in range(3))])


@pytest.fixture(scope="module")
def moved(model):
    return pushdown(model, "base", rotation=-0.02, increment=0.002)


@pytest.fixture(autouse=True)
def closed():
    with mpl.rc_context({"backend": "agg"}):
        yield
        plt.close("all")


def test_a_model_is_drawn_to_scale_with_its_ties(model):
    tied = model.tied([Tie("t", start=(0.0, 0.5), end=(0.0, 2.5), stiffness=1e4)])
    axes = tied.plot()
    assert axes.get_aspect() == 1.0
    drawn = np.vstack([p.get_path().vertices for p in axes.get_children() if hasattr(p, "get_path")][:2])
    assert drawn.min(axis=0) == pytest.approx([-1.0, -0.3])
    [line] = axes.lines
    assert np.column_stack(line.get_data()) == pytest.approx(np.array([[0.0, 0.5], [0.0, 2.5]]))


def test_a_state_is_drawn_where_it_is(model, moved):
    axes, given = plt.subplots()[1], moved.final
    assert model.plot(given, axes=axes) is axes
    masonry = next(p for p in axes.get_children() if getattr(p, "get_facecolor", lambda: 0)() == grey("0.92"))
    corners = masonry.get_path().vertices
    turned = np.array([[np.cos(-0.02), np.sin(-0.02)], [-np.sin(-0.02), np.cos(-0.02)]])
    top = np.array([[-0.3, 3.15], [0.3, 3.15]]) @ turned - [0.0, 0.15]  # about the centroid of the base
    assert min(np.abs(corners - top[0]).sum(axis=1)) < 1e-6 > min(np.abs(corners - top[1]).sum(axis=1))
    assert "×" in moved.plot().get_title() and "×" not in model.plot(given).get_title()


def grey(shade):
    return mpl.colors.to_rgba(shade)


def test_a_motion_is_a_curve_a_film_and_a_table(model, tmp_path):
    time = np.arange(0.0, 0.5, 0.005)
    motion = time_history(model, 0.3 * np.sin(12.0 * time), 0.005, control=(0.3, 3.0))
    [line] = motion.plot().lines
    assert line.get_ydata() == pytest.approx(1000.0 * motion.displacement)
    film = motion.animate(frames_per_second=20)
    film.save(tmp_path / "motion.gif", writer="pillow", dpi=30)
    assert (tmp_path / "motion.gif").read_bytes()[:4] == b"GIF8"
    frame = motion.to_frame()
    assert frame["x_3_m"].to_numpy() == pytest.approx(motion.positions[:, 3, 0])
    assert frame.index.name == "time_s" and len(frame) == len(motion.time)


def test_paths_are_films_too(model, moved, tmp_path):
    curve = pushover(model, control=(0.3, 3.0), increment=0.1)
    for found in (moved, curve):
        film = found.animate()
        film.save(tmp_path / "path.gif", writer="pillow", dpi=30)
        assert (tmp_path / "path.gif").stat().st_size > 1000


def test_results_print_a_line(model, moved):
    curve = pushover(model, control=(0.3, 3.0), increment=0.1)
    motion = time_history(model, np.zeros(3), 0.005)
    for found in (model, moved.final, limit_analysis(model), moved, curve, motion):
        assert len(repr(found)) < 160 and repr(found).startswith(f"{type(found).__name__}(")
    assert repr(model) == "Assembly(4 blocks, 1 of them supports)"
    assert repr(limit_analysis(model, sliding="coulomb")) == "Limit(+x, α = 0.2, coulomb friction)"


def test_tables_of_a_model_a_mechanism_and_a_path(model, moved):
    """Weights of 10.8 kN; the stack turns about its toe, (0.3, 0); the base bears what stands on it, its lean aside."""
    blocks = model.to_frame()
    assert blocks.weight_kN.to_numpy() == pytest.approx(10.8)
    assert blocks.support.notna().tolist() == [True, False, False, False]
    mechanism = limit_analysis(model).to_frame().to_numpy()[1:]
    assert mechanism / mechanism[:, 2:] == pytest.approx(
        np.array([[-0.5, -0.3, 1], [-1.5, -0.3, 1], [-2.5, -0.3, 1]])
    )
    path = moved.to_frame()
    assert path.reaction_z_kN.to_numpy() == pytest.approx(
        32.4
    ) and path.reaction_x_kN.to_numpy() == pytest.approx(0.0)
    assert path.movement_m.iloc[-1] == pytest.approx(0.02 * np.hypot(1.0, 0.15))
