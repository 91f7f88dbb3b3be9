"""Ties and strengthened states in a run: closed forms of one block, what is kept, and what the results say of ties."""

from __future__ import annotations

import numpy as np
import pytest

from assessment.analyses import paths as settlement
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.report.tables.mechanisms import balance
from assessment.results.hand_check import hand_checks
from assessment.results.schema import Results
from assessment.workflow.stages import run as run_stages
from mechanics import UnstableError
from mechanics.messages import message
from tests.support.block_project import ASSESSMENT, HAZARD, PUSHED, TURNED, block, write_block
from tests.support.tied_project import STRENGTHENED, TIE, overturning, strengthening, tie

BOTH = PUSHED.replace('["+x"]', '["+x", "-x"]').replace(
    "increment_m = 0.2", 'increment_m = 0.2\ncontrol = {"+x" = "right", "-x" = "left"}'
)
ARM = 0.59  # m, of the tie from the toe at x = 0.3
SLV = f'[assessment]\nlimit_states = ["SLV"]\nmodel = "none"\n[assessment.site]\nsoil = "B"\n{HAZARD}'


def results_of(folder, text: str) -> Results:
    project = load_project(write_block(folder, text))
    return run_stages(project, build_model(project), jobs=1).results


@pytest.fixture(scope="module")
def drawn(tmp_path_factory) -> Results:
    """The structure as drawn, and with the tie."""
    folder = tmp_path_factory.mktemp("strengthening") / "block"
    return results_of(
        folder, block() + BOTH + SLV + tie(states='["strengthened"]') + strengthening("original")
    )


def test_a_tie_that_yields_adds_its_work_to_that_of_the_weight(drawn):
    """α = (W b/2 + F a)/(W h/2), of the block about its toe: exact."""
    states = drawn.states
    for state, force in (("original", 0.0), ("strengthened", 5.0)):
        for direction, arm in (("+x", ARM), ("-x", 0.01)):
            rigid = states[state].pushover[direction].rigid
            assert rigid.alpha_0 == pytest.approx(overturning(force, arm), rel=1e-6)
            assert rigid.virtual_work_alpha == pytest.approx(rigid.alpha_0, rel=1e-6)
    [chain] = states["strengthened"].pushover["+x"].rigid.ties
    assert (chain.tie, chain.rest_kN, chain.yields) == ("chain", None, True)
    assert chain.peak_kN == pytest.approx(5.0, rel=1e-6) and chain.greatest_kN == pytest.approx(5.0, rel=1e-6)
    assert states["original"].pushover["+x"].rigid.ties is None


def test_the_hand_check_and_the_balance_count_the_tie(drawn):
    checks = {(each.state, each.direction): each for each in hand_checks(drawn)}
    assert checks["strengthened", "+x"].hand_alpha == pytest.approx(overturning(5.0, ARM), rel=1e-3)
    assert all(abs(each.hand_deviation) < 1e-3 for each in checks.values())
    tied = [row for row in balance(drawn).rows if row["state"] == "strengthened"]
    assert len(tied) == 2 and all(each["unbalanced"] < 1e-6 for each in tied)


def test_the_second_solver_agrees_with_ties(drawn):
    for direction in ("+x", "-x"):
        found = drawn.states["strengthened"].pushover[direction].rigid.second_solver
        assert abs(found.relative_difference) < 1e-6


def test_capacities_stand_beside_those_of_the_state_before(drawn):
    rows = {row.direction: row for row in drawn.strengthening}
    for direction, arm in (("+x", ARM), ("-x", 0.01)):
        row, before, after = rows[direction], drawn.states["original"], drawn.states["strengthened"]
        assert (row.state, row.of, row.limit_state) == ("strengthened", "original", "SLV")
        assert row.alpha_0_before == before.pushover[direction].rigid.alpha_0
        assert row.alpha_0 == after.pushover[direction].rigid.alpha_0
        assert row.d_0_before_m == before.pushover[direction].rigid.d_0_m
        a_g = [state.capacity[direction].SLV.a_g_g for state in (before, after)]
        assert [row.a_g_before_g, row.a_g_g] == a_g and row.gain == a_g[1] / a_g[0] - 1.0
        assert row.zeta_E == after.capacity[direction].SLV.zeta_E
        assert arm > 0.0


