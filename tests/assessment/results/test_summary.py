"""The summary of results: what the first page prints, held against the parts that it is of."""

from typing import Any

import pytest

from assessment.ntc.tables import farthest
from assessment.report.tables.structure import strengthening
from assessment.results.schema import Results, Summary, SummaryRow
from assessment.results.summary import summary_of
from tests.support.analysed import SETTLED, analysed
from tests.support.typed import typed


@pytest.fixture(scope="module")
def results() -> Results:
    return Results.model_validate(analysed())


def changed(change: Any) -> Summary:
    content = analysed()
    change(content)
    return summary_of(typed(content))


def row(found: Summary, state: str, direction: str = "+x") -> SummaryRow:
    return next(each for each in found.rows if (each.state, each.direction) == (state, direction))


def test_every_state_and_direction_has_its_own_numbers(results):
    found = results.summary
    assert [(each.state, each.direction) for each in found.rows] == [
        (state, direction) for state in ("original", SETTLED) for direction in ("+x", "-x")
    ]
    for each in found.rows:
        state = results.states[each.state]
        rigid, capacity = state.pushover[each.direction].rigid, state.capacity[each.direction]
        assert (each.alpha_0, each.d_0_m) == (rigid.alpha_0, rigid.d_0_m)
        assert each.checks.keys() == {"SLD", "SLV", "SLC"}
        for limit, check in each.checks.items():
            assert check.zeta_E == capacity.checks[check.check].zeta_E
            assert check.verified == (check.zeta_E >= 1.0)
            assert check.check.startswith(limit)
        assert each.static_pga_g == capacity.checks["SLC"].S * capacity.checks["SLC"].a_g_g
        assert each.governing == min(each.checks, key=lambda limit: each.checks[limit].zeta_E)


def test_a_loss_is_that_of_the_index_in_the_same_direction(results):
    for direction in ("+x", "-x"):
        before, after = (row(results.summary, state, direction) for state in ("original", SETTLED))
        assert before.alpha_loss is None and after.alpha_loss == 1.0 - after.alpha_0 / before.alpha_0
        for limit, check in after.checks.items():
            assert before.checks[limit].loss is None
            assert check.loss == 1.0 - check.zeta_E / before.checks[limit].zeta_E


def test_the_governing_one_is_the_least_index_at_slv(results):
    found = results.summary
    least = min(found.rows, key=lambda each: each.checks["SLV"].zeta_E)
    assert (found.governing.state, found.governing.direction) == (least.state, least.direction)
    assert (found.governing.limit_state, found.governing.zeta_E) == ("SLV", least.checks["SLV"].zeta_E)
    assert found.verified is all(
        each.checks[limit].zeta_E >= 1.0 for each in found.rows for limit in ("SLV", "SLC")
    )


def test_a_direction_without_capacity_is_not_determined_and_its_state_is_not_verified():
    """The least of two directions is not known where one of them is missing."""

    def verified_but_one(content):
        for state in content["states"].values():
            for capacity in state["capacity"].values():
                for limit in ("SLV", "SLC"):
                    capacity[limit] |= {"zeta_E": 1.5, "verified": True}
        del content["states"]["original"]["capacity"]["-x"]

    found = changed(verified_but_one)
    assert row(found, "original", "-x").verified is None
    assert {check.zeta_E for check in row(found, "original", "-x").checks.values()} == {None}
    assert row(found, SETTLED, "-x").checks["SLV"].loss is None
    assert row(found, "original").verified is True
    assert found.verified is None
    assert summary_of(Results.model_validate(analysed())).verified is False


def test_the_linear_check_counts_at_slv_where_the_nonlinear_one_has_no_number():
    def without(content):
        content["states"]["original"]["capacity"]["+x"]["SLV"] |= {"zeta_E": None, "verified": None}

    found = changed(without)
    counts, settled = (row(found, state).checks["SLV"] for state in ("original", SETTLED))
    assert counts.check == "SLV linear" and counts.zeta_E is not None
    # of a linear and a nonlinear check there is no loss
    assert (settled.check, settled.loss) == ("SLV", None)


def test_static_and_dynamic_capacity_are_on_one_reference_and_compared_without_confidence_factor():
    def shaken(content):
        for name, pga in (("original", 0.40), (SETTLED, 0.30)):
            state = content["states"][name]
            state["incremental"] = {
                "records": [],
                "fragility": {"pga_collapse_g": pga},
                "loss": {"dynamic": 0.25},
            }
            state["capacity"]["+x"]["nominal"] = {"pga_g": 0.5, "limit_state": "SLC"}

    found = changed(shaken)
    settled = row(found, SETTLED)
    assert found.reference == "surface"
    assert settled.dynamic_loss == pytest.approx(0.25)
    assert (settled.static_nominal_pga_g, settled.dynamic_to_static) == (0.5, pytest.approx(0.6))
    assert row(found, "original").dynamic_loss is None


@pytest.mark.parametrize(
    ("hinges", "sliding", "kind"),
    [(1, 0, "overturning"), (4, 0, "hinges"), (0, 2, "sliding"), (3, 1, "mixed")],
)
def test_a_mechanism_has_its_kind(hinges, sliding, kind):
    def moving(content):
        mechanism = content["states"]["original"]["pushover"]["+x"]["rigid"]["mechanism"]
        mechanism |= {"hinges": hinges, "sliding_joints": list(range(sliding))}

    assert row(changed(moving), "original").mechanism.kind == kind


def test_a_strengthened_state_has_its_gain_over_the_state_that_it_strengthens():
    def tied(content):
        made = {**content["states"][SETTLED], "strengthening": {"of": SETTLED, "ties": [], "layers": []}}
        made["settlement"] = None
        made["capacity"] = {"+x": {**made["capacity"]["+x"], "SLV": {**made["capacity"]["+x"]["SLV"]}}}
        made["capacity"]["+x"]["SLV"]["zeta_E"] *= 1.25
        content["states"]["tied"] = made

    assert row(changed(tied), "tied").checks["SLV"].gain == pytest.approx(0.25)
    tied(content := analysed())
    found = typed(content)
    was, made, _, other = strengthening(found.replace(summary=summary_of(found))).rows
    before, after = (found.states[name].capacity["+x"].checks for name in (SETTLED, "tied"))
    assert farthest(before) == "SLC" and (made["state"], made["of"]) == ("tied", SETTLED)
    assert (made["limit_state"], made["zeta_E"]) == ("SLV", after["SLV"].zeta_E)
    assert was["zeta_E"] == before["SLV"].zeta_E and "zeta_E" not in other
