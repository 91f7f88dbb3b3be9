"""Reference grid, interpolation, return periods: D.M. 14/01/2008, Allegati A and B; NTC 2018, §2.4, §3.2."""

import hashlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assessment.ntc.hazard import (
    RETURN_PERIODS,
    HazardCurve,
    allegato_b,
    capacity_return_period,
    read_grid,
    return_period_steps,
    site_curve,
    site_hazard,
    stated,
)
from assessment.ntc.tables import return_period

DIGEST = "060961e1a03e9b8d0af155e2632f74e7abfeae77e592d626848b9ddab3b8eb16"  # of the lines of the act


@pytest.fixture(scope="module")
def grid():
    return allegato_b()


def test_the_grid_that_comes_with_the_program_has_every_digit_of_the_act(grid):
    """The 10 751 nodes as lines of text, lon, lat, then a_g (g/10), F0, T_C* with the decimals that the act prints."""
    columns = np.column_stack(
        [grid.longitude, grid.latitude, (grid.values * [10.0, 1.0, 1.0]).reshape(-1, 27)]
    )
    decimals = [4, 3, *[3, 2, 2] * 9]
    lines = ["\t".join(f"{v:.{n}f}" for v, n in zip(row, decimals, strict=True)) for row in columns.tolist()]
    assert len(lines) == 10751
    assert lines[0].startswith("6.5448\t45.134\t0.263\t2.50\t0.18\t0.340\t2.51\t0.21")
    assert hashlib.sha256("\n".join(lines).encode()).hexdigest() == DIGEST


def _row(i, j, turn=0.1):
    """Return a node of a turned lattice of 5.56 km at 42 N 13 E; a_g = (1 + i + 10 j) × column number."""
    dx, dy = 5.56 * i, 5.56 * j
    x, y = dx * np.cos(turn) - dy * np.sin(turn), dx * np.sin(turn) + dy * np.cos(turn)
    lat = 42.0 + y / 111.195
    lon = 13.0 + x / (111.195 * np.cos(np.radians(42.0)))
    values = [v for k in range(9) for v in ((1 + i + 10 * j) * (k + 1) / 10, 2.4 + 0.01 * k, 0.3 + 0.01 * i)]
    return [lon, lat, *values]


def _write(path, rows):
    lines = ["% header", *("\t".join(f"{v:.6f}" for v in row) for row in rows), ""]
    path.write_text("\r\n".join(lines), encoding="latin-1", newline="")
    return path


@pytest.fixture
def small(tmp_path):
    return _write(tmp_path / "grid.txt", [_row(i, j) for i in range(4) for j in range(4)])


def test_laquila(grid):
    """42.35 N 13.40 E, 475 years: 0.2607 g, 2.36, 0.35 s, the value in everyday use for L'Aquila."""
    hazard = site_hazard(grid, latitude=42.35, longitude=13.40, return_period=475)
    assert hazard.ag == pytest.approx(0.2607, abs=5e-5)
    assert [hazard.F0, hazard.Tc_star] == pytest.approx([2.36, 0.35], abs=5e-3)


def test_laquila_by_hand(grid):
    """The same from four rows of the table and their distances, the formula of Allegato A written out."""
    curve = site_curve(grid, 42.35, 13.40)
    nodes = [(13.423, 42.335), (13.355, 42.335), (13.422, 42.385), (13.355, 42.385)]
    ag, d = [], []
    for lon, lat in nodes:
        k = np.flatnonzero((grid.longitude == lon) & (grid.latitude == lat))[0]
        ag.append(grid.values[k, 6, 0])
        d.append(111.195 * np.hypot((lon - 13.40) * np.cos(np.radians(42.35)), lat - 42.35))
    weights = 1 / np.array(d)
    assert curve.at(475).ag == pytest.approx((np.array(ag) * weights).sum() / weights.sum(), rel=1e-12)


def test_exact_at_nodes_and_at_the_return_periods_of_the_table(grid):
    for k in (0, 5000, 10750):  # edge nodes too: a node needs no cell
        curve = site_curve(grid, grid.latitude[k], grid.longitude[k])
        for column, T_R in enumerate(RETURN_PERIODS):
            hazard = curve.at(float(T_R))
            assert [hazard.ag, hazard.F0, hazard.Tc_star] == pytest.approx(grid.values[k, column], rel=1e-13)
    curve = site_curve(grid, 41.9, 12.5)
    for column, T_R in enumerate(RETURN_PERIODS):
        assert curve.at(float(T_R)).ag == pytest.approx(curve.values[column, 0], rel=1e-13)


