"""A number of each template: closed forms, other formulations, templates that are the same at the same dimensions."""

from typing import Annotated

import numpy as np
import pytest
from shapely.geometry import Polygon, box
from shapely.ops import unary_union

from assessment.analyses.kinematics import virtual_work
from assessment.cli.main import main
from assessment.project.catalogue import templates
from assessment.project.catalogue.new_project import TEMPLATES, made, new_project
from assessment.project.masonry import chosen_mechanisms
from assessment.project.model import build_model
from assessment.project.project import load_project
from mechanics import Assembly, limit_analysis
from tests.assessment.project.test_geometry import corners
from tests.support.template_assembly import template_assembly, with_ties

TIGHT = {"abs": 2e-9}  # of α: that of the interior-point method


# façade: simple and compound overturning, Circolare 7/2019, C8.7.1.2


def overturning(model: Assembly, toe: float, layers=None, ties=()) -> float:
    """α0 of the masonry above the foot about its outer edge: (Σ W x + Σ F z)/Σ W z, x inward from the toe, z upward."""
    turns = [
        k
        for k, each in enumerate(model.blocks)
        if model.movable[k] and (each.layer in layers if layers else each.layer != "CUNEO")
    ]
    weight = np.array([model.blocks[k].weight for k in turns])
    x, z = toe - model.initial.positions[turns, 0], model.initial.positions[turns, 1]
    return float((weight @ x + sum(force * height for force, height in ties)) / (weight @ z))


@pytest.mark.parametrize("sliding", ["associative", "coulomb"])
@pytest.mark.parametrize(
    "options",
    [
        {"storeys": 1, "floor_load_kN": 0.0, "roof_load_kN": 0.0, "crack_deg": 0.0},
        {"crack_deg": 0.0},
        {"floor_load_kN": 20.0, "bearing_m": 0.3},
        {"storeys": 3, "roof_load_kN": 15.0},
    ],
    ids=["wall alone", "floor and roof", "deep bearing, side walls", "three storeys, heavy roof"],
)
def test_simple_overturning_with_floors_and_roof(options, sliding):
    model = template_assembly("facade", **options)
    assert limit_analysis(model, "+x", sliding=sliding).alpha == pytest.approx(
        overturning(model, 0.6), **TIGHT
    )


def test_simple_overturning_with_ties_that_yield():
    """Ties at 3.325 and 6.825 m: each adds F z to what the weights gain."""
    options = {"tie_kN": 3.0}
    model = template_assembly("facade", **options)
    expected = overturning(model, 0.6, ties=[(3.0, 3.325), (3.0, 6.825)])
    found = limit_analysis(with_ties("facade", model, **options), "+x").alpha
    assert found == pytest.approx(expected, **TIGHT)


def test_overturning_with_a_roof_that_thrusts():
    """The rafter touches the ridge at its upper edge, the wall at the inner edge of its foot and the foot of the heel.

    As the wall turns by 1 its top (0, H) moves by (H, t); the rafter turns back by ψ = H/(r + e), so that its ridge
    does not leave the vertical face: its centroid moves by (H − ψ (z − H), t + ψ x), x and z those of the centroid.
    """
    options = {"roof_rise_m": 4.0, "crack_deg": 0.0}
    model = template_assembly("facade", **options)
    height, rise, rafter = 7.0, 4.0, 0.2
    turns = [k for k in range(len(model.blocks)) if model.movable[k]]
    weight = np.array([model.blocks[k].weight for k in turns])
    x, z = model.initial.positions[turns, :2].T
    dx, dz = z.copy(), 0.6 - x
    at = [model.blocks[k].layer for k in turns].index("PUNTONI")
    psi = height / (rise + rafter)
    dx[at], dz[at] = height - psi * (z[at] - height), 0.6 + psi * x[at]
    found = limit_analysis(model, "+x")
    assert found.alpha == pytest.approx(float(weight @ dz) / float(weight @ dx), **TIGHT)
    assert found.alpha < limit_analysis(template_assembly("facade", crack_deg=0.0), "+x").alpha


@pytest.mark.parametrize("angle", [15.0, 30.0])
def test_compound_overturning_is_the_chosen_mechanism_of_the_side_walls(tmp_path, angle):
    """The side walls above the crack turn with the façade: their weights and arms stand in the sums."""
    options = {"crack_deg": angle, "tie_kN": 0.0}
    new_project(tmp_path / "new", "facade", options)
    project = load_project(tmp_path / "new")
    model = build_model(project).assembly
    simple, compound = (
        virtual_work(model, model.initial.positions, each).alpha_0
        for each in chosen_mechanisms(project, model)
    )
    assert simple == pytest.approx(overturning(model, 0.6), rel=1e-12)
    every = ("FACCIATA", "SOLAI", "TETTO", "CUNEO")
    assert compound == pytest.approx(overturning(model, 0.6, every), rel=1e-12)
    assert compound > simple
    wedge = unary_union([Polygon(each) for each in made("facade", options)[0]["CUNEO"]])
    whole = 0.5 * 7.0**2 * np.tan(np.radians(angle))
    assert wedge.area == pytest.approx(whole * (1.0 + 1.0 / 20.0), rel=1e-9), (
        "each course up to its upper edge"
    )


