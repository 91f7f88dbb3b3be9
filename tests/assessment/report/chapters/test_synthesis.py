"""The first page agrees with the tables: each number of its sentences and of its table is that of the checks."""

import copy
import re

import pytest
from hypothesis import given, settings
from markupsafe import Markup

from assessment.report.chapters.synthesis import basis, lead, synthesis_grid
from assessment.report.language import Words, direction_name, plain_text, written
from assessment.report.tables.capacity import verification
from assessment.report.tables.mechanisms import mechanisms
from assessment.results.schema import SummaryCheck
from assessment.results.schema.static import Strengthening
from assessment.results.summary import index_limit, settled, worst_settled
from tests.support.analysed import analysed
from tests.support.judgement.random_results import random_results
from tests.support.results_example import SETTLED, results_example
from tests.support.typed import typed

WORDS = Words.of("en")


def borne(results, state, direction, limit):
    """ζ_E as the table of the checks has it: at SLV the linear check only where the nonlinear one has no number."""
    rows = {
        row["limit_state"]: row["zeta_E"]
        for row in verification(results).rows
        if (row["state"], row["direction"]) == (state, direction) and row["zeta_E"] is not None
    }
    found = [rows[name] for name in (limit, f"{limit} linear", f"{limit} elastic") if name in rows]
    return None if not found else found[0] if limit in {"SLV", "SLC"} else min(found)


def agrees(results):
    """Hold the table of the first page against those of checks and mechanisms."""
    made = synthesis_grid(results, WORDS)
    alpha = {(row["state"], row["direction"]): row["alpha_0"] for row in mechanisms(results).rows}
    heads = [Markup(head).striptags() for head in made.head] if made else []
    for row in made.rows if made else []:
        cells = dict(zip(heads, row, strict=True))
        state = next(name for name in results.states if WORDS.state(name) == Markup(row[0]).unescape())
        direction = Markup(row[1]).replace("−", "-")
        for head, cell in cells.items():
            if found := re.fullmatch(r"(?:ζE|Ratio) (SL\w)", head):
                ratio = borne(results, state, direction, found[1])
                assert cell == (WORDS.plain("value.open") if ratio is None else WORDS.ratio(ratio)), head
        if (state, direction) in alpha and "α0" in cells:
            assert cells["α0"] == WORDS.number(alpha[state, direction])
        limits = [
            borne(results, state, direction, limit) for limit in ("SLV", "SLC") if f"ζE {limit}" in heads
        ]
        if "Outcome" in cells and None not in limits and limits and min(limits) < 1.0:
            assert cells["Outcome"] == "not\u00a0verified"
    return made


def sentence_agrees(results):
    """The first sentence: the least index of the worst state, that before, and the loss between them."""
    limit, state = index_limit(results), worst_settled(results) or "original"
    said = Markup(lead(results, WORDS)[0]).striptags()
    found = re.search(
        r"ζE = (\S+) \((pushover|linear check), (\w+), ([+−]x)(?:, not determined in\s([+−]x))?\)"
        r"(?:; before the settlement (\S+): .*? of (\S+)\s%)?", said,
    )  # fmt: skip
    if found is None or limit is None:
        assert "ζE = " not in said
        return
    value, kind, where, direction, open_way, before, share = found.groups()
    lacking = {
        (each.state, direction_name(each.direction))
        for each in results.summary.rows
        if borne(results, each.state, each.direction, limit) is None
    }
    assert {way for name, way in lacking if name == state} == ({open_way} if open_way else set())
    if any(name in settled(results) for name, _ in lacking):
        assert not said.startswith("In the worst of"), "another one may be worse"
    own = {way: borne(results, state, way, limit) for way in ("+x", "-x")}
    known = {way: ratio for way, ratio in own.items() if ratio is not None}
    way = direction.replace("−", "-")
    assert where == limit and known[way] == min(known.values()) and value == WORDS.ratio(known[way])
    there = {each.state: each for each in results.summary.rows if each.direction == way}
    nonlinear = {name: row.checks[limit].check == limit for name, row in there.items()}
    assert (kind == "pushover") == nonlinear[state]
    assert before is None or nonlinear["original"] == nonlinear[state]
    if before is not None:
        was = borne(results, "original", way, limit)
        assert before == WORDS.ratio(was) and share == written(
            "reduction", abs(1.0 - known[way] / was), WORDS
        )
    assert ("Not verified" in said) == any(
        ratio < 1.0
        for name in ("SLV", "SLC")
        for each in ("+x", "-x")
        if (ratio := borne(results, state, each, name)) is not None
        if name in {limit for row in results.summary.rows for limit in row.checks}
    ) or limit not in {"SLV", "SLC"}


