"""Figures and tables placed so that pages of the PDF are filled: a figure that would leave much of one blank moves.

A table of up to half a page is not parted. The page is laid out once on a single endless sheet, which gives the height
of every block. A search then fills pages of A4 with them: figures move past the text and tables of their chapter, and
charts are set a little smaller. The order of the figures among themselves and that of all else stay as they are, and so
do their numbers.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from types import ModuleType
from typing import Any

from assessment.report.figures.style import WIDTH_MM

MM = 96.0 / 25.4  # CSS pixels
PAGE = 251.0 * MM  # of A4 without its margins
SLACKS = (0.5 * MM, 3.0 * MM, 6.0 * MM)  # what heights may be wrong by: taken larger where a page shows it
LINE = 9.0 * 1.4 * 96.0 / 72.0  # of text
CAPTION = (
    8.5 * 1.4 * 96.0 / 72.0 + 1.5 * MM
)  # of a figure, in one line; it has its size beside a smaller picture too
AGREES = (
    LINE + 0.5 * MM
)  # a page that is blank by no more than this beside what was expected shows no wrong height
TOP = 24.0 * MM  # margin of a page
MARGINS = {  # above and below a block, as in report.css; that above is dropped at the head of a page
    "h2": (9.0 * MM, 2.0 * MM),
    "h3": (4.0 * MM, 1.0 * MM),
    "p": (0.0, 2.0 * MM),
    "ul": (0.0, 2.0 * MM),
    "table": (2.0 * MM, 5.0 * MM),
    "figure": (3.0 * MM, 5.0 * MM),
}
BLANK = 0.22  # of a page: more at its foot is worth a move
TAIL = 0.10  # of a page: less is no fault
WHOLE = PAGE / 2.0  # of a table: one that is no higher is not parted
LEAST = {"table": 28.0 * MM, "p": 9.0 * MM, "ul": 9.0 * MM}  # of what breaks, where it begins on a page
WIDOWS = 9.0 * MM  # of a text, the least that goes on on the next page
SHIFT = 3  # blocks that a figure may move past
SIZES = (1.0, 0.92, 0.85)  # of a chart
MOVED, SHRUNK = 0.004, 0.006  # cost of a block passed, of a size down; beside the square of what is blank
PARTED = 0.02  # cost of a figure between a text and the table that it is about
MUCH = 0.1  # cost of a page of which more than BLANK is blank
KEPT = 12  # ways to fill pages that are followed at a time
TO_SCALE = {
    "model",
    "settlement",
    "thrust",
    "mechanism",
    "overturned",
    "shapes",
    "chosen",
}  # drawings of one size
BLOCK = re.compile(r"<(h2|h3|p|ul|table|figure)\b.*?</\1>", re.DOTALL)
NAME = re.compile(r"block\d+")
ENDLESS = "<style>@page { size: 210mm 30000mm; margin: 0 20mm }</style></head>"


@dataclass(frozen=True)
class Block:
    """A heading, paragraph, list, table or figure: its text in the page and its height in pixels, without margins."""

    kind: str
    text: str
    height: float = 0.0
    head: float = 0.0  # of a table, px, again on every page

    @property
    def heading(self) -> bool:
        """Whether what follows has to begin on the same page."""
        return self.kind in {"h2", "h3"}

    @property
    def breakable(self) -> bool:
        """Whether it may go on on the next page: of a paragraph two lines or more stay together on either."""
        return (
            (self.kind == "p" and self.height > 3.5 * LINE)
            or self.kind == "ul"
            or (self.kind == "table" and 'class="' in self.text and " long" in self.text)
        )

    @property
    def sizes(self) -> tuple[float, ...]:
        """In which sizes a figure may be set: drawings to scale in one."""
        name = re.search(r'data-file="figures/([a-z]+)', self.text)
        return SIZES if name and name[1] not in TO_SCALE else SIZES[:1]

    def high(self, size: float) -> float:
        """Return the height in a size."""
        return self.height - (1.0 - size) * (self.height - CAPTION)


@dataclass(frozen=True)
class Filled:
    """Pages filled so far: their cost, the most that one is blank, what is used of the last, and what was set.

    `page`, px, that a page has; `used`, px, of the last; `below`, px, the margin under its last block; `hanging`, px,
    of headings at its end, which go with what follows, and of the margin `above` them, which does not; `order`: the
    numbers of the blocks with their sizes.
    """

    page: float = PAGE
    cost: float = 0.0
    worst: float = 0.0
    used: float = 0.0
    below: float = 0.0
    hanging: float = 0.0
    above: float = 0.0
    order: tuple[tuple[int, float], ...] = ()

    def with_block(self, number: int, block: Block, size: float = 1.0, cost: float = 0.0) -> Filled:
        """Return the pages with one block more: on this page, begun on it, or on the next."""
        height, (above, below) = block.high(size), MARGINS[block.kind]
        top = self.used + max(above, self.below) if self.used or not self.order else 0.0
        blank, used = 0.0, top + height
        if used > self.page and self.used:
            if block.breakable and self.page - top > LEAST[block.kind]:
                rest = height - self._begun(block.kind, self.page - top)
                used = max(WIDOWS, self._gone_on(rest + block.head, block.head))
            else:
                blank = (self.page - self.used + self.hanging) / PAGE
                headings = self.hanging - self.above + (top - self.used) if self.hanging else 0.0
                used = self._gone_on(headings + height, block.head)
        hanging = margin = 0.0
        if block.heading:
            stays = used > self.used
            hanging = used - (self.used - self.hanging if stays else 0.0)
            margin = (self.above if self.hanging else top - self.used) if stays else 0.0
        worse = cost + max(0.0, blank - TAIL) ** 2 + (MUCH if blank > BLANK else 0.0)
        order, worst = (*self.order, (number, size)), max(self.worst, blank)
        return Filled(self.page, self.cost + worse, worst, used, below, hanging, margin, order)

    def _begun(self, kind: str, room: float) -> float:
        """Return how much of what breaks stands in the room at the foot of a page: of a text, whole lines."""
        return room if kind == "table" else room // LINE * LINE

    def _gone_on(self, height: float, head: float) -> float:
        """Return how much of its last page fills what is so high, its head again on each."""
        while height > self.page:
            height += head - self.page
        return height


def pdf_of(page: str, weasyprint: ModuleType) -> bytes:
    """Return the PDF of a report, its figures placed where they would leave much of a page blank.

    They stay where they are where that is not so, or where heights are not known.
    """
    start, end = page.find("<main>"), _last_chapter(page)
    placed = list(BLOCK.finditer(page, start, end))
    tables = [found for found in BLOCK.finditer(page, end or start) if found[1] == "table"]
    measured = _measured(page, [*placed, *tables], weasyprint)
    page = _with_texts(page, measured)
    blocks = [block for _, block in measured[: len(placed)]]
    start, end = page.find("<main>"), _last_chapter(page)
    if BLOCK.sub("", page[start + len("<main>") : end]).strip():
        blocks = []  # what is no block might be lost
    made: list[tuple[float, Any]] = []
    for slack in SLACKS if any(_as_it_stands(blocks, PAGE - slack).worst > BLANK for slack in SLACKS) else ():
        way = _best(blocks, PAGE - slack)
        filled = "\n".join(_named(number, _sized(blocks[number].text, size)) for number, size in way.order)
        document = weasyprint.HTML(string=f"{page[:start]}<main>\n{filled}\n{page[end:]}").render()
        made.append((_most_blank(document), document))
        expected = way.worst + (slack + AGREES) / PAGE
        if made[-1][0] <= max(BLANK, expected):  # heights were right: another slack fills no page better
            break
    best = min(made, key=lambda each: each[0])[1] if made else weasyprint.HTML(string=page)
    return bytes(best.write_pdf())


def _as_it_stands(blocks: Sequence[Block], page: float) -> Filled:
    drawn = Filled(page)
    for number, block in enumerate(blocks):
        drawn = drawn.with_block(number, block)
    return drawn


def _best(blocks: Sequence[Block], page: float) -> Filled:
    """Return pages of a height, px, filled best: the numbers of the blocks in that order, with their sizes."""
    ways = [Filled(page)]
    for chapter in _chapters(blocks):
        ways = _ways(ways, blocks, chapter)
    return min(ways, key=lambda way: way.cost)


def _most_blank(document: Any) -> float:
    """Return the largest part of a page that is blank at its foot, of the pages that end among the blocks."""
    found = ([box for name, box in sheet.anchors.items() if NAME.fullmatch(name)] for sheet in document.pages)
    feet = [max(box[3] for box in boxes) for boxes in found if boxes]
    return max((1.0 - (foot - TOP) / PAGE for foot in feet[:-1]), default=0.0)


def _named(number: int, text: str) -> str:
    return f'<div id="block{number}">{text}</div>'


def _sized(text: str, size: float) -> str:
    return text if size == 1.0 else text.replace("<img ", f'<img style="width: {size * WIDTH_MM:g}mm" ', 1)


def _last_chapter(page: str) -> int:
    """Return where the chapter with the last figure ends; attachments are no chapter."""
    annex = page.find('class="annex"')
    last = page.rfind("<figure>", 0, annex if annex >= 0 else None)
    found = page.find("<h2", last)
    return found if last >= 0 and found >= 0 else 0


def _measured(
    page: str, found: Sequence[re.Match[str]], weasyprint: ModuleType
) -> list[tuple[re.Match[str], Block]]:
    """Return what was found in the page, each with its block and heights; nothing where these are not known."""
    blocks = [Block(each[1], each[0]) for each in found]
    named = [
        (each, Block("", _named(number, each[0].replace("<thead>", f'<thead id="head{number}">', 1))))
        for number, each in enumerate(found)
    ]
    endless = _with_texts(page, named).replace("</head>", ENDLESS, 1)
    sheets = weasyprint.HTML(string=endless).render().pages if blocks else []
    boxes = {name: box for sheet in sheets for name, box in sheet.anchors.items()}
    if any(len(boxes.get(f"block{number}", ())) != 4 for number in range(len(blocks))):  # an older WeasyPrint
        return []

    def high(name: str) -> float:
        _, top, _, foot = boxes.get(name, (0.0,) * 4)
        return float(foot - top)

    return [
        (each, _kept_whole(replace(block, height=high(f"block{number}"), head=high(f"head{number}"))))
        for number, (each, block) in enumerate(zip(found, blocks, strict=True))
    ]


def _kept_whole(block: Block) -> Block:
    """Return a block that may not be parted, if it is a table of up to half a page; else as it is."""
    if not block.breakable or block.kind != "table" or block.height > WHOLE:
        return block
    return replace(block, text=block.text.replace(" long", "", 1))


def _with_texts(page: str, blocks: Sequence[tuple[re.Match[str], Block]]) -> str:
    """Return the page with the text of each block in the place where it was found."""
    pieces, last = [], 0
    for found, block in blocks:
        pieces += [page[last : found.start()], block.text]
        last = found.end()
    return "".join([*pieces, page[last:]])


def _chapters(blocks: Sequence[Block]) -> Iterator[range]:
    starts = [number for number, block in enumerate(blocks) if block.kind == "h2"]
    yield from (range(first, last) for first, last in pairwise([*starts, len(blocks)]))


def _ways(ways: list[Filled], blocks: Sequence[Block], chapter: range) -> list[Filled]:
    """Return the best ways to go on with a chapter: at each turn its next figure, or the next of all else."""
    figures = [number for number in chapter if blocks[number].kind == "figure"]
    others = [number for number in chapter if blocks[number].kind != "figure"]
    places = [
        sum(other < figure for other in others) for figure in figures
    ]  # blocks before each, as it stands
    reached: dict[tuple[int, int], list[Filled]] = {(0, 0): ways}
    for i in range(len(others) + 1):
        for j in range(len(figures) + 1):
            here = sorted(reached.get((i, j), []), key=lambda way: way.cost)[:KEPT]
            reached[i, j] = here
            if i < len(others):
                block = blocks[others[i]]
                reached.setdefault((i + 1, j), []).extend(way.with_block(others[i], block) for way in here)
            if j < len(figures) and _may_stand(blocks, others, i, places[j]):
                block, passed = blocks[figures[j]], abs(i - places[j])
                moved = MOVED * passed + (PARTED if passed and _parts(blocks, others, i) else 0.0)
                reached.setdefault((i, j + 1), []).extend(
                    way.with_block(figures[j], block, size, moved + SHRUNK * level)
                    for way in here
                    for level, size in enumerate(block.sizes)
                )
    return reached[len(others), len(figures)]


def _parts(blocks: Sequence[Block], others: Sequence[int], before: int) -> bool:
    """Return whether what is set behind so many of the others stands between a text and its table."""
    around = [blocks[number].kind for number in others[max(0, before - 1) : before + 1]]
    return around == ["p", "table"]


def _may_stand(blocks: Sequence[Block], others: Sequence[int], before: int, place: int) -> bool:
    """Return whether a figure may stand behind so many of the other blocks of its chapter, in place of `place`."""
    if before == place:
        return True
    passed = [blocks[number] for number in others[min(before, place) : max(before, place)]]
    first = before > 0 and blocks[others[before - 1]].heading
    return len(passed) <= SHIFT and not first and not any(block.heading for block in passed)
