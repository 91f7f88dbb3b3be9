"""Mechanisms chosen by the user: hand calculations, limit analysis as a bound, refusals, choice of blocks."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assessment.analyses.chosen_mechanism import FollowedPoint, MechanismError, compared, evaluate
from assessment.analyses.kinematics import Hinge, KinematicsError, _unhindered, finite_motion
from assessment.cli.main import main
from assessment.ntc.capacity_curve import CapacityError, mechanism_participation
from assessment.ntc.spectrum import ElasticSpectrum
from assessment.ntc.verification import Method
from assessment.project.masonry import Chosen, RotatingBlocks
from assessment.project.project import load_project
from assessment.report.tables.capacity import chosen_mechanisms, trace
from assessment.results.schema.part import plain
from mechanics import Assembly, Block, Material, limit_analysis, pushover
from tests.support.block_project import PROJECT, outcome_of
from tests.support.structures import arch_on_piers, block_on_base, on_base, rectangle, semicircular_arch
from tests.support.trace_check import recomputed
from tests.support.typed import typed
from tests.support.wording import in_italian

STONE = Material(18.0, 0.7, 1e6)
GROUND = ElasticSpectrum(0.25, 2.4, 0.30)


def mechanism(*parts):
    return Chosen("m", "original", tuple(RotatingBlocks(np.array(c), w, np.array(b)) for c, w, b in parts))


def found(model, *parts, positions=None, demands=None, F_C=1.0):
    positions = model.initial.positions if positions is None else positions
    return evaluate(model, positions, mechanism(*parts), F_C, demands or {}, Method())


def column(courses=5, width=0.6, height=0.5, loads=(), friction=0.7):
    """A column of equal courses on a base, `loads` (kN) on the top courses, their mass as said."""
    stone = Material(18.0, friction, 1e6)
    blocks = [Block(rectangle(-1.0, -0.3, 1.6, 0.0), 1.0, stone, support="base")]
    for k in range(courses):
        load, mass = dict(enumerate(loads)).get(courses - 1 - k, (0.0, True))
        outline = rectangle(0.0, k * height, width, (k + 1) * height)
        blocks.append(Block(outline, 1.0, stone, vertical_load=load, load_has_mass=mass))
    return Assembly(blocks)


def test_one_block_by_hand():
    """0.6 × 4.2 × 1.0 m at 18 kN/m³ turns about its right lower corner: W = 45.36 kN at (0.3, 2.1) m.

    θ = −1: δ_x = 2.1, δ_z = 0.3 (the centre rises as the block leans to +x); L_W = 45.36·0.3 = 13.608 kNm,
    L_P = 45.36·2.1 = 95.256 kNm; α0 = 0.142857; e* = 1; F_C = 1.35: a_0* = 0.105820 g. Soil A, a_g = 0.25 g:
    S = 1, SLD a_g = 0.105820 g, ζ_E = 0.423280; SLV linear, q = 2: a_g = 0.211640 g, ζ_E = 0.846561.

    Nonlinear, d of the centroid, whose radius is R = √4.5 m: α = tan(asin((0.3 − d)/R)), d_0* = 0.3 m. SLV: d = 0.12 m,
    α = 0.0851600, a* = 0.0630815 g, T = 1.68π√(0.12/(a* g)) = 2.32456 s < T_D = 2.6 s, η = √(10/13):
    S_De/a_g = 0.364643 m, a_g = 0.329089 g. SLC: d = 0.18 m, α = 0.0566592, a* = 0.0419697 g, T = 3.24101 s > T_D:
    S_De/a_g = 0.379685 m, a_g = 0.474077 g.
    """
    demands = {"SLD": GROUND, "SLV": GROUND, "SLC": GROUND}
    answer = found(block_on_base(0.6, 4.2), ((0.6, 0.0), -1.0, [1]), demands=demands, F_C=1.35)
    assert answer.direction == "+x"
    assert answer.alpha_0 == pytest.approx(1 / 7, rel=1e-12)
    assert (answer.e_star, answer.moving_weight_kN) == (pytest.approx(1.0), pytest.approx(45.36))
    assert answer.a_0_star_g == pytest.approx(0.105820, abs=1e-6)
    assert answer.SLD.zeta_E == pytest.approx(0.423280, abs=1e-6)
    assert answer.SLV_linear.a_g_g == pytest.approx(0.211640, abs=1e-6)
    assert answer.SLV_linear.zeta_E == pytest.approx(0.846561, abs=1e-6)
    assert answer.d_0_star_m == pytest.approx(0.3, rel=1e-7)
    assert answer.control_m == pytest.approx([0.3, 2.1])
    assert answer.SLV.T_s == pytest.approx(2.32456, rel=1e-4)
    assert answer.SLV.a_g_g == pytest.approx(0.329089, rel=1e-4)
    assert answer.SLC.a_g_g == pytest.approx(0.474077, rel=1e-4)
    assert not answer.notes
    steps = {line.symbol: line.result for line in answer.trace}
    assert [steps[s] for s in ("delta_x_1", "delta_z_1", "L_W", "L_P")] == pytest.approx(
        [2.1, 0.3, 13.608, 95.256]
    )
    mirrored = found(block_on_base(0.6, 4.2), ((0.0, 0.0), 1.0, [1]))
    assert (mirrored.direction, mirrored.alpha_0) == ("-x", pytest.approx(1 / 7))


def test_a_load_without_mass_resists_and_does_not_push():
    """One course 0.6 × 0.5 m (5.4 kN) with 10 kN on top at its centroid: L_W = 15.4·0.3 = 4.62 kNm.

    With mass L_P = 15.4·0.25 = 3.85: α0 = 1.2; without L_P = 5.4·0.25 = 1.35: α0 = 3.4222.
    """
    for mass, expected in ((True, 1.2), (False, 4.62 / 1.35)):
        answer = found(column(1, loads=[(10.0, mass)]), ((0.6, 0.0), -1.0, [1]))
        assert answer.alpha_0 == pytest.approx(expected)


@given(courses=st.integers(2, 6), hinge=st.integers(0, 5), load=st.floats(0.0, 30.0))
@settings(max_examples=15)
def test_no_chosen_mechanism_lies_below_limit_analysis(courses, hinge, load):
    """The courses above any joint turn about its edge; the lowest joint gives limit analysis's own α0."""
    model, hinge = column(courses, loads=[(load, True)]), min(hinge, courses - 1)
    part = ((0.6, 0.5 * hinge), -1.0, range(hinge + 1, courses + 1))
    answer = compared(found(model, part), *2 * [limit_analysis(model, "+x").alpha])
    assert answer.alpha_0 >= answer.alpha_0_limit * (1.0 - 1e-6)
    if hinge == 0:
        assert answer.alpha_0 == pytest.approx(answer.alpha_0_limit, rel=1e-6)
    assert not answer.notes


