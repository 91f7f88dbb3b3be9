"""Ties and strengthening in report, page, figures, tables and on the terminal: a block that a tie holds."""

import json

import numpy as np
import pytest

from assessment.project.project import load_project
from assessment.report.chapters.grids import macro_block_grids, printed_tables
from assessment.report.document import tables
from assessment.report.figures.deformed import draw_mechanisms, draw_overturned
from assessment.report.figures.drawing import draw_model
from assessment.report.language import Words
from assessment.report.viewer import viewer
from assessment.results.schema.part import plain
from mechanics.pictures import TIE
from tests.support.block_project import HAZARD, PUSHED, TURNED, block, outcome_of, write_block
from tests.support.judgement.claims import hold
from tests.support.pictured import pages_of
from tests.support.tied_project import ASSOCIATIVE, HEIGHT, overturning, strengthening, tie

TEXT = (
    block()
    + TURNED
    + PUSHED.replace('["+x"]', '["+x", "-x"]')
    + f'[assessment]\nlimit_states = ["SLV"]\nmodel = "none"\n[assessment.site]\nsoil = "B"\n{HAZARD}'
    + tie(states='["strengthened"]', stiffness_kN_m="1000.0")
    + strengthening("original")
    + '[strengthening.layers.BASE]\nfriction = 0.75\n[report]\nlanguage = "it"\n'
    + ASSOCIATIVE
)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    project = load_project(write_block(tmp_path_factory.mktemp("ties") / "block", TEXT))
    return outcome_of(project).results


@pytest.fixture(scope="module")
def pages(results, tmp_path_factory):
    return pages_of(results, tmp_path_factory.mktemp("page"))


SAID = {
    "it": (
        "bielle rettilinee che resistono a sola trazione",
        "inestensibile fino al tiro di snervamento",
        "capochiave e piastra, sfilamento, schiacciamento e punzonamento della muratura",
        "nella configurazione del disegno, in quiete sotto i pesi (stato “originale”), sono messe in opera, tese e "
        "senza allentamento, le catene: chain; sono modificati i giunti dei layer: BASE.",
        "La catena “chain” raggiunge il tiro di snervamento (strengthened, +x, giunti rigidi",
        "e si allunga, fino alla fine della curva, di 99,2",
        "Stati a confronto, ciascuno nella direzione più debole",
        "L’intervento “strengthened” porta ζ<sub>E</sub> da ",
        "Primo capochiave x; z [m]",
        "Intervento 1, layer BASE",
    ),
    "en": (
        "straight rods that bear tension alone",
        "inextensible up to its yield force",
        "anchor plate, pull-out, crushing and punching of the masonry",
        "these ties are set, taut and without slack: chain; the joints of these layers are changed: BASE.",
        "The tie “chain” reaches its yield force (strengthened, +x, rigid contacts",
        "The states compared, each in its weakest direction",
    ),
}  # fmt: skip


def test_a_tie_that_yields_lengthens_as_much_as_its_anchors_move_apart(results):
    path = results.states["strengthened"].pushover["+x"].rigid
    x, z, turn = path.final_configuration[1]
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    head = np.array([x, 0.5 * HEIGHT + z]) + rotation @ (-0.29, 4.0 - 0.5 * HEIGHT)
    apart = np.hypot(head[0] + 0.29, head[1] + 0.1)
    assert path.ties[0].lengthening_m == pytest.approx(apart - 4.1, abs=1e-6)


@pytest.mark.parametrize("language", SAID)
def test_the_report_says_how_ties_are_modelled_and_what_is_to_be_verified(pages, language):
    for text in SAID[language]:
        assert text in pages[language], text


def test_tables_have_ties_their_tension_and_the_gain(results):
    found = {table.name: table.rows for table in tables(results)}
    [drawn] = found["ties"]
    assert (drawn["from_x_m"], drawn["to_z_m"], drawn["states"]) == (-0.29, 4.0, "strengthened")
    by_direction = {row["direction"]: row for row in found["tie_tensions"]}
    assert by_direction.keys() == {"+x", "-x"} and by_direction["+x"]["yields"]
    assert by_direction["+x"]["greatest_kN"] == pytest.approx(5.0, rel=1e-6)
    was, row = (each for each in found["strengthening"] if each["direction"] == "+x")
    assert was["alpha_0"] == pytest.approx(overturning(0.0, 0.0), rel=1e-6)
    assert row["gain"] == row["a_g_g"] / was["a_g_g"] - 1.0