@pytest.fixture(scope="module")
def settled(tmp_path_factory) -> Results:
    return results_of(tmp_path_factory.mktemp("settled") / "block", block() + TURNED + PUSHED + STRENGTHENED)


def test_a_strengthened_state_starts_where_the_settled_one_came_to(settled):
    """The base turned by −0.02 rad, and the block with it: its arms are those of the turned block."""
    before, after = settled.states["base turned"], settled.states["strengthened"]
    assert after.configuration == before.configuration and after.pushdown == {}
    c, s = np.cos(0.02), np.sin(0.02)
    for state, force in ((before, 0.0), (after, 5.0)):
        weight = 45.36
        arm_x, arm_z = 0.3 * c - 2.1 * s, 0.3 * s + 2.1 * c
        alpha = (weight * arm_x + force * ARM) / (weight * arm_z)
        assert state.pushover["+x"].rigid.alpha_0 == pytest.approx(alpha, rel=1e-6)


def test_a_strengthening_whose_structure_has_no_rest_is_not_pushed_as_drawn(tmp_path, monkeypatch):
    def restless(*_):
        raise UnstableError(message("the auxiliary program of least acceleration was not solved"))

    monkeypatch.setattr(settlement, "settled", restless)
    text = block() + BOTH.replace('["rigid"]', '["elastic"]') + tie(states='["strengthened"]')
    project = load_project(write_block(tmp_path, text + strengthening("original")))
    found = run_stages(project, build_model(project), jobs=1)
    assert "+x" not in (found.results.states["strengthened"].pushover or {})
    assert not found.complete
    assert any("strengthened" in each and "not solved" in each for each in found.results.quality.warnings)


def test_a_tie_of_every_state_is_there_as_the_support_moves(tmp_path):
    found = results_of(tmp_path / "block", block() + TURNED + PUSHED + TIE)
    [path] = found.states["base turned"].pushdown.values()
    assert [each.tie for each in path.ties] == ["chain"] and found.model.ties[0].set_in == []
    assert found.states["original"].pushover["+x"].rigid.ties and found.strengthening is None


def test_changed_layers_change_the_joints_of_the_strengthened_state_only(tmp_path):
    """With a friction of 0.05 the block slides before it turns: α0 = friction."""
    changed = strengthening("original") + "[strengthening.layers.BASE]\nfriction = 0.05\n"
    pushed = PUSHED.replace("increment_m = 0.2", "increment_m = 1.0")
    found = results_of(tmp_path / "block", block() + pushed + changed)
    slides = found.states["strengthened"].pushover["+x"].rigid
    assert slides.alpha_0 == pytest.approx(0.05, rel=1e-5)
    assert found.states["original"].pushover["+x"].rigid.alpha_0 == pytest.approx(
        overturning(0.0, 0.0), rel=1e-6
    )


def test_a_chosen_mechanism_has_the_work_of_the_tie(tmp_path):
    """In the state of the tie, about the toe; a tie that never yields holds it."""
    mechanism = '[[mechanism]]\nname = "over"\nabout_m = [0.3, 0.0]\nblocks = [1]\nstate = "strengthened"\n'
    text = block() + PUSHED + ASSESSMENT + mechanism + strengthening("original")
    found = results_of(tmp_path / "yields", text + tie(states='["strengthened"]'))
    [given] = found.mechanisms
    assert given.alpha_0 == pytest.approx(overturning(5.0, ARM), rel=1e-9)
    # the curve of the finite motion begins with the same work, the tie's included
    assert (
        given.a_0_star_g == pytest.approx(given.alpha_0 / given.e_star / 1.35, rel=1e-9) and given.d_0_m > 0.0
    )
    held = results_of(tmp_path / "held", text + tie(states='["strengthened"]', yield_force_kN=""))
    [given] = held.mechanisms
    assert given.refused.startswith('tie "chain" would have to lengthen; give it a yield_force_kN')
