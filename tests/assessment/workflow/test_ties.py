"""Ties and strengthened states in a run: closed forms of one block, pushed and shaken."""

from dataclasses import replace

import numpy as np
import pytest

from assessment.analyses import paths as settlement
from assessment.project.project import load_project
from assessment.report.chapters.judgement import told
from assessment.report.chapters.synthesis import lead
from assessment.report.language import Words
from assessment.report.tables import dynamic
from assessment.report.tables.mechanisms import balance
from assessment.results.frames import tie_ends
from assessment.results.hand_check import hand_checks
from assessment.results.schema import Results
from mechanics import Material, Tie, UnstableError, time_history
from mechanics.messages import message
from tests.support.block_project import ASSESSMENT, HAZARD, PUSHED, TURNED, block, outcome_of, write_block
from tests.support.structures import built
from tests.support.tied_project import (
    ASSOCIATIVE,
    HEIGHT,
    STRENGTHENED,
    TIE,
    WEIGHT,
    WIDTH,
    overturning,
    strengthening,
    tie,
)

BOTH = PUSHED.replace('["+x"]', '["+x", "-x"]').replace(
    "increment_m = 0.2", 'increment_m = 0.2\ncontrol = {"+x" = "right", "-x" = "left"}'
)
ARM = 0.59  # m, of the tie from the toe at x = 0.3
SLV = f'[assessment]\nlimit_states = ["SLV"]\nmodel = "none"\n[assessment.site]\nsoil = "B"\n{HAZARD}'


SLOW = 0.02 * np.arange(301)
HALF_SINE = np.sin(np.pi * SLOW / 6.0)  # g; the block that stands moves as in a static test
HISTORY = '[[history]]\nrecord = "push.csv"\nscale = -0.3\ncontacts = "rigid"\n'


def results_of(folder, text: str, acceleration=None) -> Results:
    """The results of the block with these tables, and the record push.csv where there is one."""
    write_block(folder, text + ASSOCIATIVE)
    if acceleration is not None:
        np.savetxt(folder / "push.csv", np.column_stack([SLOW, acceleration]), delimiter=",", fmt="%.8f")
    project = load_project(folder)
    return outcome_of(project).results


def shaken(folder, text: str) -> Results:
    return results_of(folder, "scatter = 1\n" + text, HALF_SINE)


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


def test_the_capacity_ends_where_a_tie_breaks(tmp_path):
    """Turned by θ about the toe, the tie ends at (4 sin θ − a cos θ, 4 cos θ + a sin θ) from it, a = 0.59 m."""
    text = block() + BOTH + SLV + tie(ultimate_elongation="0.005")
    found = results_of(tmp_path / "block", text.replace("increment_m = 0.2", "increment_m = 0.02"))
    rigid, capacity = (getattr(found.states["original"], of)["+x"] for of in ("pushover", "capacity"))
    loss = rigid.rigid.local_loss
    angle = np.linspace(0.0, 0.1, 10001)
    end = np.stack([4.0 * np.sin(angle) - ARM * np.cos(angle), 4.0 * np.cos(angle) + ARM * np.sin(angle)])
    length = np.hypot(*(end - np.array([[-ARM], [-0.1]])))
    breaks = np.interp(4.1 * 1.005, length, angle)
    assert loss.displacement_m == pytest.approx(HEIGHT * np.sin(breaks), rel=1e-3)
    assert (loss.tie, loss.joint, loss.longest_m) == ("chain", None, pytest.approx(4.1 * 0.005))
    assert any(
        'the tie "chain", which has yielded by 0.0205 m, breaks' in str(text)
        for text in found.quality.warnings
    )
    limit = np.interp(loss.displacement_m, rigid.rigid.curve.displacement_m, rigid.rigid.d_star_m)
    assert capacity.SLV.d_star_m == pytest.approx(limit) and limit < 0.4 * capacity.d_0_star_m


