"""Results whose numbers are drawn freely, for the draft judgement; what is derived from them is derived as by a run."""

from operator import itemgetter
from typing import Any

from hypothesis import strategies as st

from assessment.analyses.found import quality_of
from assessment.report.tables.mechanisms import SECOND_SOLVER
from assessment.results.schema.model import QualityRow
from assessment.results.schema.part import plain
from assessment.results.schema.studies import ScenarioPoint
from assessment.results.table import comparison
from assessment.studies.variants import worst as worst_of
from tests.support.judgement.claims import LIMITS, RESIDUALS, Results
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import made, typed


def summed_up(quality: dict[str, Any]) -> dict[str, Any]:
    """The certificates with the worst of them, as a run sums them up."""
    rows = [made(QualityRow, row) for row in quality["by_stage"]]
    return plain(quality_of(rows, quality["warnings"]))


CAPACITY = st.one_of(st.none(), st.floats(0.001, 1.5), st.sampled_from([0.1, 0.2]))  # the last: equals
DIFFERENCE = st.one_of(st.none(), st.floats(-1e-4, 1e-4), st.floats(-1e-6, 1e-6))
SECOND = st.one_of(
    st.none(), DIFFERENCE.map(lambda each: dict(zip(SECOND_SOLVER, (0.1, 0.1, 0.1, each), strict=True)))
)
RESIDUAL = st.one_of(st.just(0.0), st.floats(1e-12, 1e-2))


@st.composite
def directions_checked(draw, limits, demand):
    """The checks of one direction."""
    found: Results = {"curve": None}
    for limit in limits:
        for check in ("SLV linear", "SLV") if limit == "SLV" else (limit,):
            a_g = draw(CAPACITY)
            ratio = None if a_g is None else a_g / demand[limit]
            found[check] = {"a_g_g": a_g, "demand_a_g_g": demand[limit], "pga_g": a_g, "zeta_E": ratio}
            found[check]["verified"] = None if ratio is None else ratio >= 1.0
    found["nominal"] = {"pga_g": draw(CAPACITY)}
    return found


@st.composite
def random_results(draw):
    """Results whose numbers are drawn freely; what is derived from them is derived as by a run."""
    results = results_example("en")
    example = results["states"]
    names = draw(st.lists(st.sampled_from([SETTLED, "left <b> & down", "SLC"]), max_size=2, unique=True))
    directions = draw(st.sampled_from([("+x",), ("-x",), ("+x", "-x")]))
    limits = draw(st.sets(st.sampled_from(LIMITS)))
    limits = [limit for limit in LIMITS if limit in limits]
    demand = {limit: draw(st.floats(0.02, 0.6)) for limit in limits}
    states = {}
    for name in ("original", *names):
        content = {**example["original" if name == "original" else SETTLED]}
        standing = [d for d in directions if name == "original" or draw(st.integers(0, 9))]
        content["pushover"] = {}
        for d in standing:
            alpha_0 = draw(st.floats(0.01, 0.5))
            rigid = content_of(
                example, d, alpha_0, draw(st.floats(0.95, 1.05) | st.sampled_from([0.987, 0.992]))
            )
            rigid["second_solver"] = draw(SECOND)
            content["pushover"][d] = {"control": "C1", "rigid": rigid}
        content["capacity"] = {
            d: draw(directions_checked(limits, demand))
            for d in standing
            if limits and draw(st.integers(0, 9))
        }
        collapse = draw(st.one_of(st.none(), st.floats(0.01, 0.3)))
        content["incremental"] = (
            {"records": [], "fragility": {"pga_collapse_g": collapse}} if collapse else {}
        )
        content["history"] = []
        if name != "original":
            content["pushdown"] = {
                contacts: example[SETTLED]["pushdown"][contacts]
                | {
                    "applied_movement_m": draw(st.floats(1e-3, 0.1)),
                    "ultimate_movement_m": draw(st.one_of(st.none(), st.floats(1e-3, 0.2))),
                }
                for contacts in ("rigid", "elastic")
            }
        if name != "original" and draw(st.booleans()):
            content["pushdown"], content["settlement"] = {}, None
            content["strengthening"] = {"of": "original", "ties": ["chain"], "layers": []}
            for pushed in content["pushover"].values():
                pull = draw(st.floats(0.0, 2.0))
                tension = {"tie": "chain", "rest_kN": None, "peak_kN": pull, "greatest_kN": pull}
                pushed["rigid"]["ties"] = [tension | {"yields": draw(st.booleans())}]
        states[name] = content
    results["states"] = plain(states)
    results["quality"]["by_stage"] = [
        row | {f"worst_{name}": draw(RESIDUAL) for name in RESIDUALS}
        for row in results["quality"]["by_stage"]
    ]
    results["quality"] = summed_up(results["quality"])
    results["quality"]["warnings"] = draw(st.lists(st.sampled_from(["a", "b", "c"])))
    results["echo"]["pushover"]["directions"] = list(directions)
    results["echo"]["settlements"] = [{"name": name, "to_collapse": draw(st.booleans())} for name in names]
    if limits:
        results["mechanisms"] = draw(
            st.lists(chosen(limits, demand), max_size=2, unique_by=itemgetter("name"))
        )
    results["comparison"] = plain(comparison(typed(results).summary.rows))
    if draw(st.booleans()) and names:
        results["scenarios"] = draw(scenarios_of(names, directions, limits))
    if draw(st.booleans()) and limits:
        results["sensitivity"] = draw(sensitivity_of(list(states), directions, limits))
    return Drawn(results)