def macro_blocks(model, delta):
    """Blocks of equal rotation as macro-blocks about the centre that their displacements have."""
    parts, rest = [], [i for i in np.flatnonzero(model.movable) if abs(delta[i, 2]) > 1e-7 * abs(delta).max()]
    while rest:
        same = [i for i in rest if abs(delta[i, 2] - delta[rest[0], 2]) < 1e-6 * abs(delta[:, 2]).max()]
        x, z = model.initial.positions[same[0], :2]
        theta = delta[same[0], 2]
        parts.append(((x - delta[same[0], 1] / theta, z + delta[same[0], 0] / theta), theta, same))
        rest = [i for i in rest if i not in same]
    return parts


@pytest.mark.parametrize(
    "model", [semicircular_arch(15, 0.16), arch_on_piers(friction=10.0)], ids=["arch", "arch on piers"]
)
def test_the_mechanism_of_limit_analysis_given_back_as_macro_blocks(model):
    """Four hinges, three macro-blocks: α0 and e* are those of limit analysis; no joint penetrates or slides."""
    limit = limit_analysis(model, "+x")
    parts = macro_blocks(model, limit.mechanism)
    assert len(parts) >= 3
    answer = compared(found(model, *parts), limit.alpha, limit.alpha)
    assert answer.alpha_0 == pytest.approx(limit.alpha, rel=1e-6)
    assert answer.penetration < 1e-5
    assert answer.sliding_joints == []
    assert answer.e_star == pytest.approx(
        mechanism_participation(model, limit.mechanism, 1.0).e_star, rel=1e-6
    )
    wrong = [(centre, -theta if k == 1 else theta, blocks) for k, (centre, theta, blocks) in enumerate(parts)]
    with pytest.raises(MechanismError, match="penetrates"):
        found(model, *wrong)