def test_a_motion_in_which_a_tie_breaks_has_collapsed():
    """One pulse of 0.9 g, from which the block comes back if its tie yields by 13 mm of 1.9 m and holds."""
    time, stone = 0.005 * np.arange(401), Material(18.0, 0.7)
    pulse = -0.9 * np.sin(2.0 * np.pi * time / 0.4) * (time < 0.4)
    for most, falls in ((0.01, False), (0.002, True)):
        chain = Tie("chain", (-0.29, -0.1), (-0.29, 1.8), yield_force=8.0, ultimate_elongation=most)
        model = built(stone, (-0.3, 0.0, 0.3, 2.0), base=(-1.0, -0.5, 1.0, 0.0)).tied([chain])
        motion = time_history(model, pulse, 0.005)
        assert motion.collapsed is falls and ("the tie chain breaks" in motion.collapse_reason) is falls
    longest = np.hypot(*(model.tie_ends(motion.final)[0][1] - model.tie_ends(motion.final)[0][0])) - 1.9
    assert chain.longest < longest < 1.6 * chain.longest  # where it breaks, not at the end of the pulse
    still = time_history(model.tied([replace(chain, length=1.8)]), 0.0 * pulse, 0.005)
    assert still.collapsed and still.time_of_collapse == 0.005  # broken before


def test_the_hand_check_and_the_balance_count_the_tie(drawn):
    checks = {(each.state, each.direction): each for each in hand_checks(drawn)}
    assert checks["strengthened", "+x"].hand_alpha == pytest.approx(overturning(5.0, ARM), rel=1e-3)
    assert all(abs(each.hand_deviation) < 1e-3 for each in checks.values())
    tied = [row for row in balance(drawn).rows if row["state"] == "strengthened"]
    assert len(tied) == 2 and all(each["unbalanced"] < 1e-6 for each in tied)


def test_ends_of_ties_move_with_their_blocks_so_many_times_as_far(drawn):
    turned = drawn.states["strengthened"].pushover["+x"].rigid.mechanism.displacements
    still, once, twice = (tie_ends(drawn, "strengthened", turned, times) for times in (0.0, 1.0, 2.0))
    assert still.tolist() == [[[*tie.start_m], [*tie.end_m]] for tie in drawn.model.ties]
    assert twice - still == pytest.approx(2.0 * (once - still)) and abs(once - still).max() > 0.1


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
    found = outcome_of(project)
    assert "+x" not in (found.results.states["strengthened"].pushover or {})
    assert not found.complete
    assert any("strengthened" in each and "not solved" in each for each in found.results.quality.warnings)


def test_a_tie_of_every_state_is_there_as_the_support_moves(tmp_path):
    found = results_of(tmp_path / "block", block() + TURNED + PUSHED + TIE)
    [path] = found.states["base turned"].pushdown.values()
    assert [each.tie for each in path.ties] == ["chain"] and found.model.ties[0].set_in == []
    assert found.states["original"].pushover["+x"].rigid.ties


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
    short = results_of(
        tmp_path / "breaks", text + tie(states='["strengthened"]', ultimate_elongation="0.005")
    )
    [given] = short.mechanisms
    pushed, limit = short.states["strengthened"].pushover["+x"].rigid, given.SLV.d_star_m
    assert given.SLV.governing == "local limit"
    assert limit == pytest.approx(
        np.interp(pushed.local_loss.displacement_m, pushed.curve.displacement_m, pushed.d_star_m), rel=0.03
    )
    held = results_of(tmp_path / "held", text + tie(states='["strengthened"]', yield_force_kN=""))
    [given] = held.mechanisms
    assert given.refused.startswith('tie "chain" would have to lengthen; give it a yield_force_kN')


def test_a_tie_holds_in_a_motion_what_falls_without_it(tmp_path):
    """With rigid joints its tension is not determined: any self-stress of tie and joint is possible."""
    ties = tie(states='["strengthened"]', yield_force_kN="50.0") + strengthening("original")
    found = shaken(tmp_path / "block", block() + HISTORY + ties)
    [fallen], [held] = (found.states[name].history for name in ("original", "strengthened"))
    assert fallen.collapsed and fallen.ties is None
    assert held.collapsed is False and held.peak_displacement_m < 1e-3
    [chain] = held.ties
    assert (chain.greatest_kN, chain.time_s, chain.yields) == (None, None, False)
    assert held.snapshots.tie_kN is None and "tie_kN" in held.snapshots.model_fields_set
    assert fallen.snapshots.tie_kN is None


SHAKEN = '[incremental]\nrecords = ["push.csv"]\ncontacts = "rigid"\ntolerance_g = 0.05\nmax_scale = 1.0\n'


