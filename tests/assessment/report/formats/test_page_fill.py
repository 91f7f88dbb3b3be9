"""Pages of the PDF are filled: figures move within their chapter, charts are set smaller, nothing is lost."""

import base64
import io
import re
from importlib.resources import files

import pypdf
import pytest

from assessment.report.formats.page_fill import (
    BLOCK,
    MM,
    PAGE,
    TOP,
    Block,
    Filled,
    _measured,
    _named,
    _parts,
    _sized,
    pdf_of,
)

weasyprint = pytest.importorskip("weasyprint", exc_type=OSError)
STYLE = (files("templates") / "report.css").read_text(encoding="utf-8")
LOWEST = 22.0 * 72.0 / 25.4  # foot of a page, points
HEIGHT = 251.0 * 72.0 / 25.4


def heading(text: str) -> str:
    return f"<h2>{text}</h2>"


def text(word: str, lines: int) -> str:
    return f"<p>{'<br>'.join([word] * lines)}</p>"


def figure(name: str, millimetres: float) -> str:
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" width="168mm" height="{millimetres}mm"><path d="M0 0"/></svg>'
    address = f"data:image/svg+xml;base64,{base64.b64encode(svg.encode()).decode()}"
    source = f'<img src="{address}" data-file="figures/{name}.png">'
    return f"<figure>{source}<figcaption>{name}</figcaption></figure>"


def table(name: str, rows: int) -> str:
    body = "".join(f"<tr><td>{name} {row}</td></tr>" for row in range(rows))
    kind = " long" if rows > 8 else ""
    head = f"<caption>{name}</caption><thead><tr><th>head</th></tr></thead>"
    return f'<table class="{kind}">{head}<tbody>{body}</tbody></table>'


def report(*blocks: str) -> str:
    """A page of one chapter with these blocks, and one without figures."""
    rest = f"{heading('Last')}{text('end', 3)}"
    main = f"<main>\n{heading('One')}{''.join(blocks)}{rest}</main>"
    return f"<html><head><style>{STYLE}</style></head><body>{main}</body></html>"


def pages(made: bytes) -> list[str]:
    return [page.extract_text() for page in pypdf.PdfReader(io.BytesIO(made)).pages]


def blanks(made: bytes) -> list[float]:
    """What part of each page but the last lies below its lowest text, captions included."""
    found = []
    for page in pypdf.PdfReader(io.BytesIO(made)).pages:
        heights: list[float] = []
        page.extract_text(
            visitor_text=lambda part, matrix, tm, font, size, heights=heights: (
                heights.append(tm[5] * matrix[3] + matrix[5]) if part.strip() else None
            )
        )
        found.append((min(height for height in heights if height > LOWEST - 1.0) - LOWEST) / HEIGHT)
    return found[:-1]


def as_it_stands(page: str) -> bytes:
    return weasyprint.HTML(string=page).write_pdf()


def test_text_behind_a_figure_fills_the_page_that_it_would_leave_blank():
    page = report(text("first", 26), figure("mechanism", 130.0), text("second", 16), figure("thrust", 80.0))
    assert max(blanks(as_it_stands(page))) > 0.3
    made = pdf_of(page, weasyprint)
    assert max(blanks(made)) < 0.25
    assert "second" in pages(made)[0] and "mechanism" in pages(made)[1]


def test_a_long_table_goes_on_beyond_a_figure_that_stood_behind_it():
    page = report(text("first", 2), table("rows", 26), figure("mechanism", 130.0))
    made = pdf_of(page, weasyprint)
    assert max(blanks(as_it_stands(page))) > 0.3 and max(blanks(made)) < 0.25
    assert sum(each.count("head") for each in pages(made)) == 2


def rows_by_page(made: bytes, name: str) -> list[int]:
    found = (len(re.findall(rf"{name} \d+", each)) for each in pages(made))
    return [count for count in found if count]


@pytest.mark.parametrize("in_annex", [False, True])
def test_a_table_of_up_to_half_a_page_is_not_parted_and_a_longer_one_leaves_no_row_alone(in_annex):
    """A row is 5.1 mm, caption and head 11 mm: 21 rows are less than half of 251 mm, 26 are more.

    Forty lines of text, 176 mm, and a heading leave room for some ten of them.
    """
    parted = []
    for rows in (21, 26):
        for lines in range(35, 48, 3):
            blocks = [text("first", lines), table("rows", rows)]
            page = report(figure("model", 5.0), *(() if in_annex else blocks))
            page = page.replace("</main>", f"{''.join(blocks if in_annex else ())}</main>")
            split = rows_by_page(pdf_of(page, weasyprint), "rows")
            assert sum(split) == rows and (rows == 26 or split == [21]) and min(split) >= 3
            parted.append(split)
    assert any(len(split) == 2 for split in parted)