@given(data=st.data())
def test_interpolation_stays_between_the_nodes_of_a_small_cell(grid, data):
    lat, lon = data.draw(st.floats(41.6, 42.5)), data.draw(st.floats(13.2, 14.0))
    T_R = data.draw(st.floats(30.0, 2475.0))
    curve = site_curve(grid, lat, lon)
    assert len(curve.distances) in {1, 4}
    assert curve.distances.max() < 1.05 * 5.56 * 2**0.5
    assert (curve.values >= curve.node_values.min(axis=0) - 1e-12).all()
    assert (curve.values <= curve.node_values.max(axis=0) + 1e-12).all()
    assert curve.return_period(curve.at(T_R).ag) == pytest.approx(T_R, rel=1e-9)


@pytest.mark.parametrize(
    ("latitude", "longitude"),
    [(39.22, 9.12), (35.50, 12.60), (48.0, 12.0), (13.40, 42.35)],
    ids=["Cagliari", "Lampedusa", "north of the grid", "latitude and longitude exchanged"],
)
def test_sites_without_nodes_get_a_clear_answer(grid, latitude, longitude):
    with pytest.raises(ValueError, match=r"no cell of four nodes.*nearest node.*km.*ag_g, F0 and Tc_star_s"):
        site_curve(grid, latitude, longitude)


@pytest.mark.parametrize("wrong", [{"latitude": "a"}, {"longitude": float("nan")}, {"latitude": 142.35}])
def test_what_is_no_coordinate_is_named(grid, wrong):
    with pytest.raises(ValueError, match=f"{next(iter(wrong))} = .*in degrees"):
        site_curve(grid, **{"latitude": 42.35, "longitude": 13.4, **wrong})


def test_a_hole_in_the_grid(tmp_path):
    """Without node (1, 1) its four cells are gone; no larger quadrilateral takes their place."""
    path = _write(tmp_path / "hole.txt", [_row(i, j) for i in range(4) for j in range(4) if (i, j) != (1, 1)])
    lon, lat = _row(1.2, 1.2)[:2]
    with pytest.raises(ValueError, match="no cell of four nodes"):
        site_curve(path, lat, lon)
    lon, lat = _row(2.2, 2.2)[:2]
    assert len(site_curve(path, lat, lon).distances) == 4


def test_turned_lattice_finds_the_cell(small):
    """Nodes (1,1), (2,1), (1,2), (2,2); at the cell's centre the four distances are equal: the plain mean."""
    nodes = np.array([_row(i, j) for i in (1, 2) for j in (1, 2)])
    lon, lat = nodes[:, :2].mean(axis=0)
    hazard = site_hazard(small, lat, lon, 475)
    mean = [nodes[:, 20].mean() / 10.0, 2.46, nodes[:, 22].mean()]
    assert [hazard.ag, hazard.F0, hazard.Tc_star] == pytest.approx(mean, rel=2e-4)


def test_log_interpolation_in_the_return_period(small):
    """Between 475 and 975 years: log p linear in log T_R."""
    node = _row(1, 1)
    a, b = node[20] / 10.0, node[23] / 10.0
    share = np.log(700 / 475) / np.log(975 / 475)
    hazard = site_hazard(small, node[1], node[0], 700)
    assert hazard.ag == pytest.approx(np.exp(np.log(a) + share * np.log(b / a)), rel=1e-6)
    with pytest.raises(ValueError, match="return_period = 5000"):
        site_hazard(small, node[1], node[0], 5000)


def _site_table(path, header="T_R [anni];a_g [g];F0;T_C* [s]", factor=1.0):
    lines = [f"{T_R:g};{factor * 0.05 * (k + 1):.4f};2.4;0.3{k}" for k, T_R in enumerate(RETURN_PERIODS)]
    path.write_text("\n".join([header, *lines]).replace(".", ","), encoding="latin-1")
    return path


@pytest.mark.parametrize("header", ["T_R;F0;a_g [g];T_C*", "T_R;PGA [g];F0;T_C*", "a_g [g];T_R;F0;T_C*"])
def test_a_header_that_names_other_columns_is_refused(tmp_path, header):
    with pytest.raises(
        ValueError, match=r"the header calls a column '.*' that is read as .*must be T_R; a_g"
    ):
        site_curve(_site_table(tmp_path / "site.csv", header))


def test_the_nine_lines_of_one_site(tmp_path):
    """T_R; a_g; F0; T_C* as site programs print them: no coordinates; a_g in g or in g/10 as the header says."""
    curve = site_curve(_site_table(tmp_path / "site.csv"))
    for k, T_R in enumerate(RETURN_PERIODS):
        found = curve.at(float(T_R))
        assert [found.ag, found.F0, found.Tc_star] == pytest.approx([0.05 * (k + 1), 2.4, 0.3 + 0.01 * k])
    tenths = _site_table(tmp_path / "tenths.csv", "T_R;a_g [g/10];F0;T_C*", 10.0)
    assert site_curve(tenths).values == pytest.approx(curve.values)


