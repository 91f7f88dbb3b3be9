"""Paths of a state: blocks that slide past an edge on the way, movements that begin where another ends."""

from dataclasses import replace

import numpy as np
import pytest

from assessment.analyses.capacity import assess, with_loss
from assessment.analyses.demand import demand_spectra
from assessment.analyses.paths import local_loss, loss_sentence, not_back
from assessment.analyses.states import Request, analyse_states
from assessment.ntc.verification import Method
from assessment.project.catalogue.new_project import new_project, write_drawing
from assessment.project.model import build_model, state_models
from assessment.project.project import load_project
from assessment.report.chapters.remarks import displacement_limits
from assessment.report.language import Words
from assessment.results.frames import normal_forces
from assessment.results.schema.part import plain
from assessment.results.schema.static import LocalLoss
from assessment.runtime.errors import ProjectError
from assessment.runtime.tasks import Workers
from assessment.workflow.stages import run
from mechanics import Assembly, Block, Material, State, pushdown, pushover
from mechanics.messages import message
from tests.support.block_project import ASSESSMENT, PROJECT, PUSHED, results_of, write_block
from tests.support.contract_project import MINIMAL
from tests.support.results_example import results_example
from tests.support.structures import arch_on_piers, block_on_base, built, rectangle
from tests.support.typed import typed
from tests.support.wording import in_italian

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
    normal = np.full((len(ways), 1), 1.44)
    loss = local_loss(model, states, ways, normal, falls=False)
    assert loss.displacement_m == pytest.approx(0.4)
    assert (loss.joint, loss.blocks, loss.overlap_m) == (0, [0, 1], pytest.approx(0.4))
    assert local_loss(model, states[:4], ways[:4], normal[:4], falls=True) is None
    for left, lost in ((0.03, False), (0.01, True)):  # of its bearing, where the structure falls
        ends = model.initial.positions + np.array([[0, 0, 0], [0.4 * (1.0 - left), 0, 0]])
        found = [states[0], replace(model.initial, positions=ends)]
        assert (local_loss(model, found, np.array([0.0, 0.4]), normal[:2], falls=True) is not None) is lost
    # a joint that bears nothing loses nothing
    assert local_loss(model, states, ways, 0.0 * normal, falls=True) is None
    assert "perdere l’appoggio a d = 0,4 m" in in_italian(loss_sentence(loss))


def test_a_hinge_that_turns_loses_nothing():
    model = block_on_base(0.6, 4.2)
    path = pushover(model, (0.6, 4.2), increment=0.05)
    assert path.reached_zero
    assert local_loss(model, path.states, path.displacement, normal_forces(path), path.lost) is None


def test_the_loss_is_the_limit_unless_the_project_gives_one():
    loss = LocalLoss(displacement_m=0.05, joint=0, blocks=[3, 4], overlap_m=0.1)
    found = with_loss(Method(), loss)
    assert found.local_limits == {"SLV": 0.05, "SLC": 0.05}
    assert "blocks 3 and 4" in found.local_reason
    given = Method(local_limits={"SLV": 0.2}, local_reason="beam")
    assert with_loss(given, loss) is given
    assert with_loss(given, None) is given


def test_the_check_is_made_with_it(tmp_path):
    """The block's own curve, with a loss at 0.1 m: d_SLV is d* of its centroid there; the report says why."""
    project = load_project(write_block(tmp_path / "block", PROJECT + ASSESSMENT))
    model = build_model(project)
    results = plain(run(project, model, jobs=1).results)
    state = typed(results).states["original"]
    pushed = state.pushover["+x"]
    demands = demand_spectra(project)
    whole = assess(project, model.assembly, {"+x": pushed}, demands)["+x"].value.capacity.SLV
    loss = LocalLoss(displacement_m=0.1, joint=0, blocks=[0, 1], overlap_m=0.6)
    lost = {"+x": pushed.replace(rigid=pushed.rigid.replace(local_loss=loss))}
    limited = assess(project, model.assembly, lost, demands)["+x"].value.capacity.SLV
    assert whole.governing == "0.40 d_0"
    assert limited.governing == "local limit"
    lean = np.arcsin(0.1 / 4.2)  # of the block, whose control point lies above its toe
    assert limited.d_star_m == pytest.approx(2.1 * np.sin(lean) + 0.3 * (1.0 - np.cos(lean)), rel=5e-3)
    results["states"]["original"]["pushover"]["+x"]["rigid"]["local_loss"] = loss.model_dump()
    assert "blocchi 0 e 1, appoggio iniziale 600 mm, limite 100 mm" in limits_told(results, "it")
    table = project.assessment.model_copy(update={"local_displacement_limit_m": 0.2})
    farther = project.model_copy(update={"assessment": table})
    told = assess(farther, model.assembly, lost, demands)["+x"].warnings
    assert any("write no more than that" in warning for warning in told)