def test_a_chart_is_set_smaller_and_a_drawing_to_scale_is_not():
    for name, smaller in (("pushover", True), ("mechanism", False)):
        page = report(text("first", 26), figure(name, 115.0))
        assert name not in pages(as_it_stands(page))[0]
        assert (name in pages(pdf_of(page, weasyprint))[0]) == smaller


def test_figures_and_all_else_keep_their_order_and_nothing_is_lost():
    one, two, three = figure("fone", 130.0), figure("ftwo", 100.0), figure("fthree", 140.0)
    page = report(text("a", 26), one, table("t", 6), text("b", 10), two, table("u", 20), three, text("c", 12))
    natural, made = as_it_stands(page), pdf_of(page, weasyprint)
    assert max(blanks(natural)) > 0.3 > 0.25 > max(blanks(made))
    before, after = (
        [word for word in re.findall(r"\w+", " ".join(pages(each))) if word != "head"]
        for each in (natural, made)
    )
    assert before != after and sorted(before) == sorted(after)
    for kind in ({"fone", "ftwo", "fthree"}, {"a", "b", "c", "t", "u"}):
        assert [word for word in before if word in kind] == [word for word in after if word in kind]


def test_a_report_whose_pages_are_full_stays_as_it_is():
    page = report(text("first", 10), figure("mechanism", 60.0), text("second", 10))
    assert pdf_of(page, weasyprint) == as_it_stands(page)


def test_a_page_that_nothing_fills_is_laid_out_once_more_and_not_three_times(monkeypatch):
    """Two drawings to scale of more than half a page each: to take heights larger does not help, they were right."""
    page = report(figure("mechanism", 140.0), figure("thrust", 140.0), text("second", 2))
    drawn, render = [], weasyprint.HTML.render
    monkeypatch.setattr(weasyprint.HTML, "render", lambda self: drawn.append(render(self)) or drawn[-1])
    assert max(blanks(pdf_of(page, weasyprint))) > 0.28
    assert len(drawn) == 2  # the endless sheet, and the pages


def placed(blocks: list[str], size: float = 1.0) -> tuple[float, float]:
    """Where the last of these blocks ends on its page, px: as expected of heights, and laid out; it has a size."""
    page = report(*blocks)
    found = list(BLOCK.finditer(page))[: len(blocks) + 1]
    measured = [block for _, block in _measured(page, found, weasyprint)]
    expected = Filled(PAGE)
    for number, block in enumerate(measured):
        expected = expected.with_block(number, block, size if number == len(blocks) else 1.0)
    last = _named(0, _sized(measured[-1].text, size))
    sheets = weasyprint.HTML(string=page.replace(measured[-1].text, last)).render().pages
    [*_, box] = [sheet.anchors["block0"] for sheet in sheets if "block0" in sheet.anchors]
    return expected.used, box[3] - TOP


@pytest.mark.parametrize(
    ("blocks", "size"),
    [
        ([text("first", 48), "<h3>Two</h3>", figure("mechanism", 60.0)], 1.0),
        ([text("first", 47), "<h2>Two</h2>", "<h3>Three</h3>", text("second", 9)], 1.0),
        ([text("first", 46), text("second", 12)], 1.0),
        ([text("first", 48), text("second", 5)], 1.0),
        ([text("first", 51), text("second", 3)], 1.0),
        ([text("first", 20), figure("pushover", 60.0)], 0.85),
    ],
    ids=["heading moved", "two headings moved", "lines parted", "two lines left", "three lines", "smaller"],
)
def test_blocks_end_where_their_heights_say(blocks, size):
    """A margin that is none at the head of a page, or part of a line, cost two more layouts of the whole report."""
    expected, found = placed(blocks, size)
    assert expected == pytest.approx(found, abs=0.2 * MM)


def test_a_page_with_what_is_no_block_stays_as_it_is():
    """What the search does not know it might lose."""
    page = report(text("first", 26), "<div>loose</div>", figure("mechanism", 130.0), text("second", 16))
    assert pdf_of(page, weasyprint) == as_it_stands(page)


def test_a_heading_goes_with_what_follows():
    """A heading of 10 mm at 230 of 251 mm, a figure of 40 mm: both on the next page, 21 + 10 mm are blank."""
    full = Filled(used=220.0 * MM, order=((0, 1.0),)).with_block(1, Block("h3", "", 6.0 * MM))
    assert full.used == pytest.approx(230.0 * MM)
    after = full.with_block(2, Block("figure", "", 40.0 * MM))
    assert after.used == pytest.approx(
        (6.0 + 3.0 + 40.0) * MM
    )  # at the head of a page it has no margin above
    assert after.worst == pytest.approx((21.0 * MM + 10.0 * MM) / PAGE)


def test_a_text_and_its_table_are_parted_at_a_cost():
    blocks = [Block(kind, "") for kind in ("h2", "p", "table", "p", "figure")]
    assert [_parts(blocks, [0, 1, 2, 3], before) for before in range(5)] == [False, False, True, False, False]
