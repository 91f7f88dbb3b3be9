"""A block that slides past an edge along a path is a local loss, and the limit of the checks where none is given."""

from dataclasses import replace

import numpy as np
import pytest

from assessment.analyses.checks.capacity import assess, with_loss
from assessment.analyses.checks.demand import demand_spectra
from assessment.analyses.static.local_loss import local_loss, loss_told
from assessment.ntc.verification import Method
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.report.document import _local_limit
from assessment.report.text.language import Words, words_of
from assessment.report.text.messages import translated
from assessment.workflow.stages import run
from mechanics import Assembly, Block, Material, pushover
from tests.support.block_project import ASSESSMENT, PROJECT, write_block
from tests.support.results_example import results_example
from tests.support.structures import block_on_base, rectangle

STONE = Material(18.0, 0.2)


def sliding_column():
    """A slab 0.4 m long on the end of a sill: its bearing is 0.4 m, and friction 0.2 lets it slide, not turn."""
    base = Block(rectangle(-3.0, -0.3, 0.4, 0.0), 1.0, STONE, support="base")
    return Assembly([base, Block(rectangle(0.0, 0.0, 0.4, 0.2), 1.0, STONE)])


def test_a_block_slides_past_an_edge():
    """Its face reaches from 0 to 0.4 m over a sill that ends at 0.4 m: nothing is left after a way of 0.4 m."""
    model = sliding_column()
    ways = np.array([0.0, 0.1, 0.2, 0.3, 0.45, 0.5])
    positions = [model.initial.positions + np.array([[0, 0, 0], [way, 0, 0]]) for way in ways]
    states = [replace(model.initial, positions=each) for each in positions]
    forces = np.array([[1.44, 0.0, 0.0]])
    loss = local_loss(model, states, ways, forces)
    assert loss["displacement_m"] == pytest.approx(0.4)
    assert (loss["joint"], loss["blocks"], loss["overlap_m"]) == (0, [0, 1], pytest.approx(0.4))
    assert local_loss(model, states[:4], ways[:4], forces) is None
    assert local_loss(model, states, ways, 0.0 * forces) is None  # a joint that bears nothing loses nothing
    words = words_of({"echo": {}})
    assert "perdere l’appoggio a d = 0,4 m" in translated(loss_told(loss), words)


def test_a_hinge_that_turns_loses_nothing():
    model = block_on_base(0.6, 4.2)
    path = pushover(model, (0.6, 4.2), increment=0.05)
    assert path.reached_zero
    assert local_loss(model, path.states, path.displacement, path.forces) is None


def test_the_loss_is_the_limit_unless_the_project_gives_one():
    loss = {"displacement_m": 0.05, "joint": 0, "blocks": [3, 4], "overlap_m": 0.1}
    found = with_loss(Method(), loss)
    assert found.local_limits == {"SLV": 0.05, "SLC": 0.05}
    assert "blocks 3 and 4" in found.local_reason
    given = Method(local_limits={"SLV": 0.2}, local_reason="beam")
    assert with_loss(given, loss) is given
    assert with_loss(given, None) is given


def test_the_check_is_made_with_it(tmp_path):
    """The block's own curve, α = 1/7 to 0 over 0.6 m, with a loss at 0.1 m: d_SLV = 0.1 Γ*, and the report says why."""
    project = load_project(write_block(tmp_path / "block", PROJECT + ASSESSMENT))
    model = build_model(project)
    results = run(project, model, jobs=1).results
    pushed = results["states"]["original"]["pushover"]
    demands = demand_spectra(project)[0]
    whole = assess(project, model.assembly, pushed, demands, None, [])["+x"]["SLV"]
    pushed["+x"]["rigid"]["local_loss"] = {
        "displacement_m": 0.1,
        "joint": 0,
        "blocks": [0, 1],
        "overlap_m": 0.6,
    }
    limited = assess(project, model.assembly, pushed, demands, None, [])["+x"]["SLV"]
    assert whole["governing"] == "0.40 d_0"
    assert limited["governing"] == "local limit"
    assert limited["d_star_m"] == pytest.approx(
        0.1 * results["states"]["original"]["capacity"]["+x"]["gamma_star"]
    )
    assert "perdere l’appoggio a 100 mm" in _local_limit(results, Words.of("it"))
    table = project.assessment.model_copy(update={"local_displacement_limit_m": 0.2})
    farther, warnings = project.model_copy(update={"assessment": table}), []
    assess(farther, model.assembly, pushed, demands, None, warnings)
    assert any("write no more than that" in warning for warning in warnings)


def test_an_example_without_losses_says_nothing():
    assert "local_displacement_limit_m" not in _local_limit(results_example("en"), Words.of("en"))