def test_the_motion_of_given_macro_blocks_is_that_of_the_pushover():
    """Four hinges of an arch, as limit analysis finds them: α over d follows the curve while the hinges are these."""
    model = semicircular_arch(15, 0.16)
    parts = macro_blocks(model, limit_analysis(model, "+x").mechanism)
    answer = found(model, *parts, demands={"SLV": GROUND, "SLC": GROUND})
    d = np.array(answer.curve.d_star_m) / answer.gamma_star
    alpha = np.array(answer.curve.a_star_g) * answer.e_star
    path = pushover(model, control=tuple(answer.control_m), direction="+x", increment=0.006)
    assert (np.diff(d) > 0.0).all() and alpha[-1] == 0.0
    kept = path.displacement < 0.7 * answer.d_0_m
    np.testing.assert_allclose(path.multiplier[kept], np.interp(path.displacement[kept], d, alpha), atol=1e-5)
    lines = [*answer.trace, *answer.SLV.trace, *answer.SLC.trace]
    for line in lines:
        if line.formula:
            assert recomputed(line.formula, line.inputs) == pytest.approx(line.result, rel=1e-9)


def test_a_macro_block_of_unequal_blocks_turns_about_its_toe():
    """α(θ) = −x/z of the centre of weight about the toe, turned by θ: its blocks weigh 12 and 1.8 and lie apart."""
    stone, toe = Material(20.0, 0.7), np.array([0.6, 0.0])
    shapes = [((-1.0, -0.5, 2.0, 0.0), "base"), ((0.0, 0.0, 0.6, 1.0), None), ((0.0, 1.0, 0.3, 1.3), None)]
    model = Assembly([Block(rectangle(*corners), 1.0, stone, support=name) for corners, name in shapes])
    chosen = mechanism((toe, -1.0, [1, 2]))
    places, multiplier = finite_motion(model, model.initial.positions, chosen, [Hinge(0, None, (0.6, 0.0))])
    weights = np.array([block.weight for block in model.blocks[1:]])
    x, z = np.average([block.centroid for block in model.blocks[1:]], axis=0, weights=weights) - toe
    turned = -places[:, 1, 2]
    across, up = x * np.cos(turned) + z * np.sin(turned), z * np.cos(turned) - x * np.sin(turned)
    assert len(turned) > 10
    np.testing.assert_allclose(multiplier, -across / up, atol=1e-9)


def test_a_wedge_without_hinges_has_no_nonlinear_check():
    """A centre far away is a translation: the linear check stays, and a note says why the other is missing."""
    model = column(3, friction=0.1)
    answer = found(model, ((1e4, -1e5), -1e-5, [1, 2, 3]), demands={"SLV": GROUND})
    assert "SLV" not in answer.checks and "SLV linear" in answer.checks
    assert any("no nonlinear check: the hinges between" in note for note in answer.notes)
    assert all(in_italian(note) != note for note in answer.notes)


def test_a_block_in_the_way_stops_the_motion():
    """A wall that turns about its corner into a pillar 50 mm away, reached before α = 0 (d_0 = 0.3 m at its centre)."""
    model = on_base(STONE, (-1.0, -0.3, 3.0), (0.0, 0.0, 0.6, 4.2), (0.65, 0.0, 2.0, 3.0))
    answer = found(model, ((0.6, 0.0), -1.0, [1]), demands={"SLV": GROUND})
    assert any("block 1 runs into block 2" in note for note in answer.notes)
    assert "SLV" not in answer.checks


