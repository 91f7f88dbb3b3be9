"""Halved increments and the error they let expect: against closed forms, finer references, and by themselves."""

import math
from collections.abc import Collection

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from assessment.analyses.demand import Demands
from assessment.analyses.found import Found, refined
from assessment.analyses.lateral import Pushed
from assessment.analyses.states import Request, StateResult, analyse_states
from assessment.project.catalogue.new_project import new_project
from assessment.project.model import build_model
from assessment.project.project import Project, load_project
from assessment.project.schema import PushoverTable, SettlementTable
from assessment.results.schema.static import Pushovers, RigidPush
from assessment.runtime.tasks import Workers
from assessment.studies.convergence import converge, estimated_error
from tests.assessment.studies.test_studies import ASSESSMENT, BLOCK, HEIGHT, PUSHOVER, SLENDERNESS, TURNS
from tests.support.block_project import results_of, write_block
from tests.support.typed import made

SOLVER = 1e-6  # relative: what programs leave, whatever the increments


@pytest.fixture
def block(tmp_path):
    """Write a project of one block, its first lines and then its tables; return it loaded."""

    def written(accuracy: str, *tables: str):
        text = BLOCK.replace("\n", f"\naccuracy = {accuracy}\n", 1) if accuracy else BLOCK
        return load_project(write_block(tmp_path, text + "".join(tables)))

    return written


# The estimate


@given(
    exact=st.floats(-10.0, 10.0), factor=st.floats(1e-3, 10.0), sign=st.sampled_from([-1.0, 1.0]),
    order=st.floats(0.35, 4.0), levels=st.integers(3, 6),
)  # fmt: skip
def test_the_estimate_bounds_the_error_of_any_order_that_shows(exact, factor, sign, order, levels):
    """v_k = v + C 2^(−pk): the safety up to first order, more above."""
    values = [exact + sign * factor * 2.0 ** (-order * k) for k in range(levels)]
    error, estimate = abs(values[-1] - exact), estimated_error(values)
    assert estimate >= error * (1.0 - 1e-6) - 1e-12
    if order <= 1.0:
        assert estimate == pytest.approx(1.25 * error, rel=1e-6, abs=1e-12)


def test_the_estimate_without_an_order():
    assert estimated_error([1.0]) is None
    assert estimated_error([1.0, None]) is None
    assert estimated_error([None, 1.0]) is None
    assert estimated_error([None, 1.0, 1.25]) == 1.25 * 0.25
    assert estimated_error([1.0, 1.5]) == 1.25 * 0.5  # as at first order
    assert estimated_error([1.0, 1.5, 1.0]) == 1.25 * 4 * 0.5  # scatter
    assert estimated_error([1.0, 1.5, 1.25]) == 1.25 * 0.25  # alternating, and shrinking
    assert estimated_error([1.0, 1.5, 2.0]) == 1.25 * 4 * 0.5  # drifting on
    assert estimated_error([1.0, 2.0, 2.0]) == 0.0


# The increments


@given(
    x=st.just(0.0) | st.floats(1e-6, 0.1),
    rotation=st.just(0.0) | st.floats(-0.1, -1e-6),
    increment=st.floats(1e-4, 0.2),
    halvings=st.integers(0, 4),
)
def test_increments_are_doubled_exactly(x, rotation, increment, halvings):
    """Also where the movement is no multiple of the increment, or shorter than it."""
    assume(x or rotation)
    settlement = SettlementTable(
        name="s", support="b", displacement_m=(x, 0.0), rotation_rad=rotation, increment_m=increment
    )
    project = project_of_one_settlement(settlement)
    finer = refined(project, halvings)
    assert finer.settlements[0].increments == 2**halvings * settlement.increments
    assert finer.pushover.increment_m == project.pushover.increment_m / 2**halvings


def project_of_one_settlement(settlement: SettlementTable) -> Project:
    """A project that need not be on disk."""
    return Project.model_construct(settlements=(settlement,), pushover=PushoverTable(increment_m=0.01))


# States


def test_fast_is_what_the_increments_give_and_says_so(block, tmp_path):
    """The first level of any accuracy has the same numbers."""
    fast = results_of(block('"fast"', TURNS, PUSHOVER, ASSESSMENT))
    assert fast["convergence"] == {"tolerance": None, "rows": []}
    rows = results_of(block('"standard"', TURNS, PUSHOVER, ASSESSMENT))["convergence"]["rows"]
    assert len(rows) == 6
    for row in rows:
        state = fast["states"][row["state"]]
        assert row["levels"]["d_0_m"][0] == state["pushover"][row["direction"]]["rigid"]["d_0_m"]
        assert row["levels"]["a_g_g"][0] == state["capacity"][row["direction"]]["SLC"]["a_g_g"]