@given(random_results())
@settings(max_examples=15)
def test_table_and_sentence_agree_with_the_checks(results):
    found = typed(results)
    agrees(found)
    sentence_agrees(found)


@pytest.mark.parametrize("make", [results_example, analysed], ids=lambda make: make.__name__)
def test_so_do_those_of_an_analysis(make):
    results = typed(make("en"))
    made = agrees(results)
    sentence_agrees(results)
    assert len(made.rows) == 4 and "ζ" in lead(results, WORDS)[0]


def test_the_answer_is_of_the_linear_check_where_the_nonlinear_one_has_no_number():
    content = analysed("en")
    worst = worst_settled(typed(content))
    made = {"strengthening": {"of": worst, "ties": [], "layers": []}}
    content["states"]["tied"] = copy.deepcopy(content["states"][worst]) | made
    for capacity in content["states"][worst]["capacity"].values():
        capacity["SLV"] |= {"zeta_E": None, "verified": None}
    results = typed(content)
    sentence_agrees(results)
    said, tied = lead(results, WORDS)[:2]
    assert re.search(r"\(linear check, SLV, ..\); before the settlement \S+ \(pushover\)\. ", said)
    assert re.search(r"“tied” takes .* from \S+ \(linear check\) to \S+ \(pushover, SLV, ..\)", tied)


def test_where_damage_alone_is_checked_the_linear_check_is_named():
    content = analysed("en")
    content["echo"]["assessment"]["limit_states"] = ["SLD"]
    assert "(linear check, SLD, " in lead(typed(content), WORDS)[0]


def checked(**checks):
    """The example with these numbers of its checks, in every state and direction."""
    results = results_example("en")
    for capacity in (each for state in results["states"].values() for each in state["capacity"].values()):
        for limit, numbers in checks.items():
            capacity[limit] |= numbers
    return results


def multipliers():
    """The example without an assessment."""
    results = results_example("en")
    results["echo"]["assessment"] = None
    for content in results["states"].values():
        content["capacity"] = {}
    return results


def said(results, sentences=lead):
    """What the first page says, as plain text."""
    return " ".join(plain_text(each) for each in sentences(typed(results), WORDS)).replace("\u00a0", " ")


REACHED, MISSED = {"zeta_E": 1.2, "verified": True}, {"zeta_E": 0.9, "verified": False}


def test_what_is_just_below_the_threshold_is_told_with_digits_enough():
    """ "1.00 not verified" stood there."""
    assert "ζ_E = 0.9996 (" in said(checked(SLV=MISSED | {"zeta_E": 0.9996}))


def test_where_the_index_is_reached_what_is_not_verified_is_named():
    """ "ζ_E = 1.01. Not verified." stood there, of a ratio at SLC."""
    assert lead(typed(checked(SLV=REACHED, SLC=MISSED)), WORDS)[0].endswith(". Not verified at SLC.")


def test_an_index_above_one_that_is_not_verified_has_its_reason_on_the_first_page():
    """The maximum of a record's spectrum decides what is verified, where ζ_E is that at T."""
    reason = "A limit state whose ζ_E is 1 or more is not verified"
    assert reason not in said(results_example("en"), basis)
    assert reason in said(checked(SLV={"zeta_E": 1.15, "verified": False}), basis)