def test_blocks_of_one_macro_block_do_not_run_into_each_other():
    """Three blocks of 0.6 × 1.4 m turn as one until their centre is above the corner: tan θ = 0.3/2.1.

    The control point is the uppermost centroid: d_0 = 0.3 (1 − cos θ) + 3.5 sin θ = 0.497990 m.
    """
    answer = found(column(3, height=1.4), ((0.6, 0.0), -1.0, [1, 2, 3]), demands={"SLV": GROUND})
    assert not answer.notes
    assert answer.d_0_m == pytest.approx(0.497990, rel=1e-5)
    assert answer.SLV.verified is not None


def test_the_last_configuration_of_a_motion_is_looked_at_too():
    """Of 41 every second one is looked at, from the second on; in the 41st the block has turned into the pillar."""
    model = on_base(STONE, (-1.0, -0.3, 3.0), *((x, 0.0, x + 0.6, 3.0) for x in (0.0, 0.65)))
    start = model.initial.positions
    into = model.rotated(1, (0.6, 0.0), -0.1).positions
    with pytest.raises(KinematicsError, match="block 1 runs into block 2"):
        _unhindered(model, [start] * 40 + [into], [np.array([1])])


def test_the_control_point_is_that_of_the_pushover_where_it_moves():
    """At the top, δ_C = 4.2: Γ* = ΣPδ²/(δ_C ΣPδ) = 2.1/4.2 = 0.5, d_0 = 2 · 0.3 m; else the farthest centroid's."""
    model = block_on_base(0.6, 4.2)
    top = {"+x": FollowedPoint((0.6, 4.2), 1)}
    chosen, demands = mechanism(((0.6, 0.0), -1.0, [1])), {"SLC": GROUND}
    method = Method(local_limits={"SLC": 0.1}, local_reason="beam")
    answer = evaluate(model, model.initial.positions, chosen, 1.0, demands, method, top)
    assert answer.gamma_star == pytest.approx(0.5)
    assert answer.d_0_star_m == pytest.approx(answer.d_0_m * 0.5)
    assert answer.SLC.governing == "local limit"
    assert answer.SLC.d_star_m == pytest.approx(0.05)
    other = evaluate(
        model, model.initial.positions, chosen, 1.0, demands, method, {"+x": FollowedPoint((0, -0.1), 0)}
    )
    assert other.SLC.governing == "0.60 d_0"  # a limit of another point is none of this one


@pytest.mark.parametrize(
    ("part", "says"),
    [
        (((0.6, 0.0), 1.0, [1, 2, 3]), r"block 0 penetrates block 1 by 48 %"),  # into the base
        (((0.3, 0.0), -1.0, [1, 2, 3]), r"penetrates"),  # hinge in the middle
        (((0.3, 0.75), -1.0, [1, 2, 3]), r"penetrates"),
        (((0.0, 1e9), -1.0, [2]), r"the weights do no horizontal work|alpha_0 = "),
    ],
)
def test_what_cannot_move_is_refused(part, says):
    with pytest.raises(MechanismError, match=says):
        found(column(3), part)


def test_piers_that_lean_away_from_each_other_are_no_oscillator():
    """Of 4.2 and 3.0 m, by the same angle: 3²/(3² + 4.2²) = 34 % of ΣP|δ| goes back; e* was 0.10."""
    blocks = [
        Block(rectangle(x, 0.0, x + 0.6, z), 1.0, STONE, support=support)
        for x, z, support in ((-0.6, 3.0, None), (0.0, 4.2, None))
    ]
    model = Assembly([Block(rectangle(-2.0, -0.3, 2.0, 0.0), 1.0, STONE, support="base"), *blocks])
    with pytest.raises(CapacityError, match=r"34 % of ΣP\|δ\| goes against the rest"):
        found(model, ((-0.6, 0.0), 1.0, [1]), ((0.6, 0.0), -1.0, [2]))


def test_a_hinge_set_back_from_the_edge_is_told():
    """30 mm in 2.1 m: 1.4 % of the largest displacement; α0 = 0.27/2.1 lies below limit analysis, and says why."""
    model = block_on_base(0.6, 4.2)
    answer = compared(found(model, ((0.57, 0.0), -1.0, [1])), *2 * [limit_analysis(model, "+x").alpha])
    assert answer.alpha_0 == pytest.approx(0.27 / 2.1)
    assert "penetrates block 1 by 1.4 %" in answer.notes[0]
    assert "below that of limit analysis" in answer.notes[1]


