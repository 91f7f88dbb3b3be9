"""Ranges of static paths: which states are followed again, with what, and what is used of their members."""

from dataclasses import replace

import numpy as np
import pytest

from assessment.analyses import governing as ensemble
from assessment.analyses.capacity import Assessed
from assessment.analyses.found import Found
from assessment.analyses.governing import (
    ENSEMBLE,
    EnsembleTolerances,
    governed,
    in_increments,
    members,
    shaken_corners,
)
from assessment.analyses.lateral import Pushed
from assessment.analyses.paths import Settled, turns_on_rounding
from assessment.analyses.states import Request, StateResult, analyse_states
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.results.schema import StateResults
from assessment.results.schema.checks import Capacity
from assessment.results.schema.static import ElasticPush, PushdownPath, Pushovers, RigidPush, Run
from assessment.runtime.tasks import Workers
from mechanics import Assembly, Block, Material, pushover
from mechanics.messages import message
from tests.support.block_project import TURNED, block, write_block
from tests.support.structures import block_on_base, rectangle, running_bond
from tests.support.typed import made

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


def test_where_a_member_differs_all_are_run(request_of, monkeypatch):
    monkeypatch.setattr(ensemble, "ENSEMBLE", EnsembleTolerances(agree=0.0))
    with Workers() as workers:
        found = analyse_states([request_of], workers)
        found[0].scatters = True
        (others,) = members([request_of], found, workers).values()
        assert len(others) == request_of.project.scatter - 1
        alone = replace(request_of, project=request_of.project.model_copy(update={"scatter": 1}))
        assert members([alone], found, workers) == {}
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
    settled = [request.movement[1][-1].increment_rad / asked.settlement.increment_rad for request in given]
    pushed = [request.project.pushover.increment_m / project.pushover.increment_m for request in given]
    count = asked.settlement.increments
    assert settled == pytest.approx([count / max(1, round(count / factor)) for factor in factors])
    assert pushed == pytest.approx(factors)


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


def test_a_corner_of_a_straight_face_parts_no_joint_of_a_member():
    """Results have the joints of the drawing, whichever member they are of."""
    stone, base = Material(20.0, friction=0.6), rectangle(-1.0, -1.0, 3.0, 0.0)
    left = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [1.0, 1.0], [0.0, 1.0]]
    shapes = [left, rectangle(1.0, 0.0, 2.0, 1.0)]
    model = Assembly([Block(base, 1.0, stone, support="base"), *(Block(each, 1.0, stone) for each in shapes)])
    drawn = [model.joints.a.tolist(), model.joints.b.tolist()]
    for seed in range(4):
        shaken = shaken_corners(model, seed)
        assert [shaken.joints.a.tolist(), shaken.joints.b.tolist()] == drawn


@pytest.mark.parametrize(("friction", "slides"), [(0.1, True), (0.7, False)])
def test_a_joint_that_slides_is_what_a_path_turns_on(friction, slides):
    model = block_on_base(friction=friction)
    assert turns_on_rounding(pushover(model, (0.0, 1.0), increment=0.02, until=0.9)) is slides


def curve(alpha: float, d: float | None) -> Pushovers:
    points = {"displacement_m": [0.0, d or 1.0], "multiplier": [alpha, 0.0]}
    return Pushovers(control="C", rigid=made(RigidPush, {"alpha_0": alpha, "d_0_m": d, "curve": points}))


def checked(**checks: float | None):
    """An assessment of runs: of each d_0 at each limit state a multiple of it."""

    def assess(pushovers: dict) -> dict:
        ((direction, each),) = pushovers.items()
        d = each.rigid.d_0_m
        numbers = {
            name: {"a_g_g": factor * d, "zeta_E": 2.0 * factor * d, "verified": 2.0 * factor * d >= 1.0}
            for name, factor in checks.items()
        }
        return {direction: Found(Assessed(each, made(Capacity, {"alpha_0": each.rigid.alpha_0, **numbers})))}

    return assess


def runs_of(*curves: Pushovers, ultimate: tuple[float, ...] = ()) -> list[list[StateResult]]:
    """Several runs of a state, the first its own."""
    runs = []
    for k, each in enumerate(curves, 1):
        pushed = Pushed(each.replace(run=Run(increment_m=0.01, member=k)))
        run = StateResult("s", "rigid", pushed={"+x": Found(pushed, warnings=[message("run {k}", k=k)])})
        if k <= len(ultimate):
            run.moved = Found(Settled(made(PushdownPath, {"ultimate_movement_m": ultimate[k - 1]}), None))
        runs.append([run])
    return runs


def governing(runs: list[list[StateResult]], assess=lambda _: {}) -> StateResults:
    return governed("s", made(StateResults), runs, assess)[0]


def widened(low: float, high: float) -> list[float]:
    """The range of runs between two values: 0.8 of their span wider on either side."""
    return [low - 0.8 * (high - low), high + 0.8 * (high - low)]


def test_a_sixth_run_lies_in_the_range_of_five_with_95_per_cent():
    """In their span it lies with two in three: what one user found, another one did not."""
    random = np.random.default_rng(1)
    runs = random.normal(size=(20_000, 6))
    low, high = runs[:, :5].min(axis=1), runs[:, :5].max(axis=1)
    spans = ENSEMBLE.wider * (high - low)
    within = [(runs[:, 5] > low - more) & (runs[:, 5] < high + more) for more in (0.0, spans)]
    assert [each.mean() for each in within] == pytest.approx([2.0 / 3.0, 0.95], abs=0.01)