def test_the_states_are_compared_on_one_page_with_what_the_tie_bears(results):
    """A row a state: ζ_E before and after, the gain, the greatest tension and its share of the yield force."""
    words, printed = Words.of("it"), printed_tables(results, Words.of("it"))
    rows = {row[0]: [cell.striptags() for cell in row] for row in printed["compared"].rows}
    assert list(rows) == ["originale", "base turned", "strengthened"]
    assert rows["strengthened"][-3:-1] == ["5,00", "100"]
    [row] = printed["tie_demands"].rows
    force = row[[head.striptags() for head in printed["tie_demands"].head].index("Piastra 20 × 20 cm [MPa]")]
    assert force == words.number(5e-3 / 0.2**2, 2)


def test_a_direction_without_an_index_stands_beside_the_weakest_of_the_others(results):
    """It may be weaker: the table gave the index of the direction that has one as that of the weakest."""
    state = results.states["strengthened"]
    half = state.replace(capacity={way: each for way, each in state.capacity.items() if way != "+x"})
    printed = printed_tables(results.replace(states=results.states | {"strengthened": half}), Words.of("en"))
    rows = [
        [cell.striptags() for cell in row] for row in printed["compared"].rows if row[0] == "strengthened"
    ]
    assert [row[1:3] for row in rows[1:]] == [["+x", "n.d."]] and rows[0][1] == "−x"


def test_the_hand_check_prints_the_work_of_the_tie(results):
    """W δ_z and F e, in the same column: their sum over W_s δ_x is α."""
    full = results.replace(echo=results.echo.replace(report=results.echo.report | {"annexes": "full"}))
    grids = {grid.caption.striptags(): grid for grid in macro_block_grids(full, Words.of("it"))}
    # the weakest direction of the strengthened state: towards −x the tie has nearly no arm
    [grid] = [each for caption, each in grids.items() if "“strengthened”" in caption]
    assert [row[0] for row in grid.rows] == ["1", "chain", "Σ"]
    weight, tied, whole = (float(row[-1].replace(",", ".").replace("−", "-")) for row in grid.rows)
    assert tied > 0.0 and weight + tied == pytest.approx(whole, rel=1e-3)


def ends_drawn(axes) -> list[np.ndarray]:
    return [np.array(line.get_xydata()) for line in axes.lines if line.get_linewidth() == TIE["linewidth"]]


def test_ties_are_drawn_where_their_ends_are(results):
    words = Words.of("it")
    [axes] = draw_model(results, words).axes
    assert ends_drawn(axes)[0].tolist() == [[-0.29, -0.1], [-0.29, 4.0]]
    assert "chain" in {text.get_text() for text in axes.texts}
    original, strengthened = draw_overturned(
        results, words, [("original", "+x"), ("strengthened", "+x")]
    ).axes
    assert not ends_drawn(original)
    [ends] = ends_drawn(strengthened)
    final = results.states["strengthened"].pushover["+x"].rigid.final_configuration[1]
    centre = np.array(results.geometry.blocks[1].centroid_m)
    c, s = np.cos(final[2]), np.sin(final[2])
    arm = np.array([-0.29, 4.0]) - centre
    assert ends[1] == pytest.approx(centre + final[:2] + [c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]])
    figure = draw_mechanisms(results, words, [("original", "+x"), ("strengthened", "+x")])
    assert [len(ends_drawn(each)) for each in figure.axes] == [0, 1]
    assert "catena" in {text.get_text() for text in figure.legends[0].get_texts()}


def test_the_page_has_ties_with_their_tension_at_every_step(results):
    data = json.loads(str(viewer(results, Words.of("it"))))
    assert [each["name"] for each in data["ties"]] == ["chain"]
    tied = [path for path in data["paths"] if "strengthened" in path["title"]]
    others = [path for path in data["paths"] if "strengthened" not in path["title"]]
    assert len(tied) == 2 and all(path["frames"]["ties"] == [0] for path in tied)
    assert all(path["frames"]["ties"] == [] == path["frames"]["tension"] for path in others)
    tensions = [each for each in tied[0]["frames"]["tension"] if each]
    assert max(tension for [tension] in tensions) == pytest.approx(5.0, rel=1e-4)


def test_the_judgement_says_what_is_gained_and_what_yields(results):
    keys = hold(plain(replace_language(results)))
    assert "ties_yield" in keys


def replace_language(results):
    report = results.echo.report | {"language": "en"}
    return results.replace(echo=results.echo.replace(report=report))
