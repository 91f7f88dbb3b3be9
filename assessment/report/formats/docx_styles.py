"""Page, styles, fields and running heads of the Word document; every look of it is a named style."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from docx.enum.style import WD_STYLE_TYPE
from docx.enum.text import WD_ALIGN_PARAGRAPH, WD_TAB_ALIGNMENT, WD_TAB_LEADER
from docx.oxml import OxmlElement, parse_xml
from docx.oxml.ns import nsdecls, qn
from docx.shared import Emu, Mm, Pt, RGBColor

FONT = "Arial"
PAGE, MARGIN = (Mm(210), Mm(297)), Mm(20)
WIDTH = PAGE[0] - 2 * MARGIN
RIGHT, CENTRE = WD_ALIGN_PARAGRAPH.RIGHT, WD_ALIGN_PARAGRAPH.CENTER
TABLE, FIGURE, TABLE_CAPTION = "Report Table", "Figure", "Table Caption"
TABLE_TEXT, TABLE_HEAD = "Table Text", "Table Head"
SMALL_TEXT, AFTER_TABLE = "Table Text Small", "After Table"
CONTENTS, CONTENTS_HEADING = "toc 1", "Contents Heading"
WHOLE = 0.5 * (PAGE[1] - Mm(24) - MARGIN)  # of height: a table of no more stands on one page
LINE, BETWEEN = Pt(9.8), Pt(2)  # of a row of a table: each of its lines, and above and below them
LETTER = Pt(4.2)  # of width, in the mean
TOGETHER = 3  # rows at the head and at the end of a longer table
STAMP = Mm(22)  # of height, for a stamp and a signature
MANY_COLUMNS = 9  # of a table: its text is smaller from there on
LOCALES = {"it": "it-IT", "en": "en-GB"}
OWN: Mapping[
    str, tuple[str, float, dict[str, Any]]
] = {  # styles: what they are based on, size in pt, paragraph format
    FIGURE: ("Normal", 9.5, {"alignment": CENTRE, "keep_with_next": True, "space_before": Pt(8)}),
    TABLE_CAPTION: ("Caption", 8.5, {"keep_with_next": True, "space_before": Pt(6), "space_after": Pt(3)}),
    TABLE_TEXT: ("Normal", 8.0, {"space_before": Pt(1), "space_after": Pt(1)}),
    SMALL_TEXT: (TABLE_TEXT, 7.0, {}),
    TABLE_HEAD: (TABLE_TEXT, 7.5, {"keep_with_next": True}),
    AFTER_TABLE: ("Normal", 5.0, {}),
    CONTENTS: ("Normal", 9.5, {"space_after": Pt(3)}),
    CONTENTS_HEADING: ("Normal", 13.0, {"space_after": Pt(8)}),
}
STANDARD: Mapping[
    str, tuple[float, dict[str, Any]]
] = {  # styles that Word knows: size in pt, paragraph format
    "Normal": (9.5, {"space_after": Pt(0)}),
    "Body Text": (9.5, {"space_after": Pt(6)}),
    "List Bullet": (9.5, {"space_after": Pt(3)}),
    "Quote": (9.5, {"space_after": Pt(6)}),
    "Title": (24.0, {"space_before": Pt(12), "space_after": Pt(12)}),
    "Subtitle": (11.0, {"space_before": Pt(24), "space_after": Pt(24)}),
    "Heading 1": (13.0, {"space_before": Pt(18), "space_after": Pt(6)}),
    "Heading 2": (10.5, {"space_before": Pt(12), "space_after": Pt(4)}),
    "Caption": (8.5, {"space_before": Pt(3), "space_after": Pt(10)}),
    "Header": (7.5, {}),
    "Footer": (7.5, {}),
}
BORDERED = f"""
<w:style {nsdecls("w")} w:type="table" w:customStyle="1" w:styleId="ReportTable">
  <w:name w:val="{TABLE}"/><w:basedOn w:val="TableNormal"/><w:qFormat/>
  <w:tblPr><w:tblBorders><w:top w:val="single" w:sz="8"/><w:bottom w:val="single" w:sz="8"/></w:tblBorders>
  <w:tblCellMar><w:left w:w="45" w:type="dxa"/><w:right w:w="45" w:type="dxa"/></w:tblCellMar></w:tblPr>
  <w:tblStylePr w:type="firstRow"><w:tcPr><w:tcBorders><w:bottom w:val="single" w:sz="4"/></w:tcBorders></w:tcPr>
  </w:tblStylePr>
</w:style>"""


def prepare(document: Any, language: str) -> None:
    """Set the page to A4 and the styles to one black sans-serif, in the language that Word's spelling shall have."""
    section = document.sections[0]
    section.page_width, section.page_height = PAGE
    section.left_margin = section.right_margin = section.bottom_margin = MARGIN
    section.top_margin = Mm(24)
    _only_plain_tables(document.styles.element)
    document.styles.element.append(parse_xml(BORDERED))
    for name, (size, layout) in STANDARD.items():
        _set(document.styles[name], size, layout)
    for name, (base, size, layout) in OWN.items():
        style = document.styles.add_style(name, WD_STYLE_TYPE.PARAGRAPH)
        style.base_style = document.styles[base]
        _set(style, size, layout)
    for name in (TABLE_HEAD, CONTENTS_HEADING):
        document.styles[name].font.bold = True
    for name in ("Caption", "Subtitle"):
        document.styles[name].font.bold = document.styles[name].font.italic = False
    for tag in document.styles.element.iter(qn("w:lang")):
        tag.set(qn("w:val"), LOCALES[language])