def test_no_capacity_is_taken_from_behind_a_loss(tmp_path):
    """The block's curve turned round, with its peak at the end; and its own, with a tie that has broken before."""
    project = load_project(write_block(tmp_path / "block", PROJECT + ASSESSMENT))
    model = build_model(project)
    pushed = run(project, model, jobs=1).results.states["original"].pushover["+x"]
    rising = pushed.rigid.curve.replace(multiplier=pushed.rigid.curve.multiplier[::-1])
    loss = LocalLoss(displacement_m=0.1, joint=0, blocks=[0, 1], overlap_m=0.6)
    lost = {"+x": pushed.replace(rigid=pushed.rigid.replace(curve=rising, local_loss=loss))}
    [why] = assess(project, model.assembly, lost, demand_spectra(project))["+x"].failures
    assert "is reached after the faces of blocks 0 and 1 slide off each other at d = 0.1 m" in why
    broken = LocalLoss(
        displacement_m=0.0, joint=None, blocks=[0, 1], overlap_m=None, tie="chain", longest_m=0.1
    )
    lost = {"+x": pushed.replace(rigid=pushed.rigid.replace(local_loss=broken))}
    [why] = assess(project, model.assembly, lost, demand_spectra(project))["+x"].failures
    assert 'after the tie "chain", which has yielded by 0.1 m, breaks at d = 0 m' in why


def test_a_lintel_that_drops_between_its_piers_is_lost():
    """It slides 0.5 m off the pier that has sunk, drops and is wedged between both, where α rises to twice."""
    stone = Material(18.0, 0.65)
    piers = {"left": (0.0, 0.0, 0.5, 1.0), "right": (2.0, 0.0, 2.5, 1.0)}
    model = built(stone, (0.0, 1.0, 2.5, 1.5), **piers)
    settled = pushdown(model, "right", (0.0, -0.05), increment=0.005).final
    path = pushover(model, direction="-x", increment=0.02, state=settled)
    loss = local_loss(model, path.states, path.displacement, normal_forces(path), path.lost)
    assert loss.displacement_m == pytest.approx(0.494, rel=0.02)
    assert loss.displacement_m < path.displacement[: path.peak].max() + 1e-3


ELASTIC_END = "structure with elastic contacts loses equilibrium"


def limits_told(results, language):
    told = " ".join(displacement_limits(typed(results), Words.of(language)))
    return " ".join(told.split())  # no-break spaces before units among them


def test_the_limits_are_those_of_the_checks_that_were_made():
    """The linear check and the end of an elastic curve were told of an arch of rigid joints checked at SLC alone."""
    results = results_example("en")
    check = results["states"]["original"]["capacity"]["+x"]["SLV"]
    told = limits_told(results, "en")
    assert "7/2019" in told and "linear check" not in told and ELASTIC_END not in told
    results["states"]["original"]["capacity"]["+x"]["SLV linear"] = dict(check)
    assert "linear check (SLV, linear" in limits_told(results, "en")
    check["governing"] = "end of the elastic curve"
    assert ELASTIC_END in limits_told(results, "en")
    results["echo"]["assessment"]["circular"] = 2009
    assert "617/2009" in limits_told(results, "en") and "7/2019" not in limits_told(results, "en")


BEAM = f"""{MINIMAL}friction = 0.2
[layers.LEFT]
support = "left"
[layers.RIGHT]
support = "right"
[[control]]
name = "top of the right pier"
point_m = [5.35, 3.0]
{PUSHED.replace("0.2", "0.01")}"""


