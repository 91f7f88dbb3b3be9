"""Three levels of the time step: error with the order observed, or scatter."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from assessment.analyses.dynamic.histories import Refinement


def levels(*values, scatter=0.0):
    return Refinement(values, (scatter,) * len(values), 1e-9)


@given(
    exact=st.floats(0.1, 9.0),
    share=st.floats(-0.5, 0.5).filter(lambda s: abs(s) > 1e-3),
    order=st.floats(0.5, 2.0),
    count=st.integers(3, 5),
)
def test_the_error_bounds_that_of_any_order_which_is_told(exact, share, order, count):
    values = [exact * (1.0 + share * 2.0 ** (-order * n)) for n in range(count)]
    found = levels(*values)
    assert found.order == pytest.approx(order, abs=1e-3)
    if order >= 1.0:
        assert found.error >= 0.999 * abs(values[-1] - exact)
    assert found.finished(0.5) == found.within(0.5)


def test_two_levels_never_tell_that_it_is_enough():
    assert not levels(3.22, 3.22).within(0.05) and not levels(3.22, 3.22).finished(0.05)
    assert levels(3.22, 3.22).row("s", "r", 0.05).relative_error is None


def test_two_equal_levels_and_a_third_that_differs_are_not_believed():
    """Implicit Euler on a rocking arch: 3.22, 3.22, 3.88 and then 6.7 mm."""
    found = levels(3.22, 3.22, 3.88)
    assert found.order is None and found.error == pytest.approx(0.66)
    assert not found.within(0.05)
    assert not levels(3.22, 3.22, 3.88, 6.7).within(0.05)
    last = levels(3.88, 3.22, 3.22)
    assert last.order is None and last.error == pytest.approx(0.66), "nor where the last two are the same"


def test_scatter_that_levels_do_not_exceed_is_told_as_such():
    """3.28, 3.25, 3.22 mm look converged; records that differ by 1 % say how far they are to be believed."""
    found = levels(3.28, 3.25, 3.22, scatter=0.4)
    assert found.scatters == 0.4 and found.finished(0.05) and not found.within(0.05)
    row = found.row("s", "r", 0.05)
    assert row.peak_displacement_scatter_m == 0.4 and "peak_displacement_error_m" not in row.model_fields_set
    [said] = found.missed("original", 0.05)
    assert "scatters by 12 %" in said
    assert levels(3.9, 3.5, 3.22, scatter=0.4).scatters is None


def test_a_collapse_that_all_levels_see_has_no_error_and_one_that_some_see_leaves_it_open():
    assert levels(None, None, None).within(0.05)
    assert "relative_error" not in levels(None, None, None).row("s", "r", 0.05).model_fields_set
    assert levels(0.1, None, None).error is None and not levels(0.1, None, None).within(0.05)
    assert "not known" in levels(0.1, 0.1, None).missed("original", 0.05)[0]


def test_values_that_are_nothing_have_no_error():
    found = Refinement((3e-13, 1e-13, 2e-13), (0.0,) * 3, 1e-6)
    assert found.within(0.01)