def _only_plain_tables(styles: Any) -> None:
    """Take the hundred coloured table styles of the library's own template out of the gallery."""
    for style in styles.findall(qn("w:style")):
        if style.get(qn("w:type")) == "table" and style.get(qn("w:styleId")) not in {
            "TableNormal",
            "TableGrid",
        }:
            styles.remove(style)


def paragraph(document: Any, style: str) -> Any:
    """Add an empty paragraph in a style."""
    added = document.add_paragraph()
    apply(added, style)
    return added


def apply(paragraph: Any, style: str) -> None:
    """Give a paragraph a style, by its id: the library looks names up among all styles, every time."""
    paragraph._p.style = style.replace(" ", "")


def _set(style: Any, size: float, layout: Mapping[str, Any]) -> None:
    style.font.size, style.font.color.rgb = Pt(size), RGBColor(0, 0, 0)
    fonts = style.element.get_or_add_rPr().get_or_add_rFonts()
    for attribute in list(fonts.attrib):  # those of the theme, which would prevail
        del fonts.attrib[attribute]
    for kind in ("ascii", "hAnsi", "cs", "eastAsia"):
        fonts.set(qn(f"w:{kind}"), FONT)
    for key, value in layout.items():
        setattr(style.paragraph_format, key, value)
    for tag in ("w:pBdr", "w:tabs"):  # the line below a title; tab stops of another page
        for found in list(style.element.iter(qn(tag))):
            found.getparent().remove(found)


def running_heads(section: Any, title: str, subtitle: str, program: str) -> None:
    """Write title and kind of document above every page of the section, program and page number below."""
    for part, left, right in ((section.header, title, subtitle), (section.footer, program, "")):
        part.is_linked_to_previous = False
        paragraph = part.paragraphs[0]
        paragraph.text = f"{left}\t{right}"
        paragraph.paragraph_format.tab_stops.add_tab_stop(WIDTH, WD_TAB_ALIGNMENT.RIGHT)
    _field(section.footer.paragraphs[0], "PAGE", "1")


def widths(rows: Sequence[Sequence[str]]) -> list[Emu]:
    """Return widths of the columns of a table, texts of cells: as their longest words and the square roots of texts."""
    wanted = [
        max(max([4, *map(len, text.split())]) + math.sqrt(len(text)) for text in column)
        for column in zip(*rows, strict=True)
    ]
    return [Emu(round(WIDTH * each / sum(wanted))) for each in wanted]


def kept_with_next(rows: Sequence[Sequence[str]], widths: Sequence[int]) -> set[int]:
    """Return which rows of a table, texts of cells, go with the next: all of one of up to half a page.

    Of a longer one those at its head and its end, so that no row stands alone. `widths` of the columns in EMU; heights
    are estimated, as only the program that shows the document knows them.
    """
    lines = [
        max(1 + int(len(text) * LETTER / width) for text, width in zip(row, widths, strict=True))
        for row in rows
    ]
    height = sum(LINE * count + BETWEEN for count in lines)
    together = len(rows) if height <= WHOLE else TOGETHER
    return {*range(min(together, len(rows) - 1)), *range(max(0, len(rows) - together), len(rows) - 1)}


def contents(document: Any, chapters: Mapping[str, str]) -> None:
    """Write the chapters, by their names, each with the page on which `named` has put its name: a field."""
    for name, chapter in chapters.items():
        line = paragraph(document, CONTENTS)
        line.paragraph_format.tab_stops.add_tab_stop(WIDTH, WD_TAB_ALIGNMENT.RIGHT, WD_TAB_LEADER.DOTS)
        line.add_run(f"{chapter}\t")
        _field(line, f"PAGEREF _{name} \\h", "–").set(qn("w:dirty"), "true")


def named(heading: Any, name: str, number: int) -> None:
    """Give a heading the name by which the contents know it; `number`: its own, from 0."""
    for tag, attributes in (("w:bookmarkStart", {"w:name": f"_{name}"}), ("w:bookmarkEnd", {})):
        mark = OxmlElement(tag)
        for key, value in {"w:id": str(number), **attributes}.items():
            mark.set(qn(key), value)
        heading._p.append(mark)


def _field(paragraph: Any, instruction: str, shown: str) -> Any:
    """Add a field to a paragraph, as shown until it is updated; return its beginning."""
    begin = _mark(paragraph, "begin")
    _instruction(paragraph, instruction)
    _mark(paragraph, "separate")
    paragraph.add_run(shown)
    _mark(paragraph, "end")
    return begin


def _mark(paragraph: Any, kind: str) -> Any:
    mark = OxmlElement("w:fldChar")
    mark.set(qn("w:fldCharType"), kind)
    paragraph.add_run()._r.append(mark)
    return mark


def _instruction(paragraph: Any, text: str) -> None:
    instruction = OxmlElement("w:instrText")
    instruction.set(qn("xml:space"), "preserve")
    instruction.text = text
    paragraph.add_run()._r.append(instruction)


def keep_whole(row: Any, head: bool) -> None:
    """Keep a row of a table on one page; a head is repeated on the pages that follow."""
    for tag in ("w:cantSplit", *(("w:tblHeader",) if head else ())):
        row._tr.get_or_add_trPr().append(OxmlElement(tag))


def ruled(cell: Any) -> None:
    """Draw a line below a cell, to write on."""
    borders = OxmlElement("w:tcBorders")
    bottom = OxmlElement("w:bottom")
    bottom.set(qn("w:val"), "single")
    bottom.set(qn("w:sz"), "4")
    borders.append(bottom)
    cell._tc.get_or_add_tcPr().append(borders)