def test_the_error_of_a_block_is_bounded_by_the_estimate(block):
    """Leaning by θ from the start: α0 = tan(arctan(B/H) − θ), d_0 = H (sin arctan(B/H) − sin θ) above the hinge."""
    results = results_of(block("0.001", TURNS, PUSHOVER))
    rows = {(row["state"], row["direction"]): row for row in results["convergence"]["rows"]}
    turned = {"original": 0.0, "turned": -0.04, "turned back": 0.02}
    for (state, way), row in rows.items():
        lean = -turned[state] if way == "+x" else turned[state]
        rigid = results["states"][state]["pushover"][way]["rigid"]
        exact = {
            "alpha_0": math.tan(SLENDERNESS - lean),
            "d_0_m": HEIGHT * (math.sin(SLENDERNESS) - math.sin(lean)),
        }
        for key, error in (("alpha_0", row["alpha_0_error"]), ("d_0_m", row["d_0_error_m"])):
            assert row["levels"][key][-1] == rigid[key]
            assert abs(rigid[key] - exact[key]) <= error + SOLVER * exact[key], (state, way, key)
        assert row["met"] and row["relative_error"] <= 0.001


def written_arch(folder, voussoirs: int) -> Project:
    """A semicircular arch that is pushed over, its joints rigid; nothing else."""
    new_project(folder, "arch", {"voussoirs": voussoirs})
    project = load_project(folder)
    assert project.pushover is not None
    rigid = project.pushover.model_copy(update={"contacts": ("rigid",), "directions": ("+x",)})
    law = project.contacts.model_copy(update={"sliding": "associative"})
    return project.model_copy(
        update={"pushover": rigid, "contacts": law, "settlements": (), "assessment": None}
    )


@pytest.fixture(scope="module")
def arch(tmp_path_factory):
    """Of 21 voussoirs: a part moves by itself at 25.7 mm of the 46 mm of its d_0."""
    return written_arch(tmp_path_factory.mktemp("convergence") / "arch", 21)


@pytest.fixture(scope="module")
def fine(arch):
    """The rigid push of the arch by an eighth of its increment."""
    request = Request(refined(arch, 3), build_model(arch).states["original"], None, "rigid")
    with Workers(1) as workers:
        [stage] = analyse_states([request], workers)
    return stage.pushover["+x"].rigid


def test_the_error_of_an_arch_is_within_the_estimate_and_that_within_the_tolerance(arch, fine):
    found = results_of(arch.model_copy(update={"accuracy": 0.01}))
    [right] = found["convergence"]["rows"]
    values = right["levels"]["d_0_m"]
    assert max(values) < 1.02 * min(values)  # small increments reach across that part too
    assert abs(values[-1] - fine.d_0_m) <= right["d_0_error_m"] <= 0.01 * values[-1]
    assert found["states"]["original"]["pushover"]["+x"]["rigid"]["d_0_m"] == values[-1]
    assert right["alpha_0_error"] == 0.0  # the onset knows no increment
    assert right["halvings"] >= 1


def test_where_the_tolerance_is_not_met_a_warning_says_so(tmp_path):
    arch = written_arch(tmp_path / "arch", 9)
    found = results_of(arch.model_copy(update={"accuracy": 1e-7}))
    rows = found["convergence"]["rows"]
    assert [row["halvings"] for row in rows] == [4]
    assert not any(row["met"] for row in rows)
    said = [text for text in found["quality"]["warnings"] if "discretisation" in text]
    assert [text.partition(":")[0] for text in said] == ["original, +x"]
    assert "d_0_m is" in said[0] and "1/16" in said[0] and "alpha_0" not in said[0]


def _stage(state: str, alpha_0: float, *failures: str) -> StateResult:
    pushed = Pushovers(control="C", rigid=made(RigidPush, {"alpha_0": alpha_0, "d_0_m": None}))
    found = Found(Pushed(pushed), failures=list(failures), seconds=1.0)
    return StateResult(state, "rigid", pushed={"+x": found})


def _converged(arch, *levels: dict[str, StateResult]):
    """Converge states that are made up, one dictionary by name for each level."""
    asked: list[tuple[float, list[str]]] = []

    def analyse(project: Project, states: Collection[str]) -> list[StateResult]:
        asked.append((project.pushover.increment_m, list(states)))
        return [levels[len(asked) - 1][name] for name in states if name in levels[len(asked) - 1]]

    settled = SettlementTable(name="settled", support="right", displacement_m=(0.01, 0.0))
    push = arch.pushover.model_copy(update={"increment_m": 1.0})
    project = arch.model_copy(update={"settlements": (settled,), "pushover": push, "accuracy": "standard"})
    return converge(project, build_model(project).states, Demands(), analyse), asked


def test_only_states_that_need_it_are_analysed_again(arch):
    found, asked = _converged(
        arch,
        {"original": _stage("original", 0.2), "settled": _stage("settled", 0.2)},
        {"original": _stage("original", 0.2), "settled": _stage("settled", 0.15)},
        {"settled": _stage("settled", 0.125)},
    )
    assert asked == [
        (1.0, ["original", "settled"]), (0.5, ["original", "settled"]), (0.25, ["settled"])
    ]  # fmt: skip
    assert found.halvings == {"original": 1, "settled": 2}
    assert [stage.pushover["+x"].rigid.alpha_0 for stage in found.stages] == [0.2, 0.125]
    assert [stage.seconds["pushover"] for stage in found.stages] == [2.0, 3.0]
    original, settled = found.rows
    assert original.met and not settled.met
    assert settled.alpha_0_error == pytest.approx(1.25 * 0.025)  # first order: 0.1 is where it goes
    (warning,) = found.warnings
    assert "settled, +x" in warning and "alpha_0 is 25 %" in warning and "1/4" in warning


# The key