class Drawn(Results):
    """Results whose representation is short: hypothesis makes one of every example."""

    def __repr__(self) -> str:
        return f"results of {list(self['states'])}"


def content_of(example: Results, direction: str, alpha_0: float, deviation: float) -> Results:
    """A rigid curve of the example with another multiplier, and one by virtual work that departs from it."""
    rigid = example["original"]["pushover"][direction]["rigid"]
    mechanism = rigid["mechanism"] | {"alpha": alpha_0}
    return rigid | {"alpha_0": alpha_0, "virtual_work_alpha": deviation * alpha_0, "mechanism": mechanism}


@st.composite
def chosen(draw, limits, demand):
    """A mechanism chosen by the user, with its linear checks."""
    found = draw(directions_checked([limit for limit in limits if limit != "SLC"], demand))
    found.pop("SLV", None)
    del found["curve"], found["nominal"]
    checks = {name: check | {"return_period_years": None} for name, check in found.items()}
    name = draw(st.text("abc", min_size=1, max_size=30))
    return {"name": name, "state": "original", "direction": "+x", "alpha_0": 0.1} | checks


@st.composite
def scenarios_of(draw, names, directions, limits):
    """Points of sweeps in two parts, and the worst of them."""
    by = "a_g_g" if limits else draw(st.sampled_from(["alpha_0", "alpha_u"]))
    points = []
    for name in names:
        fallen = draw(st.integers(0, 5)) == 0
        for share in (0.5, 1.0):
            for direction in directions:
                value = None if fallen else draw(CAPACITY)
                points.append(
                    {"state": name, "share": share, "movement_m": 0.02 * share, "direction": direction}
                    | {"collapses": fallen, by: value, "reduction": None if value is None else 1.0 - value}
                )
    limit = next((limit for limit in reversed(LIMITS) if limit in limits), None)
    worst = worst_of([made(ScenarioPoint, point) for point in points], by)
    return {"quantity": by, "limit_state": limit, "points": points, "worst": plain(worst)}


@st.composite
def sensitivity_of(draw, states, directions, limits):
    """Runs with two properties lower and higher."""
    runs = [
        {"state": state, "property": name, "factor": factor, "direction": direction, "a_g_g": draw(CAPACITY)}
        for state in states
        for name in ("friction", "unit_weight")
        for factor in (0.8, 1.25)
        for direction in directions
    ]
    return {"limit_state": max(limits, key=LIMITS.index), "runs": runs}
