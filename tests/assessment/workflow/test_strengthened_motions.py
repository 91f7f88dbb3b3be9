"""Motions of states with ties: each state is shaken with its own, from where its strengthening finds it."""

from __future__ import annotations

import numpy as np
import pytest

from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.results.schema import Results
from assessment.workflow.stages import run
from tests.support.block_project import PUSHED, TURNED, block, write_block
from tests.support.tied_project import HEIGHT, WEIGHT, WIDTH, strengthening, tie

ARM = 0.59  # m, of the tie from the toe at x = 0.3
SLOW = 0.01 * np.arange(601)
HALF_SINE = np.sin(np.pi * SLOW / 6.0)  # g; the block that stands moves as in a static test
HISTORY = '[[history]]\nrecord = "push.csv"\nscale = -0.3\ncontacts = "rigid"\n'


def results_of(folder, text: str, time=SLOW, acceleration=HALF_SINE) -> Results:
    write_block(folder, "scatter = 1\n" + text)
    np.savetxt(folder / "push.csv", np.column_stack([time, acceleration]), delimiter=",", fmt="%.8f")
    project = load_project(folder)
    return run(project, build_model(project), jobs=1).results


def test_a_tie_holds_in_a_motion_what_falls_without_it(tmp_path):
    """With rigid joints its tension is not determined: any self-stress of tie and joint is possible."""
    ties = tie(states='["strengthened"]', yield_force_kN="50.0") + strengthening("original")
    found = results_of(tmp_path / "block", block() + HISTORY + ties)
    [fallen], [held] = (found.states[name].history for name in ("original", "strengthened"))
    assert fallen.collapsed and fallen.ties is None
    assert held.collapsed is False and held.peak_displacement_m < 1e-3
    [chain] = held.ties
    assert (chain.greatest_kN, chain.time_s, chain.yields) == (None, None, False)
    assert held.snapshots.tie_kN is None and "tie_kN" in held.snapshots.model_fields_set
    assert fallen.snapshots.tie_kN is None


def test_elastic_joints_give_the_tension_of_a_tie_in_a_motion(tmp_path):
    """At 0.3 g, slowly: (W a h/2 − W b/2)/arm as in statics, and a fifth at most of undamped swinging about it."""
    ties = tie(states='["strengthened"]', yield_force_kN="50.0", stiffness_kN_m="20000.0")
    text = block("1e7") + HISTORY.replace('"rigid"', '"elastic"\nstates = ["strengthened"]')
    found = results_of(tmp_path / "block", text + ties + strengthening("original"))
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
    found = results_of(tmp_path / "block", block() + TURNED + HISTORY + ties)
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
    found = results_of(tmp_path / "block", text)
    drawn, turned = found.campaign.combinations
    assert (drawn.share, turned.share) == (0.0, 1.0)
    assert drawn.collapsed == [True] and turned.collapsed == [False]


def test_pretension_is_there_at_rest_with_elastic_joints(tmp_path):
    """10 kN of a tie of 1000 kN/m: the bed, 1e6 kN/m³ on 0.6 m, gives way by far less than the tie is stretched."""
    pushed = PUSHED.replace('["rigid"]', '["elastic"]').replace("0.2", "0.005")
    ties = tie(
        states='["strengthened"]', yield_force_kN="50.0", stiffness_kN_m="1000.0", pretension_kN="10.0"
    )
    shaken = HISTORY.replace("-0.3", "-0.001").replace("rigid", "elastic")
    found = results_of(tmp_path / "block", block() + pushed + shaken + ties + strengthening("original"))
    [chain] = found.states["strengthened"].pushover["+x"].elastic.ties
    assert chain.rest_kN == pytest.approx(10.0, rel=2e-2)
    assert chain.greatest_kN >= chain.peak_kN > chain.rest_kN
    [swung] = found.states["strengthened"].history[0].ties
    assert swung.greatest_kN == pytest.approx(chain.rest_kN, rel=2e-2)