def test_damage_does_not_decide_whether_a_state_is_verified():
    """The table counts SLV and SLC: a sentence "Not verified at SLD" stood above its "verified"."""
    assert lead(typed(checked(SLV=REACHED, SLC=REACHED, SLD=MISSED)), WORDS)[0].endswith(". Verified.")


def test_the_confidence_factor_without_a_level_and_the_other_law_are_told():
    results = results_example("en")
    capacity = results["states"][SETTLED]["capacity"]["-x"]
    capacity |= {"alpha_0": 0.131}
    capacity["other_law"] = {"sliding": "coulomb", "alpha_0": 0.05, "zeta_E": {"SLV": 0.31}}
    assert "given without a level of knowledge" in said(results, basis)
    told = f"With Coulomb friction ζ_E would be 0.31 (“{SETTLED}”, {direction_name('-x')})"
    assert told in said(results, basis)


def test_without_an_assessment_the_multiplier_is_the_answer():
    told = said(multipliers())
    assert re.search(r"α_0 = 0\.\d+ \(pushover, [+−]x\); before the settlement 0\.\d+: a reduction of", told)
    assert "erified" not in told and "ζ" not in " ".join(synthesis_grid(typed(multipliers()), WORDS).head)


def test_what_a_settlement_leaves_as_it_was_is_unchanged_and_no_increase_of_0():
    results = multipliers()
    results["states"][SETTLED]["pushover"] = results["states"]["original"]["pushover"]
    assert re.search(r"before the settlement 0\.\d+: unchanged\.", said(results))


def test_the_range_stands_beside_the_index_that_is_used():
    results = checked(**{limit: {"zeta_E_range": [0.25, 2.5]} for limit in ("SLV", "SLC")})
    used, told = WORDS.ratio(typed(results).summary.governing.zeta_E), said(results, basis)
    assert f"{used} is the least of several computations" in told and "between 0.25 and 2.50" in told


@pytest.mark.parametrize(
    ("low", "told"),
    [(0.25, "an index or ratio may be as low as 0.25."), (0.0, "the index may vanish or be missing.")],
)
def test_ranges_on_both_sides_of_one_decide_nothing_and_overlapping_ones_tell_no_loss(low, told):
    """Of five runs of a wall one had a capacity, and it was told as verified; scatter was told as a gain of 40 %."""
    open_ = {"zeta_E_range": [low, 9.0], "verified": None}
    results = checked(SLV=open_, SLC=open_)
    assert "no distinguishable change" in said(results) and told in said(results)
    grid = synthesis_grid(typed(results), WORDS)
    assert all("not distinguishable" in " ".join(row) for row in grid.rows if "riginal" not in row[0])


def test_without_an_index_the_ranges_are_those_of_the_multiplier():
    results = multipliers()
    results["echo"]["scatter"] = 5
    for pushed in (each for state in results["states"].values() for each in state["pushover"].values()):
        pushed["rigid"]["alpha_0_range"] = [0.1, 0.2]
    told = said(results, basis)
    assert "is the least of several computations" in told and "between 0.100 and 0.200" in told
    assert "no distinguishable change" in said(results)


def test_the_action_is_that_of_the_limit_state_of_the_index():
    results = results_example("en")
    results["echo"]["assessment"]["site"] |= {"nominal_life_years": 50.0, "use_class": "II"}
    found = typed(results)
    rows = [row.replace(checks={"SLC": row.checks["SLC"]}) for row in found.summary.rows]
    told = map(plain_text, basis(found.replace(summary=found.summary.replace(rows=rows)), WORDS))
    assert re.search(r"Action at SLC.* T_R,SLC = 975.years", " ".join(told))