def beam_on_piers(width):
    """A beam of 4.05 m with seats of 50 mm on two piers 3 m high; the left one is 1 m wide, the right one `width`."""
    drawn = {
        "LEFT": [rectangle(-0.5, -0.3, 1.5, 0.0)],
        "RIGHT": [rectangle(4.45, -0.3, 5.45 + width, 0.0)],
        "PIERS": [rectangle(0.0, 0.0, 1.0, 3.0), rectangle(4.95, 0.0, 4.95 + width, 3.0)],
        "BEAM": [rectangle(0.95, 3.0, 5.0, 3.2)],
    }
    return {layer: [np.array(polygon) for polygon in polygons] for layer, polygons in drawn.items()}


def test_a_beam_that_unseats_is_followed_from_the_drawing(tmp_path):
    """The right pier turns by φ about its toe and takes the beam along, whose left end has 50 mm of seat.

    Its inner corner, 0.4 m from the toe and 3 m above, moves by 3 sin φ + 0.4 (1 − cos φ) = 0.05 m, so φ = 0.016648 and
    the control point moves by 3 sin φ = 0.04994 m. There the beam falls: the capacity ends.
    """
    write_drawing(tmp_path / "geometry.dxf", beam_on_piers(0.4))
    (tmp_path / "project.toml").write_text("scatter = 1\n" + BEAM + ASSESSMENT, encoding="utf-8")
    project = load_project(tmp_path)
    results = results_of(project)
    rigid = results["states"]["original"]["pushover"]["+x"]["rigid"]
    loss = rigid["local_loss"]
    assert loss["displacement_m"] == pytest.approx(0.04994, rel=5e-3)
    assert (loss["blocks"], loss["overlap_m"]) == ([2, 4], pytest.approx(0.05, rel=1e-5))
    assert rigid["lost"] and not rigid["reached_zero"] and rigid["d_0_m"] == loss["displacement_m"]
    assert any(
        "the faces of blocks 2 and 4 slide off each other" in text for text in results["quality"]["warnings"]
    )
    capacity = results["states"]["original"]["capacity"]["+x"]
    limit = np.interp(loss["displacement_m"], rigid["curve"]["displacement_m"], rigid["d_star_m"])
    assert capacity["SLV"]["d_star_m"] == pytest.approx(min(0.4 * capacity["d_0_star_m"], limit))


def test_a_pier_that_moves_away_unseats_the_beam():
    """Two stocky piers stand still: the beam stays on one, and 50 mm of movement use up the seat on the other.

    Rigid joints leave open on which of two like seats it slides; a joint that has begun to slide goes on, since the
    forces of rigid joints stay near those of the step before. Elastic joints say 46 mm.
    """
    supports = {"LEFT": "left", "RIGHT": "right"}
    blocks = [
        Block(polygon, 1.0, Material(18.0, 0.5), support=supports.get(layer))
        for layer, polygons in beam_on_piers(1.0).items()
        for polygon in polygons
    ]
    model = Assembly(blocks)
    path = pushdown(model, "right", (0.002, 0.0), increment=0.002, to_collapse=True, sliding="coulomb")
    assert path.ultimate == pytest.approx(0.05, rel=0.02)
    loss = local_loss(model, path.states, path.movement, normal_forces(path), falls=True)
    assert loss.displacement_m == path.movement[-1] == pytest.approx(0.05, rel=0.02)
    assert 4 in loss.blocks
    assert local_loss(model, path.states, path.movement, normal_forces(path), falls=False) is None


def movement(name: str, support: str, x: float, z: float, *more: str) -> str:
    keys = [
        f'name = "{name}"', f'support = "{support}"', f"displacement_m = [{x}, {z}]", "increment_m = 0.002",
        *more,
    ]  # fmt: skip
    return "[[settlements]]\n" + "\n".join(keys) + "\n"


FORTH = movement("forth", "destro", 0.01, -0.006)
BACK = movement("back", "destro", -0.01, 0.006, 'after = "forth"')
THEN = movement("then", "sinistro", -0.004, 0.0, 'after = "forth"')