def test_the_return_period_of_an_acceleration_ends_at_the_bounds(tmp_path):
    """a_g from 0.05 g (30 years) to 0.45 g (2475): the columns give their years, beyond them the bound, exactly."""
    curve = site_curve(_site_table(tmp_path / "site.csv"))
    assert curve.return_period(0.35) == pytest.approx(475.0)
    assert [curve.return_period(ag) for ag in (0.01, 0.05, 0.45, 2.0)] == [30.0, 30.0, 2475.0, 2475.0]


def test_bad_grids_are_named(tmp_path):
    rows = [_row(0, 0), _row(1, 0)]
    with pytest.raises(ValueError, match=r"short\.txt: line 3: 29 numbers expected"):
        read_grid(_write(tmp_path / "short.txt", [rows[0], rows[1][:20]]))
    text = _write(tmp_path / "word.txt", rows).read_text().replace("2.400000", "many", 1)
    (tmp_path / "word.txt").write_text(text)
    with pytest.raises(ValueError, match=r"word\.txt: line 2"):
        read_grid(tmp_path / "word.txt")
    (tmp_path / "empty.txt").write_text("% nothing\n")
    with pytest.raises(ValueError, match=r"empty\.txt: no row of numbers"):
        read_grid(tmp_path / "empty.txt")
    in_g = [[v / 10 if k >= 2 and (k - 2) % 3 == 0 else v for k, v in enumerate(row)] for row in rows]
    with pytest.raises(ValueError, match="g/10"):
        read_grid(_write(tmp_path / "in_g.txt", in_g))


@pytest.mark.parametrize(
    ("state", "life", "use", "expected"),
    [
        ("SLO", 50, "II", 30.1072),  # −50/ln 0.19
        ("SLD", 50, "II", 50.2890),  # −50/ln 0.37
        ("SLV", 50, "II", 474.561),  # −50/ln 0.90
        ("SLC", 50, "II", 974.786),  # −50/ln 0.95
        ("SLV", 50, "III", 711.842),
        ("SLO", 50, "I", 30.0),
        ("SLC", 100, "IV", 2475.0),
    ],
)
def test_return_periods(state, life, use, expected):
    assert return_period(state, life, use) == pytest.approx(expected, rel=1e-5)
    assert return_period_steps(state, life, use)[-1].result == return_period(state, life, use)


VALUES = np.column_stack([np.geomspace(0.05, 0.5, 9), np.linspace(2.4, 2.5, 9), np.linspace(0.27, 0.35, 9)])
CURVE = HazardCurve("hand-made", VALUES, VALUES[None], np.zeros(1))


def test_law_by_hand():
    """T_R,D = 475 years, PGA_C/PGA_D = 0.5: 0.5^(1/0.41) = exp(−0.693147/0.41) = exp(−1.690603) = 0.184408.

    T_R,C = 475·0.184408 = 87.594 years; without a curve nothing bounds it: ratio 2 gives 475/0.184408 = 2575.8 years.
    """
    found = capacity_return_period(0.1, 0.15, 0.30, 475.0, None)
    assert found.result == pytest.approx(87.594, rel=1e-5)
    beyond = capacity_return_period(0.4, 0.60, 0.30, 475.0, None)
    assert beyond.result == pytest.approx(2575.8, rel=1e-5)
    assert (stated(beyond.result), stated(found.result)) == ("> 2475", None)
    assert capacity_return_period(0.1, 0.15, 0.30, None, None) is None


def test_the_curve_counts_within_its_bounds():
    """Between the nine return periods the curve; a_g = 0.6 g lies above its 0.5 g, 0.04 g below its 0.05 g.

    Above: T_R,D = 975, ratio 2: 975/0.184408 = 5287.2 years; T_R,D = 475, ratio 1.1: 599 years is back inside: 2475.
    Below: T_R,D = 50, ratio 0.5: 9.2204 years; ratio 0.9: 38.7 is back inside: 30.
    """
    assert capacity_return_period(0.2, 0.2, 0.1, 475.0, CURVE).result == CURVE.return_period(0.2)
    assert capacity_return_period(0.6, 0.6, 0.3, 975.0, CURVE).result == pytest.approx(5287.2, rel=1e-5)
    assert capacity_return_period(0.6, 0.33, 0.3, 475.0, CURVE).result == 2475.0
    below = capacity_return_period(0.04, 0.04, 0.08, 50.0, CURVE).result
    assert (below, stated(below)) == (pytest.approx(9.2204, rel=1e-5), "< 30")
    assert capacity_return_period(0.04, 0.045, 0.05, 50.0, CURVE).result == 30.0
    assert capacity_return_period(0.6, 0.6, 0.3, None, CURVE).result == 2475.0