def test_in_a_settled_state_it_stands_beside_the_alpha_0_that_is_printed():
    """Beside the multiplier that closes a hinge of the settlement, 0.037, a mechanism looked three times too strong."""
    answer = found(block_on_base(0.6, 4.2), ((0.6, 0.0), -1.0, [1]))
    assert compared(answer, 0.11, 0.037).alpha_0_limit == 0.11
    assert compared(answer, 0.11, 0.037).notes == answer.notes
    [*_, note] = compared(answer, 0.2, 0.037).notes
    assert note.startswith(
        "alpha_0 is below that of the state, 0.2: a hinge of the settlement closes from α = 0.037"
    )
    assert "cerniera del cedimento" in in_italian(note)


def written(project, text):
    (project / "project.toml").write_text(PROJECT + text, encoding="utf-8")
    return project


GIVEN = """
[[mechanism]]
name = "by region"
about_m = [0.3, 0.0]
region_m = [-1.0, 0.0, 1.0, 5.0]
[[mechanism]]
name = "by number"
about_m = [0.3, 0.0]
blocks = [1]
[[mechanism]]
name = "by polygon"
about_m = [-0.3, 0.0]
rotation = 1.0
region_m = [-1.0, 0.0, 1.0, 0.0, 1.0, 5.0, -1.0, 5.0]
[[mechanism]]
name = "wrong way"
about_m = [0.3, 0.0]
rotation = 1.0
blocks = [1]
[[mechanism]]
name = "settled"
about_m = [0.303, -0.006]
blocks = [1]
state = "base turned"
"""


def test_a_project_with_mechanisms(project):
    """α0 = B/H in either sense; in the settled state the corner has gone down with the base turned by 0.02 rad."""
    content = load_project(written(project, GIVEN))
    outcome = outcome_of(content)
    results = plain(outcome.results)
    assert not outcome.complete  # one is refused
    answers = {each["name"]: each for each in results["mechanisms"]}
    for name in ("by region", "by number"):
        assert answers[name]["alpha_0"] == pytest.approx(1 / 7, rel=1e-9)
        assert answers[name]["alpha_0_limit"] == pytest.approx(1 / 7, rel=1e-6)
    assert answers["by polygon"]["direction"] == "-x"
    assert answers["by polygon"]["alpha_0_limit"] is None  # not pushed that way
    assert "penetrates" in answers["wrong way"]["refused"]
    assert any("wrong way" in text and "refused" in text for text in results["quality"]["warnings"])
    assert answers["settled"]["alpha_0"] == pytest.approx(np.tan(np.arctan(1 / 7) - 0.02), rel=2e-3)
    assert answers["settled"]["alpha_0"] == pytest.approx(answers["settled"]["alpha_0_limit"], rel=2e-3)
    assert len(chosen_mechanisms(typed(results)).rows) == 5
    assert "by region: capacity" in {row["part"] for row in trace(typed(results)).rows}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('layers = ["WAL"]\n', "mechanism[1].layers: no block on layer"),
        ("blocks = [7]\n", "mechanism[1].blocks: no block 7; write 0 to 1"),
        ("blocks = [0]\n", "mechanism[1].blocks: block 0 is a support"),
        ("region_m = [5.0, 5.0, 6.0, 6.0]\n", "mechanism[1]: no movable block is chosen"),
        ("region_m = [0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0]\n", "mechanism[1].region_m: the outline crosses itself"),
        (
            'blocks = [1]\n[[mechanism]]\nname = "m"\nabout_m = [0, 0]\nblocks = [1]\n',
            "mechanism[2]: block 1 is in another",
        ),
    ],
)  # fmt: skip
def test_a_wrong_choice_is_named_before_any_analysis(project, capsys, text, says):
    written(project, f'\n[[mechanism]]\nname = "m"\nabout_m = [0.3, 0.0]\n{text}')
    assert main(["check", str(project)]) == 2
    assert f"error: project.toml: {says}" in capsys.readouterr().err