def project(folder, *tables: str):
    new_project(folder, "buttressed-arch", {})
    text = (folder / "project.toml").read_text(encoding="utf-8").partition("[[settlements]]")[0]
    (folder / "project.toml").write_text(text + "".join(tables), encoding="utf-8")
    return load_project(folder)


def analysed(made, *names: str, behaviour="rigid"):
    drawn = build_model(made).assembly
    models = state_models(made, drawn)
    requests = [Request(made, models[name], made.settlement_of(name), behaviour) for name in names]
    with Workers(jobs=1) as workers:
        return drawn, dict(zip(names, analyse_states(requests, workers), strict=True))


def test_each_movement_begins_where_the_one_before_it_ends(tmp_path):
    """Whatever the order in the file, and though only the last state is asked for."""
    made = project(tmp_path / "p", THEN, FORTH)
    drawn, found = analysed(made, "then")
    sliding = made.contacts.sliding
    forth = pushdown(drawn, "destro", (0.01, -0.006), increment=0.002, sliding=sliding)
    then = pushdown(drawn, "sinistro", (-0.004, 0.0), increment=0.002, sliding=sliding, state=forth.final)
    assert abs(found["then"].reached.positions - then.final.positions).max() < 1e-9
    assert found["then"].pushdown.movement_m[-1] == pytest.approx(0.004)
    assert not found["then"].warnings


@pytest.mark.parametrize("behaviour", ["rigid", "elastic"])
def test_blocks_that_come_back_with_their_supports_are_told_so(tmp_path, behaviour):
    """Hinges close again; elastic joints have sunk under gravity, by 3.5 mm, before any support has moved."""
    drawn, found = analysed(project(tmp_path / "p", FORTH, BACK), "forth", "back", behaviour=behaviour)
    reached = found["back"].reached.positions
    assert reached[~drawn.movable] == pytest.approx(drawn.initial.positions[~drawn.movable], abs=1e-12)
    [told] = [text for text in found["back"].warnings if "again where they were as drawn" in text]
    assert "and so are the blocks" in told and "di nuovo dove erano nel disegno" in in_italian(told)
    assert (abs(reached - drawn.initial.positions).max() > 1e-3) == (behaviour == "elastic")


def test_what_does_not_come_back_is_told():
    drawn = arch_on_piers()
    moved = drawn.initial.positions.copy()
    moved[3, 0] += 0.012
    told = not_back(drawn, State(moved, 0.0 * moved), message("as drawn"), drawn.initial)
    assert "stay away by up to 0.012 m (block 3" in told


def test_a_state_that_was_not_reached_is_no_beginning(tmp_path):
    fall = movement("fall", "destro", 0.3, 0.0).replace("0.002", "0.02")
    _, found = analysed(project(tmp_path / "p", fall, BACK.replace("forth", "fall")), "back")
    assert found["back"].reached is None and not found["back"].pushover
    [failure] = found["back"].failures
    assert "the state that the movement begins in was not reached" in failure


@pytest.mark.parametrize(
    ("tables", "key", "said"),
    [
        ((FORTH, BACK.replace('after = "forth"', 'after = "fort"')), "settlements[2].after", 'did you mean "forth"?'),
        ((FORTH + 'after = "back"\n', BACK), "settlements[1].after", "the movements begin in each other's states"),
        ((FORTH + 'after = "forth"\n',), "settlements[1].after", "begin in each other's states"),
        (
            (
                FORTH,
                BACK,
                '[[tie]]\nname = "chain"\nfrom_m = [-0.3, 0.5]\nto_m = [0.3, 0.5]\nstates = ["back"]\n',
            ),
            "settlements[2].after",
            'the tie "chain" is there in one of "forth" and "back" alone',
        ),
        ((FORTH, BACK + "steps = 4\n", "[pushover]\n"), "settlements[2].steps", "leave it out"),
        ((FORTH, BACK, '[campaign]\nrecords = ["generate:3"]\n'), "campaign.settlements", '"back" does not'),
    ],
)  # fmt: skip
def test_what_has_no_beginning_is_refused(tmp_path, tables, key, said):
    with pytest.raises(ProjectError) as refused:
        project(tmp_path / "p", *tables)
    assert any(
        line.startswith(f"project.toml: {key}: ") and said in line for line in str(refused.value).splitlines()
    )