def test_an_intervention_is_told_in_the_direction_in_which_it_found_the_structure_weakest():
    """0.40 to 1.30 in −x, beside 0.90 to 1.10 in +x: neither 0.90 to 1.10 alone, nor 0.40 to 1.10."""
    example = typed(results_example())
    drawn = example.states["original"]
    tied = drawn.replace(strengthening=Strengthening(of="original", ties=["tie"], layers=[]))
    first = example.summary.rows[0]

    def row(state, direction, ratio, gain):
        check = SummaryCheck(check="SLV", zeta_E=ratio, verified=ratio >= 1.0).replace(gain=gain)
        return first.replace(state=state, direction=direction, verified=ratio >= 1.0, checks={"SLV": check})

    rows = [
        row("original", "+x", 0.9, None),
        row("original", "-x", 0.4, None),
        row("tied", "+x", 1.1, 1.1 / 0.9 - 1.0),
        row("tied", "-x", 1.3, 1.3 / 0.4 - 1.0),
    ]
    results = example.replace(
        states={"original": drawn, "tied": tied}, summary=example.summary.replace(rows=rows)
    )
    told = " ".join(map(plain_text, lead(results, WORDS))).replace("\u00a0", " ")
    assert "0.40 (pushover, SLV, −x)" in told
    assert "from 0.40 to 1.30 (SLV, −x): a gain of 225 %; the least is now 1.10 (SLV, +x)" in told
    only = example.replace(
        states={"original": drawn, "tied": tied}, summary=example.summary.replace(rows=rows[1::2])
    )
    assert not any("least" in plain_text(sentence) for sentence in lead(only, WORDS))


def tied_multipliers():
    """The example without an assessment, and its settled state with a tie."""
    results = multipliers()
    tied = copy.deepcopy(results["states"][SETTLED])
    results["states"]["tied"] = tied | {"strengthening": {"of": SETTLED, "ties": ["chain"], "layers": []}}
    return results


@pytest.mark.parametrize(
    ("alpha_range", "levels", "told"),
    [
        (None, (0.3, 0.4), "takes α_0 from 0.131 to 0.157 (+x): a gain of 20 %."),
        ([0.12, 0.16], (0.3, 0.25), "makes no distinguishable difference to α_0: 0.131, then 0.157 (+x)."),
        (None, (0.3, 0.25), "a gain of 20 %. The two capacities go opposite ways: the PGA at collapse by the motions "
         "goes from 0.300 g to 0.250 g"),
        (None, (0.148, 0.146), "a gain of 20 %."),
    ],
)  # fmt: skip
def test_without_an_assessment_an_intervention_is_told_by_its_multiplier(alpha_range, levels, told):
    """It had no sentence; and nothing said that motions lost what the static multiplier gained."""
    results = tied_multipliers()
    for name, factor, level in (("original", 1.0, 0.3), (SETTLED, 1.0, levels[0]), ("tied", 1.2, levels[1])):
        state = results["states"][name] | {
            "incremental": {"records": [], "fragility": {"pga_collapse_g": level}}
        }
        results["states"][name] = state
        for pushed in state["pushover"].values():
            pushed["rigid"] |= {"alpha_0": factor * pushed["rigid"]["alpha_0"], "alpha_0_range": alpha_range}
    assert told in said(results)
    assert ("opposite ways" in said(results)) == ("opposite ways" in told)


def test_of_directions_that_were_alike_an_intervention_is_told_in_the_one_that_is_weakest_now():
    """It was a gain of 22 % in the first of them, where the least capacity had not changed."""
    results = tied_multipliers()
    alphas = {"original": (0.2, 0.2), SETTLED: (0.143, 0.143), "tied": (0.174, 0.143)}
    for name, values in alphas.items():
        for side, alpha in zip(("+x", "-x"), values, strict=True):
            results["states"][name]["pushover"][side]["rigid"] |= {"alpha_0": alpha, "alpha_0_range": None}
    assert "makes no distinguishable difference to α_0: 0.143, then 0.143 (−x)." in said(results)


def test_motions_alone_have_no_governing_curve_and_their_few_records_are_told():
    results = results_example("en")
    scatter = "The governing curve does not scatter"
    results["echo"] |= {"scatter": 5}
    assert scatter in said(results, basis)
    results["echo"] |= {"pushover": None, "assessment": None}
    results["states"]["original"]["incremental"] = {"records": [], "fragility": {"rule": None}}
    told = said(results, basis)
    assert scatter not in told and "Fewer than three records" in told