# gables


@pytest.mark.parametrize("options", [{}, {"width_m": 5.0, "height_m": 4.0, "thickness_m": 0.5}])
def test_a_tympanum_turns_about_its_foot(options):
    """t/2 over the height of the centroid, that of the courses; of ever lower ones H/3."""
    values = {"height_m": 3.0, "thickness_m": 0.4} | options
    height, thickness, courses = values["height_m"], values["thickness_m"], round(values["height_m"] / 0.3)
    middles = height * (np.arange(courses) + 0.5) / courses
    centroid = ((height - middles) @ middles) / (height - middles).sum()
    model = template_assembly("tympanum", **options)
    assert limit_analysis(model).alpha == pytest.approx(0.5 * thickness / centroid, **TIGHT)
    assert centroid == pytest.approx(height / 3.0, rel=0.02)
    assert model.weight == pytest.approx(0.5 * values.get("width_m", 8.0) * height * thickness * 18.0)


@pytest.mark.parametrize("openings", [1, 2, 3])
def test_a_bell_gable_sways_on_its_piers(openings):
    """Each pier turns about a lower corner, the lintel stays level on the opposite upper ones: α0 = b/h."""
    model = template_assembly("bell-gable", openings=openings)
    assert limit_analysis(model).alpha == pytest.approx(0.5 / 1.6, **TIGHT)


# arches and vaults


def test_a_pointed_arch_of_half_the_span_is_the_round_one():
    alike = {"span_m": 3.0, "rise_m": 1.5, "voussoirs": 20}
    assert corners(made("pointed-arch", alike)[0]) == corners(made("arch", alike)[0])
    # the branch of two centres
    just = template_assembly("pointed-arch", span_m=3.0, rise_m=1.5000001, voussoirs=20)
    assert limit_analysis(just).alpha == pytest.approx(
        limit_analysis(template_assembly("arch", **alike)).alpha, rel=1e-5
    )


def test_a_pointed_arch_lies_between_two_circles_about_points_of_the_springing():
    layout = made("pointed-arch", {})[0]
    right = unary_union([Polygon(each) for each in layout["ARCO"]]).intersection(box(0.0, 0.0, 9.0, 9.0))
    radius = (1.5**2 + 2.4**2) / 3.0  # R² = (R − s/2)² + r²
    x, z = np.array(right.exterior.coords).T
    away = np.hypot(x + radius - 1.5, z)
    on_a_joint = away[(abs(away - radius) < 1e-9) | (abs(away - radius - 0.3) < 1e-9)]
    assert len(on_a_joint) == len(away) and z.max() > 2.7


def test_an_arcade_of_one_bay_is_the_arch_on_piers():
    alike = {"span_m": 2.4, "rise_m": 1.2, "thickness_m": 0.3, "voussoirs": 15, "pier_width_m": 0.8}
    alike |= {"pier_height_m": 2.4, "blocks_per_pier": 5}
    one = made("arcade", alike | {"bays": 1})[0]
    assert corners(one) == corners(made("buttressed-arch", alike)[0])


def test_the_fill_of_a_vault_is_all_that_lies_between_it_and_one_level():
    """γ times the area below the level of the fill and above ring and walls, by polygons of another program."""
    layout, content = made("barrel-vault", {"cover_m": 0.3})
    layers = content["layers"]
    loads = sum(
        layers[name]["vertical_load_kN"] * len(shapes)
        for name, shapes in layout.items()
        if "vertical_load_kN" in layers.get(name, {})
    )
    masonry = unary_union(
        [Polygon(each) for name, shapes in layout.items() if "BASE" not in name for each in shapes]
    )
    low, _, high, top = masonry.bounds
    above = box(low, 2.5, high, top + 0.3).difference(masonry)
    fill = [part for part in getattr(above, "geoms", [above]) if part.bounds[3] > top + 0.29]
    assert loads == pytest.approx(16.0 * sum(part.area for part in fill), rel=1e-6)


# wall with openings


def test_dimensions_that_give_no_structure_are_refused_before_anything_is_written(
    tmp_path, capsys, monkeypatch
):
    def overlapping(width_m: Annotated[float, "width"] = 1.0):
        layout, content = templates.block(width_m, 1.0)
        return layout | {"BLOCCO": 2 * layout["BLOCCO"]}, content

    monkeypatch.setitem(TEMPLATES, "block", overlapping)
    assert main(["new", str(tmp_path / "arch"), "--template", "block", "--set", "width_m=2"]) == 2
    assert "--set: the dimensions give no structure: " in (said := capsys.readouterr().err)
    assert "drawn twice" in said and said.count("\n") == 1
    assert not list(tmp_path.iterdir())