def test_a_level_at_which_a_tie_breaks_is_told_to_be_no_fall(tmp_path):
    """The PGA at which the chain broke was told as that of a fall, without a word."""
    ties = tie(states='["strengthened"]', ultimate_elongation="0.0005") + strengthening("original")
    found = shaken(tmp_path / "block", 'accuracy = "fast"\n' + block() + SHAKEN + ties)
    signs = {name: found.states[name].incremental.records[0].signs for name in found.states}
    towards = {
        name: next(row for row in own if row.broken_tie or name == "original") for name, own in signs.items()
    }
    assert towards["strengthened"].broken_tie == "chain" and not any(
        row.broken_tie for row in signs["original"]
    )
    broken = [point for point in towards["strengthened"].points if point.collapsed]
    assert broken[0].broken_tie == "chain" and "breaks" in broken[0].reason
    count = sum(row.broken_tie is not None for row in signs["strengthened"])
    assert f"State “strengthened”, incremental analysis: of {count} of 2 records and signs" in told(found)
    italian = " ".join(lead(found, Words.of("it")))
    assert "la rottura di una catena (chain), che per convenzione vale come collasso" in italian
    rows = {row["state"]: row for row in dynamic.incremental(found).rows}
    worse = found.states["strengthened"].incremental.records[0].sign
    assert rows["strengthened"].get("broken_tie") == next(
        row.broken_tie for row in signs["strengthened"] if row.sign == worse
    )
    assert "broken_tie" not in rows["original"]


def test_elastic_joints_give_the_tension_of_a_tie_in_a_motion(tmp_path):
    """At 0.3 g, slowly: (W a h/2 − W b/2)/arm as in statics, and a fifth at most of undamped swinging about it."""
    ties = tie(states='["strengthened"]', yield_force_kN="50.0", stiffness_kN_m="20000.0")
    text = block("1e7") + HISTORY.replace('"rigid"', '"elastic"\nstates = ["strengthened"]')
    found = shaken(tmp_path / "block", text + ties + strengthening("original"))
    [held] = found.states["strengthened"].history
    [chain] = held.ties
    bears = 0.5 * WEIGHT * (0.3 * HEIGHT - WIDTH) / ARM
    assert bears < chain.greatest_kN < 1.2 * bears and not chain.yields
    assert chain.time_s == pytest.approx(3.0, abs=0.5)
    tensions = [each for each in held.snapshots.tie_kN if each is not None]
    assert max(tension for [tension] in tensions) == pytest.approx(chain.greatest_kN, rel=2e-2)


def test_a_settled_state_is_shaken_with_the_ties_that_are_set_there(tmp_path):
    """The base turned by −0.02 rad: the tie is taut where the block has come to, so that it does not move."""
    ties = tie(states='["strengthened"]', yield_force_kN="50.0") + strengthening()
    found = shaken(tmp_path / "block", block() + TURNED + HISTORY + ties)
    settled, strengthened = (found.states[name] for name in ("base turned", "strengthened"))
    assert settled.history[0].collapsed and not strengthened.history[0].collapsed
    assert strengthened.history[0].peak_displacement_m < 1e-3
    assert strengthened.configuration == settled.configuration


def test_a_campaign_takes_the_ties_of_each_state(tmp_path):
    """The tie is in the settled state alone, which withstands what the structure as drawn does not."""
    campaign = (
        '[campaign]\nrecords = ["push.csv"]\nshares = [0.0, 1.0]\nsigns = [-1]\ncontacts = "rigid"\n'
        'method = "stripes"\nlevels_g = [0.3]\n'
    )
    text = block() + TURNED + campaign + tie(states='["base turned"]', yield_force_kN="60.0")
    found = shaken(tmp_path / "block", text)
    drawn, turned = found.campaign.combinations
    assert (drawn.share, turned.share) == (0.0, 1.0)
    assert drawn.collapsed == [True] and turned.collapsed == [False]


def test_pretension_is_there_at_rest_with_elastic_joints(tmp_path):
    """10 kN of a tie of 1000 kN/m: the bed, 1e6 kN/m³ on 0.6 m, gives way by far less than the tie is stretched."""
    pushed = PUSHED.replace('["rigid"]', '["elastic"]').replace("0.2", "0.005")
    ties = tie(
        states='["strengthened"]', yield_force_kN="50.0", stiffness_kN_m="1000.0", pretension_kN="10.0"
    )
    history = HISTORY.replace("-0.3", "-0.001").replace("rigid", "elastic")
    found = shaken(tmp_path / "block", block() + pushed + history + ties + strengthening("original"))
    [chain] = found.states["strengthened"].pushover["+x"].elastic.ties
    assert chain.rest_kN == pytest.approx(10.0, rel=2e-2)
    assert chain.greatest_kN >= chain.peak_kN > chain.rest_kN
    [swung] = found.states["strengthened"].history[0].ties
    assert swung.greatest_kN == pytest.approx(chain.rest_kN, rel=2e-2)
