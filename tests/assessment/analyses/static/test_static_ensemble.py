"""Ranges of static paths: which states are followed again, with what, and what is used of their members."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assessment.analyses.checks.capacity import Assessed
from assessment.analyses.checks.ranges import Paths, with_ranges
from assessment.analyses.static import ensemble
from assessment.analyses.static.ensemble import (
    ENSEMBLE,
    EnsembleTolerances,
    in_increments,
    members,
    shaken_corners,
)
from assessment.analyses.static.paths import turns_on_rounding
from assessment.analyses.static.states import Request, StateResult, analyse_states
from assessment.project.project import load_project
from assessment.project.structure.model import build_model
from assessment.results.schema import State
from assessment.results.schema.checks import Capacity
from assessment.results.schema.model import Line
from assessment.results.schema.static import PushdownPath, Pushovers, RigidPush
from assessment.runtime.tasks import Workers
from mechanics import pushover
from tests.support.block_project import TURNED, block, read_results, run, write_block
from tests.support.structures import block_on_base, running_bond
from tests.support.typed import filled, made

PUSHOVER = '[pushover]\ndirections = ["+x"]\nincrement_m = 0.02\n'


@pytest.fixture
def request_of(tmp_path):
    project = load_project(write_block(tmp_path, block() + PUSHOVER))
    return Request(project, build_model(project).states["original"], None, "rigid")


def test_a_path_that_only_turns_is_followed_once(request_of):
    with Workers() as workers:
        found = analyse_states([request_of], workers)
        computed = workers.computed
        assert not found[0].scatters and members([request_of], found, workers) == {}
        assert workers.computed == computed


def test_one_member_is_enough_where_it_finds_the_same(request_of):
    with Workers() as workers:
        found = analyse_states([request_of], workers)
        found[0].scatters = True
        computed = workers.computed
        assert members([request_of], found, workers) == {}
        assert workers.computed == computed + 1


def test_where_a_member_differs_all_are_run(request_of):
    strict = EnsembleTolerances(agree=0.0)
    with Workers() as workers:
        found = analyse_states([request_of], workers)
        found[0].scatters = True
        (others,) = members([request_of], found, workers, strict).values()
        assert len(others) == request_of.project.scatter - 1
        alone = replace(request_of, project=request_of.project.model_copy(update={"scatter": 1}))
        assert members([alone], found, workers, strict) == {}
    alphas = {member[0].pushover["+x"].rigid.alpha_0 for member in others}
    assert len(alphas) == len(others), "each member has corners of its own"
    assert max(alphas) - min(alphas) < 1e-5


def test_members_settle_and_push_in_increments_of_their_own(tmp_path, monkeypatch):
    """They pushed in increments of their own, and settled in those of the project."""
    project = load_project(write_block(tmp_path, block() + PUSHOVER + TURNED))
    name = project.settlements[0].name
    asked = Request(project, build_model(project).states[name], project.settlement_of(name), "rigid")
    given = []

    def kept(requests, workers, study):
        given.extend(requests)
        return [StateResult(request.state, request.behaviour) for request in requests]

    monkeypatch.setattr(ensemble, "analyse_states", kept)
    found = StateResult(name, "rigid", scatters=True)
    monkeypatch.setattr(ensemble, "apart", lambda *_: True)
    members([asked], [found], Workers())
    factors = np.geomspace(*ENSEMBLE.increments, project.scatter - 1)
    settled = [
        request.settling.settlement.increment_rad / asked.settlement.increment_rad for request in given
    ]
    pushed = [request.project.pushover.increment_m / project.pushover.increment_m for request in given]
    assert settled == pytest.approx(factors) and pushed == pytest.approx(factors)


def test_members_differ_by_their_increments_and_by_the_last_digits_of_corners(request_of):
    assert in_increments(request_of.project, 0.7).pushover.increment_m == pytest.approx(0.014)
    drawn = running_bond(3, 4)
    moved = shaken_corners(drawn, 1)
    assert len(moved.joints.a) == len(drawn.joints.a)
    for one, other in zip(drawn.blocks, moved.blocks, strict=True):
        far = abs(one.polygon - other.polygon).max()
        assert far == 0.0 if one.support else 0.0 < far <= ENSEMBLE.noise * np.ptp(one.polygon, axis=0).max()
    again = shaken_corners(drawn, 1)
    assert all(np.array_equal(a.polygon, b.polygon) for a, b in zip(moved.blocks, again.blocks, strict=True))


@pytest.mark.parametrize(("friction", "slides"), [(0.1, True), (0.7, False)])
def test_a_joint_that_slides_is_what_a_path_turns_on(friction, slides):
    model = block_on_base(friction=friction)
    assert turns_on_rounding(model, pushover(model, (0.0, 1.0), increment=0.02, until=0.9)) is slides


def curve(alpha: float, d: float | None) -> Pushovers:
    points = {"displacement_m": [0.0, d or 1.0], "multiplier": [alpha, 0.0]}
    return Pushovers(control="C", rigid=made(RigidPush, {"alpha_0": alpha, "d_0_m": d, "curve": points}))


def moved(ultimate: float) -> dict:
    return {"rigid": made(PushdownPath, {"ultimate_movement_m": ultimate})}


def lines(symbol: str) -> list[dict]:
    """A calculation of one line, known by its symbol."""
    return [filled(Line, {"symbol": symbol})]


def symbols(trace: list[Line]) -> list[str]:
    return [line.symbol for line in trace]


def test_a_range_is_open_where_a_member_slides_on_without_end():
    state = made(State).replace(pushover={"+x": curve(0.10, 0.5)})
    members = [Paths({}, {"+x": curve(0.12, None)}), Paths({}, {"+x": curve(0.11, 0.4)})]
    rigid = with_ranges(state, members, lambda _: {}).pushover["+x"].rigid
    assert (rigid.d_0_m, rigid.d_0_m_range) == (0.4, [0.4, None])
    assert rigid.alpha_0_range == [0.10, 0.12]


def test_the_least_member_is_used_and_its_range_told():
    """In a direction the curve is that of the least a_g at SLC; every other number is the least of all."""

    def assess(pushovers: dict) -> dict:
        ((direction, each),) = pushovers.items()
        alpha, d = each.rigid.alpha_0, each.rigid.d_0_m
        checks = {"SLC": {"a_g_g": d, "zeta_E": 2.0 * d, "trace": lines("c")}}
        checks["SLV"] = {"a_g_g": alpha, "zeta_E": 3.0 * alpha, "trace": lines("v")}
        return {direction: Assessed(each, made(Capacity, {"trace": lines(f"α0 = {alpha}"), **checks}))}

    own = made(State).replace(pushdown=moved(0.3), pushover={"+x": curve(0.10, 0.5)})
    others = [
        Paths(moved(0.2), {"+x": curve(0.12, 0.4)}),
        Paths({}, {"+x": curve(0.11, 0.6)}),
        Paths({}, {}),
    ]
    state = with_ranges(own, others, assess)
    rigid, capacity = state.pushover["+x"].rigid, state.capacity["+x"]
    assert rigid.curve == curve(0.12, 0.4).rigid.curve and len(rigid.members) == 2
    assert (rigid.alpha_0, rigid.alpha_0_range) == (0.10, [0.10, 0.12])
    assert (rigid.d_0_m, rigid.d_0_m_range) == (0.4, [0.4, 0.6])
    path = state.pushdown["rigid"]
    assert (path.ultimate_movement_m, path.ultimate_movement_m_range) == (0.2, [0.2, 0.3])
    assert (capacity.SLC.a_g_g, capacity.SLC.a_g_g_range) == (0.4, [0.4, 0.6])
    assert capacity.SLV.zeta_E == pytest.approx(0.3)
    assert capacity.SLV.zeta_E_range == pytest.approx([0.3, 0.36])
    assert symbols(capacity.trace) == ["α0 = 0.12"]
    assert symbols(capacity.SLC.trace) == ["c"] and symbols(capacity.SLV.trace) == ["α0 = 0.1", "v"]


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize("sliding", ["coulomb", "associative"])
def test_every_curve_says_how_joints_slide(tmp_path, sliding):
    text = block().replace("friction = 0.7", "friction = 0.1") + PUSHOVER
    project = write_block(tmp_path, text + f'[contacts]\nsliding = "{sliding}"\n')
    assert run(project) == 0
    results = read_results(project / "output")
    rigid = results["states"]["original"]["pushover"]["+x"]["rigid"]
    assert rigid["sliding"] == sliding and rigid["alpha_0"] == pytest.approx(0.1, rel=1e-5)
