"""What scripts call: builders of every template, incremental analysis, fragility."""

import inspect

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

import assessment
from assessment.project.catalogue.new_project import TEMPLATES, template_options
from mechanics import ArgumentError, Material, Record, limit_analysis


@pytest.mark.parametrize("template", TEMPLATES)
def test_every_template_has_a_builder_with_its_dimensions(template):
    build = getattr(assessment, template.replace("-", "_"))
    assert template.replace("-", "_") in assessment.__all__
    given = template_options(template)
    assert list(inspect.signature(build).parameters) == [*given, "material", "depth_m"]
    assert all(f"{name}: " in build.__doc__ for name in given)


def test_a_builder_makes_the_structure_of_its_template():
    stone = Material(unit_weight=20.0, friction=0.9)
    model = assessment.block(width_m=0.5, height_m=4.0, material=stone, depth_m=2.0)
    assert model.weight == pytest.approx(0.5 * 4.0 * 2.0 * 20.0)
    assert limit_analysis(model).alpha == pytest.approx(0.5 / 4.0)
    with pytest.raises(ValueError, match='no such option; did you mean "height_m"'):
        assessment.block(heigth_m=4.0)
    with pytest.raises(ValueError, match="must be a number, in m"):
        assessment.block(height_m=-4.0)


def test_incremental_finds_the_level_that_overturns_and_fragility_counts_what_withstands():
    """A rectangular pulse of 0.5 s, as strong as it takes: West's formula is for one of constant acceleration."""
    time = np.arange(0.0, 0.8, 0.01)
    block = assessment.block(width_m=0.6, height_m=3.0)
    short, long = (
        assessment.incremental(
            block, Record(0.3 * (time < length), 0.01, f"{length} s"), (0.3, 3.0), max_scale=largest
        )
        for length, largest in ((0.1, 1.5), (0.5, 3.0))
    )
    assert short.collapse is None and short.safe == pytest.approx(0.45)
    assert 0.2 < long.safe < long.collapse < long.safe + 0.01
    assert repr(long).startswith("IncrementalCurve(0.5 s, ") and len(repr(long)) < 120
    frame = long.to_frame()
    assert frame.pga_g.is_monotonic_increasing and frame.peak_displacement_m.isna().equals(frame.collapsed)
    with mpl.rc_context({"backend": "agg"}):
        [line] = long.plot().lines
        plt.close("all")
    assert max(line.get_ydata()) < long.levels.max()
    fit = assessment.fragility([short, long])
    assert fit.median > long.collapse and fit.beta > 0.0
    assert assessment.fragility([short]) is None
    with pytest.raises(ArgumentError, match="record = ndarray: must be a Record"):
        assessment.incremental(block, time, (0.3, 3.0))