def test_a_range_is_open_where_a_member_slides_on_without_end():
    runs = runs_of(curve(0.10, 0.5), curve(0.12, None), curve(0.11, 0.4))
    pushed = governing(runs).pushover["+x"]
    assert (pushed.rigid.d_0_m, pushed.run.member) == (0.5, 1)
    assert pushed.rigid.d_0_m_range == [pytest.approx(0.4 - 0.8 * 0.1), None]
    assert pushed.rigid.alpha_0_range == pytest.approx(widened(0.10, 0.12))


def test_without_checks_the_least_alpha_governs_and_of_those_that_agree_in_it_the_least_d_0():
    runs = runs_of(curve(0.10002, 0.4), curve(0.10, 0.5), curve(0.10001, None), curve(0.2, 0.1))
    pushed = governing(runs).pushover["+x"]
    assert (pushed.run.member, pushed.rigid.alpha_0, pushed.rigid.d_0_m) == (1, 0.10002, 0.4)


def test_a_curve_that_is_cut_short_does_not_govern():
    """The settled triumphal arch was told α0 0.039, of a curve whose blocks did not come to rest after 0.6 mm."""
    runs = runs_of(curve(0.05, None), curve(0.11, 0.5), curve(0.10, 0.4))
    pushed = governing(runs).pushover["+x"]
    assert (pushed.run.member, pushed.rigid.alpha_0) == (3, 0.10) and pushed.rigid.alpha_0_range[0] < 0.05
    assert governing(runs_of(curve(0.05, None), curve(0.1, None))).pushover["+x"].rigid.alpha_0 == 0.05


def test_everything_told_of_a_direction_is_of_the_run_with_the_least_index():
    """The least of each quantity by itself would be figures of different runs in one table."""
    runs = runs_of(curve(0.10, 0.5), curve(0.12, 0.4), curve(0.11, 0.6), ultimate=(0.3, 0.2, 0.25))
    found = governing(runs, checked(SLC=1.0, SLV=0.8, SLD=0.5))
    pushed, capacity = found.pushover["+x"], found.capacity["+x"]
    assert (pushed.run.member, pushed.rigid.alpha_0, pushed.rigid.d_0_m) == (2, 0.12, 0.4)
    assert pushed.rigid.curve == curve(0.12, 0.4).rigid.curve and len(pushed.rigid.members) == 2
    assert pushed.rigid.alpha_0_range == pytest.approx(widened(0.10, 0.12))
    assert pushed.rigid.d_0_m_range == pytest.approx(widened(0.4, 0.6))
    assert capacity.alpha_0 == 0.12
    assert (capacity.SLC.a_g_g, *capacity.SLC.a_g_g_range) == pytest.approx((0.4, *widened(0.4, 0.6)))
    assert (capacity.SLV.zeta_E, *capacity.SLV.zeta_E_range) == pytest.approx((0.64, *widened(0.64, 0.96)))
    assert capacity.SLD.a_g_g_range == pytest.approx(widened(0.2, 0.3))
    path = found.pushdown["rigid"]
    assert path.ultimate_movement_m == 0.2 and path.ultimate_movement_m_range == pytest.approx(
        widened(0.2, 0.3)
    )


def test_a_check_is_verified_only_where_its_whole_range_is():
    """Of five runs of a wall four had no capacity; the fifth was told as verified."""
    runs = runs_of(curve(0.1, 0.8), curve(0.1, 0.9), curve(0.1, 1.0))
    verified = governing(runs, checked(SLC=0.65, SLV=2.0, SLD=0.6)).capacity["+x"]
    assert verified.SLV.zeta_E_range[0] > 1.0 and verified.SLV.verified
    assert verified.SLC.zeta_E > 1.0 > verified.SLC.zeta_E_range[0] and verified.SLC.verified is None
    assert verified.SLD.zeta_E < 1.0 and verified.SLD.verified is False


def test_a_ratio_that_is_no_index_governs_only_where_no_index_was_checked():
    """At SLD the first run is the least, at SLV the second: ζ_E is the index at SLV and SLC."""

    def assess(pushovers: dict) -> dict:
        ((direction, each),) = pushovers.items()
        own = each.run.member
        checks = {"SLD": {"zeta_E": 0.1 * own}, "SLV": {"zeta_E": 0.9 - 0.1 * own}}
        return {direction: Found(Assessed(each, made(Capacity, checks)))}

    runs = runs_of(curve(0.1, 0.5), curve(0.1, 0.5))
    assert governing(runs, assess).pushover["+x"].run.member == 2


def test_a_run_without_capacity_does_not_govern():
    def assess(pushovers: dict) -> dict:
        return {} if pushovers["+x"].run.member == 2 else checked(SLV=1.0)(pushovers)

    runs = runs_of(curve(0.1, 0.5), curve(0.1, 0.4), curve(0.1, 0.6))
    found = governing(runs, assess)
    assert found.pushover["+x"].run.member == 1
    low, high = found.capacity["+x"].SLV.a_g_g_range
    assert (low, high) == (0.0, pytest.approx(widened(0.5, 0.6)[1])), "another choice may find no capacity"


def test_a_run_without_a_rigid_curve_does_not_govern_by_its_elastic_one():
    """A settled arch of which one member found no rigid curve was told none at all: α_u was compared with α_0."""
    elastic = made(ElasticPush, {"alpha_u": 0.05})
    runs = runs_of(curve(0.1, 0.5).replace(elastic=elastic), Pushovers(control="C", elastic=elastic))
    pushed = governing(runs).pushover["+x"]
    assert pushed.run.member == 1 and pushed.rigid.alpha_0_range == [0.0, 0.1]
    alone = governing(runs_of(*(Pushovers(control="C", elastic=elastic) for _ in runs))).pushover["+x"]
    assert alone.rigid is None and alone.elastic.alpha_u == 0.05
